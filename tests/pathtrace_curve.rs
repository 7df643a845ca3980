//! Intersection of rays with hair segments against dense sampling along the rays.

use glam::{DVec3, Vec3, Vec3A};
use pelage_fur::random::{hash2, random, random_direction};
use pelage_pathtrace::curve::Cone;

struct Case {
    start: Vec3,
    end: Vec3,
    radii: [f32; 2],
    normals: [Vec3; 2],
    origin: Vec3,
    direction: Vec3,
}

/// Whether a point lies in the segment, by its definition.
fn inside(case: &Case, p: DVec3) -> bool {
    let (start, end) = (case.start.as_dvec3(), case.end.as_dvec3());
    let axis = (end - start).normalize();
    let along = (p - start).dot(axis);
    let radius =
        f64::from(case.radii[0]) + f64::from(case.radii[1] - case.radii[0]) * along / (end - start).length();
    radius > 0.0
        && (p - start - along * axis).length() < radius
        && (p - start).dot(case.normals[0].as_dvec3()) > 0.0
        && (end - p).dot(case.normals[1].as_dvec3()) > 0.0
}

/// First stretch of the ray within the segment by sampling `steps` points of `range`.
fn sampled(case: &Case, range: [f64; 2], steps: u32) -> Option<[f64; 2]> {
    let at = |t: f64| case.origin.as_dvec3() + t * case.direction.as_dvec3();
    let t = |i: u32| range[0] + (range[1] - range[0]) * (f64::from(i) + 0.5) / f64::from(steps);
    let first = (0..steps).find(|i| inside(case, at(t(*i))))?;
    let last = (first..steps).take_while(|i| inside(case, at(t(*i)))).last()?;
    Some([t(first), t(last)])
}

fn solved(case: &Case) -> Option<[f32; 2]> {
    let cone = Cone::new(case.start.into(), case.end.into(), case.radii)?;
    let (origin, direction) = (Vec3A::from(case.origin), Vec3A::from(case.direction));
    let span = cone.cut(cone.span(origin, direction)?, direction, case.normals.map(Vec3A::from))?;
    Some([span.enter, span.exit])
}

/// Segments of length about 1, thick enough for sampling; rays of many kinds.
fn case(i: u32) -> Case {
    let r = |k: u32| random(hash2(77, i), k);
    let start = random_direction(i, 10) * r(0);
    let axis = random_direction(i, 12);
    let end = start + axis * (0.5 + r(1));
    let (a, b) = (0.02 + 0.2 * r(2), 0.02 + 0.2 * r(3));
    let radii = match i % 4 {
        0 => [a, a],
        1 => [a, 0.0],
        2 => [1.5 * a + 0.2, 0.1 * b],
        _ => [a, b],
    };
    let tilt =
        |k: u32| if i.is_multiple_of(3) { axis } else { (axis + 0.3 * random_direction(i, k)).normalize() };
    let through = start.lerp(end, 1.2 * r(4) - 0.1) + random_direction(i, 18) * 0.25 * r(5);
    let direction = match i % 5 {
        // End on, exactly and nearly; from within; from all sides.
        0 => axis,
        1 => (-axis + 0.05 * random_direction(i, 20)).normalize(),
        _ => random_direction(i, 22),
    };
    let back = if i % 5 == 2 { 0.0 } else { 3.0 };
    Case { start, end, radii, normals: [tilt(14), tilt(16)], origin: through - back * direction, direction }
}

/// Cases that disagree by more than the step of the sampling, of `n`; `wrong` spoils the solved
/// radii.
fn disagreements(n: u32, wrong: f32) -> (u32, u32) {
    const STEPS: u32 = 6000;
    let range = [-1.0, 6.0];
    let step = (range[1] - range[0]) / f64::from(STEPS);
    let (mut bad, mut hits) = (0, 0);
    for i in 0..n {
        let case = case(i);
        let expected = sampled(&case, range, STEPS);
        let found = solved(&Case { radii: case.radii.map(|r| r * wrong), ..case_copy(&case) });
        let found = found.map(|f| f.map(f64::from)).filter(|f| f[1] > range[0] && f[0] < range[1]);
        hits += u32::from(expected.is_some());
        let agree = match (expected, found) {
            (Some(e), Some(f)) => {
                (e[0] - f[0].max(range[0])).abs() < 1.01 * step
                    && (e[1] - f[1].min(range[1])).abs() < 1.01 * step
            }
            (None, Some(f)) => f[1] - f[0] < 1.01 * step,
            (Some(e), None) => e[1] - e[0] < 0.01 * step,
            (None, None) => true,
        };
        if !agree {
            bad += 1;
            if bad < 4 && wrong == 1.0 {
                println!("{i}: expected {expected:?}, found {found:?}");
            }
        }
    }
    (bad, hits)
}

fn case_copy(c: &Case) -> Case {
    Case { ..*c }
}

#[test]
fn rays_meet_segments_where_sampling_says() {
    let (bad, hits) = disagreements(4000, 1.0);
    assert!(hits > 1000, "only {hits} of the rays hit");
    // Rays that graze within the rounding of single precision.
    assert!(bad <= 2, "{bad} of 4000 disagree");
    let (bad, _) = disagreements(1000, 1.02);
    assert!(bad > 100, "radii that are 2 % too large are not noticed: {bad}");
}

#[test]
fn offset_is_even_across_a_hair() {
    let cone = Cone::new(Vec3A::ZERO, Vec3A::new(0.3, 1.0, 0.2), [0.01, 0.01]).expect("a cone");
    let direction = Vec3A::new(0.2, -0.1, -1.0).normalize();
    let side = cone.axis.cross(direction).normalize();
    for i in -9..=9 {
        let wanted = i as f32 / 10.0;
        let origin = 0.5 * cone.length * cone.axis - 40.0 * direction + 0.01 * wanted * side;
        let span = cone.span(origin, direction).expect("a hit");
        let (along, radius, h) = cone.place(&span, direction, span.enter);
        assert!((h.abs() - wanted.abs()).abs() < 0.01 && (radius - 0.01).abs() < 1e-6, "{wanted}: {h}");
        assert!(along > 0.3 && along < 0.7);
        // h = sin(φ_o - φ_n), with the azimuths about the axis.
        let (y, z) = pelage_pathtrace::curve::frame(cone.axis, -direction);
        let at = origin + span.enter * direction;
        let normal = (at - at.dot(cone.axis) * cone.axis).normalize();
        let phi_n = normal.dot(z).atan2(normal.dot(y));
        let phi_o = (-direction).dot(z).atan2((-direction).dot(y));
        assert!(((phi_o - phi_n).sin() - h).abs() < 0.01, "{wanted}: {h}");
    }
}
