//! Growth of the rendering time with pixels, samples, guard hairs, triangles, and subelements of
//! the undercoat.

use super::super::{FigureContent, FigureContext};
use crate::bench::Column;
use crate::bench::sweep::multiply_strands;
use crate::report::Table;
use crate::report::plot::{Curve, Plot};
use pelage_core::scene::Storage;
use pelage_core::skin::Skin;
use pelage_core::{Error, Result, World};
use serde::Deserialize;
use std::collections::HashMap;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder.
    scene: String,
    /// Renderings of each variant; the fastest counts.
    runs: u32,
    /// Factors on the width and the height of the picture.
    sides: Vec<f32>,
    /// Samples a pixel.
    samples: Vec<u32>,
    /// Factors on the density of the guard hairs.
    strands: Vec<f32>,
    /// Numbers of times that each triangle is split into four.
    splits: Vec<u32>,
    /// Subdivision levels of the undercoat.
    subdivisions: Vec<u32>,
}

/// A quantity, and worlds that differ in it.
struct Sweep {
    name: &'static str,
    /// The quantity, measured in a rendering.
    amount: fn(&Column) -> f64,
    worlds: Vec<World>,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let mut content = FigureContent::default();
    let caption = "Exponents: a time grows as the quantity to this power, by least squares over the logarithms. Before the \
         first ray: steps 1 to 3; with the camera: steps 4 to 7.";
    let head = ["", "from", "to", "before the first ray", "with the camera", "all", "fragments"];
    let mut table = Table::new(caption, &head, Vec::new());
    for sweep in sweeps(&settings, &world) {
        let mut columns = Vec::new();
        for world in &sweep.worlds {
            let column = match Column::measure(context.gpu, world, sweep.name, settings.runs) {
                Err(e @ Error::OutOfMemory { .. }) => {
                    content.text += &format!("Left out of the {}: {e}.\n\n", sweep.name);
                    continue;
                }
                measured => measured?,
            };
            let ms = column.total_ms.map_or(column.wall_ms.min, |t| t.min);
            context.report(&format!("{} {}: {:.2} s", sweep.name, (sweep.amount)(&column), ms / 1e3))?;
            columns.push(column);
        }
        present(&sweep, &columns, &mut table, &mut content);
    }
    content.table(&table);
    Ok(content)
}

fn present(sweep: &Sweep, columns: &[Column], table: &mut Table, content: &mut FigureContent) {
    type Time = fn(&Column) -> Option<f64>;
    let times: [(&str, Time); 3] = [
        ("before the first ray (steps 1 to 3)", |c| c.preprocessing_ms.map(|t| t.min)),
        ("with the camera (steps 4 to 7)", |c| c.online_ms.map(|t| t.min)),
        ("all steps", |c| c.total_ms.map(|t| t.min)),
    ];
    let curve = |(name, time): (&str, Time)| {
        Curve::new(name, columns.iter().filter_map(|c| Some([(sweep.amount)(c), time(c)?])).collect())
    };
    let plot = Plot {
        caption: format!("Time by {}", sweep.name),
        x: sweep.name.to_owned(),
        y: "time, ms".into(),
        log: [true; 2],
        curves: times.map(curve).into(),
    };
    let amounts: Vec<f64> = columns.iter().map(sweep.amount).collect();
    let fragments: Vec<[f64; 2]> =
        columns.iter().map(|c| [(sweep.amount)(c), c.stats.fragments as f64]).collect();
    let show = |exponent: Option<f64>| exponent.map_or_else(|| "n/a".into(), |e| format!("{e:.2}"));
    let mut row = vec![
        sweep.name.to_owned(),
        format!("{:.0}", amounts.first().copied().unwrap_or_default()),
        format!("{:.0}", amounts.last().copied().unwrap_or_default()),
    ];
    row.extend(plot.curves.iter().map(|curve| show(exponent(&curve.points))));
    row.push(show(exponent(&fragments)));
    table.rows.push(row);
    if let Some(exponent) = exponent(&fragments) {
        content.value(&format!("fragments by {}, exponent", sweep.name), exponent, 0.03);
    }
    content.plot(&format!("by {}", sweep.name), plot);
}

/// Slope of the logarithms by least squares; `None` without two points of different positive x.
fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0).map(|p| p.map(f64::ln)).collect();
    let n = logs.len() as f64;
    let mean = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / n);
    let sum = |k: usize| logs.iter().map(|p| (p[0] - mean[0]) * (p[k] - mean[k])).sum::<f64>();
    let spread = sum(0);
    (spread > 0.0).then(|| sum(1) / spread)
}

