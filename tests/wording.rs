//! Conventions for comments and documents: citations, deviations, vocabulary, width. Each rule is a
//! function from texts to complaints, so that it is also tested on texts that break it.

use crate::common::sources::{Source, assert_none, sources};
use std::collections::BTreeSet;

// Citations.

/// Keys in brackets of a comment: a capital, then letters, digits, hyphens; at least four of them.
fn citations(comment: &str) -> Vec<&str> {
    let is_key = |key: &&str| {
        key.len() >= 4
            && key.starts_with(|c: char| c.is_ascii_uppercase())
            && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
    };
    comment.split('[').skip(1).filter_map(|rest| Some(rest.split_once(']')?.0)).filter(is_key).collect()
}

/// The keys of the last section of ARCHITECTURE.md: `- [Key] ...`.
fn references(architecture: &str) -> BTreeSet<&str> {
    let (_, section) = architecture.rsplit_once("\n## ").unwrap_or_default();
    assert!(section.starts_with("References"), "the last section of ARCHITECTURE.md is called References");
    section.lines().filter_map(|l| Some(l.strip_prefix("- [")?.split_once(']')?.0)).collect()
}

fn citation_complaints(sources: &[Source], keys: &BTreeSet<&str>) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut used = BTreeSet::new();
    for s in sources.iter().filter(|s| !s.path.ends_with(".md") && s.path != "tests/wording.rs") {
        for (line, comment) in s.comments() {
            for key in citations(comment) {
                used.insert(key);
                if !keys.contains(key) {
                    complaints.push(format!("{}:{line}: [{key}] is not in the References", s.path));
                }
            }
        }
    }
    let unused = keys.iter().filter(|key| !used.contains(**key));
    complaints.extend(unused.map(|key| format!("ARCHITECTURE.md: nothing cites [{key}]")));
    complaints
}

#[test]
fn citations_are_known() {
    let sources = sources();
    let architecture = sources.iter().find(|s| s.path == "ARCHITECTURE.md").unwrap();
    assert_none(citation_complaints(&sources, &references(&architecture.text)));
}

#[test]
fn unknown_and_unused_citations_are_detected() {
    let keys = references("# A\n\n## References\n\n- [Known2000] A book.\n");
    let complaints = |text| citation_complaints(&[Source::new("src/a.rs", text)], &keys);
    assert!(complaints("// [Known2000] eq. 3\nlet a = b[C2];").is_empty());
    assert_eq!(complaints("// [Known2000], [Unknown1999]").len(), 1);
    assert_eq!(complaints("// [`Error`] and [f32] and [Kd]").len(), 1, "only the unused one");
}

/// A deviation has a description and a reason.
fn deviation_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for s in sources.iter().filter(|s| !s.path.ends_with(".md") && s.path != "tests/wording.rs") {
        let lines: Vec<&str> = s.text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            if let Some((_, reason)) = line.split_once("DEVIATION") {
                let next = lines.get(i + 1).map(|l| l.trim_start()).filter(|l| l.starts_with("//"));
                let reason = format!("{reason}{}", next.unwrap_or_default());
                if !reason.starts_with(": ") || reason.split_whitespace().count() < 6 {
                    complaints.push(format!("{}:{}: expected `DEVIATION: ` and a reason", s.path, i + 1));
                }
            }
        }
    }
    complaints
}

#[test]
fn deviations_have_reasons() {
    assert_none(deviation_complaints(&sources()));
    let complaints = |text| deviation_complaints(&[Source::new("src/a.rs", text)]).len();
    assert_eq!(complaints("// DEVIATION: the paper draws quads,\n// which have seams."), 0);
    assert_eq!(complaints("// DEVIATION: faster"), 1);
    assert_eq!(complaints("// A DEVIATION because of all kinds of reasons that count"), 1);
}

// Vocabulary.

/// Phrases that are not used, and what stands in their place; ARCHITECTURE.md has the glossary. A
/// phrase with capitals is matched as it is written, any other in lower case.
const WORDS: [(&str, &str); 18] = [
    ("square to itself", "projected"),
    ("as seen square", "projected"),
    ("seen square", "projected"),
    ("light lattice", "optical-depth lattice"),
    ("the way through", "path length"),
    ("told of", "reported"),
    ("is told", "is reported"),
    ("refuse in words", "fail with a readable error"),
    ("refuses in words", "fails with a readable error"),
    ("refused in words", "fails with a readable error"),
    ("makers of textures", "sources of textures"),
    ("as ever", "as usual"),
    ("Scenery", "MarchInputs"),
    ("Whims", "HairVariation"),
    ("Departure", "RayOrigin"),
    ("Standing", "Orientation"),
    ("Station", "HeightLevel"),
    ("FigureStage", "FigureContext"),
];

/// The words of a text with the numbers of their lines. Comment marks and punctuation are left out,
/// so that a phrase is found across a line break.
fn words(text: &str) -> Vec<(usize, &str)> {
    let of_line = |(i, line)| {
        let parts = str::split(line, |c: char| !c.is_alphanumeric() && c != '_');
        parts.filter(|word| !word.is_empty()).map(move |word| (i + 1, word))
    };
    text.lines().enumerate().flat_map(of_line).collect()
}

