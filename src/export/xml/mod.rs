//! `modelDescription.xml`: what both versions of FMI write in the same way.

pub mod fmi2;
pub mod fmi3;
pub mod related;
pub mod source_files;
pub mod terminals;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::io;

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::{ElementWriter, Writer};

use super::description::{Causality, Description, ScalarVariable, StartValue, Type, is_structured};
use crate::model::Unit;
use crate::program::LISTED;

type Out = Writer<Vec<u8>>;
type Attributes = Vec<(&'static str, String)>;

/// A document with one element around everything.
fn document(
    name: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Out) -> io::Result<()>,
) -> io::Result<Vec<u8>> {
    let mut out = Writer::new_with_indent(Vec::new(), b' ', 2);
    out.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    element(&mut out, name, attributes, content)?;
    let mut bytes = out.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

/// The categories that the runtime logs in, with what is logged under them.
fn log_categories(out: &mut Out, categories: [(&str, &str); 3]) -> io::Result<()> {
    element(out, "LogCategories", vec![], |out| {
        categories.iter().try_for_each(|(name, about)| {
            leaf(out, "Category", vec![("name", (*name).into()), ("description", (*about).into())])
        })
    })
}

/// What a model is called, by the name that the version has for its identity.
fn header(description: &Description, version: &str, identity: (&'static str, String)) -> Attributes {
    let structured = description.variables.iter().all(|variable| is_structured(&variable.name));
    let mut attributes = vec![("fmiVersion", version.into()), ("modelName", description.model_name.clone()), identity];
    attributes.extend(about(&description.description));
    attributes.extend(description.credits.iter().cloned());
    attributes.push(("generationTool", concat!("cotree ", env!("CARGO_PKG_VERSION")).into()));
    attributes.push(("variableNamingConvention", if structured { "structured" } else { "flat" }.into()));
    attributes
}

/// What a variable is called, and what it is.
fn named(reference: usize, variable: &ScalarVariable) -> Attributes {
    let mut attributes = vec![("name", variable.name.clone()), ("valueReference", reference.to_string())];
    attributes.extend(about(&variable.description));
    attributes.push(("causality", variable.causality.name().into()));
    attributes.push(("variability", variable.variability.name().into()));
    attributes
}

/// Unit, bounds and start of a variable.
fn values(variable: &ScalarVariable) -> Attributes {
    let mut attributes = Attributes::new();
    let text = |value: f64| variable.kind.text(value);
    if variable.kind == Type::Real && !variable.unit.si.is_empty() {
        attributes.push(("unit", variable.unit.si.clone()));
        attributes.extend(variable.unit.display.iter().map(|display| ("displayUnit", display.name.clone())));
    }
    if let Some((start, [min, max])) = variable.causality.range() {
        // A Boolean has no bounds.
        let ends = [("min", min), ("max", max)].into_iter().filter(|_| variable.kind != Type::Boolean);
        attributes.extend(ends.filter_map(|(key, end)| Some((key, text(end?)))));
        attributes.push(("start", text(start)));
    }
    if let Some(StartValue::Exact(value) | StartValue::Approximate(value)) = variable.start {
        attributes.push(("start", text(value)));
    }
    attributes
}

/// Where the value at the start comes from.
fn initial(variable: &ScalarVariable) -> Option<(&'static str, String)> {
    let initial = match (variable.causality, variable.start) {
        (Causality::Independent, _) => return None,
        (Causality::Parameter { .. } | Causality::Input { .. }, _) | (_, Some(StartValue::Exact(_))) => "exact",
        (_, Some(StartValue::Approximate(_))) => "approx",
        (_, None) => "calculated",
    };
    Some(("initial", initial.into()))
}

/// States that an event may move in Model Exchange, where the importer integrates.
fn moved(description: &Description, exchange: bool) -> HashSet<usize> {
    let states = description.variables.iter().filter_map(|variable| variable.derivative_of);
    states.filter(|_| description.moves_states && exchange).collect()
}

/// The attribute with what an unknown depends on: without a list the standard takes it to be everything that is known.
fn dependencies(on: &[usize], references: impl Fn(usize) -> Vec<usize>) -> Option<(&'static str, String)> {
    let on =
        (on.len() <= LISTED).then(|| on.iter().flat_map(|&place| references(place)).collect::<BTreeSet<usize>>())?;
    let on: Vec<String> = on.iter().map(usize::to_string).collect();
    Some(("dependencies", on.join(" ")))
}

fn experiment(description: &Description) -> Attributes {
    let experiment = description.experiment;
    vec![
        ("startTime", number(experiment.start)),
        ("stopTime", number(experiment.stop)),
        ("tolerance", number(experiment.tolerance)),
        ("stepSize", number(description.sources.as_ref().map_or(experiment.step, |sources| sources.step))),
    ]
}

/// Every unit that a variable has, with the display units that any variable asks for. Omitted if empty: the schema
/// wants at least one.
fn units<'a>(out: &mut Out, all: impl Iterator<Item = &'a Unit>) -> io::Result<()> {
    let mut used: BTreeMap<&str, (&Unit, BTreeMap<&str, f64>)> = BTreeMap::new();
    for unit in all.filter(|unit| !unit.si.is_empty()) {
        let (_, displays) = used.entry(&unit.si).or_insert_with(|| (unit, BTreeMap::new()));
        displays.extend(unit.display.iter().map(|display| (display.name.as_str(), display.factor)));
    }
    if used.is_empty() {
        return Ok(());
    }
    element(out, "UnitDefinitions", vec![], |out| {
        used.values().try_for_each(|(unit, displays)| {
            element(out, "Unit", vec![("name", unit.si.clone())], |out| {
                leaf(out, "BaseUnit", exponents(unit))?;
                displays.iter().try_for_each(|(name, si)| {
                    // The standard's factor goes the other way: display value = factor * SI value.
                    leaf(out, "DisplayUnit", vec![("name", (*name).into()), ("factor", number(1.0 / si))])
                })
            })
        })
    })
}

fn exponents(unit: &Unit) -> Attributes {
    unit.exponents.powers().map(|(name, power)| (name, power.to_string())).collect()
}

/// The shortest text that reads back as the same number.
fn number(value: f64) -> String {
    Type::Real.text(value)
}

fn about(description: &str) -> Option<(&'static str, String)> {
    (!description.is_empty()).then(|| ("description", description.to_owned()))
}

/// What XML cannot hold, line breaks among them, becomes a space.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

fn begun<'o>(out: &'o mut Out, name: &'o str, attributes: Attributes) -> ElementWriter<'o, Vec<u8>> {
    let attributes: Vec<_> = attributes.into_iter().map(|(key, value)| (key, printable(&value))).collect();
    out.create_element(name).with_attributes(attributes.iter().map(|(key, value)| (*key, value.as_str())))
}

fn leaf(out: &mut Out, name: &str, attributes: Attributes) -> io::Result<()> {
    begun(out, name, attributes).write_empty().map(|_| ())
}

fn element(
    out: &mut Out,
    name: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Out) -> io::Result<()>,
) -> io::Result<()> {
    begun(out, name, attributes).write_inner_content(content).map(|_| ())
}
