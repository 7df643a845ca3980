//! What figures are produced with: the device, the figure's folder, and the size and quality of
//! pictures.

use super::content::{FigureContent, PanelImage};
use super::panel;
use super::spec::{FILE, Figure, Panel};
use crate::provenance::{only_files_missing, say};
use crate::rendering::render_whole;
use pelage_core::assets::Assets;
use pelage_core::film::{Film, composite, depth_of_field, io, resample};
use pelage_core::{Error, Result, Scene, World, animation};
use pelage_gpu::Gpu;
use pelage_render::Frame;
use serde::de::DeserializeOwned;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// The surroundings of a figure that is being produced.
pub struct FigureContext<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The figure's description.
    pub figure: &'a Figure,
    /// The figure's folder in `paper_figures/`.
    pub folder: &'a Path,
    /// Folder of the results.
    pub out: &'a Path,
    /// Whether the small version is produced.
    pub quick: bool,
    /// Panel size from the command line, pixels.
    pub asked: Option<[u32; 2]>,
    /// Set when the user wants to stop.
    pub cancel: &'a AtomicBool,
}

impl FigureContext<'_> {
    /// Pixels of a panel.
    pub fn size(&self) -> [u32; 2] {
        self.figure.panel_size(self.asked, self.quick)
    }

    /// The study's settings; in a quick run those of `[quick.settings]` replace them.
    ///
    /// # Errors
    /// [`Error::Scene`] for a setting that is missing, unknown or of the wrong type.
    pub fn settings<T: DeserializeOwned>(&self) -> Result<T> {
        let mut settings = self.figure.settings.clone();
        if self.quick {
            settings.extend(self.figure.quick.settings.clone());
        }
        settings.try_into().map_err(|e| self.fault(format!("[settings]: {}", e.message())))
    }

    /// A fault of the figure's `figure.toml`.
    pub fn fault(&self, message: impl Into<String>) -> Error {
        Error::fault(self.folder.join(FILE), message)
    }

    /// Loads a scene of the figure's folder at the size and samples of its panels, with overrides.
    ///
    /// # Errors
    /// Those of [`Scene::load`] and [`World::load`]; for missing files with a hint where to get
    /// them.
    pub fn load(&self, scene: &str, set: &[String]) -> Result<(World, Assets)> {
        let [width, height] = self.size();
        let mut overrides = vec![
            format!("film.width={width}"),
            format!("film.height={height}"),
            format!("film.spp={}", self.figure.samples(self.quick)),
        ];
        if self.quick {
            overrides.extend(self.figure.quick.set.iter().cloned());
        }
        overrides.extend(set.iter().cloned());
        let loaded = Scene::load(&self.folder.join(scene), &overrides)
            .and_then(|(scene, assets)| Ok((World::load(scene, &assets)?, assets)));
        loaded.map_err(|e| match e {
            Error::Scene(mut faults) if only_files_missing(&Error::Scene(faults.clone())) => {
                for fault in &mut faults {
                    fault.help.get_or_insert_with(|| {
                        "scripts/fetch_assets.sh fetches the bunny and the environment maps".into()
                    });
                }
                Error::Scene(faults)
            }
            other => other,
        })
    }

    /// Renders a world with all planes, before depth of field and background.
    ///
    /// # Errors
    /// Those of [`pelage_shells::render_on`]; [`Error::Interrupted`].
    pub fn render(&self, world: &World) -> Result<Frame> {
        render_whole(self.gpu, world, 0.0, self.cancel)
    }

    /// Renders a world to a finished picture, with depth of field and background.
    ///
    /// # Errors
    /// As [`FigureContext::render`], and those of reading the background.
    pub fn render_panel(&self, label: &str, world: &World, assets: &Assets) -> Result<PanelImage> {
        self.render_panel_at(label, world, assets, 0.0)
    }

    /// The same, `time` s after the first frame.
    fn render_panel_at(&self, label: &str, world: &World, assets: &Assets, time: f64) -> Result<PanelImage> {
        let mut frame = render_whole(self.gpu, world, time, self.cancel)?;
        depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
        composite::over_background(&mut frame.film, &world.scene, assets)?;
        self.report(&format!("{label}: {:.2} s", frame.stats.total_ms / 1e3))?;
        Ok(PanelImage {
            label: label.to_owned(),
            film: frame.film,
            spec: world.scene.film.clone(),
            scene: toml::to_string(&world.scene).ok(),
            stats: Some(frame.stats),
        })
    }

    /// Prints an indented line of progress; fails if the user has interrupted.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Io`].
    pub fn report(&self, text: &str) -> Result<()> {
        if self.cancel.load(Ordering::SeqCst) {
            return Err(Error::Interrupted);
        }
        say(&format!("  {text}\n"))
    }

    /// Renders the figure's panels.
    ///
    /// # Errors
    /// As [`FigureContext::load`] and [`FigureContext::render_panel`]. Everything is loaded before
    /// the first rendering, so that a missing file is reported at once.
    pub(super) fn panels(&self) -> Result<FigureContent> {
        enum Job {
            Scene(Box<World>, Assets),
            Image(Box<PanelImage>),
        }
        let load = |panel: &Panel| match (&panel.scene, &panel.image) {
            (Some(scene), _) => {
                self.load(scene, &panel.set).map(|(world, assets)| Job::Scene(Box::new(world), assets))
            }
            (None, image) => self
                .photograph(&panel.label, image.as_deref().unwrap_or_default())
                .map(|image| Job::Image(Box::new(image))),
        };
        let jobs = self.figure.panels.iter().map(load).collect::<Result<Vec<_>>>()?;
        let found = |name: &String| Assets::of_folder(self.folder).find(name).is_ok();
        let images = self.figure.panels.iter().filter_map(|panel| panel.image.clone());
        let mut content = FigureContent {
            missing: images.filter(|name| !found(name)).collect(),
            ..FigureContent::default()
        };
        for (panel, job) in self.figure.panels.iter().zip(jobs) {
            self.gpu.ledger.reset_peaks();
            content.images.push(match job {
                Job::Scene(mut world, assets) => {
                    let state = animation::at(&world.scene, panel.frame);
                    world.scene.camera = state.camera;
                    self.render_panel_at(&panel.label, &world, &assets, state.time)?
                }
                Job::Image(image) => *image,
            });
        }
        Ok(content)
    }

    /// A photograph, scaled and cropped to the size of a panel; a labelled placeholder if it is not
    /// found.
    fn photograph(&self, label: &str, name: &str) -> Result<PanelImage> {
        let [width, height] = self.size();
        let film = match Assets::of_folder(self.folder).find(name) {
            Ok(path) => {
                let photo = io::read(&path)?;
                let size = [photo.width as usize, photo.height as usize];
                let to = [width as usize, height as usize];
                let pixels = resample::cover(&photo.premultiplied()?, size, to);
                Film::from_premultiplied(width, height, &pixels)
            }
            Err(_) => panel::slot(width, height, &format!("{name} is not there")),
        };
        Ok(PanelImage::drawn(label, film))
    }
}
