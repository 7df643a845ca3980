//! pbrt-v4: a scene file, one file of curves per layer, the skin as PLY, the sky as a square map.

use super::curves;
use super::objects::{self, Exported};
use super::sky::{self, Sky};
use super::{Job, material, mean, ply, skin_colors};
use glam::Vec3;
use pelage_core::Result;
use pelage_core::scene::Filter;
use pelage_pathtrace::strands::Strands;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Largest number of materials of a layer: pbrt's curves carry no colours, so each colour is a
/// material.
const MOST_BINS: usize = 256;

/// Colours of a layer's segments, quantised.
struct Bins {
    /// Steps per channel.
    levels: f32,
    /// Index of each cell in `colors`.
    numbers: BTreeMap<[u8; 3], usize>,
    /// Mean colours, linear RGB.
    colors: Vec<Vec3>,
    /// Largest difference in a channel between a segment and its bin.
    error: f32,
}

impl Bins {
    /// The finest quantisation with at most [`MOST_BINS`] colours.
    fn of(strands: &Strands) -> Self {
        let colors =
            || curves::segments(strands).map(|s| curves::color(strands, s.hair, s.number as f32 + 0.5));
        // The finest step separates colours exactly if there are only a few.
        let mut levels = 255.0;
        loop {
            let mut sums: BTreeMap<[u8; 3], (glam::DVec3, u64)> = BTreeMap::new();
            for c in colors() {
                let sum = sums.entry(cell(c, levels)).or_default();
                *sum = (sum.0 + c.as_dvec3(), sum.1 + 1);
                if sums.len() > MOST_BINS {
                    break;
                }
            }
            if sums.len() > MOST_BINS && levels > 1.0 {
                levels = (levels * 0.8).floor().max(1.0);
                continue;
            }
            let means = sums.values().map(|(sum, n)| (*sum / *n as f64).as_vec3()).collect();
            let numbers = sums.keys().enumerate().map(|(i, key)| (*key, i)).collect();
            let mut bins = Self { levels, numbers, colors: means, error: 0.0 };
            bins.error =
                colors().fold(0.0, |e: f32, c| e.max((c - bins.colors[bins.number(c)]).abs().max_element()));
            return bins;
        }
    }

    fn number(&self, color: Vec3) -> usize {
        self.numbers.get(&cell(color, self.levels)).copied().unwrap_or(0)
    }
}

/// The cell of a colour. Cells are evenly spaced in the square root, which suits both perception
/// and absorption.
fn cell(color: Vec3, levels: f32) -> [u8; 3] {
    color.to_array().map(|c| (c.max(0.0).sqrt() * levels).round() as u8)
}

pub(super) fn write(job: &mut Job<'_>, notes: Vec<String>) -> Result<()> {
    let mut notes = notes;
    ply::write(job, ply::V::Up)?;
    objects::write_images(job)?;
    if let Some(Sky::Map { panorama, rotate }) = &job.sky {
        let path = job.folder.join("sky.exr");
        let side = sky::side(panorama);
        sky::write_exr(&path, side, side, sky::squared(panorama, *rotate, side))?;
        job.wrote(path, format!("{side} x {side} texels"))?;
    }
    let mut layers = Vec::new();
    for strands in job.strands {
        let name = curves::name(strands.layer);
        let bins = Bins::of(strands);
        if bins.error > 0.0 {
            notes.push(format!(
                "colours of the {name} are put into {} materials, constant along a segment; the largest difference is {:.4} of 1",
                bins.colors.len(),
                bins.error
            ));
        }
        let file = format!("{name}.pbrt");
        job.file(&file, curves::holds(strands), |job, out| layer(job, strands, &bins, out))?;
        layers.push(file);
    }
    job.file("scene.pbrt", String::new(), |job, out| scene(job, &notes, &layers, out))
}

