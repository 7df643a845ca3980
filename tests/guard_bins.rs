//! `guard_bins` against its CPU twin: each tile has the strands that touch it, each once.

use crate::common::gpu::{self, Fixture, jittered_grid, scaled, world_on};
use pelage_fur::layout::Root;
use pelage_fur::layout::TileGrid;
use pelage_fur::strands::position;
use pelage_gpu::Recorder;
use pelage_gpu::recorder::Timings;
use pelage_render::probe::Probe;
use pelage_render::twin::guard_bins::{may_touch, touched};
use pelage_render::twin::guard_raster::segment;

const FILM: [u32; 2] = [150, 100];

fn fixture(gpu: &'static pelage_gpu::Gpu, camera: &str) -> Fixture {
    let scene = format!(
        "[camera]\n{camera}\n[guard]\ndensity = 8\nlength = 0.8\nsegments = 5\n[render]\nfur = \"explicit\"\n"
    );
    Fixture::new(gpu, world_on(&scene, Some(scaled(jittered_grid(5, 0.2), 1.0, 5.0)), Vec::new()))
}

/// Strands by tile, sorted, as the GPU finds them.
fn bins(fixture: &Fixture, tile: &Probe<'_>, tiles: &TileGrid) -> Vec<Vec<u32>> {
    let p = &fixture.prepared;
    let strands = p.resident.as_ref().unwrap();
    let [w, h] = tiles.grid;
    let n = u64::from(w * h);
    let uniform = p.gpu.uniform("tile_grid", tiles).unwrap();
    let counts = p.gpu.storage("bin_counts", 6, n * 4).unwrap();
    let run = |list: Option<(&pelage_gpu::Buffer, &pelage_gpu::Buffer)>| {
        let mut recorder = Recorder::new(p.gpu);
        recorder.clear(&counts, n * 4);
        let scope = strands.scope(&tile.scope()).with(&[&uniform, &counts]);
        match list {
            None => p.passes.guard_bins.record_count(&mut recorder, &scope, strands.count).unwrap(),
            Some((starts, list)) => {
                let scope = scope.with(&[starts, list]);
                p.passes.guard_bins.record_fill(&mut recorder, &scope, strands.count).unwrap();
            }
        }
        recorder.submit(&mut Timings::default()).unwrap();
    };
    run(None);
    let sizes: Vec<u32> = p.gpu.read(&counts, n * 4).unwrap();
    let firsts: Vec<u32> = sizes.iter().scan(0, |sum, c| Some(std::mem::replace(sum, *sum + c))).collect();
    let total: u32 = sizes.iter().sum();
    let starts = p.gpu.upload("bin_starts", 6, &firsts).unwrap();
    let list = p.gpu.storage("bins", 6, u64::from(total) * 4).unwrap();
    run(Some((&starts, &list)));
    let all: Vec<u32> = p.gpu.read(&list, u64::from(total) * 4).unwrap();
    let of = |(first, size): (&u32, &u32)| {
        let mut bin = all[*first as usize..][..*size as usize].to_vec();
        bin.sort_unstable();
        bin
    };
    firsts.iter().zip(&sizes).map(of).collect()
}

#[test]
fn bins_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    let cases = [
        ("eye = [6, 7, 9]\ntarget = [2.5, 0, 2.5]\nfov = 40", [32, 32], [5, 4]),
        // Seen from among the hairs: some cross the near plane.
        ("eye = [2.5, 0.5, 2.5]\ntarget = [5, 0.2, 2.5]\nnear = 0.3\nfov = 60", [25, 50], [6, 2]),
    ];
    for (camera, size, grid) in cases {
        let fixture = fixture(gpu, camera);
        let tile = fixture.tile(FILM, [0, 0], FILM, 16);
        let tiles = TileGrid { origin: [0, 0], size, grid, margin: 3.0, length: 0.0 };
        let found = bins(&fixture, &tile, &tiles);
        let vertices = fixture.strand_vertices();
        let mut wanted = vec![Vec::new(); found.len()];
        for (i, strand) in vertices.chunks(fixture.prepared.segments as usize + 1).enumerate() {
            touched(&tile.frame, &tiles, strand).iter().for_each(|t| wanted[*t as usize].push(i as u32));
        }
        let entries: usize = wanted.iter().map(Vec::len).sum();
        assert!(entries > 100, "{entries}");
        // With rounding, a strand at the limit of a tile's reach may be on either side.
        let differ: usize = found
            .iter()
            .zip(&wanted)
            .map(|(a, b)| {
                a.iter().filter(|s| !b.contains(s)).count() + b.iter().filter(|s| !a.contains(s)).count()
            })
            .sum();
        assert!(differ * 500 <= entries, "{camera}: {differ} of {entries}");
    }
}

