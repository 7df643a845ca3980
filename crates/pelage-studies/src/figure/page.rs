//! The report as one HTML page. It needs no server and nothing from the network; its only script
//! moves the sliders.

use super::content::Record;
use super::markdown::work_of;
use crate::provenance::write_text;
use crate::report::escape;
use pelage_core::Result;
use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd};
use std::fmt::Write;
use std::path::Path;

/// File name of the page.
pub(super) const FILE: &str = "index.html";
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Writes the page of `records` into `root`, whole or not at all.
pub(super) fn write(records: &[Record], root: &Path) -> Result<()> {
    write_text(&root.join(FILE), &page(records))
}

fn page(records: &[Record]) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>pelage: figures</title><style>{STYLE}</style></head><body>\n<h1>Figures and tables of the works that pelage implements</h1>\n<nav>"
    );
    let mut work = String::new();
    for record in records {
        let of = work_of(&record.source);
        if of != work {
            if !work.is_empty() {
                page += "</ul>";
            }
            let _ = write!(page, "<h2>{}</h2><ul>", escape(&of));
            work = of;
        }
        let _ =
            write!(page, "<li><a href=\"#{0}\">{1}</a></li>", escape(&record.figure), escape(&record.title));
    }
    if !work.is_empty() {
        page += "</ul>";
    }
    page += "</nav>\n<main>\n";
    records.iter().for_each(|record| page += &section(record));
    let _ = write!(page, "</main>\n<script>{SCRIPT}</script>\n</body></html>\n");
    page
}

fn section(record: &Record) -> String {
    let at = |file: &str| escape(&format!("{}/result/{file}", record.figure));
    let name = escape(&record.figure);
    let mut html = format!(
        "<section id=\"{name}\"><p class=\"source\">{}</p>\n{}",
        escape(&record.source),
        prose(record.caption.split("\n## ").next().unwrap_or_default())
    );
    for [left, right] in &record.wipes {
        let label = |file: &String| {
            record.pictures.iter().find(|p| p.file == *file).map(|p| escape(&p.label)).unwrap_or_default()
        };
        let _ = writeln!(
            html,
            "<figure class=\"wipe\"><div><img src=\"{}\" alt=\"{2}\"><img class=\"over\" src=\"{}\" alt=\"{3}\"></div>\
             <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"{2} against {3}\">\
             <figcaption><span>{2}</span><span>{3}</span></figcaption></figure>",
            at(right),
            at(left),
            label(left),
            label(right)
        );
    }
    if let Some(sheet) = &record.sheet {
        let _ = writeln!(
            html,
            "<a href=\"{0}\"><img class=\"sheet\" src=\"{0}\" alt=\"{1}\"></a>",
            at(sheet),
            escape(&record.title)
        );
    }
    for drawing in &record.drawings {
        let _ = writeln!(
            html,
            "<figure class=\"drawing\"><img src=\"{}\" alt=\"{1}\"><figcaption>{1}</figcaption></figure>",
            at(&drawing.file),
            escape(&drawing.caption)
        );
    }
    for file in &record.files {
        let caption = escape(&file.caption);
        let shown = [".png", ".svg", ".gif"].iter().any(|end| file.file.ends_with(end));
        let _ = match shown {
            true => writeln!(
                html,
                "<figure class=\"drawing\"><img src=\"{}\" alt=\"{caption}\"><figcaption>{caption}</figcaption></figure>",
                at(&file.file)
            ),
            false => writeln!(html, "<p><a href=\"{}\">{caption}</a></p>", at(&file.file)),
        };
    }
    html += &prose(&record.text);
    if let Some((_, rest)) = record.caption.split_once("\n## ") {
        html += &prose(&format!("## {rest}"));
    }
    if !record.pictures.is_empty() {
        html += "<details><summary>Pictures and their layers</summary><ul>";
        for picture in &record.pictures {
            let time = picture.stats.as_ref().and_then(|s| s["total_ms"].as_f64());
            let _ = write!(
                html,
                "<li>{}: <a href=\"{}\">PNG</a>, <a href=\"{}\">OpenEXR</a>{}</li>",
                escape(&picture.label),
                at(&picture.file),
                at(&picture.layers),
                time.map_or(String::new(), |ms| format!(", {:.2} s", ms / 1e3))
            );
        }
        html += "</ul></details>\n";
    }
    let p = &record.provenance;
    let _ = writeln!(
        html,
        "<p class=\"provenance\">{}{:.1} s on {} ({}, {}), pelage {} ({}), {}</p></section>",
        if record.quick { "Small version. " } else { "" },
        record.seconds,
        escape(&p.adapter),
        escape(&p.backend),
        escape(&p.driver),
        escape(&p.version),
        escape(&p.commit),
        escape(&p.date)
    );
    html
}

/// Markdown as HTML, with headings one level down. HTML within it is shown as text.
fn prose(markdown: &str) -> String {
    let down = |level: HeadingLevel| HeadingLevel::try_from(level as usize + 1).unwrap_or(level);
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES).map(|event| match event {
        Event::Start(Tag::Heading { level, id, classes, attrs }) => {
            Event::Start(Tag::Heading { level: down(level), id, classes, attrs })
        }
        Event::End(TagEnd::Heading(level)) => Event::End(TagEnd::Heading(down(level))),
        Event::Html(text) | Event::InlineHtml(text) => Event::Text(text),
        other => other,
    });
    let mut html = String::new();
    pulldown_cmark::html::push_html(&mut html, events);
    html
}

#[cfg(test)]
mod tests {
    use super::super::content::{Drawing, Picture};
    use super::*;

    #[test]
    fn a_page_shows_all_parts_and_escapes_markup() {
        let picture = |label: &str, file: &str| Picture {
            label: label.into(),
            file: file.into(),
            ..Picture::default()
        };
        let record = Record {
            figure: "x-fig1".into(),
            title: "a < b".into(),
            source: "X 2016, figure 1".into(),
            caption:
                "# Heading\n\nText <script>.\n\n    pelage figure x-fig1\n\n## Known differences\n\n- none"
                    .into(),
            pictures: vec![picture("one", "a.png"), picture("two", "b.png")],
            wipes: vec![["a.png".into(), "b.png".into()]],
            drawings: vec![Drawing { file: "curve.svg".into(), caption: "curve".into() }],
            text: "| a | b |\n|---|---|\n| 1 | 2 |\n".into(),
            ..Record::default()
        };
        let page = page(&[record]);
        for part in [
            "x-fig1/result/a.png",
            "x-fig1/result/curve.svg",
            "<td>1</td>",
            "<h2>Heading</h2>",
            "<h3>Known differences</h3>",
            "a &lt; b",
            "type=\"range\"",
        ] {
            assert!(page.contains(part), "no {part}");
        }
        assert_eq!(page.matches("<script>").count(), 1, "markup in captions is text");
        assert!(!page.contains("://"), "nothing from the network");
    }
}
