//! Lapped textures: covers a skin with flattened patches, so that one small toroidal texture
//! suffices for any mesh. The variant without overlap is that of Lengyel et al.
//!
//! [`lap`] first finds the direction of the hair on each face (`field`). Then, until everything is
//! covered, it picks a random uncovered place, grows a disc of faces within an irregular outline
//! around it (`outline`, `grow`) and flattens it by a least-squares fit to the field (`flatten`).
//! Faces that would be flipped or stretched too much are cut off and left to later patches. A patch
//! of one face is flattened exactly, so the method terminates on every mesh.
// [Praun2000], [Lengyel2001] sec. 2.1

mod cells;
mod field;
mod flatten;
mod grow;
mod outline;
mod picture;
mod solve;
mod statistics;
mod surface;
mod write;

pub use outline::contains;
pub use picture::{field_picture, patch_picture};
pub use statistics::Statistics;
pub use write::write_obj;

use cells::Cells;
use glam::{DVec2, Vec2, Vec3};
use grow::{Grower, Seed};
use outline::Outline;
use pelage_core::scene::LappedSpec;
use pelage_core::{Error, Result, Scene, Skin};
use pelage_fur::random::hash2;
use std::time::Instant;
use surface::Surface;

/// A skin covered with patches.
#[derive(Debug, Clone, Default)]
pub struct Lapped {
    /// Direction of the hair on each face: unit, tangent to the face, world space.
    pub field: Vec<Vec3>,
    /// The patches in the order of pasting: later ones lie on earlier ones. If patches do not
    /// overlap, those that are completely hidden are left out.
    pub patches: Vec<Patch>,
    /// The patch that each face shows: the last one pasted that covers the whole face or, if there
    /// is none (which happens only with overlapping patches), the last one that touches it.
    pub topmost: Vec<u32>,
    /// uv of each face's corners in its topmost patch, cm: u runs along the field, v along normal x
    /// field. Not wrapped: divide by the torus's edge for texture coordinates.
    pub corner_uv: Vec<[Vec2; 3]>,
    /// Radius of the outlines, cm.
    pub radius: f32,
    /// Fraction of the skin's area that patches cover, 0..1; [`lap`] continues until it is 1. Of
    /// overlapping patches, only what lies within their outlines counts.
    pub coverage: f64,
    /// Whether patches follow the field.
    pub aligned: bool,
    /// Time taken, ms.
    pub time_ms: f64,
}

/// A flattened piece of the skin.
#[derive(Debug, Clone, Default)]
pub struct Patch {
    /// Its faces, in the order in which they were added.
    pub faces: Vec<u32>,
    /// uv of the corners of each of `faces`, cm, with the outline's centre at the origin.
    /// Orientation is preserved: no face has a negative area.
    pub corner_uv: Vec<[Vec2; 3]>,
    /// The outline that masks an overlapping patch (see [`contains`]): a star-shaped polygon around
    /// the origin with corners at even angles, cm, counter-clockwise from +u. Empty if patches do
    /// not overlap; then a patch shows whole faces.
    pub outline: Vec<Vec2>,
}

/// Largest area of the skin relative to the squared radius of overlapping patches; it limits their
/// number.
const MOST_PATCH_AREAS: f64 = 250_000.0;

/// Covers `skin` with patches as `scene.lapped` describes; `scene.render.seed` is the random seed.
///
/// # Errors
/// [`Error::Scene`] if the skin has no faces or no area, if a setting is out of range, or if the
/// direction field is undefined: `field = "groom"` without `guard.comb_direction`,
/// `field = "vectors"` without vectors or with one that is zero or perpendicular to the skin.
pub fn lap(skin: &Skin, scene: &Scene) -> Result<Lapped> {
    let start = Instant::now();
    let spec = &scene.lapped;
    let radius = radius(skin, spec)?;
    let surface = Surface::new(skin)?;
    let field = field::directions(&surface, spec, Vec3::from(scene.guard.comb_direction), radius)?;
    let mut lapped = Lapped {
        field: surface.frames.iter().zip(&field).map(|(f, z)| f.world(*z)).collect(),
        topmost: vec![u32::MAX; skin.triangles.len()],
        corner_uv: vec![Default::default(); skin.triangles.len()],
        radius: radius as f32,
        aligned: spec.aligned,
        ..Default::default()
    };
    let mut paste = Paste {
        grower: Grower::new(&surface, &field),
        radius,
        spec,
        seed: hash2(scene.render.seed, 0x1a99ed),
        lapped: &mut lapped,
    };
    if spec.overlapping {
        paste.overlapping()?
    } else {
        paste.whole_faces()
    }
    lapped.time_ms = start.elapsed().as_secs_f64() * 1000.0;
    Ok(lapped)
}

/// Checks the skin and the settings, and returns the radius of the outlines, cm.
fn radius(skin: &Skin, spec: &LappedSpec) -> Result<f64> {
    let area = skin.area();
    if skin.triangles.is_empty() {
        return Err(Error::fault("lapped", "the skin has no faces, expected at least one to lay a patch on"));
    }
    if !(area.is_finite() && area > 0.0) {
        return Err(Error::fault(
            "lapped",
            format!("the skin's area is {area} cm², expected a number above 0"),
        ));
    }
    let radius = spec.radius.map_or(area.sqrt() * LappedSpec::RADIUS, f64::from);
    if !(radius.is_finite() && radius > 0.0) {
        return Err(Error::fault("lapped.radius", format!("found {radius}, expected a length above 0, cm")));
    }
    let irregularity = spec.irregularity;
    if !(0.0..=0.9).contains(&irregularity) {
        return Err(Error::fault("lapped.irregularity", format!("found {irregularity}, expected 0..0.9")));
    }
    if spec.overlapping && area / (radius * radius) > MOST_PATCH_AREAS {
        return Err(too_small(radius, area));
    }
    Ok(radius)
}