fn layer(job: &Job<'_>, strands: &Strands, bins: &Bins, out: &mut dyn Write) -> io::Result<()> {
    let name = curves::name(strands.layer);
    let material = material::of(&job.world.scene, strands.layer);
    let h = material.hair;
    for (i, color) in bins.colors.iter().enumerate() {
        let a = material.absorption(*color);
        writeln!(
            out,
            "MakeNamedMaterial \"{name}{i}\" \"string type\" \"hair\" \"rgb sigma_a\" [ {} {} {} ] \"float beta_m\" {} \
             \"float beta_n\" {} \"float alpha\" {} \"float eta\" {}",
            a.x, a.y, a.z, h.beta_m, h.beta_n, h.alpha_degrees, h.ior
        )?;
    }
    let mut current = None;
    for segment in curves::segments(strands) {
        let color = curves::color(strands, segment.hair, segment.number as f32 + 0.5);
        let bin = bins.number(color);
        if current != Some(bin) {
            writeln!(out, "NamedMaterial \"{name}{bin}\"")?;
            current = Some(bin);
        }
        let [a, b] = segment.ends;
        write!(out, "Shape \"curve\" \"string type\" \"cylinder\" \"integer splitdepth\" 0 \"point3 P\" [")?;
        for t in [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0] {
            let p = if t == 1.0 { b } else { a.lerp(b, t) };
            write!(out, " {} {} {}", p.x, p.y, p.z)?;
        }
        writeln!(out, " ] \"float width0\" {} \"float width1\" {}", 2.0 * a.w, 2.0 * b.w)?;
    }
    Ok(())
}

fn scene(job: &Job<'_>, notes: &[String], layers: &[String], out: &mut dyn Write) -> io::Result<()> {
    let v = &job.view;
    writeln!(out, "# {}\n# Render with: pbrt --outfile out.exr scene.pbrt", Job::title())?;
    for note in notes {
        writeln!(out, "# Differs: {}", note.replace('\n', " "))?;
    }
    // pbrt's camera space is left-handed: without this the image would be mirrored.
    writeln!(out, "\nScale -1 1 1")?;
    let (e, t, u) = (v.eye, v.eye + v.forward, v.up);
    writeln!(out, "LookAt {} {} {}  {} {} {}  {} {} {}", e.x, e.y, e.z, t.x, t.y, t.z, u.x, u.y, u.z)?;
    let aspect = v.size[0] as f32 / v.size[1] as f32;
    write!(
        out,
        "Camera \"perspective\" \"float fov\" {} \"float screenwindow\" [ {} {aspect} -1 1 ]",
        v.fov, -aspect
    )?;
    if let Some([aperture, focus]) = v.lens {
        write!(out, " \"float lensradius\" {} \"float focaldistance\" {focus}", 0.5 * aperture)?;
    }
    writeln!(out, "\nSampler \"independent\" \"integer pixelsamples\" {}", v.spp)?;
    writeln!(out, "Integrator \"volpath\" \"integer maxdepth\" 64")?;
    let (filter, radius) = v.filter;
    let kind = match filter {
        Filter::Box => "\"box\"".to_owned(),
        Filter::Triangle => "\"triangle\"".to_owned(),
        Filter::Gaussian => format!("\"gaussian\" \"float sigma\" {}", radius / 3.0),
        Filter::Mitchell => "\"mitchell\" \"float B\" 0.33333334 \"float C\" 0.33333334".to_owned(),
    };
    writeln!(out, "PixelFilter {kind} \"float xradius\" {radius} \"float yradius\" {radius}")?;
    writeln!(
        out,
        "Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {}",
        v.size[0], v.size[1]
    )?;
    writeln!(out, "\nWorldBegin\n")?;
    for light in &job.lights {
        let (d, e) = (light.direction, light.irradiance);
        writeln!(
            out,
            "LightSource \"distant\" \"point3 from\" [ {} {} {} ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ {} {} {} ]",
            d.x, d.y, d.z, e.x, e.y, e.z
        )?;
    }
    match &job.sky {
        Some(Sky::Uniform(c)) => {
            writeln!(out, "LightSource \"infinite\" \"rgb L\" [ {} {} {} ]", c.x, c.y, c.z)?;
        }
        Some(Sky::Map { .. }) => writeln!(out, "LightSource \"infinite\" \"string filename\" \"sky.exr\"")?,
        None => {}
    }
    let c = mean(&skin_colors(job.world));
    writeln!(out, "\nMaterial \"diffuse\" \"rgb reflectance\" [ {} {} {} ]", c.x, c.y, c.z)?;
    writeln!(out, "Shape \"plymesh\" \"string filename\" \"skin.ply\"\n")?;
    job.objects.iter().try_for_each(|of| object(of, out))?;
    for file in layers {
        writeln!(out, "Include \"{file}\"")?;
    }
    Ok(())
}

