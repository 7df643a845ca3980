//! `shellfin_rows` against its CPU twin: the positions of hairs at the rows above the skin, and
//! their light there.

use crate::common::gpu;
use crate::common::shellfins::{Fur, even, fur_world};
use glam::Vec3;
use pelage_core::scene::{BakeSource, Scalar, Shells};
use pelage_fur::fibre::Fibre;
use pelage_fur::groom;
use pelage_fur::layout::Brush;
use pelage_fur::parameters::Maps;
use pelage_shells::shellfin::{FIN_ROWS, levels, rows};
use pelage_shells::twin::shellfin_rows::{Hair, RowVertex, unpack};

/// Rows of a scene as the GPU places them and as the twin does, with `disturb` applied to the
/// twin's fibre.
fn both(text: &str, source: BakeSource, disturb: impl Fn(&mut Fibre)) -> Option<Vec<(RowVertex, RowVertex)>> {
    let gpu = gpu::open()?;
    let world = fur_world(text);
    let packed = groom::pack(&world).unwrap();
    let (shells, uv) = (world.scene.shells.clone(), gpu::vertex_uv(&world.skin));
    let fur = Fur::new(gpu, world, even(source, 6, source == BakeSource::Hybrid), Vec3::new(0.1, -0.2, 0.05));
    let prepared = fur.fur.prepared();
    let layout = prepared.fur.lattice;
    let words = u64::from(layout.columns) * u64::from(layout.levels + 1) * u64::from(layout.tau_stride);
    let tau: Vec<u32> = gpu.read(prepared.buffer("tau").unwrap(), words * 4).unwrap();
    let vertices = fur.vertices(gpu);
    let brushes: Vec<Brush> = shells
        .brushes
        .iter()
        .map(|b| Brush {
            center: b.center,
            radius: b.radius,
            direction: b.direction,
            tint: b.tint,
            padding: 0,
            more_padding: 0,
        })
        .collect();
    let mut fibre = packed.guard_fibre.clone();
    disturb(&mut fibre);
    let hair = Hair {
        shellfin: &fur.rows.shellfin,
        fur: &prepared.fur,
        maps: Maps { groom: &packed.groom, texels: &packed.texels },
        lights: &packed.lights,
        fibre: &fibre,
        undercoat: &packed.undercoat_fibre,
        table: &shells.table,
        vertices: &vertices,
        uv: &uv,
        tau: &tau,
        brushes: &brushes,
        frame: &fur.frame,
    };
    let count = fur.rows.rows.len() * vertices.len();
    let positions: Vec<[f32; 4]> =
        gpu.read(fur.rows.buffer("row_positions").unwrap(), count as u64 * 16).unwrap();
    let lights: Vec<[u32; 4]> = gpu.read(fur.rows.buffer("row_lights").unwrap(), count as u64 * 16).unwrap();
    let mut pairs = Vec::new();
    for (i, row) in fur.rows.rows.iter().enumerate() {
        for v in 0..vertices.len() {
            let at = i * vertices.len() + v;
            pairs.push((unpack(positions[at], lights[at]), hair.vertex(v, row)));
        }
    }
    Some(pairs)
}

/// Largest differences of position (cm), tangent, and light relative to the brightest.
fn differences(pairs: &[(RowVertex, RowVertex)]) -> [f32; 4] {
    let brightest =
        |f: fn(&RowVertex) -> Vec3| pairs.iter().map(|p| f(&p.1).max_element()).fold(1e-9, f32::max);
    let (u, g) = (brightest(|r| r.undercoat), brightest(|r| r.guard));
    pairs.iter().fold([0.0; 4], |worst, (a, b)| {
        [
            worst[0].max(a.position.distance(b.position)),
            worst[1].max(a.tangent.distance(b.tangent)),
            worst[2].max((a.undercoat - b.undercoat).abs().max_element() / u),
            worst[3].max((a.guard - b.guard).abs().max_element() / g),
        ]
    })
}

#[test]
fn rows_along_the_groom_are_those_of_the_twin() {
    let Some(pairs) = both("comb = [0, 0.3, 0]", BakeSource::Hybrid, |_| ()) else { return };
    let worst = differences(&pairs);
    println!("{worst:?}");
    assert!(worst[0] < 1e-4 && worst[1] < 2e-3 && worst[2] < 2e-3 && worst[3] < 2e-3, "{worst:?}");
    assert!(pairs.iter().any(|p| p.1.undercoat.max_element() > 0.01 && p.1.guard.max_element() > 0.01));
}

