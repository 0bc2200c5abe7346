//! What the values at the start change with, found as the start is: positions from the loop equations and the known initial values, rates
//! from theirs, then accelerations and reactions.
//!
//! Everything is evaluated at consistent starts close to the default one, with parameters, inputs and known initial values that nothing is
//! special about, and with bounds on the rounding errors. A derivative that is nowhere larger than its bound is zero.

use std::collections::HashMap;

use petgraph::unionfind::UnionFind;

use super::dependencies::somehow;
use super::initial::Conditions;
use super::program::inverse;
use super::reduced::Reduced;
use super::start::Beginning;
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Rounded, Slopes, Symbol};

/// How far parameters, inputs and known values are moved, relative to what they are: as far as the loops can follow.
const MOVES: [f64; 4] = [0.1, 1e-2, 1e-3, 1e-5];
/// At so many starts a derivative has to vanish.
const STARTS: u64 = 3;
/// Most steps of Newton's method.
const ITERATIONS: usize = 30;
/// Steps this short may be rounding errors.
const CONVERGED: f64 = 1e-8;
/// Where coordinates begin that nothing determines, in units of a length: off what is special.
const OFF: f64 = 1e-2;
/// More derivatives than this are not evaluated.
const MOST_DERIVATIVES: usize = 2_000_000;

/// Numbers of symbols; those that are not there are zero, or as usual.
type Numbers = HashMap<Symbol, Rounded>;

/// Equations for unknowns that follow from what is known before.
#[derive(Clone, Debug, Default)]
pub(super) struct Level {
    /// What is solved for.
    pub unknowns: Vec<Symbol>,
    /// They are zero: loop equations, then known values.
    pub residuals: Vec<Expr>,
    /// How many of them are loop equations.
    pub loops: usize,
    /// They and the known values are made small first, with the loops open. What is left open goes on from there.
    pub guesses: Vec<Expr>,
    /// Is that so? It is with positions.
    pub guessing: bool,
}

/// How the start is found.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    /// In the order of their solution: positions, rates, and where drivers determine the motion accelerations and reactions.
    pub levels: Vec<Level>,
    /// Accelerations and reactions in terms of the state, where loads determine the motion.
    pub solved: HashMap<Symbol, Expr>,
    /// What followers take from inputs: the same numbers.
    pub followed: Vec<(Symbol, Symbol)>,
    /// Typical length.
    pub length: f64,
}

/// What is given by one variable: one symbol, or an input and its derivatives.
pub(super) type Given = Vec<Symbol>;

impl Search {
    /// The equations of the start. `reacts`: where drivers determine the motion, are reactions wanted?
    pub fn new(equations: &mut Equations, beginning: &Beginning, (length, reacts): (f64, bool)) -> Self {
        let followers = equations.system.followers.clone();
        let mut search = Search { length, ..Search::default() };
        for (index, &(_, input, order)) in followers.iter().enumerate() {
            let mut follow = |order, input_order| {
                let symbol = (Symbol::Follower(index, order), Symbol::Input(input.0, input_order));
                search.followed.push(symbol);
            };
            follow(order, Order::Position);
            if order == Order::Velocity {
                follow(Order::Acceleration, Order::Velocity);
            }
        }
        for (order, conditions) in [Order::Position, Order::Velocity].into_iter().zip(beginning.conditions) {
            let values = beginning.constraints[usize::from(order == Order::Velocity)];
            let free = |(index, given): (usize, Order)| (order < given).then_some(Symbol::Follower(index, order));
            let mut level = Level {
                unknowns: coordinates(equations, order)
                    .chain(followers.iter().map(|follower| follower.2).enumerate().filter_map(free))
                    .collect(),
                residuals: loops(equations, beginning).map(|row| values[row]).collect(),
                guessing: order == Order::Position,
                ..Level::default()
            };
            level.loops = level.residuals.len();
            level.impose(&mut equations.system.arena, conditions);
            search.levels.push(level);
        }
        match beginning.solved {
            Some(solved) => search.solved = beginning.symbols().zip(solved.iter().copied()).collect(),
            None => {
                search.levels.push(driven(equations, beginning));
                search.levels.extend(reacts.then(|| reactions(equations, beginning)));
            }
        }
        search
    }
}

