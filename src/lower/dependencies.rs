//! What each variable depends on while the mechanism moves: the states and inputs that change it at once.
//!
//! Dynamic motion: through the accelerations and reactions to what is in their expressions, less what cancels there ([`Slopes`]). Driven
//! motion: through the blocks of the loop equations to the inputs in them.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::f64::consts::TAU;
use std::sync::Arc;

use cotree_fmu::program::{Block, Source};
use cotree_fmu::solver::poses::Random;

use super::apart::apart;
use super::footprints::footprints;
use super::motion::typical;
use super::program::{Pose, inverse};
use super::table::Row;
use crate::equations::Equations;
use crate::expr::{Expr, Node, Order, Rounded, Slopes, Symbol};

/// Longer lists of dependencies are left out of the description, or they would grow with the square of the model.
pub(crate) const LISTED: usize = 500;

/// With more coordinates than this every coordinate of a driven mechanism counts as depending on everything that drives it.
const MOST_DRIVEN: usize = 1000;

/// More derivatives than this are not evaluated to see whether they vanish: a few seconds.
const MOST_DERIVATIVES: usize = 300_000_000;

/// At so many states a derivative has to vanish.
const STATES: u64 = 4;

/// Places of variables in the table.
type Places = BTreeSet<usize>;

/// How the mechanism moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving<'a> {
    /// Accelerations and reactions as expressions; none if the drivers determine the motion.
    pub solved: &'a [Expr],
    /// The blocks of the loop equations if the drivers determine the motion, in the order of their solution.
    pub blocks: &'a [Block],
    /// Typical length.
    pub length: f64,
    /// A consistent pose.
    pub pose: &'a Pose,
}

/// Finds the dependencies of all variables.
pub(super) fn find(rows: &mut [Row], equations: &mut Equations, moving: &Moving) {
    let driven = moving.solved.is_empty();
    let inverse = if driven && reacts(rows, equations) { inverse(equations) } else { Vec::new() };
    if !inverse.is_empty() {
        (0..equations.constraints.len()).for_each(|row| _ = equations.system.arena.symbol(Symbol::Reaction(row)));
    }
    let finder = Finder { equations, given: given(rows, driven) };
    let through = if driven { finder.driven(moving.blocks, &inverse) } else { finder.dynamic(moving.solved) };
    for row in rows.iter_mut().filter(|row| !matches!(row.source, Source::Parameter(_) | Source::Input(_))) {
        row.dependencies = finder.of([row.value], &through);
    }
    if !driven {
        finder.leave_out_what_cancels(rows, moving);
    }
}

/// Does any variable contain a reaction?
fn reacts(rows: &[Row], equations: &Equations) -> bool {
    let symbols = equations.system.arena.symbols(rows.iter().map(|row| row.value));
    symbols.iter().any(|symbol| matches!(symbol, Symbol::Reaction(_)))
}

/// The places of inputs and states.
fn given(rows: &[Row], driven: bool) -> HashMap<Symbol, usize> {
    let symbol = |source: Source| match source {
        Source::Input(index) => Some(Symbol::Input(index as usize, Order::Position)),
        Source::Coordinate(index) if !driven => Some(Symbol::Coordinate(index as usize, Order::Position)),
        Source::Rate(index) if !driven => Some(Symbol::Coordinate(index as usize, Order::Velocity)),
        _ => None,
    };
    rows.iter().enumerate().filter_map(|(place, row)| Some((symbol(row.source)?, place))).collect()
}

struct Finder<'a, 'm> {
    equations: &'a Equations<'m>,
    given: HashMap<Symbol, usize>,
}

/// What symbols depend on that are no inputs or states themselves.
type Through = HashMap<Symbol, Arc<[usize]>>;

impl Finder<'_, '_> {
    /// The variable that a symbol belongs to.
    fn place(&self, symbol: Symbol) -> Option<usize> {
        let of_input = |input: usize| self.given.get(&Symbol::Input(input, Order::Position)).copied();
        match symbol {
            // The derivatives of an input are set together with it.
            Symbol::Input(input, _) => of_input(input),
            // What a follower integrates does not change with its input at once.
            Symbol::Follower(index, order) => {
                let (_, input, given) = self.equations.system.followers[index];
                if order < given { None } else { of_input(input.0) }
            }
            other => self.given.get(&other).copied(),
        }
    }

