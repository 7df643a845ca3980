//! `guard_strands` against its CPU twin, and the shape of the strands.

use crate::common::gpu::{self, Fixture, image, jittered_grid, scaled, world_on};
use pelage_fur::guard_strands::{diameter, strand};
use pelage_fur::layout::Root;
use pelage_fur::strands::{opacity, position, radius};

fn haired(guard: &str) -> pelage_core::World {
    let scene = format!("[guard]\ndensity = 6\n{guard}\n[render]\nfur = \"explicit\"\nseed = 4\n");
    let map = image("map.png", false, 16, |u, v| [0.3 + 0.7 * u, v, 0.5, 1.0]);
    let mut skin = scaled(jittered_grid(5, 0.2), 1.0, 5.0);
    skin.colors = (0..skin.positions.len()).map(|i| glam::Vec3::splat(0.5 + (i % 5) as f32 / 10.0)).collect();
    world_on(&scene, Some(skin), vec![map])
}

const PLAIN: &str = "length = 1.5\nclump = 0\nfrizz = 0\nspread = 20\ngravity = 0.8\ncomb = 0.7\ncomb_direction = [1, 0, 0.3]\nsegments = 16";
const RICH: &str = "length = { map = \"map.png\", value = 2 }\nclump = { map = \"vertex_color\", value = 0.6 }\nclump_density = 3\n\
    curl = 0.1\ncurl_frequency = 0.8\nfrizz = 0.03\nfrizz_frequency = 2\nthickness = { map = \"map.png\", channel = \"g\", offset = 0.2 }\n\
    tip_fade = 1.5\nopacity = 0.9\ncomb = 0.4\ncomb_direction = [0, 0, 1]\nsegments = 9";
const FLAT: &str = "length = 1.5\nclump = 0\nfrizz = 0\nspread = 60\ngravity = 6\nsegments = 8";

#[test]
fn vertices_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    for guard in [PLAIN, RICH, FLAT] {
        let fixture = Fixture::new(gpu, haired(guard));
        let roots: Vec<Root> = fixture.read("roots", fixture.strands());
        let vertices = fixture.strand_vertices();
        assert!(roots.len() > 100);
        let mut worst = 0.0f32;
        for (i, (root, found)) in
            roots.iter().zip(vertices.chunks(fixture.prepared.segments as usize + 1)).enumerate()
        {
            let strand = strand(&fixture.shell, &fixture.maps(), root);
            for (k, (found, wanted)) in found.iter().zip(strand.vertices(&fixture.packed.groom)).enumerate() {
                let away = (position(*found) - position(wanted)).length() / strand.length;
                worst = worst.max(away);
                assert!(away < 1e-4, "{guard}\nstrand {i} vertex {k}: {found:?} {wanted:?}");
                // Halves keep eleven bits.
                gpu::close(radius(*found) * 1e3, radius(wanted) * 1e3, 2e-3, format!("radius {i} {k}"));
                gpu::close(opacity(*found), opacity(wanted), 2e-3, format!("opacity {i} {k}"));
            }
        }
        assert!(worst > 0.0, "the twin is not the GPU");
    }
}

#[test]
fn strands_are_as_long_as_they_should_be_and_stay_above_the_skin() {
    let Some(gpu) = gpu::open() else { return };
    for (guard, shortest) in [(PLAIN, 0.94), (FLAT, 0.0)] {
        let fixture = Fixture::new(gpu, haired(guard));
        let roots: Vec<Root> = fixture.read("roots", fixture.strands());
        let segments = fixture.prepared.segments as usize;
        for (root, found) in roots.iter().zip(fixture.strand_vertices().chunks(segments + 1)) {
            let strand = strand(&fixture.shell, &fixture.maps(), root);
            let arc: f32 = found.windows(2).map(|w| (position(w[1]) - position(w[0])).length()).sum();
            let part = arc / strand.length;
            assert!((shortest..1.0001).contains(&part), "{guard}\n{part} of the length");
            for v in found {
                let height = (position(*v) - strand.root).dot(strand.normal);
                assert!(height > -1e-5, "{guard}\n{height} below the tangent plane");
            }
            assert!((position(found[0]) - strand.root).length() < 1e-5);
        }
    }
}

#[test]
fn the_diameter_goes_from_root_to_widest_to_tip() {
    let groom = pelage_fur::groom::pack(&haired(PLAIN)).unwrap().groom;
    let hairs = groom.coats[0].hairs;
    let [root, widest, tip] = hairs.diameter;
    for (s, wanted) in [(0.0, root), (hairs.widest, widest), (1.0, tip)] {
        assert!((diameter(&hairs, s) - wanted).abs() < 1e-6 * widest, "at {s}");
    }
    let steps: Vec<f32> = (0..=1000).map(|i| diameter(&hairs, i as f32 / 1000.0)).collect();
    assert!(steps.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01 * widest), "no jump");
    assert!(steps.iter().all(|d| *d <= widest + 1e-9));
}
