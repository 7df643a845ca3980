//! Where assets are looked for: the scene's folder, `assets/`, the environment variable PELAGE_ASSETS.

use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// The search path of a scene.
#[derive(Debug, Clone, Default)]
pub struct Assets {
    /// Folders, first match wins.
    pub folders: Vec<PathBuf>,
}

impl Assets {
    /// The search path of a scene file in `folder`.
    pub fn of_folder(folder: &Path) -> Self {
        let mut folders = vec![folder.to_owned(), PathBuf::from("assets")];
        if let Some(path) = std::env::var_os("PELAGE_ASSETS") {
            folders.extend(std::env::split_paths(&path));
        }
        Self { folders }
    }

    /// The first existing file called `name` (a relative or absolute path).
    pub fn find(&self, name: &str) -> Result<PathBuf> {
        self.folders
            .iter()
            .map(|folder| folder.join(name))
            .find(|path| path.is_file())
            .ok_or_else(|| Error::fault(name, format!("not found in {:?}", self.folders)))
    }
}
