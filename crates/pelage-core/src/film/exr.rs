//! OpenEXR: all planes, linear, half float for colours and 32-bit float for the rest.

use super::primaries::{self, Primaries, REC709};
use super::{Film, Metadata, Plane, limits::check_size};
use crate::files::Failure;
use crate::scene::OutputSpace;
use ::exr::{
    image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer},
    meta::{
        MetaData,
        attribute::{AttributeValue, Chromaticities, LineOrder, Text},
        header::{Header, LayerAttributes},
    },
    prelude::{Blocks, Compression, ReadChannels, ReadLayers, Vec2, WritableImage, read},
};
use half::f16;
use rayon::prelude::*;
use std::{
    fs::File,
    io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write},
};

/// Prefix of the metadata's keys in a file.
const PREFIX: &str = "pelage.";

fn attribute_of(p: Primaries) -> Chromaticities {
    let [red, green, blue] = p.rgb.map(|[x, y]| Vec2(x, y));
    Chromaticities { red, green, blue, white: Vec2(p.white[0], p.white[1]) }
}

fn primaries_of(a: Chromaticities) -> Primaries {
    let pair = |v: Vec2<f32>| [v.x(), v.y()];
    Primaries { rgb: [a.red, a.green, a.blue].map(pair), white: pair(a.white) }
}

/// Encodes one part with a channel per plane, losslessly compressed; colours in `space`. The bytes
/// depend on the arguments alone.
///
/// Finite values beyond the range of half are clamped to it (65504); write them with
/// `full_precision` to keep them.
pub(super) fn encode(
    film: &Film,
    file: &mut File,
    meta: &Metadata,
    space: OutputSpace,
) -> Result<(), Failure> {
    let primaries = Primaries::of(space);
    let mut converted = None;
    if space != OutputSpace::Rec709 {
        let matrix = REC709.to(&primaries).ok_or("found primaries on a line")?;
        primaries::convert(converted.insert(film.clone()), &matrix);
    }
    let film = converted.as_ref().unwrap_or(film);
    let channels = film.planes.par_iter().map(|plane| {
        let samples = if plane.full_precision {
            FlatSamples::F32(plane.data.clone())
        } else {
            FlatSamples::F16(plane.data.iter().map(|v| half_of(*v)).collect())
        };
        AnyChannel::new(text(&plane.name), samples)
    });
    let channels: Vec<_> = channels.collect();
    let mut attributes = LayerAttributes {
        software_name: Some(text(concat!("pelage ", env!("CARGO_PKG_VERSION")))),
        // The white that viewers should show as white, where it is not the usual one.
        adopted_neutral: converted.as_ref().map(|_| Vec2(primaries.white[0], primaries.white[1])),
        ..LayerAttributes::default()
    };
    for (key, value) in &meta.entries {
        attributes.other.insert(text(&format!("{PREFIX}{key}")), AttributeValue::Text(text(value)));
    }
    for (name, value) in &meta.attributes {
        attributes.other.insert(text(name), AttributeValue::Text(text(value)));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        // Without a line order, blocks would be written as threads finish them.
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        (film.width as usize, film.height as usize),
        attributes,
        encoding,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut out = BufWriter::new(&mut *file);
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(attribute_of(primaries));
    image.write().to_buffered(&mut out)?;
    out.flush()?;
    drop(out);
    sort_attributes(file)
}

fn text(s: &str) -> Text {
    // The format specifies no encoding; its library and viewers use UTF-8.
    Text::from_slice_unchecked(s.as_bytes())
}

fn half_of(value: f32) -> f16 {
    let limit = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-limit, limit) } else { value })
}

/// Sorts the attributes of a single-part file by name: the exr crate keeps them in a hash map,
/// whose order differs from run to run.
fn sort_attributes(file: &mut File) -> Result<(), Failure> {
    // Magic number and version flags; then name, type, length and value of each attribute; then a
    // zero byte.
    file.seek(SeekFrom::Start(8))?;
    let mut input = BufReader::new(&mut *file);
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    loop {
        let mut attribute = zero_terminated(&mut input)?;
        if attribute.len() == 1 {
            break;
        }
        attribute.extend(zero_terminated(&mut input)?);
        let mut length = [0; 4];
        input.read_exact(&mut length)?;
        attribute.extend(length);
        let mut value = vec![0; usize::try_from(i32::from_le_bytes(length))?];
        input.read_exact(&mut value)?;
        attribute.extend(value);
        attributes.push(attribute);
    }
    drop(input);
    attributes.sort();
    file.seek(SeekFrom::Start(8))?;
    Ok(file.write_all(&attributes.concat())?)
}

