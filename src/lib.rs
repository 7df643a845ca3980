//! pelage renders hybrid fur: guard hairs as strands and undercoat as a ray-marched volume in a
//! shell over the skin, blended per sample so that each attenuates the other. The method is that of
//! Andersen et al. 2016; deviations from it are marked in the source.
//!
//! # Data flow
//!
//! A scene file becomes a [`Scene`]: plain values, with preset, includes and overrides merged. All
//! faults of the file are reported at once. The files that the scene names are loaded into a
//! [`World`]: the mesh, repaired, scaled and smoothed, as a [`Skin`]; the lights, including those
//! that replace an environment map; and the groom's maps.
//!
//! [`render::render()`] opens an adapter, uploads the groom, and prepares all that does not depend
//! on the tile: the prism shell, the undercoat's densities, the optical-depth lattice and, if they
//! fit the memory budget, the shaded strands. The remaining passes run once per tile: the nearest
//! triangles of the skin, the entries of rays into the shell, the fragments of strands, and the
//! resolve pass, which sorts the fragments of a sample and marches the undercoat between them. A
//! reconstruction filter turns samples into pixels.
//!
//! The result is a [`film::Film`] of named, premultiplied planes. Depth of field and background are
//! applied to it, and [`film::io`] writes it as EXR or PNG, whole or not at all. [`render::Stats`]
//! has counts and times in the rows of the paper's Table 1.
//!
//! # An image in a few calls
//!
//! ```no_run
//! use pelage::{Scene, World, film, render};
//! use std::path::Path;
//!
//! # fn main() -> pelage::Result<()> {
//! let (scene, assets) = Scene::load(Path::new("scenes/hat.toml"), &["film.spp=1".into()])?;
//! let world = World::load(scene, &assets)?;
//! let mut frame = render::render(&world, &render::RenderOptions::default())?;
//! film::composite::over_background(&mut frame.film, &world.scene, &assets)?;
//! film::io::write(&frame.film, "hat.png", &film::Metadata::of_program(), &world.scene.film)?;
//! println!("{} strands in {:.1} s", frame.stats.strands, frame.stats.total_ms / 1000.0);
//! # Ok(())
//! # }
//! ```
//!
//! A world can be loaded without a GPU:
//!
//! ```
//! use pelage::{Scene, World, assets::Assets};
//!
//! let text = "preset = 'rabbit'\n[mesh]\nshape = 'sphere'";
//! let scene = Scene::parse(text, "ball.toml", &["mesh.size=2".into()])?;
//! let world = World::load(scene, &Assets::default())?;
//! let hairs = world.skin.area() * f64::from(world.scene.guard.density.max());
//! assert!((world.skin.area() - 4.0 * std::f64::consts::PI).abs() < 0.2);
//! assert!(hairs > 100.0);
//! # Ok::<(), pelage::Error>(())
//! ```
//!
//! All faults of a scene file are reported together, each with file and line:
//!
//! ```
//! let text = "[mesh]\nshape = 'sphear'\n[film]\nspp = 0";
//! let fault = pelage::Scene::parse(text, "ball.toml", &[]).unwrap_err();
//! assert_eq!(fault.exit_code(), 3);
//! let text = fault.to_string();
//! assert!(text.contains("ball.toml:2:") && text.contains("did you mean"), "{text}");
//! assert!(text.contains("ball.toml:4:"), "{text}");
//! ```
//!
//! # Modules
//!
//! | module | holds |
//! |---|---|
//! | [`scene`], [`assets`] | scene files; search paths for the files that they name |
//! | [`render`], [`film`] | rendering; images, their files, background and depth of field |
//! | [`reference`](mod@reference) | the ground truth: every hair a strand, path traced on the CPU |
//! | [`shells`] | lapped patches, and baked textures for shells and fins |
//! | [`fibre`] | scattering of light by single hairs |
//! | [`export`], [`compare`](mod@compare) | scenes and hair for other renderers; metrics of images |
//!
//! The crates `pelage-core`, `pelage-fur` and so on are internal: their interfaces change without
//! notice. The items listed here are the stable interface. `ARCHITECTURE.md` in the repository
//! describes how the crates depend on each other.

pub use pelage_core::{Error, Result, Scene, SceneFault, Skin, World};

/// Scene files: their values, overrides, and JSON schema.
pub mod scene {
    pub use pelage_core::scene::{
        Animation, Background, BakeSource, Blend, Camera, Color, FieldSource, FilmSpec, Framing, FurLayers,
        OutputSpace, Override, Projection, Scalar, Storage, Tonemap, Units, UpAxis, json_schema, template,
    };
}

/// Search paths for the files that a scene names.
pub mod assets {
    pub use pelage_core::assets::Assets;
}

/// Images of named planes, their files, tone mapping, background and depth of field.
pub mod film {
    pub use pelage_core::film::{
        Film, Metadata, Plane, composite, cryptomatte, depth_of_field, io, tev, tonemap,
    };
}

/// Rendering of a [`World`]: hybrid fur, or shells and fins if the scene asks for
/// them.
pub mod render {
    pub use pelage_core::animation;
    pub use pelage_core::hair::HairFile;
    pub use pelage_core::stats::{PassTime, Stats, Step};
    pub use pelage_gpu::{AdapterSummary, Gpu, list_adapters};
    pub use pelage_render::mattes;
    pub use pelage_render::strands::strands;
    pub use pelage_render::{Frame, Progress, RenderOptions, open};
    pub use pelage_shells::{render, render_on, render_with};
}

/// The ground truth: every hair a strand, path traced on the CPU.
pub mod reference {
    pub use pelage_pathtrace::grow::{Estimate, GrowOptions, Patch, estimate, grow};
    pub use pelage_pathtrace::strands::{Hair, Strands};
    pub use pelage_pathtrace::{Identity, Integrator, LightModel, Options, Outcome, Progress, render};
}

/// Lapped patches over a skin, and textures for shells and fins baked from a groom.
pub mod shells {
    pub use pelage_shells::bake::{
        Content, Format, FurTextures, MANIFEST, ManifestFile, Texture, WriteOptions, bake, check_folder,
        gltf, load, load_manifest, mips::Keep, write,
    };
    pub use pelage_shells::lapped::{
        Lapped, Patch, Statistics, field_picture, lap, patch_picture, write_obj,
    };
}

/// Scattering of light by single hairs.
pub mod fibre {
    pub use pelage_fur::Layer;
    pub use pelage_fur::fibre::{
        Absorption, Angles, Chiang, Fibre, Hit, KajiyaKay, Medulla, Sadeghi, Sample, offsets,
    };
}

/// Skin, hairs, camera, lights and materials for other renderers.
pub mod export {
    pub use pelage_core::mesh::write_obj;
    pub use pelage_export::{EnvironmentAs, Target, Written, check_folder, write};
}

/// Metrics of images, and error images.
pub mod compare {
    pub use pelage_studies::compare::{
        Comparison, ErrorImage, METRICS, Metric, Metrics, Options, Region, Sense, Thresholds, compare,
        compare_with, error_image, error_image_with,
    };
}
