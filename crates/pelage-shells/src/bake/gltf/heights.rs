//! How much of its height the fur keeps at each vertex of the skin: less where it would fold over.

use super::points::{Point, scalar};
use glam::Vec3;
use pelage_core::scene::Scalar;
use pelage_core::{Result, Skin, World};
use pelage_fur::groom;
use pelage_fur::shell_prisms::SPREAD_ROUNDS;
use pelage_fur::surface;

/// As `FOLD_STEPS`, the part kept a step, the least area and `STEEPEST` of shaders/shell_prisms.wgsl.
const FOLD_STEPS: u32 = 16;
const STEP: f32 = 0.82;
const LEAST_AREA: f32 = 0.2;
const STEEPEST: f32 = 0.8;

/// Part of its height, 0..1, that the shell keeps over each vertex when it is raised along `upright`. As shaders/shell_prisms.wgsl lowers it.
///
/// # Errors
/// [`pelage_core::Error::Unsupported`] if the map of the undercoat's height is not loaded.
// [Andersen2016] sec. 3
pub(super) fn kept(world: &World, upright: &[Vec3]) -> Result<Vec<f32>> {
    let (skin, scene) = (&world.skin, &world.scene);
    let height = if groom::has_undercoat(scene) {
        scene.undercoat.height.clone()
    } else {
        Scalar::Constant(0.5 * scene.guard.length.max().max(0.02))
    };
    let uv = surface::vertex_uv(skin);
    let wanted = (0..skin.positions.len()).map(|v| {
        let at = Point {
            position: skin.positions[v],
            normal: skin.normals[v],
            upright: upright[v],
            uv: skin.corner_uv.is_some().then(|| uv[v].into()),
            color: skin.colors[v],
        };
        Ok(scalar(world, "undercoat.height", &height, &at)?.max(0.0))
    });
    let wanted: Vec<f32> = wanted.collect::<Result<_>>()?;
    let mut reach = wanted.clone();
    for triangle in &skin.triangles {
        let corners = triangle.map(|v| v as usize);
        let part = unfolded(skin, upright, &wanted, corners);
        for v in corners {
            reach[v] = reach[v].min(part * wanted[v]);
        }
    }
    for _ in 0..SPREAD_ROUNDS {
        let before = reach.clone();
        for triangle in &skin.triangles {
            for k in 0..3 {
                let [a, b] = [triangle[k] as usize, triangle[(k + 1) % 3] as usize];
                let rise = STEEPEST * skin.positions[a].distance(skin.positions[b]);
                reach[a] = reach[a].min(before[b] + rise);
                reach[b] = reach[b].min(before[a] + rise);
            }
        }
    }
    Ok(reach.iter().zip(&wanted).map(|(reach, wanted)| (reach / wanted.max(1e-4)).clamp(0.0, 1.0)).collect())
}

/// Part of the heights to which a triangle can be raised before its prism turns over.
fn unfolded(skin: &Skin, upright: &[Vec3], heights: &[f32], triangle: [usize; 3]) -> f32 {
    let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
    let flat = area(triangle.map(|v| skin.positions[v]));
    let mut part = 1.0;
    for _ in 1..FOLD_STEPS {
        let raised = area(triangle.map(|v| skin.positions[v] + part * heights[v] * upright[v]));
        if raised.dot(flat) > LEAST_AREA * flat.length_squared() {
            break;
        }
        part *= STEP;
    }
    part
}
