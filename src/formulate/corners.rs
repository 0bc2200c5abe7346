//! Laws of drivers whose value or rate jumps: what the jump would do to the momentum of all that is not driven is no part of the motion.

use std::collections::HashMap;

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Symbol};
use crate::lower::indicators;
use crate::mechanism::{Formula, Motion, Part, Value};

/// The experiment is looked at in so many places, and jumps are found between them by so many halvings.
const PLACES: usize = 2000;
const HALVINGS: usize = 50;
/// How far from a jump its sides are looked at, as a share of the experiment, and how much of a rate is a jump there.
const BESIDE: f64 = 1e-9;
const JUMP: f64 = 1e-5;

/// The first jump of each driver's law within the experiment.
pub(super) fn jumps(equations: &mut Equations) -> Vec<Fault> {
    let mechanism = equations.system.mechanism;
    let laws = |part: &'_ Part| -> Vec<Formula> { part.values.iter().flat_map(|(_, value)| laws(value)).collect() };
    let mut faults = Vec::new();
    for part in &mechanism.drivers {
        let found = laws(part).iter().find_map(|law| first_jump(equations, law));
        faults.extend(found.map(|(time, what)| fault(part, time, &what)));
    }
    faults
}

fn laws(value: &Value) -> Vec<Formula> {
    match value {
        Value::Motion(Motion::Given(formula)) => vec![formula.clone()],
        Value::Vector(both) => both.to_vec(),
        _ => Vec::new(),
    }
}

fn fault(part: &Part, time: f64, what: &str) -> Fault {
    let message = format!("the law of driver `{}` jumps: at t = {time} s {what}", part.name);
    Fault::warning("scene::driver_jump", message, part.span)
        .label("jumps")
        .help("what is not driven keeps its speed there: the impulse is no part of the motion; let the law turn smoothly (`smoothstep`, `spline`)")
}

/// When a law of time jumps first, or its rate does, and from where to where.
fn first_jump(equations: &mut Equations, law: &Formula) -> Option<(f64, String)> {
    let (parameters, experiment) = (&equations.system.mechanism.parameters, equations.system.mechanism.experiment);
    let value = equations.system.value(law);
    // By itself: each of many evaluations would go through the whole mechanism's expressions.
    let arena = &mut Arena::default();
    let value = *arena.import(&equations.system.arena, &[value], &HashMap::new()).first()?;
    let depends = |symbol: &Symbol| matches!(symbol, Symbol::Time | Symbol::Parameter(_));
    let switches = indicators(arena, &[value]);
    if switches.is_empty() || !arena.symbols([value]).iter().all(depends) {
        return None;
    }
    let rate = arena.time_derivative(value);
    let at = |roots: &[Expr], time: f64| {
        let known = |symbol: Symbol| match symbol {
            Symbol::Parameter(index) => parameters[index].value,
            _ => time,
        };
        arena.evaluate(roots, &known)
    };
    let span = experiment.stop - experiment.start;
    sign_changes([experiment.start, span], &switches, &at).into_iter().find_map(|time| {
        let [before, behind] = [-1.0, 1.0].map(|side| at(&[value, rate], time + side * BESIDE * span));
        let size = f64::max(before[1].abs(), behind[1].abs());
        let change =
            |what: &str, index: usize| format!("{what} goes from {:.6} to {:.6}", before[index], behind[index]);
        if (behind[0] - before[0]).abs() > JUMP * (size * span).max(before[0].abs()) {
            Some((time, change("it", 0)))
        } else {
            ((behind[1] - before[1]).abs() > JUMP * size).then(|| (time, change("its rate", 1)))
        }
    })
}

/// When functions of time change their signs, in order.
fn sign_changes([start, span]: [f64; 2], functions: &[Expr], at: &impl Fn(&[Expr], f64) -> Vec<f64>) -> Vec<f64> {
    let time = |place: usize| start + span * place as f64 / PLACES as f64;
    let sides: Vec<Vec<f64>> = (0..=PLACES).map(|place| at(functions, time(place))).collect();
    let mut found: Vec<f64> = Vec::new();
    for (index, function) in functions.iter().enumerate() {
        for place in (1..=PLACES).filter(|place| (sides[place - 1][index] >= 0.0) != (sides[*place][index] >= 0.0)) {
            let (mut before, mut behind) = (time(place - 1), time(place));
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + behind);
                let same = (at(&[*function], middle)[0] >= 0.0) == (sides[place - 1][index] >= 0.0);
                *(if same { &mut before } else { &mut behind }) = middle;
            }
            found.push(0.5 * (before + behind));
        }
    }
    found.sort_by(f64::total_cmp);
    found
}
