//! What the values at the start change with, found as the start is: positions from the loop equations and the known initial values, rates
//! from theirs, then accelerations and reactions.
//!
//! Everything is evaluated at consistent starts close to the default one, with parameters, inputs and known initial values that nothing is
//! special about, and with bounds on the rounding errors. A derivative that is nowhere larger than its bound is zero.

use std::collections::HashMap;

use petgraph::unionfind::UnionFind;

use super::dependencies::somehow;
use super::reduced::Reduced;
use super::start_levels::{Level, Search};
use crate::expr::{Arena, Expr, Rounded, Slopes, Symbol};

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
/// More derivatives than this are not evaluated: a few seconds.
const MOST_DERIVATIVES: usize = 100_000_000;
/// More unknowns than this that must be found together are not: what they contain counts.
const LARGEST: usize = 100;

/// Numbers of symbols; those that are not there are zero, or as usual.
type Numbers = HashMap<Symbol, Rounded>;

/// What moves at once: the symbols of one variable or of several that nothing depends on together. An input has its derivatives, too.
pub(super) type Given = Vec<Symbol>;

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

    fn evaluate(&self, level: &Level) -> Slopes {
        Slopes::along(self.arena, &level.order, |symbol| self.value(symbol))
    }

    /// Finds the unknowns of a level, and how they change with what is given.
    fn solve(&mut self, level: &Level, number: u64) -> Option<()> {
        if level.unknowns.len() > LARGEST {
            self.give_up(level);
            return Some(());
        }
        let all = level.all();
        self.begin(level, &all, number);
        self.newton(level)?;
        self.bound(level);
        let slopes = self.evaluate(level);
        let rows = level.jacobian(&slopes, &all);
        let right: Vec<Vec<Rounded>> = self.changes.iter().map(|change| moved(level, &slopes, &all, change)).collect();
        let loose = self.determine(level, &rows, &right);
        if !loose.is_empty() {
            self.let_go(level, &slopes, (&rows, &right), &loose);
        }
        Some(())
    }

    /// Nobody knows how these unknowns change; they stay as usual.
    fn give_up(&mut self, level: &Level) {
        for change in self.changes.iter_mut().filter(|change| touches(level, change)) {
            change.extend(level.unknowns.iter().map(|&unknown| (unknown, Rounded::exact(f64::NAN))));
        }
    }

    /// How those unknowns change that follow from the equations, given their derivatives and the changes of their residuals; returns the others.
    fn determine(&mut self, level: &Level, rows: &[Vec<Rounded>], right: &[Vec<Rounded>]) -> Vec<usize> {
        let held = level.residuals.len();
        let right: Vec<Vec<Rounded>> = right.iter().map(|residuals| residuals[..held].to_vec()).collect();
        let reduced = Reduced::new(&rows[..held], &right);
        let (determined, loose): (Vec<usize>, Vec<usize>) =
            (0..level.unknowns.len()).partition(|&column| reduced.determines(column));
        for column in determined {
            for (index, change) in self.changes.iter_mut().enumerate() {
                change.insert(level.unknowns[column], reduced.solution(column, index));
            }
        }
        loose
    }

    /// Those that are left open go somehow with everything that pulls at them: from their guess, or where the equations close.
    fn let_go(
        &mut self,
        level: &Level,
        slopes: &Slopes,
        (rows, right): (&[Vec<Rounded>], &[Vec<Rounded>]),
        loose: &[usize],
    ) {
        let every: Vec<usize> = (0..level.unknowns.len()).collect();
        let first = if level.guessing { groups(&rows[level.loops..], &every) } else { Vec::new() };
        let then = groups(&rows[..level.residuals.len()], loose);
        for (change, right) in self.changes.iter_mut().zip(right) {
            let guessed = guessed(&first, &right[level.loops..], every.len());
            let pulled = |row: usize| rows[row].iter().zip(&guessed).any(|(entry, moves)| *moves && !entry.is_zero());
            let residuals = moved(level, slopes, &level.residuals, change);
            let moved = |row: usize| !residuals[row].is_zero() || pulled(row);
            let together = then.iter().filter(|(rows, _)| rows.iter().any(|&row| moved(row)));
            let alone = loose.iter().copied().filter(|&column| guessed[column]);
            let columns = together.flat_map(|(_, columns)| columns.iter().copied()).chain(alone);
            let unknowns = columns.map(|column| level.unknowns[column]);
            change.extend(unknowns.map(|unknown| (unknown, Rounded::exact(0.5 + somehow(unknown, 18)))));
        }
    }

    /// Where the search for a level begins: off what is special, where anything moves at all.
    fn begin(&mut self, level: &Level, all: &[Expr], number: u64) {
        let slopes = self.evaluate(level);
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
    }

    /// Fulfils the equations as far as rounding lets it.
    fn newton(&mut self, level: &Level) -> Option<()> {
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let slopes = self.evaluate(level);
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
    fn bound(&mut self, level: &Level) {
        let slopes = self.evaluate(level);
        let rest = slopes.values(&level.residuals);
        let reduced = Reduced::new(&level.jacobian(&slopes, &level.residuals), &[rest]);
        for (column, &unknown) in level.unknowns.iter().enumerate() {
            let value = self.value(unknown).off_by(reduced.solution(column, 0));
            self.values.insert(unknown, value);
        }
    }

    /// Which roots change with what is given.
    fn changing(&self, roots: &[Expr]) -> Option<Vec<Vec<Option<bool>>>> {
        let slopes = Slopes::new(self.arena, &self.search.solved, roots, |symbol| self.value(symbol));
        if self.changes.len() * slopes.len() > MOST_DERIVATIVES {
            return None;
        }
        let by_given: Vec<Vec<Rounded>> =
            self.changes.iter().map(|change| slopes.slopes(roots, within(change))).collect();
        Some((0..roots.len()).map(|root| by_given.iter().map(|of| of[root].is_not_zero()).collect()).collect())
    }
}

/// Is anything in the equations of a level changed, other than its unknowns?
fn touches(level: &Level, change: &Numbers) -> bool {
    level.knowns.iter().any(|known| change.contains_key(known))
}

/// How much residuals of a level change with what is known.
fn moved(level: &Level, slopes: &Slopes, residuals: &[Expr], change: &Numbers) -> Vec<Rounded> {
    if touches(level, change) {
        slopes.slopes(residuals, within(change))
    } else {
        vec![Rounded::default(); residuals.len()]
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
