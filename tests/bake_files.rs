//! Files of baked textures: levels of detail, mips, PNG, EXR, KTX2, compression, manifest, memory.

use crate::common::{self, Folder, on_threads};
use pelage_core::Error;
use pelage_core::film::composite::over;
use pelage_core::scene::BakeSource;
use pelage_fur::random::{hash, unit_float};
use pelage_shells::bake::ktx2::{Encoding, Ktx2};
use pelage_shells::bake::mips::{self, Keep};
use pelage_shells::bake::{
    self, Content, Format, FurTextures, LayerSummary, Manifest, ManifestFile, Texels, Texture, WriteOptions,
    compress, lod, memory,
};
use std::path::Path;

/// A pseudo-random number in 0..1, from an integer.
fn random(n: u32) -> f32 {
    unit_float(hash(n))
}

/// Hairs as slightly blurred dots; hair `h` is in all layers below its height, so that layers are
/// alike as in real fur.
fn layer(width: u32, height: u32, l: u32, layers: u32) -> Texture {
    let mut texels = vec![[0.0f32; 4]; (width * height) as usize];
    for h in 0..width * height / 12 {
        if random(4 * h) < l as f32 / layers as f32 * 0.8 {
            continue;
        }
        let (x, y) = ((random(4 * h + 1) * width as f32) as u32, (random(4 * h + 2) * height as f32) as u32);
        let shade = 0.2 + 0.5 * random(4 * h + 3);
        for (dx, dy, a) in [(0, 0, 0.9f32), (1, 0, 0.45), (0, 1, 0.3)] {
            let a = a * (0.6 + 0.5 * random(5 * h + 3));
            let (x, y) = ((x + dx) % width, (y + dy) % height);
            let to = &mut texels[(y * width + x) as usize];
            *to = over([0.8 * shade * a, 0.5 * shade * a, 0.3 * shade * a, a], *to);
        }
    }
    Texture { width, height, texels }
}

fn scaled(texture: &Texture, factor: f32) -> Texture {
    Texture { texels: texture.texels.iter().map(|t| t.map(|v| v * factor)).collect(), ..*texture }
}

fn textures(layers: u32, resolution: [u32; 2], fin: [u32; 2]) -> FurTextures {
    let all: Vec<_> = (0..layers).map(|l| layer(resolution[0], resolution[1], l, layers)).collect();
    let fin_texture = layer(fin[0], fin[1], 0, 1);
    let summary = LayerSummary { coverage: 0.1, optical_depth: 0.105_360_51, color: [0.3, 0.2, 0.1] };
    FurTextures {
        guard: all.iter().map(|t| scaled(t, 0.4)).collect(),
        layers: all,
        fin_guard: scaled(&fin_texture, 0.4),
        fin: fin_texture,
        manifest: Manifest {
            version: 1,
            generator: "test".into(),
            source: BakeSource::Particles,
            seed: 7,
            layers,
            resolution,
            fin_resolution: fin,
            patch: [1.0, 1.1],
            fin_length: 1.0,
            fin_depth: 0.1,
            height: 1.7,
            spacing: 1.7 / layers as f32,
            summary: vec![summary; layers as usize],
        },
    }
}

fn rolled(t: &Texture, dx: u32, dy: u32) -> Texture {
    let at = |i: u32| ((i / t.width + dy) % t.height) * t.width + (i % t.width + dx) % t.width;
    let texels = (0..t.width * t.height).map(|i| t.texels[at(i) as usize]).collect();
    Texture { texels, ..*t }
}

/// The stack over a grey, seen along the normal.
fn stack(layers: &[Texture], grey: f32) -> Vec<[f32; 4]> {
    let mut pixels = vec![[grey, grey, grey, 1.0]; layers[0].texels.len()];
    for layer in layers {
        pixels.iter_mut().zip(&layer.texels).for_each(|(p, t)| *p = over(*t, *p));
    }
    pixels
}

fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

// Levels of detail.

