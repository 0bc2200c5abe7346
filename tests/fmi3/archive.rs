//! Rules for the archive and its descriptions.

use std::collections::BTreeSet;

use crate::fmi3_functions::FUNCTIONS;
use crate::fmu::Fmu;
use crate::xml::{Tag, attribute, tags};

/// A rule: what it is called in the catalogue, what it checks, what is found to be wrong.
pub type Rule = (&'static str, &'static str, fn(&Fmu) -> Vec<String>);

pub const RULES: &[Rule] = &[
    ("3S03", "version, interface, identifier", |fmu| {
        let version = attribute(&fmu.tags[0], "fmiVersion");
        complaint(version != Some("3.0"), || format!("version {version:?}"))
    }),
    ("3S05", "names are unique", |fmu| unique(fmu.variables.iter().map(|variable| variable.name.clone()))),
    ("3S06", "value references are unique", |fmu| unique(fmu.variables.iter().map(|variable| variable.reference))),
    ("3S08", "one independent variable", |fmu| {
        let found: Vec<_> = fmu.variables.iter().filter(|variable| variable.causality == "independent").collect();
        let sound = |one: &&crate::fmu::Variable| {
            one.start.is_none() && one.initial.is_none() && one.variability == "continuous"
        };
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
    ("3S17", "dependencies at the start", |fmu| {
        let known = |reference: &u32| {
            let variable = fmu.variable(*reference);
            variable.initial.as_deref() == Some("exact") || ["input", "independent"].contains(&&*variable.causality)
        };
        unknown(fmu, &["InitialUnknown"], known)
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
        FUNCTIONS.split_whitespace().filter(|name| !fmu.library.has(name)).map(str::to_owned).collect()
    }),
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
    ("3S30", "terminals have members that exist, each once", |fmu| {
        let Ok(document) = std::fs::read(fmu.folder.join("terminalsAndIcons/terminalsAndIcons.xml")) else {
            return complaint(
                fmu.variables.iter().any(|one| one.causality == "output" && one.name.contains('.')),
                || "none".to_owned(),
            );
        };
        let tags = tags(&document);
        let below = |end: &str| tags.iter().filter(|tag| tag.0.ends_with(end)).collect::<Vec<&Tag>>();
        let members = below("/TerminalMemberVariable");
        let names = members.iter().filter_map(|tag| attribute(tag, "variableName"));
        let mut wrong = unique(names.clone());
        wrong.extend(unique(below("Terminals/Terminal").iter().filter_map(|tag| attribute(tag, "name"))));
        wrong.extend(
            names.filter(|name| !fmu.variables.iter().any(|variable| variable.name == *name)).map(str::to_owned),
        );
        wrong.extend(complaint(members.is_empty(), || "no member".to_owned()));
        wrong
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
];

fn complaint(wrong: bool, what: impl FnOnce() -> String) -> Vec<String> {
    wrong.then(what).into_iter().collect()
}

fn sorted(mut list: Vec<u32>) -> Vec<u32> {
    list.sort_unstable();
    list
}

fn unique<T: Ord + Clone + std::fmt::Debug>(all: impl Iterator<Item = T>) -> Vec<String> {
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
