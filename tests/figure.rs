//! `pelage figure`: the folders of paper_figures/, and one figure from end to end.

use crate::common::{self, Folder, Run, command, json, names, pelage, root};
use pelage_core::Scene;
use pelage_core::film::io;
use pelage_studies::figure::Figure;

#[test]
fn every_figure_has_valid_scenes_and_a_caption() {
    let names = Figure::names().expect("paper_figures/");
    for wanted in ["fig1", "fig8", "fig9", "fig11", "table1"] {
        assert!(names.iter().any(|n| *n == format!("andersen2016-{wanted}")), "{wanted} is not in {names:?}");
    }
    for name in names {
        let (figure, folder) = Figure::find(&name).expect("a valid figure.toml");
        let caption = std::fs::read_to_string(folder.join("caption.md")).expect("a caption");
        for part in [&format!("pelage figure {name}"), "Known differences", "# "] {
            assert!(caption.contains(part), "{name}: no {part:?} in its caption");
        }
        for panel in &figure.panels {
            let Some(scene) = &panel.scene else { continue };
            for set in [panel.set.clone(), [figure.quick.set.clone(), panel.set.clone()].concat()] {
                match Scene::load(&folder.join(scene), &set) {
                    Ok(_) => {}
                    // The bunny and its garden are downloaded.
                    Err(e) => assert!(e.to_string().contains("fetch_assets"), "{name}: {e}"),
                }
            }
        }
        let golden = folder.join("golden/golden.json");
        assert!(golden.is_file(), "{name}: nothing is kept: pelage figure {name} --quick --bless");
    }
}

#[test]
fn names_and_their_endings() {
    assert_eq!(Figure::find("fig8").expect("unique").1, Figure::find("andersen2016-fig8").expect("exact").1);
    pelage(&["figure", "fig"]).expect(2, &["andersen2016-fig1,"]);
    let list = pelage(&["figure", "--list"]).expect(0, &[]).out;
    assert!(list.lines().count() >= 5 && list.contains("andersen2016-table1"), "{list}");
}

#[test]
fn a_missing_asset_is_reported_with_a_hint() {
    let folder = Folder::new();
    if root().join("assets/meshes/stanford-bunny.obj").exists() {
        eprintln!("note: skipped, assets/ holds the bunny");
        return;
    }
    pelage(&["figure", "fig11", "--quick", "-o", &folder.at("out")]).expect(3, &["fetch_assets.sh", "bunny"]);
}

/// A folder paper_figures/ with one small figure, so that the test is fast.
#[test]
fn a_figure_from_end_to_end() {
    let folder = Folder::new();
    let place = folder.path().join("paper_figures/small");
    std::fs::create_dir_all(&place).unwrap();
    let panel = |label: &str, fur: &str| {
        format!("[[panels]]\nlabel = {label:?}\nscene = \"scene.toml\"\nset = [\"render.fur={fur}\"]\n")
    };
    std::fs::write(place.join("caption.md"), "# Small\n\nTwo *pictures*.\n").unwrap();
    let head = "title = \"Small\"\nsource = \"nobody\"\ncolumns = 2\nsize = [288, 180]\nspp = 4\nquick.size = [48, 30]\nquick.spp = 1\n";
    std::fs::write(
        place.join("figure.toml"),
        head.to_owned() + &panel("guard hairs", "explicit") + &panel("skin", "base"),
    )
    .unwrap();
    let scene = "[mesh]\nshape = \"pyramid\"\n[camera]\neye = [0, 6, 30]\n[[lights]]\n[guard]\ndensity = 4\n";
    std::fs::write(place.join("scene.toml"), scene).unwrap();
    make(&folder, &["small", "--quick"]).expect(0, &[]);
    let out = place.join("result");
    assert_eq!(
        names(&out),
        ["a_guard_hairs.exr", "a_guard_hairs.png", "b_skin.exr", "b_skin.png", "figure.json", "small.png"]
    );
    let record = json(out.join("figure.json"));
    assert_eq!(record["pictures"][0]["stats"]["fur"], "explicit");
    assert_eq!(record["pictures"][1]["layers"], "b_skin.exr");
    assert!(record["provenance"]["adapter"].as_str().is_some_and(|s| !s.is_empty()));
    let panel = io::read(out.join("a_guard_hairs.exr")).unwrap();
    assert_eq!((panel.width, panel.height), (48, 30));
    assert!(panel.plane("guard.R").unwrap().iter().any(|v| *v > 0.0), "guard hairs are seen");
    let sheet = io::read(out.join("small.png")).unwrap();
    assert!(sheet.width > 96 && sheet.height > 30);
    let broken = place.join("figure.toml");
    std::fs::write(&broken, "title = \"x\"\nsource = \"y\"\npanel = 3\n").unwrap();
    make(&folder, &["small"]).expect(3, &["figure.toml:3"]);
}

/// A folder paper_figures/ with one figure of the given panels, each a TOML table without its head.
fn registry(folder: &Folder, panels: &[&str]) -> std::path::PathBuf {
    let place = folder.path().join("paper_figures/x-small");
    std::fs::create_dir_all(&place).unwrap();
    let panels: String = panels.iter().map(|panel| format!("[[panels]]\n{panel}\n")).collect();
    let head = "title = \"Small\"\nsource = \"nobody\"\ncolumns = 2\nquick.size = [48, 30]\nquick.spp = 1\n";
    std::fs::write(place.join("figure.toml"), head.to_owned() + &panels).unwrap();
    std::fs::write(place.join("caption.md"), "# Small\n\nTwo pictures.\n").unwrap();
    let scene = "[mesh]\nshape = \"pyramid\"\n[camera]\neye = [0, 6, 30]\n[[lights]]\n[guard]\ndensity = 4\n";
    std::fs::write(place.join("scene.toml"), scene).unwrap();
    place
}

fn make(folder: &Folder, arguments: &[&str]) -> Run {
    common::run(command().current_dir(folder.path()).arg("figure").args(arguments))
}

#[test]
fn differences_from_the_kept_results_are_reported() {
    let folder = Folder::new();
    let place = registry(&folder, &["label = \"hairs\"\nscene = \"scene.toml\""]);
    make(&folder, &["x-small", "--quick", "--check"]).expect(1, &["nothing is kept"]);
    make(&folder, &["x-small", "--quick", "--bless"]).expect(0, &[]);
    let page = std::fs::read_to_string(folder.path().join("paper_figures/README.md")).unwrap();
    assert!(page.contains("x-small/golden/x-small.png"), "{page}");
    make(&folder, &["--all", "--quick", "--check"]).expect(0, &[]);
    let scene = std::fs::read_to_string(place.join("scene.toml")).unwrap();
    std::fs::write(place.join("scene.toml"), scene.replace("density = 4", "density = 12")).unwrap();
    make(&folder, &["--all", "--quick", "--check"]).expect(1, &["x-small: the picture differs"]);
}

#[test]
fn a_missing_photograph_has_a_placeholder() {
    let folder = Folder::new();
    let image = "label = \"photograph\"\nimage = \"photos/no-such.png\"";
    let place = registry(&folder, &[image, "label = \"hairs\"\nscene = \"scene.toml\""]);
    let run = make(&folder, &["x-small", "--quick", "--bless"]).expect(0, &[]);
    assert!(run.out.contains("photos/no-such.png not found"), "{}", run.out);
    assert!(!place.join("golden").exists(), "a placeholder is not kept");
    let slot = io::read(place.join("result/a_photograph.png")).unwrap();
    assert_eq!((slot.width, slot.height), (48, 30));
}
