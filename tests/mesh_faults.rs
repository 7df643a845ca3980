//! OBJ files with the defects of real files, and with deliberate ones.

use crate::common::cases;
use crate::common::mesh_files::{self as files, Body};
use crate::common::{Folder, pelage};
use glam::{Vec2, Vec3};
use pelage_core::mesh::obj::{Limits, parse, read};
use pelage_core::mesh::topology::neighbours;
use pelage_core::mesh::{Mesh, load, skin_of};
use pelage_core::scene::{MeshSpec, Units};
use pelage_core::{Error, Result, Scene, Skin, World};
use proptest::prelude::*;
use std::path::Path;

fn obj(text: impl AsRef<[u8]>) -> Result<Mesh> {
    parse(text.as_ref(), Path::new("test.obj"), &Limits::default())
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn faults_name_file_line_found_and_expected() {
    // Text after the three vertices, from line 4, and parts of the message.
    let rows = [
        ("v nan 0 0\nf 1 2 3", &["test.obj:4", "`nan`", "finite"][..]),
        ("v 0 -inf 0\nf 1 2 3", &["test.obj:4", "`-inf`", "finite"]),
        ("v 0 0 1e39\nf 1 2 3", &["test.obj:4", "`1e39`", "3.4e38"]),
        ("v 0 0\nf 1 2 3", &["test.obj:4", "2 numbers", "expected x y z"]),
        ("v\nf 1 2 3", &["test.obj:4", "0 numbers"]),
        ("v 0 0 0 1 1\nf 1 2 3", &["test.obj:4", "5 numbers"]),
        ("v 0,5 0 0\nf 1 2 3", &["test.obj:4", "`0,5`"]),
        ("v 0 0 0 0\nf 1 2 3", &["test.obj:4", "w = 0"]),
        ("v 0 0 0 1 -1 1\nf 1 2 3", &["test.obj:4", "vertex colour of -1"]),
        ("vt nan 0\nf 1 2 3", &["test.obj:4", "`nan`"]),
        ("vt\nf 1 2 3", &["test.obj:4", "`vt` with 0 numbers"]),
        ("\n\nf 0 1 2", &["test.obj:6", "index 0", "1 to 3"]),
        ("f 1 2 4", &["test.obj:4", "index 4", "3 vertices"]),
        ("f 1 2 -4", &["test.obj:4", "index -4", "only 3 vertices"]),
        ("f 1 2 99999999999999999999", &["test.obj:4", "99999999999999999999", "integer"]),
        ("f 1 2 -9223372036854775808", &["test.obj:4", "only 3 vertices"]),
        ("f 1 2 x", &["test.obj:4", "`x`", "integer"]),
        ("f 1 2 /1", &["test.obj:4", "integer"]),
        ("f 1/1/1/1 2 3", &["test.obj:4", "`1/1/1/1`", "v/vt/vn"]),
        ("f 1//x 2 3", &["test.obj:4", "`x`"]),
        ("vt 0 0\nf 1/2 2/1 3/1", &["test.obj:5", "index 2", "1 uv"]),
        ("f 1 2 \\\n3 \\\n9", &["test.obj:4", "index 9"]),
        ("# one\r\n# two\rf 1 2 9", &["test.obj:6", "index 9"]),
        ("f 1 2 \u{e9}", &["test.obj:4", "integer"]),
    ];
    for (text, wanted) in rows {
        let error = obj(format!("{TRIANGLE}{text}\n")).expect_err(text);
        assert_eq!(error.exit_code(), 3, "{text}");
        let message = error.to_string();
        for part in wanted {
            assert!(message.contains(part), "{text:?}: {part:?} is not in {message:?}");
        }
    }
}

#[test]
fn all_faults_come_at_once_and_only_so_many() {
    let error = obj(format!("{TRIANGLE}v nan 0 0\nf 1 2 9\nf 0 1 2\n")).expect_err("three faults");
    let Error::Scene(faults) = error else { panic!("{error}") };
    assert_eq!(faults.iter().map(|f| f.line).collect::<Vec<_>>(), [4, 5, 6]);
    let many = format!("{TRIANGLE}{}", "f 1 2 9\n".repeat(500));
    let message = obj(many).expect_err("many faults").to_string();
    assert_eq!(message.matches("index 9").count(), 10);
    assert!(message.contains("490 more faults"), "{message}");
}

#[test]
fn empty_files_and_files_without_faces() {
    for text in ["", "\n", "# nothing\n", TRIANGLE, "v 0 0 0\nf 1 1\n", "f\n"] {
        let error = obj(text).expect_err(text);
        assert_eq!(error.exit_code(), 3);
        assert!(error.to_string().contains("no faces"), "{text:?}: {error}");
    }
    let error = obj(b"\xFF\xFEv\0 \0").expect_err("UTF-16");
    assert!(error.to_string().contains("UTF-16"), "{error}");
    // Faces, but none that can carry fur.
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("flat.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").expect("writable");
    let spec = MeshSpec { path: Some("flat.obj".into()), ..MeshSpec::default() };
    let error = load(&spec, &|_| Ok(path.clone())).expect_err("flat");
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("no triangle is left"), "{error}");
    assert!(error.to_string().contains("1 zero-area triangles"), "{error}");
    assert_eq!(read(&folder.path().join("missing.obj")).expect_err("missing").exit_code(), 1);
}