    /// Inputs and states in expressions, and behind what they contain. Many share one long list: it is neither copied nor read twice.
    fn of(&self, values: impl IntoIterator<Item = Expr>, through: &Through) -> Arc<[usize]> {
        let mut places = Places::new();
        let mut behind: HashMap<*const usize, &Arc<[usize]>> = HashMap::new();
        for symbol in self.equations.system.arena.symbols(values) {
            places.extend(self.place(symbol));
            behind.extend(through.get(&symbol).map(|more| (more.as_ptr(), more)));
        }
        let longest = behind.values().max_by_key(|more| more.len());
        let rest = behind.values().filter(|more| longest.is_none_or(|longest| more.as_ptr() != longest.as_ptr()));
        places.extend(rest.flat_map(|more| more.iter().copied()));
        match longest {
            Some(longest) if places.iter().all(|place| longest.binary_search(place).is_ok()) => (*longest).clone(),
            Some(longest) => {
                places.into_iter().chain(longest.iter().copied()).collect::<Places>().into_iter().collect()
            }
            None => places.into_iter().collect(),
        }
    }

    /// Accelerations and reactions follow from the state.
    fn dynamic(&self, solved: &[Expr]) -> Through {
        let mut everything: Vec<usize> = self.given.values().copied().collect();
        everything.sort_unstable();
        let place = |symbol| self.place(symbol).map(|place| Arc::from([place]));
        let found = footprints(&self.equations.system.arena, solved, place, (everything.into(), LISTED));
        found.into_iter().enumerate().map(|(index, places)| (self.solved_symbol(index), places)).collect()
    }

    fn solved_symbol(&self, index: usize) -> Symbol {
        match index.checked_sub(self.equations.coordinates.len()) {
            None => Symbol::Coordinate(index, Order::Acceleration),
            Some(reaction) => Symbol::Reaction(reaction),
        }
    }

    /// The loop equations give positions, their derivatives rates and accelerations, each block from those before it; the reactions follow
    /// from the last block to the first.
    fn driven(&self, blocks: &[Block], inverse: &[Expr]) -> Through {
        let mut through = Through::new();
        let whole = [Block {
            rows: (0..self.equations.constraints.len() as u32).collect(),
            columns: (0..self.equations.coordinates.len() as u32).collect(),
        }];
        let blocks = if self.equations.coordinates.len() > MOST_DRIVEN { &whole } else { blocks };
        for order in [Order::Position, Order::Velocity, Order::Acceleration] {
            for block in blocks {
                let equations: Vec<Expr> = block.rows.iter().flat_map(|&row| self.terms(row as usize, order)).collect();
                let places = self.of(equations, &through);
                let followed = self.follower_places(block, order);
                let places: Arc<[usize]> =
                    places.iter().copied().chain(followed).collect::<Places>().into_iter().collect();
                let columns = block.columns.iter().map(|&column| Symbol::Coordinate(column as usize, order));
                through.extend(columns.map(|column| (column, places.clone())));
            }
        }
        for block in blocks.iter().rev().filter(|_| !inverse.is_empty()) {
            let places = self.reaction_places(block, inverse, &through);
            let reactions = block.rows.iter().map(|&row| Symbol::Reaction(row as usize));
            through.extend(reactions.map(|reaction| (reaction, places.clone())));
        }
        through
    }

    /// What the derivative of a loop equation consists of: its coefficients, the coordinates of this order, and the rest.
    fn terms(&self, row: usize, order: Order) -> Vec<Expr> {
        let constraint = &self.equations.constraints[row];
        if order == Order::Position {
            return vec![constraint.value];
        }
        let rest = if order == Order::Velocity { constraint.time_rate } else { constraint.gamma };
        let arena = &self.equations.system.arena;
        let unknowns = constraint.jacobian.iter().flat_map(|&(column, entry)| {
            let symbol = Node::Symbol(Symbol::Coordinate(column, order));
            [Some(entry), arena.existing(symbol)]
        });
        unknowns.flatten().chain([rest]).collect()
    }

    fn follower_places(&self, block: &Block, order: Order) -> Vec<usize> {
        let followers = block.rows.iter().flat_map(|&row| &self.equations.constraints[row as usize].followers);
        followers.filter_map(|&(index, _)| self.place(Symbol::Follower(index, order))).collect()
    }

    /// J^T lambda = Q - M a in the columns of a block.
    fn reaction_places(&self, block: &Block, inverse: &[Expr], through: &Through) -> Arc<[usize]> {
        let mut terms: Vec<Expr> = block.columns.iter().map(|&column| inverse[column as usize]).collect();
        for (row, constraint) in self.equations.constraints.iter().enumerate() {
            let entries = constraint.jacobian.iter().filter(|(column, _)| block.columns.contains(&(*column as u32)));
            let before = terms.len();
            terms.extend(entries.map(|&(_, entry)| entry));
            if terms.len() > before {
                terms.extend(self.equations.system.arena.existing(Node::Symbol(Symbol::Reaction(row))));
            }
        }
        self.of(terms, through)
    }