#[test]
fn all_levels_of_detail_look_alike_along_the_normal() {
    for layers in [1, 2, 3, 7, 16] {
        let fur = textures(layers, [24, 20], [8, 8]);
        let levels = lod::coarser(&fur);
        let counts: Vec<_> = levels.iter().map(|l| l.layers.len()).collect();
        let expected: &[usize] = match layers {
            1 => &[],
            2 => &[1],
            3 => &[2, 1],
            7 => &[4, 2, 1],
            _ => &[8, 4, 2, 1],
        };
        assert_eq!(counts, expected);
        for grey in [0.0, 1.0] {
            let finest = stack(&fur.layers, grey);
            for level in &levels {
                assert!(difference(&stack(&level.layers, grey), &finest) < 3e-6);
                // Composited in the wrong order they are not alike.
                let turned: Vec<_> = level.layers.iter().rev().cloned().collect();
                assert!(turned.len() < 2 || difference(&stack(&turned, grey), &finest) > 0.01);
            }
        }
    }
}

#[test]
fn guard_hairs_are_composited_as_they_are_seen() {
    // All fur is guard hair: then its part is the whole, at every level.
    let mut fur = textures(5, [16, 16], [8, 8]);
    fur.guard = fur.layers.clone();
    lod::coarser(&fur)
        .iter()
        .for_each(|l| assert!(difference(&l.guard[0].texels, &l.layers[0].texels) < 1e-6));
    // Guard and undercoat add up to the whole, at every level.
    let mut rest = textures(5, [16, 16], [8, 8]);
    rest.guard = rest.layers.iter().map(|t| scaled(t, 0.6)).collect();
    let part = lod::coarser(&textures(5, [16, 16], [8, 8]));
    for (a, b) in part.iter().zip(&lod::coarser(&rest)) {
        for ((a, b), whole) in a.guard.iter().zip(&b.guard).zip(&a.layers) {
            let sum: Vec<_> =
                a.texels.iter().zip(&b.texels).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect();
            assert!(difference(&sum, &whole.texels) < 1e-6);
        }
    }
    // A guard hair below opaque undercoat is not seen.
    let texel = |t: [f32; 4]| Texture { width: 1, height: 1, texels: vec![t] };
    fur.layers = vec![texel([0.5; 4]), texel([0.2, 0.2, 0.2, 1.0])];
    fur.guard = vec![texel([0.5; 4]), texel([0.0; 4])];
    assert_eq!(lod::coarser(&fur)[0].guard[0].texels, [[0.0; 4]]);
}

#[test]
fn slabs_cover_the_fur_once() {
    for layers in [1u32, 5, 16, 128] {
        for level in 0..8 {
            let slabs: Vec<_> =
                (0..layers.div_ceil(1 << level)).map(|j| lod::slab(layers, level, j)).collect();
            assert_eq!((slabs[0][0], slabs.last().unwrap()[1]), (0, layers));
            assert!(slabs.windows(2).all(|w| w[0][1] == w[1][0]) && slabs.iter().all(|s| s[0] < s[1]));
        }
    }
}

// Mips.

#[test]
fn mip_levels_keep_the_means() {
    for size in [[64, 64], [128, 32], [100, 60], [37, 5], [1, 29]] {
        let base = layer(size[0], size[1], 0, 1);
        let chain = mips::chain(&base, Keep::Mean);
        assert_eq!(chain.len() as u32, mips::levels(size));
        assert_eq!(chain[0], base);
        assert_eq!([chain.last().unwrap().width, chain.last().unwrap().height], [1, 1]);
        for (k, level) in chain.iter().enumerate() {
            assert_eq!([level.width, level.height], mips::size(size, k as u32));
            let mean = |t: &Texture, c: usize| {
                t.texels.iter().map(|t| f64::from(t[c])).sum::<f64>() / t.texels.len() as f64
            };
            for c in 0..4 {
                let (found, expected) = (mean(level, c), mean(&base, c));
                assert!(
                    (found - expected).abs() < 1e-6 * expected,
                    "{size:?} level {k}: {found}, {expected}"
                );
            }
        }
    }
}

#[test]
fn mip_levels_follow_a_shift_of_the_torus() {
    let base = layer(64, 32, 0, 1);
    for k in 1..=5 {
        let shifted = mips::chain(&rolled(&base, 3 << k, 1 << k), Keep::Mean);
        let level = &mips::chain(&base, Keep::Mean)[k as usize];
        assert_eq!(shifted[k as usize], rolled(level, 3, 1), "level {k}");
        assert_ne!(shifted[k as usize], *level);
    }
}

