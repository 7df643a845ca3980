//! A world's optical-depth lattice with what its CPU twins read.

use super::gpu::{self, Fixture};
use pelage_core::World;
use pelage_core::scene::MultipleModel;
use pelage_fur::groom::multiple_model;
use pelage_fur::layout::{Column, Frame};
use pelage_fur::shell::Place;
use pelage_fur::undercoat::Undercoat;
use pelage_gpu::Gpu;
use pelage_render::twin::film::halves;
use pelage_render::twin::lattice;
use pelage_render::twin::undercoat_source::Lattice;
use pelage_transport::Table;

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
    /// Model of multiple scattering, and its table.
    pub multiple: (MultipleModel, Option<Table>),
}

impl Lit {
    /// Prepares a world.
    pub fn new(gpu: &'static Gpu, world: World) -> Self {
        let frame = gpu::frame(&world);
        let fixture = Fixture::new(gpu, world);
        let fur = fixture.fur;
        let nodes = (fur.lattice.columns * (fur.lattice.levels + 1)) as usize;
        let columns: Vec<Column> = fixture.read("columns", fur.lattice.columns as usize);
        let tau = fixture.read("tau", nodes * fur.lattice.tau_stride as usize);
        let extinction: Vec<u32> = fixture.read("lattice_extinction", nodes);
        let guard = extinction.into_iter().map(|word| halves(word)[1]).collect();
        let densities = columns.iter().map(|c| c.density).collect();
        let model = multiple_model(&fixture.world.scene);
        let tabulated = matches!(model, MultipleModel::Dual | MultipleModel::Transport);
        let table = tabulated.then(|| Table::of_world(&fixture.world, &fixture.packed));
        Self { fixture, frame, columns, tau, guard, densities, multiple: (model, table) }
    }

    /// Nodes of the lattice.
    pub fn nodes(&self) -> usize {
        (self.fixture.fur.lattice.columns * (self.fixture.fur.lattice.levels + 1)) as usize
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
            undercoat: &self.fixture.packed.undercoat_fibre,
            multiple: self.multiple.0,
            table: self.multiple.1.as_ref(),
        }
    }

    /// The medium.
    pub fn undercoat(&self) -> Undercoat<'_> {
        self.fixture.undercoat()
    }

    /// Place of a node.
    pub fn place(&self, column: u32, level: u32) -> Place {
        lattice::node_place(&self.fixture.shell, &self.fixture.fur, &self.columns[column as usize], level).0
    }
}
