//! The skin's vertices, as a client draws them: one for each place in the textures, with its hair.

use super::Manifest;
use crate::lapped::Lapped;
use crate::shellfin::{Pose, bent, brush_weight, hair_curve};
use glam::{Vec2, Vec3};
use pelage_core::mesh::topology;
use pelage_core::scene::{BakeSource, Mapping};
use pelage_core::skin::NONE;
use pelage_core::{Error, Result, Skin, World};
use pelage_fur::groom;
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint};
use pelage_fur::random::{hash2, random};
use pelage_fur::shell_prisms::{lowered, wanted_heights};
use pelage_fur::surface;
use std::collections::HashMap;

/// A skin whose vertices are split along the seams of its textures. Arrays other than `triangles`
/// have one element per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clothed {
    /// Positions, world space, cm.
    pub positions: Vec<Vec3>,
    /// Normals, unit.
    pub normals: Vec<Vec3>,
    /// Directions of upright hair, unit: the normals, smoothed over the scale of the fur's height.
    pub upright: Vec<Vec3>,
    /// The skin's own uv, v upwards; `None` without uv.
    pub skin_uv: Option<Vec<Vec2>>,
    /// Place in the fur's textures, one unit per repeat.
    pub fur_uv: Vec<Vec2>,
    /// Colour of the bare skin, linear.
    pub skin_colors: Vec<Vec3>,
    /// Factor on the textures' colour.
    pub fur_colors: Vec<Vec3>,
    /// The longest hair: the second to fourth control points of a cubic Bézier curve from the skin
    /// to the tip, relative to the first one on the skin, cm. A shell at height s (0..1) passes
    /// through the curve's point at parameter s, whose height is s times that of the tip.
    pub hairs: Vec<[Vec3; 3]>,
    /// The skin vertex from which each vertex was split.
    pub origin: Vec<u32>,
    /// Faces, in the order of the skin's.
    pub triangles: Vec<[u32; 3]>,
}

/// An edge that may carry a fin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinEdge {
    /// Its vertices, in the direction in which it runs in its face.
    pub ends: [u32; 2],
    /// The third vertex of that face, and of the neighbour: [`NONE`] at a border.
    pub opposite: [u32; 2],
    /// u of the fin texture at both ends.
    pub u: [f32; 2],
}

/// Splits the skin's vertices so that each has one place in the textures, and evaluates hair and
/// colours there.
///
/// # Errors
/// [`Error::Unsupported`] as [`super::write`].
pub fn clothe(world: &World, lapped: &Lapped, manifest: &Manifest) -> Result<Clothed> {
    let skin = &world.skin;
    let by_uv = world.scene.shells.mapping == Mapping::Uv;
    let own = if by_uv { crate::shellfin::uv_in_cm(skin) } else { None };
    let corners = if by_uv { own.as_ref() } else { Some(&lapped.corner_uv) };
    let corners = corners.ok_or_else(|| {
        Error::Unsupported(
            "shells.mapping is \"uv\", but the mesh has no uv: use \"lapped\", or add uv to the mesh".into(),
        )
    })?;
    if corners.len() != skin.triangles.len() || skin.triangles.is_empty() {
        return Err(Error::Unsupported(format!(
            "found patches for {} faces, expected those of a skin of {} faces, at least one",
            corners.len(),
            skin.triangles.len()
        )));
    }
    let edges = manifest.patch;
    let spacing = world.scene.shells.spacing.unwrap_or(manifest.spacing);
    for (name, value) in [
        ("patch", edges[0]),
        ("patch", edges[1]),
        ("fin_length", manifest.fin_length),
        ("fin_depth", manifest.fin_depth),
        ("spacing", spacing),
        ("layers", manifest.layers as f32),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::Unsupported(format!(
                "manifest: found {name} = {value}, expected a number above 0"
            )));
        }
    }
    let height = spacing * manifest.layers as f32;
    let curved = manifest.source == BakeSource::Hybrid;
    let bend = Pose::at(world, 0.0, height).by_height(height);
    // The same directions along which `pelage render` extrudes the shells.
    let packed = groom::pack(world)?;
    let maps = Maps { groom: &packed.groom, texels: &packed.texels };
    let upright = surface::shell_normals(skin, packed.undercoat.height);
    let kept = if curved { kept(skin, &maps, &upright) } else { vec![1.0; upright.len()] };
    let mut clothed = Clothed { skin_uv: skin.corner_uv.as_ref().map(|_| Vec::new()), ..Clothed::default() };
    let mut numbers: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (t, triangle) in skin.triangles.iter().enumerate() {
        let mut face = [0; 3];
        for (k, v) in triangle.iter().enumerate() {
            let fur_uv = corners[t][k] / Vec2::from(edges);
            let uv = skin.corner_uv.as_ref().map(|uv| uv[t][k]);
            let [a, b] = fur_uv.to_array().map(f32::to_bits);
            let [c, d] = uv.unwrap_or_default().to_array().map(f32::to_bits);
            let next = clothed.positions.len() as u32;
            face[k] = *numbers.entry((*v, [a, b, c, d])).or_insert(next);
            if face[k] != next {
                continue;
            }
            let at = SkinPoint {
                position: skin.positions[*v as usize],
                normal: skin.normals[*v as usize],
                uv: uv.unwrap_or_default(),
                color: skin.vertex_color(*v as usize),
                place: MeshPlace::Vertex(*v),
            };
            let upright = upright[*v as usize];
            let length = kept[*v as usize] * maps.scalar(Parameter::ShellLength, &at).max(0.0);
            clothed.positions.push(at.position);
            clothed.normals.push(at.normal);
            clothed.upright.push(upright);
            clothed.fur_uv.push(fur_uv);
            clothed.skin_uv.as_mut().into_iter().for_each(|all| all.extend(uv));
            clothed.skin_colors.push(maps.color(Parameter::BaseColor, &at));
            clothed.fur_colors.push(maps.color(Parameter::ShellColor, &at));
            clothed
                .hairs
                .push(hair(world, curved.then_some(&maps), &at, upright, bend).map(|p| height * length * p));
            clothed.origin.push(*v);
        }
        clothed.triangles.push(face);
    }
    Ok(clothed)
}

