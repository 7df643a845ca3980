//! The undercoat's volume against its hairs: optical depths along the same rays.

use crate::common::beams::{Beam, hits, optical_depth, segments};
use crate::common::gpu;
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_fur::groom;
use pelage_fur::layout::UndercoatParameters;
use pelage_fur::random::random;
use pelage_fur::shell::{Located, Place, Shell};
use pelage_fur::shell_prisms::shell_of;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::{Undercoat, extinction};
use pelage_pathtrace::grow::{GrowOptions, grow};
use pelage_pathtrace::strands::Strands;
use std::f32::consts::TAU;

/// A fur of few thick hairs, with the optical depths of many thin ones.
fn furry(mesh: &str, coat: &str) -> World {
    let text = format!(
        "[mesh]\n{mesh}\n[guard]\ncomb_direction = [1, 0, 0]\n[render]\nfur = \"implicit\"\nseed = 2\n\
         [undercoat]\ndensity = 3000\ndiameter = [30, 30]\nlayers = 64\nnoise_contrast = 0\nheight_variation = 0\nuv_jitter = 0\n{coat}"
    );
    gpu::world(&text)
}

/// A fur as volume and as hairs.
struct Both {
    shell: Shell,
    fur: UndercoatParameters,
    strands: Strands,
    /// Centroids of the triangles, cm.
    middles: Vec<Vec3>,
}

impl Both {
    fn new(world: &World) -> Self {
        let packed = groom::pack(world).expect("a groom");
        let mut layers = grow(world, &GrowOptions { patch: None, undercoat_segments: 16 }).expect("strands");
        let middles = (0..world.skin.triangles.len())
            .map(|t| world.skin.corners(t).into_iter().sum::<Vec3>() / 3.0)
            .collect();
        Self { shell: shell_of(world, &packed), fur: packed.undercoat, strands: layers.remove(0), middles }
    }

