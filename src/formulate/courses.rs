//! Ropes and bands over pulleys at the start: from where they count, and whether they lie on their pulleys.

use cotree_fmu::model::State;

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::expr::Expr;
use crate::model::{DiscreteKind, Mechanism, Part};

/// Gives the discrete variables of courses the values that the configuration of a state gives them.
pub(super) fn begin(equations: &mut Equations, state: &mut State) {
    let mechanism = equations.system.mechanism.clone();
    for (id, discrete) in mechanism.discrete_variables() {
        let DiscreteKind::Course(owner, value) = discrete.kind else { continue };
        let begin = equations.begin_of_course(owner, value);
        let [begin] = equations.system.arena.evaluate(&[begin], &*state)[..] else { continue };
        if let Some(place) = state.discrete_mut().get_mut(id.0) {
            *place = begin;
        }
    }
}

/// Circles one inside the other have no tangent between them.
pub(super) fn check(equations: &mut Equations, state: &State) -> Vec<Fault> {
    let mechanism = equations.system.mechanism.clone();
    let mut faults = Vec::new();
    for part in mechanism.parts_over_pulleys() {
        let squares: Vec<Expr> = equations.squares_of_straight_parts(part.owner);
        let values = equations.system.arena.evaluate(&squares, state);
        let crossed = values.iter().position(|square| !(square.is_finite() && *square > 0.0));
        faults.extend(crossed.map(|number| without_tangent(&mechanism, part, number)));
    }
    faults
}

fn without_tangent(mechanism: &Mechanism, part: &Part, number: usize) -> Fault {
    let names: Vec<String> = part.stations().unwrap_or_default().iter().map(|at| mechanism.place_name(at.at)).collect();
    let name = |number: usize| names.get(number).cloned().unwrap_or_default();
    let message = format!(
        "`{}` has no straight part between `{}` and `{}` at the start: they are closer to each other than its pulleys there permit",
        part.name,
        name(number),
        name(number + 1)
    );
    let fault = Fault::new("assembly::beyond_limit", message, part.span).label("pulleys one inside the other");
    fault.help("start farther apart, make a radius smaller, or put one of the centres on the other `side` of the rope")
}
