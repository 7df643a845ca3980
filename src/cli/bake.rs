//! `pelage bake`.

use super::choice::{choice, word};
use super::{
    Global,
    args::{self, SceneArgs},
    output::{self, count, human_bytes},
};
use clap::Args;
use pelage_core::film::Metadata;
use pelage_core::scene::{BakeSource, Override};
use pelage_core::{Error, Result, World};
use pelage_shells::bake::mips::Keep;
use pelage_shells::bake::{Content, Format, ManifestFile, WriteOptions};
use pelage_shells::{bake, lapped};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct BakeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the textures and their manifest; made where it does not exist.
    #[arg(long = "outdir", short = 'o', value_name = "DIR", required = true)]
    outdir: PathBuf,
    /// What is baked.
    #[arg(long, value_parser = choice::<BakeSource>())]
    source: Option<BakeSource>,
    /// Layers, 1 to 128.
    #[arg(long, value_name = "N")]
    layers: Option<u32>,
    /// Texels of a layer.
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    resolution: Option<[u32; 2]>,
    /// Edge of the torus that the texture covers, cm.
    #[arg(long, value_name = "CM")]
    patch: Option<f32>,
    /// Formats: PNG and EXR layers, KTX2 arrays uncompressed (ktx2) and as BC3 and BC7 (bc).
    #[arg(long, value_parser = choice::<Format>(), value_delimiter = ',', default_value = "png,exr,ktx2,bc", value_name = "LIST")]
    formats: Vec<Format>,
    /// Mip levels of KTX2 files keep the share of texels at or above this coverage, for alpha-tested layers; not given: the
    /// mean coverage, for blended ones.
    #[arg(long, value_name = "COVERAGE", value_parser = share)]
    alpha_test: Option<f32>,
    /// Write fur.gltf besides: the skin with hair, edges for fins and the scene's view, for real-time clients (web/shells shows it).
    #[arg(long)]
    gltf: bool,
    /// Print the manifest as JSON instead of the table.
    #[arg(long)]
    json: bool,
}

fn share(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err(format!("expected a number above 0 and at most 1, found {text:?}")),
    }
}

/// Bakes textures and prints what they take.
pub(super) fn run(args: &BakeArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load_with(args.overrides())?;
    if args.gltf && !args.formats.contains(&Format::Ktx2) {
        return Err(Error::Usage(
            "--gltf: the glTF names the uncompressed KTX2 arrays, add ktx2 to --formats".into(),
        ));
    }
    bake::check_folder(&args.outdir)?;
    let world = World::load(scene, &assets)?;
    if !global.quiet {
        world.skin.notes.iter().for_each(|note| eprintln!("note: {note}"));
    }
    let textures = bake::bake(&world)?;
    let metadata = Metadata::of_program()
        .with_scene(&toml::to_string(&world.scene).unwrap_or_default())
        .with_seed(world.scene.render.seed);
    let options = WriteOptions {
        formats: args.formats.clone(),
        keep: args.alpha_test.map_or(Keep::Mean, Keep::Share),
        metadata,
    };
    let mut files = bake::write(&textures, &args.outdir, &options)?;
    if args.gltf {
        let lapped = lapped::lap(&world.skin, &world.scene)?;
        files.extend(bake::gltf::write(&world, &lapped, &textures, &args.outdir)?);
    }
    let manifest = bake::load_manifest(&args.outdir.join(bake::MANIFEST))?;
    if args.json {
        let json = serde_json::to_value(&manifest)
            .map_err(|e| Error::Encoding(format!("the manifest cannot be written as JSON: {e}")))?;
        output::print_json(&json)
    } else if global.quiet {
        Ok(())
    } else {
        output::print(&summary(args, &manifest, files.len()))
    }
}

impl BakeArgs {
    /// The flags as values of the scene.
    fn overrides(&self) -> Vec<Override> {
        let source = self.source.and_then(|s| word(&s));
        let resolution = self.resolution.map(|[w, h]| format!("[{w}, {h}]"));
        let flags = [
            ("--source", "bake.source", source),
            ("--layers", "bake.layers", self.layers.map(|n| n.to_string())),
            ("--resolution", "bake.resolution", resolution),
            ("--patch", "bake.patch", self.patch.map(|cm| format!("{cm:?}"))),
        ];
        flags
            .into_iter()
            .filter_map(|(flag, path, value)| {
                value.map(|value| Override { flag: format!("{flag} {value}"), path: path.into(), value })
            })
            .collect()
    }
}

/// What was written, and the memory table of Lengyel et al. 2001.
fn summary(args: &BakeArgs, file: &ManifestFile, files: usize) -> String {
    let m = &file.manifest;
    let bytes: u64 = file.files.iter().map(|f| f.bytes).sum();
    let mut text = format!(
        "{}: {} layers of {} x {} texels, {} x {} cm, {} cm high; fin of {} x {} texels; {files} files, {}\n",
        args.outdir.display(),
        m.layers,
        m.resolution[0],
        m.resolution[1],
        m.patch[0],
        m.patch[1],
        m.height,
        m.fin_resolution[0],
        m.fin_resolution[1],
        human_bytes(bytes)
    );
    text += &format!(
        "{:<62} {:>12} {:>12}  Lengyel et al. 2001\n",
        "texture memory, bytes", "finest", "with mips"
    );
    for row in &file.memory {
        let paper = row.paper.as_deref().unwrap_or("-");
        text += &format!(
            "{:<62} {:>12} {:>12}  {paper}\n",
            row.what,
            count(row.bytes),
            count(row.bytes_with_mips)
        );
    }
    for f in file.files.iter().filter(|f| f.lod == 0 && f.content == Content::Layers) {
        if let Some(change) = f.coverage_change {
            let psnr = f.psnr.map_or("lossless".into(), |db| format!("PSNR {db:.1} dB"));
            text += &format!("{}: {psnr}, mean coverage {:+.2}%\n", f.path, 100.0 * change);
        }
    }
    text
}