    /// The place of a point, if it lies in the shell.
    fn place(&self, x: Vec3, w: Vec3, last: Option<Place>) -> Option<Place> {
        let inside = |mut place: Place| {
            let found = self.shell.locate(&mut place, x, w, 4) == Located::Inside;
            (found && (0.0..1.0).contains(&place.t)).then_some(place)
        };
        last.and_then(inside).or_else(|| {
            let distance = |i: &usize| self.middles[*i].distance_squared(x);
            let nearest = (0..self.middles.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            inside(Place { t: 0.5, ..self.shell.enter(nearest as u32) })
        })
    }

    /// Optical depths of the volume along `w` from `x`, cm, over `length` cm: without the hairs'
    /// crowding, and as it is.
    fn march(&self, x: Vec3, w: Vec3, length: f32) -> [f64; 2] {
        const STEP: f32 = 0.01;
        let coat = Undercoat { parameters: &self.fur, noise: Field::new(2), shell: &self.shell, cells: &[] };
        let mut sums = [0.0; 2];
        let mut place = None;
        for i in 0..(length / STEP) as u32 {
            place = self.place(x + (i as f32 + 0.5) * STEP * w, w, place);
            if let Some(place) = &place {
                let medium = coat.at(place);
                let depth = f64::from(extinction(&self.fur, medium, w) * STEP);
                sums[0] += depth / f64::from(place.crowding(place.t, medium.tangent));
                sums[1] += depth;
            }
        }
        sums
    }

    /// Mean optical depths along rays (start, direction `w`) of the hairs that are `kept`, of the
    /// volume without the crowding, and as it is.
    fn depths(&self, w: Vec3, starts: &[Vec3], length: f32, kept: impl Fn(Vec3) -> bool) -> [f64; 3] {
        let beam = Beam::new(w);
        let rays: Vec<Vec2> = starts.iter().map(|x| beam.across(*x)).collect();
        let there = segments(&self.strands).filter(|[a, b]| kept(0.5 * (a + b).truncate()));
        let hairs = optical_depth(&hits(&beam, &rays, there));
        let some: Vec<&Vec3> = starts.iter().step_by(starts.len() / 60).collect();
        let mut sums = [0.0; 2];
        for x in &some {
            let of_ray = self.march(**x, beam.along, length);
            (0..2).for_each(|k| sums[k] += of_ray[k] / some.len() as f64);
        }
        [hairs, sums[0], sums[1]]
    }
}

#[track_caller]
fn report(what: &str, [hairs, volume, crowded]: [f64; 3], tolerance: f64) {
    let off = |x: f64| 100.0 * (x / hairs - 1.0);
    println!(
        "{what}: hairs {hairs:.4}; volume without crowding {volume:.4} ({:+.1} %), as it is {crowded:.4} ({:+.1} %)",
        off(volume),
        off(crowded)
    );
    assert!((crowded / hairs - 1.0).abs() < tolerance, "{what}: {crowded} is not {hairs}");
}

/// Rays through a slab of 5 x 5 cm: `degrees` from the normal, towards `azimuth` degrees from the
/// lean.
fn slab(both: &Both, height: f32, degrees: f32, azimuth: f32) -> [f64; 3] {
    let (angle, azimuth) = (degrees.to_radians(), azimuth.to_radians());
    let across = Vec3::new(azimuth.cos(), 0.0, azimuth.sin());
    let w = across * angle.sin() - Vec3::Y * angle.cos();
    let length = height / angle.cos();
    // About the middle of the square, half a centimetre from its border where the hairs lean out or
    // are missing.
    let starts: Vec<Vec3> = (0..20_000)
        .map(|k| {
            let [x, z] = [random(k, 1), random(k, 2)].map(|u| 2.4 * (u - 0.5));
            Vec3::new(x, 0.5 * height, z) - 0.5 * length * w
        })
        .collect();
    both.depths(w, &starts, length, |_| true)
}

#[test]
fn flat_skin_with_upright_hairs() {
    let both = Both::new(&furry("shape = \"plane\"\nsize = 5", "height = 0.5\ntangent_jitter = 0"));
    for degrees in [20.0, 45.0, 70.0] {
        let [hairs, volume, crowded] = slab(&both, 0.5, degrees, 30.0);
        report(&format!("flat, upright, {degrees} degrees"), [hairs, volume, crowded], 0.02);
        assert!((volume / hairs - 1.0).abs() < 0.02);
    }
}

#[test]
fn flat_skin_with_leaning_hairs() {
    let both =
        Both::new(&furry("shape = \"plane\"\nsize = 5", "height = 0.5\ntangent_jitter = 0\nlean = 0.5"));
    for (degrees, azimuth) in [(0.0, 0.0), (45.0, 0.0), (45.0, 90.0), (45.0, 180.0), (70.0, 90.0)] {
        let depths = slab(&both, 0.5, degrees, azimuth);
        report(&format!("flat, lean 0.5, {degrees} degrees, azimuth {azimuth}"), depths, 0.02);
    }
}

#[test]
fn flat_skin_with_turned_hairs() {
    let both = Both::new(&furry(
        "shape = \"plane\"\nsize = 5",
        "height = 0.5\ntangent_jitter = 0.4\nsubdivision = 5",
    ));
    for degrees in [0.0, 45.0, 70.0] {
        report(&format!("flat, jitter 0.4, {degrees} degrees"), slab(&both, 0.5, degrees, 0.0), 0.04);
    }
}

/// Rays that pass a ball of 3 cm radius at `distance` cm from its centre, along z.
fn ball(both: &Both, distance: f32) -> [f64; 3] {
    let starts: Vec<Vec3> = (0..20_000)
        .map(|k| {
            let (sin, cos) = (TAU * random(k, 3)).sin_cos();
            // A thin ring.
            let r = distance + 0.02 * (random(k, 4) - 0.5);
            Vec3::new(r * cos, r * sin, 5.0)
        })
        .collect();
    let blocked = distance < 3.0;
    let length = if blocked { 5.0 - (9.0 - distance * distance).sqrt() } else { 10.0 };
    both.depths(Vec3::NEG_Z, &starts, length, |p| !blocked || p.z > 0.0)
}

#[test]
fn curved_skin_with_upright_hairs() {
    let both = Both::new(&furry("shape = \"sphere\"\nsize = 6", "height = 1\ntangent_jitter = 0"));
    for distance in [1.5, 2.5, 3.1, 3.4, 3.7] {
        report(&format!("ball, upright, {distance} cm from its centre"), ball(&both, distance), 0.03);
    }
}

#[test]
fn curved_skin_with_leaning_hairs() {
    let both =
        Both::new(&furry("shape = \"sphere\"\nsize = 6", "height = 1\ntangent_jitter = 0\nlean = 0.5"));
    for distance in [1.5, 2.5, 3.1, 3.4, 3.7] {
        report(&format!("ball, lean 0.5, {distance} cm from its centre"), ball(&both, distance), 0.3);
    }
}
