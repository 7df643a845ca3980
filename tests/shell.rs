//! `shared/shell`: subelements, the inverse of the extrusion, hops; the CPU twin on its own, and
//! the GPU against it.

use crate::common::cases;
use crate::common::gpu::{self, Fixture, jittered_grid, world_on};
use glam::Vec3;
use pelage_core::Skin;
use pelage_core::mesh::topology;
use pelage_core::skin::NONE;
use pelage_fur::layout::{Prism, ShellVertex};
use pelage_fur::random::{random, random_direction};
use pelage_fur::shell::{Located, Place, Shell, most_negative, subelement, subelement_centroid};
use proptest::prelude::*;

/// A shell over a skin, as high everywhere as `height` says.
fn shell_of(skin: &Skin, height: impl Fn(usize) -> f32) -> Shell {
    let neighbours = topology::neighbours(&skin.triangles).neighbours;
    let vertex = |i: usize| ShellVertex {
        position: skin.positions[i].into(),
        height: height(i),
        normal: skin.normals[i].into(),
        color: u32::MAX,
    };
    let prisms = skin.triangles.iter().zip(neighbours);
    Shell {
        vertices: (0..skin.positions.len()).map(vertex).collect(),
        prisms: prisms
            .map(|(vertices, neighbours)| Prism {
                vertices: *vertices,
                neighbours,
                ..bytemuck::Zeroable::zeroed()
            })
            .collect(),
        corner_uv: vec![[0.0; 2]; 3 * skin.triangles.len()],
        light_reach: 1.0,
    }
}

/// Uniform in a triangle.
fn barycentric(seed: u32) -> Vec3 {
    let r = random(seed, 10).sqrt();
    let v = random(seed, 11);
    Vec3::new(1.0 - r, r * (1.0 - v), r * v)
}

#[test]
fn subelements_are_numbered_without_gaps() {
    for d in 0..=6u32 {
        let n = 1i64 << d;
        let mut hits = vec![0; 1 << (2 * d)];
        // The centroids of all upright and inverted cells, in thirds of a cell.
        for (a, b) in (0..3 * n).flat_map(|a| (0..3 * n).map(move |b| (a, b))) {
            let c = 3 * n - a - b;
            let upright = [a, b, c].iter().all(|x| x.rem_euclid(3) == 1) && c > 0;
            let inverted = [a, b, c].iter().all(|x| x.rem_euclid(3) == 2) && c > 0;
            if upright || inverted {
                let lambda = Vec3::new(a as f32, b as f32, c as f32) / (3 * n) as f32;
                let id = subelement(lambda, d);
                hits[id as usize] += 1;
                let back = subelement_centroid(id, d);
                assert!((back - lambda).abs().max_element() < 1e-6, "d {d} id {id}: {back} {lambda}");
            }
        }
        assert!(hits.iter().all(|h| *h == 1), "d {d}: {hits:?}");
        for id in 0..1u32 << (2 * d) {
            assert_eq!(subelement(subelement_centroid(id, d), d), id, "d {d}");
        }
    }
}

#[test]
fn subelements_are_numbered_as_in_the_paper() {
    assert_eq!(subelement(Vec3::new(0.5, 0.3, 0.2), 2), 5);
    // The corners' cells: 0, the first of the last row, the last.
    for d in 1..=6u32 {
        let n = 1 << d;
        let near = |k: usize| Vec3::splat(0.001) + 0.997 * Vec3::AXES[k];
        assert_eq!([0, 1, 2].map(|k| subelement(near(k), d)), [0, (n - 1) * (n - 1), n * n - 1]);
    }
    let place = Place {
        cell_base: 10 * 8 * 16,
        subdivision: 2,
        ..shell_of(&jittered_grid(1, 0.0), |_| 1.0).enter(0)
    };
    assert_eq!(place.volume_index(3, 5), 1333);
}

/// Number of a cell without the clamps: off the grid at edges and grid vertices.
fn unclamped(lambda: Vec3, d: u32) -> i32 {
    let i = ((Vec3::ONE - lambda) * (1 << d) as f32).floor().as_ivec3();
    i.x * (1 + i.x) + i.y - i.z
}

