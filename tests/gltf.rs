//! glTF files of fur: the content of the buffer, read back through its accessors, and errors.

use crate::common::Folder;
use crate::common::gpu::{self, world};
use crate::common::shellfins::{Fur, even};
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_core::mesh::topology;
use pelage_core::scene::BakeSource;
use pelage_core::skin::NONE;
use pelage_shells::bake::{FurTextures, Manifest, Texture, gltf};
use pelage_shells::lapped::Lapped;
use serde_json::Value;
use std::collections::HashMap;

const PATCH: f32 = 1.5;

fn textures() -> FurTextures {
    let blank = |width, height| Texture { width, height, texels: vec![[0.0; 4]; (width * height) as usize] };
    FurTextures {
        layers: vec![blank(4, 4); 3],
        guard: Vec::new(),
        fin: blank(8, 4),
        fin_guard: Texture::default(),
        manifest: Manifest {
            version: 1,
            generator: "test".into(),
            source: BakeSource::Dots,
            seed: 0,
            layers: 3,
            resolution: [4; 2],
            fin_resolution: [8, 4],
            patch: [PATCH; 2],
            fin_length: 2.0,
            fin_depth: 0.1,
            height: 0.6,
            spacing: 0.2,
            summary: Vec::new(),
        },
    }
}

/// Two patches, of the faces towards +x and of the others, each flattened by dropping a coordinate.
fn lapped(world: &World) -> Lapped {
    let skin = &world.skin;
    let corner_uv = (0..skin.triangles.len()).map(|t| {
        let corners = skin.corners(t);
        let to_x = (corners[1] - corners[0]).cross(corners[2] - corners[0]).x > 0.0;
        corners.map(|p| if to_x { Vec2::new(p.y, p.z) } else { Vec2::new(p.z, p.y) })
    });
    Lapped { corner_uv: corner_uv.collect(), ..Lapped::default() }
}

/// A document with its buffer.
struct Document {
    json: Value,
    bin: Vec<u8>,
}

impl Document {
    fn of(world: &World) -> Self {
        Self::with(world, &textures())
    }

    fn with(world: &World, textures: &FurTextures) -> Self {
        let folder = Folder::new();
        let written = gltf::write(world, &lapped(world), textures, folder.path()).unwrap();
        assert_eq!(written, ["fur.gltf", "fur.bin"].map(|n| folder.path().join(n)));
        assert_eq!(folder.names(), ["fur.bin", "fur.gltf"]);
        let json = serde_json::from_slice(&std::fs::read(&written[0]).unwrap()).unwrap();
        Self { json, bin: std::fs::read(&written[1]).unwrap() }
    }

    /// The 4-byte elements of an accessor, by rows.
    fn words(&self, accessor: &Value, component: u64) -> Vec<Vec<u32>> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        assert_eq!(accessor["componentType"], component);
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let [start, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
        let columns = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            kind => kind.strip_prefix("VEC").unwrap().parse().unwrap(),
        };
        let words = self.bin[start..start + length].chunks_exact(4);
        let words: Vec<u32> = words.map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(words.len() as u64, accessor["count"].as_u64().unwrap() * columns as u64);
        words.chunks_exact(columns).map(<[u32]>::to_vec).collect()
    }

    fn integers(&self, accessor: &Value) -> Vec<Vec<u32>> {
        self.words(accessor, 5125)
    }

    fn floats(&self, accessor: &Value) -> Vec<Vec<f32>> {
        let rows = self.words(accessor, 5126);
        rows.into_iter().map(|row| row.into_iter().map(f32::from_bits).collect()).collect()
    }

    fn attribute(&self, name: &str) -> Vec<Vec<f32>> {
        self.floats(&self.json["meshes"][0]["primitives"][0]["attributes"][name])
    }

    fn vectors(&self, name: &str) -> Vec<Vec3> {
        self.attribute(name).iter().map(|v| Vec3::from_slice(v)).collect()
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let indices = self.integers(&self.json["meshes"][0]["primitives"][0]["indices"]);
        indices.as_flattened().chunks_exact(3).map(|t| t.try_into().unwrap()).collect()
    }

    fn extras(&self) -> &Value {
        &self.json["extras"]["pelage"]
    }
}

trait Flattened {
    fn as_flattened(&self) -> Vec<u32>;
}

impl Flattened for Vec<Vec<u32>> {
    fn as_flattened(&self) -> Vec<u32> {
        self.iter().flatten().copied().collect()
    }
}

