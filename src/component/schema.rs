//! The scene as a JSON Schema, from the same keys that the decoder and the reference read: editors complete and check scenes by it.

use serde_json::{Map, Value, json};

use super::{Component, Section, body, outline, shape, transfer};
use crate::model::Range;
use crate::scene::key::{Form, Key, Need};
use crate::scene::record::Record;
use crate::scene::tables;

/// The schema of scene files (JSON Schema, draft 2020-12).
pub fn schema() -> String {
    let mut top = object(tables::SCENE);
    top["properties"]["$schema"] = json!({ "type": "string" });
    top["properties"]["format"] = json!({ "const": 1, "description": plain(tables::SCENE[0].about) });
    let mut whole = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cotree scene",
        "description": "A planar mechanism: bodies, joints, drivers, loads, inputs and outputs",
    });
    for (key, value) in top.as_object().into_iter().flatten() {
        whole[key] = value.clone();
    }
    whole["$defs"] = definitions();
    // A tree of texts, numbers and lists can always be written.
    format!("{whole:#}\n")
}

fn definitions() -> Value {
    json!({
        "quantity": {
            "type": ["number", "string"],
            "description": "a number in SI, a number with a unit (\"120 mm\"), or an expression (\"crank_length/2\")",
        },
        "vector": { "type": "array", "items": reference("quantity"), "minItems": 1, "maxItems": 2 },
        "corner": { "anyOf": [{ "type": "string" }, reference("vector")] },
        "name": { "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" },
        "parameter": either(tables::PARAMETER),
        "input": either(tables::INPUT),
        "pulley": object(tables::PULLEY),
        "profile_corner": object(tables::CORNER),
        "drum": object(tables::DRUM),
        "state": object(tables::STATE),
        "sampler": object(tables::SAMPLED),
        "sampled_value": { "oneOf": [reference("quantity"), object(tables::SAMPLED_VALUE)] },
        "event": object(tables::EVENT),
        "signal": signal(),
        "output": either(tables::OUTPUT),
        "initial": {
            "anyOf": [
                reference("quantity"),
                object(tables::GUESS),
                { "type": "object", "additionalProperties": reference("initial"), "not": { "required": ["guess"] } },
            ],
        },
        "body": object(body::KEYS),
        "joint": parts(Section::Joints),
        "driver": parts(Section::Drivers),
        "load": parts(Section::Loads),
        "part": part(),
        "outline": { "oneOf": outline::ALL.iter().map(|kind| outline_of(kind)).collect::<Vec<_>>() },
        "shape": { "oneOf": shape::ALL.iter().map(|shape| shape_of(shape)).collect::<Vec<_>>() },
    })
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// A table of named entries.
fn named(entry: &str) -> Value {
    json!({ "type": "object", "propertyNames": reference("name"), "additionalProperties": reference(entry) })
}

/// A number or a table with these keys.
fn either(keys: &[Key]) -> Value {
    json!({ "anyOf": [reference("quantity"), object(keys)] })
}

/// A table with these keys and no others.
fn object(keys: &[Key]) -> Value {
    object_of(keys, property)
}

/// A table with these keys and no others; how the value of each is written.
pub(crate) fn object_of<F>(keys: &[Key<F>], property: impl Fn(&Key<F>) -> Value) -> Value {
    let properties: Map<String, Value> = keys.iter().map(|key| (key.name.to_string(), property(key))).collect();
    let required: Vec<&str> =
        keys.iter().filter(|key| matches!(key.need, Need::Required(_))).map(|key| key.name).collect();
    let alternatives: Vec<Value> = keys
        .iter()
        .filter(|key| matches!(key.need, Need::OneOf(_)))
        .map(|key| json!({ "required": [key.name] }))
        .collect();
    let mut object = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !required.is_empty() {
        object["required"] = json!(required);
    }
    if !alternatives.is_empty() {
        object["oneOf"] = json!(alternatives);
    }
    object
}

/// Joints, drivers or loads: a table for each component.
fn parts(section: Section) -> Value {
    let one = |component: &'static Component| {
        let mut table = object(component.keys);
        table["title"] = json!(component.words());
        table["description"] = json!(component.about);
        if section != Section::Drivers {
            table["properties"]["type"] = json!({ "const": component.name });
            let mut required = vec![json!("type")];
            required.extend(table["required"].as_array().into_iter().flatten().cloned());
            table["required"] = Value::Array(required);
        }
        table
    };
    json!({ "oneOf": section.components().map(one).collect::<Vec<_>>() })
}

/// A number, a law with its unit, or a table of one of the types.
fn signal() -> Value {
    let typed = |transfer: &&transfer::Transfer| {
        let mut table = object(&transfer.all_keys());
        table["title"] = json!(transfer.name);
        table["description"] = json!(transfer.about);
        table["properties"]["type"] = json!({ "const": transfer.name });
        let mut required = vec![json!("type")];
        required.extend(table["required"].as_array().into_iter().flatten().cloned());
        table["required"] = Value::Array(required);
        table
    };
    let plain = [reference("quantity"), object(tables::SIGNAL)];
    json!({ "anyOf": plain.into_iter().chain(transfer::ALL.iter().map(typed)).collect::<Vec<_>>() })
}

/// A file that is a part: the parameters that it has are its own.
fn part() -> Value {
    let mut part = object(tables::PART);
    part["properties"]["parameters"]["additionalProperties"] = reference("quantity");
    part
}

fn shape_of(shape: &shape::Shape) -> Value {
    let place = Key { need: Need::Required(""), ..shape.place };
    let mut table = object(&[&[place], &shape.all_keys()[1..]].concat());
    table["title"] = json!(place.name);
    table["description"] = json!(shape.about);
    table
}

