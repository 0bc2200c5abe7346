//! Rules for the archive and its descriptions.

use std::collections::BTreeSet;
use std::path::Path;

use super::archive_rules::{needs_little, plain_zip, symbols};
use super::fmi3_functions::FUNCTIONS;
use super::fmu::{Fmu, Variable};
use super::xml::{Tag, attribute};

/// A rule: what it is called in the catalogue, what it checks, what is found to be wrong.
pub type Rule = (&'static str, &'static str, fn(&Fmu) -> Vec<String>);

pub const RULES: &[Rule] = &[
    ("3S02", "a plain zip archive", |fmu| plain_zip(&std::fs::read(fmu.archive()).expect("a file"))),
    ("3S03", "version, interface, identifier", |fmu| {
        let version = attribute(&fmu.tags[0], "fmiVersion");
        complaint(version != Some("3.0"), || format!("version {version:?}"))
    }),
    ("3S04", "the library is where importers look for it", |fmu| {
        let tuple = |name: &String| {
            let (processor, system) = name.split_once('-').unwrap_or_default();
            ["x86", "x86_64", "aarch32", "aarch64"].contains(&processor)
                && ["darwin", "linux", "windows"].contains(&system)
        };
        let mut wrong = below(&fmu.folder.join("binaries"));
        wrong.retain(|name| !tuple(name));
        let library = fmu.library_path();
        wrong.extend(complaint(!library.is_file(), || library.display().to_string()));
        wrong
    }),
    ("3S05", "names are unique", |fmu| unique(fmu.variables.iter().map(|variable| variable.name.clone()))),
    ("3S06", "value references are unique", |fmu| unique(fmu.variables.iter().map(|variable| variable.reference))),
    ("3S08", "one independent variable", |fmu| {
        let found: Vec<_> = fmu.variables.iter().filter(|variable| variable.causality == "independent").collect();
        let sound = |one: &&Variable| one.start.is_none() && one.initial.is_none() && one.variability == "continuous";
        complaint(found.len() != 1 || !found.iter().all(sound), || format!("{found:?}"))
    }),
    ("3S11", "start values where they belong", |fmu| {
        let wrong = fmu.variables.iter().filter(|variable| {
            let wants = ["exact", "approx"].map(Some).contains(&variable.initial.as_deref());
            wants != variable.start.is_some()
        });
        wrong.map(|variable| variable.name.clone()).collect()
    }),
    ("3S12", "outputs", |fmu| {
        let (listed, outputs) = (sorted(fmu.structure("Output")), sorted(fmu.of_causality("output")));
        complaint(listed != outputs, || format!("{listed:?} {outputs:?}"))
    }),
    ("3S13", "derivatives of states", |fmu| {
        let state =
            |reference: u32| fmu.variable(reference).derivative.map(|state| fmu.variable(state).causality.clone());
        let wrong = fmu
            .structure("ContinuousStateDerivative")
            .into_iter()
            .filter(|&reference| !matches!(state(reference).as_deref(), Some("local" | "output")));
        wrong.map(|reference| fmu.variable(reference).name.clone()).collect()
    }),
    ("3S14", "unknowns of the initialization", |fmu| {
        let derivatives = fmu.structure("ContinuousStateDerivative");
        let states: Vec<u32> = derivatives.iter().filter_map(|&one| fmu.variable(one).derivative).collect();
        let all = [fmu.structure("Output"), derivatives, states].concat();
        let solved = |reference: &u32| fmu.variable(*reference).initial.as_deref() != Some("exact");
        let expected: BTreeSet<u32> = all.into_iter().filter(solved).collect();
        let listed = sorted(fmu.structure("InitialUnknown"));
        complaint(listed != expected.into_iter().collect::<Vec<_>>(), || format!("{listed:?}"))
    }),
    ("3S16", "dependencies are on what is known", |fmu| {
        let states: Vec<u32> =
            fmu.structure("ContinuousStateDerivative").iter().filter_map(|&one| fmu.variable(one).derivative).collect();
        let known = |reference: &u32| {
            let causality = &*fmu.variable(*reference).causality;
            states.contains(reference) || ["input", "parameter", "independent"].contains(&causality)
        };
        unknown(fmu, &["Output", "ContinuousStateDerivative"], known)
    }),
    ("3S18", "units are defined", |fmu| {
        let defined: Vec<&str> =
            fmu.below("UnitDefinitions/Unit").iter().filter_map(|tag| attribute(tag, "name")).collect();
        let used = fmu.below("ModelVariables/Float64").into_iter().filter_map(|tag| attribute(tag, "unit"));
        used.filter(|unit| !defined.contains(unit)).map(str::to_owned).collect()
    }),
    ("3S22", "reinit on states, intermediate updates of what is calculated", |fmu| {
        let derivatives = fmu.structure("ContinuousStateDerivative");
        let states: Vec<u32> = derivatives.iter().filter_map(|&one| fmu.variable(one).derivative).collect();
        let wrong = fmu.below("ModelVariables/Float64").into_iter().zip(&fmu.variables).filter(|(tag, variable)| {
            attribute(tag, "reinit").is_some() && !states.contains(&variable.reference)
                || variable.intermediate && !["output", "local"].contains(&&*variable.causality)
        });
        wrong.map(|(_, variable)| variable.name.clone()).collect()
    }),
    ("3S24", "every function of the standard is exported", |fmu| {
        let found = symbols(&fmu.library_path());
        FUNCTIONS
            .split_whitespace()
            .filter(|name| !found.iter().any(|known| known == name))
            .map(str::to_owned)
            .collect()
    }),
    ("3S25", "no other function has a name of the standard's", |fmu| {
        let mut found = symbols(&fmu.library_path());
        found.retain(|name| name.starts_with("fmi3") && !FUNCTIONS.split_whitespace().any(|known| known == name));
        found
    }),
    ("3S26", "the library needs the C library only", |fmu| needs_little(&fmu.library_path())),
    ("3S27", "documentation and pictures", |fmu| {
        let files = [
            "documentation/index.html",
            "documentation/diagram.png",
            "documentation/diagram.svg",
            "documentation/licenses/license.txt",
            "terminalsAndIcons/icon.png",
            "resources/program.bin",
        ];
        files.into_iter().filter(|file| !fmu.folder.join(file).is_file()).map(str::to_owned).collect()
    }),
    ("3S28", "a licence, and a PNG beside each SVG", |fmu| {
        let mut wrong = Vec::new();
        for folder in ["documentation", "terminalsAndIcons"].map(|name| fmu.folder.join(name)) {
            let files = below(&folder);
            let drawn = files.iter().filter_map(|name| name.strip_suffix(".svg"));
            wrong.extend(drawn.filter(|name| !files.contains(&format!("{name}.png"))).map(str::to_owned));
        }
        let licences = below(&fmu.folder.join("documentation/licenses"));
        let licensed = ["txt", "html", "spdx"].iter().any(|end| licences.contains(&format!("license.{end}")));
        wrong.extend(complaint(!licensed, || "no licence".to_owned()));
        wrong
    }),
    ("3S30", "terminals have members that exist, each once", |fmu| {
        let tags = fmu.terminals();
        if tags.is_empty() {
            let named = fmu.variables.iter().any(|one| one.causality == "output" && one.name.contains('.'));
            return complaint(named, || "none".to_owned());
        }
        let below = |end: &str| tags.iter().filter(|tag| tag.0.ends_with(end)).collect::<Vec<&Tag>>();
        let members = below("/TerminalMemberVariable");
        let names = members.iter().filter_map(|tag| attribute(tag, "variableName"));
        let mut wrong = unique(names.clone());
        wrong.extend(unique(below("Terminals/Terminal").iter().filter_map(|tag| attribute(tag, "name"))));
        wrong.extend(
            names.filter(|name| !fmu.variables.iter().any(|variable| variable.name == *name)).map(str::to_owned),
        );
        wrong.extend(complaint(members.is_empty(), || "no member".to_owned()));
        wrong.extend(members.iter().filter(|member| !fits(fmu, member)).map(|member| format!("{member:?}")));
        wrong.extend(member_names(&tags).into_iter().flat_map(|names| unique(names.into_iter())));
        wrong
    }),
    ("3S31", "every icon is in the archive", |fmu| {
        let tags = fmu.terminals();
        let names = tags.iter().filter_map(|tag| attribute(tag, "iconBaseName"));
        let there = |name: &&str| fmu.folder.join("terminalsAndIcons").join(format!("{name}.png")).is_file();
        names.filter(|name| name.contains(['/', '\\', ':']) || !there(name)).map(str::to_owned).collect()
    }),
    ("3S32", "folders for others have names of others", |fmu| {
        below(&fmu.folder.join("extra")).into_iter().filter(|name| !name.contains('.')).collect()
    }),
    ("3S34", "everything of interest has a description and a unit", |fmu| {
        let wanted = |tag: &&Tag| attribute(tag, "causality") != Some("local");
        let wrong = fmu
            .below("ModelVariables/Float64")
            .into_iter()
            .filter(wanted)
            .filter(|tag| attribute(tag, "description").is_none());
        wrong.filter_map(|tag| attribute(tag, "name")).map(str::to_owned).collect()
    }),
    ("3S35", "sources say how they are built", |fmu| {
        let sources = below(&fmu.folder.join("sources"));
        complaint(!sources.is_empty() && !sources.iter().any(|name| name == "buildDescription.xml"), || "no".to_owned())
    }),
];

