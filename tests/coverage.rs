//! Mean opacity of guard hairs against an independent sampler: points of the film, and the ribbons
//! that cover them.
//!
//! Only the strands themselves are shared with the renderer. `scripts/witness/coverage.py`
//! does the same for exported files.

use crate::common::gpu;
use glam::{DVec2, DVec3};
use pelage_core::World;
use pelage_core::hair::HairFile;
use pelage_render::RenderOptions;

/// Hairs on a plane seen from the side, without a background. The compared rows are above the
/// plane.
const SCENE: &str = r#"
[mesh]
shape = "plane"
[camera]
eye = [0, 1.2, 30]
target = [0, 1.2, 0]
fov = 7.6
[[lights]]
[guard]
density = 5
length = 2.4
diameter = [80, 130, 30]
comb = 0.3
spread = 15
segments = 8
opacity = 0.9
tip_fade = 0.4
[film]
width = 160
height = 64
spp = 16
filter = "box"
background = "transparent"
[render]
fur = "explicit"
"#;
/// Rows from the top.
const ROWS: usize = 44;
/// Points along a pixel's edge.
const POINTS: usize = 8;

/// One piece of a strand on the film, pixels.
struct Piece {
    a: DVec2,
    b: DVec2,
    radius: [f64; 2],
    opacity: [f64; 2],
}

/// The strands as the camera of `world` sees them, with diameters times `thicker`.
fn pieces(world: &World, hair: &HairFile, thicker: f64) -> Vec<Piece> {
    let camera = &world.scene.camera;
    let [eye, target, up] = [camera.eye, camera.target, camera.up].map(|v| DVec3::from(v.map(f64::from)));
    let forward = (target - eye).normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let (width, height) = (f64::from(world.scene.film.width), f64::from(world.scene.film.height));
    let scale = 0.5 * height / (0.5 * f64::from(camera.fov).to_radians()).tan();
    let project = |p: glam::Vec3| {
        let v = p.as_dvec3() - eye;
        let z = v.dot(forward);
        (DVec2::new(0.5 * width + scale * v.dot(right) / z, 0.5 * height - scale * v.dot(up) / z), scale / z)
    };
    let mut all = Vec::new();
    for (first, points) in hair.strands() {
        for k in 0..points.len() - 1 {
            let ((a, size_a), (b, size_b)) = (project(points[k]), project(points[k + 1]));
            let radius = |k: usize, size: f64| 0.5 * f64::from(hair.thickness[first + k]) * thicker * size;
            let opacity = |k: usize| 1.0 - f64::from(hair.transparency[first + k]);
            all.push(Piece {
                a,
                b,
                radius: [radius(k, size_a), radius(k + 1, size_b)],
                opacity: [opacity(k), opacity(k + 1)],
            });
        }
    }
    all
}

/// Mean opacity over the first rows, from points on a jittered grid.
fn sampled(world: &World, pieces: &[Piece]) -> f64 {
    let (columns, rows) = (world.scene.film.width as usize, ROWS);
    // The pieces that may touch each pixel.
    let mut near = vec![Vec::new(); columns * rows];
    for (i, piece) in pieces.iter().enumerate() {
        let reach = DVec2::splat(piece.radius[0].max(piece.radius[1]));
        let [low, high] = [piece.a.min(piece.b) - reach, piece.a.max(piece.b) + reach].map(DVec2::floor);
        let clamp = |v: f64, n: usize| v.clamp(-1.0, n as f64) as i64;
        for y in clamp(low.y, rows).max(0)..=clamp(high.y, rows).min(rows as i64 - 1) {
            for x in clamp(low.x, columns).max(0)..=clamp(high.x, columns).min(columns as i64 - 1) {
                near[y as usize * columns + x as usize].push(i);
            }
        }
    }
    // A linear congruential generator is random enough to displace points.
    let mut state = 12345u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut sum = 0.0;
    for (pixel, near) in near.iter().enumerate() {
        let corner = DVec2::new((pixel % columns) as f64, (pixel / columns) as f64);
        for point in 0..POINTS * POINTS {
            let cell = DVec2::new((point % POINTS) as f64 + random(), (point / POINTS) as f64 + random());
            let p = corner + cell / POINTS as f64;
            let mut through = 1.0;
            for piece in near.iter().map(|i| &pieces[*i]) {
                let d = piece.b - piece.a;
                let t = (p - piece.a).dot(d) / d.length_squared().max(1e-12);
                let across = (p - piece.a).perp_dot(d).abs() / d.length().max(1e-6);
                let mix = |[a, b]: [f64; 2]| a + (b - a) * t;
                if (0.0..1.0).contains(&t) && across < mix(piece.radius) {
                    through *= 1.0 - mix(piece.opacity);
                }
            }
            sum += 1.0 - through;
        }
    }
    sum / (columns * rows * POINTS * POINTS) as f64
}

fn rendered(world: &World) -> f64 {
    let frame = pelage_shells::render(world, &RenderOptions::default()).expect("the scene renders");
    assert_eq!(frame.stats.fragments_dropped, 0);
    let alpha = frame.film.plane("A").expect("alpha");
    let count = world.scene.film.width as usize * ROWS;
    alpha[..count].iter().map(|a| f64::from(*a)).sum::<f64>() / count as f64
}

#[test]
fn mean_opacity_is_that_of_an_independent_sampler() {
    let world = gpu::world(SCENE);
    let hair = pelage_render::strands::strands(&world).expect("the strands are exported");
    let ours = rendered(&world);
    let witness = sampled(&world, &pieces(&world, &hair, 1.0));
    let thicker = sampled(&world, &pieces(&world, &hair, 1.1));
    println!(
        "{} strands: image {ours:.5}, witness {witness:.5}, 10 % thicker {thicker:.5}",
        hair.segments.len()
    );
    assert!(ours > 0.1 && ours < 0.8, "{ours}: too little or too much to tell anything");
    assert!((ours / witness - 1.0).abs() < 0.01, "image {ours}, witness {witness}");
    // The comparison detects hairs that are 10 % too thick.
    assert!((ours / thicker - 1.0).abs() > 0.03, "image {ours}, witness of thicker hairs {thicker}");
}
