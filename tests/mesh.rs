//! Shapes, skins, neighbours: properties of loaded meshes.

use crate::common::shapes::{SHAPES, no_file, shape};
use crate::common::{assets, cases};
use glam::{Vec2, Vec3};
use pelage_core::Skin;
use pelage_core::mesh::topology::{Topology, boundary_edges, edge_key, neighbours};
use pelage_core::mesh::{Mesh, load, skin_of, write_obj};
use pelage_core::scene::{MeshSpec, Shape};
use pelage_core::skin::NONE;
use proptest::prelude::*;
use std::collections::HashMap;

fn volume(skin: &Skin) -> f64 {
    let volume = |t: usize| {
        let [a, b, c] = skin.corners(t).map(Vec3::as_dvec3);
        a.dot(b.cross(c)) / 6.0
    };
    (0..skin.triangles.len()).map(volume).sum()
}

/// Checks the properties that hold for every skin.
fn check_skin(skin: &Skin, name: &str) -> Topology {
    assert_eq!(skin.positions.len(), skin.normals.len(), "{name}");
    assert_eq!(skin.positions.len(), skin.colors.len(), "{name}");
    for n in &skin.normals {
        assert!((n.length() - 1.0).abs() < 1e-4, "{name}: normal {n}");
    }
    let mut used = vec![false; skin.positions.len()];
    for (t, corners) in skin.triangles.iter().enumerate() {
        corners.iter().for_each(|i| used[*i as usize] = true);
        assert!(skin.triangle_area(t) > 0.0, "{name}: triangle {t}");
    }
    assert!(used.iter().all(|u| *u), "{name}: unused vertices");
    if let Some(uv) = &skin.corner_uv {
        assert_eq!(uv.len(), skin.triangles.len(), "{name}");
    }
    let topology = neighbours(&skin.triangles);
    check_symmetry(&skin.triangles, &topology);
    topology
}