/// Inputs and outputs alone can be connected; what flows in is an input, what flows out an output (2.4.9.2.6).
fn fits(fmu: &Fmu, member: &Tag) -> bool {
    let name = attribute(member, "variableName").unwrap_or_default();
    let causality = fmu.variables.iter().find(|variable| variable.name == name).map(|variable| &*variable.causality);
    match attribute(member, "variableKind") {
        Some("inflow") => causality == Some("input"),
        Some("outflow") => causality == Some("output"),
        Some("signal") => matches!(causality, Some("input" | "output")),
        _ => false,
    }
}

/// What the members of each terminal are called there.
fn member_names(tags: &[Tag]) -> Vec<Vec<&str>> {
    let mut names: Vec<Vec<&str>> = Vec::new();
    for tag in tags {
        match attribute(tag, "memberName") {
            Some(name) => names.last_mut().expect("within a terminal").push(name),
            None => names.push(Vec::new()),
        }
    }
    names
}

/// The names in a folder; none if there is no folder.
fn below(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    entries.map(|entry| entry.expect("readable").file_name().into_string().expect("UTF-8")).collect()
}

/// The names of the variables that break a rule.
pub fn names(fmu: &Fmu, wrong: impl Fn(&Variable) -> bool) -> Vec<String> {
    fmu.variables.iter().filter(|variable| wrong(variable)).map(|variable| variable.name.clone()).collect()
}

pub fn complaint(wrong: bool, what: impl FnOnce() -> String) -> Vec<String> {
    wrong.then(what).into_iter().collect()
}

fn sorted(mut list: Vec<u32>) -> Vec<u32> {
    list.sort_unstable();
    list
}

pub fn unique<T: Ord + Clone + std::fmt::Debug>(all: impl Iterator<Item = T>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    all.filter(|one| !seen.insert(one.clone())).map(|one| format!("{one:?} twice")).collect()
}

/// Dependencies on what is not known.
fn unknown(fmu: &Fmu, elements: &[&str], known: impl Fn(&u32) -> bool) -> Vec<String> {
    let mut wrong = Vec::new();
    for element in elements {
        for reference in fmu.structure(element) {
            let list = fmu.dependencies(element, reference).unwrap_or_default();
            wrong.extend(list.iter().filter(|on| !known(on)).map(|on| format!("{element} {reference} on {on}")));
        }
    }
    wrong
}
