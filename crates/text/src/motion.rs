//! The equations of motion for readers: the quantities, and a formula for each.

use std::collections::{HashMap, HashSet};

use cotree::equations::{Constraint, Equations, RowKind, Share};
use cotree::expr::{Arena, Expr, ExprNode, Order, Symbol, Unary};
use cotree::model::{BodyId, CoordinateChoice, Dimension, JointId, Owner, Part, Place, Quantity, Variable};
use cotree::network::{Constrained, Direction, Force, Origin, Torque};

use super::document::{DocumentBlock, Piece};
use super::feedback::feedback;
use super::matrices::Matrices;
use super::modes::{self, Modes};
use super::name::{Name, symbol_name};
use super::read::ReadingContext;
use super::signals::signals;
use super::tree::{FormulaTree, Formulas, formulas};

/// A quantity: its name and its expression.
pub type Entry = (Name, Expr);

/// The equations, quantity by quantity. Zeros of matrices are left out.
#[derive(Clone, Debug)]
pub struct MotionEquations {
    pub groups: Vec<(&'static str, Vec<Entry>)>,
    pub dynamic: bool,
    /// {Q} as a sum of columns that are among the groups.
    pub sums: Vec<(Name, FormulaTree)>,
}

impl MotionEquations {
    /// Collects M and Q (of a model with masses), Phi, Phi_q, Phi_t, gamma, and the displacements and efforts that follow from the
    /// motion.
    pub fn new(equations: &mut Equations) -> Self {
        let dynamic = has_masses(equations);
        let mut groups = Vec::new();
        if dynamic {
            groups.extend(dynamics(equations));
            groups.extend(vibration(equations));
            groups.push(modes::sliding(equations));
            groups.extend(feedback(equations));
        }
        groups.push(("Rates of the states", rates_of_states(equations)));
        groups.extend(loops(equations));
        groups.extend(modes::indicators(equations));
        groups.push(("Slides that are no coordinates", slides(equations)));
        if dynamic {
            groups.push(("Reactions of the joints, on their second side", held(equations)));
            groups.push(("Efforts of the drivers", efforts(equations)));
        }
        groups.retain(|(_, entries)| !entries.is_empty());
        let sums = if dynamic && equations.symbolic { in_parts(equations, &mut groups) } else { Vec::new() };
        MotionEquations { groups, dynamic, sums }
    }

    pub fn formulas(&self, equations: &mut Equations) -> Formulas {
        let context = context(equations);
        formulas(equations, &self.expressions(), &context)
    }

    fn expressions(&self) -> Vec<Expr> {
        self.groups.iter().flat_map(|(_, entries)| entries.iter().map(|(_, expr)| *expr)).collect()
    }

    pub fn blocks(&self, equations: &mut Equations) -> Vec<DocumentBlock> {
        let formulas = self.formulas(equations);
        let mut blocks = Vec::new();
        if equations.coordinates.is_empty() {
            let text =
                "The drivers and joints determine the motion: there are no coordinates and no equations of motion.";
            blocks.push(DocumentBlock::Text(vec![Piece::words(text)]));
        } else {
            blocks.push(DocumentBlock::Equations(self.form(equations)));
            blocks.push(DocumentBlock::Heading("Coordinates".into()));
            blocks.push(DocumentBlock::table(Vec::new(), coordinates(equations)));
        }
        let lines = formulas.definitions.len() + formulas.formulas.len();
        if lines > READABLE {
            blocks.push(DocumentBlock::Text(vec![Piece::words(length_note(equations, lines))]));
        }
        if has_loops(equations) {
            blocks.push(DocumentBlock::Heading("Reactions".into()));
            blocks.push(DocumentBlock::table(Vec::new(), reactions(equations)));
        }
        if let Some(modes) = Modes::new(equations) {
            blocks.push(DocumentBlock::Heading("Modes".into()));
            blocks.extend(modes.blocks());
        }
        blocks.extend(self.written(equations, formulas));
        if let Some(Err(why)) = equations.linear() {
            let text = format!("There are no matrices D and K (24): {why}.");
            blocks.push(DocumentBlock::Text(vec![Piece::words(text)]));
        }
        blocks.extend(Matrices::new(equations).into_iter().flat_map(|matrices| matrices.blocks()));
        blocks
    }

    /// Inputs, abbreviations, and the formulas of all groups.
    pub fn formula_blocks(&self, equations: &mut Equations) -> Vec<DocumentBlock> {
        let formulas = self.formulas(equations);
        self.written(equations, formulas)
    }

