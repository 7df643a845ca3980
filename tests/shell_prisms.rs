//! `shell_prisms` against its CPU twin: heights of the shell, with maps and folds.

use crate::common::gpu::{self, Fixture, close, image, jittered_grid, scaled, skin, vertex_uv, world_on};
use glam::Vec3;
use pelage_core::World;
use pelage_fur::shell_prisms::{heights, part_of_area};

/// A height larger than the depth of the hollow.
const HOLLOW: &str = "4.0";

/// A bumpy grid with undercoat as high as `height` says (TOML).
fn bumpy(height: &str, displacement: f32, uv: bool) -> World {
    let scene = format!(
        "[undercoat]\nheight = {height}\nlayers = 2\nsubdivision = 1\n[render]\nfur = \"implicit\"\n"
    );
    let map =
        image("height.png", false, 16, |u, v| [0.5 + 0.5 * (6.0 * u).sin() * (6.0 * v).cos(), v, u, 1.0]);
    let mut grid = jittered_grid(10, displacement);
    if height == HOLLOW {
        // A gutter whose axis lies below the wanted height.
        let radius = 10.0 / std::f32::consts::PI;
        for p in &mut grid.positions {
            let (sin, cos) = ((p.x - 5.0) / radius).sin_cos();
            *p = Vec3::new((radius - p.y) * sin, (p.y - radius) * cos, p.z);
        }
        grid = skin(grid.positions, grid.triangles);
    }
    let mut skin = scaled(grid, 1.0, 10.0);
    if !uv {
        skin.corner_uv = None;
    }
    skin.colors = (0..skin.positions.len()).map(|i| Vec3::splat((i % 11) as f32 / 10.0)).collect();
    skin.alphas = (0..skin.positions.len()).map(|i| (i % 7) as f32 / 6.0).collect();
    world_on(&scene, Some(skin), vec![map])
}

/// The directions of extrusion.
fn normals(fixture: &Fixture) -> Vec<Vec3> {
    fixture.shell.vertices.iter().map(|v| v.normal.into()).collect()
}

#[test]
fn heights_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    let cases = [
        ("constant", "0.2", 0.0, true),
        ("map by uv", "{ map = \"height.png\", channel = \"r\", value = 0.3, offset = 0.02 }", 0.1, true),
        ("map without uv", "{ map = \"height.png\", channel = \"g\", value = 0.3 }", 0.1, false),
        ("vertex colour", "{ map = \"vertex_color\", value = 0.25 }", 0.1, true),
        ("vertex alpha", "{ map = \"vertex_color\", channel = \"a\", value = 0.25 }", 0.1, true),
        ("folds", HOLLOW, 0.1, true),
    ];
    for (name, height, displacement, uv) in cases {
        let fixture = Fixture::new(gpu, bumpy(height, displacement, uv));
        let skin = &fixture.world.skin;
        let wanted = heights(skin, &normals(&fixture), &fixture.maps(), &vertex_uv(skin));
        for (i, (vertex, wanted)) in fixture.shell.vertices.iter().zip(&wanted).enumerate() {
            close(vertex.height, *wanted, 1e-4, format!("{name}, vertex {i}"));
            assert_eq!(vertex.position, skin.positions[i].to_array(), "{name}, vertex {i}");
            let normal = Vec3::from(vertex.normal);
            assert!((normal.length() - 1.0).abs() < 1e-5, "{name}, vertex {i}");
            // Averaged over the fur's height, which is small but in the last case.
            let turned = normal.dot(skin.normals[i]);
            assert!(turned > if name == "folds" { 0.3 } else { 0.9 }, "{name}, vertex {i}: {turned}");
        }
        let most = wanted.iter().copied().fold(0.0, f32::max);
        let lowered = wanted.iter().filter(|h| **h < 0.99 * most).count();
        assert_eq!(name == "constant", lowered == 0, "{name}: {lowered} vertices below the highest");
    }
}

#[test]
fn lowering_unfolds_the_shell() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, bumpy(HOLLOW, 0.1, true));
    let skin = &fixture.world.skin;
    let lowered: Vec<f32> = fixture.shell.vertices.iter().map(|v| v.height).collect();
    let normals = normals(&fixture);
    let folded = |heights: &[f32]| {
        skin.triangles.iter().filter(|t| part_of_area(skin, &normals, t, heights, 1.0) <= 0.0).count()
    };
    let (before, after) = (folded(&vec![4.0; lowered.len()]), folded(&lowered));
    assert!(before >= 10 && after <= before / 5, "{before} prisms turned over before, {after} after");
    assert!(lowered.iter().all(|h| *h >= 0.05 * 4.0), "no spot is bald");
}
