//! The scene as a text, from what the components, the shapes and the tables of a scene say of themselves: every key with its unit and default,
//! terminal equations, stored energy, variables, and an example of each.

use std::fmt::Write;

use super::{ALL, Component, ENERGIES, RESIDUALS, Section, body, outline, shape, transfer};
use crate::model::{Dimension, Formula, KeyValue, ParameterId, Place, Quantity};
use crate::scene::key::{Form, Key, Need};
use crate::scene::tables;

/// The reference of the scene file in Markdown.
pub fn reference() -> String {
    let mut text = String::from(
        "# Scene reference\n\n\
         Generated from the descriptions of the components in `src/component` and `src/scene/tables.rs`; a test compares.\n\
         [components.md](components.md) explains the components, [expressions.md](expressions.md) the functions of expressions.\n\n\
         A scene is TOML, or JSON with the same keys. Every number may be a number in SI, a text with a unit (`\"120 mm\"`), or an expression\n\
         (`\"crank_length/2\"`). Keys in **bold** must be given.\n\n",
    );
    table(&mut text, "The top", "", tables::SCENE);
    let named = "A number, or a table with these keys. The key of the entry is its name.";
    table(&mut text, "`parameters`", named, tables::PARAMETER);
    table(&mut text, "`inputs`", named, tables::INPUT);
    let states = "State variables, whose rates are given: currents, pressures, temperatures, integrals of controllers. Laws, outputs and other states use them by name. See [machines.md](machines.md).";
    table(&mut text, "`states`", states, tables::STATE);
    let sampled = "Discrete variables, which change at sample times only and are constant in between (zero-order hold): digital controllers, counters. Laws, outputs, rates of states and other sampled values use them by name. See [machines.md](machines.md#sampled-values-digital-controllers-zero-order-hold).";
    table(&mut text, "`sampled`", sampled, tables::SAMPLED);
    push(&mut text, "Each of its `values` is a number (its start value) or a table with these keys:\n");
    rows(&mut text, tables::SAMPLED_VALUE);
    let events = "State events: what happens when a comparison becomes true; a comparison that is true at the start becomes true there. `events.NAME.time` is the time of the last event, and negative before the first. See [machines.md](machines.md#events).";
    table(&mut text, "`events`", events, tables::EVENT);
    let signals = "Laws that loads, drivers, outputs and other signals use by name: a number or an expression, or a table with these keys. See [expressions.md](expressions.md#signals).";
    table(&mut text, "`signals`", signals, tables::SIGNAL);
    transfers(&mut text);
    table(&mut text, "`ground`", "Its bare name `ground` is its origin.", tables::GROUND);
    bodies(&mut text);
    shapes(&mut text);
    outlines(&mut text);
    for section in [Section::Joints, Section::Drivers, Section::Loads] {
        push(&mut text, &format!("## `{}s`\n", section.word()));
        for component in section.components() {
            chapter(component, &mut text);
        }
    }
    let over = "`over` lists the pulleys that a rope, spring, damper, actuator or constant-force spring runs over, from its first end to its last. See [ropes.md](ropes.md).";
    table(&mut text, "`over`", over, tables::PULLEY);
    push(&mut text, "A drum, which stands in the place of an end in `between`, has these keys:\n");
    rows(&mut text, tables::DRUM);
    let profile = "`profile` of a contact lists its corners: two coordinates in metres, to which a line leads from the corner before, or a table with these keys, to which an arc leads. See [contacts.md](contacts.md#profiles).";
    table(&mut text, "`profile`", profile, tables::CORNER);
    let parts = "Each entry includes the mechanism of another file: every name `x` of it becomes `entry_x`, also written `entry.x`. See [parts.md](parts.md).";
    table(&mut text, "`parts`", parts, tables::PART);
    let initial = "The key is a position or velocity, such as `\"crank.angle\"`; the value is a number if it is known, or a table with this key.";
    table(&mut text, "`initial`", initial, tables::GUESS);
    table(&mut text, "`outputs`", "", tables::OUTPUTS);
    push(&mut text, "An output that is a table has these keys:\n");
    rows(&mut text, tables::OUTPUT);
    let experiment =
        "Parameters in these keys have their values of the scene: setting a parameter does not change the times.";
    table(&mut text, "`experiment`", experiment, tables::EXPERIMENT);
    let clearance = "What `cotree motion` reports of the distances between [outlines](#outlines). See [motion.md](motion.md#clearance).";
    table(&mut text, "`clearance`", clearance, tables::CLEARANCE);
    let display = "Results are in SI units unless a unit is given for their quantity, here or with `--units`.";
    table(&mut text, "`display`", display, tables::DISPLAY);
    table(&mut text, "`solver`", "", tables::SOLVER);
    table(&mut text, "`coordinates`", "", tables::COORDINATES);
    variables(&mut text);
    text
}

