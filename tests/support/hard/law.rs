//! What holds of a motion on its branch, and the watch over it along a run.

use std::f64::consts::TAU;

use cotree_fmu::instance::Instance;

use super::Case;

/// What holds on the branch at all times.
#[derive(Clone, Debug)]
pub enum Law {
    /// One joint of a four-bar turns all the way round. The sine of the opposite angle changes sign where the four-bar lies flat (when that joint is
    /// folded, stretched, or both) and nowhere else.
    Assembly { turn: Angle, opposite: Angle, flat: [bool; 2] },
    /// A constant combination of variables, 2 pi more or less if they are angles.
    Constant { terms: Vec<(String, f64)>, value: f64, turns: bool },
    /// The value of a variable at every multiple of a period.
    Periodic { name: String, value: f64, period: f64 },
}

/// Differences of angles of bars, and half turns.
#[derive(Clone, Debug)]
pub struct Angle {
    pub plus: Option<String>,
    pub minus: Option<String>,
    pub shift: f64,
}

/// Near the flat pose the sign of an assembly says nothing.
const UNDECIDED: f64 = 0.02;

impl Law {
    pub fn variables(&self) -> Vec<String> {
        match self {
            Law::Assembly { turn, opposite, .. } => {
                [&turn.plus, &turn.minus, &opposite.plus, &opposite.minus].into_iter().flatten().cloned().collect()
            }
            Law::Periodic { name, .. } => vec![name.clone()],
            Law::Constant { terms, .. } => terms.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    fn is_broken(&self, instance: &mut Instance, sign: &mut f64) -> Result<Option<String>, String> {
        match self {
            Law::Assembly { turn, opposite, flat } => {
                let half = turn.value(instance)? / 2.0;
                let apex = opposite.value(instance)?.sin();
                let flips = if flat[0] { half.sin() } else { 1.0 } * if flat[1] { half.cos() } else { 1.0 };
                if flips.abs() < UNDECIDED || apex.abs() < UNDECIDED {
                    return Ok(None);
                }
                let now = (apex * flips).signum();
                if *sign == 0.0 {
                    *sign = now;
                }
                Ok((now != *sign).then(|| format!("another assembly, {turn:?}")))
            }
            Law::Periodic { name, value, period } => {
                let periods = instance.time() / period;
                let off = (get(instance, name)? - value).sin().abs();
                Ok(((periods - periods.round()).abs() < 1e-9 && (off.is_nan() || off >= 1e-3))
                    .then(|| format!("{name} is off by {off:.2e}")))
            }
            Law::Constant { terms, value, turns } => {
                let mut sum = -value;
                for (name, factor) in terms {
                    sum += factor * get(instance, name)?;
                }
                if *turns {
                    sum -= TAU * (sum / TAU).round();
                }
                Ok((sum.is_nan() || sum.abs() >= 0.05).then(|| format!("{terms:?} is off by {sum:.2e}")))
            }
        }
    }
}

impl Angle {
    fn value(&self, instance: &mut Instance) -> Result<f64, String> {
        let mut value = self.shift;
        for (name, sign) in [(&self.plus, 1.0), (&self.minus, -1.0)] {
            if let Some(name) = name {
                value += sign * get(instance, name)?;
            }
        }
        Ok(value)
    }
}

pub struct Watch<'a> {
    laws: &'a [Law],
    signs: Vec<f64>,
    energy: f64,
    kinetic: f64,
    change: f64,
    pub residual: f64,
}

impl<'a> Watch<'a> {
    pub fn new(case: &'a Case, instance: &mut Instance) -> Result<Self, String> {
        let energy = get(instance, "energy.total")?;
        let signs = vec![0.0; case.laws.len()];
        let mut watch = Self { laws: &case.laws, signs, energy, kinetic: 0.0, change: 0.0, residual: 0.0 };
        watch.look(instance)?;
        Ok(watch)
    }

    pub fn drift(&self) -> f64 {
        if self.change == 0.0 { 0.0 } else { self.change / self.kinetic }
    }

    pub fn look(&mut self, instance: &mut Instance) -> Result<Option<String>, String> {
        let energy = get(instance, "energy.total")?;
        self.kinetic = self.kinetic.max(get(instance, "energy.kinetic")?);
        self.change = self.change.max((energy - self.energy).abs());
        self.residual = self.residual.max(get(instance, "constraint.position")?);
        if !(energy.is_finite() && self.residual.is_finite()) {
            return Ok(Some("not finite".into()));
        }
        for (law, sign) in self.laws.iter().zip(&mut self.signs) {
            let broken = law.is_broken(instance, sign)?;
            if broken.is_some() {
                return Ok(broken);
            }
        }
        Ok(None)
    }
}

pub fn get(instance: &mut Instance, name: &str) -> Result<f64, String> {
    let variable = instance.variable(name).ok_or_else(|| format!("no variable {name}"))?;
    instance.get(variable).map_err(|error| error.to_string())
}
