//! `pelage compare`.

use super::{
    args,
    backend::{
        compare,
        io::{self, Metadata},
    },
    output,
};
use crate::{
    Error, Result,
    scene::{FilmSpec, Tonemap},
};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// The image to judge (EXR, HDR or PNG).
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
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints the metrics.
///
/// # Errors
/// [`Error::Check`] where a threshold is given and passed.
pub(super) fn run(args: &CompareArgs) -> Result<()> {
    if let Some(path) = &args.outfile {
        output::test_writable(path)?;
    }
    let result = compare::compare(&io::read(&args.a)?, &io::read(&args.b)?)?;
    if let Some(path) = &args.outfile {
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        io::write(&result.error_image, path, &Metadata::default(), &spec)?;
    }
    let metrics = [
        ("rmse", result.rmse),
        ("relative_mse", result.relative_mse),
        ("psnr", result.psnr),
        ("flip", result.flip),
    ];
    if args.json {
        // JSON has no infinity: the PSNR of equal images is null.
        output::print_json(
            &metrics.map(|(k, v)| (k.to_owned(), serde_json::json!(v))).into_iter().collect(),
        )?;
    } else {
        for (name, value) in metrics {
            output::print(&format!("{name:<13} {value:.6}\n"))?;
        }
    }
    let limits = [("rmse", result.rmse, args.threshold_rmse), ("flip", result.flip, args.threshold_flip)];
    let past: Vec<_> = limits
        .into_iter()
        .filter_map(|(name, value, limit)| limit.map(|limit| (name, value, limit)))
        // Not `value > limit`: a value that is no number must fail too.
        .filter(|(_, value, limit)| !matches!(value.partial_cmp(limit), Some(o) if o.is_le()))
        .map(|(name, value, limit)| format!("{name} is {value:.6}, more than {limit}"))
        .collect();
    if past.is_empty() {
        return Ok(());
    }
    Err(Error::Check(format!("{} differs from {}: {}", args.a.display(), args.b.display(), past.join("; "))))
}
