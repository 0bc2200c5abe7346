//! From a scene to its program, its description and its FMU.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use cotree_fmu::program::Program;
use cotree_fmu::program::check::ProgramError;

use crate::diagnostic::suggest;
use crate::export::archive::{self, Extra, Package};
use crate::export::describe::describe;
use crate::export::description::Description;
use crate::export::runtime::Runtime;
use crate::export::scene_text::SceneText;
use crate::export::{ExportError, FmiVersion};
use crate::expr::Property;
use crate::formulate::{Formulated, LackingOutput, formulate, lacking, undetermined};
use crate::model::Unit;
use crate::report::figures::summarise;
use crate::report::summary::Summary;
use crate::scene::unit::UnitError;
use crate::scene::{Fault, Faults, QuantityReading, Requested, Resolved, Scene, Severity, Source, Span, Text, read};

/// A scene, compiled.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// What the runtime runs.
    pub program: Program,
    /// The description for importers; the same variables in the same order as in the program.
    pub description: Description,
    /// What is odd but no error.
    pub warnings: Option<Faults>,
    /// The text that the scene came from; empty if it was built in Rust.
    pub source: Source,
}

/// Formulates the equations of a scene and lowers them.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn compile(scene: &Scene) -> Result<Compiled, Faults> {
    compile_with_equations(scene).map(|(compiled, _)| compiled)
}

/// As [`compile`], with the equations.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn compile_with_equations(scene: &Scene) -> Result<(Compiled, Formulated), Faults> {
    compile_asking(scene, &Requested::Own)
}

/// As [`compile_with_equations`], with the outputs that are asked for.
///
/// # Errors
/// Everything that is wrong with the scene; an output that it does not have.
pub fn compile_asking(scene: &Scene, requested: &Requested) -> Result<(Compiled, Formulated), Faults> {
    compile_resolved(scene.resolve_asking(requested)?, &scene.source)
}

/// As [`compile_with_equations`], of a mechanism that may have been changed since it was resolved from this source.
///
/// # Errors
/// Everything that is wrong with it.
pub fn compile_resolved(mut resolved: Resolved, source: &Source) -> Result<(Compiled, Formulated), Faults> {
    // Other values than those of the scene may make a part impossible.
    let impossible_parts: Vec<Fault> =
        resolved.mechanism.check().into_iter().filter(|fault| fault.severity == Severity::Error).collect();
    if !impossible_parts.is_empty() {
        return Err(resolved.refused(source, impossible_parts));
    }
    let mut formulated =
        formulate(&resolved.mechanism, &resolved.outputs).map_err(|errors| resolved.refused(source, errors))?;
    resolved.warnings.append(&mut formulated.warnings);
    let mut program = formulated.lowered.program.clone();
    let bytes = program.to_bytes().map_err(|error| resolved.refused(source, vec![internal(&error.to_string())]))?;
    program.guid = guid(&bytes);
    program.check().map_err(|fault| resolved.refused(source, vec![impossible(&fault)]))?;
    let warnings = resolved.warnings;
    let compiled = Compiled {
        description: describe(&formulated, &program.guid),
        warnings: (!warnings.is_empty()).then(|| Faults::new(source.clone(), warnings)),
        source: source.clone(),
        program,
    };
    Ok((compiled, formulated))
}

/// The names of all outputs of a scene and of every variable that can be computed, and warnings that say which cannot, and why.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn everything(scene: &Scene) -> Result<(Vec<String>, Vec<Fault>), Faults> {
    let Resolved { mechanism, outputs, .. } = scene.resolve_asking(&Requested::Everything)?;
    let is_own = |name: &str| scene.outputs.variables.iter().any(|variable| variable.text == name);
    let lacking = lacking(&mechanism, &outputs).map_err(|list| Faults::new(scene.source.clone(), list))?;
    let mut left_out: BTreeMap<(usize, Property), Vec<&str>> = BTreeMap::new();
    for LackingOutput { output, body, property } in lacking {
        if !is_own(&output.name) {
            left_out.entry((body, property)).or_default().push(&output.name);
        }
    }
    let undetermined = undetermined(&mechanism).map_err(|list| Faults::new(scene.source.clone(), list))?;
    let undetermined: Vec<String> = undetermined
        .into_iter()
        .map(|variable| mechanism.variable_name(variable))
        .filter(|name| !is_own(name))
        .collect();
    let missing: HashSet<&str> =
        left_out.values().flatten().copied().chain(undetermined.iter().map(String::as_str)).collect();
    let names = outputs.iter().map(|output| output.name.as_str()).filter(|name| !missing.contains(name));
    let names = names.map(str::to_owned).collect();
    let warnings = left_out.iter().map(|(&(body, property), names)| {
        let key = if property == Property::Mass { "mass" } else { "inertia" };
        let owner = &mechanism.bodies[body];
        let message = format!(
            "left out, because body `{}` has no `{key}`: {}",
            owner.name,
            suggest::joined(names, suggest::MOST)
        );
        Fault::warning("scene::left_out", message, owner.span)
            .label(format!("has no `{key}`"))
            .help(format!("add `{key} = ...` to `[bodies.{}]` if you want them", owner.name))
    });
    let warnings = warnings.collect();
    Ok((names, warnings))
}

