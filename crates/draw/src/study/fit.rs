//! Measured and fitted values, and their differences.

use cotree::model::Units;
use cotree::report::data::shown;
use cotree::typeset::titled;
use cotree_study::fit::{Fit, MeasuredExperiment, MeasuredVariable};

use crate::plot::{Plot, PlotSeries};

/// Two panels for each column: what was measured beside what fits best, and the residuals. Those of several experiments have their numbers.
pub fn plot(fit: &Fit, units: &Units) -> Plot {
    let second = shown(units, "s");
    let times = |experiment: &MeasuredExperiment| {
        experiment.times.iter().map(|time| time / second.factor).collect::<Vec<f64>>()
    };
    let panels = |(index, experiment): (usize, &MeasuredExperiment)| {
        let number = if fit.measured.len() > 1 { format!(" ({})", index + 1) } else { String::new() };
        let times = times(experiment);
        experiment.columns.iter().flat_map(|column| panels(&times, column, &number, units)).collect::<Vec<_>>()
    };
    Plot {
        title: format!("{}: measured and fitted", fit.name),
        axis: titled("time", &second.name),
        series: fit.measured.iter().enumerate().flat_map(panels).collect(),
        time: fit.measured.first().map(times).unwrap_or_default(),
        true_to_scale: None,
    }
}

fn panels(times: &[f64], column: &MeasuredVariable, number: &str, units: &Units) -> [PlotSeries; 4] {
    let MeasuredVariable { name, unit, measured, fitted, .. } = column;
    let (name, unit) = (&format!("{name}{number}"), shown(units, unit));
    let residual = format!("residual of {name}");
    let series = |name: &str, values: Vec<f64>| PlotSeries {
        panel: Some(name.to_owned()),
        at: Some(times.to_vec()),
        ..PlotSeries::new(name, &unit.name, values.iter().map(|value| value / unit.factor).collect())
    };
    let ends = [times.first(), times.last()].into_iter().flatten().copied().collect();
    let residuals = measured.iter().zip(fitted).map(|(measured, fitted)| measured - fitted).collect();
    let dots = |series: PlotSeries, of: &str| PlotSeries { measured: Some(of.to_owned()), ..series };
    [
        series(name, fitted.clone()),
        dots(series(&format!("{name} measured"), measured.clone()), name),
        PlotSeries { at: Some(ends), ..series(&residual, vec![0.0, 0.0]) },
        dots(series(&format!("{name} residual"), residuals), &residual),
    ]
}
