//! Arguments that several subcommands share, and the parsers of their values.

use super::choice::{choice, name};
use clap::Args;
use pelage::assets::Assets;
use pelage::scene::{Blend, FurLayers, Override, Tonemap};
use pelage::{Result, Scene};
use std::path::PathBuf;

/// A scene file and its overrides.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// Scene file (TOML)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
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

/// `WxH` in pixels.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
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
