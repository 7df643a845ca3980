//! Shader sources and their once-only textual imports.

use crate::{Error, Result};

macro_rules! sources {
    ($($name:literal),* $(,)?) => {
        /// All WGSL sources by name, compiled into the program.
        pub const SOURCES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),*];
    };
}

sources![
    "base_raster",
    "edge_table",
    "film",
    "guard_bins",
    "guard_raster",
    "guard_shade",
    "guard_splat",
    "guard_strands",
    "hair_roots",
    "light_occlusion",
    "resolve",
    "shell_entry",
    "shell_lattice",
    "shell_prisms",
    "shellfin_raster",
    "shellfin_rows",
    "undercoat_density",
    "undercoat_light",
    "undercoat_march",
    "undercoat_source",
    "shared/angles",
    "shared/arithmetic",
    "shared/barycentric",
    "shared/base",
    "shared/clumps",
    "shared/column",
    "shared/column_place",
    "shared/constants",
    "shared/coverage",
    "shared/dual",
    "shared/fibre",
    "shared/film_sample",
    "shared/frame",
    "shared/groom",
    "shared/groom_types",
    "shared/guard_fibre",
    "shared/halves",
    "shared/index",
    "shared/lattice",
    "shared/lattice_nodes",
    "shared/lights",
    "shared/map_table",
    "shared/march",
    "shared/noise",
    "shared/noise_domain",
    "shared/octahedral",
    "shared/oit",
    "shared/oit_read",
    "shared/oit_write",
    "shared/phase",
    "shared/random",
    "shared/record",
    "shared/root_types",
    "shared/roots",
    "shared/shell",
    "shared/shell_types",
    "shared/shellfin_types",
    "shared/skin",
    "shared/source_table",
    "shared/strand_curve",
    "shared/strands",
    "shared/tau",
    "shared/transmittance",
    "shared/transport",
    "shared/undercoat",
    "shared/undercoat_fibre",
    "shared/undercoat_types",
    "shared/uv_in_cells",
    "shared/uv_in_corners",
    "shared/volume",
];

/// A shader with its imports, and for each line where it came from.
pub struct Resolved {
    /// WGSL.
    pub text: String,
    lines: Vec<(&'static str, usize)>,
}

impl Resolved {
    /// `file.wgsl:line` of a line (from 1) of the resolved text.
    pub fn origin(&self, line: usize) -> String {
        match self.lines.get(line.saturating_sub(1)) {
            Some((file, at)) => format!("shaders/{file}.wgsl:{at}"),
            None => "end of the shader".into(),
        }
    }
}

/// The shader called `name` with every `#import FILE` replaced by that file, each file once.
///
/// # Errors
/// [`Error::Gpu`] for an unknown name, with the place of the import.
pub fn resolve(name: &str) -> Result<Resolved> {
    let mut resolved = Resolved { text: String::new(), lines: Vec::new() };
    let mut seen = Vec::new();
    include(name, "the program", &mut seen, &mut resolved)?;
    Ok(resolved)
}

fn include(name: &str, from: &str, seen: &mut Vec<&'static str>, out: &mut Resolved) -> Result<()> {
    let (file, text) = SOURCES
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| Error::gpu(name, format!("no such shader, imported by {from}")))?;
    if seen.contains(file) {
        return Ok(());
    }
    seen.push(file);
    for (i, line) in text.lines().enumerate() {
        if let Some(import) = line.strip_prefix("#import ") {
            include(import.trim(), &format!("shaders/{file}.wgsl:{}", i + 1), seen, out)?;
        } else {
            out.text.push_str(line);
            out.text.push('\n');
            out.lines.push((file, i + 1));
        }
    }
    Ok(())
}

/// Parses and validates; faults name file and line.
///
/// # Errors
/// [`Error::Gpu`] with naga's message.
pub fn validate(name: &str) -> Result<(Resolved, naga::Module, naga::valid::ModuleInfo)> {
    let resolved = resolve(name)?;
    let module = naga::front::wgsl::parse_str(&resolved.text).map_err(|e| {
        let line = e.location(&resolved.text).map_or(0, |l| l.line_number as usize);
        Error::gpu(name, format!("{}: {}", resolved.origin(line), e.message()))
    })?;
    let info = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32,
    )
    .validate(&module)
    .map_err(|e| {
        let line = e.location(&resolved.text).map_or(0, |l| l.line_number as usize);
        Error::gpu(name, format!("{}: {}", resolved.origin(line), e.emit_to_string(&resolved.text)))
    })?;
    Ok((resolved, module, info))
}
