//! Faults in the input and the environment: the exit code, the message, and the files left behind.
//!
//! `scene`, `usage` and `output` need no adapter; `assets` reads meshes and images; `rendering`
//! renders.

use crate::common::{self, Folder, Run, command, pelage, pelage_without_adapter, run};

const MINIMAL: &str = "[mesh]\nshape = \"sphere\"\n";

/// Renders a scene text that must fail with exit code 3, and checks that the old image is
/// unchanged.
fn expect_fault(text: &str, args: &[&str], parts: &[&str]) -> Run {
    let folder = Folder::new();
    let scene = folder.write("scene.toml", text);
    let image = folder.write("out.png", "old");
    let mut all = vec!["render", &scene, "-o", &image];
    all.extend(args);
    let run = pelage(&all).expect(3, parts);
    assert_eq!(std::fs::read(&image).unwrap(), b"old");
    assert_eq!(folder.names(), ["out.png", "scene.toml"]);
    assert!(run.out.is_empty(), "{}", run.out);
    run
}

mod scene {
    use super::*;

    #[test]
    fn all_kinds_of_faults_come_at_once() {
        let text = "[mesh]\nshape = \"sphere\"\n[camera]\nfov = \"wide\"\n[guard]\nlenght = 2\n[film]\nspp = 0\n\
                    plate = \"none.png\"\n[environment]\nmap = \"gone.hdr\"\n";
        expect_fault(
            text,
            &["-D", "undercoat.layers=0", "--memory", "1MiB"],
            &[
                "scene.toml:4:7: camera.fov: expected a number",
                "scene.toml:6:1: unknown key \"lenght\"",
                "did you mean \"length\"?",
                "scene.toml:8:7: film.spp: must be at least 1",
                "scene.toml:9:9: film.plate: the file \"none.png\" is not there",
                "scene.toml:11:7: environment.map: the file \"gone.hdr\" is not there",
                "scripts/fetch_assets.sh",
                "-D undercoat.layers=0: undercoat.layers",
                "--memory 1048576: render.memory",
                "7 errors",
            ],
        );
    }

    #[test]
    fn text_that_is_not_toml() {
        expect_fault(
            "[mesh\nshape = \"hat\"\n[film]\nspp = = 3\n",
            &[],
            &["scene.toml:1:", "scene.toml:4:", "TOML"],
        );
    }

    #[test]
    fn a_scene_without_a_mesh() {
        expect_fault("", &[], &["neither mesh.path nor mesh.shape"]);
    }

    #[test]
    fn a_scene_that_is_not_text() {
        let folder = Folder::new();
        let scene = folder.write("scene.toml", b"[mesh]\nshape = \"\xff\xfe\"\n");
        pelage(&["check", &scene]).expect(3, &["scene.toml:2: not UTF-8"]);
    }

    #[test]
    fn a_missing_scene() {
        pelage(&["render", "no/such.toml", "-o", "x.png"]).expect(3, &["no/such.toml", "not there"]);
        let folder = Folder::new();
        pelage(&["check", &folder.path().display().to_string()]).expect(3, &["cannot be read"]);
    }

