//! Twin of `shaders/base_raster.wgsl`: the nearest triangle of the skin under each sample, by exact
//! integer rasterisation.

use crate::twin::lattice;
use glam::{Vec2, Vec3};
use half::f16;
use pelage_fur::layout::{Frame, FurParameters};
use pelage_fur::octahedral;
use pelage_fur::shell::Shell;
use pelage_fur::view::{film_from_world, sample_ray};

/// Depth of a sample at which there is no skin.
pub const NO_BASE: f32 = 1e30;

/// Grid points per sample to which corners are rounded.
const GRID: f32 = 256.0;

/// Position of a sample relative to a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cover {
    /// Whether the triangle is counter-clockwise as seen from the camera.
    pub front: bool,
    /// Least signed distance of the sample's centre from the lines through the edges, in samples;
    /// negative outside.
    pub margin: f32,
}

/// A triangle with its corners on the rasteriser's grid.
#[derive(Debug, Clone, Copy)]
pub struct Projected {
    corners: [[i64; 2]; 3],
    front: bool,
}

/// Rounds a triangle's corners to the grid of 1/256 sample; `None` if one is in front of the near
/// plane or all lie on a line.
pub fn project(frame: &Frame, corners: [Vec3; 3]) -> Option<Projected> {
    let film = corners.map(|p| film_from_world(frame, p));
    if film.iter().any(|p| p.z < frame.near) {
        return None;
    }
    let mut c = film.map(|p| [p.x, p.y].map(|x| (x * GRID).round_ties_even() as i64));
    let area = cross(c[0], c[1], c[2]);
    if area == 0 {
        return None;
    }
    // y points down, so a counter-clockwise triangle has a negative area.
    if area < 0 {
        c.swap(1, 2);
    }
    Some(Projected { corners: c, front: area < 0 })
}

fn cross(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

impl Projected {
    /// Position of sample `xy` of the tile relative to the triangle, which covers it if the margin
    /// is not negative. By the top-left rule, a centre on an edge belongs to the triangle to the
    /// right of the edge or below it.
    pub fn cover(&self, frame: &Frame, xy: [u32; 2]) -> Cover {
        let p = [0, 1].map(|k| (i64::from(frame.tile_origin[k]) + i64::from(xy[k])) * 256 + 128);
        let margin = (0..3)
            .map(|k| {
                let (a, b) = (self.corners[k], self.corners[(k + 1) % 3]);
                let d = [b[0] - a[0], b[1] - a[1]];
                let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
                let inside = cross(a, b, p);
                let length = ((d[0] * d[0] + d[1] * d[1]) as f32).sqrt();
                match inside {
                    0 if top_left => 0.0,
                    0 => -f32::MIN_POSITIVE,
                    _ => inside as f32 / length / GRID,
                }
            })
            .fold(f32::INFINITY, f32::min);
        Cover { front: self.front, margin }
    }

    /// Ranges of x and y of the tile's samples that the triangle may cover.
    pub fn bounds(&self, frame: &Frame) -> [std::ops::Range<u32>; 2] {
        [0, 1].map(|k| {
            let low = self.corners.iter().map(|c| c[k]).min().unwrap_or(0).div_euclid(256);
            let high = self.corners.iter().map(|c| c[k]).max().unwrap_or(0).div_euclid(256) + 1;
            let of_tile =
                |x: i64| (x - i64::from(frame.tile_origin[k])).clamp(0, i64::from(frame.tile_size[k]));
            of_tile(low) as u32..of_tile(high) as u32
        })
    }
}

/// Depth (cm) at which the ray of a sample meets the plane through three points.
pub fn plane_depth(frame: &Frame, corners: [Vec3; 3], ray: Vec3) -> f32 {
    let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    (corners[0] - Vec3::from(frame.eye)).dot(n) / ray.dot(n)
}

/// The nearest triangle under each sample of the tile, row by row.
pub fn triangles(frame: &Frame, shell: &Shell) -> Vec<Option<u32>> {
    let [width, height] = frame.tile_size;
    let mut nearest = vec![(NO_BASE, None); (width * height) as usize];
    for (i, prism) in shell.prisms.iter().enumerate() {
        let corners = prism.vertices.map(|v| Vec3::from(shell.vertices[v as usize].position));
        let Some(projected) = project(frame, corners) else { continue };
        let [columns, rows] = projected.bounds(frame);
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let z = plane_depth(frame, corners, sample_ray(frame, [x, y]));
            let best = &mut nearest[(y * width + x) as usize];
            if projected.cover(frame, [x, y]).margin >= 0.0 && z < best.0 {
                *best = (z, Some(i as u32));
            }
        }
    }
    nearest.into_iter().map(|(_, triangle)| triangle).collect()
}

/// Unpacked base record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// Depth, cm.
    pub z: f32,
    /// Radiance towards the camera.
    pub radiance: Vec3,
    /// Smoothed unit normal.
    pub normal: Vec3,
    /// Share of the background that shows through; 0 except on shadow catchers.
    pub transparency: f32,
}

/// Shades sample `xy`, at which `triangle` is nearest. `base_light`: radiance of the skin at each
/// column of the lattice, three halves.
pub fn shade(
    frame: &Frame,
    shell: &Shell,
    fur: &FurParameters,
    base_light: &[[u32; 2]],
    triangle: u32,
    xy: [u32; 2],
) -> Base {
    let mut place = shell.enter(triangle);
    let n = place.e1.cross(place.e2);
    let ray = sample_ray(frame, xy);
    let z = (place.p0 - Vec3::from(frame.eye)).dot(n) / ray.dot(n);
    let a = Vec3::from(frame.eye) + z * ray - place.p0;
    let l1 = a.cross(place.e2).dot(n) / n.dot(n);
    let l2 = place.e1.cross(a).dot(n) / n.dot(n);
    let lambda = Vec3::new(1.0 - l1 - l2, l1, l2);
    place.lambda = lambda;
    let cell = lattice::cell(fur, &place);
    let light = |column: u32| {
        let [rg, b] = base_light[column as usize];
        Vec3::from([rg as u16, (rg >> 16) as u16, b as u16].map(|h| f16::from_bits(h).to_f32()))
    };
    let lit: Vec3 = (0..3).map(|k| cell.weights[k] * light(cell.columns[k])).sum();
    // The inner side of an open skin is dimmed.
    let radiance = if ray.dot(n) < 0.0 { lit } else { 0.15 * lit };
    let [na, nb, nc] = place.vertices.map(|v| Vec3::from(shell.vertices[v as usize].normal));
    Base {
        z,
        radiance,
        normal: (lambda.x * na + lambda.y * nb + lambda.z * nc).normalize(),
        transparency: 0.0,
    }
}

/// Unpacks a base record: depth, radiance and transparency as halves, octahedral normal.
pub fn unpack(record: [u32; 4]) -> Base {
    let half = |word: u32| f16::from_bits(word as u16).to_f32();
    let snorm = |word: u32| (f32::from(word as u16 as i16) / 32767.0).max(-1.0);
    Base {
        z: f32::from_bits(record[0]),
        radiance: Vec3::new(half(record[1]), half(record[1] >> 16), half(record[2])),
        normal: octahedral::decode(Vec2::new(snorm(record[3]), snorm(record[3] >> 16))),
        transparency: half(record[2] >> 16),
    }
}
