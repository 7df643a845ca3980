//! Meshes from every format: one body, its parts, and damaged files.

use crate::common::mesh_files::{self as files, Body, cube};
use crate::common::shapes::shape;
use crate::common::{Folder, assets};
use glam::{Vec2, Vec3};
use pelage_core::mesh::{Limits, Mesh, MeshKind, gltf, kind_of, load, ply, read, skin_of, stl};
use pelage_core::scene::{ColorSpace, MeshSpec, Shape, Units, UpAxis};
use pelage_core::{Result, Skin};
use std::path::Path;
use std::time::{Duration, Instant};

pub(crate) fn load_file(folder: &Folder, name: &str, spec: MeshSpec) -> Result<Skin> {
    let path = folder.path().join(name);
    load(&MeshSpec { path: Some(name.into()), ..spec }, &|_| Ok(path.clone()))
}

/// In cm and with +y up, whatever the format.
pub(crate) fn as_it_is() -> MeshSpec {
    MeshSpec { units: Some(Units::Cm), up: Some(UpAxis::Y), ..MeshSpec::default() }
}

pub(crate) fn corners(skin: &Skin) -> Vec<[Vec3; 3]> {
    (0..skin.triangles.len()).map(|t| skin.corners(t)).collect()
}

/// The text of an error.
pub(crate) fn message<T>(result: Result<T>) -> String {
    match result {
        Ok(_) => panic!("an error is expected"),
        Err(e) => {
            assert!(matches!(e.exit_code(), 1 | 3), "{e}");
            e.to_string()
        }
    }
}