/// A name for these very bytes: their 128-bit FNV-1a hash, written as a GUID.
fn guid(bytes: &[u8]) -> String {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let hash = bytes.iter().fold(OFFSET, |hash, &byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME));
    let digits = format!("{hash:032x}");
    let parts = [&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]];
    format!("{{{}}}", parts.join("-"))
}

/// What the runtime would refuse.
fn impossible(error: &ProgramError) -> Fault {
    let ProgramError::Value { what } = error else {
        return internal(&error.to_string());
    };
    let message = format!("{what} is not finite: values of this scene are too large or too small for double precision");
    Fault::new("scene::out_of_range", message, Span::default())
        .help("check the units and powers of ten of masses, inertias, lengths and stiffnesses")
}

/// Something that no scene should be able to cause.
fn internal(what: &str) -> Fault {
    Fault::internal(format!("the program cannot be written: {what}"))
}

/// Why a text is no value of a variable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct QuantityError(pub String);

impl From<Fault> for QuantityError {
    fn from(fault: Fault) -> Self {
        QuantityError(fault.message)
    }
}

/// Reads a number, alone (SI) or with a unit, for a variable of the given unit; the empty unit takes any.
///
/// # Errors
/// What is wrong with the text.
pub fn quantity(text: &str, unit: &Unit) -> Result<f64, QuantityError> {
    let reading = read(&Text::from(text))?;
    match reading {
        QuantityReading::Number(value) => Ok(value),
        QuantityReading::Measure(value, given) if given.exponents == unit.exponents || unit.si.is_empty() => Ok(value),
        QuantityReading::Measure(..) => {
            Err(QuantityError(format!("`{text}` is not in {si} or a unit of the same kind", si = unit.si)))
        }
        QuantityReading::Expression => Err(QuantityError(format!("`{text}` is not a number, alone or with a unit"))),
    }
}

/// Numbers that are written together, such as the ends of a range or the items of a list: `180`, `200`, `220 mm`.
///
/// # Errors
/// One cannot be read or is of another kind, or it is not clear which unit it has.
pub fn quantities(texts: &[&str], unit: &Unit) -> Result<Vec<f64>, QuantityError> {
    // What has a unit of the wrong kind is said first.
    texts.iter().try_for_each(|text| quantity(text.trim(), unit).map(drop))?;
    with_units(texts)?.iter().map(|text| quantity(text, unit)).collect()
}

/// Two of them.
///
/// # Errors
/// As above.
pub fn both(low: &str, high: &str, unit: &Unit) -> Result<[f64; 2], QuantityError> {
    quantities(&[low, high], unit)?.try_into().map_err(|_| QuantityError("must be two numbers".to_owned()))
}

/// The same numbers, each with its unit: those that have none have that of the last.
///
/// # Errors
/// Their units are of different kinds, or it is not clear which unit a number has.
pub fn with_units(texts: &[&str]) -> Result<Vec<String>, QuantityError> {
    let texts: Vec<&str> = texts.iter().map(|text| text.trim()).collect();
    let units: Vec<Option<Unit>> = texts.iter().map(|text| unit_of(text)).collect::<Result<_, _>>()?;
    let known: Vec<(&str, &Unit)> =
        texts.iter().zip(&units).filter_map(|(text, unit)| Some((*text, unit.as_ref()?))).collect();
    let Some((last, unit)) = known.last() else { return Ok(texts.into_iter().map(str::to_owned).collect()) };
    if let Some((other, _)) = known.iter().find(|(_, other)| other.exponents != unit.exponents) {
        return Err(QuantityError(format!("`{other}` and `{last}` are of different kinds")));
    }
    let is_last = units.last().is_some_and(Option::is_some);
    let is_clear = is_last && known.iter().all(|(_, other)| other.display == unit.display);
    let named = |(text, with_unit): (&&str, &Option<Unit>)| match with_unit {
        None if text.parse::<f64>().is_err() => Ok((*text).to_owned()), // no number
        None if is_clear => Ok(format!("{text} {}", unit.shown())),
        None => Err(QuantityError(format!(
            "`{text}` has no unit, but `{last}` has one: write a unit after each number, or one after the last",
            text = (*text),
            last = (*last)
        ))),
        Some(_) => Ok((*text).to_owned()),
    };
    texts.iter().zip(&units).map(named).collect()
}