#[test]
fn huge_files_are_errors_before_memory_is_allocated() {
    let limits = Limits { bytes: 1000, vertices: 3, triangles: 2 };
    let parse = |text: String| parse(text.as_bytes(), Path::new("test.obj"), &limits);
    parse(format!("{TRIANGLE}f 1 2 3\n")).expect("within the limits");
    for text in [format!("{TRIANGLE}v 0 0 0\nf 1 2 3\n"), format!("{TRIANGLE}f 1 2 3 1 2\n")] {
        let error = parse(text).expect_err("past the limits");
        assert_eq!(error.exit_code(), 3);
        assert!(error.to_string().contains("MiB") && error.to_string().contains("help: "), "{error}");
    }
}

#[test]
fn odd_text_reads_as_the_plain_one() {
    let plain = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("plain");
    let rows: [&[u8]; 9] = [
        b"\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        b"# caf\xE9 \xFF\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng \xE9\nusemtl \xFF\xFE\nf 1 2 3\n",
        b"v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        b"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        b"v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n 2 \\\n 3\n",
        b"# C:\\models\\\nv 0 0 0 # origin\nv 1 0 0\nv 0 1 0\nf 1 2 3#\n",
        b"  v\t0 +0.0 0e5\n\x0Bv 1. .0 0\nv 0 1 0\nf -3 -2 -1\n",
        b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",
        b"mtllib missing.mtl\no a\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan 0 0\ns off\nf 1//1 2//1 3//7\nusemtl\n",
    ];
    for text in rows {
        let shown = String::from_utf8_lossy(text);
        let mesh = obj(text).unwrap_or_else(|e| panic!("{shown}: {e}"));
        assert_eq!(mesh.positions, plain.positions, "{shown}");
        assert_eq!(mesh.triangles, plain.triangles, "{shown}");
        assert!(
            mesh.notes.is_empty() && mesh.repairs.is_empty(),
            "{shown}: {:?} {:?}",
            mesh.notes,
            mesh.repairs
        );
    }
}

#[test]
fn weights_colours_and_missing_uv_are_read_with_a_note() {
    let mesh = obj("v 0 0 0 1\nv 2 0 0 2\nv 0 1 0\nf 1 2 3\n").expect("weights");
    assert_eq!(mesh.positions[1], Vec3::X);
    assert!(mesh.notes[0].starts_with("1 vertices with a weight"), "{:?}", mesh.notes);

    let mesh = obj("v 0 0 0 0.25 0.5 1\nv 1 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n").expect("colours");
    assert_eq!(mesh.colors, [Vec3::new(0.25, 0.5, 1.0), Vec3::ONE, Vec3::ZERO]);
    assert!(mesh.notes[0].starts_with("1 vertices without a colour"), "{:?}", mesh.notes);
    let mesh = obj("v 0 0 0 255 0 51\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n").expect("byte colours");
    assert_eq!(mesh.colors[0], Vec3::new(1.0, 0.0, 0.2));
    assert!(mesh.notes[0].contains("0..255"), "{:?}", mesh.notes);

    let mesh = obj(format!("{TRIANGLE}f 1/1 2/2 3/3\n")).expect("uv indices without uv");
    assert!(mesh.corner_uv.is_none());
    assert!(mesh.notes[0].starts_with("3 face corners name a uv"), "{:?}", mesh.notes);
    let mesh = obj(format!("{TRIANGLE}vt 0 0\nf 1/1 2/1 3/1\nf 1 3 2/1\n")).expect("some uv");
    assert!(mesh.corner_uv.is_none());
    assert!(mesh.notes[0].starts_with("2 face corners have no uv"), "{:?}", mesh.notes);
    let mesh = obj(format!("{TRIANGLE}vt 0 0\nvt 1 0 0\nvt 0.5\nf 1/-3 2/2 3/-1\n")).expect("uv");
    assert_eq!(mesh.corner_uv, Some(vec![[Vec2::ZERO, Vec2::X, Vec2::new(0.5, 0.0)]]));
    let mesh = obj(format!("{TRIANGLE}p 1\nl 1 2\nf 1 2\nf 1 2 3\nv 9 9 9\n")).expect("points and lines");
    assert!(mesh.notes[0].starts_with("2 points"), "{:?}", mesh.notes);
    assert_eq!(mesh.repairs.len(), 2, "{:?}", mesh.repairs);
}

