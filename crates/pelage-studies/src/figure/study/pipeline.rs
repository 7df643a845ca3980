//! The buffers after each step as pictures, as in Andersen et al. 2016, figure 3.

use super::super::drawing::{magma, number_color, pixel};
use super::super::probe::{self, Probe};
use super::super::{FigureContent, FigureContext};
use glam::Vec3;
use pelage_core::Result;
use pelage_core::film::Film;
use pelage_core::film::tonemap::{srgb_encode, tone_map};
use pelage_fur::layout::Root;
use pelage_fur::shell::Place;
use pelage_fur::view::{film_from_world, sample_ray};
use pelage_render::twin::base_raster;
use pelage_render::twin::film::Sample;
use pelage_render::twin::resolve::Kind;
use pelage_render::twin::undercoat_march::look_up;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Height within the shell at which volume and light are shown, 0..1.
    height: f32,
    /// Every how many-th root and hair is shown.
    each: usize,
}

/// Colour of pixels without a value, sRGB-encoded.
const NOTHING: Vec3 = Vec3::splat(0.86);

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, assets) = context.load(&settings.scene, &[])?;
    let size = context.size();
    let probe = probe::probe(context.gpu, &world, size, [0, 0], size)?;
    let entries = probe.lists()?;
    let places = places(&probe)?;
    let mut content = FigureContent::default();
    let mut strips = Strips { size, content: &mut content };

    // Step 1
    strips.show(&format!("1 prisms, 1/{} roots", settings.each), roots(&probe, &places, settings.each)?);
    // Step 2
    let at = |t: f32| {
        let places = &places;
        move |i: usize| places[i].map(|place| Place { t, ..place })
    };
    let high = at(settings.height);
    let inputs = probe.inputs();
    let density = |i: usize| high(i).map(|place| inputs.undercoat.at(&place).density);
    strips.map("2 density", density);
    let tangent = |i: usize| {
        let place = high(i)?;
        Some(0.5 + 0.5 * inputs.undercoat.at(&place).tangent)
    };
    let shown =
        |f: &dyn Fn(usize) -> Option<Vec3>| (0..probe.samples()).map(|i| f(i).unwrap_or(NOTHING)).collect();
    strips.show("2 tangents", shown(&tangent));
    let light = |i: usize| high(i).map(|place| (-look_up(&inputs, &place).tau[0]).exp());
    strips.map("2 key light", light);
    // Step 3
    let hairs = hairs(&probe, settings.each)?;
    strips.map(&format!("3 1/{} hairs", settings.each), |i| hairs[i]);
    // Steps 4 and 5
    let records: Vec<[u32; 4]> = probe.read("base_records", probe.samples())?;
    let bases: Vec<_> = records.into_iter().map(base_raster::unpack).collect();
    let normal = |i: usize| (bases[i].z < base_raster::NO_BASE).then(|| 0.5 + 0.5 * bases[i].normal);
    strips.show("4 skin: normals", shown(&normal));
    let entry = |i: usize| entries[i].iter().find(|n| n.kind() == Kind::Entry).map(|n| n.z);
    strips.map("5 entry, cm", entry);
    // Step 6
    probe.draw_strands()?;
    let lists = probe.lists()?;
    let drawn = |i: usize| {
        let count = lists[i].iter().filter(|n| n.kind() == Kind::Strand).count();
        (count > 0).then_some(count as f32)
    };
    strips.map("6 fragments", drawn);
    // Step 7
    let samples = probe.resolve(true)?;
    let spec = &world.scene.film;
    let display = |c: Vec3| tone_map(spec.tonemap, c * spec.exposure.exp2()).map(srgb_encode);
    let part = |f: &dyn Fn(&Sample) -> Vec3| -> Vec<Vec3> {
        let over = |s: &Sample| display(f(s));
        samples.iter().map(over).collect()
    };
    strips.show("7 guard hairs' part", part(&|s| s.guard));
    strips.show("7 undercoat's part", part(&|s| s.undercoat));
    let through = |i: usize| Some(samples[i].through);
    strips.map("7 passes", through);
    let fragments: usize = lists.iter().map(Vec::len).sum();
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    let entered = (0..probe.samples()).filter(|i| entry(*i).is_some()).count();
    let covered = bases.iter().filter(|b| b.z < base_raster::NO_BASE).count();
    let lit: Vec<f32> = (0..probe.samples()).filter_map(light).collect();
    let dense: Vec<f32> = (0..probe.samples()).filter_map(density).collect();
    let mean = |v: &[f32]| v.iter().map(|x| f64::from(*x)).sum::<f64>() / v.len().max(1) as f64;
    let about = |v: usize| (v as f64, 0.01 * v as f64);
    for (name, (value, tolerance)) in [
        ("guard hairs", (probe.prepared.strands as f64, 0.0)),
        ("subelements", (probe.prepared.subelements as f64, 0.0)),
        ("fragments", about(fragments)),
        ("longest list", about(longest)),
        ("pixels with an entry", about(entered)),
        ("pixels with skin", about(covered)),
        ("mean density at the height", (mean(&dense), 0.01)),
        ("mean part of the key light at the height", (mean(&lit), 0.01)),
    ] {
        content.value(name, value, tolerance);
    }
    content.images.push(context.render_panel("7 picture, filtered", &world, &assets)?);
    Ok(content)
}

