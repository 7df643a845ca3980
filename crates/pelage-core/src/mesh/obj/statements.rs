//! The lexical layer of OBJ: bytes to statements.

/// Iterates over the statements of an OBJ file. It works on bytes, so that comments and names may
/// have any encoding.
pub(super) struct Statements<'a> {
    rest: &'a [u8],
    line: usize,
    joined: Vec<u8>,
}

impl<'a> Statements<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), line: 0, joined: Vec::new() }
    }

    /// The next statement, without its comment, and the line (from 1) on which it begins. Lines
    /// that end in a backslash are joined with the next one; lines end with LF, CR LF or CR.
    pub(super) fn next(&mut self) -> Option<(usize, &[u8])> {
        let (line, continued) = self.physical_line()?;
        let first = self.line;
        if !continued {
            return Some((first, line));
        }
        self.joined.clear();
        self.joined.extend_from_slice(line);
        while let Some((line, continued)) = self.physical_line() {
            self.joined.push(b' ');
            self.joined.extend_from_slice(line);
            if !continued {
                break;
            }
        }
        Some((first, &self.joined))
    }

    /// The next line without its comment or final backslash, and whether it continues in the next
    /// line. A comment ends with its line, so that `# C:\models\` does not swallow the next one.
    fn physical_line(&mut self) -> Option<(&'a [u8], bool)> {
        if self.rest.is_empty() {
            return None;
        }
        self.line += 1;
        let rest = self.rest;
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let skip = match rest.get(end..end + 2) {
            Some(b"\r\n") => end + 2,
            _ => (end + 1).min(rest.len()),
        };
        self.rest = &rest[skip..];
        let line = &rest[..end];
        if let Some(comment) = line.iter().position(|b| *b == b'#') {
            return Some((&line[..comment], false));
        }
        match line.trim_ascii_end().strip_suffix(b"\\") {
            Some(head) => Some((head, true)),
            None => Some((line, false)),
        }
    }
}

/// The words of a statement.
pub(super) fn words(statement: &[u8]) -> impl Iterator<Item = &[u8]> {
    statement.split(|b| b.is_ascii_whitespace() || *b == 0x0B).filter(|word| !word.is_empty())
}
