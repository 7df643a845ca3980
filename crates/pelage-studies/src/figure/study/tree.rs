//! The march against finding subelements with a tree of bounding boxes, as Andersen et al. 2016
//! compare their march with a binary space partition.

use super::super::probe::{self, Probe};
use super::super::{FigureContent, FigureContext};
use super::boxes::{Piece, Start, Tree};
use crate::bench::{Times, repeat};
use crate::report::Table;
use crate::report::plot::{Curve, Plot};
use glam::Vec3;
use pelage_core::{Result, Skin, World};
use pelage_fur::shell::Place;
use pelage_fur::undercoat::extinction;
use pelage_fur::view::sample_ray;
use pelage_pathtrace::bvh::Stack;
use pelage_render::twin::resolve::Kind;
use pelage_render::twin::undercoat_march::{MarchInputs, first_phase, source_radiance, steps};
use serde::Deserialize;
use std::time::Instant;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Triangles of the skin within this distance of the camera's target are kept, cm.
    patch: f32,
    /// Deepest subdivision level; all from 0 are measured.
    deepest: u32,
    /// Number of rays on the CPU.
    rays: usize,
    /// Repetitions on the CPU, of which the fastest counts.
    runs: u32,
    /// Renderings, of which the fastest march counts.
    renderings: u32,
}

/// Results of a method over all rays.
#[derive(Default)]
struct Outcome {
    /// Optical depth of each ray.
    depths: Vec<f32>,
    /// Number of subelements or steps that were shaded.
    pieces: usize,
    /// Fastest run, µs per ray.
    micros: f64,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (mut world, _) = context.load(&settings.scene, &[])?;
    world.skin = patch(&world.skin, Vec3::from(world.scene.camera.target), settings.patch);
    if world.skin.triangles.is_empty() || settings.deepest > 6 {
        return Err(context.fault("the patch holds no triangle, or deepest is more than 6"));
    }
    let mut content = FigureContent::default();
    let mut levels = Vec::new();
    for d in 0..=settings.deepest {
        let level = Level::measure(context, &settings, &mut world, d)?;
        context.report(&format!("d = {d}: {} subelements", level.subelements))?;
        levels.push(level);
    }
    for l in &levels {
        let name = |what: &str| format!("d = {}: {what}", l.d);
        let depth = mean_depth(l);
        content.value(&name("mean optical depth, march"), depth, 0.01 * depth);
        let [relative, _] = rms(l, &l.points);
        content.value(&name("tree at each step: RMS relative difference of it"), relative, 0.003);
        let [relative, transmittance] = rms(l, &l.rays);
        content.value(&name("tree met by rays: RMS relative difference of it"), relative, 0.005);
        content.value(&name("tree met by rays: RMS difference of transmittance"), transmittance, 1e-4);
        content.value(&name("subelements a ray meets"), l.rays.pieces as f64 / l.count as f64, 0.5);
        content.value(&name("bytes of the tree"), l.tree_bytes as f64, 0.02 * l.tree_bytes as f64);
    }
    let curve = |name: &str, y: &dyn Fn(&Level) -> f64| {
        Curve::new(name, levels.iter().map(|l| [f64::from(l.d), y(l)]).collect())
    };
    let first = levels[0].march.micros;
    content.plot(
        "time",
        Plot {
            caption: format!("Time of a ray, {} rays, one thread on the CPU", levels[0].count),
            x: "subdivisions d".into(),
            y: "µs a ray".into(),
            log: [false, true],
            curves: vec![
                curve("march (CPU twin)", &|l| l.march.micros),
                curve("tree, asked at each step of the march", &|l| l.points.micros),
                curve("tree, all subelements that the ray meets", &|l| l.rays.micros),
                curve("march on the GPU, the device as a whole", &|l| l.gpu_micros.unwrap_or(f64::NAN)),
                curve("the paper's t (3 + 0.4 d), t our march at d = 0", &|l| first * papers_ratio(l.d)),
            ],
        },
    );
    content.plot(
        "memory",
        Plot {
            caption: format!(
                "Memory for {} prisms of {} layers",
                world.skin.triangles.len(),
                levels[0].layers
            ),
            x: "subdivisions d".into(),
            y: "bytes".into(),
            log: [false, true],
            curves: vec![
                curve("tree of boxes over the subelements", &|l| l.tree_bytes as f64),
                curve("corners of the subelements, to meet them by rays", &|l| l.body_bytes as f64),
                curve("volume that both read", &|l| l.volume_bytes as f64),
                curve("neighbours of the prisms, all that the march needs", &|l| l.neighbour_bytes as f64),
            ],
        },
    );
    content.table(&table(&levels));
    Ok(content)
}

