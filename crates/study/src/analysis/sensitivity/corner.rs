//! Features at the time at which a law switches: a peak at a corner, a threshold that a discontinuity crosses.
//!
//! At the time t_s of the switch a peak Y = y(t_s) changes by dY/dp = y_p(-) + y'(-) dt_s/dp, its time and that of a jump by dt_s/dp.

use super::super::AnalysisFailure;
use super::feature::{
    EQUAL, Feature, FeatureDerivatives, FeatureKind, FeatureSearch, NotDifferentiable, ROUNDS, SHORTER, SeenMotion,
};

/// What is found within this share of an interval from its end is found at its end.
const NEAR: f64 = 1e-9;

/// A law that has switched.
#[derive(Clone, Debug)]
pub(super) struct Switched {
    /// Just before, and just after it \[s\].
    pub times: [f64; 2],
    /// How its time changes, one for each parameter.
    pub changes: Vec<f64>,
}

/// An output on one side of a switch.
struct SwitchSide {
    value: f64,
    /// A second.
    slope: f64,
    /// Derivatives, one for each parameter.
    by: Vec<f64>,
}

impl SeenMotion<'_, '_> {
    /// What happens in an interval in which laws switch: between two of them, or where one does.
    pub(super) fn pieces(
        &self,
        search: &FeatureSearch,
        named: &(String, String),
        switched: &[&Switched],
    ) -> Result<Feature, AnalysisFailure> {
        let mut found = Vec::new();
        for switch in switched {
            found.extend(self.corner(search, named, switch)?);
        }
        let begins = [search.interval[0]].into_iter().chain(switched.iter().map(|switched| switched.times[1]));
        let ends = switched.iter().map(|switched| switched.times[0]).chain([search.interval[1]]);
        for interval in begins.zip(ends).map(|(low, high)| [low, high]).filter(|[low, high]| low < high) {
            found.extend(self.piece(&FeatureSearch { interval, ..search.clone() }, named)?);
        }
        let sign = if search.kind == FeatureKind::Smallest { -1.0 } else { 1.0 };
        let before = |one: &Feature, other: &Feature| match search.kind {
            FeatureKind::Crossing => one.time.total_cmp(&other.time),
            _ => (sign * other.value).total_cmp(&(sign * one.value)),
        };
        if let Some(best) = found.into_iter().min_by(before) {
            return Ok(best);
        }
        let time = switched.first().map_or(search.interval[0], |switch| switch.times[0]);
        let [value, _] = self.ends(&FeatureSearch { interval: [time, time], ..search.clone() })?;
        let changes = Err(NotDifferentiable::Corner);
        Ok(Feature { output: named.clone(), kind: search.kind, time, value, changes })
    }

    /// What happens between two switches; at their times it is that of the switch.
    fn piece(&self, search: &FeatureSearch, named: &(String, String)) -> Result<Option<Feature>, AnalysisFailure> {
        let [low, high] = search.interval;
        if search.kind == FeatureKind::Crossing {
            let [first, last] = self.ends(search)?;
            let crosses = (first > search.level) != (last > search.level);
            return crosses.then(|| self.smooth(search, named)).transpose();
        }
        let found = self.smooth(search, named)?;
        let near = NEAR * (high - low);
        let is_inside =
            (found.time - low > near || self.is_end(low)) && (high - found.time > near || self.is_end(high));
        Ok(Some(found).filter(|_| is_inside))
    }

    /// What happens at a switch, if it has derivatives.
    fn corner(
        &self,
        search: &FeatureSearch,
        named: &(String, String),
        switch: &Switched,
    ) -> Result<Option<Feature>, AnalysisFailure> {
        let [low, high] = search.interval;
        let before = self.beside(search.output, [low, switch.times[0]], 1.0)?;
        let after = self.beside(search.output, [switch.times[1], high], -1.0)?;
        let (Some(before), Some(after)) = (before, after) else { return Ok(None) };
        let extent = self.extent(search.output);
        let found = match search.kind {
            FeatureKind::Crossing => jumped(&before, &after, search.level, switch),
            FeatureKind::Largest => peak([&before, &after], 1.0, extent, switch),
            FeatureKind::Smallest => peak([&before, &after], -1.0, extent, switch),
        };
        let feature = |(value, changes)| Feature {
            output: named.clone(),
            kind: search.kind,
            time: switch.times[0],
            value,
            changes: Ok(changes),
        };
        Ok(found.map(feature))
    }

    /// An output at one end of an interval in which no law switches near that end.
    fn beside(&self, output: usize, mut interval: [f64; 2], end: f64) -> Result<Option<SwitchSide>, AnalysisFailure> {
        for _ in 0..ROUNDS {
            let [low, high] = interval;
            if high <= low {
                break;
            }
            let (values, derivatives) = self.polynomials(output, interval)?;
            if self.are_exact(output, &values, &derivatives) {
                let slope = values.slope().at(end) * 2.0 / (high - low);
                let by = derivatives.iter().map(|derivative| derivative.at(end)).collect();
                return Ok(Some(SwitchSide { value: values.at(end), slope, by }));
            }
            let length = SHORTER * (high - low);
            interval = if end > 0.0 { [high - length, high] } else { [low, low + length] };
        }
        Ok(None)
    }
}

/// Is a value jumped over?
fn jumped(before: &SwitchSide, after: &SwitchSide, level: f64, switch: &Switched) -> Option<(f64, FeatureDerivatives)> {
    let jumps = (before.value - level) * (after.value - level) < 0.0;
    jumps.then(|| (level, FeatureDerivatives { value: vec![0.0; switch.changes.len()], time: switch.changes.clone() }))
}

/// Does the output, with this sign, rise before and fall after, or jump down or up to where it does?
fn peak(
    [before, after]: [&SwitchSide; 2],
    sign: f64,
    extent: f64,
    switch: &Switched,
) -> Option<(f64, FeatureDerivatives)> {
    let (rises, falls) = (sign * before.slope >= 0.0, sign * after.slope <= 0.0);
    let jump = sign * (after.value - before.value);
    let (side, is_peak) = if jump > EQUAL * extent {
        (after, falls)
    } else if jump < -EQUAL * extent {
        (before, rises)
    } else {
        (before, rises && falls)
    };
    let value = || side.by.iter().zip(&switch.changes).map(|(by, time)| by + side.slope * time).collect();
    is_peak.then(|| (side.value, FeatureDerivatives { value: value(), time: switch.changes.clone() }))
}
