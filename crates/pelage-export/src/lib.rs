//! Writes a scene, with every hair a strand, for other renderers: Mitsuba 3, pbrt-v4, Blender
//! (Cycles), OpenUSD and HAIR files.
//!
//! Lengths are cm in all of them. What a target cannot express is listed in comments at the
//! beginning of its main file, the one to open. Large arrays go to files beside it, written as they
//! are computed. The main file is written last, so that it never names a missing file.

mod blender;
pub mod curves;
mod deviations;
mod hair;
pub mod material;
mod mitsuba;
mod objects;
mod pbrt;
mod ply;
pub mod sky;
mod usd;
pub mod view;

use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::light::Light;
use pelage_core::scene::Color;
use pelage_core::{Error, Result, Skin, World, files, mesh};
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint};
use pelage_pathtrace::strands::Strands;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sky::Sky;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The program that a scene is written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Mitsuba 3: scene.xml, B-spline curves as text, PLY, PFM.
    Mitsuba,
    /// pbrt-v4: scene.pbrt with included files, PLY, PFM.
    Pbrt,
    /// Blender 4 and later with Cycles: scene.py, HAIR, PLY, HDR map as EXR.
    Blender,
    /// OpenUSD in text form: scene.usda.
    Usd,
    /// Cem Yuksel's HAIR format, one file per layer, and the skin as OBJ. Objects are left out.
    Hair,
}

impl Target {
    /// The main file: the one to open.
    pub fn head(self) -> &'static str {
        match self {
            Self::Mitsuba => "scene.xml",
            Self::Pbrt => "scene.pbrt",
            Self::Blender => "scene.py",
            Self::Usd => "scene.usda",
            Self::Hair => "skin.obj",
        }
    }
}

/// What the environment is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EnvironmentAs {
    /// An environment map, or a uniform sky.
    #[default]
    Map,
    /// The directional lights that this program converts it to.
    Lights,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// The file's path.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// A description of its content with counts; empty for the main file.
    pub holds: String,
}

/// Everything that an exporter reads.
pub(crate) struct Job<'a> {
    pub world: &'a World,
    pub strands: &'a [Strands],
    pub objects: Vec<objects::Exported<'a>>,
    pub sky: Option<Sky>,
    /// The directional lights that `sky` does not include.
    pub lights: Vec<Light>,
    pub view: view::View,
    folder: &'a Path,
    written: Vec<Written>,
}

/// Writes `world` with `strands` to `folder` for `target`. The folder is created if its parent
/// exists.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be created or a file cannot be written; [`Error::Scene`] for
/// an environment map that cannot be read; [`Error::Unsupported`] for more points than a HAIR file
/// holds.
pub fn write(
    world: &World,
    strands: &[Strands],
    assets: &Assets,
    target: Target,
    environment: EnvironmentAs,
    folder: &Path,
) -> Result<Vec<Written>> {
    check_folder(folder, target)?;
    let sky = match (&world.scene.environment, environment) {
        (Some(spec), EnvironmentAs::Map) => Some(Sky::load(spec, assets)?),
        _ => None,
    };
    let lights = world.lights.iter().filter(|l| sky.is_none() || !l.environment).copied().collect();
    let view = view::View::of(&world.scene);
    let objects = objects::of(world);
    let mut job = Job { world, strands, objects, sky, lights, view, folder, written: Vec::new() };
    let notes = deviations::of(&job, target);
    match target {
        Target::Mitsuba => mitsuba::write(&mut job, notes)?,
        Target::Pbrt => pbrt::write(&mut job, notes)?,
        Target::Blender => blender::write(&mut job, &notes)?,
        Target::Usd => usd::write(&mut job, &notes)?,
        Target::Hair => hair::write(&mut job)?,
    }
    Ok(job.written)
}

/// Creates the folder if its parent exists, and checks that the main file can be written. To be
/// called before long computations.
///
/// # Errors
/// [`Error::Io`] with the folder or file and the reason.
pub fn check_folder(folder: &Path, target: Target) -> Result<()> {
    if !folder.is_dir() {
        std::fs::create_dir(folder)
            .map_err(|e| Error::io(folder, format!("the folder cannot be created: {e}")))?;
    }
    files::check_target(&folder.join(target.head()))
}

