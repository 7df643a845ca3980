//! The hairs of a particle system, the layers and the fin baked from them, and fur drawn with
//! these.

use super::super::{FigureContent, FigureContext};
use super::canvas::Canvas;
use crate::report::{Table, number};
use glam::{Vec2, Vec3};
use pelage_core::Result;
use pelage_core::scene::Camera;
use pelage_shells::bake;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder.
    scene: String,
    /// Factor on the distance between the layers in the drawing.
    apart: f32,
}

/// Outline of the slab that is projected to the fin.
const CYAN: Vec3 = Vec3::new(0.0, 0.45, 0.6);
const SKIN: Vec3 = Vec3::new(0.55, 0.38, 0.3);
const FRAME: Vec3 = Vec3::new(0.3, 0.3, 0.3);

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let size = context.size();
    let (hairs, [edge, height]) = bake::particle_hairs(&world);
    let textures = bake::bake(&world)?;
    let slab = world.scene.bake.fin_slab * edge;
    let mut content = FigureContent::default();

    let mut canvas = Canvas::new(&camera(edge, height), size);
    let pixel = 0.5 * size[1] as f32 / (0.48 * (edge * edge * 2.0 + height * height).sqrt());
    ground(&mut canvas, edge);
    for hair in &hairs {
        // Roots at v = 0 are at the front of the fin.
        let root = Vec3::new(hair.root[0] * edge, 0.0, edge - hair.root[1] * edge);
        let at = |k: usize| {
            let offset = hair.knots[k].offset;
            root + Vec3::new(offset.x, offset.z, -offset.y)
        };
        for k in 1..hair.knots.len() {
            let width = |k: usize| (hair.knots[k].diameter * pixel).max(0.6);
            let ends = [(at(k - 1), width(k - 1)), (at(k), width(k))];
            canvas.strand(ends, [hair.knots[k - 1].color, hair.knots[k].color], 0.0);
        }
    }
    let [front, back] = [edge, edge - slab];
    wire_box(&mut canvas, [Vec3::new(0.0, 0.0, back), Vec3::new(edge, height, front)], CYAN);
    content.picture("hairs, the fin's slab", canvas.film());

    let spread = settings.apart * height;
    let mut canvas = Canvas::new(&camera(edge, spread), size);
    ground(&mut canvas, edge);
    let count = textures.layers.len();
    for (l, layer) in textures.layers.iter().enumerate() {
        let y = spread * (l as f32 + 0.5) / count as f32;
        let corner = |u: f32, v: f32| (Vec3::new(u * edge, y, edge - v * edge), Vec2::new(u, v));
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        canvas.quad(corners, layer, true);
        for k in 0..4 {
            canvas.line([corners[k].0, corners[(k + 1) % 4].0], Vec3::splat(0.75), 0.6, 0.0);
        }
    }
    content.picture(&format!("{count} layers, drawn apart"), canvas.film());

    let mut canvas = Canvas::new(&front_camera(edge, height), size);
    let corner = |u: f32, v: f32| (Vec3::new(u * edge, v * height, 0.0), Vec2::new(u, v));
    let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    canvas.quad(corners, &textures.fin, false);
    for k in 0..4 {
        canvas.line([corners[k].0, corners[(k + 1) % 4].0], CYAN, 1.2, 0.0);
    }
    content.picture("fin", canvas.film());

    for (label, set) in [("without texture", "base"), ("layers", "false"), ("layers and fins", "true")] {
        let set = match set {
            "base" => ["shells.shells=false".to_owned(), "shells.fins=false".to_owned()],
            fins => ["shells.shells=true".to_owned(), format!("shells.fins={fins}")],
        };
        let (world, assets) = context.load(&settings.scene, &set)?;
        content.images.push(context.render_panel(label, &world, &assets)?);
    }

    let mut rows = Vec::new();
    for (l, of) in textures.manifest.summary.iter().enumerate() {
        let high = textures.manifest.spacing * (l as f32 + 0.5);
        rows.push(vec![
            l.to_string(),
            number(f64::from(high)),
            number(of.coverage.into()),
            number(of.optical_depth.into()),
        ]);
        if l == 0 || l + 1 == count {
            content.value(&format!("coverage of layer {l}"), of.coverage.into(), 0.005);
        }
    }
    content.value("hairs", hairs.len() as f64, 0.0);
    let head = ["layer", "height, cm", "mean coverage", "optical depth"];
    content.table(&Table::new("The layers, from the skin outwards.", &head, rows));
    Ok(content)
}

/// A view of the box from the front, the right and above.
fn camera(edge: f32, height: f32) -> Camera {
    let middle = Vec3::new(0.5 * edge, 0.46 * height, 0.5 * edge);
    let reach = (edge * edge * 2.0 + height * height).sqrt();
    Camera {
        eye: (middle + 2.25 * reach * Vec3::new(0.42, 0.5, 1.0).normalize()).into(),
        target: middle.into(),
        fov: 24.0,
        ..Camera::default()
    }
}

/// A view of the box's front.
fn front_camera(edge: f32, height: f32) -> Camera {
    let middle = Vec3::new(0.5 * edge, 0.5 * height, 0.0);
    let far = 4.0 * edge.max(height);
    let fov = 2.0 * (0.62 * edge.max(height) / far).atan().to_degrees();
    Camera { eye: (middle + far * Vec3::Z).into(), target: middle.into(), fov, ..Camera::default() }
}

fn ground(canvas: &mut Canvas, edge: f32) {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X].map(|p| p * edge);
    canvas.triangle([a, b, c], SKIN);
    canvas.triangle([a, c, d], SKIN);
    for line in [[a, b], [b, c], [c, d], [d, a]] {
        canvas.line(line, FRAME, 1.0, 0.01 * edge);
    }
}

/// The twelve edges of a box.
fn wire_box(canvas: &mut Canvas, [low, high]: [Vec3; 2], color: Vec3) {
    let corner = |k: usize| {
        let pick = |bit: usize| if k >> bit & 1 == 1 { high[bit] } else { low[bit] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    for k in 0..8 {
        for bit in (0..3).filter(|bit| k >> bit & 1 == 0) {
            canvas.line([corner(k), corner(k | 1 << bit)], color, 1.4, 1e3);
        }
    }
}
