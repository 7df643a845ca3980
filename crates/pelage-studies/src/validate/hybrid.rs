//! Hybrid fur and its variants against the same fur path traced with all orders of scattering.

use super::lab::Approximation;
use super::{Exhibit, Finding, Goal, Lab, Picture, Section, Table};
use crate::compare::{self, ErrorImage};
use crate::provenance::only_files_missing;
use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::scene::{FurLayers, MultipleModel, Shading};
use pelage_core::{Error, Result, World};
use pelage_pathtrace::grow::{GrowOptions, Patch};
use pelage_pathtrace::{self as pathtrace, Integrator};

/// Largest allowed distance of the hybrid's luminance ratio from 1.
pub const GOAL_LUMINANCE: f64 = 0.1;
/// Largest allowed HDR-FLIP of the hybrid.
pub const GOAL_HDR_FLIP: f64 = 0.25;

/// A method that is compared with the ground truth.
struct Variant {
    name: &'static str,
    /// Whether it is the renderer's best method, which has goals.
    best: bool,
    set: fn(&mut World),
    /// Whether guard hairs are added until it takes as long as the best.
    equal_time: bool,
}

const VARIANTS: [Variant; 7] = [
    Variant {
        best: true,
        ..variant("hybrid, transport", |w| w.scene.render.multiple.model = MultipleModel::Transport)
    },
    variant("hybrid, dual scattering", |w| w.scene.render.multiple.model = MultipleModel::Dual),
    variant("hybrid, similarity", |w| w.scene.render.multiple.model = MultipleModel::Similarity),
    variant("hybrid, single scattering", |w| w.scene.render.multiple.model = MultipleModel::None),
    variant("the paper's shading", |w| {
        w.scene.render.shading = Shading::Paper;
        w.scene.render.multiple.model = MultipleModel::None;
    }),
    variant("volume only", |w| {
        w.scene.render.fur = FurLayers::Implicit;
        w.scene.render.multiple.model = MultipleModel::Transport;
    }),
    Variant {
        equal_time: true,
        ..variant("strands only, equal time", |w| {
            w.scene.render.fur = FurLayers::Explicit;
            w.scene.render.multiple.model = MultipleModel::None;
        })
    },
];

const fn variant(name: &'static str, set: fn(&mut World)) -> Variant {
    Variant { name, best: false, set, equal_time: false }
}

/// A skin, and the part of it that is traced.
struct Subject {
    name: &'static str,
    scene: &'static str,
    /// The reference has only hairs with roots within this distance of the camera's target, cm;
    /// `None`: all.
    patch: Option<f32>,
    /// Whether quick runs leave it out.
    slow: bool,
}

const SUBJECTS: [Subject; 3] = [
    Subject { name: "flat patch", scene: "flat", patch: None, slow: false },
    Subject { name: "cylinder", scene: "pelt", patch: None, slow: false },
    Subject { name: "bunny, close", scene: "bunny_close", patch: Some(2.0), slow: true },
];

/// A kind of fur, and the exposure of its images.
struct Fur {
    name: &'static str,
    preset: &'static str,
    /// Stops, for all of its images.
    exposure: f32,
}

const FURS: [Fur; 2] = [
    Fur { name: "dark", preset: "brown_mink", exposure: 0.5 },
    Fur { name: "light", preset: "arctic_fox", exposure: -1.0 },
];

