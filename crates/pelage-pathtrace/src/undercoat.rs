//! The undercoat's volume realised as hairs.
//!
//! Roots are a Poisson process, because a volume attenuates exponentially, as independently placed
//! hairs do. Each hair follows the volume's tangents up through the prism shell. It has a random
//! threshold of its own, and its segments are present where the volume's density is above it. So
//! the mean number of hairs at a place is the volume's density there, and hairs end where the
//! density falls.

use super::patch::Patch;
use super::strands::{Hair, Strands};
use glam::{Vec2, Vec3, Vec4};
use pelage_core::World;
use pelage_fur::Layer;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::UndercoatParameters;
use pelage_fur::parameters::{Maps, Parameter, skin_point};
use pelage_fur::random::{even_barycentric, hash2, random, random_direction};
use pelage_fur::shell::{Located, Place, Shell};
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Hairs that a thread grows at a time.
const CHUNK: u32 = 2048;

/// Smallest cosine between a hair and the shell's direction: a hair that leaned more would hardly
/// climb.
const STEEPEST: f32 = 0.3;

/// Grows the undercoat of a prism shell.
pub(super) struct Grower<'a> {
    shell: &'a Shell,
    maps: Maps<'a>,
    /// The volume's parameters without the taper, which changes the hairs' diameter, not their
    /// number.
    fur: UndercoatParameters,
    noise: Field,
    /// Largest density of the volume relative to its mean.
    densest: f32,
    /// Diameter at root and tip, cm.
    diameter: [f32; 2],
    segments: u32,
    seed: u32,
    patch: Option<Patch>,
}

/// Random variation of one hair.
struct HairVariation {
    /// The hair is present where the relative density is above this.
    threshold: f32,
    /// Position in each segment at which the density is evaluated, 0..1.
    phase: f32,
    /// Displacement of the density's lookup at full growth, in units of the jitter, each coordinate
    /// in -1..1.
    displacement: Vec3,
    /// Two orthogonal unit vectors: from root to tip, the jitter of the tangent runs through half
    /// of their great circle.
    jitter_plane: [Vec3; 2],
}

impl HairVariation {
    fn of(seed: u32) -> Self {
        let first = random_direction(seed, 8);
        let second = random_direction(seed, 10);
        let second = second.reject_from_normalized(first).normalize_or(first.any_orthonormal_vector());
        let r = |k| 2.0 * random(seed, k) - 1.0;
        Self {
            threshold: random(seed, 2),
            phase: random(seed, 3),
            displacement: Vec3::new(r(4), r(5), r(6)),
            jitter_plane: [first, second],
        }
    }

    /// Jitter of the tangent at height t, unit: uniform on the sphere at each height, smooth along
    /// the hair.
    fn tangent_jitter(&self, t: f32) -> Vec3 {
        let (sin, cos) = (PI * t).sin_cos();
        cos * self.jitter_plane[0] + sin * self.jitter_plane[1]
    }
}

/// A point of a hair that climbs through the shell.
#[derive(Clone, Copy)]
struct Walker {
    place: Place,
    /// Position, cm.
    x: Vec3,
    /// Where the hair has left the shell over its border: `place` is the last one inside, and the
    /// point of the noise's domain has moved on by this.
    beyond: Option<Vec3>,
}

impl<'a> Grower<'a> {
    pub fn new(
        world: &World,
        packed: &'a PackedGroom,
        shell: &'a Shell,
        segments: u32,
        patch: Option<Patch>,
    ) -> Self {
        let fur = packed.undercoat;
        Self {
            shell,
            maps: Maps { groom: &packed.groom, texels: &packed.texels },
            fur: UndercoatParameters { diameter_ratio: 1.0, ..fur },
            noise: Field::new(fur.seed),
            // Largest sum of 0.5 clumps and 0.6 locks: the noise reaches 0.99 in the plane and 0.81
            // in space.
            densest: 1.0 + fur.noise_contrast * if fur.noise_domain == 1 { 1.1 } else { 0.9 },
            diameter: world.scene.undercoat.diameter.map(|um| um * 1e-4),
            segments,
            seed: hash2(fur.seed, 0x756e_6465),
            patch,
        }
    }

