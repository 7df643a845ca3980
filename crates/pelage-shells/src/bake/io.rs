//! Writes baked textures to a folder and reads them back.

use super::{
    Content, FileEntry, FurTextures, LodEntry, ManifestFile, Texels, Texture, compress,
    ktx2::{Encoding, Ktx2},
    lod::{self, LodLevel},
    manifest_schema, memory,
    mips::{self, Keep},
    png,
};
use pelage_core::files::{check_target, write_buffered};
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::FilmSpec;
use pelage_core::{Error, Result};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// Name of the manifest, which describes the other files.
pub const MANIFEST: &str = "manifest.json";

const SCHEMA: &str = "manifest.schema.json";

/// File formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// One PNG file for each layer and fin.
    Png,
    /// One OpenEXR file for each layer and fin; the only format that can be read back.
    Exr,
    /// Uncompressed KTX 2.0: the layers as an array with all mip levels, and the fin.
    Ktx2,
    /// KTX 2.0 compressed as BC3 and as BC7.
    Bc,
}

/// Options of [`write()`].
#[derive(Debug, Clone, PartialEq)]
pub struct WriteOptions {
    /// Formats to write.
    pub formats: Vec<Format>,
    /// What the mip levels of KTX 2.0 files preserve.
    pub keep: Keep,
    /// Metadata of the EXR files.
    pub metadata: Metadata,
}

impl Default for WriteOptions {
    /// All formats; mip levels for blending.
    fn default() -> Self {
        Self {
            formats: vec![Format::Png, Format::Exr, Format::Ktx2, Format::Bc],
            keep: Keep::Mean,
            metadata: Metadata::of_program(),
        }
    }
}

/// Checks that the sizes of the textures match the manifest.
///
/// # Errors
/// [`Error::Unsupported`] with the name of the texture, its size and the expected size.
pub fn check(textures: &FurTextures) -> Result<()> {
    let manifest = &textures.manifest;
    let expect = |name: String, t: &Texture, [w, h]: [u32; 2]| {
        let (found, texels) = ([t.width, t.height], t.texels.len() as u64);
        if found == [w, h] && texels == u64::from(w) * u64::from(h) && texels > 0 {
            return Ok(());
        }
        let found = format!("{} x {} ({texels} texels)", t.width, t.height);
        Err(Error::Unsupported(format!("{name} is {found}, expected {w} x {h} as the manifest says")))
    };
    for (name, part) in [("layer", &textures.layers), ("guard layer", &textures.guard)] {
        if part.len() != manifest.layers as usize && !(part.is_empty() && name == "guard layer") {
            let (found, expected) = (part.len(), manifest.layers);
            return Err(Error::Unsupported(format!(
                "{found} {name}s, expected {expected} as the manifest says"
            )));
        }
        for (l, texture) in part.iter().enumerate() {
            expect(format!("{name} {l}"), texture, manifest.resolution)?;
        }
    }
    if textures.layers.is_empty() {
        return Err(Error::Unsupported("there are no layers, expected at least one".into()));
    }
    expect("the fin".into(), &textures.fin, manifest.fin_resolution)?;
    if !textures.guard.is_empty() {
        expect("the guard hairs' fin".into(), &textures.fin_guard, manifest.fin_resolution)?;
    }
    Ok(())
}

/// Checks before a long computation that [`write()`] can write to `dir`, and creates the folder if
/// it does not exist.
///
/// # Errors
/// [`Error::Io`].
pub fn check_folder(dir: &Path) -> Result<()> {
    if dir.exists() && !dir.is_dir() {
        return Err(Error::io(dir, "is a file, expected a folder: choose another name"));
    }
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, format!("the folder cannot be made: {e}")))?;
    check_target(&dir.join(MANIFEST))
}

