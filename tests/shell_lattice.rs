//! `shell_lattice` against its CPU twin, and the geometry of the optical-depth lattice.

use crate::common::gpu::{self, Fixture, image, jittered_grid, scaled, world_on};
use bytemuck::Zeroable;
use glam::Vec3;
use pelage_fur::layout::{Column, FurParameters, LatticeParameters, Prism, ShellVertex};
use pelage_fur::random::random;
use pelage_fur::shell::{Place, Shell};
use pelage_render::twin::lattice::{self, cell, column_index, column_lambda, node_index};
use pelage_render::twin::shell_lattice;
use std::collections::HashMap;

/// A grid whose quads are `size` cm wide: small ones have one lattice cell a triangle.
fn furry(size: f32) -> pelage_core::World {
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
    for (size, edge) in [(0.1, 1), (1.0, 5)] {
        let fixture = Fixture::new(gpu, furry(size));
        assert_eq!(fixture.fur.lattice.cells, edge);
        let found: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
        let twin = |c| shell_lattice::column(&fixture.shell, &fixture.fur, &fixture.maps(), c);
        let wanted: Vec<Column> = found.iter().map(twin).collect();
        let mut densities = Vec::new();
        for (i, (a, b)) in found.iter().zip(&wanted).enumerate() {
            gpu::close(a.density, b.density, 1e-4, format!("density of column {i}"));
            densities.push(a.density);
            for (a, b) in
                [(a.color_root, b.color_root), (a.color_tip, b.color_tip), (a.color_base, b.color_base)]
            {
                let away = (lattice::unpack_albedo(a) - lattice::unpack_albedo(b)).abs().max_element();
                assert!(away < 1.01 / 1023.0, "column {i}: {a:x} {b:x}");
            }
        }
        let spread =
            densities.iter().copied().fold(0.0, f32::max) - densities.iter().copied().fold(1.0, f32::min);
        assert!(spread > 0.5, "the map is seen: {spread}");
        // Columns share the skin among them.
        let area: f64 = found.iter().map(|c| f64::from(c.area)).sum();
        assert!((area - fixture.world.skin.area()).abs() < 1e-4 * area, "{area}");
    }
}

/// A shell over a grid with its edges numbered, and the parameters of a lattice over it.
fn lattice_of(n: u32) -> (Shell, FurParameters) {
    let skin = jittered_grid(3, 0.2);
    let mut known = HashMap::new();
    let mut number = |a: u32, b: u32| {
        let next = known.len() as u32;
        *known.entry((a.min(b), a.max(b))).or_insert(next)
    };
    let prisms: Vec<Prism> = skin
        .triangles
        .iter()
        .map(|v| Prism {
            vertices: *v,
            edges: [0, 1, 2].map(|k: usize| number(v[(k + 1) % 3], v[(k + 2) % 3])),
            ..Prism::zeroed()
        })
        .collect();
    let vertex = |i: usize| ShellVertex {
        position: skin.positions[i].into(),
        height: 0.3,
        normal: skin.normals[i].into(),
        color: u32::MAX,
    };
    let vertices: Vec<ShellVertex> = (0..skin.positions.len()).map(vertex).collect();
    let fur = FurParameters {
        lattice: LatticeParameters {
            cells: n,
            levels: 5,
            reach: 1.6,
            vertices: vertices.len() as u32,
            edges: known.len() as u32,
            ..LatticeParameters::zeroed()
        },
        ..FurParameters::zeroed()
    };
    (Shell { vertices, prisms, corner_uv: Vec::new(), light_reach: 1.6 }, fur)
}

/// A place in a triangle; every third one on the lattice's grid.
fn place_of(shell: &Shell, s: u32, n: u32) -> Place {
    let mut place = shell.enter(s % shell.prisms.len() as u32);
    let (r, v) = (random(s, 0).sqrt(), random(s, 1));
    let mut lambda = Vec3::new(1.0 - r, r * (1.0 - v), r * v);
    if s.is_multiple_of(3) {
        lambda = (lambda * n as f32).round() / n as f32;
        lambda.x = 1.0 - lambda.y - lambda.z;
    }
    place.lambda = lambda;
    place.t = 1.8 * random(s, 2) - 0.1;
    place
}

