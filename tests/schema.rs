//! The JSON Schema of scenes: it is that of this program, permits what is right, and refuses what is wrong.

use crate::outside::command;
use crate::support::ROOT;

use std::path::Path;

use cotree::scene::Scene;
use cotree::task::Task;
use serde_json::Value;

use command::{code, cotree, stdout};

fn schema() -> Value {
    written("schema/scene.schema.json", &["schema"])
}

/// The schema of a file, which has to be what the command prints.
fn written(file: &str, command: &[&str]) -> Value {
    let path = Path::new(ROOT).join(file);
    let made = stdout(&cotree(Path::new("."), command));
    if std::env::var_os("COTREE_WRITE_REFERENCE").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap();
    assert!(written == made, "{file} is not up to date: COTREE_WRITE_REFERENCE=1 cargo test --test all schema::");
    serde_json::from_str(&made).unwrap()
}

/// What is wrong with a value; the keywords of JSON Schema that the schema uses, and no others.
fn wrong(whole: &Value, schema: &Value, value: &Value, place: &str) -> Option<String> {
    let inner = |schema: &Value, value: &Value, more: &str| wrong(whole, schema, value, &format!("{place}{more}"));
    let all = |schema: &Value| -> Vec<Value> { schema.as_array().unwrap().clone() };
    for (keyword, rule) in schema.as_object().unwrap() {
        let number = |limit: &Value| value.as_f64().zip(limit.as_f64());
        let fault = match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" | "properties" => None,
            "$ref" => inner(whole.pointer(&rule.as_str().unwrap()[1..]).expect("a definition"), value, ""),
            "type" => {
                let own = match value {
                    Value::Object(_) => "object",
                    Value::Array(_) => "array",
                    Value::String(_) => "string",
                    Value::Number(_) => "number",
                    Value::Bool(_) => "boolean",
                    Value::Null => "null",
                };
                let permitted = if rule.is_array() { all(rule) } else { vec![rule.clone()] };
                (!permitted.iter().any(|kind| kind == own)).then(|| format!("{place} is {own}, not {rule}"))
            }
            "const" => (value.as_f64() != rule.as_f64() || value.as_str() != rule.as_str())
                .then(|| format!("{place} is not {rule}")),
            "enum" => (!all(rule).contains(value)).then(|| format!("{place} is not one of {rule}")),
            "required" => {
                let missing = all(rule).into_iter().find(|key| value.get(key.as_str().unwrap()).is_none());
                missing.map(|key| format!("{place} lacks {key}"))
            }
            "additionalProperties" => {
                value.as_object().into_iter().flatten().find_map(|(key, value)| match schema["properties"].get(key) {
                    Some(own) => inner(own, value, &format!(".{key}")),
                    None if rule == false => Some(format!("{place} has {key}")),
                    None => inner(rule, value, &format!(".{key}")),
                })
            }
            "propertyNames" => {
                value.as_object().into_iter().flatten().find_map(|(key, _)| inner(rule, &key.as_str().into(), ""))
            }
            "pattern" => {
                assert_eq!(rule, "^[A-Za-z_][A-Za-z0-9_]*$");
                let text = value.as_str().unwrap();
                let word = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                    && !text.starts_with(|c: char| c.is_ascii_digit());
                (!word || text.is_empty()).then(|| format!("{text} is no name"))
            }
            "items" => value.as_array().into_iter().flatten().find_map(|item| inner(rule, item, "[]")),
            "minItems" => value
                .as_array()
                .filter(|list| (list.len() as u64) < rule.as_u64().unwrap())
                .map(|_| format!("{place} is short")),
            "maxItems" => value
                .as_array()
                .filter(|list| list.len() as u64 > rule.as_u64().unwrap())
                .map(|_| format!("{place} is long")),
            "minimum" => number(rule).filter(|(value, limit)| value < limit).map(|_| format!("{place} is too small")),
            "maximum" => number(rule).filter(|(value, limit)| value > limit).map(|_| format!("{place} is too large")),
            "exclusiveMinimum" => {
                number(rule).filter(|(value, limit)| value <= limit).map(|_| format!("{place} is too small"))
            }
            "allOf" => all(rule).iter().find_map(|part| inner(part, value, "")),
            "anyOf" => {
                let faults: Vec<Option<String>> = all(rule).iter().map(|part| inner(part, value, "")).collect();
                faults.iter().all(Option::is_some).then(|| format!("{place}: {faults:?}"))
            }
            "oneOf" => {
                let faults: Vec<Option<String>> = all(rule).iter().map(|part| inner(part, value, "")).collect();
                (faults.iter().filter(|fault| fault.is_none()).count() != 1).then(|| format!("{place}: {faults:?}"))
            }
            "not" => inner(rule, value, "").is_none().then(|| format!("{place} must not be {rule}")),
            unknown => panic!("the schema uses `{unknown}`"),
        };
        if fault.is_some() {
            return fault;
        }
    }
    None
}

