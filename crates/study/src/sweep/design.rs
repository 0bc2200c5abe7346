//! Which runs are made: all combinations of levels, random ones, or those of a table.

use cotree::export::description::Description;
use cotree::run::Settings;

use cotree::sheet::SheetError;
use thiserror::Error;

use super::factor::{DesignFactor, FactorError, FactorValues};
use super::sample::{Draw, Sampling};
use super::table;

/// Why runs cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct DesignError(pub String);

cotree::diagnostic::from_messages!(DesignError as DesignError: SheetError, FactorError);

/// The runs of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    factors: Vec<DesignFactor>,
    runs: Runs,
}

#[derive(Clone, Debug, PartialEq)]
enum Runs {
    /// All combinations of the levels, the last factor fastest; so many.
    Grid(usize),
    /// A column for each factor, so many rows.
    Columns(Vec<Vec<f64>>, usize),
    /// Drawn at random, each factor by itself; so many, by kind and seed.
    Drawn { draws: Vec<Draw>, count: usize, kind: Sampling, seed: u64 },
}

/// More runs than this are a mistake: numbers of runs have 32 bits where addresses have.
const MOST_RUNS: usize = 4_000_000_000;

fn too_many() -> DesignError {
    DesignError(format!("there are more than {MOST_RUNS} runs"))
}

impl Design {
    /// All combinations.
    ///
    /// # Errors
    /// A factor has no levels but a range, is there twice, or there are too many combinations.
    pub fn grid(factors: Vec<DesignFactor>) -> Result<Self, DesignError> {
        different(&factors)?;
        let mut count: usize = 1;
        for DesignFactor { name, values, .. } in &factors {
            let FactorValues::Levels(levels) = values else {
                return Err(DesignError(format!(
                    "`{name}` has a range but no values: give a count, as in 0.4..0.6:21, or draw runs at random"
                )));
            };
            count = count.checked_mul(levels.len()).filter(|count| *count <= MOST_RUNS).ok_or_else(too_many)?;
        }
        Ok(Design { factors, runs: Runs::Grid(count) })
    }

    /// So many random combinations.
    ///
    /// # Errors
    /// A factor is there twice, or there are no runs or too many.
    pub fn random(factors: Vec<DesignFactor>, kind: Sampling, count: usize, seed: u64) -> Result<Self, DesignError> {
        different(&factors)?;
        if !(1..=MOST_RUNS).contains(&count) {
            let none = || DesignError("the number of runs is 0, but must be at least 1".to_owned());
            return Err(if count == 0 { none() } else { too_many() });
        }
        let draws = (0..factors.len()).map(|place| Draw::new(kind, count, seed, place)).collect();
        Ok(Design { factors, runs: Runs::Drawn { draws, count, kind, seed } })
    }

    /// The rows of a CSV table whose first line names the factors, with units if wanted; values may have units of their own. `constant` factors have one level each.
    ///
    /// # Errors
    /// Everything that is wrong with the table, with its lines.
    pub fn table(description: &Description, text: &str, constant: Vec<DesignFactor>) -> Result<Self, Vec<DesignError>> {
        let (mut factors, mut columns) = table::columns(description, text)?;
        let count = columns.first().map_or(0, Vec::len);
        for factor in constant {
            match &factor.values {
                FactorValues::Levels(levels) if levels.len() == 1 => columns.push(vec![levels[0]; count]),
                _ => {
                    return Err(vec![DesignError(format!(
                        "with a table `{name}` can have one value only",
                        name = factor.name
                    ))]);
                }
            }
            factors.push(factor);
        }
        different(&factors).map_err(|error| vec![error])?;
        Ok(Design { factors, runs: Runs::Columns(columns, count) })
    }

    pub fn factors(&self) -> &[DesignFactor] {
        &self.factors
    }

    /// How many runs there are.
    #[expect(clippy::len_without_is_empty, reason = "a design without runs is one like any other")]
    pub fn len(&self) -> usize {
        match self.runs {
            Runs::Grid(count) | Runs::Columns(_, count) | Runs::Drawn { count, .. } => count,
        }
    }

    /// Are all combinations of its levels made?
    pub fn is_grid(&self) -> bool {
        matches!(self.runs, Runs::Grid(_))
    }

