//! Hybrid fur and its variants against path tracing of the same fur with all orders of scattering.

use super::{Exhibit, Finding, Goal, Lab, Picture, Section, Table};
use crate::compare;
use crate::compare::{Comparison, ErrorImage};
use crate::provenance::only_files_missing;
use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::scene::{FurLayers, MultipleModel, Shading};
use pelage_core::{Error, Result, World};
use pelage_pathtrace as pathtrace;
use pelage_pathtrace::Integrator;
use pelage_pathtrace::grow::{GrowOptions, Patch};

/// Largest distance of the hybrid's luminance ratio from 1 that is allowed.
pub const GOAL_LUMINANCE: f64 = 0.1;
/// Largest HDR-FLIP of the hybrid that is allowed.
pub const GOAL_HDR_FLIP: f64 = 0.25;

/// What is approximated with what.
struct Variant {
    name: &'static str,
    /// Whether it is the renderer at its best, which has goals.
    best: bool,
    set: fn(&mut World),
    /// Guard hairs are added until it takes as long as the best.
    equal_time: bool,
}

const VARIANTS: [Variant; 7] = [
    Variant {
        name: "hybrid, transport",
        best: true,
        set: |w| w.scene.render.multiple.model = MultipleModel::Transport,
        equal_time: false,
    },
    Variant {
        name: "hybrid, dual scattering",
        best: false,
        set: |w| w.scene.render.multiple.model = MultipleModel::Dual,
        equal_time: false,
    },
    Variant {
        name: "hybrid, similarity",
        best: false,
        set: |w| w.scene.render.multiple.model = MultipleModel::Similarity,
        equal_time: false,
    },
    Variant {
        name: "hybrid, single scattering",
        best: false,
        set: |w| w.scene.render.multiple.model = MultipleModel::None,
        equal_time: false,
    },
    Variant {
        name: "the paper's shading",
        best: false,
        set: |w| {
            w.scene.render.shading = Shading::Paper;
            w.scene.render.multiple.model = MultipleModel::None;
        },
        equal_time: false,
    },
    Variant {
        name: "volume only",
        best: false,
        set: |w| {
            w.scene.render.fur = FurLayers::Implicit;
            w.scene.render.multiple.model = MultipleModel::Transport;
        },
        equal_time: false,
    },
    Variant {
        name: "strands only, equal time",
        best: false,
        set: |w| {
            w.scene.render.fur = FurLayers::Explicit;
            w.scene.render.multiple.model = MultipleModel::None;
        },
        equal_time: true,
    },
];

/// Skin, and part of it that is traced.
struct Subject {
    name: &'static str,
    scene: &'static str,
    /// Hairs of the reference have their roots within this distance of what the camera looks at, cm; `None`: all.
    patch: Option<f32>,
    /// Left out of quick runs.
    slow: bool,
}

const SUBJECTS: [Subject; 3] = [
    Subject { name: "flat patch", scene: "flat", patch: None, slow: false },
    Subject { name: "cylinder", scene: "pelt", patch: None, slow: false },
    Subject { name: "bunny, close", scene: "bunny_close", patch: Some(2.0), slow: true },
];

/// Hair, and how its pictures are shown.
struct Coat {
    name: &'static str,
    preset: &'static str,
    /// Stops, for all pictures of it.
    exposure: f32,
}

const COATS: [Coat; 2] = [
    Coat { name: "dark", preset: "brown_mink", exposure: 0.5 },
    Coat { name: "light", preset: "arctic_fox", exposure: -1.0 },
];

/// An approximation's picture.
struct Shot {
    film: Film,
    seconds: f64,
    /// Guard hairs.
    strands: u64,
    compared: Comparison,
}

/// The experiment.
///
/// # Errors
/// Those of the scenes, of rendering and of path tracing; missing assets leave a scene out.
pub fn run(lab: &Lab) -> Result<Section> {
    let mut section = Section { text: text(), ..Section::default() };
    let subjects: Vec<&Subject> =
        SUBJECTS.iter().filter(|s| !s.slow || lab.choose(false, true, true)).collect();
    if subjects.len() < SUBJECTS.len() {
        section.skipped.push("the bunny, for a quick run".into());
    }
    let all = subjects.len() * COATS.len();
    for (i, subject) in subjects.iter().enumerate() {
        for (k, coat) in COATS.iter().enumerate() {
            let case = format!("{}, {} ({})", subject.name, coat.name, coat.preset);
            let place = [i * COATS.len() + k, all];
            if !lab.wants(&case) {
                section.skipped.push(format!("{case}: it was not asked for"));
                continue;
            }
            match load(lab, subject, coat) {
                Ok((world, assets)) => measure(lab, subject, &case, world, assets, place, &mut section)?,
                Err(error) if only_files_missing(&error) => section.skipped.push(format!(
                    "{case}: the mesh is not there (scripts/fetch_assets.sh fetches it; PELAGE_ASSETS says where it is)"
                )),
                Err(error) => return Err(error),
            }
            lab.step(place[0] + 1, all)?;
        }
    }
    Ok(section)
}

fn load(lab: &Lab, subject: &Subject, coat: &Coat) -> Result<(World, Assets)> {
    let [width, height] = lab.choose([80, 60], [160, 120], [320, 240]);
    let set = [
        format!("preset={}", coat.preset),
        format!("film.exposure={}", coat.exposure),
        format!("film.width={width}"),
        format!("film.height={height}"),
    ];
    lab.world(subject.scene, &set)
}

