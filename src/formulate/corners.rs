//! Laws of drivers whose value or rate jumps. Where the driver is a loop equation, closing the loops behind a jump of its rate is the impulse on all that is not
//! driven; where it is a branch of a tree, what depends on its coordinate follows, and all else keeps the rates of its coordinates.

use std::collections::HashMap;

use crate::component::Origin;
use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Symbol};
use crate::graph::ElementId;
use crate::lower::indicators;
use crate::mechanism::{Coordinates, Formula, Motion, Part, Value};
use crate::tree::Trees;

/// The experiment is looked at in so many places, and jumps are found between them by so many halvings.
const PLACES: usize = 2000;
const HALVINGS: usize = 50;
/// How far from a switch its sides are looked at, as shares of the experiment.
const BESIDE: [f64; 2] = [1e-9, 1e-11];
/// How much of its largest value in the experiment is a jump of a law or of its rate, and how much of it is left on the nearer sides: what goes through the
/// switch without a jump becomes less, however steep it is.
const JUMP: f64 = 1e-5;
const LEFT: f64 = 0.5;
/// A rate that is so many times as large on the nearer sides has no bound.
const GROWS: f64 = 2.0;

/// A law of time and parameters by itself: each of many evaluations would go through the whole mechanism's expressions.
struct Law {
    arena: Arena,
    /// The law and its rate.
    value: [Expr; 2],
    parameters: Vec<f64>,
}

impl Law {
    /// None if it depends on anything else.
    fn of(equations: &mut Equations, formula: &Formula) -> Option<Self> {
        let value = equations.system.value(formula);
        let mut arena = Arena::default();
        let value = *arena.import(&equations.system.arena, &[value], &HashMap::new()).first()?;
        let depends = |symbol: &Symbol| matches!(symbol, Symbol::Time | Symbol::Parameter(_));
        if !arena.symbols([value]).iter().all(depends) {
            return None;
        }
        let value = [value, arena.time_derivative(value)];
        let parameters = equations.system.mechanism.parameters.iter().map(|parameter| parameter.value).collect();
        Some(Self { arena, value, parameters })
    }

    fn at(&self, roots: &[Expr], time: f64) -> Vec<f64> {
        let known = |symbol: Symbol| match symbol {
            Symbol::Parameter(index) => self.parameters[index],
            _ => time,
        };
        self.arena.evaluate(roots, &known)
    }
}

/// The first jump of a driver's law within the experiment.
pub(super) struct Jump {
    /// Which driver.
    driver: usize,
    time: f64,
    /// What jumps, from where to where.
    what: String,
    /// Has the rate two values there?
    of_rate: bool,
}

/// Those of all drivers.
pub(super) fn jumps(equations: &mut Equations) -> Vec<Jump> {
    let drivers = equations.system.mechanism.drivers.iter().enumerate();
    let jump = |(driver, part): (usize, &Part)| {
        let (time, what, of_rate) = laws(part).iter().find_map(|law| first_jump(equations, law))?;
        Some(Jump { driver, time, what, of_rate })
    };
    drivers.filter_map(jump).collect()
}

/// The recommended trees, but with drivers as loop equations whose rates jump, or are inputs, which may; none if these are the scene's own, or like that already.
pub(super) fn with_impulses(equations: &Equations, jumps: &[Jump]) -> Option<Trees> {
    let system = &equations.system;
    let jumping = |id: ElementId| match system.element(id).origin {
        Origin::Driver(driver) => {
            let jumps = jumps.iter().any(|jump| jump.of_rate && jump.driver == driver.0);
            jumps || takes_speed(&system.mechanism.drivers[driver.0])
        }
        _ => false,
    };
    let trees = Trees::recommended_but(system, jumping);
    let own = matches!(system.mechanism.coordinates, Coordinates::Chosen { .. });
    let recommended = !own && equations.trees == Trees::recommended(system);
    (recommended && equations.trees != trees).then_some(trees)
}

/// Which drivers' laws jump, or may, and what becomes of the impulses.
pub(super) fn warnings(equations: &Equations, jumps: &[Jump]) -> Vec<Fault> {
    let drivers = || equations.system.mechanism.drivers.iter().enumerate();
    let laws = jumps.iter().map(|jump| {
        let part = &equations.system.mechanism.drivers[jump.driver];
        let help = if !jump.of_rate || is_branch(equations, jump.driver) {
            "what is not driven keeps the rates of its coordinates there: the impulse is no part of the motion; let the law turn smoothly (`smoothstep`, `spline`)"
        } else {
            "its impulse changes the speeds of what is not driven at once, as if the law turned very fast; if that is not meant, let it turn smoothly (`smoothstep`, `spline`)"
        };
        let message = format!("the law of driver `{}` jumps: at t = {} s {}", part.name, jump.time, jump.what);
        Fault::warning("scene::driver_jump", message, part.span).label("jumps").help(help)
    });
    let inputs = drivers().filter(|(driver, part)| takes_speed(part) && is_branch(equations, *driver)).map(|(_, part)| {
        let message = format!("driver `{}` takes its speed from an input, which may jump", part.name);
        let help = "what is not driven keeps the rates of its coordinates there: the impulse is no part of the motion; give what the driver moves a \
                    mass and an inertia, and keep it out of the trees, as the recommended ones do then";
        Fault::warning("scene::driver_jump", message, part.span).label("may jump").help(help)
    });
    laws.chain(inputs).collect()
}