fn coordinates(equations: &Equations, order: Order) -> impl Iterator<Item = Symbol> + use<> {
    (0..equations.coordinates.len()).map(move |index| Symbol::Coordinate(index, order))
}

/// The loop equations that count: independent ones, and those about followers alone.
fn loops<'a>(equations: &'a Equations, beginning: &'a Beginning) -> impl Iterator<Item = usize> + use<'a> {
    let constraints = equations.constraints.iter().zip(beginning.active).enumerate();
    let counts = constraints.filter(|(_, (row, active))| **active || (row.is_trivial() && !row.says_nothing()));
    counts.map(|(row, _)| row)
}

/// Phi_q a - gamma
fn driven(equations: &mut Equations, beginning: &Beginning) -> Level {
    let mut level = Level { unknowns: coordinates(equations, Order::Acceleration).collect(), ..Level::default() };
    for (row, constraint) in equations.constraints.iter().enumerate().filter(|(row, _)| beginning.active[*row]) {
        let arena = &mut equations.system.arena;
        let start = arena.negate(beginning.constraints[2][row]);
        let sum = |sum, &(column, entry): &(usize, Expr)| {
            let acceleration = arena.symbol(Symbol::Coordinate(column, Order::Acceleration));
            let term = arena.multiply(entry, acceleration);
            arena.add(sum, term)
        };
        level.residuals.push(constraint.jacobian.iter().fold(start, sum));
    }
    level
}

/// Q - M a - Phi_q^T lambda
fn reactions(equations: &mut Equations, beginning: &Beginning) -> Level {
    let mut level = Level { residuals: inverse(equations), ..Level::default() };
    for (row, constraint) in equations.constraints.iter().enumerate().filter(|(row, _)| beginning.active[*row]) {
        let arena = &mut equations.system.arena;
        let reaction = arena.symbol(Symbol::Reaction(row));
        level.unknowns.push(Symbol::Reaction(row));
        for &(column, entry) in &constraint.jacobian {
            let term = arena.multiply(entry, reaction);
            level.residuals[column] = arena.subtract(level.residuals[column], term);
        }
    }
    level
}

impl Level {
    /// Adds conditions.
    fn impose(&mut self, arena: &mut Arena, conditions: &Conditions) {
        let (values, targets) = conditions.results.split_at(conditions.conditions.len());
        for ((condition, &value), &target) in conditions.conditions.iter().zip(values).zip(targets) {
            let residual = arena.subtract(value, target);
            match condition.known {
                true => self.residuals.push(residual),
                false if self.guessing => self.guesses.push(residual),
                false => (),
            }
        }
    }

    fn all(&self) -> Vec<Expr> {
        self.residuals.iter().chain(&self.guesses).copied().collect()
    }

    /// Derivatives of roots by the unknowns, by rows.
    fn jacobian(&self, slopes: &Slopes, roots: &[Expr]) -> Vec<Vec<Rounded>> {
        let one = |of: Symbol| move |symbol| if symbol == of { Rounded::exact(1.0) } else { Rounded::default() };
        let columns: Vec<Vec<Rounded>> =
            self.unknowns.iter().map(|&unknown| slopes.slopes(roots, one(unknown))).collect();
        (0..roots.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }
}

/// Which roots change with what is given, as a table of roots and givens. Nothing where that could not be told.
pub(super) fn changing(
    (arena, search): (&Arena, &Search),
    roots: &[Expr],
    given: &[Given],
    usual: &impl Fn(Symbol) -> f64,
) -> Vec<Vec<Option<bool>>> {
    let mut found = vec![vec![Some(false); given.len()]; roots.len()];
    for number in 0..STARTS {
        let start = MOVES.iter().find_map(|&by| Start::find((arena, search), given, usual, (number, by)));
        let Some(changes) = start.and_then(|start| start.changing(roots)) else {
            found.iter_mut().flatten().for_each(|found| *found = found.filter(|found| *found));
            break;
        };
        for (found, changes) in found.iter_mut().flatten().zip(changes.into_iter().flatten()) {
            *found = if *found == Some(true) || changes == Some(true) { Some(true) } else { found.and(changes) };
        }
    }
    found
}

/// A consistent start.
struct Start<'a, U> {
    arena: &'a Arena,
    search: &'a Search,
    usual: &'a U,
    /// What is not as usual.
    values: Numbers,
    /// How everything changes with each given.
    changes: Vec<Numbers>,
}

