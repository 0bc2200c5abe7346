//! The factors of a sweep and their values.

use cotree::compile::{QuantityError, both, quantities, quantity};
use cotree::export::description::Description;
use cotree::model::Unit;
use cotree::run::{SettingError, settings};
use thiserror::Error;

/// Why a text is no factor with its values.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct FactorError(pub String);

cotree::diagnostic::from_messages!(FactorError as FactorError: SettingError, QuantityError);

/// A parameter, constant input or initial value that is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignFactor {
    /// Index of the variable.
    pub variable: usize,
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Its values, SI.
    pub values: FactorValues,
}

/// The values of a factor, SI.
#[derive(Clone, Debug, PartialEq)]
pub enum FactorValues {
    /// These.
    Levels(Vec<f64>),
    /// Between two bounds, each as likely.
    Uniform(f64, f64),
    /// Normal, by mean and standard deviation.
    Normal(f64, f64),
}

/// More levels than this are a mistake.
const MOST_LEVELS: usize = 10_000_000;

impl DesignFactor {
    /// Reads `name=values`: `1,1.2`, `0.4..0.6:21` (so many, both ends among them), `0.4..0.6` (any between), `0.5+-0.01` (any within), `0.5~0.01` (normal); tolerances may be
    /// shares, as in `0.5+-2%`. Numbers may have units: `"400..600 mm:21"`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(description: &Description, text: &str) -> Result<Self, FactorError> {
        let (name, values) = text.split_once('=').ok_or_else(|| FactorError("write name=values".to_owned()))?;
        let variable = settings::settable(description, name.trim())?;
        let known = &description.variables[variable];
        let values = FactorValues::read(values.trim(), &known.unit)?;
        for value in values.bounds() {
            settings::permitted(known, value).map_err(|cause| SettingError::of_value(value, &cause))?;
        }
        Ok(DesignFactor { variable, name: known.name.clone(), unit: known.unit.si.clone(), values })
    }
}

impl FactorValues {
    fn read(text: &str, unit: &Unit) -> Result<Self, FactorError> {
        let number = |text: &str| Ok(quantity(text.trim(), unit)?);
        let both = |low: &str, high: &str| both(low, high, unit);
        let around = |mean: &str, within: &str| match share(within, || number(mean))? {
            Some([mean, within]) => Ok::<_, FactorError>([mean, within]),
            None => Ok(both(mean, within)?),
        };
        if let Some((mean, within)) = text.split_once("+-").or_else(|| text.split_once('±')) {
            let [mean, within] = around(mean, within)?;
            return ordered(mean - within, mean + within).map(|[low, high]| FactorValues::Uniform(low, high));
        }
        if let Some((mean, deviation)) = text.split_once('~') {
            let [mean, deviation] = around(mean, deviation)?;
            let positive = deviation > 0.0 && deviation.is_finite();
            return if positive {
                Ok(FactorValues::Normal(mean, deviation))
            } else {
                Err(FactorError("the deviation must be positive".to_owned()))
            };
        }
        let Some((low, rest)) = text.split_once("..") else {
            return Ok(FactorValues::Levels(quantities(&text.split(',').collect::<Vec<_>>(), unit)?));
        };
        match rest.rsplit_once(':') {
            None => {
                let [low, high] = both(low, rest)?;
                ordered(low, high).map(|[low, high]| FactorValues::Uniform(low, high))
            }
            Some((high, count)) => {
                let count = count.trim().parse::<usize>().ok().filter(|count| (1..=MOST_LEVELS).contains(count));
                let count = count.ok_or_else(|| {
                    FactorError(format!("the count after `:` is not between 1 and {most}", most = MOST_LEVELS))
                })?;
                let [low, high] = both(low, high)?;
                Ok(FactorValues::Levels(spaced(low, high, count)))
            }
        }
    }

    /// Values that must all be permitted for all to be; a normal distribution has no bounds.
    fn bounds(&self) -> Vec<f64> {
        match self {
            FactorValues::Levels(levels) => levels.clone(),
            FactorValues::Uniform(low, high) => vec![*low, *high],
            FactorValues::Normal(mean, _) => vec![*mean],
        }
    }
}