/// The area of a polygon in the plane z = 0, and that of its triangles: equal, if they cover it
/// without overlap.
fn areas(corners: &[Vec2]) -> (f32, f32, Mesh) {
    let n = corners.len();
    let own: f32 = (0..n).map(|i| corners[i].perp_dot(corners[(i + 1) % n])).sum::<f32>() / 2.0;
    let mut text: String = corners.iter().map(|p| format!("v {} {} 0\n", p.x, p.y)).collect();
    text += "f";
    (1..=n).for_each(|i| text += &format!(" {i}"));
    let mesh = obj(text).expect("polygon");
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        let z = (b - a).cross(c - a).z / 2.0;
        assert!(z > -1e-4, "a triangle is turned over");
        z
    };
    let cut = mesh.triangles.iter().map(area).sum();
    (own, cut, mesh)
}

#[test]
fn polygons_are_cut_concave_ones_too() {
    let points = |p: &[(f32, f32)]| p.iter().map(|(x, y)| Vec2::new(*x, *y)).collect::<Vec<_>>();
    let arrow = points(&[(0.0, 0.0), (4.0, 2.0), (0.0, 4.0), (1.5, 2.0)]);
    let comb: Vec<Vec2> = (0..40)
        .map(|i| Vec2::new(i as f32, if i % 2 == 0 { 0.0 } else { 8.0 }))
        .chain([Vec2::new(40.0, 9.0), Vec2::new(-1.0, 9.0)])
        .collect();
    let spiral: Vec<Vec2> = (0..60)
        .map(|i| Vec2::from_angle(0.3 * i as f32) * (1.0 + 0.1 * i as f32))
        .chain((0..60).rev().map(|i| Vec2::from_angle(0.3 * i as f32) * (0.7 + 0.1 * i as f32)))
        .collect::<Vec<_>>();
    for (start, polygon) in [arrow, comb, spiral].into_iter().enumerate() {
        let mut polygon = polygon;
        let n = polygon.len();
        let winding: f32 = (0..n).map(|i| polygon[i].perp_dot(polygon[(i + 1) % n])).sum();
        if winding < 0.0 {
            polygon.reverse();
        }
        polygon.rotate_left(start % n);
        let (own, cut, mesh) = areas(&polygon);
        assert!((own - cut).abs() < 1e-3 * own, "{own} {cut}");
        assert_eq!(mesh.triangles.len(), n - 2);
        assert!(mesh.notes.iter().any(|n| n.contains("ear clipping")), "{:?}", mesh.notes);
    }
    let hexagon: Vec<Vec2> = (0..6).map(|i| Vec2::from_angle(i as f32)).collect();
    let (_, _, mesh) = areas(&hexagon);
    assert_eq!(mesh.notes, ["1 polygons cut into triangles"]);
    // A bow tie intersects itself: it is triangulated, with or without a note, and never hangs.
    obj("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n").expect("bow tie");
}

#[test]
fn strict_lists_every_repair() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("bad.obj");
    let text = format!("{TRIANGLE}v 0 0 1\nv 5 5 5\nf 1 2 3\nf 1 2 4\nf 2 3 1\nf 1 1 2\nf 1 2\n");
    std::fs::write(&path, text).expect("writable");
    let spec = MeshSpec { path: Some("bad.obj".into()), strict: true, ..MeshSpec::default() };
    let message = load(&spec, &|_| Ok(path.clone())).expect_err("strict").to_string();
    for wanted in [
        "bad.obj",
        "1 unused vertices",
        "1 faces with fewer than three corners",
        "1 zero-area triangles",
        "1 duplicate triangles",
        "1 triangles turned over",
        "4 boundary edges",
    ] {
        assert!(message.contains(wanted), "{wanted:?} is not in {message}");
    }
    let spec = MeshSpec { strict: false, ..spec };
    assert_eq!(load(&spec, &|_| Ok(path.clone())).expect("repaired").triangles.len(), 2);
}

