//! ZBrush's vertex colours: comments of the form `#MRGB MMRRGGBBMMRRGGBB...`, four bytes in
//! hexadecimal for each vertex, in the order of the vertices.

/// Mask, red, green and blue of vertices; empty if the text has none.
///
/// # Errors
/// Line and message of the first line that is damaged.
pub(super) fn read(text: &[u8]) -> Result<Vec<[u8; 4]>, (usize, String)> {
    let mut colors = Vec::new();
    let mut rest = text;
    let mut line = 0;
    while !rest.is_empty() {
        line += 1;
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        if let Some(digits) = rest[..end].strip_prefix(b"#MRGB ") {
            let digits = digits.trim_ascii();
            let fault = || {
                let expected = "expected eight hexadecimal digits for each vertex, MMRRGGBB";
                (line, format!("found a damaged #MRGB line of {} characters, {expected}", digits.len()))
            };
            if !digits.len().is_multiple_of(8) {
                return Err(fault());
            }
            for word in digits.chunks_exact(8) {
                let word = std::str::from_utf8(word).map_err(|_| fault())?;
                colors.push(u32::from_str_radix(word, 16).map_err(|_| fault())?.to_be_bytes());
            }
        }
        let skip = if rest[end..].starts_with(b"\r\n") { end + 2 } else { (end + 1).min(rest.len()) };
        rest = &rest[skip..];
    }
    Ok(colors)
}