#[test]
fn alpha_tested_levels_keep_their_share() {
    for (size, threshold) in [([128, 128], 0.5), ([100, 60], 0.3), ([64, 64], 0.8)] {
        let base = layer(size[0], size[1], 0, 1);
        let wanted = mips::share(&base, threshold);
        let (kept, mean) = (mips::chain(&base, Keep::Share(threshold)), mips::chain(&base, Keep::Mean));
        let mut worst: f64 = 0.0;
        for (level, filtered) in kept.iter().zip(&mean) {
            // Clients have 8 bits, which move a few texels over the threshold.
            let bytes = compress::from_rgba8(level.width, level.height, &compress::rgba8(level));
            let texel = 1.0 / level.texels.len() as f64;
            for (level, most) in [(level, (0.5 * texel).max(0.02 * wanted)), (&bytes, texel.max(0.005))] {
                let error = (mips::share(level, threshold) - wanted).abs();
                assert!(error <= most, "{size:?}: {error} of {wanted} at {} wide", level.width);
            }
            worst = worst.max((mips::share(filtered, threshold) - wanted).abs());
            for (t, f) in level.texels.iter().zip(&filtered.texels).filter(|(_, f)| f[3] > 1e-6) {
                assert!((t[0] / t[3] - f[0] / f[3]).abs() < 1e-5, "colour changed: {t:?} {f:?}");
            }
        }
        // The box filter alone does not keep it, so that the test can fail.
        assert!(worst > 0.1 * wanted);
    }
    // No texel, and all texels.
    for value in [0.0, 1.0] {
        let flat = Texture { width: 8, height: 8, texels: vec![[value; 4]; 64] };
        mips::chain(&flat, Keep::Share(0.5)).iter().for_each(|l| assert_eq!(l.texels[0], [value; 4]));
    }
}

// Bytes and blocks.

#[test]
fn bytes_are_srgb_with_linear_coverage() {
    let grey = Texture { width: 1, height: 1, texels: vec![[0.214_041_14, 0.0, 1.0, 0.5]] };
    assert_eq!(compress::rgba8(&grey), [128, 0, 255, 128]);
    let t = layer(16, 16, 0, 1);
    let bytes = compress::rgba8(&t);
    assert_eq!(compress::rgba8(&compress::from_rgba8(16, 16, &bytes)), bytes);
}

#[test]
fn blocks_are_close_and_wrong_ones_are_detected() {
    for (w, h) in [(128, 128), (64, 32), (10, 6), (2, 1)] {
        let (a, b) =
            (compress::rgba8(&layer(w, h, 0, 1)), compress::rgba8(&rolled(&layer(w, h, 0, 1), 1, 0)));
        for (encoding, least) in [(Encoding::Bc3, 32.0), (Encoding::Bc7, 34.0)] {
            let blocks = compress::blocks(encoding, [w, h], &a, true).unwrap();
            assert_eq!(blocks.len() as u64, encoding.layer_bytes([w, h]));
            let back = compress::from_blocks(encoding, [w, h], &blocks).unwrap();
            let (psnr, wrong) = (compress::psnr(&a, &back), compress::psnr(&b, &back));
            println!("{w} x {h} {encoding:?}: {psnr:.1} dB; shifted by a texel {wrong:.1} dB");
            assert!(psnr > least, "{w} x {h} {encoding:?}: {psnr} dB");
            assert!(w < 16 || wrong < least - 12.0, "a shifted picture has {wrong} dB");
        }
    }
    assert_eq!(compress::psnr(&[1, 2], &[1, 2]), f64::INFINITY);
    assert!(compress::blocks(Encoding::Bc3, [4, 4], &[0; 63], true).is_err());
    assert!(compress::blocks(Encoding::Bc7, [0, 4], &[], true).is_err());
    assert!(compress::from_blocks(Encoding::Bc7, [5, 4], &[0; 16]).is_err());
}

// KTX2.

fn image(encoding: Encoding, size: [u32; 2], layers: Option<u32>) -> Ktx2 {
    let mut ktx = Ktx2 { encoding, size, layers, levels: Vec::new() };
    for level in 0..mips::levels(size) {
        let bytes = ktx.level_bytes(level) as u32;
        ktx.levels.push((0..bytes).map(|i| hash(i + 1000 * level) as u8).collect());
    }
    ktx
}

