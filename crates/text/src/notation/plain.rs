//! Formulas as plain text, with the fewest parentheses.

use super::{Binding, Notation};
use crate::number::{decimal, rounded};

pub const PLAIN: Notation = Notation {
    pi: "pi",
    comma: ", ",
    number: |value| decimal(rounded(value)),
    name: |name| name.plain.clone(),
    parenthesised: |inside| format!("({inside})"),
    row: |inside| inside,
    signs: ["-", " - ", " + "],
    times: ["*", "*", "* "],
    relation: |sign| format!(" {sign} "),
    quotient: (|over, under| format!("{over}/{under}"), [Binding::Product, Binding::Power]),
    power: (|base, exponent| format!("{base}^{exponent}"), Binding::Atom),
    root: |inside| format!("sqrt({inside})"),
    brackets: |function| (function.to_owned(), ["(", ")"]),
    call: |name, [open, close], arguments| format!("{name}{open}{arguments}{close}"),
    open: |name, open| format!("{name}{open}"),
    close: str::to_owned,
    over: "/",
    line: |parts| parts.trim().to_owned(),
    width: |part| PLAIN.part(part, false).chars().count() as f64,
};
