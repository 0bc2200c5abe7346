//! The request of a fit and its checks.

use cotree::compile::{QuantityError, quantity, with_units};
use cotree::diagnostic::suggest;
use cotree::model::Experiment;
use cotree::report::csv::CsvTable;
use thiserror::Error;

use super::LEAST;
use super::levenberg::Residuals;
use crate::analysis::{VariedQuantity, Varying};
use crate::request::{RequestFault, TooFew};

/// What is to be fitted to what.
#[derive(Clone, Debug)]
pub struct FitRequest {
    /// What was measured, a table for each experiment: columns named like outputs. Columns of one name have one standard deviation.
    pub tables: Vec<CsvTable>,
    /// What is varied.
    pub vary: Vec<Vary>,
    /// Standard deviations of columns, as far as they are known: a number (SI) or a number with its unit.
    pub deviations: Vec<(String, String)>,
}

/// A quantity that is varied: a parameter, a constant input or an initial value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vary {
    pub name: String,
    /// Its bounds, if not those of the scene: numbers (SI) or numbers with their unit.
    pub bounds: [Option<String>; 2],
}

/// Why a text names no quantity with its bounds.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct VaryError(pub String);

cotree::diagnostic::from_messages!(VaryError as VaryError: QuantityError);

impl Vary {
    /// Reads `name`, `name=low..high`, `name=low..` or `name=..high`; the unit of `high` is that of `low`, too, if that has none.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(text: &str) -> Result<Self, VaryError> {
        let Some((name, range)) = text.split_once('=') else {
            return Ok(Vary { name: text.trim().to_owned(), bounds: [None, None] });
        };
        let (low, high) =
            range.split_once("..").ok_or_else(|| VaryError("write the bounds as low..high".to_owned()))?;
        let given: Vec<&str> = [low, high].into_iter().filter(|text| !text.trim().is_empty()).collect();
        let mut given = with_units(&given)?.into_iter();
        let mut bound = |text: &str| if text.trim().is_empty() { None } else { given.next() };
        Ok(Vary { name: name.trim().to_owned(), bounds: [bound(low), bound(high)] })
    }
}

/// The same, checked.
#[derive(Debug)]
pub(super) struct Weighed {
    /// Of each quantity, SI.
    pub bounds: Vec<[f64; 2]>,
    pub tables: Vec<TablePlaces>,
    /// The standard deviation of each kind of column \[SI\], and whether it was given.
    pub deviations: Vec<(f64, bool)>,
    /// The extent of each kind, SI.
    extents: Vec<f64>,
}

/// Where the values of a table belong.
#[derive(Clone, Debug)]
pub(super) struct TablePlaces {
    /// The output of each column.
    pub outputs: Vec<usize>,
    /// Its kind: columns of one name are of one kind, in all experiments.
    pub kinds: Vec<usize>,
    /// Row and column of each value that was measured, row by row.
    pub measured: Vec<(usize, usize)>,
}

impl FitRequest {
    /// Everything that is wrong is said.
    pub(super) fn weighed(&self, experiments: &[(&Varying, Experiment)]) -> Result<Weighed, Vec<RequestFault>> {
        let Some((first, _)) = experiments.first() else {
            return Err(vec![RequestFault("nothing was measured".to_owned())]);
        };
        if experiments.len() != self.tables.len() {
            return Err(vec![RequestFault(format!(
                "{} experiments with {} tables",
                experiments.len(),
                self.tables.len()
            ))]);
        }
        let mut faults = Vec::new();
        let bounds = bounds(&self.vary, first.parameters(), &mut faults);
        let kinds = self.kinds();
        let mut tables = Vec::with_capacity(experiments.len());
        for (index, (table, (varying, experiment))) in self.tables.iter().zip(experiments).enumerate() {
            let mut outputs_used = Vec::new();
            let outputs = places(table, varying, &mut outputs_used);
            check_times(table, *experiment, &mut outputs_used);
            outputs_used.extend(differing(varying.parameters(), first.parameters()));
            let measured = measured(table);
            let empty =
                (0..table.names().len()).filter(|column| measured.iter().all(|(_, variable)| variable != column));
            outputs_used.extend(
                empty.map(|column| RequestFault(format!("the column `{}` has no value", table.names()[column]))),
            );
            let kind = |name: &String| kinds.iter().position(|kind| *kind == name).unwrap_or_default();
            tables.push(TablePlaces { outputs, kinds: table.names().iter().map(kind).collect(), measured });
            let several = |fault| match experiments.len() > 1 {
                true => RequestFault(format!("experiment {number}: {cause}", number = index + 1, cause = fault)),
                false => fault,
            };
            faults.extend(outputs_used.into_iter().map(several));
        }
        let (values, quantities) = (tables.iter().map(|table| table.measured.len()).sum(), self.vary.len());
        if !kinds.is_empty() {
            faults.extend(too_few(values, quantities).map(RequestFault::from));
        }
        let extents: Vec<f64> = kinds.iter().map(|kind| self.extent(kind)).collect();
        let mut deviations: Vec<(f64, bool)> = extents.iter().map(|&extent| (extent, false)).collect();
        for (name, text) in &self.deviations {
            match deviation(&kinds, experiments, name, text) {
                Ok((kind, deviation)) => deviations[kind] = (deviation, true),
                Err(fault) => faults.push(fault),
            }
        }
        if faults.is_empty() { Ok(Weighed { bounds, tables, deviations, extents }) } else { Err(faults) }
    }

