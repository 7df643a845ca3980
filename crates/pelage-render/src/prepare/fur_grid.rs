//! The fur as a grid of extinction over its bounding box, for light that crosses it on its way to
//! an object. Hairs are sampled, so that the time does not depend on their number.

use bytemuck::Zeroable;
use glam::{UVec3, Vec2, Vec3};
use half::f16;
use pelage_core::{World, stage};
use pelage_fur::groom::{self, PackedGroom};
use pelage_fur::guard_strands::strand;
use pelage_fur::hair_roots::Roots;
use pelage_fur::layout::{FurGrid, Root};
use pelage_fur::parameters::{Maps, Parameter, skin_point};
use pelage_fur::random::{even_barycentric, hash2, random};
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use rayon::prelude::*;

/// Cells along the longest side of the box.
const CELLS: u32 = 128;
/// Bytes of a cell in `fur_cells`.
const CELL_BYTES: u64 = 16;
/// Guard hairs that are sampled, about, if there are more.
const STRANDS: f64 = 60_000.0;
/// Largest number of parts of a strand, each of which is deposited at one of its points, drawn at
/// random, so that strands of one length leave no layers.
const PARTS: u32 = 128;
/// Separates the random numbers of samples from those of the fur itself.
const SAMPLE: u32 = 0x6772_6964;
/// Points at which the undercoat is sampled, about.
const POINTS: f64 = 1_500_000.0;

/// Sides of a box around the skin with hairs that stand out from it, cm.
fn expected_box(world: &World) -> Vec3 {
    let (low, high) = world.skin.bounds();
    high - low + 2.0 * stage::longest_hair(&world.scene)
}

/// Expected size of the grid of a world's fur, bytes.
pub fn grid_bytes(world: &World) -> u64 {
    let fur = groom::has_guard(&world.scene) || groom::has_undercoat(&world.scene);
    let side = expected_box(world);
    if !fur || !side.is_finite() || side.max_element() <= 0.0 {
        return CELL_BYTES;
    }
    cells_of(side).1.to_array().map(u64::from).iter().product::<u64>() * CELL_BYTES
}

/// Edge of a cell, and their numbers along the axes, of the grid over a box with these sides.
fn cells_of(side: Vec3) -> (f32, UVec3) {
    let cell = side.max_element() * 1.0001 / CELLS as f32;
    (cell, (side / cell).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(CELLS)))
}

/// The grid and its cells, as `shared/fur_grid.wgsl` reads them.
pub struct FurCells {
    /// Place and size.
    pub grid: FurGrid,
    /// Projected area of hairs per volume, and means of the squares and products of the components
    /// of their directions.
    pub cells: Vec<[u32; 4]>,
}

/// A piece of hair: its middle, its direction (unit), and length times diameter times opacity, cm².
#[derive(Clone, Copy)]
struct Piece {
    at: Vec3,
    along: Vec3,
    area: f32,
}

impl FurCells {
    /// The grid of the fur of `world` on `shell`.
    pub fn of(world: &World, packed: &PackedGroom, shell: &Shell) -> Self {
        let mut pieces = Vec::new();
        if groom::has_guard(&world.scene) {
            pieces.extend(guard_pieces(world, packed, shell));
        }
        if groom::has_undercoat(&world.scene) {
            pieces.extend(undercoat_pieces(packed, shell));
        }
        pieces.retain(|p: &Piece| p.area > 0.0 && p.at.is_finite() && p.along.is_finite());
        Self::deposit(&pieces)
    }

    fn deposit(pieces: &[Piece]) -> Self {
        let (low, high) = pieces
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p.at), high.max(p.at)));
        let longest = (high - low).max_element();
        if pieces.is_empty() || longest <= 0.0 {
            return Self { grid: FurGrid::zeroed(), cells: vec![[0; 4]] };
        }
        let (cell, size) = cells_of(high - low);
        let mut sums = vec![[0f32; 7]; (size.x * size.y * size.z) as usize];
        for p in pieces {
            let at = ((p.at - low) / cell).as_uvec3().min(size - 1);
            let sum = &mut sums[((at.z * size.y + at.y) * size.x + at.x) as usize];
            let t = p.along;
            let terms = [1.0, t.x * t.x, t.y * t.y, t.z * t.z, t.x * t.y, t.x * t.z, t.y * t.z];
            sum.iter_mut().zip(terms).for_each(|(s, term)| *s += p.area * term);
        }
        let volume = cell * cell * cell;
        let pack = |a: f32, b: f32| {
            u32::from(f16::from_f32(a).to_bits()) | (u32::from(f16::from_f32(b).to_bits()) << 16)
        };
        let cells = sums
            .iter()
            .map(|[area, xx, yy, zz, xy, xz, yz]| {
                let share = if *area > 0.0 { 1.0 / area } else { 0.0 };
                let words = [[xx, yy], [zz, xy], [xz, yz]].map(|[a, b]| pack(a * share, b * share));
                [(area / volume).to_bits(), words[0], words[1], words[2]]
            })
            .collect();
        let grid = FurGrid { low: low.into(), cell, size: size.to_array(), padding: 0 };
        Self { grid, cells }
    }
}

