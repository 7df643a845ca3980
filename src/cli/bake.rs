//! `pelage bake`.

use super::Global;
use super::args::{self, SceneArgs};
use super::choice::{choice, name};
use super::output::{self, count, human_bytes};
use clap::Args;
use pelage::film::Metadata;
use pelage::scene::{BakeSource, Override};
use pelage::shells::{self, Content, Format, Keep, ManifestFile, WriteOptions};
use pelage::{Error, Result, World};
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage bake scenes/default.toml -o fur/ --gltf
  pelage bake scenes/default.toml -o fur/ --layers 32 --resolution 256x256 --formats png")]
pub(super) struct BakeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Folder for the textures and their manifest; created if it does not exist
    #[arg(long = "outdir", short = 'o', value_name = "DIR", required = true)]
    outdir: PathBuf,
    /// Source of the hair in the textures
    #[arg(long, value_parser = choice::<BakeSource>())]
    source: Option<BakeSource>,
    /// Number of layers, 1 to 128
    #[arg(long, value_name = "N")]
    layers: Option<u32>,
    /// Size of a layer in texels
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    resolution: Option<[u32; 2]>,
    /// Edge of the square that the texture covers and repeats, cm
    #[arg(long, value_name = "CM")]
    patch: Option<f32>,
    /// File formats: layers as PNG and EXR, arrays as KTX2, uncompressed (ktx2) or in BC3 and BC7
    /// (bc)
    #[arg(long, value_parser = choice::<Format>(), value_delimiter = ',', default_value = "png,exr,ktx2,bc", value_name = "LIST")]
    formats: Vec<Format>,
    /// For alpha-tested layers: mip levels of KTX2 files preserve the share of texels at or above
    /// this coverage. [default: they preserve the mean coverage, for blended layers]
    #[arg(long, value_name = "COVERAGE", value_parser = share)]
    alpha_test: Option<f32>,
    /// Also write fur.gltf for real-time viewers such as web/shells: the skin with its hair, the
    /// edges for fins, and the camera
    #[arg(long)]
    gltf: bool,
    /// Print the manifest as JSON instead of the table
    #[arg(long)]
    json: bool,
}

fn share(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err(format!("expected a number above 0 and at most 1, found {text:?}")),
    }
}

/// Bakes textures and prints their sizes.
pub(super) fn run(args: &BakeArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load_with(args.overrides())?;
    if args.gltf && !args.formats.contains(&Format::Ktx2) {
        return Err(Error::Usage(
            "--gltf: the glTF file refers to the uncompressed KTX2 arrays; add ktx2 to --formats".into(),
        ));
    }
    shells::check_folder(&args.outdir)?;
    let mut world = World::load(scene, &assets)?;
    output::admit(&mut world, false, global.quiet)?;
    output::print_notes(&notes_of_objects(&world, args.gltf), global.quiet);
    let textures = shells::bake(&world)?;
    let metadata = Metadata::of_program()
        .with_scene(&toml::to_string(&world.scene).unwrap_or_default())
        .with_seed(world.scene.render.seed);
    let options = WriteOptions {
        formats: args.formats.clone(),
        keep: args.alpha_test.map_or(Keep::Mean, Keep::Share),
        metadata,
    };
    let mut files = shells::write(&textures, &args.outdir, &options)?;
    if args.gltf {
        let lapped = shells::lap(&world.skin, &world.scene)?;
        files.extend(shells::gltf::write(&world, &lapped, &textures, &args.outdir)?);
    }
    let manifest = shells::load_manifest(&args.outdir.join(shells::MANIFEST))?;
    if args.json {
        output::print_json(&output::to_json(&manifest, "manifest")?)
    } else if global.quiet {
        Ok(())
    } else {
        output::print(&summary(args, &manifest, files.len()))
    }
}

/// What becomes of the scene's objects, if it has any.
fn notes_of_objects(world: &World, gltf: bool) -> Vec<String> {
    match (world.objects.len(), gltf) {
        (0, _) => Vec::new(),
        (_, true) => shells::gltf::notes(world),
        (count, false) => {
            let names: Vec<_> = world.objects.iter().map(|o| format!("{:?}", o.name)).collect();
            let names = names.join(", ");
            vec![format!("textures hold the fur alone: found {count} objects that are not baked: {names}")]
        }
    }
}

impl BakeArgs {
    /// Overrides of the flags.
    fn overrides(&self) -> Vec<Override> {
        let source = self.source.and_then(|s| name(&s));
        let resolution = self.resolution.map(|[w, h]| format!("[{w}, {h}]"));
        let flags = [
            ("--source", "bake.source", source),
            ("--layers", "bake.layers", self.layers.map(|n| n.to_string())),
            ("--resolution", "bake.resolution", resolution),
            ("--patch", "bake.patch", self.patch.map(|cm| format!("{cm:?}"))),
        ];
        args::overrides(flags).collect()
    }
}

/// What was written, and the table of texture memory, as in Lengyel et al. 2001.
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