fn sweeps(settings: &Settings, world: &World) -> [Sweep; 5] {
    let film = &world.scene.film;
    let changed = |change: &dyn Fn(&mut World)| {
        let mut world = world.clone();
        change(&mut world);
        world
    };
    let side = |factor: &f32| {
        changed(&|w: &mut World| {
            let of = |pixels: u32| ((pixels as f32 * factor).round() as u32).max(1);
            w.scene.film.width = of(film.width);
            w.scene.film.height = of(film.height);
        })
    };
    let strands = |factor: &f32| changed(&|w| multiply_strands(w, *factor));
    let split = |times: &u32| {
        changed(&|w: &mut World| {
            for _ in 0..*times {
                w.skin = split_in_four(&w.skin);
            }
            // Stored densities would grow with the number of triangles; evaluated ones treat all
            // levels alike.
            w.scene.undercoat.storage = Storage::Evaluated;
        })
    };
    let subdivision = |level: &u32| {
        changed(&|w: &mut World| {
            w.scene.undercoat.subdivision = Some(*level);
            w.scene.undercoat.storage = Storage::Stored;
        })
    };
    [
        Sweep {
            name: "pixels",
            amount: |c| f64::from(c.stats.width) * f64::from(c.stats.height),
            worlds: settings.sides.iter().map(side).collect(),
        },
        Sweep {
            name: "samples a pixel",
            amount: |c| f64::from(c.stats.spp),
            worlds: settings.samples.iter().map(|spp| changed(&|w| w.scene.film.spp = *spp)).collect(),
        },
        Sweep {
            name: "guard hairs",
            amount: |c| c.stats.strands as f64,
            worlds: settings.strands.iter().map(strands).collect(),
        },
        Sweep {
            name: "triangles of the skin",
            amount: |c| c.stats.triangles as f64,
            worlds: settings.splits.iter().map(split).collect(),
        },
        Sweep {
            name: "subelements of the undercoat",
            amount: |c| c.stats.subelements as f64,
            worlds: settings.subdivisions.iter().map(subdivision).collect(),
        },
    ]
}

/// The same surface with every triangle split into four by the midpoints of its edges.
fn split_in_four(skin: &Skin) -> Skin {
    let section_of = skin.section_of.iter().flat_map(|s| [*s; 4]).collect();
    let mut new = Skin { triangles: Vec::new(), corner_uv: None, section_of, ..skin.clone() };
    let mut middles = HashMap::new();
    let mut uv = Vec::new();
    for (t, corners) in skin.triangles.iter().enumerate() {
        let [a, b, c] = *corners;
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [i, k] = [a as usize, b as usize];
                new.positions.push(0.5 * (skin.positions[i] + skin.positions[k]));
                new.normals.push((skin.normals[i] + skin.normals[k]).normalize_or(skin.normals[i]));
                new.colors.push(0.5 * (skin.colors[i] + skin.colors[k]));
                if !skin.alphas.is_empty() {
                    new.alphas.push(0.5 * (skin.alphas[i] + skin.alphas[k]));
                }
                new.positions.len() as u32 - 1
            })
        });
        new.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        if let Some([a, b, c]) = skin.corner_uv.as_ref().map(|uv| uv[t]) {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]| 0.5 * (a + b));
            uv.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
    }
    new.corner_uv = skin.corner_uv.is_some().then_some(uv);
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_core::Scene;
    use pelage_core::mesh::topology;

    #[test]
    fn a_split_skin_is_the_same_surface() {
        let scene = Scene::parse("[mesh]\nshape = \"cylinder_pelt\"", "test", &[]).unwrap();
        let skin = World::load(scene, &pelage_core::assets::Assets::default()).unwrap().skin;
        let split = split_in_four(&skin);
        assert_eq!(split.triangles.len(), 4 * skin.triangles.len());
        assert!((split.area() / skin.area() - 1.0).abs() < 1e-4);
        let [before, after] = [&skin, &split].map(|skin| topology::neighbours(&skin.triangles));
        assert_eq!(after.boundary_edges, 2 * before.boundary_edges);
        assert_eq!((after.non_manifold_edges, after.inconsistent_edges), (0, 0));
        let uv = |skin: &Skin| -> f32 {
            let area = |[a, b, c]: &[glam::Vec2; 3]| (*b - *a).perp_dot(*c - *a);
            skin.corner_uv.iter().flatten().map(area).sum()
        };
        assert!((uv(&split) / uv(&skin) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn exponents_are_slopes_of_logarithms() {
        let points = |power: f64| [1.0f64, 2.0, 4.0, 8.0].map(|x| [x, 3.0 * x.powf(power)]);
        assert!((exponent(&points(1.0)).unwrap() - 1.0).abs() < 1e-9);
        assert!((exponent(&points(0.5)).unwrap() - 0.5).abs() < 1e-9);
        assert_eq!(exponent(&[[2.0, 1.0], [2.0, 3.0]]), None);
        assert_eq!(exponent(&[[2.0, 0.0], [4.0, 3.0]]), None);
    }
}
