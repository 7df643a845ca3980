//! Procedural shapes. Sizes in cm; bounding boxes are centred at the origin, y is up. One unit of
//! uv is about [`UV_CM`], so that noise and maps have the same scale all over a shape and on all
//! shapes.

mod critter;
mod hat;

use super::Mesh;
use crate::scene::Shape;
use glam::{DVec2, Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_4, TAU};

/// Length of a uv unit, cm.
pub const UV_CM: f32 = 10.0;

/// The mesh of `shape`.
pub fn shape(shape: Shape) -> Mesh {
    match shape {
        Shape::CylinderPelt => cylinder_pelt(),
        Shape::Hat => hat::hat(),
        Shape::Sphere => sphere(),
        Shape::Plane => plane(),
        Shape::Disc => disc(),
        Shape::Cube => cube(),
        Shape::Cylinder => cylinder(),
        Shape::Torus => torus(),
        Shape::Pyramid => pyramid(),
        Shape::Die => die(),
        Shape::Critter => critter::critter(),
    }
}

/// A grid of `size.0` x `size.1` quads, two triangles each, its diagonals alternating. `point` and
/// `uv` are called with 0..=size; along directions marked in `wrap`, the last row is the first one
/// again. Triangles are counter-clockwise seen from d point/di x d point/dj.
fn grid(
    size: (u32, u32),
    wrap: (bool, bool),
    point: impl Fn(u32, u32) -> Vec3,
    uv: impl Fn(u32, u32) -> Vec2,
) -> Mesh {
    let (columns, rows) = (size.0 + u32::from(!wrap.0), size.1 + u32::from(!wrap.1));
    let mut mesh = Mesh::default();
    for j in 0..rows {
        mesh.positions.extend((0..columns).map(|i| point(i, j)));
    }
    let mut corner_uv = Vec::new();
    for (j, i) in (0..size.1).flat_map(|j| (0..size.0).map(move |i| (j, i))) {
        let quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let halves = if (i + j) % 2 == 0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
        for half in halves {
            let corners = half.map(|k: usize| quad[k]);
            mesh.triangles.push(corners.map(|(i, j)| (j % rows) * columns + i % columns));
            corner_uv.push(corners.map(|(i, j)| uv(i, j)));
        }
    }
    mesh.corner_uv = Some(corner_uv);
    mesh
}

/// Moves the centre of the bounding box to the origin.
fn centered(mut mesh: Mesh) -> Mesh {
    let low = mesh.positions.iter().fold(Vec3::MAX, |low, p| low.min(*p));
    let high = mesh.positions.iter().fold(Vec3::MIN, |high, p| high.max(*p));
    mesh.positions.iter_mut().for_each(|p| *p -= (low + high) / 2.0);
    mesh
}

/// An open pelt of 190 cm² that lies over a horizontal cylinder (axis x, radius 4 cm) and hangs
/// down on both sides: 200 degrees on the cylinder, then 2.2 cm that curve outwards. 64 quads along
/// the bend, 28 along the axis.
fn cylinder_pelt() -> Mesh {
    const AREA: f64 = 190.0;
    const RADIUS: f64 = 4.0;
    const HANG: f64 = 2.2;
    const BEND: u32 = 64;
    const AXIS: u32 = 28;
    let on_cylinder = RADIUS * 100.0_f64.to_radians();
    let half = on_cylinder + HANG;
    // Direction of the profile, radians below the horizontal, at the distance s >= 0 from the
    // ridge. The curvature of the hanging part changes linearly from 1/RADIUS to -2/RADIUS, so that
    // there is no kink.
    let angle = |s: f64| {
        let t = (s - on_cylinder).max(0.0);
        s / RADIUS - 1.5 * t * t / (RADIUS * HANG)
    };
    // Points of the profile at equal distances, by the midpoint rule with fine steps.
    const FINE: u32 = 256;
    let step = half / f64::from(BEND / 2 * FINE);
    let mut side = vec![DVec2::ZERO];
    let mut at = DVec2::ZERO;
    for i in 0..BEND / 2 * FINE {
        let a = angle((f64::from(i) + 0.5) * step);
        at += step * DVec2::new(a.cos(), -a.sin());
        if (i + 1) % FINE == 0 {
            side.push(at);
        }
    }
    let chords: f64 = side.windows(2).map(|w| (w[1] - w[0]).length()).sum();
    let width = AREA / (2.0 * chords);
    let middle = BEND / 2;
    let along = |i: u32| (f64::from(i) / f64::from(AXIS) - 0.5) * width;
    // From the front (+z) over the ridge to the back, so that normals point outwards.
    let point = |i: u32, j: u32| {
        let p = side[j.abs_diff(middle) as usize];
        let z = if j < middle { p.x } else { -p.x };
        Vec3::new(along(i) as f32, p.y as f32, z as f32)
    };
    let uv = |i: u32, j: u32| {
        let v = f64::from(j) * half / f64::from(middle);
        Vec2::new((along(i) + width / 2.0) as f32, v as f32) / UV_CM
    };
    centered(grid((AXIS, BEND), (false, false), point, uv))
}

