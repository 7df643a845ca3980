//! `shell_entry` against its CPU twin, and against plain ray casting.

use crate::common::gpu::{self, Fixture};
use glam::Vec4;
use pelage_fur::view::sample_ray;
use pelage_render::twin::base_raster::{NO_BASE, project, unpack};
use pelage_render::twin::light_occlusion::hit;
use pelage_render::twin::shell_entry::{entries, faces};

const FILM: [u32; 2] = [96, 72];
const KIND_ENTRY: u32 = 1;

#[test]
fn rays_enter_where_the_twin_says() {
    let Some(gpu) = gpu::open() else { return };
    // A closed skin, and an open one with walls over its border.
    for (mesh, open) in [
        ("shape = \"torus\"\nsize = 2", false),
        ("shape = \"cylinder_pelt\"\nsize = 2\nrotate = [20, 40, 0]", true),
    ] {
        let scene = format!(
            "[mesh]\n{mesh}\n[camera]\neye = [1.5, 1.2, 4]\nfov = 42\n[[lights]]\n[undercoat]\nheight = 0.2\nlayers = 1\nsubdivision = 0\n[render]\nfur = \"implicit\"\n"
        );
        let fixture = Fixture::new(gpu, gpu::world(&scene));
        let border: Vec<[u32; 2]> = fixture.read("border", fixture.prepared.walls as usize);
        assert_eq!(open, !border.is_empty());
        let (origin, size) = ([5, 3], [80, 60]);
        let tile = fixture.tile(FILM, origin, size, 100_000);
        tile.draw_base().unwrap();
        tile.draw_entries().unwrap();
        let base_z: Vec<f32> = tile.base_records().unwrap().into_iter().map(|r| unpack(r).z).collect();
        let wanted = entries(&tile.frame, &fixture.shell, &border, &base_z);
        let free = entries(&tile.frame, &fixture.shell, &border, &vec![NO_BASE; base_z.len()]);
        let hidden = free.iter().map(Vec::len).sum::<usize>() - wanted.iter().map(Vec::len).sum::<usize>();
        assert!(open || hidden > 50, "{mesh}: {hidden} entries lie behind the skin");
        let faces = faces(&fixture.shell, &border);
        let (mut total, mut odd, mut through_walls) = (0, 0, 0);
        for (i, (found, wanted)) in tile.lists().unwrap().iter().zip(&wanted).enumerate() {
            let xy = [i as u32 % size[0], i as u32 / size[0]];
            total += wanted.len();
            assert!(found.iter().all(|n| n.source >> 30 == KIND_ENTRY && n.color == Vec4::ZERO));
            let near = |z: f32| 1e-4 * (1.0 + z);
            // Entries that rounding can neither create nor remove.
            let mut sure = true;
            for entry in wanted {
                let there = found
                    .iter()
                    .any(|n| n.source & 0x3fff_ffff == entry.prism && (n.z - entry.z).abs() < near(entry.z));
                let doubtful = entry.margin < 0.01 || (entry.z - base_z[i]).abs() < near(entry.z);
                assert!(there || doubtful, "{mesh}: sample {xy:?}: no {entry:?} in {found:?}");
                sure &= !doubtful;
            }
            odd += usize::from(found.len() != wanted.len());
            // And none that the twin does not have.
            for node in found {
                let prism = node.source & 0x3fff_ffff;
                let known = wanted.iter().any(|e| e.prism == prism && (node.z - e.z).abs() < near(e.z));
                let on_edge = || {
                    let of_prism = faces.iter().filter(|(p, _)| *p == prism);
                    let mut projected = of_prism.filter_map(|(_, corners)| project(&tile.frame, *corners));
                    projected.any(|p| p.cover(&tile.frame, xy).margin.abs() < 0.01)
                };
                let doubtful = (node.z - base_z[i]).abs() < near(node.z) || on_edge();
                assert!(known || doubtful, "{mesh}: sample {xy:?}: {node:?} not among {wanted:?}");
            }
            // Ray casting: front faces before the skin.
            if sure && i % 7 == 0 {
                let ray = sample_ray(&tile.frame, xy);
                let mut hits = 0;
                for (k, (_, corners)) in faces.iter().enumerate() {
                    let front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(ray) < 0.0;
                    let depth = hit(*corners, tile.frame.eye.into(), ray).filter(|_| front);
                    let before = depth.is_some_and(|t| t < f64::from(base_z[i]) - 1e-4);
                    hits += usize::from(before);
                    through_walls += usize::from(before && k >= fixture.shell.prisms.len());
                }
                odd += usize::from(hits != wanted.len());
            }
        }
        assert!(total > 500, "{mesh}: {total} entries");
        assert!(odd * 100 < total, "{mesh}: {odd} samples with another number of entries, of {total}");
        assert_eq!(open, through_walls > 0, "{mesh}: {through_walls} entries through walls");
    }
}
