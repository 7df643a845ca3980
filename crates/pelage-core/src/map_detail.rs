//! Notes about maps with more detail than the mesh can carry.
//!
//! Heights are read at the vertices of the skin; colours and densities of the undercoat and colours
//! of the skin at the columns of the optical-depth lattice, about 2 mm apart but at most 8 along an
//! edge. Between these points they are interpolated.

use crate::maps::{MapImage, MapSet, VERTEX_COLOR};
use crate::scene::{Color, Scalar};
use crate::{Scene, Skin};
use glam::{Vec2, Vec3, Vec4};

/// Root mean square of the difference between a map and what is interpolated, in units of the
/// texels, from which a note is given.
const MOST: f32 = 0.1;

/// About as many points are compared per map.
const POINTS: usize = 20_000;

/// Wanted distance between columns of the lattice, cm, and the largest number along an edge.
const COLUMNS: (f32, f32) = (0.2, 8.0);

/// A map and how the renderers read it.
struct Use<'a> {
    key: &'a str,
    image: &'a MapImage,
    /// Channel of a scalar; all three of a colour.
    channel: Option<usize>,
    /// Read only at the vertices.
    at_vertices: bool,
}

/// A note for each parameter whose map varies between the points at which it is read.
pub(crate) fn notes(scene: &Scene, skin: &Skin, maps: &MapSet) -> Vec<String> {
    let scalars =
        [("undercoat.height", &scene.undercoat.height, true), ("shells.length", &scene.shells.length, true)];
    let density = ("undercoat.density", &scene.undercoat.density, false);
    let colors = [
        ("undercoat.color_root", &scene.undercoat.color_root),
        ("undercoat.color_tip", &scene.undercoat.color_tip),
        ("base.color", &scene.base.color),
    ];
    let image = |name: &str, layer: &str, color| {
        let found = if name == VERTEX_COLOR { None } else { maps.index_of(name, layer, color) };
        found.map(|index| &maps.images[index])
    };
    let scalars = scalars.into_iter().chain([density]).filter_map(|(key, scalar, at_vertices)| {
        let Scalar::Mapped(map) = scalar else { return None };
        let channel = Some(map.channel.index());
        image(&map.map, &map.layer, false).map(|image| Use { key, image, channel, at_vertices })
    });
    let colors = colors.into_iter().filter_map(|(key, color)| {
        let Color::Mapped(map) = color else { return None };
        image(&map.map, &map.layer, true).map(|image| Use { key, image, channel: None, at_vertices: false })
    });
    scalars.chain(colors).filter_map(|of| note(&of, skin)).collect()
}

fn note(of: &Use<'_>, skin: &Skin) -> Option<String> {
    let triangles = skin.triangles.len();
    if triangles == 0 {
        return None;
    }
    let step = triangles.div_ceil(POINTS / 10);
    let looked: Vec<usize> = (0..triangles).step_by(step).collect();
    let (mut sum, mut count, mut widest) = (0f32, 0usize, 0f32);
    for t in &looked {
        let cells = cells(of, skin, *t);
        // At least two points along the edge of each cell.
        let wanted = (2.0 * POINTS as f32 / looked.len() as f32).sqrt();
        let points = wanted.max(2.0 * cells as f32) as u32;
        widest = widest.max(texels(of, skin, *t) / cells as f32);
        for j in 0..points {
            for i in 0..points - j {
                let l = (Vec2::new(i as f32, j as f32) + 1.0 / 3.0) / points as f32;
                let d = value(of, skin, *t, l) - interpolated(of, skin, *t, l, cells);
                sum += if of.channel.is_some() { d.x * d.x } else { d.length_squared() / 3.0 };
                count += 1;
            }
        }
    }
    let difference = (sum / count as f32).sqrt();
    if difference <= MOST {
        return None;
    }
    let level = ((widest / 4.0).log2().ceil() as u32).clamp(1, 6);
    let place = if of.at_vertices { "at the vertices of the mesh" } else { "at points between its vertices" };
    Some(format!(
        "{}: {} is read {place}, up to {widest:.0} texels apart, and loses its detail; mesh.subdivide = \
         {level} makes the triangles smaller",
        of.image.name, of.key
    ))
}

/// Cells along the edges of a triangle, at whose corners a map is read.
fn cells(of: &Use<'_>, skin: &Skin, t: usize) -> u32 {
    let edge = (2.309 * skin.triangle_area(t)).sqrt();
    if of.at_vertices { 1 } else { (edge / COLUMNS.0).round().clamp(1.0, COLUMNS.1) as u32 }
}

