//! Maps of the groom: loading, sampling, and errors.

use glam::{Vec2, Vec3};
use pelage_core::assets::Assets;
use pelage_core::maps::{MapImage, MapSet};
use pelage_core::scene::{ColorMap, Scalar, ScalarMap};
use pelage_core::{Result, Scene};
use std::path::Path;

fn scalar(map: &str) -> Scalar {
    Scalar::Mapped(ScalarMap {
        map: map.into(),
        layer: String::new(),
        channel: Default::default(),
        value: 1.0,
        offset: 0.0,
    })
}

fn color(map: &str) -> pelage_core::scene::Color {
    pelage_core::scene::Color::Mapped(ColorMap { map: map.into(), layer: String::new(), value: [1.0; 3] })
}

fn load(folder: &Path, change: impl FnOnce(&mut Scene)) -> Result<MapSet> {
    let mut scene = Scene::default();
    change(&mut scene);
    MapSet::load(&scene, &Assets { folders: vec![folder.to_owned()] })
}

fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> MapImage {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| [texel(x, y), x as f32, y as f32, 1.0]).collect();
    MapImage { name: String::new(), layer: String::new(), color: false, width, height, texels }
}

#[track_caller]
fn close(found: [f32; 4], wanted: [f32; 4]) {
    let difference = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(difference < 1e-5, "{found:?}, expected {wanted:?}");
}

#[test]
fn bilinear_lookup() {
    let map = image(4, 2, |x, y| (10 * y + x) as f32);
    // Texel centres: v = 0.75 is the top row, v = 0.25 the bottom row.
    close(map.bilinear(Vec2::new(0.125, 0.75)), [0.0, 0.0, 0.0, 1.0]);
    close(map.bilinear(Vec2::new(0.625, 0.25)), [12.0, 2.0, 1.0, 1.0]);
    // Halfway between texels.
    close(map.bilinear(Vec2::new(0.25, 0.75)), [0.5, 0.5, 0.0, 1.0]);
    close(map.bilinear(Vec2::new(0.125, 0.5)), [5.0, 0.0, 0.5, 1.0]);
    // Over the edges: the last and the first texel mix.
    close(map.bilinear(Vec2::new(0.0, 0.75)), [1.5, 1.5, 0.0, 1.0]);
    close(map.bilinear(Vec2::new(0.125, 0.0)), [5.0, 0.0, 0.5, 1.0]);
    // Repeated, forwards and backwards.
    for k in [-3.0, -1.0, 1.0, 7.0] {
        close(map.bilinear(Vec2::new(0.4 + k, 0.6 - k)), map.bilinear(Vec2::new(0.4, 0.6)));
    }
    close(map.bilinear(Vec2::new(-1e-9, -1e-9)), map.bilinear(Vec2::ZERO));
    let one = image(1, 1, |_, _| 3.0);
    close(one.bilinear(Vec2::new(0.2, 0.9)), [3.0, 0.0, 0.0, 1.0]);
}

#[test]
fn triplanar_lookup() {
    let map = image(8, 8, |x, y| (x * y) as f32);
    let p = Vec3::new(1.3, 2.6, 4.1);
    let at = |u: f32, v: f32| map.bilinear(Vec2::new(u, v) / 10.0);
    close(map.triplanar(p, Vec3::X, 1.0), at(p.y, p.z));
    close(map.triplanar(p, Vec3::NEG_Y, 1.0), at(p.x, p.z));
    close(map.triplanar(p, Vec3::Z, 1.0), at(p.x, p.y));
    close(map.triplanar(p, Vec3::Z, 2.0), at(2.0 * p.x, 2.0 * p.y));
    let mean: Vec<f32> =
        (0..4).map(|k| (at(p.y, p.z)[k] + at(p.x, p.z)[k] + at(p.x, p.y)[k]) / 3.0).collect();
    close(map.triplanar(p, Vec3::ONE, 1.0), [mean[0], mean[1], mean[2], mean[3]]);
    // Twice the component weighs 16 times as much.
    let mixed: Vec<f32> = (0..4).map(|k| (16.0 * at(p.y, p.z)[k] + at(p.x, p.z)[k]) / 17.0).collect();
    close(map.triplanar(p, Vec3::new(2.0, 1.0, 0.0), 1.0), [mixed[0], mixed[1], mixed[2], mixed[3]]);
    assert!(map.triplanar(p, Vec3::ZERO, 1.0).iter().all(|v| v.is_finite()));
}