#[test]
fn rounding_at_grid_vertices_stays_in_range() {
    let mut outside = 0;
    for d in 0..=6u32 {
        let n = 1i32 << d;
        let ids = 1i32 << (2 * d);
        for (a, b) in (0..=n).flat_map(|a| (0..=n - a).map(move |b| (a, b))) {
            let exact = [a, b, n - a - b].map(|x| x as f32 / n as f32);
            // The last units in the last place on both sides of a grid vertex, and points along the
            // grid's lines.
            for k in 0..343 {
                let nudge = [k % 7, k / 7 % 7, k / 49];
                let lambda = Vec3::from([0, 1, 2].map(|i| exact[i] + (nudge[i] - 3) as f32 * 3e-8));
                let id = subelement(lambda, d);
                assert!((id as i32) < ids, "d {d} {lambda}: {id}");
                outside += i32::from(!(0..ids).contains(&unclamped(lambda, d)));
                // The cell holds the point but for rounding.
                let i = subelement_centroid(id, d);
                assert!(
                    (i - lambda).abs().max_element() < 1.01 * 2.0 / 3.0 / n as f32 + 1e-5,
                    "d {d} {lambda}: {id}"
                );
            }
        }
    }
    assert!(outside > 1000, "without the clamps {outside} points fall out of the grid");
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn a_cell_holds_its_point(u in 0.0f32..1.0, v in 0.0f32..1.0, d in 0u32..=6) {
        let r = u.sqrt();
        let lambda = Vec3::new(1.0 - r, r * (1.0 - v), r * v);
        let id = subelement(lambda, d);
        prop_assert!(id < 1 << (2 * d));
        let away = (subelement_centroid(id, d) - lambda).abs().max_element() * (1 << d) as f32;
        prop_assert!(away <= 2.0 / 3.0 + 1e-3, "{away}");
    }

    #[test]
    fn the_inverse_finds_the_point(seed in 0u32..1_000_000, t in 0.0f32..1.0, height in 0.05f32..0.6) {
        let skin = jittered_grid(4, 0.25);
        let shell = shell_of(&skin, |i| height * (0.7 + 0.3 * random(i as u32, 3)));
        let prism = seed % skin.triangles.len() as u32;
        let lambda = barycentric(seed);
        let mut place = shell.enter(prism);
        let x = place.point(t, lambda);
        place.t = 0.5;
        shell.solve(&mut place, x, Vec3::Y, 6);
        prop_assert!((place.t - t).abs() < 1e-5 && (place.lambda - lambda).abs().max_element() < 1e-5,
            "{} {}, wanted {t} {lambda}", place.t, place.lambda);
        // The slope against a difference.
        let step = 1e-2 * random_direction(seed, 0);
        let mut ahead = place;
        shell.solve(&mut ahead, x + step, step, 6);
        let wanted = ahead.t - place.t;
        shell.solve(&mut place, x, step, 6);
        prop_assert!((place.dt_dz - wanted).abs() < 0.02 * step.length() / height + 0.05 * wanted.abs(), "{} {wanted}", place.dt_dz);
    }

    #[test]
    fn neighbours_agree_on_their_wall(seed in 0u32..100_000, t in 0.0f32..1.0, along in 0.0f32..1.0) {
        let skin = jittered_grid(4, 0.25);
        let shell = shell_of(&skin, |i| 0.4 + 0.2 * random(i as u32, 3));
        let prism = seed % skin.triangles.len() as u32;
        let mut place = shell.enter(prism);
        for k in 0..3 {
            if place.neighbours[k] == NONE {
                continue;
            }
            let mut lambda = [0.0; 3];
            lambda[(k + 1) % 3] = along;
            lambda[(k + 2) % 3] = 1.0 - along;
            let x = place.point(t, lambda.into());
            shell.solve(&mut place, x, Vec3::Y, 6);
            let mut other = shell.enter(place.neighbours[k]);
            shell.solve(&mut other, x, Vec3::Y, 6);
            prop_assert!((place.t - other.t).abs() < 1e-5, "{} {}", place.t, other.t);
        }
    }
}

/// Marches from prism to prism through points of the shell; how many of them are not found in it.
fn lost(step: f32, edge: impl Fn(&Shell, &Place, Vec3) -> usize) -> usize {
    let skin = jittered_grid(12, 0.25);
    let shell = shell_of(&skin, |_| 0.35);
    let mut lost = 0;
    for ray in 0..400u32 {
        // A point in the middle of the grid, in a prism that is looked for among all.
        let start = Vec3::new(3.0 + 6.0 * random(ray, 0), 0.0, 3.0 + 6.0 * random(ray, 1));
        let level = |p: Vec3| Vec3::new(p.x, 0.15, p.z);
        let home = (0..shell.prisms.len() as u32).find_map(|prism| {
            let mut place = shell.enter(prism);
            place.t = 0.5;
            shell.solve(&mut place, level(start), Vec3::Y, 6);
            let inside = place.lambda.min_element() >= 0.0 && (0.0..=1.0).contains(&place.t);
            inside.then_some(place)
        });
        let Some(mut place) = home else { continue };
        let angle = std::f32::consts::TAU * random(ray, 2);
        let d = step * Vec3::new(angle.cos(), 0.0, angle.sin());
        for i in 1..=(2.0 / step) as u32 {
            let x = level(start) + i as f32 * d;
            let found = shell.locate_by(&mut place, x, d, 4, |place, x| edge(&shell, place, x));
            if found != Located::Inside {
                lost += 1;
                break;
            }
        }
    }
    lost
}

