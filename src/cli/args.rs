//! Arguments that several subcommands share, and the parsers of their values.

use super::choice::{choice, name};
use clap::Args;
use pelage::assets::Assets;
use pelage::scene::{Blend, FurLayers, Override, Tonemap, Units, UpAxis};
use pelage::{Result, Scene};
use std::path::PathBuf;

/// A scene file and its overrides.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// Scene file (TOML), or a mesh (OBJ, glTF, GLB, PLY, STL), which is rendered with a preset, a
    /// camera and lights that suit it
    #[arg(value_name = "SCENE|MESH")]
    pub scene: PathBuf,
    #[command(flatten)]
    body: BodyArgs,
    /// Override a value of the scene file, e.g. -D camera.fov=30 or -D lights.0.irradiance=[1,1,1]
    #[arg(short = 'D', value_name = "KEY.PATH=VALUE", value_parser = key_value)]
    define: Vec<String>,
    /// Samples per pixel
    #[arg(long, value_name = "N", help_heading = "Scene overrides")]
    pub spp: Option<u32>,
    /// Seed of all random numbers of the fur
    #[arg(long, value_name = "N", help_heading = "Scene overrides")]
    seed: Option<u32>,
    /// Layers to render
    #[arg(long, value_parser = choice::<FurLayers>(), help_heading = "Scene overrides")]
    fur: Option<FurLayers>,
    /// Blending of undercoat and guard hairs
    #[arg(long, value_parser = choice::<Blend>(), help_heading = "Scene overrides")]
    blend: Option<Blend>,
    /// Virtual fragments per ray, for --blend virtual
    #[arg(long, value_name = "N", help_heading = "Scene overrides")]
    virtual_fragments: Option<u32>,
    /// Memory budget, e.g. 1GiB or 512MiB: GPU memory, or main memory for `reference` [default
    /// there: 8GiB]
    #[arg(long, value_name = "SIZE", value_parser = bytes, help_heading = "Scene overrides")]
    pub memory: Option<u64>,
    /// Edge of a tile in samples
    #[arg(long, value_name = "N", help_heading = "Scene overrides")]
    tile: Option<u32>,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = "Scene overrides")]
    size: Option<[u32; 2]>,
    /// Tone mapping of PNG output
    #[arg(long, value_parser = choice::<Tonemap>(), help_heading = "Scene overrides")]
    tonemap: Option<Tonemap>,
    /// Exposure in stops
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, help_heading = "Scene overrides")]
    exposure: Option<f32>,
    /// Treat mesh defects as errors instead of repairing them
    #[arg(long, help_heading = "Scene overrides")]
    strict: bool,
}

/// What a mesh does not say of itself.
#[derive(Debug, Args)]
pub(super) struct BodyArgs {
    /// Coat of the animal; `pelage presets` lists them [default for a mesh: brown_mink]
    #[arg(long, value_name = "NAME", help_heading = "Body and coat")]
    preset: Option<String>,
    /// Longest side of the body, e.g. 30cm, 0.3m or 12in
    #[arg(long, value_name = "LENGTH", value_parser = length, help_heading = "Body and coat")]
    body_size: Option<f64>,
    /// Unit of the mesh's coordinates
    #[arg(long, value_parser = choice::<Units>(), help_heading = "Body and coat")]
    units: Option<Units>,
    /// Axis of the mesh that points up
    #[arg(long, value_parser = choice::<UpAxis>(), help_heading = "Body and coat")]
    up: Option<UpAxis>,
}

impl BodyArgs {
    fn overrides(&self) -> impl Iterator<Item = Override> {
        overrides([
            ("--preset", "preset", self.preset.clone()),
            ("--body-size", "mesh.size", self.body_size.map(|v| v.to_string())),
            ("--units", "mesh.units", self.units.and_then(|v| name(&v))),
            ("--up", "mesh.up", self.up.and_then(|v| name(&v))),
        ])
    }
}

impl SceneArgs {
    /// Loads the scene with all overrides.
    pub fn load(&self) -> Result<(Scene, Assets)> {
        self.load_with(Vec::new())
    }

    /// Loads the scene with all overrides, then those of the subcommand's own flags.
    pub fn load_with(&self, own: Vec<Override>) -> Result<(Scene, Assets)> {
        let mut all = self.overrides()?;
        all.extend(own);
        Scene::load_with(&self.scene, &all)
    }

    /// `-D` in order, then the flags.
    fn overrides(&self) -> Result<Vec<Override>> {
        let mut all = self.define.iter().map(|d| Override::parse(d)).collect::<Result<Vec<_>>>()?;
        let flags = [
            ("--spp", "film.spp", self.spp.map(|v| v.to_string())),
            ("--seed", "render.seed", self.seed.map(|v| v.to_string())),
            ("--fur", "render.fur", self.fur.and_then(|v| name(&v))),
            ("--blend", "render.blend", self.blend.and_then(|v| name(&v))),
            (
                "--virtual-fragments",
                "render.virtual_fragments",
                self.virtual_fragments.map(|v| v.to_string()),
            ),
            ("--memory", "render.memory", self.memory.map(|v| v.to_string())),
            ("--tile", "render.tile", self.tile.map(|v| v.to_string())),
            ("--size", "film.width", self.size.map(|s| s[0].to_string())),
            ("--size", "film.height", self.size.map(|s| s[1].to_string())),
            ("--tonemap", "film.tonemap", self.tonemap.and_then(|v| name(&v))),
            ("--exposure", "film.exposure", self.exposure.map(|v| format!("{v:?}"))),
            ("--strict", "mesh.strict", self.strict.then(|| "true".to_owned())),
        ];
        all.extend(self.body.overrides());
        all.extend(overrides(flags));
        Ok(all)
    }
}

