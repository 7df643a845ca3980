//! Scene files: parsing, faults, overrides, includes, presets, the schema.

use crate::common::{self, Folder, cases};
use pelage_core::scene::{self, Blend, Color, Framing, FurLayers, Scalar, Shape, preset};
use pelage_core::{Error, Scene, SceneFault};
use proptest::prelude::*;

const MINIMAL: &str = "[mesh]\nshape = \"sphere\"\n";

fn faults(text: &str, overrides: &[&str]) -> Vec<SceneFault> {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    match Scene::parse(text, "test.toml", &overrides) {
        Err(e @ Error::Scene(_)) => {
            assert_eq!(e.exit_code(), 3);
            let Error::Scene(faults) = e else { unreachable!() };
            faults
        }
        other => panic!("expected faults, got {other:?}"),
    }
}

fn parse(text: &str, overrides: &[&str]) -> Scene {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    Scene::parse(text, "test.toml", &overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// The only fault of a scene with `line` added: its message and help.
fn fault(line: &str) -> String {
    let faults = faults(&format!("{MINIMAL}\n{line}\n"), &[]);
    assert_eq!(faults.len(), 1, "{faults:?}");
    faults[0].to_string()
}

#[test]
fn a_minimal_scene_has_the_defaults() {
    let scene = parse(MINIMAL, &[]);
    let mut expected = Scene::default();
    expected.mesh.shape = Some(Shape::Sphere);
    // A camera without a position frames the fur.
    expected.camera.frame = Framing::Auto;
    expected.camera.fov = 20.0;
    assert_eq!(scene, expected);
}

#[test]
fn values_are_read() {
    let scene = parse(
        "[mesh]\npath = \"a.obj\"\nsize = 20\n[guard]\nlength = { map = \"l.png\", value = 2, offset = 0.5 }\n\
         density = 100\ncolor_tip = { map = \"vertex_color\" }\n[render]\nfur = \"implicit\"\nmemory = 1_000_000_000\n\
         [[lights]]\ndirection = [0, 1, 0]\n[environment]\nlights = 4\n[camera.lens]\naperture = 1",
        &[],
    );
    assert_eq!(scene.mesh.size, Some(20.0));
    assert_eq!(scene.guard.density, Scalar::Constant(100.0));
    assert!(matches!(&scene.guard.length, Scalar::Mapped(m) if m.value == 2.0 && m.offset == 0.5));
    assert!(matches!(&scene.guard.color_tip, Color::Mapped(m) if m.map == "vertex_color"));
    assert_eq!(scene.render.fur, FurLayers::Implicit);
    assert_eq!(scene.render.memory, 1_000_000_000);
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(scene.lights[0].irradiance, [3.0; 3]);
    assert_eq!(scene.environment.as_ref().map(|e| e.lights), Some(4));
    assert!(scene.camera.lens.is_some());
}

#[test]
fn all_faults_come_at_once_with_their_places() {
    let text =
        "width = 3\n[mesh]\nshape = \"spere\"\n\n[camera]\nfov = 180\n  eye = [1, 2]\n[film]\nspp = 0.5\n";
    let found: Vec<_> = faults(text, &["camera.nearr=1"]).iter().map(|f| (f.line, f.column)).collect();
    // By file name: the flag's fault, which has no line, comes first.
    assert_eq!(found, [(0, 0), (1, 1), (3, 9), (6, 7), (7, 9), (9, 7)]);
}

#[test]
fn unknown_keys_are_answered_with_a_suggestion() {
    for (line, help) in [
        ("[guard]\nlenght = 1", "did you mean \"length\"?"),
        ("[gard]\nlength = 1", "did you mean \"guard\"?"),
        ("[camera]\nspp = 4", "did you mean \"film.spp\"?"),
        ("[camera.lens]\napperture = 4", "did you mean \"aperture\"?"),
        ("[film]\npreset = \"wolf\"", "belongs to the top"),
        ("[base]\nqqqqqqqq = 1", "known: color"),
        ("[film]\ntonemap = \"agxx\"", "did you mean \"agx\"?"),
    ] {
        let fault = fault(line);
        assert!(fault.contains(help), "{fault}");
    }
    assert!(
        faults("preset = \"brown_mnk\"\n[mesh]\nshape = \"hat\"", &[])[0]
            .help
            .as_deref()
            .is_some_and(|h| h.contains("\"brown_mink\""))
    );
}

#[test]
fn wrong_types_say_what_was_expected_and_found() {
    for (line, parts) in [
        ("[camera]\nfov = \"wide\"", ["camera.fov: expected a number", "the string \"wide\""]),
        ("[film]\nspp = 1.5", ["film.spp: expected an integer", "found 1.5"]),
        ("[camera]\neye = [1, 2]", ["expected an array of 3 numbers", "array of 2 values"]),
        (
            "[guard]\ncolor_tip = \"red\"",
            ["guard.color_tip: expected an array of 3 numbers or a table", "red"],
        ),
        ("[guard]\nlength = { value = 2 }", ["guard.length", "the key \"map\" is missing"]),
        ("[environment]\nvisible = 1", ["expected true or false", "found 1"]),
        ("[film]\nexposure = 1979-05-27", ["film.exposure", "the date"]),
        ("[[camera]]\nfov = 3", ["camera: expected a table", "an array"]),
        ("[render]\nseed = 99999999999999999999", ["render.seed", "too large"]),
    ] {
        let fault = fault(line);
        parts.iter().for_each(|part| assert!(fault.contains(part), "no {part:?} in {fault}"));
    }
}

#[test]
fn ranges_are_checked() {
    for line in [
        "[camera]\nfov = 0",
        "[camera]\nfov = 180",
        "[camera]\nnear = 0",
        "[guard]\ndensity = -1",
        "[guard]\nsegments = 0",
        "[guard]\nsegments = 65",
        "[guard]\nlength_variation = 1.01",
        "[guard]\ndiameter = [0, 1, 1]",
        "[guard]\nclump = 2",
        "[guard]\ncolor_root = [0, 0, 1.5]",
        "[guard.fibre]\nwidth = [0, 5, 5]",
        "[undercoat]\nlayers = 0",
        "[undercoat]\nlayers = 257",
        "[undercoat]\nsubdivision = 8",
        "[undercoat]\ndiameter = [10, -1]",
        "[undercoat]\nforward_scattering = 1.5",
        "[film]\nwidth = 0",
        "[film]\nheight = 32769",
        "[film]\nspp = 0",
        "[environment]\nlights = 0",
        "[environment]\nlights = 65",
        "[[lights]]\nirradiance = [1, -1, 1]",
        "[render]\nseed = -1",
        "[render]\nseed = 4294967296",
        "[render]\nmemory = 1000",
        "[camera]\nfov = nan",
        "[camera]\neye = [inf, 0, 0]",
        "[camera]\neye = [1e39, 0, 0]",
    ] {
        let fault = fault(line);
        assert!(fault.contains("must be") || fault.contains("finite"), "{line}: {fault}");
    }
    for line in
        ["[guard]\ndensity = 0", "[undercoat]\nlayers = 256\nsubdivision = 7", "[film]\nwidth = 32768"]
    {
        parse(&format!("{MINIMAL}{line}"), &[]);
    }
}

#[test]
fn inconsistent_values_are_faults() {
    for (line, part) in [
        ("path = \"x.obj\"", "both mesh.path and mesh.shape"),
        ("[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]", "eye and target are the same"),
        ("[camera]\neye = [0, 5, 0]", "parallel"),
        ("[camera]\neye = [0, 0, 9]\nup = [0, 0, 0]", "up is zero"),
        ("[film]\nbackground = \"plate\"", "film.plate"),
        ("[[lights]]\ndirection = [0, 0, 0]", "lights.0.direction"),
        ("[guard]\nlength = { map = \"a.png\", value = -1, offset = -1 }", "negative everywhere"),
        ("[film]\nwidth = 32768\nheight = 32768", "pixels"),
    ] {
        let fault = fault(line);
        assert!(fault.contains(part), "no {part:?} in {fault}");
    }
    assert!(faults("", &[])[0].message.contains("neither mesh.path nor mesh.shape"));
    // A misspelt key is one fault, not two.
    assert_eq!(faults("[mesh]\nshap = \"hat\"", &[]).len(), 1);
}

#[test]
fn syntax_errors_come_all_at_once() {
    let lines: Vec<_> =
        faults("[mesh\nshape = \"hat\"\n[film]\nspp = = 3\n", &[]).iter().map(|f| f.line).collect();
    assert!(lines.contains(&1) && lines.contains(&4), "{lines:?}");
}

#[test]
fn overrides_replace_values_of_the_file() {
    let scene = parse(
        &format!("{MINIMAL}[camera]\nfov = 20\n[[lights]]\ndirection = [0, 1, 0]\n"),
        &[
            "camera.fov=30",
            "render.blend=virtual",
            "mesh.path=meshes/some cat.obj",
            "lights.0.irradiance=[1, 2, 3]",
            "lights.1.direction=[1,0,0]",
            "camera.eye.1=8",
            "guard.length={map=\"a.png\"}",
            "environment.lights=3",
            "film.plate=\"1\"",
        ],
    );
    assert_eq!(scene.camera.fov, 30.0);
    assert_eq!(scene.camera.eye, [0.0, 8.0, 30.0]);
    assert_eq!(scene.render.blend, Blend::Virtual);
    assert_eq!((scene.mesh.path.as_deref(), scene.mesh.shape), (Some("meshes/some cat.obj"), None));
    assert_eq!(scene.lights[0].direction, [0.0, 1.0, 0.0]);
    assert_eq!(scene.lights[0].irradiance, [1.0, 2.0, 3.0]);
    assert_eq!(scene.lights[1].direction, [1.0, 0.0, 0.0]);
    assert!(matches!(&scene.guard.length, Scalar::Mapped(m) if m.map == "a.png" && m.value == 1.0));
    assert_eq!(scene.environment.map(|e| e.lights), Some(3));
    assert_eq!(scene.film.plate, "1");
}

#[test]
fn faults_of_overrides_name_the_flag() {
    for (flag, part) in [
        ("camera.fov=wide", "expected a number, found the string \"wide\""),
        ("camera.fvo=3", "did you mean \"fov\"?"),
        ("film.spp=0", "must be at least 1"),
        ("lights.3.direction=[1,0,0]", "no item 3"),
        ("lights.first.direction=[1,0,0]", "expected an index"),
        ("camera..fov=3", "expected a key path"),
        ("include=[\"a.toml\"]", "found include, which cannot be set"),
        ("camera.fov", "expected key.path=value"),
        ("preset=dodo", "no preset is called \"dodo\""),
    ] {
        let text = format!("{MINIMAL}[[lights]]\n");
        let found = faults(&text, &[flag]);
        assert_eq!(found.len(), 1, "{found:?}");
        let fault = found[0].to_string();
        assert!(fault.starts_with(&format!("-D {flag}: ")) && fault.contains(part), "{fault}");
    }
}

#[test]
fn the_file_replaces_values_of_presets() {
    let text = format!("preset = \"red_fox\"\n{MINIMAL}[guard]\nlength = 1.5\n");
    let scene = parse(&text, &["guard.diameter.1=70"]);
    let whole = parse(&format!("preset = \"red_fox\"\n{MINIMAL}"), &[]);
    assert_eq!(scene.guard.length, Scalar::Constant(1.5));
    assert_eq!(scene.guard.density, whole.guard.density);
    assert_ne!(whole.guard, Scene::default().guard);
    assert_eq!(scene.guard.diameter, [whole.guard.diameter[0], 70.0, whole.guard.diameter[2]]);
    assert_eq!(scene.undercoat, whole.undercoat);
    assert_eq!(parse(&text, &["preset=wolf"]).preset.as_deref(), Some("wolf"));
}

#[test]
fn every_preset_is_listed_and_valid() {
    let mut files: Vec<_> = std::fs::read_dir(common::root().join("presets"))
        .unwrap()
        .map(|f| f.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    files.sort();
    assert_eq!(files, preset::names().collect::<Vec<_>>());
    assert!(files.len() >= 5);
    for name in preset::names() {
        let scene = parse(&format!("preset = \"{name}\"\n{MINIMAL}"), &[]);
        let (guard, under) = (&scene.guard, &scene.undercoat);
        assert!(guard.length.max() > under.height.max(), "{name}: guard hairs rise above the undercoat");
        assert!(guard.density.max() * 4.0 < under.density.max(), "{name}: guard hairs are the fewer");
        assert!(guard.diameter[1] > 2.0 * under.diameter[0], "{name}: guard hairs are the thicker");
    }
}

#[test]
fn presets_differ() {
    let scenes: Vec<_> =
        preset::names().map(|n| (n, parse(&format!("preset = \"{n}\"\n{MINIMAL}"), &[]))).collect();
    let sizes = |s: &Scene| {
        [&s.guard.density, &s.guard.length, &s.undercoat.density, &s.undercoat.height].map(|v| v.max().ln())
    };
    let colors = |s: &Scene| {
        let all = [&s.guard.color_root, &s.guard.color_tip, &s.undercoat.color_tip];
        all.map(|c| if let Color::Constant(c) = c { *c } else { panic!("presets have constant colours") })
    };
    for (i, (a, x)) in scenes.iter().enumerate() {
        for (b, y) in &scenes[..i] {
            let shape: f32 = sizes(x).iter().zip(sizes(y)).map(|(x, y)| (x - y).abs()).sum();
            let color: f32 = colors(x)
                .as_flattened()
                .iter()
                .zip(colors(y).as_flattened())
                .map(|(x, y)| (x - y).abs())
                .sum();
            assert!(shape > 0.5 && color > 0.5, "{a} and {b}: {shape} in size, {color} in colour");
        }
    }
}

#[test]
fn the_file_replaces_values_of_includes() {
    let folder = Folder::new();
    folder.write(
        "base.toml",
        "[film]\nspp = 2\nwidth = 100\n[mesh]\nshape = \"hat\"\nsize = 3\n[[lights]]\n[[lights]]\n",
    );
    folder.write("over.toml", "[film]\nspp = 3\n[[lights]]\ndirection = [1, 0, 0]\n");
    let main = folder.write(
        "main.toml",
        "include = [\"base.toml\", \"over.toml\"]\npreset = \"rabbit\"\n[film]\nheight = 50\n[mesh]\nshape = \"torus\"\n",
    );
    let (scene, assets) = Scene::load(main.as_ref(), &[]).unwrap();
    assert_eq!((scene.film.spp, scene.film.width, scene.film.height), (3, 100, 50));
    assert_eq!((scene.mesh.shape, scene.mesh.size), (Some(Shape::Torus), Some(3.0)));
    assert_eq!(scene.lights.len(), 1, "arrays are replaced");
    assert!(scene.include.is_empty());
    assert_eq!(assets.folders[0], folder.path());

    // A mesh file over an included shape hides the shape.
    folder.write("x.obj", "v 0 0 0\n");
    let mesh = folder.write("mesh.toml", "include = [\"base.toml\"]\n[mesh]\npath = \"x.obj\"\n");
    let (scene, _) = Scene::load(mesh.as_ref(), &[]).unwrap();
    assert_eq!((scene.mesh.path.as_deref(), scene.mesh.shape), (Some("x.obj"), None));
}

#[test]
fn faults_of_included_files_name_them() {
    let folder = Folder::new();
    folder.write("inner.toml", "[film]\n\nspp = 0\n");
    let main =
        folder.write("main.toml", "include = [\"inner.toml\"]\n[mesh]\nshape = \"hat\"\n[camera]\nfov = 0\n");
    let text = Scene::load(main.as_ref(), &[]).unwrap_err().to_string();
    assert!(text.contains("inner.toml:3:7: film.spp"), "{text}");
    assert!(text.contains("main.toml:5:7: camera.fov"), "{text}");
}

#[test]
fn a_resolved_scene_reads_back_the_same() {
    for name in preset::names() {
        let scene =
            parse(&format!("preset = \"{name}\"\n{MINIMAL}[camera.lens]\n[environment]\n[[lights]]\n"), &[]);
        let text = toml::to_string(&scene).unwrap();
        assert_eq!(parse(&text, &[]), scene, "{text}");
    }
}

#[test]
fn every_scene_of_the_repository_is_valid() {
    let downloaded = common::assets().is_some();
    let files = |folder: &str| std::fs::read_dir(common::root().join(folder)).unwrap();
    for file in files("scenes").chain(files("scenes/validate")) {
        let path = file.unwrap().path();
        if path.is_dir() {
            continue;
        }
        match Scene::load(&path, &[]) {
            Ok(_) => {}
            Err(Error::Scene(faults)) if !downloaded => {
                let missing = faults.iter().all(|f| f.message.contains("is not there"));
                assert!(missing, "{}: {faults:?}", path.display());
            }
            Err(e) => panic!("{e}"),
        }
    }
}

#[test]
fn the_schema_describes_everything() {
    let schema = scene::json_schema();
    assert_eq!(schema.pointer("/$defs/Undercoat/properties/layers/maximum"), Some(&256.into()));
    assert_eq!(schema.pointer("/additionalProperties"), Some(&false.into()));
    let tables = schema["$defs"].as_object().unwrap().values().chain([schema]);
    for (key, property) in tables.filter_map(|t| t["properties"].as_object()).flatten() {
        assert!(property["description"].is_string(), "{key} has no description");
    }
}

proptest! {
    #![proptest_config(cases(300))]

    /// Every file is read or is an error; none crashes the parser.
    #[test]
    fn damaged_files_are_errors(at in 0_usize..600, length in 0_usize..20, noise in "[ -~\\n\u{e9}]{0,12}") {
        let mut text = std::fs::read_to_string(common::root().join("scenes/default.toml")).unwrap();
        let start = (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        let end = (start..=(start + length).min(text.len())).rev().find(|i| text.is_char_boundary(*i));
        text.replace_range(start..end.unwrap_or(start), &noise);
        match Scene::parse(&text, "damaged.toml", &[]) {
            Ok(_) => {}
            Err(Error::Scene(faults)) => prop_assert!(!faults.is_empty()),
            Err(other) => prop_assert!(false, "{}", other),
        }
    }
}

#[test]
fn groom_scale_scales_every_length_of_the_coat_once() {
    let text = "\"$schema\" = \"pelage.json\"\n[mesh]\nshape = \"sphere\"\n[guard]\ncurl = 0.3\ncurl_frequency = 1.5\n\
                length = { map = \"vertex_color\", value = 3, offset = 1 }\n[bake]\nheight = 2\n";
    let plain = Scene::parse(text, "a.toml", &[]).unwrap();
    let half = Scene::parse(text, "a.toml", &["groom.scale=0.5".into()]).unwrap();
    let Scalar::Mapped(map) = &half.guard.length else { panic!("{:?}", half.guard.length) };
    assert_eq!((map.value, map.offset), (1.5, 0.5));
    assert_eq!((half.guard.curl.max(), half.guard.curl_frequency), (0.15, 3.0));
    assert_eq!(half.guard.clump_density, 4.0 * plain.guard.clump_density);
    assert_eq!(half.undercoat.height.max(), 0.5 * plain.undercoat.height.max());
    assert_eq!(half.undercoat.noise_frequency, 2.0 * plain.undercoat.noise_frequency);
    assert_eq!((half.bake.height, half.bake.patch), (Some(1.0), None));
    assert_eq!(half.guard.diameter, plain.guard.diameter);
    assert_eq!(half.guard.density, plain.guard.density);
    // The resolved scene is not scaled again.
    let resolved = toml::to_string(&half).unwrap();
    assert!(!resolved.contains("[groom]") && !resolved.contains("$schema"), "{resolved}");
    assert_eq!(Scene::parse(&resolved, "b.toml", &[]).unwrap(), half);
    assert!(Scene::parse(text, "a.toml", &["groom.scale=0".into()]).is_err());
}