/// A flat square of 10 x 10 cm that faces +y, 32 x 32 quads.
fn plane() -> Mesh {
    const N: u32 = 32;
    let at = |i: u32| (i as f32 / N as f32 - 0.5) * 10.0;
    let uv = |i: u32, j: u32| Vec2::new(i as f32, j as f32) / N as f32 * (10.0 / UV_CM);
    grid((N, N), (false, false), |i, j| Vec3::new(at(i), 0.0, -at(j)), uv)
}

/// Points of a disc of radius 1 for a square from -1 to 1: squares around the middle become
/// circles, so that no triangle is pinched.
// [ShirleyChiu1997]
fn on_disc([a, b]: [f32; 2]) -> Vec2 {
    let (radius, angle) = match a.abs() > b.abs() {
        true => (a, FRAC_PI_4 * b / a),
        false if b == 0.0 => (0.0, 0.0),
        false => (b, 2.0 * FRAC_PI_4 - FRAC_PI_4 * a / b),
    };
    radius * Vec2::from_angle(angle)
}

/// A flat disc of radius 5 cm that faces +y, 32 x 32 quads.
fn disc() -> Mesh {
    const N: u32 = 32;
    const RADIUS: f32 = 5.0;
    let at = |i: u32, j: u32| RADIUS * on_disc([i, j].map(|k| 2.0 * k as f32 / N as f32 - 1.0));
    let point = |i, j| Vec3::new(at(i, j).x, 0.0, -at(i, j).y);
    grid((N, N), (false, false), point, |i, j| (at(i, j) + RADIUS) / UV_CM)
}

/// A cube of edge 10 cm, 8 quads per side.
fn cube() -> Mesh {
    const N: i32 = 8;
    const EDGE: f32 = 10.0;
    cube_surface(N, EDGE, |p| Vec3::from_array(p.map(|i| (i as f32 / N as f32 - 0.5) * EDGE)))
}

/// A closed cylinder of radius 1 cm around the y axis, 10 cm long: 48 x 72 quads around it, and
/// discs at its ends.
fn cylinder() -> Mesh {
    const N: u32 = 12;
    const ROWS: u32 = 72;
    const LENGTH: f32 = 10.0;
    // The border of the square of a disc, against the sun as seen from above.
    let border = |i: u32| match i % (4 * N) {
        i if i < N => (i, 0),
        i if i < 2 * N => (N, i - N),
        i if i < 3 * N => (3 * N - i, N),
        i => (0, 4 * N - i),
    };
    let at = |(i, j): (u32, u32)| on_disc([i, j].map(|k| 2.0 * k as f32 / N as f32 - 1.0));
    let height = |j: u32| LENGTH * (j as f32 / ROWS as f32 - 0.5);
    let around = |i: u32, j: u32| Vec3::new(at(border(i)).x, height(j), -at(border(i)).y);
    let uv = |i: u32, j: u32| Vec2::new(TAU * i as f32 / (4 * N) as f32, height(j) + LENGTH / 2.0) / UV_CM;
    let mut mesh = grid((4 * N, ROWS), (true, false), around, uv);
    for (j, up) in [(ROWS, true), (0, false)] {
        let end = |i: u32, k: u32| at(if up { (i, k) } else { (N - i, k) });
        let point = |i: u32, k: u32| Vec3::new(end(i, k).x, height(j), -end(i, k).y);
        let cap = grid((N, N), (false, false), point, |i, k| (end(i, k) + 1.0) / UV_CM);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(cap.positions);
        mesh.triangles.extend(cap.triangles.iter().map(|t| t.map(|v| v + first)));
        let uv = mesh.corner_uv.get_or_insert_default();
        uv.extend(cap.corner_uv.into_iter().flatten());
    }
    mesh
}

/// A torus around the y axis, radii 5 and 2 cm, 80 x 32 quads.
fn torus() -> Mesh {
    const AROUND: u32 = 80;
    const TUBE: u32 = 32;
    let point = |i: u32, j: u32| {
        let (a, b) = (TAU * i as f32 / AROUND as f32, TAU * j as f32 / TUBE as f32);
        let r = 5.0 + 2.0 * b.cos();
        Vec3::new(r * a.cos(), 2.0 * b.sin(), -r * a.sin())
    };
    let uv = |i: u32, j: u32| {
        Vec2::new(TAU * 5.0 * i as f32 / AROUND as f32, TAU * 2.0 * j as f32 / TUBE as f32) / UV_CM
    };
    grid((AROUND, TUBE), (true, true), point, uv)
}

