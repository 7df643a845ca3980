//! Documents that are made from the program, and what `pelage presets` prints.

use crate::common::{pelage, root};
use pelage_core::scene::preset;
use serde_json::Value;

fn document(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[test]
fn the_reference_of_scenes_is_that_of_the_program() {
    let made = pelage(&["schema", "--markdown"]).expect(0, &[]).out;
    assert!(made.contains("| `fov` |"), "{made}");
    let kept = document("docs/scene.md");
    let differs = made.lines().zip(kept.lines()).find(|(made, kept)| made != kept);
    assert!(
        made == kept,
        "docs/scene.md is stale; run `pelage schema --markdown > docs/scene.md`: {differs:?}"
    );
}

#[test]
fn presets_are_listed_with_one_line_each() {
    let list = pelage(&["presets"]).expect(0, &[]).out;
    let lines: Vec<_> = list.lines().collect();
    assert_eq!(lines.len(), preset::names().count(), "{list}");
    for (name, line) in preset::names().zip(lines) {
        let (first, about) = line.split_once(' ').unwrap_or_else(|| panic!("{line}"));
        assert_eq!(first, name);
        assert_eq!(Some(about.trim_start()), preset::about(name));
        assert!(line.chars().count() <= 110 && about.contains(": "), "{line}");
    }
    let json: Value = serde_json::from_str(&pelage(&["presets", "--json"]).expect(0, &[]).out).unwrap();
    assert_eq!(json.as_array().map(Vec::len), Some(preset::names().count()));
    assert_eq!(json[0]["name"], "arctic_fox");
}

#[test]
fn a_preset_is_printed_as_its_file() {
    let text = pelage(&["presets", "wolf"]).expect(0, &[]).out;
    assert_eq!(text, document("presets/wolf.toml"));
    let json: Value =
        serde_json::from_str(&pelage(&["presets", "wolf", "--json"]).expect(0, &[]).out).unwrap();
    assert_eq!(json["values"]["guard"]["length"], 6.5);
    pelage(&["presets", "dodo"]).expect(2, &["no preset is called \"dodo\"", "red_fox"]);
}

/// The lines after the first, before the values: where the numbers are from.
#[test]
fn presets_name_the_source_of_their_numbers() {
    for name in preset::names() {
        let text = preset::text(name).unwrap();
        let source: String = text.lines().skip(1).take_while(|line| line.starts_with("# ")).collect();
        let cites = ["19", "20"].iter().any(|century| {
            source
                .match_indices(century)
                .any(|(at, _)| source[at..].chars().take_while(char::is_ascii_digit).count() == 4)
        });
        assert!(source.contains("by eye") || cites, "presets/{name}.toml: {source:?}");
    }
}

#[test]
fn every_preset_is_in_its_document() {
    let page = document("docs/presets.md");
    for name in preset::names() {
        let row = format!("| `{name}` | {} |", preset::about(name).unwrap());
        assert!(page.contains(&row), "docs/presets.md lacks {row}");
    }
}
