//! Small line plots as SVG.

use super::escape;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A named curve.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// x and y. Points that are not finite are left out.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// A curve through `points`.
    pub fn new(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points }
    }
}

/// Curves over common axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Plot {
    /// What it shows.
    pub caption: String,
    /// Name of the x axis.
    pub x: String,
    /// Name of the y axis.
    pub y: String,
    /// Whether x and y are logarithmic; values that are not positive are then left out.
    #[serde(default)]
    pub log: [bool; 2],
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Colours that are distinguishable on white and with colour vision deficiency.
// [OkabeIto2008]
const COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
const SIZE: [f64; 2] = [460.0, 300.0];
/// Left, right, top, bottom.
const MARGIN: [f64; 4] = [62.0, 14.0, 12.0, 44.0];

impl Plot {
    /// The plot as an `svg` element.
    pub fn svg(&self) -> String {
        let all = || self.curves.iter().flat_map(|c| &c.points);
        let [x, y] = [0, 1].map(|k| match self.log[k] {
            true => Axis::decades(all().map(|p| p[k])),
            false => Axis::of(all().map(|p| p[k])),
        });
        let [left, right, top, bottom] = MARGIN;
        let place = |p: [f64; 2]| {
            [
                left + x.part(p[0]) * (SIZE[0] - left - right),
                SIZE[1] - bottom - y.part(p[1]) * (SIZE[1] - top - bottom),
            ]
        };
        let mut svg = format!(
            "<svg class=\"plot\" viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\" role=\"img\" aria-label=\"{}\">",
            SIZE[0],
            SIZE[1],
            SIZE[0],
            SIZE[1],
            escape(&self.caption)
        );
        let mut line = |a: [f64; 2], b: [f64; 2], color: &str| {
            let _ = write!(
                svg,
                "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\"/>",
                a[0], a[1], b[0], b[1]
            );
        };
        let [low, high] = [[x.lowest(), y.lowest()], [x.highest(), y.highest()]];
        x.ticks().for_each(|t| line(place([t, low[1]]), place([t, high[1]]), "#ddd"));
        y.ticks().for_each(|t| line(place([low[0], t]), place([high[0], t]), "#ddd"));
        line(place(low), place([high[0], low[1]]), "#444");
        line(place(low), place([low[0], high[1]]), "#444");
        let mut text = |[at_x, at_y]: [f64; 2], anchor: &str, text: &str, more: &str| {
            let _ = write!(
                svg,
                "<text x=\"{at_x:.1}\" y=\"{at_y:.1}\" text-anchor=\"{anchor}\"{more}>{}</text>",
                escape(text)
            );
        };
        for t in x.ticks() {
            let [px, py] = place([t, low[1]]);
            text([px, py + 15.0], "middle", &x.label(t), "");
        }
        for t in y.ticks() {
            let [px, py] = place([low[0], t]);
            text([px - 5.0, py + 4.0], "end", &y.label(t), "");
        }
        text([0.5 * (SIZE[0] + left), SIZE[1] - 8.0], "middle", &self.x, "");
        let middle = 0.5 * (SIZE[1] - bottom + top);
        text([14.0, middle], "middle", &self.y, &format!(" transform=\"rotate(-90 14 {middle})\""));
        for (curve, color) in self.curves.iter().zip(COLORS.iter().cycle()) {
            let points: Vec<[f64; 2]> =
                curve.points.iter().map(|p| place(*p)).filter(|p| p.iter().all(|v| v.is_finite())).collect();
            let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            let _ = write!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.8\"/>",
                path.join(" ")
            );
            for [x, y] in points {
                let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\" fill=\"{color}\"/>");
            }
        }
        svg + "</svg>"
    }

    /// The plot as an SVG file: on white, with the names of its curves below.
    pub fn file(&self) -> String {
        const LINE: f64 = 17.0;
        let height = SIZE[1] + LINE * self.curves.len() as f64 + 6.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {height}\" width=\"{0}\" height=\"{height}\">\
             <style>text{{font:11px system-ui,sans-serif;fill:#333}}</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{1}",
            SIZE[0],
            self.svg()
        );
        for (k, (curve, color)) in self.curves.iter().zip(COLORS.iter().cycle()).enumerate() {
            let y = SIZE[1] + LINE * (k as f64 + 0.5);
            let _ = write!(
                svg,
                "<rect x=\"{0}\" y=\"{1}\" width=\"18\" height=\"4\" fill=\"{color}\"/><text x=\"{2}\" y=\"{3}\">{4}</text>",
                MARGIN[0],
                y - 2.0,
                MARGIN[0] + 26.0,
                y + 4.0,
                escape(&curve.name)
            );
        }
        svg + "</svg>\n"
    }

    /// The names of the curves with their colours, HTML.
    pub fn legend(&self) -> String {
        let entry = |(curve, color): (&Curve, &&str)| {
            format!("<span><i style=\"background:{color}\"></i>{}</span>", escape(&curve.name))
        };
        self.curves.iter().zip(COLORS.iter().cycle()).map(entry).collect()
    }
}