/// The paper taken literally: the edge whose line is closest, on whichever side.
// [Andersen2016] sec. 3.2
fn closest_edge(_: &Shell, place: &Place, x: Vec3) -> usize {
    let corner = [0, 1, 2].map(|k| place.point(place.t, Vec3::AXES[k]));
    let distance = |k: usize| {
        let (a, b) = (corner[(k + 1) % 3], corner[(k + 2) % 3]);
        (x - a).cross(b - a).length() / (b - a).length()
    };
    let mut edges = [0, 1, 2];
    edges.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    edges[0]
}

#[test]
fn hops_lose_no_point_inside() {
    for step in [0.1, 0.5, 1.0] {
        assert_eq!(lost(step, |_, place, _| most_negative(place.lambda)), 0, "step {step}");
    }
    // [Andersen2016] sec. 3.2 taken literally.
    for step in [0.5, 1.0] {
        assert!(lost(step, closest_edge) > 20, "step {step}: {}", lost(step, closest_edge));
    }
}

const CODE: &str = "
#import shared/undercoat_types
#import shared/shell
@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<uniform> fur: FurParameters;
struct Query { point: vec3f, prism: u32, ray: vec3f, t: f32 }
struct Answer { lambda: vec3f, t: f32, dt_dz: f32, prism: u32, found: u32, id: u32, centroid: vec3f, padding: u32 }
@group(0) @binding(50) var<storage, read> input: array<Query>;
@group(0) @binding(51) var<storage, read_write> output: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&input) { return; }
    let q = input[id.x];
    var place: Place;
    enter_prism(&place, q.prism);
    place.t = q.t;
    let found = locate(&place, q.point, q.ray, 6u);
    let cell = subelement(place.lambda, 5u);
    output[id.x] = Answer(place.lambda, place.t, place.dt_dz, place.prism, found, cell, subelement_centroid(id.x & 4095u, 6u), 0u);
}";

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Query {
    point: [f32; 3],
    prism: u32,
    ray: [f32; 3],
    t: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    lambda: [f32; 3],
    t: f32,
    dt_dz: f32,
    prism: u32,
    found: u32,
    id: u32,
    centroid: [f32; 3],
    padding: u32,
}

#[test]
fn the_gpu_finds_the_same_places() {
    let Some(gpu) = gpu::open() else { return };
    let scene = "[undercoat]\nheight = 0.3\nlayers = 1\nsubdivision = 0\n[render]\nfur = \"implicit\"\n";
    let fixture = Fixture::new(gpu, world_on(scene, Some(jittered_grid(8, 0.25)), Vec::new()));
    let shell = &fixture.shell;
    let queries: Vec<Query> = (0..5000u32)
        .map(|s| {
            let prism = s % shell.prisms.len() as u32;
            let place = shell.enter(prism);
            let aside = random_direction(s, 0) * Vec3::new(1.0, 0.0, 1.0) * random(s, 5);
            let x = place.point(1.1 * random(s, 4) - 0.05, barycentric(s)) + aside;
            Query { point: x.into(), prism, ray: random_direction(s, 6).into(), t: random(s, 8) }
        })
        .collect();
    let buffer = |name| fixture.prepared.buffer(name).unwrap();
    let more = [(1, buffer("shell_vertices")), (2, buffer("prisms")), (3, buffer("fur"))];
    let answers: Vec<Answer> = gpu::evaluate(gpu, CODE, &more, &queries, queries.len());
    let (mut elsewhere, mut outside) = (0, 0);
    for (i, (query, answer)) in queries.iter().zip(&answers).enumerate() {
        let wanted = subelement_centroid(i as u32 & 4095, 6);
        assert!((Vec3::from(answer.centroid) - wanted).abs().max_element() < 1e-6, "centroid {i}");
        let mut place = shell.enter(query.prism);
        place.t = query.t;
        let found = shell.locate(&mut place, query.point.into(), query.ray.into(), 6);
        if !(-0.3..1.3).contains(&place.t) {
            outside += 1; // Newton's steps are cut off there: no root, no agreement.
            continue;
        }
        if answer.prism != place.prism || answer.found != found as u32 {
            elsewhere += 1; // Rounding may move a point near an edge to the other side.
            continue;
        }
        gpu::close(answer.t, place.t, 1e-4, format!("t {i}"));
        gpu::close(answer.dt_dz, place.dt_dz, 1e-3, format!("slope {i}"));
        assert!(
            (Vec3::from(answer.lambda) - place.lambda).abs().max_element() < 1e-3,
            "{i}: {answer:?} {place:?}"
        );
        assert!(answer.id < 1024 && subelement(answer.lambda.into(), 5) == answer.id, "cell {i}");
    }
    assert!(elsewhere < 5 && outside < 1000, "{elsewhere} points end elsewhere, {outside} outside");
}
