//! All structs that Rust and WGSL share, declared once; a test compares them with naga's
//! reflection.
//!
//! Fields have the names and the order of those in the WGSL struct of the same name.

use bytemuck::{Pod, Zeroable};

/// Largest number of directional lights.
pub const MAX_LIGHTS: usize = pelage_core::light::MAX_LIGHTS;
/// Largest number of objects: their materials are a uniform of at most 64 KiB.
pub const MAX_OBJECTS: usize = pelage_core::scene::MAX_OBJECTS;

/// Parameters that maps may vary.
pub const PARAMETERS: usize = 17;
/// Largest number of coats: the scene's own and those of its parts.
pub const MAX_COATS: usize = 16;

/// Words of a node of the fragment lists (`shared/oit.wgsl`): link, depth, kind and id, colour.
pub const NODE_WORDS: u32 = 5;
/// Further words of a node with features: albedo, tangent.
pub const NODE_FEATURE_WORDS: u32 = 2;
/// Words of a record of the skin under a sample (`shared/base.wgsl`): depth, radiance, normal.
pub const BASE_WORDS: u32 = 4;
/// Words of a sample of the film (`shared/film_sample.wgsl`).
pub const SAMPLE_WORDS: u32 = 8;
/// Further words of a sample with features: albedo, normal, tangent, coverages.
pub const SAMPLE_FEATURE_WORDS: u32 = 8;

macro_rules! shared {
    ($($(#[$doc:meta])* struct $name:ident { $($field:ident: $ty:ty),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
            #[allow(missing_docs)]
            pub struct $name { $(pub $field: $ty),* }

            impl $name {
                /// Field names and byte offsets, to compare with WGSL.
                pub const FIELDS: &'static [(&'static str, usize)] =
                    &[$((stringify!($field), std::mem::offset_of!($name, $field))),*];
            }
        )*
        /// All shared structs: name, size in bytes, fields.
        pub const STRUCTS: &[(&str, usize, &[(&str, usize)])] =
            &[$((stringify!($name), std::mem::size_of::<$name>(), $name::FIELDS)),*];
    };
}

