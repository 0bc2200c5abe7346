//! The terminal equations of the elements: their rows of Table 1.

use super::{acceleration, angle, direction, displacement, dot, force, scalar, torque};
use crate::element::{Angle, Direction, Element, Force, Known, Origin, Resistance, Torque};
use crate::equations::Equations;
use crate::expr::Expr;
use crate::graph::ElementId;
use crate::mechanism::{BodyId, Owner, Quantity, Variable};
use crate::print::motion::context;
use crate::print::name::{Name, Names};
use crate::print::read::Reading;
use crate::print::tree::{Tree, formulas};

/// Left and right sides; the right side may contain a formula of the scene.
enum Side {
    Tree(Tree),
    Formula(Expr),
    Components([Expr; 2]),
    /// A tree in front of components.
    Turned(Tree, [Expr; 2]),
    /// A formula in front of a tree.
    Times(Expr, Tree),
}

/// The equations of all elements, in order; those of forces and torques only if they are needed.
pub fn equations(equations: &mut Equations, dynamic: bool) -> Vec<(Tree, Tree)> {
    let elements = equations.system.elements.clone();
    let mut rows = Vec::new();
    for (index, element) in elements.iter().enumerate() {
        translation(equations, element, &mut rows);
        rotation(element, &mut rows);
        if dynamic {
            force_equations(equations, element, &mut rows);
            torque_equations(equations, ElementId(index), element, &mut rows);
        }
    }
    resolve(equations, rows)
}

type Rows = Vec<(Tree, Side)>;

fn translation(equations: &mut Equations, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.translation else { return };
    let own = displacement(element);
    let free = row.motion.first().map(|(along, _)| *along);
    match (&row.known, element.origin) {
        (Known::Zero, Origin::Joint(_)) => match free {
            Some(along @ Direction::Fixed(_, axis)) => {
                let axis_name = direction(along, element, true);
                rows.push((own, Side::Tree(Tree::product(vec![scalar("s", element), axis_name.clone()]))));
                rows.push((axis_name, turned(equations, fixed_in(along), axis)));
            }
            _ => rows.push((own, Side::Tree(Tree::zero()))),
        },
        (Known::Zero, _) => {}
        // A rolling disc: along the line, and a radius beside it.
        (Known::Fixed(body, at), Origin::Joint(_)) => {
            let beside = Tree::Name(Name::bold("h", &element.label));
            if let Some(along @ Direction::Fixed(_, axis)) = free {
                let axis_name = direction(along, element, true);
                let slide = Tree::product(vec![scalar("s", element), axis_name.clone()]);
                rows.push((own, Side::Tree(Tree::Sum(vec![(false, slide), (false, beside.clone())]))));
                rows.push((axis_name, turned(equations, fixed_in(along), axis)));
            }
            rows.push((beside, turned(equations, *body, *at)));
        }
        (Known::Fixed(body, at), _) => rows.push((own, turned(equations, *body, *at))),
        (Known::Given([x, y]), _) => rows.push((own, Side::Components([x.value, y.value]))),
        (Known::Along(_, _, signal), _) => {
            let axis = Tree::Name(Name::bold("u", &element.label));
            rows.push((own, Side::Times(signal.value, axis)));
        }
    }
}

fn force_equations(equations: &mut Equations, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.translation else { return };
    match &row.through {
        Force::None if row.motion.is_empty() => {}
        Force::None => {
            for (along, _) in &row.motion {
                rows.push((dot(force(element), direction(*along, element, true)), Side::Tree(Tree::zero())));
            }
        }
        Force::Inertia(body) => {
            let mass = Tree::Name(own(equations, *body, "mass"));
            let gravity =
                equations.system.mechanism.gravity.each_ref().map(|component| equations.system.value(component));
            let weight = (gravity != [Expr::ZERO; 2]).then(|| Tree::Name(Name::bold("g", "")));
            let net =
                Tree::sum([(true, acceleration(element))].into_iter().chain(weight.map(|g| (false, g))).collect());
            let through = match net {
                Tree::Sum(terms) if terms.len() == 1 => {
                    Tree::Sum(vec![(true, Tree::product(vec![mass, acceleration(element)]))])
                }
                net => Tree::product(vec![mass, net]),
            };
            rows.push((force(element), Side::Tree(through)));
        }
        Force::Resistance(law) => {
            if let Some((along, _)) = row.motion.first() {
                let speed = Tree::Name(Name {
                    dots: 1,
                    plain: format!("v_{}", element.label),
                    ..Name::letter("s", &element.label)
                });
                let side = resisting(equations, element, *law, speed, Quantity::V);
                rows.push((dot(force(element), direction(*along, element, true)), side));
            }
        }
        Force::World(vector) => {
            let components = vector.each_ref().map(|component| equations.formula(component));
            rows.push((force(element), Side::Components(components)));
        }
        Force::InBody(body, vector) => {
            let components = vector.each_ref().map(|component| equations.formula(component));
            rows.push((force(element), turned(equations, Some(*body), components)));
        }
        Force::Line(law) => {
            let law = equations.formula(law);
            let size = Tree::Call("abs", vec![displacement(element)]);
            let along = Tree::Quotient(Box::new([displacement(element), size]));
            rows.push((force(element), Side::Times(law, along)));
        }
    }
}