fn measure(
    lab: &Lab,
    subject: &Subject,
    case: &str,
    world: World,
    assets: Assets,
    place: [usize; 2],
    section: &mut Section,
) -> Result<()> {
    let centre = Vec3::from(world.scene.camera.target);
    let options = pathtrace::Options {
        integrator: Integrator::Path,
        samples: Some(lab.choose(32, 128, 1024)),
        time: Some(lab.choose(30.0, 100.0, 3600.0)),
        grow: GrowOptions {
            patch: subject.patch.map(|radius| Patch { centre, radius }),
            ..GrowOptions::default()
        },
        assets,
        ..pathtrace::Options::default()
    };
    let truth = lab.trace(&world, options, place)?;
    let exposure = world.scene.film.exposure;
    let mut shots: Vec<Shot> = Vec::new();
    for variant in &VARIANTS {
        let wanted = shots.first().map(|best| best.seconds);
        shots.push(shoot(lab, &world, variant, wanted, &truth.film, exposure)?);
    }
    let mut table = Table {
        caption: format!(
            "{case}. Reference: {} samples a pixel, {:.0} s, its own relative MSE {:.5}.",
            truth.samples, truth.seconds, truth.error
        ),
        head: [
            "variant",
            "guard hairs",
            "luminance ratio",
            "FLIP",
            "HDR-FLIP",
            "relative MSE",
            "SSIM",
            "detail 3 px",
            "at the silhouette: luminance ratio",
            "HDR-FLIP",
            "time, s",
        ]
        .map(String::from)
        .to_vec(),
        rows: Vec::new(),
    };
    for (variant, shot) in VARIANTS.iter().zip(&shots) {
        let m = &shot.compared.all;
        let rim = shot.compared.silhouette.as_ref();
        let dash = || "–".to_owned();
        table.rows.push(vec![
            variant.name.into(),
            shot.strands.to_string(),
            format!("{:.3}", m.luminance_ratio),
            format!("{:.4}", m.flip),
            format!("{:.4}", m.hdr_flip),
            format!("{:.4}", m.relative_mse),
            format!("{:.4}", m.ssim),
            format!("{:.3}", m.detail_ratio[0]),
            rim.map_or_else(dash, |rim| format!("{:.3}", rim.luminance_ratio)),
            rim.map_or_else(dash, |rim| format!("{:.4}", rim.hdr_flip)),
            format!("{:.2}", shot.seconds),
        ]);
        let [light, flip] =
            [Goal::OneWithin(GOAL_LUMINANCE), Goal::AtMost(GOAL_HDR_FLIP)].map(|g| variant.best.then_some(g));
        let find = |metric, value, goal| {
            Finding::new(variant.name, case, metric, value, goal).in_seconds(shot.seconds)
        };
        section.findings.push(find("luminance ratio", m.luminance_ratio, light));
        section.findings.push(find("HDR-FLIP", m.hdr_flip, flip));
    }
    let pictures = pictures(lab, case, &truth.film, &shots, exposure)?;
    section.exhibits.push(Exhibit { table: Some(table), pictures });
    Ok(())
}

fn shoot(
    lab: &Lab,
    world: &World,
    variant: &Variant,
    best_seconds: Option<f64>,
    truth: &Film,
    exposure: f32,
) -> Result<Shot> {
    let mut world = world.clone();
    (variant.set)(&mut world);
    let mut frame = lab.render(&world)?;
    if let (true, Some(wanted)) = (variant.equal_time, best_seconds) {
        // Time grows about as the number of hairs, from a start that does not: two corrections are enough to be near.
        for _ in 0..2 {
            let factor = (wanted * 1e3 / frame.stats.total_ms.max(1.0)).clamp(0.25, 8.0) as f32;
            if (factor - 1.0).abs() < 0.1 {
                break;
            }
            let density = world.scene.guard.density.max() * factor;
            world.scene.guard.density = density.into();
            match lab.render(&world) {
                Ok(next) => frame = next,
                Err(Error::OutOfMemory { .. }) => break,
                Err(error) => return Err(error),
            }
        }
    }
    let options = compare::Options { exposure: f64::from(exposure), ..compare::Options::default() };
    Ok(Shot {
        compared: compare::compare_with(&frame.film, truth, &options)?,
        seconds: frame.stats.total_ms / 1e3,
        strands: frame.stats.strands,
        film: frame.film,
    })
}

fn pictures(lab: &Lab, case: &str, truth: &Film, shots: &[Shot], exposure: f32) -> Result<Vec<Picture>> {
    let options = compare::Options { exposure: f64::from(exposure), ..compare::Options::default() };
    let name = |what: &str| format!("hybrid {case} {what}");
    let mut all = vec![lab.picture(truth, exposure, &name("reference"), "path traced")?];
    for (variant, shot) in VARIANTS.iter().zip(shots) {
        all.push(lab.picture(&shot.film, exposure, &name(variant.name), variant.name)?);
        if variant.best {
            let flip = compare::error_image_with(&shot.film, truth, ErrorImage::HdrFlip, &options)?;
            let caption = format!("{}: HDR-FLIP", variant.name);
            all.push(lab.picture(&flip, 0.0, &name("hdr flip"), &caption)?);
        }
    }
    Ok(all)
}

fn text() -> Vec<String> {
    vec![
        "Small pieces of fur at full density, dark and light. The reference traces every hair, guard and undercoat, with all orders of \
         scattering. It has the renderer's directional lights, hair colours and fibre models: what is measured is the fur's \
         approximations, not the lights'. Pictures of one case have the same exposure."
            .into(),
        "Strands only has no undercoat and scatters once; guard hairs are added until it takes about as long as the hybrid. The paper's shading ignores \
         the fibre tables of the scene where it has models of its own. Times are those of one picture at this size on the adapter \
         named above, with all that is done before the first ray."
            .into(),
    ]
}