/// A document without its section called Glossary, line by line.
fn without_glossary(text: &str) -> String {
    let mut inside = false;
    let keep = |line: &str| {
        if line.starts_with("## ") {
            inside = line == "## Glossary";
        }
        if inside { "\n".to_owned() } else { format!("{line}\n") }
    };
    text.lines().map(keep).collect()
}

fn vocabulary_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    let texts = [".rs", ".wgsl", ".md", ".toml", ".sh", ".py"];
    for s in sources.iter().filter(|s| texts.iter().any(|end| s.path.ends_with(end))) {
        // The reference of scenes is made from comments, which are checked where they stand.
        if s.path == "tests/wording.rs" || s.path == "docs/scene.md" {
            continue;
        }
        let text = if s.path == "ARCHITECTURE.md" { without_glossary(&s.text) } else { s.text.clone() };
        let exact = words(&text);
        let lower: Vec<String> = exact.iter().map(|(_, word)| word.to_lowercase()).collect();
        for (phrase, instead) in WORDS {
            let wanted: Vec<&str> = phrase.split(' ').collect();
            let cased = phrase.contains(char::is_uppercase);
            for (i, (line, _)) in exact.iter().enumerate() {
                let fits =
                    |k: usize, word: &&str| {
                        exact.get(i + k).is_some_and(|(_, found)| {
                            if cased { found == word } else { lower[i + k] == **word }
                        })
                    };
                if wanted.iter().enumerate().all(|(k, word)| fits(k, word)) {
                    complaints.push(format!("{}:{line}: \"{phrase}\", expected \"{instead}\"", s.path));
                }
            }
        }
    }
    complaints
}

#[test]
fn the_vocabulary_is_that_of_the_glossary() {
    assert_none(vocabulary_complaints(&sources()));
}

#[test]
fn words_outside_the_glossary_are_detected() {
    let complaints = |path: &str, text: &str| vocabulary_complaints(&[Source::new(path, text)]).len();
    for (phrase, _) in WORDS {
        let sentence = format!("// It has the {phrase}, and more.");
        assert!(complaints("src/a.rs", &sentence) > 0, "{phrase}");
        // Across a line break, and not within another word.
        let wrapped = format!("    /// {}\n", phrase.replace(' ', "\n    /// "));
        assert!(complaints("shaders/a.wgsl", &wrapped) > 0, "{phrase}");
        assert_eq!(complaints("README.md", &format!("un{phrase}ly")), 0, "{phrase}");
    }
    assert_eq!(complaints("src/a.rs", "// The Light Lattice."), 1);
    assert_eq!(complaints("src/a.rs", "// Hairs standing upright; a station."), 0);
    assert_eq!(complaints("src/a.svg", "light lattice"), 0);
    let document = "# A\n\n## Glossary\n\n| lattice | not: light lattice |\n\n## Light\n\n";
    assert_eq!(complaints("ARCHITECTURE.md", document), 0);
    assert_eq!(complaints("ARCHITECTURE.md", &format!("{document}The light lattice.\n")), 1);
    assert_eq!(complaints("README.md", document), 1);
}

/// Most columns of a comment line.
const COLUMNS: usize = 100;

/// Lines that hold nothing but a comment are at most [`COLUMNS`] wide, except URLs and tables.
fn width_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for s in sources.iter().filter(|s| [".rs", ".wgsl"].iter().any(|end| s.path.ends_with(end))) {
        for (i, line) in s.text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let is_table = comment.trim_start_matches(['/', '!']).trim_start().starts_with('|');
            let columns = line.chars().count();
            if columns > COLUMNS && !is_table && !comment.contains("://") {
                complaints.push(format!("{}:{}: {columns} columns, more than {COLUMNS}", s.path, i + 1));
            }
        }
    }
    complaints
}

#[test]
fn comments_are_wrapped() {
    assert_none(width_complaints(&sources()));
}

#[test]
fn wide_comments_are_detected() {
    let complaints = |path: &str, text: &str| width_complaints(&[Source::new(path, text)]).len();
    let long = "x".repeat(COLUMNS);
    for mark in ["//", "///", "//!", "    //"] {
        assert_eq!(complaints("src/a.rs", &format!("{mark} {long}")), 1, "{mark}");
        assert_eq!(complaints("shaders/a.wgsl", &format!("{mark} {long}")), 1, "{mark}");
        assert_eq!(complaints("src/a.rs", &format!("{mark} {}", "µ".repeat(COLUMNS - mark.len() - 1))), 0);
        assert_eq!(complaints("src/a.rs", &format!("{mark} https://{long}")), 0, "{mark}");
        assert_eq!(complaints("src/a.rs", &format!("{mark} | {long} |")), 0, "{mark}");
    }
    assert_eq!(complaints("src/a.rs", &format!("let a = \"// {long}\";")), 0);
    assert_eq!(complaints("README.md", &format!("// {long}")), 0);
}