/// A ball of quads, with triangles around its poles, radius 5: vertices and faces, each
/// counter-clockwise from outside.
fn ball() -> (Vec<Vec3>, Vec<Vec<u32>>) {
    const AROUND: u32 = 24;
    const RINGS: u32 = 11;
    let mut positions = vec![Vec3::Y * 5.0, Vec3::NEG_Y * 5.0];
    for ring in 1..=RINGS {
        let (sin, cos) = (std::f32::consts::PI * ring as f32 / (RINGS + 1) as f32).sin_cos();
        positions.extend((0..AROUND).map(|i| {
            let (z, x) = (std::f32::consts::TAU * i as f32 / AROUND as f32).sin_cos();
            5.0 * Vec3::new(sin * x, cos, sin * z)
        }));
    }
    let at = |ring: u32, i: u32| 2 + ring * AROUND + i % AROUND;
    let mut faces = Vec::new();
    for i in 0..AROUND {
        faces.push(vec![0, at(0, i + 1), at(0, i)]);
        faces.push(vec![1, at(RINGS - 1, i), at(RINGS - 1, i + 1)]);
        for ring in 0..RINGS - 1 {
            faces.push(vec![at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)]);
        }
    }
    (positions, faces)
}

fn obj_text(positions: &[Vec3], faces: &[Vec<u32>]) -> String {
    let mut text: String = positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    for face in faces {
        text += "f";
        face.iter().for_each(|i| text += &format!(" {}", i + 1));
        text += "\n";
    }
    text
}

fn outwards(skin: &Skin) -> bool {
    (0..skin.triangles.len()).all(|t| {
        let [a, b, c] = skin.corners(t);
        (b - a).cross(c - a).dot(a + b + c) > 0.0
    })
}

#[test]
fn faces_that_are_there_twice_are_dropped() {
    type Change = fn(&mut Vec<u32>);
    let (positions, faces) = ball();
    let once = 2 * 24 + 2 * 10 * 24;
    let check = |skin: &Skin, name: &str| {
        assert_eq!(skin.triangles.len(), once, "{name}: {:?}", skin.notes);
        let topology = neighbours(&skin.triangles);
        assert_eq!(
            (topology.boundary_edges, topology.non_manifold_edges),
            (0, 0),
            "{name}: {:?}",
            skin.notes
        );
        assert!(outwards(skin), "{name}");
    };
    let again = |change: Change| {
        let copies = faces.iter().cloned().map(|mut f| {
            change(&mut f);
            f
        });
        obj_text(&positions, &faces.iter().cloned().chain(copies).collect::<Vec<_>>())
    };
    let rows: [(&str, Change); 5] = [
        ("the same", |_| ()),
        ("turned by one corner", |f| f.rotate_left(1)),
        ("reversed", |f| f.reverse()),
        ("reversed and turned", |f| {
            f.reverse();
            f.rotate_left(1);
        }),
        ("turned by two", |f| f.rotate_left(2)),
    ];
    for (name, change) in rows {
        let skin = skin_of(obj(again(change)).expect(name));
        check(&skin, name);
        assert!(
            skin.notes.iter().any(|n| n.starts_with("240 faces that were there before")),
            "{:?}",
            skin.notes
        );
    }
    // As triangles, along this or the other diagonal, and with vertices of their own.
    let cut = |start: usize, faces: &[Vec<u32>]| -> Vec<[u32; 3]> {
        let fan = |f: &Vec<u32>| {
            let f = f.clone();
            let n = f.len();
            (1..n - 1)
                .map(move |i| [f[start % n], f[(start + i) % n], f[(start + i + 1) % n]])
                .collect::<Vec<_>>()
        };
        faces.iter().flat_map(fan).collect()
    };
    for start in [0, 1] {
        let mut triangles = cut(0, &faces);
        triangles.extend(cut(start, &faces).iter().map(|[a, b, c]| [*a, *c, *b]));
        let body = Body { positions: positions.clone(), triangles };
        let folder = Folder::new();
        for (name, bytes) in files::all(&body) {
            folder.write(name, bytes);
            let path = folder.path().join(name);
            let spec = MeshSpec { path: Some(name.into()), units: Some(Units::Cm), ..MeshSpec::default() };
            let skin = load(&spec, &|_| Ok(path.clone())).expect(name);
            check(&skin, name);
            assert!(
                skin.notes.iter().any(|n| n == &format!("{once} duplicate triangles dropped")),
                "{:?}",
                skin.notes
            );
        }
    }
    // Quads, and the same again as triangles along the other diagonal.
    let mixed: Vec<Vec<u32>> =
        faces.iter().cloned().chain(cut(1, &faces).iter().map(|t| t.to_vec())).collect();
    check(&skin_of(obj(obj_text(&positions, &mixed)).expect("mixed")), "mixed");
    // A tetrahedron and two quads that share three corners are what they are.
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    assert_eq!(skin_of(obj(tetrahedron).expect("tetrahedron")).triangles.len(), 4);
}

