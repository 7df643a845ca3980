//! Objects as other renderers take them.

use super::{Job, colors_on, sky};
use glam::{Vec2, Vec3};
use pelage_core::maps::{MapImage, VERTEX_COLOR};
use pelage_core::objects::Object;
use pelage_core::scene::Color;
use pelage_core::{Result, Skin, World};
use pelage_fur::surface::split_at_seams;
use std::borrow::Cow;
use std::collections::HashSet;

/// An object that is exported.
pub(crate) struct Exported<'a> {
    /// The object.
    pub object: &'a Object,
    /// Its name in letters, digits and underscores, different from all others.
    pub stem: String,
    /// Its surface; where it has an image, with one uv per vertex.
    pub surface: Cow<'a, Skin>,
    /// Base colour.
    pub base: Base<'a>,
}

/// Base colour of an object, linear RGB.
pub(crate) enum Base<'a> {
    /// One value, or one per vertex.
    Colors(Vec<Vec3>),
    /// An image, the factor on it, and the uv of each vertex.
    Image(&'a MapImage, Vec3, Vec<Vec2>),
}

/// Words that name other things in the files.
const TAKEN: [&str; 9] = ["skin", "guard", "undercoat", "sky", "scene", "world", "camera", "looks", "light"];

/// The objects of a world, in the order of the scene.
pub(crate) fn of(world: &World) -> Vec<Exported<'_>> {
    let mut taken: HashSet<String> = TAKEN.iter().map(|s| (*s).to_owned()).collect();
    let mut all = Vec::with_capacity(world.objects.len());
    for object in &world.objects {
        let (surface, base) = based(world, object);
        all.push(Exported { object, stem: stem(&object.name, &mut taken), surface, base });
    }
    all
}

fn based<'a>(world: &'a World, object: &'a Object) -> (Cow<'a, Skin>, Base<'a>) {
    if let Color::Mapped(map) = &object.material.color
        && let Some(index) = world.maps.index_of(&map.map, &map.layer, true)
        && let Some((surface, uv)) = split_at_seams(&object.surface)
    {
        let base = Base::Image(&world.maps.images[index], map.value.into(), uv);
        return (Cow::Owned(surface), base);
    }
    let colors = colors_on(world, &object.material.color, &object.surface, object.origin);
    (Cow::Borrowed(&object.surface), Base::Colors(colors))
}

/// Writes the images of the objects' base colours, with their factors, clamped to 0..1.
pub(crate) fn write_images(job: &mut Job<'_>) -> Result<()> {
    for i in 0..job.objects.len() {
        let of = &job.objects[i];
        let (Base::Image(image, value, _), Some(name)) = (&of.base, of.image()) else { continue };
        let (width, height) = (image.width as usize, image.height as usize);
        let holds = format!("{width} x {height} texels, the colour of the object {:?}", of.object.name);
        let path = job.folder.join(name);
        sky::write_exr(&path, width, height, |x, y| {
            let [r, g, b, _] = image.texels[y * width + x];
            (*value * Vec3::new(r, g, b)).clamp(Vec3::ZERO, Vec3::ONE)
        })?;
        job.wrote(path, holds)?;
    }
    Ok(())
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

    /// The file of its base colour, if that is an image.
    pub fn image(&self) -> Option<String> {
        matches!(self.base, Base::Image(..)).then(|| format!("{}.exr", self.stem))
    }

    /// Its base colour without an image: one value, or one per vertex; empty with an image.
    pub fn colors(&self) -> &[Vec3] {
        match &self.base {
            Base::Colors(colors) => colors,
            Base::Image(..) => &[],
        }
    }

    /// The uv of each vertex where it has an image, else empty.
    pub fn uv(&self) -> &[Vec2] {
        match &self.base {
            Base::Colors(_) => &[],
            Base::Image(.., uv) => uv,
        }
    }

    /// Whether its colour varies over the vertices because its mesh has no uv for its image.
    pub fn without_uv(&self) -> bool {
        let image = matches!(&self.object.material.color, Color::Mapped(m) if m.map != VERTEX_COLOR);
        image && self.colors().len() > 1
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
