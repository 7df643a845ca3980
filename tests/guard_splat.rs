//! `guard_splat` against its CPU twin: the guard hairs are deposited on the lattice without loss.

use crate::common::gpu::{self, Fixture, jittered_grid, scaled, world_on};
use pelage_fur::layout::{Column, Root};
use pelage_fur::strands::{position, radius};
use pelage_gpu::Recorder;
use pelage_gpu::recorder::Timings;
use pelage_render::twin::guard_splat::{deposits, extinction, volume};

/// Fixed point of the deposits, 1/cm2.
const FIXED_POINT: f64 = 4_194_304.0;

fn haired(size: f32, guard: &str) -> pelage_core::World {
    let density = 4.0 / (size * size);
    let scene = format!(
        "[guard]\ndensity = {density}\nsegments = 8\n{guard}\n[undercoat]\nheight = {}\nlayers = 1\nsubdivision = 0\n",
        0.3 * size
    );
    world_on(&scene, Some(scaled(jittered_grid(6, 0.15), size, 6.0 * size)), Vec::new())
}

/// The deposits, computed again into a separate buffer.
fn redrawn(fixture: &Fixture) -> Vec<u32> {
    let p = &fixture.prepared;
    let nodes = (fixture.fur.lattice.columns * (fixture.fur.lattice.levels + 1)) as usize;
    let buffer = p.gpu.storage("deposits", 2, nodes as u64 * 4).unwrap();
    let extinction = p.gpu.storage("lattice_extinction", 2, nodes as u64 * 4).unwrap();
    let strands = p.resident.as_ref().unwrap();
    let mut recorder = Recorder::new(p.gpu);
    let scope = strands.scope(&p.scope()).with(&[&buffer, &extinction]);
    p.passes.guard_splat.record_deposit(&mut recorder, &scope, strands.count).unwrap();
    recorder.submit(&mut Timings::default()).unwrap();
    p.gpu.read(&buffer, nodes as u64 * 4).unwrap()
}

#[test]
fn deposits_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    for (size, guard) in
        [(1.0, "length = 0.3\nspread = 30"), (0.1, "length = 0.05\nspread = 10\ngravity = 1")]
    {
        let fixture = Fixture::new(gpu, haired(size, guard));
        let roots: Vec<Root> = fixture.read("roots", fixture.strands());
        let vertices = fixture.strand_vertices();
        let (wanted, total) =
            deposits(&fixture.shell, &fixture.fur, &roots, &vertices, fixture.prepared.segments);
        let found: Vec<f64> = redrawn(&fixture).into_iter().map(|d| f64::from(d) / FIXED_POINT).collect();
        let sum: f64 = found.iter().sum();
        // Twelve roundings a segment, each by half a unit at most, up or down.
        let roundings = (roots.len() * fixture.prepared.segments as usize * 12) as f64;
        assert!(
            (sum - total).abs() < 0.5 * roundings.sqrt() * 3.0 / FIXED_POINT + 1e-4 * total,
            "{sum} {total}"
        );
        let largest = wanted.iter().copied().fold(0.0, f64::max);
        for (i, (a, b)) in found.iter().zip(&wanted).enumerate() {
            // Rounded to whole units some hundred times.
            assert!((a - b).abs() < 1e-3 * largest + 16.0 / FIXED_POINT, "{guard}: node {i}: {a} {b}");
        }
        let off: f64 = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).sum();
        assert!(off < 1e-3 * total + 4.0 * found.len() as f64 / FIXED_POINT, "{guard}: {off} of {total}");
        // The result of the passes.
        let columns: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
        let undercoat = fixture.evaluated_undercoat();
        let kept: Vec<u32> = fixture.read("lattice_extinction", found.len());
        let mut seen = [0.0f32; 2];
        for (i, word) in kept.iter().enumerate() {
            let (column, level) =
                (i as u32 / (fixture.fur.lattice.levels + 1), i as u32 % (fixture.fur.lattice.levels + 1));
            let wanted = extinction(&fixture.fur, &undercoat, &columns[column as usize], level, found[i]);
            let halves = [*word as u16, (*word >> 16) as u16].map(|h| half::f16::from_bits(h).to_f32());
            for k in 0..2 {
                seen[k] = seen[k].max(wanted[k]);
                gpu::close(halves[k], wanted[k], 1.5e-3, format!("{guard}: extinction {k} at node {i}"));
            }
        }
        assert!(seen[0] > 1.0 && seen[1] > 0.01, "{guard}: {seen:?}");
    }
}

#[test]
fn what_is_deposited_is_length_times_diameter() {
    let Some(gpu) = gpu::open() else { return };
    // Short upright hairs, so that only few cross the border of the skin.
    let fixture =
        Fixture::new(gpu, haired(1.0, "length = 0.2\nspread = 0\ngravity = 0\nfrizz = 0\nclump = 0"));
    let vertices = fixture.strand_vertices();
    let strands = vertices.chunks(fixture.prepared.segments as usize + 1);
    let area: f64 = strands
        .flat_map(|s| s.windows(2))
        .map(|w| f64::from((position(w[1]) - position(w[0])).length() * (radius(w[0]) + radius(w[1]))))
        .sum();
    let sum: f64 = redrawn(&fixture).into_iter().map(|d| f64::from(d) / FIXED_POINT).sum();
    assert!((sum - area).abs() < 0.01 * area, "{sum} deposited of {area}");
}

#[test]
fn node_volumes_fill_the_shell() {
    let Some(gpu) = gpu::open() else { return };
    let mut world = haired(1.0, "length = 0.3");
    // A flat skin: the shell is a slab.
    world.skin = scaled(jittered_grid(6, 0.0), 1.0, 6.0);
    let fixture = Fixture::new(gpu, world);
    let columns: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
    let levels = 0..=fixture.fur.lattice.levels;
    let volumes =
        columns.iter().flat_map(|c| levels.clone().map(|l| volume(&fixture.shell, &fixture.fur, c, l)));
    let sum: f64 = volumes.map(f64::from).sum();
    let slab = 36.0 * 0.3 * f64::from(fixture.fur.lattice.reach);
    assert!((sum - slab).abs() < 1e-3 * slab, "{sum} {slab}");
}