#[test]
fn columns_are_numbered_without_gaps_and_shared() {
    for n in 1..=8 {
        let (shell, fur) = lattice_of(n);
        let inner = (n - 1) * n.saturating_sub(2) / 2;
        let count = fur.lattice.vertices + fur.lattice.edges * (n - 1) + shell.prisms.len() as u32 * inner;
        let mut stands: Vec<Option<Vec3>> = vec![None; count as usize];
        for prism in 0..shell.prisms.len() as u32 {
            let place = shell.enter(prism);
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                let column = Column { prism, grid: i | (j << 16), ..Column::zeroed() };
                let p = place.point(0.0, column_lambda(&fur, &column));
                let slot = &mut stands[column_index(&fur, &place, i, j) as usize];
                // All triangles that share a column agree on its position.
                assert!(
                    slot.is_none_or(|q| (p - q).length() < 1e-5),
                    "n {n}, prism {prism} {i} {j}: {p} {slot:?}"
                );
                *slot = Some(p);
            }
        }
        assert!(stands.iter().all(Option::is_some), "n {n}");
        // Interpolation keeps linear functions: here the position itself.
        for s in 0..2000 {
            let place = place_of(&shell, s, n);
            let found = cell(&fur, &place);
            assert!(
                (found.weights.element_sum() - 1.0).abs() < 1e-5 && found.weights.min_element() > -1e-5,
                "{found:?}"
            );
            assert!(found.level < fur.lattice.levels && (0.0..=1.0).contains(&found.fraction), "{found:?}");
            let height =
                (found.level as f32 + found.fraction) / fur.lattice.levels as f32 * fur.lattice.reach;
            assert!((height - place.t.clamp(0.0, fur.lattice.reach)).abs() < 1e-5, "{found:?}");
            let stand = |k: usize| stands[found.columns[k] as usize].unwrap();
            let back: Vec3 = (0..3).map(|k| found.weights[k] * stand(k)).sum();
            let wanted = place.point(0.0, place.lambda);
            assert!((back - wanted).length() < 1e-5, "n {n} {}: {found:?}", place.lambda);
        }
    }
}

const CODE: &str = "
#import shared/undercoat_types
#import shared/shell
#import shared/lattice
@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<uniform> fur: FurParameters;
struct Query { lambda: vec3f, t: f32, prism: u32 }
struct Answer { columns: vec3u, level: u32, weights: vec3f, fraction: f32, node: u32 }
@group(0) @binding(50) var<storage, read> input: array<Query>;
@group(0) @binding(51) var<storage, read_write> output: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&input) { return; }
    let q = input[id.x];
    var place: Place;
    enter_prism(&place, q.prism);
    place.lambda = q.lambda;
    place.t = q.t;
    let c = lattice_cell(&place);
    output[id.x] = Answer(c.columns, c.level, c.weights, c.fraction, node_index(c.columns.y, c.level));
}";

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Query {
    lambda: [f32; 3],
    t: f32,
    prism: u32,
    padding: [u32; 3],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    columns: [u32; 3],
    level: u32,
    weights: [f32; 3],
    fraction: f32,
    node: u32,
    padding: [u32; 3],
}

#[test]
fn the_gpu_finds_the_same_cells() {
    let Some(gpu) = gpu::open() else { return };
    for n in [1, 2, 3, 8] {
        let (shell, fur) = lattice_of(n);
        let uniform = gpu.uniform("fur", &fur).unwrap();
        let buffers = [
            gpu.upload("shell_vertices", 1, &shell.vertices).unwrap(),
            gpu.upload("prisms", 1, &shell.prisms).unwrap(),
        ];
        let places: Vec<Place> = (0..3000).map(|s| place_of(&shell, s, n)).collect();
        let queries: Vec<Query> = places
            .iter()
            .map(|p| Query { lambda: p.lambda.into(), t: p.t, prism: p.prism, padding: [0; 3] })
            .collect();
        let more = [(1, &buffers[0]), (2, &buffers[1]), (3, &uniform)];
        let output: Vec<Answer> = gpu::evaluate(gpu, CODE, &more, &queries, queries.len());
        let mut elsewhere = 0;
        for (i, (place, found)) in places.iter().zip(&output).enumerate() {
            let wanted = cell(&fur, place);
            assert_eq!(found.node, node_index(&fur, found.columns[1], found.level));
            if (found.columns, found.level) != (wanted.columns, wanted.level) {
                // Only on the lattice's own lines.
                assert!(i % 3 == 0, "n {n} {}: {found:?} {wanted:?}", place.lambda);
                elsewhere += 1;
                continue;
            }
            assert!(
                (Vec3::from(found.weights) - wanted.weights).abs().max_element() < 1e-5,
                "{found:?} {wanted:?}"
            );
            assert!((found.fraction - wanted.fraction).abs() < 1e-5, "{found:?} {wanted:?}");
        }
        assert!(elsewhere < 200, "n {n}: {elsewhere} places in another cell");
    }
}
