//! Image maps of the groom.

use crate::assets::Assets;
use crate::film::{LARGEST_HALF, io};
use crate::scene::{Coat, Color, MeshSpec, Part, Scalar};
use crate::{Error, Result, Scene};
use glam::{Vec2, Vec3, Vec4};
use std::path::Path;

/// The map name that means the mesh's vertex colours instead of an image.
pub const VERTEX_COLOR: &str = "vertex_color";

/// Images that are wider or higher than this many texels are reduced to it.
pub const MAX_SIDE: u32 = 2048;

/// Length that an image covers at scale 1 where it is looked up without uv, cm.
pub const TRIPLANAR_CM: f32 = 10.0;

/// The images that a scene's groom names, each once.
#[derive(Debug, Clone, Default)]
pub struct MapSet {
    /// The images.
    pub images: Vec<MapImage>,
    /// What loading changed or noticed, to be reported to the user.
    pub notes: Vec<String>,
}

/// One image, RGBA.
#[derive(Debug, Clone)]
pub struct MapImage {
    /// File name as in the scene.
    pub name: String,
    /// Layer of an EXR image; empty for the default one.
    pub layer: String,
    /// Whether it is read as a colour: a format of integers is then decoded from sRGB to linear.
    /// Scalars are read as the file has them.
    pub color: bool,
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// Row by row from the top, straight alpha.
    pub texels: Vec<[f32; 4]>,
}

impl MapSet {
    /// Loads every map that `scene` names, in any format that [`io::read`] takes.
    ///
    /// # Errors
    /// [`Error::Scene`] with all images that are missing or unreadable, each by name.
    pub fn load(scene: &Scene, assets: &Assets) -> Result<Self> {
        let mut set = Self::default();
        let mut faults = Vec::new();
        for (name, layer, color) in maps_of(scene) {
            if set.index_of(name, layer, color).is_some() {
                continue;
            }
            match assets.find(name).and_then(|path| load_image(&path, [name, layer], color, &mut set.notes)) {
                Ok(image) => set.images.push(image),
                Err(Error::Scene(mut found)) => {
                    // A file may be read both as a colour and as a scalar: one message is enough.
                    found.retain(|fault| !faults.contains(fault));
                    faults.append(&mut found);
                }
                Err(other) => return Err(other),
            }
        }
        if faults.is_empty() { Ok(set) } else { Err(Error::Scene(faults)) }
    }

    /// Index in `images` of `layer` of the map called `name`, read as a colour or as a scalar.
    pub fn index_of(&self, name: &str, layer: &str, color: bool) -> Option<usize> {
        self.images.iter().position(|i| i.name == name && i.layer == layer && i.color == color)
    }
}

/// Whether a parameter of the groom is read from the vertex colours.
pub fn uses_vertex_color(scene: &Scene) -> bool {
    names_of(scene).iter().any(|(name, ..)| *name == VERTEX_COLOR)
}

/// A note that vertex colours are read from a mesh that has none.
pub(crate) fn white_vertices(mesh: &MeshSpec) -> String {
    let name = match (&mesh.path, mesh.shape) {
        (Some(path), _) => path.clone(),
        (None, shape) => shape.map_or_else(String::new, |s| format!("the shape {s:?}")),
    };
    format!(
        "warning: {name} has no vertex colours: what the scene reads from \"{VERTEX_COLOR}\" is white everywhere"
    )
}

/// The images that groom and objects name and their layers, with repetitions, and whether each is
/// read as a colour.
fn maps_of(scene: &Scene) -> Vec<(&str, &str, bool)> {
    let mut maps = names_of(scene);
    maps.extend(scene.objects.iter().filter_map(|object| match &object.material.color {
        Color::Mapped(m) => Some((m.map.as_str(), m.layer.as_str(), true)),
        Color::Constant(_) => None,
    }));
    maps.retain(|(name, ..)| *name != VERTEX_COLOR);
    maps
}

/// As [`maps_of`], with vertex colours.
fn names_of(scene: &Scene) -> Vec<(&str, &str, bool)> {
    let mut maps = maps_of_coat(&scene.own_coat());
    if let Scalar::Mapped(m) = &scene.shells.length {
        maps.push((m.map.as_str(), m.layer.as_str(), false));
    }
    if let Color::Mapped(m) = &scene.shells.color {
        maps.push((m.map.as_str(), m.layer.as_str(), true));
    }
    maps.extend(scene.parts.iter().flat_map(|part| maps_of_part(scene, part)));
    maps
}

