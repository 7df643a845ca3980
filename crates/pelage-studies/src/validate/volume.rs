//! Undercoat as a volume against the same hairs as strands. Both have the same lights, the same
//! fibre model and single scattering, so that only the volume differs.

use super::lab::Approximation;
use super::{Exhibit, Finding, Goal, Lab, Picture, Section, Table};
use crate::compare::{self, ErrorImage};
use crate::report::plot::{Curve, Plot};
use pelage_core::film::Film;
use pelage_core::scene::LightLookup;
use pelage_core::{Result, World};
use pelage_pathtrace::{self as pathtrace, Integrator};

/// Largest allowed difference of the mean coverage.
pub const GOAL_COVERAGE: f64 = 0.02;

/// A method to find the optical depth towards a light.
struct Lookup {
    name: &'static str,
    light: LightLookup,
    /// Largest allowed distance of the luminance ratio from 1.
    goal: f64,
}

/// A nested march, which leaves the error of the volume alone, and the optical-depth lattice.
const LOOKUPS: [Lookup; 2] = [
    Lookup { name: "undercoat as a volume, light marched", light: LightLookup::Nested, goal: 0.05 },
    Lookup { name: "undercoat as a volume, lattice", light: LightLookup::Lattice, goal: 0.1 },
];

/// A property of the fur, and the values that it takes.
struct Sweep {
    name: &'static str,
    key: &'static str,
    values: Vec<f64>,
}

