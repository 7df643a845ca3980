//! The direction of the hair on each face, as a complex number of modulus 1 in the face's frame.
//!
//! All sources lead to the same system: the connection Laplacian of the dual graph, which penalises
//! changes of direction between adjacent faces unfolded into a plane. Singularities, which a sphere
//! cannot avoid, arise where they cost least.
// [Knoppel2013]; here on the dual graph of the faces instead of the vertices

use super::{
    solve::{Complex, Factor},
    surface::{Surface, unit},
};
use faer::Mat;
use glam::{DVec3, Vec3};
use pelage_core::scene::{FieldSource, FieldVector, LappedSpec};
use pelage_core::{Error, Result};
use rayon::prelude::*;

const ZERO: Complex = Complex::new(0.0, 0.0);

/// Sine below which a direction counts as perpendicular to a face, without a usable tangential
/// part.
const PERPENDICULAR: f64 = 0.02;

/// Initial direction for the smoothest field: downwards and slightly aside. Exactly downwards, a
/// symmetric skin would keep a parting along its ridge.
const DOWN: DVec3 = DVec3::new(0.1, -1.0, 0.3);

/// Length over which projected directions are smoothed, relative to the patches' radius. Otherwise
/// a direction almost perpendicular to the skin would follow every dent, and no patch could follow
/// it.
const SMOOTHING: f64 = 0.5;

/// The directions that `spec` describes; `comb` is the groom's comb direction in world space,
/// `radius` that of the patches, cm.
pub(super) fn directions(
    surface: &Surface,
    spec: &LappedSpec,
    comb: Vec3,
    radius: f64,
) -> Result<Vec<Complex>> {
    match spec.field {
        FieldSource::Auto => smoothest(surface),
        FieldSource::Gravity => projected(surface, DVec3::NEG_Y, radius),
        FieldSource::Groom => match comb.as_dvec3().try_normalize() {
            Some(comb) => projected(surface, comb, radius),
            None => Err(Error::fault(
                "guard.comb_direction",
                format!(
                    "lapped.field is \"groom\" and the direction is {comb}, expected one that is not zero: set it, or \
                     choose another lapped.field"
                ),
            )),
        },
        FieldSource::Vectors => interpolated(surface, &spec.vectors),
    }
}

/// `direction`, projected on each face and diffused over part of the radius: the length of a
/// projection is its weight. Where nothing is left, the surroundings decide.
fn projected(surface: &Surface, direction: DVec3, radius: f64) -> Result<Vec<Complex>> {
    let z: Vec<Complex> = surface.frames.iter().map(|frame| frame.tangential(direction)).collect();
    let mut most = vec![0.0_f64; surface.parts.len()];
    z.iter()
        .zip(&surface.part)
        .for_each(|(z, p)| most[*p as usize] = most[*p as usize].max(z.re.hypot(z.im)));
    // A diagonal of s times the fraction of area diffuses over a length of sqrt(area / s).
    let share = |f: usize| surface.parts[surface.part[f] as usize].1 / (SMOOTHING * radius).powi(2);
    let laplacian = Laplacian::new(surface, 1e-9, |f, mass| mass * share(f))?;
    let even = laplacian.solve(&z, |f| laplacian.mass[f] * share(f));
    let of = |(z, part): (&Complex, &u32)| if most[*part as usize] > PERPENDICULAR { unit(*z) } else { None };
    filled(surface, even.iter().zip(&surface.part).map(of).collect())
}

/// Gives faces without a direction the mean of their neighbours', nearest faces first. Parts of the
/// skin without any direction get their smoothest field.
fn filled(surface: &Surface, mut field: Vec<Option<Complex>>) -> Result<Vec<Complex>> {
    let mut known = vec![false; surface.parts.len()];
    field.iter().zip(&surface.part).filter(|(z, _)| z.is_some()).for_each(|(_, p)| known[*p as usize] = true);
    if known.contains(&false) {
        let smooth = smoothest(surface)?;
        for ((z, smooth), part) in field.iter_mut().zip(&smooth).zip(&surface.part) {
            if !known[*part as usize] {
                *z = Some(*smooth);
            }
        }
    }
    let mut open: Vec<u32> = (0..field.len() as u32).filter(|f| field[*f as usize].is_none()).collect();
    while !open.is_empty() {
        // One ring at a time, from values of the ring before, so that the result does not depend on
        // the order of faces.
        let mean = |f: u32| {
            let arriving = surface.around(f).filter_map(|(k, g)| {
                let back = surface.side_of(g, f, k);
                field[g as usize].map(|z| z * surface.transport(g, back, f))
            });
            let mut arriving = arriving.peekable();
            let first = *arriving.peek()?;
            Some(unit(arriving.fold(ZERO, |sum, z| sum + z)).unwrap_or(first))
        };
        let ring: Vec<_> = open.iter().map(|f| (*f, mean(*f))).collect();
        let before = open.len();
        ring.iter().for_each(|(f, z)| field[*f as usize] = *z);
        open.retain(|f| field[*f as usize].is_none());
        if open.len() == before {
            break;
        }
    }
    Ok(field.into_iter().map(|z| z.unwrap_or(Complex::new(1.0, 0.0))).collect())
}