    fn written(&self, equations: &Equations, formulas: Formulas) -> Vec<DocumentBlock> {
        let Formulas { angles, definitions, formulas } = formulas;
        let mut blocks = Vec::new();
        let signals = signals(equations, &self.expressions());
        if !signals.is_empty() {
            let held =
                if equations.system.mechanism.has_instants() { ", discrete variables (zero-order hold)" } else { "" };
            let heading = if equations.states.is_empty() { "Inputs" } else { "Inputs and states" };
            let heading = format!("{heading}{held}");
            blocks.push(DocumentBlock::Heading(heading));
            blocks.push(DocumentBlock::table(Vec::new(), signals));
        }
        if !angles.is_empty() || !definitions.is_empty() {
            blocks.push(DocumentBlock::Heading("Abbreviations".into()));
            blocks.push(DocumentBlock::Equations(angles.into_iter().chain(definitions).collect()));
        }
        let (mut formulas, mut sums) = (formulas.into_iter(), self.sums.clone());
        for (title, entries) in &self.groups {
            blocks.push(DocumentBlock::Heading((*title).into()));
            if entries.iter().any(|(name, _)| self.sums.iter().any(|(_, sum)| sum.names(name))) && !sums.is_empty() {
                let rows = std::mem::take(&mut sums);
                blocks.push(DocumentBlock::Equations(
                    rows.into_iter().map(|(name, sum)| (FormulaTree::Name(name), sum)).collect(),
                ));
            }
            let names = entries.iter().map(|(name, _)| FormulaTree::Name(name.clone()));
            blocks.push(DocumentBlock::Equations(names.zip(formulas.by_ref()).collect()));
        }
        blocks
    }

