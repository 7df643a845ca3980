//! Renderings of the path tracer: threads, passes, resuming from a file, convergence, the command.

use crate::common::hairs::*;
use crate::common::{Folder, on_threads, pelage};
use glam::Vec3;
use pelage_core::film::{Film, io};
use pelage_core::scene::DirectionalLight;
use pelage_core::{Error, World};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_pathtrace::strands::Strands;
use pelage_pathtrace::{self as pathtrace, Accumulator, Integrator, LightModel, Options, Outcome};

fn world() -> World {
    empty_world(|s| {
        s.environment = Some(sky());
        s.lights = vec![DirectionalLight::default()];
        s.camera.eye = [1.0, 5.0, 3.0];
        s.camera.target = [0.0, 0.2, 0.0];
        s.camera.fov = 8.0;
        s.film.filter = pelage_core::scene::Filter::Mitchell;
    })
}

fn coats() -> Vec<(Strands, Fibre)> {
    let coat = |layer, count, radius, seed| {
        let color = Vec3::new(0.9, 0.6, 0.3);
        (strands(layer, 6, coat(count, 0.8, 0.6, radius, 0.4, 6, seed), color), diffuse())
    };
    vec![coat(Layer::Guard, 40, 0.012, 1), coat(Layer::Undercoat, 400, 0.004, 2)]
}

fn outcome(world: &World, options: &Options<'_>) -> Outcome {
    pathtrace::render_layers(world, coats(), options, &mut |_| Ok(())).expect("a picture")
}

fn bits(film: &Film) -> Vec<(String, Vec<u32>)> {
    film.planes.iter().map(|p| (p.name.clone(), p.data.iter().map(|v| v.to_bits()).collect())).collect()
}

#[test]
fn threads_and_passes_do_not_change_the_image() {
    let world = world();
    let base = options(Integrator::Path, LightModel::Map, 12);
    let of = |threads: usize, pass: u32| {
        on_threads(threads, || outcome(&world, &Options { pass, ..base.clone() }).film)
    };
    let one = bits(&of(1, 4));
    assert!(one == bits(&of(3, 4)), "threads show");
    assert!(one == bits(&of(2, 6)), "passes show");
    let other = outcome(&world, &Options { seed: 1, ..base.clone() }).film;
    assert!(one != bits(&other), "another seed has the same samples");
}

#[test]
fn parts_add_up() {
    let world = world();
    let film = outcome(&world, &options(Integrator::Path, LightModel::Map, 8)).film;
    for c in ["R", "G", "B"] {
        let parts: f64 =
            ["guard", "undercoat", "base"].iter().map(|l| mean(&film, &format!("{l}.{c}"))).sum();
        assert!((parts - mean(&film, c)).abs() < 1e-5, "{c}");
    }
    assert!(mean(&film, "guard.R") > 0.0 && mean(&film, "undercoat.R") > 0.0);
    let depths: Vec<f32> = film.plane("depth.Z").unwrap().iter().copied().filter(|z| z.is_finite()).collect();
    assert!(!depths.is_empty() && depths.iter().all(|z| (4.5..7.0).contains(z)));
}

#[test]
fn a_resumed_rendering_equals_an_uninterrupted_one() {
    let world = world();
    let folder = Folder::new();
    let path = folder.path().join("half.exr");
    let base = Options { samples: Some(6), ..options(Integrator::Path, LightModel::Map, 6) };
    let identity = pathtrace::Identity::new(&world, &base);
    let save = |film: &Film, samples: u32, path: &std::path::Path| {
        io::write(film, path, &identity.metadata(samples), &world.scene.film).unwrap();
    };
    let first = outcome(&world, &base);
    save(&first.film, first.samples, &path);
    let start = identity.read(&path, [24, 24]).expect("means");
    let more = Options { samples: Some(22), start: Some(start), ..base.clone() };
    let resumed = outcome(&world, &more);
    let whole = outcome(&world, &Options { samples: Some(22), ..base.clone() });
    assert_eq!((resumed.samples, whole.samples), (22, 22));
    assert!(bits(&resumed.film) == bits(&whole.film));
    let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
    save(&resumed.film, 22, &a);
    save(&whole.film, 22, &b);
    assert!(std::fs::read(a).unwrap() == std::fs::read(b).unwrap());
    // The error names the difference.
    let mut other = world.clone();
    other.scene.guard.length = 3.0.into();
    let options = Options { integrator: Integrator::Single, seed: 7, ..base };
    let fault = pathtrace::Identity::new(&other, &options).read(&path, [24, 24]).unwrap_err();
    let text = fault.to_string();
    for word in ["integrator", "sampling_seed", "scene_sha256", "half.exr"] {
        assert!(text.contains(word), "no {word} in: {text}");
    }
    assert!(matches!(fault, Error::Usage(_)) && !text.contains("found version"));
}