fn zero_terminated(input: &mut impl Read) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    loop {
        let mut byte = [0];
        input.read_exact(&mut byte)?;
        bytes.push(byte[0]);
        if byte[0] == 0 {
            return Ok(bytes);
        }
    }
}

/// Decodes all channels of all parts. `bytes` is the length of the file. `R G B A` become those of
/// `layer`; where it is empty, of the first layer that has them. `color`: colours become those of
/// Rec. 709 where the file names other primaries, which is added to `notes`.
pub(super) fn decode(
    input: &mut BufReader<File>,
    bytes: u64,
    layer: &str,
    color: bool,
    notes: &mut Vec<String>,
) -> Result<Film, Failure> {
    let headers = MetaData::read_from_buffered(&mut *input, false)?.headers;
    check_headers(&headers, bytes)?;
    input.rewind()?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(&mut *input)?;
    let size = headers[0].layer_size;
    let mut film =
        Film { width: u32::try_from(size.x())?, height: u32::try_from(size.y())?, planes: Vec::new() };
    let parts = image.layer_data.len();
    for layer in image.layer_data {
        let part = layer.attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
        for channel in layer.channel_data.list {
            let mut name = channel.name.to_string();
            if parts > 1 && !part.is_empty() && !name.starts_with(&format!("{part}.")) {
                name = format!("{part}.{name}");
            }
            let (full_precision, data) = match channel.sample_data {
                FlatSamples::F16(values) => (false, values.par_iter().map(|v| v.to_f32()).collect()),
                FlatSamples::F32(values) => (true, values),
                FlatSamples::U32(values) => (true, values.par_iter().map(|v| *v as f32).collect()),
            };
            film.planes.push(Plane { name, full_precision, data });
        }
    }
    film.validate()?;
    if let Some(found) = image.attributes.chromaticities.filter(|_| color) {
        to_rec709(&mut film, &primaries_of(found), notes);
    }
    select(&mut film, layer)?;
    complete(&mut film)?;
    film.validate()?;
    Ok(film)
}

/// Converts the colours of a film with the given primaries.
fn to_rec709(film: &mut Film, found: &Primaries, notes: &mut Vec<String>) {
    if found.is(&REC709) {
        return;
    }
    match found.to(&REC709) {
        Some(matrix) => {
            primaries::convert(film, &matrix);
            let name = if found.is(&primaries::AP1) { " (ACEScg)" } else { "" };
            notes.push(format!("its primaries are {found}{name}: converted to Rec. 709"));
        }
        None => notes.push(format!("warning: its primaries make no sense ({found}): read as Rec. 709")),
    }
}

/// Checks everything that the header says before the pixels are allocated.
fn check_headers(headers: &[Header], bytes: u64) -> Result<(), Failure> {
    let first = headers.first().ok_or("found no header, expected an OpenEXR file")?;
    let channels: usize = headers.iter().map(|h| h.channels.list.len()).sum();
    let mut table = 0u64;
    for header in headers {
        let (Vec2(width, height), Vec2(x, y)) = (header.layer_size, header.own_attributes.layer_position);
        check_size(width as u64, height as u64, channels as u64)?;
        let display = header.shared_attributes.display_window;
        if display.size != header.layer_size || display.position != header.own_attributes.layer_position {
            return Err(format!(
                "found a data window ({width} x {height} at {x}, {y}) that differs from the display window ({} x {} at {}, {}): \
                 save the image uncropped",
                display.size.x(),
                display.size.y(),
                display.position.x(),
                display.position.y()
            )
            .into());
        }
        if header.layer_size != first.layer_size {
            return Err("found parts of different sizes: save them as separate files".into());
        }
        if header.deep {
            return Err("found deep data, which is not supported: flatten the image".into());
        }
        if let Some(c) = header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
            return Err(format!(
                "found the subsampled channel {}, which is not supported: save it at full resolution",
                c.name
            )
            .into());
        }
        table = table.saturating_add((header.chunk_count as u64).saturating_mul(8));
    }
    // With a forged size, the table of block offsets alone would not fit into the file.
    if table > bytes {
        return Err(format!(
            "found a header whose table of blocks takes {table} bytes in a file of {bytes} bytes: it is truncated or damaged"
        )
        .into());
    }
    Ok(())
}

