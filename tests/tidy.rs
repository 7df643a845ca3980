//! Habits that a compiler does not check: names, tags, sizes, leftovers. Each rule is a function
//! from texts to complaints, so that it is also tried on texts that break it.

use crate::common::root;
use pelage_render::shaders;
use std::collections::BTreeSet;
use std::path::Path;

/// A file of the repository: its path from the root, with `/`, and its text.
struct Source {
    path: String,
    text: String,
}

impl Source {
    fn new(path: &str, text: &str) -> Self {
        Self { path: path.into(), text: text.into() }
    }

    /// Part of the library or the command, not of its tests.
    fn is_library(&self) -> bool {
        self.is("src/", ".rs") || self.is("crates/", ".rs")
    }

    fn is(&self, folder: &str, extension: &str) -> bool {
        self.path.starts_with(folder) && self.path.ends_with(extension)
    }

    /// `line number, comment` for each line that has one.
    fn comments(&self) -> impl Iterator<Item = (usize, &str)> {
        let mark = if self.path.ends_with(".rs") || self.path.ends_with(".wgsl") { "//" } else { "#" };
        self.text.lines().enumerate().filter_map(move |(i, line)| Some((i + 1, line.split_once(mark)?.1)))
    }
}

/// All texts that people write, sorted by path.
fn sources() -> Vec<Source> {
    fn walk(folder: &Path, found: &mut Vec<Source>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                // What figures came out as was written by no one.
                if !["result", "golden"].iter().any(|made| path.ends_with(made)) {
                    walk(&path, found);
                }
            } else if path.ends_with("paper_figures/index.html") {
                // So was the report.
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

/// A rule whose folder has moved finds no file, and so nothing wrong.
#[test]
fn rules_find_their_files() {
    let sources = sources();
    for (folder, extension, least) in [
        ("src/", ".rs", 15),
        ("crates/", ".rs", 150),
        ("crates/pelage-render/src/passes/", ".rs", 18),
        ("crates/pelage-render/src/twin/", ".rs", 14),
        ("shaders/", ".wgsl", 40),
        ("shaders/shared/", ".wgsl", 10),
        ("tests/", ".rs", 60),
    ] {
        let found = sources.iter().filter(|s| s.is(folder, extension)).count();
        assert!(found >= least, "{found} files {folder}*{extension}, expected {least} or more");
    }
}

fn assert_none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "{} complaints:\n{}", complaints.len(), complaints.join("\n"));
}

// One stem names the shader, its record in Rust, its CPU twin and its test.

/// What a stem lacks or has elsewhere, and why.
const EXCEPTIONS: [(&str, &str, &str); 1] =
    [("film", "tests/film_pass.rs", "tests/film.rs is the test of the module film, which writes images")];

fn stem_complaints(paths: &BTreeSet<&str>, exceptions: &[(&str, &str, &str)]) -> Vec<String> {
    let mut complaints = Vec::new();
    for stem in paths.iter().filter_map(|p| p.strip_prefix("shaders/")?.strip_suffix(".wgsl")) {
        if stem.contains('/') {
            continue;
        }
        // The fur's own mathematics stands in pelage-fur, whoever else needs it.
        let rooms = ["crates/pelage-render/src", "crates/pelage-shells/src"];
        let pass = rooms.map(|room| format!("{room}/passes/{stem}.rs"));
        let twin: Vec<String> = rooms
            .iter()
            .map(|room| format!("{room}/twin/{stem}.rs"))
            .chain([format!("crates/pelage-fur/src/{stem}.rs")])
            .collect();
        let test = exceptions.iter().find(|(s, _, _)| *s == stem);
        let test = [test.map_or_else(|| format!("tests/{stem}.rs"), |(_, path, _)| (*path).to_owned())];
        for wanted in [&pass[..], &twin[..], &test[..]] {
            if !wanted.iter().any(|path| paths.contains(path.as_str())) {
                complaints.push(format!("shaders/{stem}.wgsl has no {}", wanted.join(" or ")));
            }
        }
    }
    for path in paths {
        let pass = path.split_once("/src/passes/").and_then(|(_, file)| file.strip_suffix(".rs"));
        if pass.is_some_and(|pass| !paths.contains(format!("shaders/{pass}.wgsl").as_str())) {
            complaints.push(format!("{path} has no shader of its name"));
        }
    }
    complaints
}

