//! Rules for the archive, the description and the library, none of which is run.

use std::collections::{BTreeSet, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::archive_rules::{entries, needs_little, plain_zip, symbols};
use super::fmi3_functions;
use super::fmu::*;

/// Name, what it checks, and the check: a list of complaints.
pub type Case = (&'static str, &'static str, fn(&Archive) -> Vec<String>);

pub const CASES: &[Case] = &[
    ("S02", "a plain zip archive", |archive| plain_zip(&archive.bytes)),
    ("S03", "version, GUID, identifier, library", identity),
    ("S04", "variable names", names),
    ("S05", "causality, variability, initial", combinations),
    ("S06", "start values", starts),
    ("S07", "Outputs lists the outputs", outputs),
    ("S08", "Derivatives lists the derivatives", derivatives),
    ("S09", "InitialUnknowns", initial_unknowns),
    ("S10", "dependencies", dependencies),
    ("S11", "units", units),
    ("S12", "independent variable and aliases", independent),
    ("S13", "capabilities", capabilities),
    ("S14", "default experiment and date", experiment),
    ("S15", "every function is exported", exported),
    ("S16", "nothing else is exported", only_exported),
    ("S17", "the library needs the C library only", |archive| needs_little(&archive.library)),
    ("S18", "documentation and licence", documentation),
    ("S19", "descriptions and units", described),
];

/// An FMU file with what is in it.
pub struct Archive {
    bytes: Vec<u8>,
    fmu: Fmu,
    pub library: PathBuf,
}

impl Archive {
    pub fn open(archive: &Path, folder: &Path) -> Self {
        let fmu = Fmu::open(folder);
        Self { bytes: fs::read(archive).expect("a file"), library: fmu.library_path(), fmu }
    }

    fn text<'a>(&'a self, end: &str, key: &str) -> Vec<&'a str> {
        self.fmu.below(end).into_iter().filter_map(|tag| attribute(tag, key)).collect()
    }

    /// Index (from 1) and dependencies of the unknowns in a list.
    fn unknowns(&self, list: &str) -> Vec<(usize, Vec<usize>)> {
        let number = |text: &str| text.parse().expect("a number");
        let unknowns = self.fmu.below(&format!("/ModelStructure/{list}/Unknown"));
        let dependencies =
            |tag| attribute(tag, "dependencies").unwrap_or_default().split_whitespace().map(number).collect();
        unknowns
            .into_iter()
            .map(|tag| (number(attribute(tag, "index").expect("required")), dependencies(tag)))
            .collect()
    }

    /// Indices from 1 of the variables wanted.
    fn indices(&self, wanted: impl Fn(&Variable) -> bool) -> Vec<usize> {
        let variables = self.fmu.variables.iter().enumerate();
        variables.filter(|(_, variable)| wanted(variable)).map(|(index, _)| index + 1).collect()
    }
}

/// The index from 1 of what a variable is the derivative of.
fn state(variable: &Variable) -> Option<usize> {
    variable.derivative.map(|index| index as usize)
}

fn complain(holds: bool, complaint: impl Into<String>) -> Vec<String> {
    if holds { vec![] } else { vec![complaint.into()] }
}

/// One complaint for every variable that breaks a rule.
fn each(archive: &Archive, rule: impl Fn(&Variable) -> bool) -> Vec<String> {
    archive.fmu.variables.iter().filter(|variable| !rule(variable)).map(|variable| format!("{variable:?}")).collect()
}

fn identity(archive: &Archive) -> Vec<String> {
    let identifier = archive.fmu.identifier();
    let c_name = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !identifier.starts_with(|c: char| c.is_ascii_digit());
    let all = c_name
        && archive.text("fmiModelDescription", "fmiVersion") == ["2.0"]
        && !archive.fmu.guid.is_empty()
        && archive.library.is_file();
    complain(all, format!("{identifier} {}", archive.library.display()))
}

