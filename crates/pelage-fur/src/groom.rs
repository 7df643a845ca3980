//! The groom, as the passes read it: values of the scene in the units and structs of the shaders.

use crate::fibre::Fibre;
use crate::layout::{Groom, Light, LightParameters, MAX_LIGHTS, Noise, Parameter, UndercoatParameters};
use bytemuck::Zeroable;
use glam::Vec3;
use noise::permutationtable::{NoiseHasher, PermutationTable};
use pelage_core::maps::MapSet;
use pelage_core::scene::{
    Blend, Color, FibreModel, FibreSpec, FurLayers, MultipleModel, NoiseDomain, Scalar, Scene, Shading,
    ShellLighting,
};
use pelage_core::{Result, World};

/// Words of the scattered light at a node of the optical-depth lattice, after the optical depths:
/// mean radiance from above and from below.
pub const SCATTERED_WORDS: u32 = 3;

/// Bytes of a texel of the map buffer: four halves.
const TEXEL: u64 = 8;

/// The groom, packed for upload.
pub struct PackedGroom {
    /// Parameters, and settings of the guard hairs.
    pub groom: Groom,
    /// Texels of all maps, four halves each, followed by the scattering tables of both fibres.
    pub texels: Vec<[u32; 2]>,
    /// First texels of the scattering tables of guard hairs and undercoat.
    pub table_bases: [u32; 2],
    /// Settings of the undercoat.
    pub undercoat: UndercoatParameters,
    /// Scattering model of the guard hairs.
    pub guard_fibre: Fibre,
    /// Scattering model of the undercoat.
    pub undercoat_fibre: Fibre,
    /// Tables of the simplex noise.
    pub noise: Noise,
    /// All lights, padded to [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// Number of lights, and the key lights.
    pub light_parameters: LightParameters,
}

/// Whether shells and fins are rendered with the light of the groom's own fur.
fn lit_shells(scene: &Scene) -> bool {
    scene.render.fur == FurLayers::Shells && scene.shells.lighting == ShellLighting::Scene
}

/// Whether the guard hairs, or at least their shadows, are rendered.
pub fn has_guard(scene: &Scene) -> bool {
    (matches!(scene.render.fur, FurLayers::Explicit | FurLayers::Hybrid) || lit_shells(scene))
        && scene.guard.density.max() > 0.0
}

/// Whether the undercoat, or at least its shadow, is rendered.
pub fn has_undercoat(scene: &Scene) -> bool {
    (matches!(scene.render.fur, FurLayers::Implicit | FurLayers::Hybrid) || lit_shells(scene))
        && scene.undercoat.density.max() > 0.0
        && scene.undercoat.height.max() > 0.0
}

/// The model of multiple scattering; never [`MultipleModel::Auto`].
pub fn multiple_model(scene: &Scene) -> MultipleModel {
    match scene.render.shading {
        Shading::Paper => MultipleModel::None,
        Shading::Physical => match scene.render.multiple.model {
            MultipleModel::Auto => {
                let physical =
                    |spec: &FibreSpec| matches!(spec.model, Some(FibreModel::Chiang | FibreModel::Medulla));
                let guard = has_guard(scene) && physical(&scene.guard.fibre);
                let undercoat = has_undercoat(scene) && physical(&scene.undercoat.fibre);
                if guard || undercoat { MultipleModel::Transport } else { MultipleModel::Similarity }
            }
            named => named,
        },
    }
}

/// Words of packed optical depths at a lattice node: two per word, one for each light and one for
/// the view direction in the slot after the last light.
pub fn tau_pairs(lights: u32) -> u32 {
    (lights + 2) / 2
}

/// Words of a lattice node in the optical-depth buffer: the optical depths and, for the `transport`
/// model, the scattered light.
pub fn tau_stride(scene: &Scene, lights: u32) -> u32 {
    let scattered = multiple_model(scene) == MultipleModel::Transport;
    tau_pairs(lights) + if scattered { SCATTERED_WORDS } else { 0 }
}

