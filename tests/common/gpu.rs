//! Worlds, buffers and small shaders for the tests that compare the passes with their CPU twins.

use bytemuck::Pod;
use glam::{Vec2, Vec3};
use pelage_core::assets::Assets;
use pelage_core::maps::{MapImage, MapSet};
use pelage_core::{Scene, Skin, World};
use pelage_fur::layout::Frame;
use pelage_gpu::{Buffer, Gpu, shader};
use pelage_render::probe::{PreparedWorld, Probe, frame_of};
use pelage_render::shaders;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// The adapter; `None`, with a note, where there is none. With `PELAGE_GPU=required` that is a
/// failure.
pub fn open() -> Option<&'static Gpu> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    match GPU.get_or_init(|| pelage_render::open().map_err(|e| e.to_string())) {
        Ok(gpu) => Some(gpu),
        Err(e) if std::env::var("PELAGE_GPU").is_ok_and(|v| v == "required") => panic!("{e}"),
        Err(e) => {
            eprintln!("note: skipped, {e}");
            None
        }
    }
}

/// The world of a scene text.
pub fn world(text: &str) -> World {
    let scene = Scene::parse(text, "test.toml", &[]).expect("a valid scene");
    World::load(scene, &Assets::default()).expect("a world")
}

/// The world of a scene text on a skin of its own, with image maps of its own.
pub fn world_on(text: &str, skin: Option<Skin>, images: Vec<MapImage>) -> World {
    // A scene needs a mesh, even where the skin is given.
    let shape: &[String] = if skin.is_some() { &["mesh.shape=plane".into()] } else { &[] };
    let scene = Scene::parse(text, "test.toml", shape).expect("a valid scene");
    let assets = Assets::default();
    let skin = skin
        .unwrap_or_else(|| pelage_core::mesh::load(&scene.mesh, &|name| assets.find(name)).expect("a mesh"));
    let lights = pelage_core::light::lights_of(&scene, &assets, &mut Vec::new()).expect("lights");
    World {
        scene,
        skin,
        objects: Vec::new(),
        lights,
        maps: MapSet { images, notes: Vec::new() },
        textures: None,
        notes: Vec::new(),
    }
}

/// An image map of a function of uv, read at the texels' centres.
pub fn image(name: &str, color: bool, side: u32, value: impl Fn(f32, f32) -> [f32; 4]) -> MapImage {
    let centre = |i: u32| (i as f32 + 0.5) / side as f32;
    let texels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| value(centre(x), 1.0 - centre(y))).collect();
    MapImage { name: name.into(), layer: String::new(), color, width: side, height: side, texels }
}

/// A skin of triangles as they are: nothing is welded, dropped or turned.
pub fn skin(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Skin {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        t.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
    }
    let normals = normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect();
    let colors = vec![Vec3::ONE; positions.len()];
    Skin { positions, normals, colors, triangles, ..Skin::default() }
}

/// The uv of each vertex: that of its last corner.
pub fn vertex_uv(skin: &Skin) -> Vec<[f32; 2]> {
    let mut uv = vec![[0.0; 2]; skin.positions.len()];
    for (triangle, corners) in skin.triangles.iter().zip(skin.corner_uv.iter().flatten()) {
        (0..3).for_each(|k| uv[triangle[k] as usize] = corners[k].to_array());
    }
    uv
}

/// A bumpy square of `n` x `n` quads, 1 cm a quad, facing +y, its inner vertices displaced.
pub fn jittered_grid(n: u32, displacement: f32) -> Skin {
    use pelage_fur::random::random;
    let mut positions = Vec::new();
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        let seed = j * (n + 1) + i;
        let inner = i > 0 && j > 0 && i < n && j < n;
        let d = if inner { displacement } else { 0.0 };
        let r = |k| d * (2.0 * random(seed, k) - 1.0);
        positions.push(Vec3::new(i as f32 + r(0), 0.5 * r(1), j as f32 + r(2)));
    }
    let mut triangles = Vec::new();
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * (n + 1) + i);
        triangles.extend([[a, c, b], [a, d, c]]);
    }
    skin(positions, triangles)
}

/// The frame of a world's whole film, of one sample a pixel.
pub fn frame(world: &World) -> Frame {
    let film = [world.scene.film.width, world.scene.film.height];
    frame_of(world, film)
}