fn names(archive: &Archive) -> Vec<String> {
    let mut seen = HashSet::new();
    let structured = archive.text("fmiModelDescription", "variableNamingConvention") == ["structured"];
    let part = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let names = archive.fmu.variables.iter().map(|variable| &variable.name);
    names.filter(|name| !seen.insert(*name) || (structured && !name.split('.').all(part))).cloned().collect()
}

fn combinations(archive: &Archive) -> Vec<String> {
    each(archive, |variable| {
        let initial = variable.initial.as_deref();
        match (variable.causality.as_str(), variable.variability.as_str()) {
            ("parameter", "fixed" | "tunable") => initial == Some("exact"),
            ("input" | "independent", "continuous") => initial.is_none(),
            ("output" | "local", "continuous") => matches!(initial, Some("exact" | "approx" | "calculated")),
            _ => false,
        }
    })
}

fn starts(archive: &Archive) -> Vec<String> {
    each(archive, |variable| {
        let wanted = variable.causality == "input" || matches!(variable.initial.as_deref(), Some("exact" | "approx"));
        let value = variable.start.unwrap_or_default();
        variable.start.is_some() == wanted
            && variable.min.is_none_or(|min| min <= value)
            && variable.max.is_none_or(|max| value <= max)
    })
}

fn outputs(archive: &Archive) -> Vec<String> {
    let listed: Vec<usize> = archive.unknowns("Outputs").into_iter().map(|unknown| unknown.0).collect();
    complain(listed == archive.indices(|variable| variable.causality == "output"), format!("{listed:?}"))
}

fn derivatives(archive: &Archive) -> Vec<String> {
    let mut listed: Vec<usize> = archive.unknowns("Derivatives").into_iter().map(|unknown| unknown.0).collect();
    listed.sort_unstable();
    let states: Vec<usize> = archive.fmu.variables.iter().filter_map(state).collect();
    let unique: BTreeSet<usize> = states.iter().copied().collect();
    let continuous = states.iter().all(|&state| archive.fmu.variables[state - 1].variability == "continuous");
    let same = listed == archive.indices(|variable| variable.derivative.is_some());
    complain(same && continuous && unique.len() == states.len(), format!("{listed:?} {states:?}"))
}

fn initial_unknowns(archive: &Archive) -> Vec<String> {
    let listed: Vec<usize> = archive.unknowns("InitialUnknowns").into_iter().map(|unknown| unknown.0).collect();
    let states: BTreeSet<usize> = archive.fmu.variables.iter().filter_map(state).collect();
    let variables = archive.fmu.variables.iter().enumerate();
    let wanted: Vec<usize> = variables
        .filter(|(index, variable)| {
            let concerned =
                variable.causality == "output" || variable.derivative.is_some() || states.contains(&(index + 1));
            concerned && matches!(variable.initial.as_deref(), Some("calculated" | "approx"))
        })
        .map(|(index, _)| index + 1)
        .collect();
    complain(listed == wanted, format!("{listed:?} instead of {wanted:?}"))
}

fn dependencies(archive: &Archive) -> Vec<String> {
    let count = archive.fmu.variables.len();
    let states: BTreeSet<usize> = archive.fmu.variables.iter().filter_map(state).collect();
    let mut complaints = Vec::new();
    for list in ["Outputs", "Derivatives"] {
        for (index, on) in archive.unknowns(list) {
            let permitted = |index: &usize| {
                let Some(variable) = index.checked_sub(1).and_then(|place| archive.fmu.variables.get(place)) else {
                    return false;
                };
                let given = matches!(variable.causality.as_str(), "input" | "independent");
                given || states.contains(index)
            };
            complaints.extend(complain(index <= count && on.iter().all(permitted), format!("{list} {index}: {on:?}")));
        }
    }
    complaints
}