/// Is the speed of a driver an input?
fn takes_speed(part: &Part) -> bool {
    part.values.iter().any(|(_, value)| matches!(value, Value::Motion(Motion::Velocity(_))))
}

/// Is the motion of a driver substituted, not imposed by a loop equation?
fn is_branch(equations: &Equations, driver: usize) -> bool {
    let own =
        |id: &ElementId| matches!(equations.system.element(*id).origin, Origin::Driver(other) if other.0 == driver);
    let trees = &equations.trees;
    trees.translation.branches.iter().chain(&trees.rotation.branches).any(own)
}

/// The first driver whose law has a value at a time, but no rate.
pub(super) fn without_rate<'m>(equations: &mut Equations<'m>, time: f64) -> Option<&'m Part> {
    let mechanism = equations.system.mechanism;
    mechanism.drivers.iter().find(|part| {
        let laws = laws(part);
        let mut laws = laws.iter().filter_map(|formula| Law::of(equations, formula));
        laws.any(|law| law.at(&law.value, time).iter().map(|number| number.is_finite()).eq([true, false]))
    })
}

fn laws(part: &Part) -> Vec<Formula> {
    part.values.iter().flat_map(|(_, value)| laws_of(value)).collect()
}

fn laws_of(value: &Value) -> Vec<Formula> {
    match value {
        Value::Motion(Motion::Given(formula)) => vec![formula.clone()],
        Value::Vector(both) => both.to_vec(),
        _ => Vec::new(),
    }
}

/// When a law of time jumps first, or its rate does, and from where to where.
fn first_jump(equations: &mut Equations, formula: &Formula) -> Option<(f64, String, bool)> {
    let experiment = equations.system.mechanism.experiment;
    let mut law = Law::of(equations, formula)?;
    let switches = indicators(&mut law.arena, &law.value[..1]);
    if switches.is_empty() {
        return None;
    }
    let [start, span] = [experiment.start, experiment.stop - experiment.start];
    let places: Vec<Vec<f64>> = (0..=PLACES).map(|place| law.at(&law.value, start + span * share(place))).collect();
    let finite = |index: usize| places.iter().map(move |place| place[index].abs()).filter(|size| size.is_finite());
    let largest = |index: usize| finite(index).fold(0.0, f64::max);
    let largest = [0, 1].map(largest);
    let times = sign_changes([start, span], &switches, &|roots, time| law.at(roots, time));
    times.into_iter().find_map(|time| {
        let (what, of_rate) = jump(&law, largest, time, span)?;
        Some((time, what, of_rate))
    })
}

/// What of a law jumps at a switch, and whether it is a rate with two values.
fn jump(law: &Law, largest: [f64; 2], time: f64, span: f64) -> Option<(String, bool)> {
    // On both sides, first further away.
    let [far, near] = BESIDE.map(|beside| [-1.0, 1.0].map(|side: f64| law.at(&law.value, time + side * beside * span)));
    let change = |sides: &[Vec<f64>; 2], index: usize| (sides[1][index] - sides[0][index]).abs();
    let size = |sides: &[Vec<f64>; 2]| f64::max(sides[0][1].abs(), sides[1][1].abs());
    let jumps = |index: usize| {
        let near = change(&near, index);
        near > JUMP * largest[index] && near > LEFT * change(&far, index)
    };
    let says = |what: &str, index: usize| format!("{what} goes from {:.6} to {:.6}", near[0][index], near[1][index]);
    if jumps(0) {
        Some((says("it", 0), false))
    } else if size(&near) > GROWS * size(&far) && size(&near) > largest[1] {
        Some(("its rate grows beyond all bounds".to_owned(), false))
    } else {
        jumps(1).then(|| (says("its rate", 1), true))
    }
}

fn share(place: usize) -> f64 {
    place as f64 / PLACES as f64
}

/// When functions of time change their signs, in order.
fn sign_changes([start, span]: [f64; 2], functions: &[Expr], at: &impl Fn(&[Expr], f64) -> Vec<f64>) -> Vec<f64> {
    let time = |place: usize| start + span * share(place);
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