#[test]
fn corners_read_back_are_those_of_skin_and_patches() {
    for shape in ["die", "plane"] {
        let world = world(&format!("[mesh]\nshape = '{shape}'"));
        let (document, lapped) = (Document::of(&world), lapped(&world));
        let (positions, normals) = (document.vectors("POSITION"), document.vectors("NORMAL"));
        let texcoord = document.extras()["fur_texcoord"].as_u64().unwrap();
        let has_uv = world.skin.corner_uv.is_some();
        assert_eq!(texcoord, u64::from(has_uv));
        let fur_uv = document.attribute(&format!("TEXCOORD_{texcoord}"));
        let own_uv = has_uv.then(|| document.attribute("TEXCOORD_0"));
        let triangles = document.triangles();
        assert_eq!(triangles.len(), world.skin.triangles.len());
        for (t, triangle) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (i, v) = (triangle[k] as usize, world.skin.triangles[t][k] as usize);
                assert_eq!(positions[i], world.skin.positions[v]);
                assert_eq!(normals[i], world.skin.normals[v]);
                assert_eq!(fur_uv[i], (lapped.corner_uv[t][k] / PATCH).to_array());
                if let (Some(uv), Some(own_uv)) = (&world.skin.corner_uv, &own_uv) {
                    assert_eq!(own_uv[i], [uv[t][k].x, 1.0 - uv[t][k].y]);
                }
            }
        }
        // Vertices are shared inside a patch: fewer than corners, more than the skin's where
        // patches meet.
        assert!(
            positions.len() < 2 * world.skin.positions.len() && positions.len() >= world.skin.positions.len()
        );
        let accessor = &document.json["accessors"][0];
        let (low, high) = world.skin.bounds();
        assert_eq!(accessor["min"], serde_json::json!(low.to_array()));
        assert_eq!(accessor["max"], serde_json::json!(high.to_array()));
    }
}

#[test]
fn every_edge_is_listed_once_with_both_faces() {
    for shape in ["torus", "plane"] {
        let world = world(&format!("[mesh]\nshape = '{shape}'\n[render]\nseed = 7"));
        let document = Document::of(&world);
        let positions = document.vectors("POSITION");
        let fins = &document.extras()["fins"];
        let (edges, u) = (document.integers(&fins["edges"]), document.floats(&fins["u"]));
        let topology = topology::neighbours(&world.skin.triangles);
        let triangles = document.triangles();
        assert_eq!(edges.len(), topology.edges);
        assert_eq!(u.len(), edges.len());
        assert_eq!(edges.iter().filter(|e| e[3] == NONE).count(), topology.boundary_edges);
        // Split vertices by their positions.
        let at = |i: u32| positions[i as usize].to_array().map(f32::to_bits);
        let mut seen: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
        let mut starts = Vec::new();
        for (edge, u) in edges.iter().zip(&u) {
            let mut key = [at(edge[0]), at(edge[1])];
            key.sort_unstable();
            *seen.entry(key).or_default() += 1;
            let length = positions[edge[0] as usize].distance(positions[edge[1] as usize]);
            assert!((u[1] - u[0] - length / 2.0).abs() < 1e-5);
            assert!((0.0..1.0).contains(&u[0]));
            starts.push(u[0]);
            // The first face runs along the edge, the neighbour against it, and both faces exist.
            let face = |a: u32, b: u32, c: u32| {
                let wanted = [a, b, c].map(at);
                triangles
                    .iter()
                    .map(|t| t.map(at))
                    .any(|t| (0..3).any(|k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]] == wanted))
            };
            if seen.len().is_multiple_of(37) {
                assert!(face(edge[0], edge[1], edge[2]));
                assert!(edge[3] == NONE || face(edge[1], edge[0], edge[3]));
            }
        }
        assert!(seen.values().all(|n| *n == 1));
        // Spread over the texture.
        let mean = starts.iter().sum::<f32>() / starts.len() as f32;
        assert!((mean - 0.5).abs() < 0.1, "{mean}");
    }
}