/// The images of a part: its mask, and those of its coat.
fn maps_of_part<'a>(scene: &'a Scene, part: &'a Part) -> Vec<(&'a str, &'a str, bool)> {
    let mut maps: Vec<_> =
        part.mask.iter().map(|mask| (mask.map.as_str(), mask.layer.as_str(), false)).collect();
    if let Some(coat) = scene.coat_of(part) {
        maps.extend(maps_of_coat(&coat));
    } else if let Some(Color::Mapped(m)) = part.base.as_ref().map(|base| &base.color) {
        maps.push((m.map.as_str(), m.layer.as_str(), true));
    }
    maps
}

/// The images of a coat, scalars first.
fn maps_of_coat<'a>(coat: &Coat<'a>) -> Vec<(&'a str, &'a str, bool)> {
    let (guard, undercoat) = (coat.guard, coat.undercoat);
    let colors =
        [&guard.color_root, &guard.color_tip, &undercoat.color_root, &undercoat.color_tip, &coat.base.color];
    let scalars = coat.scalars().into_iter().filter_map(|(_, scalar)| match scalar {
        Scalar::Mapped(m) => Some((m.map.as_str(), m.layer.as_str(), false)),
        Scalar::Constant(_) => None,
    });
    let colors = colors.into_iter().filter_map(|c| match c {
        Color::Mapped(m) => Some((m.map.as_str(), m.layer.as_str(), true)),
        Color::Constant(_) => None,
    });
    scalars.chain(colors).collect()
}

/// Reads one image, brings its values into the range that maps may have, and reduces it to
/// [`MAX_SIDE`].
fn load_image(
    path: &Path,
    [name, layer]: [&str; 2],
    color: bool,
    notes: &mut Vec<String>,
) -> Result<MapImage> {
    let (width, height, texels) = io::read_texels(path, layer, color, notes)?;
    let mut image = MapImage { name: name.to_owned(), layer: layer.to_owned(), color, width, height, texels };
    notes.extend(image.limited().into_iter().map(|note| format!("{name}: {note}")));
    if width > MAX_SIDE || height > MAX_SIDE {
        image = image.reduced();
        notes.push(format!("{name}: reduced from {width}x{height} to {}x{}", image.width, image.height));
    }
    Ok(image)
}

impl MapImage {
    /// Replaces values that are not finite by 0, cuts those that half floats do not hold, as the
    /// GPU reads them, and sets negative channels of a colour to 0. Returns a note with the number
    /// of values for each of these.
    fn limited(&mut self) -> Vec<String> {
        let (mut odd, mut large, mut negative) = (0, 0, 0);
        for texel in &mut self.texels {
            for (c, v) in texel.iter_mut().enumerate() {
                if !v.is_finite() {
                    (*v, odd) = (0.0, odd + 1);
                } else if v.abs() > LARGEST_HALF {
                    (*v, large) = (v.clamp(-LARGEST_HALF, LARGEST_HALF), large + 1);
                }
                if self.color && c < 3 && *v < 0.0 {
                    (*v, negative) = (0.0, negative + 1);
                }
            }
        }
        let note = |n: usize, what: String| (n > 0).then(|| format!("{n} values {what}"));
        let all = [
            note(odd, "that are not finite numbers, set to 0".into()),
            note(large, format!("beyond {LARGEST_HALF}, the largest half float, cut to it")),
            note(negative, "of colours below 0, set to 0".into()),
        ];
        all.into_iter().flatten().collect()
    }

    /// The texel at column x and row y, which wrap around if they are one step outside.
    fn texel(&self, x: i32, y: i32) -> Vec4 {
        let wrap = |i: i32, n: u32| (i + n as i32) as usize % n as usize;
        self.texels
            .get(wrap(y, self.height) * self.width as usize + wrap(x, self.width))
            .map_or(Vec4::ZERO, |t| Vec4::from_array(*t))
    }

