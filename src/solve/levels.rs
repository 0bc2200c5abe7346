//! What follows from accelerations and reactions and acts on them, in the solution of the equations of motion: friction, and loads whose laws read them.
//!
//! With levels s the solution is x = x0 + sum y s: x0 without friction, and y what a level of one adds, both by the same symmetric factors. The levels are laws of x, so there are as many
//! equations in s as there are levels: linear ones where what presses is a sum, a quadratic one for a single vector (a pin), and for several of them Newton's method, which begins where each obeys its own
//! quadratic equation. Where a pivot falls to zero, the mechanism locks itself (Painleve 1895; Pfeiffer and Glocker 1996, section 5.4). The value of a load is such a level by a law of its own.

use crate::equations::{Equations, Feedback, Level, Pressing};
use crate::expr::{Arena, Binary, Expr, Order, Symbol, Unary};

/// Newton's steps for several pins: each squares an error, which begins with what they change in each other's forces.
const STEPS: usize = 4;
/// After them a level is known to this share of all levels, or the mechanism is said to lock itself: some thousand roundings.
const KNOWN: f64 = 1e-12;
/// Vectors shorter than this have no direction.
const LEAST: f64 = 1e-150;

/// The levels of a mechanism, with what they read of the solution and what they add to it.
pub(crate) struct Levels {
    all: Vec<MultiplierLaw>,
    /// What each law reads: sums over the solution.
    sums: Vec<Vec<AffineSum>>,
    /// What a level of one adds to accelerations and multipliers.
    responses: Vec<Vec<Expr>>,
}

/// Whose value a multiplier is.
enum MultiplierLaw {
    /// The level of what rubs at this place in the mechanism.
    Friction(usize, Level),
    Load(LoadLaw),
}

/// The law of a load, with what it reads and its derivatives by that.
struct LoadLaw {
    row: usize,
    value: Expr,
    read: Vec<Symbol>,
    slopes: Vec<Expr>,
}

/// rest + sum of slope x solution.
#[derive(Clone)]
pub(crate) struct AffineSum {
    pub rest: Expr,
    /// By accelerations of coordinates, then multipliers.
    pub slopes: Vec<(usize, Expr)>,
}

/// A solution with its levels.
pub(crate) struct LevelSolution {
    pub values: Vec<Expr>,
    /// All positive, or the mechanism locks itself.
    pub locks: Vec<Expr>,
}

impl Levels {
    /// The levels of a mechanism; `response` gives the change of the solution by loads on the coordinates.
    pub fn new(equations: &mut Equations, mut response: impl FnMut(&mut Arena, &[Expr]) -> Vec<Expr>) -> Self {
        let mut all: Vec<MultiplierLaw> =
            equations.levels().into_iter().map(|(place, level)| MultiplierLaw::Friction(place, level)).collect();
        for load in equations.feedback() {
            all.push(MultiplierLaw::Load(LoadLaw::new(&mut equations.system.arena, &load)));
        }
        let coordinates = equations.coordinates.len();
        let read: Vec<Vec<Expr>> = all.iter().map(|law| law.reads(&mut equations.system.arena)).collect();
        let mut sums = solved_sums(&mut equations.system.arena, &read.concat(), coordinates).into_iter();
        let sums = read.iter().map(|terms| sums.by_ref().take(terms.len()).collect()).collect();
        let responses = all.iter().map(|law| {
            let column = column_of(equations, law.row());
            let mut response = response(&mut equations.system.arena, &column);
            response[coordinates + law.row()] = Expr::ONE;
            response
        });
        let responses = responses.collect();
        Self { all, sums, responses }
    }

    /// What presses where signs decide: each sign's place among those of its level, and the sum.
    pub fn signed(&self) -> impl Iterator<Item = (usize, &[(Expr, Expr)])> {
        self.all.iter().filter_map(|law| match law {
            MultiplierLaw::Friction(place, Level { pressing: Pressing::Sum(signed), .. }) => {
                Some((*place, &signed[..]))
            }
            MultiplierLaw::Friction(_, Level { pressing: Pressing::Sizes(_), .. }) | MultiplierLaw::Load(_) => None,
        })
    }

    /// True if nothing follows from the solution.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The solution with friction from that without. In an impact only what follows from impulses counts.
    pub fn solve(&self, arena: &mut Arena, without: Vec<Expr>, impact: bool) -> LevelSolution {
        if self.all.is_empty() {
            return LevelSolution { values: without, locks: Vec::new() };
        }
        let (at_rest, changes) = self.read(arena, &without, impact);
        let (sizes, locks) = self.sizes(arena, impact, &at_rest, &changes);
        let mut values = without;
        for (size, response) in sizes.iter().zip(&self.responses) {
            for (value, &change) in values.iter_mut().zip(response) {
                *value = arena.add_product(*value, change, *size);
            }
        }
        LevelSolution { values, locks }
    }