/// The experiment.
///
/// # Errors
/// Those of the scenes, of rendering and of path tracing. A scene whose assets are missing is left
/// out.
pub fn run(lab: &Lab) -> Result<Section> {
    let mut section = Section { text: text(), ..Section::default() };
    let subjects: Vec<&Subject> =
        SUBJECTS.iter().filter(|s| !s.slow || lab.choose(false, true, true)).collect();
    if subjects.len() < SUBJECTS.len() {
        section.skipped.push("the bunny, for a quick run".into());
    }
    let all = subjects.len() * FURS.len();
    for (i, subject) in subjects.iter().enumerate() {
        for (k, fur) in FURS.iter().enumerate() {
            let case = format!("{}, {} ({})", subject.name, fur.name, fur.preset);
            let place = [i * FURS.len() + k, all];
            if !lab.wants(&case) {
                section.skipped.push(format!("{case}: it was not asked for"));
                continue;
            }
            match load(lab, subject, fur) {
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

fn load(lab: &Lab, subject: &Subject, fur: &Fur) -> Result<(World, Assets)> {
    let [width, height] = lab.choose([80, 60], [160, 120], [320, 240]);
    let set = [
        format!("preset={}", fur.preset),
        format!("film.exposure={}", fur.exposure),
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
    let mut images: Vec<Approximation> = Vec::new();
    for variant in &VARIANTS {
        let wanted = images.first().map(|best| best.seconds);
        images.push(render(lab, &world, variant, wanted, &truth.film)?);
    }
    let caption = format!(
        "{case}. Reference: {} samples a pixel, {:.0} s, its own relative MSE {:.5}.",
        truth.samples, truth.seconds, truth.error
    );
    let head = [
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
    ];
    let mut table = Table::new(caption, &head, Vec::new());
    for (variant, image) in VARIANTS.iter().zip(&images) {
        let m = &image.compared.all;
        let rim = image.compared.silhouette.as_ref();
        let dash = || "–".to_owned();
        table.rows.push(vec![
            variant.name.into(),
            image.strands.to_string(),
            format!("{:.3}", m.luminance_ratio),
            format!("{:.4}", m.flip),
            format!("{:.4}", m.hdr_flip),
            format!("{:.4}", m.relative_mse),
            format!("{:.4}", m.ssim),
            format!("{:.3}", m.detail_ratio[0]),
            rim.map_or_else(dash, |rim| format!("{:.3}", rim.luminance_ratio)),
            rim.map_or_else(dash, |rim| format!("{:.4}", rim.hdr_flip)),
            format!("{:.2}", image.seconds),
        ]);
        let [light, flip] =
            [Goal::OneWithin(GOAL_LUMINANCE), Goal::AtMost(GOAL_HDR_FLIP)].map(|g| variant.best.then_some(g));
        let find = |metric, value, goal| {
            Finding::new(variant.name, case, metric, value, goal).in_seconds(image.seconds)
        };
        section.findings.push(find("luminance ratio", m.luminance_ratio, light));
        section.findings.push(find("HDR-FLIP", m.hdr_flip, flip));
    }
    let pictures = pictures(lab, case, &truth.film, &images, exposure)?;
    section.exhibits.push(Exhibit { table: Some(table), pictures });
    Ok(())
}

/// Renders a variant; with `equal_time` in about `best_seconds`.
fn render(
    lab: &Lab,
    world: &World,
    variant: &Variant,
    best_seconds: Option<f64>,
    truth: &Film,
) -> Result<Approximation> {
    let mut world = world.clone();
    (variant.set)(&mut world);
    let mut frame = lab.render(&world)?;
    if let (true, Some(wanted)) = (variant.equal_time, best_seconds) {
        // Time is roughly linear in the number of hairs, plus a constant: two corrections are
        // enough.
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
    Approximation::new(frame, truth, world.scene.film.exposure)
}

fn pictures(
    lab: &Lab,
    case: &str,
    truth: &Film,
    images: &[Approximation],
    exposure: f32,
) -> Result<Vec<Picture>> {
    let options = compare::Options { exposure: f64::from(exposure), ..compare::Options::default() };
    let name = |what: &str| format!("hybrid {case} {what}");
    let mut all = vec![lab.picture(truth, exposure, &name("reference"), "path traced")?];
    for (variant, image) in VARIANTS.iter().zip(images) {
        all.push(lab.picture(&image.film, exposure, &name(variant.name), variant.name)?);
        if variant.best {
            let flip = compare::error_image_with(&image.film, truth, ErrorImage::HdrFlip, &options)?;
            let caption = format!("{}: HDR-FLIP", variant.name);
            all.push(lab.picture(&flip, 0.0, &name("hdr flip"), &caption)?);
        }
    }
    Ok(all)
}

fn text() -> Vec<String> {
    vec![
        "Small pieces of fur at full density, dark and light. The reference traces every hair, guard and undercoat, with all orders of \
         scattering. It has the renderer's directional lights, hair colours and fibre models, so that the approximation of the \
         lights is not measured. Images of one case have the same exposure."
            .into(),
        "\"Strands only\" has no undercoat and scatters once; guard hairs are added until it takes about as long as the hybrid. The \
         paper's shading ignores the scene's fibre models where the paper has its own. Times are those of one image of this size on the \
         adapter named above, including all that is computed before the first ray."
            .into(),
    ]
}