/// Overrides of flags that are given: the flag, the key in the scene, and the value.
pub(super) fn overrides<const N: usize>(
    flags: [(&str, &str, Option<String>); N],
) -> impl Iterator<Item = Override> {
    flags.into_iter().filter_map(|(flag, path, value)| {
        let value = value?;
        Some(Override { flag: format!("{flag} {value}"), path: path.to_owned(), value })
    })
}

/// `key.path=value`, the argument of `-D`.
pub(super) fn key_value(text: &str) -> Result<String, String> {
    Override::parse(text).map(|_| text.to_owned()).map_err(|_| "expected key.path=value".into())
}

/// A length with a unit, in cm; without a unit it is cm.
pub(super) fn length(text: &str) -> Result<f64, String> {
    let expected = || format!("expected a length above 0 such as 30cm, 300mm, 0.3m or 12in, found {text:?}");
    let digits = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let cm = match unit {
        "" | "cm" => 1.0,
        "mm" => 0.1,
        "m" => 100.0,
        "in" => 2.54,
        _ => return Err(expected()),
    };
    let length = number.trim().parse::<f64>().map_err(|_| expected())? * cm;
    if length.is_finite() && length > 0.0 { Ok(length) } else { Err(expected()) }
}

/// `WxH` in pixels.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    if let Ok(cm) = length(text) {
        return Err(format!(
            "expected WIDTHxHEIGHT of the picture in pixels, e.g. 960x568; for a body of {cm} cm give --body-size {text}"
        ));
    }
    let expected = || format!("expected WIDTHxHEIGHT in pixels, e.g. 960x568, found {text:?}");
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let side = |t: &str| t.trim().parse::<u32>().ok().filter(|n| *n > 0).ok_or_else(expected);
    Ok([side(w)?, side(h)?])
}

/// A number of bytes with an optional unit: B, kB, MB, GB (powers of 1000), or KiB, MiB, GiB
/// (powers of 1024).
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let expected = || format!("expected a size such as 1GiB, 512MiB or 2GB, found {text:?}");
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let number: f64 = number.parse().map_err(|_| expected())?;
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1_u64,
        "kb" => 1000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        _ => return Err(expected()),
    };
    let bytes = number * factor as f64;
    if bytes.is_finite() && bytes < (1_u64 << 53) as f64 { Ok(bytes as u64) } else { Err(expected()) }
}

/// `x0,x1,y0,y1` in 0..1, as in pbrt.
pub(super) fn crop(text: &str) -> Result<[f32; 4], String> {
    let expected =
        || format!("expected x0,x1,y0,y1 with 0 <= x0 < x1 <= 1 and 0 <= y0 < y1 <= 1, found {text:?}");
    let numbers: Vec<f32> =
        text.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| expected())?;
    let [x0, x1, y0, y1] = numbers[..] else { return Err(expected()) };
    let ordered = |a: f32, b: f32| (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b) && a < b;
    if ordered(x0, x1) && ordered(y0, y1) { Ok([x0, x1, y0, y1]) } else { Err(expected()) }
}

/// A finite number that is not negative.
pub(super) fn threshold(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= 0.0 => Ok(x),
        _ => Err(format!("expected a number of at least 0, found {text:?}")),
    }
}

/// A finite number of stops.
pub(super) fn stops(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.abs() <= 64.0 => Ok(x),
        _ => Err(format!("expected a number of stops from -64 to 64, found {text:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_memory() {
        assert_eq!(bytes("1GiB"), Ok(1 << 30));
        assert_eq!(bytes("1.5 MiB"), Ok(3 << 19));
        assert_eq!(bytes("2GB"), Ok(2_000_000_000));
        assert_eq!(bytes("4096"), Ok(4096));
        for bad in ["", "GiB", "1 parsec", "-1GiB", "1e400", "99999999GiB"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lengths_with_units() {
        for (text, cm) in [("30cm", 30.0), ("30", 30.0), ("300 mm", 30.0), ("0.3m", 30.0), ("10in", 25.4)] {
            assert!((length(text).unwrap() - cm).abs() < 1e-9, "{text}");
        }
        for bad in ["", "cm", "-3cm", "0", "3ft", "1e999m", "960x568"] {
            assert!(length(bad).is_err(), "{bad}");
        }
        assert!(size("30cm").unwrap_err().contains("--body-size 30cm"));
    }

    #[test]
    fn sizes_of_images() {
        assert_eq!(size("960x568"), Ok([960, 568]));
        for bad in ["960", "0x5", "x", "960x", "-1x4"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn crop_windows() {
        assert_eq!(crop("0,0.5,0.25,1"), Ok([0.0, 0.5, 0.25, 1.0]));
        for bad in ["0,1,0", "0.5,0.5,0,1", "0,2,0,1", "a,b,c,d", "nan,1,0,1"] {
            assert!(crop(bad).is_err(), "{bad}");
        }
    }
}
