//! What each variable depends on while the mechanism moves: the states, inputs and parameters, and time, that change it at once.
//!
//! It follows from the structure of the expressions, so that no entry is ever missing; one whose effect cancels stays (FMI 2.0, section 2.2.8,
//! asks for no more). Where drivers determine the motion, what is solved for comes in stages: the unknowns of one depend on everything in its equations.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use cotree_fmu::program::Source;

use super::dependency_sets::dependency_sets;
use super::lowered::inverse;
use super::table::TableRow;
use super::variable::Variability;
use crate::equations::{Constraint, Equations, MotionLayout};
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::solve::Block;

/// Longer lists of dependencies are left out of the description, or they would grow with the square of the model.
pub(crate) const LISTED: usize = 500;

/// With more coordinates than this every coordinate of a driven mechanism counts as depending on everything that drives it.
const MOST_DRIVEN: usize = 1000;

const ORDERS: [Order; 3] = [Order::Position, Order::Velocity, Order::Acceleration];

type Places = Arc<[usize]>;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Moving<'a> {
    /// Accelerations, then reactions, as expressions; none if the drivers determine the motion.
    pub solved: &'a [Expr],
    /// The blocks of the loop equations if the drivers determine the motion, in the order of their solution.
    pub blocks: &'a [Block],
}

/// Finds the dependencies of all variables in motion. Dynamic motion: through the accelerations and reactions to what is in their expressions.
/// Driven motion: through the blocks of the loop equations to the inputs in them.
pub(crate) fn in_motion(rows: &mut [TableRow], equations: &mut Equations, moving: &Moving) {
    let (driven, layout) = (moving.solved.is_empty(), equations.motion_layout());
    // Discrete variables are no knowns of the standard: they change at events only.
    let open = rows.iter().enumerate().filter(|(_, row)| row.variable.variability != Variability::Discrete);
    let given = open.filter_map(|(place, row)| Some((place, known(row.source, driven, layout)?)));
    // Time is beyond all places.
    let given: Vec<_> = given.chain([(rows.len(), vec![Symbol::Time])]).collect();
    let mut sources = Sources::new(equations, &given);
    // FMI 2.0 does not list parameters and time: they are not to make its lists too long.
    sources.most += 1 + rows.iter().filter(|row| matches!(row.source, Source::Parameter(_))).count();
    let values: Vec<Expr> = rows.iter().map(|row| row.value).collect();
    if driven {
        let symbols = equations.system.arena.symbols(values.iter().copied());
        let reacts = symbols.iter().any(|symbol| matches!(symbol, Symbol::Reaction(_)));
        let reactions = reacts.then(|| (reaction_equations(equations), laws_of_the_motion(equations)));
        driven_stages(equations, moving.blocks, reactions).iter().for_each(|stage| sources.add_stage(stage));
    } else {
        sources.add_solved(equations, moving.solved);
    }
    let found = sources.of(&equations.system.arena, &values);
    let computed =
        |row: &TableRow| !matches!(row.source, Source::Parameter(_) | Source::Input(_) | Source::Discrete(_));
    let mut changing = Changing::new(rows);
    for (row, places) in rows.iter_mut().zip(found).filter(|(row, _)| computed(row)) {
        row.variable.dependencies = changing.among(&places);
        row.variable.all_dependencies = places;
    }
}

/// The states and inputs among what variables depend on: found once for a list, because many variables share a long one.
struct Changing {
    /// Of each variable: true if it is no parameter.
    changes: Vec<bool>,
    known: HashMap<*const usize, Places>,
}

impl Changing {
    fn new(rows: &[TableRow]) -> Self {
        let changes = rows.iter().map(|row| !matches!(row.source, Source::Parameter(_))).collect();
        Self { changes, known: HashMap::new() }
    }

    fn among(&mut self, places: &Places) -> Places {
        let Self { changes, known } = self;
        let changes = |place: &usize| changes.get(*place).is_some_and(|&changes| changes);
        let found = known.entry(places.as_ptr()).or_insert_with(|| match places.iter().all(changes) {
            true => places.clone(),
            false => places.iter().copied().filter(changes).collect(),
        });
        found.clone()
    }
}

/// The symbols of a parameter, input or state; a driven mechanism has no states but those of its drivers.
fn known(source: Source, driven: bool, layout: MotionLayout) -> Option<Vec<Symbol>> {
    match source {
        Source::Parameter(index) => Some(vec![Symbol::Parameter(index as usize)]),
        // The derivatives of an input are set together with it.
        Source::Input(index) => Some(ORDERS.map(|order| Symbol::Input(index as usize, order)).to_vec()),
        Source::Coordinate(index) if !driven => Some(vec![Symbol::Coordinate(index as usize, Order::Position)]),
        Source::Rate(index) if !driven => Some(vec![layout.variable(index as usize).symbol(Order::Velocity)]),
        _ => None,
    }
}

/// Unknowns, and what is in the equations that they are found from once the stages before are known.
struct SolutionStage {
    unknowns: Vec<Symbol>,
    terms: BTreeSet<Symbol>,
}

