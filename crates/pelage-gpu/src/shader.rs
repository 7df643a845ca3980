//! Shader sources and their once-only textual imports.

use pelage_core::{Error, Result};

use std::borrow::Cow;
use std::sync::Arc;

/// Finds the text of a shader by its name, such as `resolve` or `shared/oit`.
pub type Sources = fn(&str) -> Option<Cow<'static, str>>;

/// A shader with its imports, and for each line where it came from.
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

/// The shader called `name` with every `#import FILE` replaced by that file, each file once.
///
/// # Errors
/// [`Error::Gpu`] for an unknown name, with the place of the import.
pub fn resolve(sources: Sources, name: &str) -> Result<Resolved> {
    let mut resolved = Resolved { text: String::new(), lines: Vec::new() };
    include(sources, name, "the program", &mut Vec::new(), &mut resolved)?;
    Ok(resolved)
}

/// As [`resolve`], of a text that no file holds; `name` stands for it in messages.
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

/// Parses and validates; faults name file and line.
///
/// # Errors
/// [`Error::Gpu`] with naga's message.
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
