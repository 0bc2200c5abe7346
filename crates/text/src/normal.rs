//! Normal form of expressions for printing: sums of products with like terms collected and numbers in front. Products of sums are not expanded.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use cotree::expr::{Binary, Order, Symbol, Unary};

/// A sum of terms with different factors, in the order in which they are written.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sum(pub Vec<Term>);

pub type Factors = Vec<(Factor, i32)>;

/// number x product of factors; each factor once, with its power, in the order in which they are written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Term {
    pub factors: Vec<(Factor, i32)>,
    pub number: Number,
}

#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

/// An irreducible factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Factor {
    /// A symbol; a weight is a parameter with mass in its unit: a mass, an inertia, a force, a stiffness.
    Symbol(Symbol, bool),
    /// A definition; does it depend on parameters only?
    Named(usize, bool),
    /// Cosine (false) or sine (true) of an angle.
    Trigonometric(Sum, bool),
    Call(CalledFunction, Vec<Sum>),
    /// A sum of at least two terms whose first number is positive.
    Sum(Sum),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CalledFunction {
    One(Unary),
    Two(Binary),
    /// if(condition, then, otherwise)
    Select,
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Number {}
impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Number {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Factor {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Factor {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank().cmp(&other.rank()).then_with(|| match (self, other) {
            (Factor::Symbol(a, _), Factor::Symbol(b, _)) => a.cmp(b),
            (Factor::Named(a, _), Factor::Named(b, _)) => a.cmp(b),
            (Factor::Trigonometric(a, x), Factor::Trigonometric(b, y)) => (a, x).cmp(&(b, y)),
            (Factor::Call(f, a), Factor::Call(g, b)) => (f, a).cmp(&(g, b)),
            (Factor::Sum(a), Factor::Sum(b)) => a.cmp(b),
            _ => self.kind().cmp(&other.kind()),
        })
    }
}

impl Factor {
    pub fn is_constant(&self) -> bool {
        match self {
            Factor::Symbol(symbol, _) => symbol.is_constant_between_instants() || matches!(symbol, Symbol::Missing(..)),
            Factor::Named(_, constant) => *constant,
            Factor::Trigonometric(argument, _) => argument.is_constant(),
            Factor::Call(_, arguments) => arguments.iter().all(Sum::is_constant),
            Factor::Sum(sum) => sum.is_constant(),
        }
    }

    /// Parameters first, then signals, then the motion, then trigonometric functions and sums of it.
    fn rank(&self) -> u8 {
        match self {
            Factor::Symbol(symbol, _) => match symbol {
                Symbol::Missing(..) => 0,
                Symbol::Parameter(_) | Symbol::Discrete(_) => 1,
                Symbol::Input(..) => 4,
                Symbol::Time => 5,
                Symbol::Follower(..) | Symbol::State(..) => 6,
                Symbol::Reaction(_) => 7,
                Symbol::Coordinate(_, Order::Position) | Symbol::Argument => 8,
                Symbol::Coordinate(..) => 9,
            },
            Factor::Named(..) if self.is_constant() => 2,
            Factor::Sum(_) | Factor::Call(..) | Factor::Trigonometric(..) if self.is_constant() => 3,
            Factor::Named(..) => 10,
            Factor::Trigonometric(..) => 11,
            Factor::Call(..) => 12,
            Factor::Sum(_) => 13,
        }
    }

    fn kind(&self) -> u8 {
        match self {
            Factor::Symbol(..) => 0,
            Factor::Named(..) => 1,
            Factor::Trigonometric(..) => 2,
            Factor::Call(..) => 3,
            Factor::Sum(_) => 4,
        }
    }

    pub fn leaves(&self) -> usize {
        match self {
            Factor::Symbol(..) | Factor::Named(..) => 1,
            Factor::Trigonometric(argument, _) => argument.leaves().max(1),
            Factor::Call(_, arguments) => 1 + arguments.iter().map(Sum::leaves).sum::<usize>(),
            Factor::Sum(sum) => sum.leaves(),
        }
    }
}

impl Term {
    pub fn number(value: f64) -> Self {
        Term { factors: Vec::new(), number: Number(value) }
    }

    pub fn factor(factor: Factor) -> Self {
        Term { factors: vec![(factor, 1)], number: Number(1.0) }
    }

    pub fn leaves(&self) -> usize {
        self.factors.iter().map(|(factor, _)| factor.leaves()).sum::<usize>().max(1)
    }

    pub fn times(&self, other: &Term) -> Term {
        let mut powers: BTreeMap<Factor, i32> = self.factors.iter().cloned().collect();
        for (factor, power) in &other.factors {
            *powers.entry(factor.clone()).or_default() += power;
        }
        powers.retain(|_, power| *power != 0);
        Term { factors: powers.into_iter().collect(), number: Number(self.number.0 * other.number.0) }
    }

    pub fn inverse(&self) -> Term {
        let factors = self.factors.iter().map(|(factor, power)| (factor.clone(), -power)).collect();
        Term { factors, number: Number(1.0 / self.number.0) }
    }

    pub fn scaled(&self, value: f64) -> Term {
        Term { factors: self.factors.clone(), number: Number(value * self.number.0) }
    }

    /// The factors of parameters and those of the motion.
    pub fn split(&self) -> (Factors, Factors) {
        self.factors.iter().cloned().partition(|(factor, _)| factor.is_constant())
    }

    /// The sum that this is but for a number, if it is one.
    fn only_sum(&self) -> Option<&Sum> {
        match self.factors.as_slice() {
            [(Factor::Sum(sum), 1)] => Some(sum),
            _ => None,
        }
    }
}

impl Sum {
    pub fn of(term: Term) -> Self {
        Sum::collect([term])
    }

    /// Adds up terms with the same factors. A sum within the sum loses its parentheses.
    pub fn collect(terms: impl IntoIterator<Item = Term>) -> Self {
        let mut numbers: BTreeMap<Vec<(Factor, i32)>, f64> = BTreeMap::new();
        for term in terms {
            match term.only_sum() {
                Some(sum) if term.number.0.abs() == 1.0 => {
                    for inner in &sum.0 {
                        add(&mut numbers, inner.scaled(term.number.0));
                    }
                }
                _ => add(&mut numbers, term),
            }
        }
        Sum::sorted(numbers.into_iter().map(|(factors, number)| Term { factors, number: Number(number) }).collect())
    }

    /// The terms in the order in which they are written: short ones first. Their factors differ already.
    pub fn sorted(mut terms: Vec<Term>) -> Self {
        terms.retain(|term| term.number.0 != 0.0);
        terms.sort_by_cached_key(|term| (term.leaves(), term.factors.clone()));
        Sum(terms)
    }

    pub fn scaled(&self, value: f64) -> Sum {
        Sum(self.0.iter().map(|term| term.scaled(value)).collect())
    }

    pub fn is_constant(&self) -> bool {
        self.0.iter().all(|term| term.factors.iter().all(|(factor, _)| factor.is_constant()))
    }

    pub fn leaves(&self) -> usize {
        self.0.iter().map(Term::leaves).sum()
    }

    /// The only symbol or name, if there is nothing else.
    pub fn single(&self) -> Option<&Factor> {
        match self.0.as_slice() {
            [Term { factors, number: Number(1.0) }] => match factors.as_slice() {
                [(factor, 1)] => Some(factor),
                _ => None,
            },
            _ => None,
        }
    }

    /// Multiplies numbers into sums unless the result is longer.
    pub fn expanded(self) -> Sum {
        if !self.0.iter().any(|term| term.only_sum().is_some()) {
            return self;
        }
        let mut terms = Vec::new();
        for term in &self.0 {
            match term.only_sum() {
                Some(sum) => terms.extend(sum.scaled(term.number.0).0),
                None => terms.push(term.clone()),
            }
        }
        let expanded = Sum::collect(terms);
        if expanded.leaves() <= self.leaves() { expanded } else { self }
    }
}

/// Adds a term; a sum below the rounding error of its terms is zero.
fn add(numbers: &mut BTreeMap<Vec<(Factor, i32)>, f64>, term: Term) {
    let entry = numbers.entry(term.factors).or_default();
    let sum = *entry + term.number.0;
    let largest = entry.abs().max(term.number.0.abs());
    *entry = if sum.abs() <= 8.0 * f64::EPSILON * largest { 0.0 } else { sum };
}