    /// The names of all columns, each once.
    fn kinds(&self) -> Vec<&String> {
        let mut kinds: Vec<&String> = Vec::new();
        for name in self.tables.iter().flat_map(CsvTable::names) {
            if !kinds.contains(&name) {
                kinds.push(name);
            }
        }
        kinds
    }

    /// How far apart the values of a name are.
    fn extent(&self, kind: &str) -> f64 {
        let column = |table: &CsvTable| {
            let place = table.names().iter().position(|name| name == kind);
            place.map_or_else(Vec::new, |place| table.column(place).to_vec())
        };
        extent(&self.tables.iter().flat_map(column).collect::<Vec<f64>>())
    }
}

/// What is varied is the same in all experiments: none may set it otherwise.
fn differing(parameters: &[VariedQuantity], first: &[VariedQuantity]) -> Vec<RequestFault> {
    let differs = parameters.iter().zip(first).filter(|(varied, first)| varied.start != first.start);
    let fault = |(varied, first): (&VariedQuantity, &VariedQuantity)| {
        RequestFault(format!(
            "`{name}` is varied, but set to {here:?} {unit} here and to {first:?} {unit} in the first one",
            name = varied.name,
            here = varied.start,
            unit = varied.unit.si,
            first = first.start
        ))
    };
    differs.map(fault).collect()
}

/// The kind of a column, and its standard deviation.
fn deviation(
    kinds: &[&String],
    experiments: &[(&Varying, Experiment)],
    name: &str,
    text: &str,
) -> Result<(usize, f64), RequestFault> {
    let (name, text) = (name.to_owned(), text.to_owned());
    let Some(kind) = kinds.iter().position(|kind| **kind == name) else {
        let known = suggest::known(&name, kinds.iter().map(|kind| kind.as_str()));
        return Err(RequestFault(format!("there is no column `{name}`; {known}")));
    };
    let mut outputs = experiments.iter().flat_map(|(varying, _)| varying.outputs());
    let unit = outputs.find(|(output, _)| *output == name).map(|(_, unit)| unit.clone()).unwrap_or_default();
    match quantity(&text, &unit) {
        Ok(value) if value > 0.0 && value.is_finite() => Ok((kind, value)),
        Ok(_) => Err(RequestFault(format!("`{name}={text}`: a standard deviation must be positive"))),
        Err(cause) => Err(RequestFault(format!("`{name}={text}`: {cause}"))),
    }
}

/// The bounds of what is varied, SI: those that are asked for, else those of the scene.
pub(crate) fn bounds(varied: &[Vary], parameters: &[VariedQuantity], faults: &mut Vec<RequestFault>) -> Vec<[f64; 2]> {
    if varied.is_empty() {
        faults.push(RequestFault("nothing is varied".to_owned()));
    }
    let mut bounds = Vec::with_capacity(parameters.len());
    for (index, (vary, parameter)) in varied.iter().zip(parameters).enumerate() {
        if varied[..index].iter().any(|other| other.name == vary.name) {
            faults.push(RequestFault(format!("`{}` is varied twice", vary.name)));
        }
        let mut range =
            [parameter.bounds[0].unwrap_or(f64::NEG_INFINITY), parameter.bounds[1].unwrap_or(f64::INFINITY)];
        for (place, text) in vary.bounds.iter().enumerate() {
            let Some(text) = text else { continue };
            let (name, text) = (vary.name.clone(), text.clone());
            match quantity(&text, &parameter.unit).map(|value| (value, parameter.unit.permit(value, parameter.bounds)))
            {
                Ok((value, Ok(()))) => range[place] = value,
                Ok((_, Err(cause))) => faults.push(RequestFault(format!("`{name}={text}`: {cause}"))),
                Err(cause) => faults.push(RequestFault(format!("`{name}={text}`: {cause}"))),
            }
        }
        let ([low, high], start) = (range, parameter.start);
        let (name, unit) = (vary.name.clone(), parameter.unit.si.clone());
        if low >= high {
            faults.push(RequestFault(format!("`{name}`: {low:?} {unit} is not below {high:?} {unit}")));
        } else if !(low..=high).contains(&start) {
            faults.push(RequestFault(format!(
                "`{name}` starts at {start:?} {unit}, outside {low:?}..{high:?} {unit}; set it"
            )));
        }
        bounds.push(range);
    }
    bounds
}

