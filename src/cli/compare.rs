//! `pelage compare`.

use super::{args, output};
use crate::{
    Error, Result,
    compare::{self, ErrorImage, Thresholds},
    film::{Metadata, io},
    scene::{FilmSpec, Tonemap},
};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// The image to judge (EXR, PNG or HDR).
    #[arg(value_name = "A")]
    a: PathBuf,
    /// The reference.
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Fail where the RMSE is larger.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_rmse: Option<f64>,
    /// Fail where the mean FLIP is larger.
    #[arg(long, value_name = "X", value_parser = args::threshold)]
    threshold_flip: Option<f64>,
    /// Write the error image, .png or .exr.
    #[arg(long = "outfile", short = 'o', value_name = "FILE")]
    outfile: Option<PathBuf>,
    /// What the error image shows: flip, difference, or difference*FACTOR.
    #[arg(long, value_name = "KIND", default_value = "flip", value_parser = error_kind)]
    error: ErrorImage,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the metrics.
///
/// # Errors
/// [`Error::Check`] where a threshold is given and passed.
pub(super) fn run(args: &CompareArgs) -> Result<()> {
    args.outfile.iter().try_for_each(io::check_writable)?;
    let (image, reference) = (io::read(&args.a)?, io::read(&args.b)?);
    let result = compare::compare(&image, &reference)?;
    if let Some(path) = &args.outfile {
        let picture = compare::error_image(&image, &reference, args.error)?;
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        let meta = Metadata::of_program().with_command_line(output::command_line());
        io::write(&picture, path, &meta, &spec)?;
    }
    let json = serde_json::to_value(&result)
        .map_err(|e| Error::Check(format!("the comparison cannot be written as JSON: {e}")))?;
    if args.json {
        output::print_json(&json)?;
    } else {
        let metrics = [
            ("RMSE", result.rmse),
            ("relative MSE", result.relative_mse),
            ("PSNR, dB", result.psnr),
            ("SSIM", result.ssim),
            ("FLIP", result.flip),
            ("luminance ratio", result.luminance_ratio),
            ("alpha difference", result.alpha_difference),
            ("largest difference", result.max_abs),
        ];
        let lines: Vec<_> = metrics.iter().map(|(name, value)| format!("{name:<19} {value:.6}\n")).collect();
        output::print(&lines.concat())?;
    }
    let limits = Thresholds { rmse: args.threshold_rmse, flip: args.threshold_flip, ..Thresholds::default() };
    match result.exceeds(&limits) {
        None => Ok(()),
        Some(why) => Err(Error::Check(format!("{} and {}: {why}", args.a.display(), args.b.display()))),
    }
}

fn error_kind(text: &str) -> Result<ErrorImage, String> {
    match text {
        "flip" => Ok(ErrorImage::Flip),
        "difference" => Ok(ErrorImage::Difference(1.0)),
        other => match other.strip_prefix("difference*").map(args::threshold) {
            Some(factor) => Ok(ErrorImage::Difference(factor? as f32)),
            None => Err("expected flip, difference, or difference*10 with a factor of your choice".into()),
        },
    }
}
