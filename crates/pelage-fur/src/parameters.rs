//! Twin of `shaders/shared/groom.wgsl` and `shaders/shared/roots.wgsl`: groom parameters at a point
//! of the skin.

use crate::layout::{self, Groom, GuardHairs, Root};
use crate::shell::Shell;
use glam::{Vec2, Vec3, Vec4};
use half::f16;
use pelage_core::Skin;
use pelage_core::maps::{TRIPLANAR_CM, bilinear, triplanar};

/// Indices of the parameters in [`Coat::parameters`](crate::layout::Coat::parameters).
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
    PartMask,
}

/// Source of a parameter that a coat leaves as it is below.
pub const SOURCE_BELOW: u32 = 4;
/// Lane of a coat whose part chooses no region of the mesh.
pub const NO_LANE: u32 = u32::MAX;

/// A point of the skin at which parameters are evaluated.
#[derive(Debug, Clone, Copy)]
pub struct SkinPoint {
    /// World space, cm.
    pub position: Vec3,
    /// Unit.
    pub normal: Vec3,
    /// uv of the skin.
    pub uv: Vec2,
    /// Interpolated vertex colour and alpha.
    pub color: Vec4,
    /// Where it lies on the mesh.
    pub place: MeshPlace,
}

/// A place on the mesh, for what is stored by triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshPlace {
    /// A vertex.
    Vertex(u32),
    /// A triangle and barycentric coordinates.
    Triangle(u32, Vec3),
}

/// Unpacks a colour of eight bits per channel to 0..1.
pub fn unpack_color(word: u32) -> Vec4 {
    Vec4::from_array(word.to_le_bytes().map(f32::from)) / 255.0
}

/// Packs a colour to eight bits per channel; it is clamped to 0..=1.
pub fn pack_color(color: Vec4) -> u32 {
    u32::from_le_bytes(color.to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8))
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
        color: {
            let [a, b, c] = corners.map(|v| unpack_color(v.color));
            lambda.x * a + lambda.y * b + lambda.z * c
        },
        place: MeshPlace::Triangle(prism, lambda),
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
        color: {
            let [a, b, c] = corners.map(|v| skin.vertex_color(v));
            lambda.x * a + lambda.y * b + lambda.z * c
        },
        place: MeshPlace::Triangle(triangle as u32, lambda),
    }
}

/// A value that goes over from coat to coat.
pub trait Blend: Copy {
    /// The value of what lies below (`self`), with the share of a part's value.
    fn over(self, part: Self, share: f32) -> Self;
}

impl Blend for f32 {
    fn over(self, part: Self, share: f32) -> Self {
        if share >= 1.0 { part } else { self + share * (part - self) }
    }
}

impl Blend for Vec3 {
    fn over(self, part: Self, share: f32) -> Self {
        if share >= 1.0 { part } else { self + share * (part - self) }
    }
}

impl<const N: usize> Blend for [f32; N] {
    fn over(self, part: Self, share: f32) -> Self {
        std::array::from_fn(|i| self[i].over(part[i], share))
    }
}

impl Blend for GuardHairs {
    fn over(self, part: Self, share: f32) -> Self {
        Self {
            comb_direction: self.comb_direction.over(part.comb_direction, share),
            widest: self.widest.over(part.widest, share),
            diameter: self.diameter.over(part.diameter, share),
            spread: self.spread.over(part.spread, share),
            color_transition: self.color_transition.over(part.color_transition, share),
            color_variation: self.color_variation.over(part.color_variation, share),
            length_variation: self.length_variation.over(part.length_variation, share),
            gravity: self.gravity.over(part.gravity, share),
            clump_density: self.clump_density.over(part.clump_density, share),
            curl_frequency: self.curl_frequency.over(part.curl_frequency, share),
            frizz_frequency: self.frizz_frequency.over(part.frizz_frequency, share),
            root_darkening: self.root_darkening.over(part.root_darkening, share),
            opacity: self.opacity.over(part.opacity, share),
            tip_fade: self.tip_fade.over(part.tip_fade, share),
        }
    }
}

/// The groom with its maps.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// The packed groom.
    pub groom: &'a Groom,
    /// Texels of all maps, four halves each, and coverage rows.
    pub texels: &'a [[u32; 2]],
}

fn unpack(texel: [u32; 2]) -> Vec4 {
    let halves = |word: u32| [word as u16, (word >> 16) as u16].map(|h| f16::from_bits(h).to_f32());
    let ([r, g], [b, a]) = (halves(texel[0]), halves(texel[1]));
    Vec4::new(r, g, b, a)
}

