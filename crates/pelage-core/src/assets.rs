//! Where assets are searched for: the scene's folder, `assets/`, and the folders in the environment
//! variable PELAGE_ASSETS.

use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// The search path of a scene.
#[derive(Debug, Clone, Default)]
pub struct Assets {
    /// Folders, in order of preference.
    pub folders: Vec<PathBuf>,
}

impl Assets {
    /// The search path of a scene file in `folder`.
    pub fn of_folder(folder: &Path) -> Self {
        let mut folders = vec![folder.to_owned(), PathBuf::from("assets")];
        if let Some(path) = std::env::var_os("PELAGE_ASSETS") {
            folders.extend(std::env::split_paths(&path).filter(|p| !p.as_os_str().is_empty()));
        }
        Self { folders }
    }

    /// The first existing file called `name` (a relative or absolute path).
    ///
    /// # Errors
    /// [`Error::Scene`] that lists the folders and says how to get the files.
    pub fn find(&self, name: &str) -> Result<PathBuf> {
        self.folders
            .iter()
            .map(|folder| folder.join(name))
            .find(|path| path.is_file())
            .ok_or_else(|| Error::fault(name, format!("the file is not there; {}", self.advice())))
    }

    /// Where files were searched for, and how to get those that the example scenes use.
    pub fn advice(&self) -> String {
        let folders: Vec<_> = self.folders.iter().map(|f| f.display().to_string()).collect();
        let unset =
            if std::env::var_os("PELAGE_ASSETS").is_some() { "" } else { ", PELAGE_ASSETS (not set)" };
        format!(
            "looked in {}{unset}; scripts/fetch_assets.sh fetches the bunny and the environment maps into assets/",
            folders.join(", ")
        )
    }
}
