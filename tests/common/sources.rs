//! The texts of the repository, for the rules on them.

use super::root;
use std::path::Path;

/// A text file of the repository.
pub struct Source {
    /// Path from the root, with `/`.
    pub path: String,
    /// Content.
    pub text: String,
}

impl Source {
    /// A text, for tests of a rule.
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.into(), text: text.into() }
    }

    /// Part of the library or the command, not of its tests.
    pub fn is_library(&self) -> bool {
        self.is("src/", ".rs") || self.is("crates/", ".rs")
    }

    /// Whether the path begins with `folder` and ends with `extension`.
    pub fn is(&self, folder: &str, extension: &str) -> bool {
        self.path.starts_with(folder) && self.path.ends_with(extension)
    }

    /// `line number, comment` for each line that has one.
    pub fn comments(&self) -> impl Iterator<Item = (usize, &str)> {
        let mark = if self.path.ends_with(".rs") || self.path.ends_with(".wgsl") { "//" } else { "#" };
        self.text.lines().enumerate().filter_map(move |(i, line)| Some((i + 1, line.split_once(mark)?.1)))
    }
}

/// All texts that people write, sorted by path.
pub fn sources() -> Vec<Source> {
    fn walk(folder: &Path, found: &mut Vec<Source>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                // Results of figures are generated.
                if !["result", "golden"].iter().any(|generated| path.ends_with(generated)) {
                    walk(&path, found);
                }
            } else if path.ends_with("paper_figures/index.html") {
                // So is the report.
            } else if let Ok(text) = std::fs::read_to_string(&path) {
                let path = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
                found.push(Source { path, text });
            }
        }
    }
    let mut found = Vec::new();
    for folder in
        ["src", "crates", "shaders", "tests", "scripts", "scenes", "presets", "paper_figures", ".ci", "docs"]
    {
        walk(&root().join(folder), &mut found);
    }
    for file in
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "assets/README.md", "Cargo.toml"]
    {
        let text = std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        found.push(Source { path: file.into(), text });
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// Fails with all complaints of a rule.
#[track_caller]
pub fn assert_none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "{} complaints:\n{}", complaints.len(), complaints.join("\n"));
}
