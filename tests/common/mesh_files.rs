//! Small mesh files of every format.

use glam::Vec3;
use std::fmt::Write as _;

/// Vertices and triangles.
#[derive(Clone)]
pub struct Body {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// A cube with corners at 0 and `edge`, which faces outwards.
pub fn cube(edge: f32) -> Body {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * edge;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Body { positions: (0..8).map(corner).collect(), triangles }
}

pub fn obj(body: &Body) -> Vec<u8> {
    let mut text = String::new();
    body.positions.iter().for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap());
    body.triangles
        .iter()
        .map(|t| t.map(|i| i + 1))
        .for_each(|[a, b, c]| writeln!(text, "f {a} {b} {c}").unwrap());
    text.into_bytes()
}

/// The encodings of PLY.
pub const PLY: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

pub fn ply(body: &Body, encoding: &str) -> Vec<u8> {
    let (v, f) = (body.positions.len(), body.triangles.len());
    let mut file = format!(
        "ply\nformat {encoding} 1.0\ncomment caf\u{e9}\nelement vertex {v}\nproperty float x\nproperty float y\n\
         property float z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let big = encoding.ends_with("big_endian");
    for p in &body.positions {
        if encoding == "ascii" {
            file.extend(format!("{} {} {}\n", p.x, p.y, p.z).bytes());
        } else {
            p.to_array()
                .iter()
                .for_each(|x| file.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() }));
        }
    }
    for [a, b, c] in &body.triangles {
        if encoding == "ascii" {
            file.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            file.push(3);
            [a, b, c].iter().for_each(|i| file.extend(if big { i.to_be_bytes() } else { i.to_le_bytes() }));
        }
    }
    file
}

pub fn stl_ascii(body: &Body) -> Vec<u8> {
    let mut text = "solid a body\n".to_owned();
    for t in &body.triangles {
        text += "  facet normal 0 0 0\n    outer loop\n";
        t.map(|i| body.positions[i as usize])
            .iter()
            .for_each(|p| writeln!(text, "      vertex {} {} {}", p.x, p.y, p.z).unwrap());
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid a body\n").into_bytes()
}

pub fn stl_binary(body: &Body) -> Vec<u8> {
    // A header that looks like a text.
    let mut file = b"solid binary".to_vec();
    file.resize(80, b' ');
    file.extend((body.triangles.len() as u32).to_le_bytes());
    for t in &body.triangles {
        file.extend([0; 12]);
        for p in t.map(|i| body.positions[i as usize]) {
            p.to_array().iter().for_each(|x| file.extend(x.to_le_bytes()));
        }
        file.extend([0; 2]);
    }
    file
}

/// The buffer of a glTF file: positions, then indices.
pub fn gltf_buffer(body: &Body) -> Vec<u8> {
    let positions = body.positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes);
    positions.chain(body.triangles.iter().flatten().flat_map(|i| i.to_le_bytes())).collect()
}

/// A glTF document with one node; `uri` of its buffer, if it has one, and `node`, more keys of the
/// node.
pub fn gltf_document(body: &Body, uri: Option<&str>, node: &str) -> String {
    let (v, i) = (body.positions.len(), 3 * body.triangles.len());
    let uri = uri.map_or_else(String::new, |uri| format!("\"uri\": \"{uri}\", "));
    let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max].map(|pick| {
        let [x, y, z] = [0, 1, 2].map(|k| body.positions.iter().map(|p| p[k]).reduce(pick).unwrap());
        format!("[{x}, {y}, {z}]")
    });
    format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"scene\": 0, \"scenes\": [{{\"nodes\": [0]}}],\n\
         \"nodes\": [{{\"mesh\": 0, \"name\": \"Body\"{node}}}],\n\
         \"meshes\": [{{\"primitives\": [{{\"attributes\": {{\"POSITION\": 0}}, \"indices\": 1, \"material\": 0}}]}}],\n\
         \"materials\": [{{\"name\": \"Fur\", \"pbrMetallicRoughness\": {{\"baseColorFactor\": [0.5, 0.25, 0.125, 1]}}}}],\n\
         \"accessors\": [{{\"bufferView\": 0, \"componentType\": 5126, \"count\": {v}, \"type\": \"VEC3\", \"min\": {low}, \"max\": {high}}},\n\
         {{\"bufferView\": 1, \"componentType\": 5125, \"count\": {i}, \"type\": \"SCALAR\"}}],\n\
         \"bufferViews\": [{{\"buffer\": 0, \"byteLength\": {}}}, {{\"buffer\": 0, \"byteOffset\": {}, \"byteLength\": {}}}],\n\
         \"buffers\": [{{{uri}\"byteLength\": {}}}]}}",
        12 * v,
        12 * v,
        4 * i,
        12 * v + 4 * i
    )
}

pub fn glb(document: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = document.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = buffer.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    let word = |n: usize| (n as u32).to_le_bytes();
    file.extend(word(2));
    file.extend(word(12 + 8 + json.len() + 8 + bin.len()));
    file.extend(word(json.len()));
    file.extend(b"JSON");
    file.extend(json);
    file.extend(word(bin.len()));
    file.extend(b"BIN\0");
    file.extend(bin);
    file
}

/// Base64 by its definition.
pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let n = three.iter().chain(&[0; 2]).take(3).fold(0_usize, |n, b| n << 8 | usize::from(*b));
        for k in 0..4 {
            text.push(if k <= three.len() { DIGITS[n >> (18 - 6 * k) & 63] as char } else { '=' });
        }
    }
    text
}

/// A file name with its content.
pub type NamedFile = (&'static str, Vec<u8>);

/// The body in every format and encoding; no file needs another one.
pub fn all(body: &Body) -> Vec<NamedFile> {
    let buffer = gltf_buffer(body);
    let uri = format!("data:application/octet-stream;base64,{}", base64(&buffer));
    vec![
        ("a.obj", obj(body)),
        ("ascii.ply", ply(body, PLY[0])),
        ("little.ply", ply(body, PLY[1])),
        ("big.ply", ply(body, PLY[2])),
        ("ascii.stl", stl_ascii(body)),
        ("binary.stl", stl_binary(body)),
        ("a.gltf", gltf_document(body, Some(&uri), "").into_bytes()),
        ("a.glb", glb(&gltf_document(body, None, ""), &buffer)),
    ]
}
