//! The groom, as the passes read it: values of the scene in the units and structs of the shaders.

mod coats;
mod coverage;
mod lights;
mod map_packer;

use crate::fibre::Fibre;
use crate::layout::{
    self, Groom, Light, LightParameters, MAX_COATS, Noise, ObjectMaterial, UndercoatParameters,
};
use crate::parameters::NO_LANE;
use crate::simplex::noise_tables;
use bytemuck::Zeroable;
use coverage::Coverage;
use glam::Vec3;
use lights::pack_lights;
use map_packer::MapPacker;
use pelage_core::scene::{
    Blend, Coat, FibreModel, FibreSpec, FurLayers, MultipleModel, NoiseDomain, Scene, Shading, ShellLighting,
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
        && guard_density(scene) > 0.0
}

/// Whether the undercoat, or at least its shadow, is rendered.
pub fn has_undercoat(scene: &Scene) -> bool {
    (matches!(scene.render.fur, FurLayers::Implicit | FurLayers::Hybrid) || lit_shells(scene))
        && scene.coats().any(|coat| coat.undercoat.density.max() > 0.0 && coat.undercoat.height.max() > 0.0)
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

/// Largest density of the guard hairs in all coats, hairs/cm².
pub fn guard_density(scene: &Scene) -> f32 {
    scene.largest(|coat| coat.guard.density.max())
}

/// Largest length of the guard hairs in all coats, cm.
pub fn guard_length(scene: &Scene) -> f32 {
    scene.largest(|coat| coat.guard.length.max())
}

/// Largest density of the undercoat in all coats, hairs/cm² of the diameter of the scene's own.
pub fn undercoat_density(scene: &Scene) -> f32 {
    scene.largest(|coat| coat.undercoat.density.max() * relative_diameter(scene, coat))
}

/// Diameter of a coat's undercoat at the root relative to the scene's own. All of the undercoat has
/// the diameter of the latter; as much more or less of it blocks as much light.
fn relative_diameter(scene: &Scene, coat: &Coat<'_>) -> f32 {
    match (coat.undercoat.diameter[0], scene.undercoat.diameter[0]) {
        (of_coat, own) if of_coat == own => 1.0,
        (of_coat, own) => of_coat / own.max(1e-6),
    }
}

/// Height of the prism shell where there is no undercoat, cm: the shell then carries the
/// optical-depth lattice of the guard hairs alone. `None` where it is the undercoat's.
fn bare_height(scene: &Scene) -> Option<f32> {
    (!has_undercoat(scene)).then(|| 0.5 * guard_length(scene).max(0.02))
}

/// Packs the parameters, the settings of the guard hairs, the texels of all maps, and the materials
/// of the objects. `height` is
/// [`UndercoatHeight`](crate::parameters::Parameter::UndercoatHeight) of all coats, cm, by default
/// the height of each coat's undercoat.
pub fn pack_parameters(world: &World, height: Option<f32>) -> (Groom, Vec<[u32; 2]>, Vec<ObjectMaterial>) {
    let scene = &world.scene;
    let mut maps = MapPacker::new(&world.maps, world.skin.corner_uv.is_some());
    let mut coats = vec![coats::own(scene, &mut maps, height)];
    let mut lanes = 0..;
    for part in scene.parts.iter().take(MAX_COATS - 1) {
        let lane = if part.has_region() { lanes.next() } else { None };
        coats.push(coats::of_part(scene, part, &mut maps, height, lane.unwrap_or(NO_LANE)));
    }
    let count = coats.len() as u32;
    coats.resize(MAX_COATS, layout::Coat::zeroed());
    let coverage = Coverage::new(scene, &world.skin);
    let objects = world.objects.iter().map(|object| {
        let material = &object.material;
        ObjectMaterial {
            color: maps.color_on(&material.color, object.surface.corner_uv.is_some()),
            roughness: material.roughness,
            metallic: material.metallic,
            clearcoat: material.clearcoat,
            clearcoat_roughness: material.clearcoat_roughness,
            origin: object.origin,
            shadow_catcher: u32::from(object.shadow_catcher),
        }
    });
    let objects = objects.collect();
    let mut texels = maps.finish();
    let coverage_base = texels.len() as u32;
    texels.extend(coverage.texels());
    let groom = Groom {
        segments: scene.coats().map(|coat| coat.guard.segments).max().unwrap_or(1),
        seed: scene.render.seed,
        paper: u32::from(scene.render.shading == Shading::Paper),
        coverage_base,
        coverage_texels: coverage.texels_of_row(),
        vertex_rows: 3 * world.skin.triangles.len() as u32,
        count,
        padding: 0,
        origin: scene.mesh.translate,
        more_padding: 0,
        coats: std::array::from_fn(|i| coats[i]),
    };
    (groom, texels, objects)
}

/// Packs the groom of `world`.
pub fn pack(world: &World) -> Result<PackedGroom> {
    let scene = &world.scene;
    let undercoat = &scene.undercoat;
    let bare_height = bare_height(scene);
    let (groom, mut texels, objects) = pack_parameters(world, bare_height);
    let multiple = multiple_model(scene);
    let comb = Vec3::from(groom.coats[0].hairs.comb_direction);
    let density = undercoat_density(scene);
    let extinction = if has_undercoat(scene) { density * undercoat.diameter[0] * 1e-4 } else { 0.0 };
    let height = bare_height.unwrap_or_else(|| scene.largest(|coat| coat.undercoat.height.max()));
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
        density: density.max(1e-6),
        attenuation: scene.render.simplified_attenuation,
        origin: scene.mesh.translate,
        padding: 0,
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
