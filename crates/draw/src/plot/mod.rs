//! Curves over time: one panel for each unit, a common time axis. Maps over two quantities;
//! histograms; curves over logarithmic axes.

mod curve;
mod histogram;
mod map;
mod panel;
mod ticks;

pub use curve::PlotCurve;
pub(super) use curve::{LogScale, draw_axes};
pub use histogram::{Histogram, HistogramSample};
pub use map::{Field, Map};
pub(super) use panel::place;

use super::svg::{PictureFrame, Svg};
use panel::Panel;
use ticks::Ticks;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotSeries {
    pub name: String,
    /// Its unit; curves of the same unit and size share a panel.
    pub unit: String,
    /// Where its values are along the axis, if not where those of the plot are.
    pub at: Option<Vec<f64>>,
    /// Its values, one for each place along the axis. Where one is not finite the curve has a gap.
    pub values: Vec<f64>,
    /// The name of its panel: curves that name one share that one only, whatever their size.
    pub panel: Option<String>,
    /// The curve that it was measured for: it is drawn as dots in the panel of that one.
    pub measured: Option<String>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    pub title: String,
    /// What is along the axis, such as `time [s]`.
    pub axis: String,
    /// The unit of the axis, if one unit is to be as long upwards as along it.
    pub true_to_scale: Option<String>,
    /// The places along the axis.
    pub time: Vec<f64>,
    pub series: Vec<PlotSeries>,
}

/// Width of the picture [px].
const WIDTH: f64 = 800.0;
/// Height of one panel's axes [px].
const HEIGHT: f64 = 190.0;
/// Space between panels [px].
const GAP: f64 = 26.0;
/// Left of the axes: tick labels and axis title [px].
const LEFT: f64 = 84.0;
/// Right of the axes: the legend [px].
const RIGHT: f64 = 170.0;
/// Above the first panel: the title [px].
const TOP: f64 = 44.0;
/// Below the last panel: the time axis [px].
const BOTTOM: f64 = 52.0;

/// Curves whose largest values are this much apart do not share a panel.
const SCALES: f64 = 25.0;
/// Lowest and highest panel that is true to scale [px].
const HEIGHTS: [f64; 2] = [HEIGHT, 620.0];

impl Plot {
    pub fn svg(&self) -> String {
        let panels = self.panels();
        let at = || self.series.iter().filter_map(|series| series.at.as_ref()).flatten().chain(&self.time).copied();
        let mut ticks = if self.true_to_scale.is_some() { Ticks::around(at(), 8) } else { Ticks::over(at(), 8) };
        let mut svg = headed(&self.title);
        let mut frame = PictureFrame { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT };
        for (index, panel) in panels.iter().enumerate() {
            if index > 0 {
                frame.y += frame.height + GAP;
            }
            let mut values = panel.values();
            if self.true_to_scale.as_deref() == Some(panel.unit) {
                frame.height = same_scale(frame.width, &mut ticks, &mut values);
            } else {
                frame.height = HEIGHT;
            }
            panel.draw(&mut svg, frame, &self.time, &ticks, &values);
        }
        panel::along(&mut svg, frame, &ticks, &self.axis);
        let height = frame.y + frame.height + BOTTOM;
        svg.finish(PictureFrame { x: 0.0, y: 0.0, width: WIDTH, height }, &self.title)
    }

    /// Curves by unit and size, in the order in which they occur.
    fn panels(&self) -> Vec<Panel<'_>> {
        let mut panels: Vec<Panel> = Vec::new();
        for series in self.series.iter().filter(|series| series.measured.is_none()) {
            let size = series.size();
            let fits = |panel: &&mut Panel| {
                let sizes = panel.series.iter().map(|series| series.size()).filter(|size| *size > 0.0);
                let near = |other: f64| size <= SCALES * other && other <= SCALES * size;
                let is_named = series.panel.is_some();
                let same = panel.unit == series.unit
                    && panel.series.iter().all(|curve_series| curve_series.panel == series.panel);
                same && (is_named || size == 0.0 || sizes.into_iter().all(near))
            };
            match panels.iter_mut().find(fits) {
                Some(panel) => panel.series.push(series),
                None => panels.push(Panel { unit: &series.unit, series: vec![series], measured: Vec::new() }),
            }
        }
        for measured in &self.series {
            let of = |panel: &&mut Panel| {
                measured.measured.is_some()
                    && panel.series.iter().any(|curve_series| Some(&curve_series.name) == measured.measured.as_ref())
            };
            if let Some(panel) = panels.iter_mut().find(of) {
                panel.measured.push(measured);
            }
        }
        panels
    }
}

