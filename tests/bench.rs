//! `pelage bench`: the rows of the paper's table, comparisons, JSON.

use crate::common::{self, Folder, pelage};
use pelage_studies::bench::Times;
use serde_json::Value;

const SCENE: &str = r#"
[mesh]
shape = "pyramid"
[camera]
eye = [0, 6, 30]
[[lights]]
[guard]
density = 4
[undercoat]
density = 2000
layers = 2
height = 1
"#;

fn bench(folder: &Folder, arguments: &[&str]) -> (String, Value) {
    let scene = folder.write("cylinder.toml", SCENE);
    let json = folder.at("bench.json");
    let mut all = vec!["bench", &scene, "--size", "48x32", "--json", &json];
    all.extend(arguments);
    let run = pelage(&all).expect(0, &[]);
    (run.out, common::json(json))
}

#[test]
fn rows_of_table_1() {
    let folder = Folder::new();
    let (out, json) = bench(&folder, &["--runs", "2", "--memory", "256MiB"]);
    for part in ["Process base mesh", "pre-processing", "online", "total, total memory", "3813.0"] {
        assert!(out.contains(part), "no {part:?} in\n{out}");
    }
    assert_eq!(json["runs"], 2);
    assert!(json["compile_ms"].as_f64().is_some_and(|ms| ms > 0.0));
    for key in ["adapter", "driver", "version", "date"] {
        assert!(json["provenance"][key].as_str().is_some_and(|s| !s.is_empty()), "{key}");
    }
    let column = &json["table"][0];
    assert_eq!(column["scene"], "cylinder");
    assert_eq!(column["stats"]["memory_budget_bytes"], 256 << 20);
    assert_eq!((&column["stats"]["width"], &column["stats"]["spp"]), (&48.into(), &1.into()));
    assert_eq!(column["paper"]["online_ms"], 1407.0);
    let rows = column["rows"].as_array().expect("rows");
    assert_eq!(rows.iter().map(|r| r["step"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7]);
    let bytes: u64 = rows.iter().map(|r| r["bytes"].as_u64().unwrap()).sum();
    assert_eq!(column["total_bytes"], bytes);
    let time = |value: &Value, key: &str| value[key].as_f64();
    if let Some(total) = time(&column["total_ms"], "min") {
        let steps: f64 = rows.iter().map(|r| time(&r["ms"], "min").expect("every step has a time")).sum();
        assert!(steps <= total * 1.000_001 && total <= time(&column["wall_ms"], "min").unwrap(), "{column}");
    }
    assert!(column["peak_bytes"].as_u64().unwrap() <= 256 << 20);
}

#[test]
fn comparisons_of_one_scene() {
    let folder = Folder::new();
    let (out, json) = bench(&folder, &["--sweep", "blend", "--sweep", "strands"]);
    assert!(out.contains("virtual, 30") && out.contains("16 x"), "{out}");
    let rows = |i: usize| json["sweeps"][i]["rows"].as_array().expect("rows").clone();
    let fragments = |row: &Value| row["stats"]["fragments"].as_u64().unwrap();
    let blends = rows(0);
    assert_eq!(blends.len(), 3);
    assert!(fragments(&blends[1]) > fragments(&blends[0]), "virtual fragments are fragments: {out}");
    let strands: Vec<u64> = rows(1).iter().map(|row| row["stats"]["strands"].as_u64().unwrap()).collect();
    assert!((strands[4] as f64 / strands[0] as f64 - 16.0).abs() < 1.0, "{strands:?}");
}

#[test]
fn frames_per_second_of_shells_and_fins() {
    let folder = Folder::new();
    let fur = "[bake]\nsource = \"particles\"\nlayers = 4\nheight = 0.5\nresolution = [16, 16]\nfin_resolution = [32, 8]\n";
    let scene = folder.write("fur.toml", format!("{SCENE}{fur}"));
    let json = folder.at("fur.json");
    let run = pelage(&[
        "bench", "--shells", &scene, "--size", "48x32", "--runs", "2", "--layers", "3", "--json", &json,
    ])
    .expect(0, &[]);
    for part in ["all layers, and half of them", "growth with layers", "12 fps", "23 fps"] {
        assert!(run.out.contains(part), "no {part:?} in\n{}", run.out);
    }
    let report = common::json(&json);
    assert_eq!((&report["runs"], &report["size"]), (&2.into(), &serde_json::json!([48, 32])));
    let rows: Vec<&Value> = ["frames", "layers"].iter().flat_map(|k| report[k].as_array().unwrap()).collect();
    assert_eq!(rows.iter().map(|r| r["shells"].as_u64().unwrap()).collect::<Vec<_>>(), [4, 2, 3]);
    for row in rows {
        let time = |key: &str| row[key]["median"].as_f64();
        let (frame, fps) = (time("frame_ms").unwrap(), time("fps").unwrap());
        assert!(frame > 0.0 && (fps * frame / 1e3 - 1.0).abs() < 1e-9, "{row}");
        assert!(row["fps"]["best"].as_f64().unwrap() >= fps && row["edges"].as_u64().unwrap() > 0, "{row}");
        // All fur is as high, however many layers it has.
        assert!((row["height"].as_f64().unwrap() - 0.5).abs() < 1e-6, "{row}");
        for part in ["rows_ms", "skin_ms", "fins_ms", "shells_ms"] {
            assert!(time(part).is_none_or(|ms| ms > 0.0 && ms < frame), "{part}: {row}");
        }
    }
    pelage(&["bench", &scene, "--layers", "3"]).expect(2, &["--shells"]);
    pelage(&["bench", "--shells", &scene, "--layers", "0"]).expect(2, &["--layers"]);
}

#[test]
fn a_scene_without_its_mesh_is_skipped() {
    let folder = Folder::new();
    let scene = folder.write("absent.toml", "[mesh]\npath = \"absent.obj\"\n");
    let json = folder.at("bench.json");
    let run = pelage(&["bench", &scene, "--size", "8x8", "--json", &json]).expect(0, &[]);
    assert!(run.out.contains("skipped") && run.out.contains("fetch_assets"), "{}", run.out);
    let report = common::json(&json);
    assert_eq!(report["skipped"][0]["scene"], "absent");
    assert_eq!(report["table"].as_array().map(Vec::len), Some(0));
    // A broken scene is not skipped.
    let scene = folder.write("broken.toml", "[mesh]\nshape = \"bread\"\n");
    pelage(&["bench", &scene, "--size", "8x8"]).expect(3, &["bread"]);
    pelage(&["bench", &folder.at("none.toml")]).expect(2, &["no such scene"]);
}

#[test]
fn times_of_runs() {
    let of = |runs: &[f64]| Times::of(runs.iter().map(|ms| Some(*ms))).unwrap();
    assert_eq!(of(&[3.0]), Times { min: 3.0, median: 3.0 });
    assert_eq!(of(&[5.0, 1.0, 2.0]), Times { min: 1.0, median: 2.0 });
    assert_eq!(of(&[4.0, 1.0, 2.0, 9.0]), Times { min: 1.0, median: 3.0 });
    assert_eq!(Times::of([Some(1.0), None].into_iter()), None);
    assert_eq!(Times::of(std::iter::empty()), None);
}
