//! Groom parameters at their mean over the skin: one texture serves all of it.

use glam::{Vec2, Vec3, Vec4};
use pelage_core::World;
use pelage_core::maps::VERTEX_COLOR;
use pelage_core::scene::{Color, Scalar};
use pelage_fur::random::{hash2, random};

/// Places on the skin where maps are read.
const SAMPLES: usize = 20_000;

/// Places spread over the skin, by area.
pub(super) struct SkinSamples<'a> {
    world: &'a World,
    /// Triangle and barycentric coordinates, and the area that the place stands for.
    places: Vec<(usize, Vec3, f64)>,
}

impl<'a> SkinSamples<'a> {
    /// A few places on each triangle, more on larger ones.
    pub fn new(world: &'a World) -> Self {
        let skin = &world.skin;
        let total = skin.area().max(1e-30);
        let mut places = Vec::new();
        for t in 0..skin.triangles.len() {
            let area = f64::from(skin.triangle_area(t));
            let n = ((area / total * SAMPLES as f64).round() as u32).max(1);
            let seed = hash2(0x6d65_616e, t as u32);
            for k in 0..n {
                // The R2 sequence, so that the places of one triangle lie evenly.
                let u = Vec2::new(random(seed, 0), random(seed, 1))
                    + k as f32 * Vec2::new(0.754_877_7, 0.569_840_3);
                let u = u - u.floor();
                let r = u.x.sqrt();
                let lambda = Vec3::new(1.0 - r, r * (1.0 - u.y), r * u.y);
                places.push((t, lambda, area / f64::from(n)));
            }
        }
        Self { world, places }
    }

    fn mean(&self, map: &str, color: bool) -> Vec4 {
        let World { skin, maps, .. } = self.world;
        let image = maps.index_of(map, color).and_then(|i| maps.images.get(i));
        if map != VERTEX_COLOR && image.is_none() {
            return Vec4::ONE;
        }
        let (mut sum, mut area) = ([0.0f64; 4], 0.0);
        for (t, lambda, weight) in &self.places {
            let triangle = skin.triangles[*t].map(|v| v as usize);
            let mix = |f: &[Vec3]| {
                lambda.x * f[triangle[0]] + lambda.y * f[triangle[1]] + lambda.z * f[triangle[2]]
            };
            let texel = match (image, &skin.corner_uv) {
                (None, _) => mix(&skin.colors).extend(1.0).to_array(),
                (Some(image), Some(uv)) => {
                    let [a, b, c] = uv[*t];
                    image.bilinear(lambda.x * a + lambda.y * b + lambda.z * c)
                }
                (Some(image), None) => image.triplanar(mix(&skin.positions), mix(&skin.normals), 1.0),
            };
            (0..4).for_each(|k| sum[k] += weight * f64::from(texel[k]));
            area += weight;
        }
        if area > 0.0 { Vec4::from(sum.map(|s| (s / area) as f32)) } else { Vec4::ONE }
    }

    /// The mean of a scalar, not below 0.
    pub fn scalar(&self, scalar: &Scalar) -> f32 {
        let value = match scalar {
            Scalar::Constant(v) => *v,
            Scalar::Mapped(m) => {
                let texel = self.mean(&m.map, false);
                m.value * texel[m.channel.index()] + m.offset
            }
        };
        value.max(0.0)
    }

    /// The mean of a colour.
    pub fn color(&self, color: &Color) -> Vec3 {
        match color {
            Color::Constant(c) => Vec3::from(*c),
            Color::Mapped(m) => Vec3::from(m.value) * self.mean(&m.map, true).truncate(),
        }
    }

    /// Mean of a function of the skin's normal over its area.
    pub fn over_normals(&self, f: impl Fn(Vec3) -> f32) -> f32 {
        let skin = &self.world.skin;
        let (mut sum, mut area) = (0.0, 0.0);
        for t in 0..skin.triangles.len() {
            let [a, b, c] = skin.corners(t);
            if let Some(normal) = (b - a).cross(c - a).try_normalize() {
                sum += f64::from(skin.triangle_area(t)) * f64::from(f(normal));
                area += f64::from(skin.triangle_area(t));
            }
        }
        (sum / area.max(1e-30)) as f32
    }

    /// Length of one unit of uv on the skin, cm; `None` where the skin has none.
    pub fn uv_unit(&self) -> Option<f32> {
        let skin = &self.world.skin;
        let uv = skin.corner_uv.as_ref()?;
        let flat: f64 = uv.iter().map(|[a, b, c]| f64::from(0.5 * (*b - *a).perp_dot(*c - *a).abs())).sum();
        (flat > 0.0).then(|| (skin.area() / flat).sqrt() as f32)
    }
}
