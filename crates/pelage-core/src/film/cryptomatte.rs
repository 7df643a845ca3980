//! Cryptomatte: mattes of named things, several per pixel, that compositors pick by name.
//!
//! A *set* of mattes is a typed layer of the file, such as `CryptoObject`. Each pixel lists the
//! mattes that cover it as pairs of an id (the hash of the name, as a float) and a coverage, sorted
//! by coverage: the channels `CryptoObject00.r g b a` hold the first two pairs,
//! `CryptoObject01.r g b a` the next two. The header maps names to ids.
// [FriedmanJones2015]

use super::{Film, Metadata};
use crate::{Error, Result};
use rayon::prelude::*;
use std::io::Cursor;

/// Pairs per pixel that a file has if there are as many mattes, as compositors usually expect; more
/// only where a pixel needs them.
pub const USUAL_RANKS: usize = 6;

/// A named thing and the planes whose sum is its coverage, premultiplied (0..1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matte {
    /// Name, any UTF-8 text.
    pub name: String,
    /// Names of planes of the film.
    pub planes: Vec<String>,
}

impl Matte {
    /// A matte from planes that the film holds.
    pub fn new(name: impl Into<String>, planes: &[&str]) -> Self {
        Self { name: name.into(), planes: planes.iter().map(|p| (*p).to_owned()).collect() }
    }
}

/// MurmurHash3_x86_32 of a name's UTF-8, seed 0.
pub fn hash(name: &str) -> u32 {
    // Reading from memory does not fail.
    murmur3::murmur3_32(&mut Cursor::new(name.as_bytes()), 0).unwrap_or_default()
}

/// The id of a name: the float with the bits of its hash, of which one is flipped where they would
/// make a denormal number, an infinity or a NaN.
pub fn id(name: &str) -> f32 {
    let bits = hash(name);
    let exponent = (bits >> 23) & 255;
    f32::from_bits(if exponent == 0 || exponent == 255 { bits ^ (1 << 23) } else { bits })
}

/// Adds the set called `set` to a film and its description to `meta`. Every pixel's coverages add
/// up to the sum of the mattes' planes; with negative lobes of the reconstruction filter, negative
/// coverages become 0 and the others are scaled. Returns the metadata.
///
/// # Errors
/// [`Error::Unsupported`] for a plane that the film lacks, for names that occur twice or share an
/// id, and for a set that the film already has.
pub fn add(film: &mut Film, meta: Metadata, set: &str, mattes: &[Matte]) -> Result<Metadata> {
    film.validate()?;
    let ids: Vec<f32> = mattes.iter().map(|m| id(&m.name)).collect();
    for (i, matte) in mattes.iter().enumerate() {
        if let Some(k) = ids[..i].iter().position(|id| id.to_bits() == ids[i].to_bits()) {
            return Err(Error::Unsupported(format!(
                "found the mattes \"{}\" and \"{}\" with the same id in {set}, expected different ones: rename one",
                mattes[k].name, matte.name
            )));
        }
    }
    let planes = |matte: &Matte| -> Result<Vec<&[f32]>> {
        let found = |name: &String| {
            film.plane(name).ok_or_else(|| {
                Error::Unsupported(format!(
                    "found no plane {name} in the film, expected it for the matte \"{}\"",
                    matte.name
                ))
            })
        };
        matte.planes.iter().map(found).collect()
    };
    let coverages: Vec<Vec<&[f32]>> = mattes.iter().map(planes).collect::<Result<_>>()?;
    let of_pixel = |i: usize| {
        let sum = |of: &Vec<&[f32]>| of.iter().map(|plane| plane[i]).sum::<f32>();
        let raw: Vec<f32> = coverages.iter().map(sum).collect();
        let (all, positive) = (raw.iter().sum::<f32>(), raw.iter().map(|c| c.max(0.0)).sum::<f32>());
        let scale = if all < positive { all.max(0.0) / positive } else { 1.0 };
        let mut pairs: Vec<(f32, f32)> =
            ids.iter().zip(&raw).filter(|(_, c)| **c > 0.0).map(|(id, c)| (*id, c * scale)).collect();
        pairs.sort_by(|a, b| b.1.total_cmp(&a.1)); // stable: the order of the table decides
        pairs
    };
    let mut pixels: Vec<_> = (0..film.pixels()).into_par_iter().map(of_pixel).collect();
    let needed = pixels.iter().map(Vec::len).max().unwrap_or(0);
    let ranks = mattes.len().clamp(1, USUAL_RANKS).max(needed).div_ceil(2) * 2;
    pixels.iter_mut().for_each(|pairs| pairs.resize(ranks, (0.0, 0.0)));
    for rank in 0..ranks {
        let [id, coverage] = if rank % 2 == 0 { ["r", "g"] } else { ["b", "a"] };
        let layer = rank / 2;
        film.push(format!("{set}{layer:02}.{id}"), true, pixels.iter().map(|p| p[rank].0).collect());
        let coverages = pixels.iter().map(|p| p[rank].1).collect();
        film.push(format!("{set}{layer:02}.{coverage}"), true, coverages);
    }
    film.validate()?;
    Ok(describe(meta, set, mattes))
}

/// The attributes of a set.
fn describe(meta: Metadata, set: &str, mattes: &[Matte]) -> Metadata {
    let manifest: serde_json::Map<String, serde_json::Value> =
        mattes.iter().map(|m| (m.name.clone(), format!("{:08x}", id(&m.name).to_bits()).into())).collect();
    let key = &format!("{:08x}", hash(set))[..7];
    meta.with_attribute(&format!("cryptomatte/{key}/name"), set)
        .with_attribute(&format!("cryptomatte/{key}/hash"), "MurmurHash3_32")
        .with_attribute(&format!("cryptomatte/{key}/conversion"), "uint32_to_float32")
        .with_attribute(
            &format!("cryptomatte/{key}/manifest"),
            serde_json::Value::Object(manifest).to_string(),
        )
}
