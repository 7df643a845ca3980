//! Where figures are made: the device, the figure's folder, and how large and how good pictures are to be.

use super::content::{FigureContent, PanelImage};
use super::panel;
use super::spec::{Figure, Panel};
use crate::provenance::{only_files_missing, say};
use pelage_core::animation;
use pelage_core::assets::Assets;
use pelage_core::film::{composite, depth_of_field, io};
use pelage_core::{Error, Result, Scene, World};
use pelage_gpu::Gpu;
use pelage_render::{Frame, RenderOptions};
use serde::de::DeserializeOwned;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// What makers of figures are given.
pub struct FigureContext<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// What is to be content.
    pub figure: &'a Figure,
    /// The figure's folder in the registry.
    pub folder: &'a Path,
    /// Where results go.
    pub out: &'a Path,
    /// Whether it is the small version.
    pub quick: bool,
    /// Panel size that was asked for.
    pub asked: Option<[u32; 2]>,
    /// Raised when the user wants to stop.
    pub cancel: &'a AtomicBool,
}

impl FigureContext<'_> {
    /// Pixels of a panel.
    pub fn size(&self) -> [u32; 2] {
        self.figure.panel_size(self.asked, self.quick)
    }

    /// The study's settings, those of `[quick.settings]` over them in a quick run.
    ///
    /// # Errors
    /// [`Error::Scene`] that names what is not as `T` has it.
    pub fn settings<T: DeserializeOwned>(&self) -> Result<T> {
        let mut settings = self.figure.settings.clone();
        if self.quick {
            settings.extend(self.figure.quick.settings.clone());
        }
        settings.try_into().map_err(|e| {
            Error::fault(self.folder.join("figure.toml"), format!("[settings]: {}", e.message()))
        })
    }

    /// A scene of the figure's folder at the panels' size and samples, with overrides.
    ///
    /// # Errors
    /// Those of [`Scene::load`] and [`World::load`]; missing files say how to get them.
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

    /// The renderer's image with all layers, before the lens and the background.
    ///
    /// # Errors
    /// Those of [`render::render_on`]; [`Error::Interrupted`].
    pub fn render(&self, world: &World) -> Result<Frame> {
        self.render_at(world, 0.0)
    }

    /// The same, `time` s after the scene's first frame.
    fn render_at(&self, world: &World, time: f64) -> Result<Frame> {
        let options =
            RenderOptions { aovs: true, cancel: Some(self.cancel), time, ..RenderOptions::default() };
        let frame = pelage_shells::render_on(self.gpu, world, &options)?;
        match frame.fault {
            Some(fault) => Err(fault),
            None if frame.complete => Ok(frame),
            None => Err(Error::Interrupted),
        }
    }

    /// The finished picture of a world: through its lens, over its background.
    ///
    /// # Errors
    /// As [`FigureContext::render`], and those of reading the background.
    pub fn render_panel(&self, label: &str, world: &World, assets: &Assets) -> Result<PanelImage> {
        self.render_panel_at(label, world, assets, 0.0)
    }

    fn render_panel_at(&self, label: &str, world: &World, assets: &Assets, time: f64) -> Result<PanelImage> {
        let mut frame = self.render_at(world, time)?;
        depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
        composite::over_background(&mut frame.film, &world.scene, assets)?;
        self.tell(&format!("{label}: {:.2} s", frame.stats.total_ms / 1e3))?;
        Ok(PanelImage {
            label: label.to_owned(),
            film: frame.film,
            spec: world.scene.film.clone(),
            scene: toml::to_string(&world.scene).ok(),
            stats: Some(frame.stats),
        })
    }

    /// Says what was done; notices an interrupt.
    ///
    /// # Errors
    /// [`Error::Interrupted`], [`Error::Io`].
    pub fn tell(&self, words: &str) -> Result<()> {
        if self.cancel.load(Ordering::SeqCst) {
            return Err(Error::Interrupted);
        }
        say(&format!("  {words}\n"))
    }

    /// Renders the figure's panels.
    ///
    /// # Errors
    /// As [`FigureContext::load`] and [`FigureContext::render_panel`]. Everything is loaded before anything is rendered: a missing file shows itself at once.
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
                .map(|shot| Job::Image(Box::new(shot))),
        };
        let jobs = self.figure.panels.iter().map(load).collect::<Result<Vec<_>>>()?;
        let there = |name: &String| Assets::of_folder(self.folder).find(name).is_ok();
        let images = self.figure.panels.iter().filter_map(|panel| panel.image.clone());
        let mut content = FigureContent {
            missing: images.filter(|name| !there(name)).collect(),
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
                Job::Image(shot) => *shot,
            });
        }
        Ok(content)
    }

    /// A photograph cut to the panels' size; words on grey where it is not there.
    fn photograph(&self, label: &str, name: &str) -> Result<PanelImage> {
        let [width, height] = self.size();
        let film = match Assets::of_folder(self.folder).find(name) {
            Ok(path) => {
                let photo = io::read(&path)?;
                let size = [photo.width as usize, photo.height as usize];
                let to = [width as usize, height as usize];
                let pixels = pelage_core::film::resample::cover(&photo.premultiplied()?, size, to);
                pelage_core::film::Film::from_premultiplied(width, height, &pixels)
            }
            Err(_) => panel::slot(width, height, &format!("{name} is not there")),
        };
        Ok(PanelImage::drawn(label, film))
    }
}
