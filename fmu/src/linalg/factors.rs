//! L D L^T of the symmetric matrix [M J^T; J 0] of a large mechanism, once a step: cost follows the entries, not the square of the size.
//!
//! The pattern is that of the mechanism and stays. Equations with the fewest neighbours go first, a loop equation only
//! after all unknowns that it contains: by then its pivot is that of -J M^-1 J^T, so that no pivot vanishes but in singular poses.

use std::collections::BTreeSet;
use std::ops::Range;

use super::SINGULAR;
use super::lane::at_each;
use super::matrix::{Entries, Places, most};

/// The order of elimination and the entries that are not zero: columns of L, each from its diagonal down.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    /// Equation of each column.
    equations: Vec<usize>,
    /// Column of each equation.
    columns: Vec<usize>,
    /// First entry of each column, and the end; how many it has.
    first: Vec<usize>,
    counts: Vec<usize>,
    /// Column that each entry stands in the row of, ascending.
    rows: Vec<u32>,
    /// The entries by rows: how many each row has, and where each entry of the columns is.
    counts_by_rows: Vec<usize>,
    turned: Vec<u32>,
    /// The products that are taken off each entry: the entry and the factor of an earlier column, by rows.
    products: Lists,
    /// Columns whose part of the inverse is needed, from the last one up, and for each of their entries the other factors of the column and the entries of the inverse that
    /// they are multiplied by.
    wanted: Vec<usize>,
    sources: Lists,
}

/// Lists of pairs of places, one after the other.
#[derive(Clone, Debug, Default)]
struct Lists {
    counts: Vec<usize>,
    pairs: Vec<[u32; 2]>,
}

impl Lists {
    fn new(lists: &[Vec<[u32; 2]>]) -> Self {
        Self { counts: lists.iter().map(Vec::len).collect(), pairs: lists.concat() }
    }
}

/// Takes so many off the front.
#[inline(always)]
fn take<'a, T>(rest: &mut &'a [T], count: usize) -> &'a [T] {
    let (taken, left) = rest.split_at(count.min(rest.len()));
    *rest = left;
    taken
}

/// Takes so many off the end.
#[inline(always)]
fn take_last<'a, T>(rest: &mut &'a [T], count: usize) -> &'a [T] {
    let (left, taken) = rest.split_at(rest.len().saturating_sub(count));
    *rest = left;
    taken
}

impl Pattern {
    /// For the places (row, column) of the entries, either triangle or both; equations from `unknowns` on are loop equations. The inverse will be asked for the diagonal of
    /// these.
    pub fn new(size: usize, unknowns: usize, places: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut neighbours = vec![BTreeSet::new(); size];
        for (row, column) in places.filter(|(row, column)| row != column) {
            neighbours[row].insert(column);
            neighbours[column].insert(row);
        }
        let (equations, below) = eliminate(neighbours, unknowns);
        let mut columns = vec![0; size];
        equations.iter().enumerate().for_each(|(column, &equation)| columns[equation] = column);
        let (mut first, mut rows) = (vec![0], Vec::new());
        for equations in below {
            let mut entries: Vec<u32> = equations.iter().map(|&equation| columns[equation] as u32).collect();
            entries.sort_unstable();
            rows.extend(entries);
            first.push(rows.len());
        }
        let mut pattern = Self {
            counts: first.windows(2).map(|ends| ends[1] - ends[0]).collect(),
            counts_by_rows: Vec::new(),
            turned: vec![0; rows.len()],
            products: Lists::default(),
            wanted: Vec::new(),
            sources: Lists::default(),
            equations,
            columns,
            first,
            rows,
        };
        pattern.turn();
        pattern.find_products();
        pattern.find_sources(unknowns);
        pattern
    }

    /// Finds the entries by rows.
    fn turn(&mut self) {
        let mut by_rows: Vec<u32> = (0..self.rows.len() as u32).collect();
        by_rows.sort_by_key(|&entry| self.rows[entry as usize]);
        self.counts_by_rows = vec![0; self.equations.len()];
        for (place, &entry) in by_rows.iter().enumerate() {
            self.turned[entry as usize] = place as u32;
            self.counts_by_rows[self.rows[entry as usize] as usize] += 1;
        }
    }