#[test]
fn hair_follows_length_comb_and_brush() {
    let plain = Document::of(&world("[mesh]\nshape = 'plane'"));
    for (tip, normal) in plain.vectors("_FUR").iter().zip(plain.vectors("NORMAL")) {
        assert!(tip.distance(0.6 * normal) < 1e-6);
    }
    for (inner, share) in [("_FUR_1", 1.0 / 3.0), ("_FUR_2", 2.0 / 3.0)] {
        for (point, tip) in plain.vectors(inner).iter().zip(plain.vectors("_FUR")) {
            assert!(point.distance(share * tip) < 1e-6, "straight hair");
        }
    }
    let scene = "[mesh]\nshape = 'plane'\n[shells]\nlength = 0.5\nspacing = 0.4\ncomb = [1, 5, 0]\ncolor = [0.5, 0.25, 1]\n\
                 [[shells.brushes]]\ncenter = [5, 0, 5]\nradius = 3\ndirection = [0, 0, -2]";
    let combed = Document::of(&world(scene));
    assert!(combed.vectors("_FUR_COLOR").iter().all(|c| *c == Vec3::new(0.5, 0.25, 1.0)));
    let far = Vec3::new(1.0, 1.0, 0.0) * 0.6;
    let mut brushed = 0;
    for (tip, position) in combed.vectors("_FUR").iter().zip(combed.vectors("POSITION")) {
        assert!((tip.y - 0.6).abs() < 1e-5, "combing is a shear");
        if position.distance(Vec3::new(5.0, 0.0, 5.0)) >= 3.0 {
            assert!(tip.distance(far) < 1e-5, "{tip} at {position}");
        } else {
            brushed += 1;
            assert!(tip.z < 0.0);
        }
    }
    assert!(brushed > 0);
}

/// The longest hair of vertex `i` at `s` of its height, cm.
fn hair(clothed: &gltf::Clothed, i: usize, s: f32) -> Vec3 {
    let [p1, p2, p3] = clothed.hairs[i];
    let r = 1.0 - s;
    3.0 * r * r * s * p1 + 3.0 * r * s * s * p2 + s * s * s * p3
}

#[test]
fn the_renderer_draws_what_is_written() {
    let Some(gpu) = gpu::open() else { return };
    for (source, more) in [(BakeSource::Hybrid, ""), (BakeSource::Particles, "slanted = false")] {
        // The undercoat is too high for the inside of the ring.
        let text = format!(
            "[mesh]\nshape = 'torus'\n[[lights]]\ndirection = [0, 1, 0]\nirradiance = [1, 1, 1]\n\
             [guard]\ncomb = 0.6\ncomb_direction = [1, 0, 0]\ngravity = 0.3\nspread = 14\n\
             [undercoat]\nheight = 4\nlean = 0.4\n[shells]\nmapping = 'uv'\ncomb = [0, 0.3, 0.1]\n{more}\n\
             [shells.dynamics]\nwind = [0, 0, 300]"
        );
        let mut textures = even(source, 6, source == BakeSource::Hybrid);
        textures.manifest.height = 2.5;
        textures.manifest.spacing = 2.5 / 6.0;
        let (a, b) = (world(&text), world(&text));
        let clothed = gltf::clothe(&a, &lapped(&a), &textures.manifest).unwrap();
        let extras = Document::with(&a, &textures).extras().clone();
        let extras: gltf::Extras = serde_json::from_value(extras).unwrap();
        let bend = pelage_shells::shellfin::Pose::at(&a, 0.0, 2.5).bend;
        let fur = Fur::new(gpu, b, textures, bend);
        let vertices = a.skin.positions.len();
        let count = (fur.rows.rows.len() * vertices) as u64;
        let places: Vec<[f32; 4]> = gpu.read(fur.rows.buffer("row_positions").unwrap(), count * 16).unwrap();
        let mut lowered = 0;
        for (r, row) in fur.rows.rows.iter().enumerate() {
            for i in 0..clothed.positions.len() {
                let [x, y, z, _] = places[r * vertices + clothed.origin[i] as usize];
                let place = clothed.positions[i] + hair(&clothed, i, row.height);
                // The renderer keeps the length at every height, the curve at its tip: a difference
                // of second order in the bend.
                assert!(place.distance(Vec3::new(x, y, z)) < 1e-2, "{source:?} row {r} vertex {i}: {place}");
                lowered += usize::from(clothed.hairs[i][2].dot(clothed.upright[i]) < 2.0);
            }
        }
        assert_eq!(lowered > 0, source == BakeSource::Hybrid, "{lowered}");
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-5 * b.abs().max(1.0), "{a}, renderer {b}");
        assert_eq!(extras.strays.len(), 6);
        for (stray, row) in extras.strays.iter().zip(&fur.rows.rows) {
            close(stray.guard, row.share);
            close(stray.variance, row.jitter);
        }
        close(extras.guard_variance, fur.rows.shellfin.spread.powi(2));
        close(extras.fins.depth, fur.fur.fin_depth);
        let lean = Vec3::from(fur.fur.prepared().fur.undercoat.lean);
        let last = extras.strays[5].lean.map(Vec3::from);
        let wanted = lean * (2.5 * 5.5 / 6.0 / 4.0);
        assert!(last.map_or(source != BakeSource::Hybrid, |l| l.distance(wanted) < 1e-5), "{last:?}");
    }
}