#[test]
fn one_body_is_the_same_skin_from_every_format() {
    let folder = Folder::new();
    let critter = shape(Shape::Critter);
    let body = Body { positions: critter.positions.clone(), triangles: critter.triangles.clone() };
    let buffer = files::gltf_buffer(&body);
    folder.write("buffer 1.bin", &buffer);
    let mut all = files::all(&body);
    all.push(("external.gltf", files::gltf_document(&body, Some("buffer%201.bin"), "").into_bytes()));
    for (name, bytes) in all {
        folder.write(name, &bytes);
        let skin = load_file(&folder, name, as_it_is()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(corners(&skin), corners(&critter), "{name}");
        assert_eq!(skin.positions.len(), critter.positions.len(), "{name}");
        assert!(skin.normals.iter().all(|n| n.is_finite()), "{name}");
        assert_eq!((skin.sections.len(), skin.section_of.len()), (1, skin.triangles.len()), "{name}");
        let named = (skin.sections[0].group.as_str(), skin.sections[0].material.as_str());
        let is_gltf = name.contains(".gl");
        assert_eq!(named, if is_gltf { ("Body", "Fur") } else { ("", "") }, "{name}");
        assert_eq!(skin.sections[0].base_color, is_gltf.then_some([0.5, 0.25, 0.125]), "{name}");
        assert!(!skin.colored && skin.alphas.is_empty(), "{name}");
    }
}

#[test]
fn kinds_are_told_by_the_content() {
    let folder = Folder::new();
    let wanted = [
        MeshKind::Obj,
        MeshKind::Ply,
        MeshKind::Ply,
        MeshKind::Ply,
        MeshKind::Stl,
        MeshKind::Stl,
        MeshKind::Gltf,
        MeshKind::Glb,
    ];
    for ((_, bytes), kind) in files::all(&cube(3.0)).into_iter().zip(wanted) {
        for name in ["mesh", "mesh.toml", "mesh.obj", "mesh.stl", "mesh.glb"] {
            let path = folder.path().join(name);
            folder.write(name, &bytes);
            assert_eq!(kind_of(&path), Some(kind), "{name}");
            let mesh = read(&path).unwrap_or_else(|e| panic!("{kind:?} {name}: {e}"));
            assert_eq!(mesh.triangles.len(), 12, "{kind:?} {name}");
            let other = path.extension().is_some_and(|e| e != kind.extension() && e != "toml");
            let both_gltf = kind == MeshKind::Gltf && name == "mesh.glb";
            let noted = mesh.notes.iter().any(|n| n.contains("read as the"));
            assert_eq!(noted, other && !both_gltf, "{kind:?} {name}: {:?}", mesh.notes);
        }
    }
    // A scene is never a mesh, and other files are named as what they are.
    let others: [(&str, &[u8], &str); 9] = [
        ("scene.toml", b"preset = \"red_fox\"\n[mesh]\nshape = \"hat\"\n", "TOML"),
        ("scene.obj", b"# a scene\n\n[mesh]\nshape = \"hat\"\n", "TOML"),
        ("v.stl", b"solid = 3\n[mesh]\n", "TOML"),
        ("a.obj", b"\x89PNG\r\n\x1a\n", "PNG"),
        ("a.fbx", b"Kaydara FBX Binary  \0", "FBX"),
        ("a.ply", b"OFF\n3 1 0\n", "OFF"),
        ("a.glb", b"PK\x03\x04", "ZIP"),
        ("a.txt", b"some words\n", "no mesh that can be read"),
        ("a.json", b"{\"time\": 3}", "no mesh that can be read"),
    ];
    for (name, bytes, what) in others {
        let path = folder.path().join(name);
        folder.write(name, bytes);
        assert_eq!(kind_of(&path), None, "{name}");
        let message = message(read(&path));
        assert!(
            message.contains(name) && message.contains(what) && message.contains("expected a mesh"),
            "{message}"
        );
    }
    assert_eq!(kind_of(&folder.path().join("missing.obj")), None);
}

#[test]
fn gltf_nodes_modes_and_attributes() {
    let folder = Folder::new();
    // Positions as a strip and as a fan: the same square, and a line.
    let square: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut buffer: Vec<u8> = square.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    buffer.extend([0, 1, 3, 2]); // indices of the fan, at 48
    let uv: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]];
    buffer.extend(uv.iter().flatten().flat_map(|x| x.to_le_bytes())); // at 52
    // Normalised colours with alpha, at 84: half red.
    buffer.extend([[255_u8, 0, 51, 128]; 4].concat());
    let document = "{\"asset\": {\"version\": \"2.0\"}, \"scenes\": [{\"nodes\": [0, 3]}, {\"nodes\": []}],\n\
        \"extensionsUsed\": [\"KHR_materials_unlit\"], \"extensionsRequired\": [\"KHR_materials_unlit\"],\n\
        \"nodes\": [{\"name\": \"root\", \"translation\": [10, 0, 0], \"scale\": [2, 2, 2], \"children\": [1, 2]},\n\
        {\"name\": \"strip\", \"mesh\": 0, \"translation\": [0, 0, 1]},\n\
        {\"name\": \"fan\", \"mesh\": 1, \"matrix\": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}, {\"mesh\": 2}],\n\
        \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 2, \"COLOR_0\": 3}, \"mode\": 5, \"material\": 0}]},\n\
        {\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"TEXCOORD_0\": 2}, \"indices\": 1, \"mode\": 6, \"material\": 1}]},\n\
        {\"name\": \"lines\", \"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"mode\": 1}]}],\n\
        \"materials\": [{\"name\": \"skin\", \"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0}}},\n\
        {\"name\": \"inner\", \"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 1}}}],\n\
        \"textures\": [{\"source\": 0}, {\"source\": 1}],\n\
        \"images\": [{\"uri\": \"maps/fur%20map.png\"}, {\"name\": \"inside\", \"uri\": \"data:image/png;base64,AAAA\"}],\n\
        \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4, \"type\": \"VEC3\"},\n\
        {\"bufferView\": 1, \"componentType\": 5121, \"count\": 4, \"type\": \"SCALAR\"},\n\
        {\"bufferView\": 2, \"componentType\": 5126, \"count\": 4, \"type\": \"VEC2\"},\n\
        {\"bufferView\": 3, \"componentType\": 5121, \"normalized\": true, \"count\": 4, \"type\": \"VEC4\"}],\n\
        \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 48}, {\"buffer\": 0, \"byteOffset\": 48, \"byteLength\": 4},\n\
        {\"buffer\": 0, \"byteOffset\": 52, \"byteLength\": 32}, {\"buffer\": 0, \"byteOffset\": 84, \"byteLength\": 16}],\n\
        \"buffers\": [{\"byteLength\": 100}]}";
    folder.write("parts.glb", files::glb(document, &buffer));
    let mesh = read(&folder.path().join("parts.glb")).unwrap();
    let at = |t: usize| mesh.triangles[t].map(|i| mesh.positions[i as usize]);
    let p = Vec3::new;
    assert_eq!(mesh.triangles.len(), 4);
    // The strip: turned every second time; moved by (0, 0, 1), then scaled, then moved by 10.
    assert_eq!(at(0), [p(10.0, 0.0, 2.0), p(12.0, 0.0, 2.0), p(10.0, 2.0, 2.0)]);
    assert_eq!(at(1), [p(10.0, 2.0, 2.0), p(12.0, 0.0, 2.0), p(12.0, 2.0, 2.0)]);
    // The fan, mirrored at x: its triangles are turned over, so that they still face +z.
    for t in [2, 3] {
        let [a, b, c] = at(t);
        assert!((b - a).cross(c - a).z > 0.0 && a.x.min(b.x).min(c.x) == 8.0, "{a} {b} {c}");
    }
    assert_eq!(mesh.corner_uv.as_ref().unwrap()[0], [Vec2::ZERO, Vec2::X, Vec2::Y]);
    assert_eq!(mesh.colors[0], Vec3::new(1.0, 0.0, 0.2));
    assert!((mesh.alphas[0] - 128.0 / 255.0).abs() < 1e-6 && !mesh.srgb);
    assert_eq!((mesh.colors[4], mesh.alphas[4]), (Vec3::ONE, 1.0));
    assert_eq!(mesh.section_of, [0, 0, 1, 1]);
    let names: Vec<_> = mesh.sections.iter().map(|s| (s.group.as_str(), s.material.as_str())).collect();
    assert_eq!(names, [("strip", "skin"), ("fan", "inner")]);
    let map = mesh.sections[0].base_map.as_ref().unwrap();
    assert_eq!(Path::new(map), folder.path().join("maps/fur map.png"));
    assert_eq!(mesh.sections[1].base_map, None);
    for wanted in ["\"inside\" lies within the file", "1 primitives of points or lines", "1 other scenes"] {
        assert!(mesh.notes.iter().any(|n| n.contains(wanted)), "{wanted}: {:?}", mesh.notes);
    }
    let clamped = "4 vertex colours outside 0..1 clamped";
    assert!(!mesh.notes.iter().any(|n| n == clamped), "{:?}", mesh.notes);
    // Bytes that the file does not call normalised: 255 and 51 are clamped.
    folder.write("bytes.glb", files::glb(&document.replace("\"normalized\": true, ", ""), &buffer));
    let mesh = read(&folder.path().join("bytes.glb")).unwrap();
    assert_eq!(mesh.colors[0], Vec3::new(1.0, 0.0, 1.0));
    assert!(mesh.notes.iter().any(|n| n == clamped), "{:?}", mesh.notes);
}

