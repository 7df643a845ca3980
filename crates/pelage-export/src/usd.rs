//! OpenUSD in text form: everything but the sky's map in one file, scene.usda.

use super::objects::{self, Exported};
use super::sky::{self, Sky};
use super::{Job, curves, skin_colors};
use glam::Vec3;
use pelage_core::light::Light;
use pelage_core::{Result, Skin};
use pelage_fur::Layer;
use pelage_pathtrace::strands::Strands;
use std::io::{self, Write};

pub(super) fn write(job: &mut Job<'_>, notes: &[String]) -> Result<()> {
    objects::write_images(job)?;
    if let Some(Sky::Map { panorama, .. }) = &job.sky {
        let path = job.folder.join("sky.exr");
        sky::write_exr(&path, panorama.width, panorama.height, |x, y| {
            panorama.texels[y * panorama.width + x].into()
        })?;
        let holds = format!("{} x {} texels", panorama.width, panorama.height);
        job.wrote(path, holds)?;
    }
    let mut holds = vec![job.skin_holds()];
    holds.extend(job.objects.iter().map(Exported::holds));
    holds.extend(job.strands.iter().map(curves::holds));
    job.file("scene.usda", holds.join(", "), |job, out| stage(job, notes, out))
}

fn stage(job: &Job<'_>, notes: &[String], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "#usda 1.0\n# {}", Job::title())?;
    for note in notes {
        writeln!(out, "# Differs: {}", note.replace('\n', " "))?;
    }
    writeln!(out, "(\n    defaultPrim = \"World\"\n    metersPerUnit = 0.01\n    upAxis = \"Y\"\n)\n")?;
    writeln!(out, "def Xform \"World\" (\n    kind = \"component\"\n)\n{{")?;
    camera(job, out)?;
    for (i, light) in job.lights.iter().enumerate() {
        distant(i, light, out)?;
    }
    dome(job, out)?;
    writeln!(out, "    def Mesh \"Skin\"\n    {{")?;
    surface(&job.world.skin, &skin_colors(job.world), out)?;
    writeln!(out, "    }}\n")?;
    job.objects.iter().try_for_each(|of| object(of, out))?;
    looks(job, out)?;
    for strands in job.strands {
        layer(strands, out)?;
    }
    writeln!(out, "}}")
}

fn camera(job: &Job<'_>, out: &mut dyn Write) -> io::Result<()> {
    let v = &job.view;
    // Lengths of the film are in tenths of the scene's unit: mm.
    const HEIGHT: f32 = 24.0;
    let focal = 0.5 * HEIGHT / v.tan_y;
    let width = HEIGHT * v.size[0] as f32 / v.size[1] as f32;
    writeln!(out, "    def Camera \"Camera\"\n    {{\n        token projection = \"perspective\"")?;
    writeln!(out, "        float horizontalAperture = {width}\n        float verticalAperture = {HEIGHT}")?;
    writeln!(
        out,
        "        float focalLength = {focal}\n        float2 clippingRange = ({}, 1000000)",
        v.near
    )?;
    if let Some([aperture, focus]) = v.lens {
        writeln!(
            out,
            "        float fStop = {}\n        float focusDistance = {focus}",
            focal / 10.0 / aperture
        )?;
    }
    let row = |v: Vec3, w: u8| format!("({}, {}, {}, {w})", v.x, v.y, v.z);
    let rows = [row(v.right, 0), row(v.up, 0), row(-v.forward, 0), row(v.eye, 1)].join(", ");
    writeln!(out, "        matrix4d xformOp:transform = ( {rows} )")?;
    writeln!(out, "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }}\n")
}

/// A distant light, which emits along its -z axis. With the angle 0 and normalised, its intensity
/// is an irradiance.
fn distant(number: usize, light: &Light, out: &mut dyn Write) -> io::Result<()> {
    let z = light.direction;
    let x = z.any_orthonormal_vector();
    let y = z.cross(x);
    let strength = light.irradiance.max_element();
    let c = if strength > 0.0 { light.irradiance / strength } else { Vec3::ONE };
    writeln!(out, "    def DistantLight \"Light{number}\"\n    {{\n        float inputs:angle = 0")?;
    writeln!(out, "        bool inputs:normalize = 1\n        float inputs:intensity = {strength}")?;
    writeln!(out, "        color3f inputs:color = ({}, {}, {})", c.x, c.y, c.z)?;
    let row = |v: Vec3| format!("({}, {}, {}, 0)", v.x, v.y, v.z);
    let rows = [row(x), row(y), row(z), "(0, 0, 0, 1)".into()].join(", ");
    writeln!(out, "        matrix4d xformOp:transform = ( {rows} )")?;
    writeln!(out, "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }}\n")
}