#[test]
fn the_view_and_the_settings_are_the_scenes() {
    let scene = "[mesh]\nshape = 'sphere'\n[camera]\neye = [1, 2, 30]\nfov = 25\n[[lights]]\ndirection = [0, 2, 0]\n\
                 irradiance = [1, 2, 3]\n[film]\nwidth = 320\nheight = 200\n[shells]\nlayers = 2\nfins = false\n\
                 [shells.table]\ndiffuse = 0.7";
    let document = Document::of(&world(scene));
    let extras: gltf::Extras = serde_json::from_value(document.extras().clone()).unwrap();
    assert_eq!(extras.version, 1);
    assert_eq!(extras.manifest, textures().manifest);
    assert_eq!((extras.view.width, extras.view.height, extras.view.camera.fov), (320, 200, 25.0));
    assert_eq!(extras.view.camera.eye, [1.0, 2.0, 30.0]);
    assert_eq!(extras.view.lights.len(), 1);
    assert_eq!(extras.view.lights[0].direction, [0.0, 1.0, 0.0]);
    assert_eq!(extras.shells.layers, 2);
    assert!(extras.shells.shells && !extras.shells.fins);
    assert_eq!(extras.shells.table.diffuse, 0.7);
    assert_eq!(document.json["buffers"][0]["byteLength"], document.bin.len());
}

#[test]
fn inconsistent_inputs_are_readable_errors() {
    let folder = Folder::new();
    let error_of = |scene: &str, change: fn(&mut Lapped, &mut FurTextures)| {
        let world = world(scene);
        let (mut lapped, mut textures) = (lapped(&world), textures());
        change(&mut lapped, &mut textures);
        let error = gltf::write(&world, &lapped, &textures, folder.path()).unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(folder.names().is_empty());
        error.to_string()
    };
    let sphere = "[mesh]\nshape = 'sphere'";
    let text = error_of(sphere, |lapped, _| lapped.corner_uv.truncate(5));
    assert!(text.contains("5 faces"), "{text}");
    let text = error_of(sphere, |_, textures| textures.manifest.patch[1] = 0.0);
    assert!(text.contains("patch = 0"), "{text}");
    let text = error_of(sphere, |_, textures| textures.manifest.fin_length = f32::NAN);
    assert!(text.contains("fin_length"), "{text}");
    let text = error_of(sphere, |_, textures| textures.manifest.layers = 0);
    assert!(text.contains("layers = 0"), "{text}");
}

#[test]
fn the_same_fur_gives_the_same_bytes() {
    let scene = "preset = 'rabbit'\n[mesh]\nshape = 'critter'";
    let (a, b) = (Document::of(&world(scene)), Document::of(&world(scene)));
    assert_eq!((a.json, a.bin), (b.json, b.bin));
}

