//! `guard_raster` against its CPU twin, and the coverage of ribbons.

use crate::common::gpu::{self, Fixture, jittered_grid, scaled, world_on};
use glam::Vec3;
use pelage_fur::layout::Bin;
use pelage_fur::layout::Root;
use pelage_fur::strands::{radius, vertex};
use pelage_fur::view::{ray_through, samples_per_slope};
use pelage_gpu::Recorder;
use pelage_gpu::recorder::Timings;
use pelage_render::probe::Probe;
use pelage_render::twin::base_raster::NO_BASE;
use pelage_render::twin::guard_raster::{ribbon_coverage, segment};
use pelage_render::twin::resolve::Node;

const FILM: [u32; 2] = [160, 110];

fn fixture(gpu: &'static pelage_gpu::Gpu, diameter: f32, segments: u32) -> Fixture {
    let scene = format!(
        "[camera]\neye = [6, 7, 9]\ntarget = [2.5, 0, 2.5]\nfov = 40\n[[lights]]\n[guard]\ndensity = 5\nlength = 0.8\ntip_fade = 1\n\
         diameter = [{diameter}, {diameter}, 10]\nsegments = {segments}\n[render]\nfur = \"explicit\"\n"
    );
    Fixture::new(gpu, world_on(&scene, Some(scaled(jittered_grid(5, 0.2), 1.0, 5.0)), Vec::new()))
}

/// Explicit strands.
struct Strands {
    roots: Vec<Root>,
    vertices: Vec<[f32; 4]>,
    shades: Vec<[u32; 2]>,
}

/// The fragments of each sample; the skin lies at depth `base`.
fn draw(fixture: &Fixture, tile: &Probe<'_>, strands: &Strands, base: f32) -> Vec<Vec<Node>> {
    let p = &fixture.prepared;
    let n = strands.roots.len() as u32;
    let samples = (tile.frame.tile_size[0] * tile.frame.tile_size[1]) as usize;
    p.gpu.queue.write_buffer(
        &tile.buffers().buffer("base_records").unwrap().raw,
        0,
        bytemuck::cast_slice(&vec![[base, 0.0, 0.0, 0.0]; samples]),
    );
    let buffers = [
        p.gpu.uniform("bin", &Bin { start: 0, strands: n }).unwrap(),
        p.gpu.upload("bins", 6, &(0..n).collect::<Vec<u32>>()).unwrap(),
        p.gpu.upload("roots", 3, &strands.roots).unwrap(),
        p.gpu.upload("strand_vertices", 3, &strands.vertices).unwrap(),
        p.gpu.upload("shades", 3, &strands.shades).unwrap(),
    ];
    let mut recorder = Recorder::new(p.gpu);
    let scope = tile.scope().with(&buffers.iter().collect::<Vec<_>>());
    p.passes.guard_raster.record(&mut recorder, &scope, n, p.segments).unwrap();
    recorder.submit(&mut Timings::default()).unwrap();
    tile.lists().unwrap()
}

#[test]
fn fragments_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    // Much thinner than a sample, and several samples wide.
    for diameter in [60.0, 3000.0] {
        let fixture = fixture(gpu, diameter, 6);
        let strands = Strands {
            roots: fixture.read("roots", fixture.strands()),
            vertices: fixture.strand_vertices(),
            shades: fixture.read("shades", fixture.strands() * 7),
        };
        let size = [120, 90];
        let tile = fixture.tile(FILM, [20, 10], size, 400_000);
        let base = 11.0;
        let found = draw(&fixture, &tile, &strands, base);
        let mut wanted = vec![Vec::new(); found.len()];
        for (i, root) in strands.roots.iter().enumerate() {
            let of = 7 * i..7 * (i + 1);
            let (vertices, shades) = (&strands.vertices[of.clone()], &strands.shades[of]);
            for f in (0..6).flat_map(|k| segment(&tile.frame, vertices, shades, root.seed, k)) {
                if f.z < base {
                    wanted[(f.xy[1] * size[0] + f.xy[0]) as usize].push(f);
                }
            }
        }
        let total: usize = wanted.iter().map(Vec::len).sum();
        let drawn: usize = found.iter().map(Vec::len).sum();
        assert!(total > 500 && total.abs_diff(drawn) * 500 < total, "{drawn} fragments, {total} wanted");
        let mut odd = 0;
        for (i, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
            for f in wanted {
                let twin = found.iter().filter(|n| n.source == f.source);
                let away = |n: &Node| (n.color - f.color).abs().max_element();
                match twin.min_by(|a, b| away(a).total_cmp(&away(b))) {
                    // Halves, and rounding where a ribbon is much shorter than a sample.
                    Some(n) if away(n) < 4e-3 && (n.z - f.z).abs() < 1e-3 => {}
                    Some(n) => {
                        odd += 1;
                        assert!(away(n) < 0.1, "{diameter} um, sample {i}: {n:?} {f:?}");
                    }
                    // A sliver, or a column whose centre is at the end of a segment.
                    None => odd += 1,
                }
            }
        }
        assert!(odd * 200 < total, "{diameter} um: {odd} of {total} fragments differ");
    }
}