    /// What each law reads without them, and what each level changes in it.
    fn read(&self, arena: &mut Arena, without: &[Expr], impact: bool) -> (Vec<Vec<Expr>>, Vec<Vec<Vec<Expr>>>) {
        let mut at = |sum: &AffineSum, solution: &[Expr], rest: Expr| {
            sum.slopes.iter().fold(rest, |total, &(index, slope)| arena.add_product(total, slope, solution[index]))
        };
        let rest = |sum: &AffineSum| if impact { Expr::ZERO } else { sum.rest };
        let at_rest = self
            .sums
            .iter()
            .map(|contact_sums| contact_sums.iter().map(|sum| at(sum, without, rest(sum))).collect())
            .collect();
        let changes = self.sums.iter().map(|contact_sums| {
            let of = |sum: &AffineSum| self.responses.iter().map(|response| at(sum, response, Expr::ZERO)).collect();
            contact_sums.iter().map(of).collect()
        });
        let changes = changes.collect();
        (at_rest, changes)
    }

    /// The levels, and what must be positive.
    fn sizes(
        &self,
        arena: &mut Arena,
        impact: bool,
        at_rest: &[Vec<Expr>],
        changes: &[Vec<Vec<Expr>>],
    ) -> (Vec<Expr>, Vec<Expr>) {
        let laws = |arena: &mut Arena, sizes: &[Expr]| -> Vec<(Expr, Vec<Expr>)> {
            let of = |(index, law): (usize, &MultiplierLaw)| {
                let sums = at_rest[index].iter().zip(&changes[index]).map(|(&rest, change)| {
                    change.iter().zip(sizes).fold(rest, |sum, (&change, &size)| arena.add_product(sum, change, size))
                });
                let sums: Vec<Expr> = sums.collect();
                law.at(arena, impact, &sums, (&changes[index], self.all.len()))
            };
            self.all.iter().enumerate().map(of).collect()
        };
        let zeros = vec![Expr::ZERO; self.all.len()];
        let mut sizes: Vec<Expr> = laws(arena, &zeros).into_iter().map(|(value, _)| value).collect();
        for index in 0..sizes.len() {
            let Some(pin) = self.all[index].pin(impact) else { continue };
            let components = [0, 1].map(|component| {
                let change = &changes[index][component];
                let others = change.iter().zip(&sizes).enumerate().filter(|(other, _)| *other != index);
                let rest = others
                    .fold(at_rest[index][component], |sum, (_, (&change, &size))| arena.add_product(sum, change, size));
                [rest, change[index]]
            });
            let (size, lock) = pin.solve(arena, components);
            if sizes.len() == 1 {
                return (vec![size], vec![lock]);
            }
            sizes[index] = size;
        }
        let is_linear = self.all.iter().all(|law| law.is_linear(arena));
        let mut locks = Vec::new();
        for _ in 0..if is_linear { 1 } else { STEPS } {
            let values = laws(arena, &sizes);
            let mut matrix = Vec::new();
            let mut right = Vec::new();
            for (index, (value, slopes)) in values.into_iter().enumerate() {
                let entry = |(other, slope): (usize, Expr)| {
                    arena.subtract(if other == index { Expr::ONE } else { Expr::ZERO }, slope)
                };
                matrix.push(slopes.into_iter().enumerate().map(entry).collect::<Vec<Expr>>());
                right.push(arena.subtract(value, sizes[index]));
            }
            let (steps, pivots) = eliminate(arena, matrix, right);
            sizes = sizes.iter().zip(steps).map(|(&size, step)| arena.add(size, step)).collect();
            locks = pivots;
        }
        if !is_linear {
            let values = laws(arena, &sizes);
            locks.push(converged(arena, &sizes, &values));
        } else if self.all.iter().all(|law| matches!(law, MultiplierLaw::Load(_))) {
            // Linear equations have one solution, whatever the signs.
            locks.clear();
        }
        (sizes, locks)
    }
}

impl MultiplierLaw {
    fn row(&self) -> usize {
        match self {
            MultiplierLaw::Friction(_, level) => level.row,
            MultiplierLaw::Load(load) => load.row,
        }
    }

    /// The law of a single vector of two components.
    fn pin(&self, impact: bool) -> Option<PinLaw> {
        match self {
            MultiplierLaw::Friction(_, Level { pressing: Pressing::Sizes(vectors), free, share, .. }) if matches!(&vectors[..], [vector] if vector.len() == 2) => {
                Some(PinLaw { free: if impact { Expr::ZERO } else { *free }, share: *share })
            }
            MultiplierLaw::Friction(..) | MultiplierLaw::Load(_) => None,
        }
    }

