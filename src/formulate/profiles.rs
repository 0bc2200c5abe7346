//! What touches a profile must be on its free side at the start.

use cotree_fmu::model::State;

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::formulate::explain::assembly::show;
use crate::model::Part;
use crate::program::contour;

/// What is inside by less than this share of the mechanism touches: starts are solved for to rounding errors.
const TOUCHING: f64 = 1e-11;

/// Says of discs that start inside their profiles by how much they do.
pub(super) fn check_profiles(equations: &mut Equations, state: &State, length: f64) -> Vec<Fault> {
    let mechanism = equations.system.mechanism.clone();
    let fault = |part: &Part| {
        let contour = contour(part)?;
        let place = equations.place_at_profile(part.owner)?;
        let [x, y] = equations.system.arena.evaluate(&place, state)[..] else { return None };
        let depth = contour.depth([x, y]);
        if depth <= TOUCHING * length {
            return None;
        }
        let message = format!("`{}` starts inside its profile, by {}", part.name, show(depth, false));
        let side = if part.choice("side") == Some("right") { "left" } else { "right" };
        let help = format!(
            "move the start out of it, or write `side = \"{side}\"` if the free side is on the other side of the profile, seen along it"
        );
        let fault = Fault::new("assembly::beyond_limit", message, part.span);
        Some(fault.label("the start is inside this profile").help(help))
    };
    mechanism.parts().filter_map(fault).collect()
}