    fn find_products(&mut self) {
        let mut products = vec![Vec::new(); self.rows.len()];
        for (upper, lower) in (0..self.equations.len()).flat_map(|column| self.pairs(column)) {
            let factors = [lower, upper].map(|entry| self.turned[entry]);
            products[self.entry(self.rows[upper], self.rows[lower])].push(factors);
        }
        self.products = Lists::new(&products);
    }

    fn find_sources(&mut self, unknowns: usize) {
        let size = self.equations.len();
        let mut wanted: Vec<bool> = self.equations.iter().map(|equation| *equation >= unknowns).collect();
        let mut sources = vec![Vec::new(); self.rows.len()];
        for column in 0..size {
            if wanted[column] {
                self.entries(column).for_each(|entry| wanted[self.rows[entry] as usize] = true);
                for (upper, lower) in self.pairs(column) {
                    let source = self.entry(self.rows[upper], self.rows[lower]) as u32;
                    sources[upper].push([lower as u32, source]);
                    sources[lower].push([upper as u32, source]);
                }
            }
        }
        sources.iter_mut().for_each(|others| others.sort_unstable());
        self.wanted = (0..size).rev().filter(|&column| wanted[column]).collect();
        let in_order = self.wanted.iter().flat_map(|&column| self.entries(column));
        self.sources = Lists::new(&in_order.map(|entry| std::mem::take(&mut sources[entry])).collect::<Vec<_>>());
    }

    /// Multiplications of a factorisation, and of a solution.
    pub fn work(&self) -> [usize; 2] {
        [self.products.pairs.len() + 2 * self.rows.len(), 2 * self.rows.len() + self.equations.len()]
    }

    #[inline(always)]
    fn entries(&self, column: usize) -> Range<usize> {
        self.first[column]..self.first[column + 1]
    }

    /// Each entry of a column with each one below it.
    fn pairs(&self, column: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let entries = self.entries(column);
        entries.clone().flat_map(move |upper| (upper + 1..entries.end).map(move |lower| (upper, lower)))
    }

    /// The entry below the diagonal of a column, in the row of a later one.
    fn entry(&self, column: u32, row: u32) -> usize {
        let entries = self.entries(column as usize);
        entries.start + self.rows[entries].partition_point(|entry| *entry < row)
    }

    /// Where an entry of the matrix is kept: diagonals first.
    fn place(&self, row: usize, column: usize) -> usize {
        let (a, b) = (self.columns[row], self.columns[column]);
        if a == b { a } else { self.equations.len() + self.entry(a.min(b) as u32, a.max(b) as u32) }
    }
}

/// The order of elimination, and for each equation those that it is coupled with when its turn comes.
fn eliminate(mut neighbours: Vec<BTreeSet<usize>>, unknowns: usize) -> (Vec<usize>, Vec<BTreeSet<usize>>) {
    let original = neighbours.clone();
    // The unknowns that each loop equation waits for; an unknown waits for none.
    let mut waits = vec![BTreeSet::new(); neighbours.len()];
    for (waits, neighbours) in waits.iter_mut().zip(&original).skip(unknowns) {
        waits.extend(neighbours.range(..unknowns).copied());
    }
    let mut ranks = vec![Rank::default(); neighbours.len()];
    ranks[..unknowns].iter_mut().for_each(|rank| rank.leaves_open = true);
    let key =
        |index: usize, neighbours: &[BTreeSet<usize>], ranks: &[Rank]| (neighbours[index].len(), ranks[index], index);
    let ready = (0..neighbours.len()).filter(|&index| waits[index].is_empty());
    let mut next: BTreeSet<(usize, Rank, usize)> = ready.map(|index| key(index, &neighbours, &ranks)).collect();
    let (mut order, mut below) = (Vec::with_capacity(neighbours.len()), Vec::with_capacity(neighbours.len()));
    while let Some((.., index)) = next.pop_first() {
        let coupled = std::mem::take(&mut neighbours[index]);
        for &other in &coupled {
            next.remove(&key(other, &neighbours, &ranks));
            ranks[other].height = ranks[other].height.max(ranks[index].height + 1);
            neighbours[other].remove(&index);
            neighbours[other].extend(coupled.iter().copied().filter(|fill| *fill != other));
        }
        if index < unknowns {
            original[index].range(unknowns..).for_each(|&row| _ = waits[row].remove(&index));
        }
        for &row in &coupled {
            if let (1, Some(&last)) = (waits[row].len(), waits[row].first()) {
                next.remove(&key(last, &neighbours, &ranks));
                ranks[last] = Rank { leaves_open: false, height: ranks[last].height.max(ranks[row].height) };
                next.insert(key(last, &neighbours, &ranks));
            }
        }
        let ready = coupled.iter().filter(|&&other| waits[other].is_empty());
        next.extend(ready.map(|&other| key(other, &neighbours, &ranks)));
        order.push(index);
        below.push(coupled);
    }
    (order, below)
}

