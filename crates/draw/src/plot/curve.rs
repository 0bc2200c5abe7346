//! A curve with labelled points over two logarithmic axes.

use super::headed;
use super::panel::{AXIS, GRID, TICK, below, beside, place};
use crate::alike::Alike;
use crate::svg::{PictureFrame, Pixel, Svg, polyline};

/// A curve; all coordinates are above zero.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotCurve {
    pub title: String,
    /// Titles of the horizontal and of the vertical axis.
    pub axes: [String; 2],
    pub points: Vec<([f64; 2], String)>,
}

const WIDTH: f64 = 640.0;
const AXES: PictureFrame = PictureFrame { x: 84.0, y: 44.0, width: 520.0, height: 300.0 };
/// Below the axes: tick labels and title [px].
const BOTTOM: f64 = 52.0;
/// Space between the axes' ends and the outer points, with their labels: a factor, and a share of the decades in between.
const SPACE: f64 = 1.6;
const SHARE: f64 = 0.06;

const HALO: &str = r##"paint-order="stroke" stroke="#ffffff" stroke-width="3""##;
const LINE: &str = r##"fill="none" stroke="#2f6cab" stroke-width="1.8" stroke-linejoin="round""##;

impl PlotCurve {
    pub fn svg(&self) -> String {
        let [across, up] = [0, 1].map(|axis| LogScale::over(self.points.iter().map(|(point, _)| point[axis])));
        let mut svg = headed(&self.title);
        draw_axes(&mut svg, AXES, [&across, &up], [&self.axes[0], &self.axes[1]]);
        let pixels: Vec<Pixel> =
            self.points.iter().map(|([x, y], _)| place(AXES, across.part(*x), up.part(*y))).collect();
        svg.path(&polyline(&pixels), LINE);
        for ([x, y], (_, label)) in pixels.into_iter().zip(&self.points) {
            svg.circle([x, y], 4.0, r##"fill="#2f6cab" stroke="#ffffff" stroke-width="1.5""##);
            svg.text([x + 8.0, y - 6.0], &format!("{TICK} {HALO}"), label);
        }
        svg.finish(PictureFrame { x: 0.0, y: 0.0, width: WIDTH, height: AXES.y + AXES.height + BOTTOM }, &self.title)
    }
}

/// Two logarithmic axes with their grid and titles.
pub(crate) fn draw_axes(svg: &mut Svg, axes: PictureFrame, [across, up]: [&LogScale; 2], titles: [&str; 2]) {
    let PictureFrame { x: left, y: top, width, height } = axes;
    let (right, bottom) = (left + width, top + height);
    for tick in across.ticks() {
        let x = left + across.part(tick) * width;
        svg.line([x, top], [x, bottom], GRID);
        svg.text([x, bottom + 18.0], &format!(r#"{TICK} text-anchor="middle""#), &label(tick));
    }
    for tick in up.ticks() {
        let y = bottom - up.part(tick) * height;
        svg.line([left, y], [right, y], GRID);
        svg.text([left - 8.0, y + 4.2], &format!(r#"{TICK} text-anchor="end""#), &label(tick));
    }
    svg.line([left, top], [left, bottom], AXIS);
    svg.line([left, bottom], [right, bottom], AXIS);
    below(svg, axes, titles[0]);
    beside(svg, axes, titles[1]);
}

/// A logarithmic axis: the decimal logarithms of its ends.
pub(crate) struct LogScale {
    ends: [f64; 2],
}

impl LogScale {
    pub fn over(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] =
            values.fold([f64::MAX, f64::MIN_POSITIVE], |[low, high], value| [low.min(value), high.max(value)]);
        let space = SPACE.decimal_logarithm() + SHARE * (high / low).decimal_logarithm();
        Self { ends: [low.decimal_logarithm() - space, high.decimal_logarithm() + space] }
    }

    /// Where a value is on the axis: 0 at its beginning, 1 at its end.
    pub fn part(&self, value: f64) -> f64 {
        (value.decimal_logarithm() - self.ends[0]) / (self.ends[1] - self.ends[0])
    }

    /// Powers of ten; on a short axis also twice and five times as much.
    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.ends;
        let factors: &[f64] = if high - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = low.floor() as i32..=high.ceil() as i32;
        let ticks = decades.flat_map(|decade| factors.iter().map(move |factor| factor * 10f64.powi(decade)));
        ticks.filter(|tick| (low..=high).contains(&tick.decimal_logarithm())).collect()
    }
}

fn label(value: f64) -> String {
    if (1.0..1e5).contains(&value) { format!("{value:.0}") } else { format!("{value:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_powers_of_ten_or_finer() {
        let scale = LogScale::over([1e-10, 1e-4].into_iter());
        let labels: Vec<String> = scale.ticks().into_iter().map(label).collect();
        assert_eq!(labels, ["1e-10", "1e-9", "1e-8", "1e-7", "1e-6", "1e-5", "1e-4"]);
        let scale = LogScale::over([300.0, 4000.0].into_iter());
        let labels: Vec<String> = scale.ticks().into_iter().map(label).collect();
        assert_eq!(labels, ["200", "500", "1000", "2000", "5000"]);
    }

    /// A label reaches 18 px above its point and 45 px to its right.
    #[test]
    fn labels_of_outer_points_are_within_the_axes() {
        let scale = LogScale::over([1e-11, 1e-4].into_iter());
        assert!((1.0 - scale.part(1e-4)) * AXES.height > 18.0);
        let work = LogScale::over([200.0, 350.0].into_iter());
        assert!((1.0 - work.part(350.0)) * AXES.width > 45.0);
    }

    #[test]
    fn one_point_has_axes_too() {
        let scale = LogScale::over([1.0].into_iter());
        assert!((scale.part(1.0) - 0.5).abs() < 1e-12);
    }
}