fn rotation(element: &Element, rows: &mut Rows) {
    let Some(row) = &element.rotation else { return };
    match &row.angle {
        Angle::Free(_) => {}
        Angle::Constant(value) => rows.push((angle(element), Side::Formula(*value))),
        Angle::Given(signal) => rows.push((angle(element), Side::Formula(signal.value))),
    }
}

fn torque_equations(equations: &mut Equations, id: ElementId, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.rotation else { return };
    match &row.through {
        Torque::None if matches!(row.angle, Angle::Free(_)) => rows.push((torque(element), Side::Tree(Tree::zero()))),
        Torque::None => {}
        Torque::Inertia(body) => {
            let inertia = Tree::Name(own(equations, *body, "inertia"));
            let alpha = Tree::Name(Name {
                dots: 2,
                plain: format!("alpha_{}", element.label),
                ..Name::letter("theta", &element.label)
            });
            let mut terms = vec![(true, Tree::product(vec![inertia, alpha]))];
            for other in carried(equations, id, *body) {
                terms.push((true, Tree::Relation("x", Box::new([displacement(&other), force(&other)]))));
            }
            rows.push((torque(element), Side::Tree(Tree::Sum(terms))));
        }
        Torque::Resistance(law) => {
            let omega = Tree::Name(Name {
                dots: 1,
                plain: format!("omega_{}", element.label),
                ..Name::letter("theta", &element.label)
            });
            let side = resisting(equations, element, *law, omega, Quantity::Omega);
            rows.push((torque(element), side));
        }
        Torque::Law(law) => {
            let law = equations.formula(law);
            rows.push((torque(element), Side::Formula(law)));
        }
    }
}

/// -c v; with friction the whole law of the joint's velocity.
fn resisting(equations: &mut Equations, element: &Element, law: Resistance, speed: Tree, quantity: Quantity) -> Side {
    match (law.damper(), element.origin) {
        (None, Origin::Joint(joint)) => {
            let velocity = equations.variable(Variable { owner: Owner::Joint(joint), quantity });
            Side::Formula(law.at(&mut equations.system.arena, velocity))
        }
        (damper, _) => Side::Times(damper.unwrap_or(Expr::ZERO), Tree::Sum(vec![(true, speed)])),
    }
}

/// Arms of a body, and slides whose axis is fixed in it: their forces turn it (6).
fn carried(equations: &Equations, own: ElementId, body: BodyId) -> Vec<Element> {
    let is_carried = |element: &Element| match (element.origin, &element.translation) {
        (Origin::Arm(of, _), _) => of == body,
        (Origin::Joint(_), Some(row)) => row.motion.iter().any(|(along, _)| fixed_in(*along) == Some(body)),
        (Origin::Driver(_), Some(row)) => matches!(row.known, Known::Along(of, ..) if of == Some(body)),
        _ => false,
    };
    let others = equations.system.elements.iter().enumerate().filter(|(index, _)| *index != own.0);
    others.map(|(_, element)| element).filter(|element| is_carried(element)).cloned().collect()
}

fn fixed_in(along: Direction) -> Option<BodyId> {
    match along {
        Direction::Fixed(body, _) => body,
        Direction::X | Direction::Y => None,
    }
}

/// R(theta) (x, y); the ground does not turn.
fn turned(equations: &Equations, body: Option<BodyId>, at: [Expr; 2]) -> Side {
    match body {
        None => Side::Components(at),
        Some(body) => Side::Turned(Tree::Call("R", vec![Tree::Name(own(equations, body, "angle"))]), at),
    }
}

fn own(equations: &Equations, body: BodyId, word: &str) -> Name {
    Name::variable(&format!("{}.{word}", equations.system.mechanism.bodies[body.0].name))
}

/// Puts formulas of the scene where expressions stand; abbreviations go behind.
fn resolve(equations: &mut Equations, rows: Rows) -> Vec<(Tree, Tree)> {
    let roots = rows.iter().flat_map(|(_, side)| match side {
        Side::Tree(_) => Vec::new(),
        Side::Formula(expr) | Side::Times(expr, _) => vec![*expr],
        Side::Components(pair) | Side::Turned(_, pair) => pair.to_vec(),
    });
    let roots: Vec<Expr> = roots.collect();
    let context = context(equations);
    let reading = Reading::new(&equations.system.arena, &roots, &context);
    let resolved = formulas(&reading, &Names::new(equations));
    let mut found = resolved.formulas.into_iter();
    let mut next = || found.next().unwrap_or_else(Tree::zero);
    let mut lines = Vec::new();
    for (left, side) in rows {
        let right = match side {
            Side::Tree(tree) => tree,
            Side::Formula(_) => next(),
            Side::Components(_) => Tree::Call("", vec![next(), next()]),
            Side::Turned(turn, _) => Tree::product(vec![turn, Tree::Call("", vec![next(), next()])]),
            Side::Times(_, tree) => Tree::product(vec![next(), tree]),
        };
        lines.push((left, right));
    }
    lines.extend(resolved.angles);
    lines.extend(resolved.definitions);
    lines
}
