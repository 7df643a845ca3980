//! Transmittance of a slab of upright hairs.

use super::{Exhibit, Finding, Goal, Lab, Section, Table};
use crate::report::plot::{Curve, Plot};
use glam::{Vec2, Vec3, Vec3A, Vec4};
use pelage_core::{Result, World};
use pelage_fur::fibre::Fibre;
use pelage_fur::random::{hash2, random};
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use pelage_fur::{Layer, camera, groom, view};
use pelage_pathtrace::bvh::Ray;
use pelage_pathtrace::geometry::{Geometry, Hit, RayOrigin};
use pelage_pathtrace::grow::{GrowOptions, Patch, grow};
use pelage_pathtrace::strands::{Hair, Strands};
use rayon::prelude::*;
use std::f32::consts::TAU;
use std::f64::consts::PI;

/// Largest allowed difference of a transmittance.
pub const GOAL: f64 = 0.02;
/// Hairs have their roots within about this distance of the centre, cm.
const REACH: f32 = 2.6;
/// Rays end within this distance of the centre, cm.
const TARGET: f32 = 0.6;
/// Height above the skin at which rays start, in heights of the slab.
const ABOVE: f32 = 1.2;

/// A slab of upright hairs of constant diameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Hairs/cm².
    pub density: f32,
    /// Diameter of a hair, cm.
    pub diameter: f32,
    /// Height of the slab, cm.
    pub height: f32,
    /// Mean part of the hairs that is present, over the height; towards their ends hairs thin out.
    pub fill: f64,
}

/// Distribution of the roots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roots {
    /// Independent and uniform.
    Random,
    /// One in each square of a grid.
    Jittered,
}

impl Slab {
    /// The slab of a scene whose undercoat is uniform and upright.
    ///
    /// # Errors
    /// Those of [`groom::pack`].
    pub fn of(world: &World) -> Result<Self> {
        let spec = &world.scene.undercoat;
        let packed = groom::pack(world)?;
        let shell = Shell::default();
        let undercoat =
            Undercoat { parameters: &packed.undercoat, noise: Field::new(0), shell: &shell, cells: &[] };
        let layers = spec.layers.max(1);
        let at =
            |l: u32| undercoat.evaluate(Vec3::ZERO, Vec3::Y, (l as f32 + 0.5) / layers as f32, 0).density;
        let fill = (0..layers).map(|l| f64::from(at(l))).sum::<f64>() / f64::from(layers);
        Ok(Self {
            density: spec.density.max(),
            diameter: spec.diameter[0] * 1e-4,
            height: spec.height.max(),
            fill,
        })
    }

    /// Transmittance at `angle` radians from the normal: exp(-n d s sin θ), with path length s = H
    /// / cos(angle) and the angle θ = `angle` between ray and hairs.
    pub fn expected(&self, angle: f64) -> f64 {
        let projected =
            f64::from(self.density) * f64::from(self.diameter) * f64::from(self.height) * self.fill;
        (-projected * angle.tan()).exp()
    }

    /// Its hairs as strands of full length around the centre.
    pub fn strands(&self, roots: Roots, seed: u32) -> Strands {
        let side = 1.0 / self.density.sqrt();
        let cells = (REACH / side).ceil() as i32;
        let squares = (4 * cells * cells) as u32;
        let root = |i: u32| {
            let u = [random(hash2(seed, i), 0), random(hash2(seed, i), 1)];
            match roots {
                Roots::Random => [0, 1].map(|k| (2.0 * u[k] - 1.0) * cells as f32 * side),
                Roots::Jittered => {
                    let cell = [i as i32 % (2 * cells) - cells, i as i32 / (2 * cells) - cells];
                    [0, 1].map(|k| (cell[k] as f32 + u[k]) * side)
                }
            }
        };
        let radius = 0.5 * self.diameter;
        let points = (0..squares)
            .flat_map(|i| {
                let [x, z] = root(i);
                [Vec4::new(x, 0.0, z, radius), Vec4::new(x, self.height, z, radius)]
            })
            .collect();
        let hair = Hair { color_root: Vec3::ONE, color_tip: Vec3::ONE, glint_angle: 0.0, present: u64::MAX };
        Strands {
            layer: Layer::Undercoat,
            segments: 1,
            points,
            hairs: vec![hair; squares as usize],
            opacity: Vec::new(),
            color_transition: [0.0, 1.0],
            color_transitions: Vec::new(),
        }
    }
}

