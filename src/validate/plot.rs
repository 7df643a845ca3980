//! Small line plots as SVG.

use super::html::escape;
use serde::Serialize;
use std::fmt::Write;

/// A curve.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// x and y. Points that are not finite are left out.
    pub points: Vec<[f64; 2]>,
}

/// Curves over common axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Plot {
    /// What it shows.
    pub caption: String,
    /// Name of the x axis.
    pub x: String,
    /// Name of the y axis.
    pub y: String,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Readable on white and told apart without colour vision (Okabe and Ito).
const COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
const SIZE: [f64; 2] = [460.0, 300.0];
/// Left, right, top, bottom.
const MARGIN: [f64; 4] = [62.0, 14.0, 12.0, 44.0];

impl Plot {
    /// The plot as an `svg` element.
    pub fn svg(&self) -> String {
        let [x, y] = [0, 1].map(|k| Axis::of(self.curves.iter().flat_map(|c| &c.points).map(|p| p[k])));
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
        x.ticks().for_each(|t| line(place([t, y.low]), place([t, y.high]), "#ddd"));
        y.ticks().for_each(|t| line(place([x.low, t]), place([x.high, t]), "#ddd"));
        line(place([x.low, y.low]), place([x.high, y.low]), "#444");
        line(place([x.low, y.low]), place([x.low, y.high]), "#444");
        let mut text = |[at_x, at_y]: [f64; 2], anchor: &str, words: &str, more: &str| {
            let _ = write!(
                svg,
                "<text x=\"{at_x:.1}\" y=\"{at_y:.1}\" text-anchor=\"{anchor}\"{more}>{}</text>",
                escape(words)
            );
        };
        for t in x.ticks() {
            let [px, py] = place([t, y.low]);
            text([px, py + 15.0], "middle", &x.label(t), "");
        }
        for t in y.ticks() {
            let [px, py] = place([x.low, t]);
            text([px - 5.0, py + 4.0], "end", &y.label(t), "");
        }
        text([0.5 * (SIZE[0] + left), SIZE[1] - 8.0], "middle", &self.x, "");
        let middle = 0.5 * (SIZE[1] - bottom + top);
        text([14.0, middle], "middle", &self.y, &format!(" transform=\"rotate(-90 14 {middle})\""));
        for (curve, color) in self.curves.iter().zip(COLORS.iter().cycle()) {
            let points: Vec<[f64; 2]> =
                curve.points.iter().filter(|p| p.iter().all(|v| v.is_finite())).map(|p| place(*p)).collect();
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

    /// What the colours of the curves mean.
    pub fn legend(&self) -> String {
        let entry = |(curve, color): (&Curve, &&str)| {
            format!("<span><i style=\"background:{color}\"></i>{}</span>", escape(&curve.name))
        };
        self.curves.iter().zip(COLORS.iter().cycle()).map(entry).collect()
    }
}

/// A linear axis from one round number to another.
struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // An axis that nearly starts at zero does start there.
        if low > 0.0 && low < 0.4 * high {
            low = 0.0;
        }
        let span = (high - low).max(1e-6 * high.abs().max(1.0));
        let power = 10f64.powf((span / 5.0).log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|s| span / s <= 6.0).unwrap_or(power);
        let low = (low / step).floor() * step;
        Self { low, high: ((high / step).ceil() * step).max(low + step), step }
    }

    fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + use<> {
        let (low, step) = (self.low, self.step);
        let count = ((self.high - low) / step).round() as usize;
        (0..=count).map(move |k| low + k as f64 * step)
    }

    fn label(&self, value: f64) -> String {
        let digits = (-self.step.log10().floor()).clamp(0.0, 9.0) as usize;
        // No minus before a zero.
        format!("{:.digits$}", if value.abs() < 0.5 * self.step { 0.0 } else { value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_round_and_hold_everything() {
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
    fn a_plot_draws_what_it_is_given() {
        let plot = Plot {
            caption: "a < b".into(),
            curves: vec![Curve { name: "one".into(), points: vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0]] }],
            ..Plot::default()
        };
        let svg = plot.svg();
        assert_eq!(svg.matches("<circle").count(), 2, "a point that is no number has no mark");
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN"), "{svg}");
        assert!(plot.legend().contains("one"));
    }
}
