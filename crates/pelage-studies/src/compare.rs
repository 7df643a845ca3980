//! Differences between two images in light, structure and perception: over all pixels, at the
//! silhouette, and inside.

mod metric;
mod perceptual;
mod region;
mod spectrum;

pub use metric::{METRICS, Metric, Metrics, Sense, Thresholds};
pub use region::Region;
pub use spectrum::OCTAVES;

use glam::Vec3;
use pelage_core::film::Film;
use pelage_core::film::tonemap::{luminance, srgb_decode, srgb_encode};
use pelage_core::{Error, Result};
use serde::Serialize;

/// Added to the squared reference value in the denominator of relative errors.
// [Rousselle2011] sec. 3.1
const RELATIVE_FLOOR: f64 = 1e-2;

/// Differences of an image from a reference.
///
/// Pixels that are infinite or not a number in either image are counted and left out; FLIP and SSIM
/// treat them as black. In JSON an infinite or undefined number becomes `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Pixels of the image that are infinite or not a number.
    pub non_finite_image: u64,
    /// Pixels of the reference that are infinite or not a number.
    pub non_finite_reference: u64,
    /// First and last exposure of HDR-FLIP, stops.
    pub hdr_flip_exposures: [f64; 2],
    /// Over all pixels.
    #[serde(flatten)]
    pub all: Metrics,
    /// Over the pixels near the outline of the reference; `None` if it has none.
    pub silhouette: Option<Metrics>,
    /// Over the pixels that the reference covers, without the silhouette; `None` if there are none.
    pub inside: Option<Metrics>,
}

/// Settings of [`compare_with`], which apply to both images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Stops, for the metrics of displayed images (PSNR, SSIM, FLIP). Of the metrics of linear
    /// light only RMSE, the largest difference and the floor of relative MSE depend on it: they use
    /// exposed values.
    pub exposure: f64,
    /// Width of the silhouette on each side of the outline, pixels.
    pub band: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { exposure: 0.0, band: 8.0 }
    }
}

/// Kinds of [`error_image`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ErrorImage {
    /// The FLIP error in the magma colour map: black 0, white 1.
    Flip,
    /// The HDR-FLIP error in the same colour map.
    HdrFlip,
    /// Absolute difference of each channel, times a factor.
    Difference(f32),
    /// Relative error of each channel (the root of the terms of relative MSE), times a factor.
    Relative(f32),
}

impl Comparison {
    /// The metrics of a region.
    pub fn region(&self, region: Region) -> Option<&Metrics> {
        match region {
            Region::All => Some(&self.all),
            Region::Silhouette => self.silhouette.as_ref(),
            Region::Inside => self.inside.as_ref(),
        }
    }

    /// The metrics past their limits over all pixels, as [`Comparison::exceeds_in`].
    pub fn exceeds(&self, limits: &Thresholds) -> Option<String> {
        self.exceeds_in(Region::All, limits)
    }

