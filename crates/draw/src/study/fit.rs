//! Measured and fitted values, and their differences.

use cotree_study::fit::{Column, Fit};

use crate::plot::{Plot, Series};

/// Two panels for each column: what was measured beside what fits best, and the residuals.
pub fn plot(fit: &Fit) -> Plot {
    Plot {
        title: format!("{}: measured and fitted", fit.name),
        axis: "time [s]".to_owned(),
        time: fit.times.clone(),
        series: fit.columns.iter().flat_map(|column| panels(fit, column)).collect(),
        true_to_scale: None,
    }
}

fn panels(fit: &Fit, Column { name, unit, measured, fitted, .. }: &Column) -> [Series; 4] {
    let residual = format!("residual of {name}");
    let series = |name: &str, values: Vec<f64>| Series {
        name: name.to_owned(),
        unit: unit.clone(),
        values,
        panel: Some(name.to_owned()),
        ..Series::default()
    };
    let ends = [fit.times.first(), fit.times.last()].into_iter().flatten().copied().collect();
    let residuals = measured.iter().zip(fitted).map(|(measured, fitted)| measured - fitted).collect();
    let dots = |own: Series, of: &str| Series { measured: Some(of.to_owned()), ..own };
    [
        series(name, fitted.clone()),
        dots(series(&format!("{name} measured"), measured.clone()), name),
        Series { at: Some(ends), ..series(&residual, vec![0.0, 0.0]) },
        dots(series(&format!("{name} residual"), residuals), &residual),
    ]
}
