//! Blender with Cycles: a Python script that builds the scene from HAIR, PLY and EXR files beside
//! it.

use super::sky::{self, Sky};
use super::{Job, curves, hair, material, mean, objects, ply, skin_colors};
use glam::Vec3;
use pelage_core::Result;
use pelage_core::scene::{Background, Filter};
use std::io::{self, Write};

/// The part of the script that does not depend on the scene.
const BUILDER: &str = include_str!("blender.py");

pub(super) fn write(job: &mut Job<'_>, notes: &[String]) -> Result<()> {
    ply::write(job, ply::V::Up)?;
    objects::write_images(job)?;
    hair::layers(job)?;
    if let Some(Sky::Map { panorama, .. }) = &job.sky {
        let path = job.folder.join("sky.exr");
        sky::write_exr(&path, panorama.width, panorama.height, |x, y| {
            panorama.texels[y * panorama.width + x].into()
        })?;
        let holds = format!("{} x {} texels", panorama.width, panorama.height);
        job.wrote(path, holds)?;
    }
    job.file("scene.py", String::new(), |job, out| script(job, notes, out))
}

fn tuple(v: Vec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

/// A name as a string of Python.
fn string(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' | '\\' => format!("\\{c}"),
            c if c.is_control() => format!("\\u{:04x}", u32::from(c)),
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}

fn truth(b: bool) -> &'static str {
    if b { "True" } else { "False" }
}

fn script(job: &Job<'_>, notes: &[String], out: &mut dyn Write) -> io::Result<()> {
    let v = &job.view;
    writeln!(out, "# {}\n# Render with: blender -b -P scene.py -- out.exr", Job::title())?;
    for note in notes {
        writeln!(out, "# Differs: {}", note.replace('\n', " "))?;
    }
    writeln!(out, "\nSIZE = ({}, {})\nSAMPLES = {}", v.size[0], v.size[1], v.spp)?;
    let filter = match v.filter.0 {
        Filter::Box => "BOX",
        Filter::Gaussian => "GAUSSIAN",
        Filter::Triangle | Filter::Mitchell => "BLACKMAN_HARRIS",
    };
    // Cycles takes the full width of the filter, not its radius.
    writeln!(out, "FILTER = (\"{filter}\", {})", 2.0 * v.filter.1)?;
    let axes = [v.right, v.up, -v.forward, v.eye].map(tuple).join(", ");
    writeln!(out, "# Right, up, backwards, eye.\nCAMERA = ({axes})\nTAN_Y = {}\nNEAR = {}", v.tan_y, v.near)?;
    let lens = v.lens.map_or("None".into(), |[aperture, focus]| format!("({aperture}, {focus})"));
    writeln!(out, "# Diameter of the aperture and distance in focus.\nLENS = {lens}")?;
    writeln!(out, "# Direction towards the light, irradiance.\nLIGHTS = [")?;
    for light in &job.lights {
        writeln!(out, "    ({}, {}),", tuple(light.direction), tuple(light.irradiance))?;
    }
    writeln!(out, "]")?;
    let (sky, rotate) = match &job.sky {
        None => ("None".into(), 0.0),
        Some(Sky::Uniform(c)) => (tuple(*c), 0.0),
        Some(Sky::Map { rotate, .. }) => ("\"sky.exr\"".into(), *rotate),
    };
    writeln!(
        out,
        "# A radiance or a map, and the map's rotation about +y in degrees.\nSKY = {sky}\nSKY_ROTATE = {rotate}"
    )?;
    let seen = job.sky.is_some() && job.world.scene.film.background == Background::Environment;
    writeln!(out, "SKY_SEEN = {}", truth(seen))?;
    let colors = skin_colors(job.world);
    let color = if colors.len() > 1 { "None".into() } else { tuple(mean(&colors)) };
    writeln!(out, "# None: a colour a vertex.\nSKIN_COLOR = {color}\nOBJECTS = [")?;
    for of in &job.objects {
        let m = &of.object.material;
        let color = match (of.image(), of.colors()) {
            (Some(file), _) => string(&file),
            (None, [c]) => tuple(*c),
            (None, _) => "None".into(),
        };
        writeln!(
            out,
            "    {{\n        \"name\": {},\n        \"file\": \"{}\",",
            string(&of.object.name),
            of.file()
        )?;
        writeln!(out, "        \"color\": {color},\n        \"roughness\": {},", m.roughness)?;
        writeln!(out, "        \"metallic\": {},\n        \"clearcoat\": {},", m.metallic, m.clearcoat)?;
        writeln!(out, "        \"clearcoat_roughness\": {},", m.clearcoat_roughness)?;
        writeln!(out, "        \"shadow_catcher\": {},\n    }},", truth(of.object.shadow_catcher))?;
    }
    writeln!(out, "]\nLAYERS = [")?;
    for strands in job.strands {
        let m = material::of(&job.world.scene, strands.layer);
        let h = m.hair;
        let absorption = if m.colored { "None".into() } else { tuple(h.absorption) };
        writeln!(out, "    {{")?;
        writeln!(out, "        \"name\": \"{}\",", curves::name(strands.layer))?;
        writeln!(out, "        \"beta_m\": {},\n        \"beta_n\": {},", h.beta_m, h.beta_n)?;
        writeln!(out, "        \"alpha_degrees\": {},\n        \"ior\": {},", h.alpha_degrees, h.ior)?;
        writeln!(
            out,
            "        # None: from the colours, (ln c / fit)^2.\n        \"absorption\": {absorption},"
        )?;
        writeln!(
            out,
            "        \"fit\": {},\n        \"darkest\": {},",
            material::fit(h.beta_n),
            material::DARKEST
        )?;
        writeln!(out, "    }},")?;
    }
    writeln!(out, "]\n")?;
    out.write_all(BUILDER.as_bytes())
}