/// A TOML scene as JSON.
fn json(text: &str) -> Value {
    fn value(toml: toml::Value) -> Value {
        match toml {
            toml::Value::Table(table) => Value::Object(table.into_iter().map(|(key, own)| (key, value(own))).collect()),
            toml::Value::Array(list) => list.into_iter().map(value).collect(),
            toml::Value::String(text) => text.into(),
            toml::Value::Integer(number) => number.into(),
            toml::Value::Float(number) => number.into(),
            toml::Value::Boolean(is) => is.into(),
            toml::Value::Datetime(date) => date.to_string().into(),
        }
    }
    value(toml::Value::Table(text.parse().unwrap()))
}

fn scenes() -> Vec<(String, String)> {
    let root = Path::new(ROOT);
    let mut paths: Vec<_> =
        root.join("models").read_dir().unwrap().map(|entry| entry.unwrap().path().join("scene.toml")).collect();
    for folder in ["tests/scenes", "tests/scenes/components", "benches/scenes"] {
        paths.extend(root.join(folder).read_dir().unwrap().map(|entry| entry.unwrap().path()));
    }
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    assert!(paths.len() > 25);
    paths.iter().map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn every_scene_is_valid_and_names_a_schema_that_is_there() {
    let schema = schema();
    for (path, text) in scenes() {
        assert_eq!(wrong(&schema, &schema, &json(&text), "").map(|why| format!("{path}: {why}")), None);
        if let Some(named) = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")) {
            assert!(Path::new(&path).parent().unwrap().join(named).exists(), "{path} names {named}");
        }
    }
    let json: Value = serde_json::from_str(include_str!("scenes/slider_crank.json")).unwrap();
    assert_eq!(wrong(&schema, &schema, &json, ""), None);
}

#[test]
fn what_the_program_refuses_for_its_form_the_schema_refuses_too() {
    let schema = schema();
    let right = include_str!("scenes/slider_crank.toml");
    let mistakes = [
        ("mass = 2.0", "mas = 2.0"),
        ("mass = 2.0", "mass = -2.0"),
        ("mass = 2.0", "mass = [2.0]"),
        ("mass = 2.0", "mass = true"),
        ("type = \"revolute\"", "type = \"hinge\""),
        ("type = \"revolute\"", "axis = [1, 0]\ntype = \"revolute\""),
        ("between = [\"ground.bearing\", \"crank.inner\"]", "between = [\"ground.bearing\"]"),
        ("axis = [1.0, 0.0]", ""),
        ("[experiment]", "[experiment]\nend = 3"),
        ("[initial]", "[initial]\n\"crank.x\" = { guess = true }"),
        ("[outputs]", "[outputs]\nforce = { unit = \"N\" }"),
    ];
    let right: String =
        right.lines().map(|line| format!("{}\n", line.split_whitespace().collect::<Vec<_>>().join(" "))).collect();
    assert_eq!(wrong(&schema, &schema, &json(&right), ""), None);
    for (before, after) in mistakes {
        assert!(right.contains(before), "{before}\n{right}");
        let text = right.replacen(before, after, 1);
        assert!(wrong(&schema, &schema, &json(&text), "").is_some(), "{after}");
        assert!(Scene::from_toml(&text).and_then(|scene| scene.resolve()).is_err(), "{after}");
    }
    let drivers =
        ["joint = \"a\"\nangle = \"t\"\n", "between = [\"a\", \"b\"]\nangle = { input = \"u\", as = \"velocity\" }\n"];
    for (text, right) in
        drivers.map(|text| (text, true)).into_iter().chain([("joint = \"a\"\n", false), ("angle = \"t\"\n", false)])
    {
        let scene = json(&format!("name = \"d\"\n[drivers.d]\n{text}"));
        assert_eq!(wrong(&schema, &schema, &scene, "").is_none(), right, "{text}");
    }
}