/// The unit that a number is written with.
fn unit_of(text: &str) -> Result<Option<Unit>, QuantityError> {
    match read(&Text::from(text))? {
        QuantityReading::Measure(_, unit) => Ok(Some(unit)),
        QuantityReading::Number(_) | QuantityReading::Expression => Ok(None),
    }
}

/// A unit that is given on the command line.
///
/// # Errors
/// It is none.
pub fn unit(text: &str) -> Result<Unit, UnitError> {
    crate::scene::unit::parse(&Text::from(text)).map_err(|fault| UnitError(Box::new(fault)))
}

impl Scene {
    /// Writes the scene as a self-contained FMU for the platform that this program runs on. It has no page and no pictures: those are of
    /// the command and the Python package.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or a file that cannot be written.
    pub fn export_fmu(&self, path: impl AsRef<Path>) -> Result<(), ExportFailure> {
        self.export_fmu_as(FmiVersion::V2, path)
    }

    /// The same in a version of FMI.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or a file that cannot be written.
    pub fn export_fmu_as(&self, version: FmiVersion, path: impl AsRef<Path>) -> Result<(), ExportFailure> {
        let runtime = Runtime::embedded().map_err(ExportError::from)?;
        Ok(compile(self)?.write_fmu(version, Vec::new(), &[runtime], path.as_ref())?)
    }

    /// The mechanism in figures and names, as `cotree show` prints it.
    ///
    /// # Errors
    /// Everything that is wrong with the scene.
    pub fn summary(&self) -> Result<Summary, Faults> {
        Ok(summarise(&compile_with_equations(self)?.1))
    }
}

/// Why there is no FMU.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ExportFailure(pub String);

crate::diagnostic::from_messages!(ExportFailure as ExportFailure: Faults, ExportError);

impl Compiled {
    /// Adds warnings.
    pub fn warn(&mut self, more: Vec<Fault>) {
        let known = self.warnings.take().into_iter().flat_map(|known| known.list);
        let all: Vec<Fault> = known.chain(more).collect();
        self.warnings = (!all.is_empty()).then(|| Faults::new(self.source.clone(), all));
    }

    /// Writes the FMU, for the platforms of the runtimes, with what it carries beside the model.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_fmu(
        &self,
        version: FmiVersion,
        extras: Vec<Extra>,
        runtimes: &[Runtime],
        path: &Path,
    ) -> Result<(), ExportError> {
        archive::write(&self.package(version, extras, runtimes, &self.program.to_bytes()?), path)
    }

    /// The bytes of that file.
    ///
    /// # Errors
    /// A description or a picture that cannot be written.
    pub fn pack_fmu(
        &self,
        version: FmiVersion,
        extras: Vec<Extra>,
        runtimes: &[Runtime],
    ) -> Result<Vec<u8>, ExportError> {
        archive::pack(&self.package(version, extras, runtimes, &self.program.to_bytes()?))
    }

    fn package<'a>(
        &'a self,
        version: FmiVersion,
        extras: Vec<Extra>,
        runtimes: &'a [Runtime],
        program: &'a [u8],
    ) -> Package<'a> {
        let is_json = self.source.own_text().trim_start().starts_with('{');
        let extension = if is_json { "json" } else { "toml" };
        Package {
            version,
            description: &self.description,
            program,
            scene: (!self.source.text.is_empty()).then_some(SceneText { extension, source: &self.source }),
            extras,
            runtimes,
        }
    }

    /// What a simulation reports: indices of variables of the description.
    pub fn reported(&self) -> Vec<usize> {
        self.description.reported()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metre() -> Unit {
        Unit::length()
    }

    #[test]
    fn masses_beyond_all_bounds_are_faults_of_the_scene() {
        let text = include_str!("../models/slider_crank/scene.toml").replace("mass = 3.0", "mass = 1e308");
        let faults = compile(&Scene::from_toml(&text).unwrap()).unwrap_err().to_json().to_string();
        assert!(faults.contains("scene::out_of_range") && faults.contains("powers of ten"), "{faults}");
    }

    #[test]
    fn quantities_are_numbers_with_the_right_unit() {
        assert_eq!(quantity("1.5", &metre()), Ok(1.5));
        assert_eq!(quantity("120 mm", &metre()), Ok(0.12));
        for (text, message) in
            [("3 kg", "not in m"), ("2*l", "not a number"), ("", "not a number"), ("2 furlong", "furlong")]
        {
            let error = quantity(text, &metre()).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