    /// The equations as matrices (Eqs 19-22).
    fn form(&self, equations: &Equations) -> Vec<(FormulaTree, FormulaTree)> {
        let mut rows = governing(equations, self.dynamic);
        if has_loops(equations) {
            let jacobian = |rates: &str| product(matrix("Phi", "q"), column(rates, ""));
            rows.push((jacobian("v"), FormulaTree::Sum(vec![(true, column("Phi", "t"))])));
            rows.push((jacobian("a"), column("gamma", "")));
        }
        rows
    }
}

/// z' = g of each state of the scene.
fn rates_of_states(equations: &Equations) -> Vec<Entry> {
    let rates = equations.states.iter().enumerate();
    rates.map(|(index, &rate)| (symbol_name(equations, Symbol::State(index, Order::Velocity)), rate)).collect()
}

fn column(base: &str, subscript: &str) -> FormulaTree {
    FormulaTree::Name(Name::column(base, subscript))
}

fn matrix(base: &str, subscript: &str) -> FormulaTree {
    FormulaTree::Name(Name::matrix(base, subscript))
}

fn product(a: FormulaTree, b: FormulaTree) -> FormulaTree {
    FormulaTree::product(vec![a, b])
}

/// M a + Phi_q^T lambda = Q (22) of a model with masses, with the friction that slides, and Phi = 0.
pub fn governing(equations: &Equations, dynamic: bool) -> Vec<(FormulaTree, FormulaTree)> {
    let mut terms = vec![(false, product(matrix("M", ""), column("a", "")))];
    let transposed = FormulaTree::power(matrix("Phi", "q"), FormulaTree::Name(Name::letter("T", "")));
    let loops = has_loops(equations).then(|| (column("Phi", ""), FormulaTree::zero()));
    terms.extend(loops.as_ref().map(|_| (false, product(transposed, column("lambda", "")))));
    let mut loads = vec![(false, column("Q", ""))];
    loads.extend(equations.rubs_dry().then(|| (false, column("Q", "friction"))));
    let reads = equations.constraints.iter().any(|row| matches!(row.kind, RowKind::LoadValue));
    loads.extend(reads.then(|| (false, column("Q", "feedback"))));
    dynamic.then(|| (FormulaTree::sum(terms), FormulaTree::sum(loads))).into_iter().chain(loops).collect()
}

/// More formulas than this need a word about their number.
const READABLE: usize = 1000;

/// A note on the length of the page and on shorter formulations.
fn length_note(equations: &Equations, lines: usize) -> String {
    let hint = match equations.system.mechanism.coordinates {
        CoordinateChoice::Recommended => "",
        _ => {
            " Other coordinates give other equations of the same motion: try `preset = \"recommended\"` in `[coordinates]`. With \
              joint angles, each relative to the body before, the terms grow with the fourth power of the depth; with absolute angles of \
              bodies they grow with its square."
        }
    };
    format!("These are {lines} formulas.{hint}")
}

/// Are all masses and inertias that the equations need given?
pub fn has_masses(equations: &mut Equations) -> bool {
    let dynamics = equations.dynamics();
    let mut roots: Vec<Expr> = dynamics.load.clone();
    roots.extend(dynamics.mass.iter().flatten().map(|(_, entry)| *entry));
    !equations.system.arena.symbols(roots).into_iter().any(|symbol| matches!(symbol, Symbol::Missing(..)))
}

const LOADS: &str = "Loads";

pub fn dynamics(equations: &mut Equations) -> [(&'static str, Vec<Entry>); 2] {
    let dynamics = equations.dynamics();
    let mass = dynamics.mass.iter().enumerate().flat_map(|(row, entries)| {
        let upper = entries.iter().filter(move |(column, _)| *column >= row);
        upper.map(move |(column, entry)| (Name::entry("M", &[row, *column]), *entry))
    });
    let load = dynamics.load.iter().enumerate().map(|(row, entry)| (Name::entry("Q", &[row]), *entry));
    [("Mass matrix (symmetric; zeros left out)", mass.collect()), (LOADS, load.collect())]
}

/// \[D\], \[K\] and {F} of masses on a line (33).
pub fn vibration(equations: &mut Equations) -> Vec<(&'static str, Vec<Entry>)> {
    let Some(vibration) = equations.vibration() else { return Vec::new() };
    let upper = |symbol: &str, matrix: &[Vec<Expr>]| -> Vec<Entry> {
        let rows = matrix.iter().enumerate();
        let entries =
            rows.flat_map(|(row, entries)| (row..entries.len()).map(move |column| (row, column, entries[column])));
        let some = entries.filter(|(.., entry)| *entry != Expr::ZERO);
        some.map(|(row, column, entry)| (Name::entry(symbol, &[row, column]), entry)).collect()
    };
    let force = vibration.force.iter().enumerate().map(|(row, &entry)| (Name::entry("F", &[row]), entry));
    vec![
        ("Damping matrix (symmetric; zeros left out)", upper("D", &vibration.damping)),
        ("Stiffness matrix (symmetric; zeros left out)", upper("K", &vibration.stiffness)),
        ("Forces: {Q} = {F} - [D]{v} - [K]{q}", force.collect()),
    ]
}

/// Puts the parts of {Q} in the place of {Q}, and says what their sums are.
fn in_parts(equations: &mut Equations, groups: &mut Vec<(&'static str, Vec<Entry>)>) -> Vec<(Name, FormulaTree)> {
    let Some(place) = groups.iter().position(|(title, _)| *title == LOADS) else { return Vec::new() };
    let (_, whole) = groups.remove(place);
    let shares = equations.load_shares();
    let mut sums = Vec::new();
    for (row, (name, _)) in whole.into_iter().enumerate() {
        let acting = shares.iter().filter(|(_, load)| load[row] != Expr::ZERO);
        sums.push((
            name,
            FormulaTree::sum(acting.map(|(share, _)| (false, FormulaTree::Name(part_of_load(*share, row)))).collect()),
        ));
    }
    let part = |(share, load): &(Share, Vec<Expr>)| {
        let rows = load.iter().enumerate().filter(|(_, entry)| **entry != Expr::ZERO);
        let [_, title, _] = called(*share);
        (title, rows.map(|(row, entry)| (part_of_load(*share, row), *entry)).collect())
    };
    let parts: Vec<_> = shares.iter().map(part).collect();
    groups.splice(place..place, parts);
    sums
}

fn part_of_load(share: Share, row: usize) -> Name {
    let [word, ..] = called(share);
    Name { plain: format!("Q_{word}[{}]", row + 1), ..Name::letter("Q", &format!("{}, {word}", row + 1)) }
}

/// A part of {Q} as a subscript, as a title, and within a sentence.
pub fn called(share: Share) -> [&'static str; 3] {
    match share {
        Share::Applied => ["applied", "Applied loads", "applied forces and torques"],
        Share::Gravity => ["gravity", "Gravity", "gravity"],
        Share::Velocity => [
            "velocity",
            "Velocity-dependent loads: centrifugal and Coriolis forces",
            "velocities (centrifugal and Coriolis terms)",
        ],
        Share::Elastic => ["elastic", "Springs and their dampers", "springs and their dampers"],
        Share::Resistance | Share::Element(_) => {
            ["resistance", "Damping and friction in joints", "damping and friction in joints"]
        }
    }
}

fn has_loops(equations: &Equations) -> bool {
    equations.loops().next().is_some()
}

pub fn loops(equations: &Equations) -> [(&'static str, Vec<Entry>); 4] {
    let rows = |of: fn(&Constraint) -> Expr, symbol: &str| -> Vec<Entry> {
        let rows = equations.loops().enumerate();
        rows.map(|(row, (_, constraint))| (Name::entry(symbol, &[row]), of(constraint))).collect()
    };
    let jacobian = equations.loops().enumerate().flat_map(|(row, (_, constraint))| {
        constraint.jacobian.iter().map(move |(column, entry)| (Name::entry("Phi_q", &[row, *column]), *entry))
    });
    let mut rates = rows(|constraint| constraint.time_rate, "Phi_t");
    rates.retain(|(_, expr)| *expr != Expr::ZERO);
    [
        ("Loop equations", rows(|constraint| constraint.value, "Phi")),
        ("Jacobian of the loop equations (zeros left out)", jacobian.collect()),
        ("Partial derivatives by time (zeros left out)", rates),
        ("Right-hand sides for accelerations", rows(|constraint| constraint.gamma, "gamma")),
    ]
}

/// The displacements of joints that slide and are in the cotree (Eqs 41, 42).
pub fn slides(equations: &mut Equations) -> Vec<Entry> {
    let chords = equations.trees.translation.chords.clone();
    let slides = chords.into_iter().filter_map(|chord| {
        let element = equations.system.element(chord);
        let slides = element.translation.as_ref().is_some_and(|row| !row.motion.is_empty());
        match element.origin {
            Origin::Joint(joint) if slides => Some(joint),
            _ => None,
        }
    });
    let slides: Vec<JointId> = slides.collect();
    let slide = |joint| Variable { owner: Owner::Joint(joint), quantity: Quantity::S };
    entries(equations, slides.into_iter().map(slide))
}

/// The efforts of the drivers, in terms of accelerations and reactions.
pub fn efforts(equations: &mut Equations) -> Vec<Entry> {
    let mechanism = &equations.system.mechanism;
    entries(equations, mechanism.driver_efforts().into_iter())
}

/// The reactions of the joints, in terms of accelerations and multipliers.
pub fn held(equations: &mut Equations) -> Vec<Entry> {
    let mechanism = &equations.system.mechanism;
    entries(equations, mechanism.joint_reactions().into_iter())
}

fn entries(equations: &mut Equations, variables: impl Iterator<Item = Variable>) -> Vec<Entry> {
    let entry = |variable| {
        let name = Name::variable(&equations.system.mechanism.variable_name(variable));
        (name, equations.variable(variable))
    };
    variables.map(entry).collect()
}

pub fn context(equations: &mut Equations) -> ReadingContext {
    ReadingContext { variables: variables(equations), weights: weights(equations) }
}

/// Angles, rates and lengths that are no symbols themselves but have a name.
fn variables(equations: &mut Equations) -> HashMap<Expr, String> {
    let mechanism = &*equations.system.mechanism.clone();
    if mechanism.dimension == Dimension::One {
        return HashMap::new(); // sums of coordinates: the shorter the fewer names
    }
    let turning = [Quantity::Angle, Quantity::Omega];
    let bodies = (0..mechanism.bodies.len()).map(|body| (Owner::Place(Place::Centre(BodyId(body))), turning));
    let joints = mechanism.joints.iter().filter(|joint| joint.component().reactions == [Quantity::Fx, Quantity::Fy]);
    let joints = joints.map(|joint| (joint.owner, turning));
    let stretching = [Quantity::Length, Quantity::Rate];
    let stretches = |load: &&Part| stretching.iter().all(|variable| load.component().variables.contains(variable));
    let lines = mechanism.loads.iter().filter(stretches).map(|load| (load.owner, stretching));
    let mut names = if equations.symbolic { laws(equations) } else { HashMap::new() };
    for (owner, quantities) in bodies.chain(joints).chain(lines).collect::<Vec<_>>() {
        for quantity in quantities {
            let variable = Variable { owner, quantity };
            let expr = equations.variable(variable);
            if deserves_name(&equations.system.arena, expr) {
                names.entry(expr).or_insert_with(|| mechanism.variable_name(variable));
            }
        }
    }
    names
}

/// The laws of loads that are more than a symbol, by the names of their forces and torques.
fn laws(equations: &mut Equations) -> HashMap<Expr, String> {
    let mut laws = Vec::new();
    for element in equations.system.elements.iter().filter(|element| matches!(element.origin, Origin::Load(_))) {
        let name = || element.name.clone();
        match element.translation.as_ref().map(|row| row.through.clone()) {
            Some(Force::Line(law) | Force::Tangent(law, _)) => laws.push((law, name(), Quantity::Force)),
            // Components in the axes of a body have no name: `fx` and `fy` are those in the axes of the world.
            Some(Force::World([x, y])) => laws.extend([(x, name(), Quantity::Fx), (y, name(), Quantity::Fy)]),
            Some(Force::None | Force::Inertia(_) | Force::Resistance(_) | Force::InBody(..)) | None => {}
        }
        if let Some(Torque::Law(law)) = element.rotation.as_ref().map(|row| row.through.clone()) {
            laws.push((law, name(), Quantity::Torque));
        }
    }
    let laws: Vec<(Expr, String, Quantity)> =
        laws.into_iter().map(|(law, owner, quantity)| (equations.formula(&law), owner, quantity)).collect();
    // A force that pulls is written without its sign.
    let arena = &equations.system.arena;
    let unsigned = laws.into_iter().filter_map(|(law, owner, quantity)| match (arena.node(law), quantity) {
        (ExprNode::Unary(Unary::Negate, inner), Quantity::Force) => Some((inner, format!("{owner}.pull"))),
        (ExprNode::Unary(Unary::Negate, inner), Quantity::Torque) => Some((inner, format!("{owner}.resistance"))),
        (ExprNode::Unary(Unary::Negate, _), _) => None,
        _ => Some((law, quantity.of(&owner))),
    });
    unsigned.filter(|(law, _)| deserves_name(arena, *law)).collect()
}

/// Parameters with mass in their unit (masses, inertias, forces, stiffnesses), and masses that are not given.
fn weights(equations: &Equations) -> HashSet<Symbol> {
    let parameters = &equations.system.mechanism.parameters;
    let is_weight = |symbol: &Symbol| match symbol {
        // Initial values that can be set are parameters of the program, not of the scene.
        Symbol::Parameter(index) => {
            parameters.get(*index).is_some_and(|parameter| parameter.unit.exponents.kilogram != 0)
        }
        Symbol::Missing(..) => true,
        Symbol::Time | Symbol::Discrete(_) | Symbol::Input(..) | Symbol::Follower(..) | Symbol::State(..) => false,
        Symbol::Coordinate(..) | Symbol::Reaction(_) | Symbol::Argument => false,
    };
    let all = equations.system.arena.all().filter_map(|expr| match equations.system.arena.node(expr) {
        ExprNode::Symbol(symbol) => Some(symbol),
        _ => None,
    });
    all.filter(is_weight).collect()
}

/// Is it more than a symbol, and does it change?
fn deserves_name(arena: &Arena, expr: Expr) -> bool {
    let unsigned = if let ExprNode::Unary(Unary::Negate, inner) = arena.node(expr) { inner } else { expr };
    !matches!(arena.node(unsigned), ExprNode::Constant(_) | ExprNode::Symbol(_))
        && arena.symbols([expr]).iter().any(|symbol| !symbol.is_parameter())
}

fn coordinates(equations: &Equations) -> Vec<Vec<Piece>> {
    let row = |(index, coordinate): (usize, &cotree::equations::Coordinate)| {
        let short = Name::entry("q", &[index]);
        let unit = if coordinate.angular { "rad" } else { "m" };
        let pair =
            [&coordinate.name.position, &coordinate.name.rate].map(|name| FormulaTree::Name(Name::variable(name)));
        let [position, rate] = pair.map(Piece::Math);
        let name = Piece::Code(equations.system.element(coordinate.element).name.clone());
        vec![Piece::Math(FormulaTree::Name(short)), position, Piece::words(unit), rate, Piece::words("branch"), name]
    };
    equations.coordinates.iter().enumerate().map(row).collect()
}

fn reactions(equations: &Equations) -> Vec<Vec<Piece>> {
    let row = |(index, constraint): (usize, &Constraint)| {
        let along = match constraint.constrained {
            Constrained::Along(Direction::Fixed(..)) if !constraint.coupled.is_empty() => {
                "N, force along its coupled direction"
            }
            Constrained::Along(Direction::X) => "N, force along x",
            Constrained::Along(Direction::Y) => "N, force along y",
            Constrained::Along(Direction::Fixed(..)) => "N, force along its constrained direction",
            Constrained::Length => "N, force along its line",
            Constrained::Angle => "N.m, torque",
        };
        let name = FormulaTree::Name(super::name::symbol_name(equations, Symbol::Reaction(index)));
        let owner = equations.system.name(constraint.element).to_owned();
        let along =
            if constraint.repeats() { format!("{along}; this loop equation repeats others") } else { along.into() };
        vec![Piece::Math(name), Piece::Code(owner), Piece::words(along)]
    };
    equations.loops().map(row).collect()
}
