//! Shader sources, and textual imports that include each file once.

use pelage_core::{Error, Result};

use std::borrow::Cow;
use std::sync::Arc;

/// Finds the text of a shader by its name, such as `resolve` or `shared/oit`.
pub type Sources = fn(&str) -> Option<Cow<'static, str>>;

/// A shader with its imports resolved, and the origin of each line.
pub struct Resolved {
    /// WGSL.
    pub text: String,
    lines: Vec<(Arc<str>, usize)>,
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

/// The shader called `name` with `#import FILE` replaced by that file at its first occurrence and
/// by nothing at later ones.
///
/// # Errors
/// [`Error::Gpu`] for an unknown name, with file and line of the import.
pub fn resolve(sources: Sources, name: &str) -> Result<Resolved> {
    let mut resolved = Resolved { text: String::new(), lines: Vec::new() };
    include(sources, name, "the program", &mut Vec::new(), &mut resolved)?;
    Ok(resolved)
}

/// As [`resolve`], for a text that is no file; messages call it `name`.
///
/// # Errors
/// As [`resolve`].
pub fn resolve_text(sources: Sources, name: &str, text: &str) -> Result<Resolved> {
    let mut resolved = Resolved { text: String::new(), lines: Vec::new() };
    append(sources, &name.into(), text, &mut Vec::new(), &mut resolved)?;
    Ok(resolved)
}

fn include(
    sources: Sources,
    name: &str,
    from: &str,
    seen: &mut Vec<Arc<str>>,
    out: &mut Resolved,
) -> Result<()> {
    if seen.iter().any(|file| **file == *name) {
        return Ok(());
    }
    let text =
        sources(name).ok_or_else(|| Error::gpu(name, format!("no such shader, imported by {from}")))?;
    let file: Arc<str> = name.into();
    seen.push(file.clone());
    append(sources, &file, &text, seen, out)
}

fn append(
    sources: Sources,
    file: &Arc<str>,
    text: &str,
    seen: &mut Vec<Arc<str>>,
    out: &mut Resolved,
) -> Result<()> {
    for (i, line) in text.lines().enumerate() {
        if let Some(import) = line.trim_start().strip_prefix("#import ") {
            include(sources, import.trim(), &format!("shaders/{file}.wgsl:{}", i + 1), seen, out)?;
        } else {
            out.text.push_str(line);
            out.text.push('\n');
            out.lines.push((file.clone(), i + 1));
        }
    }
    Ok(())
}

/// Resolves, parses and validates the shader called `name`.
///
/// # Errors
/// [`Error::Gpu`] with naga's message, file and line.
pub fn validate(sources: Sources, name: &str) -> Result<(Resolved, naga::Module, naga::valid::ModuleInfo)> {
    let resolved = resolve(sources, name)?;
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
