//! Lapped patches: properties that hold on any mesh.

use crate::common::shapes::{SHAPES, shape};
use crate::common::{Folder, assets, cases, command, json, pelage, run};
use glam::{DVec2, DVec3, Vec2, Vec3};
use pelage_core::Skin;
use pelage_core::mesh::{self, Mesh};
use pelage_core::scene::{FieldSource, FieldVector, LappedSpec, Scene, Shape};
use pelage_shells::lapped::{Lapped, contains, lap};
use proptest::prelude::*;
use rayon::prelude::*;
use std::collections::BTreeSet;

fn skin(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Skin {
    mesh::skin_of(Mesh { positions, triangles, ..Mesh::default() })
}

fn scene(edit: impl FnOnce(&mut LappedSpec)) -> Scene {
    let mut scene = Scene::default();
    edit(&mut scene.lapped);
    scene
}

fn lap_and_check(skin: &Skin, scene: &Scene, name: &str) -> Lapped {
    let lapped = lap(skin, scene).unwrap_or_else(|e| panic!("{name}: {e}"));
    check(skin, scene, &lapped, name);
    lapped
}

/// The map from a face to uv: u and v for the face's directions `s` and normal × `s`; `None` for a
/// needle.
fn jacobian(corners: [DVec3; 3], uv: &[Vec2; 3], s: DVec3) -> Option<[DVec2; 2]> {
    let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
    let longest = a.length().max(b.length()).max(a.distance(b));
    let n = a.cross(b);
    if n.length() < 2e-5 * longest * longest {
        return None;
    }
    let t = n.normalize().cross(s);
    let uv = uv.map(|p| p.as_dvec2());
    // Barycentric gradients.
    let (ga, gb) = (b.cross(n) / n.length_squared(), n.cross(a) / n.length_squared());
    let along = |d: DVec3| (uv[1] - uv[0]) * ga.dot(d) + (uv[2] - uv[0]) * gb.dot(d);
    Some([along(s), along(t)])
}

/// Checks the properties that hold for any skin and any settings.
fn check(skin: &Skin, scene: &Scene, lapped: &Lapped, name: &str) {
    let (faces, spec) = (skin.triangles.len(), &scene.lapped);
    assert_eq!([lapped.field.len(), lapped.topmost.len(), lapped.corner_uv.len()], [faces; 3], "{name}");
    assert!((lapped.coverage - 1.0).abs() < 1e-12, "{name}: coverage {}", lapped.coverage);
    let corners = |f: u32| skin.corners(f as usize).map(|p| p.as_dvec3());
    for f in 0..faces as u32 {
        let d = lapped.field[f as usize].as_dvec3();
        assert!((d.length() - 1.0).abs() < 1e-5, "{name}: face {f} has the direction {d}");
        let [a, b, c] = corners(f);
        let n = (b - a).cross(c - a).normalize_or_zero();
        let needle = jacobian(corners(f), &[Vec2::ZERO; 3], d).is_none();
        assert!(needle || d.dot(n).abs() < 1e-5, "{name}: {d} leaves face {f}");
    }
    let mut holds = vec![Vec::new(); faces];
    for (p, patch) in lapped.patches.iter().enumerate() {
        assert_eq!(patch.faces.len(), patch.corner_uv.len(), "{name}");
        assert_eq!(patch.outline.is_empty(), !spec.overlapping, "{name}");
        for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
            holds[*f as usize].push((p as u32, *uv));
            let [a, b, c] = uv.map(|p| p.as_dvec2());
            assert!((b - a).perp_dot(c - a) > 0.0, "{name}: face {f} of patch {p} is flipped: {uv:?}");
            let Some([s, t]) = jacobian(corners(*f), uv, lapped.field[*f as usize].as_dvec3()) else {
                continue;
            };
            let (sum, det) = (s.length_squared() + t.length_squared(), s.perp_dot(t));
            let most = (0.5 * (sum + (sum * sum - 4.0 * det * det).max(0.0).sqrt())).sqrt();
            let least = det / most;
            assert!(most < 2.01 && least > 0.497 && det > 0.497 && det < 2.01, "{name}: {most} {least}");
            let angle = s.y.atan2(s.x).to_degrees();
            assert!(!spec.aligned || angle.abs() < 45.1, "{name}: face {f} is {angle}° off");
        }
        if !spec.overlapping {
            check_disc(skin, &patch.faces, &format!("{name}: patch {p}"));
        }
    }
    let shown: BTreeSet<_> = lapped.topmost.iter().collect();
    assert!(spec.overlapping || shown.len() == lapped.patches.len(), "{name}: a patch is hidden");
    for (f, holds) in holds.iter().enumerate() {
        let shown = holds.iter().find(|(p, _)| *p == lapped.topmost[f]);
        let (_, uv) = shown.unwrap_or_else(|| panic!("{name}: face {f} is bare"));
        assert_eq!(*uv, lapped.corner_uv[f], "{name}");
        if !spec.overlapping {
            assert_eq!(Some(lapped.topmost[f]), holds.last().map(|(p, _)| *p), "{name}: the last one shows");
            continue;
        }
        for i in 0..12_u32 {
            let (mut s, mut t) = ((i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / 12.0);
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let covers = |(p, uv): &(u32, [Vec2; 3])| {
                let at = uv[0] + (uv[1] - uv[0]) * s + (uv[2] - uv[0]) * t;
                contains(&lapped.patches[*p as usize].outline, at)
            };
            assert!(holds.iter().any(covers), "{name}: face {f} is bare at {s}, {t}");
        }
    }
}

/// Connected over edges, and vertices - edges + faces = 1.
fn check_disc(skin: &Skin, faces: &[u32], name: &str) {
    let mut vertices = Vec::new();
    let mut sides = Vec::new();
    for (i, f) in faces.iter().enumerate() {
        let v = skin.triangles[*f as usize];
        vertices.extend(v);
        sides.extend([0, 1, 2].map(|k| (v[k].min(v[(k + 1) % 3]), v[k].max(v[(k + 1) % 3]), i)));
    }
    vertices.sort_unstable();
    vertices.dedup();
    sides.sort_unstable();
    let edges: Vec<_> = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
    assert_eq!(vertices.len() + faces.len(), edges.len() + 1, "{name} is no disc");
    assert!(edges.iter().all(|e| e.len() <= 2), "{name} branches");
    // In the order of growth each face touches an earlier one.
    let mut joined = vec![false; faces.len()];
    edges.iter().filter(|e| e.len() == 2).for_each(|e| joined[e[1].2] = true);
    assert!(joined.iter().skip(1).all(|j| *j), "{name} is not connected");
}

#[test]
fn every_shape_is_covered_with_all_settings() {
    SHAPES.into_par_iter().for_each(|which| {
        let skin = shape(which);
        let scenes = [
            scene(|_| ()),
            scene(|s| (s.overlapping, s.irregularity) = (true, 0.6)),
            scene(|s| (s.aligned, s.irregularity) = (false, 0.0)),
            scene(|s| s.field = FieldSource::Gravity),
        ];
        for (i, scene) in scenes.iter().enumerate() {
            lap_and_check(&skin, scene, &format!("{which:?}, scene {i}"));
        }
    });
}

#[test]
fn flat_and_rolled_skins_are_flattened_without_stretch() {
    for which in [Shape::Plane, Shape::CylinderPelt] {
        for overlapping in [false, true] {
            let skin = shape(which);
            let lapped = lap_and_check(&skin, &scene(|s| s.overlapping = overlapping), "flat");
            let s = lapped.statistics(&skin).unwrap();
            assert!(s.worst_stretch < 1.002, "{which:?}: {}", s.worst_stretch);
            assert!(s.worst_angle_error.unwrap() < 0.1, "{which:?}: {s:?}");
        }
    }
}

#[test]
fn a_torus_needs_no_singular_point() {
    let skin = shape(Shape::Torus);
    let s = lap_and_check(&skin, &scene(|_| ()), "torus").statistics(&skin).unwrap();
    assert!(s.worst_angle_error.unwrap() < 15.0 && s.worst_stretch < 1.4, "{s:?}");
    assert_eq!((s.flipped, s.faces, s.coverage), (0, 5120, 1.0));
    assert!(s.mean_stretch >= 1.0 && s.mean_stretch < 1.1 && s.layers > 1.0, "{s:?}");
}

#[test]
fn smaller_outlines_make_more_patches_and_longer_seams() {
    let skin = shape(Shape::Sphere);
    let of = |radius| {
        let s =
            lap_and_check(&skin, &scene(|s| s.radius = Some(radius)), "sphere").statistics(&skin).unwrap();
        (s.patches, s.seam_length)
    };
    let (coarse, fine) = (of(2.0), of(0.6));
    assert!(fine.0 > 3 * coarse.0 && fine.1 > 2.0 * coarse.1, "{coarse:?} {fine:?}");
    // Larger than the skin, and smaller than its faces.
    assert!(of(100.0).0 < 20);
    assert_eq!(of(1e-4).0, 4800);
}

#[test]
fn isotropic_patches_are_turned_at_random() {
    let skin = shape(Shape::Plane);
    let turns = |aligned| {
        let lapped = lap_and_check(&skin, &scene(|s| s.aligned = aligned), "plane");
        let turn = |(patch, p): (&pelage_shells::lapped::Patch, usize)| {
            let f = patch.faces[p] as usize;
            let corners = skin.corners(f).map(|p| p.as_dvec3());
            jacobian(corners, &patch.corner_uv[p], lapped.field[f].as_dvec3()).unwrap()[0].normalize()
        };
        let mean = lapped.patches.iter().map(|p| turn((p, 0))).sum::<DVec2>() / lapped.patches.len() as f64;
        assert_eq!(lapped.statistics(&skin).unwrap().mean_angle_error.is_some(), aligned);
        mean.length()
    };
    assert!(turns(true) > 0.999);
    assert!(turns(false) < 0.25);
}

#[test]
fn parts_isolated_faces_and_needles_are_covered() {
    let mut ball = shape(Shape::Sphere);
    let moved: Vec<Vec3> = ball.positions.iter().map(|p| *p * 0.3 + Vec3::X * 20.0).collect();
    let first = ball.positions.len() as u32;
    let copy: Vec<_> = ball.triangles.iter().map(|t| t.map(|v| v + first)).collect();
    ball.positions.extend(moved);
    ball.normals.extend_from_within(..);
    ball.colors.extend_from_within(..);
    ball.triangles.extend(copy);
    for overlapping in [false, true] {
        lap_and_check(&ball, &scene(|s| s.overlapping = overlapping), "two balls");
        // Isolated triangles of all thicknesses down to 0.
        let mut needles = Skin::default();
        for i in 0..24 {
            let (y, thin) = (Vec3::Y * i as f32, 10.0_f32.powi(-i));
            let first = needles.positions.len() as u32;
            needles.positions.extend([
                y,
                y + Vec3::X,
                y + Vec3::new(0.3, 0.0, if i == 23 { 0.0 } else { thin }),
            ]);
            needles.normals.extend([Vec3::NEG_Y; 3]);
            needles.triangles.push([first, first + 1, first + 2]);
        }
        let lapped = lap_and_check(&needles, &scene(|s| s.overlapping = overlapping), "needles");
        let s = lapped.statistics(&needles).unwrap();
        assert!(s.needles > 10 && s.flipped == 0, "{s:?}");
    }
}

proptest! {
    #![proptest_config(cases(64))]

    /// Soups: faces that cross, share edges with many others, and are of any thickness.
    #[test]
    fn any_soup_is_covered(
        points in prop::collection::vec((-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0), 3..14),
        picks in prop::collection::vec((0_u32..14, 0_u32..14, 0_u32..14), 1..40),
        flat in 0_u32..4,
        size in -3_i32..4,
        far in prop::bool::ANY,
        radius in prop::option::of(0.2_f32..3.0),
        flags in (prop::bool::ANY, prop::bool::ANY, prop::bool::ANY),
    ) {
        let size = 10_f32.powi(size);
        let away = if far { Vec3::splat(300.0 * size) } else { Vec3::ZERO };
        let depth = 10_f32.powi(-2 * flat as i32);
        let positions: Vec<_> =
            points.iter().map(|(x, y, z)| Vec3::new(*x, *y, *z * depth) * size + away).collect();
        let n = positions.len() as u32;
        let skin = skin(positions, picks.iter().map(|(a, b, c)| [a % n, b % n, c % n]).collect());
        prop_assume!(skin.area() > 0.0);
        let (overlapping, aligned, gravity) = flags;
        let field = if gravity { FieldSource::Gravity } else { FieldSource::Auto };
        let scene = scene(|s| {
            *s = LappedSpec { radius: radius.map(|r| r * size), overlapping, aligned, field, ..s.clone() }
        });
        lap_and_check(&skin, &scene, "soup");
    }

    /// Rough heights over a grid with holes.
    #[test]
    fn any_landscape_is_covered(
        heights in prop::collection::vec(-1.0_f32..1.0, 81),
        holes in prop::collection::vec(0_usize..128, 0..30),
        steep in 0.0_f32..2.0,
        overlapping in prop::bool::ANY,
    ) {
        let at = |i: usize| Vec3::new((i % 9) as f32, heights[i] * steep, (i / 9) as f32);
        let quads = (0..64).map(|q| (q % 8 + q / 8 * 9) as u32);
        let halves = quads.flat_map(|q| [[q, q + 9, q + 1], [q + 1, q + 9, q + 10]]);
        let triangles = halves.enumerate().filter(|(i, _)| !holes.contains(i)).map(|(_, t)| t).collect();
        let skin = skin((0..81).map(at).collect(), triangles);
        lap_and_check(&skin, &scene(|s| (s.overlapping, s.radius) = (overlapping, Some(2.0))), "landscape");
    }
}

#[test]
fn every_mesh_of_the_assets_is_covered() {
    let Some(folder) = assets() else { return };
    let mut paths: Vec<_> =
        std::fs::read_dir(folder.join("meshes")).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "obj"));
    paths.sort();
    assert!(!paths.is_empty());
    paths.par_iter().for_each(|path| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let skin = mesh::skin_of(mesh::obj::read(path).unwrap());
        let lapped = lap_and_check(&skin, &scene(|_| ()), &name);
        let patches = lapped.patches.len();
        eprintln!("{name}: {patches} patches on {} faces, {:.0} ms", skin.triangles.len(), lapped.time_ms);
        // 306 in the paper's Table 1.
        assert!(name != "bunny-5k.obj" || (230..400).contains(&patches), "{patches}");
        if skin.triangles.len() < 2000 {
            lap_and_check(&skin, &scene(|s| s.overlapping = true), &name);
            lap_and_check(&skin, &scene(|s| (s.aligned, s.field) = (false, FieldSource::Gravity)), &name);
        }
    });
}

