//! The terminal equations of the elements: their rows of Table 1.

mod coupling;

use super::letters::Letters;
use crate::component::{Angle, Direction, Element, Force, Known, Origin, Resistance, Torque};
use crate::equations::Equations;
use crate::expr::Expr;
use crate::graph::ElementId;
use crate::mechanism::{BodyId, Owner, Quantity, Variable};
use crate::output::text::motion::context;
use crate::output::text::name::{Name, Names};
use crate::output::text::read::Reading;
use crate::output::text::tree::{Tree, formulas};

/// A right side; it may contain formulas of the scene.
enum Side {
    Tree(Tree),
    /// Formulas times trees; a formula alone has none.
    Sum(Vec<(Expr, Option<Tree>)>),
    Components([Expr; 2]),
    Turned(Tree, [Expr; 2]),
}

impl Side {
    fn formula(expr: Expr) -> Side {
        Side::Sum(vec![(expr, None)])
    }

    fn times(expr: Expr, tree: Tree) -> Side {
        Side::Sum(vec![(expr, Some(tree))])
    }

    fn formulas(&self) -> Vec<Expr> {
        match self {
            Side::Tree(_) => Vec::new(),
            Side::Sum(terms) => terms.iter().map(|(expr, _)| *expr).collect(),
            Side::Components(pair) | Side::Turned(_, pair) => pair.to_vec(),
        }
    }
}

type Rows = Vec<(Tree, Side)>;

/// The equations of all elements, in order; those of forces and torques only if they are needed.
pub fn equations(equations: &mut Equations, dynamic: bool) -> Vec<(Tree, Tree)> {
    let elements = equations.system.elements.clone();
    let letters = Letters::new(equations.system.mechanism.dimension);
    let mut rows = Vec::new();
    for (index, element) in elements.iter().enumerate() {
        let id = ElementId(index);
        translation(equations, letters, element, &mut rows);
        rotation(letters, element, &mut rows);
        coupling::relation(equations, letters, id, &mut rows);
        if dynamic {
            force_equations(equations, letters, element, &mut rows);
            torque_equations(equations, letters, id, &mut rows);
            coupling::loads(equations, letters, id, &mut rows);
        }
    }
    let mechanism = equations.system.mechanism;
    let gravity = mechanism.gravity.each_ref().map(|component| equations.system.value(component));
    if dynamic && gravity != [Expr::ZERO; 2] {
        rows.push((letters.gravity(), components(letters, gravity)));
    }
    resolve(equations, rows)
}

fn translation(equations: &mut Equations, letters: Letters, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.translation else { return };
    let own = letters.displacement(&element.label);
    let slide = row.motion.first().and_then(|(along, _)| match *along {
        Direction::Fixed(body, axis) => Some((letters.direction(*along, element, true), body, axis)),
        Direction::X | Direction::Y => None,
    });
    match (&row.known, element.origin, slide) {
        (Known::Zero, Origin::Joint(_), Some((axis_name, body, axis))) => {
            let slide = Tree::product(vec![letters.slide(&element.label), axis_name.clone()]);
            rows.push((own, Side::Tree(slide)));
            rows.push((axis_name, turned(equations, letters, body, axis)));
        }
        (Known::Zero, Origin::Joint(_), None) => rows.push((own, Side::Tree(Tree::zero()))),
        (Known::Zero, ..) => {}
        // A rolling disc: along the line, and a radius beside it.
        (Known::Fixed(body, at), Origin::Joint(_), Some((axis_name, of, axis))) => {
            let beside = Tree::Name(Name::bold("h", &element.label));
            let slide = Tree::product(vec![letters.slide(&element.label), axis_name.clone()]);
            rows.push((own, Side::Tree(Tree::Sum(vec![(false, slide), (false, beside.clone())]))));
            rows.push((axis_name, turned(equations, letters, of, axis)));
            rows.push((beside, turned(equations, letters, *body, *at)));
        }
        (Known::Fixed(body, at), ..) => rows.push((own, turned(equations, letters, *body, *at))),
        (Known::Given([x, y]), ..) => rows.push((own, components(letters, [x.value, y.value]))),
        (Known::Along(of, axis, signal), ..) => {
            let axis_name = Tree::Name(Name::bold("u", &element.label));
            rows.push((own, Side::times(signal.value, axis_name.clone())));
            rows.push((axis_name, turned(equations, letters, *of, *axis)));
        }
    }
}