    fn reads(&self, arena: &mut Arena) -> Vec<Expr> {
        match self {
            MultiplierLaw::Friction(_, level) => level.pressing.sums(),
            MultiplierLaw::Load(load) => load.read.iter().map(|&symbol| arena.symbol(symbol)).collect(),
        }
    }

    /// True if it is linear in what it reads.
    fn is_linear(&self, arena: &Arena) -> bool {
        match self {
            MultiplierLaw::Friction(_, level) => matches!(level.pressing, Pressing::Sum(_)),
            MultiplierLaw::Load(load) => !arena.symbols(load.slopes.iter().copied()).into_iter().any(Symbol::is_solved),
        }
    }

    /// Its value where what it reads is this, and its slopes by so many levels, which change that like this. What does not follow from impulses has no part in an impact.
    fn at(
        &self,
        arena: &mut Arena,
        impact: bool,
        sums: &[Expr],
        (changes, count): (&[Vec<Expr>], usize),
    ) -> (Expr, Vec<Expr>) {
        let (share, (read, factors)) = match self {
            MultiplierLaw::Friction(_, level) => (level.share, level.pressing.at(arena, sums)),
            MultiplierLaw::Load(load) => (Expr::ONE, load.at(arena, sums)),
        };
        let slope = |level: usize| {
            let products = factors.iter().zip(changes);
            let slope =
                products.fold(Expr::ZERO, |total, (&factor, change)| arena.add_product(total, factor, change[level]));
            arena.multiply(share, slope)
        };
        let slopes = (0..count).map(slope).collect();
        let free = match self {
            MultiplierLaw::Friction(_, level) if !impact => level.free,
            MultiplierLaw::Friction(..) | MultiplierLaw::Load(_) => Expr::ZERO,
        };
        (arena.add_product(free, share, read), slopes)
    }
}

/// The law of one pin by itself: s = free + share |w0 + y s|.
struct PinLaw {
    free: Expr,
    share: Expr,
}

impl PinLaw {
    /// The level, and what is positive if there is one with a positive slope of s - share |w0 + y s|; given are w0 and y of both components.
    ///
    /// With u = (s - free) / share and w = w0 + y free, u^2 = |w + share y u|^2. As that slope falls from a positive value at u = 0, the least root is the one: (share B + root) / D if B = w y is not negative,
    /// else the same without cancellation, A / (root - share B), where A = w w, D = 1 - share^2 y y, root^2 = share^2 B^2 + D A.
    fn solve(&self, arena: &mut Arena, components: [[Expr; 2]; 2]) -> (Expr, Expr) {
        let [mut a, mut b, mut c] = [Expr::ZERO; 3];
        for [rest, change] in components {
            let w = arena.add_product(rest, change, self.free);
            a = arena.add_product(a, w, w);
            b = arena.add_product(b, w, change);
            c = arena.add_product(c, change, change);
        }
        let along = arena.multiply(self.share, b);
        let square = arena.square(self.share);
        let left = arena.subtract_product(Expr::ONE, square, c);
        let of_along = arena.square(along);
        let under = arena.add_product(of_along, left, a);
        let under_or_none = arena.binary(Binary::Max, under, Expr::ZERO);
        let root = arena.unary(Unary::Sqrt, under_or_none);
        let rising = arena.add(along, root);
        let rising = arena.divide(rising, left);
        let apart = arena.subtract(root, along);
        let falling = arena.divide(a, apart);
        let falls = arena.binary(Binary::Less, b, Expr::ZERO);
        let size = arena.select(falls, falling, rising);
        let either = arena.binary(Binary::Max, left, under);
        let lock = arena.select(falls, either, left);
        (arena.add_product(self.free, self.share, size), lock)
    }
}

impl Pressing {
    /// What presses where its sums are these, and its derivatives by them.
    fn at(&self, arena: &mut Arena, sums: &[Expr]) -> (Expr, Vec<Expr>) {
        match self {
            Pressing::Sum(signed) => {
                let factors: Vec<Expr> = signed.iter().map(|(sign, _)| *sign).collect();
                let products = factors.iter().zip(sums);
                let pressing = products.fold(Expr::ZERO, |total, (&sign, &sum)| arena.add_product(total, sign, sum));
                (pressing, factors)
            }
            Pressing::Sizes(vectors) => {
                let (mut total, mut factors, mut rest) = (Expr::ZERO, Vec::new(), sums);
                for vector in vectors {
                    let (components, others) = rest.split_at(vector.len());
                    let (size, along) = direction_of(arena, components);
                    total = arena.add(total, size);
                    factors.extend(along);
                    rest = others;
                }
                (total, factors)
            }
        }
    }
}