/// Time with the paper's binary space partition by that of its march, at subdivision level `d`.
// [Andersen2016]
fn papers_ratio(d: u32) -> f64 {
    3.0 + 0.4 * f64::from(d)
}

/// Optical depths by the march and by another method, and their transmittances.
fn pairs<'a>(level: &'a Level, other: &'a Outcome) -> impl Iterator<Item = [[f64; 2]; 2]> + 'a {
    level.march.depths.iter().zip(&other.depths).map(|(a, b)| {
        let depths = [*a, *b].map(f64::from);
        [depths, depths.map(|d| (-d).exp())]
    })
}

fn mean_depth(level: &Level) -> f64 {
    level.march.depths.iter().map(|d| f64::from(*d)).sum::<f64>() / level.count as f64
}

/// Root mean squares of the relative difference of optical depths and of the difference of
/// transmittances.
fn rms(level: &Level, other: &Outcome) -> [f64; 2] {
    let root = |f: &dyn Fn([[f64; 2]; 2]) -> f64| {
        (pairs(level, other).map(|pair| f(pair).powi(2)).sum::<f64>() / level.count as f64).sqrt()
    };
    [root(&|[[a, b], _]| (a - b) / a.max(1e-3)), root(&|[_, [a, b]]| a - b)]
}

/// A skin of the triangles whose corners are all within `radius` cm of a point.
fn patch(skin: &Skin, centre: Vec3, radius: f32) -> Skin {
    let kept: Vec<usize> = (0..skin.triangles.len())
        .filter(|t| skin.corners(*t).iter().all(|p| p.distance(centre) < radius))
        .collect();
    let mut numbers = vec![u32::MAX; skin.positions.len()];
    let mut part = Skin { sections: skin.sections.clone(), colored: skin.colored, ..Skin::default() };
    part.triangles = kept
        .iter()
        .map(|t| {
            skin.triangles[*t].map(|v| {
                let v = v as usize;
                if numbers[v] == u32::MAX {
                    numbers[v] = part.positions.len() as u32;
                    part.positions.push(skin.positions[v]);
                    part.normals.push(skin.normals[v]);
                    part.colors.push(skin.colors.get(v).copied().unwrap_or(Vec3::ONE));
                    part.alphas.extend(skin.alphas.get(v));
                }
                numbers[v]
            })
        })
        .collect();
    part.corner_uv = skin.corner_uv.as_ref().map(|uv| kept.iter().map(|t| uv[*t]).collect());
    part.section_of = kept.iter().filter_map(|t| skin.section_of.get(*t).copied()).collect();
    part
}

/// All methods at one level.
struct Level {
    d: u32,
    layers: u32,
    count: usize,
    subelements: u64,
    march: Outcome,
    /// Time to look up medium and light at the places of the march, µs per ray.
    shading: f64,
    points: Outcome,
    rays: Outcome,
    gpu_micros: Option<f64>,
    build_ms: f64,
    tree_bytes: u64,
    body_bytes: u64,
    volume_bytes: u64,
    neighbour_bytes: u64,
}

