//! Small pictures of every kind of fur and blending against kept ones.
//!
//! After an intended change of pictures, check them and keep the new ones:
//!
//!     PELAGE_BLESS=1 cargo test --release --test pelage golden::
//!
//! A picture that fails is written to `target/golden/` beside its error image.

use crate::common::films::plain;
use crate::common::root;
use pelage_core::film::{Film, Metadata, composite, io};
use pelage_core::{Scene, World};
use pelage_gpu::Gpu;
use pelage_render::RenderOptions;
use pelage_studies::compare::{self, Comparison, ErrorImage, Thresholds};
use std::path::{Path, PathBuf};

/// Name, scene, overrides.
const PICTURES: &[(&str, &str, &[&str])] = &[
    ("default_hybrid_exact", "scenes/default.toml", &[]),
    ("cylinder_explicit", "scenes/cylinder.toml", &["render.fur=explicit"]),
    ("hat_implicit", "scenes/hat.toml", &["render.fur=implicit"]),
    ("critter_base", "scenes/default.toml", &["render.fur=base"]),
    ("sphere_virtual", "tests/golden/sphere.toml", &["render.blend=virtual"]),
    ("sphere_simplified", "tests/golden/sphere.toml", &["render.blend=simplified"]),
];

/// Overrides for all scenes: small images, and volumes coarse enough for a CPU.
const COMMON: &[&str] =
    &["film.width=160", "film.height=100", "film.spp=4", "undercoat.cell=0.08", "undercoat.layers=12"];

/// Drivers differ in the last bits, and in whether the edge of a hair covers a sample; fur that is
/// lit or placed differently exceeds these thresholds.
const LIMITS: Thresholds = Thresholds {
    rmse: Some(0.012),
    flip: Some(0.03),
    luminance_ratio: Some(0.01),
    relative_mse: None,
    psnr: None,
    ssim: None,
    hdr_flip: None,
    color_ratio: None,
    detail_ratio: None,
    alpha_difference: None,
    max_abs: None,
};

fn kept(name: &str) -> PathBuf {
    root().join("tests/golden").join(format!("{name}.png"))
}

/// The tone-mapped picture, as in the file.
fn picture(gpu: &Gpu, scene: &str, overrides: &[&str], folder: &Path) -> Film {
    let overrides: Vec<String> = COMMON.iter().chain(overrides).map(|o| (*o).to_owned()).collect();
    let (scene, assets) = Scene::load(&root().join(scene), &overrides).expect("the scene is valid");
    let world = World::load(scene, &assets).expect("the scene loads");
    let mut frame = pelage_shells::render_on(gpu, &world, &RenderOptions::default()).expect("it renders");
    composite::over_background(&mut frame.film, &world.scene, &assets).expect("a background");
    let path = folder.join("picture.png");
    io::write(&frame.film, &path, &Metadata::default(), &world.scene.film).expect("it is written");
    io::read(&path).expect("it is read back")
}

#[test]
fn pictures_match_the_kept_ones() {
    let bless = std::env::var_os("PELAGE_BLESS").is_some_and(|v| v == "1");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let gpu = pelage_render::open().expect("an adapter");
    let mut faults = Vec::new();
    for (name, scene, overrides) in PICTURES {
        let film = picture(&gpu, scene, overrides, folder.path());
        let path = kept(name);
        if bless {
            io::write(&film, &path, &Metadata::default(), &plain()).expect("the golden picture is written");
            let bytes = std::fs::metadata(&path).expect("it is there").len();
            assert!(bytes < 40_000, "{name}: {bytes} bytes are too many to keep");
            println!("{name}: kept, {bytes} bytes");
            continue;
        }
        let reference = io::read(&path).unwrap_or_else(|e| panic!("{e}: make it with PELAGE_BLESS=1"));
        let found = compare::compare(&film, &reference).expect("the same size");
        println!(
            "{name}: RMSE {:.5}, FLIP {:.5}, luminance {:.5}",
            found.all.rmse, found.all.flip, found.all.luminance_ratio
        );
        if let Some(reason) = found.exceeds(&LIMITS) {
            let failed = root().join("target/golden");
            std::fs::create_dir_all(&failed).expect("a folder for what failed");
            let error = compare::error_image(&film, &reference, ErrorImage::Flip).expect("the same size");
            io::write(&film, failed.join(format!("{name}.png")), &Metadata::default(), &plain())
                .expect("written");
            io::write(&error, failed.join(format!("{name}_error.png")), &Metadata::default(), &plain())
                .expect("written");
            faults.push(format!("{name}: {reason} (see {})", failed.display()));
        }
    }
    assert!(faults.is_empty(), "{}\nIf this is meant to be: PELAGE_BLESS=1", faults.join("\n"));
}

/// The comparison of two kept pictures, the first through `change`.
fn changed(name: &str, change: impl Fn(usize, [f32; 4]) -> [f32; 4]) -> Comparison {
    let reference = io::read(kept(name)).expect("a golden picture");
    let mut film = reference.clone();
    let pixels: Vec<[f32; 4]> = film
        .premultiplied()
        .expect("four planes")
        .into_iter()
        .enumerate()
        .map(|(i, p)| change(i, p))
        .collect();
    film.set_premultiplied(&pixels);
    compare::compare(&film, &reference).expect("the same size")
}

#[test]
fn a_wrong_picture_is_noticed() {
    let name = "default_hybrid_exact";
    assert!(changed(name, |_, p| p).exceeds(&LIMITS).is_none(), "a picture equals itself");
    let brighter = changed(name, |_, [r, g, b, a]| [1.02 * r, 1.02 * g, 1.02 * b, a]);
    assert!(brighter.exceeds(&LIMITS).is_some(), "2 % brighter: {brighter}");
    let in_tile = |i: usize| (68..92).contains(&(i % 160)) && (40..64).contains(&(i / 160));
    let tile = changed(name, |i, p| if in_tile(i) { [0.0, 0.0, 0.0, p[3]] } else { p });
    assert!(tile.exceeds(&LIMITS).is_some(), "a lost tile: {tile}");
    let reference = io::read(kept(name)).expect("a golden picture");
    let other = io::read(kept("critter_base")).expect("a golden picture");
    let bald = compare::compare(&other, &reference).expect("the same size");
    assert!(bald.exceeds(&LIMITS).is_some(), "no fur: {bald}");
    let pixels = reference.premultiplied().expect("four planes");
    let shifted = changed(name, |i, p| if i % 160 == 0 { p } else { pixels[i - 1] });
    assert!(shifted.exceeds(&LIMITS).is_some(), "a pixel to the right: {shifted}");
}
