//! Tables with known keys, and values of the right type.

use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::model::Vector;
use crate::scene::quantity::{Quantity, Value};

/// A table whose keys are all known.
pub(crate) struct Fields<'n> {
    /// Whose table it is, for messages: "joint `wrist_pin`".
    pub owner: String,
    /// Where its owner is named.
    pub span: Span,
    entries: &'n [(Text, DocumentNode)],
    /// Entries whose keys are not known, with the keys that may be meant: they are read as these, so that a slip is one fault.
    meant: Vec<(String, &'n (Text, DocumentNode))>,
    /// The others whose keys are not known.
    strange: Vec<&'n (Text, DocumentNode)>,
}

impl<'n> Fields<'n> {
    /// The fields of a table; unknown keys and what is no table are faults.
    pub fn open(
        node: &'n DocumentNode,
        owner: &str,
        span: Span,
        keys: &[&str],
        faults: &mut Sink,
    ) -> Option<Fields<'n>> {
        let mut fields = Fields::open_any(node, owner, span, faults)?;
        for entry in fields.entries {
            let key = &entry.0;
            // Editors find the schema of a JSON file by this key.
            if !keys.contains(&key.text.as_str()) && key.text != "$schema" {
                let near = meant(&key.text, keys);
                let help = unknown_key_help(&key.text, owner, near, keys);
                faults.push(
                    Fault::new("scene::unknown_key", format!("{owner} has no key `{}`", key.text), key.span)
                        .label("unknown key")
                        .help(help),
                );
                match near {
                    Some(near) => fields.meant.push((near.to_string(), entry)),
                    None => fields.strange.push(entry),
                }
            }
        }
        Some(fields)
    }

    /// The fields of a table, whatever they are.
    pub fn open_any(node: &'n DocumentNode, owner: &str, span: Span, faults: &mut Sink) -> Option<Fields<'n>> {
        let Content::Table(entries) = &node.kind else {
            faults.push(wrong_type(node, owner, "a table"));
            return None;
        };
        Some(Fields { owner: owner.to_string(), span, entries, meant: Vec::new(), strange: Vec::new() })
    }

    /// The names of tables in tables whose keys are not known: what they are, nobody knows, but they are there.
    pub fn strange_names(&self) -> impl Iterator<Item = &'n str> {
        let tables = self.strange.iter().filter_map(|(_, node)| match &node.kind {
            Content::Table(entries) => Some(entries),
            _ => None,
        });
        let is_table = |(_, node): &&(Text, DocumentNode)| matches!(node.kind, Content::Table(_));
        tables.flatten().filter(is_table).map(|(name, _)| name.text.as_str())
    }

    /// The key of an entry that may be meant by this one.
    pub fn misspelt(&self, key: &str) -> Option<&'n Text> {
        self.entries.iter().map(|(name, _)| name).find(|name| name.text != key && meant(&name.text, &[key]).is_some())
    }

    pub fn get(&self, key: &str) -> Option<&'n DocumentNode> {
        self.all(key).next().map(|(_, node)| node)
    }

    pub fn key_span(&self, key: &str) -> Option<Span> {
        self.all(key).next().map(|(other, _)| other.span)
    }

    /// What is written for a key, and then for what may be meant by it.
    pub fn all(&self, key: &str) -> impl Iterator<Item = &'n (Text, DocumentNode)> {
        let entries = self.entries.iter().filter(move |(other, _)| other.text == key);
        entries.chain(self.meant.iter().filter(move |(meant, _)| meant == key).map(|(_, entry)| *entry))
    }

    /// The value of a key; a fault with the advice `help` if it is not there.
    pub fn required(&self, key: &str, help: &str, faults: &mut Sink) -> Option<&'n DocumentNode> {
        let node = self.get(key);
        if node.is_none() {
            faults.push(
                Fault::new("scene::missing_key", format!("{} has no `{key}`", self.owner), self.span)
                    .label(format!("`{key}` is missing"))
                    .help(help),
            );
        }
        node
    }

    /// "`mass` of body `crank`"
    pub fn name_of(&self, key: &str) -> String {
        format!("`{key}` of {}", self.owner)
    }
}

