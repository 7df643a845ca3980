//! A lost device is reopened once; finished tiles are kept.

use crate::common;
use pelage_core::{Error, Scene, World};
use pelage_render::{Progress, RenderOptions};
use pelage_shells::render_with;
use std::sync::Mutex;

/// Renders, and destroys the device during the rendering `losses` times, each time after a part of
/// the tiles.
fn render(losses: usize) -> (pelage_core::Result<pelage_render::Frame>, usize) {
    let overrides = ["film.width=24", "film.height=16", "render.tile=8"].map(str::to_owned);
    let (scene, assets) = Scene::load(&common::root().join("tests/data/small.toml"), &overrides).unwrap();
    let world = World::load(scene, &assets).unwrap();
    let opened: Mutex<Vec<wgpu::Device>> = Mutex::default();
    let open = || {
        let gpu = pelage_render::open()?;
        opened.lock().unwrap().push(gpu.device.clone());
        Ok(gpu)
    };
    let lose = |progress: Progress| {
        let opened = opened.lock().unwrap();
        let part = 0.3 * opened.len() as f32;
        if opened.len() <= losses && progress.done >= part && progress.done < 1.0 {
            opened.last().unwrap().destroy();
        }
    };
    let frame = render_with(&open, &world, &RenderOptions { progress: Some(&lose), ..Default::default() });
    let count = opened.lock().unwrap().len();
    (frame, count)
}

#[test]
fn a_lost_device_is_opened_again_and_the_rendering_goes_on() {
    let (whole, opened) = render(0);
    let whole = whole.unwrap();
    assert!(opened == 1 && whole.complete && whole.fault.is_none());
    let (again, opened) = render(1);
    let again = again.unwrap();
    assert!(opened == 2 && again.complete && again.fault.is_none());
    assert_eq!(whole.film, again.film);
    assert_eq!(whole.stats.fragments, again.stats.fragments);
    assert_eq!(whole.stats.tiles, again.stats.tiles);
}

#[test]
fn the_second_loss_ends_with_the_part_that_is_done() {
    let (frame, opened) = render(2);
    let frame = frame.unwrap();
    assert_eq!(opened, 2);
    assert!(!frame.complete);
    let fault = frame.fault.unwrap();
    assert!(matches!(fault, Error::DeviceLost { .. }), "{fault}");
    assert_eq!(fault.exit_code(), 5);
    let alpha = frame.film.plane("A").unwrap();
    let half = alpha.len() / 2;
    assert!(alpha[..half].iter().any(|a| *a > 0.0), "what was done is there");
    assert!(frame.stats.tiles > 0 && !frame.stats.adapter.is_empty());
}
