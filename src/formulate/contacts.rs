//! What is held on one side only must be open at the start, or touch, and belong to something that moves freely.

use cotree_fmu::model::State;

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::formulate::explain::assembly::show;
use crate::network::Held;

/// What is open by less than nothing, by no more than this share of its scale, touches: starts are solved for to rounding errors.
const TOUCHING: f64 = 1e-11;

/// What is wrong with what parts hold on one side, at the start.
pub(super) fn check_contacts(equations: &mut Equations, state: &State, length: f64, driven: bool) -> Vec<Fault> {
    let mechanism = equations.system.mechanism.clone();
    let mut faults = Vec::new();
    for (index, own) in mechanism.unilaterals.iter().enumerate() {
        let fault = |code, message: String, label| Fault::new(code, message, own.span).label(label);
        let Some(row) = equations.row_of_unilateral(index) else {
            let message = format!("nothing moves `{}`: what it would stop cannot move", own.name);
            faults.push(fault("scene::limits", message, "holds nothing").help("leave it out"));
            continue;
        };
        if driven {
            let message = format!(
                "`{}` would stop what drivers move: a stop gives way or is given way to, and they do neither",
                own.name
            );
            let help = "leave it out, or let a force or a torque move the mechanism instead of a driver";
            faults.push(fault("scene::limits", message, "stops a driven motion").help(help));
            continue;
        }
        if own.slip.is_some() {
            // It begins to stick wherever it is.
            continue;
        }
        let bound = equations.system.value(&own.held.bound);
        let gap = equations.constraints[row].one_sided.as_ref().map_or(bound, |gap| gap.value);
        let [gap, bound] = equations.system.arena.evaluate(&[gap, bound], state)[..] else { continue };
        let scale = equations.constraints[row].scale(length);
        if gap < -TOUCHING * scale {
            let is_angle = equations.constraints[row].held == Held::Angle;
            let signed = |value: f64| format!("{}{}", if value < 0.0 { "-" } else { "" }, show(value, is_angle));
            let [value, limit, by] = [bound + own.held.sign * gap, bound, -gap].map(signed);
            let message = format!("the start is beyond `{}`: it begins at {value}, the limit is {limit}", own.name);
            let help = format!("begin within the limit, or move the limit by {by}");
            faults.push(fault("assembly::beyond_limit", message, "the start is beyond it").help(help));
        }
    }
    faults
}
