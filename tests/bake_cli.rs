//! `pelage bake` on the command line: the files that it writes, and bad input.

use crate::common::{Folder, Run, json, names, pelage, pelage_without_adapter};
use serde_json::Value;

const SCENE: &str = "tests/data/small.toml";

/// Bakes few and small textures into `dir`.
fn bake(dir: &str, more: &[&str]) -> Run {
    let small = ["-D", "bake.fin_resolution=[32,16]", "--layers", "3", "--resolution", "16x12"];
    let args =
        ["bake", SCENE, "-o", dir, "--source", "dots"].into_iter().chain(small).chain(more.iter().copied());
    pelage(&args.collect::<Vec<_>>())
}

#[test]
fn baking_leaves_what_the_manifest_lists() {
    let folder = Folder::new();
    // The folder is created, with its parents.
    let dir = folder.at("new/fur");
    let run = bake(&dir, &["--seed", "5", "--patch", "0.5"]).expect(0, &[]);
    for part in
        ["3 layers of 16 x 12 texels, 0.5 x ", "with mips", "Lengyel et al. 2001", "layers_bc7.ktx2: PSNR"]
    {
        assert!(run.out.contains(part), "no {part:?} in {}", run.out);
    }
    let manifest = json(folder.path().join("new/fur/manifest.json"));
    assert_eq!(manifest["source"], "dots");
    assert_eq!(manifest["seed"], 5);
    assert_eq!(manifest["patch"][0], 0.5);
    for file in manifest["files"].as_array().unwrap() {
        let path = folder.path().join("new/fur").join(file["path"].as_str().unwrap());
        assert_eq!(std::fs::metadata(&path).unwrap().len(), file["bytes"].as_u64().unwrap());
    }
    let read = pelage_shells::bake::load(&folder.path().join("new/fur/manifest.json")).unwrap();
    assert_eq!((read.layers.len(), read.fin.width), (3, 32));
}

#[test]
fn the_papers_figure_is_printed_for_its_sizes() {
    let folder = Folder::new();
    let args = [
        "bake",
        SCENE,
        "-o",
        &folder.at("fur"),
        "--source",
        "dots",
        "--formats",
        "ktx2",
        "--resolution",
        "128x128",
    ];
    let out = pelage(&args).expect(0, &[]).out;
    let row = out.lines().find(|l| l.starts_with("layers and fin, RGBA8")).unwrap();
    assert!(row.contains("1,572,860") && row.contains("1.6 MB"), "{row}");
}

#[test]
fn formats_can_be_chosen() {
    let folder = Folder::new();
    let dir = folder.at("fur");
    bake(&dir, &["--formats", "ktx2", "--quiet"]).expect(0, &[]);
    assert_eq!(
        names(dir.as_ref()),
        ["fin.ktx2", "layers.ktx2", "lod1", "lod2", "manifest.json", "manifest.schema.json"]
    );
    let summary: Value =
        serde_json::from_str(&bake(&dir, &["--formats", "exr,png", "--json"]).expect(0, &[]).out).unwrap();
    assert_eq!(summary["layers"], 3);
    assert!(
        summary["files"].as_array().unwrap().iter().all(|f| !f["path"].as_str().unwrap().ends_with("ktx2"))
    );
}

#[test]
fn same_scene_and_seed_give_the_same_files() {
    let folder = Folder::new();
    let read = |name: &str, more: &[&str]| {
        bake(&folder.at(name), more).expect(0, &[]);
        ["layers.ktx2", "layer_001.exr", "fin.png"]
            .map(|f| std::fs::read(folder.path().join(name).join(f)).unwrap())
    };
    let one = read("a", &["--threads", "1"]);
    assert!(one == read("b", &["--threads", "2"]));
    assert!(one != read("c", &["--seed", "77"]));
}

