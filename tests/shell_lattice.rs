//! `shell_lattice` against its twin, and the geometry of the light lattice.

#[path = "common/gpu.rs"]
mod gpu;

use glam::Vec3;
use gpu::{Fixture, image, jittered_grid, scaled, world_on};
use pelage::layout::{Column, Fur};
use pelage::reference::hash::random;
use pelage::reference::lattice::{cell, column_spot, node_index};
use pelage::reference::{lattice, shell_lattice};

/// A grid whose quads are `size` cm wide: small ones have one lattice cell a triangle.
fn furry(size: f32) -> pelage::World {
    let scene = "[undercoat]\nheight = 0.3\nlayers = 2\nsubdivision = 1\ndensity = { map = \"a.png\", value = 15000, offset = 500 }\n\
        color_root = { map = \"c.png\" }\ncolor_tip = { map = \"vertex_color\", value = [0.9, 0.7, 0.5] }\n\
        [base]\ncolor = [0.2, 0.4, 0.6]\n[render]\nfur = \"implicit\"\n";
    let mut skin = scaled(jittered_grid(6, 0.2), size, 6.0 * size);
    skin.colors = (0..skin.positions.len()).map(|i| Vec3::splat((i % 7) as f32 / 6.0)).collect();
    let maps = vec![
        image("a.png", false, 16, |u, v| [u * v, 0.0, 0.0, 1.0]),
        image("c.png", true, 16, |u, v| [u, v, 1.0 - u, 1.0]),
    ];
    world_on(scene, Some(skin), maps)
}

#[test]
fn columns_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    for (size, edge) in [(0.1, 1), (1.0, 8)] {
        let fixture = Fixture::new(gpu, furry(size));
        assert_eq!(fixture.fur.lattice, edge);
        let found: Vec<Column> = fixture.read("columns", fixture.fur.columns as usize);
        let wanted = shell_lattice::columns(&fixture.shell, &fixture.fur, &fixture.maps(), &found);
        let mut densities = Vec::new();
        for (i, (a, b)) in found.iter().zip(&wanted).enumerate() {
            gpu::close(a.density, b.density, 1e-4, format!("density of column {i}"));
            densities.push(a.density);
            for (a, b) in [(a.color_root, b.color_root), (a.color_tip, b.color_tip), (a.color_base, b.color_base)] {
                let away = (lattice::unpack_albedo(a) - lattice::unpack_albedo(b)).abs().max_element();
                assert!(away < 1.01 / 1023.0, "column {i}: {a:x} {b:x}");
            }
        }
        let spread = densities.iter().copied().fold(0.0, f32::max) - densities.iter().copied().fold(1.0, f32::min);
        assert!(spread > 0.5, "the map is seen: {spread}");
        // Columns share the skin among them.
        let area: f64 = found.iter().map(|c| f64::from(c.area)).sum();
        assert!((area - fixture.world.skin.area()).abs() < 1e-4 * area, "{area}");
    }
}

fn fur(lattice: u32) -> Fur {
    Fur { lattice, levels: 5, light_reach: 1.6, ..bytemuck::Zeroable::zeroed() }
}

