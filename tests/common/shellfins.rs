//! Small furs of shells and fins, with synthetic textures.

use super::gpu::{self, skin, world_on};
use glam::Vec3;
use pelage_core::scene::BakeSource;
use pelage_core::{Skin, World};
use pelage_fur::layout::{Frame, ShellVertex};
use pelage_fur::random::random;
use pelage_gpu::Gpu;
use pelage_gpu::recorder::Timings;
use pelage_shells::bake::{FurTextures, Manifest, Texture};
use pelage_shells::shellfin::{Pose, Rows, Shellfins};

/// A closed body of eight triangles with uv, 2 cm across.
pub fn octahedron() -> Skin {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z].to_vec();
    let faces =
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]].to_vec();
    let mut body = skin(corners, faces);
    let uv = |v: u32| body.positions[v as usize].truncate() * 0.5 + body.positions[v as usize].z * 0.21;
    let corner_uv = body.triangles.iter().map(|t| t.map(uv)).collect();
    body.corner_uv = Some(corner_uv);
    body
}

/// A fur on [`octahedron`] seen from the side; `text` is added to the scene, `[shells]` first.
pub fn fur_world(text: &str) -> World {
    let head = "[camera]\neye = [3, 2, 6]\nfov = 30\n[film]\nwidth = 64\nheight = 48\n[render]\nfur = 'shells'\n\
        [[lights]]\ndirection = [0.5, 0.8, 0.4]\nirradiance = [3, 2.8, 2.5]\n\
        [[lights]]\ndirection = [-0.8, 0.1, 0.3]\nirradiance = [0.7, 0.9, 1.2]\n\
        [guard]\ndensity = 200\nlength = 0.5\ncomb = 0.4\ncomb_direction = [1, 0, 0]\ngravity = 0.2\nspread = 8\n\
        [undercoat]\nheight = 0.3\ndensity = 8000\nlean = 0.2\n[shells]\nmapping = 'uv'\n";
    world_on(&format!("{head}{text}"), Some(octahedron()), Vec::new())
}

/// Textures of `layers` layers: `texel(layer, u, v, guard)` gives linear premultiplied RGBA. The
/// fin is that of layer `layers`.
pub fn textures(
    source: BakeSource,
    layers: u32,
    side: u32,
    guard: bool,
    texel: impl Fn(u32, f32, f32, bool) -> [f32; 4],
) -> FurTextures {
    let texture = |layer: u32, guard: bool| {
        let at = |i: u32| (i as f32 + 0.5) / side as f32;
        let texels = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
        let texels = texels.map(|(x, y)| texel(layer, at(x), at(y), guard)).collect();
        Texture { width: side, height: side, texels }
    };
    let all = |guard: bool| (0..layers).map(|l| texture(l, guard)).collect();
    FurTextures {
        layers: all(false),
        guard: if guard { all(true) } else { Vec::new() },
        fin: texture(layers, false),
        fin_guard: if guard { texture(layers, true) } else { Texture::default() },
        manifest: Manifest {
            version: 1,
            generator: "test".into(),
            source,
            seed: 0,
            layers,
            resolution: [side; 2],
            fin_resolution: [side; 2],
            patch: [1.5; 2],
            fin_length: 2.0,
            fin_depth: 0.1,
            height: 0.4,
            spacing: 0.4 / layers as f32,
            summary: Vec::new(),
        },
    }
}

/// Even layers: the colour and coverage of a layer are the same everywhere.
pub fn even(source: BakeSource, layers: u32, guard: bool) -> FurTextures {
    textures(source, layers, 4, guard, |layer, _, _, part| {
        let r = |k| random(layer + 17, k);
        let coverage = 0.15 + 0.3 * r(0);
        let whole = [0.8 * r(1), 0.8 * r(2), 0.8 * r(3)].map(|c| c * coverage);
        let share = if part { 0.4 } else { 1.0 };
        [whole[0] * share, whole[1] * share, whole[2] * share, coverage * share]
    })
}

/// A fur on the GPU with the rows of its view.
pub struct Fur<'w> {
    /// The fur.
    pub fur: Shellfins<'static>,
    /// The rows.
    pub rows: Rows,
    /// The view.
    pub frame: Frame,
    /// The textures.
    pub textures: FurTextures,
    /// What it grows on.
    pub world: &'w World,
}

impl Fur<'static> {
    /// Uploads a fur and places its rows. The world lives as long as the test.
    pub fn new(gpu: &'static Gpu, world: World, textures: FurTextures, bend: Vec3) -> Self {
        let world: &'static World = Box::leak(Box::new(world));
        let frame = gpu::frame(world);
        let mut timings = Timings::default();
        let fur = Shellfins::new(gpu, world, &textures, &frame, &mut timings).expect("a fur");
        let rows = fur.rows(&frame, &Pose { bend }, &mut timings).expect("rows");
        Self { fur, rows, frame, textures, world }
    }

    /// The skin's vertices.
    pub fn vertices(&self, gpu: &Gpu) -> Vec<ShellVertex> {
        let buffer = self.fur.prepared().buffer("shell_vertices").expect("the shell");
        gpu.read(buffer, u64::from(self.rows.shellfin.vertices) * 32).expect("a read-back")
    }
}
