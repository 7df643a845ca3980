//! Mattes in EXR files: ids, ranks, sums, the header; and those of a rendering.

use crate::common::{Folder, pelage};
use pelage_core::Error;
use pelage_core::film::cryptomatte::{Matte, USUAL_RANKS, add, hash, id};
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::FilmSpec;
use std::collections::BTreeMap;

#[test]
fn hashes_are_those_of_the_reference() {
    for (name, wanted) in [
        ("", 0),
        ("hello", 0x248b_fa47),
        ("hello, world", 0x149b_bb7f),
        ("19 Jan 2038 at 3:14:07 AM", 0xe31e_8a70),
        ("The quick brown fox jumps over the lazy dog.", 0xd5c4_8bfc),
    ] {
        assert_eq!(hash(name), wanted, "{name:?}: {:08x}", hash(name));
    }
}

/// Names and ids of the sample pictures that come with the specification.
#[test]
fn ids_are_those_of_the_specification() {
    for (name, wanted) in [("bunny", 0x1385_1a76), ("default", 0x42c9_679f)] {
        assert_eq!(id(name).to_bits(), wanted, "{name:?}: {:08x}", id(name).to_bits());
    }
}

#[test]
fn ids_are_ordinary_numbers() {
    let mut mended = 0;
    for i in 0..20_000 {
        let name = format!("object {i}");
        assert!(id(&name).is_normal(), "{name}");
        mended += u32::from(id(&name).to_bits() != hash(&name));
    }
    // Two of 256 exponents.
    assert!((100..220).contains(&mended), "{mended}");
}

/// Pairs of id and coverage of a pixel, read as a compositor does.
fn pairs(film: &Film, set: &str, pixel: usize) -> Vec<(u32, f32)> {
    let mut pairs = Vec::new();
    for layer in 0.. {
        for [id, coverage] in [["r", "g"], ["b", "a"]] {
            let plane = |c: &str| film.plane(&format!("{set}{layer:02}.{c}"));
            let (Some(id), Some(coverage)) = (plane(id), plane(coverage)) else { return pairs };
            if coverage[pixel] > 0.0 {
                pairs.push((id[pixel].to_bits(), coverage[pixel]));
            }
        }
    }
    pairs
}

/// Manifest of a set: names by id.
fn manifest(meta: &Metadata, set: &str) -> BTreeMap<u32, String> {
    let key = meta
        .attributes
        .iter()
        .find(|(name, value)| name.ends_with("/name") && value == set)
        .map(|(name, _)| name.strip_suffix("name").unwrap().to_owned())
        .expect("the set's name");
    assert_eq!(key, format!("cryptomatte/{}/", &format!("{:08x}", hash(set))[..7]));
    assert_eq!(meta.attribute(&format!("{key}hash")), Some("MurmurHash3_32"));
    assert_eq!(meta.attribute(&format!("{key}conversion")), Some("uint32_to_float32"));
    let text = meta.attribute(&format!("{key}manifest")).expect("a manifest");
    let names: BTreeMap<String, String> = serde_json::from_str(text).unwrap();
    names.into_iter().map(|(name, hex)| (u32::from_str_radix(&hex, 16).unwrap(), name)).collect()
}

fn film(planes: &[(&str, Vec<f32>)]) -> Film {
    let mut film = Film::new(planes[0].1.len() as u32, 1);
    planes.iter().for_each(|(name, data)| film.push(*name, true, data.clone()));
    film
}

#[test]
fn mattes_come_back_from_a_file() {
    let folder = Folder::new();
    let mut film = film(&[
        ("a.A", vec![0.25, 0.0, 0.5, -0.1]),
        ("b.A", vec![0.5, 0.0, 0.125, 0.6]),
        ("c.A", vec![0.125, 1.0, 0.25, 0.3]),
    ]);
    let mattes =
        [Matte::new("ä \"b\"", &["a.A"]), Matte::new("both", &["b.A"]), Matte::new("third", &["c.A"])];
    let meta = add(&mut film, Metadata::of_program(), "CryptoObject", &mattes).unwrap();
    let meta = add(&mut film, meta, "CryptoMaterial", &[Matte::new("all", &["a.A", "b.A", "c.A"])]).unwrap();
    let path = folder.path().join("a.exr");
    io::write(&film, &path, &meta, &FilmSpec::default()).unwrap();
    let (film, meta) = (io::read(&path).unwrap(), io::read_metadata(&path).unwrap());
    assert!(film.planes.iter().filter(|p| p.name.starts_with("Crypto")).all(|p| p.full_precision));
    let names = manifest(&meta, "CryptoObject");
    let named = |pixel| -> Vec<(&str, f32)> {
        pairs(&film, "CryptoObject", pixel).iter().map(|(id, c)| (names[id].as_str(), *c)).collect()
    };
    assert_eq!(named(0), [("both", 0.5), ("ä \"b\"", 0.25), ("third", 0.125)]);
    assert_eq!(named(1), [("third", 1.0)]);
    assert_eq!(named(2), [("ä \"b\"", 0.5), ("third", 0.25), ("both", 0.125)]);
    // A negative lobe: the others give way, so that the sum stays.
    let last = named(3);
    assert_eq!((last[0].0, last[1].0, last.len()), ("both", "third", 2));
    assert!((last.iter().map(|(_, c)| c).sum::<f32>() - 0.8).abs() < 1e-6, "{last:?}");
    let all = manifest(&meta, "CryptoMaterial");
    assert_eq!(pairs(&film, "CryptoMaterial", 0), [(*all.first_key_value().unwrap().0, 0.875)]);
}