/// The loop equations give positions, their derivatives rates and accelerations, each block from those before it; the reactions follow
/// from the last block to the first, or all together where laws read them.
fn driven_stages(
    equations: &Equations,
    blocks: &[Block],
    reactions: Option<(Vec<Vec<Symbol>>, Vec<Symbol>)>,
) -> Vec<SolutionStage> {
    let whole = [Block {
        rows: (0..equations.constraints.len() as u32).collect(),
        columns: (0..equations.coordinates.len() as u32).collect(),
    }];
    let blocks = if equations.coordinates.len() > MOST_DRIVEN { &whole } else { blocks };
    let motion = ORDERS.into_iter().flat_map(|order| blocks.iter().map(move |block| (order, block)));
    let motion = motion.map(|(order, block)| {
        let unknowns = block.columns.iter().map(|&column| Symbol::Coordinate(column as usize, order)).collect();
        let rows = block.rows.iter().map(|&row| &equations.constraints[row as usize]);
        SolutionStage { unknowns, terms: rows.flat_map(|row| terms(&equations.system.arena, row, order)).collect() }
    });
    if let Some((columns, laws)) = reactions.as_ref().filter(|(_, laws)| !laws.is_empty()) {
        let unknowns = (0..equations.constraints.len()).map(Symbol::Reaction).collect();
        let terms = columns.iter().flatten().chain(laws).copied().collect();
        return motion.chain([SolutionStage { unknowns, terms }]).collect();
    }
    let efforts = reactions.iter().flat_map(|(columns, _)| {
        blocks.iter().rev().map(move |block| {
            let unknowns = block.rows.iter().map(|&row| Symbol::Reaction(row as usize)).collect();
            let terms = block.columns.iter().flat_map(|&column| columns[column as usize].iter().copied()).collect();
            SolutionStage { unknowns, terms }
        })
    });
    motion.chain(efforts).collect()
}

fn terms(arena: &Arena, row: &Constraint, order: Order) -> Vec<Symbol> {
    let coefficients = row.jacobian.iter().map(|&(_, entry)| entry).filter(|_| order != Order::Position);
    let rest = match order {
        Order::Position => row.value,
        Order::Velocity => row.time_rate,
        Order::Acceleration => row.gamma,
    };
    let unknowns = row.jacobian.iter().map(|&(column, _)| Symbol::Coordinate(column, order));
    let followers = row.followers.iter().map(|&(index, _)| Symbol::Follower(index, order));
    arena.symbols(coefficients.chain([rest])).into_iter().chain(unknowns).chain(followers).collect()
}

/// Phi_q^T lambda = Q - M a, an equation for each coordinate.
fn reaction_equations(equations: &mut Equations) -> Vec<Vec<Symbol>> {
    let places = 0..equations.coordinates.len();
    let accelerations: Vec<Expr> =
        places.map(|index| equations.system.arena.symbol(Symbol::Coordinate(index, Order::Acceleration))).collect();
    let residuals = inverse(equations, &accelerations);
    let arena = &equations.system.arena;
    let mut columns: Vec<Vec<Symbol>> = residuals.into_iter().map(|residual| arena.symbols([residual])).collect();
    for (row, constraint) in equations.constraints.iter().enumerate() {
        for &(column, entry) in &constraint.jacobian {
            columns[column].push(Symbol::Reaction(row));
            columns[column].extend(arena.symbols([entry]));
        }
    }
    columns
}

/// What is in the laws of loads that read accelerations or reactions.
fn laws_of_the_motion(equations: &mut Equations) -> Vec<Symbol> {
    let laws: Vec<Expr> = equations.feedback().into_iter().map(|load| load.value).collect();
    equations.system.arena.symbols(laws)
}

struct Sources {
    places: HashMap<Symbol, Places>,
    everything: Places,
    /// Longer lists are everything.
    most: usize,
}

impl Sources {
    /// What is given stands for itself, and what a driver takes from an input for that; what it integrates does not change with the input at once.
    fn new(equations: &Equations, given: &[(usize, Vec<Symbol>)]) -> Self {
        let mut places: HashMap<Symbol, Places> = HashMap::new();
        for (place, symbols) in given {
            places.extend(symbols.iter().map(|&symbol| (symbol, Arc::from([*place]))));
        }
        for (index, &(_, input, order)) in equations.system.followers.iter().enumerate() {
            let Some(followed) = places.get(&Symbol::Input(input.0, Order::Position)).cloned() else { continue };
            let taken = ORDERS.into_iter().filter(|taken| *taken >= order).map(|order| Symbol::Follower(index, order));
            places.extend(taken.map(|symbol| (symbol, followed.clone())));
        }
        Sources { places, everything: given.iter().map(|(place, _)| *place).collect(), most: LISTED }
    }

    fn add_stage(&mut self, stage: &SolutionStage) {
        let behind = self.behind(&stage.terms);
        self.places.extend(stage.unknowns.iter().map(|&unknown| (unknown, behind.clone())));
    }

    /// Accelerations, then reactions, from their expressions.
    fn add_solved(&mut self, equations: &Equations, solved: &[Expr]) {
        let found = self.of(&equations.system.arena, solved);
        let layout = equations.motion_layout();
        self.places.extend(found.into_iter().enumerate().map(|(index, places)| {
            let reaction = index.checked_sub(layout.count()).map(Symbol::Reaction);
            (reaction.unwrap_or_else(|| layout.variable(index).symbol(Order::Acceleration)), places)
        }));
    }

    /// What each of these expressions depends on; everything if that is much.
    fn of(&self, arena: &Arena, values: &[Expr]) -> Vec<Places> {
        dependency_sets(arena, values, |symbol| self.places.get(&symbol).cloned(), (self.everything.clone(), self.most))
    }

    fn behind(&self, known: &BTreeSet<Symbol>) -> Places {
        // Many symbols share one long list.
        let lists: HashMap<*const usize, &Places> =
            known.iter().filter_map(|known| self.places.get(known)).map(|list| (list.as_ptr(), list)).collect();
        let all: BTreeSet<usize> = lists.values().flat_map(|list| list.iter().copied()).collect();
        if all.len() > self.most { self.everything.clone() } else { all.into_iter().collect() }
    }
}
