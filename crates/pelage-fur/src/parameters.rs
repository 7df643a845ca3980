//! Twin of `shaders/shared/groom.wgsl` and `shaders/shared/roots.wgsl`: groom parameters at a point
//! of the skin.

use crate::layout::{self, Groom, Root};
use crate::shell::Shell;
use glam::{Vec2, Vec3, Vec4};
use half::f16;
use pelage_core::Skin;
use pelage_core::maps::{TRIPLANAR_CM, bilinear, triplanar};

/// Indices of the parameters in [`Groom::parameters`].
#[allow(missing_docs)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    GuardDensity,
    GuardLength,
    GuardThickness,
    GuardComb,
    GuardClump,
    GuardCurl,
    GuardFrizz,
    GuardColorRoot,
    GuardColorTip,
    UndercoatDensity,
    UndercoatHeight,
    UndercoatColorRoot,
    UndercoatColorTip,
    BaseColor,
    ShellColor,
    ShellLength,
}

/// A point of the skin at which parameters are evaluated.
#[derive(Debug, Clone, Copy)]
pub struct SkinPoint {
    /// World space, cm.
    pub position: Vec3,
    /// Unit.
    pub normal: Vec3,
    /// uv of the skin.
    pub uv: Vec2,
    /// Interpolated vertex colour.
    pub color: Vec3,
}

/// Unpacks a colour of eight bits per channel to 0..1.
pub fn unpack_color(word: u32) -> Vec3 {
    Vec3::new((word & 255) as f32, ((word >> 8) & 255) as f32, ((word >> 16) & 255) as f32) / 255.0
}

/// The point of the skin at barycentric coordinates `lambda` of a prism's triangle.
pub fn skin_point(shell: &Shell, prism: u32, lambda: Vec3) -> SkinPoint {
    let corners = shell.prisms[prism as usize].vertices.map(|v| shell.vertices[v as usize]);
    let [a, b, c] = corners;
    let mix = |f: [Vec3; 3]| lambda.x * f[0] + lambda.y * f[1] + lambda.z * f[2];
    let uv = |k: u32| Vec2::from(shell.corner_uv[(3 * prism + k) as usize]);
    SkinPoint {
        position: mix([a.position.into(), b.position.into(), c.position.into()]),
        normal: mix([a.normal.into(), b.normal.into(), c.normal.into()]).normalize(),
        uv: lambda.x * uv(0) + lambda.y * uv(1) + lambda.z * uv(2),
        color: mix(corners.map(|v| unpack_color(v.color))),
    }
}

/// The point of the skin at a root.
pub fn root_point(shell: &Shell, root: &Root) -> SkinPoint {
    let [l1, l2] = root.lambda;
    skin_point(shell, root.prism, Vec3::new(1.0 - l1 - l2, l1, l2))
}

/// The point at barycentric coordinates `lambda` of a triangle, with the skin's own normals rather
/// than those of the shell.
pub fn triangle_point(skin: &Skin, triangle: usize, lambda: Vec3) -> SkinPoint {
    let corners = skin.triangles[triangle].map(|v| v as usize);
    let mix = |f: &[Vec3]| {
        let [a, b, c] = corners.map(|v| f[v]);
        lambda.x * a + lambda.y * b + lambda.z * c
    };
    let uv = |[a, b, c]: [Vec2; 3]| lambda.x * a + lambda.y * b + lambda.z * c;
    SkinPoint {
        position: mix(&skin.positions),
        normal: mix(&skin.normals).normalize_or(Vec3::Y),
        uv: skin.corner_uv.as_ref().map_or(Vec2::ZERO, |of| uv(of[triangle])),
        color: if skin.colors.is_empty() { Vec3::ONE } else { mix(&skin.colors) },
    }
}

/// The groom with its maps.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// The packed groom.
    pub groom: &'a Groom,
    /// Texels of all maps, four halves each.
    pub texels: &'a [[u32; 2]],
}

impl Maps<'_> {
    fn texel(&self, p: &layout::Parameter, x: i32, y: i32) -> Vec4 {
        let [width, height] = p.size.map(|s| s as i32);
        let at = p.texel_base as usize + (y.rem_euclid(height) * width + x.rem_euclid(width)) as usize;
        let halves = |word: u32| [word as u16, (word >> 16) as u16].map(|h| f16::from_bits(h).to_f32());
        let ([r, g], [b, a]) = (halves(self.texels[at][0]), halves(self.texels[at][1]));
        Vec4::new(r, g, b, a)
    }

    /// Repeating bilinear lookup; v = 0 is the bottom row.
    fn bilinear(&self, p: &layout::Parameter, uv: Vec2) -> Vec4 {
        bilinear(p.size, uv, |x, y| self.texel(p, x, y))
    }

    /// Three planar lookups with a period of 10 cm, weighted by the normal.
    // [Geiss2007]
    fn triplanar(&self, p: &layout::Parameter, position: Vec3, normal: Vec3) -> Vec4 {
        triplanar(position / TRIPLANAR_CM, normal, |uv| self.bilinear(p, uv))
    }

    fn lookup(&self, p: &layout::Parameter, at: &SkinPoint) -> Vec4 {
        match p.source {
            1 => at.color.extend(1.0),
            2 => self.bilinear(p, at.uv),
            3 => self.triplanar(p, at.position, at.normal),
            _ => Vec4::ONE,
        }
    }

    /// Evaluates a scalar parameter.
    pub fn scalar(&self, parameter: Parameter, at: &SkinPoint) -> f32 {
        let p = &self.groom.parameters[parameter as usize];
        p.value[0] * self.lookup(p, at)[p.channel as usize] + p.offset
    }

    /// Evaluates a colour parameter, linear RGB.
    pub fn color(&self, parameter: Parameter, at: &SkinPoint) -> Vec3 {
        self.color_of(&self.groom.parameters[parameter as usize], at)
    }

    /// Evaluates a packed colour, linear RGB.
    pub fn color_of(&self, p: &layout::Parameter, at: &SkinPoint) -> Vec3 {
        Vec4::from(p.value).truncate() * self.lookup(p, at).truncate()
    }
}
