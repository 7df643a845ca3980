//! Mitsuba 3: an XML scene, curves as text, absorption as PFM, the skin as PLY.
//!
//! The coordinate v of curves runs over all segments of a shape, so a texture of one column gives
//! every segment its own absorption.

use super::curves::{self, Segment};
use super::objects::{self, Exported};
use super::sky::{self, Sky};
use super::{Job, material, mean, ply, skin_colors};
use glam::Vec3;
use pelage_core::Result;
use pelage_core::scene::{Background, Filter};
use pelage_fur::Layer;
use pelage_pathtrace::strands::Strands;
use std::io::{self, Write};

/// Largest height of an absorption texture: about that of the largest textures on GPUs.
const MOST_TEXELS: usize = 1 << 15;

/// A file of curves and the file of their absorptions, if there is one.
struct Part {
    curves: String,
    absorption: Option<String>,
}

pub(super) fn write(job: &mut Job<'_>, notes: Vec<String>) -> Result<()> {
    let mut notes = notes;
    ply::write(job, ply::V::Down)?;
    objects::write_images(job)?;
    if let Some(Sky::Map { panorama, .. }) = &job.sky {
        let path = job.folder.join("sky.exr");
        sky::write_exr(&path, panorama.width, panorama.height, |x, y| {
            panorama.texels[y * panorama.width + x].into()
        })?;
        let holds = format!("{} x {} texels", panorama.width, panorama.height);
        job.wrote(path, holds)?;
    }
    let mut layers = Vec::new();
    for strands in job.strands {
        let parts = layer(job, strands)?;
        if parts.iter().any(|p| p.absorption.is_some()) {
            notes.push(format!(
                "colours of the {} are constant along each of {} parts of a segment",
                curves::name(strands.layer),
                texels_a_segment(strands.layer)
            ));
        }
        layers.push((strands.layer, parts));
    }
    job.file("scene.xml", String::new(), |job, out| xml(job, &notes, &layers, out))
}

/// Absorptions per segment: guard hairs change colour over few segments, the undercoat's segments
/// are many and short.
fn texels_a_segment(layer: Layer) -> usize {
    match layer {
        Layer::Guard => 4,
        Layer::Undercoat => 1,
    }
}

/// Writes the curves of a layer in parts whose absorptions fit into a texture.
fn layer(job: &mut Job<'_>, strands: &Strands) -> Result<Vec<Part>> {
    let name = curves::name(strands.layer);
    let material = material::of(&job.world.scene, strands.layer);
    let varied = material.colored && curves::one_color(strands).is_none();
    let texels = texels_a_segment(strands.layer);
    let most = if varied { MOST_TEXELS / texels } else { usize::MAX };
    let mut segments = curves::segments(strands).peekable();
    let mut parts = Vec::new();
    while segments.peek().is_some() {
        let number = parts.len();
        let curves_name = format!("{name}-{number:04}.txt");
        let mut column: Vec<[f32; 3]> = Vec::new();
        let (mut count, mut hairs, mut last) = (0, 0_usize, None);
        let path = job.folder.join(&curves_name);
        pelage_core::files::write_buffered(&path, |out| {
            for segment in segments.by_ref().take(most) {
                curve(&segment, out)?;
                count += 1;
                hairs += usize::from(last != Some(segment.hair));
                last = Some(segment.hair);
                if varied {
                    column.extend((0..texels).map(|i| {
                        let k = segment.number as f32 + (i as f32 + 0.5) / texels as f32;
                        material.absorption(curves::color(strands, segment.hair, k)).to_array()
                    }));
                }
            }
            Ok(())
        })?;
        job.wrote(path, format!("{count} segments of {hairs} hairs of the {name}"))?;
        let absorption = varied.then(|| format!("{name}-{number:04}.pfm"));
        if let Some(file) = &absorption {
            job.file(file, format!("{} absorptions", column.len()), |_, out| pfm(&column, out))?;
        }
        parts.push(Part { curves: curves_name, absorption });
    }
    Ok(parts)
}

/// A segment as a uniform cubic B-spline, which is linear because its control points are equally
/// spaced on a line.
fn curve(segment: &Segment, out: &mut dyn Write) -> io::Result<()> {
    let [a, b] = segment.ends;
    for p in [2.0 * a - b, a, b, 2.0 * b - a] {
        writeln!(out, "{} {} {} {}", p.x, p.y, p.z, p.w)?;
    }
    writeln!(out)
}

