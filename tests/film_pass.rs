//! `film` against its CPU twin: from samples of every kind to pixels.

use crate::common::gpu::{self, Fixture};
use crate::common::worlds::{self, ball};
use bytemuck::Zeroable;
use pelage_core::scene::Filter;
use pelage_fur::layout::Reconstruction;
use pelage_fur::random::{hash2, random};
use pelage_gpu::Recorder;
use pelage_gpu::recorder::Timings;
use pelage_render::twin::film::{PLANES, Sample, pixel, unpack};

/// Samples with random fields, with features if `words` is 16 instead of 8; some see nothing.
fn samples(count: u32, words: usize) -> Vec<Vec<u32>> {
    (0..count)
        .map(|i| {
            let half = |k: u32| u32::from(half::f16::from_f32(random(i, k)).to_bits());
            let pair = |k: u32| half(k) | (half(k + 1) << 16);
            let nothing = i % 5 == 0;
            let z = if nothing { 1e30 } else { 4.0 + random(i, 20) };
            let normal = if i % 3 == 0 { 0 } else { hash2(i, 21) | 1 };
            let coverage = |k: u32| random(i, k).to_bits();
            let all = [
                [pair(0), pair(2), pair(4), pair(6), pair(8), f32::to_bits(z), normal, hash2(i, 22) % 50],
                [pair(30), pair(32), pair(34), pair(36), pair(38), coverage(40), coverage(41), coverage(42)],
            ];
            all.concat()[..words].to_vec()
        })
        .collect()
}

/// Weights along an axis, and their number.
fn weights(filter: Filter, grid: u32) -> (u32, [[f32; 4]; 32], u32) {
    let radius = pelage_core::film::filter::usual_radius(filter);
    let (margin, found) = pelage_core::film::filter::sample_weights(filter, radius, grid).expect("weights");
    let mut packed = [[0.0; 4]; 32];
    found.iter().enumerate().for_each(|(i, w)| packed[i / 4][i % 4] = *w);
    (margin, packed, found.len() as u32)
}

#[test]
fn pixels_agree_with_the_twin() {
    pixels_agree(false);
}

#[test]
fn pixels_with_features_agree_with_the_twin() {
    pixels_agree(true);
}

fn pixels_agree(features: bool) {
    let Some(gpu) = gpu::open() else { return };
    let world = ball(|s| s.render.fur = pelage_core::scene::FurLayers::Base);
    let fixture = Fixture::with_features(gpu, world, features);
    for (filter, grid) in [(Filter::Box, 1), (Filter::Box, 3), (Filter::Gaussian, 2), (Filter::Mitchell, 4)] {
        let (reach, weights, taps) = weights(filter, grid);
        let pixels = [7u32, 5];
        let size = pixels.map(|p| p * grid + 2 * reach);
        let tile = fixture.tile([96, 64], [0, 0], size, 16);
        let words = samples(size[0] * size[1], if features { 16 } else { 8 });
        let all: Vec<Sample> = words.iter().map(|w| unpack(w)).collect();
        let count = u64::from(pixels[0] * pixels[1]);
        let input = gpu.upload("samples", 7, &words.concat()).unwrap();
        let output = gpu.storage("pixels", 7, count * PLANES as u64 * 4).unwrap();
        let mut wanted = vec![[0f64; PLANES]; count as usize];
        // Twice, the second added to the first.
        for pass in 0..2 {
            let r = Reconstruction {
                origin: [reach as i32; 2],
                pixels,
                grid,
                reach: reach as i32,
                taps,
                planes: PLANES as u32,
                accumulate: pass,
                scale: if pass == 0 { 0.75 } else { 0.25 },
                weights,
                ..Reconstruction::zeroed()
            };
            let uniform = gpu.uniform("reconstruction", &r).unwrap();
            let scope = tile.scope().with(&[&input, &output, &uniform]);
            let mut recorder = Recorder::new(gpu);
            fixture.prepared.passes.film.record(&mut recorder, &scope, count).unwrap();
            recorder.submit(&mut Timings::default()).unwrap();
            for (i, sums) in wanted.iter_mut().enumerate() {
                let at = [i as u32 % pixels[0], i as u32 / pixels[0]];
                sums.iter_mut().zip(pixel(&tile.frame, &r, &all, at)).for_each(|(sum, v)| *sum += v);
            }
        }
        let found: Vec<f32> = gpu.read(&output, count * PLANES as u64 * 4).unwrap();
        for (i, sums) in wanted.iter().enumerate() {
            for (p, wanted) in sums.iter().enumerate() {
                let found = f64::from(found[p * count as usize + i]);
                // Single against double precision; fragments and depths are large numbers.
                let tolerance = 2e-5 * (1.0 + wanted.abs());
                assert!(
                    (found - wanted).abs() < tolerance,
                    "{filter:?} {grid}, pixel {i}, plane {p}: {found} is not {wanted}"
                );
            }
        }
    }
}

/// The weights of the renderer's plan add up to 1, so that an even image stays even to its edge.
#[test]
fn even_image_stays_even() {
    for (filter, spp) in
        [(Filter::Gaussian, 1), (Filter::Mitchell, 4), (Filter::Triangle, 3), (Filter::Box, 9)]
    {
        let world = ball(|s| {
            s.film.filter = filter;
            s.film.spp = spp;
            s.film.width = 24;
            s.film.height = 16;
            // From within the ball: all that is seen is the skin's inner side, of alpha 1.
            s.render.fur = pelage_core::scene::FurLayers::Base;
            s.camera.eye = [0.0, 0.0, 0.1];
        });
        let film = worlds::render(&world).film;
        let alpha = worlds::plane(&film, "A");
        assert!(alpha.iter().all(|a| (a - 1.0).abs() < 1e-5), "{filter:?} {spp}: {alpha:?}");
    }
}