    /// Takes away what is in an expression without effect, because terms cancel.
    fn leave_out_what_cancels(&self, rows: &mut [Row], moving: &Moving) {
        let arena = &self.equations.system.arena;
        let listed: Vec<usize> =
            (0..rows.len()).filter(|&row| (1..=LISTED).contains(&rows[row].dependencies.len())).collect();
        let roots: Vec<Expr> = listed.iter().map(|&row| rows[row].value).collect();
        let solved = self.solved_in(&roots, moving.solved);
        let mut idle = suspects(&listed.iter().map(|&row| &*rows[row].dependencies).collect::<Vec<_>>());
        for state in 0..STATES {
            idle.retain(|pairs| !pairs.is_empty());
            let slopes =
                Slopes::new(arena, &solved, &roots, |symbol| Rounded::exact(self.somewhere(symbol, moving, state)));
            if slopes.len() * idle.len() > MOST_DERIVATIVES {
                return;
            }
            for pairs in &mut idle {
                let moved: HashSet<usize> = pairs.iter().map(|&(_, known)| known).collect();
                let moves = |symbol: &Symbol| self.place(*symbol).is_some_and(|place| moved.contains(&place));
                let changes = slopes.changing(&roots, |symbol| if moves(&symbol) { somehow(symbol, 17) } else { 0.0 });
                pairs.retain(|&(unknown, _)| changes[unknown] == Some(false));
            }
        }
        let mut left_out: HashMap<usize, HashSet<usize>> = HashMap::new();
        for (unknown, known) in idle.into_iter().flatten() {
            left_out.entry(listed[unknown]).or_default().insert(known);
        }
        for (row, idle) in left_out {
            let rest = rows[row].dependencies.iter().copied().filter(|place| !idle.contains(place));
            rows[row].dependencies = rest.collect();
        }
    }

    /// Those accelerations and reactions that are in these expressions.
    fn solved_in(&self, roots: &[Expr], solved: &[Expr]) -> HashMap<Symbol, Expr> {
        let symbols: HashSet<Symbol> = self.equations.system.arena.symbols(roots.iter().copied()).into_iter().collect();
        let all = solved.iter().enumerate().map(|(index, &value)| (self.solved_symbol(index), value));
        all.filter(|(symbol, _)| symbols.contains(symbol)).collect()
    }

    /// The value of a symbol at a state that nothing is special about, not far from a consistent one.
    fn somewhere(&self, symbol: Symbol, moving: &Moving, state: u64) -> f64 {
        let mechanism = self.equations.system.mechanism;
        let usual = typical(mechanism, moving.pose)(symbol);
        let random = somehow(symbol, state);
        let scaled = |size: f64| if usual == 0.0 { size * random } else { usual * (0.75 + 0.5 * random) };
        match symbol {
            Symbol::Missing(..) => usual,
            Symbol::Time => usual + random,
            Symbol::Parameter(_) | Symbol::Input(..) => scaled(1.0),
            Symbol::Coordinate(index, order) => {
                let angular = self.equations.coordinates[index].angular;
                let size = if angular { TAU / 6.0 } else { moving.length };
                if order == Order::Position { usual + size * (random - 0.5) } else { size * (random + 0.25) }
            }
            Symbol::Follower(..) => usual + random,
            Symbol::Reaction(_) => random,
        }
    }
}

/// Every entry of every list, as the number of the list and the place: in groups in which no list occurs twice.
fn suspects(lists: &[&[usize]]) -> Vec<Vec<(usize, usize)>> {
    let groups = apart(lists.iter().copied());
    let places = groups.iter().enumerate().flat_map(|(group, places)| places.iter().map(move |&place| (place, group)));
    let group_of: HashMap<usize, usize> = places.collect();
    let mut suspects = vec![Vec::new(); groups.len()];
    for (unknown, list) in lists.iter().enumerate() {
        list.iter().for_each(|known| suspects[group_of[known]].push((unknown, *known)));
    }
    suspects
}

/// A number between 0 and 1, another one for each symbol and state.
pub(super) fn somehow(symbol: Symbol, state: u64) -> f64 {
    let (kind, index, order) = match symbol {
        Symbol::Time => (0, 0, Order::Position),
        Symbol::Parameter(index) => (1, index, Order::Position),
        Symbol::Input(index, order) => (2, index, order),
        Symbol::Follower(index, order) => (3, index, order),
        Symbol::Coordinate(index, order) => (4, index, order),
        Symbol::Reaction(index) => (5, index, Order::Position),
        Symbol::Missing(index, _) => (6, index, Order::Position),
    };
    let seed = (index as u64) << 8 | kind << 4 | (order as u64) << 2 | 1;
    Random::new(seed.wrapping_add(state << 32)).unit()
}
