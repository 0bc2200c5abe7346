//! Measured and fitted values, and their differences.

use cotree::model::Units;
use cotree::report::data::shown;
use cotree::typeset::titled;
use cotree_study::fit::{Column, Fit};

use crate::plot::{Plot, Series};

/// Two panels for each column: what was measured beside what fits best, and the residuals.
pub fn plot(fit: &Fit, units: &Units) -> Plot {
    let second = shown(units, "s");
    let times: Vec<f64> = fit.times.iter().map(|time| time / second.factor).collect();
    Plot {
        title: format!("{}: measured and fitted", fit.name),
        axis: titled("time", &second.name),
        series: fit.columns.iter().flat_map(|column| panels(&times, column, units)).collect(),
        time: times,
        true_to_scale: None,
    }
}

fn panels(times: &[f64], Column { name, unit, measured, fitted, .. }: &Column, units: &Units) -> [Series; 4] {
    let unit = shown(units, unit);
    let residual = format!("residual of {name}");
    let series = |name: &str, values: Vec<f64>| Series {
        panel: Some(name.to_owned()),
        ..Series::new(name, &unit.name, values.iter().map(|value| value / unit.factor).collect())
    };
    let ends = [times.first(), times.last()].into_iter().flatten().copied().collect();
    let residuals = measured.iter().zip(fitted).map(|(measured, fitted)| measured - fitted).collect();
    let dots = |own: Series, of: &str| Series { measured: Some(of.to_owned()), ..own };
    [
        series(name, fitted.clone()),
        dots(series(&format!("{name} measured"), measured.clone()), name),
        Series { at: Some(ends), ..series(&residual, vec![0.0, 0.0]) },
        dots(series(&format!("{name} residual"), residuals), &residual),
    ]
}
