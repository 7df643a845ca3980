//! Size and columns of the optical-depth lattice.

use pelage_core::{Result, Skin, World};
use pelage_fur::groom;
use pelage_fur::layout::{Column, UndercoatParameters};
use pelage_fur::surface::number_edges;

/// Size of the optical-depth lattice.
pub(super) struct Lattice {
    /// Cells along an edge of a skin triangle.
    pub cells: u32,
    /// Cells from the skin to the top; a column has one node more.
    pub levels: u32,
    /// Height of the top in shell heights.
    pub reach: f32,
}

/// Estimated bytes of the optical-depth lattice of `world` on an adapter with storage bindings of
/// 128 MiB: columns, extinction, optical depths, and the light at the nodes.
///
/// # Errors
/// As [`groom::pack`].
pub fn lattice_bytes(world: &World) -> Result<u64> {
    let packed = groom::pack(world)?;
    let skin = &world.skin;
    let stride = groom::tau_stride(&world.scene, packed.light_parameters.count);
    let room = (128 << 20) - 8 * packed.undercoat_fibre.texels().len() as u64;
    let lattice = Lattice::plan(skin, world, &packed.undercoat, stride, room);
    let (_, edges) = number_edges(skin);
    let n = u64::from(lattice.cells);
    let columns = skin.positions.len() as u64
        + u64::from(edges) * (n - 1)
        + skin.triangles.len() as u64 * ((n - 1) * n.saturating_sub(2) / 2);
    let node = 4 + 16 + 4 * u64::from(stride);
    Ok(columns * (u64::from(lattice.levels + 1) * node + size_of::<Column>() as u64 + 8))
}

impl Lattice {
    /// Columns about 2 mm and levels about two mean free paths of the undercoat apart (1 to 8 cells
    /// along an edge, 14 to 48 levels), or coarser where the lattice would exceed `room` bytes.
    /// `tau_stride`: words per node of `tau`.
    pub fn plan(
        skin: &Skin,
        world: &World,
        undercoat: &UndercoatParameters,
        tau_stride: u32,
        room: u64,
    ) -> Self {
        /// Wanted distance between columns, cm.
        const SPACING: f32 = 0.2;
        /// Wanted distance between levels in mean free paths of the undercoat.
        const LEVEL_PATHS: f32 = 2.0;
        let reach = if groom::has_guard(&world.scene) {
            (0.8 * groom::guard_length(&world.scene) / undercoat.height.max(1e-4)).clamp(1.0, 4.0)
        } else {
            1.0
        };
        let mean_area = (skin.area() / skin.triangles.len().max(1) as f64) as f32;
        let mean_edge = (mean_area * 2.309).sqrt();
        let path =
            if undercoat.extinction > 0.0 { 1.0 / undercoat.extinction } else { undercoat.height / 4.0 };
        let mut edge = ((mean_edge / SPACING).round() as u32).clamp(1, 8);
        let mut levels = ((undercoat.height * reach / (LEVEL_PATHS * path)).ceil() as u32).clamp(14, 48);
        let bytes = |edge: u32, levels: u32| {
            // A triangular grid has half as many points as cells.
            let columns =
                skin.triangles.len() as u64 * u64::from(edge * edge) / 2 + skin.positions.len() as u64;
            columns * u64::from(levels + 1) * u64::from(tau_stride.max(4)) * 4
        };
        while bytes(edge, levels) > room && edge > 1 {
            edge -= 1;
        }
        while bytes(edge, levels) > room && levels > 4 {
            levels -= 1;
        }
        Self { cells: edge, levels, reach }
    }

    /// Column at barycentric coordinates `(n - i - j, i, j) / n` of triangle `t`, as `column_index`
    /// of `shared/lattice.wgsl` numbers it.
    fn column(&self, skin: &Skin, edge_numbers: &[[u32; 3]], edges: u32, t: usize, i: u32, j: u32) -> usize {
        let n = self.cells;
        let v = skin.triangles[t];
        let vertices = skin.positions.len() as u32;
        let on_edge =
            |edge: u32, a: u32, b: u32, k: u32| vertices + edge * (n - 1) + if a < b { k } else { n - k } - 1;
        let column = match (i, j) {
            (0, 0) => v[0],
            (i, _) if i == n => v[1],
            (_, j) if j == n => v[2],
            (i, 0) => on_edge(edge_numbers[t][2], v[0], v[1], i),
            (0, j) => on_edge(edge_numbers[t][1], v[0], v[2], j),
            (i, j) if i + j == n => on_edge(edge_numbers[t][0], v[1], v[2], j),
            (i, j) => {
                let inner = (n - 1) * (n - 2) / 2;
                vertices + edges * (n - 1) + t as u32 * inner + (j - 1) * (n - 1) - (j - 1) * j / 2 + i - 1
            }
        };
        column as usize
    }

    /// The columns, with their grid point in one of their triangles and their share of the skin's
    /// area (cm²).
    pub fn columns(&self, skin: &Skin, edge_numbers: &[[u32; 3]], edges: u32) -> Vec<Column> {
        let n = self.cells;
        let inner = (n - 1) * n.saturating_sub(2) / 2;
        let count =
            skin.positions.len() + edges as usize * (n as usize - 1) + skin.triangles.len() * inner as usize;
        let mut columns = vec![<Column as bytemuck::Zeroable>::zeroed(); count];
        for t in 0..skin.triangles.len() {
            let share = skin.triangle_area(t) / (n * n) as f32 / 3.0;
            let mut add = |i: u32, j: u32| {
                let column = &mut columns[self.column(skin, edge_numbers, edges, t, i, j)];
                column.prism = t as u32;
                column.grid = i | (j << 16);
                column.area += share;
            };
            for j in 0..n {
                for i in 0..n - j {
                    for (i, j) in [(i, j), (i + 1, j), (i, j + 1)] {
                        add(i, j);
                    }
                    if i + j + 2 <= n {
                        for (i, j) in [(i + 1, j + 1), (i, j + 1), (i + 1, j)] {
                            add(i, j);
                        }
                    }
                }
            }
        }
        columns
    }
}
