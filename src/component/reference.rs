//! The components as a text: what each is, its terminal equations, its keys with their units, its variables.

use std::fmt::Write;

use super::{Facts, Form, Key, Need, Section};

/// Every component in Markdown, a chapter for each section of the scene.
pub fn reference() -> String {
    let mut text = String::new();
    for section in [Section::Joints, Section::Drivers, Section::Loads] {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "## `[{}s]`\n", section.word());
        for component in section.components() {
            chapter(component.facts(), &mut text);
        }
    }
    text
}

fn chapter(facts: &Facts, text: &mut String) {
    let heading = if facts.section == Section::Drivers { "key" } else { "type" };
    let _ = writeln!(text, "### {heading} `{}`\n", facts.name);
    let _ = writeln!(text, "{}: {}\n", capital(facts.about), facts.equations);
    let _ = writeln!(text, "| key | what it says | unit | default |\n|---|---|---|---|");
    for key in facts.keys {
        let unit = unit(key);
        let unit = if unit.is_empty() { String::new() } else { format!("`{unit}`") };
        let _ = writeln!(text, "| `{}` | {} | {unit} | {} |", key.name, key.about, default(key));
    }
    let variables: Vec<String> = facts.variables.iter().map(|quantity| format!("`{}`", quantity.word())).collect();
    let _ = writeln!(
        text,
        "\nVariables: {}\n",
        variables.into_iter().chain(["`power`".to_string()]).collect::<Vec<_>>().join(", ")
    );
}

fn capital(text: &str) -> String {
    let (first, rest) = text.split_at(text.len().min(1));
    first.to_uppercase() + rest
}

fn unit(key: &Key) -> String {
    match key.form {
        Form::Constant(wanted, _) | Form::Law(wanted) | Form::Vector(wanted) => wanted.si.to_string(),
        Form::Motion([motion, ..]) => motion.si.to_string(),
        Form::Friction([level, velocity]) => format!("{}, {}", level.si, velocity.si),
        _ => String::new(),
    }
}

fn default(key: &Key) -> String {
    match (key.need, key.form) {
        (Need::Required(_), _) => "must be given".to_string(),
        (Need::OneOf(_), _) => "one of these".to_string(),
        (_, Form::Constant(..)) => "0".to_string(),
        (_, Form::Choice([first, ..], _)) => format!("`\"{first}\"`"),
        (_, Form::CarrierBody | Form::CarrierPoint) => "`\"ground\"`".to_string(),
        _ => "none".to_string(),
    }
}
