//! Curves over time: one panel for each unit, a common time axis.

mod panel;
mod ticks;

use super::svg::{Frame, Svg};
use panel::Panel;
use ticks::Ticks;

#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// Its unit; curves of the same unit share a panel.
    pub unit: String,
    /// Its values, one for each time. Where one is not finite the curve has a gap.
    pub values: Vec<f64>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    pub title: String,
    /// \[s\]
    pub time: Vec<f64>,
    pub series: Vec<Series>,
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

impl Plot {
    pub fn svg(&self) -> String {
        let panels = self.panels();
        let ticks = Ticks::over(self.time.iter().copied(), 8);
        let mut svg = Svg::default();
        let title = r##"font-size="15" font-weight="600" fill="#1f2933""##;
        svg.text([LEFT, 27.0], title, &self.title);
        let mut frame = Frame { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT };
        for (index, panel) in panels.iter().enumerate() {
            frame.y = TOP + (HEIGHT + GAP) * index as f64;
            panel.draw(&mut svg, frame, &self.time, &ticks);
        }
        panel::time_axis(&mut svg, frame, &ticks);
        let height = frame.y + frame.height + BOTTOM;
        svg.finish(Frame { x: 0.0, y: 0.0, width: WIDTH, height }, &self.title)
    }

    /// Curves by unit, in the order in which the units occur.
    fn panels(&self) -> Vec<Panel<'_>> {
        let mut panels: Vec<Panel> = Vec::new();
        for series in &self.series {
            match panels.iter_mut().find(|panel| panel.unit == series.unit) {
                Some(panel) => panel.series.push(series),
                None => panels.push(Panel { unit: &series.unit, series: vec![series] }),
            }
        }
        panels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, unit: &str, values: Vec<f64>) -> Series {
        Series { name: name.into(), unit: unit.into(), values }
    }

    #[test]
    fn one_panel_for_each_unit() {
        let series = vec![
            series("crank.angle", "rad", vec![0.0, 1.0]),
            series("slider.x", "m", vec![0.0, 1.0]),
            series("rod.angle", "rad", vec![1.0, 0.0]),
        ];
        let plot = Plot { title: "a < b".into(), time: vec![0.0, 1.0], series };
        let units: Vec<_> = plot.panels().iter().map(|panel| (panel.unit, panel.series.len())).collect();
        assert_eq!(units, [("rad", 2), ("m", 1)]);
        assert!(plot.svg().contains("<title>a &lt; b</title>"));
    }

    #[test]
    fn what_has_no_known_unit_is_not_called_a_pure_number() {
        let series = vec![series("a", "", vec![0.0, 1.0]), series("b", "", vec![1.0, 0.0])];
        let plot = Plot { title: "p".into(), time: vec![0.0, 1.0], series };
        assert!(!plot.svg().contains("[1]") && !plot.svg().contains("[]"), "{}", plot.svg());
    }

    #[test]
    fn values_that_are_no_numbers_leave_gaps() {
        let time = (0..6).map(f64::from).collect();
        let values = vec![0.0, f64::NAN, 1.0, 2.0, f64::INFINITY, 3.0];
        let svg = Plot { title: String::new(), time, series: vec![series("x", "m", values)] }.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn nothing_to_plot_is_still_a_picture() {
        assert!(Plot::default().svg().ends_with("</svg>\n"));
        let empty = Plot { series: vec![series("x", "m", vec![])], ..Plot::default() };
        assert!(!empty.svg().contains("NaN"));
    }
}