#[test]
fn open_parts_are_turned_outwards() {
    let (positions, faces) = ball();
    let above = |f: &Vec<u32>, height: f32| f.iter().all(|i| positions[*i as usize].y < height);
    let reversed = |faces: &[Vec<u32>]| -> Vec<Vec<u32>> {
        faces.iter().map(|f| f.iter().rev().copied().collect()).collect()
    };
    // Inside out, with a hole of more and more of the ball.
    for height in [4.9, 4.0, 2.0, 0.5] {
        let kept: Vec<_> = faces.iter().filter(|f| above(f, height)).cloned().collect();
        let skin = skin_of(obj(obj_text(&positions, &reversed(&kept))).expect("a ball"));
        assert!(outwards(&skin), "{height}");
        assert!(skin.notes.iter().any(|n| n.starts_with("1 open parts turned outwards")), "{:?}", skin.notes);
        let skin = skin_of(obj(obj_text(&positions, &kept)).expect("a ball"));
        assert!(outwards(&skin) && !skin.notes.iter().any(|n| n.contains("turned")), "{:?}", skin.notes);
        // Half of the faces wound the other way.
        let mut mixed = kept.clone();
        mixed.iter_mut().step_by(2).for_each(|f| f.reverse());
        assert!(outwards(&skin_of(obj(obj_text(&positions, &mixed)).expect("a ball"))), "{height}");
    }
    // A shallow dish has no inside: its file says which side is up.
    let dish: Vec<_> = faces.iter().filter(|f| above(f, -3.5)).cloned().collect();
    let skin = skin_of(obj(obj_text(&positions, &reversed(&dish))).expect("a dish"));
    assert!(skin.triangles.len() > 48 && !outwards(&skin));
    assert!(!skin.notes.iter().any(|n| n.contains("turned")), "{:?}", skin.notes);
}

#[test]
fn one_bright_vertex_does_not_change_the_others() {
    let colors = |rows: &[&str]| {
        let vertices: String =
            rows.iter().enumerate().map(|(i, c)| format!("v {i} {} 0 {c}\n", i * i)).collect();
        obj(format!("{vertices}f 1 2 3\n")).expect("colours")
    };
    let mesh = colors(&["0.5 0.5 0.5", "1.0001 0.25 1", "3 0 0"]);
    assert_eq!(mesh.colors, [Vec3::splat(0.5), Vec3::new(1.0, 0.25, 1.0), Vec3::X]);
    assert!(mesh.notes[0].starts_with("2 vertex colours above 1 clamped"), "{:?}", mesh.notes);
    // One value of 2 among ones and zeros is no byte either.
    let mesh = colors(&["1 1 1", "0 1 0", "2 0 0"]);
    assert_eq!(mesh.colors[0], Vec3::ONE);
    assert!(mesh.notes[0].starts_with("1 vertex colours above 1"), "{:?}", mesh.notes);
    let mesh = colors(&["255 0 51", "102 0 0", "300 0 0"]);
    assert_eq!(mesh.colors, [Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.4, 0.0, 0.0), Vec3::X]);
    assert!(mesh.notes[0].contains("0..255, 1 above 255 clamped"), "{:?}", mesh.notes);
}