/// The hair at a point, in units of the fur's height: upright, sheared by comb and brushes, its tip
/// displaced by `bend`. For textures baked from the groom (`groom`) it is the groom's strand
/// without its random parts, scaled so that its tip is as high as the fur. Height is proportional
/// to the curve's parameter, so that each texture layer lies at its own height.
// As in shaders/shellfin_rows.wgsl. [Lengyel2001] sec. 2.4, [Xbdev]
fn hair(world: &World, groom: Option<&Maps<'_>>, at: &SkinPoint, n: Vec3, bend: Vec3) -> [Vec3; 3] {
    let shells = &world.scene.shells;
    let strokes = shells
        .brushes
        .iter()
        .map(|b| brush_weight(at.position, b.center, b.radius) * Vec3::from(b.direction));
    let mut lean = Vec3::from(shells.comb) + strokes.sum::<Vec3>();
    if let Some(maps) = groom {
        lean += maps.combed_lean(at, Vec3::ZERO);
    }
    lean -= n * n.dot(lean);
    let [p1, p2, p3] = hair_curve(n, lean, groom.map(|maps| maps.hairs_at(at).gravity));
    [p1, p2, bent(p3, bend, n, 1.0)]
}

/// All edges once each (an edge of more than two faces once per face), in the order of faces. Each
/// edge has a random place in the texture and its own length there.
// [Lengyel2001] sec. 2.3
pub fn fin_edges(world: &World, clothed: &Clothed, fin_length: f32) -> Vec<FinEdge> {
    let topology = topology::neighbours(&world.skin.triangles);
    let mut edges = Vec::with_capacity(topology.edges);
    for (t, (face, neighbours)) in clothed.triangles.iter().zip(&topology.neighbours).enumerate() {
        for (k, other) in neighbours.iter().enumerate() {
            if *other != NONE && (*other as usize) < t {
                continue;
            }
            let ends = [face[(k + 1) % 3], face[(k + 2) % 3]];
            let [a, b] = ends.map(|i| clothed.origin[i as usize]);
            // The neighbour's corner that is not on the edge.
            let beyond = clothed
                .triangles
                .get(*other as usize)
                .and_then(|f| f.iter().copied().find(|i| ![a, b].contains(&clothed.origin[*i as usize])));
            let length = clothed.positions[ends[0] as usize].distance(clothed.positions[ends[1] as usize]);
            let start = random(hash2(a, b), 0);
            edges.push(FinEdge {
                ends,
                opposite: [face[k], beyond.unwrap_or(NONE)],
                u: [start, start + length / fin_length],
            });
        }
    }
    edges
}

/// Fraction of its wanted height, 0..1, that the shell keeps over each vertex when it is extruded
/// along `upright`.
fn kept(skin: &Skin, maps: &Maps<'_>, upright: &[Vec3]) -> Vec<f32> {
    let wanted = wanted_heights(skin, upright, maps, &surface::vertex_uv(skin));
    let heights = lowered(skin, upright, &wanted);
    heights.iter().zip(&wanted).map(|(height, wanted)| (height / wanted.max(1e-4)).clamp(0.0, 1.0)).collect()
}
