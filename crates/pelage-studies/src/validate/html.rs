//! The report as one HTML page without scripts, which needs nothing from the network. Pictures are
//! files beside it.

use super::{Finding, Report, Section};
use crate::report::{Table, escape, number};
use std::fmt::Write;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:1180px;margin:2em auto;padding:0 1em;color:#222}\
h1{font-size:1.6em}h2{margin-top:2em;border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:1em 0}\
caption{text-align:left;padding:.3em 0;color:#444}th,td{padding:.25em .7em;border-bottom:1px solid #e2e2e2;text-align:left}\
th{background:#f3f3f3}td.n{white-space:nowrap;text-align:right;font-variant-numeric:tabular-nums}.met{color:#00704a}.missed{color:#b3261e;font-weight:600}\
.row{display:flex;flex-wrap:wrap;gap:10px;margin:1em 0}figure{margin:0}.row figure{width:240px}figure img{width:100%;background:#777;\
image-rendering:pixelated}figcaption{font-size:.85em;color:#444}.plots{display:flex;flex-wrap:wrap;gap:20px}\
.plots figure{max-width:480px}.plot text{font:11px system-ui,sans-serif;fill:#333}.legend span{margin-right:1.2em;white-space:nowrap}\
.legend i{display:inline-block;width:1.4em;height:.25em;margin-right:.4em;vertical-align:middle}.skipped{color:#7a4a00}";

/// The whole page.
pub fn page(report: &Report) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>pelage: validation</title><style>{STYLE}</style></head>\
         <body>\n<h1>What the approximations cost</h1>\n"
    );
    let p = &report.provenance;
    let level = match report.level {
        super::Level::Quick => "quick",
        super::Level::Usual => "usual",
        super::Level::Full => "full",
    };
    let about = [
        ("Version", format!("pelage {} ({})", p.version, p.commit)),
        ("Date", p.date.clone()),
        ("Adapter", format!("{} ({}, {}), {}", p.adapter, p.backend, p.device_type, p.driver)),
        ("CPU threads", report.threads.to_string()),
        ("Command", p.command.join(" ")),
        ("Level", level.to_owned()),
        ("Time", format!("{:.0} s", report.seconds)),
    ];
    page += "<table>";
    for (name, value) in about {
        let _ = writeln!(page, "<tr><th>{name}</th><td>{}</td></tr>", escape(&value));
    }
    page += "</table>\n";
    let (missed, with_goal) = (report.missed().len(), report.findings().filter(|f| f.met.is_some()).count());
    let (class, verdict) = match missed {
        0 => ("met", format!("All {with_goal} goals are met.")),
        n => ("missed", format!("{n} of {with_goal} goals are missed.")),
    };
    let _ = writeln!(page, "<p class=\"{class}\">{verdict}</p>");
    page += "<h2>All findings</h2>\n";
    page += &findings(report.findings());
    report.sections.iter().for_each(|s| page += &section(s));
    page + "</body></html>\n"
}

fn findings<'a>(findings: impl Iterator<Item = &'a Finding>) -> String {
    let mut html =
        "<table><tr><th>Approximation</th><th>Case</th><th>Measure</th><th>Value</th><th>Goal</th><th></th>\
        <th>Time, s</th></tr>\n"
            .to_owned();
    for f in findings {
        let (class, verdict) = match f.met {
            Some(true) => ("met", "met"),
            Some(false) => ("missed", "missed"),
            None => ("", ""),
        };
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td><td class=\"{class}\">{verdict}</td><td class=\"n\">{}</td></tr>",
            escape(&f.approximation),
            escape(&f.case),
            escape(&f.metric),
            number(f.value),
            f.goal.map_or(String::new(), |goal| goal.to_string()),
            f.seconds.map_or(String::new(), |s| format!("{s:.1}"))
        );
    }
    html + "</table>\n"
}

fn section(section: &Section) -> String {
    let mut html = format!("<h2 id=\"{}\">{}</h2>\n", escape(&section.name), escape(&section.title));
    for paragraph in &section.text {
        let _ = writeln!(html, "<p>{}</p>", escape(paragraph));
    }
    for reason in &section.skipped {
        let _ = writeln!(html, "<p class=\"skipped\">Left out: {}</p>", escape(reason));
    }
    if !section.plots.is_empty() {
        html += "<div class=\"plots\">";
        for plot in &section.plots {
            let _ = writeln!(
                html,
                "<figure>{}<figcaption>{}<div class=\"legend\">{}</div></figcaption></figure>",
                plot.svg(),
                escape(&plot.caption),
                plot.legend()
            );
        }
        html += "</div>\n";
    }
    for exhibit in &section.exhibits {
        exhibit.table.iter().for_each(|t| html += &table(t));
        if exhibit.pictures.is_empty() {
            continue;
        }
        html += "<div class=\"row\">";
        for picture in &exhibit.pictures {
            let _ = write!(
                html,
                "<figure><img src=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>",
                escape(&picture.file),
                escape(&picture.caption),
                escape(&picture.caption)
            );
        }
        html += "</div>\n";
    }
    let _ = writeln!(html, "<p>Time: {:.0} s.</p>", section.seconds);
    html
}

fn table(table: &Table) -> String {
    let cells = |tag: &str, cells: &[String]| -> String {
        let cell = |text: &String| {
            let class = if text.parse::<f64>().is_ok() { " class=\"n\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escape(text))
        };
        cells.iter().map(cell).collect()
    };
    let mut html = format!(
        "<table><caption>{}</caption><tr>{}</tr>\n",
        escape(&table.caption),
        cells("th", &table.head)
    );
    for row in &table.rows {
        let _ = writeln!(html, "<tr>{}</tr>", cells("td", row));
    }
    html + "</table>\n"
}