#[test]
fn zbrush_colours_and_alpha_are_read() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let text = format!(
        "{square}# the colours\r\n#MRGB ff336600ff00FF00\r\n#MRGB 80ffffffff000033\r\nf 4 3 2\nf 4 2 1\n"
    );
    let mesh = obj(&text).expect("MRGB");
    let of = |p: Vec3| mesh.positions.iter().position(|q| *q == p).expect("a vertex");
    assert_eq!(mesh.colors[of(Vec3::ZERO)], Vec3::new(0.2, 0.4, 0.0));
    assert_eq!(mesh.colors[of(Vec3::X)], Vec3::Y);
    assert_eq!(mesh.colors[of(Vec3::Y)], Vec3::new(0.0, 0.0, 0.2));
    assert_eq!(mesh.alphas[of(Vec3::new(1.0, 1.0, 0.0))], 128.0 / 255.0);
    assert!(
        mesh.notes.iter().any(|n| n.starts_with("4 vertex colours read from ZBrush")),
        "{:?}",
        mesh.notes
    );
    let short = obj(format!("{square}#MRGB ff336600\nf 1 2 3 4\n")).expect("one colour");
    assert!(short.notes.iter().any(|n| n.starts_with("3 vertices without an #MRGB")), "{:?}", short.notes);
    for damaged in ["ff33660", "ff33660g"] {
        let message = obj(format!("{square}#MRGB {damaged}\nf 1 2 3\n")).expect_err("damaged").to_string();
        assert!(message.contains("test.obj:5") && message.contains("MMRRGGBB"), "{message}");
    }
    // Alpha, also of a vertex that no face uses; and what a groom reads from it.
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "v 9 9 9 1 1 1 0.1\nv 0 0 0 0.5 1 1 0.25\nv 1 0 0 1 1 1 1\nv 0 1 0 1 1 1 7\nf 2 3 4\n",
    );
    let scene = "[mesh]\npath = \"a.obj\"\n[guard]\nlength = { map = \"vertex_color\", channel = \"a\", value = 2 }\n";
    let path = folder.write("s.toml", scene);
    let (scene, assets) = Scene::load(Path::new(&path), &[]).expect("a scene");
    let world = World::load(scene, &assets).expect("a world");
    assert_eq!(world.skin.alphas, [0.25, 1.0, 1.0]);
    assert!(world.skin.colored && !world.skin.notes.iter().any(|n| n.contains("vertex colours")));
    let packed = pelage_fur::groom::pack(&world).expect("packed");
    let maps = pelage_fur::parameters::Maps { groom: &packed.groom, texels: &packed.texels };
    let at = pelage_fur::parameters::triangle_point(&world.skin, 0, Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(maps.scalar(pelage_fur::parameters::Parameter::GuardLength, &at), 0.5);
    // A mesh without colours is named.
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let (scene, assets) = Scene::load(Path::new(&path), &[]).expect("a scene");
    let notes = World::load(scene, &assets).expect("a world").skin.notes;
    assert!(notes.iter().any(|n| n.contains("a.obj has no vertex colours")), "{notes:?}");
}

#[test]
fn a_mesh_may_stand_in_place_of_a_scene() {
    let folder = Folder::new();
    let (positions, faces) = ball();
    let mut text = obj_text(&positions, &faces);
    text += &"f 1 2 3\n".repeat(6000);
    // A mesh stands for its scene, whatever its name.
    let path = folder.write("my.obj", text);
    pelage(&["check", &path]).expect(0, &["30 cm long"]);
    let path = folder.write("scene", files::stl_binary(&files::cube(1.0)));
    pelage(&["check", &path, "-D", "guard.density=10"]).expect(0, &["STL files do not say which axis is up"]);
    // No list of faults is endless.
    let keys: String = (0..12_011).map(|i| format!("key{i} = 1\n")).collect();
    let path = folder.write("s.toml", format!("{keys}[mesh]\nshape = \"hat\"\n"));
    let error = Scene::load(Path::new(&path), &[]).expect_err("unknown keys");
    let text = error.to_string();
    assert_eq!(text.matches("unknown key").count(), 20, "{text}");
    assert!(text.ends_with("and 11,991 more"), "{text}");
    pelage(&["check", &path]).expect(3, &["key0", "and 11,991 more", "12011 errors"]);
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn no_text_makes_the_reader_panic(
        parts in prop::collection::vec(prop::sample::select(vec![
            "v", "vt", "vn", "f", "l", "o", "g", "usemtl", "mtllib", "#", "\\", "\n", "\n", "\n", "\r", " ", "1", "2", "-1",
            "0", "3/1", "2//1", "1/1/1", "-1/-1", "/", "//", "nan", "1e38", "1e-40", "0.5", "\u{e9}", "4",
        ]), 0..120)
    ) {
        let text = parts.join(" ");
        if let Ok(mesh) = obj(&text) {
            let skin = skin_of(mesh);
            prop_assert!(skin.normals.iter().all(|n| n.is_finite()));
        }
        let text = format!("{TRIANGLE}{text}\nf 1 2 3\n");
        if let Ok(mesh) = obj(&text) {
            skin_of(mesh);
        }
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = obj(&bytes);
    }
}
