//! The quantities of a motion over its input.

use cotree::model::Units;
use cotree::report::data::composed;
use cotree::typeset::titled;
use cotree_study::motion::report::radius_of;
use cotree_study::motion::{Cam, Figures, MotionColumn};

use crate::plot::{Plot, PlotSeries};

/// The table over the input.
pub fn plot(figures: &Figures, units: &Units) -> Plot {
    let series = |column: &MotionColumn| {
        let unit = composed(units, &column.unit);
        // Beyond a hundred a ratio is on its way to infinity, beyond ten base circles the radius of a profile.
        let radius = |cam: &&Cam| column.name == radius_of(&cam.name);
        let of_cam = figures.cams.iter().find(radius).map(|cam| 10.0 * cam.base);
        let limit = if column.name == "advantage" { Some(100.0) } else { of_cam };
        let is_far = |value: f64| limit.is_some_and(|limit| value.abs() > limit);
        let value = |value: &f64| if is_far(*value) { f64::NAN } else { value / unit.factor };
        PlotSeries::new(&column.name, &unit.name, column.values.iter().map(value).collect())
    };
    let Some((input, rest)) = figures.table.split_first() else { return Plot::default() };
    let unit = composed(units, &input.unit);
    Plot {
        title: figures.name.clone(),
        axis: titled(&input.name, &unit.name),
        true_to_scale: None,
        time: input.values.iter().map(|value| value / unit.factor).collect(),
        series: rest.iter().map(series).collect(),
    }
}