#[test]
fn values_out_of_range_are_errors_before_anything_is_written() {
    let folder = Folder::new();
    let dir = folder.at("fur");
    for (args, code, parts) in [
        (&["--layers", "0"][..], 3, &["--layers 0", "1"][..]),
        (&["--layers", "129"], 3, &["--layers 129", "128"]),
        (&["--layers=-1"], 2, &["--layers"]),
        (&["--resolution", "2x16"], 3, &["--resolution", "4"]),
        (&["--resolution", "0x16"], 2, &["--resolution"]),
        (&["--resolution", "99999x16"], 3, &["--resolution", "4096"]),
        (&["--patch", "0"], 3, &["--patch 0"]),
        (&["--patch", "nan"], 3, &["--patch"]),
        (&["--source", "wool"], 2, &["wool", "particles"]),
        (&["--formats", "png,gif"], 2, &["gif", "ktx2"]),
        (&["--formats", ""], 2, &["--formats"]),
        (&["--alpha-test", "0"], 2, &["--alpha-test"]),
        (&["-D", "bake.layer=3"], 3, &["bake.layer", "layers"]),
    ] {
        let args: Vec<&str> = ["bake", SCENE, "-o", &dir].into_iter().chain(args.iter().copied()).collect();
        pelage(&args).expect(code, parts);
    }
    pelage(&["bake", SCENE]).expect(2, &["--outdir"]);
    pelage(&["bake", "nowhere.toml", "-o", &dir]).expect(3, &["nowhere.toml"]);
    assert!(folder.names().is_empty());
}

#[test]
fn folders_that_cannot_be_written_are_named() {
    let folder = Folder::new();
    let file = folder.write("taken", "not a folder");
    bake(&file, &[]).expect(1, &["taken", "is a file", "expected a folder"]);
    bake(&folder.at("taken/below"), &[]).expect(1, &["below", "cannot be made"]);
    assert_eq!(std::fs::read(&file).unwrap(), b"not a folder");
    // A folder with the name of a file to write.
    std::fs::create_dir_all(folder.path().join("fur/manifest.json")).unwrap();
    bake(&folder.at("fur"), &[]).expect(1, &["manifest.json", "is a folder"]);
    assert_eq!(folder.names(), ["fur", "taken"]);
    #[cfg(target_os = "linux")]
    bake("/proc/fur", &[]).expect(1, &["/proc/fur"]);
}

#[test]
fn a_bake_needs_no_adapter() {
    let folder = Folder::new();
    let small = ["--layers", "2", "--resolution", "16x16", "--formats", "exr"];
    let dir = folder.at("fur");
    let args = [&["bake", SCENE, "-o", &dir], &small[..]].concat();
    pelage_without_adapter(&args).expect(0, &[]);
}

/// Objects have no fur, so that nothing of them is baked; a note says what becomes of them.
#[test]
fn objects_are_noted() {
    let folder = Folder::new();
    let small = std::fs::read_to_string(SCENE).unwrap();
    let objects = "\n[[objects]]\nname = 'bell'\nmesh = { shape = 'sphere', scale = 0.1 }\n\
                   [[objects]]\nname = 'ground'\nmesh.shape = 'plane'\nshadow_catcher = true\n";
    let scene = folder.write("scene.toml", small + objects);
    let args = |dir: &str| {
        let all = ["bake", &scene, "-o", dir, "--source", "dots", "--layers", "2", "--resolution", "8x8"];
        let small = ["--formats", "ktx2", "-D", "bake.fin_resolution=[8,8]"];
        all.into_iter().chain(small).map(str::to_owned).collect::<Vec<_>>()
    };
    let run = pelage(&args(&folder.at("bare")))
        .expect(0, &["found 2 objects that are not baked: \"bell\", \"ground\""]);
    assert_eq!(run.err.matches("objects").count(), 1, "{}", run.err);
    let mut with = args(&folder.at("gltf"));
    with.push("--gltf".into());
    pelage(&with).expect(0, &["shadow catchers are left out of the glTF file", "\"ground\""]);
    let document = json(folder.path().join("gltf/fur.gltf"));
    assert_eq!(document["meshes"][1]["name"], "bell");
}
