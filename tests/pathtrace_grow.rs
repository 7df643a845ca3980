//! Strands grown on the CPU: guard hairs like the renderer's, undercoat like its volume.

use crate::common::beams::{Beam, hits, segments, transmittance};
use crate::common::gpu::{self, image, jittered_grid, scaled, world, world_on};
use crate::common::on_threads;
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_fur::random::{hash2, random};
use pelage_fur::shell_prisms::shell_of;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use pelage_fur::{Layer, groom};
use pelage_pathtrace::grow::{GrowOptions, Patch, estimate, grow};
use pelage_pathtrace::strands::Strands;

/// A flat square of `side` cm, facing +y; `text` is the rest of the scene.
fn square(side: f32, text: &str) -> World {
    world(&format!("[mesh]\nshape = \"plane\"\nsize = {side}\n{text}"))
}

/// Upright hairs without random variation; `text` is added to the undercoat.
fn even(side: f32, text: &str) -> World {
    square(
        side,
        &format!(
            "[render]\nfur = \"implicit\"\nseed = 3\n[undercoat]\nnoise_contrast = 0\nheight_variation = 0\n\
             tangent_jitter = 0\nuv_jitter = 0\n{text}"
        ),
    )
}

fn all(world: &World) -> Vec<Strands> {
    grow(world, &GrowOptions::default()).expect("strands")
}

/// The only layer.
fn only(world: &World) -> Strands {
    let mut layers = all(world);
    assert_eq!(layers.len(), 1);
    layers.remove(0)
}

fn roots(strands: &Strands) -> Vec<Vec3> {
    strands.points.iter().step_by(strands.segments + 1).map(|p| p.truncate()).collect()
}

#[test]
fn guard_hairs_are_the_renderers() {
    if gpu::open().is_none() {
        return;
    }
    let guard = "density = { map = \"map.png\", value = 90 }\nlength = { map = \"map.png\", value = 1.2 }\nclump = 0.4\ncurl = 0.05\n\
        comb = 0.5\ncomb_direction = [1, 0, 0.4]\ngravity = 0.4\nsegments = 7\nopacity = 0.9\ntip_fade = 1";
    for seed in [2, 11] {
        let scene = format!(
            "[guard]\n{guard}\n[undercoat]\nheight = 0.3\n[render]\nfur = \"explicit\"\nseed = {seed}\n"
        );
        let map = image("map.png", false, 32, |u, v| [0.3 + 0.7 * u * v; 4]);
        let world = world_on(&scene, Some(scaled(jittered_grid(6, 0.25), 1.0, 6.0)), vec![map]);
        let wanted = pelage_render::strands::strands(&world).expect("strands of the GPU");
        let found = only(&world);
        assert_eq!((found.layer, found.segments), (Layer::Guard, 7));
        assert!(found.hairs.len() > 500, "{} hairs", found.hairs.len());
        assert_eq!(found.hairs.len(), wanted.segments.len());
        let away = |found: &Strands| {
            let pairs = found.points.iter().zip(&wanted.points);
            pairs.map(|(a, b)| a.truncate().distance(*b)).fold(0.0, f32::max)
        };
        let most = away(&found);
        println!("seed {seed}: {} guard hairs, largest distance {most:.2e} cm", found.hairs.len());
        assert!(most < 1e-4, "{most} cm");
        for (i, p) in found.points.iter().enumerate() {
            gpu::close(2.0 * p.w * 1e3, wanted.thickness[i] * 1e3, 2e-3, format!("thickness at {i}"));
            let opacity = found.opacity[i % 8];
            gpu::close(opacity, 1.0 - wanted.transparency[i], 2e-3, format!("opacity at {i}"));
        }
        assert!(found.hairs.iter().all(|h| h.present == 0b111_1111));
        // Hairs in another order are not the same hairs.
        let mut turned = found.clone();
        turned.points.rotate_left(8);
        assert!(away(&turned) > 0.01);
    }
}