fn png(path: &Path, width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) {
    image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y))).save(path).expect("written");
}

#[test]
fn each_map_is_loaded_once_as_color_and_as_scalar() {
    let folder = tempfile::tempdir().expect("temporary folder");
    png(&folder.path().join("a.png"), 3, 2, |x, y| [188, (x * 40) as u8, (y * 200) as u8, 128]);
    let set = load(folder.path(), |scene| {
        scene.guard.density = scalar("a.png");
        scene.undercoat.height = scalar("a.png");
        scene.guard.color_tip = color("a.png");
        scene.base.color = color("a.png");
        scene.guard.length = scalar("vertex_color");
        scene.undercoat.color_root = color("vertex_color");
    })
    .expect("loaded");
    assert_eq!(set.images.len(), 2);
    let raw = &set.images[set.index_of("a.png", "", false).expect("as a scalar")];
    let linear = &set.images[set.index_of("a.png", "", true).expect("as a colour")];
    assert_eq!(set.index_of("b.png", "", true), None);
    assert_eq!((raw.width, raw.height, raw.texels.len()), (3, 2, 6));
    close(raw.texels[1], [188.0 / 255.0, 40.0 / 255.0, 0.0, 128.0 / 255.0]);
    // sRGB 188 is about half the light; alpha stays.
    assert!((linear.texels[1][0] - 0.503).abs() < 1e-3, "{:?}", linear.texels[1]);
    assert!((linear.texels[1][3] - 128.0 / 255.0).abs() < 1e-6);
    assert!(load(folder.path(), |_| ()).expect("nothing named").images.is_empty());
}

#[test]
fn every_mapped_parameter_is_found() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let names: Vec<String> = (0..14).map(|i| format!("{i}.png")).collect();
    names.iter().for_each(|n| png(&folder.path().join(n), 1, 1, |_, _| [0; 4]));
    let set = load(folder.path(), |scene| {
        let (guard, undercoat) = (&mut scene.guard, &mut scene.undercoat);
        let scalars = [
            &mut guard.density,
            &mut guard.length,
            &mut guard.thickness,
            &mut guard.comb,
            &mut guard.clump,
            &mut guard.curl,
            &mut guard.frizz,
            &mut undercoat.density,
            &mut undercoat.height,
        ];
        scalars.into_iter().zip(&names).for_each(|(s, n)| *s = scalar(n));
        let colors = [
            &mut guard.color_root,
            &mut guard.color_tip,
            &mut undercoat.color_root,
            &mut undercoat.color_tip,
            &mut scene.base.color,
        ];
        colors.into_iter().zip(&names[9..]).for_each(|(c, n)| *c = color(n));
    })
    .expect("loaded");
    for (i, name) in names.iter().enumerate() {
        assert!(set.index_of(name, "", i >= 9).is_some(), "{name}");
    }
}

#[test]
fn large_images_are_reduced_by_means() {
    let folder = tempfile::tempdir().expect("temporary folder");
    // Columns of 0 and 255 by turns, and a ramp downwards.
    png(&folder.path().join("a.png"), 4096, 20, |x, y| [(x % 2 * 255) as u8, (y * 10) as u8, 7, 255]);
    let set = load(folder.path(), |scene| scene.guard.density = scalar("a.png")).expect("loaded");
    let map = &set.images[0];
    assert_eq!((map.width, map.height), (2048, 10));
    close(map.texels[5], [0.5, 5.0 / 255.0, 7.0 / 255.0, 1.0]);
    close(map.texels[9 * 2048 + 2047], [0.5, 185.0 / 255.0, 7.0 / 255.0, 1.0]);
    assert_eq!(set.notes, ["a.png: reduced from 4096x20 to 2048x10"]);
    // A ratio that is no whole number keeps the mean.
    png(&folder.path().join("b.png"), 3000, 1, |x, _| [(x % 251) as u8; 4]);
    let set = load(folder.path(), |scene| scene.guard.density = scalar("b.png")).expect("loaded");
    let mean = set.images[0].texels.iter().map(|t| f64::from(t[0])).sum::<f64>() / 2048.0;
    let wanted = (0..3000).map(|x| f64::from(x % 251)).sum::<f64>() / 3000.0 / 255.0;
    assert!((mean - wanted).abs() < 1e-5, "{mean} {wanted}");
}