impl Maps<'_> {
    fn texel(&self, p: &layout::Parameter, x: i32, y: i32) -> Vec4 {
        let [width, height] = p.size.map(|s| s as i32);
        let at = p.texel_base as usize + (y.rem_euclid(height) * width + x.rem_euclid(width)) as usize;
        unpack(self.texels[at])
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

    fn lookup(&self, p: &layout::Parameter, at: &SkinPoint, origin: [f32; 3]) -> Vec4 {
        match p.source {
            1 => at.color,
            2 => self.bilinear(p, at.uv),
            3 => self.triplanar(p, at.position - Vec3::from(origin), at.normal),
            _ => Vec4::ONE,
        }
    }

    fn coat_scalar(&self, coat: usize, parameter: Parameter, at: &SkinPoint) -> f32 {
        let p = &self.groom.coats[coat].parameters[parameter as usize];
        p.value[0] * self.lookup(p, at, self.groom.origin)[p.channel as usize] + p.offset
    }

    fn coat_color(&self, coat: usize, parameter: Parameter, at: &SkinPoint) -> Vec3 {
        self.color_of(&self.groom.coats[coat].parameters[parameter as usize], at, self.groom.origin)
    }

    /// Coverage of a lane in a row.
    fn row_coverage(&self, row: u32, lane: u32) -> f32 {
        let texel = self.groom.coverage_base + row * self.groom.coverage_texels + lane / 4;
        unpack(self.texels[texel as usize])[(lane % 4) as usize]
    }

    /// How much of the skin at a point belongs to a part rather than to what lies below it, 0..1.
    /// `coat` is the number of the part, from 1.
    pub fn part_share(&self, coat: usize, at: &SkinPoint) -> f32 {
        let mut share = self.coat_scalar(coat, Parameter::PartMask, at).clamp(0.0, 1.0);
        let lane = self.groom.coats[coat].lane;
        if lane != NO_LANE {
            let coverage = match at.place {
                MeshPlace::Vertex(v) => self.row_coverage(self.groom.vertex_rows + v, lane),
                MeshPlace::Triangle(t, lambda) => {
                    lambda.dot(Vec3::from([0, 1, 2].map(|k| self.row_coverage(3 * t + k, lane))))
                }
            };
            share *= coverage.clamp(0.0, 1.0);
        }
        (1.001 * share).min(1.0)
    }

    /// Share of the hairs of a part: bare skin leaves the shape of hairs as it is.
    fn hair_share(&self, coat: usize, at: &SkinPoint) -> f32 {
        if self.groom.coats[coat].bare == 1 { 0.0 } else { self.part_share(coat, at) }
    }

    /// A value of the coats at a point. `share` gives that of a part, `of` the value of a coat.
    fn blend<T: Blend>(&self, share: impl Fn(usize) -> f32, of: impl Fn(usize) -> T) -> T {
        (1..self.groom.count as usize).fold(of(0), |below, coat| {
            let share = share(coat);
            if share > 0.0 { below.over(of(coat), share) } else { below }
        })
    }

    /// Share of a part where it has a value of its own for `parameter`, else 0.
    fn value_share(&self, coat: usize, parameter: Parameter, at: &SkinPoint) -> f32 {
        let below = self.groom.coats[coat].parameters[parameter as usize].source == SOURCE_BELOW;
        if below { 0.0 } else { self.part_share(coat, at) }
    }

    /// Evaluates a scalar parameter.
    pub fn scalar(&self, parameter: Parameter, at: &SkinPoint) -> f32 {
        let share = |coat| self.value_share(coat, parameter, at);
        self.blend(share, |coat| self.coat_scalar(coat, parameter, at))
    }

    /// Evaluates a colour parameter, linear RGB.
    pub fn color(&self, parameter: Parameter, at: &SkinPoint) -> Vec3 {
        let share = |coat| self.value_share(coat, parameter, at);
        self.blend(share, |coat| self.coat_color(coat, parameter, at))
    }

    /// The guard hairs at a point.
    pub fn hairs_at(&self, at: &SkinPoint) -> GuardHairs {
        self.blend(|coat| self.hair_share(coat, at), |coat| self.groom.coats[coat].hairs)
    }

    /// Lean by the comb at a point, its length the tangent of the angle; tangential to `n`.
    pub fn combed_lean(&self, at: &SkinPoint, n: Vec3) -> Vec3 {
        let lean = |coat: usize| {
            let direction = Vec3::from(self.groom.coats[coat].hairs.comb_direction);
            (direction - n * n.dot(direction)) * self.coat_scalar(coat, Parameter::GuardComb, at)
        };
        self.blend(|coat| self.hair_share(coat, at), lean)
    }

    /// Pull of the tips towards clump centres, cm. `to_clump` gives the vector to the nearest
    /// centre where there are as many 1/cm² as its argument says.
    pub fn clump_pull(&self, at: &SkinPoint, to_clump: impl Fn(f32) -> Vec3) -> Vec3 {
        let n = at.normal;
        let pull = |coat: usize| {
            let clump = self.coat_scalar(coat, Parameter::GuardClump, at);
            if clump <= 0.0 {
                return Vec3::ZERO;
            }
            let offset = to_clump(self.groom.coats[coat].hairs.clump_density);
            clump * (offset - n * n.dot(offset))
        };
        self.blend(|coat| self.hair_share(coat, at), pull)
    }

    /// Evaluates a packed colour, linear RGB, on a mesh moved by `origin`.
    pub fn color_of(&self, p: &layout::Parameter, at: &SkinPoint, origin: [f32; 3]) -> Vec3 {
        Vec4::from(p.value).truncate() * self.lookup(p, at, origin).truncate()
    }
}