#[test]
fn as_many_hairs_as_area_times_density() {
    let flat = even(2.5, "height = 0.3\ndensity = 6000");
    let count = |world: &World| {
        let found = only(world).hairs.len() as f64;
        let wanted = world.skin.area() * 6000.0;
        (found, wanted, (found - wanted) / wanted.sqrt())
    };
    let (found, wanted, sigmas) = count(&flat);
    println!("{found} hairs on 6.25 cm2, {wanted:.0} expected, {sigmas:+.2} sigma");
    assert!(sigmas.abs() < 3.0, "{found} hairs, {wanted} expected");
    // On a curved skin as on a flat one: the density is that of the skin.
    let ball = world(
        "[mesh]\nshape = \"sphere\"\nsize = 2\n[render]\nfur = \"implicit\"\nseed = 4\n\
         [undercoat]\nheight = 0.2\ndensity = 6000\nnoise_contrast = 0\nheight_variation = 0",
    );
    let (found, wanted, sigmas) = count(&ball);
    println!("{found} hairs on a ball, {wanted:.0} expected, {sigmas:+.2} sigma");
    assert!(sigmas.abs() < 3.0, "{found} hairs, {wanted} expected");
    // The comparison detects two per cent more.
    assert!((found * 1.02 - wanted).abs() > 3.0 * wanted.sqrt());
}

#[test]
fn thinning_follows_the_density_map() {
    let scene = "[render]\nfur = \"implicit\"\n[undercoat]\nheight = 0.2\nnoise_contrast = 0\nheight_variation = 0\n\
        tangent_jitter = 0\ndensity = { map = \"map.png\", value = 8000 }";
    let map = image("map.png", false, 64, |u, _| [(2.0 * u - 1.0).clamp(0.0, 1.0); 4]);
    let world = world_on(scene, Some(scaled(jittered_grid(4, 0.0), 0.5, 2.0)), vec![map]);
    let found = roots(&only(&world));
    let part =
        |low: f32, high: f32| found.iter().filter(|p| (low..high).contains(&(p.x / 2.0))).count() as f32;
    assert_eq!(part(0.05, 0.47), 0.0, "hairs where the map is bald");
    let share = part(0.75, 0.95) / part(0.55, 0.95);
    let wanted = (0.9f32.powi(2) - 0.5f32.powi(2)) / (0.9f32.powi(2) - 0.1f32.powi(2));
    assert!((share - wanted).abs() < 0.015, "{share} is not {wanted}");
}

/// Variance over mean of the numbers of points in 40 x 40 cells of the square: 1 for a Poisson
/// process.
fn dispersion(points: &[Vec3], side: f32) -> f64 {
    const N: usize = 40;
    let mut cells = vec![0.0f64; N * N];
    for p in points {
        let at = |x: f32| ((((x / side) + 0.5) * N as f32) as usize).min(N - 1);
        cells[at(p.z) * N + at(p.x)] += 1.0;
    }
    let mean = cells.iter().sum::<f64>() / cells.len() as f64;
    let variance = cells.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / (cells.len() - 1) as f64;
    variance / mean
}

#[test]
fn roots_of_the_undercoat_are_poisson_and_those_of_the_guard_hairs_are_not() {
    // The standard deviation of the ratio over 1600 cells is 3.5 %.
    let undercoat = dispersion(&roots(&only(&even(2.5, "height = 0.1\ndensity = 6000"))), 2.5);
    let guard =
        square(2.5, "[guard]\ndensity = 6000\nlength = 0.1\nsegments = 1\n[render]\nfur = \"explicit\"");
    let guard = dispersion(&roots(&only(&guard)), 2.5);
    println!("variance over mean: undercoat {undercoat:.3}, guard hairs {guard:.3}");
    assert!((undercoat - 1.0).abs() < 0.12, "{undercoat}");
    assert!(guard < 0.8, "{guard}");
}

/// Mean of the volume's density over heights.
fn mean_density(world: &World) -> f64 {
    let packed = groom::pack(world).expect("a groom");
    let shell = pelage_fur::shell::Shell::default();
    let coat = Undercoat { parameters: &packed.undercoat, noise: Field::new(3), shell: &shell, cells: &[] };
    let at = |k: u32| coat.clump_density(Vec3::ZERO, Vec3::ZERO, (k as f32 + 0.5) / 1000.0);
    (0..1000).map(|k| f64::from(at(k))).sum::<f64>() / 1000.0
}