#[test]
fn error_between_halves_falls_as_one_over_the_samples_and_is_that_against_the_truth() {
    let world = world();
    let base = options(Integrator::Path, LightModel::Map, 16);
    let few = outcome(&world, &base);
    let many = outcome(&world, &Options { samples: Some(256), ..base.clone() });
    let ratio = few.error / many.error;
    println!("16 samples {:.3e}, 256 samples {:.3e}, ratio {ratio:.1}", few.error, many.error);
    // Evenly spread samples are better than independent ones at the hairs' edges.
    assert!((12.0..80.0).contains(&ratio), "{ratio}");
    let truth = outcome(&world, &Options { samples: Some(4096), seed: 5, ..base.clone() });
    let actual = pelage_studies::compare::compare(&few.film, &truth.film).unwrap().all.relative_mse;
    println!("16 samples against the truth: {actual:.3e}");
    assert!((0.6..1.6).contains(&(actual / few.error)), "{actual} is not {}", few.error);
    // The variance gives the same error, except that sequences are better than independent samples.
    let (variance, mean_square) = (mean(&few.film, "variance.Y"), {
        let (a, b) = (few.film.plane("half0.G").unwrap(), few.film.plane("half1.G").unwrap());
        a.iter().zip(b).map(|(a, b)| f64::from(0.25 * (a - b) * (a - b))).sum::<f64>() / a.len() as f64
    });
    println!("variance {variance:.3e}, from halves {mean_square:.3e}");
    assert!((0.5..6.0).contains(&(variance / mean_square)), "{variance} {mean_square}");
    // The rendering stops when it reaches the given error.
    let reached = outcome(&world, &Options { samples: None, error: Some(2.0 * many.error), ..base });
    assert!(reached.error <= 2.0 * many.error && reached.samples < 256, "{reached:?}");
}

#[test]
fn a_limit_is_required_and_memory_is_bounded() {
    let world = world();
    let none = Options { samples: None, ..Options::default() };
    let fault = pathtrace::render_layers(&world, coats(), &none, &mut |_| Ok(())).unwrap_err();
    assert!(matches!(fault, Error::Usage(_)), "{fault}");
    let small = Options { memory: 1000, ..Options::default() };
    let fault = pathtrace::render_layers(&world, coats(), &small, &mut |_| Ok(())).unwrap_err();
    assert!(fault.to_string().contains("--memory"), "{fault}");
    let mut broken = coats();
    broken[1].0.points.pop();
    let fault = pathtrace::render_layers(&world, broken, &Options::default(), &mut |_| Ok(())).unwrap_err();
    assert!(fault.to_string().contains("Undercoat"), "{fault}");
    let start = Some(Accumulator::new(3, 3));
    let other = Options { start, ..Options::default() };
    assert!(pathtrace::render_layers(&world, coats(), &other, &mut |_| Ok(())).is_err());
}

const SCENE: &str = "preset = 'rabbit'\n[mesh]\nshape = 'sphere'\nsize = 2\n[camera]\neye = [0, 1, 7]\nfov = 24\n\
    [film]\nwidth = 32\nheight = 24\n[guard]\ndensity = 100\n[undercoat]\ndensity = 500\n[[lights]]\n";

#[test]
fn the_command_writes_resumes_and_reports_errors() {
    let folder = Folder::new();
    let scene = folder.write("ball.toml", SCENE);
    let (exr, whole) = (folder.at("ball.exr"), folder.at("whole.exr"));
    let run = |out: &str, more: &[&str]| {
        let mut args = vec!["reference", &scene, "-o", out, "--integrator", "single"];
        args.extend(more);
        pelage(&args)
    };
    let first = run(&exr, &["--spp", "2"]).expect(0, &[]);
    assert!(first.out.contains("2 spp") && first.out.contains("million/s"), "{}", first.out);
    run(&exr, &["--spp", "6", "--resume", "--quiet"]).expect(0, &[]);
    run(&whole, &["--spp", "6", "--threads", "1"]).expect(0, &[]);
    assert!(std::fs::read(&exr).unwrap() == std::fs::read(&whole).unwrap());
    run(&exr, &["--spp", "6", "--resume", "--depth", "9", "--sampling-seed", "3"])
        .expect(2, &["depth \"256\"", "sampling_seed"]);
    run(&exr, &["--spp", "2", "--memory", "16MiB"]).expect(2, &["GiB", "patch"]);
    run(&exr, &["--patch", "0,0,0"]).expect(2, &["x,y,z,r"]);
    let film = io::read(&exr).unwrap();
    assert!(mean(&film, "guard.G") > 0.0 && mean(&film, "undercoat.G") > 0.0 && mean(&film, "base.G") > 0.0);
    assert!((mean(&film, "A") - 1.0).abs() < 1e-6, "the background is opaque");
    let patch = folder.at("patch.png");
    run(&patch, &["--spp", "2", "--patch", "0,0,1,0.3", "--layers", "undercoat"]).expect(0, &[]);
}
