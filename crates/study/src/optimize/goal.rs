//! Objective and constraints: weighted sums of measures, as written in the request.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use cotree::run::{Measure, Statistic};

use crate::request::{GoalError, LimitError};

/// A sum of measures with their weights, such as `peak(drive.torque) + 0.1*rms(ram.fn)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    pub terms: Vec<(f64, Measure)>,
}

/// What a sum of measures has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    AtMost,
    AtLeast,
    Equal,
}

/// A condition such as `range(ram.s) = 120 mm`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasureLimit {
    pub goal: Goal,
    pub relation: Relation,
    /// The number with its unit, as it is written.
    pub bound: String,
}

/// How conditions are written: longer signs first.
const RELATIONS: [(&str, Relation); 5] = [
    ("<=", Relation::AtMost),
    (">=", Relation::AtLeast),
    ("≤", Relation::AtMost),
    ("≥", Relation::AtLeast),
    ("=", Relation::Equal),
];

impl Goal {
    /// The same with the opposite sign: what is made large.
    #[must_use]
    pub fn negative(self) -> Goal {
        Goal { terms: self.terms.into_iter().map(|(weight, measure)| (-weight, measure)).collect() }
    }
}

impl FromStr for Goal {
    type Err = GoalError;

    fn from_str(text: &str) -> Result<Self, GoalError> {
        let terms = split(text).into_iter().map(|(sign, text)| term(sign, text)).collect::<Result<_, _>>()?;
        Ok(Goal { terms })
    }
}

/// The terms of a sum, each with its sign.
fn split(text: &str) -> Vec<(f64, &str)> {
    let (mut terms, mut depth, mut begin, mut sign) = (Vec::new(), 0, 0, 1.0);
    for (place, letter) in text.char_indices() {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            '+' | '-' if depth == 0 => {
                let before = text[begin..place].trim();
                // The sign of an exponent, as in `1e-3*max(x)`, is no sign of a term.
                let is_exponent = before.strip_suffix(['e', 'E']).is_some_and(|number| number.parse::<f64>().is_ok());
                if is_exponent {
                    continue;
                }
                if !before.is_empty() || begin > 0 {
                    terms.push((sign, before));
                }
                (begin, sign) = (place + 1, if letter == '-' { -1.0 } else { 1.0 });
            }
            _ => {}
        }
    }
    terms.push((sign, text[begin..].trim()));
    terms
}

/// `weight*measure`, or a measure alone.
fn term(sign: f64, text: &str) -> Result<(f64, Measure), GoalError> {
    let (weight, measure) = match text.split_once('*') {
        None => (1.0, text),
        Some((weight, measure)) => {
            let number = weight.trim().parse::<f64>().ok().filter(|number| number.is_finite() && *number != 0.0);
            (
                number.ok_or_else(|| GoalError(format!("`{}` is not a weight: write a number", weight.trim())))?,
                measure.trim(),
            )
        }
    };
    if measure.is_empty() {
        return Err(GoalError("a measure is missing, such as peak(motor.torque)".to_owned()));
    }
    let measure: Measure = measure.parse()?;
    match measure.statistic() {
        Statistic::WhenMax | Statistic::WhenMin => Err(GoalError(format!(
            "`{0}` is discontinuous where another extreme becomes the largest, and cannot be optimized",
            measure
        ))),
        Statistic::Max
        | Statistic::Min
        | Statistic::Peak
        | Statistic::Range
        | Statistic::Mean
        | Statistic::RootMeanSquare
        | Statistic::First
        | Statistic::Last => Ok((sign * weight, measure)),
    }
}

impl Display for Goal {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for (place, (weight, measure)) in self.terms.iter().enumerate() {
            let sign = match (place, *weight < 0.0) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            match weight.abs() == 1.0 {
                true => write!(f, "{sign}{measure}")?,
                false => write!(f, "{sign}{:?}*{measure}", weight.abs())?,
            }
        }
        Ok(())
    }
}

impl FromStr for MeasureLimit {
    type Err = LimitError;

    fn from_str(text: &str) -> Result<Self, LimitError> {
        let found = RELATIONS.iter().find_map(|(sign, relation)| Some((text.split_once(sign)?, *relation)));
        let Some(((goal, bound), relation)) = found else {
            return Err(LimitError("write a condition such as \"max(ram.s) <= 120 mm\", with <=, >= or =".to_owned()));
        };
        let bound = bound.trim().to_owned();
        if bound.is_empty() {
            return Err(LimitError("the number after the sign is missing".to_owned()));
        }
        Ok(MeasureLimit { goal: goal.parse()?, relation, bound })
    }
}

impl Display for MeasureLimit {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let sign = match self.relation {
            Relation::AtMost => "<=",
            Relation::AtLeast => ">=",
            Relation::Equal => "=",
        };
        write!(f, "{} {sign} {}", self.goal, self.bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_read_as_they_are_written() {
        for (text, shown) in [
            ("peak(a.torque)", "peak(a.torque)"),
            ("-min(x) + 2*rms( y )", "-min(x) + 2.0*rms(y)"),
            ("1e-3*max(x)-y", "0.001*max(x) - last(y)"),
            ("+ x", "last(x)"),
        ] {
            assert_eq!(text.parse::<Goal>().unwrap().to_string(), shown, "{text}");
        }
        let limit: MeasureLimit = "range(ram.s) = 120 mm".parse().unwrap();
        assert_eq!((limit.relation, &*limit.bound), (Relation::Equal, "120 mm"));
        assert_eq!("max(x) >= 2".parse::<MeasureLimit>().unwrap().relation, Relation::AtLeast);
        assert_eq!("-x <= -2".parse::<MeasureLimit>().unwrap().to_string(), "-last(x) <= -2");
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        for (text, message) in
            [("", "missing"), ("max(x) +", "missing"), ("q*max(x)", "not a weight"), ("0*x", "not a weight")]
        {
            let error = text.parse::<Goal>().unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
        assert!("when_max(x)".parse::<Goal>().unwrap_err().to_string().contains("discontinuous"));
        assert!("max(x) 3".parse::<MeasureLimit>().unwrap_err().to_string().contains("<="));
        assert!("max(x) <=".parse::<MeasureLimit>().unwrap_err().to_string().contains("missing"));
    }
}