shared! {
    /// `shared/frame.wgsl`
    struct Frame {
        eye: [f32; 3],
        near: f32,
        right: [f32; 3],
        tan_x: f32,
        up: [f32; 3],
        tan_y: f32,
        forward: [f32; 3],
        seed: u32,
        film_size: [f32; 2],
        jitter: [f32; 2],
        lens_shear: [f32; 2],
        tile_origin: [i32; 2],
        tile_size: [u32; 2],
        flags: u32,
        node_capacity: u32,
    }
    /// `shared/shell_types.wgsl`
    struct ShellVertex {
        position: [f32; 3],
        height: f32,
        normal: [f32; 3],
        color: u32,
    }
    /// `shared/shell_types.wgsl`
    struct Prism {
        vertices: [u32; 3],
        cell_base: u32,
        neighbours: [u32; 3],
        subdivision: u32,
        edges: [u32; 3],
        object: u32,
    }
    /// `shared/undercoat_types.wgsl`: derived from the scene.
    struct UndercoatParameters {
        layers: u32,
        noise_domain: u32,
        seed: u32,
        extinction: f32,
        diameter_ratio: f32,
        noise_frequency: f32,
        noise_contrast: f32,
        height_variation: f32,
        height_frequency: f32,
        uv_jitter: f32,
        tangent_jitter: f32,
        jitter_exponent: f32,
        step: f32,
        light_step: f32,
        height: f32,
        isotropic: u32,
        lean: [f32; 3],
        forward_scattering: f32,
        opacity_cut: f32,
        virtual_fragments: u32,
        density: f32,
        attenuation: f32,
        origin: [f32; 3],
        padding: u32,
    }
    /// `shared/undercoat_types.wgsl`: derived from the skin and the memory budget.
    struct LatticeParameters {
        cells: u32,
        levels: u32,
        reach: f32,
        columns: u32,
        vertices: u32,
        edges: u32,
        tau_stride: u32,
        padding: u32,
    }
    /// `shared/undercoat_types.wgsl`: derived from the lights.
    struct LightParameters {
        count: u32,
        keys: u32,
        key_lights: [u32; 2],
        key_direction: [[f32; 4]; 2],
        key_irradiance: [[f32; 4]; 2],
    }
    /// `shared/undercoat_types.wgsl`
    struct FurParameters {
        undercoat: UndercoatParameters,
        lattice: LatticeParameters,
        lights: LightParameters,
    }
    /// `shared/noise.wgsl`
    struct Noise {
        permutation: [[u32; 4]; 16],
        gradients2: [[f32; 4]; 8],
        gradients3: [[f32; 4]; 32],
    }
    /// `shared/groom_types.wgsl`
    struct Parameter {
        value: [f32; 4],
        source: u32,
        texel_base: u32,
        size: [u32; 2],
        offset: f32,
        channel: u32,
        padding: [u32; 2],
    }
    /// `shared/groom_types.wgsl`
    struct GuardHairs {
        comb_direction: [f32; 3],
        widest: f32,
        diameter: [f32; 3],
        spread: f32,
        color_transition: [f32; 2],
        color_variation: f32,
        length_variation: f32,
        gravity: f32,
        clump_density: f32,
        curl_frequency: f32,
        frizz_frequency: f32,
        root_darkening: [f32; 2],
        opacity: f32,
        tip_fade: f32,
    }
    /// `shared/groom_types.wgsl`
    struct Coat {
        parameters: [Parameter; PARAMETERS],
        hairs: GuardHairs,
        lane: u32,
        bare: u32,
        padding: [u32; 2],
    }
    /// `shared/groom_types.wgsl`
    struct Groom {
        segments: u32,
        seed: u32,
        paper: u32,
        coverage_base: u32,
        coverage_texels: u32,
        vertex_rows: u32,
        count: u32,
        padding: u32,
        origin: [f32; 3],
        more_padding: u32,
        coats: [Coat; MAX_COATS],
    }
    /// `shared/lights.wgsl`
    struct Light {
        direction: [f32; 3],
        undercoat: u32,
        irradiance: [f32; 3],
        spread: f32,
    }
    /// `objects.wgsl`
    struct ObjectMaterial {
        color: Parameter,
        roughness: f32,
        metallic: f32,
        clearcoat: f32,
        clearcoat_roughness: f32,
        origin: [f32; 3],
        shadow_catcher: u32,
    }
    /// `shared/fur_grid.wgsl`
    struct FurGrid {
        low: [f32; 3],
        cell: f32,
        size: [u32; 3],
        padding: u32,
    }
    /// `shared/fibre.wgsl`
    struct Fibre {
        intensity: [f32; 3],
        diffuse: f32,
        shift: [f32; 3],
        azimuth_tt: f32,
        width: [f32; 3],
        glint: f32,
        glint_width: f32,
        specular: f32,
        specular_exponent: f32,
        divisor: f32,
        absorption: [f32; 3],
        table_base: u32,
        variance: [f32; 4],
        turn_sin: [f32; 4],
        turn_cos: [f32; 4],
        table_size: [u32; 3],
        padding: u32,
    }
    /// `shared/column.wgsl`
    struct Column {
        prism: u32,
        grid: u32,
        area: f32,
        density: f32,
        color_root: u32,
        color_tip: u32,
        color_base: u32,
        padding: u32,
        blocked: [u32; 2],
    }
    /// `shared/root_types.wgsl`
    struct Root {
        prism: u32,
        seed: u32,
        lambda: [f32; 2],
    }
    /// `shared/bvh.wgsl`
    struct BvhNode {
        low: [f32; 3],
        first: u32,
        high: [f32; 3],
        count: u32,
    }
    /// `film.wgsl`
    struct Reconstruction {
        origin: [i32; 2],
        pixels: [u32; 2],
        grid: u32,
        reach: i32,
        taps: u32,
        planes: u32,
        accumulate: u32,
        scale: f32,
        objects: u32,
        padding: u32,
        weights: [[f32; 4]; 32],
    }
    /// `shared/shellfin_types.wgsl`
    struct Shellfin {
        comb: [f32; 3],
        shells: u32,
        bend: [f32; 3],
        fin_rows: u32,
        shadow_direction: [f32; 3],
        lighting: u32,
        torus: [f32; 2],
        fin_length: f32,
        height: f32,
        fade: u32,
        fin_threshold: f32,
        slanted: u32,
        shadow_offset: f32,
        shadow_strength: f32,
        vertices: u32,
        brushes: u32,
        curved: u32,
        spread: f32,
        guard: u32,
        edge_fade: f32,
        first_corner: u32,
    }
    /// `shared/shellfin_types.wgsl`
    struct ShellRow {
        height: f32,
        fine: u32,
        coarse: u32,
        blend: f32,
        undercoat: [f32; 3],
        shade: f32,
        guard: [f32; 3],
        jitter: f32,
        coverage: f32,
        share: f32,
        padding: [u32; 2],
    }
    /// `shellfin_rows.wgsl`
    struct Brush {
        center: [f32; 3],
        radius: f32,
        direction: [f32; 3],
        padding: u32,
        tint: [f32; 3],
        more_padding: u32,
    }
    /// `shellfin_raster.wgsl`
    struct FurCorner {
        vertex: u32,
        patch_index: u32,
        uv: [f32; 2],
        skin_uv: [f32; 2],
    }
    /// `shellfin_raster.wgsl`
    struct FinEdge {
        a: u32,
        b: u32,
        opposite: [u32; 2],
    }
    /// `shared/root_types.wgsl`: the strands that a dispatch works on.
    struct StrandBatch {
        strands: u32,
    }
    /// `hair_roots.wgsl`: a range of triangles, the largest density (hairs/cm²) and the seed of the
    /// rendering.
    struct RootRange {
        first: u32,
        count: u32,
        density: f32,
        seed: u32,
        parts: u32,
        padding: u32,
        more_padding: [u32; 2],
    }
    /// `guard_bins.wgsl`: a grid of tiles, in samples.
    struct TileGrid {
        origin: [i32; 2],
        size: [u32; 2],
        grid: [u32; 2],
        margin: f32,
        length: f32,
    }
    /// `guard_raster.wgsl`: a range of the list of strands by tile.
    struct Bin {
        start: u32,
        strands: u32,
    }
    /// `edge_table.wgsl`
    struct EdgeCounts {
        edges: u32,
        mask: u32,
    }
    /// `shell_prisms.wgsl`
    struct ShellCounts {
        vertices: u32,
        triangles: u32,
    }
    /// `undercoat_density.wgsl`
    struct DensityCounts {
        triangles: u32,
    }
    /// `undercoat_light.wgsl`: the level of nodes that a dispatch works on.
    struct Sweep {
        level: u32,
    }
    /// `resolve.wgsl`: length of the sorted runs that a dispatch merges.
    struct SortRun {
        length: u32,
    }
    /// `shared/lights.wgsl`
    struct Lights {
        lights: [Light; MAX_LIGHTS],
    }
    /// `objects.wgsl`: the lights of a dispatch.
    struct LightBatch {
        first: u32,
        end: u32,
    }
    /// `objects.wgsl`
    struct ObjectMaterials {
        materials: [ObjectMaterial; MAX_OBJECTS],
    }
    /// `shellfin_rows.wgsl`
    struct LightingTable {
        values: [[f32; 4]; 256],
    }
}
