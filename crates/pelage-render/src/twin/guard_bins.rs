//! Twin of `shaders/guard_bins.wgsl`: which strands touch which tile.

use glam::{Vec2, Vec3};
use pelage_fur::layout::{Frame, TileGrid};
use pelage_fur::strands::{position, radius};
use pelage_fur::view::{film_from_world, samples_per_slope};

/// Numbers of the tiles that a strand touches, row by row.
pub fn touched(frame: &Frame, tiles: &TileGrid, strand: &[[f32; 4]]) -> Vec<u32> {
    let film: Vec<(Vec3, f32)> =
        strand.iter().map(|v| (film_from_world(frame, position(*v)), radius(*v))).collect();
    let all = |_: u32, _: u32| true;
    let pick = |keep: &dyn Fn(u32, u32) -> bool| {
        let [columns, rows] = tiles.grid;
        (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .filter(|(x, y)| keep(*x, *y))
            .map(|(x, y)| y * columns + x)
            .collect()
    };
    let behind = film.iter().filter(|(p, _)| p.z <= frame.near).count();
    if behind == film.len() {
        return Vec::new();
    }
    if behind > 0 {
        return pick(&all);
    }
    let mut low = Vec2::INFINITY;
    let mut high = Vec2::NEG_INFINITY;
    for (p, radius) in &film {
        let pad = radius * samples_per_slope(frame) / p.z + 2.0 + tiles.margin;
        low = low.min(p.truncate() - pad);
        high = high.max(p.truncate() + pad);
    }
    pick(&|x, y| {
        let tile = Vec2::new(x as f32, y as f32);
        let size = Vec2::new(tiles.size[0] as f32, tiles.size[1] as f32);
        let corner = Vec2::new(tiles.origin[0] as f32, tiles.origin[1] as f32) + tile * size;
        corner.cmple(high).all() && (corner + size).cmpgt(low).all()
    })
}

/// Whether a strand from `root` (cm) that reaches at most `length` cm from it may touch the tile of
/// `frame`, extended by `margin` samples. Conservative.
pub fn may_touch(frame: &Frame, root: Vec3, length: f32, margin: f32) -> bool {
    let p = film_from_world(frame, root);
    let nearest = p.z - length;
    if p.z + length < frame.near {
        return false;
    }
    if nearest <= frame.near {
        return true;
    }
    // A sphere around the root; away from the view axis its image is slightly elongated.
    let slope = frame.tan_x.max(frame.tan_y);
    let radius = length * samples_per_slope(frame) / nearest * (1.0 + 2.0 * slope * slope).sqrt() + margin;
    (0..2).all(|k| {
        let low = frame.tile_origin[k] as f32;
        (low - radius..=low + frame.tile_size[k] as f32 + radius).contains(&p[k])
    })
}