fn dome(job: &Job<'_>, out: &mut dyn Write) -> io::Result<()> {
    let Some(sky) = &job.sky else { return Ok(()) };
    writeln!(out, "    def DomeLight \"Sky\"\n    {{\n        float inputs:intensity = 1")?;
    match sky {
        Sky::Uniform(c) => writeln!(out, "        color3f inputs:color = ({}, {}, {})", c.x, c.y, c.z)?,
        Sky::Map { rotate, .. } => {
            writeln!(out, "        asset inputs:texture:file = @./sky.exr@")?;
            writeln!(out, "        token inputs:texture:format = \"latlong\"")?;
            // A dome's map has its centre at +z, this program's at -z.
            writeln!(out, "        float xformOp:rotateY = {}", rotate + 180.0)?;
            writeln!(out, "        uniform token[] xformOpOrder = [\"xformOp:rotateY\"]")?;
        }
    }
    writeln!(out, "    }}\n")
}

/// Writes `values` as an array, with a few of them in each line.
fn array<T>(
    out: &mut dyn Write,
    declaration: &str,
    values: impl Iterator<Item = T>,
    print: impl Fn(&mut dyn Write, T) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "        {declaration} = [")?;
    for (i, value) in values.enumerate() {
        out.write_all(match i {
            0 => b"",
            i if i % 16 == 0 => b",\n            ",
            _ => b", ",
        })?;
        print(out, value)?;
    }
    write!(out, "]")
}

fn vector(out: &mut dyn Write, v: Vec3) -> io::Result<()> {
    write!(out, "({}, {}, {})", v.x, v.y, v.z)
}

fn extent(points: impl Iterator<Item = (Vec3, f32)>, out: &mut dyn Write) -> io::Result<()> {
    let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = points.fold(empty, |(low, high), (p, r)| (low.min(p - r), high.max(p + r)));
    let (low, high) = if low.is_finite() { (low, high) } else { (Vec3::ZERO, Vec3::ZERO) };
    array(out, "float3[] extent", [low, high].into_iter(), vector)?;
    writeln!(out)
}

fn interpolation(out: &mut dyn Write, kind: &str) -> io::Result<()> {
    writeln!(out, " (\n            interpolation = \"{kind}\"\n        )")
}

/// The points, triangles and colours of a mesh.
fn surface(skin: &Skin, colors: &[Vec3], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "        uniform token subdivisionScheme = \"none\"")?;
    extent(skin.positions.iter().map(|p| (*p, 0.0)), out)?;
    array(out, "int[] faceVertexCounts", skin.triangles.iter(), |out, _| write!(out, "3"))?;
    writeln!(out)?;
    array(out, "int[] faceVertexIndices", skin.triangles.iter().flatten(), |out, i| write!(out, "{i}"))?;
    writeln!(out)?;
    array(out, "point3f[] points", skin.positions.iter(), |out, p| vector(out, *p))?;
    writeln!(out)?;
    array(out, "normal3f[] normals", skin.normals.iter(), |out, n| vector(out, *n))?;
    interpolation(out, "vertex")?;
    if let Some(uv) = &skin.corner_uv {
        array(out, "texCoord2f[] primvars:st", uv.iter().flatten(), |out, uv| {
            write!(out, "({}, {})", uv.x, uv.y)
        })?;
        interpolation(out, "faceVarying")?;
    }
    if colors.is_empty() {
        return Ok(());
    }
    let kind = if colors.len() > 1 { "vertex" } else { "constant" };
    array(out, "color3f[] primvars:displayColor", colors.iter(), |out, c| vector(out, *c))?;
    interpolation(out, kind)
}

fn object(of: &Exported<'_>, out: &mut dyn Write) -> io::Result<()> {
    let shown: String = of.object.name.chars().filter(|c| !c.is_control()).collect();
    let shown = shown.replace('\\', "\\\\").replace('"', "\\\"");
    writeln!(out, "    def Mesh \"{}\" (\n        displayName = \"{shown}\"", of.stem)?;
    writeln!(out, "        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{")?;
    writeln!(out, "        uniform bool doubleSided = 1")?;
    surface(&of.surface, of.colors(), out)?;
    writeln!(out, "        rel material:binding = </World/Looks/{}>\n    }}\n", of.stem)
}

