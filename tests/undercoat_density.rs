//! `undercoat_density` against its CPU twin: the stored volume.

use crate::common::gpu::{self, Fixture, jittered_grid, scaled, world_on};
use pelage_fur::random as hash;
use pelage_fur::undercoat::{DENSITY_RANGE, Medium, Undercoat, pack_medium, unpack_medium};
use pelage_render::twin::undercoat_density::media;

/// Half a diagonal step of the octahedral map of ten bits, where it stretches most: sqrt(2) / 1023
/// x 3.
const TANGENT_STEP: f32 = 4.2e-3;

fn furry(undercoat: &str, seed: u32) -> pelage_core::World {
    let scene = format!(
        "[undercoat]\nheight = 0.4\nlayers = 6\nstorage = \"stored\"\n{undercoat}\n[render]\nfur = \"implicit\"\nseed = {seed}\n"
    );
    world_on(&scene, Some(scaled(jittered_grid(4, 0.2), 1.0, 4.0)), Vec::new())
}

/// Largest difference of the stored volume from the twin's: density, tangent.
fn differences(fixture: &Fixture, wanted: &[Medium]) -> (f32, f32) {
    assert_eq!(fixture.cells.len(), wanted.len());
    let both = fixture.cells.iter().copied().map(unpack_medium).zip(wanted);
    both.fold((0.0, 0.0), |(density, tangent), (found, wanted)| {
        let clamped = wanted.density.min(DENSITY_RANGE);
        (
            f32::max(density, (found.density - clamped).abs()),
            f32::max(tangent, (found.tangent - wanted.tangent).length()),
        )
    })
}

fn twin(fixture: &Fixture) -> Vec<Medium> {
    media(&fixture.evaluated_undercoat())
}

#[test]
fn the_volume_is_that_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    let cases = [
        ("subdivision = 3", 0),
        ("subdivision = 2\nnoise_domain = \"uv\"\nnoise_frequency = 3", 5),
        (
            "cell = 0.2\nlean = 0.8\nnoise_contrast = 1\nheight_variation = 0.9\ntangent_jitter = 1\njitter_exponent = 0.7",
            8,
        ),
        ("subdivision = 0\nnoise_contrast = 0\nheight_variation = 0\ntangent_jitter = 0", 1),
    ];
    for (undercoat, seed) in cases {
        let fixture = Fixture::new(gpu, furry(undercoat, seed));
        assert!(fixture.prepared.variant.stored);
        let wanted = twin(&fixture);
        let (density, tangent) = differences(&fixture, &wanted);
        // Half a step of the stored density and of the octahedral map, and rounding.
        let step = DENSITY_RANGE / 4095.0;
        assert!(density < 0.5 * step + 3e-4, "{undercoat}: density off by {density}");
        assert!(tangent < TANGENT_STEP, "{undercoat}: tangent off by {tangent}");
        if seed == 0 {
            let mean = wanted.iter().map(|m| m.density).sum::<f32>() / wanted.len() as f32;
            assert!((0.3..1.0).contains(&mean), "mean density {mean}");
        }
    }
}

#[test]
fn another_seed_is_seen() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, furry("subdivision = 2", 3));
    let other = pelage_fur::layout::UndercoatParameters { seed: 4, ..fixture.fur.undercoat };
    let wanted = media(&Undercoat { parameters: &other, ..fixture.evaluated_undercoat() });
    let (density, tangent) = differences(&fixture, &wanted);
    assert!(density > 0.05 && tangent > 0.05, "{density} {tangent}");
}

#[test]
fn packing_keeps_a_medium() {
    for s in 0..5000 {
        let m = Medium { density: DENSITY_RANGE * hash::random(s, 9), tangent: hash::random_direction(s, 0) };
        let back = unpack_medium(pack_medium(m));
        assert!((back.density - m.density).abs() <= 0.5001 * DENSITY_RANGE / 4095.0, "{m:?} {back:?}");
        assert!((back.tangent - m.tangent).length() < TANGENT_STEP, "{m:?} {back:?}");
    }
    assert!(
        unpack_medium(pack_medium(Medium { density: 9.0, tangent: glam::Vec3::Z })).density == DENSITY_RANGE
    );
}
