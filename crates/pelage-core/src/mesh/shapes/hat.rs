//! A fur hat: a surface of revolution with a round crown and a turned-up brim.

use super::{UV_CM, centered};
use crate::mesh::Mesh;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Radius (cm) and height (cm) along the profile: over the crown, down to the fold, up and over the
/// brim, down its outside, and under.
const PROFILE: [[f32; 2]; 15] = [
    [0.0, 13.0],
    [2.2, 12.9],
    [4.4, 12.4],
    [6.4, 11.3],
    [7.8, 9.6],
    [8.5, 7.7],
    [8.75, 6.1],
    [9.25, 5.45],
    [9.95, 5.9],
    [10.5, 5.75],
    [10.9, 4.7],
    [11.0, 3.0],
    [10.75, 1.3],
    [10.2, 0.25],
    [9.4, 0.0],
];

/// Vertices around, away from the pole.
const AROUND: u32 = 64;
/// Bands of quads between the outer rings.
const BANDS: u32 = 42;
/// Vertices of the rings around the pole: fewer towards it, so that no triangle is pinched. The
/// rings, the pole and the innermost ring of `AROUND` make 256 triangles, as many as two bands:
/// together 2 x 64 x 44.
const CAP: [u32; 5] = [6, 12, 18, 24, 36];
/// Radius of the innermost ring of `AROUND`, cm along the profile.
const CAP_RADIUS: f32 = 6.0;

/// A ring of vertices.
struct Ring {
    count: u32,
    first: u32,
    /// Distance from the pole along the profile, cm.
    along: f32,
}

/// The hat: 5,632 triangles, 22 cm wide, open below, fur outside.
pub(super) fn hat() -> Mesh {
    let profile = fine_profile();
    let length = profile.last().map_or(0.0, |p| p.1);
    let mut mesh = Mesh::default();
    let mut rings: Vec<Ring> = Vec::new();
    let mut add = |count: u32, along: f32, mesh: &mut Mesh| {
        rings.push(Ring { count, first: mesh.positions.len() as u32, along });
        let Vec2 { x: radius, y } = at(&profile, along);
        mesh.positions.extend((0..count).map(|i| {
            let angle = TAU * i as f32 / count as f32;
            Vec3::new(radius * angle.cos(), y, -radius * angle.sin())
        }));
    };
    add(1, 0.0, &mut mesh);
    for (k, count) in CAP.iter().enumerate() {
        add(*count, CAP_RADIUS * (k + 1) as f32 / (CAP.len() + 1) as f32, &mut mesh);
    }
    for k in 0..=BANDS {
        add(AROUND, CAP_RADIUS + (length - CAP_RADIUS) * k as f32 / BANDS as f32, &mut mesh);
    }

    let mut corner_uv = Vec::new();
    for (k, pair) in rings.windows(2).enumerate() {
        let [inner, outer] = pair else { continue };
        // The crown is mapped as a disc, the rest as a strip as long as the hat is around.
        let uv = |ring: &Ring, i: u32| {
            let angle = TAU * i as f32 / ring.count as f32;
            match k <= CAP.len() {
                true => Vec2::new(angle.cos(), angle.sin()) * ring.along / UV_CM,
                false => Vec2::new(angle * 10.0, length - ring.along) / UV_CM,
            }
        };
        for corners in band(inner.count, outer.count, k as u32) {
            let ring = |outside: bool| if outside { outer } else { inner };
            mesh.triangles.push(corners.map(|(outside, i)| ring(outside).first + i % ring(outside).count));
            corner_uv.push(corners.map(|(outside, i)| uv(ring(outside), i)));
        }
    }
    mesh.corner_uv = Some(corner_uv);
    centered(mesh)
}

/// Triangles between two rings, which may have different numbers of vertices: corners as (on the
/// outer ring, index on the ring, from 0 to its count). Around the rings, the one whose next vertex
/// is nearer takes the next step; ties alternate.
fn band(inner: u32, outer: u32, odd: u32) -> Vec<[(bool, u32); 3]> {
    let (mut i, mut o) = (0, 0);
    let mut triangles = Vec::with_capacity((inner + outer) as usize);
    // The pole is a ring of one vertex: it never steps.
    let steps = if inner == 1 { 0 } else { inner };
    while i < steps || o < outer {
        // Compares the middles of the next steps of both rings, as fractions of the circle.
        let (next_outer, next_inner) = ((2 * o + 1) * inner, (2 * i + 1) * outer);
        let outside = match next_outer.cmp(&next_inner) {
            _ if i == steps => true,
            _ if o == outer => false,
            std::cmp::Ordering::Equal => (i + o + odd + (o + odd) / 2).is_multiple_of(2),
            order => order.is_lt(),
        };
        if outside {
            triangles.push([(true, o), (true, o + 1), (false, i)]);
            o += 1;
        } else {
            triangles.push([(true, o), (false, i + 1), (false, i)]);
            i += 1;
        }
    }
    triangles
}

/// The profile as a fine polyline (radius, height) with the length up to each point: a Catmull-Rom
/// spline.
fn fine_profile() -> Vec<(Vec2, f32)> {
    const FINE: u32 = 64;
    let p = |k: isize| {
        // Mirrored at the pole, so that the crown is smooth there; extrapolated at the hem.
        let last = PROFILE.len() as isize - 1;
        match k {
            -1 => Vec2::from(PROFILE[1]) * Vec2::new(-1.0, 1.0),
            k if k > last => {
                2.0 * Vec2::from(PROFILE[last as usize]) - Vec2::from(PROFILE[last as usize - 1])
            }
            k => Vec2::from(PROFILE[k as usize]),
        }
    };
    let mut fine = vec![(Vec2::from(PROFILE[0]), 0.0)];
    for k in 0..PROFILE.len() as isize - 1 {
        let (a, b, c, d) = (p(k - 1), p(k), p(k + 1), p(k + 2));
        for s in 1..=FINE {
            let t = s as f32 / FINE as f32;
            let cubic = 2.0 * b
                + (c - a) * t
                + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
                + (3.0 * (b - c) + d - a) * t * t * t;
            let point = cubic / 2.0;
            let (before, length) = fine[fine.len() - 1];
            fine.push((point, length + point.distance(before)));
        }
    }
    fine
}

/// The point at distance `along` from the pole.
fn at(profile: &[(Vec2, f32)], along: f32) -> Vec2 {
    let next = profile.partition_point(|(_, s)| *s < along).clamp(1, profile.len() - 1);
    let ((a, s), (b, t)) = (profile[next - 1], profile[next]);
    a.lerp(b, ((along - s) / (t - s)).clamp(0.0, 1.0))
}