/// Packs the groom of `world`.
pub fn pack(world: &World) -> Result<PackedGroom> {
    let scene = &world.scene;
    let mut maps = MapPacker {
        maps: &world.maps,
        texels: Vec::new(),
        bases: Vec::new(),
        uv: world.skin.corner_uv.is_some(),
    };
    let guard = &scene.guard;
    let undercoat = &scene.undercoat;
    let no_undercoat = !has_undercoat(scene);
    // Without an undercoat the shell still carries the optical-depth lattice of the guard hairs.
    let shell_height = if no_undercoat {
        Scalar::Constant(0.5 * guard.length.max().max(0.02))
    } else {
        undercoat.height.clone()
    };
    let parameters = [
        maps.scalar(&guard.density),
        maps.scalar(&guard.length),
        maps.scalar(&guard.thickness),
        maps.scalar(&guard.comb),
        maps.scalar(&guard.clump),
        maps.scalar(&guard.curl),
        maps.scalar(&guard.frizz),
        maps.color(&guard.color_root),
        maps.color(&guard.color_tip),
        maps.scalar(&undercoat.density),
        maps.scalar(&shell_height),
        maps.color(&undercoat.color_root),
        maps.color(&undercoat.color_tip),
        maps.color(&scene.base.color),
        maps.color(&scene.shells.color),
        maps.scalar(&scene.shells.length),
    ];
    let paper = scene.render.shading == Shading::Paper;
    let multiple = multiple_model(scene);
    let comb = Vec3::from(guard.comb_direction).normalize_or_zero();
    let groom = Groom {
        parameters,
        comb_direction: comb.into(),
        segments: guard.segments,
        diameter: guard.diameter.map(|um| um * 1e-4),
        widest: guard.widest,
        color_transition: guard.color_transition,
        color_variation: guard.color_variation,
        length_variation: guard.length_variation,
        gravity: guard.gravity,
        spread: guard.spread.to_radians().tan(),
        clump_density: guard.clump_density,
        curl_frequency: guard.curl_frequency,
        frizz_frequency: guard.frizz_frequency,
        opacity: guard.opacity,
        tip_fade: guard.tip_fade,
        seed: scene.render.seed,
        root_darkening: guard.root_darkening,
        paper: u32::from(paper),
        padding: 0,
    };
    let extinction = if no_undercoat { 0.0 } else { undercoat.density.max() * undercoat.diameter[0] * 1e-4 };
    let height = shell_height.max();
    let free_path = if extinction > 0.0 { 1.0 / extinction } else { height };
    let undercoat = UndercoatParameters {
        layers: undercoat.layers,
        noise_domain: u32::from(undercoat.noise_domain == NoiseDomain::Uv),
        seed: scene.render.seed,
        extinction,
        diameter_ratio: undercoat.diameter[1] / undercoat.diameter[0].max(1e-6),
        noise_frequency: undercoat.noise_frequency,
        noise_contrast: undercoat.noise_contrast,
        height_variation: undercoat.height_variation,
        height_frequency: undercoat.height_frequency,
        uv_jitter: undercoat.uv_jitter,
        tangent_jitter: undercoat.tangent_jitter,
        jitter_exponent: undercoat.jitter_exponent,
        step: (undercoat.step * free_path).min(height / 16.0),
        light_step: (1.5 * free_path).clamp(height / 32.0, height / 8.0),
        height,
        lean: (comb * undercoat.lean).into(),
        forward_scattering: if multiple == MultipleModel::Similarity {
            undercoat.forward_scattering
        } else {
            0.0
        },
        isotropic: u32::from(paper),
        opacity_cut: 0.001,
        virtual_fragments: match scene.render.blend {
            Blend::Virtual => scene.render.virtual_fragments.max(1),
            Blend::Simplified | Blend::Exact => 0,
        },
        density: undercoat.density.max().max(1e-6),
        attenuation: scene.render.simplified_attenuation,
    };
    let (guard_fibre, undercoat_fibre) = (Fibre::guard(scene), Fibre::undercoat(scene));
    let mut texels = maps.finish();
    let table_bases = [&guard_fibre, &undercoat_fibre].map(|fibre| {
        let base = texels.len() as u32;
        texels.extend(fibre.texels());
        base
    });
    let (light_parameters, lights) = pack_lights(world);
    Ok(PackedGroom {
        groom,
        texels,
        table_bases,
        undercoat,
        guard_fibre,
        undercoat_fibre,
        noise: noise_tables(scene.render.seed),
        lights,
        light_parameters,
    })
}