/// A picture that begins with its title.
pub(super) fn headed(title: &str) -> Svg {
    let mut svg = Svg::default();
    svg.text([LEFT, 27.0], r##"font-size="15" font-weight="600" fill="#1f2933""##, title);
    svg
}

impl PlotSeries {
    /// A curve along the axis of its plot.
    pub fn new(name: &str, unit: &str, values: Vec<f64>) -> Self {
        PlotSeries { name: name.into(), unit: unit.into(), values, ..PlotSeries::default() }
    }

    /// Its largest value, without its sign.
    fn size(&self) -> f64 {
        self.values.iter().filter(|value| value.is_finite()).fold(0.0, |size, value| f64::max(size, value.abs()))
    }
}

/// Makes both axes equally long for one unit; the height of the axes [px].
fn same_scale(width: f64, along: &mut Ticks, up: &mut Ticks) -> f64 {
    let [right, high] = [&*along, &*up].map(|ticks| ticks.range[1] - ticks.range[0]);
    let height = (width * high / right).clamp(HEIGHTS[0], HEIGHTS[1]);
    let scale = (right / width).max(high / height);
    *along = along.widened(scale * width, 8);
    *up = up.widened(scale * height, 6);
    height
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alike::Alike;

    #[test]
    fn one_panel_for_each_unit() {
        let series = vec![
            PlotSeries::new("crank.angle", "rad", vec![0.0, 1.0]),
            PlotSeries::new("slider.x", "m", vec![0.0, 1.0]),
            PlotSeries::new("rod.angle", "rad", vec![1.0, 0.0]),
        ];
        let plot = Plot { title: "a < b".into(), time: vec![0.0, 1.0], series, ..Plot::default() };
        let units: Vec<_> = plot.panels().iter().map(|panel| (panel.unit, panel.series.len())).collect();
        assert_eq!(units, [("rad", 2), ("m", 1)]);
        assert!(plot.svg().contains("<title>a &lt; b</title>"));
    }

    #[test]
    fn what_has_no_known_unit_is_not_called_a_pure_number() {
        let series = vec![PlotSeries::new("a", "", vec![0.0, 1.0]), PlotSeries::new("b", "", vec![1.0, 0.0])];
        let plot = Plot { title: "p".into(), time: vec![0.0, 1.0], series, ..Plot::default() };
        assert!(!plot.svg().contains("[1]") && !plot.svg().contains("[]"), "{}", plot.svg());
    }

    #[test]
    fn curves_of_different_size_get_panels_of_their_own() {
        let series = vec![
            PlotSeries::new("large", "N", vec![0.0, 1e4]),
            PlotSeries::new("small", "N", vec![0.0, 3.0]),
            PlotSeries::new("zero", "N", vec![0.0, 0.0]),
            PlotSeries::new("smaller", "N", vec![-1.0, 1.0]),
        ];
        let plot = Plot { time: vec![0.0, 1.0], series, ..Plot::default() };
        let names: Vec<Vec<&str>> =
            plot.panels().iter().map(|panel| panel.series.iter().map(|series| &*series.name).collect()).collect();
        assert_eq!(names, [vec!["large", "zero"], vec!["small", "smaller"]]);
    }

    #[test]
    fn equal_curves_are_told_apart() {
        let series =
            ["a", "b", "c"].map(|name| PlotSeries::new(name, "N", vec![0.0, if name == "c" { 2.0 } else { 1.0 }]));
        let plot = Plot { time: vec![0.0, 1.0], series: series.to_vec(), ..Plot::default() };
        assert_eq!(plot.svg().matches("stroke-dasharray").count(), 2, "one curve and its line in the legend");
    }

    #[test]
    fn what_is_measured_is_dots_beside_its_curve() {
        let measured = PlotSeries {
            at: Some(vec![0.25, 0.5]),
            measured: Some("x".into()),
            ..PlotSeries::new("x measured", "m", vec![0.3, 0.5])
        };
        let plot = Plot {
            time: vec![0.0, 1.0],
            series: vec![PlotSeries::new("x", "m", vec![0.0, 1.0]), measured],
            ..Plot::default()
        };
        assert_eq!((plot.panels().len(), plot.svg().matches("<circle").count()), (1, 3));
    }

    #[test]
    fn a_circle_is_drawn_as_a_circle() {
        let turn = (0..=100).map(|index| f64::from(index) * std::f64::consts::TAU / 100.0);
        let (time, values) = turn.map(|angle| (0.2 * angle.cosine(), 0.2 * angle.sine())).unzip();
        let plot = Plot {
            true_to_scale: Some("m".into()),
            time,
            series: vec![PlotSeries::new("y", "m", values)],
            ..Plot::default()
        };
        let svg = plot.svg();
        let path = svg.split("<path d=\"").nth(1).unwrap().split('"').next().unwrap();
        let pixels: Vec<[f64; 2]> = path
            .split(['M', 'L'])
            .skip(1)
            .map(|pair| {
                let (x, y) = pair.split_once(' ').unwrap();
                [x.parse().unwrap(), y.parse().unwrap()]
            })
            .collect();
        let extent = |axis: usize| {
            let of = || pixels.iter().map(|pixel| pixel[axis]);
            of().fold(f64::MIN, f64::max) - of().fold(f64::MAX, f64::min)
        };
        assert!((extent(0) - extent(1)).abs() < 0.02 && extent(0) > 150.0, "{} {}", extent(0), extent(1));
    }

    #[test]
    fn values_that_are_no_numbers_leave_gaps() {
        let time = (0..6).map(f64::from).collect();
        let values = vec![0.0, f64::NAN, 1.0, 2.0, f64::INFINITY, 3.0];
        let svg = Plot { time, series: vec![PlotSeries::new("x", "m", values)], ..Plot::default() }.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn nothing_to_plot_is_still_a_picture() {
        assert!(Plot::default().svg().ends_with("</svg>\n"));
        let empty = Plot { series: vec![PlotSeries::new("x", "m", vec![])], ..Plot::default() };
        assert!(!empty.svg().contains("NaN"));
    }
}