#[test]
fn a_stem_names_shader_pass_twin_and_test() {
    let sources = sources();
    assert_none(stem_complaints(&sources.iter().map(|s| s.path.as_str()).collect(), &EXCEPTIONS));
}

#[test]
fn missing_files_of_a_stem_are_found() {
    let paths = BTreeSet::from([
        "shaders/a.wgsl",
        "crates/pelage-render/src/passes/a.rs",
        "crates/pelage-render/src/twin/a.rs",
        "tests/a.rs",
    ]);
    assert!(stem_complaints(&paths, &[]).is_empty());
    for path in &paths {
        let mut fewer = paths.clone();
        fewer.remove(path);
        assert_eq!(stem_complaints(&fewer, &[]).len(), 1, "without {path}");
    }
    assert_eq!(stem_complaints(&paths, &[("a", "tests/b.rs", "why")]).len(), 1);
}

#[test]
fn every_shader_is_compiled_into_the_program() {
    let listed: BTreeSet<String> =
        shaders::names().iter().map(|name| format!("shaders/{name}.wgsl")).collect();
    let there: BTreeSet<String> =
        sources().iter().filter(|s| s.is("shaders/", ".wgsl")).map(|s| s.path.clone()).collect();
    assert_eq!(listed, there);
    let texts: Vec<_> = shaders::names().iter().filter_map(|name| shaders::text(name)).collect();
    let imported: BTreeSet<String> = texts
        .iter()
        .flat_map(|text| text.lines().filter_map(|l| l.strip_prefix("#import ")))
        .map(|name| format!("shaders/{}.wgsl", name.trim()))
        .collect();
    let unused: Vec<_> = there.iter().filter(|p| p.contains("/shared/") && !imported.contains(*p)).collect();
    assert!(unused.is_empty(), "shared shaders that nothing imports: {unused:?}");
}

/// Functions are shared, bindings are not, but for the frame that everything sees.
#[test]
fn shared_shaders_declare_no_bindings_and_no_entry_points() {
    let mut complaints = Vec::new();
    for s in sources().iter().filter(|s| s.is("shaders/shared/", ".wgsl")) {
        for word in ["@group", "@binding", "@compute", "@vertex", "@fragment"] {
            if s.text.contains(word) && !(s.path.ends_with("/frame.wgsl") && word.ends_with(['p', 'g'])) {
                complaints.push(format!("{} has a {word}", s.path));
            }
        }
    }
    assert_none(complaints);
}

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

/// The keys that the last section of ARCHITECTURE.md explains: `- [Key] ...`.
fn references(architecture: &str) -> BTreeSet<&str> {
    let (_, section) = architecture.rsplit_once("\n## ").unwrap_or_default();
    assert!(section.starts_with("References"), "the last section of ARCHITECTURE.md is called References");
    section.lines().filter_map(|l| Some(l.strip_prefix("- [")?.split_once(']')?.0)).collect()
}