impl LoadLaw {
    fn new(arena: &mut Arena, load: &Feedback) -> Self {
        let read: Vec<Symbol> = arena.symbols([load.value]).into_iter().filter(|symbol| symbol.is_solved()).collect();
        let slopes = read.iter().map(|&symbol| arena.derivative(load.value, symbol)).collect();
        Self { row: load.row, value: load.value, read, slopes }
    }

    /// Its value where what it reads is this, and its derivatives by it.
    fn at(&self, arena: &mut Arena, read: &[Expr]) -> (Expr, Vec<Expr>) {
        let mut with = |law: Expr| {
            let known = self.read.iter().zip(read);
            known.fold(law, |law, (&symbol, &value)| arena.substituted(law, symbol, value))
        };
        let slopes = self.slopes.iter().map(|&slope| with(slope)).collect();
        (with(self.value), slopes)
    }
}

/// The size of a vector, and its direction.
fn direction_of(arena: &mut Arena, vector: &[Expr]) -> (Expr, Vec<Expr>) {
    let size = match vector {
        [sum] => arena.unary(Unary::Abs, *sum),
        _ => {
            let squares: Vec<Expr> = vector.iter().map(|&sum| arena.square(sum)).collect();
            let square = arena.sum(squares);
            arena.unary(Unary::Sqrt, square)
        }
    };
    let least = arena.constant(LEAST);
    let divisor = arena.binary(Binary::Max, size, least);
    (size, vector.iter().map(|&sum| arena.divide(sum, divisor)).collect())
}

/// Sums over accelerations and multipliers as such.
pub(crate) fn solved_sums(arena: &mut Arena, sums: &[Expr], coordinates: usize) -> Vec<AffineSum> {
    let symbols = arena.symbols(sums.iter().copied()).into_iter().filter(|symbol| symbol.is_solved());
    let symbols: Vec<Symbol> = symbols.collect();
    let rests = arena.without(sums, Symbol::is_solved);
    let mut found: Vec<AffineSum> = rests.into_iter().map(|rest| AffineSum { rest, slopes: Vec::new() }).collect();
    for symbol in symbols {
        let index = match symbol {
            Symbol::Coordinate(index, Order::Acceleration) => index,
            Symbol::Reaction(row) => coordinates + row,
            // No reaction follows from the rate of a state.
            _ => continue,
        };
        let slopes = arena.derivatives(sums, symbol);
        for (sum, slope) in found.iter_mut().zip(slopes).filter(|(_, slope)| *slope != Expr::ZERO) {
            sum.slopes.push((index, slope));
        }
    }
    found
}

/// What a multiplier of one adds to the loads of the coordinates.
fn column_of(equations: &mut Equations, row: usize) -> Vec<Expr> {
    let reactions = equations.dynamics().reactions.clone();
    let arena = &mut equations.system.arena;
    let entry = |entries: &Vec<(usize, Expr)>| {
        let entry = entries.iter().find(|(index, _)| *index == row);
        entry.map_or(Expr::ZERO, |&(_, entry)| arena.negate(entry))
    };
    reactions.iter().map(entry).collect()
}

/// Gauss's elimination in the given order: the solution and the pivots. The matrix is that of one minus a small part, so that its pivots are positive unless the mechanism locks itself.
fn eliminate(arena: &mut Arena, mut matrix: Vec<Vec<Expr>>, mut right: Vec<Expr>) -> (Vec<Expr>, Vec<Expr>) {
    let size = right.len();
    for pivot in 0..size {
        for row in pivot + 1..size {
            let factor = arena.divide(matrix[row][pivot], matrix[pivot][pivot]);
            for column in pivot + 1..size {
                matrix[row][column] = arena.subtract_product(matrix[row][column], factor, matrix[pivot][column]);
            }
            right[row] = arena.subtract_product(right[row], factor, right[pivot]);
        }
    }
    let pivots = (0..size).map(|index| matrix[index][index]).collect();
    for row in (0..size).rev() {
        let rest = (row + 1..size)
            .fold(right[row], |rest, column| arena.subtract_product(rest, matrix[row][column], right[column]));
        right[row] = arena.divide(rest, matrix[row][row]);
    }
    (right, pivots)
}

/// Positive if the levels are what their laws give.
fn converged(arena: &mut Arena, sizes: &[Expr], laws: &[(Expr, Vec<Expr>)]) -> Expr {
    let least = arena.constant(LEAST);
    let mut margin = least;
    let known = arena.constant(KNOWN);
    for (&size, (law, _)) in sizes.iter().zip(laws) {
        let off = arena.subtract(size, *law);
        let (off, size) = (arena.unary(Unary::Abs, off), arena.unary(Unary::Abs, size));
        margin = arena.add_product(margin, known, size);
        margin = arena.subtract(margin, off);
    }
    margin
}