impl<'a, U: Fn(Symbol) -> f64> Start<'a, U> {
    /// The start with that number, where givens are moved by so much. None if it cannot be found.
    fn find(
        (arena, search): (&'a Arena, &'a Search),
        given: &[Given],
        usual: &'a U,
        (number, by): (u64, f64),
    ) -> Option<Self> {
        let mut start = Start { arena, search, usual, values: Numbers::new(), changes: Vec::new() };
        for symbols in given {
            for &symbol in symbols {
                let usual = usual(symbol);
                let size = if usual == 0.0 { 1.0 } else { usual };
                let value = usual + by * size * (2.0 * somehow(symbol, number) - 1.0);
                start.values.insert(symbol, Rounded::exact(value));
            }
            start.changes.push(symbols.iter().map(|&symbol| (symbol, Rounded::exact(somehow(symbol, 17)))).collect());
        }
        for &(symbol, input) in &search.followed {
            start.values.insert(symbol, start.value(input));
            start.changes.iter_mut().for_each(|change| copy(change, input, symbol));
        }
        search.levels.iter().try_for_each(|level| start.solve(level, number))?;
        Some(start)
    }

    fn value(&self, symbol: Symbol) -> Rounded {
        self.values.get(&symbol).copied().unwrap_or_else(|| Rounded::exact((self.usual)(symbol)))
    }

    fn evaluate(&self, solved: &HashMap<Symbol, Expr>, roots: &[Expr]) -> Option<Slopes> {
        let slopes = Slopes::new(self.arena, solved, roots, |symbol| self.value(symbol));
        (self.changes.len() * slopes.len() <= MOST_DERIVATIVES).then_some(slopes)
    }

    /// Finds the unknowns of a level, and how they change with what is given.
    fn solve(&mut self, level: &Level, number: u64) -> Option<()> {
        let all = level.all();
        self.begin(level, &all, number)?;
        self.newton(level)?;
        self.bound(level)?;
        let slopes = self.evaluate(&HashMap::new(), &all)?;
        let rows = level.jacobian(&slopes, &all);
        let held = level.residuals.len();
        let right: Vec<Vec<Rounded>> = self.changes.iter().map(|change| slopes.slopes(&all, within(change))).collect();
        let reduced = Reduced::new(&rows[..held], &right.iter().map(|rows| rows[..held].to_vec()).collect::<Vec<_>>());
        let (determined, loose): (Vec<usize>, Vec<usize>) =
            (0..level.unknowns.len()).partition(|&column| reduced.determines(column));
        for column in determined {
            for (index, change) in self.changes.iter_mut().enumerate() {
                change.insert(level.unknowns[column], reduced.solution(column, index));
            }
        }
        if loose.is_empty() {
            return Some(());
        }
        let every: Vec<usize> = (0..level.unknowns.len()).collect();
        let first = if level.guessing { groups(&rows[level.loops..], &every) } else { Vec::new() };
        let then = groups(&rows[..held], &loose);
        for (change, right) in self.changes.iter_mut().zip(&right) {
            let guessed = guessed(&first, &right[level.loops..], every.len());
            let moved: Vec<bool> = (slopes.slopes(&level.residuals, within(change)).into_iter().zip(&rows))
                .map(|(slope, row)| {
                    !slope.is_zero() || row.iter().zip(&guessed).any(|(at, moves)| *moves && !at.is_zero())
                })
                .collect();
            let together = then.iter().filter(|(rows, _)| rows.iter().any(|&row| moved[row]));
            let alone = loose.iter().copied().filter(|&column| guessed[column]);
            let columns: Vec<usize> = together.flat_map(|(_, columns)| columns.iter().copied()).chain(alone).collect();
            let unknowns = columns.into_iter().map(|column| level.unknowns[column]);
            change.extend(unknowns.map(|unknown| (unknown, Rounded::exact(0.5 + somehow(unknown, 18)))));
        }
        Some(())
    }