/// What keys are called by people who know other programs.
const CALLED: [(&str, &[&str]); 17] = [
    ("parameters", &["param", "params", "constants", "variables"]),
    ("ground", &["frame", "fixed", "base"]),
    ("bodies", &["body", "link", "links", "member", "members", "segments"]),
    ("joints", &["constraint", "constraints", "connection", "connections", "hinges"]),
    ("drivers", &["motor", "motors", "drives", "actuator", "actuators"]),
    ("loads", &["force", "forces", "torques", "spring", "springs", "damper", "dampers"]),
    ("initial", &["init", "initial_conditions", "initial_values", "start"]),
    ("experiment", &["simulation", "sim", "time"]),
    ("proportional", &["kp", "k_p", "p", "p_gain"]),
    ("integral", &["ki", "k_i", "i", "i_gain"]),
    ("derivative", &["kd", "k_d", "d", "d_gain"]),
    ("stiffness", &["k", "spring_constant", "spring_rate"]),
    ("damping", &["c", "b", "d", "damping_coefficient"]),
    ("mass", &["m", "weight"]),
    ("inertia", &["i", "j", "izz", "moment_of_inertia"]),
    ("com", &["cg", "cog", "centroid", "center_of_mass", "centre_of_mass"]),
    ("angle", &["theta", "phi", "rotation"]),
];

/// The one of the keys that is meant by a word that is none of them.
fn meant<'k>(word: &str, keys: &[&'k str]) -> Option<&'k str> {
    let word = word.to_lowercase();
    let called = CALLED.iter().filter(|(_, words)| words.contains(&word.as_str()));
    let mut known = called.filter_map(|(key, _)| keys.iter().find(|candidate| *candidate == key));
    known.next().copied().or_else(|| suggest::nearest(&word, keys.iter().copied()))
}

/// What to write where a key is not known.
fn unknown_key_help(key: &str, owner: &str, near: Option<&str>, keys: &[&str]) -> String {
    let of_element = ["type", "between"].contains(&key);
    match near {
        Some(near) => format!("did you mean `{near}`?"),
        None if of_element => {
            "`type` and `between` belong to a joint or a load: write its header above this line, such as `[joints.NAME]`".to_owned()
        }
        None => {
            let known = suggest::joined(keys.iter().map(|key| format!("`{key}`")), keys.len());
            format!("the keys of {owner} are {known}")
        }
    }
}

pub(super) fn wrong_type(node: &DocumentNode, what: &str, wanted: &str) -> Fault {
    let fault =
        Fault::new("scene::wrong_type", format!("{what} is {}, but must be {wanted}", node.kind.name()), node.span)
            .label(format!("not {wanted}"));
    match &node.kind {
        // `[[bodies.NAME]]`
        Content::Array(items)
            if !items.is_empty() && items.iter().all(|item| matches!(item.kind, Content::Table(_))) =>
        {
            fault.help("write the header of a table in single brackets: `[...]`")
        }
        _ => fault,
    }
}

/// A value as it is written in a list, if it is a number or a text.
pub(crate) fn written(node: &DocumentNode) -> Option<String> {
    match &node.kind {
        Content::Number(number) => Some(number.to_string()),
        Content::Text(text) => Some(format!("\"{text}\"")),
        Content::Table(_) | Content::Array(_) | Content::Boolean(_) | Content::Date | Content::Null => None,
    }
}

/// Two components, as near as possible to what is there: `what` begins with the key, whose direction or unit an example has.
pub(super) fn as_vector(node: &DocumentNode, what: &str) -> String {
    let value = |key: &str| match &node.kind {
        Content::Table(entries) => {
            entries.iter().find(|(name, _)| name.text == key).and_then(|(_, node)| written(node))
        }
        _ => None,
    };
    let key = what.trim_start_matches('`').split('`').next().unwrap_or_default();
    match (written(node).filter(|_| is_value(node)), value("x"), value("y")) {
        (Some(value), ..) if key == "gravity" => {
            let down = value.trim_start_matches(['"', '-']);
            let quote = if value.starts_with('"') { "\"" } else { "" };
            format!("gravity acts downwards, against y: write `[0, {quote}-{down}]`")
        }
        (Some(value), ..) => format!("give x and y: `[{value}, 0]`, or `[0, {value}]`"),
        (None, Some(x), Some(y)) => format!("give x and y as a list: `[{x}, {y}]`"),
        _ => format!("give x and y, such as `{}`", example(key, node)),
    }
}

/// A number, a number with its unit or a formula; a mere word is none.
fn is_value(node: &DocumentNode) -> bool {
    match &node.kind {
        Content::Text(text) => !text.trim_start_matches('-').chars().all(|c| c.is_alphabetic() || c == '_'),
        _ => true,
    }
}

/// A vector for a key, along the axis that is named.
fn example(key: &str, node: &DocumentNode) -> &'static str {
    let named = match &node.kind {
        Content::Text(text) => text.trim().to_lowercase(),
        _ => String::new(),
    };
    match (key, named.as_str()) {
        ("axis", "y" | "vertical") => "[0, 1]",
        ("axis", "-x") => "[-1, 0]",
        ("axis", "-y") => "[0, -1]",
        ("axis", _) => "[1, 0]",
        ("gravity", _) => "[0, -9.81]",
        _ => "[\"50 mm\", 0]",
    }
}

