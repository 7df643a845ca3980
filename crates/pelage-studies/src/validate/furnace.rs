//! White furnace: white hairs in uniform white light may neither lose nor gain energy.

use super::{Finding, Goal, Lab, Section};
use crate::report::plot::{Curve, Plot};
use glam::Vec3;
use pelage_core::Result;
use pelage_core::scene::{FibreModel, FibreSpec};
use pelage_fur::Layer;
use pelage_fur::fibre::{Fibre, Hit, offsets};
use pelage_fur::random::{hash2, random};
use pelage_pathtrace::{self as pathtrace, Integrator, LightModel};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Largest allowed distance from 1.
pub const GOAL: f64 = 0.01;
/// The same for hairs with a medulla, whose scattering is tabulated.
pub const GOAL_TABLES: f64 = 0.02;

/// Energy conservation of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Neither loses nor gains energy; whether its scattering is tabulated.
    Lossless(bool),
    /// Gains no energy.
    Bounded,
    /// No guarantee.
    Free,
}

/// Radiance that a white hair scatters to a direction of inclination asin(`sin`) under uniform
/// white light of radiance 1, with importance sampling of the model: the mean of the weights of its
/// samples.
pub fn albedo_sampled(fibre: &Fibre, sin: f32, samples: u32) -> f64 {
    let wo = Vec3::new(sin, (1.0 - sin * sin).max(0.0).sqrt(), 0.0);
    let sum: f64 = (0..samples)
        .into_par_iter()
        .map(|i| {
            let seed = hash2(11, i);
            let hit = white(2.0 * random(seed, 4) - 1.0);
            let u = [0, 1, 2, 3].map(|k| random(seed, k));
            fibre.sample(&hit, wo, u).map_or(0.0, |s| f64::from(s.weight.x))
        })
        .sum();
    sum / f64::from(samples)
}

/// The same by integration over the sphere, with `steps` inclinations, twice as many azimuths and,
/// for near-field models, half as many offsets across the hair.
pub fn albedo_integrated(fibre: &Fibre, sin: f32, steps: u32) -> f64 {
    let wo = Vec3::new(sin, (1.0 - sin * sin).max(0.0).sqrt(), 0.0);
    let across = if fibre.is_near_field() { steps / 2 } else { 1 };
    let of_ring = |i: u32| {
        let (s, c) = ((i as f32 + 0.5) * PI / steps as f32 - 0.5 * PI).sin_cos();
        let mut sum = 0.0;
        for k in 0..2 * steps {
            let (z, y) = ((k as f32 + 0.5) * TAU / (2 * steps) as f32).sin_cos();
            let wi = Vec3::new(s, c * y, c * z);
            for (h, weight) in offsets(across) {
                sum += f64::from(weight * fibre.evaluate(&white(h), wi, wo).x * c * c);
            }
        }
        sum
    };
    let cell = f64::from(PI / steps as f32) * f64::from(TAU / (2 * steps) as f32);
    (0..steps).into_par_iter().map(of_ring).sum::<f64>() * cell
}

fn white(h: f32) -> Hit {
    Hit { tint: Vec3::ONE, glint_angle: 0.6, h }
}

/// The models, without absorption if possible.
fn models() -> Vec<(&'static str, FibreSpec, Kind)> {
    let of = |model| FibreSpec { model: Some(model), ..FibreSpec::default() };
    let mut medulla = of(FibreModel::Medulla);
    medulla.absorption = Some([0.0; 3]);
    medulla.medulla.absorption = 0.0;
    vec![
        ("Kajiya-Kay, diffuse", of(FibreModel::KajiyaKay), Kind::Lossless(false)),
        ("Sadeghi", of(FibreModel::Sadeghi), Kind::Free),
        ("Sadeghi, normalised", of(FibreModel::SadeghiNormalised), Kind::Bounded),
        ("Chiang", of(FibreModel::Chiang), Kind::Lossless(false)),
        ("medulla", medulla, Kind::Lossless(true)),
    ]
}

