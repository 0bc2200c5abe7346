//! Tasks as a JSON Schema, from the keys that the reader takes: editors complete and check tasks by it.

use serde_json::{Value, json};

use super::{CHOOSE, FUNCTION, KINDS, LIMITS, PATH, POSES, STROKE, TaskKey, ValueForm};
use crate::component::object_of;

/// The schema of task files (JSON Schema, draft 2020-12).
pub fn schema() -> String {
    let kind = |name: &str| json!({ "required": [name] });
    let whole = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cotree task",
        "description": "A task of linkage synthesis: poses, a function, a path or a stroke, and limits",
        "type": "object",
        "additionalProperties": false,
        "oneOf": KINDS.map(kind),
        "properties": {
            "$schema": { "type": "string" },
            "name": { "type": "string", "description": "the name of the task" },
            "description": { "type": "string", "description": "one line about the task" },
            "poses": table(POSES),
            "function": table(FUNCTION),
            "path": table(PATH),
            "stroke": table(STROKE),
            "limits": table(LIMITS),
            "choose": table(CHOOSE),
        },
        "$defs": {
            "quantity": {
                "type": ["number", "string"],
                "description": "a number in SI, or a number with a unit (\"120 mm\")",
            },
            "numbers": { "type": "array", "items": reference("quantity") },
            "pair": list("quantity", 2),
        },
    });
    format!("{whole:#}\n")
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// A list of so many.
fn list(of: &str, count: usize) -> Value {
    json!({ "type": "array", "items": reference(of), "minItems": count, "maxItems": count })
}

fn table(keys: &[TaskKey]) -> Value {
    object_of(keys, |key| {
        let mut value = key.form.schema();
        value["description"] = json!(key.about);
        value
    })
}

impl ValueForm {
    fn schema(self) -> Value {
        let either = |one: Value, other: Value| json!({ "anyOf": [one, other] });
        let text = || json!({ "type": "string" });
        match self {
            ValueForm::Number => reference("quantity"),
            ValueForm::Numbers => reference("numbers"),
            ValueForm::Each => either(reference("quantity"), reference("numbers")),
            ValueForm::Pair | ValueForm::Point => reference("pair"),
            ValueForm::NumbersOrLaw => either(text(), reference("numbers")),
            ValueForm::Flag => json!({ "type": "boolean" }),
            ValueForm::Bars => json!({ "enum": [4, 6] }),
            ValueForm::Preference => json!({ "enum": ["size", "transmission"] }),
            ValueForm::TwoPoints => list("pair", 2),
            ValueForm::PointsOrTable => {
                either(text(), json!({ "type": "array", "items": reference("pair"), "minItems": 3 }))
            }
            ValueForm::Poses => either(text(), json!({ "type": "array", "items": list("quantity", 3), "minItems": 2 })),
            ValueForm::Area => {
                let sides = json!({ "x": reference("pair"), "y": reference("pair") });
                let sides = json!({ "type": "object", "properties": sides, "additionalProperties": false });
                either(sides, json!({ "type": "array", "items": reference("pair"), "minItems": 3 }))
            }
        }
    }
}