fn outline_of(kind: &outline::OutlineKind) -> Value {
    let mut table = object(&[Key { need: Need::Required(""), ..kind.place }, kind.offset]);
    table["title"] = json!(kind.place.name);
    table["description"] = json!(kind.about);
    table
}

fn property(key: &Key) -> Value {
    let mut value = form(key);
    let unit = super::reference::unit(key.form);
    let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    let default = match key.need {
        Need::Default(otherwise) if otherwise != "none" => format!("; {} if absent", plain(otherwise)),
        _ => String::new(),
    };
    value["description"] = json!(format!("{}{unit}{default}", plain(key.about)));
    value
}

fn form(key: &Key) -> Value {
    let strings = |least: usize, most: usize| json!({ "type": "array", "items": { "type": "string" }, "minItems": least, "maxItems": most });
    match key.form {
        Form::Constant(_, range) => constant(range),
        Form::Law(_) | Form::Curve(..) => reference("quantity"),
        Form::Vector(_) | Form::ConstantVector(_) | Form::Axis => reference("vector"),
        Form::Ends => {
            let end = json!({ "anyOf": [{ "type": "string" }, reference("drum")] });
            json!({ "type": "array", "items": end, "minItems": 2, "maxItems": 2 })
        }
        Form::Course => json!({ "type": "array", "items": reference("pulley") }),
        Form::Profile => {
            let corner = json!({ "anyOf": [reference("vector"), reference("profile_corner")] });
            json!({ "type": "array", "items": corner, "minItems": 2 })
        }
        Form::Points | Form::Bodies | Form::BodyAndPoint => strings(2, 2),
        Form::Point | Form::Body | Form::Joint | Form::OtherJoint | Form::CarrierBody | Form::CarrierPoint => {
            json!({ "type": "string" })
        }
        Form::Text | Form::UnitOf(_) => json!({ "type": "string" }),
        Form::Names => json!({ "type": "array", "items": { "type": "string" } }),
        Form::Switch => json!({ "type": "boolean" }),
        Form::Choice(words, _) => json!({ "enum": words }),
        Form::Record(record) => self::record(record),
        Form::Motion(_) => json!({
            "anyOf": [reference("quantity"), {
                "type": "object",
                "properties": { "input": { "type": "string" }, "as": { "enum": crate::scene::InputAs::WORDS } },
                "required": ["input", "as"],
                "additionalProperties": false,
            }],
        }),
        Form::NamedPoints => named("vector"),
        Form::Corner => reference("corner"),
        Form::Corners(least, most) if most == usize::MAX => {
            json!({ "type": "array", "items": reference("corner"), "minItems": least })
        }
        Form::Corners(least, most) => {
            json!({ "type": "array", "items": reference("corner"), "minItems": least, "maxItems": most })
        }
        Form::Shape => reference("shape"),
        Form::Outline => reference("outline"),
        Form::Pairs => json!({ "type": "array", "items": strings(2, 2) }),
        Form::Table => section(key.name),
    }
}

/// A table with the keys of a record.
fn record(record: Record) -> Value {
    let properties: Map<String, Value> =
        record.entries().iter().map(|entry| (entry.name.to_owned(), constant(entry.range))).collect();
    let mut value = json!({ "type": "object", "properties": properties });
    match record.needed() {
        [] => {}
        [one] => value["required"] = json!([one]),
        several => {
            let any: Vec<Value> = several.iter().map(|key| json!({ "required": [key] })).collect();
            value["anyOf"] = json!(any);
        }
    }
    value["additionalProperties"] = json!(false);
    value
}

/// A number, within its bounds where it is written as one.
fn constant(range: Range) -> Value {
    let bound = match range {
        Range::Any => return reference("quantity"),
        Range::NotNegative => json!({ "minimum": 0 }),
        Range::Positive => json!({ "exclusiveMinimum": 0 }),
        Range::NotZero => json!({ "not": { "const": 0 } }),
        Range::Share => json!({ "minimum": 0, "maximum": 1 }),
        Range::FromOne => json!({ "minimum": 1 }),
    };
    json!({ "allOf": [reference("quantity"), bound] })
}

/// A table at the top of a scene.
fn section(name: &str) -> Value {
    match name {
        "parameters" => named("parameter"),
        "inputs" => named("input"),
        "states" => named("state"),
        "sampled" => named("sampler"),
        "values" => named("sampled_value"),
        "set" => named("quantity"),
        "events" => named("event"),
        "signals" => named("signal"),
        "ground" => object(tables::GROUND),
        "bodies" => named("body"),
        "joints" => named("joint"),
        "drivers" => named("driver"),
        "loads" => named("load"),
        "parts" => named("part"),
        "initial" => json!({ "type": "object", "additionalProperties": reference("initial") }),
        "outputs" => {
            let mut outputs = object(tables::OUTPUTS);
            outputs["additionalProperties"] = reference("output");
            outputs
        }
        "experiment" => object(tables::EXPERIMENT),
        "clearance" => object(tables::CLEARANCE),
        "display" => object(tables::DISPLAY),
        "solver" => object(tables::SOLVER),
        "coordinates" => object(tables::COORDINATES),
        _ => json!({ "type": "object" }),
    }
}

/// Words of the reference without its links and code marks.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once('[') {
        match link.split_once("](").and_then(|(words, rest)| Some((words, rest.split_once(')')?.1))) {
            Some((words, after)) if !words.contains('[') => {
                plain += before;
                plain += words;
                rest = after;
            }
            _ => {
                plain += before;
                plain.push('[');
                rest = link;
            }
        }
    }
    (plain + rest).replace('`', "")
}