/// Parts of the guard hairs or, if there are many, of a sample of them, each of which stands for as
/// many as it is drawn from.
fn guard_pieces(world: &World, packed: &PackedGroom, shell: &Shell) -> Vec<Piece> {
    let density = groom::guard_density(&world.scene);
    let expected = world.skin.area() * f64::from(density);
    let share = (STRANDS / expected.max(1.0)).min(1.0) as f32;
    let groom = &packed.groom;
    let maps = Maps { groom, texels: &packed.texels };
    let roots = Roots { shell, maps, density, seed: world.scene.render.seed };
    let drawn = |prism: u32| {
        if share >= 1.0 {
            return roots.of(prism);
        }
        let seed = hash2(hash2(roots.seed, SAMPLE), prism);
        let count = (roots.expected(prism) * share + random(seed, 0)) as u32;
        let grown = (1..=count).filter_map(|k| {
            let seed = hash2(seed, k);
            let lambda = even_barycentric(Vec2::new(random(seed, 1), random(seed, 2)));
            let wanted = maps.scalar(Parameter::GuardDensity, &skin_point(shell, prism, lambda));
            let grows = random(seed, 3) * density < wanted;
            grows.then_some(Root { prism, seed, lambda: [lambda.y, lambda.z] })
        });
        grown.collect()
    };
    let (cell, _) = cells_of(expected_box(world));
    let of_triangle = |prism: u32| {
        let pieces = drawn(prism).into_iter().flat_map(|root| {
            let strand = strand(shell, &maps, &root);
            let parts =
                ((strand.length / cell).ceil() as u32).clamp(groom.segments, PARTS.max(groom.segments));
            let mut before = strand.point(0.0);
            (0..parts).map(move |k| {
                let after = strand.point((k + 1) as f32 / parts as f32);
                let part = random(root.seed, 1000 + k);
                let s = (k as f32 + part) / parts as f32;
                let way = after - before;
                let piece = Piece {
                    at: before + part * way,
                    along: way.normalize_or(Vec3::Y),
                    area: way.length() * strand.diameter(s) * strand.opacity(s) / share,
                };
                before = after;
                piece
            })
        });
        pieces.collect::<Vec<_>>()
    };
    (0..shell.prisms.len() as u32).into_par_iter().flat_map_iter(of_triangle).collect()
}

/// The undercoat at points that are spread over the shell in proportion to its volume.
fn undercoat_pieces(packed: &PackedGroom, shell: &Shell) -> Vec<Piece> {
    let fur = &packed.undercoat;
    let maps = Maps { groom: &packed.groom, texels: &packed.texels };
    let undercoat = Undercoat { parameters: fur, noise: Field::new(fur.seed), shell, cells: &[] };
    // Volume per height and share of the triangle.
    let volume = |place: &pelage_fur::shell::Place, t: f32, lambda: Vec3| {
        let layer = (place.e1 + t * place.w1).cross(place.e2 + t * place.w2);
        0.5 * layer.dot(place.extrusion(lambda)).abs()
    };
    let rough: Vec<f32> = (0..shell.prisms.len() as u32)
        .map(|prism| volume(&shell.enter(prism), 0.5, Vec3::splat(1.0 / 3.0)))
        .collect();
    let whole: f64 = rough.iter().map(|v| f64::from(*v)).sum();
    if !whole.is_finite() || whole <= 0.0 {
        return Vec::new();
    }
    let of_prism = |prism: u32| {
        let place = shell.enter(prism);
        let wanted = POINTS * f64::from(rough[prism as usize]) / whole;
        let seed = hash2(hash2(fur.seed, SAMPLE), prism);
        // At least one point, so that a small triangle is not left out.
        let count = (wanted.ceil() as u32).max(1);
        (0..count).filter_map(move |k| {
            let seed = hash2(seed, k);
            let lambda = even_barycentric(Vec2::new(random(seed, 0), random(seed, 1)));
            let t = (k as f32 + random(seed, 2)) / count as f32;
            let at = skin_point(shell, prism, lambda);
            let density = maps.scalar(Parameter::UndercoatDensity, &at) / fur.density;
            let up = place.extrusion(lambda);
            if density <= 0.0 || up.length_squared() < 1e-12 {
                return None;
            }
            let domain = undercoat.domain_point(&place, lambda);
            let medium = undercoat.evaluate(domain, up.normalize(), t, seed);
            let relative = density * medium.density * place.crowding(t, medium.tangent);
            let area = fur.extinction * relative * volume(&place, t, lambda) / count as f32;
            Some(Piece { at: place.point(t, lambda), along: medium.tangent, area })
        })
    };
    (0..shell.prisms.len() as u32).into_par_iter().flat_map_iter(of_prism).collect()
}
