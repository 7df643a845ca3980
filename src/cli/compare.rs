//! `pelage compare`.

use super::{Global, args, output};
use clap::Args;
use pelage::compare::{self, ErrorImage, Options, Region, Thresholds};
use pelage::film::{Metadata, io};
use pelage::scene::{FilmSpec, Tonemap};
use pelage::{Error, Result};
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage compare image.exr reference.exr
  pelage compare image.exr reference.exr -o error.png --error difference*10
  pelage compare image.exr reference.exr --threshold-flip 0.05    exits with 1 above")]
pub(super) struct CompareArgs {
    /// Image (EXR, PNG, HDR, JPEG, TIFF, TGA, BMP or WebP)
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Reference image (EXR, PNG, HDR, JPEG, TIFF, TGA, BMP or WebP)
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Write an error image, .png or .exr
    #[arg(long = "outfile", short = 'o', value_name = "FILE")]
    outfile: Option<PathBuf>,
    /// Kind of the error image: flip, hdr-flip, difference or relative; the latter two also with a
    /// factor, as in difference*10
    #[arg(long, value_name = "KIND", default_value = "flip", value_parser = error_kind)]
    error: ErrorImage,
    /// Exposure of both images in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = args::stops)]
    exposure: f64,
    /// Largest distance of the silhouette's pixels from the reference's outline, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 8.0, value_parser = args::threshold)]
    band: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Thresholds (exit with 1 if one is exceeded)")]
struct Limits {
    /// Region that the thresholds apply to: all, silhouette or inside
    #[arg(long, value_name = "REGION", default_value = "all", value_parser = region)]
    region: Region,
    /// Largest RMSE
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_rmse: Option<f64>,
    /// Largest relative MSE
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_relative_mse: Option<f64>,
    /// Smallest PSNR in dB
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_psnr: Option<f64>,
    /// Smallest SSIM
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_ssim: Option<f64>,
    /// Largest mean FLIP
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_flip: Option<f64>,
    /// Largest mean HDR-FLIP
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_hdr_flip: Option<f64>,
    /// Largest distance from 1 of the ratio of mean luminances
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_luminance_ratio: Option<f64>,
    /// Largest distance from 1 of the ratio of means of a colour channel
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_color_ratio: Option<f64>,
    /// Largest distance from 1 of the ratio of detail in an octave
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_detail_ratio: Option<f64>,
    /// Largest mean difference of alpha
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_alpha_difference: Option<f64>,
    /// Largest difference of a colour channel
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_max_abs: Option<f64>,
}

impl Limits {
    fn thresholds(&self) -> Thresholds {
        Thresholds {
            rmse: self.threshold_rmse,
            relative_mse: self.threshold_relative_mse,
            psnr: self.threshold_psnr,
            ssim: self.threshold_ssim,
            flip: self.threshold_flip,
            hdr_flip: self.threshold_hdr_flip,
            luminance_ratio: self.threshold_luminance_ratio,
            color_ratio: self.threshold_color_ratio,
            detail_ratio: self.threshold_detail_ratio,
            alpha_difference: self.threshold_alpha_difference,
            max_abs: self.threshold_max_abs,
        }
    }
}

/// Prints the metrics.
///
/// # Errors
/// [`Error::GoalMissed`] if a threshold is exceeded.
pub(super) fn run(args: &CompareArgs, global: &Global) -> Result<()> {
    args.outfile.iter().try_for_each(io::check_writable)?;
    let mut notes = Vec::new();
    let (image, reference) = (io::read_noting(&args.a, &mut notes)?, io::read_noting(&args.b, &mut notes)?);
    output::print_notes(&notes, global.quiet);
    let options = Options { exposure: args.exposure, band: args.band };
    let result = compare::compare_with(&image, &reference, &options)?;
    if let Some(path) = &args.outfile {
        let picture = compare::error_image_with(&image, &reference, args.error, &options)?;
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        let meta = Metadata::of_program().with_command_line(output::command_line());
        io::write(&picture, path, &meta, &spec)?;
    }
    if args.json {
        output::print_json(&output::to_json(&result, "comparison")?)?;
    } else {
        output::print(&format!("{result}\n"))?;
    }
    match result.exceeds_in(args.limits.region, &args.limits.thresholds()) {
        None => Ok(()),
        Some(lines) => {
            Err(Error::GoalMissed(format!("{} and {}: {lines}", args.a.display(), args.b.display())))
        }
    }
}

fn region(text: &str) -> Result<Region, String> {
    [Region::All, Region::Silhouette, Region::Inside]
        .into_iter()
        .find(|region| region.to_string() == text)
        .ok_or_else(|| "expected all, silhouette or inside".into())
}

fn error_kind(text: &str) -> Result<ErrorImage, String> {
    let factor = |factor: Option<&str>| factor.map_or(Ok(1.0), |f| args::threshold(f).map(|f| f as f32));
    let (name, times) = text.split_once('*').map_or((text, None), |(name, times)| (name, Some(times)));
    match (name, times) {
        ("flip", None) => Ok(ErrorImage::Flip),
        ("hdr-flip", None) => Ok(ErrorImage::HdrFlip),
        ("difference", times) => Ok(ErrorImage::Difference(factor(times)?)),
        ("relative", times) => Ok(ErrorImage::Relative(factor(times)?)),
        _ => Err("expected flip, hdr-flip, difference or relative; the latter two also with a factor, \
            such as difference*10"
            .into()),
    }
}