/// Each component's section and type with a small example of it in TOML, called `example`. It uses a body `crank` with the points `inner` and
/// `outer`, bodies `rod` and `slider`, joints `pin` and `guide`, a point `ground.bearing`, and parameters.
pub fn examples() -> Vec<(&'static str, &'static str, String)> {
    ALL.iter().map(|component| (component.section.word(), component.name, example(component))).collect()
}

fn push(text: &mut String, line: &str) {
    // Writing to a text cannot fail.
    let _ = writeln!(text, "{line}");
}

fn table(text: &mut String, title: &str, about: &str, keys: &[Key]) {
    push(text, &format!("## {title}\n"));
    if !about.is_empty() {
        push(text, &format!("{about}\n"));
    }
    rows(text, keys);
}

fn rows(text: &mut String, keys: &[Key]) {
    push(text, "| key | meaning | unit | default |\n|---|---|---|---|");
    for key in keys {
        let unit = unit(key.form);
        let unit = if unit.is_empty() { String::new() } else { format!("`{unit}`") };
        let mark = if matches!(key.need, Need::Required(_)) { "**" } else { "" };
        push(
            text,
            &format!("| {mark}`{}`{mark} | {}{} | {unit} | {} |", key.name, key.about, range(key.form), default(key)),
        );
    }
    push(text, "");
}

fn bodies(text: &mut String) {
    let [about, equations] = body::ABOUT;
    push(text, "## `bodies`\n");
    push(text, &format!("{}, whose bare name used as a point is its mass centre: `{equations}`\n", capital(about)));
    rows(text, body::KEYS);
    push(
        text,
        &format!("Variables: {}; of a point `p`: {}\n", words(body::VARIABLES, ""), words(body::POINT_VARIABLES, "p.")),
    );
    push(text, "A body's kinetic energy is in `energy.kinetic`, that of its weight in `energy.potential`.\n");
    let points = "points  = { inner = [0.0, 0.0], outer = [\"0.3 m\", 0.0] }";
    push(
        text,
        &format!("```toml\n[bodies.crank]\nmass    = 2.0\ninertia = 0.02\ncom     = [0.15, 0.0]\n{points}\n```\n"),
    );
}

fn shapes(text: &mut String) {
    push(text, "## Shapes\n");
    push(
        text,
        "A uniform shape gives a body its mass centre and, with a density, its mass and moment of inertia. Each can be given instead:\n\
         `mass` in place of the density, `inertia`, and with `inertia` also `com`. A place is the name of a point of the body, or two\n\
         coordinates in the frame of its points.\n",
    );
    for shape in shape::ALL {
        push(text, &format!("### `{}`\n", shape.place.name));
        push(text, &format!("{}: `{}`\n", capital(shape.about), shape.equations));
        let place = Key { need: Need::Required(""), ..shape.place };
        let rest = shape.all_keys();
        rows(text, &[&[place], &rest[1..]].concat());
        push(text, &format!("```toml\nshape = {}\n```\n", shape.example));
    }
}

fn outlines(text: &mut String) {
    push(text, "## Outlines\n");
    push(
        text,
        "The outline of a body or of the ground is what pictures show and what `cotree motion` measures distances between. It has no mass and changes no motion. A body\n\
         without an `outline` has that of its `shape`. A place is the name of a point of the same body, or two coordinates in the frame of its points.\n",
    );
    for kind in outline::ALL {
        push(text, &format!("### Outline with the key `{}`\n", kind.place.name));
        push(text, &format!("{}.\n", capital(kind.about)));
        rows(text, &[Key { need: Need::Required(""), ..kind.place }, kind.offset]);
        push(text, &format!("```toml\noutline = {}\n```\n", kind.example));
    }
}

