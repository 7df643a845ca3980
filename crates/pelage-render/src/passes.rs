//! The passes. Each has a stem, which names this module's file, the WGSL shader, the CPU twin and
//! the test.
//!
//! `record` methods list the names that must be in scope when they are called, that is the bindings
//! of the kernels that the method does not create itself.
//!
//! | step of the paper | passes |
//! |---|---|
//! | 1 roots and shell | [`edge_table`], [`shell_prisms`], [`hair_roots`] |
//! | 2 volume data and its light | [`undercoat_density`], [`shell_lattice`], [`guard_splat`], [`light_occlusion`], [`undercoat_light`], [`undercoat_source`] |
//! | 3 strands | [`guard_strands`], [`guard_shade`] |
//! | 4 base mesh | [`base_raster`], [`objects`] |
//! | 5 shell | [`shell_entry`], [`undercoat_march`] |
//! | 6 strands | [`guard_bins`], [`guard_raster`] |
//! | 7 blending | [`resolve`], [`film`] |

pub mod base_raster;
pub mod edge_table;
pub mod film;
pub mod guard_bins;
pub mod guard_raster;
pub mod guard_shade;
pub mod guard_splat;
pub mod guard_strands;
pub mod hair_roots;
pub mod light_occlusion;
pub mod objects;
pub mod resolve;
pub mod shell_entry;
pub mod shell_lattice;
pub mod shell_prisms;
pub mod undercoat_density;
pub mod undercoat_light;
pub mod undercoat_march;
pub mod undercoat_source;

use pelage_core::Result;
use pelage_fur::fibre::MODELS;
use pelage_fur::layout::MAX_COATS;
use pelage_gpu::Gpu;
use std::sync::Arc;

/// What the passes are compiled for: values of the shaders' `override` constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Variant {
    /// Whether densities are stored or evaluated while marching.
    pub stored: bool,
    /// Whether optical depths towards key lights are found by a nested march at every step instead
    /// of by lookup.
    pub nested: bool,
    /// Fibre model of the guard hairs, see [`pelage_fur::fibre::Fibre::number`].
    pub guard: u32,
    /// Fibre model of the undercoat.
    pub undercoat: u32,
    /// Multiple scattering: 0 none or similarity, 1 dual scattering, 2 transport.
    pub multiple: u32,
    /// Coats: the scene's own and those of its parts; 0 counts as 1.
    pub coats: u32,
    /// Whether albedo, normal, tangent and coverages are made.
    pub features: bool,
}

impl Variant {
    /// Number of variants.
    pub const COUNT: usize = 24 * (MODELS * MODELS) as usize * MAX_COATS;

    /// Number of the variant, below [`Variant::COUNT`].
    pub fn index(self) -> usize {
        let models = self.guard.min(MODELS - 1) * MODELS + self.undercoat.min(MODELS - 1);
        usize::from(self.stored)
            + 2 * usize::from(self.nested)
            + 4 * usize::from(self.features)
            + 8 * (models * 3 + self.multiple.min(2)) as usize
            + Self::COUNT / MAX_COATS * (self.coats.clamp(1, MAX_COATS as u32) - 1) as usize
    }