    /// How many levels each factor of a grid has.
    pub fn shape(&self) -> Option<Vec<usize>> {
        let levels = |factor: &DesignFactor| match &factor.values {
            FactorValues::Levels(levels) => levels.len(),
            FactorValues::Uniform(..) | FactorValues::Normal(..) => 1,
        };
        self.is_grid().then(|| self.factors.iter().map(levels).collect())
    }

    /// Are the runs drawn at random?
    pub fn is_drawn(&self) -> bool {
        matches!(self.runs, Runs::Drawn { .. })
    }

    /// Which factors have more than one value.
    pub fn varied(&self) -> Vec<usize> {
        let varies = |values: &[f64]| values.iter().any(|value| *value != values[0]);
        let is_varied = |&index: &usize| match (&self.runs, &self.factors[index].values) {
            (Runs::Columns(columns, _), _) => varies(&columns[index]),
            (Runs::Grid(_) | Runs::Drawn { .. }, FactorValues::Levels(levels)) => varies(levels),
            (Runs::Grid(_) | Runs::Drawn { .. }, FactorValues::Uniform(low, high)) => low != high,
            (Runs::Grid(_) | Runs::Drawn { .. }, FactorValues::Normal(_, deviation)) => *deviation != 0.0,
        };
        (0..self.factors.len()).filter(is_varied).collect()
    }

    /// The values of a run, one for each factor, SI.
    pub fn values(&self, run: usize) -> Vec<f64> {
        match &self.runs {
            Runs::Grid(_) => {}
            Runs::Columns(columns, _) => return columns.iter().map(|column| column[run]).collect(),
            Runs::Drawn { draws, .. } => {
                return draws.iter().zip(&self.factors).map(|(draw, factor)| draw.value(&factor.values, run)).collect();
            }
        }
        let mut rest = run;
        let mut values: Vec<f64> = Vec::with_capacity(self.factors.len());
        for factor in self.factors.iter().rev() {
            let FactorValues::Levels(levels) = &factor.values else { continue };
            values.push(levels[rest % levels.len()]);
            rest /= levels.len();
        }
        values.reverse();
        values
    }

    /// A digest of what the values of all runs follow from.
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::default();
        for DesignFactor { variable, values, .. } in &self.factors {
            digest.add(&variable.to_le_bytes());
            match values {
                FactorValues::Levels(levels) => levels.iter().for_each(|level| digest.number(*level)),
                FactorValues::Uniform(one, other) | FactorValues::Normal(one, other) => {
                    digest.add(if matches!(values, FactorValues::Normal(..)) { b"~" } else { b".." });
                    [one, other].into_iter().for_each(|value| digest.number(*value));
                }
            }
            digest.add(b";");
        }
        match &self.runs {
            Runs::Grid(_) => {}
            Runs::Columns(columns, _) => columns.iter().flatten().for_each(|value| digest.number(*value)),
            Runs::Drawn { kind, seed, count, .. } => {
                digest.add(if *kind == Sampling::Latin { b"latin" } else { b"random" });
                digest.add(&seed.to_le_bytes());
                digest.add(&count.to_le_bytes());
            }
        }
        digest.0
    }

    /// The same as settings of a run.
    pub fn settings(&self, run: usize) -> Settings {
        self.factors.iter().map(|factor| factor.variable).zip(self.values(run)).collect()
    }
}

/// FNV-1a of 64 bits (Fowler, Noll and Vo 1991).
#[derive(Clone, Copy, Debug)]
pub(super) struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Digest(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    pub fn add(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |digest, byte| (digest ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    }

    fn number(&mut self, value: f64) {
        self.add(&value.to_bits().to_le_bytes());
    }
}

fn different(factors: &[DesignFactor]) -> Result<(), DesignError> {
    let again = |(index, factor): (usize, &DesignFactor)| {
        factors[..index].iter().any(|other| other.variable == factor.variable)
    };
    match factors.iter().enumerate().find(|&place| again(place)) {
        Some((_, factor)) => Err(DesignError(format!("`{name}` is given twice", name = factor.name))),
        None => Ok(()),
    }
}
