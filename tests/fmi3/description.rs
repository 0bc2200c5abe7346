//! Rules for the descriptions.

use std::collections::BTreeSet;

use super::archive::{Rule, complaint, names, unique};
use super::xml::{Tag, attribute};

pub const RULES: &[Rule] = &[
    ("3S07", "structured names", |fmu| {
        let structured = attribute(&fmu.tags[0], "variableNamingConvention") == Some("structured");
        let names = fmu.variables.iter().map(|variable| &variable.name);
        names.filter(|name| structured && !is_structured(name)).cloned().collect()
    }),
    ("3S09", "causality and variability fit", |fmu| {
        let fits = |causality: &str, variability: &str| match causality {
            "parameter" => ["fixed", "tunable"].contains(&variability),
            "input" | "independent" => variability == "continuous",
            "output" => ["constant", "discrete", "continuous"].contains(&variability),
            "local" => ["constant", "fixed", "tunable", "discrete", "continuous"].contains(&variability),
            _ => false,
        };
        names(fmu, |variable| !fits(&variable.causality, &variable.variability))
    }),
    ("3S10", "initial fits", |fmu| {
        names(fmu, |variable| match (&*variable.causality, variable.initial.as_deref()) {
            ("parameter" | "input", initial) => initial.is_some_and(|initial| initial != "exact"),
            ("independent", initial) => initial.is_some(),
            (_, initial) => !["exact", "approx", "calculated"].map(Some).contains(&initial),
        })
    }),
    ("3S15", "event indicators", |fmu| {
        let indicators = fmu.structure("EventIndicator").into_iter().map(|reference| fmu.variable(reference));
        let wrong = indicators.filter(|one| {
            one.variability != "continuous" || !["local", "output"].contains(&&*one.causality) || one.start.is_some()
        });
        wrong.map(|variable| variable.name.clone()).collect()
    }),
    ("3S19", "no empty lists", |fmu| {
        let lists =
            ["UnitDefinitions", "TypeDefinitions", "LogCategories", "ModelVariables", "Annotations", "Terminals"];
        let tags: Vec<Tag> = fmu.tags.iter().cloned().chain(fmu.terminals()).collect();
        let is_list = |path: &&str| lists.iter().any(|list| path.ends_with(&format!("/{list}")));
        let empty = |path: &&str| !tags.iter().any(|tag| tag.0.starts_with(&format!("{path}/")));
        tags.iter().map(|tag| tag.0.as_str()).filter(is_list).filter(empty).map(str::to_owned).collect()
    }),
    ("3S20", "capabilities go together", |fmu| {
        let flag = |name| ["CoSimulation", "ModelExchange"].map(|interface| fmu.flag(interface, name));
        let implied = |first, second| flag(first).into_iter().zip(flag(second)).any(|(first, second)| first && !second);
        let pairs = [
            ("canSerializeFMUState", "canGetAndSetFMUState"),
            ("canReturnEarlyAfterIntermediateUpdate", "providesIntermediateUpdate"),
        ];
        let clocks = !fmu.below("ModelVariables/Clock").is_empty() && !fmu.flag("CoSimulation", "hasEventMode");
        let wrong = pairs.into_iter().filter(|(first, second)| implied(first, second));
        wrong.map(|pair| format!("{pair:?}")).chain(complaint(clocks, || "clocks".to_owned())).collect()
    }),
    ("3S21", "capabilities that the standard knows", |fmu| {
        let interfaces = ["CoSimulation", "ModelExchange"].map(|name| fmu.below(&format!("/{name}")));
        let used = interfaces.iter().flatten().flat_map(|tag| &tag.1).map(|(name, _)| name);
        used.filter(|name| !CAPABILITIES.contains(&name.as_str())).cloned().collect()
    }),
    ("3S23", "default experiment and date", |fmu| {
        let experiment = fmu.below("/DefaultExperiment")[0];
        let number = |key| attribute(experiment, key).and_then(|text| text.parse::<f64>().ok()).unwrap_or(f64::NAN);
        let sound = number("startTime") < number("stopTime") && number("stepSize") > 0.0 && number("tolerance") > 0.0;
        // No date is a good date: the same scene gives the same bytes.
        let date = attribute(&fmu.tags[0], "generationDateAndTime");
        complaint(!sound || date.is_some_and(|date| date.len() != 20 || !date.ends_with('Z')), || format!("{date:?}"))
    }),
    ("3S33", "log categories", |fmu| {
        let categories = fmu.below("LogCategories/Category");
        let found: BTreeSet<&str> = categories.iter().filter_map(|tag| attribute(tag, "name")).collect();
        let twice = unique(categories.iter().filter_map(|tag| attribute(tag, "name")));
        let wanted = ["logEvents", "logStatusError"].into_iter().filter(|name| !found.contains(name));
        twice.into_iter().chain(wanted.map(|name| format!("{name} is missing"))).collect()
    }),
];

/// 2.4.2, 3.4, 4.4
const CAPABILITIES: [&str; 18] = [
    "modelIdentifier",
    "needsExecutionTool",
    "canBeInstantiatedOnlyOncePerProcess",
    "canGetAndSetFMUState",
    "canSerializeFMUState",
    "providesDirectionalDerivatives",
    "providesAdjointDerivatives",
    "providesPerElementDependencies",
    "needsCompletedIntegratorStep",
    "providesEvaluateDiscreteStates",
    "canHandleVariableCommunicationStepSize",
    "fixedInternalStepSize",
    "maxOutputDerivativeOrder",
    "recommendedIntermediateInputSmoothness",
    "providesIntermediateUpdate",
    "mightReturnEarlyFromDoStep",
    "canReturnEarlyAfterIntermediateUpdate",
    "hasEventMode",
];

/// Names joined by dots, or a derivative of that: `der(a.b)`, `der(a.b,2)` (2.4.7.5.1; nothing of ours needs quotes or indices).
fn is_structured(name: &str) -> bool {
    let part = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let inner = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
    let name = inner.map_or(name, |inner| match inner.rsplit_once(',') {
        Some((name, order)) if order.parse::<u32>().is_ok_and(|order| order > 0) => name,
        _ => inner,
    });
    name.split('.').all(part)
}