impl Job<'_> {
    /// Writes a file in the folder; `holds` describes its content.
    fn file<F>(&mut self, name: &str, holds: String, write: F) -> Result<()>
    where
        F: FnOnce(&Self, &mut dyn Write) -> io::Result<()>,
    {
        let path = self.folder.join(name);
        files::write_buffered(&path, |out| Ok(write(self, out)?))?;
        self.wrote(path, holds)
    }

    /// Records a file that was written.
    fn wrote(&mut self, path: PathBuf, holds: String) -> Result<()> {
        let bytes = std::fs::metadata(&path).map_err(|e| Error::io(&path, e))?.len();
        self.written.push(Written { path, bytes, holds });
        Ok(())
    }

    /// Writes the skin as OBJ.
    fn obj(&mut self, name: &str) -> Result<()> {
        let path = self.folder.join(name);
        mesh::write_obj(&self.world.skin, &path)?;
        let mut holds = self.skin_holds();
        if !self.objects.is_empty() {
            let names: Vec<_> = self.objects.iter().map(|o| format!("{:?}", o.object.name)).collect();
            holds += &format!("; left out are the objects {}", names.join(", "));
        }
        self.wrote(path, holds)
    }

    /// Description of the skin.
    fn skin_holds(&self) -> String {
        format!("{} triangles", self.world.skin.triangles.len())
    }

    /// The first line of every file that has comments.
    fn title() -> String {
        format!(
            "Written by pelage {}. Lengths in cm, colours linear RGB (sRGB primaries).",
            env!("CARGO_PKG_VERSION")
        )
    }
}

/// Reflectance of the skin, linear RGB: one value, or one per vertex if it comes from a map or from
/// vertex colours.
pub fn skin_colors(world: &World) -> Vec<Vec3> {
    let (skin, color) = (&world.skin, &world.scene.base.color);
    if !world.scene.parts.is_empty() {
        return colors_with_parts(world);
    }
    colors_on(world, color, skin, world.scene.mesh.translate)
}

/// A colour on `surface`, which was moved by `origin`, linear RGB: one value, or one per vertex if
/// it comes from a map or from vertex colours.
fn colors_on(world: &World, color: &Color, surface: &Skin, origin: [f32; 3]) -> Vec<Vec3> {
    let map = match color {
        Color::Constant(c) => return vec![Vec3::from(*c)],
        Color::Mapped(map) => map,
    };
    let value = Vec3::from(map.value);
    let clamped = |c: Vec3| (c * value).clamp(Vec3::ZERO, Vec3::ONE);
    if map.map == pelage_core::maps::VERTEX_COLOR {
        return surface.colors.iter().map(|c| clamped(*c)).collect();
    }
    let Some(index) = world.maps.index_of(&map.map, &map.layer, true) else {
        return vec![clamped(Vec3::ONE)];
    };
    let image = &world.maps.images[index];
    let texel = |[r, g, b, _]: [f32; 4]| clamped(Vec3::new(r, g, b));
    if surface.corner_uv.is_none() {
        let origin = Vec3::from(origin);
        let at = |i: usize| texel(image.triplanar(surface.positions[i] - origin, surface.normals[i], 1.0));
        return (0..surface.positions.len()).map(at).collect();
    }
    let uv = pelage_fur::surface::vertex_uv(surface);
    uv.into_iter().map(|uv| texel(image.bilinear(uv.into()))).collect()
}

/// [`skin_colors`] by the packed groom, which knows the parts; one value if they are all the same.
fn colors_with_parts(world: &World) -> Vec<Vec3> {
    let skin = &world.skin;
    let (groom, texels, _) = pelage_fur::groom::pack_parameters(world, None);
    let maps = Maps { groom: &groom, texels: &texels };
    let uv = pelage_fur::surface::vertex_uv(skin);
    let at = |v: usize| SkinPoint {
        position: skin.positions[v],
        normal: skin.normals[v],
        uv: uv[v].into(),
        color: skin.vertex_color(v),
        place: MeshPlace::Vertex(v as u32),
    };
    let color = |v| maps.color(Parameter::BaseColor, &at(v)).clamp(Vec3::ZERO, Vec3::ONE);
    let mut colors: Vec<Vec3> = (0..skin.positions.len()).map(color).collect();
    if colors.windows(2).all(|pair| pair[0] == pair[1]) {
        colors.truncate(1);
    }
    colors
}

/// The mean of [`skin_colors`].
fn mean(colors: &[Vec3]) -> Vec3 {
    colors.iter().sum::<Vec3>() / colors.len().max(1) as f32
}