/// The `ktx2` crate reads what we write and would describe the format in the same bytes.
#[test]
fn ktx2_files_are_valid() {
    for (encoding, format) in [
        (Encoding::Rgba8, ktx2::Format::R8G8B8A8_SRGB),
        (Encoding::Bc3, ktx2::Format::BC3_SRGB_BLOCK),
        (Encoding::Bc7, ktx2::Format::BC7_SRGB_BLOCK),
    ] {
        for (size, layers) in [([16, 8], Some(3)), ([10, 7], Some(1)), ([512, 64], None)] {
            let ktx = image(encoding, size, layers);
            let file = ktx.encode().unwrap();
            let reader = ktx2::Reader::new(&file).unwrap();
            let header = reader.header();
            assert_eq!(header.format, Some(format));
            assert_eq!([header.pixel_width, header.pixel_height, header.pixel_depth], [size[0], size[1], 0]);
            assert_eq!(
                (header.layer_count, header.face_count, header.type_size),
                (layers.unwrap_or(0), 1, 1)
            );
            assert_eq!((header.level_count, header.supercompression_scheme), (mips::levels(size), None));
            let (expected, _) = ktx2::dfd::Basic::from_format_with(format, true, None, None, None).unwrap();
            assert_eq!(reader.basic_dfd(), Some(&expected));
            assert_eq!(reader.is_alpha_premultiplied(), Some(true));
            assert_eq!(reader.transfer_function(), Some(ktx2::TransferFunction::SRGB));
            assert!(reader.writer().is_some_and(|w| w.starts_with("pelage ")));
            let levels: Vec<_> = reader.levels().map(|l| l.data.to_vec()).collect();
            assert_eq!(levels, ktx.levels);
            // The coarsest comes first, each at a multiple of its block.
            let at = |l: usize| u64::from_le_bytes(file[80 + 24 * l..88 + 24 * l].try_into().unwrap());
            assert!((1..levels.len()).all(|l| at(l) < at(l - 1)));
            assert!((0..levels.len()).all(|l| at(l) % u64::from(encoding.block_bytes()) == 0));
            assert_eq!(at(0) + levels[0].len() as u64, file.len() as u64);
            assert_eq!(Ktx2::decode(&file), Ok(ktx));
        }
    }
}

#[test]
fn broken_ktx2_files_are_errors() {
    let good = image(Encoding::Rgba8, [8, 8], Some(2));
    let file = good.encode().unwrap();
    for length in 0..file.len() {
        assert!(Ktx2::decode(&file[..length]).is_err(), "cut at {length}");
    }
    for (at, what) in [
        (0, "identifier"),
        (12, "vkFormat"),
        (20, "level"),
        (28, "pixelDepth"),
        (32, "level"),
        (36, "faceCount"),
        (40, "level"),
        (44, "supercompression"),
        (80 + 8, "level"),
        (48, "descriptor"),
    ] {
        let mut bad = file.clone();
        bad[at] ^= 0x35;
        let error = Ktx2::decode(&bad).unwrap_err();
        assert!(error.contains(what), "byte {at}: {error}");
    }
    let mut short = good.clone();
    short.levels[1].pop();
    assert!(short.encode().unwrap_err().contains("level 1"));
    assert!(Ktx2 { layers: Some(0), ..good.clone() }.encode().is_err());
    assert!(Ktx2 { levels: Vec::new(), ..good }.encode().is_err());
}

// Memory.

#[test]
fn the_papers_memory_table_is_reproduced() {
    let table = memory::table(16, [128, 128], [512, 64]);
    let all = &table[0];
    assert_eq!(all.bytes_with_mips, 16 * 87_380 + 174_780);
    assert_eq!(format!("{:.3}", all.bytes_with_mips as f64 / 1e6), "1.573");
    assert_eq!(all.paper.as_deref(), Some("1.6 MB with mips"));
    let ratio = all.bytes_with_mips as f64 / table[1].bytes_with_mips as f64;
    assert!((3.9..=4.0).contains(&ratio), "{ratio}");
    let single = &table[3];
    assert_eq!(single.bytes, 2 * 128 * 128 * 4 + 512 * 64 * 4);
    assert!(memory::table(17, [128, 128], [512, 64]).iter().all(|row| row.paper.is_none()));
}

// Folders of files.

fn write(fur: &FurTextures, dir: &Path, formats: &[Format]) -> ManifestFile {
    let options = WriteOptions { formats: formats.to_vec(), ..WriteOptions::default() };
    let files = bake::write(fur, dir, &options).unwrap();
    assert_eq!(files.last().unwrap(), &dir.join(bake::MANIFEST));
    files.iter().for_each(|f| assert!(f.is_file(), "{}", f.display()));
    bake::load_manifest(&dir.join(bake::MANIFEST)).unwrap()
}