/// A straight strand at depth `z` between two points of the film, in samples, all of one width.
fn straight(tile: &Probe<'_>, ends: [[f32; 2]; 2], width: f32, segments: u32) -> Strands {
    let z = 8.0;
    let world = |s: [f32; 2]| Vec3::from(tile.frame.eye) + z * ray_through(&tile.frame, s.into());
    let radius_cm = 0.5 * width * z / samples_per_slope(&tile.frame);
    let [a, b] = ends.map(world);
    let at = |k: u32| vertex(a.lerp(b, k as f32 / segments as f32), radius_cm, 1.0);
    Strands {
        roots: vec![Root { prism: 0, seed: 5, lambda: [0.3; 2] }],
        vertices: (0..=segments).map(at).collect(),
        // White, seen.
        shades: vec![[0x3c00_3c00, 0x0000_3c00]; segments as usize + 1],
    }
}

#[test]
fn coverage_adds_up_to_the_width() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = fixture(gpu, 60.0, 4);
    // Along x and along y, level and slanting. The slopes are irrational, so that all phases occur.
    for (slope, tolerance) in [(0.0, 1e-3), (0.381_966, 4e-3), (0.763_932, 4e-3)] {
        for (steep, width) in [(false, 0.07), (false, 0.8), (true, 1.7), (true, 6.3)] {
            let tile = fixture.tile(FILM, [0, 0], FILM, 100_000);
            let (long, from) = if steep { (90.0, 10.0) } else { (120.0, 10.3) };
            let ends = [[from, 12.4], [from + long, 12.4 + slope * long]];
            let ends = if steep { ends.map(|[a, b]| [b, a]) } else { ends };
            let strands = straight(&tile, ends, width, 4);
            let lists = draw(&fixture, &tile, &strands, NO_BASE);
            let [w, h] = FILM.map(|n| n as usize);
            let alpha = |x: usize, y: usize| lists[y * w + x].iter().map(|n| n.color[3]).sum::<f32>();
            let sums: Vec<f32> = if steep {
                (0..h).map(|y| (0..w).map(|x| alpha(x, y)).sum()).collect()
            } else {
                (0..w).map(|x| (0..h).map(|y| alpha(x, y)).sum()).collect()
            };
            // Every column or row between the ends once, and none beyond.
            let lit: Vec<f32> = sums.iter().copied().filter(|s| *s > 0.0).collect();
            assert_eq!(lit.len(), long as usize, "slope {slope}, steep {steep}, width {width}");
            let decoded = 2.0 * radius(strands.vertices[0]) * samples_per_slope(&tile.frame) / 8.0;
            let wanted = decoded * (1.0 + slope * slope).sqrt();
            let mean = lit.iter().sum::<f32>() / lit.len() as f32;
            assert!(
                (mean - wanted).abs() < tolerance * wanted.max(1.0),
                "slope {slope}, steep {steep}: {mean}, wanted {wanted}"
            );
            // Segments share no column, so that no sample is covered twice.
            assert!(lists.iter().all(|l| l.len() <= 1), "slope {slope}, steep {steep}, width {width}");
        }
    }
}

#[test]
fn coverage_of_a_box() {
    assert_eq!(ribbon_coverage(0.0, 3.0), 1.0);
    assert_eq!(ribbon_coverage(0.0, 0.1), 0.2);
    assert_eq!(ribbon_coverage(2.0, 2.0), 0.5);
    assert_eq!(ribbon_coverage(3.0, 2.0), 0.0);
    // Boxes side by side share the width.
    for shift in 0..10 {
        let sum: f32 = (-9..=9).map(|i| ribbon_coverage((i as f32 + 0.1 * shift as f32).abs(), 1.3)).sum();
        assert!((sum - 2.6).abs() < 1e-5, "{sum}");
    }
}