fn citation_complaints(sources: &[Source], keys: &BTreeSet<&str>) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut used = BTreeSet::new();
    for s in sources.iter().filter(|s| !s.path.ends_with(".md") && s.path != "tests/tidy.rs") {
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
fn unknown_and_unused_citations_are_found() {
    let keys = references("# A\n\n## References\n\n- [Known2000] A book.\n");
    let complaints = |text| citation_complaints(&[Source::new("src/a.rs", text)], &keys);
    assert!(complaints("// [Known2000] eq. 3\nlet a = b[C2];").is_empty());
    assert_eq!(complaints("// [Known2000], [Unknown1999]").len(), 1);
    assert_eq!(complaints("// [`Error`] and [f32] and [Kd]").len(), 1, "only the unused one");
}

/// A deviation says what from, or why.
fn deviation_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for s in sources.iter().filter(|s| !s.path.ends_with(".md") && s.path != "tests/tidy.rs") {
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

// Leftovers.

fn leftover_complaints(sources: &[Source]) -> Vec<String> {
    // Written in parts, so that this file does not hold them.
    let words: Vec<String> = [
        ("FIX", "ME"),
        ("XX", "X"),
        ("TO", "DO"),
        ("todo", "!"),
        ("unimpl", "emented!"),
        ("dbg", "!("),
        ("#[ig", "nore"),
    ]
    .iter()
    .map(|(a, b)| format!("{a}{b}"))
    .collect();
    let places: Vec<String> = [
        ("/ho", "me/"),
        ("/ro", "ot/"),
        ("/wo", "rk/"),
        ("/Us", "ers/"),
        ("C:\\", "Users"),
        ("/tm", "p/"),
        ("../sh", "ared"),
    ]
    .iter()
    .map(|(a, b)| format!("{a}{b}"))
    .collect();
    let mut complaints = Vec::new();
    for s in sources {
        for (i, line) in s.text.lines().enumerate() {
            let mut find = |list: &[String], what: &str| {
                // mktemp's template is no mark.
                let line = line.replace("XXXXXX", "");
                if let Some(word) = list.iter().find(|w| line.contains(w.as_str())) {
                    complaints.push(format!("{}:{}: {what} {word}", s.path, i + 1));
                }
            };
            find(&words, "a leftover:");
            // The integration run alone knows where its assets lie.
            if s.path != ".ci/run" {
                find(&places, "a place on one machine:");
            }
        }
    }
    complaints
}

#[test]
fn nothing_is_left_over() {
    assert_none(leftover_complaints(&sources()));
    let complaints = |text: String| leftover_complaints(&[Source::new("a.rs", &text)]).len();
    assert_eq!(complaints("todo: nothing, and home/sweet".into()), 0);
    assert_eq!(complaints(format!("// {}{}", "FIX", "ME later\n")), 1);
    assert_eq!(complaints(format!("let a = \"{}{}\";", "/ho", "me/me/a.obj")), 1);
}

/// Library code returns errors; only its unit tests, at the end of a file, may panic.
fn panic_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for s in sources.iter().filter(|s| s.is_library()) {
        let code = s.text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        for (i, line) in code.lines().enumerate().filter(|(_, l)| !l.trim_start().starts_with("//")) {
            for call in [".unwrap()", ".expect(", "panic!(", "unreachable!(", "unsafe "] {
                if line.contains(call) {
                    complaints.push(format!("{}:{}: {call}", s.path, i + 1));
                }
            }
            // Files appear whole or not at all: `files` writes them.
            for call in ["fs::write(", "File::create(", "fs::File::create_new("] {
                if line.contains(call) && !s.path.ends_with("/files.rs") {
                    complaints.push(format!("{}:{}: {call}, expected a function of files", s.path, i + 1));
                }
            }
        }
    }
    complaints
}

#[test]
fn the_library_neither_panics_nor_writes_torn_files() {
    assert_none(panic_complaints(&sources()));
    let complaints = |text| panic_complaints(&[Source::new("src/a.rs", text)]).len();
    assert_eq!(
        complaints("a.unwrap_or(b);\n// .unwrap()\n#[cfg(test)]\nmod tests {\n    a.unwrap();\n}\n"),
        0
    );
    assert_eq!(complaints("a.unwrap();\nstd::fs::write(a, b);\n"), 2);
}

#[test]
fn files_are_short() {
    const MOST: usize = 600;
    // Prose and meshes are as long as they are.
    let long = sources().into_iter().filter(|s| ![".md", ".obj"].iter().any(|end| s.path.ends_with(end)));
    let long = long.map(|s| (s.text.lines().count(), s.path)).filter(|(lines, _)| *lines > MOST);
    assert_none(long.map(|(lines, path)| format!("{path}: {lines} lines, more than {MOST}")).collect());
}

/// A Rust file that no `mod` declares is not compiled, and nobody notices: a test in it never
/// fails.
fn module_complaints(sources: &[Source]) -> Vec<String> {
    let mut complaints = Vec::new();
    for s in sources.iter().filter(|s| s.is_library() || s.is("tests/", ".rs")) {
        let (folder, name) = s.path.trim_end_matches(".rs").rsplit_once('/').unwrap_or_default();
        let parent = match (folder, name) {
            (_, "lib") | ("src" | "tests", "main") => continue,
            ("src", _) => "src/main.rs".into(),
            (root, _) if root.starts_with("crates/") && root.ends_with("/src") => format!("{root}/lib.rs"),
            ("tests", _) | ("tests/common", "mod") => "tests/main.rs".into(),
            ("tests/common", _) => "tests/common/mod.rs".into(),
            _ => format!("{folder}.rs"),
        };
        let name = if name == "mod" { "common" } else { name };
        let text = sources.iter().find(|p| p.path == parent).map_or("", |p| &p.text);
        let declaration = format!("mod {name};");
        let declares = |line: &str| {
            let before = line.trim_end().strip_suffix(declaration.as_str());
            before.is_some_and(|visibility| visibility.is_empty() || visibility.starts_with("pub"))
        };
        if !text.lines().any(declares) {
            complaints.push(format!("{}: {parent} does not declare it", s.path));
        }
    }
    complaints
}

#[test]
fn every_module_has_a_parent() {
    assert_none(module_complaints(&sources()));
}

#[test]
fn undeclared_modules_are_found() {
    let complaints = |path, parent, text| {
        module_complaints(&[Source::new(path, ""), Source::new(parent, text)])
            .iter()
            .filter(|c| c.starts_with(path))
            .count()
    };
    for (path, parent) in [
        ("src/a.rs", "src/main.rs"),
        ("src/b/a.rs", "src/b.rs"),
        ("crates/pelage-x/src/a.rs", "crates/pelage-x/src/lib.rs"),
        ("crates/pelage-x/src/b/a.rs", "crates/pelage-x/src/b.rs"),
        ("tests/a.rs", "tests/main.rs"),
        ("tests/common/a.rs", "tests/common/mod.rs"),
    ] {
        assert_eq!(complaints(path, parent, "mod a;"), 0, "{path}");
        assert_eq!(complaints(path, parent, "pub mod a;"), 0, "{path}");
        assert_eq!(complaints(path, parent, "mod aa;\n// mod a;"), 1, "{path}");
    }
    assert_eq!(complaints("tests/common/mod.rs", "tests/main.rs", "mod common;"), 0);
    assert_eq!(complaints("tests/common/mod.rs", "tests/main.rs", "mod a;"), 1);
}

// The crates.

/// All packages that `package` is built from.
fn dependencies(package: &str) -> BTreeSet<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = std::process::Command::new(cargo)
        .args([
            "tree",
            "--locked",
            "--offline",
            "--edges",
            "normal",
            "--prefix",
            "none",
            "--package",
            package,
        ])
        .current_dir(root())
        .output()
        .expect("cargo tree");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names");
    text.lines().filter_map(|line| Some(line.split_whitespace().next()?.to_owned())).collect()
}

