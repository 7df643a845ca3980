//! `shared/random` and `shared/octahedral` against their CPU twins.

use crate::common::gpu;
use glam::Vec3;
use pelage_fur::{octahedral, random as hash};

const CODE: &str = "
#import shared/random
#import shared/octahedral
@group(0) @binding(50) var<storage, read> input: array<vec2u>;
@group(0) @binding(51) var<storage, read_write> output: array<vec4u>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&input) { return; }
    let k = input[id.x];
    let v = random_direction(k.x, k.y);
    let e = octahedral_encode(v);
    let back = octahedral_decode(e);
    output[4u * id.x] = vec4u(hash(k.x), hash2(k.x, k.y), bitcast<u32>(random(k.x, k.y)), 0u);
    output[4u * id.x + 1u] = vec4u(bitcast<vec3u>(v), 0u);
    output[4u * id.x + 2u] = vec4u(bitcast<vec2u>(e), 0u, 0u);
    output[4u * id.x + 3u] = vec4u(bitcast<vec3u>(back), 0u);
}";

#[test]
fn the_gpu_draws_the_same_numbers() {
    let Some(gpu) = gpu::open() else { return };
    let mut input: Vec<[u32; 2]> = (0..4000u32).map(|i| [i.wrapping_mul(2_654_435_761), i % 17]).collect();
    input.extend([[0, 0], [u32::MAX, u32::MAX], [1, u32::MAX - 0x9e37_79b8]]);
    let output: Vec<[u32; 4]> = gpu::evaluate(gpu, CODE, &[], &input, 4 * input.len());
    let vector = |w: [u32; 4]| Vec3::new(f32::from_bits(w[0]), f32::from_bits(w[1]), f32::from_bits(w[2]));
    for (k, out) in input.iter().zip(output.chunks(4)) {
        let [a, b] = *k;
        assert_eq!(out[0], [hash::hash(a), hash::hash2(a, b), hash::random(a, b).to_bits(), 0], "{k:?}");
        let direction = hash::random_direction(a, b);
        assert!((vector(out[1]) - direction).length() < 1e-5, "{k:?}: {:?} {direction}", vector(out[1]));
        let e = octahedral::encode(vector(out[1]));
        assert!((vector(out[2]).truncate() - e).length() < 1e-5, "{k:?}");
        assert!((vector(out[3]) - direction).length() < 1e-5, "{k:?}");
    }
}

#[test]
fn numbers_are_uniform() {
    // Chi-square with 63 degrees of freedom: the 0.1% and 99.9% quantiles are 34 and 103.
    for seed in 0..20 {
        let mut bins = [0.0f64; 64];
        (0..6400).for_each(|k| bins[(hash::random(seed, k) * 64.0) as usize] += 1.0);
        let chi: f64 = bins.iter().map(|n| (n - 100.0).powi(2) / 100.0).sum();
        assert!((30.0..110.0).contains(&chi), "seed {seed}: {chi}");
    }
    let mean: Vec3 = (0..10_000).map(|s| hash::random_direction(s, 0)).sum::<Vec3>() / 10_000.0;
    assert!(mean.length() < 0.03, "{mean}");
}

#[test]
fn octahedral_map_is_its_own_inverse() {
    let corners = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let others = (0..2000).map(|s| hash::random_direction(s, 0));
    for v in corners.into_iter().chain(others) {
        let e = octahedral::encode(v);
        assert!(e.abs().max_element() <= 1.0 + 1e-6, "{v}");
        assert!((octahedral::decode(e) - v).length() < 1e-6, "{v}");
    }
}