/// The smoothest field of each part of the skin: the eigenvector of the smallest eigenvalue of the
/// Laplacian, by inverse iteration from the downward direction, so that of equally smooth fields it
/// is the one that points down most. Then the directions, normalised on each face, are diffused
/// over about a seventh of the part's size, because an eigenvector may almost vanish on a limb.
// [Knoppel2013]
fn smoothest(surface: &Surface) -> Result<Vec<Complex>> {
    let mut z = vec![ZERO; surface.frames.len()];
    for direction in [DOWN, DVec3::X] {
        // A part perpendicular to the direction has no initial value.
        let mut left = vec![0.0; surface.parts.len()];
        z.iter().zip(&surface.part).for_each(|(z, p)| left[*p as usize] += z.re.hypot(z.im));
        for ((z, frame), part) in z.iter_mut().zip(&surface.frames).zip(&surface.part) {
            if left[*part as usize] < 0.01 * surface.parts[*part as usize].0 as f64 {
                *z = frame.tangential(direction);
            }
        }
    }
    let wide = Laplacian::new(surface, 1.0, |_, _| 0.0)?;
    for _ in 0..12 {
        z = wide.solve(&z, |f| wide.mass[f]);
        // Each part is normalised separately.
        let mut largest = vec![0.0_f64; surface.parts.len()];
        z.iter()
            .zip(&surface.part)
            .for_each(|(z, p)| largest[*p as usize] = largest[*p as usize].max(z.re.hypot(z.im)));
        for (z, part) in z.iter_mut().zip(&surface.part) {
            let scale = 1.0 / largest[*part as usize].max(f64::MIN_POSITIVE);
            *z *= scale;
        }
    }
    let near = Laplacian::new(surface, 50.0, |_, _| 0.0)?;
    for _ in 0..6 {
        z.iter_mut().for_each(|z| *z = unit(*z).unwrap_or(ZERO));
        z = near.solve(&z, |f| near.mass[f]);
    }
    Ok(z.into_iter().map(|z| unit(z).unwrap_or(Complex::new(1.0, 0.0))).collect())
}

/// The smoothest directions that approximate the given vectors where they are given.
fn interpolated(surface: &Surface, vectors: &[FieldVector]) -> Result<Vec<Complex>> {
    if vectors.is_empty() {
        let message = "lapped.field is \"vectors\" and there are none, expected at least one: add [[lapped.vectors]] with at \
                       and direction, or choose another lapped.field";
        return Err(Error::fault("lapped.vectors", message));
    }
    let mut weight = vec![0.0; surface.frames.len()];
    let mut given = vec![ZERO; surface.frames.len()];
    for (i, vector) in vectors.iter().enumerate() {
        let (f, z) = placed(surface, vector)
            .map_err(|message| Error::fault(format!("lapped.vectors.{i}"), message))?;
        weight[f] += 1e3;
        given[f] += z * 1e3;
    }
    let laplacian = Laplacian::new(surface, 1e-6, |f, _| weight[f])?;
    let z = laplacian.solve(&given, |_| 1.0);
    let mut known = vec![false; surface.parts.len()];
    (0..z.len()).filter(|f| weight[*f] > 0.0).for_each(|f| known[surface.part[f] as usize] = true);
    let of = |(z, part): (&Complex, &u32)| if known[*part as usize] { unit(*z) } else { None };
    filled(surface, z.iter().zip(&surface.part).map(of).collect())
}