fn sweeps(lab: &Lab) -> [Sweep; 3] {
    let values = |quick: &[f64], usual: &[f64], full: &[f64]| lab.choose(quick, usual, full).to_vec();
    [
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
fn coverage(film: &Film) -> f64 {
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
    let mut done = 0;
    for sweep in &sweeps {
        let mut curves = [const { Vec::new() }; 4];
        for value in &sweep.values {
            let case = format!("{} {value}", sweep.name);
            if !lab.wants(&case) {
                section.skipped.push(format!("{case}: it was not asked for"));
                done += 1;
                continue;
            }
            let patch = Patch::measure(lab, &format!("{}={value:?}", sweep.key), [done, all])?;
            section.findings.extend(patch.findings(&case));
            for (k, image) in patch.images.iter().enumerate() {
                curves[k].push([*value, image.compared.all.luminance_ratio]);
                curves[2 + k].push([*value, image.compared.all.relative_mse]);
            }
            section.exhibits.push(patch.exhibit(lab, &case)?);
            done += 1;
            lab.step(done, all)?;
        }
        if sweep.values.len() > 1 {
            let [a, b, c, d] = curves;
            for (y, both) in [("luminance ratio", [a, b]), ("relative MSE", [c, d])] {
                let curve = |(lookup, points): (&Lookup, _)| Curve::new(lookup.name, points);
                section.plots.push(Plot {
                    caption: format!("{y} of volume and strands by {}", sweep.name),
                    x: sweep.name.into(),
                    y: y.into(),
                    log: [false; 2],
                    curves: LOOKUPS.iter().zip(both).map(curve).collect(),
                });
            }
        }
    }
    Ok(section)
}

/// A patch of fur both as strands and as a volume.
struct Patch {
    strands: pathtrace::Outcome,
    /// The volume with each lookup.
    images: Vec<Approximation>,
    exposure: f32,
}

impl Patch {
    fn measure(lab: &Lab, set: &str, place: [usize; 2]) -> Result<Self> {
        let [width, height] = lab.choose([80, 60], [120, 90], [240, 180]);
        let size = [format!("film.width={width}"), format!("film.height={height}")];
        let (mut world, assets): (World, _) = lab.world("patch", &[&[set.to_owned()][..], &size].concat())?;
        let options = pathtrace::Options {
            integrator: Integrator::Single,
            samples: Some(lab.choose(64, 256, 1024)),
            assets,
            ..pathtrace::Options::default()
        };
        let strands = lab.trace(&world, options, place)?;
        let exposure = world.scene.film.exposure;
        let mut images = Vec::new();
        for lookup in &LOOKUPS {
            world.scene.render.light = lookup.light;
            images.push(Approximation::new(lab.render(&world)?, &strands.film, exposure)?);
        }
        Ok(Self { strands, images, exposure })
    }

    fn findings(&self, case: &str) -> Vec<Finding> {
        let mut findings = Vec::new();
        for (lookup, image) in LOOKUPS.iter().zip(&self.images) {
            let m = &image.compared.all;
            let find = |metric, value, goal| {
                Finding::new(lookup.name, case, metric, value, goal).in_seconds(image.seconds)
            };
            findings.push(find("luminance ratio", m.luminance_ratio, Some(Goal::OneWithin(lookup.goal))));
            findings.push(find("relative MSE", m.relative_mse, None));
        }
        // The coverage does not depend on the lookup.
        let difference = (coverage(&self.images[0].film) - coverage(&self.strands.film)).abs();
        let goal = Some(Goal::AtMost(GOAL_COVERAGE));
        findings.push(Finding::new(
            "undercoat as a volume",
            case,
            "difference of the coverage",
            difference,
            goal,
        ));
        findings
    }

    fn exhibit(&self, lab: &Lab, case: &str) -> Result<Exhibit> {
        let head = [
            "",
            "luminance ratio",
            "coverage",
            "relative MSE",
            "FLIP",
            "detail 3 px",
            "6 px",
            "13 px",
            "26 px",
            "time, s",
        ];
        let row = |(lookup, image): (&Lookup, &Approximation)| {
            let m = &image.compared.all;
            let numbers = [m.luminance_ratio, coverage(&image.film), m.relative_mse, m.flip];
            let numbers = numbers.into_iter().chain(m.detail_ratio).map(|v| format!("{v:.4}"));
            std::iter::once(lookup.name.to_owned())
                .chain(numbers)
                .chain([format!("{:.2}", image.seconds)])
                .collect()
        };
        let caption = format!(
            "{case}. Strands: {} samples a pixel, {:.0} s, coverage {:.4}, their own relative MSE {:.5}.",
            self.strands.samples,
            self.strands.seconds,
            coverage(&self.strands.film),
            self.strands.error
        );
        let table = Table::new(caption, &head, LOOKUPS.iter().zip(&self.images).map(row).collect());
        let options = compare::Options { exposure: f64::from(self.exposure), ..compare::Options::default() };
        let picture = |film: &Film, exposure: f32, what: &str| -> Result<Picture> {
            lab.picture(film, exposure, &format!("volume {case} {what}"), what)
        };
        let mut pictures = vec![picture(&self.strands.film, self.exposure, "strands")?];
        for (lookup, image) in LOOKUPS.iter().zip(&self.images) {
            pictures.push(picture(&image.film, self.exposure, lookup.name)?);
            let flip =
                compare::error_image_with(&image.film, &self.strands.film, ErrorImage::Flip, &options)?;
            pictures.push(picture(&flip, 0.0, &format!("{}: FLIP", lookup.name))?);
        }
        Ok(Exhibit { table: Some(table), pictures })
    }
}

fn text() -> Vec<String> {
    vec![
        "A flat patch of undercoat, rendered as a volume and path traced with every hair a strand. Both have single scattering; lights, \
         hair colours and the fibre model are the same, so that only the volume is measured. Strands have the directions and the \
         density of the volume's field. The optical depth towards each light is found by a nested march at every step, which \
         leaves the medium's own error (homogeneous extinction in place of single hairs), or in the optical-depth lattice, the \
         renderer's default."
            .into(),
        "One property is varied at a time; the others are those of scenes/validate/patch.toml. Detail: power of the luminance in octaves \
         of the period, of the volume by that of the strands without their noise; below 1 the volume is too soft. A medium cannot \
         show single hairs."
            .into(),
    ]
}
