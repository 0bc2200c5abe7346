//! What is held on one side only must be open at the start, or touch, and belong to something that moves freely.

use cotree_fmu::model::State;

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::expr::{Expr, Symbol};
use crate::formulate::explain::assembly::show;
use crate::model::{Contact, Mechanism, Owner};
use crate::network::Constrained;

/// What is open by less than nothing, by no more than this share of its scale, touches: starts are solved for to rounding errors.
const TOUCHING: f64 = 1e-11;

/// What is held on one side, but moves by drivers alone or not at all.
pub(super) fn check_moved(equations: &Equations) -> Vec<Fault> {
    let all = equations.system.mechanism.contacts.iter().enumerate();
    let unmoved = all.filter(|(index, _)| equations.row_of_contact(*index).is_none());
    unmoved.map(|(index, contact)| unmoved_fault(equations, index, contact)).collect()
}

fn unmoved_fault(equations: &Equations, index: usize, contact: &Contact) -> Fault {
    if equations.drivers_move_contact(index) {
        return driven(contact);
    }
    if contact.slip.is_some() {
        let message = format!("`{}` cannot move, so its friction force is not determined", contact.name);
        let help = "leave the friction out; for an equilibrium or its vibrations drivers do not move";
        return Fault::new("scene::friction", message, contact.span).label("friction where nothing moves").help(help);
    }
    let message = format!("`{}` cannot move, so a hard stop has no effect", contact.name);
    Fault::new("scene::limits", message, contact.span).label("holds nothing").help("leave it out")
}

fn driven(contact: &Contact) -> Fault {
    if contact.slip.is_some() {
        let message = format!(
            "`{}` has dry friction in a driven motion, and other motions depend on its force, which is not determined while it is at rest",
            contact.name
        );
        return Fault::new("scene::friction", message, contact.span)
            .label("dry friction in a driven motion")
            .help("make the friction smooth by giving its `velocity`, or replace the driver by a force or a torque");
    }
    let message = format!(
        "`{}` is a unilateral constraint (hard stop, contact or rope) on a driven motion: a prescribed motion cannot stop",
        contact.name
    );
    Fault::new("scene::limits", message, contact.span).label("constrains a driven motion").help(
        "remove it, or replace the driver by a force or a torque; `cotree motion` reports how far the drive can go",
    )
}

/// What is wrong with what parts hold on one side, at the start; `is_driven` says that drivers move all of the mechanism.
pub(super) fn check_contacts(equations: &mut Equations, state: &State, length: f64, is_driven: bool) -> Vec<Fault> {
    let mechanism = equations.system.mechanism.clone();
    if is_driven {
        // What rubs acts on the drivers; a contact that nothing presses closed has no force to rub with.
        let stops = mechanism.contacts.iter().filter(|contact| contact.slip.is_none());
        return stops.map(driven).collect();
    }
    let mut faults = Vec::new();
    for (index, contact) in mechanism.contacts.iter().enumerate() {
        let Some(row) = equations.row_of_contact(index) else { continue };
        if equations.constraints[row].is_trivial() {
            let rubs = contact.slip.as_ref().is_some_and(|slip| slip.on.is_none());
            if rubs && equations.drivers_move_contact(index) {
                continue;
            }
            faults.push(unmoved_fault(equations, index, contact));
            continue;
        }
        if contact.gap.of_rate || contact.slip.is_some() {
            // It begins wherever it is.
            continue;
        }
        let bound = equations.system.value(&contact.gap.bound);
        let gap = equations.constraints[row].contact().map_or(bound, |gap| gap.value);
        let [gap, bound] = equations.system.arena.evaluate(&[gap, bound], state)[..] else { continue };
        let scale = equations.constraints[row].scale(length);
        if gap < -TOUCHING * scale {
            let is_angle = equations.constraints[row].constrained == Constrained::Angle;
            let signed = |value: f64| format!("{}{}", if value < 0.0 { "-" } else { "" }, show(value, is_angle));
            let [value, limit, by] = [bound + contact.gap.sign * gap, bound, -gap].map(signed);
            let message =
                format!("the start is beyond `{}`: it starts at {value}, but the limit is {limit}", contact.name);
            let help = other_side(&mechanism, contact)
                .unwrap_or_else(|| format!("start within the limit, or move the limit by {by}"));
            let fault = Fault::new("assembly::beyond_limit", message, contact.span);
            faults.push(fault.label("the start is beyond this limit").help(help));
        }
    }
    faults
}

/// How a contact with a line is turned over: by its side, or by its ends, of which the first has the line.
fn other_side(mechanism: &Mechanism, contact: &Contact) -> Option<String> {
    let Owner::Joint(joint) = contact.owner else { return None };
    let part = mechanism.joints.get(joint.0)?;
    let has_sides = part.component().keys.iter().any(|key| key.name == "side");
    if !has_sides || part.value("axis").is_none() {
        return None;
    }
    let side = if part.choice("side") == Some("right") { "left" } else { "right" };
    let [first, second] = part.between.map(|place| mechanism.place_name(place));
    Some(format!(
        "the line belongs to `{first}`: write `side = \"{side}\"` if `{second}` stays on the other side of it, or `between = [\"{second}\", \"{first}\"]` if the line belongs to `{second}`; otherwise start within the limit"
    ))
}

/// What rubs where drivers lead it has no force that is determined at rest: what moves freely beside it may not follow from that.
pub(super) fn check_led(equations: &mut Equations) -> Vec<Fault> {
    if equations.is_driven() || equations.first_led().is_none() {
        return Vec::new();
    }
    let mechanism = equations.system.mechanism.clone();
    let led = |equations: &Equations, symbol: &Symbol| {
        let mut driven_contacts = mechanism.contacts.iter().enumerate().filter(|(index, _)| equations.is_led(*index));
        driven_contacts.find(|(_, contact)| {
            contact.state.direction.is_some_and(|direction| Symbol::Discrete(direction.0) == *symbol)
        })
    };
    let levels = equations.levels().into_iter().filter(|(index, _)| !equations.is_led(*index));
    let mut read: Vec<Expr> = levels.flat_map(|(_, level)| level.pressing.sums()).collect();
    read.extend(equations.feedback().into_iter().map(|load| load.value));
    read.extend(&equations.states);
    let symbols = equations.system.arena.symbols(read);
    symbols.iter().find_map(|symbol| led(equations, symbol)).map(|(_, contact)| driven(contact)).into_iter().collect()
}
