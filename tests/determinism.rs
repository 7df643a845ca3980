//! The same scene, seed and adapter give the same bytes, whatever the tile size, the memory budget
//! and the order of threads.

use crate::common::worlds::{ball, differing, render};
use pelage_core::scene::{Blend, Filter, FurLayers, Scene};

fn scene(blend: Blend) -> impl Fn(&mut Scene) {
    move |scene| {
        scene.film.filter = Filter::Gaussian;
        scene.render.blend = blend;
        scene.render.virtual_fragments = 8;
    }
}

fn with(blend: Blend, edit: impl FnOnce(&mut Scene)) -> pelage_core::World {
    ball(|s| {
        scene(blend)(s);
        edit(s);
    })
}

#[test]
fn two_runs_are_equal_to_the_last_bit() {
    for blend in [Blend::Exact, Blend::Virtual, Blend::Simplified] {
        let world = with(blend, |_| ());
        let found = differing(&render(&world).film, &render(&world).film);
        assert!(found.is_empty(), "{blend:?}: plane, pixels, most, first: {found:?}");
    }
}

#[test]
fn tile_size_does_not_change_the_image() {
    for blend in [Blend::Exact, Blend::Virtual, Blend::Simplified] {
        let whole = render(&with(blend, |_| ()));
        for tile in [64, 100, 8] {
            let tiled = render(&with(blend, |s| s.render.tile = Some(tile)));
            assert!(tiled.stats.tiles > whole.stats.tiles);
            let found = differing(&whole.film, &tiled.film);
            println!("{blend:?} tile {tile}: {} tiles, {found:?}", tiled.stats.tiles);
            assert!(found.is_empty(), "{blend:?}, tile {tile}: plane, pixels, most, first: {found:?}");
        }
    }
}

#[test]
fn shells_are_the_same_in_two_runs_and_nearly_so_in_other_tiles() {
    let shells = |tile: Option<u32>| {
        let world = with(Blend::Exact, |s| {
            s.render.fur = FurLayers::Shells;
            s.render.tile = tile;
            s.bake.resolution = [32; 2];
        });
        render(&world)
    };
    let whole = shells(None);
    let again = differing(&whole.film, &shells(None).film);
    assert!(again.is_empty(), "plane, pixels, most, first: {again:?}");
    let tiled = shells(Some(40));
    assert!(tiled.stats.tiles > 1);
    for name in ["R", "G", "B", "A"] {
        let [a, b] = [&whole, &tiled].map(|f| f.film.plane(name).expect("a plane"));
        let most = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{name}: {most}");
        assert!(most < 2e-3, "{name}: {most}");
    }
}

#[test]
fn the_seed_changes_the_image() {
    let found = differing(
        &render(&with(Blend::Exact, |_| ())).film,
        &render(&with(Blend::Exact, |s| s.render.seed = 1)).film,
    );
    assert!(found.iter().any(|f| f.0 == "R"), "two seeds made the same image");
}

#[test]
fn the_budget_does_not_change_the_image() {
    // Coarser than the defaults, so that it fits a small budget; more hairs, so that tiles
    // overflow.
    let dense = |memory: u64| {
        with(Blend::Virtual, |s| {
            s.render.memory = memory;
            s.film.filter = Filter::Box;
            s.guard.density = 600.0.into();
            s.guard.segments = 3;
            s.render.virtual_fragments = 40;
        })
    };
    let roomy = render(&dense(1 << 30));
    assert_eq!(roomy.stats.tiles_retried, 0);
    let tight = render(&dense(20 << 20));
    println!("{} retried of {}", tight.stats.tiles_retried, tight.stats.tiles);
    assert!(tight.stats.tiles_retried > 0, "the small budget was not small enough to test anything");
    // With the box filter no sample is in two tiles, so that the counts are equal too.
    assert_eq!(roomy.stats.fragments, tight.stats.fragments);
    assert_eq!(roomy.stats.fragments_max, tight.stats.fragments_max);
    let found = differing(&roomy.film, &tight.film);
    assert!(found.is_empty(), "plane, pixels, most, first: {found:?}");
}

#[test]
fn strands_out_of_core_do_not_change_the_image() {
    let hairy = |memory: u64| {
        with(Blend::Exact, |s| {
            s.render.memory = memory;
            s.film.spp = 1;
            s.guard.density = 3000.0.into();
        })
    };
    let roomy = render(&hairy(1 << 30));
    let tight = render(&hairy(20 << 20));
    // A strand takes a root and for each of seven vertices 24 bytes; three tenths of the budget are
    // for strands.
    assert!(roomy.stats.strands * 184 > (20 << 20) * 3 / 10, "all strands fit: nothing was tested");
    assert_eq!(roomy.stats.strands, tight.stats.strands);
    let found = differing(&roomy.film, &tight.film);
    assert!(found.is_empty(), "plane, pixels, most, first: {found:?}");
}

#[test]
fn viewport_of_shader_and_recorder_are_one() {
    let frame = pelage_render::shaders::text("shared/frame").expect("shared/frame");
    let line = format!("const RASTER_MARGIN: f32 = {:.1};", pelage_gpu::recorder::RASTER_MARGIN);
    assert!(frame.contains(&line), "no line `{line}` in shared/frame.wgsl");
}
