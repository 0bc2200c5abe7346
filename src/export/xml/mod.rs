//! `modelDescription.xml`: what both versions of FMI write in the same way.

pub mod fmi2;
pub mod fmi3;
pub mod terminals;

use std::collections::BTreeMap;
use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use super::description::Description;
use crate::mechanism::Unit;

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

fn experiment(description: &Description) -> Attributes {
    let experiment = description.experiment;
    vec![
        ("startTime", number(experiment.start)),
        ("stopTime", number(experiment.stop)),
        ("tolerance", number(experiment.tolerance)),
        ("stepSize", number(experiment.step)),
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
    let names = ["kg", "m", "s", "rad"];
    let powers = names.into_iter().zip(unit.exponents).filter(|(_, power)| *power != 0);
    powers.map(|(name, power)| (name, power.to_string())).collect()
}

/// The shortest text that reads back as the same number.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn about(description: &str) -> Option<(&'static str, String)> {
    (!description.is_empty()).then(|| ("description", description.to_owned()))
}

/// What XML cannot hold, line breaks among them, becomes a space.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

fn leaf(out: &mut Out, name: &str, attributes: Attributes) -> io::Result<()> {
    let attributes: Vec<_> = attributes.into_iter().map(|(key, value)| (key, printable(&value))).collect();
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_str()));
    out.create_element(name).with_attributes(attributes).write_empty().map(|_| ())
}

fn element(
    out: &mut Out,
    name: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Out) -> io::Result<()>,
) -> io::Result<()> {
    let attributes: Vec<_> = attributes.into_iter().map(|(key, value)| (key, printable(&value))).collect();
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_str()));
    out.create_element(name).with_attributes(attributes).write_inner_content(content).map(|_| ())
}
