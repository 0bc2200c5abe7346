//! What each variable depends on while the mechanism moves: the states and inputs that change it at once.
//!
//! Read off the structure of the expressions, so that no entry is ever missing; one whose effect cancels stays (FMI 2.0, section 2.2.8, asks
//! for no more). Dynamic motion: through the accelerations and reactions to what is in their expressions. Driven motion: through the blocks of
//! the loop equations to the inputs in them.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use cotree_fmu::program::{Block, Source};

use super::footprints::footprints;
use super::program::inverse;
use super::table::Row;
use crate::equations::Equations;
use crate::expr::{Expr, Node, Order, Symbol};

/// Longer lists of dependencies are left out of the description, or they would grow with the square of the model.
pub(crate) const LISTED: usize = 500;

/// With more coordinates than this every coordinate of a driven mechanism counts as depending on everything that drives it.
const MOST_DRIVEN: usize = 1000;

type Places = BTreeSet<usize>;

#[derive(Clone, Copy, Debug)]
pub(super) struct Moving<'a> {
    /// Accelerations and reactions as expressions; none if the drivers determine the motion.
    pub solved: &'a [Expr],
    /// The blocks of the loop equations if the drivers determine the motion, in the order of their solution.
    pub blocks: &'a [Block],
}

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
}

fn reacts(rows: &[Row], equations: &Equations) -> bool {
    let symbols = equations.system.arena.symbols(rows.iter().map(|row| row.value));
    symbols.iter().any(|symbol| matches!(symbol, Symbol::Reaction(_)))
}

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
}
