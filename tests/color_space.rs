//! Colour spaces of EXR files: what is written, and what is read from files of other programs.

use crate::common::films::{chart, plain};
use crate::common::{Folder, pelage};
use glam::DVec3;
use pelage_core::assets::Assets;
use pelage_core::film::primaries::{AP1, Primaries, REC709};
use pelage_core::film::{Film, Metadata, io};
use pelage_core::light::lights_of;
use pelage_core::maps::MapSet;
use pelage_core::scene::{
    Background, Channel, Color, ColorMap, DirectionalLight, Environment, FilmSpec, OutputSpace, Scalar,
    ScalarMap,
};
use pelage_core::{Scene, World};

fn acescg() -> FilmSpec {
    FilmSpec { color_space: OutputSpace::Acescg, ..plain() }
}

fn write(film: &Film, path: &str, spec: &FilmSpec) {
    io::write(film, path, &Metadata::default(), spec).unwrap();
}

/// Place of the attribute `chromaticities` in a file's bytes.
fn chromaticities(bytes: &[u8]) -> std::ops::Range<usize> {
    let key = b"chromaticities\0chromaticities\0\x20\0\0\0";
    let at = bytes.windows(key.len()).position(|w| w == key).expect("the attribute") + key.len();
    at..at + 32
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// Overwrites the primaries that a file names.
fn claim(path: &str, primaries: [f32; 8]) {
    let mut bytes = std::fs::read(path).unwrap();
    let at = chromaticities(&bytes);
    bytes[at].copy_from_slice(&primaries.map(f32::to_le_bytes).concat());
    std::fs::write(path, bytes).unwrap();
}

const AP1_IN_FILES: [f32; 8] = [0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.321_68, 0.337_67];

/// The matrix that the ACES project publishes for linear sRGB to ACEScg, with Bradford adaptation.
#[test]
fn the_matrix_to_acescg_is_the_known_one() {
    let matrix = REC709.to(&AP1).unwrap();
    let known = [[0.6131, 0.3395, 0.0474], [0.0702, 0.9164, 0.0135], [0.0206, 0.1096, 0.8698]];
    for (row, known) in known.iter().enumerate() {
        for (column, value) in known.iter().enumerate() {
            let found = matrix.col(column)[row];
            assert!((found - value).abs() < 1e-4, "{row} {column}: {found}, known {value}");
        }
    }
    let back = AP1.to(&REC709).unwrap() * matrix;
    assert!(back.abs_diff_eq(glam::DMat3::IDENTITY, 1e-12), "{back}");
    // White stays white in every space, XYZ included, whose blue has no luminance.
    let xyz = Primaries { rgb: [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]], white: [1.0 / 3.0; 2] };
    for space in [AP1, xyz] {
        let white = space.to(&REC709).unwrap() * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-5), "{white}");
    }
    // Without adaptation, Y of a colour is its luminance.
    let d65_xyz = Primaries { white: REC709.white, ..xyz };
    let unscaled = REC709.to(&d65_xyz).unwrap();
    let y = [0, 1, 2].map(|c| unscaled.col(c)[1]);
    assert!((y[0] - 0.2126).abs() < 1e-3 && (y[1] - 0.7152).abs() < 1e-3, "{y:?}");
    for odd in [
        Primaries { rgb: [[0.3, 0.3]; 3], ..REC709 },
        Primaries { white: [0.3, 0.0], ..REC709 },
        Primaries { white: [f32::NAN; 2], ..REC709 },
        Primaries { rgb: [[f32::INFINITY, 0.3], [0.3, 0.6], [0.15, 0.06]], ..REC709 },
    ] {
        assert!(odd.to(&REC709).is_none(), "{odd}");
    }
}