fn force_equations(equations: &mut Equations, letters: Letters, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.translation else { return };
    let own = letters.force(&element.label);
    match &row.through {
        // The free direction of a rolling disc belongs to its coupling.
        Force::None if element.coupling.is_some() => {}
        Force::None => {
            for (along, _) in &row.motion {
                let projected = letters.projected(own.clone(), *along, element, true);
                rows.push((projected, Side::Tree(Tree::zero())));
            }
        }
        Force::Inertia(body) => {
            let mass = Tree::Name(own_name(equations, *body, "mass"));
            rows.push((own, Side::Tree(inertia_force(equations, letters, element, *body, mass))));
        }
        Force::Resistance(law) => {
            if let Some((along, _)) = row.motion.first() {
                let speed = Tree::Name(Name {
                    dots: 1,
                    plain: format!("v_{}", element.label),
                    ..Name::letter("s", &element.label)
                });
                let side = resisting(equations, element, *law, speed, Quantity::V);
                rows.push((letters.projected(own, *along, element, true), side));
            }
        }
        Force::World(vector) => {
            let vector = vector.each_ref().map(|component| equations.formula(component));
            rows.push((own, components(letters, vector)));
        }
        Force::InBody(body, vector) => {
            let vector = vector.each_ref().map(|component| equations.formula(component));
            rows.push((own, turned(equations, letters, Some(*body), vector)));
        }
        Force::Line(law) => {
            let law = equations.formula(law);
            rows.push((own, Side::times(law, unit(letters, &element.label))));
        }
    }
}

/// -m (a - g); a body that opts out of gravity has no g.
fn inertia_force(equations: &mut Equations, letters: Letters, element: &Element, body: BodyId, mass: Tree) -> Tree {
    let mechanism = equations.system.mechanism;
    let gravity = mechanism.gravity.each_ref().map(|component| equations.system.value(component));
    let weightless = mechanism.bodies[body.0].weightless || gravity == [Expr::ZERO; 2];
    let acceleration = letters.acceleration(&element.label);
    match weightless {
        true => Tree::Sum(vec![(true, Tree::product(vec![mass, acceleration]))]),
        false => Tree::product(vec![mass, Tree::sum(vec![(true, acceleration), (false, letters.gravity())])]),
    }
}

/// The direction from one end of an element to the other.
fn unit(letters: Letters, label: &str) -> Tree {
    let size = Tree::Call("abs", vec![letters.displacement(label)]);
    Tree::Quotient(Box::new([letters.displacement(label), size]))
}

fn rotation(letters: Letters, element: &Element, rows: &mut Rows) {
    let Some(row) = &element.rotation else { return };
    match &row.angle {
        Angle::Free(_) => {}
        Angle::Constant(value) => rows.push((letters.angle(&element.label), Side::formula(*value))),
        Angle::Given(signal) => rows.push((letters.angle(&element.label), Side::formula(signal.value))),
    }
}

fn torque_equations(equations: &mut Equations, letters: Letters, id: ElementId, rows: &mut Rows) {
    let element = equations.system.element(id).clone();
    let Some(row) = &element.rotation else { return };
    let own = letters.torque(&element.label);
    match &row.through {
        Torque::None if matches!(row.angle, Angle::Free(_)) && element.coupling.is_none() => {
            rows.push((own, Side::Tree(Tree::zero())));
        }
        Torque::None => {}
        Torque::Inertia(body) => {
            let inertia = Tree::Name(own_name(equations, *body, "inertia"));
            let alpha = Tree::Name(Name {
                dots: 2,
                plain: format!("alpha_{}", element.label),
                ..Name::letter("theta", &element.label)
            });
            let mut terms = vec![(true, Tree::product(vec![inertia, alpha]))];
            for other in carried(equations, id, *body) {
                let moment = [letters.displacement(&other), letters.force(&other)];
                terms.push((true, Tree::Relation("x", Box::new(moment))));
            }
            rows.push((own, Side::Tree(Tree::Sum(terms))));
        }
        Torque::Resistance(law) => {
            let omega = Tree::Name(Name {
                dots: 1,
                plain: format!("omega_{}", element.label),
                ..Name::letter("theta", &element.label)
            });
            let side = resisting(equations, &element, *law, omega, Quantity::Omega);
            rows.push((own, side));
        }
        Torque::Law(law) => {
            let law = equations.formula(law);
            rows.push((own, Side::formula(law)));
        }
    }
}