/// Packs the lights; the key lights are the two brightest of those that light the undercoat, by
/// luminance.
// [BT709]
fn pack_lights(world: &World) -> (LightParameters, Vec<Light>) {
    let mut lights: Vec<Light> = world
        .lights
        .iter()
        .take(MAX_LIGHTS)
        .map(|l| Light {
            direction: l.direction.into(),
            undercoat: u32::from(l.undercoat),
            irradiance: l.irradiance.into(),
            padding: 0,
        })
        .collect();
    let mut order: Vec<usize> = (0..lights.len()).filter(|i| lights[*i].undercoat == 1).collect();
    order.sort_by(|a, b| {
        let power = |i: usize| world.lights[i].irradiance.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        power(*b).total_cmp(&power(*a))
    });
    let mut parameters = LightParameters {
        count: lights.len() as u32,
        keys: order.len().min(2) as u32,
        key_lights: [u32::MAX; 2],
        ..LightParameters::zeroed()
    };
    for (k, i) in order.into_iter().take(2).enumerate() {
        let [x, y, z] = lights[i].direction;
        let [r, g, b] = lights[i].irradiance;
        parameters.key_lights[k] = i as u32;
        parameters.key_direction[k] = [x, y, z, 0.0];
        parameters.key_irradiance[k] = [r, g, b, 0.0];
    }
    lights.resize(MAX_LIGHTS, Light::zeroed());
    (parameters, lights)
}

/// The tables of the `noise` crate's simplex noise for a seed, as `shaders/shared/noise.wgsl` reads
/// them.
// [Perlin2001], [Gustavson2005]
pub fn noise_tables(seed: u32) -> Noise {
    let table = PermutationTable::new(seed);
    let mut permutation = [[0u32; 4]; 16];
    for i in 0..256usize {
        permutation[i / 16][(i / 4) % 4] |= (table.hash(&[i as isize]) as u32) << (8 * (i % 4));
    }
    let d = std::f32::consts::FRAC_1_SQRT_2;
    let gradients2 = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [d, d], [-d, d], [d, -d], [-d, -d]]
        .map(|[x, y]| [x, y, 0.0, 0.0]);
    let mut gradients3 = [[0.0f32; 4]; 32];
    for (i, g) in gradients3.iter_mut().enumerate() {
        // The twelve edges of the cube, twice, then its eight corners.
        let sign = |bit: usize| if i & bit == 0 { 1.0 } else { -1.0 };
        *g = if i >= 24 {
            let c = 1.0 / 3f32.sqrt();
            [sign(1) * c, sign(2) * c, sign(4) * c, 0.0]
        } else {
            let e = i % 12;
            let (a, b) = (if e & 1 == 0 { d } else { -d }, if e & 2 == 0 { d } else { -d });
            match e / 4 {
                0 => [a, b, 0.0, 0.0],
                1 => [a, 0.0, b, 0.0],
                _ => [0.0, a, b, 0.0],
            }
        };
    }
    Noise { permutation, gradients2, gradients3 }
}

/// Collects the texels of the maps that parameters refer to, each map once.
struct MapPacker<'a> {
    maps: &'a MapSet,
    texels: Vec<[u32; 2]>,
    bases: Vec<(usize, u32)>,
    uv: bool,
}

