//! Objects as other renderers take them.

use super::colors_on;
use glam::Vec3;
use pelage_core::World;
use pelage_core::objects::Object;
use std::collections::HashSet;

/// An object that is exported.
pub(crate) struct Exported<'a> {
    /// The object.
    pub object: &'a Object,
    /// Its name in letters, digits and underscores, different from all others.
    pub stem: String,
    /// Base colour, linear RGB: one value, or one per vertex.
    pub colors: Vec<Vec3>,
}

/// Words that name other things in the files.
const TAKEN: [&str; 9] = ["skin", "guard", "undercoat", "sky", "scene", "world", "camera", "looks", "light"];

/// The objects of a world, in the order of the scene.
pub(crate) fn of(world: &World) -> Vec<Exported<'_>> {
    let mut taken: HashSet<String> = TAKEN.iter().map(|s| (*s).to_owned()).collect();
    let exported = |object| Exported {
        object,
        stem: stem(&object.name, &mut taken),
        colors: colors_on(world, &object.material.color, &object.surface, object.origin),
    };
    world.objects.iter().map(exported).collect()
}

/// A name for identifiers and files; `taken` are those in use, in lower case.
fn stem(name: &str, taken: &mut HashSet<String>) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut base: String = name.chars().map(plain).take(48).collect();
    if base.starts_with(|c: char| c.is_ascii_digit()) || base.is_empty() {
        base.insert(0, '_');
    }
    let mut all = std::iter::once(base.clone()).chain((2..).map(|n| format!("{base}_{n}")));
    let free = all.find(|s| taken.insert(s.to_lowercase()));
    free.unwrap_or(base)
}

impl Exported<'_> {
    /// The file of its surface.
    pub fn file(&self) -> String {
        format!("{}.ply", self.stem)
    }

    /// Description of it.
    pub fn holds(&self) -> String {
        format!("{} triangles of the object {:?}", self.object.surface.triangles.len(), self.object.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers_of_their_own() {
        let mut taken: HashSet<String> = TAKEN.iter().map(|s| (*s).to_owned()).collect();
        let found =
            ["left eye", "left-eye", "Left_Eye", "3rd", "skin", "größe", ""].map(|n| stem(n, &mut taken));
        assert_eq!(found, ["left_eye", "left_eye_2", "Left_Eye_3", "_3rd", "skin_2", "gr__e", "_"]);
    }
}