impl Level {
    fn measure(context: &FigureContext, settings: &Settings, world: &mut World, d: u32) -> Result<Self> {
        world.scene.undercoat.subdivision = Some(d);
        let film = [world.scene.film.width, world.scene.film.height];
        let (starts, level) = {
            let probe = probe::probe(context.gpu, world, film, [0, 0], film)?;
            let starts = starts(&probe, settings.rays)?;
            if starts.0.is_empty() {
                return Err(context.fault("no ray enters the patch from above and ends on its skin"));
            }
            let level = Self::on_the_cpu(&probe, settings, d, &starts.0);
            (starts, level)
        };
        // Only the kernel that marches: with undercoat alone, resolve does nothing else.
        let runs = repeat(context.gpu, world, settings.renderings)?;
        let times = Times::of(runs.iter().map(|stats| {
            stats.passes.iter().filter(|p| p.pass.starts_with("resolve")).map(|p| p.ms).sum::<Option<f64>>()
        }));
        let all = starts.1.max(1) as f64;
        Ok(Self { gpu_micros: times.map(|t| 1e3 * t.min / all), ..level })
    }

    fn on_the_cpu(probe: &Probe<'_>, settings: &Settings, d: u32, starts: &[Start]) -> Self {
        let inputs = probe.inputs();
        let march = run(&inputs, starts, settings.runs, &mut |start, pieces| {
            for s in steps(&inputs, start.ray, start.prism, start.z, start.phase).0 {
                pieces.push(Piece {
                    from: s.z,
                    to: s.z_end,
                    place: s.place,
                    shaded: Some((s.sigma, s.radiance)),
                });
            }
        });
        // Shades the same places again, without finding them.
        let known: Vec<Vec<Place>> = starts
            .iter()
            .map(|s| steps(&inputs, s.ray, s.prism, s.z, s.phase).0.iter().map(|s| s.place).collect())
            .collect();
        let mut next = 0;
        let shading = run(&inputs, starts, settings.runs, &mut |start, pieces| {
            let z = start.z;
            pieces.extend(known[next % known.len()].iter().map(|p| Piece {
                from: z,
                to: z,
                place: *p,
                shaded: None,
            }));
            next += 1;
        });
        let begin = Instant::now();
        let tree = Tree::new(&probe.shell, probe.fur.undercoat.layers, d);
        let build_ms = begin.elapsed().as_secs_f64() * 1e3;
        let mut stack = Stack::new();
        let eye = Vec3::from(probe.frame.eye);
        let points = run(&inputs, starts, settings.runs, &mut |start, pieces| {
            tree.ask_at_steps(&inputs, eye, start, &mut stack, pieces);
        });
        let mut stack = Stack::new();
        let rays = run(&inputs, starts, settings.runs, &mut |start, pieces| {
            tree.meet(eye, start, &mut stack, pieces);
        });
        Self {
            d,
            layers: probe.fur.undercoat.layers,
            count: starts.len(),
            subelements: probe.prepared.subelements,
            march,
            shading: shading.micros,
            points,
            rays,
            gpu_micros: None,
            build_ms,
            tree_bytes: tree.bvh.bytes(),
            body_bytes: size_of_val(&tree.bodies[..]) as u64,
            volume_bytes: 4 * probe.prepared.subelements,
            neighbour_bytes: 12 * u64::from(probe.prepared.triangles),
        }
    }
}

/// Entries of evenly spaced pixels, and the number of all pixels with one. Only rays that enter
/// once, through the top, and end on the skin are kept, so that the border of the patch does not
/// count.
fn starts(probe: &Probe<'_>, most: usize) -> Result<(Vec<Start>, usize)> {
    let (lists, bases) = (probe.lists()?, probe.bases()?);
    let from_above = |i: usize, z: f32, prism: u32| {
        let (ray, mut place) = (sample_ray(&probe.frame, probe.xy(i)), probe.shell.enter(prism));
        place.t = 1.0;
        probe.shell.solve(&mut place, Vec3::from(probe.frame.eye) + z * ray, ray, 4);
        place.t > 0.999
    };
    let entered: Vec<(usize, f32, u32, f32)> = lists
        .iter()
        .zip(&bases)
        .enumerate()
        .filter_map(|(i, (list, base))| {
            let mut entries = list.iter().filter(|n| n.kind() == Kind::Entry);
            let (first, base) = (entries.next()?, (*base)?);
            let alone = entries.next().is_none() && from_above(i, first.z, first.id());
            alone.then(|| (i, first.z, first.id(), base.z))
        })
        .collect();
    let stride = entered.len().div_ceil(most.max(1)).max(1);
    let start = |(i, z, prism, z_base): &(usize, f32, u32, f32)| {
        let xy = probe.xy(*i);
        let (ray, phase) = (sample_ray(&probe.frame, xy), first_phase(&probe.frame, xy));
        Start { ray, z: *z, prism: *prism, phase, z_base: *z_base }
    };
    let all = lists.iter().filter(|list| !list.is_empty()).count();
    Ok((entered.iter().step_by(stride).map(start).collect(), all))
}