#[test]
fn hdr_and_exr_stay_linear() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = std::fs::File::create(folder.path().join("a.hdr")).expect("writable");
    let pixels: Vec<image::Rgb<f32>> = (0..12).map(|i| image::Rgb([i as f32, 0.5, 4.0])).collect();
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, 4, 3).expect("written");
    exr::prelude::write_rgba_file(folder.path().join("a.exr"), 4, 3, |x, y| {
        (0.25 * x as f32, f32::NAN, 2.0 * y as f32, 0.5_f32)
    })
    .expect("written");
    let set = load(folder.path(), |scene| {
        scene.guard.density = scalar("a.hdr");
        scene.guard.length = scalar("a.exr");
        scene.guard.color_tip = color("a.exr");
    })
    .expect("loaded");
    assert_eq!(set.images[0].texels[7], [7.0, 0.5, 4.0, 1.0]);
    assert_eq!(set.images[1].texels[7], [0.75, 0.0, 2.0, 0.5]);
    assert_eq!(set.images[2].texels[7], [1.5, 0.0, 4.0, 0.5], "colours are straight");
    assert!(set.notes[0].contains("12 values"), "{:?}", set.notes);
}

#[test]
fn broken_images_are_named_all_at_once() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name);
    png(&path("good.png"), 64, 64, |x, y| [x as u8, y as u8, (x * y) as u8, 255]);
    let bytes = std::fs::read(path("good.png")).expect("readable");
    std::fs::write(path("short.png"), &bytes[..bytes.len() / 2]).expect("writable");
    let mut forged = bytes;
    // The size in the IHDR chunk, whose checksum no longer fits either.
    forged[16..24].copy_from_slice(&[0x7F; 8]);
    std::fs::write(path("forged.png"), &forged).expect("writable");
    std::fs::write(path("text.png"), "not an image").expect("writable");
    std::fs::write(path("empty.png"), "").expect("writable");
    std::fs::write(path("short.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100 +X 100\n")
        .expect("writable");
    std::fs::write(path("forged.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000000000 +X 9\n")
        .expect("writable");
    std::fs::write(path("odd.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 4 -Y 4\n").expect("writable");
    exr::prelude::write_rgb_file(path("good.exr"), 64, 64, |x, y| (x as f32, y as f32, 0.0_f32))
        .expect("written");
    let exr = std::fs::read(path("good.exr")).expect("readable");
    std::fs::write(path("short.exr"), &exr[..exr.len() / 2]).expect("writable");
    // The lower right corner of the data window.
    let mut forged = exr.clone();
    let window = b"dataWindow\0box2i\0";
    let at = exr.windows(window.len()).position(|w| w == window).expect("a data window") + window.len() + 4;
    forged[at + 8..at + 16].copy_from_slice(&[0, 0, 0, 0x40, 0, 0, 0, 0x40]);
    std::fs::write(path("forged.exr"), &forged).expect("writable");

    let names = [
        "short.png",
        "forged.png",
        "text.png",
        "empty.png",
        "short.hdr",
        "forged.hdr",
        "odd.hdr",
        "short.exr",
    ];
    for name in names.into_iter().chain(["forged.exr", "missing.png"]) {
        let error = load(folder.path(), |scene| scene.guard.density = scalar(name)).expect_err(name);
        assert_eq!(error.exit_code(), 3, "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    let error = load(folder.path(), |scene| {
        scene.guard.density = scalar("short.png");
        scene.guard.length = scalar("missing.png");
        scene.guard.color_root = color("short.png");
        scene.guard.color_tip = color("text.png");
    })
    .expect_err("three broken maps");
    let pelage_core::Error::Scene(faults) = error else { panic!("{error}") };
    assert_eq!(faults.len(), 3, "{faults:?}");
}

#[test]
fn every_parameter_of_a_scene_loads_its_map() {
    let folder = std::env::temp_dir().join("pelage-no-such-folder");
    let set = load(&folder, |scene| {
        scene.shells.length = scalar("a.png");
        scene.shells.color = color("b.png");
    });
    let error = set.expect_err("neither is there").to_string();
    assert!(error.contains("a.png") && error.contains("b.png"), "{error}");
}
