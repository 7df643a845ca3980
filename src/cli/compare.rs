//! `pelage compare`.

use super::{args, output};
use clap::Args;
use pelage_core::film::{Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::{Error, Result};
use pelage_studies::compare;
use pelage_studies::compare::{ErrorImage, Options, Region, Thresholds};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// The image to judge (EXR, PNG or HDR).
    #[arg(value_name = "A")]
    a: PathBuf,
    /// The reference.
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Write the error image, .png or .exr.
    #[arg(long = "outfile", short = 'o', value_name = "FILE")]
    outfile: Option<PathBuf>,
    /// What the error image shows: flip, hdr-flip, difference, relative, the latter two also with *FACTOR.
    #[arg(long, value_name = "KIND", default_value = "flip", value_parser = error_kind)]
    error: ErrorImage,
    /// Stops by which both images are exposed.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = args::stops)]
    exposure: f64,
    /// Pixels within this distance of the reference's outline are the silhouette.
    #[arg(long, value_name = "PIXELS", default_value_t = 8.0, value_parser = args::threshold)]
    band: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Thresholds: exit with 1 where one is passed")]
struct Limits {
    /// Which pixels the thresholds are for: all, silhouette or inside.
    #[arg(long, value_name = "REGION", default_value = "all", value_parser = region)]
    region: Region,
    /// Largest RMSE.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_rmse: Option<f64>,
    /// Largest relative MSE.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_relative_mse: Option<f64>,
    /// Smallest PSNR, dB.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_psnr: Option<f64>,
    /// Smallest SSIM.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_ssim: Option<f64>,
    /// Largest mean FLIP.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_flip: Option<f64>,
    /// Largest mean HDR-FLIP.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_hdr_flip: Option<f64>,
    /// Largest distance of the ratio of mean luminances from 1.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_luminance_ratio: Option<f64>,
    /// Largest distance of a ratio of mean colours from 1.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_color_ratio: Option<f64>,
    /// Largest distance from 1 of the ratio of detail in an octave.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_detail_ratio: Option<f64>,
    /// Largest mean difference of alpha.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_alpha_difference: Option<f64>,
    /// Largest difference of a channel.
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
/// [`Error::Unsupported`] where a threshold is given and passed.
pub(super) fn run(args: &CompareArgs) -> Result<()> {
    args.outfile.iter().try_for_each(io::check_writable)?;
    let (image, reference) = (io::read(&args.a)?, io::read(&args.b)?);
    let options = Options { exposure: args.exposure, band: args.band };
    let result = compare::compare_with(&image, &reference, &options)?;
    if let Some(path) = &args.outfile {
        let picture = compare::error_image_with(&image, &reference, args.error, &options)?;
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        let meta = Metadata::of_program().with_command_line(output::command_line());
        io::write(&picture, path, &meta, &spec)?;
    }
    if args.json {
        let json = serde_json::to_value(&result)
            .map_err(|e| Error::Encoding(format!("the comparison cannot be written as JSON: {e}")))?;
        output::print_json(&json)?;
    } else {
        output::print(&format!("{result}\n"))?;
    }
    match result.exceeds_in(args.limits.region, &args.limits.thresholds()) {
        None => Ok(()),
        Some(why) => Err(Error::GoalMissed(format!("{} and {}: {why}", args.a.display(), args.b.display()))),
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
        _ => Err("expected flip, hdr-flip, difference or relative, or one of these two with a factor, \
            such as difference*10"
            .into()),
    }
}
