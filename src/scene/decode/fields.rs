//! Tables with known keys, and values of the right type.

use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::scene::document::{Content, Node};
use crate::scene::model::Vector;
use crate::scene::quantity::{Quantity, Value};

/// A table whose keys are all known.
pub(crate) struct Fields<'n> {
    /// Whose table it is, for messages: "joint `wrist_pin`".
    pub owner: String,
    /// Where its owner is named.
    pub span: Span,
    entries: &'n [(Text, Node)],
    /// Entries whose keys are not known, with the keys that may be meant: they are read as these, so that a slip is one fault.
    meant: Vec<(String, &'n (Text, Node))>,
}

impl<'n> Fields<'n> {
    /// The fields of a table; unknown keys and what is no table are faults.
    pub fn open(node: &'n Node, owner: &str, span: Span, keys: &[&str], faults: &mut Sink) -> Option<Fields<'n>> {
        let mut fields = Fields::open_any(node, owner, span, faults)?;
        for entry in fields.entries {
            let key = &entry.0;
            // Editors find the schema of a JSON file by this key.
            if !keys.contains(&key.text.as_str()) && key.text != "$schema" {
                let otherwise = format!("the keys of {owner} are {}", suggest::list(keys.iter().copied()));
                faults.push(
                    Fault::new("scene::unknown_key", format!("{owner} has no key `{}`", key.text), key.span)
                        .label("unknown key")
                        .help(suggest::hint(&key.text, keys.iter().copied(), otherwise)),
                );
                let near = suggest::nearest(&key.text, keys.iter().copied());
                fields.meant.extend(near.map(|near| (near.to_string(), entry)));
            }
        }
        Some(fields)
    }

    /// The fields of a table, whatever they are.
    pub fn open_any(node: &'n Node, owner: &str, span: Span, faults: &mut Sink) -> Option<Fields<'n>> {
        let Content::Table(entries) = &node.kind else {
            faults.push(wrong_type(node, owner, "a table"));
            return None;
        };
        Some(Fields { owner: owner.to_string(), span, entries, meant: Vec::new() })
    }

    pub fn get(&self, key: &str) -> Option<&'n Node> {
        self.all(key).next().map(|(_, node)| node)
    }

    pub fn key_span(&self, key: &str) -> Option<Span> {
        self.all(key).next().map(|(other, _)| other.span)
    }

    /// What is written for a key, and then for what may be meant by it.
    pub fn all(&self, key: &str) -> impl Iterator<Item = &'n (Text, Node)> {
        let own = self.entries.iter().filter(move |(other, _)| other.text == key);
        own.chain(self.meant.iter().filter(move |(meant, _)| meant == key).map(|(_, entry)| *entry))
    }

    /// The value of a key; a fault with the advice `help` if it is not there.
    pub fn required(&self, key: &str, help: &str, faults: &mut Sink) -> Option<&'n Node> {
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

fn wrong_type(node: &Node, what: &str, wanted: &str) -> Fault {
    Fault::new("scene::wrong_type", format!("{what} is {}, but must be {wanted}", node.kind.name()), node.span)
        .label(format!("not {wanted}"))
}

impl Sink {
    pub fn entries<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n [(Text, Node)]> {
        let entries = if let Content::Table(entries) = &node.kind { Some(&entries[..]) } else { None };
        self.expect(entries, node, what, "a table")
    }

    fn expect<T>(&mut self, found: Option<T>, node: &Node, what: &str, wanted: &str) -> Option<T> {
        if found.is_none() {
            self.push(wrong_type(node, what, wanted));
        }
        found
    }

    pub fn text(&mut self, node: &Node, what: &str) -> Option<Text> {
        self.expect(node.text(), node, what, "a text in quotes")
    }

    pub fn boolean(&mut self, node: &Node, what: &str) -> Option<bool> {
        let value = if let Content::Boolean(value) = node.kind { Some(value) } else { None };
        self.expect(value, node, what, "true or false")
    }

    pub fn quantity(&mut self, node: &Node, what: &str) -> Option<Quantity> {
        let value = match &node.kind {
            Content::Number(number) => Value::Number(*number),
            Content::Text(text) => Value::Text(text.clone()),
            _ => {
                let fault = wrong_type(node, what, "a number or a text")
                    .help("such as `0.12`, `\"120 mm\"` or `\"0.5*crank_length\"`");
                self.push(fault);
                return None;
            }
        };
        Some(Quantity { value, span: node.span })
    }

    /// One or two components; `resolve` knows how many there must be.
    pub fn vector(&mut self, node: &Node, what: &str) -> Option<Vector> {
        let Content::Array(items) = &node.kind else {
            self.push(wrong_type(node, what, "a list of two numbers").help("such as `[0.0, -9.81]`"));
            return None;
        };
        let components: Option<Vec<Quantity>> = items.iter().map(|item| self.quantity(item, what)).collect();
        components.map(|components| Vector { components, span: node.span })
    }

    pub fn texts(&mut self, node: &Node, what: &str) -> Option<Vec<Text>> {
        let Content::Array(items) = &node.kind else {
            self.push(wrong_type(node, what, "a list of names").help("such as `[\"crank\", \"rod\"]`"));
            return None;
        };
        let item = format!("an entry of {what}");
        Some(items.iter().filter_map(|node| self.text(node, &item)).collect())
    }

    pub fn pair(&mut self, node: &Node, what: &str, help: &str) -> Option<[Text; 2]> {
        let names = self.texts(node, what)?;
        let count = names.len();
        let pair: Option<[Text; 2]> = names.try_into().ok();
        if pair.is_none() && matches!(&node.kind, Content::Array(items) if items.len() == count) {
            self.push(
                Fault::new("scene::wrong_value", format!("{what} names {count} instead of two"), node.span)
                    .label("two are wanted")
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
