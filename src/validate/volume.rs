//! Undercoat as a volume against the same hairs as strands. Both scatter light once, from the same lights with the same fibre model:
//! what differs is the volume.

use super::plot::{Curve, Plot};
use super::{Finding, Goal, Lab, Picture, Section, Table};
use crate::compare::{self, ErrorImage};
use crate::pathtrace::{self, Integrator};
use crate::{Result, World};

/// Largest distance of the luminance ratio from 1 that is allowed.
pub const GOAL_LUMINANCE: f64 = 0.1;
/// Largest difference of the mean coverage that is allowed.
pub const GOAL_COVERAGE: f64 = 0.02;

/// One property of the fur, the values that it takes and that of the other cases.
struct Sweep {
    name: &'static str,
    key: &'static str,
    values: Vec<f64>,
}

fn sweeps(lab: &Lab) -> Vec<Sweep> {
    let values = |quick: &[f64], usual: &[f64], full: &[f64]| lab.choose(quick, usual, full).to_vec();
    vec![
        Sweep {
            name: "density, hairs/cm²",
            key: "undercoat.density",
            values: values(&[5e3, 2e4], &[5e3, 1e4, 2e4, 4e4], &[5e3, 1e4, 1.5e4, 2e4, 3e4, 4e4]),
        },
        Sweep {
            name: "clumping (noise_contrast)",
            key: "undercoat.noise_contrast",
            values: values(&[1.0], &[0.0, 0.5, 1.0], &[0.0, 0.25, 0.5, 0.75, 1.0]),
        },
        Sweep {
            name: "lean (tangent)",
            key: "undercoat.lean",
            values: values(&[0.6], &[0.0, 0.3, 0.6], &[0.0, 0.15, 0.3, 0.45, 0.6]),
        },
    ]
}

/// Mean alpha.
fn coverage(film: &crate::film::Film) -> f64 {
    let alpha = film.plane("A").unwrap_or_default();
    alpha.iter().map(|v| f64::from(*v)).sum::<f64>() / alpha.len().max(1) as f64
}

/// The experiment.
///
/// # Errors
/// Those of the scene, of rendering and of path tracing.
pub fn run(lab: &Lab) -> Result<Section> {
    let mut section = Section { text: text(), ..Section::default() };
    let sweeps = sweeps(lab);
    let all: usize = sweeps.iter().map(|sweep| sweep.values.len()).sum();
    let mut table = Table {
        caption: "Volume against strands, scattered once. Noise: relative MSE of the strands' own picture."
            .into(),
        head: [
            "case",
            "luminance ratio",
            "coverage",
            "of strands",
            "relative MSE",
            "noise",
            "FLIP",
            "detail 3 px",
            "6 px",
            "13 px",
        ]
        .map(String::from)
        .to_vec(),
        rows: Vec::new(),
    };
    let mut done = 0;
    for sweep in &sweeps {
        let (mut light, mut error) = (Vec::new(), Vec::new());
        for value in &sweep.values {
            let case = format!("{} {value}", sweep.name);
            let set = format!("{}={value:?}", sweep.key);
            let one = measure(lab, &set, [done, all])?;
            let m = &one.compared.all;
            let cover = [coverage(&one.volume), coverage(&one.strands)];
            let find =
                |metric, value, goal| Finding::new("undercoat as a volume", &case, metric, value, goal);
            section.findings.push(
                find("luminance ratio", m.luminance_ratio, Some(Goal::OneWithin(GOAL_LUMINANCE)))
                    .in_seconds(one.seconds),
            );
            let difference = (cover[0] - cover[1]).abs();
            section.findings.push(find(
                "difference of the coverage",
                difference,
                Some(Goal::AtMost(GOAL_COVERAGE)),
            ));
            section.findings.push(find("relative MSE", m.relative_mse, None));
            let numbers = [m.luminance_ratio, cover[0], cover[1], m.relative_mse, one.noise, m.flip]
                .into_iter()
                .chain(m.detail_ratio[..3].iter().copied());
            table
                .rows
                .push(std::iter::once(case.clone()).chain(numbers.map(|v| format!("{v:.4}"))).collect());
            light.push([*value, m.luminance_ratio]);
            error.push([*value, m.relative_mse]);
            section.pictures.push(one.pictures(lab, &case)?);
            done += 1;
            lab.step(done, all)?;
        }
        if light.len() > 1 {
            for (y, points) in [("luminance ratio", light), ("relative MSE", error)] {
                section.plots.push(Plot {
                    caption: format!("{y} by {}", sweep.name),
                    x: sweep.name.into(),
                    y: y.into(),
                    curves: vec![Curve { name: "volume / strands".into(), points }],
                });
            }
        }
    }
    section.tables.push(table);
    Ok(section)
}

/// A patch both ways.
struct Both {
    volume: crate::film::Film,
    strands: crate::film::Film,
    compared: compare::Comparison,
    noise: f64,
    seconds: f64,
    exposure: f32,
}

fn measure(lab: &Lab, set: &str, place: [usize; 2]) -> Result<Both> {
    let [width, height] = lab.choose([72, 54], [120, 90], [200, 150]);
    let size = [format!("film.width={width}"), format!("film.height={height}")];
    let (world, assets): (World, _) = lab.world("patch", &[&[set.to_owned()][..], &size].concat())?;
    let frame = lab.render(&world)?;
    let options = pathtrace::Options {
        integrator: Integrator::Single,
        samples: Some(lab.choose(32, 96, 512)),
        assets,
        ..pathtrace::Options::default()
    };
    let outcome = lab.trace(&world, options, place)?;
    let exposure = world.scene.film.exposure;
    let options = compare::Options { exposure: f64::from(exposure), ..compare::Options::default() };
    Ok(Both {
        compared: compare::compare_with(&frame.film, &outcome.film, &options)?,
        volume: frame.film,
        strands: outcome.film,
        noise: outcome.error,
        seconds: frame.stats.total_ms / 1e3,
        exposure,
    })
}

impl Both {
    fn pictures(&self, lab: &Lab, case: &str) -> Result<Vec<Picture>> {
        let options = compare::Options { exposure: f64::from(self.exposure), ..compare::Options::default() };
        let flip = compare::error_image_with(&self.volume, &self.strands, ErrorImage::Flip, &options)?;
        let picture = |film, exposure, what: &str| {
            lab.picture(film, exposure, &format!("volume {case} {what}"), &format!("{case}: {what}"))
        };
        Ok(vec![
            picture(&self.strands, self.exposure, "strands")?,
            picture(&self.volume, self.exposure, "volume")?,
            picture(&flip, 0.0, "FLIP")?,
        ])
    }
}

fn text() -> Vec<String> {
    vec![
        "A flat patch of undercoat, rendered as a volume and path traced with every hair a strand. Both scatter light once; lights, hair \
         colours and the fibre model are the same, so that only the volume is measured: its extinction, its cells, its light lattice. \
         Strands have the directions and the density of the volume's field."
            .into(),
        "One property is varied at a time; the others are those of scenes/validate/patch.toml.".into(),
    ]
}