fn check_symmetry(triangles: &[[u32; 3]], topology: &Topology) {
    for (t, sides) in topology.neighbours.iter().enumerate() {
        for (k, other) in sides.iter().enumerate().filter(|(_, n)| **n != NONE) {
            let edge = |t: usize, k: usize| (triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
            let (a, b) = edge(t, k);
            let back: Vec<usize> = (0..3).filter(|j| edge(*other as usize, *j) == (b, a)).collect();
            assert_eq!(back.len(), 1);
            assert_eq!(topology.neighbours[*other as usize][back[0]], t as u32);
        }
    }
}

#[test]
fn shapes_have_their_counts_areas_and_borders() {
    // Shape, triangles, boundary edges, area (cm²), volume (cm³), largest side (cm).
    let rows = [
        (Shape::CylinderPelt, 3584, 2 * (64 + 28), Some((190.0, 1e-4)), None, 10.35),
        (Shape::Hat, 5632, 64, None, None, 22.0),
        (Shape::Sphere, 4800, 0, Some((314.16, 2e-3)), Some((523.6, 3e-3)), 10.0),
        (Shape::Plane, 2048, 4 * 32, Some((100.0, 1e-5)), None, 10.0),
        (Shape::Disc, 2048, 4 * 32, Some((78.54, 3e-3)), None, 10.0),
        (Shape::Cube, 768, 0, Some((600.0, 1e-5)), Some((1000.0, 1e-5)), 10.0),
        (Shape::Cylinder, 7488, 0, Some((69.115, 3e-3)), Some((31.416, 3e-3)), 10.0),
        (Shape::Torus, 5120, 0, Some((394.8, 3e-3)), Some((394.8, 1e-2)), 14.0),
        (Shape::Pyramid, 1536, 0, Some((288.68, 1e-4)), Some((800.0 / 3.0, 1e-4)), 10.0),
        (Shape::Die, 4800, 0, None, None, 8.0),
        (Shape::Critter, 6836, 0, None, None, 20.0),
    ];
    for (which, triangles, boundary, area, enclosed, side) in rows {
        let name = format!("{which:?}");
        let skin = shape(which);
        let topology = check_skin(&skin, &name);
        // The critter's count depends on float rounding; the others are exact.
        match which {
            Shape::Critter => {
                assert!((6000..=10000).contains(&skin.triangles.len()), "{}", skin.triangles.len())
            }
            _ => assert_eq!(skin.triangles.len(), triangles, "{name}"),
        }
        assert_eq!(topology.boundary_edges, boundary, "{name}");
        assert_eq!((topology.non_manifold_edges, topology.inconsistent_edges), (0, 0), "{name}");
        assert_eq!(boundary_edges(&topology).len(), boundary, "{name}");
        // Every edge has two sides but for the boundary's: B = 2E - 3F.
        assert_eq!(boundary, 2 * topology.edges - 3 * skin.triangles.len(), "{name}");
        let close = |found: f64, (wanted, part): (f64, f64)| (found - wanted).abs() <= wanted * part;
        assert!(area.is_none_or(|a| close(skin.area(), a)), "{name}: area {}", skin.area());
        if boundary == 0 {
            let genus_zero = skin.positions.len() + skin.triangles.len() - topology.edges;
            assert_eq!(genus_zero, if which == Shape::Torus { 0 } else { 2 }, "{name}: Euler characteristic");
            assert!(volume(&skin) > 0.0, "{name}: inside out");
            assert!(enclosed.is_none_or(|v| close(volume(&skin), v)), "{name}: volume {}", volume(&skin));
        }
        let (low, high) = skin.bounds();
        assert!(((high - low).max_element() - side).abs() < 0.02, "{name}: {low} to {high}");
        assert!((low + high).abs().max_element() < 1e-4, "{name}: not centred");
        assert!(skin.corner_uv.is_some() && skin.notes.is_empty(), "{name}: {:?}", skin.notes);
    }
}

#[test]
fn open_shapes_face_outwards() {
    for n in &shape(Shape::Plane).normals {
        assert!(n.distance(Vec3::Y) < 1e-6);
    }
    let pelt = shape(Shape::CylinderPelt);
    let (_, high) = pelt.bounds();
    let hat = shape(Shape::Hat);
    for (p, n) in pelt.positions.iter().zip(&pelt.normals).filter(|(p, _)| p.y > high.y - 1.0) {
        assert!(n.y > 0.5, "{p} {n}");
    }
    for (p, n) in hat.positions.iter().zip(&hat.normals) {
        let radius = Vec2::new(p.x, p.z).length();
        if radius < 5.0 {
            assert!(n.y > 0.5, "crown at {p}: {n}");
        } else if radius > 10.95 {
            assert!(n.x * p.x + n.z * p.z > 0.9 * radius, "brim at {p}: {n}");
        }
    }
}

#[test]
fn shapes_have_no_slivers_and_even_uv() {
    for which in SHAPES {
        let skin = shape(which);
        let (mut total, mut even) = (0.0, 0.0);
        for (t, uv) in skin.corner_uv.iter().flatten().enumerate() {
            let [a, b, c] = skin.corners(t);
            let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
            let quality = 4.0 * 3.0_f32.sqrt() * skin.triangle_area(t) / squares;
            assert!(quality > 0.3, "{which:?}: triangle {t} has quality {quality}");
            // A uv unit is 10 cm long, 100 cm² large.
            let covered = 50.0 * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
            total += 1.0;
            even += f32::from(u8::from((0.4..2.0).contains(&(covered / skin.triangle_area(t)))));
        }
        assert!(even / total > 0.9, "{which:?}: uv even on {even} of {total}");
    }
}

#[test]
fn transforms_apply_in_order() {
    let spec = MeshSpec {
        shape: Some(Shape::Plane),
        size: Some(4.0),
        scale: Some(2.0),
        // Facing +y, then +z after x by 90 degrees, then +x after y by 90 degrees.
        rotate: [90.0, 90.0, 0.0],
        translate: [1.0, 2.0, 3.0],
        center: true,
        ..MeshSpec::default()
    };
    let skin = load(&spec, &no_file).expect("loads");
    let (low, high) = skin.bounds();
    assert!(low.distance(Vec3::new(1.0, -2.0, -1.0)) < 1e-5, "{low}");
    assert!(high.distance(Vec3::new(1.0, 6.0, 7.0)) < 1e-5, "{high}");
    assert!(skin.normals.iter().all(|n| n.distance(Vec3::X) < 1e-5));

    for (spec, wanted) in [
        (MeshSpec { size: Some(0.0), shape: Some(Shape::Die), ..MeshSpec::default() }, "mesh.size = 0"),
        (MeshSpec { scale: Some(-1.0), shape: Some(Shape::Die), ..MeshSpec::default() }, "mesh.scale = -1"),
        (MeshSpec { rotate: [f32::NAN; 3], shape: Some(Shape::Die), ..MeshSpec::default() }, "mesh.rotate"),
        (MeshSpec { size: Some(1e20), shape: Some(Shape::Die), ..MeshSpec::default() }, "at most 1e8"),
        (MeshSpec::default(), "neither mesh.path nor mesh.shape"),
        (
            MeshSpec { path: Some("a".into()), shape: Some(Shape::Die), ..MeshSpec::default() },
            "both mesh.path",
        ),
    ] {
        let error = load(&spec, &no_file).expect_err(wanted);
        assert!(error.to_string().contains(wanted), "{error}");
        assert_eq!(error.exit_code(), 3);
    }
}

#[test]
fn winding_is_made_consistent_and_outward() {
    let good = shape(Shape::Die);
    let inside_out = |turned: fn(usize) -> bool| {
        let mut mesh = Mesh {
            positions: good.positions.clone(),
            triangles: good.triangles.clone(),
            corner_uv: good.corner_uv.clone(),
            ..Mesh::default()
        };
        for t in (0..mesh.triangles.len()).filter(|t| turned(*t)) {
            mesh.triangles[t].swap(1, 2);
            mesh.corner_uv.as_mut().expect("has uv")[t].swap(1, 2);
        }
        skin_of(mesh)
    };
    for turned in [(|_| true) as fn(usize) -> bool, |t| t % 3 == 0, |t| t == 7] {
        let skin = inside_out(turned);
        let sorted = |skin: &Skin| {
            // Corners rotate with the vertex that was not swapped; compare as cycles from the
            // smallest.
            skin.triangles
                .iter()
                .map(|t| {
                    let k = (0..3).min_by_key(|k| t[*k]).unwrap_or(0);
                    [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(sorted(&skin), sorted(&good));
        assert!(skin.notes.iter().any(|n| n.contains("turned over")), "{:?}", skin.notes);
    }
    // A Möbius band cannot be wound consistently: one seam of opposite winding remains, as a
    // boundary.
    let n = 20;
    let at = |i: u32, s: f32| {
        let a = std::f32::consts::TAU * i as f32 / n as f32;
        let r = 3.0 + s * (a / 2.0).cos();
        Vec3::new(r * a.cos(), s * (a / 2.0).sin(), r * a.sin())
    };
    let mut mesh = Mesh::default();
    for i in 0..n {
        mesh.positions.extend([at(i, -1.0), at(i, 1.0)]);
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < n { (a + 2, a + 3) } else { (1, 0) };
        mesh.triangles.extend([[a, b, c], [b, d, c]]);
    }
    let skin = skin_of(mesh);
    let topology = check_skin(&skin, "Möbius band");
    assert_eq!((topology.inconsistent_edges, topology.boundary_edges), (1, 2 * n as usize));
}

#[test]
fn repairs_are_counted() {
    let p = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let mesh = Mesh {
        positions: vec![
            p(0.0, 0.0),
            p(1.0, 0.0),
            p(0.0, 1.0),
            p(-0.0, 0.0),
            p(1.0, 1.0),
            p(5.0, 5.0),
            p(0.5, 0.5),
        ],
        triangles: vec![
            [0, 1, 2],
            [1, 4, 2],
            [3, 1, 2],  // the first one again, through a vertex at the same place
            [1, 6, 2],  // no area
            [0, 0, 1],  // no area
            [0, 1, 99], // no such vertex
        ],
        ..Mesh::default()
    };
    let skin = skin_of(mesh);
    check_skin(&skin, "repaired");
    assert_eq!((skin.triangles.len(), skin.positions.len()), (2, 4));
    for wanted in [
        "1 triangles without three finite corners dropped",
        "1 vertices welded",
        "2 zero-area triangles dropped",
        "1 duplicate triangles dropped",
        "4 boundary edges",
    ] {
        assert!(skin.notes.iter().any(|n| n.starts_with(wanted)), "{wanted}: {:?}", skin.notes);
    }
    // Three triangles on one edge: a boundary for each of them.
    let fin = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z],
        triangles: vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]],
        ..Mesh::default()
    };
    let skin = skin_of(fin);
    assert_eq!(check_skin(&skin, "fin").non_manifold_edges, 1);
    assert!(skin.notes.iter().any(|n| n.starts_with("1 non-manifold edges")), "{:?}", skin.notes);
    // A sheet folded flat: normals cancel, and still none is NaN.
    let fold = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.3, 0.3, 0.0)],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        ..Mesh::default()
    };
    check_skin(&skin_of(fold), "fold");
    assert!(skin_of(Mesh::default()).triangles.is_empty());
}