/// Writes textures, all levels of detail, their manifest and its schema to the folder `dir`, which
/// is created if it does not exist. Files of the same names are replaced, others are left alone.
/// Returns the paths, the manifest last: all files that it lists are complete.
///
/// # Errors
/// [`Error::Unsupported`] as [`check`]; [`Error::Usage`] without formats; [`Error::Io`].
pub fn write(textures: &FurTextures, dir: &Path, options: &WriteOptions) -> Result<Vec<PathBuf>> {
    check(textures)?;
    if options.formats.is_empty() {
        return Err(Error::Usage("no formats to write: expected at least one of png, exr, ktx2, bc".into()));
    }
    check_folder(dir)?;
    let levels = lod::coarser(textures);
    for level in 1..=levels.len() {
        let dir = dir.join(format!("lod{level}"));
        std::fs::create_dir_all(&dir)
            .map_err(|e| Error::io(&dir, format!("the folder cannot be made: {e}")))?;
    }
    let tasks = tasks(textures, &levels, &options.formats);
    let files: Vec<FileEntry> =
        tasks.par_iter().map(|task| task.write(dir, options)).collect::<Result<_>>()?;
    let manifest = ManifestFile {
        schema: SCHEMA.into(),
        manifest: textures.manifest.clone(),
        unit: "cm".into(),
        primaries: "Rec. 709".into(),
        lods: lods(textures, levels.len() as u32),
        files,
        memory: memory::table(
            textures.manifest.layers,
            textures.manifest.resolution,
            textures.manifest.fin_resolution,
        ),
    };
    let mut paths: Vec<_> = manifest.files.iter().map(|f| dir.join(&f.path)).collect();
    // The manifest is written last: when it is there, all files that it lists are there.
    let path = dir.join(SCHEMA);
    write_buffered(&path, |out| Ok(writeln!(out, "{:#}", manifest_schema())?))?;
    paths.push(path);
    let path = dir.join(MANIFEST);
    write_buffered(&path, |out| {
        serde_json::to_writer_pretty(&mut *out, &manifest)?;
        Ok(writeln!(out)?)
    })?;
    paths.push(path);
    Ok(paths)
}

fn lods(textures: &FurTextures, coarsest: u32) -> Vec<LodEntry> {
    let (layers, spacing) = (textures.manifest.layers, textures.manifest.spacing);
    let middle = |[from, to]: [u32; 2]| 0.5 * (from + to) as f32 * spacing;
    let count = |level: u32| layers.div_ceil(1 << level);
    let heights = |level| (0..count(level)).map(|j| middle(lod::slab(layers, level, j))).collect();
    (0..=coarsest).map(|level| LodEntry { level, layers: count(level), heights: heights(level) }).collect()
}

/// A file to write.
struct Task<'a> {
    path: String,
    content: Content,
    lod: u32,
    layer: Option<u32>,
    texels: Texels,
    /// The layers of an array, or a single image.
    textures: &'a [Texture],
    array: bool,
}

fn tasks<'a>(textures: &'a FurTextures, levels: &'a [LodLevel], formats: &[Format]) -> Vec<Task<'a>> {
    use Content::{Fin, FinGuard, Guard, Layers};
    let finest = [(Layers, &textures.layers), (Guard, &textures.guard)].map(|(c, t)| (c, 0, t.as_slice()));
    let coarser = (1..)
        .zip(levels)
        .flat_map(|(lod, l)| [(Layers, lod, l.layers.as_slice()), (Guard, lod, l.guard.as_slice())]);
    let mut fins = vec![(Fin, 0, std::slice::from_ref(&textures.fin))];
    if !textures.guard.is_empty() {
        fins.push((FinGuard, 0, std::slice::from_ref(&textures.fin_guard)));
    }
    let mut tasks = Vec::new();
    for (content, lod, textures) in finest.into_iter().chain(coarser).chain(fins) {
        let folder = if lod == 0 { String::new() } else { format!("lod{lod}/") };
        let (one, all) = match content {
            Layers => ("layer_", "layers"),
            Guard => ("guard_", "guard"),
            Fin => ("fin", "fin"),
            FinGuard => ("fin_guard", "fin_guard"),
        };
        let layered = matches!(content, Layers | Guard);
        let mut single = |texels, extension: &str| {
            for (layer, texture) in textures.iter().enumerate() {
                let number = if layered { format!("{layer:03}") } else { String::new() };
                tasks.push(Task {
                    path: format!("{folder}{one}{number}.{extension}"),
                    content,
                    lod,
                    layer: layered.then_some(layer as u32),
                    texels,
                    textures: std::slice::from_ref(texture),
                    array: false,
                });
            }
        };
        if formats.contains(&Format::Exr) {
            single(Texels::ExrFloat, "exr");
        }
        if formats.contains(&Format::Png) {
            single(Texels::PngStraight, "png");
        }
        // Only what a client draws; the guard hairs' contribution is for programs that light it
        // separately.
        let drawn = matches!(content, Layers | Fin);
        for (format, texels, suffix) in [
            (Format::Ktx2, Texels::Ktx2Rgba8, ""),
            (Format::Bc, Texels::Ktx2Bc3, "_bc3"),
            (Format::Bc, Texels::Ktx2Bc7, "_bc7"),
        ] {
            if drawn && formats.contains(&format) {
                let path = format!("{folder}{all}{suffix}.ktx2");
                tasks.push(Task { path, content, lod, layer: None, texels, textures, array: layered });
            }
        }
    }
    tasks
}

