//! The mattes of a rendering: which planes of its film cover which named thing.

use crate::planes;
use pelage_core::film::cryptomatte::{self, Matte};
use pelage_core::film::{Film, Metadata};
use pelage_core::scene::{FurLayers, Scene};
use pelage_core::{Error, Result};

/// The sets of mattes of a scene's film, by name: `CryptoObject` and, except for shells and fins,
/// whose layers cannot be told apart, `CryptoLayer`.
pub fn sets(scene: &Scene) -> Vec<(&'static str, Vec<Matte>)> {
    let object = scene.mesh.name();
    if scene.render.fur == FurLayers::Shells {
        return vec![("CryptoObject", vec![Matte::new(object, &["A"])])];
    }
    let [guard, undercoat, base] = planes::COVERAGES;
    let layers = vec![
        Matte::new("guard", &[guard]),
        Matte::new("undercoat", &[undercoat]),
        Matte::new("skin", &[base]),
    ];
    vec![("CryptoLayer", layers), ("CryptoObject", vec![Matte::new(object, &planes::COVERAGES)])]
}

/// Adds the mattes of [`sets`] to a film rendered with features, before a background is added.
/// Returns the metadata with their description.
///
/// # Errors
/// As [`cryptomatte::add`]; [`Error::Unsupported`] if a pixel has more mattes than a file keeps.
pub fn add(film: &mut Film, meta: Metadata, scene: &Scene) -> Result<Metadata> {
    sets(scene).into_iter().try_fold(meta, |meta, (set, mattes)| {
        let (meta, over) = cryptomatte::add(film, meta, set, &mattes)?;
        if over > 0 {
            let most = cryptomatte::MOST_RANKS;
            return Err(Error::Unsupported(format!(
                "found {over} pixels with more than {most} mattes of {set}, expected no more: join some"
            )));
        }
        Ok(meta)
    })
}