/// Those who read scenes, grow fur or trace paths on the CPU get no GPU, no command line, no
/// solver and no font. That the crates form no cycle, cargo itself sees to.
#[test]
fn crates_for_the_cpu_depend_on_no_gpu() {
    for package in ["pelage-core", "pelage-fur", "pelage-pathtrace"] {
        let all = dependencies(package);
        assert!(all.contains("glam"), "{package}: {all:?}");
        for unwanted in ["wgpu", "naga", "clap", "faer", "noto-sans-mono-bitmap", "pelage-gpu"] {
            assert!(!all.contains(unwanted), "{package} depends on {unwanted}");
        }
    }
    let render = dependencies("pelage-render");
    assert!(
        render.contains("wgpu") && render.contains("pelage-fur") && render.contains("faer"),
        "{render:?}"
    );
    assert!(!render.contains("pelage-shells") && !render.contains("clap"), "{render:?}");
}

/// Links of the documents to files of the repository.
#[test]
fn links_lead_somewhere() {
    let mut complaints = Vec::new();
    for s in sources().iter().filter(|s| s.path.ends_with(".md")) {
        let folder = Path::new(&s.path).parent().unwrap();
        for target in s.text.split("](").skip(1).filter_map(|rest| rest.split([')', '#', ' ']).next()) {
            if !target.is_empty() && !target.contains("://") && !root().join(folder).join(target).exists() {
                complaints.push(format!("{}: {target} is not there", s.path));
            }
        }
    }
    assert_none(complaints);
}