/// Names of the layers (parts or channels' prefixes) with channels R, G and B, or Y.
fn layers(film: &Film) -> Vec<String> {
    let has = |layer: &str, channel: &str| film.plane(&format!("{layer}.{channel}")).is_some();
    let mut found: Vec<String> = Vec::new();
    for plane in &film.planes {
        let Some((layer, _)) = plane.name.rsplit_once('.') else { continue };
        let coloured = ["R", "G", "B"].iter().all(|c| has(layer, c)) || has(layer, "Y");
        if coloured && !found.iter().any(|name| name == layer) {
            found.push(layer.to_owned());
        }
    }
    found
}

/// Renames the channels of `layer` to `R G B A` or `Y A`, in place of those that have these names;
/// without a name those of the first layer, if none has these names.
fn select(film: &mut Film, layer: &str) -> Result<(), Failure> {
    let plain = film.plane("Y").is_some() || ["R", "G", "B"].iter().all(|c| film.plane(c).is_some());
    if layer.is_empty() && plain {
        return Ok(());
    }
    let found = layers(film);
    let chosen = if layer.is_empty() { found.first() } else { found.iter().find(|name| *name == layer) };
    let Some(chosen) = chosen else {
        if layer.is_empty() {
            return Ok(());
        }
        let list = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
        return Err(format!(
            "found no layer \"{layer}\" with channels R, G, B or Y, expected one of: {list}"
        )
        .into());
    };
    let named = |name: &str| {
        name.strip_prefix(chosen.as_str())
            .and_then(|rest| rest.strip_prefix('.'))
            .filter(|c| ["R", "G", "B", "A", "Y"].contains(c))
            .map(str::to_owned)
    };
    film.planes.retain(|p| !["R", "G", "B", "A", "Y"].contains(&p.name.as_str()));
    for plane in &mut film.planes {
        if let Some(channel) = named(&plane.name) {
            plane.name = channel;
        }
    }
    Ok(())
}

/// Ensures planes `R G B A`, in front of the other planes.
fn complete(film: &mut Film) -> Result<(), Failure> {
    if ["R", "G", "B"].iter().any(|name| film.plane(name).is_none()) {
        let grey = film.planes.iter().position(|p| p.name == "Y").ok_or_else(|| {
            let found = film.planes.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
            format!("found the channels {found}, expected R, G, B or Y")
        })?;
        let grey = film.planes.remove(grey);
        film.planes.retain(|p| !["R", "G", "B"].contains(&p.name.as_str()));
        for name in ["R", "G", "B"] {
            film.push(name, grey.full_precision, grey.data.clone());
        }
    }
    if film.plane("A").is_none() {
        film.push("A", false, vec![1.0; film.pixels()]);
    }
    // Stable: the rest keeps the order of the file.
    film.planes.sort_by_key(|p| ["R", "G", "B", "A"].iter().position(|n| *n == p.name).unwrap_or(4));
    Ok(())
}

/// The `pelage.*` attributes, and those of Cryptomatte, by name.
pub(super) fn decode_metadata(input: &mut BufReader<File>) -> Result<Metadata, Failure> {
    let mut meta = Metadata::default();
    for header in MetaData::read_from_buffered(input, false)?.headers {
        for (name, value) in &header.own_attributes.other {
            let name = String::from_utf8_lossy(name.as_slice()).into_owned();
            let AttributeValue::Text(value) = value else { continue };
            let value = String::from_utf8_lossy(value.as_slice());
            if let Some(key) = name.strip_prefix(PREFIX) {
                meta = meta.with(key, value);
            } else if name.starts_with("cryptomatte/") {
                meta = meta.with_attribute(&name, value);
            }
        }
    }
    meta.entries.sort();
    meta.attributes.sort();
    Ok(meta)
}
