//! Films after rendering: writing, reading, tone mapping, backgrounds.

use crate::common::films::{chart, plain};
use crate::common::{assets, message, names};
use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::film::{Film, Metadata, composite, io, resample, tonemap};
use pelage_core::scene::{Background, FilmSpec, Tonemap};
use pelage_core::{Error, Scene};
use std::path::Path;

// Writing and reading.

#[test]
fn exr_keeps_planes_and_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut film = chart(37, 19);
    film.push("guard.R", false, vec![0.125; film.pixels()]);
    let depth = (0..film.pixels()).map(|i| if i % 3 == 0 { f32::INFINITY } else { 0.1 + i as f32 });
    film.push("depth.Z", true, depth.collect());
    film.plane_mut("R").unwrap()[0] = 1e6;
    let meta = Metadata::of_program()
        .with_scene("[mesh]\nshape = \"hat\" # Fellmütze\n")
        .with_seed(7)
        .with_command_line(["/some folder/pelage", "render", "a b.toml"]);
    io::write(&film, &path, &meta, &plain()).unwrap();
    let back = io::read(&path).unwrap();
    assert_eq!((back.width, back.height), (37, 19));
    assert_eq!(back.plane("depth.Z"), film.plane("depth.Z"), "32-bit float is exact");
    assert_eq!(back.plane("guard.R"), film.plane("guard.R"));
    let order: Vec<&str> = back.planes.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(order, ["R", "G", "B", "A", "depth.Z", "guard.R"]);
    assert_eq!(back.plane("R").unwrap()[0], 65504.0, "clamped to half, not infinite");
    for (a, b) in film.plane("G").unwrap().iter().zip(back.plane("G").unwrap()) {
        assert!((a - b).abs() <= a.abs() * 1e-3 + 1e-6, "{a} {b}");
    }
    let read = io::read_metadata(&path).unwrap();
    assert_eq!(read.get("scene"), meta.get("scene"));
    assert_eq!(read.get("scene_sha256").unwrap().len(), 64);
    assert_eq!(read.get("command_line"), Some("pelage render \"a b.toml\""));
    assert_eq!(names(folder.path()), ["a.exr"], "no temporary is left");
}

#[test]
fn the_same_film_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let film = chart(64, 300);
    let meta = Metadata::of_program().with_scene("x").with_seed(1).with_adapter("a", "b");
    for extension in ["exr", "png"] {
        let of = |i: u32| {
            let path = folder.path().join(format!("{i}.{extension}"));
            io::write(&film, &path, &meta, &plain()).unwrap();
            std::fs::read(path).unwrap()
        };
        let first = of(0);
        assert!((1..8).all(|i| of(i) == first), "{extension}");
    }
}

#[test]
fn png_keeps_colours_alpha_and_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let film = chart(40, 30);
    let long = "scene text ".repeat(1000);
    let meta = Metadata::of_program().with_scene(&long).with("note", "mü");
    io::write(&film, &path, &meta, &plain()).unwrap();
    let back = io::read(&path).unwrap();
    for name in ["R", "G", "B", "A"] {
        for (a, b) in film.plane(name).unwrap().iter().zip(back.plane(name).unwrap()) {
            assert!((a - b).abs() < 0.01, "{name}: {a} {b}");
        }
    }
    let read = io::read_metadata(&path).unwrap();
    assert_eq!((read.get("scene"), read.get("note")), (Some(long.as_str()), Some("mü")));
    // A picture that was read and is written again has the same 8-bit values.
    let again = folder.path().join("b.png");
    io::write(&back, &again, &meta, &plain()).unwrap();
    assert_eq!(io::read(&again).unwrap(), back);
}

#[test]
fn an_opaque_png_has_no_alpha_channel() {
    let folder = tempfile::tempdir().unwrap();
    for (alpha, expected) in [(1.0, 2u8), (0.5, 6u8)] {
        let path = folder.path().join("a.png");
        let film = Film::from_premultiplied(2, 2, &[[0.2, 0.2, 0.2, alpha]; 4]);
        io::write(&film, &path, &Metadata::default(), &plain()).unwrap();
        assert_eq!(std::fs::read(&path).unwrap()[25], expected, "colour type in IHDR");
    }
    let mut pixel = io::read(folder.path().join("a.png")).unwrap().premultiplied().unwrap()[0];
    pixel[3] -= 128.0 / 255.0;
    assert!(
        pixel[3].abs() < 1e-6 && (pixel[0] - 0.2).abs() < 2e-3,
        "straight in the file, premultiplied again"
    );
}

