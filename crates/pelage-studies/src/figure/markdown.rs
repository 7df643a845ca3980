//! The report in Markdown: `README.md` beside the figures, with the kept pictures.

use super::golden::{self, Kept};
use super::spec::Figure;
use crate::provenance::write_text;
use pelage_core::Result;
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "# Figures\n\n\
    The figures and tables of the works that pelage implements, made by this program, and some of its own. Pictures here are the small ones of\n\
    `pelage figure --all --quick`; `pelage figure --all` makes them in the papers' sizes, with OpenEXR layers, and writes `index.html`, where\n\
    sliders wipe between the pictures of a comparison. This page is written by `pelage figure --all --quick --bless`.\n";

/// Writes the page from the figures' folders and the kept results in them.
pub(super) fn write(registry: &Path) -> Result<()> {
    let names = Figure::names()?;
    let mut page = HEAD.to_owned();
    let mut body = String::new();
    let mut work = String::new();
    for name in &names {
        let (figure, folder) = Figure::find(name)?;
        let of = work_of(&figure.source);
        if of != work {
            let _ = write!(page, "\n{of}\n\n");
            work = of;
        }
        let _ = writeln!(page, "- [{}](#{name}): {}", figure.source, figure.title);
        let caption = std::fs::read_to_string(folder.join("caption.md")).unwrap_or_default();
        body += &section(name, &caption, Kept::read(&folder).as_ref());
    }
    page.push_str(&body);
    write_text(&registry.join("README.md"), &page)
}

/// The work of a source: the text before the first comma.
pub(super) fn work_of(source: &str) -> String {
    source.split(',').next().unwrap_or(source).to_owned()
}

fn section(name: &str, caption: &str, kept: Option<&Kept>) -> String {
    let mut lines = caption.lines();
    let heading = lines.next().unwrap_or_default().trim_start_matches('#').trim();
    let mut text = format!("\n<a id=\"{name}\"></a>\n\n## {heading}\n");
    if let Some(kept) = kept {
        let folder = golden::FOLDER;
        if let Some(sheet) = &kept.sheet {
            let _ = write!(text, "\n![{heading}]({name}/{folder}/{sheet})\n");
        }
        for drawing in &kept.drawings {
            let _ = write!(
                text,
                "\n![{}]({name}/{folder}/{})\n",
                drawing.caption.replace(']', ")"),
                drawing.file
            );
        }
    }
    for line in lines {
        // Headings of a caption are one level below that of its section.
        let _ = writeln!(text, "{}{line}", if line.starts_with('#') { "#" } else { "" });
    }
    if let Some(kept) = kept.filter(|kept| !kept.text.is_empty()) {
        let _ = write!(text, "\n{}\n\nMeasured with `--quick`: {}.\n", kept.text.trim_end(), kept.provenance);
    }
    text
}