    /// The metrics past their limits in a region, one line each; `None` if all are within. Pixels
    /// that are not finite, a metric that is not a number, and a region without pixels if a limit
    /// is set always exceed.
    pub fn exceeds_in(&self, region: Region, limits: &Thresholds) -> Option<String> {
        let mut lines = match self.region(region) {
            Some(metrics) => metrics.exceeds(limits),
            None if *limits == Thresholds::default() => Vec::new(),
            None => vec![format!("the reference has no pixels of the region \"{region}\"")],
        };
        for (name, count) in [("image", self.non_finite_image), ("reference", self.non_finite_reference)] {
            if count > 0 {
                lines.push(format!("{count} pixels of the {name} are infinite or not a number"));
            }
        }
        (!lines.is_empty()).then(|| lines.join("\n"))
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{:<22}{} x {}", "size", self.width, self.height)?;
        let regions: Vec<_> = [Region::All, Region::Silhouette, Region::Inside]
            .into_iter()
            .filter_map(|region| Some((region, self.region(region)?)))
            .collect();
        if regions.len() > 1 {
            write!(f, "{:<22}", "")?;
            regions.iter().try_for_each(|(region, _)| write!(f, "{:<14}", region.to_string()))?;
            writeln!(f)?;
        }
        for metric in &METRICS {
            for part in 0..(metric.values)(&self.all).len() {
                let name = metric.part_name(part);
                let mut line = format!("{name:<22}");
                for (_, metrics) in &regions {
                    // A space at least between columns.
                    line += &format!("{:<13} ", cell((metric.values)(metrics)[part]));
                }
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        let [from, to] = self.hdr_flip_exposures;
        writeln!(f, "{:<22}{from:.2} to {to:.2} stops", "HDR-FLIP exposures")?;
        write!(
            f,
            "{:<22}{} image, {} reference",
            "not finite", self.non_finite_image, self.non_finite_reference
        )
    }
}

/// A value as it is printed, 13 characters at most.
fn cell(value: f64) -> String {
    let text = format!("{value:.6}");
    if value.is_nan() {
        "undefined".to_owned()
    } else if text.len() > 13 {
        format!("{value:.5e}")
    } else {
        text
    }
}

/// Compares an image with a reference of the same size.
///
/// # Errors
/// [`Error::Unsupported`] if the sizes differ, or if a film lacks one of the planes `R G B A`.
pub fn compare(image: &Film, reference: &Film) -> Result<Comparison> {
    compare_with(image, reference, &Options::default())
}

/// Compares an image with a reference of the same size, with settings.
///
/// # Errors
/// As [`compare`].
pub fn compare_with(image: &Film, reference: &Film, options: &Options) -> Result<Comparison> {
    let pair = Pair::new(image, reference, options.exposure)?;
    let hdr = pair.hdr_flip()?;
    let [shown, wanted] = [&pair.image, &pair.reference].map(|pixels| encoded_luminance(pixels));
    let maps = metric::Maps {
        squares: shown.iter().zip(&wanted).map(|(a, b)| (a - b) * (a - b)).collect(),
        ssim: perceptual::ssim(&shown, &wanted, pair.size),
        flip: pair.flip()?,
        hdr_flip: hdr.map,
        detail: [&pair.image, &pair.reference]
            .map(|pixels| spectrum::octaves(spectrum::luminances(pixels), pair.size)),
        noise: [image, reference].map(|film| {
            spectrum::noise(film, options.exposure.exp2() as f32)
                .map(|noise| spectrum::octaves(noise, pair.size))
        }),
    };
    let masks = region::masks(&pair.reference, pair.size, options.band);
    let of = |mask: &[bool]| metric::Metrics::new(&pair, &maps, mask);
    let bad = |pixels: &[[f32; 4]]| pixels.iter().filter(|p| !finite(p)).count() as u64;
    Ok(Comparison {
        width: image.width,
        height: image.height,
        non_finite_image: bad(&pair.image),
        non_finite_reference: bad(&pair.reference),
        hdr_flip_exposures: hdr.exposures.map(|stops| stops + options.exposure),
        all: of(&vec![true; pair.image.len()]),
        silhouette: masks.silhouette.map(|mask| of(&mask)),
        inside: masks.inside.map(|mask| of(&mask)),
    })
}

/// An opaque image of the differences; write it with tone mapping `none` and exposure 0.
///
/// # Errors
/// As [`compare`].
pub fn error_image(image: &Film, reference: &Film, kind: ErrorImage) -> Result<Film> {
    error_image_with(image, reference, kind, &Options::default())
}

/// As [`error_image`], with both images at the exposure of the options.
///
/// # Errors
/// As [`compare`].
pub fn error_image_with(image: &Film, reference: &Film, kind: ErrorImage, options: &Options) -> Result<Film> {
    let pair = Pair::new(image, reference, options.exposure)?;
    let each = |value: &dyn Fn(f32, f32) -> f32| -> Vec<[f32; 4]> {
        let pixels = pair.image.iter().zip(&pair.reference);
        pixels.map(|(p, q)| [value(p[0], q[0]), value(p[1], q[1]), value(p[2], q[2]), 1.0]).collect()
    };
    let pixels = match kind {
        ErrorImage::Flip => magma(&pair.flip()?),
        ErrorImage::HdrFlip => magma(&pair.hdr_flip()?.map),
        ErrorImage::Difference(factor) => each(&|i, r| (i - r).abs() * factor),
        ErrorImage::Relative(factor) => {
            each(&|i, r| (i - r).abs() / (r * r + RELATIVE_FLOOR as f32).sqrt() * factor)
        }
    };
    Ok(Film::from_premultiplied(image.width, image.height, &pixels))
}

/// Errors of 0..1 in the magma colour map, linear.
fn magma(errors: &[f32]) -> Vec<[f32; 4]> {
    let lut = nv_flip::magma_lut().to_vec();
    let color = |error: &f32| {
        let entry = 3 * (error.clamp(0.0, 1.0) * 255.0).round() as usize;
        let [r, g, b] =
            [0, 1, 2].map(|c| srgb_decode(lut.get(entry + c).copied().map_or(0.0, f32::from) / 255.0));
        [r, g, b, 1.0]
    };
    errors.iter().map(color).collect()
}

/// Two images of the same size, premultiplied linear, after exposure.
struct Pair {
    image: Vec<[f32; 4]>,
    reference: Vec<[f32; 4]>,
    size: [usize; 2],
}

impl Pair {
    fn new(image: &Film, reference: &Film, exposure: f64) -> Result<Self> {
        if (image.width, image.height) != (reference.width, reference.height) {
            return Err(Error::Unsupported(format!(
                "the image is {} x {} pixels, the reference {} x {}: only images of the same size can be compared",
                image.width, image.height, reference.width, reference.height
            )));
        }
        let factor = exposure.exp2() as f32;
        let exposed = |film: &Film| -> Result<Vec<[f32; 4]>> {
            let mut pixels = film.premultiplied()?;
            pixels.iter_mut().for_each(|p| p[..3].iter_mut().for_each(|v| *v *= factor));
            Ok(pixels)
        };
        Ok(Self {
            image: exposed(image)?,
            reference: exposed(reference)?,
            size: [image.width as usize, image.height as usize],
        })
    }

    fn flip(&self) -> Result<Vec<f32>> {
        perceptual::flip(&self.image, &self.reference, self.size)
    }

    fn hdr_flip(&self) -> Result<perceptual::HdrFlip> {
        perceptual::hdr_flip(&self.image, &self.reference, self.size)
    }
}

fn rgb(pixel: &[f32; 4]) -> Vec3 {
    Vec3::new(pixel[0], pixel[1], pixel[2])
}

fn finite(pixel: &[f32; 4]) -> bool {
    pixel.iter().all(|v| v.is_finite())
}

fn encoded_luminance(pixels: &[[f32; 4]]) -> Vec<f64> {
    pixels.iter().map(|p| f64::from(srgb_encode(luminance(rgb(p))))).collect()
}