#[test]
fn rows_of_other_models_are_those_of_the_twin() {
    let text = "comb = [0, 0.3, 0]\n[guard.fibre]\nmodel = 'chiang'\n[undercoat.fibre]\nmodel = 'medulla'";
    let Some(pairs) = both(text, BakeSource::Hybrid, |_| ()) else { return };
    let worst = differences(&pairs);
    println!("{worst:?}");
    assert!(worst[2] < 0.02 && worst[3] < 0.02, "{worst:?}");
}

#[test]
fn brushed_rows_under_a_table_are_those_of_the_twin() {
    let text = "lighting = 'table'\ncomb = [0.2, 0, 0]\nbrushes = [{ center = [1, 0, 0], radius = 1.2, direction = [0, 0.8, 0], tint = [0.5, 2, 1] }]\n\
        length = { map = 'vertex_color', value = 0.7 }";
    let Some(pairs) = both(text, BakeSource::Particles, |_| ()) else { return };
    let worst = differences(&pairs);
    println!("{worst:?}");
    // The twin evaluates what the shader reads from the table.
    assert!(worst[0] < 1e-4 && worst[1] < 2e-3 && worst[2] < 0.02, "{worst:?}");
}

#[test]
fn another_fibre_is_noticed() {
    let Some(pairs) = both("", BakeSource::Hybrid, |f| {
        if let Fibre::Sadeghi(model) = f {
            model.width[0] *= 1.3;
        }
    }) else {
        return;
    };
    assert!(differences(&pairs)[3] > 0.01);
}

#[test]
fn levels_halve() {
    assert_eq!(levels(16), [16, 8, 4, 2, 1]);
    assert_eq!(levels(11), [11, 6, 3, 2, 1]);
    assert_eq!(levels(1), [1]);
    assert!(levels(128).iter().sum::<u32>() <= 256, "all levels fit the smallest limit of array layers");
}

/// The shells of a scene with levels of detail at a distance.
fn at(distance: f32, layers: u32) -> Vec<(f32, u32, u32, f32)> {
    let mut shells = Shells { length: Scalar::Constant(1.0), ..Default::default() };
    shells.lod.enabled = true;
    shells.lod.distance = 8.0;
    let all = rows(&shells, layers, layers, distance, &[], &|_| 0.0);
    let count = all.len() - FIN_ROWS as usize;
    all[..count].iter().map(|r| (r.height, r.fine, r.coarse, r.blend)).collect()
}

#[test]
fn detail_falls_by_half_each_doubling_of_the_distance() {
    for (distance, count) in [(1.0, 16), (3.9, 16), (8.0, 8), (16.0, 4), (32.0, 2), (64.0, 1), (1e4, 1)] {
        assert_eq!(at(distance, 16).len(), count, "at {distance}");
    }
    // Layers of a level follow those of the level before in the texture.
    assert_eq!(at(8.0, 16)[0].1, 16);
    assert_eq!(at(16.0, 16)[3].1, 16 + 8 + 3);
}

#[test]
fn nothing_jumps_between_levels() {
    for layers in [16, 11, 2] {
        for doubling in 0..5 {
            let distance = 8.0 * 2f32.powi(doubling);
            let (near, far) = (at(distance * (1.0 - 1e-4), layers), at(distance, layers));
            for (height, _, coarse, blend) in near {
                // Nearly at the coarser level: the remaining layers are at the heights of the
                // coarse ones, the others have faded out.
                if blend > 0.0 && coarse != pelage_core::skin::NONE {
                    assert!(blend > 0.999);
                    let same = far.iter().find(|f| f.1 == coarse).expect("the coarse layer");
                    assert!((same.0 - height).abs() < 1e-3, "{layers} layers at {distance}");
                }
            }
            // Slightly beyond, the fine layers are still at their heights.
            for (a, b) in far.iter().zip(at(distance * (1.0 + 1e-4), layers)) {
                assert!((a.0 - b.0).abs() < 1e-3 && a.1 == b.1 && b.3 < 1e-3);
            }
        }
    }
}

#[test]
fn fewer_shells_keep_their_places() {
    let shells = Shells::default();
    let all = rows(&shells, 16, 16, 1.0, &[], &|_| 0.0);
    let some = rows(&shells, 16, 5, 1.0, &[], &|_| 0.0);
    assert_eq!(some[..5], all[..5]);
    // The fins end where the shells end.
    assert_eq!(some.last().unwrap().height, 5.0 / 16.0);
    assert_eq!(rows(&shells, 16, 0, 1.0, &[], &|_| 0.0).len(), FIN_ROWS as usize);
}
