//! Conventions that a compiler does not check: files, modules, crates, sizes, leftovers. Each rule
//! is a function from texts to complaints, so that it is also tested on texts that break it.

use crate::common::root;
use crate::common::sources::{Source, assert_none, sources};
use pelage_render::shaders;
use std::collections::BTreeSet;
use std::path::Path;

/// A rule whose folder was moved would find no file, and so no fault.
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

// One stem names the shader, its record in Rust, its CPU twin and its test.

/// Files of a stem in other places, with the reason.
const EXCEPTIONS: [(&str, &str, &str); 1] =
    [("film", "tests/film_pass.rs", "tests/film.rs is the test of the module film, which writes images")];

fn stem_complaints(paths: &BTreeSet<&str>, exceptions: &[(&str, &str, &str)]) -> Vec<String> {
    let mut complaints = Vec::new();
    for stem in paths.iter().filter_map(|p| p.strip_prefix("shaders/")?.strip_suffix(".wgsl")) {
        if stem.contains('/') {
            continue;
        }
        // CPU twins that other crates also need are in pelage-fur.
        let crates = ["crates/pelage-render/src", "crates/pelage-shells/src"];
        let pass = crates.map(|folder| format!("{folder}/passes/{stem}.rs"));
        let twin: Vec<String> = crates
            .iter()
            .map(|folder| format!("{folder}/twin/{stem}.rs"))
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
fn every_stem_has_shader_pass_twin_and_test() {
    let sources = sources();
    assert_none(stem_complaints(&sources.iter().map(|s| s.path.as_str()).collect(), &EXCEPTIONS));
}

#[test]
fn missing_files_of_a_stem_are_detected() {
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

/// Shared shaders hold functions; the only binding in them is the frame's.
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

// Leftovers.

fn leftover_complaints(sources: &[Source]) -> Vec<String> {
    // Written in parts, so that this file does not contain them.
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
                // Not the template of mktemp.
                let line = line.replace("XXXXXX", "");
                if let Some(word) = list.iter().find(|w| line.contains(w.as_str())) {
                    complaints.push(format!("{}:{}: {what} {word}", s.path, i + 1));
                }
            };
            find(&words, "a leftover:");
            // Only the integration run has absolute paths of its assets.
            if s.path != ".ci/run" {
                find(&places, "a path of one machine:");
            }
        }
    }
    complaints
}

#[test]
fn there_are_no_leftovers() {
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
            // Files appear whole or not at all: the module `files` writes them.
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
    // Prose and meshes may be longer.
    let long = sources().into_iter().filter(|s| ![".md", ".obj"].iter().any(|end| s.path.ends_with(end)));
    let long = long.map(|s| (s.text.lines().count(), s.path)).filter(|(lines, _)| *lines > MOST);
    assert_none(long.map(|(lines, path)| format!("{path}: {lines} lines, more than {MOST}")).collect());
}

/// A Rust file that no `mod` declares is not compiled, so that a test in it never fails.
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
fn undeclared_modules_are_detected() {
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

/// The crates for scenes, fur and path tracing need no GPU, command line, solver or font. Cargo
/// itself rejects cycles between crates.
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

/// Links in documents point to files of the repository.
#[test]
fn links_have_targets() {
    let mut complaints = Vec::new();
    for s in sources().iter().filter(|s| s.path.ends_with(".md")) {
        let folder = Path::new(&s.path).parent().unwrap();
        for target in s.text.split("](").skip(1).filter_map(|rest| rest.split([')', '#', ' ']).next()) {
            if !target.is_empty() && !target.contains("://") && !root().join(folder).join(target).exists() {
                complaints.push(format!("{}: {target} does not exist", s.path));
            }
        }
    }
    assert_none(complaints);
}
