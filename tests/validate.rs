//! The validation measures what it says, misses goals where it should, and writes a report.

use crate::common::{Folder, gpu, json, pelage};
use pelage_core::World;
use pelage_core::scene::{FibreModel, FibreSpec};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_pathtrace::geometry::Geometry;
use pelage_studies::provenance::Provenance;
use pelage_studies::report::Table;
use pelage_studies::validate::furnace::{self, albedo_integrated, albedo_sampled};
use pelage_studies::validate::transmittance::{GOAL, Roots, Slab, through, worst};
use pelage_studies::validate::{Exhibit, Finding, Goal, Level, Picture, Report, Section, html};

#[test]
fn goals() {
    for (goal, good, bad) in [
        (Goal::AtMost(0.1), 0.1, 0.11),
        (Goal::AtLeast(0.9), 0.9, 0.89),
        (Goal::OneWithin(0.1), 0.95, 0.85),
        (Goal::OneWithin(0.1), 1.05, 1.15),
    ] {
        assert!(goal.met(good) && !goal.met(bad) && !goal.met(f64::NAN), "{goal}");
        assert_eq!(Finding::new("a", "b", "c", bad, Some(goal)).met, Some(false));
    }
    assert_eq!(Finding::new("a", "b", "c", f64::NAN, None).met, None);
}

fn slab() -> (World, Slab) {
    (
        gpu::world("[mesh]\nshape = 'plane'"),
        Slab { density: 2000.0, diameter: 0.0015, height: 0.3, fill: 1.0 },
    )
}

/// Transmittances by the angle, degrees.
fn measured(world: &World, slab: &Slab, roots: Roots) -> Vec<[f64; 2]> {
    let coats = vec![(slab.strands(roots, 3), Fibre::undercoat(&world.scene))];
    let geometry = Geometry::new(world, coats).expect("strands that fit each other");
    let at =
        |degrees: f32| [f64::from(degrees), through(&geometry, slab.height, degrees.to_radians(), 20_000)];
    [10.0, 45.0, 60.0, 75.0].map(at).to_vec()
}

fn expected(slab: &Slab, like: &[[f64; 2]]) -> Vec<[f64; 2]> {
    like.iter().map(|[degrees, _]| [*degrees, slab.expected(degrees.to_radians())]).collect()
}

#[test]
fn strands_follow_beer_and_lambert_and_wrong_ones_do_not() {
    let (world, slab) = slab();
    let random = measured(&world, &slab, Roots::Random);
    let off = worst(&random, &expected(&slab, &random));
    println!("random roots: {random:.4?}, off by {off:.4}");
    assert!(off < GOAL);
    for wrong in
        [Slab { diameter: 1.1 * slab.diameter, ..slab }, Slab { density: 0.9 * slab.density, ..slab }]
    {
        let off = worst(&random, &expected(&wrong, &random));
        assert!(off > GOAL, "{wrong:?} is off by {off:.4} only");
    }
    let mut broken = random.clone();
    broken[1][1] = f64::NAN;
    assert!(worst(&broken, &random).is_nan());
    // One hair in each square of a grid leaves fewer gaps.
    let jittered = measured(&world, &slab, Roots::Jittered);
    assert!(jittered[2][1] < random[2][1] - 0.005, "{jittered:.4?}");
}

#[test]
fn furnace_sees_what_a_fibre_loses_and_gains() {
    let of = |model, diffuse| {
        let spec = FibreSpec { model: Some(model), diffuse, ..FibreSpec::default() };
        Fibre::new(&spec, Layer::Undercoat, false)
    };
    for sin in [0.0, 0.6, -0.9] {
        for (fibre, wanted) in [
            (of(FibreModel::KajiyaKay, None), 1.0),
            (of(FibreModel::KajiyaKay, Some(0.7)), 0.7),
            (of(FibreModel::KajiyaKay, Some(1.1)), 1.1),
            (of(FibreModel::Chiang, None), 1.0),
        ] {
            let found = [albedo_sampled(&fibre, sin, 40_000), albedo_integrated(&fibre, sin, 64)];
            for value in found {
                assert!((value - wanted).abs() < furnace::GOAL, "{found:?} is not {wanted} at {sin}");
            }
        }
    }
}

fn report(value: f64) -> Report {
    let finding =
        Finding::new("volume <march>", "a case", "luminance ratio", value, Some(Goal::OneWithin(0.1)));
    Report {
        provenance: Provenance {
            version: "1.2.3".into(),
            commit: "unknown".into(),
            command: vec!["pelage".into(), "validate".into()],
            date: "2020-01-02T03:04:05Z".into(),
            adapter: "an adapter".into(),
            backend: "Vulkan".into(),
            device_type: "Cpu".into(),
            driver: "a driver".into(),
        },
        threads: 2,
        level: Level::Quick,
        seconds: 12.0,
        sections: vec![Section {
            name: "volume".into(),
            title: "A title".into(),
            findings: vec![finding.in_seconds(1.5)],
            exhibits: vec![Exhibit {
                table: Some(Table {
                    caption: "t".into(),
                    head: vec!["a".into()],
                    rows: vec![vec!["0.25".into()]],
                }),
                pictures: vec![Picture { file: "a.png".into(), caption: "a picture".into() }],
            }],
            skipped: vec!["a bunny".into()],
            ..Section::default()
        }],
    }
}

#[test]
fn a_missed_goal_shows_in_the_page_and_in_the_verdict() {
    let good = report(1.05);
    assert!(good.verdict().is_ok());
    let page = html::page(&good);
    for part in [
        "All 1 goals are met",
        "volume &lt;march&gt;",
        "1 ± 0.1",
        "an adapter",
        "2020-01-02",
        "pelage validate",
        "src=\"a.png\"",
        "a bunny",
        ">1.5<",
    ] {
        assert!(page.contains(part), "{part} is not in\n{page}");
    }
    for outside in ["<script", "http:", "https:", "//cdn"] {
        assert!(!page.contains(outside), "the page needs {outside}");
    }
    for wrong in [0.8, 1.2, f64::NAN] {
        let bad = report(wrong);
        let error = bad.verdict().unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().contains("luminance ratio"), "{error}");
        assert!(html::page(&bad).contains("1 of 1 goals are missed"));
    }
}

#[test]
fn the_command_writes_a_report() {
    let folder = Folder::new();
    let out = folder.at("report");
    pelage(&["validate", "--only", "nonsense", "-o", &out]).expect(2, &["nonsense", "transmittance"]);
    pelage(&["validate", "--quick", "--full", "-o", &out]).expect(2, &["--full"]);
    if gpu::open().is_none() {
        return;
    }
    let text = pelage(&["validate", "--quick", "--only", "transmittance", "-o", &out]).expect(0, &[]).out;
    assert!(
        text.contains("march through the volume") && text.contains("met") && !text.contains("MISSED"),
        "{text}"
    );
    let value = json(format!("{out}/report.json"));
    let findings = value["sections"][0]["findings"].as_array().expect("findings");
    assert!(findings.len() >= 4 && findings.iter().all(|f| f["met"] != false), "{findings:?}");
    assert_eq!(value["level"], "quick");
    let page = std::fs::read_to_string(format!("{out}/report.html")).expect("a page");
    assert!(page.contains("<svg") && page.contains("march through the volume"), "{page}");
}