#[test]
fn unknown_extensions_are_usage_errors() {
    for path in ["a.gif", "a", "a.exr.txt"] {
        for result in [
            io::check_writable(path),
            io::write(&chart(2, 2), path, &Metadata::default(), &plain()),
            io::read(path).map(|_| ()),
        ] {
            assert!(matches!(&result, Err(Error::Usage(text)) if text.contains(".exr")), "{result:?}");
        }
    }
}

#[test]
fn check_writable_leaves_nothing_and_names_the_fault() {
    let folder = tempfile::tempdir().unwrap();
    io::check_writable(folder.path().join("new.exr")).unwrap();
    assert!(names(folder.path()).is_empty());
    let missing = folder.path().join("no/such/a.png");
    assert!(message(io::check_writable(&missing)).contains("does not exist"));
    std::fs::create_dir(folder.path().join("dir.png")).unwrap();
    assert!(message(io::check_writable(folder.path().join("dir.png"))).contains("folder"));
    let locked = folder.path().join("locked.png");
    std::fs::write(&locked, "old").unwrap();
    let mut permissions = std::fs::metadata(&locked).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&locked, permissions).unwrap();
    assert!(message(io::check_writable(&locked)).contains("write-protected"));
    let result = io::write(&chart(2, 2), &locked, &Metadata::default(), &plain());
    assert!(message(result).contains("locked.png"));
    assert_eq!(std::fs::read(&locked).unwrap(), b"old");
}

#[test]
fn a_failed_write_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, "old").unwrap();
    let failing = pelage_core::files::write_atomically(&path, |file| {
        std::io::Write::write_all(file, b"half of the new one")?;
        Err("no space left".into())
    });
    assert!(message(failing).contains("no space left"));
    let mut torn = chart(4, 4);
    torn.planes[1].data.pop();
    assert!(message(io::write(&torn, &path, &Metadata::default(), &plain())).contains("15 values"));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[cfg(unix)]
#[test]
fn outputs_are_readable_by_others_and_links_stay_links() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (path, plain_file, link) =
        (folder.path().join("a.png"), folder.path().join("plain"), folder.path().join("link.png"));
    std::os::unix::fs::symlink(&path, &link).unwrap();
    io::write(&chart(2, 2), &path, &Metadata::default(), &plain()).unwrap();
    std::fs::write(&plain_file, "").unwrap();
    let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain_file), "the umask decides");
    io::write(&chart(3, 2), &link, &Metadata::default(), &plain()).unwrap();
    assert!(link.is_symlink());
    assert_eq!(io::read(&path).unwrap().width, 3);
}

fn hdr_bytes(size: &str, pixels: usize) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    bytes.extend((0..pixels).flat_map(|_| [128u8, 64, 32, 129]));
    bytes
}

#[test]
fn damaged_pictures_are_clear_errors() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        io::read(path)
    };
    let film = at("good.hdr", &hdr_bytes("-Y 2 +X 3", 6)).unwrap();
    assert_eq!(film.premultiplied().unwrap()[5], [1.0, 0.5, 0.25, 1.0]);
    assert!(message(at("short.hdr", &hdr_bytes("-Y 2 +X 3", 5))).contains("short.hdr"));
    assert!(message(at("huge.hdr", &hdr_bytes("-Y 60000 +X 60000", 6))).contains("limit"));
    assert!(message(at("odd.hdr", &hdr_bytes("+Y 2 +X 3", 6))).contains("odd.hdr"));
    assert!(message(at("zero.hdr", &hdr_bytes("-Y 0 +X 3", 6))).contains("zero.hdr"));
    for extension in ["exr", "png"] {
        let path = folder.path().join(format!("good.{extension}"));
        io::write(&chart(64, 64), &path, &Metadata::default(), &plain()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for keep in [0, 3, 40, bytes.len() / 2, bytes.len() - 20] {
            let name = format!("cut{keep}.{extension}");
            assert!(message(at(&name, &bytes[..keep])).contains(&name));
        }
        let text = message(at(&format!("text.{extension}"), b"this is not a picture at all"));
        assert!(text.contains("cannot be read as an image"), "{text}");
    }
    assert!(message(io::read(folder.path().join("none.exr"))).contains("cannot be opened"));
}

