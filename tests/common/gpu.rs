//! Worlds, buffers and small shaders for the tests that compare the passes with their CPU twins.

use bytemuck::Pod;
use glam::{Vec2, Vec3};
use pelage_core::assets::Assets;
use pelage_core::maps::{MapImage, MapSet};
use pelage_core::{Scene, Skin, World};
use pelage_fur::camera;
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::{Frame, FurParameters};
use pelage_fur::parameters::Maps;
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use pelage_gpu::kernel::{DEPTH_FORMAT, ID_FORMAT};
use pelage_gpu::recorder::{RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource, Scope, shader};
use pelage_render::prepare::Prepared;
use pelage_render::shaders;
use std::sync::OnceLock;

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
    let lights = pelage_core::light::lights_of(&scene, &assets).expect("lights");
    World { scene, skin, lights, maps: MapSet { images, notes: Vec::new() }, textures: None }
}

/// An image map of a function of uv, read at the texels' centres.
pub fn image(name: &str, color: bool, side: u32, value: impl Fn(f32, f32) -> [f32; 4]) -> MapImage {
    let centre = |i: u32| (i as f32 + 0.5) / side as f32;
    let texels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| value(centre(x), 1.0 - centre(y))).collect();
    MapImage { name: name.into(), color, width: side, height: side, texels }
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
    Skin { positions, normals, colors, triangles, corner_uv: None, notes: Vec::new() }
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
    camera::frame(&world.scene.camera, film, Vec2::ZERO, Vec2::ZERO, world.scene.render.seed)
}

/// A prepared world with what its twins read.
pub struct Fixture {
    /// The world.
    pub world: World,
    /// Steps 1 to 3, done.
    pub prepared: Prepared<'static>,
    /// The shell as read back.
    pub shell: Shell,
    /// The groom as packed; its `fur` is not that of the renderer.
    pub packed: PackedGroom,
    /// Undercoat and lattice as the passes read them.
    pub fur: FurParameters,
}

impl Fixture {
    /// Prepares a world.
    pub fn new(gpu: &'static Gpu, world: World) -> Self {
        let frame = frame(&world);
        let prepared = Prepared::new(gpu, &world, &frame, &mut Timings::default()).expect("steps 1 to 3");
        let packed = groom::pack(&world).expect("a groom");
        let fur = prepared.fur;
        let mut fixture = Self { world, prepared, shell: Shell::default(), packed, fur };
        fixture.shell = Shell {
            vertices: fixture.read("shell_vertices", fixture.world.skin.positions.len()),
            prisms: fixture.read("prisms", fixture.world.skin.triangles.len()),
            corner_uv: match &fixture.world.skin.corner_uv {
                Some(uv) => uv.iter().flatten().map(|uv| uv.to_array()).collect(),
                None => vec![[0.0; 2]; 3 * fixture.world.skin.triangles.len()],
            },
            light_reach: fur.light_reach,
        };
        fixture
    }

    /// The first `count` elements of a buffer of the prepared world or of its strands.
    pub fn read<T: Pod>(&self, name: &str, count: usize) -> Vec<T> {
        let of_strands = || self.prepared.resident.as_ref().and_then(|s| s.buffer(name));
        let buffer =
            self.prepared.buffer(name).or_else(of_strands).unwrap_or_else(|| panic!("no buffer {name}"));
        self.prepared.gpu.read(buffer, (count * size_of::<T>()) as u64).expect("a read-back")
    }

    /// The groom and its maps.
    pub fn maps(&self) -> Maps<'_> {
        Maps { groom: &self.packed.groom, texels: &self.packed.texels }
    }

    /// The stored volume; empty where it is evaluated.
    pub fn cells(&self) -> Vec<u32> {
        if self.fur.storage == 1 {
            self.read("cells", self.prepared.subelements as usize)
        } else {
            Vec::new()
        }
    }

    /// The undercoat with the stored volume `cells`, or evaluated where that is empty.
    pub fn undercoat<'a>(&'a self, cells: &'a [u32]) -> Undercoat<'a> {
        Undercoat { fur: &self.fur, noise: self.noise(), shell: &self.shell, cells }
    }

    /// The noise of the scene's seed.
    pub fn noise(&self) -> Field {
        Field::new(self.world.scene.render.seed)
    }

    /// Guard hairs.
    pub fn strands(&self) -> usize {
        self.prepared.strands as usize
    }

    /// Vertices of all strands.
    pub fn strand_vertices(&self) -> Vec<[f32; 4]> {
        self.read("strand_vertices", self.strands() * (self.prepared.segments as usize + 1))
    }
}

/// A fragment as the lists hold it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Depth, cm.
    pub z: f32,
    /// Kind and id.
    pub source: u32,
    /// Premultiplied.
    pub color: [f32; 4],
}

/// A tile with the buffers that steps 4 to 7 write.
pub struct Tile {
    /// Its frame globals.
    pub frame: Frame,
    buffers: Vec<Buffer>,
    ids: wgpu::Texture,
    views: [wgpu::TextureView; 2],
    capacity: u64,
}