/// The output of each column of a table.
pub(crate) fn places(table: &CsvTable, varying: &Varying, faults: &mut Vec<RequestFault>) -> Vec<usize> {
    if table.names().is_empty() {
        faults.push(RequestFault("the table has no column but `time`".to_owned()));
    }
    let mut places = Vec::new();
    for (name, unit) in table.names().iter().zip(table.units()) {
        let Some((place, (_, name_of_output))) =
            varying.outputs().enumerate().find(|(_, (name_of_output, _))| name_of_output == name)
        else {
            let known = suggest::known(name, varying.outputs().map(|(name_of_output, _)| name_of_output));
            faults.push(RequestFault(format!("the column `{column}` is not an output; {known}", column = name)));
            continue;
        };
        if let Some(unit) =
            unit.as_ref().filter(|unit| !name_of_output.si.is_empty() && !unit.is_compatible(name_of_output))
        {
            let (column, unit, si) = (name.clone(), unit.shown().to_owned(), name_of_output.si.clone());
            faults.push(RequestFault(format!("the column `{column}` is in `{unit}`, but the variable in `{si}`")));
        }
        places.push(place);
    }
    places
}

/// Are all times of a table within the experiment?
pub(crate) fn check_times(
    table: &CsvTable,
    Experiment { start, stop, .. }: Experiment,
    faults: &mut Vec<RequestFault>,
) {
    let outside = |time: &&f64| !(start..=stop).contains(*time);
    let times = table.times();
    if let Some(&first) = times.iter().find(outside) {
        let (count, all) = (times.iter().filter(outside).count(), times.len());
        faults.push(RequestFault(format!("{count} of {all} times, the first {first:?} s, are outside the experiment, {start:?} s to {stop:?} s; remove these rows, or change the times of the experiment")));
    }
}

impl Weighed {
    /// Estimates the standard deviations that were not given from the residuals, with the kind of each; the largest change, as a share.
    pub fn estimate(&mut self, (residuals, kinds): (&Residuals, &[usize]), quantities: usize) -> f64 {
        let all = kinds.len();
        let mut change: f64 = 0.0;
        for (kind, (deviation, is_given)) in self.deviations.iter_mut().enumerate() {
            if *is_given {
                continue;
            }
            let of_kind = residuals.values.iter().zip(kinds).filter(|(_, of_value)| **of_value == kind);
            let (count, squares) = of_kind.fold((0, 0.0), |(count, sum), (value, _)| (count + 1, sum + value * value));
            if count == 0 {
                continue;
            }
            let degrees = f64::from(count) * (1.0 - quantities as f64 / all as f64);
            let estimated = (squares / degrees).sqrt().max(LEAST * self.extents[kind]);
            change = change.max((estimated / *deviation - 1.0).abs());
            *deviation = estimated;
        }
        change
    }
}

/// Row and column of each value that was measured, row by row.
fn measured(table: &CsvTable) -> Vec<(usize, usize)> {
    let places = (0..table.times().len()).flat_map(|row| (0..table.names().len()).map(move |column| (row, column)));
    places.filter(|&(row, column)| !table.column(column)[row].is_nan()).collect()
}

/// Says that measured values are too few, if they are.
pub(super) fn too_few(values: usize, quantities: usize) -> Option<TooFew> {
    (values <= quantities).then_some(TooFew { values, quantities })
}

/// How far apart values are; their size if they are all the same.
fn extent(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), &value| (low.min(value), high.max(value)));
    [high - low, high.abs(), 1.0].into_iter().find(|size| *size > 0.0 && size.is_finite()).unwrap_or(1.0)
}