#[test]
fn a_pixel_with_many_mattes_keeps_all_of_them() {
    let names: Vec<String> = (0..9).map(|i| format!("m{i}.A")).collect();
    let planes: Vec<(&str, Vec<f32>)> =
        names.iter().enumerate().map(|(i, n)| (n.as_str(), vec![0.01 * (i + 1) as f32, 0.0])).collect();
    let mut film = film(&planes);
    let mattes: Vec<Matte> = names.iter().map(|n| Matte::new(n, &[n])).collect();
    let before = film.planes.len();
    add(&mut film, Metadata::default(), "CryptoObject", &mattes).unwrap();
    let found = pairs(&film, "CryptoObject", 0);
    assert_eq!((found.len(), film.planes.len() - before), (9, 2 * 10));
    assert!((found[0].1 - 0.09).abs() < 1e-6 && (found[8].1 - 0.01).abs() < 1e-6, "{found:?}");
    // Where no pixel has many, a file has the usual ranks.
    film.planes.truncate(before);
    film.planes[before - 3..].iter_mut().for_each(|plane| plane.data.fill(0.0));
    add(&mut film, Metadata::default(), "CryptoObject", &mattes).unwrap();
    assert_eq!(film.planes.len() - before, 2 * USUAL_RANKS);
}

#[test]
fn faults_of_mattes_are_named() {
    let mut film = film(&[("a.A", vec![0.5])]);
    let mut fault = |mattes: &[Matte]| match add(&mut film, Metadata::default(), "CryptoObject", mattes) {
        Err(Error::Unsupported(text)) => text,
        other => panic!("{other:?}"),
    };
    assert!(fault(&[Matte::new("x", &["b.A"])]).contains("no plane b.A"));
    assert!(fault(&[Matte::new("x", &["a.A"]), Matte::new("x", &["a.A"])]).contains("\"x\" and \"x\""));
}

/// Renders the small scene of the tests to an EXR file.
fn rendered(folder: &Folder, more: &[&str]) -> Option<(Film, Metadata)> {
    crate::common::gpu::open()?;
    let path = folder.at("a.exr");
    pelage(&[&["render", "tests/data/small.toml", "-o", &path], more].concat()).expect(0, &[]);
    Some((io::read(&path).unwrap(), io::read_metadata(&path).unwrap()))
}

#[test]
fn a_rendering_has_mattes_of_layers_and_of_the_object() {
    let folder = Folder::new();
    let background = "film.background='color'";
    for blend in ["exact", "simplified"] {
        let Some((film, meta)) = rendered(&folder, &["--blend", blend, "--spp", "4", "-D", background])
        else {
            return;
        };
        let (layers, objects) = (manifest(&meta, "CryptoLayer"), manifest(&meta, "CryptoObject"));
        assert_eq!(layers.values().collect::<Vec<_>>().len(), 3);
        assert_eq!(objects.values().collect::<Vec<_>>(), ["pyramid"]);
        let through = film.plane("transmittance.Y").unwrap();
        let mut totals: BTreeMap<&str, f32> = BTreeMap::new();
        for (i, through) in through.iter().enumerate() {
            let (of_layers, of_object) = (pairs(&film, "CryptoLayer", i), pairs(&film, "CryptoObject", i));
            for (id, coverage) in &of_layers {
                *totals.entry(layers[id].as_str()).or_default() += coverage;
            }
            for found in [of_layers, of_object] {
                assert!(found.windows(2).all(|w| w[0].1 >= w[1].1), "{found:?}");
                let sum: f32 = found.iter().map(|(_, c)| c).sum();
                assert!((sum - (1.0 - through)).abs() < 1e-4, "pixel {i}: {sum}, {through}");
            }
        }
        assert!(["guard", "undercoat", "skin"].iter().all(|name| totals[name] > 1.0), "{totals:?}");
    }
}

#[test]
fn shells_have_the_matte_of_their_object() {
    let folder = Folder::new();
    let Some((film, meta)) = rendered(
        &folder,
        &["--fur", "shells", "-D", "bake.resolution=[32,32]", "-D", "film.background=transparent"],
    ) else {
        return;
    };
    let key = |name: &str| meta.attributes.iter().any(|(_, value)| value == name);
    assert!(key("CryptoObject") && !key("CryptoLayer"));
    let (alpha, coverage) = (film.plane("A").unwrap(), film.plane("CryptoObject00.g").unwrap());
    // Alpha is stored as half, coverage as float.
    assert!(alpha.iter().zip(coverage).all(|(a, c)| (a - c.max(0.0)).abs() < 1e-3));
    assert!(coverage.iter().any(|c| *c > 0.9));
}