/// The surface of a cube with `n` quads per side. `point` maps lattice points, each coordinate in
/// 0..=n and at least one of them 0 or n; it is called once for each. A face's uv are its lattice
/// coordinates times `edge` cm.
fn cube_surface(n: i32, edge: f32, point: impl Fn([i32; 3]) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let mut corner_uv = Vec::new();
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    for (axis, high) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
        // Two axes whose cross product points out of the face.
        let (u, v) = if high { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        let mut number = |i: u32, j: u32| {
            let mut lattice = [0; 3];
            lattice[axis] = if high { n } else { 0 };
            lattice[u] = i as i32;
            lattice[v] = j as i32;
            *numbers.entry(lattice).or_insert_with(|| {
                mesh.positions.push(point(lattice));
                mesh.positions.len() as u32 - 1
            })
        };
        let side = n as u32 + 1;
        let face: Vec<u32> = (0..side * side).map(|k| number(k % side, k / side)).collect();
        let uv = |i: u32, j: u32| Vec2::new(i as f32, j as f32) / n as f32 * (edge / UV_CM);
        let flat = grid((n as u32, n as u32), (false, false), |_, _| Vec3::ZERO, uv);
        mesh.triangles.extend(flat.triangles.iter().map(|t| t.map(|i| face[i as usize])));
        corner_uv.extend(flat.corner_uv.into_iter().flatten());
    }
    mesh.corner_uv = Some(corner_uv);
    mesh
}

/// A sphere of radius 5 cm: a cube with 20 quads per side, inflated along equal angles, so that no
/// triangle is pinched.
fn sphere() -> Mesh {
    const N: i32 = 20;
    const RADIUS: f32 = 5.0;
    let tangent = |i: i32| (FRAC_PI_4 * (2 * i - N) as f32 / N as f32).tan();
    cube_surface(N, RADIUS * TAU / 4.0, |p| RADIUS * Vec3::from_array(p.map(tangent)).normalize())
}

/// A cube of edge 8 cm whose edges and corners are rounded with a radius of 1.6 cm, 20 quads per
/// side.
fn die() -> Mesh {
    const N: i32 = 20;
    const EDGE: f32 = 8.0;
    const ROUND: f32 = 1.6;
    // Of the twenty quads along a side, four lie on the rounding at each end, in proportion to the
    // length of its 45 degrees.
    const CURVED: i32 = 4;
    let core = EDGE / 2.0 - ROUND;
    // For a lattice coordinate: the position on the core cube, and the tangent of the angle on the
    // rounding.
    let split = |i: i32| {
        let (sign, from_middle) = ((2 * i - N).signum() as f32, (2 * i - N).abs());
        let flat = N - 2 * CURVED;
        if from_middle <= flat {
            return (core * (2 * i - N) as f32 / flat as f32, 0.0);
        }
        let angle = FRAC_PI_4 * (from_middle - flat) as f32 / (2 * CURVED) as f32;
        (sign * core, sign * angle.tan())
    };
    cube_surface(N, EDGE, |p| {
        let parts = p.map(split);
        let inner = Vec3::from_array(parts.map(|(c, _)| c));
        inner + ROUND * Vec3::from_array(parts.map(|(_, t)| t)).normalize()
    })
}

/// A pyramid, base 10 x 10 cm, 8 cm high, each face cut into triangles of about 0.6 cm; closed.
fn pyramid() -> Mesh {
    const N: u32 = 16;
    const HEIGHT: f32 = 8.0;
    let base =
        [(-5.0, 5.0), (5.0, 5.0), (5.0, -5.0), (-5.0, -5.0)].map(|(x, z)| Vec3::new(x, -HEIGHT / 2.0, z));
    let apex = Vec3::new(0.0, HEIGHT / 2.0, 0.0);
    let across = |i: u32| (base[1] - base[0]) * (i as f32 / N as f32);
    let down = |j: u32| (base[3] - base[0]) * (j as f32 / N as f32);
    // Seen from below: from the back edge to the front edge. All numbers are sixteenths, so that
    // shared points are exactly the same and get welded.
    let uv = |i: u32, j: u32| Vec2::new(i as f32, j as f32) / N as f32 * (10.0 / UV_CM);
    let mut mesh = grid((N, N), (false, false), |i, j| base[3] + across(i) - down(j), uv);
    let slant = Vec2::new(HEIGHT, 5.0).length();
    let mut corner_uv = mesh.corner_uv.take().unwrap_or_default();
    for side in 0..4 {
        let (a, b) = (base[side], base[(side + 1) % 4]);
        let start = mesh.positions.len() as u32;
        // Row j, from the base up, has N - j + 1 points.
        let mut first = vec![start];
        let mut flat = Vec::new();
        for j in 0..=N {
            for i in 0..=N - j {
                let (s, t) = (i as f32 / N as f32, j as f32 / N as f32);
                mesh.positions.push(a + (b - a) * s + (apex - a) * t);
                flat.push(Vec2::new(10.0 * (s + t / 2.0), slant * t) / UV_CM);
            }
            first.push(mesh.positions.len() as u32);
        }
        for j in 0..N {
            for i in 0..N - j {
                let (low, high) = (first[j as usize] + i, first[j as usize + 1] + i);
                mesh.triangles.push([low, low + 1, high]);
                if i + 1 < N - j {
                    mesh.triangles.push([low + 1, high + 1, high]);
                }
            }
        }
        let added = &mesh.triangles[corner_uv.len()..];
        corner_uv.extend(added.iter().map(|t| t.map(|i| flat[(i - start) as usize])));
    }
    mesh.corner_uv = Some(corner_uv);
    mesh
}
