//! The bytes of glTF's buffers: the binary chunk, files beside the document, data URIs.

use crate::mesh::read::Limits;
use crate::{Error, Result};
use ::gltf::{Document, buffer::Source};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::{Path, PathBuf};

/// The content of each buffer.
pub(super) fn load(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    file: &Path,
    limits: &Limits,
) -> Result<Vec<Vec<u8>>> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let fault = |message: String| Error::fault(file, format!("buffer {}: {message}", buffer.index()));
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| fault("found no binary chunk, expected one".into()))?,
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => decoded(data).map_err(fault)?,
                None => {
                    let path = beside(file, uri);
                    let size = std::fs::metadata(&path).map_err(|e| Error::io(&path, e))?.len();
                    if size > limits.bytes {
                        return Err(fault(format!("found {size} bytes, expected at most {}", limits.bytes)));
                    }
                    std::fs::read(&path).map_err(|e| Error::io(&path, e))?
                }
            },
        };
        if bytes.len() < buffer.length() {
            let message =
                format!("found {} bytes, expected {}: it is cut short", bytes.len(), buffer.length());
            return Err(fault(message));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// The bytes of a data URI without its `data:`.
fn decoded(data: &str) -> Result<Vec<u8>, String> {
    let (kind, text) = data.split_once(',').ok_or("found a data URI without a comma")?;
    if !kind.ends_with(";base64") {
        return Err(format!("found a data URI of kind \"{kind}\", expected base64"));
    }
    STANDARD.decode(text.trim()).map_err(|e| format!("its data URI is no base64: {e}"))
}

/// The path of a file that the document at `file` names: relative to it, with percent signs
/// decoded.
pub(super) fn beside(file: &Path, uri: &str) -> PathBuf {
    let bytes = uri.as_bytes();
    let mut name = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = bytes.get(at + 1..at + 3).and_then(|hex| std::str::from_utf8(hex).ok());
        match code.and_then(|hex| u8::from_str_radix(hex, 16).ok()).filter(|_| bytes[at] == b'%') {
            Some(byte) => {
                name.push(byte);
                at += 3;
            }
            None => {
                name.push(bytes[at]);
                at += 1;
            }
        }
    }
    file.parent().unwrap_or(Path::new("")).join(String::from_utf8_lossy(&name).into_owned())
}