impl Task<'_> {
    fn write(&self, dir: &Path, options: &WriteOptions) -> Result<FileEntry> {
        let path = dir.join(&self.path);
        let fail = |e: &dyn std::fmt::Display| Error::io(&path, format!("cannot be encoded: {e}"));
        let first = self.textures.first().ok_or_else(|| fail(&"there are no layers"))?;
        let mut entry = FileEntry {
            path: self.path.clone(),
            content: self.content,
            lod: self.lod,
            layer: self.layer,
            texels: self.texels,
            size: [first.width, first.height],
            layers: if self.array { self.textures.len() as u32 } else { 0 },
            mips: 1,
            bytes: 0,
            psnr: None,
            coverage_change: None,
        };
        let bytes = match self.texels {
            Texels::ExrFloat => {
                let mut film = Film::from_premultiplied(first.width, first.height, &first.texels);
                film.planes.iter_mut().for_each(|plane| plane.full_precision = true);
                io::write(&film, &path, &options.metadata, &FilmSpec::default())?;
                entry.bytes = std::fs::metadata(&path).map_err(|e| Error::io(&path, e))?.len();
                return Ok(entry);
            }
            Texels::PngStraight => png::encode(first).map_err(|e| fail(&e))?,
            Texels::Ktx2Rgba8 => self.ktx2(Encoding::Rgba8, options, &mut entry).map_err(|e| fail(&e))?,
            Texels::Ktx2Bc3 => self.ktx2(Encoding::Bc3, options, &mut entry).map_err(|e| fail(&e))?,
            Texels::Ktx2Bc7 => self.ktx2(Encoding::Bc7, options, &mut entry).map_err(|e| fail(&e))?,
        };
        entry.bytes = bytes.len() as u64;
        write_buffered(&path, |out| Ok(out.write_all(&bytes)?))?;
        Ok(entry)
    }

    /// Encodes the file and records the compression loss in `entry`.
    fn ktx2(&self, encoding: Encoding, o: &WriteOptions, entry: &mut FileEntry) -> Result<Vec<u8>, String> {
        let wrap_v = matches!(self.content, Content::Layers | Content::Guard);
        let encoded = self.textures.par_iter().map(|texture| {
            let chain = mips::chain(texture, o.keep);
            chain
                .iter()
                .map(|mip| compress::blocks(encoding, [mip.width, mip.height], &compress::rgba8(mip), wrap_v))
                .collect::<Result<Vec<_>, _>>()
        });
        let encoded: Vec<Vec<Vec<u8>>> = encoded.collect::<Result<_, _>>()?;
        entry.mips = mips::levels(entry.size);
        let mut levels = vec![Vec::new(); entry.mips as usize];
        for layer in &encoded {
            levels.iter_mut().zip(layer).for_each(|(level, bytes)| level.extend(bytes));
        }
        if encoding != Encoding::Rgba8 {
            let (mut before, mut after) = (Vec::new(), Vec::new());
            for (texture, layer) in self.textures.iter().zip(&encoded) {
                before.extend(compress::rgba8(texture));
                let finest = layer.first().map(Vec::as_slice).unwrap_or_default();
                after.extend(compress::from_blocks(encoding, entry.size, finest)?);
            }
            let psnr = compress::psnr(&before, &after);
            entry.psnr = psnr.is_finite().then_some(psnr as f32);
            let coverage = |bytes: &[u8]| bytes.chunks_exact(4).map(|t| f64::from(t[3])).sum::<f64>();
            let (before, after) = (coverage(&before), coverage(&after));
            entry.coverage_change = (before > 0.0).then_some((after / before - 1.0) as f32);
        }
        Ktx2 { encoding, size: entry.size, layers: self.array.then_some(entry.layers), levels }.encode()
    }
}