/// Triangles with three different corners of a few vertices: every kind of fault turns up.
fn soups() -> impl Strategy<Value = Vec<[u32; 3]>> {
    let triangle = (0..12_u32, 1..12_u32, 1..11_u32).prop_map(|(a, b, c)| {
        let b = (a + b) % 12;
        let c = (0..12).filter(|i| *i != a && *i != b).nth(c as usize % 10).unwrap_or(0);
        [a, b, c]
    });
    prop::collection::vec(triangle, 0..60)
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn neighbours_are_symmetric_and_follow_the_keys(triangles in soups()) {
        let topology = neighbours(&triangles);
        check_symmetry(&triangles, &topology);
        // The definition, literally.
        let mut owners: HashMap<u64, Vec<u32>> = HashMap::new();
        for (t, v) in triangles.iter().enumerate() {
            for k in 0..3 {
                owners.entry(edge_key(v[(k + 1) % 3], v[(k + 2) % 3])).or_default().push(t as u32);
            }
        }
        for (t, v) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (v[(k + 1) % 3], v[(k + 2) % 3]);
                let found = match (&owners[&edge_key(a, b)][..], owners.get(&edge_key(b, a)).map(Vec::as_slice)) {
                    ([_], Some([other])) => *other,
                    _ => NONE,
                };
                prop_assert_eq!(topology.neighbours[t][k], found);
            }
        }
    }

    #[test]
    fn boundary_is_two_edges_less_three_faces(kept in prop::collection::vec(any::<bool>(), 2048)) {
        let plane = shape(Shape::Plane);
        let triangles: Vec<_> = plane.triangles.iter().zip(kept).filter(|(_, k)| *k).map(|(t, _)| *t).collect();
        let topology = neighbours(&triangles);
        prop_assert_eq!(topology.boundary_edges, 2 * topology.edges - 3 * triangles.len());
        prop_assert_eq!(topology.boundary_edges, boundary_edges(&topology).len());
    }

    #[test]
    fn any_soup_becomes_a_skin(triangles in soups(), flat in any::<bool>()) {
        let spread = |i: u32| {
            let v = Vec3::new((i * 7 % 12) as f32, (i * 5 % 12) as f32, (i * i % 12) as f32);
            if flat { Vec3::new(v.x.min(3.0), v.y.min(2.0), 0.0) } else { v }
        };
        let mesh = Mesh { positions: (0..12).map(spread).collect(), triangles, ..Mesh::default() };
        check_skin(&skin_of(mesh), "soup");
    }
}