/// An axis between round numbers.
struct Axis {
    /// Decimal logarithms if `log`.
    low: f64,
    high: f64,
    step: f64,
    log: bool,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // An axis that starts near zero starts at zero.
        if low > 0.0 && low < 0.4 * high {
            low = 0.0;
        }
        let span = (high - low).max(1e-6 * high.abs().max(1.0));
        let power = 10f64.powf((span / 5.0).log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|s| span / s <= 6.0).unwrap_or(power);
        let low = (low / step).floor() * step;
        Self { low, high: ((high / step).ceil() * step).max(low + step), step, log: false }
    }

    /// A logarithmic axis over whole decades.
    fn decades(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite() && *v > 0.0)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v.log10()), h.max(v.log10())));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low.floor(), high.ceil()) };
        Self { low, high: high.max(low + 1.0), step: 1.0, log: true }
    }

    fn value(&self, place: f64) -> f64 {
        if self.log { 10f64.powf(place) } else { place }
    }

    fn lowest(&self) -> f64 {
        self.value(self.low)
    }

    fn highest(&self) -> f64 {
        self.value(self.high)
    }

    /// Position along the axis, 0..1; not finite for a value that is not positive on a logarithmic
    /// axis.
    fn part(&self, value: f64) -> f64 {
        let place = if self.log { value.log10() } else { value };
        (place - self.low) / (self.high - self.low)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + use<> {
        let (low, step, log) = (self.low, self.step, self.log);
        let count = ((self.high - low) / step).round() as usize;
        (0..=count).map(move |k| low + k as f64 * step).map(move |x| if log { 10f64.powf(x) } else { x })
    }

    fn label(&self, value: f64) -> String {
        if self.log {
            return if (0.001..1e6).contains(&value) {
                format!("{}", (value * 1e3).round() / 1e3)
            } else {
                format!("{value:e}")
            };
        }
        let digits = (-self.step.log10().floor()).clamp(0.0, 9.0) as usize;
        // No negative zero.
        format!("{:.digits$}", if value.abs() < 0.5 * self.step { 0.0 } else { value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_round_and_contain_all_values() {
        for (values, low, high) in [
            (vec![0.0, 80.0], 0.0, 80.0),
            (vec![0.93, 1.04], 0.92, 1.04),
            (vec![3.0, 3.0], 3.0, 3.0),
            (vec![], 0.0, 1.0),
            (vec![f64::NAN, 0.2, 1.0], 0.0, 1.0),
        ] {
            let axis = Axis::of(values.iter().copied());
            assert!(axis.low <= low && axis.high >= high && axis.high > axis.low, "{values:?}: {}", axis.low);
            let ticks: Vec<f64> = axis.ticks().collect();
            assert!((2..=9).contains(&ticks.len()), "{values:?}: {ticks:?}");
            assert!((ticks[ticks.len() - 1] - axis.high).abs() < 1e-9);
        }
        assert_eq!(Axis::of([0.9, 1.1].into_iter()).label(1.0), "1.00");
    }

    #[test]
    fn a_logarithmic_axis_has_whole_decades() {
        let axis = Axis::decades([0.02, 5.0, -1.0, f64::NAN].into_iter());
        assert_eq!((axis.lowest(), axis.highest()), (0.01, 10.0));
        let labels: Vec<String> = axis.ticks().map(|t| axis.label(t)).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10"]);
        assert!((axis.part(0.1) - 1.0 / 3.0).abs() < 1e-9 && !axis.part(0.0).is_finite());
        let points = vec![[1.0, 0.0], [2.0, 10.0]];
        let plot = Plot {
            log: [false, true],
            curves: vec![Curve { name: "one".into(), points }],
            ..Plot::default()
        };
        let file = plot.file();
        assert_eq!(file.matches("<circle").count(), 1, "zero is left out");
        assert!(file.contains("xmlns") && file.contains(">one</text>"));
    }

    #[test]
    fn a_plot_draws_what_it_is_given() {
        let plot = Plot {
            caption: "a < b".into(),
            curves: vec![Curve { name: "one".into(), points: vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0]] }],
            ..Plot::default()
        };
        let svg = plot.svg();
        assert_eq!(svg.matches("<circle").count(), 2, "a point that is not a number is left out");
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN"), "{svg}");
        assert!(plot.legend().contains("one"));
    }
}