    /// The image at `uv`, repeated, by bilinear interpolation. u goes to the right, v upwards: v =
    /// 0 is the lower edge of the bottom row. Texel centres lie at half texels.
    pub fn bilinear(&self, uv: Vec2) -> [f32; 4] {
        bilinear([self.width, self.height], uv, |x, y| self.texel(x, y)).to_array()
    }

    /// The image at a point without uv: three lookups along the axes, at (y, z), (x, z) and (x, y),
    /// weighted by the fourth power of the normal's component along the axis. At `scale` 1 the
    /// image repeats every [`TRIPLANAR_CM`], at 2 twice as often. `position_cm` is the point in cm;
    /// `normal` need not be of unit length.
    pub fn triplanar(&self, position_cm: Vec3, normal: Vec3, scale: f32) -> [f32; 4] {
        let p = position_cm * (scale / TRIPLANAR_CM);
        triplanar(p, normal, |uv| Vec4::from_array(self.bilinear(uv))).to_array()
    }

    /// An image of at most [`MAX_SIDE`] texels a side, with the same aspect ratio up to rounding.
    /// Its texels are means over the boxes that they cover, parts of texels included.
    fn reduced(&self) -> Self {
        let larger = self.width.max(self.height);
        let side = |n: u32| {
            let scaled = u64::from(n) * u64::from(MAX_SIDE) / u64::from(larger);
            (scaled as u32).max(1)
        };
        let (width, height) = (side(self.width), side(self.height));
        let columns = boxes(self.width, width);
        let rows = boxes(self.height, height);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for row in &rows {
            for column in &columns {
                let mut sum = Vec4::ZERO;
                for (y, wy) in row {
                    let line = &self.texels[*y as usize * self.width as usize..][..self.width as usize];
                    for (x, wx) in column {
                        sum += Vec4::from_array(line[*x as usize]) * (wx * wy);
                    }
                }
                texels.push(sum.to_array());
            }
        }
        Self { name: self.name.clone(), layer: self.layer.clone(), color: self.color, width, height, texels }
    }
}

/// Repeating bilinear lookup in an image of `size` texels: u to the right, v up, so that v = 0 is
/// the lower edge of the bottom row. Texel centres lie at half texels. `texel` is asked for columns
/// and rows up to one outside the image.
pub fn bilinear(size: [u32; 2], uv: Vec2, texel: impl Fn(i32, i32) -> Vec4) -> Vec4 {
    let fraction = uv - uv.floor();
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    interpolate(Vec2::new(fraction.x, 1.0 - fraction.y) * size - 0.5, texel)
}

/// Bilinear interpolation at `at`, in texels: the texel in column x and row y is centred on (x, y).
pub fn interpolate(at: Vec2, texel: impl Fn(i32, i32) -> Vec4) -> Vec4 {
    let base = at.floor();
    let f = at - base;
    let (x, y) = (base.x as i32, base.y as i32);
    let row = |y| texel(x, y).lerp(texel(x.saturating_add(1), y), f.x);
    row(y).lerp(row(y.saturating_add(1)), f.y)
}

/// Three lookups of `plane` along the axes, at (y, z), (x, z) and (x, y) of `p`, weighted by the
/// fourth power of the normal's component along the axis.
// [Geiss2007]
pub fn triplanar(p: Vec3, normal: Vec3, plane: impl Fn(Vec2) -> Vec4) -> Vec4 {
    let n2 = normal * normal;
    let sum = n2.dot(n2);
    let w = if sum > 0.0 { n2 * n2 / sum } else { Vec3::Y };
    w.x * plane(Vec2::new(p.y, p.z)) + w.y * plane(Vec2::new(p.x, p.z)) + w.z * plane(Vec2::new(p.x, p.y))
}

/// For each of `to` equal intervals of `from` texels: the texels that it covers and their weights,
/// which add up to 1.
fn boxes(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let step = f64::from(from) / f64::from(to);
    (0..to)
        .map(|i| {
            let (low, high) = (f64::from(i) * step, f64::from(i + 1) * step);
            let last = (high.ceil() as u32).min(from);
            (low as u32..last)
                .map(|x| {
                    let covered = high.min(f64::from(x + 1)) - low.max(f64::from(x));
                    (x, (covered / step).max(0.0) as f32)
                })
                .collect()
        })
        .collect()
}
