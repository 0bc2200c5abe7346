//! The goal and the limits of an optimum while one quantity after the other changes.

use cotree::model::Units;
use cotree::report::data::shown;
use cotree_study::optimize::{Best, NearOptimum};

use crate::plot::{Plot, PlotSeries};

/// A panel for the goal and one for each limit: a curve for each quantity from bound to bound, and the best goal or the bound, which each curve crosses at the best value.
pub fn plot(best: &Best, around: &[NearOptimum], units: &Units) -> Plot {
    let shares = |around: &NearOptimum| {
        let [low, high] = [around.values.first(), around.values.last()].map(|end| end.copied().unwrap_or(0.0));
        around.values.iter().map(|value| 100.0 * (value - low) / (high - low)).collect::<Vec<f64>>()
    };
    let mut series = Vec::new();
    let mut panel = |name: &str, unit: &str, (line, level): (&str, f64), of: &dyn Fn(&NearOptimum) -> Vec<f64>| {
        let unit = shown(units, unit);
        let curve = |label: &str, at: Vec<f64>, values: Vec<f64>| PlotSeries {
            panel: Some(name.to_owned()),
            at: Some(at),
            ..PlotSeries::new(label, &unit.name, values.into_iter().map(|value| value / unit.factor).collect())
        };
        let curves = around.iter().zip(&best.quantities);
        series.extend(curves.map(|(around, quantity)| curve(&quantity.name, shares(around), of(around))));
        series.push(curve(line, vec![0.0, 100.0], vec![level; 2]));
    };
    let (goal, unit) = &best.goal;
    panel(goal, unit, ("best", best.values[1].unwrap_or(f64::NAN)), &|around| around.goal.clone());
    for (index, limit) in best.limits.iter().enumerate() {
        let bounded = limit.text.split(['<', '>', '=', '≤', '≥']).next().unwrap_or_default().trim();
        panel(bounded, &limit.unit, ("bound", limit.bound), &|around| around.limits[index].clone());
    }
    Plot {
        title: format!("{}: around the best values", best.name),
        axis: "each quantity between its bounds [%]".to_owned(),
        series,
        ..Plot::default()
    }
}
