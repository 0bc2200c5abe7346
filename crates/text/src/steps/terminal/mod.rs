//! The terminal equations of the elements: their rows of Table 1.

mod coupling;
mod law;

use cotree::component::{Angle, Direction, Element, Force, Known, Origin, Resistance, Torque};
use cotree::equations::Equations;
use cotree::expr::Expr;
use cotree::graph::ElementId;
use cotree::mechanism::{BodyId, Owner, Quantity, Variable};

use super::labels::number;
use super::letters::Letters;
use super::parts::kind;
use super::{Lesson, heading, thinned, words};
use crate::document::{Block, Piece};
use crate::name::Name;
use crate::tree::{Tree, plain};

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

impl Lesson<'_> {
    /// Section 5: what each element says by itself.
    pub fn terminal(&mut self) -> Vec<Block> {
        let count = self.equations.system.elements.len();
        let mut rows = Vec::new();
        for id in (0..count).map(ElementId) {
            let element = self.equations.system.element(id).clone();
            let equation = |(left, right)| Piece::Math(Tree::Relation("=", Box::new([left, right])));
            let equations = Piece::list(";  ", self.says(id).into_iter().map(equation));
            let row = vec![Piece::words(&element.label), equations, self.unknowns(&element)];
            rows.push((kind(&element).to_owned(), row));
        }
        let mut blocks = vec![heading("5. What does each part say by itself? Terminal equations (Table 1)")];
        blocks.push(words("Nothing is eliminated yet; u and n are unit vectors along and across an axis, R turns by an angle, k is out of the plane."));
        blocks.extend(thinned("Terminal equations", &["edge", "equations", "unknown"], rows));
        blocks.extend(self.gravity());
        if self.letters.has_two_components() {
            blocks.push(words("What is fixed in a body, arms and axes, turns with it:"));
            blocks.push(Block::Equations(turning()));
        }
        blocks.push(words(self.count_of_equations()));
        blocks
    }

    /// The components of gravity, if it acts.
    fn gravity(&mut self) -> Option<Block> {
        let mechanism = &*self.equations.system.mechanism.clone();
        let gravity = mechanism.gravity.each_ref().map(|component| self.equations.system.value(component));
        let [x, y] = <[Tree; 2]>::try_from(plain(&self.equations, &gravity)).ok()?;
        let acts = self.dynamic && gravity != [Expr::ZERO; 2];
        acts.then(|| Block::Equations(vec![(self.letters.gravity(), pair(self.letters, [x, y]))]))
    }

    /// The terminal equations of one element, forces and torques only if there are masses.
    pub fn says(&mut self, id: ElementId) -> Vec<(Tree, Tree)> {
        let (letters, dynamic) = (self.letters, self.dynamic);
        let equations = &mut self.equations;
        let element = equations.system.element(id).clone();
        let mut rows = Vec::new();
        translation(equations, letters, &element, &mut rows);
        rotation(letters, &element, &mut rows);
        coupling::relation(equations, letters, id, &mut rows);
        if dynamic {
            force_equations(equations, letters, &element, &mut rows);
            torque_equations(equations, letters, id, &mut rows);
            coupling::loads(equations, letters, id, &mut rows);
        }
        resolve(equations, rows)
    }

    /// What an element leaves unknown: r or s, F or lambda, theta, T.
    fn unknowns(&self, element: &Element) -> Piece {
        let (letters, label) = (self.letters, element.label.as_str());
        let mut unknown = Vec::new();
        if let Some(row) = &element.translation {
            match row.motion.first() {
                Some((Direction::Fixed(..), _)) => unknown.push(letters.slide(label)),
                Some(_) => unknown.push(letters.displacement(label)),
                None => {}
            }
            match (row.reaction.len(), matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_))) {
                (0, false) => {}
                (1, _) if letters.has_two_components() => {
                    let along = !row.motion.is_empty();
                    unknown.push(letters.projected(letters.force(label), row.reaction[0], element, !along));
                }
                _ => unknown.push(letters.force(label)),
            }
        }
        if let Some(row) = &element.rotation {
            let free = matches!(row.angle, Angle::Free(_));
            unknown.push(if free { letters.angle(label) } else { letters.torque(label) });
        }
        Piece::list(", ", unknown.into_iter().map(Piece::Math))
    }

    /// Two variables for each edge and direction against terminal, cutset and circuit equations.
    fn count_of_equations(&self) -> String {
        let directions = if self.letters.has_two_components() { 2 } else { 1 };
        let (t, r) = (self.translation.edges().len(), self.rotation.edges().len());
        let (t_cut, r_cut) = (directions * self.translation.branches.len(), self.rotation.branches.len());
        let (t_loop, r_loop) = (directions * self.translation.chords.len(), self.rotation.chords.len());
        let (unknowns, own) = (2 * directions * t + 2 * r, directions * t + r);
        let all = own + t_cut + r_cut + t_loop + r_loop;
        let verdict = if all == unknowns { "as many" } else { "NOT as many" };
        format!(
            "Check: two variables for each edge and direction are 2*{directions}*{t} + 2*{r} = {unknowns} unknowns; {own} terminal, {t_cut} + \
             {r_cut} cutset and {t_loop} + {r_loop} circuit equations are {all}, {verdict}. The four steps bring them to {}.",
            self.equations.coordinates.len() + self.equations.loops().count()
        )
    }
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
            let beside = Tree::Name(Name::edge("h", &element.label, true));
            let slide = Tree::product(vec![letters.slide(&element.label), axis_name.clone()]);
            rows.push((own, Side::Tree(Tree::Sum(vec![(false, slide), (false, beside.clone())]))));
            rows.push((axis_name, turned(equations, letters, of, axis)));
            rows.push((beside, turned(equations, letters, *body, *at)));
        }
        (Known::Fixed(body, at), ..) => rows.push((own, turned(equations, letters, *body, *at))),
        (Known::Given([x, y]), ..) => rows.push((own, components(letters, [x.value, y.value]))),
        (Known::Along(of, axis, signal), ..) => {
            let axis_name = Tree::Name(Name::edge("u", &element.label, true));
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
            let mass = value_name(equations, *body, "mass");
            rows.push((own, Side::Tree(inertia_force(equations, letters, element, *body, mass))));
        }
        Force::Resistance(law) => {
            if let Some((along, _)) = row.motion.first() {
                let speed = letters.rate_of_slide(&element.label);
                let side = resisting(equations, element, *law, speed, Quantity::V);
                rows.push((letters.projected(own, *along, element, true), side));
            }
        }
        Force::World(vector) => {
            let vector = vector.each_ref().map(|component| law::tree(equations, letters, component));
            rows.push((own, Side::Tree(pair(letters, vector))));
        }
        Force::InBody(body, vector) => {
            let vector = vector.each_ref().map(|component| law::tree(equations, letters, component));
            let turn = Tree::Call("R", vec![angle_of(equations, letters, *body)]);
            rows.push((own, Side::Tree(Tree::product(vec![turn, pair(letters, vector)]))));
        }
        Force::Line(law) => {
            let law = law::tree(equations, letters, law);
            let side = match letters.has_two_components() {
                true => law::times(law, unit(letters, &element.label)),
                false => law,
            };
            rows.push((own, Side::Tree(side)));
        }
    }
}