/// Writes a column of texels, the first on top, as PFM, whose rows begin at the bottom.
fn pfm(column: &[[f32; 3]], out: &mut dyn Write) -> io::Result<()> {
    write!(out, "PF\n1 {}\n-1.0\n", column.len())?;
    let floats = column.iter().rev().flatten();
    floats.into_iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn xml(
    job: &Job<'_>,
    notes: &[String],
    layers: &[(Layer, Vec<Part>)],
    out: &mut dyn Write,
) -> io::Result<()> {
    let v = &job.view;
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!--\n{}", Job::title())?;
    writeln!(out, "Render with: mitsuba scene.xml -Dspp={} -Dmax_depth=64\n", v.spp)?;
    for note in notes {
        writeln!(out, "Differs: {}", note.replace("--", "- -"))?;
    }
    writeln!(out, "-->\n<scene version=\"3.0.0\">")?;
    writeln!(
        out,
        "  <default name=\"spp\" value=\"{}\"/>\n  <default name=\"max_depth\" value=\"64\"/>",
        v.spp
    )?;
    let seen = job.sky.is_some() && job.world.scene.film.background == Background::Environment;
    writeln!(out, "  <integrator type=\"path\">\n    <integer name=\"max_depth\" value=\"$max_depth\"/>")?;
    // Russian roulette would add noise to dark hair.
    writeln!(out, "    <integer name=\"rr_depth\" value=\"1000\"/>")?;
    writeln!(out, "    <boolean name=\"hide_emitters\" value=\"{}\"/>\n  </integrator>", !seen)?;
    sensor(job, out)?;
    for light in &job.lights {
        let (d, e) = (-light.direction, light.irradiance);
        writeln!(out, "  <emitter type=\"directional\">")?;
        writeln!(out, "    <vector name=\"direction\" value=\"{} {} {}\"/>", d.x, d.y, d.z)?;
        writeln!(out, "    <rgb name=\"irradiance\" value=\"{} {} {}\"/>\n  </emitter>", e.x, e.y, e.z)?;
    }
    match &job.sky {
        Some(Sky::Uniform(c)) => {
            writeln!(out, "  <emitter type=\"constant\">")?;
            writeln!(out, "    <rgb name=\"radiance\" value=\"{} {} {}\"/>\n  </emitter>", c.x, c.y, c.z)?;
        }
        Some(Sky::Map { rotate, .. }) => {
            writeln!(out, "  <emitter type=\"envmap\">\n    <string name=\"filename\" value=\"sky.exr\"/>")?;
            // Mitsuba's map has its left edge at -z, where this program's has its centre.
            writeln!(out, "    <transform name=\"to_world\">")?;
            writeln!(
                out,
                "      <rotate y=\"1\" angle=\"{}\"/>\n    </transform>\n  </emitter>",
                rotate + 180.0
            )?;
        }
        None => {}
    }
    let colors = skin_colors(job.world);
    writeln!(out, "  <shape type=\"ply\" id=\"skin\">\n    <string name=\"filename\" value=\"skin.ply\"/>")?;
    writeln!(out, "    <bsdf type=\"twosided\"><bsdf type=\"diffuse\">")?;
    color("reflectance", &colors, out)?;
    writeln!(out, "    </bsdf></bsdf>\n  </shape>")?;
    job.objects.iter().try_for_each(|of| object(of, out))?;
    for (layer, parts) in layers {
        for part in parts {
            hairs(job, *layer, part, out)?;
        }
    }
    writeln!(out, "</scene>")
}

/// A colour of a surface: one value, or that of its vertices.
fn color(name: &str, colors: &[Vec3], out: &mut dyn Write) -> io::Result<()> {
    if colors.len() > 1 {
        writeln!(out, "      <texture name=\"{name}\" type=\"mesh_attribute\">")?;
        return writeln!(out, "        <string name=\"name\" value=\"vertex_color\"/>\n      </texture>");
    }
    let c = mean(colors);
    writeln!(out, "      <rgb name=\"{name}\" value=\"{} {} {}\"/>", c.x, c.y, c.z)
}

fn object(of: &Exported<'_>, out: &mut dyn Write) -> io::Result<()> {
    let m = &of.object.material;
    writeln!(out, "  <shape type=\"ply\" id=\"{}\">", of.stem)?;
    writeln!(out, "    <string name=\"filename\" value=\"{}\"/>", of.file())?;
    writeln!(out, "    <bsdf type=\"twosided\"><bsdf type=\"principled\">")?;
    match of.image() {
        Some(file) => {
            writeln!(out, "      <texture name=\"base_color\" type=\"bitmap\">")?;
            writeln!(out, "        <string name=\"filename\" value=\"{file}\"/>\n      </texture>")?;
        }
        None => color("base_color", of.colors(), out)?,
    }
    let mut float =
        |name: &str, value: f32| writeln!(out, "      <float name=\"{name}\" value=\"{value}\"/>");
    float("roughness", m.roughness)?;
    float("metallic", m.metallic)?;
    float("eta", 1.5)?;
    if m.clearcoat > 0.0 {
        float("clearcoat", m.clearcoat)?;
        // The gloss takes the width of the lobe from 0.1 to 0.001.
        let width = m.clearcoat_roughness * m.clearcoat_roughness;
        float("clearcoat_gloss", ((0.1 - width) / 0.099).clamp(0.0, 1.0))?;
    }
    writeln!(out, "    </bsdf></bsdf>\n  </shape>")
}

fn sensor(job: &Job<'_>, out: &mut dyn Write) -> io::Result<()> {
    let v = &job.view;
    let kind = if v.lens.is_some() { "thinlens" } else { "perspective" };
    writeln!(out, "  <sensor type=\"{kind}\">\n    <float name=\"fov\" value=\"{}\"/>", v.fov)?;
    writeln!(
        out,
        "    <string name=\"fov_axis\" value=\"y\"/>\n    <float name=\"near_clip\" value=\"{}\"/>",
        v.near
    )?;
    writeln!(out, "    <float name=\"far_clip\" value=\"1000000\"/>")?;
    if let Some([aperture, focus]) = v.lens {
        writeln!(out, "    <float name=\"aperture_radius\" value=\"{}\"/>", 0.5 * aperture)?;
        writeln!(out, "    <float name=\"focus_distance\" value=\"{focus}\"/>")?;
    }
    // The sensor's x axis points to the left of the image.
    let [l, u, f, e] = [-v.right, v.up, v.forward, v.eye].map(|v| v.to_array());
    let row = |i: usize| format!("{} {} {} {}", l[i], u[i], f[i], e[i]);
    writeln!(out, "    <transform name=\"to_world\">")?;
    writeln!(out, "      <matrix value=\"{} {} {} 0 0 0 1\"/>\n    </transform>", row(0), row(1), row(2))?;
    writeln!(
        out,
        "    <sampler type=\"independent\">\n      <integer name=\"sample_count\" value=\"$spp\"/>"
    )?;
    writeln!(out, "    </sampler>\n    <film type=\"hdrfilm\">")?;
    writeln!(out, "      <integer name=\"width\" value=\"{}\"/>", v.size[0])?;
    writeln!(out, "      <integer name=\"height\" value=\"{}\"/>", v.size[1])?;
    writeln!(out, "      <string name=\"pixel_format\" value=\"rgba\"/>")?;
    writeln!(out, "      <string name=\"component_format\" value=\"float32\"/>")?;
    let (filter, radius) = v.filter;
    match filter {
        Filter::Box => writeln!(out, "      <rfilter type=\"box\"/>")?,
        Filter::Triangle => {
            writeln!(
                out,
                "      <rfilter type=\"tent\"><float name=\"radius\" value=\"{radius}\"/></rfilter>"
            )?;
        }
        Filter::Gaussian => {
            let sigma = radius / 3.0;
            writeln!(
                out,
                "      <rfilter type=\"gaussian\"><float name=\"stddev\" value=\"{sigma}\"/></rfilter>"
            )?;
        }
        Filter::Mitchell => writeln!(out, "      <rfilter type=\"mitchell\"/>")?,
    }
    writeln!(out, "    </film>\n  </sensor>")
}

fn hairs(job: &Job<'_>, layer: Layer, part: &Part, out: &mut dyn Write) -> io::Result<()> {
    let material = material::of(&job.world.scene, layer);
    let h = material.hair;
    writeln!(
        out,
        "  <shape type=\"bsplinecurve\">\n    <string name=\"filename\" value=\"{}\"/>",
        part.curves
    )?;
    writeln!(out, "    <bsdf type=\"hair\">")?;
    for (name, value) in [
        ("longitudinal_roughness", h.beta_m),
        ("azimuthal_roughness", h.beta_n),
        ("scale_tilt", h.alpha_degrees),
        ("int_ior", h.ior),
        ("ext_ior", 1.0),
    ] {
        writeln!(out, "      <float name=\"{name}\" value=\"{value}\"/>")?;
    }
    match &part.absorption {
        Some(file) => {
            writeln!(out, "      <texture name=\"sigma_a\" type=\"bitmap\">")?;
            writeln!(out, "        <string name=\"filename\" value=\"{file}\"/>")?;
            writeln!(out, "        <boolean name=\"raw\" value=\"true\"/>")?;
            writeln!(out, "        <string name=\"filter_type\" value=\"nearest\"/>")?;
            writeln!(out, "        <string name=\"wrap_mode\" value=\"clamp\"/>\n      </texture>")?;
        }
        None => {
            let strands = job.strands.iter().find(|s| s.layer == layer);
            let color = strands.and_then(curves::one_color).unwrap_or_default();
            let a = material.absorption(color);
            writeln!(out, "      <rgb name=\"sigma_a\" value=\"{} {} {}\"/>", a.x, a.y, a.z)?;
        }
    }
    writeln!(out, "    </bsdf>\n  </shape>")
}
