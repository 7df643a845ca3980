//! Texts of all shaders: compiled into a release, read from disk in development, so that a changed
//! shader needs no compilation.

use pelage_core::Result;
use pelage_gpu::Gpu;
use std::borrow::Cow;

#[derive(rust_embed::Embed)]
#[folder = "../../shaders"]
struct Folder;

/// The text of the shader called `name`, such as `resolve` or `shared/oit`.
pub fn text(name: &str) -> Option<Cow<'static, str>> {
    let file = Folder::get(&format!("{name}.wgsl"))?;
    String::from_utf8(file.data.into_owned()).ok().map(Cow::Owned)
}

/// Names of all shaders, those of `shared/` included.
pub fn names() -> Vec<String> {
    let mut names: Vec<String> =
        Folder::iter().filter_map(|file| file.strip_suffix(".wgsl").map(str::to_owned)).collect();
    names.sort();
    names
}

/// Opens the adapter that the environment selects, with these shaders.
///
/// # Errors
/// As [`Gpu::open`].
pub fn open() -> Result<Gpu> {
    Gpu::open(text)
}