#[test]
fn interpolation_keeps_linear_functions() {
    for n in 1..=8 {
        let fur = fur(n);
        let vertices = [4, 9, 2];
        // Where a column stands; with one cell a triangle columns are vertices of triangle 3.
        let spot = |column: u32| match vertices.iter().position(|v| *v == column) {
            Some(k) if n == 1 => Vec3::AXES[k],
            _ => column_spot(&fur, column, 0).1,
        };
        for s in 0..2000 {
            // Also on edges and corners, and a little outside.
            let mut lambda = Vec3::new(random(s, 0), random(s, 1), 0.0);
            if lambda.x + lambda.y > 1.0 {
                lambda = Vec3::new(1.0 - lambda.x, 1.0 - lambda.y, 0.0);
            }
            lambda.z = 1.0 - lambda.x - lambda.y;
            if s % 3 == 0 {
                lambda = (lambda * n as f32).round() / n as f32;
                lambda.x = 1.0 - lambda.y - lambda.z;
            }
            let inside = lambda.min_element() >= 0.0;
            let t = 1.8 * random(s, 2) - 0.1;
            let found = cell(&fur, 3, vertices, lambda, t);
            assert!((found.weights.element_sum() - 1.0).abs() < 1e-5 && found.weights.min_element() > -1e-5, "{found:?}");
            assert!(found.level < fur.levels && (0.0..=1.0).contains(&found.fraction), "{found:?}");
            let height = (found.level as f32 + found.fraction) / fur.levels as f32 * fur.light_reach;
            assert!((height - t.clamp(0.0, fur.light_reach)).abs() < 1e-5, "{found:?}");
            if n > 1 {
                let of_prism = found.columns.map(|c| c / lattice::columns_per_triangle(n));
                assert_eq!(of_prism, [3; 3], "n {n} {lambda}: {found:?}");
            }
            let back: Vec3 = (0..3).map(|k| found.weights[k] * spot(found.columns[k])).sum();
            assert!(!inside || (back - lambda).abs().max_element() < 1e-5, "n {n}: {lambda} {back} {found:?}");
        }
    }
}

const CODE: &str = "
#import shared/undercoat_types
#import shared/lattice
#import shared/column
@group(0) @binding(3) var<uniform> fur: Fur;
struct Answer { columns: vec3u, level: u32, weights: vec3f, fraction: f32, node: u32, prism: u32, spot: vec2f }
@group(0) @binding(50) var<storage, read> input: array<vec4f>;
@group(0) @binding(51) var<storage, read_write> output: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&input) { return; }
    let q = input[id.x];
    let c = lattice_cell(7u, vec3u(4u, 9u, 2u), q.xyz, q.w);
    let s = column_spot(id.x, id.x);
    output[id.x] = Answer(c.columns, c.level, c.weights, c.fraction, node_index(c.columns.y, c.level), s.prism, s.lambda.yz);
}";

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    columns: [u32; 3],
    level: u32,
    weights: [f32; 3],
    fraction: f32,
    node: u32,
    prism: u32,
    spot: [f32; 2],
}

#[test]
fn the_gpu_finds_the_same_cells() {
    let Some(gpu) = gpu::open() else { return };
    for n in [1, 2, 3, 8] {
        let fur = fur(n);
        let uniform = gpu.uniform("fur", &fur).unwrap();
        let input: Vec<[f32; 4]> = (0..3000)
            .map(|s| {
                let (r, v) = (random(s, 0).sqrt() * 1.01, random(s, 1));
                [1.0 - r, r * (1.0 - v), r * v, 1.8 * random(s, 2) - 0.1]
            })
            .collect();
        let output: Vec<Answer> = gpu::evaluate(gpu, CODE, &[(3, &uniform)], &input, input.len());
        let mut elsewhere = 0;
        for (i, (q, found)) in input.iter().zip(&output).enumerate() {
            let wanted = cell(&fur, 7, [4, 9, 2], Vec3::new(q[0], q[1], q[2]), q[3]);
            let (prism, lambda) = column_spot(&fur, i as u32, i as u32);
            assert_eq!(found.prism, prism, "n {n} column {i}");
            assert!((glam::Vec2::from(found.spot) - lambda.truncate().with_x(lambda.y).with_y(lambda.z)).length() < 1e-6);
            assert_eq!(found.node, node_index(&fur, found.columns[1], found.level));
            if (found.columns, found.level) != (wanted.columns, wanted.level) {
                elsewhere += 1;
                continue;
            }
            assert!((Vec3::from(found.weights) - wanted.weights).abs().max_element() < 1e-5, "n {n} {q:?}: {found:?} {wanted:?}");
            assert!((found.fraction - wanted.fraction).abs() < 1e-5, "n {n} {q:?}: {found:?} {wanted:?}");
        }
        assert!(elsewhere < 10, "n {n}: {elsewhere} places in another cell");
    }
}