/// A mean and a tolerance such as `2 %` of it; none if it is no share.
fn share(text: &str, mean: impl Fn() -> Result<f64, FactorError>) -> Result<Option<[f64; 2]>, FactorError> {
    let Some(percent) = text.trim().strip_suffix('%') else { return Ok(None) };
    let mean = mean()?;
    let number = percent.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let number = number.ok_or_else(|| FactorError(format!("`{}` is not a percentage", text.trim())))?;
    Ok(Some([mean, 0.01 * number * mean.abs()]))
}

fn ordered(low: f64, high: f64) -> Result<[f64; 2], FactorError> {
    if low <= high { Ok([low, high]) } else { Err(FactorError(format!("{low:?} is above {high:?}"))) }
}

/// So many values, evenly spaced, the ends exact.
fn spaced(low: f64, high: f64, count: usize) -> Vec<f64> {
    let last = count.max(2) - 1;
    let value = |index: usize| match index {
        0 => low,
        index if index == last => high,
        index => low + (high - low) * (index as f64 / last as f64),
    };
    (0..count).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<FactorValues, FactorError> {
        FactorValues::read(text, &Unit::length())
    }

    #[test]
    fn values_are_written_in_five_ways() {
        assert_eq!(values("1, 1.2"), Ok(FactorValues::Levels(vec![1.0, 1.2])));
        assert_eq!(values("0.4..0.6:3"), Ok(FactorValues::Levels(vec![0.4, 0.5, 0.6])));
        assert_eq!(values("400 mm .. 0.6 m : 2"), Ok(FactorValues::Levels(vec![0.4, 0.6])));
        assert_eq!(values("2..1:2"), Ok(FactorValues::Levels(vec![2.0, 1.0])));
        assert_eq!(values("7..9:1"), Ok(FactorValues::Levels(vec![7.0])));
        assert_eq!(values("-1..-0.5"), Ok(FactorValues::Uniform(-1.0, -0.5)));
        assert_eq!(values("500 mm +- 125 mm"), Ok(FactorValues::Uniform(0.375, 0.625)));
        assert_eq!(values("0.5 m~10 mm"), Ok(FactorValues::Normal(0.5, 0.01)));
        assert_eq!(values("-500 mm +- 25 %"), Ok(FactorValues::Uniform(-0.625, -0.375)));
        assert_eq!(values("0.5 ~ 50%"), Ok(FactorValues::Normal(0.5, 0.25)));
    }

    #[test]
    fn the_last_unit_holds_for_all() {
        assert_eq!(values("180..220 mm:3"), Ok(FactorValues::Levels(vec![0.18, 0.2, 0.22])));
        assert_eq!(values("180,200,220 mm"), Ok(FactorValues::Levels(vec![0.18, 0.2, 0.22])));
        assert_eq!(values("180 mm, 200, 0.22 mm"), Ok(FactorValues::Levels(vec![0.18, 0.2, 0.000_22])));
        assert_eq!(values("-10..10 mm"), Ok(FactorValues::Uniform(-0.01, 0.01)));
        assert_eq!(values("500+-125 mm"), Ok(FactorValues::Uniform(0.375, 0.625)));
        assert_eq!(values("500~10 mm"), Ok(FactorValues::Normal(0.5, 0.01)));
        let number = |text: &str| FactorValues::read(text, &Unit::default());
        assert_eq!(number("1..2 mm:2"), Ok(FactorValues::Levels(vec![0.001, 0.002])));
        assert!(number("1 deg..2 mm:2").unwrap_err().to_string().contains("different kinds"));
        for unclear in ["180 mm..220:3", "180, 200 mm, 0.22 m", "180 mm,220"] {
            assert!(values(unclear).unwrap_err().to_string().contains("has no unit"), "{unclear}");
        }
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        for (text, message) in [
            ("1,", "not a number"),
            ("1..2:0", "count"),
            ("1..2:x", "count"),
            ("2..1", "above"),
            ("1~0", "must be positive"),
            ("1+-x%", "percent"),
            ("1~-2%", "must be positive"),
            ("1 kg", "not in m"),
            ("", "not a number"),
        ] {
            let error = values(text).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