#[test]
fn forged_sizes_are_errors_before_allocation() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.exr");
    io::write(&chart(64, 64), &good, &Metadata::default(), &plain()).unwrap();
    let bytes = std::fs::read(&good).unwrap();
    let forge = |windows: &[&[u8]], last: i32| {
        let mut forged = bytes.clone();
        for name in windows {
            // Name, zero, "box2i", zero, length; then x0 y0 x1 y1.
            let at = bytes.windows(name.len()).position(|w| w == *name).unwrap() + name.len() + 1 + 6 + 4 + 8;
            forged[at..at + 4].copy_from_slice(&last.to_le_bytes());
            forged[at + 4..at + 8].copy_from_slice(&last.to_le_bytes());
        }
        let path = folder.path().join("forged.exr");
        std::fs::write(&path, forged).unwrap();
        message(io::read(path))
    };
    let both: &[&[u8]] = &[b"dataWindow", b"displayWindow"];
    assert!(forge(both, 1_000_000).contains("limit"), "beyond the pixel cap");
    assert!(forge(both, 9_999).contains("truncated"), "blocks that the file has no room for");
    assert!(forge(&[b"displayWindow"], 99).contains("display window"), "odd data window");
    let path = folder.path().join("good.png");
    io::write(&chart(8, 8), &path, &Metadata::default(), &plain()).unwrap();
    let mut png = std::fs::read(&path).unwrap();
    // Width in IHDR; its checksum is then wrong too, which is also a clear error.
    png[16..20].copy_from_slice(&0x7fff_ffffu32.to_be_bytes());
    let path = folder.path().join("forged.png");
    std::fs::write(&path, png).unwrap();
    assert!(message(io::read(path)).contains("forged.png"));
}

#[test]
fn flipped_bytes_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let hdr = folder.path().join("a.hdr");
    std::fs::write(&hdr, hdr_bytes("-Y 8 +X 8", 64)).unwrap();
    for extension in ["exr", "png"] {
        let path = folder.path().join(format!("a.{extension}"));
        io::write(&chart(24, 24), path, &Metadata::of_program(), &plain()).unwrap();
    }
    let mut state = 1u32;
    let mut random = |n: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % n
    };
    for extension in ["exr", "png", "hdr"] {
        let path = folder.path().join(format!("a.{extension}"));
        let bytes = std::fs::read(&path).unwrap();
        for _ in 0..300 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random(4) {
                let at = random(damaged.len());
                damaged[at] = random(256) as u8;
            }
            let path = folder.path().join(format!("damaged.{extension}"));
            std::fs::write(&path, damaged).unwrap();
            if let Ok(film) = io::read(&path) {
                film.validate().unwrap();
            }
        }
    }
}

// Tone mapping.

#[test]
fn srgb_has_its_known_values_and_inverts() {
    for (linear, code) in [(0.0, 0.0), (1.0, 1.0), (0.002, 0.02584), (0.18, 0.461_356), (0.5, 0.735_357)] {
        assert!((tonemap::srgb_encode(linear) - code).abs() < 1e-5, "{linear}");
    }
    for code in 0..=255 {
        let linear = tonemap::srgb_decode(code as f32 / 255.0);
        assert_eq!((tonemap::srgb_encode(linear) * 255.0).round() as i32, code);
    }
    assert_eq!(tonemap::srgb_encode(f32::NAN), 0.0);
}