    /// Where the search for a level begins: off what is special, where anything moves at all.
    fn begin(&mut self, level: &Level, all: &[Expr], number: u64) -> Option<()> {
        let slopes = self.evaluate(&HashMap::new(), all)?;
        let moved: Vec<bool> = slopes.values(all).into_iter().map(|rest| !rest.is_zero()).collect();
        let columns: Vec<usize> = (0..level.unknowns.len()).collect();
        for (rows, columns) in groups(&level.jacobian(&slopes, all), &columns) {
            for column in columns.into_iter().filter(|_| rows.iter().any(|&row| moved[row])) {
                let unknown = level.unknowns[column];
                let off = OFF * self.search.length.min(1.0) * (2.0 * somehow(unknown, number) - 1.0);
                let value = (self.usual)(unknown) + off;
                self.values.insert(unknown, Rounded::exact(value));
            }
        }
        Some(())
    }

    /// Fulfils the equations as far as rounding lets it.
    fn newton(&mut self, level: &Level) -> Option<()> {
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let slopes = self.evaluate(&HashMap::new(), &level.residuals)?;
            let rest = slopes.values(&level.residuals);
            let reduced = Reduced::new(&level.jacobian(&slopes, &level.residuals), &[rest]);
            let mut longest = 0.0_f64;
            for (column, &unknown) in level.unknowns.iter().enumerate() {
                let step = reduced.solution(column, 0).value;
                longest = longest.max(step.abs());
                let value = self.value(unknown).value + step;
                self.values.insert(unknown, Rounded::exact(value));
            }
            if !longest.is_finite() {
                return None;
            }
            if longest == 0.0 || (longest < CONVERGED && longest > 0.5 * before) {
                return reduced.is_consistent().then_some(());
            }
            before = longest;
        }
        None
    }

    /// How far the unknowns may still be from the solution.
    fn bound(&mut self, level: &Level) -> Option<()> {
        let slopes = self.evaluate(&HashMap::new(), &level.residuals)?;
        let rest = slopes.values(&level.residuals);
        let reduced = Reduced::new(&level.jacobian(&slopes, &level.residuals), &[rest]);
        for (column, &unknown) in level.unknowns.iter().enumerate() {
            let value = self.value(unknown).off_by(reduced.solution(column, 0));
            self.values.insert(unknown, value);
        }
        Some(())
    }

    /// Which roots change with what is given.
    fn changing(&self, roots: &[Expr]) -> Option<Vec<Vec<Option<bool>>>> {
        let slopes = self.evaluate(&self.search.solved, roots)?;
        let by_given: Vec<Vec<Rounded>> =
            self.changes.iter().map(|change| slopes.slopes(roots, within(change))).collect();
        Some((0..roots.len()).map(|root| by_given.iter().map(|of| of[root].is_not_zero()).collect()).collect())
    }
}

fn copy(numbers: &mut Numbers, from: Symbol, to: Symbol) {
    if let Some(&number) = numbers.get(&from) {
        numbers.insert(to, number);
    }
}

/// Which unknowns move where known values and guesses are made small with the loops open, given which of these residuals move.
fn guessed(groups: &[Group], residuals: &[Rounded], columns: usize) -> Vec<bool> {
    let mut guessed = vec![false; columns];
    for (rows, columns) in groups {
        let moved = rows.iter().any(|&row| !residuals[row].is_zero());
        columns.iter().for_each(|&column| guessed[column] = moved);
    }
    guessed
}

fn within(numbers: &Numbers) -> impl Fn(Symbol) -> Rounded {
    |symbol| numbers.get(&symbol).copied().unwrap_or_default()
}

/// Rows and columns that belong together.
type Group = (Vec<usize>, Vec<usize>);

/// What belongs together, of some of the columns of a matrix.
fn groups(matrix: &[Vec<Rounded>], columns: &[usize]) -> Vec<Group> {
    let mut sets = UnionFind::<usize>::new(matrix.first().map_or(0, Vec::len));
    let of_row = |row: usize| columns.iter().copied().filter(move |&column| !matrix[row][column].is_zero());
    for row in 0..matrix.len() {
        let mut members = of_row(row);
        if let Some(first) = members.next() {
            members.for_each(|column| _ = sets.union(first, column));
        }
    }
    let mut groups: HashMap<usize, Group> = HashMap::new();
    for row in 0..matrix.len() {
        if let Some(column) = of_row(row).next() {
            groups.entry(sets.find(column)).or_default().0.push(row);
        }
    }
    for &column in columns {
        if let Some(group) = (column < sets.len()).then(|| sets.find(column)).and_then(|set| groups.get_mut(&set)) {
            group.1.push(column);
        }
    }
    groups.into_values().collect()
}
