//! The command line with valid input.

use crate::common::{Folder, Run, command, pelage, root, run};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e} in {text}"))
}

/// A small PNG with one colour.
fn picture(folder: &Folder, name: &str, rgb: [u8; 3]) -> String {
    let path = folder.at(name);
    image::RgbImage::from_pixel(32, 16, image::Rgb(rgb)).save(&path).unwrap();
    path
}

#[test]
fn help_and_version_are_not_errors() {
    for args in [&["--help"][..], &["--version"], &["render", "--help"], &["help", "check"]] {
        let run = pelage(args).expect(0, &[]);
        assert!(!run.out.is_empty() && run.err.is_empty(), "{run:?}");
    }
    assert!(pelage(&["--version"]).out.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_subcommand_exists() {
    let help = pelage(&["--help"]).out;
    for name in
        ["render", "check", "presets", "schema", "devices", "export", "bake", "compare", "bench", "figure"]
    {
        assert!(help.contains(&format!("  {name} ")), "{name} is not in\n{help}");
        pelage(&[name, "--help"]).expect(0, &[]);
    }
}

#[test]
fn the_schema_is_json() {
    let schema = json(&pelage(&["schema"]).expect(0, &[]).out);
    assert_eq!(schema["type"], "object");
    assert_eq!(schema["$defs"]["Camera"]["properties"]["fov"]["exclusiveMaximum"], 180);
    for table in ["mesh", "camera", "lights", "environment", "base", "guard", "undercoat", "film", "render"] {
        assert!(schema["properties"][table].is_object(), "{table}");
    }
}

#[test]
fn check_says_what_to_expect() {
    let text = pelage(&["check", "scenes/default.toml"]).expect(0, &[]).out;
    let lines: Vec<_> = text.lines().map(|line| line.split_whitespace().next().unwrap_or_default()).collect();
    assert_eq!(
        lines,
        ["body", "guard", "undercoat", "mesh", "objects", "picture", "memory", "time"],
        "{text}"
    );
    // The body is 20 cm long, its guard hairs 0.55 times 2.1 cm.
    for part in
        ["body         20.00 x", "up to 1.155 cm, 5.8 % of the body's largest side", " of 1.0 GiB on the GPU"]
    {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let small = ["check", "scenes/hat.toml", "-D", "mesh.size=0.5"];
    pelage(&small).expect(0, &["longest hair has 2.1 cm, more than a quarter", "groom.scale", "mesh.size"]);
    let text = pelage(&["check", "scenes/default.toml", "--fur", "base"]).expect(0, &[]).out;
    assert!(!text.contains("guard hairs") && !text.contains("undercoat"), "{text}");
}

#[test]
fn check_prints_the_resolved_scene() {
    let args = ["check", "scenes/default.toml", "--full", "-D", "camera.fov=31"];
    let text = pelage(&args).expect(0, &[]).out;
    for part in ["fov = 31", "# body ", "# memory ", "[undercoat.fibre]"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    // The output is a scene file.
    let folder = Folder::new();
    let resolved = folder.write("resolved.toml", &text);
    let again = pelage(&["check", &resolved, "--full"]).expect(0, &[]).out;
    assert_eq!(again, text);
}

#[test]
fn check_measures_the_time() {
    let args = ["check", "tests/data/small.toml", "--json", "--measure"];
    let time = &json(&pelage(&args).expect(0, &[]).out)["time"];
    let seconds = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{time}"));
    let (least, most) = (seconds(&time["total"][0]), seconds(&time["total"][1]));
    assert!(0.0 < least && least < most, "{time}");
    assert!(seconds(&time["preparation"]) > 0.0 && time["adapter"].is_string(), "{time}");
}

#[test]
fn check_prints_json() {
    let args = ["check", "scenes/default.toml", "--json", "--spp", "7", "--fur", "base", "--size", "20x10"];
    let value = json(&pelage(&args).expect(0, &[]).out);
    assert_eq!(value["scene"]["film"]["spp"], 7);
    assert_eq!(value["scene"]["film"]["width"], 20);
    assert_eq!(value["scene"]["film"]["height"], 10);
    assert_eq!(value["counts"]["strands"], 0, "the base has no hairs");
    assert!(value["bytes"]["budget"].is_u64());
    assert!(value["notes"].is_array());
    assert_eq!(value["time"], Value::Null, "nothing was measured");
}

#[test]
fn flags_set_the_scene() {
    let args = [
        "check",
        "scenes/default.toml",
        "--json",
        "--seed",
        "9",
        "--blend",
        "virtual",
        "--virtual-fragments",
        "12",
        "--memory",
        "512MiB",
        "--tile",
        "64",
        "--tonemap",
        "agx",
        "--exposure",
        "-1.5",
        "--strict",
    ];
    let scene = &json(&pelage(&args).expect(0, &[]).out)["scene"];
    assert_eq!(scene["render"]["seed"], 9);
    assert_eq!(scene["render"]["blend"], "virtual");
    assert_eq!(scene["render"]["virtual_fragments"], 12);
    assert_eq!(scene["render"]["memory"], 512 << 20);
    assert_eq!(scene["render"]["tile"], 64);
    assert_eq!(scene["film"]["tonemap"], "agx");
    assert_eq!(scene["film"]["exposure"], -1.5);
    assert_eq!(scene["mesh"]["strict"], true);
}

#[test]
fn a_mesh_on_the_command_line_is_relative_to_the_working_folder() {
    let folder = Folder::new();
    folder.write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let scene = root().join("scenes/hat.toml");
    let mut check = command();
    check.current_dir(folder.path()).arg("check").arg(scene).args(["-D", "mesh.path=tri.obj", "--json"]);
    let value = json(&run(&mut check).expect(0, &[]).out);
    assert_eq!(value["scene"]["mesh"]["path"], "tri.obj");
    assert_eq!(value["scene"]["mesh"]["shape"], Value::Null);
}

#[test]
fn assets_are_found_through_the_environment() {
    let (scenes, assets) = (Folder::new(), Folder::new());
    assets.write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let scene = scenes.write("s.toml", "[mesh]\npath = \"tri.obj\"\n");
    pelage(&["check", &scene]).expect(3, &["mesh.path", "PELAGE_ASSETS (not set)"]);
    run(command().args(["check", &scene]).env("PELAGE_ASSETS", assets.path())).expect(0, &[]);
}

#[test]
fn compare_prints_metrics_and_passes_equal_images() {
    let folder = Folder::new();
    let a = picture(&folder, "a.png", [100, 120, 140]);
    let text =
        pelage(&["compare", &a, &a, "--threshold-rmse", "0", "--threshold-flip", "0"]).expect(0, &[]).out;
    for name in ["RMSE", "relative MSE", "PSNR", "FLIP"] {
        assert!(text.contains(name), "{text}");
    }
    let value = json(&pelage(&["compare", &a, &a, "--json"]).expect(0, &[]).out);
    assert_eq!(value["rmse"], 0.0);
    assert_eq!(value["psnr"], Value::Null, "infinite");
}

#[test]
fn compare_fails_past_a_threshold_and_still_writes_the_error_image() {
    let folder = Folder::new();
    let (a, b) = (picture(&folder, "a.png", [100, 120, 140]), picture(&folder, "b.png", [120, 120, 140]));
    pelage(&["compare", &a, &b]).expect(0, &[]);
    for flag in ["--threshold-rmse", "--threshold-flip"] {
        pelage(&["compare", &a, &b, flag, "0.001"]).expect(1, &["more than 0.001"]);
        pelage(&["compare", &a, &b, flag, "1"]).expect(0, &[]);
    }
    for (flag, hard, easy) in [
        ("--threshold-relative-mse", "1e-9", "1"),
        ("--threshold-psnr", "200", "1"),
        ("--threshold-ssim", "1", "0"),
        ("--threshold-hdr-flip", "1e-9", "1"),
        ("--threshold-luminance-ratio", "1e-9", "1"),
        ("--threshold-color-ratio", "1e-9", "1"),
        ("--threshold-max-abs", "1e-9", "1"),
    ] {
        pelage(&["compare", &a, &b, flag, hard]).expect(1, &["than"]);
        pelage(&["compare", &a, &b, flag, easy]).expect(0, &[]);
    }
    pelage(&["compare", &a, &b, "--threshold-ssim", "0", "--region", "silhouette"]).expect(1, &["no pixels"]);
    pelage(&["compare", &a, &b, "--error", "relative*2", "--exposure", "-1.5", "--band", "3"]).expect(0, &[]);
    pelage(&["compare", &a, &b, "--error", "flip*2"]).expect(2, &["hdr-flip"]);
    let error = folder.at("error.png");
    pelage(&["compare", &a, &b, "-o", &error, "--threshold-rmse", "0"]).expect(1, &["RMSE"]);
    assert_eq!(image::open(&error).unwrap().to_rgb8().dimensions(), (32, 16));
    assert_eq!(folder.names(), ["a.png", "b.png", "error.png"]);
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    use std::process::Stdio;
    let mut child = command().arg("schema").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let run = Run::from(child.wait_with_output().unwrap()).expect(0, &[]);
    assert!(run.err.is_empty(), "{}", run.err);
}

#[test]
fn check_estimates_what_the_renderer_prepares() {
    let folder = Folder::new();
    // Triangles whose edges ask for more levels of subdivision than there are.
    let scene =
        folder.write("scene.toml", "[mesh]\nshape = \"pyramid\"\nsize = 40\n[undercoat]\ncell = 0.0002\n");
    let value = json(&pelage(&["check", &scene, "--json", "--fur", "implicit"]).expect(0, &[]).out);
    let triangles = value["counts"]["triangles"].as_u64().unwrap();
    assert_eq!(value["counts"]["subelements"].as_u64().unwrap(), triangles * 24 * 4u64.pow(6));
    assert!(value["bytes"]["lattice"].as_u64().unwrap() > 0);
}

#[test]
fn a_picture_of_a_few_pixels_holds_all_fragments_of_a_pelt() {
    let folder = Folder::new();
    let image = folder.at("out.png");
    pelage(&["render", "scenes/cylinder.toml", "--size", "4x3", "--spp", "1", "-o", &image]).expect(0, &[]);
}

#[test]
fn the_exposure_is_chosen_and_recorded() {
    let folder = Folder::new();
    let image = folder.at("out.png");
    let dark = ["--auto-exposure", "-D", "film.background=\"transparent\"", "--size", "40x25", "--spp", "1"];
    let mut args = vec!["render", "tests/data/small.toml", "-o", &image];
    args.extend(dark);
    let run = pelage(&args).expect(0, &[]);
    assert!(run.out.contains("exposure   ") && run.out.contains(" stops"), "{}", run.out);
    let bytes = std::fs::read(&image).unwrap();
    assert!(bytes.windows(20).any(|w| w == b"pelage.auto_exposure"), "no metadata");
    args.extend(["--exposure", "1"]);
    pelage(&args).expect(2, &["--auto-exposure"]);
}

#[test]
fn frames_without_motion_are_noted() {
    let folder = Folder::new();
    let image = folder.at("out.png");
    let mut args = vec!["render", "tests/data/small.toml", "-o", &image, "--size", "8x5", "--spp", "1"];
    args.extend(["--fur", "base", "--frames", "2"]);
    pelage(&args).expect(0, &["note: nothing moves", "animation.turntable"]);
    args.extend(["-D", "animation.turntable=90"]);
    assert!(!pelage(&args).expect(0, &[]).err.contains("nothing moves"));
}

#[test]
fn an_empty_picture_is_noted() {
    let folder = Folder::new();
    let image = folder.at("out.png");
    let mut args = vec!["render", "tests/data/small.toml", "-o", &image, "--size", "8x5", "--spp", "1"];
    args.extend(["-D", "camera.eye=[0,0,100]", "-D", "camera.target=[0,0,200]"]);
    pelage(&args).expect(0, &["note: no part of the fur is in the picture", "note: the picture is empty"]);
}