fn too_small(radius: f64, area: f64) -> Error {
    let least = (area / MOST_PATCH_AREAS).sqrt();
    Error::fault(
        "lapped.radius",
        format!(
            "found {radius:e} cm, too small for overlapping patches on {area:.4e} cm², expected about {least:e} cm or \
             more: raise it, or let patches not overlap"
        ),
    )
}

/// State of pasting patches one after the other.
struct Paste<'a> {
    grower: Grower<'a>,
    radius: f64,
    spec: &'a LappedSpec,
    seed: u32,
    lapped: &'a mut Lapped,
}

impl Paste<'_> {
    /// Pastes patches of whole faces: a face belongs to a patch if its centroid lies in the
    /// outline. Each face shows the last patch.
    // [Lengyel2001] sec. 2.1
    fn whole_faces(&mut self) {
        for face in self.grower.surface.random_order(self.seed) {
            if self.lapped.topmost[face as usize] != u32::MAX {
                continue;
            }
            let (outline, seed) = self.start(face, DVec2::splat(1.0 / 3.0));
            let inside = |uv: &[DVec2; 3]| outline.contains((uv[0] + uv[1] + uv[2]) / 3.0);
            let patch = self.grower.patch(&seed, &inside);
            for f in &patch.faces {
                self.lapped.topmost[*f as usize] = self.lapped.patches.len() as u32;
            }
            self.lapped.patches.push(patch);
        }
        self.drop_hidden();
        self.look_up_topmost();
        self.lapped.coverage = 1.0;
    }

    /// Pastes patches masked by their outlines; a face belongs to every patch whose outline touches
    /// it.
    fn overlapping(&mut self) -> Result<()> {
        let surface = self.grower.surface;
        let area = surface.area;
        let least = self.radius * (1.0 - f64::from(self.spec.irregularity));
        let mut cells = Cells::new(surface, (self.radius / 8.0).min(least / 2.0))
            .ok_or_else(|| too_small(self.radius, area))?;
        let mut whole = vec![false; surface.frames.len()];
        for face in surface.random_order(self.seed) {
            loop {
                let draw = hash2(self.seed ^ 0x5eed, self.lapped.patches.len() as u32);
                let Some((cell, center)) = cells.uncovered(face, draw) else { break };
                let (outline, seed) = self.start(face, center);
                let touches = |uv: &[DVec2; 3]| outline.relation(uv) != outline::Relation::Outside;
                let mut patch = self.grower.patch(&seed, &touches);
                self.only_touched(&mut patch, &outline, face);
                patch.outline = outline.polygon();
                let number = self.lapped.patches.len() as u32;
                for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
                    let uv = uv.map(|p| p.as_dvec2());
                    let f = *f as usize;
                    let all = outline.relation(&uv) == outline::Relation::Inside;
                    if all || !whole[f] {
                        self.lapped.topmost[f] = number;
                        whole[f] |= all;
                    }
                    cells.cover(f as u32, &uv, &outline);
                }
                // A cell is smaller than the outline around its centre, so it is covered now.
                // Should rounding prevent that, it is given up, which counts as uncovered in the
                // end, and the loop terminates.
                cells.give_up(face, cell);
                self.lapped.patches.push(patch);
            }
        }
        self.lapped.coverage = cells.coverage();
        self.look_up_topmost();
        Ok(())
    }

    /// Outline and seed of the next patch, centred on `center` (barycentric coordinates of corners
    /// 1 and 2) of `face`.
    fn start(&self, face: u32, center: DVec2) -> (Outline, Seed) {
        let random = hash2(self.seed, self.lapped.patches.len() as u32);
        let outline = Outline::new(self.radius, f64::from(self.spec.irregularity), random);
        let turn = f64::from(pelage_fur::random::random(random, 0)) * std::f64::consts::TAU;
        let turn = if self.spec.aligned { None } else { Some(turn) };
        (outline, Seed { face, center, turn })
    }

    /// Removes faces that the outline does not touch once the patch is flat.
    fn only_touched(&self, patch: &mut Patch, outline: &Outline, seed: u32) {
        let touched = |f: u32, uv: &[Vec2; 3]| {
            f == seed || outline.relation(&uv.map(|p| p.as_dvec2())) != outline::Relation::Outside
        };
        let kept: (Vec<u32>, Vec<[Vec2; 3]>) =
            patch.faces.iter().zip(&patch.corner_uv).filter(|(f, uv)| touched(**f, uv)).unzip();
        (patch.faces, patch.corner_uv) = kept;
    }

    /// Removes patches that are completely hidden by later ones.
    fn drop_hidden(&mut self) {
        let Lapped { patches, topmost, .. } = &mut *self.lapped;
        let mut shown = vec![false; patches.len()];
        topmost.iter().for_each(|p| shown[*p as usize] = true);
        // New index of each patch: the number of visible patches before it.
        let number: Vec<u32> = shown
            .iter()
            .scan(0, |count, shown| {
                *count += u32::from(*shown);
                Some(*count - u32::from(*shown))
            })
            .collect();
        topmost.iter_mut().for_each(|p| *p = number[*p as usize]);
        let mut shown = shown.into_iter();
        patches.retain(|_| shown.next().unwrap_or(true));
    }

    fn look_up_topmost(&mut self) {
        let Lapped { patches, topmost, corner_uv, .. } = &mut *self.lapped;
        for (p, patch) in patches.iter().enumerate() {
            for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
                if topmost[*f as usize] == p as u32 {
                    corner_uv[*f as usize] = *uv;
                }
            }
        }
    }
}