impl MapPacker<'_> {
    fn source(&mut self, name: &str, color: bool) -> (u32, u32, [u32; 2]) {
        if name == "vertex_color" {
            return (1, 0, [1, 1]);
        }
        let Some(index) = self.maps.images.iter().position(|i| i.name == name && i.color == color) else {
            return (0, 0, [1, 1]);
        };
        let image = &self.maps.images[index];
        let known = self.bases.iter().find(|(i, _)| *i == index).map(|(_, base)| *base);
        let base = known.unwrap_or_else(|| {
            let base = self.texels.len() as u32;
            let half = |a: f32, b: f32| {
                u32::from(half::f16::from_f32(a).to_bits())
                    | (u32::from(half::f16::from_f32(b).to_bits()) << 16)
            };
            self.texels.extend(image.texels.iter().map(|t| [half(t[0], t[1]), half(t[2], t[3])]));
            self.bases.push((index, base));
            base
        });
        (if self.uv { 2 } else { 3 }, base, [image.width, image.height])
    }

    fn scalar(&mut self, scalar: &Scalar) -> Parameter {
        match scalar {
            Scalar::Constant(v) => parameter([*v; 4], (0, 0, [1, 1]), 0.0, 0),
            Scalar::Mapped(m) => {
                parameter([m.value; 4], self.source(&m.map, false), m.offset, m.channel.index() as u32)
            }
        }
    }

    fn color(&mut self, color: &Color) -> Parameter {
        match color {
            Color::Constant([r, g, b]) => parameter([*r, *g, *b, 1.0], (0, 0, [1, 1]), 0.0, 0),
            Color::Mapped(m) => {
                let [r, g, b] = m.value;
                parameter([r, g, b, 1.0], self.source(&m.map, true), 0.0, 0)
            }
        }
    }

    fn finish(mut self) -> Vec<[u32; 2]> {
        if self.texels.is_empty() {
            self.texels.push([0; 2]);
        }
        debug_assert!((self.texels.len() as u64 * TEXEL) < u64::from(u32::MAX));
        self.texels
    }
}

fn parameter(
    value: [f32; 4],
    (source, texel_base, size): (u32, u32, [u32; 2]),
    offset: f32,
    channel: u32,
) -> Parameter {
    Parameter { value, source, texel_base, size, offset, channel, padding: [0; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_of_multiple_scattering_follows_the_fibres_unless_it_is_named() {
        let model = |text: &str| multiple_model(&Scene::parse(text, "test", &[]).expect("a scene"));
        let chiang = "[mesh]\nshape = \"pyramid\"\n[undercoat.fibre]\nmodel = \"chiang\"\n";
        assert_eq!(model("[mesh]\nshape = \"pyramid\""), MultipleModel::Similarity);
        assert_eq!(model(chiang), MultipleModel::Transport);
        assert_eq!(model(&chiang.replace("undercoat", "guard")), MultipleModel::Transport);
        assert_eq!(model(&chiang.replace("chiang", "medulla")), MultipleModel::Transport);
        // Hairs that are not drawn do not count.
        assert_eq!(model(&format!("{chiang}[render]\nfur = \"explicit\"")), MultipleModel::Similarity);
        assert_eq!(model(&format!("{chiang}[render.multiple]\nmodel = \"dual\"")), MultipleModel::Dual);
        assert_eq!(model(&format!("{chiang}[render]\nshading = \"paper\"")), MultipleModel::None);
    }

    #[test]
    fn noise_gradients_are_units_and_balanced() {
        let tables = noise_tables(7);
        let mut sum = [0.0f32; 3];
        for g in tables.gradients3 {
            let norm: f32 = g.iter().map(|x| x * x).sum();
            assert!((norm - 1.0).abs() < 1e-6);
            (0..3).for_each(|k| sum[k] += g[k]);
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-5), "{sum:?}");
    }
}