#[test]
fn gravity_and_comb_follow_their_direction() {
    let skin = shape(Shape::Sphere);
    let mut comb = scene(|s| s.field = FieldSource::Groom);
    comb.guard.comb_direction = [0.0, -3.0, 0.0];
    let gravity = lap_and_check(&skin, &scene(|s| s.field = FieldSource::Gravity), "gravity");
    let combed = lap_and_check(&skin, &comb, "comb");
    for f in 0..skin.triangles.len() {
        let [a, b, c] = skin.corners(f);
        let n = (b - a).cross(c - a).normalize();
        let down = (Vec3::NEG_Y + n * n.y).normalize();
        assert!(n.y.abs() > 0.9 || gravity.field[f].dot(down) > 0.99, "{f}: {}", gravity.field[f]);
        assert!(combed.field[f].distance(gravity.field[f]) < 1e-5);
    }
    // On a level skin no direction points down; it is covered nevertheless.
    lap_and_check(&shape(Shape::Plane), &scene(|s| s.field = FieldSource::Gravity), "level");
}

fn vector(at: [f32; 3], direction: [f32; 3]) -> FieldVector {
    FieldVector { at, direction }
}

#[test]
fn vectors_are_interpolated() {
    let skin = shape(Shape::Plane);
    let ends = [vector([-4.9, 0.0, 0.0], [1.0, 0.4, 0.0]), vector([4.9, 0.0, 0.0], [0.0, 0.0, -1.0])];
    let lapped = lap_and_check(
        &skin,
        &scene(|s| (s.field, s.vectors) = (FieldSource::Vectors, ends.to_vec())),
        "plane with two vectors",
    );
    let nearest = |at: Vec3| {
        let center = |f: usize| skin.corners(f).iter().sum::<Vec3>() / 3.0;
        let distance = |f: &usize| center(*f).distance_squared(at);
        let f = (0..skin.triangles.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let d = lapped.field[f];
        (-d.z).atan2(d.x).to_degrees()
    };
    let [first, middle, last] = [-4.9, 0.0, 4.9].map(|x| nearest(Vec3::X * x));
    assert!(first.abs() < 3.0 && (middle - 45.0).abs() < 5.0 && (last - 90.0).abs() < 3.0);

    // A part without a vector has its smoothest field.
    let mut two = shape(Shape::Torus);
    let count = two.positions.len() as u32;
    two.positions.extend_from_within(..);
    two.positions[count as usize..].iter_mut().for_each(|p| p.y += 10.0);
    two.normals.extend_from_within(..);
    let copy: Vec<_> = two.triangles.iter().map(|t| t.map(|v| v + count)).collect();
    two.triangles.extend(copy);
    let one = vec![vector([7.0, 0.0, 0.0], [0.0, 1.0, 0.0])];
    lap_and_check(&two, &scene(|s| (s.field, s.vectors) = (FieldSource::Vectors, one)), "two tori");
}

#[test]
fn meaningless_settings_are_errors() {
    let sphere = shape(Shape::Sphere);
    let fault = |skin: &Skin, scene: &Scene, parts: &[&str]| {
        let e = lap(skin, scene).map(|_| "patches").unwrap_err();
        assert_eq!(e.exit_code(), 3);
        parts.iter().for_each(|p| assert!(e.to_string().contains(p), "no {p:?} in {e}"));
    };
    fault(&Skin::default(), &scene(|_| ()), &["no faces"]);
    fault(&sphere, &scene(|s| s.field = FieldSource::Groom), &["guard.comb_direction", "not zero"]);
    fault(&sphere, &scene(|s| s.field = FieldSource::Vectors), &["lapped.vectors", "at least one"]);
    let vectors = |v: FieldVector| {
        scene(|s| {
            let fine = vector([5.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
            (s.field, s.vectors) = (FieldSource::Vectors, vec![fine, v]);
        })
    };
    fault(&sphere, &vectors(vector([0.0, 5.0, 0.0], [0.0; 3])), &["lapped.vectors.1", "not zero"]);
    fault(&sphere, &vectors(vector([0.0, 5.0, 0.0], [f32::NAN, 0.0, 1.0])), &["lapped.vectors.1", "finite"]);
    fault(&sphere, &vectors(vector([f32::INFINITY; 3], [1.0; 3])), &["lapped.vectors.1", "at ="]);
    let upright = vectors(vector([0.0, 5.0, 0.0], [0.0, 2.0, 0.0]));
    fault(&shape(Shape::Plane), &upright, &["lapped.vectors.1", "perpendicular"]);
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        fault(&sphere, &scene(|s| s.radius = Some(radius)), &["lapped.radius", "above 0"]);
    }
    fault(&sphere, &scene(|s| s.irregularity = 1.5), &["lapped.irregularity", "0..0.9"]);
    fault(
        &sphere,
        &scene(|s| (s.radius, s.overlapping) = (Some(1e-4), true)),
        &["lapped.radius", "too small", "raise it"],
    );
}

#[test]
fn a_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    let scene = folder.write("s.toml", "[mesh]\nshape = 'die'\n");
    let files = |name: &str, more: &[&str]| {
        let out = folder.at(name);
        pelage(&[&["lapped", &scene, "-o", &out, "-q"], more].concat()).expect(0, &[]);
        ["patches.obj", "patches.png", "field.png"].map(|f| std::fs::read(format!("{out}/{f}")).unwrap())
    };
    let one = files("one", &["--threads", "1"]);
    assert!(one == files("two", &["--threads", "3"]), "threads change the result");
    let skin = shape(Shape::Die);
    let of_seed = |seed| {
        let mut scene = Scene::default();
        scene.render.seed = seed;
        lap(&skin, &scene).unwrap().topmost
    };
    assert!(of_seed(5) == of_seed(5) && of_seed(5) != of_seed(6), "the seed changes nothing");
}

#[test]
fn the_command_writes_patches_pictures_and_statistics() {
    let folder = Folder::new();
    // A tetrahedron; its file extension makes it a mesh.
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let path = folder.write("tetra.OBJ", mesh);
    let out = folder.at("made/here");
    let run = pelage(&["lapped", &path, "-o", &out]).expect(0, &[]);
    for part in ["faces        4\n", "patches", "coverage     100.00%", "flipped      0\n"] {
        assert!(run.out.contains(part), "no {part:?} in {}", run.out);
    }
    let record = json(format!("{out}/lapped.json"));
    let s = &record["statistics"];
    assert_eq!(
        (s["coverage"].as_f64(), s["flipped"].as_u64(), s["faces"].as_u64()),
        (Some(1.0), Some(0), Some(4))
    );
    for key in
        ["mean_stretch", "worst_stretch", "mean_angle_error", "worst_angle_error", "seam_length", "time_ms"]
    {
        assert!(s[key].is_f64(), "{key} in {s}");
    }
    for picture in ["patches.png", "field.png"] {
        let image = image::open(format!("{out}/{picture}")).unwrap().to_rgb8();
        assert!(image.width().max(image.height()) == 960);
        assert!(image.pixels().filter(|p| p.0 != [255; 3]).count() > 100_000, "{picture} is empty");
    }
    let written = mesh::obj::read(std::path::Path::new(&format!("{out}/patches.obj"))).unwrap();
    assert_eq!((written.triangles.len(), written.positions.len()), (4, 4));
    assert!(written.corner_uv.is_some_and(|uv| uv.len() == 4));

    let args = ["lapped", &path, "-o", &out, "-q", "--overlapping", "--isotropic", "--radius", "0.3"];
    let more = ["--field", "gravity", "--irregularity", "0.1", "-D", "mesh.size=2"];
    let run = pelage(&[&args[..], &more].concat()).expect(0, &[]);
    assert!(run.out.is_empty() && run.err.is_empty(), "{run:?}");
    let record = json(format!("{out}/lapped.json"));
    assert_eq!(record["lapped"]["overlapping"], true);
    assert_eq!(record["lapped"]["field"], "gravity");
    assert!(record["statistics"]["mean_angle_error"].is_null());
    let text = std::fs::read_to_string(format!("{out}/patches.obj")).unwrap();
    let groups = text.lines().filter(|l| l.starts_with("g ")).count();
    assert_eq!(record["statistics"]["patches"], groups);
}

#[test]
fn errors_of_the_command_are_readable() {
    let folder = Folder::new();
    let out = folder.at("out");
    let bare = folder.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    let fine = folder.write("fine.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let vectors =
        "[mesh]\nshape = 'sphere'\n[lapped]\nfield = 'vectors'\n[[lapped.vectors]]\nat = [0, 5, 0]\n";
    let zero = folder.write("zero.toml", format!("{vectors}direction = [0, 0, 0]\n"));
    let fails = |args: &[&str], code, parts: &[&str]| {
        pelage(&[&["lapped", "-o", &out], args].concat()).expect(code, parts);
    };
    fails(&[&bare], 3, &["bare.obj", "no "]);
    fails(&[&folder.at("none.obj")], 3, &["none.obj", "not there"]);
    fails(&[&folder.at("none.toml")], 3, &["none.toml"]);
    fails(&[&zero], 3, &["lapped.vectors.0", "not zero"]);
    fails(&[&fine, "--wavy"], 2, &["--wavy"]);
    fails(&[&fine, "--field", "north"], 2, &["north", "gravity"]);
    fails(&[&fine, "--radius", "wide"], 2, &["wide"]);
    fails(&[&fine, "--radius", "0"], 3, &["lapped.radius"]);
    fails(&[&fine, "--irregularity", "2"], 3, &["lapped.irregularity"]);
    let uncombed = folder.write("uncombed.toml", "[mesh]\nshape = 'sphere'\n");
    fails(&[&uncombed, "--field", "groom"], 3, &["guard.comb_direction"]);
    fails(&[&fine, "-D", "lapped.radios=2"], 3, &["radios", "radius"]);
    fails(&[&fine, "-D", "no_value"], 2, &["key.path=value"]);
    pelage(&["lapped", &fine]).expect(2, &["--outfile"]);
    pelage(&["lapped", "-o", &out]).expect(2, &["SCENE|MESH"]);
    let taken = folder.write("taken", "");
    pelage(&["lapped", &fine, "-o", &taken]).expect(1, &["taken", "cannot be created"]);
    let mut here = command();
    here.current_dir(folder.path()).args(["lapped", "fine.obj", "-o", "out"]);
    run(&mut here).expect(0, &[]);
}