#[test]
fn acescg_is_written_and_read_back() {
    let folder = Folder::new();
    let [usual, path] = ["usual.exr", "acescg.exr"].map(|name| folder.at(name));
    let mut film = chart(40, 30);
    let n = film.pixels();
    let ramp = |k: f32| (0..n).map(|i| k * i as f32 / n as f32).collect::<Vec<f32>>();
    let colors = ["guard.", "Albedo.", "half0."];
    for prefix in colors {
        for (c, k) in [("R", 0.9), ("G", 0.2), ("B", 0.5)] {
            film.push(format!("{prefix}{c}"), true, ramp(k));
        }
    }
    let data =
        ["N.X", "N.Y", "N.Z", "depth.Z", "guard.A", "CryptoLayer00.R", "CryptoLayer00.G", "CryptoLayer00.B"];
    for (i, name) in data.into_iter().enumerate() {
        film.push(name, true, ramp(i as f32 - 2.0));
    }
    film.plane_mut("depth.Z").unwrap()[0] = f32::INFINITY;
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    write(&film, &usual, &plain());
    write(&film, &path, &acescg());

    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(floats(&bytes[chromaticities(&bytes)]), AP1_IN_FILES);
    let neutral = b"adoptedNeutral\0v2f\0\x08\0\0\0";
    let at = bytes.windows(neutral.len()).position(|w| w == neutral).expect("adoptedNeutral") + neutral.len();
    assert_eq!(floats(&bytes[at..at + 8]), [0.321_68, 0.337_67]);
    let plain_bytes = std::fs::read(&usual).unwrap();
    assert!(!plain_bytes.windows(neutral.len()).any(|w| w == neutral));

    // Read as it is: the file with the primaries of Rec. 709 written over its own.
    let raw = folder.at("raw.exr");
    std::fs::copy(&path, &raw).unwrap();
    claim(&raw, [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    let raw = io::read(&raw).unwrap();
    let matrix = REC709.to(&AP1).unwrap();
    for prefix in ["", "guard.", "Albedo.", "half0."] {
        let [r, g, b] = ["R", "G", "B"].map(|c| film.plane(&format!("{prefix}{c}")).unwrap()[n / 3]);
        let wanted = matrix * DVec3::new(r.into(), g.into(), b.into());
        let found = ["R", "G", "B"].map(|c| f64::from(raw.plane(&format!("{prefix}{c}")).unwrap()[n / 3]));
        assert!(DVec3::from(found).abs_diff_eq(wanted, 1e-6), "{prefix}: {found:?}, expected {wanted}");
        assert!((wanted.x - f64::from(r)).abs() > 0.01, "the conversion changes {prefix}");
    }
    for name in data.into_iter().chain(["A"]) {
        assert_eq!(raw.plane(name), film.plane(name), "{name}");
    }

    let mut notes = Vec::new();
    let back = io::read_noting(&path, &mut notes).unwrap();
    assert!(notes.len() == 1 && notes[0].contains("acescg.exr") && notes[0].contains("ACEScg"), "{notes:?}");
    for plane in &film.planes {
        let found = back.plane(&plane.name).unwrap();
        let same = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 1e-6;
        assert!(plane.data.iter().zip(found).all(same), "{}", plane.name);
    }
    notes.clear();
    io::read_noting(&usual, &mut notes).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
}

/// PNG files are sRGB whatever the space, and pictures are compared in one space.
#[test]
fn pictures_in_both_spaces_are_the_same_picture() {
    let folder = Folder::new();
    let film = chart(64, 48);
    let [a, b] = ["a", "b"].map(|name| folder.at(name));
    for (path, spec) in [(&a, plain()), (&b, acescg())] {
        write(&film, &format!("{path}.exr"), &spec);
        write(&film, &format!("{path}.png"), &spec);
    }
    assert!(std::fs::read(format!("{a}.png")).unwrap() == std::fs::read(format!("{b}.png")).unwrap());
    let pair = [format!("{a}.exr"), format!("{b}.exr")];
    let compare = ["compare", &pair[0], &pair[1], "--threshold-max-abs"];
    let run = pelage(&[&compare[..], &["0.002"]].concat()).expect(0, &["note: b.exr", "ACEScg"]);
    assert!(!run.err.contains("a.exr"), "{}", run.err);
    // The same numbers in another space are another picture.
    claim(&pair[1], [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    pelage(&[&compare[..], &["0.05"]].concat()).expect(1, &["more than 0.05"]);
}

/// Maps of colours, environment maps and plates are converted; scalars are data and are not.
#[test]
fn assets_in_another_space_are_converted() {
    let folder = Folder::new();
    let path = folder.at("green.exr");
    let mut film = Film::from_premultiplied(16, 8, &[[0.1, 0.6, 0.2, 1.0]; 128]);
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    write(&film, &path, &acescg());
    let assets = Assets { folders: vec![folder.path().to_owned()] };
    let mut scene = Scene::parse("[mesh]\nshape = \"sphere\"\n", "scene.toml", &[]).unwrap();
    let map = "green.exr".to_owned();
    scene.base.color = Color::Mapped(ColorMap { map: map.clone(), layer: String::new(), value: [1.0; 3] });
    let scalar =
        ScalarMap { map: map.clone(), layer: String::new(), channel: Channel::R, value: 1.0, offset: 0.0 };
    scene.guard.comb = Scalar::Mapped(scalar);
    scene.environment = Some(Environment { map: map.clone(), ..Environment::default() });
    scene.film.background = Background::Plate;
    scene.film.plate = map;
    let world = World::load(scene, &assets).unwrap();
    let texel = |color: bool| world.maps.images.iter().find(|i| i.color == color).unwrap().texels[0];
    let near = |found: &[f32], wanted: [f64; 3]| {
        found.iter().zip(wanted).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-5)
    };
    assert!(near(&texel(true)[..3], [0.1, 0.6, 0.2]), "{:?}", texel(true));
    let raw = REC709.to(&AP1).unwrap() * DVec3::new(0.1, 0.6, 0.2);
    assert!(near(&texel(false)[..3], raw.to_array()), "{:?}", texel(false));
    let light: glam::Vec3 = world.lights.iter().map(|l| l.irradiance).sum();
    assert!((light.y / light.x - 6.0).abs() < 1e-3 && (light.z / light.x - 2.0).abs() < 1e-3, "{light}");
    let said = world.notes.iter().filter(|n| n.contains("green.exr") && n.contains("converted to Rec. 709"));
    assert_eq!(said.count(), 3, "colour map, environment and plate: {:?}", world.notes);
    // Primaries that make no sense are not used, and that is said.
    claim(&path, [0.0; 8]);
    let mut notes = Vec::new();
    let read = io::read_noting(&path, &mut notes).unwrap();
    assert!(notes.len() == 1 && notes[0].starts_with("warning: green.exr"), "{notes:?}");
    assert!((f64::from(read.plane("R").unwrap()[0]) - raw.x).abs() < 1e-6);
    // So are colours outside of Rec. 709, which have negative channels.
    let mut pure = Film::from_premultiplied(16, 8, &[[1.0, 0.0, 0.0, 1.0]; 128]);
    pure.planes.iter_mut().for_each(|p| p.full_precision = true);
    write(&pure, &path, &plain());
    claim(&path, AP1_IN_FILES);
    let scene = Scene { lights: Vec::new(), environment: None, ..world.scene };
    let maps = MapSet::load(&scene, &assets).unwrap();
    assert!(maps.notes.iter().any(|n| n.contains("256 values of colours below 0")), "{:?}", maps.notes);
    let of = |color: bool| maps.images.iter().find(|i| i.color == color).unwrap().texels[0];
    assert!(of(true)[0] > 1.5 && of(true)[1] == 0.0 && of(false) == [1.0, 0.0, 0.0, 1.0]);
}

// Values that are replaced are counted.

#[test]
fn values_of_maps_that_are_replaced_are_counted() {
    let folder = Folder::new();
    let mut pixels = [[0.5, 0.5, 0.5, 1.0]; 64];
    pixels[3][0] = f32::NAN;
    pixels[4][1] = f32::INFINITY;
    pixels[5] = [1e6, -0.25, -1e6, 1.0];
    let mut film = Film::from_premultiplied(8, 8, &pixels);
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    write(&film, &folder.at("odd.exr"), &plain());
    let assets = Assets { folders: vec![folder.path().to_owned()] };
    let map = "odd.exr".to_owned();
    let mut scene = Scene::default();
    scene.base.color = Color::Mapped(ColorMap { map: map.clone(), layer: String::new(), value: [1.0; 3] });
    let color = MapSet::load(&scene, &assets).unwrap();
    let said = |set: &MapSet, text: &str| set.notes.iter().any(|n| n == &format!("odd.exr: {text}"));
    assert!(said(&color, "2 values that are not finite numbers, set to 0"), "{:?}", color.notes);
    assert!(said(&color, "2 values beyond 65504, the largest half float, cut to it"), "{:?}", color.notes);
    assert!(said(&color, "2 values of colours below 0, set to 0"), "{:?}", color.notes);
    assert_eq!(color.images[0].texels[5], [65504.0, 0.0, 0.0, 1.0]);
    scene.base.color = Color::Constant([0.5; 3]);
    let scalar = ScalarMap { map, layer: String::new(), channel: Channel::G, value: 1.0, offset: 0.5 };
    scene.guard.comb = Scalar::Mapped(scalar);
    let data = MapSet::load(&scene, &assets).unwrap();
    assert_eq!(data.notes.len(), 2, "scalars may be negative: {:?}", data.notes);
    assert_eq!(data.images[0].texels[5], [65504.0, -0.25, -65504.0, 1.0]);
}

#[test]
fn lights_that_are_too_bright_are_noted() {
    let light = |v: f32| DirectionalLight { direction: [0.0, 1.0, 0.0], irradiance: [1.0, v, 1.0] };
    let of = |lights: Vec<DirectionalLight>, intensity: f32| {
        let environment = Some(Environment { lights: 4, intensity, ..Environment::default() });
        let mut notes = Vec::new();
        lights_of(&Scene { lights, environment, ..Scene::default() }, &Assets::default(), &mut notes)
            .unwrap();
        notes
    };
    assert!(of(vec![light(65504.0)], 1.0).is_empty());
    let notes = of(vec![light(1.0), light(1e6), light(7e4)], 1.0);
    assert!(notes.len() == 1 && notes[0].contains("2 with an irradiance up to 1000000"), "{notes:?}");
    assert!(notes[0].contains("lights[1], lights[2]") && notes[0].contains("film.exposure"), "{notes:?}");
    let notes = of(Vec::new(), 1e5);
    assert!(
        notes.len() == 1 && notes[0].contains("light: 4 with") && notes[0].contains("environment"),
        "{notes:?}"
    );
    let mut film = Film::from_premultiplied(2, 1, &[[65504.0, 1.0, 1.0, 1.0], [1.0; 4]]);
    assert_eq!(film.cut_pixels(), 1);
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    assert_eq!(film.cut_pixels(), 0, "written as it is");
}