/// -c v; with friction the whole law of the joint's velocity.
fn resisting(equations: &mut Equations, element: &Element, law: Resistance, speed: Tree, quantity: Quantity) -> Side {
    match (law.damper(), element.origin) {
        (None, Origin::Joint(joint)) => {
            let velocity = equations.variable(Variable { owner: Owner::Joint(joint), quantity });
            Side::formula(law.at(&mut equations.system.arena, velocity))
        }
        (damper, _) => {
            let minus = equations.system.arena.negate(damper.unwrap_or(Expr::ZERO));
            Side::times(minus, speed)
        }
    }
}

/// The edges whose forces turn a body (6): its arms, what slides along an axis fixed in it, and couplings along such an axis.
fn carried(equations: &Equations, own: ElementId, body: BodyId) -> Vec<String> {
    let system = &equations.system;
    let is_carried = |element: &Element| match (element.origin, &element.translation) {
        (Origin::Arm(of, _), _) => of == body,
        (Origin::Joint(_) | Origin::Driver(_), Some(row)) => row.carrier() == Some(body),
        _ => false,
    };
    let others = system.elements.iter().enumerate().filter(|(index, _)| *index != own.0);
    let edges = others.filter(|(_, element)| is_carried(element)).map(|(_, element)| element.label.clone());
    edges.chain(coupling::carried(system, body)).collect()
}

/// R(theta) (x, y); the ground does not turn, nor does anything on a line.
fn turned(equations: &Equations, letters: Letters, body: Option<BodyId>, at: [Expr; 2]) -> Side {
    match body {
        Some(body) if letters.has_two_components() => {
            Side::Turned(Tree::Call("R", vec![Tree::Name(own_name(equations, body, "angle"))]), at)
        }
        _ => components(letters, at),
    }
}

fn components(letters: Letters, vector: [Expr; 2]) -> Side {
    if letters.has_two_components() { Side::Components(vector) } else { Side::formula(vector[0]) }
}

fn own_name(equations: &Equations, body: BodyId, word: &str) -> Name {
    Name::variable(&format!("{}.{word}", equations.system.mechanism.bodies[body.0].name))
}

/// Replaces expressions by formulas; abbreviations follow.
fn resolve(equations: &mut Equations, rows: Rows) -> Vec<(Tree, Tree)> {
    let roots: Vec<Expr> = rows.iter().flat_map(|(_, side)| side.formulas()).collect();
    let context = context(equations);
    let reading = Reading::new(&equations.system.arena, &roots, &context);
    let resolved = formulas(&reading, &Names::new(equations));
    let mut found = resolved.formulas.into_iter();
    let mut next = || found.next().unwrap_or_else(Tree::zero);
    let mut lines = Vec::new();
    for (left, side) in rows {
        let right = match side {
            Side::Tree(tree) => tree,
            Side::Sum(terms) => sum(terms.into_iter().map(|(_, tree)| (next(), tree)).collect()),
            Side::Components(_) => Tree::Call("", vec![next(), next()]),
            Side::Turned(turn, _) => Tree::product(vec![turn, Tree::Call("", vec![next(), next()])]),
        };
        lines.push((left, right));
    }
    lines.extend(resolved.angles);
    lines.extend(resolved.definitions);
    lines
}

/// Products with their signs in front; ones and zeros are left out.
fn sum(terms: Vec<(Tree, Option<Tree>)>) -> Tree {
    let one = Tree::Number(1.0);
    let term = |(factor, tree): (Tree, Option<Tree>)| {
        let (minus, factor) = match factor {
            Tree::Sum(mut only) if only.len() == 1 => only.remove(0),
            other => (false, other),
        };
        let product = match tree {
            Some(tree) if factor == one => tree,
            Some(tree) if factor != Tree::zero() => Tree::product(vec![factor, tree]),
            _ => factor,
        };
        (minus, product)
    };
    Tree::sum(terms.into_iter().map(term).filter(|(_, tree)| *tree != Tree::zero()).collect())
}