/// Objects are nodes with meshes and materials of their own, without shadow catchers.
#[test]
fn objects_are_ordinary_meshes() {
    let world = world(
        "[mesh]\nshape = 'plane'\n\
         [[objects]]\nname = 'caught'\nmesh = { shape = 'plane', scale = 2, translate = [0, -1, 0] }\nshadow_catcher = true\n\
         [[objects]]\nname = 'eye'\nmesh = { shape = 'sphere', scale = 0.1, translate = [0, 2, 0] }\n\
         material = { color = [0.25, 0.5, 0.75], roughness = 0.125, clearcoat = 0.5, clearcoat_roughness = 0.25 }\n\
         [[objects]]\nname = 'bell'\nmesh = { shape = 'sphere', scale = 0.05, translate = [3, 2, 0] }\n\
         material = { color = { map = 'vertex_color', value = [1, 0.5, 0.25] }, metallic = 1 }",
    );
    let document = Document::of(&world);
    let json = &document.json;
    assert_eq!(json["scenes"][0]["nodes"], serde_json::json!([0, 1, 2]));
    let names: Vec<_> =
        json["nodes"].as_array().unwrap().iter().map(|n| n["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["fur", "eye", "bell"]);
    assert_eq!(json["extensionsUsed"], serde_json::json!(["KHR_materials_clearcoat"]));
    for (node, object) in [(1, &world.objects[1]), (2, &world.objects[2])] {
        assert_eq!(json["nodes"][node]["scale"], json["nodes"][0]["scale"]);
        let mesh = &json["meshes"][json["nodes"][node]["mesh"].as_u64().unwrap() as usize];
        let primitive = &mesh["primitives"][0];
        let attribute = |name: &str| -> Vec<Vec3> {
            document.floats(&primitive["attributes"][name]).iter().map(|v| Vec3::from_slice(v)).collect()
        };
        assert_eq!(attribute("POSITION"), object.surface.positions);
        assert_eq!(attribute("NORMAL"), object.surface.normals);
        assert_eq!(
            document.integers(&primitive["indices"]).as_flattened(),
            object.surface.triangles.as_flattened()
        );
        assert_eq!(primitive["material"], node);
    }
    let eye = &json["materials"][1];
    assert_eq!(eye["pbrMetallicRoughness"]["baseColorFactor"], serde_json::json!([0.25, 0.5, 0.75, 1.0]));
    assert_eq!(eye["pbrMetallicRoughness"]["roughnessFactor"], 0.125);
    assert_eq!(eye["pbrMetallicRoughness"]["metallicFactor"], 0.0);
    assert_eq!(eye["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"], 0.5);
    assert_eq!(eye["extensions"]["KHR_materials_clearcoat"]["clearcoatRoughnessFactor"], 0.25);
    // The mesh has no colours, which count as white.
    let colors = document.floats(&json["meshes"][2]["primitives"][0]["attributes"]["COLOR_0"]);
    assert!(colors.iter().all(|c| c == &[1.0, 0.5, 0.25]));
    assert_eq!(json["materials"][2]["pbrMetallicRoughness"]["metallicFactor"], 1.0);
    assert!(json["materials"][2].get("extensions").is_none());
    let notes = gltf::notes(&world).join("\n");
    assert!(notes.contains("left out of the glTF file") && notes.contains("\"caught\""), "{notes}");
    assert!(!notes.contains("bell"), "vertex colours are exact: {notes}");
    // Without objects the document has none of it.
    let bare = Document::of(&gpu::world("[mesh]\nshape = 'plane'"));
    assert_eq!(bare.json["nodes"].as_array().unwrap().len(), 1);
    assert!(bare.json.get("extensionsUsed").is_none());
}

/// An image of an object is written with its factor, and its vertices have the uv of the mesh.
#[test]
fn images_of_objects_are_kept() {
    let text = "[mesh]\nshape = 'plane'\n[[objects]]\nname = 'bell'\nmesh = { shape = 'sphere', scale = 0.1 }\n\
                [[objects]]\nname = 'sign'\nmesh = { shape = 'plane', scale = 0.2 }\n\
                material.color = { map = 'sign.png', value = [0.5, 1, 1] }";
    let source = Folder::new();
    let map = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255, 255 * x as u8, 0]));
    map.save(source.path().join("sign.png")).unwrap();
    let path = source.write("scene.toml", text);
    let (scene, assets) = pelage_core::Scene::load(std::path::Path::new(&path), &[]).unwrap();
    let world = World::load(scene, &assets).unwrap();
    let folder = Folder::new();
    let written = gltf::write(&world, &lapped(&world), &textures(), folder.path()).unwrap();
    assert_eq!(folder.names(), ["fur.bin", "fur.gltf", "object2.png"]);
    assert_eq!(written[2], folder.path().join("object2.png"));
    let json: Value = serde_json::from_slice(&std::fs::read(&written[0]).unwrap()).unwrap();
    let document = Document { json, bin: std::fs::read(&written[1]).unwrap() };
    let json = &document.json;
    assert_eq!(json["materials"][2]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
    assert!(json["materials"][1]["pbrMetallicRoughness"].get("baseColorTexture").is_none());
    assert_eq!(json["textures"][0]["source"], 0);
    assert_eq!(json["images"][0]["uri"], "object2.png");
    // Half of the red is 188 in sRGB.
    let image = image::open(&written[2]).unwrap().to_rgb8();
    assert_eq!(image.as_raw(), &[188, 0, 0, 188, 255, 0]);
    let attributes = &json["meshes"][2]["primitives"][0]["attributes"];
    let uv = document.floats(&attributes["TEXCOORD_0"]);
    let indices = document.integers(&json["meshes"][2]["primitives"][0]["indices"]).as_flattened();
    let wanted = world.objects[1].surface.corner_uv.iter().flatten().flatten();
    for (i, wanted) in indices.iter().zip(wanted) {
        assert_eq!(uv[*i as usize], [wanted.x, 1.0 - wanted.y]);
    }
    assert!(attributes.get("COLOR_0").is_none());
}
