//! Where laws of drivers jump, or their rates do: at switches (`min`, `abs`, `if`), and where a root, a quotient or an arc bends without one.

use super::rough::{RoughPlace, Roughness};
use super::steep::divisor;
use crate::expr::{Arena, Binary, Expr, ExprNode, Symbol, Unary, indicators};
use crate::model::translate::translate;
use crate::model::{Formula, KeyValue, Mechanism, Motion, Part};

/// The experiment is looked at in so many places, and jumps are found between them by so many halvings.
pub(crate) const PLACES: usize = 2000;
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

/// A law of time and parameters.
pub(crate) struct TimeLaw {
    pub arena: Arena,
    /// The law and its rate.
    pub value: [Expr; 2],
    parameters: Vec<f64>,
}

impl TimeLaw {
    /// None if it depends on anything else.
    fn of(mechanism: &Mechanism, formula: &Formula) -> Option<Self> {
        let mut arena = Arena::default();
        // Resolving refuses laws with variables.
        let value = translate(&mut arena, formula, &mut |_, _| Expr::ZERO);
        let depends = |symbol: &Symbol| matches!(symbol, Symbol::Time | Symbol::Parameter(_));
        if !arena.symbols([value]).iter().all(depends) {
            return None;
        }
        let value = [value, arena.time_derivative(value)];
        Some(Self { arena, value, parameters: mechanism.parameter_values() })
    }

    /// The same of a law that may have variables, inputs and states: none if it has.
    pub fn of_time(mechanism: &Mechanism, formula: &Formula) -> Option<Self> {
        let mut moves = false;
        formula.visit(&mut |part| {
            moves |= matches!(part, Formula::Variable(_) | Formula::Input(_) | Formula::Discrete(_) | Formula::State(_))
        });
        if moves { None } else { Self::of(mechanism, formula) }
    }

    /// Is there a function whose value or rate may jump without a switch: a root, say, where its argument touches zero?
    fn may_bend(&mut self) -> bool {
        let expanded = self.arena.expanded(&self.value[..1]);
        let bends = |expr: Expr| match self.arena.node(expr) {
            ExprNode::Unary(Unary::Asin | Unary::Acos | Unary::Tan, a) | ExprNode::Binary(Binary::Atan2, a, _) => {
                Some(a)
            }
            _ => divisor(&self.arena, expr),
        };
        let mut arguments = self.arena.reachable(expanded).into_iter().filter_map(bends);
        arguments.any(|argument| self.arena.symbols([argument]).iter().any(|symbol| matches!(symbol, Symbol::Time)))
    }

    fn spot(&self, time: f64) -> RoughPlace {
        let found = self.at(&self.value, time);
        RoughPlace { at: time, value: [found[0], found[1]] }
    }

    pub fn at(&self, roots: &[Expr], time: f64) -> Vec<f64> {
        let known = |symbol: Symbol| match symbol {
            Symbol::Parameter(index) => self.parameters[index],
            Symbol::Time => time,
            Symbol::Discrete(_) | Symbol::Input(..) | Symbol::Follower(..) | Symbol::Coordinate(..) => time,
            Symbol::State(..) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => time,
        };
        self.arena.evaluate(roots, &known)
    }
}

/// The first jump of a driver's law within the experiment.
pub(crate) struct Jump {
    /// Which driver.
    pub driver: usize,
    pub time: f64,
    /// What jumps, from where to where.
    pub what: String,
    /// Has the rate two values there?
    pub of_rate: bool,
}

/// Those of all drivers.
pub(crate) fn jumps(mechanism: &Mechanism) -> Vec<Jump> {
    let jump = |(driver, part): (usize, &Part)| laws(part).find_map(|formula| first_jump(mechanism, driver, formula));
    mechanism.drivers.iter().enumerate().filter_map(jump).collect()
}

/// The drivers whose laws have a value at a time, but no rate.
pub(crate) fn without_rate(mechanism: &Mechanism, time: f64) -> impl Iterator<Item = &Part> {
    mechanism.drivers.iter().filter(move |part| {
        let mut laws = laws(part).filter_map(|formula| TimeLaw::of(mechanism, formula));
        laws.any(|law| law.at(&law.value, time).iter().map(|number| number.is_finite()).eq([true, false]))
    })
}

