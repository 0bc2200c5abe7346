//! Where the laws of a scene have values: the arguments of their divisions, roots and logarithms.

use cotree_fmu::program::domain::{Domain, Limit};

use crate::equations::{Equations, if_positive};
use crate::expr::{Binary, Expr, Function, Order, Symbol, Unary};
use crate::model::{Comparison, Formula, Friction, KeyValue, Mechanism, Motion, Owner, Part, Quantity, Variable};
use crate::network::{Force, Origin};

/// The arguments that must stay within limits, what may be said of one thing before what is said of a whole law.
pub(crate) fn domains(equations: &mut Equations) -> Vec<(Domain, Expr)> {
    let mechanism = &equations.system.mechanism;
    let mut found = ArgumentDomains { mechanism, arguments: Vec::new() };
    for part in mechanism.parts() {
        found.part(part);
    }
    for state in &mechanism.states {
        found.law(&format!("states.{}.rate", state.name), &state.rate);
    }
    found.arguments.sort_by_key(|(domain, _)| domain.limit == Limit::Value);
    let laws = found.arguments.into_iter().map(|(domain, argument)| (domain, equations.formula(&argument)));
    let mut domains: Vec<(Domain, Expr)> = laws.collect();
    domains.extend(distances(equations));
    domains.extend(courses(equations));
    let arena = &equations.system.arena;
    let is_known = |symbol: Symbol| match symbol {
        Symbol::Coordinate(_, order) => order != Order::Acceleration,
        Symbol::State(_, order) => order == Order::Position,
        Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => false,
        Symbol::Time | Symbol::Parameter(_) | Symbol::Discrete(_) | Symbol::Input(..) | Symbol::Follower(..) => true,
    };
    // What moves, and what is known before the accelerations are.
    domains.retain(|(_, argument)| {
        arena.as_constant(*argument).is_none() && arena.symbols([*argument]).into_iter().all(is_known)
    });
    domains
}

/// Values of keys that must keep within a range, whatever the parameters are.
pub(crate) fn ranges(equations: &mut Equations) -> Vec<(Domain, Expr)> {
    let mechanism = &*equations.system.mechanism.clone();
    let limits = mechanism.bounds.iter().map(|bound| {
        let (place, argument) = (bound.name.clone(), mechanism.written(&bound.value));
        (Domain { place, argument, limit: bound.limit }, equations.formula(&bound.value))
    });
    limits.collect()
}

/// Forces along the line between two points have no direction where these meet.
fn distances(equations: &mut Equations) -> Vec<(Domain, Expr)> {
    let mechanism = &*equations.system.mechanism.clone();
    let lines = equations.system.elements.iter().filter_map(|element| match (&element.translation, element.origin) {
        (Some(row), Origin::Load(load)) if matches!(row.through, Force::Line(_)) => Some(load),
        _ => None,
    });
    let mut loads: Vec<_> = lines.collect();
    loads.retain(|&load| {
        let id = equations.system.find(Origin::Load(load));
        id.is_none_or(|id| equations.centred(id).is_none())
    });
    let distance = |load: crate::model::LoadId| {
        let part = &mechanism.loads[load.0];
        let [a, b] = part.between.map(|place| mechanism.place_name(place));
        let domain = Domain {
            place: format!("loads.{}", part.name),
            argument: format!("`{a}` and `{b}`"),
            limit: Limit::Distance,
        };
        let length = Variable { owner: Owner::Load(load), quantity: Quantity::Length };
        (domain, equations.formula(&Formula::Variable(length)))
    };
    loads.into_iter().map(distance).collect()
}

/// Ropes and bands need tangents between circles, and do not push pulleys away.
fn courses(equations: &mut Equations) -> Vec<(Domain, Expr)> {
    let mechanism = &*equations.system.mechanism.clone();
    let mut found = Vec::new();
    for part in mechanism.parts_over_pulleys() {
        let names: Vec<String> =
            part.stations().unwrap_or_default().iter().map(|station| mechanism.place_name(station.at)).collect();
        for (square, ends) in equations.squares_of_straight_parts(part.owner).into_iter().zip(names.windows(2)) {
            let place = format!("the straight part of `{}` between `{}` and `{}`", part.name, ends[0], ends[1]);
            found.push((Domain { place, argument: "length^2".to_owned(), limit: Limit::Positive }, square));
        }
    }
    for (place, margin) in equations.course_margins() {
        let domain = |limit| Domain { place: place.clone(), argument: "wrap".to_owned(), limit };
        let is_left = if_positive(&mut equations.system.arena, margin);
        found.extend([(domain(Limit::NotNegative), margin), (domain(Limit::Value), is_left)]);
    }
    found
}

/// What has been found so far.
struct ArgumentDomains<'m> {
    mechanism: &'m Mechanism,
    arguments: Vec<(Domain, Formula)>,
}

/// Conditions under which a part of a formula counts: left, right, and whether the comparison holds.
type Conditions<'f> = Vec<(Comparison, [&'f Formula; 2], bool)>;