/// Transmittance of the slab's hairs over 120,000 rays at `degrees` from the normal, and that of
/// Beer and Lambert with the extinction times `factor`.
fn slab(world: &World, strands: &Strands, degrees: f32, factor: f64) -> [f64; 2] {
    const RAYS: u32 = 120_000;
    let coat = &world.scene.undercoat;
    let height = coat.height.max();
    let angle = degrees.to_radians();
    let beam = Beam::new(Vec3::new(angle.sin(), -angle.cos(), 0.0));
    // Rays that stay above the square from its top to the skin.
    let drift = height * angle.tan();
    let rays: Vec<Vec2> = (0..RAYS)
        .map(|k| {
            let [x, z] = [random(k, 1), random(k, 2)].map(|u| u - 0.5);
            beam.across(Vec3::new(x * (5.0 - drift - 0.1) - 0.5 * drift, height, 4.9 * z))
        })
        .collect();
    let seen = transmittance(&hits(&beam, &rays, segments(strands)));
    let depth = f64::from(coat.density.max() * coat.diameter[0] * 1e-4 * height) * f64::from(angle).tan();
    [seen, (-factor * depth * mean_density(world)).exp()]
}

#[test]
fn even_slab_follows_beer_and_lambert() {
    let world = even(5.0, "height = 0.3\ndensity = 2500\ndiameter = [15, 15]");
    let strands = only(&world);
    let fits = |[seen, wanted]: [f64; 2]| (seen - wanted).abs() < (0.02 * wanted).max(0.005);
    for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0] {
        let [seen, wanted] = slab(&world, &strands, degrees, 1.0);
        println!(
            "{degrees} degrees: transmittance {seen:.4}, expected {wanted:.4}, {:+.2} %",
            (seen / wanted - 1.0) * 100.0
        );
        assert!(fits([seen, wanted]), "{degrees} degrees: {seen} is not {wanted}");
    }
    for factor in [0.95, 1.05] {
        let wrong = slab(&world, &strands, 45.0, factor);
        println!("extinction times {factor}: {wrong:.4?}");
        assert!(!fits(wrong));
    }
}

/// Chi-square per cell of the hairs that cross height `t` in cells of a millimetre of a square of 2
/// x 2 cm, and their number, against the volume's density there; and both numbers.
fn crossings(world: &World, strands: &Strands, t: f32, against: f32) -> [f64; 3] {
    const N: usize = 20;
    let packed = groom::pack(world).expect("a groom");
    let fur = pelage_fur::layout::UndercoatParameters { diameter_ratio: 1.0, ..packed.undercoat };
    let shell = shell_of(world, &packed);
    let coat = Undercoat { parameters: &fur, noise: Field::new(fur.seed), shell: &shell, cells: &[] };
    let k = (t * strands.segments as f32) as usize;
    let mut seen = vec![0.0f64; N * N];
    for (hair, points) in strands.hairs.iter().zip(strands.points.chunks(strands.segments + 1)) {
        if hair.present >> k & 1 == 1 {
            // The positions of upright hairs.
            let [x, z] = [points[k].x, points[k].z].map(|x| (((x + 1.0) * 10.0) as usize).min(N - 1));
            seen[z * N + x] += 1.0;
        }
    }
    let (mut chi, mut total) = (0.0, 0.0);
    for (cell, seen) in seen.iter().enumerate() {
        const SAMPLES: u32 = 400;
        let mean: f64 = (0..SAMPLES)
            .map(|i| {
                let r = |j| random(hash2(cell as u32, i), j);
                let at = |c: usize, r: f32| (c as f32 + r) / 10.0 - 1.0;
                let p = Vec3::new(at(cell % N, r(0)), 0.0, at(cell / N, r(1)));
                let t = against + (r(2) - 0.5) / strands.segments as f32;
                let jitter = 2.0 * Vec3::new(r(3), r(4), r(5)) - 1.0;
                let jitter = fur.uv_jitter * t.powf(fur.jitter_exponent) * jitter;
                f64::from(coat.clump_density(p, p + jitter, t))
            })
            .sum();
        let wanted = mean / f64::from(SAMPLES) * f64::from(fur.density) / 100.0;
        chi += (seen - wanted).powi(2) / wanted.max(1.0);
        total += wanted;
    }
    [chi / (N * N) as f64, seen.iter().sum(), total]
}