/// Reads `manifest.json`.
///
/// # Errors
/// [`Error::Io`] for a missing or damaged file, or an unknown version.
pub fn load_manifest(path: &Path) -> Result<ManifestFile> {
    let text = std::fs::read_to_string(path).map_err(|e| {
        Error::io(path, format!("cannot be read: {e}; expected the {MANIFEST} of `pelage bake`"))
    })?;
    let file: ManifestFile = serde_json::from_str(&text).map_err(|e| {
        Error::io(path, format!("is not a manifest of baked textures: {e}; bake the textures again"))
    })?;
    if file.manifest.version != 1 {
        let found = file.manifest.version;
        return Err(Error::io(path, format!("has version {found}, expected 1: bake the textures again")));
    }
    Ok(file)
}

/// Reads the finest textures back, unchanged, from the EXR files that a manifest lists.
///
/// # Errors
/// [`Error::Io`] with the file, what was found and what was expected: files that are missing,
/// damaged or of another size than the manifest's; coverage outside 0..1 or values that are not
/// finite; a manifest without EXR files.
pub fn load(manifest: &Path) -> Result<FurTextures> {
    let file = load_manifest(manifest)?;
    let folder = manifest.parent().unwrap_or(Path::new(""));
    let find = |content, layer: Option<u32>| {
        let exr = |f: &&FileEntry| f.texels == Texels::ExrFloat && f.lod == 0;
        file.files.iter().filter(exr).find(|f| f.content == content && f.layer == layer)
    };
    let read = |content, layer: Option<u32>, size| {
        let what = layer.map_or_else(|| format!("{content:?}"), |l| format!("layer {l} of {content:?}"));
        let entry = find(content, layer).ok_or_else(|| {
            let what = what.to_lowercase();
            Error::io(manifest, format!("lists no EXR file of {what}: bake again with --formats exr"))
        })?;
        read_texture(&folder.join(&entry.path), size)
    };
    let expected = &file.manifest;
    if expected.layers == 0 {
        return Err(Error::io(manifest, "lists 0 layers, expected at least one: bake the textures again"));
    }
    let all = |content| {
        let layers = (0..expected.layers).into_par_iter();
        layers.map(|l| read(content, Some(l), expected.resolution)).collect::<Result<Vec<_>>>()
    };
    let layers = all(Content::Layers)?;
    let fin = read(Content::Fin, None, expected.fin_resolution)?;
    let has_guard = file.files.iter().any(|f| f.content == Content::Guard);
    let (guard, fin_guard) = if has_guard {
        (all(Content::Guard)?, read(Content::FinGuard, None, expected.fin_resolution)?)
    } else {
        Default::default()
    };
    Ok(FurTextures { layers, guard, fin, fin_guard, manifest: file.manifest })
}

fn read_texture(path: &Path, [width, height]: [u32; 2]) -> Result<Texture> {
    let film = io::read(path)?;
    let again = "bake the textures again";
    if [film.width, film.height] != [width, height] {
        let found = format!("{} x {}", film.width, film.height);
        return Err(Error::io(
            path,
            format!("is {found}, expected {width} x {height} as in the manifest: {again}"),
        ));
    }
    let texels = film.premultiplied()?;
    let broken = |t: &[f32; 4]| !t.iter().all(|v| v.is_finite()) || !(0.0..=1.0).contains(&t[3]);
    if let Some(at) = texels.iter().position(broken) {
        let (i, j, [r, g, b, a]) = (at as u32 % width, at as u32 / width, texels[at]);
        return Err(Error::io(
            path,
            format!(
                "has R {r}, G {g}, B {b}, A {a} at texel {i}, {j}, expected finite values and A in 0..1: {again}"
            ),
        ));
    }
    Ok(Texture { width, height, texels })
}
