//! A world's light lattice with what its twins read.

#![allow(dead_code)] // Every test file uses a part of this.

use crate::gpu::Fixture;
use glam::Vec2;
use pelage::World;
use pelage::camera;
use pelage::gpu::Gpu;
use pelage::layout::{Column, Frame};
use pelage::reference::film::halves;
use pelage::reference::lattice;
use pelage::reference::shell::Place;
use pelage::reference::undercoat::Undercoat;
use pelage::reference::undercoat_source::Lattice;

/// A world with its light.
pub struct Lit {
    /// The world, prepared.
    pub fixture: Fixture,
    /// The view that it was prepared for.
    pub frame: Frame,
    /// The columns.
    pub columns: Vec<Column>,
    /// Optical depths.
    pub tau: Vec<u32>,
    /// Extinction by guard hairs at the nodes, 1/cm.
    pub guard: Vec<f32>,
    /// Densities of the columns.
    pub densities: Vec<f32>,
    /// The stored volume.
    pub cells: Vec<u32>,
}

impl Lit {
    /// Prepares a world.
    pub fn new(gpu: &'static Gpu, world: World) -> Self {
        let film = [world.scene.film.width, world.scene.film.height];
        let frame = camera::frame(&world.scene.camera, film, Vec2::ZERO, Vec2::ZERO, world.scene.render.seed);
        let fixture = Fixture::new(gpu, world);
        let fur = fixture.fur;
        let nodes = (fur.columns * (fur.levels + 1)) as usize;
        let columns: Vec<Column> = fixture.read("columns", fur.columns as usize);
        let tau = fixture.read("tau", nodes * lattice::tau_pairs(&fur) as usize);
        let extinction: Vec<u32> = fixture.read("lattice_extinction", nodes);
        let guard = extinction.into_iter().map(|word| halves(word)[1]).collect();
        let cells = if fur.storage == 1 {
            fixture.read("cells", fixture.prepared.subelements as usize)
        } else {
            Vec::new()
        };
        let densities = columns.iter().map(|c| c.density).collect();
        Self { fixture, frame, columns, tau, guard, densities, cells }
    }

    /// Nodes of the lattice.
    pub fn nodes(&self) -> usize {
        (self.fixture.fur.columns * (self.fixture.fur.levels + 1)) as usize
    }

    /// The lattice as the twins read it.
    pub fn lattice(&self) -> Lattice<'_> {
        Lattice {
            fur: &self.fixture.fur,
            shell: &self.fixture.shell,
            lights: &self.fixture.packed.lights,
            columns: &self.columns,
            tau: &self.tau,
            frame: &self.frame,
            coat: &self.fixture.packed.coat_fibre,
        }
    }

    /// The medium.
    pub fn undercoat(&self) -> Undercoat<'_> {
        Undercoat {
            fur: &self.fixture.fur,
            noise: self.fixture.noise(),
            shell: &self.fixture.shell,
            cells: &self.cells,
        }
    }

    /// Where a node is.
    pub fn place(&self, column: u32, level: u32) -> Place {
        let Fixture { fur, shell, .. } = &self.fixture;
        lattice::node_place(shell, fur, &self.columns[column as usize], level).0
    }
}
