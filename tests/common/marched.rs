//! A tile of a small world through steps 4 to 7, with what the CPU twins of these steps read.

use super::gpu::{self, Fixture, Tile};
use glam::Vec4;
use pelage_core::World;
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Buffer, Gpu, Recorder};
use pelage_render::twin::base_raster;
use pelage_render::twin::film::{Sample, unpack};
use pelage_render::twin::resolve::{Base, Node};
use pelage_render::twin::undercoat_march::MarchInputs;

/// A tile and its world.
pub struct Marched {
    /// The world, prepared.
    pub fixture: Fixture,
    /// The tile.
    pub tile: Tile,
    /// The lattice's source terms as the march reads them.
    pub source: Vec<[u32; 4]>,
    /// The stored volume.
    pub cells: Vec<u32>,
    more: Vec<Buffer>,
}

impl Marched {
    /// The tile of `size` samples at `origin` of a film of `film` samples; skin and entries are
    /// drawn.
    pub fn new(gpu: &'static Gpu, world: World, film: [u32; 2], origin: [i32; 2], size: [u32; 2]) -> Self {
        let fixture = Fixture::new(gpu, world);
        let samples = u64::from(size[0] * size[1]);
        let tile = Tile::new(&fixture, film, origin, size, 200 * samples);
        let nodes = fixture.fur.columns * (fixture.fur.levels + 1);
        let source = fixture.read("source", nodes as usize);
        let cells = fixture.cells();
        let more =
            vec![gpu.storage("samples", 7, samples * 32).unwrap(), gpu.storage("lost_rays", 7, 16).unwrap()];
        let made = Self { fixture, tile, source, cells, more };
        made.tile.draw_base(&made.fixture);
        made.tile.draw_entries(&made.fixture);
        made
    }

    /// What the march reads.
    pub fn inputs(&self) -> MarchInputs<'_> {
        MarchInputs {
            undercoat: self.fixture.undercoat(&self.cells),
            source: &self.source,
            frame: &self.tile.frame,
            coat: &self.fixture.packed.undercoat_fibre,
        }
    }

    /// Samples of the tile with their places.
    pub fn places(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        let [w, h] = self.tile.frame.tile_size;
        (0..w * h).map(move |i| (i as usize, [i % w, i / w]))
    }

    fn run(&self, record: impl FnOnce(&mut Recorder<'_>, &pelage_gpu::Scope<'_>)) {
        let gpu = self.fixture.prepared.gpu;
        let mut recorder = Recorder::new(gpu);
        let scope = self.tile.scope(&self.fixture).with(&self.more.iter().collect::<Vec<_>>());
        record(&mut recorder, &scope);
        recorder.submit(&mut Timings::default()).unwrap();
    }

    fn samples(&self) -> u64 {
        u64::from(self.tile.frame.tile_size[0] * self.tile.frame.tile_size[1])
    }

    /// Step 5's march.
    pub fn march(&self) {
        self.run(|r, scope| {
            self.fixture.prepared.passes.undercoat_march.record(r, scope, self.samples()).unwrap()
        });
    }

    /// Step 6, all strands.
    pub fn draw_strands(&self) {
        let p = &self.fixture.prepared;
        let Some(strands) = &p.resident else { return };
        let all: Vec<u32> = (0..strands.count).collect();
        let list = p.gpu.upload("bins", 6, &all).unwrap();
        let bin = p.gpu.uniform("bin", &[0, strands.count, 0, 0]).unwrap();
        self.run(|r, scope| {
            let scope = strands.scope(scope).with(&[&list, &bin]);
            p.passes.guard_raster.record(r, &scope, strands.count, p.segments).unwrap();
        });
    }

    /// Step 7.
    pub fn resolve(&self, exact: bool) -> Vec<Sample> {
        self.run(|r, scope| {
            self.fixture.prepared.passes.resolve.record(r, scope, self.samples(), exact).unwrap()
        });
        let words: Vec<[u32; 8]> =
            self.fixture.prepared.gpu.read(&self.more[0], self.samples() * 32).unwrap();
        words.into_iter().map(unpack).collect()
    }

    /// Rays given up, and the longest list.
    pub fn counts(&self) -> [u32; 2] {
        let counts: Vec<u32> = self.fixture.prepared.gpu.read(&self.more[1], 8).unwrap();
        [counts[0], counts[1]]
    }

    /// The fragments of each sample, sorted.
    pub fn nodes(&self) -> Vec<Vec<Node>> {
        let node = |n: &gpu::Node| Node { z: n.z, source: n.source, color: Vec4::from(n.color) };
        self.tile
            .lists(self.fixture.prepared.gpu)
            .iter()
            .map(|list| list.iter().map(node).collect())
            .collect()
    }

    /// The skin under each sample.
    pub fn bases(&self) -> Vec<Option<Base>> {
        let records = self.tile.base_records(self.fixture.prepared.gpu);
        let seen = records.into_iter().map(base_raster::unpack);
        seen.map(|b| (b.z < 1e30).then_some(Base { z: b.z, radiance: b.radiance })).collect()
    }
}
