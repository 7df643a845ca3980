//! Shows a picture while it is rendered: refreshes the output files, sends it to a viewer.

use pelage::film::{Film, Metadata, composite::Backdrop, io, tev::Tev};
use pelage::{Result, Scene};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A preview may take one part in this many of the rendering's time.
const SHARE: u32 = 50;

/// Time per pixel of a preview, assumed until the first has been measured.
const USUAL_COST: Duration = Duration::from_nanos(300);

/// Where the unfinished picture goes, and when next.
pub(super) struct Preview<'a> {
    scene: &'a Scene,
    backdrop: Backdrop,
    interval: Duration,
    state: Mutex<State>,
}

struct State {
    files: Vec<PathBuf>,
    tev: Option<Tev>,
    due: Instant,
}

impl<'a> Preview<'a> {
    /// A preview in `files` and in `tev`, at most every `interval`.
    pub fn new(
        scene: &'a Scene,
        backdrop: Backdrop,
        interval: Duration,
        files: Vec<PathBuf>,
        tev: Option<Tev>,
    ) -> Self {
        let cost = USUAL_COST * scene.film.width.saturating_mul(scene.film.height);
        let due = Instant::now() + interval.max(SHARE * cost);
        Self { scene, backdrop, interval, state: Mutex::new(State { files, tev, due }) }
    }

    /// Shows the picture so far, unless that happened a moment ago. What fails is reported and not
    /// tried again: the rendering goes on.
    pub fn offer(&self, film: &Film) {
        let Ok(mut state) = self.state.lock() else { return };
        let start = Instant::now();
        if start < state.due || (state.files.is_empty() && state.tev.is_none()) {
            return;
        }
        if let Err(e) = self.show(film, &mut state) {
            eprintln!("warning: no more previews: {e}");
            (state.files, state.tev) = (Vec::new(), None);
        }
        state.due = Instant::now() + self.interval.max(SHARE * start.elapsed());
    }

    /// Colour and alpha over the background, without depth of field as a post-process.
    fn show(&self, film: &Film, state: &mut State) -> Result<()> {
        let mut picture = Film::from_premultiplied(film.width, film.height, &film.premultiplied()?);
        self.backdrop.under(&mut picture)?;
        let meta = Metadata::of_program().with("complete", "false");
        state.files.iter().try_for_each(|path| io::write(&picture, path, &meta, &self.scene.film))?;
        state.tev.as_mut().map_or(Ok(()), |tev| tev.show(&picture))
    }

    /// Shows the finished picture in the viewer.
    pub fn finish(self, film: &Film) {
        let Ok(mut state) = self.state.into_inner() else { return };
        if let Some(Err(e)) = state.tev.as_mut().map(|tev| tev.show(film)) {
            eprintln!("warning: the finished picture is not shown: {e}");
        }
    }
}

/// Name of a picture in a viewer's list.
pub(super) fn title(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