#[test]
fn gltf_faults_say_what_is_wrong() {
    let body = cube(1.0);
    let (plain, buffer) = (files::gltf_document(&body, None, ""), files::gltf_buffer(&body));
    let fault = |from: &str, to: &str| {
        assert!(plain.contains(from), "{from}");
        let file = files::glb(&plain.replace(from, to), &buffer);
        message(gltf::parse(&file, Path::new("a.glb"), &Limits::default()))
    };
    let asset = "\"asset\": {\"version\": \"2.0\"}";
    let count = "\"count\": 8";
    for (from, to, words) in [
        (
            asset,
            "\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": [\"KHR_draco_mesh_compression\"]",
            "KHR_draco_mesh_compression",
        ),
        (
            asset,
            "\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": [\"EXT_meshopt_compression\"]",
            "EXT_meshopt_compression",
        ),
        (count, "\"count\": 9", "do not fit"),
        (count, "\"count\": 7", "indices"),
        (count, "\"count\": 4000000000", "at most"),
        (count, "\"count\": -1", "cannot be read as glTF"),
        ("\"indices\": 1", "\"indices\": 7", "no valid glTF"),
        ("\"indices\": 1", "\"indices\": 0", "unsigned integers"),
        ("\"indices\": 1", "\"indices\": 1, \"mode\": 0", "no triangles"),
        ("\"name\": \"Body\"", "\"children\": [0]", "child of two nodes or of itself"),
        (
            "\"name\": \"Body\"",
            "\"scale\": [1e38, 1e38, 1e38], \"translation\": [3e38, 3e38, 3e38]",
            "finite",
        ),
        ("\"byteOffset\": 96", "\"byteOffset\": 18446744073709551615", "do not fit"),
        ("\"byteLength\": 240", "\"byteLength\": 4000000000", "cut short"),
        ("VEC3", "VEC2", "expected vectors of 3"),
    ] {
        let text = fault(from, to);
        assert!(text.contains(words) && text.contains("a.glb"), "{to}: {text}");
    }
    let file = files::glb(&plain, &buffer);
    let cut = message(gltf::parse(&file[..file.len() - 7], Path::new("a.glb"), &Limits::default()));
    assert!(cut.contains("cut short"), "{cut}");
    let folder = Folder::new();
    folder.write("a.gltf", files::gltf_document(&body, Some("missing.bin"), ""));
    assert!(message(read(&folder.path().join("a.gltf"))).contains("missing.bin"));
    folder.write("a.gltf", files::gltf_document(&body, Some("data:,abc"), ""));
    assert!(message(read(&folder.path().join("a.gltf"))).contains("base64"));
    folder.write("a.gltf", "{\"asset\": {\"version\": \"2.0\"},\n\"meshes\": 3}");
    assert!(message(read(&folder.path().join("a.gltf"))).contains("a.gltf:2"));
}

fn ply_mesh(text: &str) -> Result<Mesh> {
    ply::parse(text.as_bytes(), Path::new("a.ply"), &Limits::default())
}

#[test]
fn ply_properties_are_read() {
    let square = "0 0 0 255 0 55 128\n1 0 0 255 255 255 255\n1 1 0 0 0 0 255\n0 1 0 0 0 0 255\n";
    let text = format!(
        "ply\r\nformat ascii 1.0\r\nelement vertex 4\nproperty double x\nproperty float32 y\nproperty float z\n\
         property uchar red\nproperty uint8 green\nproperty uchar blue\nproperty uchar alpha\nelement face 2\n\
         property list uchar uint vertex_index\nproperty list uchar float texcoord\nelement edge 1\n\
         property int vertex1\nproperty int vertex2\nend_header\n{square}\
         4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 2 6 0 0 1 0 1 1\n0 1\n"
    );
    let mesh = ply_mesh(&text).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(mesh.corner_uv.as_ref().unwrap()[1], [Vec2::ZERO, Vec2::ONE, Vec2::Y]);
    assert!(mesh.srgb && mesh.notes.iter().any(|n| n.contains("1 elements \"edge\"")), "{:?}", mesh.notes);
    assert!((mesh.alphas[0] - 128.0 / 255.0).abs() < 1e-6);
    // Bytes are sRGB: 55 is 0.0382 of the light.
    let skin = skin_of(mesh);
    assert!(
        skin.colored && skin.colors[0].distance(Vec3::new(1.0, 0.0, 0.0382)) < 1e-4,
        "{}",
        skin.colors[0]
    );
    assert_eq!((skin.triangles.len(), skin.section_of.len()), (2, 2));
    // Colours in floating point are linear, and the scene can say otherwise.
    let float = text.replace("uchar red", "float red").replace("uint8 green", "float green");
    let float = float
        .replace("uchar blue", "float blue")
        .replace("255 0 55", "1 0 0.5")
        .replace("255 255 255", "1 1 1");
    let mesh = ply_mesh(&float).unwrap();
    assert!(!mesh.srgb && mesh.colors[0] == Vec3::new(1.0, 0.0, 0.5), "{}", mesh.colors[0]);
    // What is replaced is counted.
    let mesh = ply_mesh(&float.replace("1 1 0 0 0 0", "1 1 0 -1 0 0.25")).unwrap();
    assert_eq!(mesh.colors[2..], [Vec3::new(0.0, 0.0, 0.25), Vec3::ZERO]);
    assert!(mesh.notes.iter().any(|n| n == "1 vertex colours below 0 clamped"), "{:?}", mesh.notes);
    let folder = Folder::new();
    folder.write("a.ply", &float);
    let spec = MeshSpec { vertex_colors: Some(ColorSpace::Srgb), ..as_it_is() };
    let skin = load_file(&folder, "a.ply", spec).unwrap();
    assert!((skin.colors[0].z - 0.2140).abs() < 1e-4, "{}", skin.colors[0]);
    // uv of vertices, and strips.
    let strip = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float s\nproperty float t\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n1 1 0 1 1\n9 0 1 2 3 -1 3 2 1 -1\n";
    let mesh = ply_mesh(strip).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [3, 2, 1]]);
    assert_eq!(mesh.corner_uv.unwrap()[1], [Vec2::Y, Vec2::X, Vec2::ONE]);
}

