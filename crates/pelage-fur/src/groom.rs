//! The groom, as the passes read it: values of the scene in the units and structs of the shaders.

mod lights;
mod map_packer;

use crate::fibre::Fibre;
use crate::layout::{Groom, Light, LightParameters, Noise, ObjectMaterial, UndercoatParameters};
use crate::simplex::noise_tables;
use glam::Vec3;
use lights::pack_lights;
use map_packer::MapPacker;
use pelage_core::scene::{
    Blend, FibreModel, FibreSpec, FurLayers, MultipleModel, NoiseDomain, Scalar, Scene, Shading,
    ShellLighting,
};
use pelage_core::{Result, World};

/// Words of the scattered light at a node of the optical-depth lattice, after the optical depths:
/// mean radiance from above and from below.
pub const SCATTERED_WORDS: u32 = 3;

/// The groom, packed for upload.
pub struct PackedGroom {
    /// Parameters, and settings of the guard hairs.
    pub groom: Groom,
    /// Texels of all maps, four halves each, followed by the scattering tables of both fibres.
    pub texels: Vec<[u32; 2]>,
    /// Materials of the objects, in the order of the scene.
    pub objects: Vec<ObjectMaterial>,
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
    /// All lights, padded to [`MAX_LIGHTS`](crate::layout::MAX_LIGHTS).
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

/// Height of the prism shell as a parameter: that of the undercoat. Without an undercoat the shell
/// still carries the optical-depth lattice of the guard hairs.
fn shell_height(scene: &Scene) -> Scalar {
    if has_undercoat(scene) {
        scene.undercoat.height.clone()
    } else {
        Scalar::Constant(0.5 * scene.guard.length.max().max(0.02))
    }
}

/// Packs the parameters, the settings of the guard hairs, the texels of all maps, and the materials
/// of the objects. `height` is
/// the parameter [`UndercoatHeight`](crate::parameters::Parameter::UndercoatHeight).
pub fn pack_parameters(world: &World, height: &Scalar) -> (Groom, Vec<[u32; 2]>, Vec<ObjectMaterial>) {
    let scene = &world.scene;
    let mut maps = MapPacker::new(&world.maps, world.skin.corner_uv.is_some());
    let (guard, undercoat) = (&scene.guard, &scene.undercoat);
    let groom = Groom {
        parameters: [
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
            maps.scalar(height),
            maps.color(&undercoat.color_root),
            maps.color(&undercoat.color_tip),
            maps.color(&scene.base.color),
            maps.color(&scene.shells.color),
            maps.scalar(&scene.shells.length),
        ],
        comb_direction: Vec3::from(guard.comb_direction).normalize_or_zero().into(),
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
        paper: u32::from(scene.render.shading == Shading::Paper),
        padding: 0,
    };
    let objects = world.objects.iter().map(|object| {
        let material = &object.material;
        ObjectMaterial {
            color: maps.color_on(&material.color, object.surface.corner_uv.is_some()),
            roughness: material.roughness,
            metallic: material.metallic,
            clearcoat: material.clearcoat,
            clearcoat_roughness: material.clearcoat_roughness,
            shadow_catcher: u32::from(object.shadow_catcher),
            padding: [0; 3],
        }
    });
    let objects = objects.collect();
    (groom, maps.finish(), objects)
}

/// Packs the groom of `world`.
pub fn pack(world: &World) -> Result<PackedGroom> {
    let scene = &world.scene;
    let undercoat = &scene.undercoat;
    let shell_height = shell_height(scene);
    let (groom, mut texels, objects) = pack_parameters(world, &shell_height);
    let multiple = multiple_model(scene);
    let comb = Vec3::from(groom.comb_direction);
    let extinction =
        if has_undercoat(scene) { undercoat.density.max() * undercoat.diameter[0] * 1e-4 } else { 0.0 };
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
        isotropic: groom.paper,
        opacity_cut: 0.001,
        virtual_fragments: match scene.render.blend {
            Blend::Virtual => scene.render.virtual_fragments.max(1),
            Blend::Simplified | Blend::Exact => 0,
        },
        density: undercoat.density.max().max(1e-6),
        attenuation: scene.render.simplified_attenuation,
    };
    let (guard_fibre, undercoat_fibre) = (Fibre::guard(scene), Fibre::undercoat(scene));
    let table_bases = [&guard_fibre, &undercoat_fibre].map(|fibre| {
        let base = texels.len() as u32;
        texels.extend(fibre.texels());
        base
    });
    let (light_parameters, lights) = pack_lights(world);
    Ok(PackedGroom {
        groom,
        texels,
        objects,
        table_bases,
        undercoat,
        guard_fibre,
        undercoat_fibre,
        noise: noise_tables(scene.render.seed),
        lights,
        light_parameters,
    })
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
}
