//! `shared/noise` against the `noise` crate's simplex noise.

use crate::common::gpu;
use glam::Vec3;
use pelage_fur::random::random;
use pelage_fur::simplex::{Field, noise_tables};

const CODE: &str = "
#import shared/noise
@group(0) @binding(1) var<uniform> noise: Noise;
@group(0) @binding(50) var<storage, read> input: array<vec4f>;
@group(0) @binding(51) var<storage, read_write> output: array<vec2f>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&input) { return; }
    let p = input[id.x].xyz;
    output[id.x] = vec2f(simplex2(p.xy), simplex3(p));
}";

/// Largest difference of the GPU's noise for a seed from the crate's for another: in the plane, in
/// space.
fn differences(gpu: &pelage_gpu::Gpu, seed: u32, seed_of_oracle: u32) -> (f32, f32) {
    let point = |s: u32| Vec3::new(random(s, 0), random(s, 1), random(s, 2)) * 60.0 - 30.0;
    let mut input: Vec<[f32; 4]> = (0..20_000).map(|s| point(s).extend(0.0).to_array()).collect();
    // Near the origin and on the axes, where negative cells begin.
    input.extend((0..200).map(|i| [0.01 * i as f32 - 1.0, 0.0, 0.0, 0.0]));
    let tables = gpu.uniform("noise", &noise_tables(seed)).unwrap();
    let output: Vec<[f32; 2]> = gpu::evaluate(gpu, CODE, &[(1, &tables)], &input, input.len());
    let field = Field::new(seed_of_oracle);
    let (mut worst2, mut worst3) = (0.0f32, 0.0f32);
    for (p, found) in input.iter().zip(output) {
        let p = Vec3::new(p[0], p[1], p[2]);
        worst2 = worst2.max((found[0] - field.simplex2(p.truncate())).abs());
        worst3 = worst3.max((found[1] - field.simplex3(p)).abs());
    }
    (worst2, worst3)
}

#[test]
fn simplex_noise_is_that_of_the_crate() {
    let Some(gpu) = gpu::open() else { return };
    for seed in [0, 1, 77] {
        let (plane, space) = differences(gpu, seed, seed);
        assert!(plane < 1e-4 && space < 1e-4, "seed {seed}: {plane} in the plane, {space} in space");
    }
    // The comparison detects the tables of another seed.
    let (plane, space) = differences(gpu, 1, 2);
    assert!(plane > 0.5 && space > 0.5, "{plane} {space}");
}
