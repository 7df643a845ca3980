//! `pelage lapped`: a mesh covered with overlapping patches of one small texture.

use super::choice::{choice, name};
use super::output::{self, count};
use super::{Global, args};
use clap::Args;
use pelage::assets::Assets;
use pelage::film::{Metadata, io};
use pelage::scene::{FieldSource, FilmSpec, Override, Tonemap};
use pelage::shells::{self, Statistics};
use pelage::{Error, Result, Scene};
use pelage_core::{files, mesh};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct LappedArgs {
    /// Scene file, or a mesh (OBJ) with default settings
    #[arg(value_name = "SCENE.toml|MESH.obj")]
    input: PathBuf,
    /// Folder for patches.obj, patches.png, field.png and lapped.json; created if it does not exist
    #[arg(long = "outfile", short = 'o', value_name = "FOLDER")]
    outfile: PathBuf,
    /// Override a value of the scene file, e.g. -D mesh.size=10
    #[arg(short = 'D', value_name = "KEY.PATH=VALUE", value_parser = args::key_value)]
    define: Vec<String>,
    /// Radius of a patch's outline in cm
    #[arg(long, value_name = "CM", help_heading = "Scene overrides")]
    radius: Option<f32>,
    /// Irregularity of the outline, 0..0.9
    #[arg(long, value_name = "PART", help_heading = "Scene overrides")]
    irregularity: Option<f32>,
    /// Source of the hair's direction field
    #[arg(long, value_parser = choice::<FieldSource>(), help_heading = "Scene overrides")]
    field: Option<FieldSource>,
    /// Let patches overlap within their outlines
    #[arg(long, help_heading = "Scene overrides")]
    overlapping: bool,
    /// Rotate each patch at random instead of aligning it with the direction field
    #[arg(long, help_heading = "Scene overrides")]
    isotropic: bool,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", help_heading = "Scene overrides")]
    seed: Option<u32>,
}

/// Pixels along the longer side of the pictures.
const SIDE: u32 = 960;

pub(super) fn run(args: &LappedArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.load()?;
    let folder = &args.outfile;
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, format!("cannot be created: {e}")))?;
    let [obj, picture, field, json] =
        ["patches.obj", "patches.png", "field.png", "lapped.json"].map(|name| folder.join(name));
    [&obj, &picture, &field, &json].into_iter().try_for_each(|path| files::check_target(path))?;
    let skin = mesh::load(&scene.mesh, &|name| assets.find(name))?;
    output::print_notes(&skin.notes, global.quiet);
    let lapped = shells::lap(&skin, &scene)?;
    let statistics = lapped.statistics(&skin)?;
    shells::write_obj(&lapped, &skin, &obj)?;
    let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
    let meta = Metadata::of_program().with_seed(scene.render.seed);
    io::write(&shells::patch_picture(&lapped, &skin, SIDE), &picture, &meta, &spec)?;
    io::write(&shells::field_picture(&lapped, &skin, SIDE), &field, &meta, &spec)?;
    let value = serde_json::json!({
        "generator": concat!("pelage ", env!("CARGO_PKG_VERSION")),
        "mesh": scene.mesh,
        "lapped": scene.lapped,
        "seed": scene.render.seed,
        "statistics": statistics,
    });
    output::write_json(&json, &value)?;
    if global.quiet { Ok(()) } else { output::print(&text(&statistics, folder)) }
}

impl LappedArgs {
    fn load(&self) -> Result<(Scene, Assets)> {
        let overrides = self.overrides()?;
        if !self.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
            return Scene::load_with(&self.input, &overrides);
        }
        // A scene of this mesh alone.
        let name = self.input.display().to_string();
        let assets = Assets::of_folder(Path::new("."));
        assets.find(&name)?;
        let text = format!("[mesh]\npath = {}\n", toml::Value::String(name.clone()));
        let overrides: Vec<String> = overrides.iter().map(|o| format!("{}={}", o.path, o.value)).collect();
        Ok((Scene::parse(&text, &name, &overrides)?, assets))
    }

    /// `-D` in order, then the flags.
    fn overrides(&self) -> Result<Vec<Override>> {
        let mut all = self.define.iter().map(|d| Override::parse(d)).collect::<Result<Vec<_>>>()?;
        let field = self.field.and_then(|v| name(&v));
        let flags = [
            ("--radius", "lapped.radius", self.radius.map(|v| format!("{v:?}"))),
            ("--irregularity", "lapped.irregularity", self.irregularity.map(|v| format!("{v:?}"))),
            ("--field", "lapped.field", field),
            ("--overlapping", "lapped.overlapping", self.overlapping.then(|| "true".to_owned())),
            ("--isotropic", "lapped.aligned", self.isotropic.then(|| "false".to_owned())),
            ("--seed", "render.seed", self.seed.map(|v| v.to_string())),
        ];
        all.extend(args::overrides(flags));
        Ok(all)
    }
}

fn text(s: &Statistics, folder: &Path) -> String {
    let degrees = |angle: Option<f64>| angle.map_or("n/a".to_owned(), |a| format!("{a:.1}°"));
    let mut text = format!("{}\n", folder.display());
    text += &format!("faces        {}\n", count(s.faces));
    text += &format!(
        "patches      {} of radius {:.4} cm, {} of a single face\n",
        count(s.patches),
        s.radius,
        count(s.single_face_patches)
    );
    text += &format!("coverage     {:.2}% in {:.2} layers\n", 100.0 * s.coverage, s.layers);
    text += &format!("stretch      {:.3} mean, {:.3} worst\n", s.mean_stretch, s.worst_stretch);
    text += &format!(
        "angle error  {} mean, {} worst\n",
        degrees(s.mean_angle_error),
        degrees(s.worst_angle_error)
    );
    text += &format!("seams        {:.1} cm\n", s.seam_length);
    text += &format!("flipped      {}\n", count(s.flipped));
    text += &format!("time         {:.0} ms\n", s.time_ms);
    text
}