fn units(archive: &Archive) -> Vec<String> {
    let defined: HashSet<&str> = archive.text("/UnitDefinitions/Unit", "name").into_iter().collect();
    let displays: HashSet<&str> = archive.text("/Unit/DisplayUnit", "name").into_iter().collect();
    let mut complaints: Vec<String> = Vec::new();
    for (key, known) in [("unit", &defined), ("displayUnit", &displays)] {
        let used = archive.text("/ScalarVariable/Real", key).into_iter();
        complaints.extend(used.filter(|name| !known.contains(name)).map(|name| format!("{key} {name}")));
    }
    let factors = archive.text("/BaseUnit", "factor").into_iter().chain(archive.text("/DisplayUnit", "factor"));
    complaints.extend(factors.filter(|text| !text.parse::<f64>().is_ok_and(f64::is_finite)).map(str::to_owned));
    let empty = archive.fmu.below("fmiModelDescription/UnitDefinitions").len() == 1 && defined.is_empty();
    complaints.extend(complain(!empty, "UnitDefinitions is empty"));
    complaints
}

fn independent(archive: &Archive) -> Vec<String> {
    let independent = archive.indices(|variable| variable.causality == "independent");
    let references: HashSet<u32> = archive.fmu.variables.iter().map(|variable| variable.reference).collect();
    let aliases = references.len() != archive.fmu.variables.len();
    complain(independent.len() <= 1 && !aliases, format!("{independent:?}, aliases: {aliases}"))
}

fn capabilities(archive: &Archive) -> Vec<String> {
    let exchange = !archive.fmu.below("fmiModelDescription/ModelExchange").is_empty();
    let indicators = archive.text("fmiModelDescription", "numberOfEventIndicators");
    let serializes = |interface| {
        !archive.fmu.flag(interface, "canSerializeFMUstate") || archive.fmu.flag(interface, "canGetAndSetFMUstate")
    };
    let consistent = archive.fmu.below("fmiModelDescription/CoSimulation").len() == 1
        && exchange != indicators.is_empty()
        && ["CoSimulation", "ModelExchange"].into_iter().all(serializes);
    complain(consistent, format!("{indicators:?}"))
}

fn experiment(archive: &Archive) -> Vec<String> {
    let number = |key| archive.text("/DefaultExperiment", key)[0].parse::<f64>().unwrap_or(f64::NAN);
    let sound = number("startTime") < number("stopTime") && number("stepSize") > 0.0 && number("tolerance") > 0.0;
    // No date is a good date: the same scene gives the same bytes.
    let dates = archive.text("fmiModelDescription", "generationDateAndTime");
    complain(sound && dates.iter().all(|date| date.len() == 20 && date.ends_with('Z')), format!("{dates:?}"))
}

fn exported(archive: &Archive) -> Vec<String> {
    let symbols = symbols(&archive.library);
    let missing = FUNCTIONS.iter().filter(|name| !symbols.iter().any(|symbol| symbol == *name));
    missing.map(|name| (*name).to_owned()).collect()
}

fn only_exported(archive: &Archive) -> Vec<String> {
    // The runtime is the same for both versions of FMI.
    let permitted = |symbol: &String| {
        FUNCTIONS.contains(&symbol.as_str()) || fmi3_functions::FUNCTIONS.split_whitespace().any(|name| name == symbol)
    };
    symbols(&archive.library).into_iter().filter(|symbol| !permitted(symbol)).collect()
}

fn documentation(archive: &Archive) -> Vec<String> {
    let names: Vec<String> = entries(&archive.bytes).into_iter().map(|entry| entry.name).collect();
    let wanted = ["documentation/index.html", "documentation/licenses/license.txt", "model.png"];
    wanted.into_iter().filter(|name| !names.iter().any(|known| known == name)).map(str::to_owned).collect()
}

fn described(archive: &Archive) -> Vec<String> {
    let scalars = archive.fmu.below("/ScalarVariable");
    let reals = archive.fmu.below("/ScalarVariable/Real");
    let bare = scalars.into_iter().zip(reals).filter(|(scalar, real)| {
        let computed = matches!(attribute(scalar, "causality"), Some("output" | "local"));
        (computed && attribute(real, "unit").is_none()) || attribute(scalar, "description").is_none_or(str::is_empty)
    });
    bare.map(|(scalar, _)| format!("{scalar:?}")).collect()
}