const ALL: [Format; 4] = [Format::Png, Format::Exr, Format::Ktx2, Format::Bc];

#[test]
fn textures_come_back_exactly() {
    let folder = Folder::new();
    let mut fur = textures(5, [20, 12], [32, 8]);
    // Values that are not half floats.
    fur.layers[2].texels[7] = [0.123_456_79, 1.0e-30, 0.333_333_34, 0.999_999_9];
    let file = write(&fur, folder.path(), &ALL);
    let path = folder.path().join(bake::MANIFEST);
    assert!(bake::load(&path).unwrap() == fur);
    assert_eq!(file.manifest, fur.manifest);
    fur.guard.clear();
    fur.fin_guard = Texture::default();
    write(&fur, folder.path(), &[Format::Exr]);
    assert!(bake::load(&path).unwrap() == fur);
}

#[test]
fn the_manifest_lists_what_is_there() {
    let folder = Folder::new();
    let file = write(&textures(5, [20, 12], [32, 8]), folder.path(), &ALL);
    assert_eq!(file.lods.iter().map(|l| l.layers).collect::<Vec<_>>(), [5, 3, 2, 1]);
    let close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close(&file.lods[1].heights, &[0.34, 1.02, 1.53]), "{:?}", file.lods[1].heights);
    // 5 + 3 + 2 + 1 layers with their guard hairs as two formats, 2 fins as two; 4 levels and a fin
    // as three KTX2.
    assert_eq!(file.files.len(), 11 * 2 * 2 + 2 * 2 + 5 * 3);
    for f in &file.files {
        let path = folder.path().join(&f.path);
        assert_eq!(std::fs::metadata(&path).unwrap().len(), f.bytes, "{}", f.path);
        let bytes = std::fs::read(&path).unwrap();
        match f.texels {
            Texels::ExrFloat | Texels::PngStraight => assert_eq!((f.layers, f.mips), (0, 1)),
            Texels::Ktx2Rgba8 | Texels::Ktx2Bc3 | Texels::Ktx2Bc7 => {
                let ktx = Ktx2::decode(&bytes).unwrap();
                assert_eq!((ktx.size, ktx.layers.unwrap_or(0)), (f.size, f.layers), "{}", f.path);
                assert_eq!(ktx.levels.len() as u32, f.mips);
                assert_eq!(ktx.layers.is_none(), f.content == Content::Fin);
            }
        }
    }
    // The manifest fits its schema.
    let json = common::json(folder.path().join("manifest.json"));
    let schema = common::json(folder.path().join(json["$schema"].as_str().unwrap()));
    for key in schema["required"].as_array().unwrap() {
        assert!(!json[key.as_str().unwrap()].is_null(), "{key}");
    }
    for key in json.as_object().unwrap().keys() {
        assert!(schema["properties"][key].is_object(), "{key} is not in the schema");
    }
    assert_eq!(json["unit"], "cm");
}

#[test]
fn the_uncompressed_array_holds_layers_and_their_mips() {
    let folder = Folder::new();
    let fur = textures(3, [16, 8], [32, 8]);
    write(&fur, folder.path(), &[Format::Ktx2]);
    let ktx = Ktx2::decode(&std::fs::read(folder.path().join("layers.ktx2")).unwrap()).unwrap();
    for (l, texture) in fur.layers.iter().enumerate() {
        for (level, mip) in ktx.levels.iter().zip(mips::chain(texture, Keep::Mean)) {
            let bytes = level.len() / 3;
            assert_eq!(&level[l * bytes..(l + 1) * bytes], compress::rgba8(&mip));
        }
    }
}

#[test]
fn pngs_are_straight_and_have_no_dark_fringes() {
    let folder = Folder::new();
    let mut fur = textures(1, [16, 16], [8, 8]);
    fur.layers[0].texels =
        (0..256).map(|i| if i % 16 == 3 { [0.5, 0.25, 0.1, 0.5] } else { [0.0; 4] }).collect();
    write(&fur, folder.path(), &[Format::Png]);
    let png = image::open(folder.path().join("layer_000.png")).unwrap().into_rgba8();
    // Linear 1, 0.5 and 0.2 as sRGB.
    assert_eq!(png.get_pixel(3, 5).0, [255, 188, 124, 128]);
    assert!(png.pixels().all(|p| p.0[..3] == [255, 188, 124]), "colour where nothing covers");
    assert_eq!(png.get_pixel(4, 5).0[3], 0);
}