/// Materials of the objects.
fn looks(job: &Job<'_>, out: &mut dyn Write) -> io::Result<()> {
    if job.objects.is_empty() {
        return Ok(());
    }
    writeln!(out, "    def Scope \"Looks\"\n    {{")?;
    for of in &job.objects {
        let (m, place) = (&of.object.material, format!("/World/Looks/{}", of.stem));
        writeln!(out, "        def Material \"{}\"\n        {{", of.stem)?;
        writeln!(out, "            token outputs:surface.connect = <{place}/Surface.outputs:surface>\n")?;
        writeln!(out, "            def Shader \"Surface\"\n            {{")?;
        writeln!(out, "                uniform token info:id = \"UsdPreviewSurface\"")?;
        let color = "color3f inputs:diffuseColor";
        match (of.colors(), of.image()) {
            (_, Some(_)) => writeln!(out, "                {color}.connect = <{place}/Image.outputs:rgb>")?,
            ([c], _) => writeln!(out, "                {color} = ({}, {}, {})", c.x, c.y, c.z)?,
            _ => writeln!(out, "                {color}.connect = <{place}/Color.outputs:result>")?,
        }
        for (name, value) in [
            ("roughness", m.roughness),
            ("metallic", m.metallic),
            ("clearcoat", m.clearcoat),
            ("clearcoatRoughness", m.clearcoat_roughness),
            ("ior", 1.5),
        ] {
            writeln!(out, "                float inputs:{name} = {value}")?;
        }
        writeln!(out, "                token outputs:surface\n            }}")?;
        if of.colors().len() > 1 {
            reader(out, ["Color", "float3", "displayColor"])?;
        }
        if let Some(file) = of.image() {
            reader(out, ["Place", "float2", "st"])?;
            writeln!(out, "\n            def Shader \"Image\"\n            {{")?;
            writeln!(out, "                uniform token info:id = \"UsdUVTexture\"")?;
            writeln!(out, "                asset inputs:file = @./{file}@")?;
            writeln!(out, "                token inputs:sourceColorSpace = \"raw\"")?;
            writeln!(out, "                token inputs:wrapS = \"repeat\"")?;
            writeln!(out, "                token inputs:wrapT = \"repeat\"")?;
            writeln!(out, "                float2 inputs:st.connect = <{place}/Place.outputs:result>")?;
            writeln!(out, "                float3 outputs:rgb\n            }}")?;
        }
        writeln!(out, "        }}\n")?;
    }
    writeln!(out, "    }}\n")
}

/// A shader that reads a primvar.
fn reader(out: &mut dyn Write, [name, kind, primvar]: [&str; 3]) -> io::Result<()> {
    writeln!(out, "\n            def Shader \"{name}\"\n            {{")?;
    writeln!(out, "                uniform token info:id = \"UsdPrimvarReader_{kind}\"")?;
    writeln!(out, "                string inputs:varname = \"{primvar}\"")?;
    writeln!(out, "                {kind} outputs:result\n            }}")
}

fn layer(strands: &Strands, out: &mut dyn Write) -> io::Result<()> {
    let name = match strands.layer {
        Layer::Guard => "Guard",
        Layer::Undercoat => "Undercoat",
    };
    writeln!(out, "    def BasisCurves \"{name}\"\n    {{\n        uniform token type = \"linear\"")?;
    writeln!(out, "        uniform token wrap = \"nonperiodic\"")?;
    let points = || curves::runs(strands).flat_map(|run| run.points);
    extent(points().map(|p| (p.truncate(), p.w)), out)?;
    array(out, "int[] curveVertexCounts", curves::runs(strands), |out, run| {
        write!(out, "{}", run.points.len())
    })?;
    writeln!(out)?;
    array(out, "point3f[] points", points(), |out, p| vector(out, p.truncate()))?;
    writeln!(out)?;
    array(out, "float[] widths", points(), |out, p| write!(out, "{}", 2.0 * p.w))?;
    interpolation(out, "vertex")?;
    let at = || {
        curves::runs(strands).flat_map(|run| (0..run.points.len()).map(move |k| (run.hair, run.first + k)))
    };
    array(out, "color3f[] primvars:displayColor", at(), |out, (hair, k)| {
        vector(out, curves::color(strands, hair, k as f32))
    })?;
    interpolation(out, "vertex")?;
    if !strands.opacity.is_empty() {
        array(out, "float[] primvars:displayOpacity", at(), |out, (hair, k)| {
            write!(out, "{}", strands.opacity_at(hair, k))
        })?;
        interpolation(out, "vertex")?;
    }
    writeln!(out, "    }}\n")
}