/// What a driver prescribes.
pub(crate) fn laws(part: &Part) -> impl Iterator<Item = &Formula> {
    part.values.iter().flat_map(|(_, value)| match value {
        KeyValue::Motion(Motion::Given(formula)) => std::slice::from_ref(formula),
        KeyValue::Vector(both) => both,
        _ => &[],
    })
}

/// All formulas of a load or driver.
pub(crate) fn formulas(part: &Part) -> Vec<&Formula> {
    part.values.iter().flat_map(|(_, value)| value.formulas()).collect()
}

/// When a law of time jumps first, or its rate does, and from where to where.
fn first_jump(mechanism: &Mechanism, driver: usize, formula: &Formula) -> Option<Jump> {
    let experiment = mechanism.experiment;
    let mut law = TimeLaw::of(mechanism, formula)?;
    let (switches, may_bend) = (indicators(&mut law.arena, &law.value[..1]), law.may_bend());
    if switches.is_empty() && !may_bend {
        return None;
    }
    let [start, span] = [experiment.start, experiment.stop - experiment.start];
    let spots: Vec<RoughPlace> = (0..=PLACES).map(|place| law.spot(start + span * share(place))).collect();
    let finite = |index: usize| spots.iter().map(move |spot| spot.value[index].abs()).filter(|size| size.is_finite());
    let largest = |index: usize| finite(index).fold(0.0, f64::max);
    let largest = [0, 1].map(largest);
    let switches = sign_changes(&law, &switches, [start, span]).into_iter().map(|time| (time, BESIDE));
    let bends = if may_bend { bends(&law, &spots, largest) } else { Vec::new() };
    let mut candidates: Vec<(f64, [f64; 2])> =
        switches.chain(bends.into_iter().map(|time| (time, BESIDE_BEND))).collect();
    candidates.sort_by(|one, other| one.0.total_cmp(&other.0));
    candidates.into_iter().find_map(|(time, beside)| {
        let (what, of_rate) = jump(&law, largest, time, beside.map(|share| share * span))?;
        Some(Jump { driver, time, what, of_rate })
    })
}

/// What of a law jumps at a switch, and whether it is a rate with two values.
fn jump(law: &TimeLaw, largest: [f64; 2], time: f64, beside: [f64; 2]) -> Option<(String, bool)> {
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
        Some(("its rate is unbounded".to_owned(), false))
    } else {
        jumps(1).then(|| (says("its rate", 1), true))
    }
}

/// Where a law may jump or turn at once without a switch.
fn bends(law: &TimeLaw, spots: &[RoughPlace], largest: [f64; 2]) -> Vec<f64> {
    let rough = Roughness { bends: BENDS, least: JUMP, halvings: HALVINGS, largest };
    let sharpest = |step: usize| rough.sharpest([spots[step], spots[step + 1]], |time| law.spot(time).value);
    rough.steps(spots).into_iter().map(sharpest).map(|[low, high]| 0.5 * (low.at + high.at)).collect()
}

/// When functions of time change their signs.
fn sign_changes(law: &TimeLaw, functions: &[Expr], [start, span]: [f64; 2]) -> Vec<f64> {
    let time = |place: usize| start + span * share(place);
    let positive = |function: Expr, time: f64| law.at(&[function], time)[0] >= 0.0;
    let mut found = Vec::new();
    for &function in functions {
        let signs: Vec<bool> = (0..=PLACES).map(|place| positive(function, time(place))).collect();
        for place in (0..PLACES).filter(|&place| signs[place] != signs[place + 1]) {
            let sides = [time(place), time(place + 1)];
            found.push(halved(sides, |middle| positive(function, middle) == signs[place]));
        }
    }
    found
}

/// A time between two, by halving: `later` says whether it lies behind their middle.
fn halved([mut before, mut behind]: [f64; 2], mut later: impl FnMut(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + behind);
        *(if later(middle) { &mut before } else { &mut behind }) = middle;
    }
    0.5 * (before + behind)
}

pub(crate) fn share(place: usize) -> f64 {
    place as f64 / PLACES as f64
}