/// Of equations with equally many neighbours the one of the lowest rank is eliminated first. Unknowns that no loop equation waits for alone come last: elimination works from all ends of a mechanism
/// towards its middle, and consecutive results do not depend on each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    leaves_open: bool,
    /// The number of eliminations before it, each of which depends on the one before.
    height: usize,
}

/// The factors of one matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factors {
    pattern: Pattern,
    /// Where parts of a solution go: the first equation, its place, and so many in a row.
    targets: Vec<[usize; 3]>,
    /// D, from the matrix; then 1 / D.
    diagonal: Vec<f64>,
    /// Entries of the matrix.
    entries: Vec<f64>,
    /// L by columns, and by rows.
    factors: Vec<Part>,
    by_rows: Vec<Part>,
    /// What each pivot is the difference of.
    sizes: Vec<f64>,
    /// The inverse where the factors have entries.
    inverse_diagonal: Vec<f64>,
    inverse: Vec<f64>,
    solution: Vec<f64>,
}

/// Places that follow each other: the first one's number, the first one, and how many.
fn in_rows(places: &[usize]) -> Vec<[usize; 3]> {
    let mut rows: Vec<[usize; 3]> = Vec::new();
    for (number, &place) in places.iter().enumerate() {
        match rows.last_mut() {
            Some([_, first, count]) if *first + *count == place => *count += 1,
            _ => rows.push([number, place, 1]),
        }
    }
    rows
}

/// An entry of L D, that of L, and the equation whose part of a solution this multiplies.
#[derive(Clone, Copy, Debug)]
struct Part {
    entry: f64,
    factor: f64,
    equation: u32,
}

impl Part {
    fn of(equation: usize) -> Self {
        Self { entry: 0.0, factor: 0.0, equation: equation as u32 }
    }
}

impl Entries for Factors {
    #[inline(always)]
    fn add(&mut self, [place, _]: Places, value: f64) {
        match place.checked_sub(self.diagonal.len()) {
            None => self.diagonal[place] += value,
            Some(entry) => self.entries[entry] += value,
        }
    }
}