fn transfers(text: &mut String) {
    push(
        text,
        "A signal with a `type` is a block with a memory: its output depends on its input so far. Its states or sampled values are named after it, such as `NAME.integral`. A bare\n\
         value is in its `unit`, a bare gain in SI. See [machines.md](machines.md#pid-controllers-filters-and-delays).\n",
    );
    for transfer in transfer::ALL {
        push(text, &format!("### Signal of type `{}`\n", transfer.name));
        push(text, &format!("{}: `{}`\n", capital(transfer.about), transfer.equations));
        rows(text, &transfer.all_keys());
        let head = format!("[signals.example]\ntype = \"{}\"\n", transfer.name);
        push(text, &format!("```toml\n{head}{}```\n", shown(&transfer.all_keys())));
    }
}

fn chapter(component: &Component, text: &mut String) {
    let heading = if component.section == Section::Drivers { "with the key" } else { "of type" };
    push(text, &format!("### {} {heading} `{}`\n", capital(component.section.word()), component.name));
    push(text, &format!("{}: `{}`\n", capital(component.about), component.equations));
    rows(text, component.keys);
    let variables = component.variables.iter().copied().chain([Quantity::Power]).collect::<Vec<_>>();
    push(text, &format!("Variables: {}\n", words(&variables, "")));
    if !component.engaging.is_empty() {
        push(text, &format!("If events engage or release it: {}\n", words(component.engaging, "")));
    }
    let coordinates = component.coordinates(Dimension::Two).iter().copied();
    let coordinates: Vec<Quantity> = coordinates.filter(|quantity| !variables.contains(quantity)).collect();
    if !coordinates.is_empty() {
        push(text, &format!("From its first end to its second: {}\n", words(&coordinates, "")));
    }
    let energy = energy(component);
    let stored = energy.map_or("none".to_string(), |energy| format!("`{energy}`, in `energy.potential`"));
    push(text, &format!("Stored energy: {stored}\n"));
    push(text, &format!("```toml\n{}```\n", example(component)));
}

fn variables(text: &mut String) {
    push(text, "## Variables\n");
    push(
        text,
        "Their names are `owner.variable`, such as `crank.angle`. `energy` and `constraint` belong to the whole mechanism.\n",
    );
    push(text, "| variable | unit | meaning |\n|---|---|---|");
    let all = ALL.iter().copied();
    let both =
        |component: &Component| [Dimension::Two, Dimension::One].map(|dimension| component.coordinates(dimension));
    let coordinates = all.clone().flat_map(both).flatten();
    let parts = all.flat_map(|component| component.variables).chain(coordinates).copied();
    let mut seen: Vec<Quantity> = Vec::new();
    let engaging = ALL.iter().flat_map(|component| component.engaging).copied();
    for quantity in body::VARIABLES.iter().copied().chain(parts).chain(engaging).chain([Quantity::Power]) {
        if !seen.contains(&quantity) {
            seen.push(quantity);
            variable(text, "", quantity);
        }
    }
    for (owner, quantities) in [("energy.", ENERGIES), ("constraint.", RESIDUALS)] {
        quantities.iter().for_each(|quantity| variable(text, owner, *quantity));
    }
}

fn variable(text: &mut String, owner: &str, quantity: Quantity) {
    let what = quantity.words().trim_end_matches(" of");
    push(text, &format!("| `{owner}{}` | `{}` | {what} |", quantity.word(), quantity.measure().si));
}

/// Names of variables in a row.
fn words(quantities: &[Quantity], before: &str) -> String {
    let word = |quantity: &Quantity| format!("`{before}{}` [{}]", quantity.word(), quantity.measure().si);
    quantities.iter().map(word).collect::<Vec<_>>().join(", ")
}

/// The energy that the entry `example` stores, in terms of its keys.
fn energy(component: &Component) -> Option<String> {
    let is_number = |key: &Key| matches!(key.form, Form::Constant(..) | Form::Law(_));
    let keys = component.keys.iter().enumerate().filter(|(_, key)| is_number(key));
    let values = keys.map(|(index, key)| (key.name, KeyValue::Formula(Formula::Parameter(ParameterId(index)))));
    let part = component.part("example", [Place::Origin; 2], values.collect());
    let energy = match part.energy()? {
        // Close to where the formula has no value there is a series in its place.
        Formula::If(_, pieces) => pieces[3].clone(),
        whole => whole,
    };
    let written = energy.written(&|symbol| match symbol {
        Formula::Parameter(id) => component.keys[id.0].name.to_owned(),
        Formula::Variable(variable) => variable.quantity.of(&part.name),
        other => format!("{other:?}"),
    });
    Some(written.replace('+', " + ").replace('-', " - "))
}

