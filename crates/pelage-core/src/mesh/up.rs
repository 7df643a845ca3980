//! Which axis is up in a file whose format does not say.

use crate::Skin;
use crate::scene::UpAxis;
use glam::{DVec2, DVec3};

/// The side of the bounding box on which the mesh stands: +y or +z, whichever leaves the mesh
/// firmly on its lowest points and better than the other. `None` where neither does, as for a ball
/// or a head.
///
/// Files are made with one of the two up, so that the others are not tried.
pub(super) fn standing(skin: &Skin) -> Option<UpAxis> {
    let centre = centroid(skin)?;
    let [y, z] = [1, 2].map(|axis| stance(skin, axis, centre));
    let better = |a: Stance, b: Stance| a.margin >= MARGIN && a.base >= BASE && a.margin >= b.margin + MARGIN;
    match () {
        () if better(y, z) => Some(UpAxis::Y),
        () if better(z, y) => Some(UpAxis::Z),
        () => None,
    }
}

/// What a firm stance has at least, in the units of [`Stance`]. Of 13 scans and models of animals
/// and toys, those that stand have margins of 0.09 to 0.34 and bases of 0.3 to 0.9; lying down,
/// they have margins of -0.6 to 0.11.
const MARGIN: f64 = 0.05;
const BASE: f64 = 0.25;

/// Points count as lowest within this part of the height.
const LOWEST: f64 = 0.05;

#[derive(Clone, Copy)]
struct Stance {
    /// Distance of the centre of mass from the edge of the base, positive within it, relative to
    /// the root of the outline's area.
    margin: f64,
    /// Area of the base, relative to the outline's.
    base: f64,
}

/// How the mesh would stand if `axis` were up.
fn stance(skin: &Skin, axis: usize, centre: DVec3) -> Stance {
    let flat = |p: DVec3| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    let (low, high) = skin.bounds();
    let limit = f64::from(low[axis]) + LOWEST * f64::from(high[axis] - low[axis]);
    let points = || skin.positions.iter().map(|p| p.as_dvec3());
    let outline = area(&hull(points().map(flat).collect()));
    let base = hull(points().filter(|p| p[axis] <= limit).map(flat).collect());
    if outline <= 0.0 || base.len() < 3 {
        return Stance { margin: f64::NEG_INFINITY, base: 0.0 };
    }
    let at = flat(centre);
    let distance = |i: usize| {
        let (p, q) = (base[i], base[(i + 1) % base.len()]);
        (q - p).perp_dot(at - p) / (q - p).length()
    };
    let margin = (0..base.len()).map(distance).fold(f64::INFINITY, f64::min);
    Stance { margin: margin / outline.sqrt(), base: area(&base) / outline }
}

/// Centre of mass of the surface.
fn centroid(skin: &Skin) -> Option<DVec3> {
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for t in 0..skin.triangles.len() {
        let [a, b, c] = skin.corners(t).map(|p| p.as_dvec3());
        let area = (b - a).cross(c - a).length();
        sum += area * (a + b + c) / 3.0;
        total += area;
    }
    (total > 0.0).then(|| sum / total)
}

/// Convex hull, counter-clockwise (monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut below = half(&mut points.iter().copied());
    below.extend(half(&mut points.iter().rev().copied()));
    below
}

fn area(polygon: &[DVec2]) -> f64 {
    let n = polygon.len();
    (0..n).map(|i| polygon[i].perp_dot(polygon[(i + 1) % n])).sum::<f64>() / 2.0
}