/// What the program reads as a task the schema permits, and what it refuses for its form the schema refuses too.
#[test]
fn tasks_have_a_schema_that_says_what_is_read() {
    let schema = written("schema/task.schema.json", &["schema", "--task"]);
    let permitted = |text: &str| wrong(&schema, &schema, &json(text), "").is_none();
    let is_read = |text: &str| Task::from_text(text).is_ok();
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/synthesis.md")).unwrap();
    let blocks = page.split("```toml ").skip(1).filter_map(|block| block.split_once('\n'));
    let mut tasks: Vec<&str> = blocks.filter_map(|(_, text)| text.split("```").next()).collect();
    tasks.extend([
        "[poses]\nat = [[0, 0, 0], [1, 0, 0.5]]\ntolerance = \"1 mm\"\nweight = [1, 2]\n",
        "[function]\ninput = [0, 1, 2]\noutput = [0, \"1 mm\", 3]\ninput_zero = 0.1\n",
        "[function]\ninput = [0, 1]\noutput = \"x^2\"\nx = [0, 1]\nrange = [0, 1]\nground = 2\n",
        "[path]\npoints = [[0, 0], [1, 0], [1, 1]]\nclosed = true\ncrank = [0, 1, 2]\npivots = [[0, 0], [1, 0]]\n",
        "[stroke]\ncrank_turn = 3\nstroke = 0.2\noffset = 0\n[limits]\nground = [[0, 0], [1, 0], [1, 1]]\ncrank = true\nlength = [0.1, 1]\n",
    ]);
    assert!(tasks.len() >= 8);
    for text in tasks {
        assert!(permitted(text) && is_read(text), "{text}");
    }
    for text in [
        "name = \"none\"\n",
        "[poses]\nat = [[0, 0], [1, 0]]\n",
        "[poses]\nat = [[0, 0, 0]]\n",
        "[poses]\nat = [[0, 0, 0], [1, 0, 1]]\n[path]\npoints = [[0, 0], [1, 0], [1, 1]]\n",
        "[path]\npoints = [[0, 0], [1, 0]]\n",
        "[path]\npoints = [[0, 0], [1, 0], [1, 1]]\nopen = true\n",
        "[function]\ninput = [0, 1, 2]\n",
        "[stroke]\ncrank_turn = 3\nstroke = true\n",
        "[stroke]\ncrank_turn = 3\nstroke = 1\n[limits]\nlength = [1]\n",
        "[stroke]\ncrank_turn = 3\nstroke = 1\n[limits]\nground = { x = [0, 1], z = [0, 1] }\n",
    ] {
        assert!(!permitted(text) && !is_read(text), "{text}");
    }
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let commands = ["new", "check", "show", "simulate", "export", "schema"];
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = cotree(folder.path(), &["completions", shell]);
        let text = stdout(&output);
        assert!(code(&output) == 0 && commands.iter().all(|command| text.contains(command)), "{shell}");
    }
    let written = cotree(folder.path(), &["man", "pages"]);
    assert_eq!(code(&written), 0);
    for command in commands {
        let page = std::fs::read_to_string(folder.path().join(format!("pages/cotree-{command}.1"))).unwrap();
        assert!(page.contains(".TH") && page.contains("SYNOPSIS"), "{page:.300}");
    }
    assert!(stdout(&written).contains("cotree.1"));
    assert!(std::fs::read_to_string(folder.path().join("pages/cotree-simulate.1")).unwrap().contains("overlay"));
}