#[test]
fn tone_maps_have_their_known_values() {
    let grey = |kind, v| tonemap::tone_map(kind, Vec3::splat(v));
    let near = |a: Vec3, b: Vec3| assert!((a - b).abs().max_element() < 1e-4, "{a} {b}");
    near(grey(Tonemap::None, 0.18), Vec3::splat(0.18));
    // Neutral subtracts 0.04 and leaves the middle unchanged; at 1.0 the peak 0.96 becomes 1 -
    // 0.0576 / 0.44.
    near(grey(Tonemap::Neutral, 0.5), Vec3::splat(0.46));
    near(grey(Tonemap::Neutral, 0.04), Vec3::splat(0.04 * 0.04 * 6.25));
    near(grey(Tonemap::Neutral, 1.0), Vec3::splat(1.0 - 0.0576 / 0.44));
    // A saturated bright red loses a little saturation: p = 4, p_n = 1 - 0.0576 / 3.48, g = 1 /
    // (0.15 (p - p_n) + 1).
    let (p, p_n) = (4.0f32, 1.0 - 0.0576 / 3.48);
    let g = 1.0 / (0.15 * (p - p_n) + 1.0);
    near(
        tonemap::tone_map(Tonemap::Neutral, Vec3::new(4.0, 0.0, 0.0)),
        Vec3::new(p_n, p_n * (1.0 - g), p_n * (1.0 - g)),
    );
    // AgX: middle grey is the pivot of its curve, 0.5 on a display of exponent 2.2.
    near(grey(Tonemap::Agx, 0.18), Vec3::splat(0.5f32.powf(2.2)));
    assert!(grey(Tonemap::Agx, 1e5).min_element() > 0.99 && grey(Tonemap::Agx, 0.0).max_element() < 1e-4);
    let red = tonemap::tone_map(Tonemap::Agx, Vec3::new(50.0, 0.0, 0.0));
    assert!(red.y > 0.2 && red.z > 0.2, "bright red goes to white: {red}");
    near(grey(Tonemap::Aces, 1.0), Vec3::splat(2.54 / 3.16));
    near(grey(Tonemap::Aces, 0.18), Vec3::splat(0.18 * 0.4818 / (0.18 * 1.0274 + 0.14)));
}

#[test]
fn tone_maps_rise_and_stay_in_range() {
    for kind in [Tonemap::None, Tonemap::Neutral, Tonemap::Agx, Tonemap::Aces] {
        let mut last = -1.0;
        for i in 0..4000 {
            let v = (i as f32 / 100.0 - 20.0).exp2();
            let [r, g, b] = tonemap::tone_map(kind, Vec3::splat(v)).to_array();
            // The published AgX matrices shift greys by less than a thousandth.
            assert!((0.0..=1.0).contains(&r) && (r - g).abs() < 1e-3 && (r - b).abs() < 1e-3, "{kind:?} {v}");
            assert!(r >= last - 1e-6, "{kind:?} falls at {v}");
            last = r;
        }
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX] {
            let out = tonemap::tone_map(kind, Vec3::new(odd, 0.2, 0.3));
            assert!(
                out.is_finite() && out.min_element() >= 0.0 && out.max_element() <= 1.0,
                "{kind:?} {odd}"
            );
        }
    }
}

#[test]
fn exposure_counts_in_stops() {
    let spec = FilmSpec { exposure: 1.0, ..plain() };
    assert_eq!(
        tonemap::display_rgb8(Vec3::splat(0.2), &spec),
        tonemap::display_rgb8(Vec3::splat(0.4), &plain())
    );
}

// Backgrounds.

#[test]
fn over_is_porter_and_duff() {
    assert_eq!(composite::over([0.25, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 1.0]), [0.25, 0.5, 0.0, 1.0]);
    let (a, b, c) = ([0.1, 0.2, 0.3, 0.4], [0.3, 0.1, 0.0, 0.5], [0.2, 0.2, 0.6, 0.75]);
    let (left, right) =
        (composite::over(composite::over(a, b), c), composite::over(a, composite::over(b, c)));
    assert!(left.iter().zip(right).all(|(l, r)| (l - r).abs() < 1e-6), "associative");
}

#[test]
fn backgrounds_fill_what_the_fur_leaves() {
    let assets = Assets::default();
    let mut scene = Scene::default();
    let mut film = Film::from_premultiplied(2, 1, &[[0.1, 0.1, 0.1, 0.25], [0.0; 4]]);
    film.push("base.R", false, vec![0.1, 0.0]);
    scene.film.background = Background::Transparent;
    let mut same = film.clone();
    composite::over_background(&mut same, &scene, &assets).unwrap();
    assert_eq!(same, film);
    scene.film.background = Background::Color;
    scene.film.background_color = [0.4, 0.8, 0.0];
    composite::over_background(&mut film, &scene, &assets).unwrap();
    let pixels = film.premultiplied().unwrap();
    assert!((pixels[0][0] - 0.4).abs() < 1e-6 && pixels[1] == [0.4, 0.8, 0.0, 1.0]);
    assert_eq!((pixels[0][3], film.plane("base.R").unwrap()[0]), (1.0, 0.1));
    let sum = film.plane("base.R").unwrap()[0] + film.plane("background.R").unwrap()[0];
    assert!((sum - pixels[0][0]).abs() < 1e-6, "contributions still add up");
}