#[test]
fn obj_round_trip() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("hat.obj");
    let mut hat = shape(Shape::Hat);
    hat.colors[3] = Vec3::new(0.25, 0.5, 0.75);
    std::fs::write(&path, "old").expect("writable");
    write_obj(&hat, &path).expect("written");
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1, "no temporary file stays");
    let spec = MeshSpec { path: Some("hat.obj".into()), ..MeshSpec::default() };
    let again = load(&spec, &|_| Ok(path.clone())).expect("read again");
    assert_eq!(again.triangles.len(), hat.triangles.len());
    let corners = |s: &Skin| (0..s.triangles.len()).map(|t| s.corners(t)).collect::<Vec<_>>();
    assert_eq!(corners(&again), corners(&hat));
    assert_eq!(again.corner_uv, hat.corner_uv);
    assert_eq!(again.colors.iter().filter(|c| **c == hat.colors[3]).count(), 1);

    let error = write_obj(&hat, &folder.path().join("missing/hat.obj")).expect_err("no such folder");
    assert_eq!(error.exit_code(), 1);
    assert!(error.to_string().contains("hat.obj"), "{error}");
}

/// The files of the assets' folder with the counts stated there: vertices used, triangles with
/// area, boundary edges.
#[test]
fn assets_load_with_their_counts() {
    let Some(folder) = assets() else { return };
    let rows = [
        ("armadillo-29k", 14587, 29170, 0, false),
        ("bunny-5k", 2514, 5000, 32, false),
        ("bunny-closed-60k", 29834, 59664, 0, false),
        ("cat", 7949, 15894, 0, false),
        ("cheburashka", 6669, 13334, 0, false),
        ("horse", 48485, 96966, 0, false),
        ("ratboy-body", 12909, 25814, 0, false),
        ("spot-23k", 11533, 23062, 0, false),
        ("spot-quads", 2930, 5856, 0, true),
        ("spot", 2930, 5856, 0, true),
        ("stanford-bunny", 35947 - 1113, 69451, 223, false),
        // Two vertices of the eyes lie on the lids and are welded to them.
        ("suzanne", 507 - 2, 968, 42, false),
    ];
    for (name, vertices, triangles, boundary, uv) in rows {
        let path = folder.join("meshes").join(name).with_extension("obj");
        let spec =
            MeshSpec { path: Some(name.into()), size: Some(15.0), center: true, ..MeshSpec::default() };
        let skin = load(&spec, &|_| Ok(path.clone())).expect(name);
        let topology = check_skin(&skin, name);
        assert_eq!(skin.triangles.len(), triangles, "{name}: {:?}", skin.notes);
        assert_eq!(skin.positions.len(), vertices, "{name}: {:?}", skin.notes);
        assert_eq!(topology.boundary_edges, boundary, "{name}: {:?}", skin.notes);
        assert_eq!((topology.non_manifold_edges, topology.inconsistent_edges), (0, 0), "{name}");
        assert_eq!(boundary, 2 * topology.edges - 3 * triangles, "{name}");
        assert_eq!(skin.corner_uv.is_some(), uv, "{name}");
        let (low, high) = skin.bounds();
        assert!(((high - low).max_element() - 15.0).abs() < 1e-4, "{name}");
        if boundary == 0 {
            assert!(volume(&skin) > 0.0, "{name}: inside out");
        }
    }
    // The spider is welded and repaired.
    let path = folder.join("meshes/spider.obj");
    let spec = |strict| MeshSpec { path: Some("spider".into()), strict, ..MeshSpec::default() };
    let skin = load(&spec(false), &|_| Ok(path.clone())).expect("spider");
    check_skin(&skin, "spider");
    println!("spider: {} triangles, {:?}", skin.triangles.len(), skin.notes);
    assert!(skin.notes.iter().any(|n| n == "56 zero-area triangles dropped"), "{:?}", skin.notes);
    assert!(skin.triangles.len() <= 1368 - 56);
    let error = load(&spec(true), &|_| Ok(path.clone())).expect_err("strict");
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("56 zero-area triangles dropped; "), "{error}");
}

#[test]
fn facets_share_nothing() {
    let spec = MeshSpec { shape: Some(Shape::Die), ..MeshSpec::default() };
    let whole = load(&spec, &no_file).expect("a die");
    let facets = load(&MeshSpec { faceted: true, ..spec }, &no_file).expect("a die");
    assert_eq!(facets.positions.len(), 3 * whole.triangles.len());
    assert_eq!(facets.colors.len(), facets.positions.len());
    for (t, triangle) in whole.triangles.iter().enumerate() {
        assert_eq!(facets.corners(t), whole.corners(t));
        let [a, b, c] = whole.corners(t);
        let normal = (b - a).cross(c - a).normalize();
        for k in 0..3 {
            let v = facets.triangles[t][k] as usize;
            assert!(facets.normals[v].distance(normal) < 1e-6);
            assert_eq!(v, 3 * t + k);
        }
        let smooth = triangle.map(|v| whole.normals[v as usize].distance(normal));
        assert!(smooth.iter().all(|d| *d < 0.6), "smoothed normals are near it");
    }
    assert!(whole.positions.len() < facets.positions.len() / 2);
}
