//! Files from which a rendering resumes.

use super::{Options, film::Accumulator};
use pelage_core::film::{Metadata, io};
use pelage_core::{Error, Result, World};
use std::path::Path;

/// What must agree between a file and the rendering that resumes from it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Keys of the metadata with their values.
    entries: Vec<(&'static str, String)>,
    metadata: Metadata,
}

impl Identity {
    /// Identity of a rendering of `world` with `options`.
    ///
    /// Parts of the scene that change no sample do not count: samples per pixel, memory budget,
    /// tile size, background and tone mapping.
    pub fn new(world: &World, options: &Options<'_>) -> Self {
        let mut scene = world.scene.clone();
        let plain = pelage_core::Scene::default();
        scene.render =
            pelage_core::scene::RenderSpec { fur: scene.render.fur, seed: scene.render.seed, ..plain.render };
        scene.film = pelage_core::scene::FilmSpec {
            width: scene.film.width,
            height: scene.film.height,
            filter: scene.film.filter,
            filter_radius: scene.film.filter_radius,
            ..plain.film
        };
        let metadata = Metadata::of_program().with_scene(&toml::to_string(&scene).unwrap_or_default());
        let word = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
        let patch = options.grow.patch.map_or("all".to_owned(), |p| format!("{:?} {:?}", p.centre, p.radius));
        let entries = vec![
            ("version", metadata.get("version").unwrap_or_default().to_owned()),
            ("scene_sha256", metadata.get("scene_sha256").unwrap_or_default().to_owned()),
            ("integrator", word(&options.integrator)),
            ("lights", word(&options.light_model())),
            ("depth", options.depth.to_string()),
            ("sampling_seed", options.seed.to_string()),
            ("patch", patch),
            ("undercoat_segments", options.grow.undercoat_segments.to_string()),
            ("layers", format!("{:?}", options.layers)),
        ];
        Self { entries, metadata }
    }

    /// The metadata of an image with `samples` samples per pixel. Nothing in it differs between
    /// runs.
    pub fn metadata(&self, samples: u32) -> Metadata {
        let all = self.entries.iter().fold(self.metadata.clone(), |m, (key, value)| m.with(key, value));
        all.with("samples", samples.to_string())
    }

    /// Reads the means of an earlier rendering.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::Usage`] with all entries that differ,
    /// another size, or if planes are missing.
    pub fn read(&self, path: &Path, size: [u32; 2]) -> Result<Accumulator> {
        let found = io::read_metadata(path)?;
        let mut differing: Vec<String> = self
            .entries
            .iter()
            .filter(|(key, value)| found.get(key) != Some(value))
            .map(|(key, value)| {
                format!(
                    "found {key} {:?} in the file, expected {value:?}",
                    found.get(key).unwrap_or("missing")
                )
            })
            .collect();
        let samples = found.get("samples").and_then(|s| s.parse::<u32>().ok());
        if samples.is_none_or(|s| s % 2 != 0) {
            differing.push("found no even number of samples in the file".into());
        }
        let fault = |what: String| {
            Error::Usage(format!(
                "--resume {}: {what}; render the same scene with the same options, or leave --resume out to start anew",
                path.display()
            ))
        };
        if !differing.is_empty() {
            return Err(fault(differing.join("; ")));
        }
        let film = io::read(path)?;
        if [film.width, film.height] != size {
            return Err(fault(format!(
                "found {} x {} pixels in the file, expected {} x {}",
                film.width, film.height, size[0], size[1]
            )));
        }
        Accumulator::from_film(&film, samples.unwrap_or(0)).ok_or_else(|| {
            fault(
                "found no planes such as half0.R in the file, expected an image of `pelage reference`".into(),
            )
        })
    }
}