/// The face nearest to a vector's position, and the vector's direction on it.
fn placed(surface: &Surface, vector: &FieldVector) -> Result<(usize, Complex), String> {
    let (at, direction) = (Vec3::from(vector.at), Vec3::from(vector.direction));
    if !at.is_finite() {
        return Err(format!("found at = {:?}, expected finite numbers", vector.at));
    }
    let direction = direction.as_dvec3().try_normalize().ok_or_else(|| {
        format!("found direction = {:?}, expected a finite direction that is not zero", vector.direction)
    })?;
    let distance = |f: usize| distance_squared(at.as_dvec3(), surface.skin.corners(f).map(|p| p.as_dvec3()));
    let nearest = (0..surface.frames.len())
        .into_par_iter()
        .map(|f| (distance(f), f))
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some((_, f)) = nearest else { return Err("the skin has no faces".into()) };
    let z = surface.frames[f].tangential(direction);
    match unit(z).filter(|_| z.re.hypot(z.im) > PERPENDICULAR) {
        Some(z) => Ok((f, z)),
        None => Err(format!(
            "found direction = {:?}, which is perpendicular to the skin at {:?}, expected one with a tangential part",
            vector.direction, vector.at
        )),
    }
}

/// Squared distance from `p` to a triangle.
fn distance_squared(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_edge = |a: DVec3, b: DVec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance_squared(if t.is_nan() { a } else { a.lerp(b, t) })
    };
    let n = (b - a).cross(c - a);
    let inside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(n) >= 0.0;
    if n.length_squared() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return (p - a).dot(n).powi(2) / n.length_squared();
    }
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// The factorised sum of the connection Laplacian of the dual graph and a diagonal.
struct Laplacian {
    factor: Factor<Complex>,
    /// Fraction of each face in the area of its part.
    mass: Vec<f64>,
}

impl Laplacian {
    /// The diagonal is `shift` times the mass (see [`Laplacian::mass`]) plus `more(face, mass)`.
    fn new(surface: &Surface, shift: f64, more: impl Fn(usize, f64) -> f64) -> Result<Self> {
        let faces = surface.frames.len();
        let share = |f: usize| {
            let (count, area) = surface.parts[surface.part[f] as usize];
            // The second term avoids zeros on the diagonal for faces without area.
            let by_area = if area > 0.0 { surface.frames[f].area / area } else { 0.0 };
            by_area + 1e-6 / count as f64
        };
        let mass: Vec<f64> = (0..faces).map(share).collect();
        let mut diagonal: Vec<f64> = (0..faces).map(|f| shift * mass[f] + more(f, mass[f])).collect();
        let mut entries = Vec::with_capacity(3 * faces);
        for f in 0..faces as u32 {
            for (k, g) in surface.around(f).filter(|(_, g)| *g < f) {
                let w = weight(surface, f, k, g);
                diagonal[f as usize] += w;
                diagonal[g as usize] += w;
                // The row of f asks for z_f = r z_g, with r the transport from g to f.
                let back = surface.transport(f, k, g).conj();
                entries.push((f as usize, g as usize, back * -w));
            }
        }
        let diagonal = diagonal.into_iter().enumerate().map(|(f, d)| (f, f, Complex::new(d, 0.0)));
        let factor = Factor::new(faces, entries.into_iter().chain(diagonal)).ok_or_else(|| {
            Error::Unsupported(format!("the direction field of {faces} faces could not be solved for"))
        })?;
        Ok(Self { factor, mass })
    }

    /// Solves for the right-hand side `weight * z`.
    fn solve(&self, z: &[Complex], weight: impl Fn(usize) -> f64) -> Vec<Complex> {
        let mut column = Mat::from_fn(z.len(), 1, |f, _| z[f] * weight(f));
        self.factor.solve(&mut column);
        (0..z.len()).map(|f| column[(f, 0)]).collect()
    }
}

/// Weight of a pair of adjacent faces: length of their common side over the distance of their
/// centroids, unfolded into a plane.
fn weight(surface: &Surface, f: u32, k: usize, g: u32) -> f64 {
    let apart = |f: u32, k: usize| {
        let c = &surface.frames[f as usize].corners;
        ((c[0] + c[1] + c[2]) / 3.0).distance((c[(k + 1) % 3] + c[(k + 2) % 3]) / 2.0)
    };
    let across = apart(f, k) + apart(g, surface.side_of(g, f, k));
    let weight = surface.side(f, k).length() / across;
    if weight.is_finite() { weight.clamp(1e-3, 1e3) } else { 1.0 }
}
