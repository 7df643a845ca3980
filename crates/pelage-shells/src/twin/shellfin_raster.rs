//! Twin of `shaders/shellfin_raster.wgsl`: the image of skin, fins and shells, sample by sample and
//! triangle by triangle in drawing order. Textures are read at their finest level only, so
//! comparisons need magnified or uniform textures.

use crate::bake::Texture;
use crate::lapped::contains;
use crate::passes::shellfin_raster::Draws;
use crate::twin::shellfin_rows::RowVertex;
use glam::{Vec2, Vec3, Vec4};
use pelage_core::skin::NONE;
use pelage_fur::arithmetic::smoothstep;
use pelage_fur::layout::{FinEdge, Frame, FurCorner, ShellRow, ShellVertex, Shellfin};
use pelage_fur::random::{hash2, random};
use pelage_fur::view::sample_ray;
use pelage_render::twin::base_raster::{Projected, plane_depth, project};

/// Coverage below which a fragment is discarded, as in the shader.
const LEAST_COVERAGE: f32 = 0.002;

/// Inputs of the pass.
pub struct Picture<'a> {
    /// Parameters of shells and fins.
    pub shellfin: &'a Shellfin,
    /// Numbers of primitives to draw.
    pub draws: Draws,
    /// The view.
    pub frame: &'a Frame,
    /// The skin's vertices.
    pub vertices: &'a [ShellVertex],
    /// Radiance of the skin at its vertices.
    pub base_light: &'a [Vec3],
    /// Three corners per triangle: of the skin, then of the shells if patches overlap.
    pub corners: &'a [FurCorner],
    /// Outlines of overlapping patches; empty if they do not overlap.
    pub outlines: &'a [Vec<Vec2>],
    /// Edges with both adjacent faces.
    pub edges: &'a [FinEdge],
    /// The rows.
    pub rows: &'a [ShellRow],
    /// Vertices of the rows, `[row][vertex of the skin]`.
    pub row_vertices: &'a [RowVertex],
    /// Layers of all levels of detail.
    pub layers: &'a [Texture],
    /// Contribution of the guard hairs to the layers; empty if they are not separate.
    pub guard_layers: &'a [Texture],
    /// The fin and the guard hairs' contribution to it, deepened as for drawing.
    pub fin: [&'a Texture; 2],
}

/// Interpolated attributes of a vertex.
#[derive(Clone, Copy)]
struct Varying {
    position: Vec3,
    patch: u32,
    uv: Vec2,
    normal: Vec3,
    tangent: Vec3,
    lean: Vec3,
    undercoat: Vec3,
    guard: Vec3,
}

/// A sample of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Premultiplied colour and coverage.
    pub color: Vec4,
    /// Depth of the skin and of shells that write it, cm; infinite if there is none.
    pub depth: f32,
    /// Distance to the nearest edge of any triangle that was tested here, in samples.
    pub margin: f32,
}

/// Opacity of a fin, 0..1, seen from `eye`.
// [Lengyel2001] sec. 2.3, [Tariq2007]
pub fn fin_fade(shellfin: &Shellfin, vertices: &[ShellVertex], edge: &FinEdge, eye: Vec3) -> f32 {
    let at = |v: u32| Vec3::from(vertices[v as usize].position);
    let (a, b) = (at(edge.a), at(edge.b));
    let view = (eye - 0.5 * (a + b)).normalize();
    let border = edge.opposite[1] == NONE;
    let n1 = (b - a).cross(at(edge.opposite[0]) - a).normalize();
    let n2 = if border { n1 } else { (at(edge.opposite[1]) - a).cross(b - a).normalize() };
    let [na, nb] = [edge.a, edge.b].map(|v| Vec3::from(vertices[v as usize].normal));
    let p = (b - a).normalize().cross(na + nb).normalize().dot(view);
    let (c1, c2) = (n1.dot(view), n2.dot(view));
    let nearest = c1.abs().min(c2.abs());
    let on = c1 * c2 < 0.0 || border;
    match shellfin.fade {
        0 => (2.0 * p.abs() - 1.0).max(0.0),
        1 => f32::from(u8::from(on || nearest < shellfin.fin_threshold)),
        _ if on => 1.0,
        _ => (2.0 - 2.0 * nearest / shellfin.fin_threshold.max(1e-4)).clamp(0.0, 1.0),
    }
}

/// Root mean square sine of the angle between the view direction and hairs whose directions vary
/// around `tangent` with `variance` per axis.
fn spread_sine(tangent: Vec3, view: Vec3, variance: f32) -> f32 {
    let c = tangent.normalize().dot(view);
    (1.0 - (c * c + variance * (1.0 - c * c)) / (1.0 + 2.0 * variance)).max(0.0).sqrt()
}

/// Lit colour, premultiplied; `guard` is the guard hairs' contribution to `whole`.
fn lit(whole: Vec4, guard: Vec4, at: &Varying) -> Vec4 {
    let fine = (whole.truncate() - guard.truncate()).max(Vec3::ZERO);
    (fine * at.undercoat + guard.truncate() * at.guard).extend(whole.w)
}

