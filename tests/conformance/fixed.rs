//! Rules for the archive, the description and the library, none of which is run.

use std::collections::{BTreeSet, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::fmi3_functions;
use crate::fmu::*;

/// Name, what it checks, and the check: a list of complaints.
pub type Case = (&'static str, &'static str, fn(&Archive) -> Vec<String>);

pub const CASES: &[Case] = &[
    ("S02", "a plain zip archive", plain_zip),
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
    ("S17", "the library needs the C library only", needed),
    ("S18", "documentation and licence", documentation),
    ("S19", "descriptions and units", described),
];

/// An FMU file with what is in it.
pub struct Archive {
    bytes: Vec<u8>,
    fmu: Fmu,
    library: PathBuf,
}

impl Archive {
    pub fn open(archive: &Path, folder: &Path) -> Self {
        let fmu = Fmu::open(folder);
        let library = Fmu::library_path(folder, &fmu.identifier);
        Self { bytes: fs::read(archive).expect("a file"), fmu, library }
    }

    /// The newest version of the C library that the shared library asks for.
    pub fn glibc(&self) -> String {
        let symbols = printed("objdump", &["-T"], &self.library);
        let versions = symbols.split(|c: char| c.is_whitespace() || "()".contains(c));
        let versions = versions.filter(|word| word.starts_with("GLIBC_") && !word.ends_with("PRIVATE"));
        let newest = versions.reduce(|newest, version| if newer(version, newest) { version } else { newest });
        newest.expect("it uses the C library").to_owned()
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

fn complain(holds: bool, complaint: impl Into<String>) -> Vec<String> {
    if holds { vec![] } else { vec![complaint.into()] }
}

/// One complaint for every variable that breaks a rule.
fn each(archive: &Archive, rule: impl Fn(&Variable) -> bool) -> Vec<String> {
    archive.fmu.variables.iter().filter(|variable| !rule(variable)).map(|variable| format!("{variable:?}")).collect()
}

/// Headers of the central directory: version needed, flags, method, mode, name.
fn entries(bytes: &[u8]) -> Vec<(u16, u16, u16, u32, String)> {
    let short = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let long = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let end = bytes.len() - 22;
    assert_eq!(long(end), 0x0605_4b50, "no comment at the end");
    let mut at = long(end + 16) as usize;
    let mut entries = Vec::new();
    for _ in 0..short(end + 10) {
        assert_eq!(long(at), 0x0201_4b50);
        let [name, extra, comment] = [28, 30, 32].map(|field| short(at + field) as usize);
        let text = String::from_utf8_lossy(&bytes[at + 46..at + 46 + name]).into_owned();
        entries.push((short(at + 6), short(at + 8), short(at + 10), long(at + 38) >> 16, text));
        at += 46 + name + extra + comment;
    }
    entries
}

fn plain_zip(archive: &Archive) -> Vec<String> {
    let mut seen = HashSet::new();
    let bad = entries(&archive.bytes).into_iter().filter(|(version, flags, method, mode, name)| {
        let link = mode & 0o170_000 == 0o120_000;
        let path = name.contains('\\') || name.starts_with('/') || name.split('/').any(|part| part == "..");
        *version & 0xff > 20 || flags & 1 != 0 || ![0, 8].contains(method) || link || path || !seen.insert(name.clone())
    });
    bad.map(|entry| format!("{entry:?}")).collect()
}

fn identity(archive: &Archive) -> Vec<String> {
    let identifier = &archive.fmu.identifier;
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
    let states: Vec<usize> = archive.fmu.variables.iter().filter_map(|variable| variable.derivative).collect();
    let unique: BTreeSet<usize> = states.iter().copied().collect();
    let continuous = states.iter().all(|&state| archive.fmu.variables[state - 1].variability == "continuous");
    let same = listed == archive.indices(|variable| variable.derivative.is_some());
    complain(same && continuous && unique.len() == states.len(), format!("{listed:?} {states:?}"))
}

fn initial_unknowns(archive: &Archive) -> Vec<String> {
    let listed: Vec<usize> = archive.unknowns("InitialUnknowns").into_iter().map(|unknown| unknown.0).collect();
    let states: BTreeSet<usize> = archive.fmu.variables.iter().filter_map(|variable| variable.derivative).collect();
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
    let states: BTreeSet<usize> = archive.fmu.variables.iter().filter_map(|variable| variable.derivative).collect();
    let mut complaints = Vec::new();
    for list in ["Outputs", "Derivatives", "InitialUnknowns"] {
        for (index, on) in archive.unknowns(list) {
            let permitted = |index: &usize| {
                let Some(variable) = index.checked_sub(1).and_then(|place| archive.fmu.variables.get(place)) else {
                    return false;
                };
                let given = matches!(variable.causality.as_str(), "input" | "independent");
                let exact = variable.initial.as_deref() == Some("exact");
                given || if list == "InitialUnknowns" { exact } else { states.contains(index) }
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

/// What a tool prints about the library.
fn printed(tool: &str, arguments: &[&str], library: &Path) -> String {
    let output = Command::new(tool).args(arguments).arg(library).output();
    let output = output.unwrap_or_else(|error| panic!("{tool} (package binutils): {error}"));
    assert!(output.status.success(), "{tool}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn symbols(archive: &Archive) -> Vec<String> {
    let text = printed("nm", &["-D", "--defined-only"], &archive.library);
    text.lines().filter_map(|line| line.split_whitespace().next_back()).map(str::to_owned).collect()
}

fn exported(archive: &Archive) -> Vec<String> {
    let symbols = symbols(archive);
    let missing = FUNCTIONS.iter().filter(|name| !symbols.iter().any(|symbol| symbol == *name));
    missing.map(|name| (*name).to_owned()).collect()
}

fn only_exported(archive: &Archive) -> Vec<String> {
    // The runtime is the same for both versions of FMI.
    let permitted = |symbol: &String| {
        FUNCTIONS.contains(&symbol.as_str()) || fmi3_functions::FUNCTIONS.split_whitespace().any(|name| name == symbol)
    };
    symbols(archive).into_iter().filter(|symbol| !permitted(symbol)).collect()
}

fn needed(archive: &Archive) -> Vec<String> {
    const PERMITTED: [&str; 6] = ["libc.so", "libm.so", "libdl.so", "libpthread.so", "libgcc_s.so", "ld-linux"];
    let dynamic = printed("readelf", &["-dW"], &archive.library);
    let libraries = dynamic.lines().filter(|line| line.contains("(NEEDED)"));
    let foreign = libraries.filter(|line| !PERMITTED.iter().any(|name| line.contains(name)));
    let mut complaints: Vec<String> = foreign.map(str::to_owned).collect();
    complaints.extend(dynamic.lines().filter(|line| line.contains("PATH)")).map(str::to_owned));
    complaints.extend(complain(!newer(&archive.glibc(), NEWEST_GLIBC), format!("needs {}", archive.glibc())));
    let segments = printed("readelf", &["-lW"], &archive.library);
    let stack = segments.lines().find(|line| line.contains("GNU_STACK"));
    complaints.extend(stack.filter(|line| line.contains("RWE")).map(str::to_owned));
    complaints
}

/// The C library of Debian 10 and RHEL 8.
const NEWEST_GLIBC: &str = "GLIBC_2.28";

/// Is the first version newer than the second?
fn newer(version: &str, other: &str) -> bool {
    let numbers = |text: &str| -> Vec<u32> {
        let number = |part: &str| part.parse().expect("a number");
        text.trim_start_matches("GLIBC_").split('.').map(number).collect()
    };
    numbers(version) > numbers(other)
}

fn documentation(archive: &Archive) -> Vec<String> {
    let names: Vec<String> = entries(&archive.bytes).into_iter().map(|entry| entry.4).collect();
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