/// A list of names, as near as possible to what is there.
fn as_list(node: &DocumentNode) -> String {
    match &node.kind {
        Content::Text(text) => {
            let names = text.split([',', ';', ' ']).filter(|name| !name.is_empty());
            let names: Vec<String> = names.map(|name| format!("\"{name}\"")).collect();
            format!("write `[{}]`", names.join(", "))
        }
        _ => "give names in quotes, between `[` and `]`".to_owned(),
    }
}

impl Sink {
    pub fn entries<'n>(&mut self, node: &'n DocumentNode, what: &str) -> Option<&'n [(Text, DocumentNode)]> {
        let entries = if let Content::Table(entries) = &node.kind { Some(&entries[..]) } else { None };
        self.expect(entries, node, what, "a table")
    }

    /// Points by their names.
    pub fn points<'n>(&mut self, node: &'n DocumentNode, what: &str) -> Option<&'n [(Text, DocumentNode)]> {
        if let Content::Array(_) = &node.kind {
            let help = "each point has a name: `points = { a = [0, 0], b = [\"50 mm\", 0] }`";
            self.push(wrong_type(node, what, "a table").help(help));
            return None;
        }
        self.entries(node, what)
    }

    fn expect<T>(&mut self, found: Option<T>, node: &DocumentNode, what: &str, wanted: &str) -> Option<T> {
        if found.is_none() {
            self.push(wrong_type(node, what, wanted));
        }
        found
    }

    pub fn text(&mut self, node: &DocumentNode, what: &str) -> Option<Text> {
        self.expect(node.text(), node, what, "a text in quotes")
    }

    pub fn boolean(&mut self, node: &DocumentNode, what: &str) -> Option<bool> {
        let value = if let Content::Boolean(value) = node.kind { Some(value) } else { None };
        self.expect(value, node, what, "true or false")
    }

    pub fn quantity(&mut self, node: &DocumentNode, what: &str) -> Option<Quantity> {
        let value = match &node.kind {
            Content::Number(number) => Value::Number(*number),
            Content::Text(text) => Value::Text(text.clone()),
            _ => {
                let fault = wrong_type(node, what, "a number or a text")
                    .help("such as `0.12`, `\"120 mm\"`, or an expression in quotes: `\"2*0.06\"`");
                self.push(fault);
                return None;
            }
        };
        Some(Quantity { value, span: node.span })
    }

    /// One or two components; `resolve` knows how many there must be.
    pub fn vector(&mut self, node: &DocumentNode, what: &str) -> Option<Vector> {
        let Content::Array(items) = &node.kind else {
            self.push(wrong_type(node, what, "a list of two numbers").help(as_vector(node, what)));
            return None;
        };
        let components: Option<Vec<Quantity>> = items.iter().map(|item| self.quantity(item, what)).collect();
        components.map(|components| Vector { components, span: node.span })
    }

    pub fn texts(&mut self, node: &DocumentNode, what: &str) -> Option<Vec<Text>> {
        let Content::Array(items) = &node.kind else {
            self.push(wrong_type(node, what, "a list of names").help(as_list(node)));
            return None;
        };
        let item = format!("an entry of {what}");
        Some(items.iter().filter_map(|node| self.text(node, &item)).collect())
    }

    pub fn pair(&mut self, node: &DocumentNode, what: &str, help: &str) -> Option<[Text; 2]> {
        let names = self.texts(node, what)?;
        let count = names.len();
        let pair: Option<[Text; 2]> = names.try_into().ok();
        if pair.is_none() && matches!(&node.kind, Content::Array(items) if items.len() == count) {
            self.push(
                Fault::new("scene::wrong_value", format!("{what} must have two entries, but has {count}"), node.span)
                    .label("two are needed")
                    .help(help),
            );
        }
        pair
    }

    pub fn optional_quantity(&mut self, fields: &Fields<'_>, key: &str) -> Option<Quantity> {
        fields.get(key).and_then(|node| self.quantity(node, &fields.name_of(key)))
    }

    pub fn optional_text(&mut self, fields: &Fields<'_>, key: &str) -> Option<Text> {
        fields.get(key).and_then(|node| self.text(node, &fields.name_of(key)))
    }

    pub fn required_quantity(&mut self, fields: &Fields<'_>, key: &str, help: &str) -> Option<Quantity> {
        let node = fields.required(key, help, self)?;
        self.quantity(node, &fields.name_of(key))
    }

    pub fn required_text(&mut self, fields: &Fields<'_>, key: &str, help: &str) -> Option<Text> {
        let node = fields.required(key, help, self)?;
        self.text(node, &fields.name_of(key))
    }
}