/// `color` for a path `slant` times as long through the layer, whose mean transmittance is raised
/// to that power.
fn slanted(row: &ShellRow, color: Vec4, slant: f32, at: &Varying) -> Vec4 {
    let mean_through = 1.0 - row.coverage.min(0.9999);
    if slant <= 1.0 {
        return color * (1.0 - mean_through.powf(slant)) / row.coverage.max(1e-6);
    }
    let more = (1.0 - color.w) * (1.0 - mean_through.powf(slant - 1.0));
    let [undercoat, guard] = [row.undercoat, row.guard].map(Vec3::from);
    let fog = (undercoat * at.undercoat).lerp(guard * at.guard, row.share);
    color + more * fog.extend(1.0)
}

/// A projected triangle.
struct Ready {
    corners: [Varying; 3],
    on_film: Projected,
}

impl Picture<'_> {
    fn row_vertex(&self, row: u32, v: u32) -> &RowVertex {
        &self.row_vertices[row as usize * self.shellfin.vertices as usize + v as usize]
    }

    fn ready(&self, corners: [Varying; 3]) -> Option<Ready> {
        let on_film = project(self.frame, corners.map(|c| c.position))?;
        Some(Ready { corners, on_film })
    }

    fn skin(&self) -> Vec<Option<Ready>> {
        let skin = 3 * self.draws.triangles as usize;
        self.triangles(&self.corners[..skin], |corner| Varying {
            patch: NONE,
            position: self.vertices[corner.vertex as usize].position.into(),
            uv: Vec2::ZERO,
            normal: Vec3::ZERO,
            tangent: Vec3::ZERO,
            lean: Vec3::ZERO,
            undercoat: self.base_light[corner.vertex as usize],
            guard: Vec3::ZERO,
        })
    }

    fn shell(&self, row: u32) -> Vec<Option<Ready>> {
        let first = self.shellfin.first_corner as usize;
        let end = first + 3 * self.draws.shell_triangles as usize;
        self.triangles(&self.corners[first..end], |corner| {
            let at = self.row_vertex(row, corner.vertex);
            Varying {
                patch: corner.patch_index,
                position: at.position,
                uv: Vec2::from(corner.uv) / Vec2::from(self.shellfin.torus),
                normal: self.vertices[corner.vertex as usize].normal.into(),
                tangent: at.tangent,
                lean: at.lean,
                undercoat: at.undercoat,
                guard: at.guard,
            }
        })
    }

    fn triangles(
        &self,
        corners: &[FurCorner],
        varying: impl Fn(&FurCorner) -> Varying,
    ) -> Vec<Option<Ready>> {
        let ready = |c: &[FurCorner]| self.ready([varying(&c[0]), varying(&c[1]), varying(&c[2])]);
        corners.chunks_exact(3).map(ready).collect()
    }

    /// Two triangles for each pair of adjacent rows of a fin.
    fn fins(&self, edge: &FinEdge) -> Vec<Option<Ready>> {
        let width = Vec3::from(self.vertices[edge.a as usize].position)
            .distance(self.vertices[edge.b as usize].position.into());
        let first = random(hash2(edge.a, edge.b), 0);
        let vertex = |row: u32, right: bool| {
            let v = if right { edge.b } else { edge.a };
            let at = self.row_vertex(self.draws.shells + row, v);
            let u = first + if right { width / self.shellfin.fin_length } else { 0.0 };
            let height = self.rows[(self.draws.shells + row) as usize].height;
            Varying {
                patch: NONE,
                position: at.position,
                uv: Vec2::new(u, height),
                normal: Vec3::ZERO,
                tangent: at.tangent,
                lean: at.lean,
                undercoat: at.undercoat,
                guard: at.guard,
            }
        };
        (0..self.draws.fin_rows - 1)
            .flat_map(|k| {
                let [a, b] = [vertex(k, false), vertex(k, true)];
                let [c, d] = [vertex(k + 1, false), vertex(k + 1, true)];
                [self.ready([a, b, d]), self.ready([a, d, c])]
            })
            .collect()
    }

    fn shell_color(&self, row: &ShellRow, at: &Varying) -> Vec4 {
        let place = at.uv * Vec2::from(self.shellfin.torus);
        if self.outlines.get(at.patch as usize).is_some_and(|outline| !contains(outline, place)) {
            return Vec4::ZERO;
        }
        let whole = self.layers[row.fine as usize].bilinear(at.uv, true);
        let coarse = |textures: &[Texture]| match row.coarse {
            NONE => Vec4::ZERO,
            layer => textures[layer as usize].bilinear(at.uv, true),
        };
        let whole = whole.lerp(coarse(self.layers), row.blend);
        let guard = match self.guard_layers {
            [] => Vec4::ZERO,
            guards => guards[row.fine as usize].bilinear(at.uv, true).lerp(coarse(guards), row.blend),
        };
        if self.shellfin.slanted == 0 {
            return lit(whole, guard, at);
        }
        let view = (Vec3::from(self.frame.eye) - at.position).normalize();
        let facing = at.normal.normalize().dot(view).abs();
        let undercoat = spread_sine(at.lean, view, row.jitter);
        let of_guard = spread_sine(at.tangent, view, self.shellfin.spread.powi(2));
        let slant = (undercoat + row.share * (of_guard - undercoat)) / facing.max(0.08);
        let edge = smoothstep(0.0, 0.35, facing);
        slanted(row, lit(whole, guard, at), slant, at) * (1.0 + self.shellfin.edge_fade * (edge - 1.0))
    }

    fn fin_color(&self, fade: f32, at: &Varying) -> Vec4 {
        let whole = self.fin[0].bilinear(at.uv, false);
        let guard = if self.shellfin.guard == 1 { self.fin[1].bilinear(at.uv, false) } else { Vec4::ZERO };
        lit(whole, guard, at) * fade
    }

    /// Draws the tile and returns its samples, row by row.
    pub fn draw(&self) -> Vec<Pixel> {
        let skin = self.skin();
        let eye = Vec3::from(self.frame.eye);
        let edges = &self.edges[..self.draws.edges as usize];
        let fins: Vec<(f32, Vec<Option<Ready>>)> = edges
            .iter()
            .map(|edge| (fin_fade(self.shellfin, self.vertices, edge, eye), edge))
            .filter(|(fade, _)| *fade > 0.0)
            .map(|(fade, edge)| (fade, self.fins(edge)))
            .collect();
        let shells: Vec<Vec<Option<Ready>>> = (0..self.draws.shells).map(|row| self.shell(row)).collect();
        let [width, height] = self.frame.tile_size;
        let mut pixels = Vec::new();
        for xy in (0..height).flat_map(|y| (0..width).map(move |x| [x, y])) {
            let mut pixel = Pixel { color: Vec4::ZERO, depth: f32::INFINITY, margin: f32::INFINITY };
            for triangle in skin.iter().flatten() {
                if let Some((at, front)) = self.hit(triangle, xy, &mut pixel) {
                    let shown = if front { 1.0 } else { 0.15 };
                    pixel.depth = self.depth(at.position);
                    pixel.color = (at.undercoat * shown).extend(1.0);
                }
            }
            for (fade, triangles) in &fins {
                for triangle in triangles.iter().flatten() {
                    if let Some((at, _)) = self.hit(triangle, xy, &mut pixel) {
                        over(&mut pixel, self.fin_color(*fade, &at));
                    }
                }
            }
            for (row, triangles) in self.rows.iter().zip(&shells) {
                for triangle in triangles.iter().flatten() {
                    let Some((at, true)) = self.hit(triangle, xy, &mut pixel) else { continue };
                    if over(&mut pixel, self.shell_color(row, &at)) && self.draws.depth_write {
                        pixel.depth = self.depth(at.position);
                    }
                }
            }
            pixels.push(pixel);
        }
        pixels
    }

    fn depth(&self, p: Vec3) -> f32 {
        (p - Vec3::from(self.frame.eye)).dot(self.frame.forward.into())
    }

    /// Interpolated attributes of a triangle at a sample, and whether its front is visible; `None`
    /// if the sample is not covered or fails the depth test.
    fn hit(&self, triangle: &Ready, xy: [u32; 2], pixel: &mut Pixel) -> Option<(Varying, bool)> {
        let cover = triangle.on_film.cover(self.frame, xy);
        pixel.margin = pixel.margin.min(cover.margin.abs());
        if cover.margin < 0.0 {
            return None;
        }
        let p = triangle.corners.map(|c| c.position);
        let ray = sample_ray(self.frame, xy);
        let z = plane_depth(self.frame, p, ray);
        if z > pixel.depth {
            return None;
        }
        let x = Vec3::from(self.frame.eye) + z * ray;
        let n = (p[1] - p[0]).cross(p[2] - p[0]);
        let weight = |a: Vec3, b: Vec3| (b - a).cross(x - a).dot(n) / n.dot(n);
        let w = Vec3::new(weight(p[1], p[2]), weight(p[2], p[0]), weight(p[0], p[1]));
        let c = &triangle.corners;
        let mix = |f: &dyn Fn(&Varying) -> Vec3| w.x * f(&c[0]) + w.y * f(&c[1]) + w.z * f(&c[2]);
        let uv = w.x * c[0].uv + w.y * c[1].uv + w.z * c[2].uv;
        let at = Varying {
            position: x,
            patch: c[0].patch,
            uv,
            normal: mix(&|v| v.normal),
            tangent: mix(&|v| v.tangent),
            lean: mix(&|v| v.lean),
            undercoat: mix(&|v| v.undercoat),
            guard: mix(&|v| v.guard),
        };
        Some((at, cover.front))
    }
}

/// Composites a fragment over a pixel; returns false if its coverage is too small.
// [PorterDuff1984]
fn over(pixel: &mut Pixel, color: Vec4) -> bool {
    if color.w < LEAST_COVERAGE {
        return false;
    }
    pixel.color = color + pixel.color * (1.0 - color.w);
    true
}