/// Pictures of one size, some with a colour key.
struct Strips<'a> {
    size: [u32; 2],
    content: &'a mut FigureContent,
}

impl Strips<'_> {
    /// Rows of the colour key.
    const KEY: u32 = 6;

    /// Adds a picture of sRGB-encoded colours.
    fn show(&mut self, label: &str, colors: Vec<Vec3>) {
        let [w, h] = self.size;
        let pixels: Vec<[f32; 4]> = colors.into_iter().map(pixel).collect();
        self.content.picture(label, Film::from_premultiplied(w, h, &pixels));
    }

    /// Adds a picture of values in the magma colour map, from the smallest to the 99th percentile.
    /// The label contains the range; the colour key covers the lowest rows.
    fn map(&mut self, label: &str, value: impl Fn(usize) -> Option<f32>) {
        let [w, h] = self.size;
        let values: Vec<Option<f32>> = (0..w as usize * h as usize).map(value).collect();
        let mut sorted: Vec<f32> = values.iter().flatten().copied().collect();
        sorted.sort_by(f32::total_cmp);
        let low = sorted.first().copied().unwrap_or(0.0);
        let high = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(1.0);
        let color = |v: f32| magma((v - low) / (high - low).max(1e-9));
        let mut colors: Vec<Vec3> = values.iter().map(|v| v.map_or(NOTHING, color)).collect();
        let key = h.saturating_sub(Self::KEY);
        for (x, y) in (key..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let shown = if y == key { Vec3::ONE } else { magma(x as f32 / w as f32) };
            colors[(y * w + x) as usize] = shown;
        }
        let digits = usize::from(high < 10.0);
        self.show(&format!("{label}: {low:.digits$}-{high:.digits$}"), colors);
    }
}

/// The place on the skin that is visible in each pixel.
fn places(probe: &Probe<'_>) -> Result<Vec<Option<Place>>> {
    let triangles = base_raster::triangles(&probe.frame, &probe.shell);
    let place = |(i, triangle): (usize, &Option<u32>)| {
        let mut place = probe.shell.enter((*triangle)?);
        let ray = sample_ray(&probe.frame, probe.xy(i));
        let n = place.e1.cross(place.e2);
        let z = (place.p0 - Vec3::from(probe.frame.eye)).dot(n) / ray.dot(n);
        let a = Vec3::from(probe.frame.eye) + z * ray - place.p0;
        let (l1, l2) = (a.cross(place.e2).dot(n) / n.dot(n), place.e1.cross(a).dot(n) / n.dot(n));
        place.lambda = Vec3::new(1.0 - l1 - l2, l1, l2);
        Some(place)
    };
    Ok(triangles.iter().enumerate().map(place).collect())
}

/// Prisms, each in its own colour, and the visible roots.
fn roots(probe: &Probe<'_>, places: &[Option<Place>], each: usize) -> Result<Vec<Vec3>> {
    let mut colors: Vec<Vec3> =
        places.iter().map(|p| p.map_or(NOTHING, |place| number_color(place.prism, 0.25, 0.95))).collect();
    let roots: Vec<Root> = probe.read("roots", probe.prepared.strands as usize)?;
    let [width, height] = probe.frame.tile_size;
    for root in roots.into_iter().step_by(each.max(1)) {
        let place = probe.shell.enter(root.prism);
        let [l1, l2] = root.lambda;
        let p = place.point(0.0, Vec3::new(1.0 - l1 - l2, l1, l2));
        let at = film_from_world(&probe.frame, p);
        if at.x < 0.0 || at.y < 0.0 || at.x >= width as f32 || at.y >= height as f32 {
            continue;
        }
        let i = at.y as usize * width as usize + at.x as usize;
        // Other roots are on the far side of the skin.
        let near = places[i].is_some_and(|seen| (seen.point(0.0, seen.lambda) - p).length() < 0.5);
        if near {
            colors[i] = Vec3::ZERO;
        }
    }
    Ok(colors)
}

/// Position along the nearest hair in each pixel: 0 root, 1 tip.
fn hairs(probe: &Probe<'_>, each: usize) -> Result<Vec<Option<f32>>> {
    let segments = probe.prepared.segments as usize;
    let vertices: Vec<[f32; 4]> =
        probe.read("strand_vertices", probe.prepared.strands as usize * (segments + 1))?;
    let [width, height] = probe.frame.tile_size;
    let mut nearest = vec![(f32::INFINITY, None); probe.samples()];
    for strand in vertices.chunks_exact(segments + 1).step_by(each.max(1)) {
        let film: Vec<Vec3> =
            strand.iter().map(|v| film_from_world(&probe.frame, Vec3::new(v[0], v[1], v[2]))).collect();
        for (k, pair) in film.windows(2).enumerate() {
            let points = (2.0 * pair[0].truncate().distance(pair[1].truncate())).clamp(1.0, 200.0).ceil();
            for j in 0..points as u32 {
                let part = j as f32 / points;
                let at = pair[0].lerp(pair[1], part);
                let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < width as f32 && at.y < height as f32;
                if !inside || at.z < probe.frame.near {
                    continue;
                }
                let slot = &mut nearest[at.y as usize * width as usize + at.x as usize];
                if at.z < slot.0 {
                    *slot = (at.z, Some((k as f32 + part) / segments as f32));
                }
            }
        }
    }
    Ok(nearest.into_iter().map(|(_, height)| height).collect())
}