#[test]
fn every_fragment_lies_in_a_tile_that_has_its_strand() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = fixture(gpu, "eye = [6, 7, 9]\ntarget = [2.5, 0, 2.5]\nfov = 40");
    let tile = fixture.tile(FILM, [0, 0], FILM, 16);
    let tiles = TileGrid { origin: [0, 0], size: [16, 16], grid: [10, 7], margin: 0.0, length: 0.0 };
    let segments = fixture.prepared.segments as usize;
    let roots: Vec<Root> = fixture.read("roots", fixture.strands());
    let vertices = fixture.strand_vertices();
    let shown = vec![[0u32; 2]; segments + 1];
    let found = bins(&fixture, &tile, &tiles);
    let mut fragments = 0;
    for (i, (strand, root)) in vertices.chunks(segments + 1).zip(&roots).enumerate() {
        for f in (0..segments).flat_map(|k| segment(&tile.frame, strand, &shown, root.seed, k)) {
            let bin = f.xy[1] / 16 * 10 + f.xy[0] / 16;
            assert!(found[bin as usize].contains(&(i as u32)), "strand {i} at {:?}", f.xy);
            fragments += 1;
        }
    }
    assert!(fragments > 1000, "{fragments}");
}

#[test]
fn gathered_roots_are_all_that_may_touch_a_tile() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = fixture(gpu, "eye = [6, 7, 9]\ntarget = [2.5, 0, 2.5]\nfov = 40");
    let p = &fixture.prepared;
    let strands = p.resident.as_ref().unwrap();
    let tile = fixture.tile(FILM, [60, 40], [24, 24], 16);
    let (length, margin) = (1.2f32, 2.0f32);
    let n = u64::from(strands.count);
    let buffers = [
        p.gpu
            .uniform("tile_grid", &TileGrid { origin: [0; 2], size: [24; 2], grid: [1; 2], margin, length })
            .unwrap(),
        p.gpu.storage("bin_counts", 6, 4).unwrap(),
        p.gpu.storage("tile_roots", 6, n * 16).unwrap(),
        p.gpu.storage("bins", 6, n * 4).unwrap(),
    ];
    let mut recorder = Recorder::new(p.gpu);
    let scope = strands.scope(&tile.scope()).with(&buffers.iter().collect::<Vec<_>>());
    p.passes.guard_bins.record_gather(&mut recorder, &scope, strands.count).unwrap();
    recorder.submit(&mut Timings::default()).unwrap();
    let count = p.gpu.read::<u32>(&buffers[1], 4).unwrap()[0];
    let gathered: Vec<Root> = p.gpu.read(&buffers[2], u64::from(count) * 16).unwrap();
    let list: Vec<u32> = p.gpu.read(&buffers[3], u64::from(count) * 4).unwrap();
    assert_eq!(list, (0..count).collect::<Vec<_>>());

    let roots: Vec<Root> = fixture.read("roots", fixture.strands());
    let vertices = fixture.strand_vertices();
    let segments = p.segments as usize;
    let shown = vec![[0u32; 2]; segments + 1];
    let (mut wanted, mut seen, mut differ) = (0, 0, 0);
    for (root, strand) in roots.iter().zip(vertices.chunks(segments + 1)) {
        let there = gathered.contains(root);
        let may = may_touch(&tile.frame, position(strand[0]), length, margin);
        wanted += u32::from(may);
        differ += u32::from(may != there);
        let shows = (0..segments).any(|k| !segment(&tile.frame, strand, &shown, root.seed, k).is_empty());
        seen += u32::from(shows);
        assert!(there || !shows, "{root:?} shows in the tile");
    }
    assert!(
        seen > 3 && wanted < strands.count,
        "{seen} of {wanted} strands show, there are {}",
        strands.count
    );
    assert!(differ <= 1, "{differ} of {wanted}");
}