    /// Number of candidates for hairs, 1/cm².
    pub fn candidate_density(&self) -> f64 {
        f64::from(self.fur.density) * f64::from(self.densest)
    }

    fn volume(&self) -> Undercoat<'_> {
        Undercoat { parameters: &self.fur, noise: self.noise, shell: self.shell, cells: &[] }
    }

    /// Number of candidates on a triangle, Poisson distributed: as many exponential gaps as fit
    /// into the mean.
    fn candidates(&self, prism: u32) -> u32 {
        if self.patch.is_some_and(|p| !p.reaches(self.shell, prism)) {
            return 0;
        }
        let place = self.shell.enter(prism);
        let mean = 0.5 * f64::from(place.e1.cross(place.e2).length()) * self.candidate_density();
        let seed = hash2(hash2(self.seed, prism), u32::MAX);
        let mut sum = 0.0;
        let mut count = 0;
        loop {
            // The middle of one of the 2^24 steps, so that the logarithm's argument is never 0.
            sum -= (f64::from(random(seed, count)) + 0.5 / 16_777_216.0).ln();
            if sum > mean || count == u32::MAX - 1 {
                return count;
            }
            count += 1;
        }
    }

    /// Grows all hairs.
    pub fn grow(&self) -> Strands {
        let counts: Vec<u32> =
            (0..self.shell.prisms.len() as u32).into_par_iter().map(|p| self.candidates(p)).collect();
        let jobs: Vec<(u32, std::ops::Range<u32>)> = (0..)
            .zip(counts)
            .flat_map(|(prism, count)| {
                let chunks = (0..count).step_by(CHUNK as usize);
                chunks.map(move |first| (prism, first..count.min(first + CHUNK)))
            })
            .collect();
        let grown: Vec<(Vec<Vec4>, Vec<Hair>)> = jobs
            .into_par_iter()
            .map(|(prism, range)| {
                let (mut points, mut hairs) = (Vec::new(), Vec::new());
                hairs.extend(range.filter_map(|k| self.hair(prism, k, &mut points)));
                (points, hairs)
            })
            .collect();
        Strands::joined(Layer::Undercoat, self.segments as usize, grown)
    }

    /// Grows the k-th candidate of a triangle; `None` outside the patch or where no segment is
    /// present.
    fn hair(&self, prism: u32, k: u32, points: &mut Vec<Vec4>) -> Option<Hair> {
        let seed = hash2(hash2(self.seed, prism), k);
        let lambda = even_barycentric(Vec2::new(random(seed, 0), random(seed, 1)));
        if let Some(patch) = &self.patch
            && !patch.holds(self.shell.enter(prism).point(0.0, lambda))
        {
            return None;
        }
        self.hair_at(prism, lambda, seed, points)
    }

    /// Grows the hair with its root at the barycentric coordinates `lambda` and appends its points
    /// to `points`; `None` where no segment is present.
    pub fn hair_at(&self, prism: u32, lambda: Vec3, seed: u32, points: &mut Vec<Vec4>) -> Option<Hair> {
        let variation = HairVariation::of(seed);
        let at = skin_point(self.shell, prism, lambda);
        let density = self.maps.scalar(Parameter::UndercoatDensity, &at) / self.fur.density;
        let place = Place { t: 0.0, lambda, ..self.shell.enter(prism) };
        if density <= 0.0 || place.extrusion(lambda).length_squared() < 1e-12 {
            return None;
        }
        let threshold = variation.threshold * self.densest / density;
        let volume = self.volume();
        let first = points.len();
        let mut present = 0;
        let mut walker = Walker { place, x: place.point(0.0, lambda), beyond: None };
        let dt = 1.0 / self.segments as f32;
        points.push(walker.x.extend(self.radius(0.0)));
        for k in 0..self.segments {
            let t = k as f32 * dt;
            // Midpoint rule: half a step first, then the whole step with the direction there.
            let half = self.climb(&walker, t, t + 0.5 * dt, self.direction(&walker.place, t, &variation));
            let along = self.direction(&half.place, t + 0.5 * dt, &variation);
            let end = if k + 1 == self.segments { 1.0 } else { t + dt };
            let next = self.climb(&walker, t, end, along);
            // Evaluated at another position for each hair, so that the mean over hairs is that of
            // the segment.
            let t_read = t + variation.phase * dt;
            let read = self.climb(&walker, t, t_read, along);
            if self.density(&volume, &read, t_read, &variation) > threshold {
                present |= 1 << k;
            }
            walker = next;
            points.push(walker.x.extend(self.radius(end)));
        }
        if present == 0 {
            points.truncate(first);
            return None;
        }
        let color = |p| self.maps.color(p, &at).clamp(Vec3::ZERO, Vec3::ONE);
        Some(Hair {
            color_root: color(Parameter::UndercoatColorRoot),
            color_tip: color(Parameter::UndercoatColorTip),
            glint_angle: pelage_fur::fibre::glint_angle(random(seed, 7)),
            present,
        })
    }

    /// Radius at height t, cm.
    fn radius(&self, t: f32) -> f32 {
        let [root, tip] = self.diameter;
        0.5 * (root + (tip - root) * t)
    }

    /// The volume's density relative to its mean, at a point of a hair.
    fn density(&self, volume: &Undercoat<'_>, at: &Walker, t: f32, variation: &HairVariation) -> f32 {
        let p = volume.domain_point(&at.place, at.place.lambda) + at.beyond.unwrap_or_default();
        let growth = t.powf(self.fur.jitter_exponent);
        volume.clump_density(p, p + self.fur.uv_jitter * growth * variation.displacement, t)
    }

    /// Direction of a hair, scaled so that its part along the shell's direction is 1: the volume's
    /// tangent, but with a jitter that is smooth along each hair, where the volume draws one for
    /// each cell.
    fn direction(&self, place: &Place, t: f32, variation: &HairVariation) -> Vec3 {
        let up = place.extrusion(place.lambda).normalize_or(Vec3::Y);
        let growth = t.powf(self.fur.jitter_exponent);
        let tangent = (up
            + Vec3::from(self.fur.lean) * t
            + self.fur.tangent_jitter * growth * variation.tangent_jitter(t))
        .normalize_or(up);
        let rise = tangent.dot(up);
        // DEVIATION: the volume's tangents may lie flat or point down; a hair that did would never
        // reach the top.
        up + (tangent - rise * up) / rise.max(STEEPEST)
    }

    /// Climbs from height `t` to `end` along a direction as that of [`Grower::direction`].
    fn climb(&self, from: &Walker, t: f32, end: f32, direction: Vec3) -> Walker {
        let mut walker = *from;
        let place = &mut walker.place;
        let up = place.extrusion(place.lambda);
        if let Some(beyond) = &mut walker.beyond {
            // A hair that hangs over the border of the skin keeps its last place.
            let step = direction * (up.length() * (end - t));
            walker.x += step;
            *beyond += self.in_domain(step, up);
            return walker;
        }
        // How fast t grows along the direction, relative to its growth along the extrusion.
        let normal = (place.e1 + t * place.w1).cross(place.e2 + t * place.w2);
        let rate = direction.dot(normal) / up.dot(normal);
        let least = 0.2 / up.length();
        let step = direction * ((end - t) / if rate > least { rate } else { least });
        place.t = end;
        // The height is known: no iterations are needed, only the barycentric coordinates, from
        // which the point then follows.
        match self.shell.locate(place, from.x + step, direction, 0) {
            Located::Inside => {
                walker.x = place.point(end, place.lambda);
            }
            Located::LeftBorder | Located::Lost => {
                walker.place = from.place;
                walker.x += step;
                walker.beyond = Some(self.in_domain(step, up));
            }
        }
        walker
    }

    /// A step as one in the noise's domain: along the skin, cm. In uv the last point is kept.
    fn in_domain(&self, step: Vec3, up: Vec3) -> Vec3 {
        if self.fur.noise_domain == 1 { Vec3::ZERO } else { step.reject_from(up) }
    }
}
