//! The mattes of a rendering: which planes of its film cover which named thing.

use crate::planes;
use pelage_core::Result;
use pelage_core::film::cryptomatte::{self, Matte};
use pelage_core::film::{Film, Metadata};
use pelage_core::scene::{FurLayers, Scene};

/// The sets of mattes of a scene's film, by name: `CryptoObject` (the body under the name of its
/// mesh, and each object) and, except for shells and fins, whose layers cannot be told apart,
/// `CryptoLayer`.
pub fn sets(scene: &Scene) -> Vec<(&'static str, Vec<Matte>)> {
    let object = scene.mesh.name();
    if scene.render.fur == FurLayers::Shells {
        return vec![("CryptoObject", vec![Matte::new(object, &["A"])])];
    }
    let [guard, undercoat, base] = planes::COVERAGES;
    let mut layers = vec![Matte::new("guard", &[guard]), Matte::new("undercoat", &[undercoat])];
    let of_objects: Vec<String> = (0..scene.objects.len()).map(planes::object_coverage).collect();
    if of_objects.is_empty() {
        layers.push(Matte::new("skin", &[base]));
        return vec![("CryptoLayer", layers), ("CryptoObject", vec![Matte::new(object, &planes::COVERAGES)])];
    }
    layers.push(Matte::new("skin", &[planes::SKIN_COVERAGE]));
    layers.push(Matte::new("objects", &of_objects.iter().map(String::as_str).collect::<Vec<_>>()));
    let mut things = vec![Matte::new(object, &[guard, undercoat, planes::SKIN_COVERAGE])];
    things.extend(scene.objects.iter().zip(&of_objects).map(|(o, plane)| Matte::new(&o.name, &[plane])));
    vec![("CryptoLayer", layers), ("CryptoObject", things)]
}

/// Adds the mattes of [`sets`] to a film rendered with features, before a background is added.
/// Returns the metadata with their description.
///
/// # Errors
/// As [`cryptomatte::add`].
pub fn add(film: &mut Film, meta: Metadata, scene: &Scene) -> Result<Metadata> {
    sets(scene).into_iter().try_fold(meta, |meta, (set, mattes)| cryptomatte::add(film, meta, set, &mattes))
}