    #[test]
    fn a_backslash_in_a_file_name_is_explained() {
        let text = |name: &str| format!("[mesh]\npath = {name}\n");
        let help = "begins an escape: write / between folders, or put the name in single quotes";
        expect_fault(&text(r#""meshes\plane.obj""#), &[], &["scene.toml:2:", "not valid TOML", help]);
        // A line break, to TOML.
        expect_fault(&text(r#""meshes\new.obj""#), &[], &["mesh.path: the file \"meshes\\new.obj\"", help]);
    }

    #[test]
    fn a_body_in_the_wrong_unit() {
        let text = |more: &str| format!("{MINIMAL}{more}[[lights]]\n");
        let huge = expect_fault(&text("size = 10000\n"), &[], &["guard.density", "at most 2e8", "mesh.size"]);
        assert!(huge.err.contains("longest side is 10000 cm"), "{}", huge.err);
        let folder = Folder::new();
        let tiny = folder.write("tiny.toml", text("size = 0.0001\n"));
        pelage(&["check", &tiny]).expect(0, &["note: no hair is expected", "0.0001 cm", "mesh.size"]);
        let small = folder.write("small.toml", text("size = 4\n"));
        pelage(&["check", &small])
            .expect(0, &["more than a quarter of the body's longest side", "groom.scale"]);
        let fits = pelage(&["check", &small, "-D", "groom.scale=0.2"]).expect(0, &[]);
        assert!(!fits.err.contains("longest"), "{}", fits.err);
    }

    #[test]
    fn a_patch_smaller_than_a_hair_is_refused() {
        let folder = Folder::new();
        let out = folder.at("out");
        pelage(&["bake", "scenes/hat.toml", "-o", &out, "--patch", "1e-6"])
            .expect(3, &["bake.patch: found 1e-6 cm", "expected at most 4000", "cm or more"]);
    }

    #[test]
    fn a_missing_include() {
        expect_fault(
            &format!("include = [\"gone.toml\"]\n{MINIMAL}"),
            &[],
            &["scene.toml:1:12: cannot include \"gone.toml\""],
        );
    }

    #[test]
    fn cyclic_includes() {
        let folder = Folder::new();
        let a = folder.write("a.toml", format!("include = [\"b.toml\"]\n{MINIMAL}"));
        folder.write("b.toml", "include = [\"c.toml\"]\n");
        folder.write("c.toml", "[film]\nspp = 0\n");
        pelage(&["check", &a]).expect(3, &["c.toml:2:7: film.spp"]);
        folder.write("c.toml", "include = [\"./a.toml\"]\n");
        pelage(&["check", &a])
            .expect(3, &["c.toml:1:12: include cycle: a.toml -> b.toml -> c.toml -> a.toml"]);
        folder.write("a.toml", format!("include = [\"a.toml\"]\n{MINIMAL}"));
        pelage(&["check", &a]).expect(3, &["include cycle: a.toml -> a.toml"]);
    }

    #[test]
    fn includes_that_explode() {
        let folder = Folder::new();
        for i in 0..30 {
            let next = format!("{}.toml", i + 1);
            folder.write(&format!("{i}.toml"), format!("include = [\"{next}\", \"{next}\"]\n"));
        }
        folder.write("30.toml", MINIMAL);
        pelage(&["check", &folder.at("0.toml")]).expect(3, &["more than 64 included files"]);
    }

    #[test]
    fn deep_nesting() {
        let deep = "[".repeat(100_000);
        expect_fault(&format!("{MINIMAL}[camera]\neye = {deep}"), &[], &["TOML"]);
    }
}

mod usage {
    use super::*;

    #[test]
    fn wrong_usage_exits_with_2() {
        let scene = "scenes/default.toml";
        for (args, part) in [
            (&["render", scene][..], "--outfile"),
            (&["render", "-o", "x.png"], "SCENE"),
            (&["render", scene, "-o", "x.jpg"], ".png or .exr"),
            (&["render", scene, "-o", "x.png", "--size", "12"], "WIDTHxHEIGHT"),
            (&["render", scene, "-o", "x.png", "--memory", "lots"], "1GiB"),
            (&["render", scene, "-o", "x.png", "--cropwindow", "0,2,0,1"], "x0,x1,y0,y1"),
            (&["render", scene, "-o", "x.png", "--fur", "hybird"], "hybrid"),
            (&["render", scene, "-o", "x.png", "--threads", "0"], "--threads"),
            (&["check", scene, "-D", "camera.fov"], "key.path=value"),
            (&["check", scene, "--bogus"], "--bogus"),
            (&["export", scene], "--strands"),
            (&["compare", "a.png"], "<B>"),
            (&["compare", "a.png", "b.png", "--threshold-rmse", "nan"], "at least 0"),
            (&["figure"], "--list"),
            (&["paint"], "paint"),
            (&[], "Usage"),
        ] {
            let run = pelage(args).expect(2, &[part]);
            assert!(run.out.is_empty(), "{}", run.out);
        }
        assert!(!common::root().join("x.png").exists());
    }
}

mod output {
    use super::*;

    /// Exit code 1 before an adapter is requested: without one, a later check would exit with 4.
    fn expect_fault(args: &[&str], parts: &[&str]) {
        pelage_without_adapter(args).expect(1, parts);
    }

    #[test]
    fn a_missing_folder() {
        let folder = Folder::new();
        let image = folder.at("none/out.png");
        expect_fault(
            &["render", "scenes/default.toml", "-o", &image],
            &["out.png", "does not exist", "create it"],
        );
        let (good, stats) = (folder.at("out.png"), folder.at("none/stats.json"));
        expect_fault(&["render", "scenes/default.toml", "-o", &good, "--stats", &stats], &["stats.json"]);
        expect_fault(&["export", "scenes/default.toml", "--strands", &folder.at("none/a.hair")], &["a.hair"]);
        assert!(folder.names().is_empty());
    }

    #[test]
    fn a_folder_of_that_name() {
        let folder = Folder::new();
        std::fs::create_dir(folder.at("out.png")).unwrap();
        expect_fault(&["render", "scenes/default.toml", "-o", &folder.at("out.png")], &["is a folder"]);
    }

    #[test]
    fn a_read_only_file_stays() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        let mut permissions = std::fs::metadata(&image).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&image, permissions).unwrap();
        expect_fault(&["render", "scenes/default.toml", "-o", &image], &["write-protected"]);
        assert_eq!(std::fs::read(&image).unwrap(), b"old");
        assert_eq!(folder.names(), ["out.png"]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_folder_that_takes_no_files() {
        // Not even root may create files here, unlike in a folder without write permission.
        expect_fault(&["render", "scenes/default.toml", "-o", "/proc/out.png"], &["/proc/out.png"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_read_only_folder() {
        use std::os::unix::fs::PermissionsExt;
        let folder = Folder::new();
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o555)).unwrap();
        if std::fs::write(folder.at("probe"), "").is_ok() {
            eprintln!("note: skipped, this user writes where nobody may");
            return;
        }
        expect_fault(&["render", "scenes/default.toml", "-o", &folder.at("out.png")], &["out.png"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_not_a_file() {
        expect_fault(
            &["render", "scenes/default.toml", "-o", "x.png", "--stats", "/dev/null"],
            &["/dev/null", "regular"],
        );
    }

    /// A limit on the size of files simulates a full disk: writing fails after a part.
    #[test]
    #[cfg(unix)]
    fn a_full_disk() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        let script = "trap '' XFSZ; ulimit -f 4; exec \"$0\" render scenes/default.toml -o \"$1\"";
        let mut shell = std::process::Command::new("sh");
        shell.current_dir(common::root()).args(["-c", script, env!("CARGO_BIN_EXE_pelage"), &image]);
        run(&mut shell).expect(1, &["out.png", "cannot be written"]);
        assert_eq!(std::fs::read(&image).unwrap(), b"old");
        assert_eq!(folder.names(), ["out.png"]);
    }
}

mod assets {
    use super::*;

    fn mesh(content: impl AsRef<[u8]>, parts: &[&str]) {
        let folder = Folder::new();
        folder.write("a.obj", content);
        let scene = folder.write("s.toml", "[mesh]\npath = \"a.obj\"\n");
        pelage(&["check", &scene]).expect(3, parts);
    }

    #[test]
    fn meshes_with_impossible_numbers() {
        let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        mesh(format!("{head}v nan 0 0\nf 1 2 3\n"), &["a.obj:4"]);
        mesh(format!("{head}v 1e99 0 0\nf 1 2 3\n"), &["a.obj:4"]);
        mesh(format!("{head}f 0 1 2\n"), &["a.obj:4"]);
        mesh(format!("{head}f 1 2 9\n"), &["a.obj:4", "9"]);
        mesh(format!("{head}f 1 2 -9\n"), &["a.obj:4"]);
    }

    #[test]
    fn meshes_without_triangles() {
        mesh("", &["a.obj"]);
        mesh("v 0 0 0\n", &["a.obj"]);
    }

    #[test]
    fn environment_maps_that_are_cut_or_forged() {
        let folder = Folder::new();
        let scene = folder.write("s.toml", format!("{MINIMAL}[environment]\nmap = \"e.hdr\"\n"));
        let forged = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 999999 +X 999999\n";
        for content in ["", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n", forged, "not an image"] {
            folder.write("e.hdr", content);
            pelage(&["check", &scene]).expect(3, &["e.hdr"]);
        }
    }

    #[test]
    fn files_to_compare_that_are_not_images() {
        let folder = Folder::new();
        let (a, b) = (folder.write("a.png", "no image"), folder.at("b.png"));
        pelage(&["compare", &a, &a]).expect(1, &["a.png"]);
        pelage(&["compare", &b, &b]).expect(1, &["b.png"]);
        pelage(&["compare", &folder.write("c.txt", ""), &b]).expect(2, &["c.txt"]);
    }

    #[test]
    fn images_of_different_sizes() {
        let folder = Folder::new();
        let (a, b) = (folder.at("a.png"), folder.at("b.png"));
        image::RgbImage::new(4, 4).save(&a).unwrap();
        image::RgbImage::new(4, 5).save(&b).unwrap();
        pelage(&["compare", &a, &b]).expect(1, &["4"]);
    }
}

mod rendering {
    use super::*;
    use std::time::Duration;

    /// A short rendering.
    const SMALL: [&str; 5] = ["render", "tests/data/small.toml", "--size", "32x20", "--quiet"];

    fn is_whole_png(path: &str) -> bool {
        image::open(path).is_ok_and(|i| i.width() > 0)
    }

    #[test]
    fn no_adapter() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        pelage_without_adapter(&["devices"]).expect(4, &["adapter"]);
        let mut args = SMALL.to_vec();
        args.extend(["-o", &image]);
        pelage_without_adapter(&args).expect(4, &["adapter"]);
        assert_eq!(std::fs::read(&image).unwrap(), b"old");
        assert_eq!(folder.names(), ["out.png"]);
    }

    #[test]
    fn an_unknown_adapter() {
        let folder = Folder::new();
        let mut named = command();
        named.args(SMALL).args(["-o", &folder.at("out.png")]).env("WGPU_ADAPTER_NAME", "no such adapter");
        run(&mut named).expect(4, &["no such adapter"]);
        assert!(folder.names().is_empty());
    }

    #[test]
    fn a_finished_rendering_leaves_what_was_asked_for_and_nothing_else() {
        let folder = Folder::new();
        let (png, exr, stats) =
            (folder.write("out.png", "old"), folder.at("out.exr"), folder.at("stats.json"));
        let mut args = SMALL.to_vec();
        args.pop();
        args.extend(["-o", &png, "-o", &exr, "--stats", &stats, "--json", "--progress", "text"]);
        let run = pelage(&args).expect(0, &["%"]);
        assert_eq!(folder.names(), ["out.exr", "out.png", "stats.json"]);
        assert!(is_whole_png(&png));
        let stats = common::json(&stats);
        assert_eq!(stats, serde_json::from_str::<serde_json::Value>(&run.out).unwrap());
        for key in [
            "adapter",
            "width",
            "height",
            "spp",
            "fur",
            "blend",
            "triangles",
            "strands",
            "tiles",
            "fragments",
            "fragments_dropped",
            "memory_budget_bytes",
            "gpu_peak_bytes",
            "total_ms",
        ] {
            assert!(!stats[key].is_null(), "{key} is missing in {stats}");
        }
        assert_eq!((&stats["width"], &stats["height"]), (&32.into(), &20.into()));
        for step in stats["steps"].as_array().unwrap() {
            for key in ["step", "name", "ms", "bytes"] {
                assert!(step.get(key).is_some(), "{key} is missing in {step}");
            }
        }
        let mut quiet = SMALL.to_vec();
        quiet.extend(["-o", &png]);
        let run = pelage(&quiet).expect(0, &[]);
        assert!(run.out.is_empty() && run.err.is_empty(), "{run:?}");
    }

    /// Starts a rendering that would take long, and waits for a first sign of progress.
    #[cfg(unix)]
    fn start_long(image: &str) -> std::process::Child {
        use std::io::{BufRead, BufReader};
        let mut long = command();
        long.args(["render", "tests/data/small.toml", "--size", "1920x1200", "--tile", "64", "-o", image]);
        long.args(["--progress", "text"]).stderr(std::process::Stdio::piped());
        let mut child = long.spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let mut before = Vec::new();
        // From the first finished tile on there is a partial image.
        let begun = |line: &String| line.contains("% ") && !line.trim_start().starts_with("0%");
        while !before.last().is_some_and(begun) {
            match lines.next() {
                Some(line) => before.push(line.unwrap()),
                None => panic!("it ended before there was progress: {before:?}"),
            }
        }
        // Without a reader, the child would block on its stderr.
        std::thread::spawn(move || lines.for_each(drop));
        child
    }

    #[cfg(unix)]
    fn signal(child: &std::process::Child, name: &str) {
        let status = std::process::Command::new("kill").args([name, &child.id().to_string()]).status();
        assert!(status.is_ok_and(|s| s.success()));
    }

    #[test]
    #[cfg(unix)]
    fn the_first_interrupt_writes_the_partial_image() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        let mut child = start_long(&image);
        signal(&child, "-INT");
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert!(is_whole_png(&image));
        assert_eq!(folder.names(), ["out.png"]);
    }

    #[test]
    #[cfg(unix)]
    fn an_interrupt_of_the_preparation_quits_at_once() {
        let folder = Folder::new();
        let image = folder.write("out.exr", "old");
        // Millions of hairs grow before anything is traced.
        let mut heavy = command();
        heavy.args(["reference", "scenes/default.toml", "--memory", "400GiB", "-o", &image]);
        heavy.args(["-D", "undercoat.density=200000"]).stderr(std::process::Stdio::null());
        let mut child = heavy.spawn().unwrap();
        std::thread::sleep(Duration::from_secs(3));
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        let begin = std::time::Instant::now();
        signal(&child, "-INT");
        assert_eq!(child.wait().unwrap().code(), Some(130));
        // One second on a machine that is not busy with other tests.
        assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
        assert_eq!(std::fs::read(&image).unwrap(), b"old");
        assert_eq!(folder.names(), ["out.exr"]);
    }

    #[test]
    #[cfg(unix)]
    fn the_second_interrupt_quits_at_once() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        let mut child = start_long(&image);
        signal(&child, "-INT");
        std::thread::sleep(Duration::from_millis(20));
        signal(&child, "-INT");
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert!(std::fs::read(&image).unwrap() == b"old" || is_whole_png(&image));
    }

    #[test]
    #[cfg(unix)]
    fn a_killed_rendering_leaves_the_old_image() {
        let folder = Folder::new();
        let image = folder.write("out.png", "old");
        let mut child = start_long(&image);
        signal(&child, "-KILL");
        assert_eq!(child.wait().unwrap().code(), None);
        assert_eq!(std::fs::read(&image).unwrap(), b"old");
    }

    #[test]
    fn two_renderings_at_once_to_the_same_file() {
        let folder = Folder::new();
        let image = folder.at("out.png");
        let start = || command().args(SMALL).args(["-o", &image]).spawn().unwrap();
        let mut children = [start(), start()];
        for child in &mut children {
            assert_eq!(child.wait().unwrap().code(), Some(0));
        }
        assert!(is_whole_png(&image));
        assert_eq!(folder.names(), ["out.png"]);
    }

    #[test]
    fn export_writes_strands_and_mesh() {
        let folder = Folder::new();
        let (hair, obj) = (folder.at("a.hair"), folder.at("a.obj"));
        let args = ["export", "tests/data/small.toml", "--strands", &hair, "--mesh", &obj];
        pelage(&args).expect(0, &[]);
        assert!(std::fs::read(&hair).unwrap().starts_with(b"HAIR"));
        assert!(std::fs::read_to_string(&obj).unwrap().lines().any(|l| l.starts_with("f ")));
        assert_eq!(folder.names(), ["a.hair", "a.obj"]);
        let mut nothing = args.to_vec();
        nothing.extend(["--fur", "implicit"]);
        pelage(&nothing).expect(1, &["no guard hairs", "implicit"]);
    }
}