impl ArgumentDomains<'_> {
    fn part(&mut self, part: &Part) {
        let table = match part.owner {
            Owner::Joint(_) => "joints",
            Owner::Driver(_) => "drivers",
            Owner::Load(_) | Owner::Place(_) | Owner::System => "loads",
        };
        let place = format!("{table}.{}", part.name);
        for (key, value) in &part.values {
            let place = format!("{place}.{key}");
            match value {
                KeyValue::Formula(formula) | KeyValue::Motion(Motion::Given(formula)) => self.law(&place, formula),
                KeyValue::Vector(components) => components.iter().for_each(|component| self.law(&place, component)),
                KeyValue::Friction(friction) => {
                    self.law(&format!("{place}.coulomb"), &friction.coulomb);
                    if let Some(velocity) = &friction.velocity {
                        self.law(&format!("{place}.velocity"), velocity);
                        self.add(&format!("{place}.velocity"), Limit::Divisor, velocity, &Vec::new());
                    }
                    self.law(&format!("{place}.mu"), &friction.mu);
                }
                KeyValue::Limits(limits) => limits.formulas().for_each(|formula| self.law(&place, formula)),
                _ => {}
            }
        }
        if let Some(law) = part.law() {
            self.law(&place, &law);
        }
        if let Some(friction) = part.component().rubs.and_then(|rubs| (rubs.law)(part)) {
            self.friction(&place, part, &friction);
        }
    }

    /// Laws that may lead friction out of its range.
    fn friction(&mut self, place: &str, part: &Part, friction: &Friction) {
        let one = Formula::Number(1.0);
        let keys = if part.friction().is_some() {
            ["friction.coulomb", "friction.mu", "friction.static"]
        } else {
            ["level", "mu", "static"]
        };
        let laws = [
            (&friction.coulomb, Limit::NotNegative, Formula::Number(-NEGATIVE)),
            (&friction.mu, Limit::NotNegative, Formula::Number(-NEGATIVE)),
            (&friction.ratio, Limit::AtLeast(1.0), Formula::Number(1.0 - NEGATIVE)),
        ];
        for (key, (law, limit, least)) in keys.into_iter().zip(laws).filter(|(_, (law, ..))| law.varies()) {
            let domain = Domain { place: format!("{place}.{key}"), argument: self.mechanism.written(law), limit };
            let outside = Formula::If(Comparison::Less, Box::new([law.clone(), least, law.clone(), one.clone()]));
            self.arguments.push((domain, outside));
        }
    }

    fn law(&mut self, place: &str, formula: &Formula) {
        self.visit(place, formula, &mut Vec::new());
        self.add(place, Limit::Value, formula, &Vec::new());
    }

    fn visit<'f>(&mut self, place: &str, formula: &'f Formula, conditions: &mut Conditions<'f>) {
        match formula {
            Formula::If(comparison, parts) => {
                let [left, right, then, otherwise] = &**parts;
                [left, right].into_iter().for_each(|side| self.visit(place, side, conditions));
                for (branch, holds) in [(then, true), (otherwise, false)] {
                    conditions.push((*comparison, [left, right], holds));
                    self.visit(place, branch, conditions);
                    conditions.pop();
                }
            }
            Formula::Call(function, arguments) => {
                arguments.iter().for_each(|argument| self.visit(place, argument, conditions));
                let limited = match (function, &arguments[..]) {
                    (Function::Two(Binary::Divide), [_, divisor]) => Some((Limit::Divisor, divisor)),
                    (Function::Two(Binary::Power), [base, Formula::Number(power)]) if power.fract() == 0.0 => {
                        (*power < 0.0).then_some((Limit::Divisor, base))
                    }
                    (Function::Two(Binary::Power), [base, _]) => Some((Limit::Base, base)),
                    (Function::One(Unary::Sqrt), [argument]) => Some((Limit::Root, argument)),
                    (Function::One(Unary::Log), [argument]) => Some((Limit::Logarithm, argument)),
                    (Function::One(Unary::Asin | Unary::Acos), [argument]) => Some((Limit::ArcSine, argument)),
                    _ => None,
                };
                if let Some((limit, argument)) = limited {
                    self.add(place, limit, argument, conditions);
                }
            }
            _ => {}
        }
    }

    /// What is not chosen counts as one, which every limit allows.
    fn add(&mut self, place: &str, limit: Limit, argument: &Formula, conditions: &Conditions) {
        let text = self.mechanism.written(argument);
        let domain = Domain { place: place.to_string(), argument: text, limit };
        let known = |(other, _): &(Domain, Formula)| other.argument == domain.argument && other.limit == limit;
        if matches!(argument, Formula::Number(_)) || self.arguments.iter().rev().take(RECENT).any(known) {
            return;
        }
        let one = Formula::Number(1.0);
        let guarded = conditions.iter().rev().fold(argument.clone(), |inner, (comparison, [left, right], holds)| {
            let (left, right) = ((*left).clone(), (*right).clone());
            let parts = if *holds { [left, right, inner, one.clone()] } else { [left, right, one.clone(), inner] };
            Formula::If(*comparison, Box::new(parts))
        });
        self.arguments.push((domain, guarded));
    }
}

/// What is negative by no more than this, in SI units, is a zero with the errors of states.
const NEGATIVE: f64 = 1e-6;

/// A law is made of what the keys of its own part say: so far back the same argument is sought.
const RECENT: usize = 16;