#[test]
fn hairs_are_as_dense_as_the_volume() {
    let world = square(
        2.0,
        "[render]\nfur = \"implicit\"\nseed = 8\n[undercoat]\nheight = 0.5\ntangent_jitter = 0\nnoise_contrast = 0.8\nheight_variation = 0.5",
    );
    let strands = only(&world);
    for t in [0.05, 0.35, 0.55, 0.75] {
        let [chi, seen, wanted] = crossings(&world, &strands, t, t);
        println!("t {t}: {seen} hairs, {wanted:.0} expected, chi-square {chi:.3} a cell");
        assert!((seen / wanted - 1.0).abs() < 0.02, "{seen} hairs cross {t}, {wanted} expected");
        // Of 400 cells: within 3.5 standard deviations, and the noise of what is expected.
        assert!((chi - 1.0).abs() < 0.3, "chi-square {chi} at {t}");
    }
    // The clumps differ from height to height.
    let [chi, seen, wanted] = crossings(&world, &strands, 0.35, 0.75);
    assert!(chi > 2.0 && (seen / wanted - 1.0).abs() > 0.1, "{chi} {seen} {wanted}");
}

#[test]
fn hairs_mostly_end_where_they_are_not_whole() {
    for (name, text) in [
        ("default", ""),
        ("without the turns of the tangents", "tangent_jitter = 0"),
        ("lean 0.5", "lean = 0.5"),
        ("without clumps", "noise_contrast = 0"),
    ] {
        let world = square(
            2.0,
            &format!(
                "[guard]\ncomb_direction = [1, 0, 0]\n[render]\nfur = \"implicit\"\n[undercoat]\ndensity = 10000\n{text}"
            ),
        );
        let strands = only(&world);
        let [mut whole, mut ending, mut floating, mut interrupted] = [0.0f64; 4];
        for hair in &strands.hairs {
            // From the root up without a gap.
            let p = hair.present;
            if p == (1 << strands.segments) - 1 {
                whole += 1.0;
            } else if p & (p + 1) == 0 {
                ending += 1.0;
            } else if (p >> p.trailing_zeros()) & ((p >> p.trailing_zeros()) + 1) == 0 {
                floating += 1.0;
            } else {
                interrupted += 1.0;
            }
        }
        let n = strands.hairs.len() as f64;
        println!(
            "{name}: {n} hairs; whole {:.1} %, ending {:.1} %, beginning above the skin {:.1} %, interrupted {:.1} %",
            100.0 * whole / n,
            100.0 * ending / n,
            100.0 * floating / n,
            100.0 * interrupted / n
        );
        assert!(interrupted < 0.1 * n, "{interrupted} of {n} hairs are interrupted");
    }
}

#[test]
fn the_same_hairs_whatever_the_threads() {
    let world = world(
        "[mesh]\nshape = \"sphere\"\nsize = 1.5\n[guard]\ncomb_direction = [1, 0, 0]\n[render]\nseed = 5\n[undercoat]\nheight = 0.4\nlean = 0.4",
    );
    let grown = |threads| on_threads(threads, || all(&world));
    let (one, two) = (grown(1), grown(2));
    assert_eq!(one.len(), 2);
    for (a, b) in one.iter().zip(&two) {
        assert!(a.hairs.len() > 500);
        assert_eq!((a.layer, a.segments, &a.hairs), (b.layer, b.segments, &b.hairs));
        let bits = |s: &Strands| -> Vec<[u32; 4]> {
            s.points.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
        };
        assert!(bits(a) == bits(b), "points differ");
        assert!(a.points.iter().all(|p| p.is_finite()));
    }
}