#[test]
fn missing_backgrounds_are_scene_errors() {
    let assets = Assets::default();
    let mut scene = Scene::default();
    scene.film.background = Background::Plate;
    assert!(matches!(composite::Backdrop::load(&scene, &assets), Err(Error::Scene(_))));
    scene.film.plate = "no-such.png".into();
    assert!(message(composite::Backdrop::load(&scene, &assets)).contains("no-such.png"));
    scene.film.background = Background::Environment;
    assert!(message(composite::Backdrop::load(&scene, &assets)).contains("[environment]"));
    scene.environment = Some(pelage_core::scene::Environment { visible: false, ..Default::default() });
    assert!(message(composite::Backdrop::load(&scene, &assets)).contains("visible"));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.png"), "bad").unwrap();
    scene.film.background = Background::Plate;
    scene.film.plate = "bad.png".into();
    let assets = Assets { folders: vec![folder.path().to_owned()] };
    let error = composite::Backdrop::load(&scene, &assets).unwrap_err();
    assert_eq!(error.exit_code(), 3);
}

#[test]
fn a_plate_covers_the_film_without_stretching() {
    // A ramp over x: covering a square cuts the sides off and keeps its slope.
    let ramp: Vec<[f32; 4]> = (0..80 * 20).map(|i| [(i % 80) as f32, 0.0, 0.0, 1.0]).collect();
    for (to, slope) in [([20, 20], 1.0), ([10, 10], 2.0), ([40, 40], 0.5), ([10, 20], 1.0)] {
        let out = resample::cover(&ramp, [80, 20], to);
        let middle = to[1] / 2 * to[0] + to[0] / 2;
        assert!((out[middle][0] - out[middle - 1][0] - slope).abs() < 1e-3, "{to:?}");
        assert!((out[middle][0] + out[middle - 1][0] - 79.0).abs() < 1e-2, "{to:?} centred");
    }
    assert_eq!(resample::cover(&ramp, [80, 20], [80, 20]), ramp);
    // Shrinking averages: a checkerboard becomes grey, away from the border.
    let board: Vec<[f32; 4]> = (0..64 * 64).map(|i| [((i % 64 + i / 64) % 2) as f32 * 2.0; 4]).collect();
    let out = resample::cover(&board, [64, 64], [8, 8]);
    assert!(out.iter().all(|p| (p[0] - 1.0).abs() < 0.05));
}

#[test]
fn the_environment_behind_the_fur_is_the_plate_of_the_same_view() {
    let Some(folder) = assets() else { return };
    let plate = folder.join("plates/chinese_garden_plate_yaw0_fov60.png");
    let mut scene = Scene::default();
    // The plate: towards -Z, horizontal field of view 60 degrees, 960 x 540, exposure 1.
    scene.camera.eye = [0.0; 3];
    scene.camera.target = [0.0, 0.0, -1.0];
    scene.camera.fov = 2.0 * (30f32.to_radians().tan() * 540.0 / 960.0).atan().to_degrees();
    scene.film.background = Background::Environment;
    scene.environment = Some(pelage_core::scene::Environment {
        map: "env/chinese_garden_1k.hdr".into(),
        visible: true,
        ..Default::default()
    });
    let assets = Assets::of_folder(Path::new("."));
    let difference = |scene: &Scene| {
        let mut film = Film::new(960, 540);
        composite::over_background(&mut film, scene, &assets).unwrap();
        let expected = io::read(&plate).unwrap();
        let code = |film: &Film| -> Vec<f32> {
            film.plane("G").unwrap().iter().map(|v| tonemap::srgb_encode(*v)).collect()
        };
        let (a, b) = (code(&film), code(&expected));
        a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32
    };
    let right = difference(&scene);
    assert!(right < 0.03, "mean difference {right}");
    for degrees in [-5.0, 5.0, 180.0] {
        scene.environment.as_mut().unwrap().rotate = degrees;
        let wrong = difference(&scene);
        assert!(wrong > 1.5 * right, "turned by {degrees}: {wrong}, right {right}");
    }
}