/// Runs a method over all rays: `find` finds the pieces, which are shaded in the same way for all
/// methods.
fn run(
    inputs: &MarchInputs<'_>,
    starts: &[Start],
    runs: u32,
    find: &mut dyn FnMut(&Start, &mut Vec<Piece>),
) -> Outcome {
    let mut outcome = Outcome { micros: f64::INFINITY, ..Outcome::default() };
    let mut pieces = Vec::new();
    for _ in 0..runs.max(1) {
        outcome.depths.clear();
        outcome.pieces = 0;
        let begin = Instant::now();
        for start in starts {
            pieces.clear();
            find(start, &mut pieces);
            outcome.pieces += pieces.len();
            let speed = start.ray.length();
            let view = -start.ray / speed;
            let mut opaque = 0.0;
            let mut light = Vec3::ZERO;
            for piece in &pieces {
                let (sigma, radiance) = piece.shaded.unwrap_or_else(|| {
                    let medium = inputs.undercoat.at(&piece.place);
                    let (radiance, density) = source_radiance(inputs, &piece.place, medium, view);
                    (extinction(&inputs.fur.undercoat, medium, view) * density * speed, radiance)
                });
                opaque += sigma * (piece.to.min(start.z_base) - piece.from).max(0.0);
                light += radiance * sigma;
            }
            // Keeps the compiler from removing the computation.
            std::hint::black_box(light);
            outcome.depths.push(opaque);
        }
        let micros = begin.elapsed().as_secs_f64() * 1e6 / starts.len().max(1) as f64;
        outcome.micros = outcome.micros.min(micros);
    }
    outcome
}

fn table(levels: &[Level]) -> Table {
    let head = [
        "d",
        "subelements",
        "march, µs",
        "tree at each step, µs",
        "ratio",
        "tree met by rays, µs",
        "ratio",
        "paper's ratio 3 + 0.4 d",
        "march on the GPU, µs",
        "shading alone, µs",
        "ratio of finding alone, at each step",
        "tree, bytes",
        "built in, ms",
        "steps a ray",
        "subelements a ray meets",
        "at each step: RMS difference of optical depth",
        "met by rays: RMS difference of optical depth",
    ];
    let rows = levels.iter().map(|l| {
        let count = l.count as f64;
        vec![
            l.d.to_string(),
            l.subelements.to_string(),
            format!("{:.1}", l.march.micros),
            format!("{:.1}", l.points.micros),
            format!("{:.2}", l.points.micros / l.march.micros),
            format!("{:.1}", l.rays.micros),
            format!("{:.2}", l.rays.micros / l.march.micros),
            format!("{:.1}", papers_ratio(l.d)),
            l.gpu_micros.map_or("n/a".into(), |t| format!("{t:.2}")),
            format!("{:.1}", l.shading),
            format!("{:.1}", (l.points.micros - l.shading) / (l.march.micros - l.shading).max(1e-3)),
            l.tree_bytes.to_string(),
            format!("{:.0}", l.build_ms),
            format!("{:.1}", l.march.pieces as f64 / count),
            format!("{:.1}", l.rays.pieces as f64 / count),
            format!("{:.2} %", 100.0 * rms(l, &l.points)[0]),
            format!("{:.2} %", 100.0 * rms(l, &l.rays)[0]),
        ]
    });
    Table::new("Times of a ray; ratios to the march:", &head, rows.collect())
}