    /// The constants of the kernels that march the undercoat.
    fn constants(self) -> [(&'static str, f64); 4] {
        [
            ("STORED", f64::from(u8::from(self.stored))),
            ("NESTED", f64::from(u8::from(self.nested))),
            self.undercoat(),
            self.features(),
        ]
    }

    /// The constant that selects the model of multiple scattering.
    fn multiple(self) -> (&'static str, f64) {
        ("MULTIPLE", f64::from(self.multiple))
    }

    /// The constant that bounds the coats in kernels that evaluate parameters of the groom.
    pub fn coats(self) -> (&'static str, f64) {
        ("COATS", f64::from(self.coats.max(1)))
    }

    /// The constant that selects whether features are made.
    fn features(self) -> (&'static str, f64) {
        ("FEATURES", f64::from(u8::from(self.features)))
    }

    /// The constant that selects the fibre model of the guard hairs.
    pub fn guard(self) -> (&'static str, f64) {
        ("GUARD_MODEL", f64::from(self.guard))
    }

    /// The constant that selects the fibre model of the undercoat.
    pub fn undercoat(self) -> (&'static str, f64) {
        ("UNDERCOAT_MODEL", f64::from(self.undercoat))
    }
}

/// All passes, compiled.
pub struct Passes {
    /// `base_raster`
    pub base_raster: base_raster::BaseRaster,
    /// `edge_table`
    pub edge_table: edge_table::EdgeTable,
    /// `film`
    pub film: film::Film,
    /// `guard_bins`
    pub guard_bins: guard_bins::GuardBins,
    /// `guard_raster`
    pub guard_raster: guard_raster::GuardRaster,
    /// `guard_shade`
    pub guard_shade: guard_shade::GuardShade,
    /// `guard_splat`
    pub guard_splat: guard_splat::GuardSplat,
    /// `guard_strands`
    pub guard_strands: guard_strands::GuardStrands,
    /// `hair_roots`
    pub hair_roots: hair_roots::HairRoots,
    /// `light_occlusion`
    pub light_occlusion: light_occlusion::LightOcclusion,
    /// `resolve`
    pub resolve: resolve::Resolve,
    /// `shell_entry`
    pub shell_entry: shell_entry::ShellEntry,
    /// `shell_lattice`
    pub shell_lattice: shell_lattice::ShellLattice,
    /// `shell_prisms`
    pub shell_prisms: shell_prisms::ShellPrisms,
    /// `undercoat_density`
    pub undercoat_density: undercoat_density::UndercoatDensity,
    /// `undercoat_light`
    pub undercoat_light: undercoat_light::UndercoatLight,
    /// `undercoat_march`
    pub undercoat_march: undercoat_march::UndercoatMarch,
    /// `undercoat_source`
    pub undercoat_source: undercoat_source::UndercoatSource,
}

impl Passes {
    /// All kernels of a variant; compiled at the first call and kept with the device.
    ///
    /// # Errors
    /// As [`Passes::new`].
    pub fn of(gpu: &Gpu, variant: Variant) -> Result<Arc<Self>> {
        gpu.keep(variant.index(), || Self::new(gpu, variant))
    }

    /// Compiles all kernels of a variant.
    ///
    /// # Errors
    /// [`pelage_core::Error::Gpu`] with file and line of a fault in a shader.
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self> {
        Ok(Self {
            base_raster: base_raster::BaseRaster::new(gpu, variant)?,
            edge_table: edge_table::EdgeTable::new(gpu)?,
            film: film::Film::new(gpu, variant)?,
            guard_bins: guard_bins::GuardBins::new(gpu)?,
            guard_raster: guard_raster::GuardRaster::new(gpu, variant)?,
            guard_shade: guard_shade::GuardShade::new(gpu, variant)?,
            guard_splat: guard_splat::GuardSplat::new(gpu)?,
            guard_strands: guard_strands::GuardStrands::new(gpu, variant)?,
            hair_roots: hair_roots::HairRoots::new(gpu, variant)?,
            light_occlusion: light_occlusion::LightOcclusion::new(gpu)?,
            resolve: resolve::Resolve::new(gpu, variant)?,
            shell_entry: shell_entry::ShellEntry::new(gpu, variant)?,
            shell_lattice: shell_lattice::ShellLattice::new(gpu, variant)?,
            shell_prisms: shell_prisms::ShellPrisms::new(gpu, variant)?,
            undercoat_density: undercoat_density::UndercoatDensity::new(gpu)?,
            undercoat_light: undercoat_light::UndercoatLight::new(gpu)?,
            undercoat_march: undercoat_march::UndercoatMarch::new(gpu, variant)?,
            undercoat_source: undercoat_source::UndercoatSource::new(gpu, variant)?,
        })
    }
}

/// The row of the paper's Table 1 to which a pass belongs; 7 for resolve, film and unknown stems.
pub fn step_of(stem: &str) -> u32 {
    match stem {
        "edge_table" | "shell_prisms" | "hair_roots" => 1,
        "undercoat_density" | "shell_lattice" | "guard_splat" | "light_occlusion" | "undercoat_light"
        | "undercoat_source" => 2,
        "guard_strands" | "guard_shade" | "shellfin_rows" => 3,
        "shell_entry" | "undercoat_march" | "shellfin_raster" => 4,
        "base_raster" | "objects" => 5,
        "guard_bins" | "guard_raster" => 6,
        _ => 7,
    }
}

/// Names of the rows of the paper's Table 1.
// [Andersen2016] table 1
pub const STEP_NAMES: [&str; 7] = [
    "Process base mesh",
    "Prism volume densities and light",
    "Generate explicit strands",
    "Rasterize shell volume",
    "Rasterize base mesh",
    "Rasterize explicit fur",
    "OIT post-processing",
];