impl Factors {
    /// Storage; solutions go to `targets`.
    pub fn new(pattern: Pattern, targets: Vec<usize>) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        let (size, count) = (targets.len(), pattern.rows.len());
        let below = |row: &u32| Part::of(pattern.equations[*row as usize]);
        let mut by_rows = vec![Part::of(0); count];
        for (column, &equation) in pattern.equations.iter().enumerate() {
            pattern.entries(column).for_each(|entry| by_rows[pattern.turned[entry] as usize] = Part::of(equation));
        }
        Self {
            targets: in_rows(&targets),
            diagonal: zeros(size),
            sizes: zeros(size),
            inverse_diagonal: zeros(size),
            entries: zeros(count),
            factors: pattern.rows.iter().map(below).collect(),
            by_rows,
            inverse: zeros(count),
            solution: zeros(size),
            pattern,
        }
    }

    /// Where its entries are.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Where an entry of the matrix is kept, which is its mirror image too.
    pub fn places(&self, row: usize, column: usize) -> Places {
        [self.pattern.place(row, column); 2]
    }

    /// Makes all entries zero.
    pub fn clear(&mut self) {
        self.diagonal.fill(0.0);
        self.entries.fill(0.0);
    }

    /// Replaces the matrix by its factors; has it some? Each entry is found at once, from those of earlier columns: sums stay in registers.
    #[inline(always)]
    pub fn factor(&mut self) -> bool {
        let Self { pattern, diagonal, entries, factors, by_rows, sizes, .. } = self;
        let (mut products, mut counts) = (&pattern.products.pairs[..], pattern.products.counts.iter());
        let (mut first, mut first_by_rows) = (0, 0);
        for column in 0..diagonal.len() {
            let mut pivot = diagonal[column];
            let mut size = pivot.abs();
            let row = &by_rows[first_by_rows..][..pattern.counts_by_rows[column]];
            for part in row {
                let product = part.entry * part.factor;
                pivot -= product;
                size += product.abs();
            }
            first_by_rows += row.len();
            sizes[column] = size;
            // Not a number is singular too.
            let regular = pivot.abs() > SINGULAR * size;
            if !regular {
                return false;
            }
            let inverse = 1.0 / pivot;
            diagonal[column] = inverse;
            let end = first + pattern.counts[column];
            for (entry, count) in (first..end).zip(&mut counts) {
                let mut value = entries[entry];
                for &[earlier, other] in take(&mut products, *count) {
                    value -= by_rows[earlier as usize].entry * by_rows[other as usize].factor;
                }
                let (part, turned) = (&mut factors[entry], &mut by_rows[pattern.turned[entry] as usize]);
                part.factor = value * inverse;
                (turned.entry, turned.factor) = (value, part.factor);
            }
            first = end;
        }
        self.invert();
        true
    }

    /// The inverse where the factors have entries, from the last column to the first (Takahashi, Fagan and Chin, 1973).
    #[inline(always)]
    fn invert(&mut self) {
        let Self { pattern, diagonal, factors, inverse, inverse_diagonal, .. } = self;
        let (mut sources, mut counts) = (&pattern.sources.pairs[..], pattern.sources.counts.iter());
        for &column in &pattern.wanted {
            let mut sum = diagonal[column];
            for (entry, count) in pattern.entries(column).zip(&mut counts) {
                let factor = factors[entry].factor;
                let mut value = -(factor * inverse_diagonal[pattern.rows[entry] as usize]);
                for &[other, source] in take(&mut sources, *count) {
                    value -= factors[other as usize].factor * inverse[source as usize];
                }
                inverse[entry] = value;
                sum -= factor * value;
            }
            inverse_diagonal[column] = sum;
        }
    }

    /// An entry of the diagonal of the inverse.
    pub fn diagonal(&self, equation: usize) -> f64 {
        self.inverse_diagonal[self.pattern.columns[equation]]
    }

    /// Solutions for several right-hand sides, by equations.
    #[inline(always)]
    pub fn solve_all<const D: usize>(&self, vectors: &[[f64; D]], solutions: &mut [[f64; D]]) {
        solutions.copy_from_slice(vectors);
        self.substitute(solutions);
    }

    /// Replaces right-hand sides by solutions, by equations. Each is found at once from the others: sums stay in registers.
    #[inline(always)]
    fn substitute<const D: usize>(&self, x: &mut [[f64; D]]) {
        let Pattern { equations, counts, counts_by_rows, .. } = &self.pattern;
        let mut rest = &self.by_rows[..];
        for (&equation, &count) in equations.iter().zip(counts_by_rows).filter(|(_, count)| **count > 0) {
            let mut sum = x[equation];
            for part in take(&mut rest, count) {
                let value = &x[part.equation as usize];
                at_each!(D, i => sum[i] -= part.factor * value[i]);
            }
            x[equation] = sum;
        }
        let mut rest = &self.factors[..];
        for ((&equation, &count), inverse) in equations.iter().zip(counts).zip(&self.diagonal).rev() {
            let mut sum = x[equation];
            at_each!(D, i => sum[i] *= inverse);
            for part in take_last(&mut rest, count).iter().rev() {
                let value = &x[part.equation as usize];
                at_each!(D, i => sum[i] -= part.factor * value[i]);
            }
            x[equation] = sum;
        }
    }

    /// How much larger than the pivot of an equation that is which it is the difference of.
    fn growth(&self, equation: usize) -> f64 {
        let column = self.pattern.columns[equation];
        self.sizes[column] * self.diagonal[column].abs()
    }

    /// The largest share of what the pivot of an equation before `unknowns` is the difference of in that pivot, and the equation.
    pub fn cancellation(&self, unknowns: usize) -> (f64, usize) {
        most((0..unknowns).map(|equation| self.growth(equation)))
    }

    /// The solution for right-hand sides by equations, at its places.
    #[inline(always)]
    pub fn solve(&mut self, vector: &[f64], solution: &mut [f64]) {
        let mut x = std::mem::take(&mut self.solution);
        x.copy_from_slice(vector);
        self.substitute(x.as_chunks_mut::<1>().0);
        for &[equation, place, count] in &self.targets {
            solution[place..][..count].copy_from_slice(&x[equation..][..count]);
        }
        self.solution = x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// A ladder: unknowns in a row, each coupled with the next, and a loop equation over three of them.
    fn ladder(unknowns: usize) -> (usize, Vec<(usize, usize, f64)>) {
        let mut entries = Vec::new();
        let mut equation = unknowns;
        for index in 0..unknowns {
            entries.push((index, index, 2.0 + (index as f64).sin()));
            if index + 1 < unknowns {
                entries.push((index, index + 1, 0.3 * (3.0 * index as f64).cos()));
            }
            if index % 2 == 0 && index + 2 < unknowns {
                let row = [1.0, (index as f64).cos(), -0.7];
                entries.extend((0..3).map(|offset| (equation, index + offset, row[offset])));
                equation += 1;
            }
        }
        (equation, entries)
    }

    fn dense(size: usize, entries: &[(usize, usize, f64)]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(size, size);
        for &(row, column, value) in entries {
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
        }
        matrix
    }

    fn factors(size: usize, unknowns: usize, entries: &[(usize, usize, f64)]) -> Factors {
        let pattern = Pattern::new(size, unknowns, entries.iter().map(|&(row, column, _)| (row, column)));
        let mut factors = Factors::new(pattern, (0..size).collect());
        for &(row, column, value) in entries {
            factors.add(factors.places(row, column), value);
        }
        factors
    }

    #[test]
    fn factors_solve_and_know_the_inverse() {
        let unknowns = 17;
        let (size, entries) = ladder(unknowns);
        let matrix = dense(size, &entries);
        let mut factors = factors(size, unknowns, &entries);
        assert!(factors.factor());
        let expected = DVector::from_fn(size, |row, _| 1.0 / (1.0 + row as f64));
        let mut solution = vec![0.0; size];
        factors.solve((&matrix * &expected).as_slice(), &mut solution);
        assert!((DVector::from_vec(solution) - expected).amax() < 1e-13);
        let inverse = matrix.try_inverse().unwrap();
        for row in unknowns..size {
            assert!((factors.diagonal(row) - inverse[(row, row)]).abs() < 1e-13, "{row}");
        }
    }

    #[test]
    fn work_grows_with_the_entries_only() {
        let work = |unknowns: usize| {
            let (size, entries) = ladder(unknowns);
            let places = entries.iter().map(|&(row, column, _)| (row, column));
            Pattern::new(size, unknowns, places).work().map(|count| count as f64 / unknowns as f64)
        };
        let (few, many) = (work(100), work(3000));
        few.iter().zip(many).for_each(|(few, many)| assert!(many < 1.1 * few, "{few} {many}"));
    }

    /// Bars side by side, each tied to the next one: of so many loops.
    fn row_of_loops(loops: usize) -> Pattern {
        let unknowns = 2 * loops + 1;
        let of_loop = |index: usize| {
            let bars = [index, index + 1, loops + 1 + index];
            let rows = [0, 1].map(|component| unknowns + 2 * index + component);
            rows.into_iter().flat_map(move |row| bars.map(|bar| (row, bar))).chain([(bars[0], bars[2])])
        };
        Pattern::new(unknowns + 2 * loops, unknowns, (0..loops).flat_map(of_loop))
    }

    #[test]
    fn a_row_of_loops_is_eliminated_from_both_ends() {
        let loops = 40;
        let pattern = row_of_loops(loops);
        let mut waits = vec![0; pattern.columns.len()];
        for column in 0..waits.len() {
            let later = waits[column] + 1;
            pattern.rows[pattern.entries(column)]
                .iter()
                .for_each(|&row| waits[row as usize] = later.max(waits[row as usize]));
        }
        // Two loop equations for each loop of a half, after a tie and a bar.
        assert!(waits.iter().all(|wait| *wait <= loops + 4), "{:?}", waits.iter().max());
    }

    #[test]
    fn loop_equations_that_depend_on_each_other_have_none() {
        let twice = [(0, 0, 1.0), (1, 1, 2.0), (2, 0, 1.0), (2, 1, 0.3), (3, 0, -2.0), (3, 1, -0.6)];
        assert!(!factors(4, 2, &twice).factor());
        assert!(!factors(1, 1, &[(0, 0, f64::NAN)]).factor());
    }
}