/// The map at barycentric coordinates `l` of a triangle: a scalar in the first component, or a
/// colour.
fn value(of: &Use<'_>, skin: &Skin, t: usize, l: Vec2) -> Vec3 {
    let mix = |[a, b, c]: [Vec3; 3]| a * (1.0 - l.x - l.y) + b * l.x + c * l.y;
    let texel = match &skin.corner_uv {
        Some(uv) => of.image.bilinear(mix(uv[t].map(|uv| uv.extend(0.0))).truncate()),
        None => {
            let normals = skin.triangles[t].map(|v| skin.normals[v as usize]);
            of.image.triplanar(mix(skin.corners(t)), mix(normals), 1.0)
        }
    };
    match of.channel {
        Some(channel) => Vec3::new(texel[channel], 0.0, 0.0),
        None => Vec4::from(texel).truncate(),
    }
}

/// The same, interpolated between the corners of the cell that contains the point.
fn interpolated(of: &Use<'_>, skin: &Skin, t: usize, l: Vec2, cells: u32) -> Vec3 {
    let n = cells as f32;
    let base = (l * n).floor();
    let r = l * n - base;
    let at = |x: f32, y: f32| value(of, skin, t, (base + Vec2::new(x, y)) / n);
    if r.x + r.y <= 1.0 {
        return at(0.0, 0.0) * (1.0 - r.x - r.y) + at(1.0, 0.0) * r.x + at(0.0, 1.0) * r.y;
    }
    at(1.0, 1.0) * (r.x + r.y - 1.0) + at(0.0, 1.0) * (1.0 - r.x) + at(1.0, 0.0) * (1.0 - r.y)
}

/// Length of a triangle's longest edge in the map, texels.
fn texels(of: &Use<'_>, skin: &Skin, t: usize) -> f32 {
    let size = Vec2::new(of.image.width as f32, of.image.height as f32);
    let corners = match &skin.corner_uv {
        Some(uv) => uv[t].map(|uv| (uv * size).extend(0.0)),
        None => skin.corners(t).map(|p| p / crate::maps::TRIPLANAR_CM * size.max_element()),
    };
    (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, skin_of};
    use crate::scene::Shape;

    /// A plane of two triangles per square of 5 cm, a map of 64 texels with a square hole, and the
    /// notes for it.
    fn noted(scene: &str, texel: fn(u32, u32) -> f32) -> Vec<String> {
        let scene =
            Scene::parse(&format!("[mesh]\nshape = \"plane\"\n{scene}"), "test", &[]).expect("a scene");
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(Vec2::from);
        let triangles = vec![[0, 2, 1], [1, 2, 3]];
        let mesh = crate::mesh::Mesh {
            positions: corners.map(|c| Vec3::new(10.0 * c.x, 0.0, 10.0 * c.y)).to_vec(),
            corner_uv: Some(triangles.iter().map(|t: &[u32; 3]| t.map(|v| corners[v as usize])).collect()),
            triangles,
            ..Default::default()
        };
        let texels = (0..64 * 64).map(|i| [texel(i % 64, i / 64); 4]).collect();
        let map = |color| MapImage {
            name: "m.png".into(),
            layer: String::new(),
            color,
            width: 64,
            height: 64,
            texels,
        };
        let images = vec![map(scene.undercoat.height == 0.8.into())];
        notes(&scene, &skin_of(mesh), &MapSet { images, notes: Vec::new() })
    }

    #[test]
    fn a_map_that_the_mesh_cannot_carry_is_noted_with_the_remedy() {
        let hole = |x: u32, y: u32| f32::from(!((22..43).contains(&x) && (22..43).contains(&y)));
        let height = "[undercoat]\nheight = { map = \"m.png\" }\n";
        let found = noted(height, hole);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].contains("undercoat.height") && found[0].contains("mesh.subdivide = 5"),
            "{found:?}"
        );
        // A map that triangles can carry gets no note, whatever its size.
        assert!(noted(height, |x, _| x as f32 / 64.0 * 0.2).is_empty());
        assert!(noted(height, |_, _| 1.0).is_empty());
        let color = "[undercoat]\nheight = 0.8\ncolor_tip = { map = \"m.png\" }\n";
        assert_eq!(noted(color, |x, y| f32::from((x / 2 + y / 2) % 2 == 0)).len(), 1);
        // Columns 8 texels apart show a hole whose edge is 16 wide.
        let soft = |x: u32, y: u32| (x.abs_diff(32).max(y.abs_diff(32)) as f32 / 16.0 - 0.5).clamp(0.0, 1.0);
        assert!(noted(color, soft).is_empty());
    }

    #[test]
    fn built_in_shapes_need_no_uv() {
        let mut skin = skin_of(shapes::shape(Shape::Sphere));
        skin.corner_uv = None;
        let scene = "[mesh]\nshape = \"sphere\"\n[undercoat]\nheight = { map = \"m.png\" }\n";
        let scene = Scene::parse(scene, "test", &[]).expect("a scene");
        let texels = (0..1024 * 1024u32).map(|i| [f32::from(i / 1024 % 2 == 0); 4]).collect();
        let images = vec![MapImage {
            name: "m.png".into(),
            layer: String::new(),
            color: false,
            width: 1024,
            height: 1024,
            texels,
        }];
        assert_eq!(notes(&scene, &skin, &MapSet { images, notes: Vec::new() }).len(), 1);
    }
}