impl Tile {
    /// A tile of `size` samples at `origin` of a film of `film` samples, with room for `capacity`
    /// fragments.
    pub fn new(fixture: &Fixture, film: [u32; 2], origin: [i32; 2], size: [u32; 2], capacity: u64) -> Self {
        let gpu = fixture.prepared.gpu;
        let scene = &fixture.world.scene;
        let mut frame = camera::frame(&scene.camera, film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
        frame.tile_origin = origin;
        frame.tile_size = size;
        frame.node_capacity = capacity as u32;
        let samples = u64::from(size[0] * size[1]);
        let buffers = vec![
            gpu.uniform("frame", &frame).unwrap(),
            gpu.storage("base_records", 5, samples * 16).unwrap(),
            gpu.storage("fragment_lists", 6, (1 + samples + 5 * capacity) * 4).unwrap(),
        ];
        use wgpu::TextureUsages as U;
        let texture = |format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let ids = texture(ID_FORMAT, U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC);
        let depth = texture(DEPTH_FORMAT, U::RENDER_ATTACHMENT);
        let views = [&ids, &depth].map(|t| t.create_view(&Default::default()));
        Self { frame, buffers, ids, views, capacity }
    }

    /// The prepared world's buffers and the tile's.
    pub fn scope<'a>(&'a self, fixture: &'a Fixture) -> Scope<'a> {
        let scope = fixture.prepared.scope().with(&self.buffers.iter().collect::<Vec<_>>());
        scope.and("triangle_ids", Resource::Texture(&self.views[0]))
    }

    /// What raster passes write to.
    pub fn targets(&self) -> RasterTargets<'_> {
        RasterTargets { ids: &self.views[0], depth: &self.views[1], size: self.frame.tile_size }
    }

    /// A buffer by its name.
    pub fn buffer(&self, name: &str) -> &Buffer {
        self.buffers.iter().find(|b| b.name == name).expect("a buffer of the tile")
    }

    /// Step 4.
    pub fn draw_base(&self, fixture: &Fixture) {
        let mut recorder = Recorder::new(fixture.prepared.gpu);
        let pass = &fixture.prepared.passes.base_raster;
        pass.record(&mut recorder, &self.scope(fixture), &self.targets(), fixture.prepared.triangles)
            .unwrap();
        recorder.submit(&mut Timings::default()).unwrap();
    }

    /// Step 5's entries.
    pub fn draw_entries(&self, fixture: &Fixture) {
        let p = &fixture.prepared;
        let mut recorder = Recorder::new(p.gpu);
        let pass = &p.passes.shell_entry;
        pass.record(&mut recorder, &self.scope(fixture), &self.targets(), p.triangles, p.walls).unwrap();
        recorder.submit(&mut Timings::default()).unwrap();
    }

    /// Base fragments, row by row.
    pub fn base_records(&self, gpu: &Gpu) -> Vec<[u32; 4]> {
        let [w, h] = self.frame.tile_size;
        gpu.read(self.buffer("base_records"), u64::from(w * h) * 16).unwrap()
    }

    /// The triangle numbers, row by row; 0 where there is none, else the number + 1.
    pub fn triangle_ids(&self, gpu: &Gpu) -> Vec<u32> {
        let [w, h] = self.frame.tile_size;
        let row = (w * 4).next_multiple_of(256);
        let copy = gpu.storage("staging", 0, u64::from(row * h)).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.ids.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &copy.raw, layout },
            self.ids.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let words: Vec<u32> = gpu.read(&copy, u64::from(row * h)).unwrap();
        words.chunks(row as usize / 4).flat_map(|line| line[..w as usize].to_vec()).collect()
    }

    /// The fragments of each sample by depth and source, row by row.
    pub fn lists(&self, gpu: &Gpu) -> Vec<Vec<Node>> {
        let buffer = self.buffer("fragment_lists");
        let words: Vec<u32> = gpu.read(buffer, buffer.size).unwrap();
        assert!(u64::from(words[0]) <= self.capacity, "{} fragments, room for {}", words[0], self.capacity);
        let [w, h] = self.frame.tile_size;
        let samples = (w * h) as usize;
        let half = |word: u32| half::f16::from_bits(word as u16).to_f32();
        let mut seen = 0;
        let lists: Vec<Vec<Node>> = (0..samples)
            .map(|i| {
                let mut nodes = Vec::new();
                let mut node = words[1 + i];
                while node != 0 {
                    let at = &words[1 + samples + 5 * (node as usize - 1)..][..5];
                    let color = [half(at[3]), half(at[3] >> 16), half(at[4]), half(at[4] >> 16)];
                    nodes.push(Node { z: f32::from_bits(at[1]), source: at[2], color });
                    node = at[0];
                }
                nodes.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.source.cmp(&b.source)));
                seen += nodes.len();
                nodes
            })
            .collect();
        assert_eq!(seen, words[0] as usize, "every counted fragment is in one list");
        lists
    }
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