/// Part of `rays` rays at `angle` radians from the normal that pass through hairs of `height` cm to
/// the skin, the plane y = 0.
pub fn through(geometry: &Geometry, height: f32, angle: f32, rays: u32) -> f64 {
    let passed: u32 = (0..rays)
        .into_par_iter()
        .map_init(Vec::new, |stack, i| {
            let h = hash2(0x5eed, i);
            let (around, radius) = (TAU * random(h, 0), TARGET * random(h, 1).sqrt());
            let end = Vec3::new(radius * around.cos(), 0.0, radius * around.sin());
            let azimuth = TAU * random(h, 2);
            let up = Vec3::new(angle.sin() * azimuth.cos(), angle.cos(), angle.sin() * azimuth.sin());
            let start = end + ABOVE * height / angle.cos() * up;
            let ray = Ray::new(Vec3A::from(start), Vec3A::from(-up));
            let hit = geometry.closest(&ray, &RayOrigin::default(), h, stack);
            u32::from(matches!(hit, Some((Hit::Surface(_), _))))
        })
        .sum();
    f64::from(passed) / f64::from(rays)
}

/// Largest difference between two curves with the same x values; NaN if one is NaN.
pub fn worst(found: &[[f64; 2]], expected: &[[f64; 2]]) -> f64 {
    // `f64::max` would ignore NaN.
    found
        .iter()
        .zip(expected)
        .map(|(a, b)| (a[1] - b[1]).abs())
        .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Mean transmittance to the skin by the march through the volume at `degrees` from the normal, and
/// the expected one.
fn marched(lab: &Lab, world: &World, slab: &Slab, degrees: f32) -> Result<[f64; 2]> {
    let mut world = world.clone();
    let (sin, cos) = degrees.to_radians().sin_cos();
    world.scene.camera.eye = [0.0, 10.0 * cos, 10.0 * sin];
    world.scene.camera.up = [0.0, sin, -cos];
    let film = lab.render(&world)?.film;
    let frame = camera::frame(&world.scene.camera, [film.width, film.height], Vec2::ZERO, Vec2::ZERO, 0);
    let base = film.plane("base.R").unwrap_or_default();
    let white = world.lights.iter().map(|l| f64::from(l.irradiance.x)).sum::<f64>() / PI;
    let mut expected = 0.0;
    for y in 0..film.height {
        for x in 0..film.width {
            let ray = view::sample_ray(&frame, [x, y]).normalize();
            expected += slab.expected(f64::from(-ray.y).clamp(-1.0, 1.0).acos());
        }
    }
    let pixels = film.pixels() as f64;
    Ok([base.iter().map(|v| f64::from(*v)).sum::<f64>() / white / pixels, expected / pixels])
}

/// The experiment.
///
/// # Errors
/// Those of the scene, of growing and of rendering.
pub fn run(lab: &Lab) -> Result<Section> {
    let step = lab.choose(20, 10, 5);
    let rays = lab.choose(20_000, 60_000, 200_000);
    let angles: Vec<f32> = (0..=80).step_by(step).map(|a| a as f32).collect();
    let (world, _) = lab.world("slab", &[])?;
    let slab = Slab::of(&world)?;
    let full = Slab { fill: 1.0, ..slab };
    let grown =
        GrowOptions { patch: Some(Patch { centre: Vec3::ZERO, radius: REACH }), undercoat_segments: 32 };
    let mut grown = grow(&world, &grown)?;
    grown.retain(|strands| strands.layer == Layer::Undercoat);
    let with_fibre =
        |strands: Vec<Strands>| strands.into_iter().map(|s| (s, Fibre::undercoat(&world.scene))).collect();
    let kinds: [(&str, Slab, Vec<Strands>, bool); 3] = [
        ("undercoat grown as strands", slab, grown, true),
        ("strands with random roots", full, vec![full.strands(Roots::Random, 7)], true),
        ("strands with jittered roots", full, vec![full.strands(Roots::Jittered, 7)], false),
    ];
    let all = angles.len() * (kinds.len() + 1);
    let mut done = 0;
    let mut section = Section { text: text(&slab), ..Section::default() };
    let mut curves = Vec::new();
    let mut add = |name: &str, found: Vec<[f64; 2]>, expected: &[[f64; 2]], has_goal: bool| {
        let goal = has_goal.then_some(Goal::AtMost(GOAL));
        let case = format!("upright, 0 to 80 degrees, {} angles", found.len());
        let worst = worst(&found, expected);
        section.findings.push(Finding::new(
            name,
            &case,
            "largest difference of the transmittance",
            worst,
            goal,
        ));
        curves.push((name.to_owned(), found));
    };
    let exact = |slab: &Slab| -> Vec<[f64; 2]> {
        angles.iter().map(|a| [f64::from(*a), slab.expected(f64::from(*a).to_radians())]).collect()
    };
    for (name, slab, strands, has_goal) in kinds {
        let geometry = Geometry::new(&world, with_fibre(strands))?;
        let mut found = Vec::new();
        for degrees in &angles {
            found.push([f64::from(*degrees), through(&geometry, slab.height, degrees.to_radians(), rays)]);
            done += 1;
            lab.step(done, all)?;
        }
        add(name, found, &exact(&slab), has_goal);
    }
    let (mut found, mut expected) = (Vec::new(), Vec::new());
    for degrees in &angles {
        let [seen, wanted] = marched(lab, &world, &slab, *degrees)?;
        found.push([f64::from(*degrees), seen]);
        expected.push([f64::from(*degrees), wanted]);
        done += 1;
        lab.step(done, all)?;
    }
    add("march through the volume", found, &expected, true);
    let head = ["angle", "Beer and Lambert, with thinned ends", "without"];
    let mut table = Table::new("Transmittance by the angle to the normal, degrees", &head, Vec::new());
    table.head.extend(curves.iter().map(|(name, _)| name.clone()));
    for (i, degrees) in angles.iter().enumerate() {
        let exact = [slab, full].map(|s| s.expected(f64::from(*degrees).to_radians()));
        let values = exact.into_iter().chain(curves.iter().map(|(_, points)| points[i][1]));
        table
            .rows
            .push(std::iter::once(format!("{degrees}")).chain(values.map(|v| format!("{v:.4}"))).collect());
    }
    section.exhibits.push(Exhibit { table: Some(table), pictures: Vec::new() });
    let mut plot = Plot {
        caption: "Transmittance of the slab".into(),
        x: "angle to the normal, degrees".into(),
        y: "transmittance".into(),
        log: [false; 2],
        curves: vec![Curve::new("Beer and Lambert", exact(&slab))],
    };
    plot.curves.extend(curves.into_iter().map(|(name, points)| Curve::new(name, points)));
    section.plots.push(plot);
    Ok(section)
}

fn text(slab: &Slab) -> Vec<String> {
    vec![
        format!(
            "Upright hairs, {} to the cm², {:.0} µm thick, {} cm high. The transmittance of random parallel cylinders is \
             exp(-n d s sin θ). Strands are intersected by rays in the path tracer's geometry; the march is measured by the light \
             from a white skin below a volume that scatters nothing. Towards their ends the hairs of the march and of the strands \
             grown from the scene thin out ({:.1} % of the hair is present); the other strands have full length.",
            slab.density,
            slab.diameter * 1e4,
            slab.height,
            100.0 * slab.fill
        ),
        "Roots jittered on a grid block more light than random ones; they are shown for comparison and have no goal. Along the \
         hairs (0 degrees) strands block the area of their ends, which the formula neglects."
            .into(),
    ]
}