/// The entry `example` with the keys that must be given, as the help of each shows it.
fn example(component: &Component) -> String {
    let mut text = format!("[{}s.example]\n", component.section.word());
    if component.section != Section::Drivers {
        push(&mut text, &format!("type = \"{}\"", component.name));
    }
    text + &shown(component.keys)
}

/// The keys that must be given, as the help of each shows it.
fn shown(keys: &[Key]) -> String {
    let mut text = String::new();
    let mut chosen = false;
    for key in keys {
        let shown = match key.need {
            Need::Required(help) | Need::Captured(help) | Need::RequiredAlone(help) => help,
            Need::OneOf(help) if !std::mem::replace(&mut chosen, true) => help,
            _ => continue,
        };
        let mut codes = shown.split('`').skip(1).step_by(2);
        let start = format!("{} = ", key.name);
        let first = codes.clone().next().unwrap_or_default();
        let value = codes.find_map(|code| code.strip_prefix(&start)).unwrap_or(first);
        push(&mut text, &format!("{start}{value}"));
    }
    text
}

fn capital(text: &str) -> String {
    let (first, rest) = text.split_at(text.len().min(1));
    first.to_uppercase() + rest
}

pub(super) fn unit(form: Form) -> String {
    match form {
        Form::Constant(wanted, _) | Form::Law(wanted) | Form::Vector(wanted) | Form::ConstantVector(wanted) => {
            wanted.si.to_string()
        }
        Form::Curve(_, [sliding, turning]) => format!("{} or {}", sliding.si, turning.si),
        Form::UnitOf(wanted) => wanted.si.to_string(),
        Form::Motion([motion, ..]) => motion.si.to_string(),
        Form::Record(record) => {
            record.measures().iter().map(|wanted| wanted.si.to_string()).collect::<Vec<_>>().join(", ")
        }
        Form::NamedPoints | Form::Corner | Form::Corners(..) | Form::Profile => "m".to_string(),
        _ => String::new(),
    }
}

fn range(form: Form) -> String {
    use crate::model::Range::{Any, FromOne, NotNegative, NotZero, Positive, Share};
    match form {
        Form::Constant(_, Any) => String::new(),
        Form::Constant(_, NotNegative) => ", not negative".to_string(),
        Form::Constant(_, Positive) => ", positive".to_string(),
        Form::Constant(_, NotZero) => ", not zero".to_string(),
        Form::Constant(_, Share) => ", from 0 to 1".to_string(),
        Form::Constant(_, FromOne) => ", 1 or more".to_string(),
        Form::Law(_) | Form::Curve(..) | Form::Vector(_) => ", an expression".to_string(),
        Form::Record(record) => {
            let patterns: Vec<String> = record.patterns().iter().map(|pattern| format!("`{pattern}`")).collect();
            format!(": {}", patterns.join(", or "))
        }
        Form::Motion(_) => ", an expression or `{ input = ..., as = ... }`".to_string(),
        Form::Choice(words, _) => {
            let words: Vec<String> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
            format!(": {}", words.join(", "))
        }
        _ => String::new(),
    }
}

fn default(key: &Key) -> String {
    match (key.need, key.form) {
        (Need::Required(_), _) => "must be given".to_string(),
        (Need::Captured(_), _) => "must be given, unless an event engages it where it stands".to_string(),
        (Need::RequiredAlone(_), _) => "must be given without `over`".to_string(),
        (Need::Default(otherwise), _) => otherwise.to_string(),
        (Need::OneOf(_), _) => "one of these".to_string(),
        (_, Form::Constant(..)) => "0".to_string(),
        (_, Form::Choice([first, ..], _)) => format!("`\"{first}\"`"),
        (_, Form::CarrierBody | Form::CarrierPoint) => "`\"ground\"`".to_string(),
        _ => "none".to_string(),
    }
}