/// -m (a - g); a body that opts out of gravity has no g.
fn inertia_force(equations: &mut Equations, letters: Letters, element: &Element, body: BodyId, mass: Tree) -> Tree {
    let mechanism = &*equations.system.mechanism.clone();
    let gravity = mechanism.gravity.each_ref().map(|component| equations.system.value(component));
    let weightless = mechanism.bodies[body.0].weightless || gravity == [Expr::ZERO; 2];
    let acceleration = letters.acceleration(&element.label);
    match weightless {
        _ if mass == Tree::zero() => mass,
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
            let inertia = value_name(equations, *body, "inertia");
            let alpha = letters.alpha(&element.label);
            let mut terms = vec![(true, Tree::product(vec![inertia.clone(), alpha]))];
            terms.retain(|_| inertia != Tree::zero());
            let moments = carried(equations, id, *body).into_iter().map(|other| {
                let moment = [letters.displacement(&other), letters.force(&other)];
                (false, Tree::Relation("x", Box::new(moment)))
            });
            let moments: Vec<(bool, Tree)> = moments.collect();
            if !moments.is_empty() {
                terms.push((true, letters.out_of_plane(Tree::Sum(moments))));
            }
            rows.push((own, Side::Tree(Tree::sum(terms))));
        }
        Torque::Resistance(law) => {
            let omega = letters.omega(&element.label);
            let side = resisting(equations, &element, *law, omega, Quantity::Omega);
            rows.push((own, side));
        }
        Torque::Law(law) => {
            let law = law::tree(equations, letters, law);
            rows.push((own, Side::Tree(law)));
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

/// v = omega k x r, a = alpha k x r - omega^2 r
fn turning() -> Vec<(Tree, Tree)> {
    let [k, r, v, a] = ["k", "r", "v", "a"].map(|letter| Tree::Name(Name::bold(letter, "")));
    let [omega, alpha] = ["omega", "alpha"].map(|letter| Tree::Name(Name::word(letter)));
    let across = |rate: &Tree| Tree::Relation("x", Box::new([Tree::product(vec![rate.clone(), k.clone()]), r.clone()]));
    let square = Tree::product(vec![Tree::power(omega.clone(), Tree::Number(2.0)), r.clone()]);
    vec![(v, across(&omega)), (a, Tree::Sum(vec![(false, across(&alpha)), (true, square)]))]
}

/// R(theta) (x, y); the ground does not turn, nor does anything on a line.
fn turned(equations: &Equations, letters: Letters, body: Option<BodyId>, at: [Expr; 2]) -> Side {
    match body {
        Some(body) if letters.has_two_components() => {
            Side::Turned(Tree::Call("R", vec![angle_of(equations, letters, body)]), at)
        }
        _ => components(letters, at),
    }
}

fn pair(letters: Letters, [x, y]: [Tree; 2]) -> Tree {
    if letters.has_two_components() { Tree::Call("", vec![x, y]) } else { x }
}

fn components(letters: Letters, vector: [Expr; 2]) -> Side {
    if letters.has_two_components() { Side::Components(vector) } else { Side::formula(vector[0]) }
}

/// The symbol of a body's mass or inertia.
fn value_name(equations: &mut Equations, body: BodyId, word: &str) -> Tree {
    let own = &equations.system.mechanism.clone().bodies[body.0];
    let formula = if word == "mass" { &own.mass } else { &own.inertia };
    match formula {
        Some(formula) => {
            let value = equations.system.value(formula);
            plain(equations, &[value]).pop().unwrap_or_else(Tree::zero)
        }
        // A body that does not turn needs no inertia: its symbol stands, and goes with its angular acceleration.
        None => {
            let letter = if word == "mass" { "m" } else { "I" };
            let number = equations.system.find(Origin::Body(body)).map(|id| number(&equations.system, id));
            Tree::Name(Name::symbol(&format!("{letter}_{}", number.unwrap_or_default())))
        }
    }
}

/// theta of the edge of a body.
fn angle_of(equations: &Equations, letters: Letters, body: BodyId) -> Tree {
    let id = equations.system.find(Origin::Body(body));
    letters.angle(id.map_or("", |id| equations.system.element(id).label.as_str()))
}

/// Replaces expressions by formulas; abbreviations follow.
fn resolve(equations: &mut Equations, rows: Rows) -> Vec<(Tree, Tree)> {
    let roots: Vec<Expr> = rows.iter().flat_map(|(_, side)| side.formulas()).collect();
    let mut found = plain(equations, &roots).into_iter();
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
