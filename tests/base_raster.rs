//! `base_raster` against its CPU twin, and against plain ray casting.

use crate::common::gpu::{self, Fixture};
use glam::Vec3;
use pelage_fur::layout::Frame;
use pelage_fur::shell::Shell;
use pelage_fur::view::sample_ray;
use pelage_render::twin::base_raster::{NO_BASE, project, shade, triangles, unpack};
use pelage_render::twin::light_occlusion::hit;

const FILM: [u32; 2] = [120, 90];

fn fixture(gpu: &'static pelage_gpu::Gpu, mesh: &str) -> Fixture {
    let scene = format!(
        "[mesh]\n{mesh}\n[camera]\neye = [1.5, 3, 4]\nfov = 38\n[[lights]]\n[undercoat]\nheight = 0.05\nlayers = 1\nsubdivision = 0\n[render]\nfur = \"implicit\"\n"
    );
    Fixture::new(gpu, gpu::world(&scene))
}

/// Distance of a sample from a triangle's edges; negative outside.
fn margin(frame: &Frame, shell: &Shell, triangle: u32, xy: [u32; 2]) -> f32 {
    let corners =
        shell.prisms[triangle as usize].vertices.map(|v| Vec3::from(shell.vertices[v as usize].position));
    project(frame, corners).map_or(0.0, |p| p.cover(frame, xy).margin)
}

/// The nearest triangle that a sample's ray hits.
fn cast(frame: &Frame, shell: &Shell, xy: [u32; 2]) -> Option<u32> {
    let ray = sample_ray(frame, xy);
    let hits = shell.prisms.iter().enumerate().filter_map(|(i, prism)| {
        let corners = prism.vertices.map(|v| shell.vertices[v as usize].position.into());
        hit(corners, frame.eye.into(), ray).map(|t| (t, i as u32))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

#[test]
fn samples_see_the_triangles_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    for mesh in ["shape = \"torus\"\nsize = 2", "shape = \"cylinder_pelt\"\nsize = 2\nrotate = [20, 40, 0]"] {
        let fixture = fixture(gpu, mesh);
        let shell = &fixture.shell;
        let light: Vec<[u32; 2]> = fixture.read("base_light", fixture.fur.lattice.columns as usize);
        for (origin, size) in [([0, 0], FILM), ([37, 20], [41, 33])] {
            let tile = fixture.tile(FILM, origin, size, 16);
            tile.draw_base().unwrap();
            let found = gpu::triangle_ids(&tile);
            let wanted = triangles(&tile.frame, shell);
            let records = tile.base_records().unwrap();
            let mut seen = 0;
            for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
                let xy = [i as u32 % size[0], i as u32 / size[0]];
                let found = found.checked_sub(1);
                let margin = |t| margin(&tile.frame, shell, t, xy);
                if found != wanted {
                    // They may differ only on an edge.
                    let edge = [found, wanted].into_iter().flatten().any(|t| margin(t).abs() < 0.01);
                    assert!(edge, "{mesh}: sample {xy:?}: {found:?}, wanted {wanted:?}");
                }
                if found.is_none_or(|t| margin(t) > 0.02) && i % 5 == 0 {
                    let cast = cast(&tile.frame, shell, xy);
                    let edge = cast.is_some_and(|t| margin(t) < 0.02);
                    assert!(found == cast || edge, "{mesh}: sample {xy:?}: {found:?}, ray casting {cast:?}");
                }
                let base = unpack(records[i]);
                let Some(triangle) = found else {
                    assert_eq!(base.z, NO_BASE);
                    continue;
                };
                seen += 1;
                let twin = shade(&tile.frame, shell, &fixture.fur, &light, triangle, xy);
                gpu::close(base.z, twin.z, 1e-5, format!("{mesh}: depth at {xy:?}"));
                let away = (base.radiance - twin.radiance).abs().max_element();
                assert!(
                    away < 2e-3 * (0.05 + twin.radiance.max_element()),
                    "{mesh} {xy:?}: {base:?} {twin:?}"
                );
                assert!((base.normal - twin.normal).length() < 2e-3, "{mesh} {xy:?}: {base:?} {twin:?}");
            }
            assert!(seen > size[0] * size[1] / 10, "{mesh}: {seen} samples see the skin");
        }
    }
}

#[test]
fn a_tile_sees_what_the_whole_film_sees() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = fixture(gpu, "shape = \"torus\"\nsize = 2");
    let whole = fixture.tile(FILM, [0, 0], FILM, 16);
    whole.draw_base().unwrap();
    let whole = gpu::triangle_ids(&whole);
    let (origin, size) = ([31, 17], [53, 44]);
    let tile = fixture.tile(FILM, origin, size, 16);
    tile.draw_base().unwrap();
    for (i, id) in gpu::triangle_ids(&tile).into_iter().enumerate() {
        let (x, y) = (i as u32 % size[0] + origin[0] as u32, i as u32 / size[0] + origin[1] as u32);
        assert_eq!(id, whole[(y * FILM[0] + x) as usize], "sample {x} {y}");
    }
}
