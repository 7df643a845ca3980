//! Images as other programs write them: formats, layers, transfer functions, and damage.

use pelage_core::Scene;
use pelage_core::assets::Assets;
use pelage_core::film::{Film, Metadata, composite, io};
use pelage_core::light::environment::Panorama;
use pelage_core::maps::MapSet;
use pelage_core::scene::{Color, ColorMap, FilmSpec};
use std::path::{Path, PathBuf};

const NAMES: [&str; 6] =
    ["rgbe_magic.hdr", "crlf.hdr", "layer-named.exr", "multipart.exr", "linear-16bit-gama.png", "mask.jpg"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/images")
}

/// The first texel of a map that is read as a colour.
fn color(file: &str, layer: &str) -> Result<[f32; 4], String> {
    let mut scene = Scene::default();
    let map = ColorMap { map: file.into(), layer: layer.into(), value: [1.0; 3] };
    scene.base.color = Color::Mapped(map);
    let set = MapSet::load(&scene, &Assets { folders: vec![folder()] }).map_err(|e| e.to_string())?;
    Ok(set.images[0].texels[0])
}

#[test]
fn radiance_images_with_any_signature_and_line_ends() {
    for name in ["rgbe_magic.hdr", "crlf.hdr"] {
        let map = Panorama::load(&folder().join(name), "", None, &mut Vec::new()).unwrap();
        assert_eq!((map.width, map.height), (32, 16), "{name}");
        // Mantissa 204 and exponent 126: 204 / 256 * 2^-2.
        // One bright spot: mantissas 160, 144 and 120, exponent 134.
        let (sky, sun): (Vec<&[f32; 3]>, Vec<&[f32; 3]>) =
            map.texels.iter().partition(|t| **t == [0.199_218_75; 3]);
        assert!(sun.len() < 6 && sun.iter().all(|t| **t == [40.0, 36.0, 30.0]), "{name}: {sun:?}");
        assert!(sky.len() > 500, "{name}");
    }
}

#[test]
fn layers_of_an_exr() {
    let first = color("multipart.exr", "").unwrap();
    assert_eq!(color("multipart.exr", "beauty"), Ok(first));
    let other = color("multipart.exr", "spec").unwrap();
    assert_ne!(first, other);
    let wrong = color("multipart.exr", "diffuse").unwrap_err();
    assert!(wrong.contains("beauty, spec") && !wrong.contains("ends early"), "{wrong}");
    let named = color("layer-named.exr", "").unwrap();
    assert_eq!(color("layer-named.exr", "ViewLayer.Combined"), Ok(named));
    assert!(named[..3].iter().any(|v| *v > 0.0));
    let wrong = color("linear-16bit-gama.png", "beauty").unwrap_err();
    assert!(wrong.contains("only OpenEXR"), "{wrong}");
    println!("{first:?} {other:?} {named:?}");
}

#[test]
fn png_says_how_it_is_encoded() {
    let found = color("linear-16bit-gama.png", "").unwrap();
    assert!(found[..3].iter().all(|v| (v - 0.5).abs() < 1e-4), "{found:?}");
}

#[test]
fn formats_are_recognised_by_content() {
    let jpeg = io::read(folder().join("mask.jpg")).unwrap();
    let temporary = tempfile::tempdir().unwrap();
    let renamed = temporary.path().join("mask.png");
    std::fs::copy(folder().join("mask.jpg"), &renamed).unwrap();
    assert_eq!(io::read(&renamed).unwrap(), jpeg);
    // An uncompressed Targa of one orange pixel, stored as B, G, R.
    let mut targa = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0x20];
    targa.extend([0, 188, 255]);
    let path = temporary.path().join("a.tga");
    std::fs::write(&path, targa).unwrap();
    let read = io::read(&path).unwrap();
    assert_eq!([read.plane("R").unwrap()[0], read.plane("B").unwrap()[0]], [1.0, 0.0]);
    assert!((read.plane("G").unwrap()[0] - 0.502_886).abs() < 1e-5, "188 in sRGB");
}

/// Cuts, flips and forged sizes: an error or an image, but no panic, hang or huge allocation.
#[test]
fn damage_is_an_error() {
    let temporary = tempfile::tempdir().unwrap();
    let mut random = 0x2016_u32;
    let mut next = |n: usize| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize % n
    };
    for name in NAMES {
        let whole = std::fs::read(folder().join(name)).unwrap();
        let path = temporary.path().join(name);
        for case in 0..60 {
            let mut bytes = whole.clone();
            match case % 3 {
                0 => bytes.truncate(next(bytes.len())),
                1 => (0..4).for_each(|_| {
                    let i = next(bytes.len());
                    bytes[i] ^= 1 << next(8);
                }),
                _ => {
                    let i = next(bytes.len().min(300) - 4);
                    bytes[i..i + 4].fill(0xff);
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            if let Err(error) = io::read(&path) {
                let text = error.to_string();
                assert!(text.contains(name), "{text}");
            }
        }
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert!(io::read(&path).is_err(), "half of {name}");
    }
}

#[test]
fn exr_names_its_primaries() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("a.exr");
    io::write(&Film::new(2, 2), &path, &Metadata::default(), &FilmSpec::default()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let key = b"chromaticities\0chromaticities\0\x20\0\0\0";
    let at = bytes.windows(key.len()).position(|w| w == key).expect("the attribute") + key.len();
    let found: Vec<f32> =
        bytes[at..at + 32].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(found, [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    io::read(&path).unwrap();
}

#[test]
fn outside_of_a_crop_window_is_transparent() {
    let mut film = Film::from_premultiplied(4, 2, &[[0.5, 0.5, 0.5, 1.0]; 8]);
    film.push("background.R", false, vec![0.25; 8]);
    composite::clear_outside(&mut film, [0.5, 1.0, 0.0, 0.5]);
    let wanted = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(film.plane("A").unwrap(), wanted);
    assert_eq!(film.plane("background.R").unwrap(), wanted.map(|v| 0.25 * v));
}

#[test]
fn more_than_64_lights_are_refused() {
    use pelage_core::light::lights_of;
    use pelage_core::scene::{DirectionalLight, Environment};
    let light = || DirectionalLight { direction: [0.0, 1.0, 0.0], irradiance: [1.0; 3] };
    let of = |given: usize, made: Option<u32>| {
        let scene = Scene {
            lights: (0..given).map(|_| light()).collect(),
            environment: made.map(|lights| Environment { lights, ..Environment::default() }),
            ..Scene::default()
        };
        lights_of(&scene, &Assets::default(), &mut Vec::new()).map(|l| l.len()).map_err(|e| e.to_string())
    };
    assert_eq!(of(64, None), Ok(64));
    assert_eq!(of(2, Some(62)), Ok(64));
    for (given, made) in [(65, None), (200, None), (2, Some(64))] {
        assert!(of(given, made).unwrap_err().contains("at most 64"));
    }
}
