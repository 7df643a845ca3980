//! Default values of the scene file: a neutral brown fur on a plain film.

use super::model::*;

impl Default for Camera {
    fn default() -> Self {
        Self {
            frame: Framing::Given,
            view: None,
            eye: [0.0, 6.0, 30.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov: 30.0,
            near: 0.1,
            lens: None,
        }
    }
}

impl Default for Lens {
    fn default() -> Self {
        Self { aperture: 0.2, focus: None, method: LensMethod::Samples }
    }
}

impl Default for DirectionalLight {
    fn default() -> Self {
        Self { direction: [0.4, 0.8, 0.5], irradiance: [3.0; 3] }
    }
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            map: String::new(),
            layer: String::new(),
            projection: None,
            lights: 16,
            intensity: 1.0,
            tint: [1.0; 3],
            rotate: 0.0,
            undercoat: true,
            visible: true,
        }
    }
}

impl Default for BaseMaterial {
    fn default() -> Self {
        Self { color: [0.30, 0.22, 0.17].into() }
    }
}

impl Default for Guard {
    fn default() -> Self {
        Self {
            density: 300.0.into(),
            length: 2.0.into(),
            length_variation: 0.3,
            diameter: [45.0, 90.0, 10.0],
            widest: 0.6,
            thickness: 1.0.into(),
            segments: 8,
            gravity: 0.15,
            comb_direction: [0.0; 3],
            comb: 0.0.into(),
            spread: 10.0,
            clump: 0.1.into(),
            clump_density: 25.0,
            curl: 0.0.into(),
            curl_frequency: 0.5,
            frizz: 0.01.into(),
            frizz_frequency: 2.0,
            color_root: [0.26, 0.17, 0.11].into(),
            color_tip: [0.42, 0.30, 0.20].into(),
            color_transition: [0.5, 0.6],
            color_variation: 0.25,
            opacity: 1.0,
            tip_fade: 0.0,
            fibre: FibreSpec::default(),
            root_darkening: [0.85, 0.25],
        }
    }
}

impl Default for Undercoat {
    fn default() -> Self {
        Self {
            density: 20_000.0.into(),
            diameter: [14.0, 8.0],
            height: 1.1.into(),
            layers: 24,
            subdivision: None,
            cell: 0.03,
            noise_domain: NoiseDomain::Object,
            noise_frequency: 7.0,
            noise_contrast: 0.7,
            height_variation: 0.35,
            height_frequency: 2.5,
            uv_jitter: 0.05,
            tangent_jitter: 0.4,
            jitter_exponent: 1.5,
            lean: 0.0,
            color_root: [0.42, 0.30, 0.22].into(),
            color_tip: [0.62, 0.47, 0.34].into(),
            fibre: FibreSpec::default(),
            forward_scattering: 0.6,
            storage: Storage::Auto,
            step: 0.9,
        }
    }
}

impl Default for FilmSpec {
    fn default() -> Self {
        Self {
            width: 640,
            height: 400,
            spp: 4,
            filter: Filter::Gaussian,
            filter_radius: None,
            background: Background::Color,
            background_color: [0.75, 0.79, 0.86],
            plate: String::new(),
            exposure: 0.0,
            tonemap: Tonemap::Neutral,
            color_space: OutputSpace::default(),
        }
    }
}

impl Default for RenderSpec {
    fn default() -> Self {
        Self {
            fur: FurLayers::Hybrid,
            blend: Blend::Exact,
            virtual_fragments: 30,
            simplified_attenuation: 4.0,
            shading: Shading::Physical,
            multiple: MultipleScattering::default(),
            light: LightLookup::Lattice,
            seed: 0,
            tile: None,
            memory: 1 << 30,
        }
    }
}

impl Default for MultipleScattering {
    fn default() -> Self {
        Self { model: MultipleModel::default(), forward: true, backward: true, density: [0.7; 2] }
    }
}