#[test]
fn ply_and_stl_faults_say_where() {
    let text = String::from_utf8(files::ply(&cube(1.0), "ascii").iter().map(|b| b & 0x7F).collect()).unwrap();
    for (from, to, words) in [
        ("element face 12", "element face 13", "a.ply"),
        ("element vertex 8", "element vertex 4000000000", "at most"),
        ("element face 12", "element face 60000000", "cut short"),
        ("property list uchar int vertex_indices\n", "", "without properties"),
        ("end_header", "end_heade", "end_header"),
        ("format ascii 1.0", "format klingon 1.0", "a.ply:2"),
        ("property float z", "property float w", "without x, y and z"),
        ("0 0 0\n", "0 zero 0\n", "a.ply:11"),
        ("3 0 2 3\n", "3 0 2 8\n", "corner 8, expected 0 to 7"),
        ("3 0 2 3\n", "3 0 2 -1\n", "corner -1"),
        ("element face 12", "element thing 12", "no faces"),
    ] {
        assert!(text.contains(from), "{from}");
        let found = message(ply_mesh(&text.replacen(from, to, 1)));
        assert!(found.contains(words) && found.contains("a.ply"), "{to}: {found}");
    }
    let stl = |bytes: &[u8]| stl::parse(bytes, Path::new("a.stl"), &Limits::default());
    let text = String::from_utf8(files::stl_ascii(&cube(1.0))).unwrap();
    for (from, to, words) in [
        ("vertex 0 0 0", "vertex 0 0", "a.stl:4: found `vertex` with 2 numbers"),
        ("vertex 0 0 0", "vertex 0 0 nan", "a.stl:4: found `nan`"),
        ("      vertex 0 0 0\n", "", "a.stl:6: found a loop of 2 vertices"),
        ("outer loop", "inner loop", "a.stl:3: found `inner`"),
        ("endsolid a body", "", "ends early"),
    ] {
        let found = message(stl(text.replacen(from, to, 1).as_bytes()));
        assert!(found.contains(words), "{to}: {found}");
    }
    // Several solids, upper case, no name, NaN normals, CR LF.
    let two = format!("{}{text}", text.to_uppercase().replace('\n', "\r\n").replace("A BODY", ""));
    let two = two.replace("NORMAL 0 0 0", "NORMAL NAN NAN NAN");
    assert_eq!(stl(two.as_bytes()).unwrap().triangles.len(), 24);
    assert!(message(stl(b"solid empty\nendsolid\n")).contains("without triangles"));
    let mut binary = files::stl_binary(&cube(1.0));
    let length = binary.len();
    assert!(message(stl(&binary[..length - 1])).contains("cut short"));
    binary[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message(stl(&binary)).contains("4294967295"));
    binary[80..84].copy_from_slice(&12_u32.to_le_bytes());
    binary[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(message(stl(&binary)).contains("triangle 1"));
}

#[test]
fn obj_groups_materials_and_their_library() {
    let folder = Folder::new();
    let text = "mtllib some colours.mtl missing.mtl\nmtllib other.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
        v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\no Body\nusemtl Fur coat\nf 1 2 3 4\nusemtl Eye\nf 5 6 7\n\
        g Head ears\nf 5 7 8\nusemtl Fur coat\no Body\nf 1 2 6 5\nf 1 1 1\nf 1 2\n";
    folder.write("a.obj", text);
    folder.write("some colours.mtl", "newmtl not read: the statement names two files\nKd 1 1 1\n");
    folder.write(
        "other.mtl",
        "# test\nKd 9 9 9\nnewmtl Fur coat\nNs 10\nKd 0.5 0.25 2\nmap_Kd -s 1 1 1 -o 0.5 -clamp on maps\\a fur.png\n\
         newmtl Eye\nKd nonsense\nmap_Kd\n",
    );
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    folder.write("maps/a fur.png", "");
    let skin = load_file(&folder, "a.obj", as_it_is()).unwrap();
    let named: Vec<_> = skin.sections.iter().map(|s| (s.group.as_str(), s.material.as_str())).collect();
    assert_eq!(named, [("Body", "Fur coat"), ("Body", "Eye"), ("Head ears", "Eye")]);
    assert_eq!(skin.section_of, [0, 0, 1, 2, 0, 0]);
    assert_eq!(skin.sections[0].base_color, Some([0.5, 0.25, 1.0]));
    let map = skin.sections[0].base_map.as_ref().unwrap();
    assert_eq!(Path::new(map), folder.path().join("maps/a fur.png"));
    assert_eq!((skin.sections[1].base_color, &skin.sections[1].base_map), (None, &None));
    for wanted in ["missing.mtl is not there", "2 damaged statements"] {
        assert!(skin.notes.iter().any(|n| n.contains(wanted)), "{wanted}: {:?}", skin.notes);
    }
    // Facets keep the sections, shapes have one.
    let facets = load_file(&folder, "a.obj", MeshSpec { faceted: true, ..as_it_is() }).unwrap();
    assert_eq!((facets.section_of, facets.sections), (skin.section_of, skin.sections));
    let hat = shape(Shape::Hat);
    assert_eq!((hat.sections.len(), hat.section_of.len()), (1, hat.triangles.len()));
}

#[test]
fn damaged_files_of_every_format_are_errors_and_no_more() {
    // A fixed sequence of random numbers.
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below.max(1) as u64) as usize
    };
    for (name, file) in files::all(&cube(2.0)) {
        let (mut slowest, mut readable) = (Duration::ZERO, 0);
        let mut attempt = |bytes: &[u8]| {
            let start = Instant::now();
            let path = Path::new(name);
            let limits = Limits::default();
            let mesh = match path.extension().and_then(|e| e.to_str()) {
                Some("obj") => pelage_core::mesh::obj::parse(bytes, path, &limits),
                Some("ply") => ply::parse(bytes, path, &limits),
                Some("stl") => stl::parse(bytes, path, &limits),
                _ => gltf::parse(bytes, path, &limits),
            };
            match mesh {
                Ok(mesh) => {
                    readable += 1;
                    assert!(skin_of(mesh).normals.iter().all(|n| n.is_finite()), "{name}");
                }
                Err(e) => {
                    let text = e.to_string();
                    // A damaged name of a buffer is a file that is not there.
                    let located = text.contains(name) || e.exit_code() == 1;
                    assert!(located && !text.contains("the file is damaged"), "{name}: {text}");
                }
            }
            slowest = slowest.max(start.elapsed());
        };
        (0..file.len()).step_by(3).for_each(|n| attempt(&file[..n]));
        for _ in 0..400 {
            let mut bytes = file.clone();
            for _ in 0..1 + random(4) {
                let at = random(bytes.len());
                bytes[at] = if random(2) == 0 { random(256) as u8 } else { bytes[at] ^ (1 << random(8)) };
            }
            attempt(&bytes);
        }
        for _ in 0..100 {
            // A piece again, somewhere else.
            let (from, to) = (random(file.len()), random(file.len()));
            let piece = &file[from..(from + 1 + random(200)).min(file.len())];
            let mut bytes = file.clone();
            bytes.splice(to..to, piece.iter().copied());
            attempt(&bytes);
        }
        attempt(&file.repeat(3));
        println!("{name}: {readable} readable, slowest {slowest:?}");
        assert!(slowest < Duration::from_secs(1), "{name}: {slowest:?}");
    }
}

/// The assets as PLY and STL are the same skins.
#[test]
fn assets_are_the_same_in_every_format() {
    let Some(folder) = assets() else { return };
    let here = Folder::new();
    for name in ["bunny-5k", "suzanne", "spot"] {
        let path = folder.join("meshes").join(name).with_extension("obj");
        let wanted =
            load(&MeshSpec { path: Some(name.into()), ..as_it_is() }, &|_| Ok(path.clone())).unwrap();
        let body = Body { positions: wanted.positions.clone(), triangles: wanted.triangles.clone() };
        for (file, bytes) in files::all(&body) {
            here.write(file, &bytes);
            let skin = load_file(&here, file, as_it_is()).unwrap();
            assert_eq!(corners(&skin), corners(&wanted), "{name} as {file}");
        }
    }
}