/// The experiment.
///
/// # Errors
/// Those of the scene and of path tracing.
pub fn run(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        text: vec![
            "Fibre models: radiance that a white hair scatters to the camera under uniform white light of radiance 1, by the inclination \
             of the view direction to the plane across the hair; mean over the offset across the hair, as an integral and by the \
             model's own samples. A model that conserves energy has 1. Sadeghi's lobes guarantee nothing; normalised ones never \
             scatter more than arrives."
                .into(),
            "Path tracer: a ball with dense white fur on white skin under a white sky of radiance 1 has radiance 1 everywhere. A \
             deficit comes from paths that end too early."
                .into(),
        ],
        ..Section::default()
    };
    let models = models();
    let traced = lab.choose(1, 2, 3);
    let all = models.len() + 4 * traced;
    let angles: Vec<f32> = (0..=80).step_by(lab.choose(20, 10, 5)).map(|a| a as f32).collect();
    let samples = lab.choose(100_000, 400_000, 2_000_000);
    let steps = lab.choose(60, 96, 160);
    let mut plot = Plot {
        caption: "White furnace of a single fibre, by its own samples".into(),
        x: "inclination, degrees".into(),
        y: "light sent to the eye".into(),
        log: [false; 2],
        curves: Vec::new(),
    };
    for (i, (name, spec, kind)) in models.iter().enumerate() {
        let fibre = Fibre::new(spec, Layer::Undercoat, false);
        let sines: Vec<f32> = angles.iter().map(|a| a.to_radians().sin()).collect();
        let sampled: Vec<f64> = sines.iter().map(|s| albedo_sampled(&fibre, *s, samples)).collect();
        let integrated: Vec<f64> = sines.iter().map(|s| albedo_integrated(&fibre, *s, steps)).collect();
        for (how, values) in [("integral", &integrated), ("samples", &sampled)] {
            section.findings.push(judged(name, how, values, *kind));
        }
        let points = angles.iter().zip(&sampled).map(|(a, v)| [f64::from(*a), *v]).collect();
        plot.curves.push(Curve::new(*name, points));
        lab.step(i + 1, all)?;
    }
    section.plots.push(plot);
    for (k, model) in ["kajiya_kay", "chiang", "medulla"].into_iter().take(traced).enumerate() {
        let finding = of_tracer(lab, model, [models.len() / 4 + k, all.div_ceil(4)])?;
        section.findings.push(finding);
    }
    Ok(section)
}

fn judged(name: &str, how: &str, values: &[f64], kind: Kind) -> Finding {
    let case = format!("single fibre, 0 to 80 degrees, {how}");
    // `f64::max` would ignore NaN.
    let largest = |value: &dyn Fn(f64) -> f64| {
        values.iter().map(|v| value(*v)).fold(f64::NEG_INFINITY, |a, b| if a >= b { a } else { b })
    };
    let from_one = largest(&|v| (v - 1.0).abs());
    match kind {
        Kind::Lossless(tables) => {
            let goal = if tables { GOAL_TABLES } else { GOAL };
            Finding::new(name, &case, "largest distance from 1", from_one, Some(Goal::AtMost(goal)))
        }
        Kind::Bounded => Finding::new(
            name,
            &case,
            "largest share sent out",
            largest(&|v| v),
            Some(Goal::AtMost(1.0 + GOAL)),
        ),
        Kind::Free => Finding::new(name, &case, "largest share sent out", largest(&|v| v), None),
    }
}

fn of_tracer(lab: &Lab, model: &str, place: [usize; 2]) -> Result<Finding> {
    let mut overrides = vec![format!("undercoat.fibre.model={model}")];
    if model == "medulla" {
        overrides.extend(
            ["undercoat.fibre.absorption=[0,0,0]", "undercoat.fibre.medulla.absorption=0"].map(String::from),
        );
    }
    let edge = lab.choose(32, 48, 96);
    overrides.extend([format!("film.width={edge}"), format!("film.height={edge}")]);
    let (world, assets) = lab.world("furnace", &overrides)?;
    let options = pathtrace::Options {
        integrator: Integrator::Path,
        lights: Some(LightModel::Map),
        depth: 1 << 14,
        samples: Some(lab.choose(64, 256, 1024)),
        assets,
        ..pathtrace::Options::default()
    };
    let outcome = lab.trace(&world, options, place)?;
    let sum =
        |name: &str| outcome.film.plane(name).unwrap_or_default().iter().map(|v| f64::from(*v)).sum::<f64>();
    let value = sum("G") / sum("A");
    let case = format!("furry ball, {model}, {} samples a pixel", outcome.samples);
    Ok(Finding::new("path tracer", &case, "mean radiance", value, Some(Goal::OneWithin(GOAL)))
        .in_seconds(outcome.seconds))
}
