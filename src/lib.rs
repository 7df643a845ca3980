//! pelage renders hybrid fur: guard hairs as strands, undercoat as a ray-marched volume in a shell over the skin, blended
//! per sample so that each attenuates the other. The method is that of Andersen et al. 2016; what departs from it is
//! marked where it does.
//!
//! # The way of the data
//!
//! A scene file becomes a [`Scene`] ([`scene`]): plain values, with preset, includes and overrides merged, all faults of
//! the file reported at once. What the scene names is loaded into a [`World`] ([`world`]): the mesh, repaired, scaled and
//! smoothed, as a [`Skin`] ([`mesh`], [`skin`]); lights, and environment maps turned into lights ([`light`]); the
//! groom's images ([`maps`]).
//!
//! [`render::render`] opens an adapter ([`gpu`]) and packs the groom into the structs of the shaders ([`groom`],
//! [`layout`]). [`prepare`] makes everything that does not depend on the view's tiles: the prism shell, the undercoat's
//! densities, the light lattice and, where they fit the memory budget, the shaded strands; else these are grown for each
//! tile. Then each tile goes through the last passes ([`passes`]): the skin's nearest triangles, the rays' entries into
//! the shell, the strands' fragments, and the resolve pass, which sorts the fragments of a sample and marches the
//! undercoat between them. A filter makes pixels of samples.
//!
//! The pixels are a [`Film`](film::Film) of named planes, premultiplied. Depth of field and background change it;
//! [`film::io`] writes it as EXR or PNG, whole or not at all ([`files`]). [`stats`] counts and times everything in the
//! rows of the paper's Table 1.
//!
//! # A picture in a few calls
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
//! Without a GPU there is still the world:
//!
//! ```
//! use pelage::{Scene, World, assets::Assets};
//!
//! let scene = Scene::parse("preset = 'rabbit'\n[mesh]\nshape = 'sphere'", "ball.toml", &["mesh.size=2".into()])?;
//! let world = World::load(scene, &Assets::default())?;
//! let hairs = world.skin.area() * f64::from(world.scene.guard.density.max());
//! assert!((world.skin.area() - 4.0 * std::f64::consts::PI).abs() < 0.2);
//! assert!(hairs > 100.0);
//! # Ok::<(), pelage::Error>(())
//! ```
//!
//! Faults come together, each with file and line:
//!
//! ```
//! let fault = pelage::Scene::parse("[mesh]\nshape = 'sphear'\n[film]\nspp = 0", "ball.toml", &[]).unwrap_err();
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
//! | [`scene`], [`assets`] | scene files; where the files they name are found |
//! | [`mesh`], [`skin`], [`maps`], [`light`], [`camera`], [`world`] | what is loaded |
//! | [`animation`], [`dynamics`] | what a frame shows; how far hair is bent in it |
//! | [`groom`], [`layout`] | what the shaders are given |
//! | [`lapped`], [`bake`], [`shellfin`], [`dynamics`] | patches, textures, shells and fins, forces on hair |
//! | [`gpu`], [`passes`], [`prepare`], [`render`] | the GPU, the passes, and their order |
//! | [`film`], [`files`], [`hair`], [`export`], [`compare`] | pictures, files, hair and scenes for other programs, metrics |
//! | [`mod@reference`] | the passes once more in plain Rust, for the tests |
//! | [`mod@bench`], [`figure`], [`validate`], [`provenance`] | the paper's Table 1 and figures, errors of the approximations, and where results came from |
//! | [`report`] | plots and tables of reports |
//! | [`stats`], [`error`], [`cli`] | counts and times, what can go wrong, the command |
//!
//! `ARCHITECTURE.md` in the repository says why things are as they are.

pub mod animation;
pub mod assets;
pub mod bake;
pub mod bench;
pub mod camera;
pub mod cli;
pub mod compare;
pub mod dynamics;
pub mod error;
pub mod export;
pub mod fibre;
pub mod figure;
pub mod files;
pub mod film;
pub mod gpu;
pub mod groom;
pub mod hair;
pub mod lapped;
pub mod layout;
pub mod light;
pub mod maps;
pub mod mesh;
pub mod passes;
pub mod pathtrace;
pub mod prepare;
pub mod provenance;
pub mod reference;
pub mod render;
pub mod report;
pub mod scene;
pub mod shellfin;
pub mod skin;
pub mod stats;
pub mod transport;
pub mod validate;
pub mod world;

pub use error::{Error, Result, SceneFault};
pub use scene::Scene;
pub use skin::Skin;
pub use world::World;