#[test]
fn a_patch_contains_the_hairs_rooted_in_it() {
    let world = world(
        "[mesh]\nshape = \"torus\"\nsize = 4\n[render]\nseed = 6\n[undercoat]\nheight = 0.2\nlean = 0.3\ndensity = 4000",
    );
    let patch = Patch { centre: Vec3::new(1.6, 0.5, 0.2), radius: 0.6 };
    let options = GrowOptions { patch: Some(patch), ..Default::default() };
    let (whole, part) = (all(&world), grow(&world, &options).expect("strands"));
    for (whole, part) in whole.iter().zip(&part) {
        let n = whole.segments + 1;
        let inside: Vec<usize> =
            (0..whole.hairs.len()).filter(|i| patch.holds(whole.points[i * n].truncate())).collect();
        assert!(inside.len() > 100 && inside.len() < whole.hairs.len() / 2);
        assert_eq!(inside.len(), part.hairs.len());
        for (k, i) in inside.into_iter().enumerate() {
            assert_eq!(whole.hairs[i], part.hairs[k]);
            assert_eq!(whole.points[i * n..][..n], part.points[k * n..][..n]);
        }
    }
}

#[test]
fn estimates_hold_and_fail_with_readable_errors() {
    let patch = Some(Patch { centre: Vec3::new(0.3, 0.0, -0.2), radius: 0.7 });
    for patch in [None, patch] {
        let world = square(2.0, "[undercoat]\nheight = 0.3\ndensity = 9000");
        let options = GrowOptions { patch, ..Default::default() };
        let estimate = estimate(&world, &options).expect("an estimate");
        let grown = grow(&world, &options).expect("strands");
        let bytes: usize = grown.iter().map(|s| size_of_val(&s.points[..]) + size_of_val(&s.hairs[..])).sum();
        let segments: usize = grown.iter().map(|s| s.hairs.len() * s.segments).sum();
        println!("{estimate:?}: {} and {} hairs, {bytes} bytes", grown[0].hairs.len(), grown[1].hairs.len());
        for (estimated, is) in [
            (estimate.guard_hairs, grown[0].hairs.len()),
            (estimate.undercoat_hairs, grown[1].hairs.len()),
            (estimate.segments, segments),
            (estimate.bytes, bytes),
        ] {
            assert!((estimated as f64 / is as f64 - 1.0).abs() < 0.06, "{estimated} estimated, {is} grown");
        }
        assert!(estimate.check(estimate.bytes).is_ok());
        let error = estimate.check(1000).expect_err("too much").to_string();
        assert!(error.contains("undercoat hairs") && error.contains("GiB"), "{error}");
    }
    let bad = GrowOptions { undercoat_segments: 65, ..Default::default() };
    let error = grow(&square(1.0, ""), &bad).expect_err("65 segments").to_string();
    assert!(error.contains("65") && error.contains("1 to 64"), "{error}");
}

#[test]
fn leaning_hairs_hang_over_the_border_and_keep_their_height() {
    let world = square(
        1.0,
        "[guard]\ncomb_direction = [1, 0, 0]\n[render]\nfur = \"implicit\"\n[undercoat]\ndensity = 4000\nheight = 0.4\nlean = 0.8\n\
         tangent_jitter = 0",
    );
    let strands = only(&world);
    let tip = |points: &[glam::Vec4]| (points[0].truncate(), points[strands.segments].truncate());
    for points in strands.points.chunks(strands.segments + 1) {
        let (root, tip) = tip(points);
        // The direction is (lean t, 1): the tip has moved by half of lean times height.
        let away = tip - root - Vec3::new(0.16, 0.4, 0.0);
        assert!(away.length() < 1e-3, "root {root}, tip {tip}");
        let width = points.iter().map(|p| p.w).collect::<Vec<_>>();
        assert!(
            width.windows(2).all(|w| w[0] > w[1])
                && (width[0] - 7e-4).abs() < 1e-8
                && (width[10] - 4e-4).abs() < 1e-8
        );
    }
    let beyond = strands.points.iter().filter(|p| p.x > 0.5).count();
    assert!(beyond > 1000, "{beyond} points beyond the border");
}