/// An object and its materials. A metal is a conductor, under an interface where it is coated; a
/// dielectric has one interface over a diffuse base; others are mixed of these.
fn object(of: &Exported<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (m, c) = (&of.object.material, mean(of.colors()));
    let mut color = format!("\"rgb reflectance\" [ {} {} {} ]", c.x, c.y, c.z);
    if let Some(file) = of.image() {
        let image = format!("{}.color", of.stem);
        writeln!(out, "Texture \"{image}\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\"")?;
        color = format!("\"texture reflectance\" \"{image}\"");
    }
    let exact = "\"bool remaproughness\" false";
    let [width, coat_width] = [m.roughness, m.clearcoat_roughness].map(|r| r * r);
    let mut named = |kind: &str, what: String| {
        let name = format!("{}.{kind}", of.stem);
        writeln!(out, "MakeNamedMaterial \"{name}\" \"string type\" {what}").map(|()| name)
    };
    let mix = |[first, second]: [&str; 2], amount: f32| {
        format!("\"mix\" \"string materials\" [ \"{first}\" \"{second}\" ] \"float amount\" {amount}")
    };
    let mut dielectric = None;
    if m.metallic < 1.0 {
        let what = format!("\"coateddiffuse\" {color} \"float roughness\" {width} {exact} \"float eta\" 1.5");
        dielectric = Some(named("dielectric", what)?);
    }
    let mut metal = None;
    if m.metallic > 0.0 {
        let bare = format!("\"conductor\" {color} \"float roughness\" {width} {exact}");
        let coated = format!(
            "\"coatedconductor\" {color} \"float conductor.roughness\" {width} {exact} \
             \"float interface.roughness\" {coat_width} \"float interface.eta\" 1.5"
        );
        metal = Some(match m.clearcoat {
            c if c <= 0.0 => named("metal", bare)?,
            c if c >= 1.0 => named("coated", coated)?,
            c => {
                let both = [named("metal", bare)?, named("coated", coated)?];
                named("partly_coated", mix(both.each_ref().map(String::as_str), c))?
            }
        });
    }
    let chosen = match (dielectric, metal) {
        (Some(inside), Some(metal)) => named("mixed", mix([&inside, &metal], m.metallic))?,
        (one, other) => one.or(other).unwrap_or_default(),
    };
    writeln!(out, "NamedMaterial \"{chosen}\"")?;
    writeln!(out, "Shape \"plymesh\" \"string filename\" \"{}\"\n", of.file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_fur::Layer;
    use pelage_pathtrace::strands::Hair;

    #[test]
    fn colours_are_gathered_into_few_bins() {
        let hair = |i: usize| Hair {
            color_root: Vec3::new(i as f32 / 2000.0, 0.3, 0.1),
            color_tip: Vec3::new(0.5, i as f32 / 2000.0, 0.2),
            glint_angle: 0.0,
            present: u64::MAX,
        };
        let strands = Strands {
            layer: Layer::Undercoat,
            segments: 2,
            points: (0..6000).map(|i| glam::Vec4::new(i as f32, (i % 3) as f32, 0.0, 0.1)).collect(),
            hairs: (0..2000).map(hair).collect(),
            opacity: Vec::new(),
            color_transition: [0.5, 1.0],
            color_transitions: Vec::new(),
        };
        let bins = Bins::of(&strands);
        assert!(bins.colors.len() > MOST_BINS / 4 && bins.colors.len() <= MOST_BINS, "{}", bins.colors.len());
        assert!(bins.error > 0.001 && bins.error < 0.1, "{}", bins.error);
    }
}