/// A prepared world with what its twins read.
pub struct Fixture(Arc<PreparedWorld<'static>>);

impl Deref for Fixture {
    type Target = PreparedWorld<'static>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl Fixture {
    /// Runs steps 1 to 3.
    pub fn new(gpu: &'static Gpu, world: World) -> Self {
        Self::with_features(gpu, world, false)
    }

    /// Runs steps 1 to 3 with kernels that make features if `features`.
    pub fn with_features(gpu: &'static Gpu, world: World, features: bool) -> Self {
        let film = [world.scene.film.width, world.scene.film.height];
        let prepared = PreparedWorld::with_features(gpu, world, film, features);
        Self(Arc::new(prepared.expect("steps 1 to 3")))
    }

    /// The first `count` elements of a buffer of the prepared world or of its strands.
    pub fn read<T: Pod>(&self, name: &str, count: usize) -> Vec<T> {
        self.0.read(name, count).expect("a read-back")
    }

    /// Guard hairs.
    pub fn strands(&self) -> usize {
        self.prepared.strands as usize
    }

    /// Vertices of all strands.
    pub fn strand_vertices(&self) -> Vec<[f32; 4]> {
        self.read("strand_vertices", self.strands() * (self.prepared.segments as usize + 1))
    }

    /// A tile of `size` samples at `origin` of a film of `film` samples, with room for `capacity`
    /// fragments.
    pub fn tile(&self, film: [u32; 2], origin: [i32; 2], size: [u32; 2], capacity: u64) -> Probe<'static> {
        Probe::new(&self.0, film, origin, size, capacity).expect("a tile")
    }
}

/// The triangle numbers of a tile, row by row; 0 where there is none, else the number + 1.
pub fn triangle_ids(tile: &Probe<'_>) -> Vec<u32> {
    let gpu = tile.prepared.gpu;
    let ids = tile.buffers().ids();
    let [w, h] = tile.frame.tile_size;
    let row = (w * 4).next_multiple_of(256);
    let copy = gpu.storage("staging", 0, u64::from(row * h)).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        ids.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &copy.raw, layout },
        ids.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let words: Vec<u32> = gpu.read(&copy, u64::from(row * h)).unwrap();
    words.chunks(row as usize / 4).flat_map(|line| line[..w as usize].to_vec()).collect()
}

/// Runs WGSL `code` (with `#import` lines) whose entry point `main` has workgroups of 64 and reads
/// `input` (binding 50) and writes `output` (binding 51); `more` are further buffers by binding.
/// Returns `count` elements of `output`.
pub fn evaluate<I: Pod, O: Pod>(
    gpu: &Gpu,
    code: &str,
    more: &[(u32, &Buffer)],
    input: &[I],
    count: usize,
) -> Vec<O> {
    let text = shader::resolve_text(shaders::text, "test", code).unwrap().text;
    let input = gpu.upload("input", 0, input).unwrap();
    let output = gpu.storage("output", 0, (count * size_of::<O>()) as u64).unwrap();
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    gpu.check("a shader of a test").unwrap();
    let entries: Vec<_> = [(50, &input), (51, &output)]
        .iter()
        .chain(more)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: buffer.raw.as_entire_binding(),
        })
        .collect();
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&output, (count * size_of::<O>()) as u64).unwrap()
}

/// Fails unless `actual` and `wanted` differ by at most `tolerance` x (1 + |wanted|).
#[track_caller]
pub fn close(actual: f32, wanted: f32, tolerance: f32, what: impl std::fmt::Display) {
    assert!(
        (actual - wanted).abs() <= tolerance * (1.0 + wanted.abs()),
        "{what}: {actual} is not {wanted} within {tolerance}"
    );
}

/// A skin scaled about the origin, with uv from its x and z: one unit of uv is `unit` cm.
pub fn scaled(mut skin: Skin, factor: f32, unit: f32) -> Skin {
    skin.positions.iter_mut().for_each(|p| *p *= factor);
    let uv = |v: u32| skin.positions[v as usize];
    skin.corner_uv =
        Some(skin.triangles.iter().map(|t| t.map(|v| Vec2::new(uv(v).x, uv(v).z) / unit)).collect());
    skin
}
