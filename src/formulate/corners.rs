//! Laws of drivers whose value or rate jumps. Where the driver is a loop equation, closing the loops behind a jump of its rate is the impulse on all that is not
//! driven; where it is a branch of a tree, what depends on its coordinate follows, and all else keeps the rates of its coordinates.

use std::collections::HashMap;

use crate::component::Origin;
use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::expr::{Arena, Binary, Expr, Node, Symbol, Unary};
use crate::graph::ElementId;
use crate::lower::indicators;
use crate::mechanism::{Coordinates, Formula, Motion, Part, Value};
use crate::tree::Trees;

/// The experiment is looked at in so many places, and jumps are found between them by so many halvings.
const PLACES: usize = 2000;
const HALVINGS: usize = 50;
/// How far from a switch its sides are looked at, as shares of the experiment; and from where a root or a quotient bends, next to which rounding errors are larger.
const BESIDE: [f64; 2] = [1e-9, 1e-11];
const BESIDE_BEND: [f64; 2] = [1e-5, 1e-7];
/// Where a rate changes so many times as much from one place to the next as it does two places away, it may jump between them.
const BENDS: f64 = 3.0;
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

    /// Is there a function whose value or rate may jump without a switch: a root, say, where its argument touches zero?
    fn may_bend(&mut self) -> bool {
        let expanded = self.arena.expanded(&self.value[..1]);
        let bends = |expr: Expr| match self.arena.node(expr) {
            Node::Unary(Unary::Sqrt | Unary::Log | Unary::Asin | Unary::Acos | Unary::Tan, a) => Some(a),
            Node::Binary(Binary::Divide, _, a) | Node::Binary(Binary::Power | Binary::Atan2, a, _) => Some(a),
            _ => None,
        };
        let mut arguments = self.arena.reachable(expanded).into_iter().filter_map(bends);
        arguments.any(|argument| self.arena.symbols([argument]).iter().any(|symbol| matches!(symbol, Symbol::Time)))
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

/// The recommended trees, but with drivers as loop equations whose rates jump, or may, as they follow inputs; none if these are the scene's own, or like that already.
pub(super) fn with_impulses(equations: &Equations, jumps: &[Jump]) -> Option<Trees> {
    let system = &equations.system;
    let jumping = |id: ElementId| match system.element(id).origin {
        Origin::Driver(driver) => {
            let jumps = jumps.iter().any(|jump| jump.of_rate && jump.driver == driver.0);
            jumps || follows_input(&system.mechanism.drivers[driver.0])
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
    let inputs = drivers().filter(|(driver, part)| follows_input(part) && is_branch(equations, *driver)).map(|(_, part)| {
        let message = format!("driver `{}` follows an input, and its rate may jump", part.name);
        let help = "what is not driven keeps the rates of its coordinates there: the impulse is no part of the motion; give what the driver moves a \
                    mass and an inertia, and keep it out of the trees, as the recommended ones do then";
        Fault::warning("scene::driver_jump", message, part.span).label("may jump").help(help)
    });
    laws.chain(inputs).collect()
}

/// Is the speed of a driver an input, or its position one or a function of one? Importers set them in steps, or along lines with corners.
fn follows_input(part: &Part) -> bool {
    let mut follows = part.values.iter().any(|(_, value)| matches!(value, Value::Motion(Motion::Velocity(_))));
    for law in laws(part) {
        law.visit(&mut |formula| follows |= matches!(formula, Formula::Input(_)));
    }
    follows
}

/// Is the motion of a driver substituted, not imposed by a loop equation?
fn is_branch(equations: &Equations, driver: usize) -> bool {
    let own =
        |id: &ElementId| matches!(equations.system.element(*id).origin, Origin::Driver(other) if other.0 == driver);
    let trees = &equations.trees;
    trees.translation.branches.iter().chain(&trees.rotation.branches).any(own)
}

/// The drivers whose laws have a value at a time, but no rate.
pub(super) fn without_rate<'m>(equations: &mut Equations<'m>, time: f64) -> Vec<&'m Part> {
    let mechanism = equations.system.mechanism;
    let drivers = mechanism.drivers.iter().filter(|part| {
        let laws = laws(part);
        let mut laws = laws.iter().filter_map(|formula| Law::of(equations, formula));
        laws.any(|law| law.at(&law.value, time).iter().map(|number| number.is_finite()).eq([true, false]))
    });
    drivers.collect()
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
    let (switches, may_bend) = (indicators(&mut law.arena, &law.value[..1]), law.may_bend());
    if switches.is_empty() && !may_bend {
        return None;
    }
    let [start, span] = [experiment.start, experiment.stop - experiment.start];
    let places: Vec<Vec<f64>> = (0..=PLACES).map(|place| law.at(&law.value, start + span * share(place))).collect();
    let finite = |index: usize| places.iter().map(move |place| place[index].abs()).filter(|size| size.is_finite());
    let largest = |index: usize| finite(index).fold(0.0, f64::max);
    let largest = [0, 1].map(largest);
    let times = sign_changes([start, span], &switches, &|roots, time| law.at(roots, time));
    let switches = times.into_iter().map(|time| (time, BESIDE));
    let bends = if may_bend { bends(&law, &places, largest, [start, span]) } else { Vec::new() };
    let mut candidates: Vec<(f64, [f64; 2])> =
        switches.chain(bends.into_iter().map(|time| (time, BESIDE_BEND))).collect();
    candidates.sort_by(|one, other| one.0.total_cmp(&other.0));
    candidates.into_iter().find_map(|(time, beside)| {
        let (what, of_rate) = jump(&law, largest, time, beside.map(|share| share * span))?;
        Some((time, what, of_rate))
    })
}

/// What of a law jumps at a switch, and whether it is a rate with two values.
fn jump(law: &Law, largest: [f64; 2], time: f64, beside: [f64; 2]) -> Option<(String, bool)> {
    // On both sides, first further away.
    let [far, near] = beside.map(|beside| [-1.0, 1.0].map(|side: f64| law.at(&law.value, time + side * beside)));
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

/// Where a law may jump or turn at once without a switch: between two places the rate changes by far more than around them, or the value by what the rates
/// do not explain.
fn bends(law: &Law, places: &[Vec<f64>], largest: [f64; 2], [start, span]: [f64; 2]) -> Vec<f64> {
    let (time, step) = (|place: usize| start + span * share(place), span * share(1));
    let change = |place: usize| (places[place + 1][1] - places[place][1]).abs();
    let jerks = |place: usize| {
        let around = [place.checked_sub(2), Some(place + 2).filter(|after| *after < PLACES)];
        let around = around.into_iter().flatten().map(change).fold(0.0, f64::max);
        let lack = unexplained(&places[place], &places[place + 1], step);
        // Written so that what is not finite may be a jump.
        let smooth = change(place) <= BENDS * around || change(place) <= JUMP * largest[1];
        let explained = lack <= step * around + JUMP * largest[0];
        !(smooth && explained)
    };
    let narrow = |place: usize| {
        let [mut before, mut behind] = [place, place + 1].map(|place| (time(place), places[place].clone()));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before.0 + behind.0);
            let value = law.at(&law.value, middle);
            let size = |one: &[f64], other: &[f64]| {
                let gap = unexplained(one, other, 0.5 * (behind.0 - before.0)) / largest[0].max(f64::MIN_POSITIVE);
                gap + (other[1] - one[1]).abs() / largest[1].max(f64::MIN_POSITIVE)
            };
            let later = size(&before.1, &value) <= size(&value, &behind.1);
            *(if later { &mut before } else { &mut behind }) = (middle, value);
        }
        0.5 * (before.0 + behind.0)
    };
    (0..PLACES).filter(|place| jerks(*place)).map(narrow).collect()
}

/// By how much a value changes between two places beyond what the rates there make of it.
fn unexplained(one: &[f64], other: &[f64], way: f64) -> f64 {
    (other[0] - one[0] - 0.5 * way * (one[1] + other[1])).abs()
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