#[test]
fn the_same_bytes_whatever_the_threads() {
    let fur = textures(4, [32, 32], [16, 8]);
    let bytes = |threads| {
        let folder = Folder::new();
        let file = on_threads(threads, || write(&fur, folder.path(), &ALL));
        let read = |f: &str| std::fs::read(folder.path().join(f)).unwrap();
        let mut all: Vec<_> = file.files.iter().map(|f| read(&f.path)).collect();
        all.push(read(bake::MANIFEST));
        all
    };
    assert!(bytes(1) == bytes(3));
}

fn reason(result: Result<FurTextures, Error>) -> String {
    match result {
        Err(error) => {
            assert_eq!(error.exit_code(), 1);
            error.to_string()
        }
        Ok(_) => panic!("expected an error"),
    }
}

#[test]
fn errors_of_broken_folders_name_the_file() {
    let folder = Folder::new();
    let fur = textures(3, [16, 8], [32, 8]);
    write(&fur, folder.path(), &[Format::Exr]);
    let path = folder.path().join(bake::MANIFEST);
    let good = std::fs::read_to_string(&path).unwrap();
    let layer = folder.path().join("layer_001.exr");
    let bytes = std::fs::read(&layer).unwrap();
    let expect = |parts: &[&str]| {
        let reason = reason(bake::load(&path));
        parts.iter().for_each(|part| assert!(reason.contains(part), "no {part:?} in {reason}"));
    };

    std::fs::remove_file(&layer).unwrap();
    expect(&["layer_001.exr", "cannot be opened"]);
    std::fs::write(&layer, &bytes[..bytes.len() / 2]).unwrap();
    expect(&["layer_001.exr", "cannot be read"]);
    std::fs::copy(folder.path().join("fin.exr"), &layer).unwrap();
    expect(&["layer_001.exr", "32 x 8", "16 x 8", "again"]);
    std::fs::write(&layer, &bytes).unwrap();
    assert!(bake::load(&path).is_ok());

    for (from, to, parts) in [
        ("\"version\": 1", "\"version\": 9", &["version 9", "expected 1"][..]),
        (
            "\"layers\": 3,\n  \"resolution\"",
            "\"layers\": 4,\n  \"resolution\"",
            &["layer 3", "--formats exr"],
        ),
        ("\"layers\": 3,\n  \"resolution\"", "\"layers\": 0,\n  \"resolution\"", &["0 layers"]),
        ("\"spacing\"", "\"gap\"", &["spacing", "again"]),
        ("{", "(", &["manifest.json", "line 1"]),
    ] {
        assert!(good.contains(from), "{from} is not in {good}");
        std::fs::write(&path, good.replacen(from, to, 1)).unwrap();
        expect(parts);
    }
    std::fs::remove_file(&path).unwrap();
    expect(&["manifest.json", "pelage bake"]);

    // Impossible coverage.
    let mut bad = fur.clone();
    bad.layers[2].texels[17] = [0.0, f32::NAN, 0.0, 0.5];
    write(&bad, folder.path(), &[Format::Exr]);
    expect(&["layer_002.exr", "texel 1, 1", "NaN"]);
    write(&fur, folder.path(), &[Format::Ktx2]);
    expect(&["--formats exr"]);
}

#[test]
fn inconsistent_textures_are_errors() {
    let folder = Folder::new();
    let good = textures(3, [16, 8], [32, 8]);
    let expect_error = |fur: &FurTextures, part: &str| {
        let error = bake::write(fur, folder.path(), &WriteOptions::default()).unwrap_err().to_string();
        assert!(error.contains(part), "no {part:?} in {error}");
    };
    let mut bad = good.clone();
    bad.layers[1].texels.pop();
    expect_error(&bad, "layer 1 is 16 x 8 (127 texels)");
    let mut bad = good.clone();
    bad.layers.pop();
    expect_error(&bad, "2 layers, expected 3");
    let mut bad = good.clone();
    bad.fin = Texture::default();
    expect_error(&bad, "the fin is 0 x 0");
    let mut bad = good.clone();
    bad.layers.clear();
    bad.guard.clear();
    bad.manifest.layers = 0;
    expect_error(&bad, "no layers");
    assert!(folder.names().is_empty());
    let options = WriteOptions { formats: Vec::new(), ..WriteOptions::default() };
    assert_eq!(bake::write(&good, folder.path(), &options).unwrap_err().exit_code(), 2);
}
