//! A tile of a small world through steps 4 to 7, with what the CPU twins of these steps read.

use super::gpu::Fixture;
use pelage_core::World;
use pelage_gpu::Gpu;
use pelage_render::probe::Probe;
use pelage_render::twin::film::Sample;
use pelage_render::twin::resolve::{Base, Node};
use pelage_render::twin::undercoat_march::MarchInputs;

/// A tile and its world.
pub struct Marched {
    /// The world, prepared.
    pub fixture: Fixture,
    /// The tile.
    pub tile: Probe<'static>,
}

impl Marched {
    /// The tile of `size` samples at `origin` of a film of `film` samples; skin and entries are
    /// drawn.
    pub fn new(gpu: &'static Gpu, world: World, film: [u32; 2], origin: [i32; 2], size: [u32; 2]) -> Self {
        Self::of(Fixture::new(gpu, world), film, origin, size)
    }

    /// A tile of a prepared world.
    pub fn of(fixture: Fixture, film: [u32; 2], origin: [i32; 2], size: [u32; 2]) -> Self {
        let tile = fixture.tile(film, origin, size, 200 * u64::from(size[0] * size[1]));
        tile.draw_base().expect("step 4");
        tile.draw_entries().expect("entries");
        Self { fixture, tile }
    }

    /// What the march reads.
    pub fn inputs(&self) -> MarchInputs<'_> {
        self.tile.inputs()
    }

    /// Samples of the tile with their places.
    pub fn places(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        let [w, h] = self.tile.frame.tile_size;
        (0..w * h).map(move |i| (i as usize, [i % w, i / w]))
    }

    /// Step 5's march.
    pub fn march(&self) {
        self.tile.march().expect("the march");
    }

    /// Step 6, all strands.
    pub fn draw_strands(&self) {
        self.tile.draw_strands().expect("step 6");
    }

    /// Step 7.
    pub fn resolve(&self, exact: bool) -> Vec<Sample> {
        self.tile.resolve(exact).expect("step 7")
    }

    /// Rays given up, and the longest list.
    pub fn counts(&self) -> [u32; 2] {
        let counts = self.tile.counters().expect("counters");
        [counts.rays_lost as u32, counts.longest as u32]
    }

    /// The fragments of each sample, sorted.
    pub fn nodes(&self) -> Vec<Vec<Node>> {
        self.tile.lists().expect("lists")
    }

    /// The skin under each sample.
    pub fn bases(&self) -> Vec<Option<Base>> {
        self.tile.bases().expect("records of the skin")
    }
}
