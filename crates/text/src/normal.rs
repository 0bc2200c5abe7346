//! Normal form of expressions for printing: sums of products with like terms collected and numbers in front. Products of sums are not expanded.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use cotree::expr::{Binary, Order, Symbol, Unary};

/// A sum of terms with different factors, in the order in which they are written.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sum(pub Vec<ProductTerm>);

pub type Factors = Vec<(TermFactor, i32)>;

/// number x product of factors; each factor once, with its power, in the order in which they are written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ProductTerm {
    pub factors: Vec<(TermFactor, i32)>,
    pub number: Number,
}

#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

/// An irreducible factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TermFactor {
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

impl PartialOrd for TermFactor {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for TermFactor {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank().cmp(&other.rank()).then_with(|| match (self, other) {
            (TermFactor::Symbol(a, _), TermFactor::Symbol(b, _)) => a.cmp(b),
            (TermFactor::Named(a, _), TermFactor::Named(b, _)) => a.cmp(b),
            (TermFactor::Trigonometric(a, x), TermFactor::Trigonometric(b, y)) => (a, x).cmp(&(b, y)),
            (TermFactor::Call(f, a), TermFactor::Call(g, b)) => (f, a).cmp(&(g, b)),
            (TermFactor::Sum(a), TermFactor::Sum(b)) => a.cmp(b),
            _ => self.kind().cmp(&other.kind()),
        })
    }
}

impl TermFactor {
    pub fn is_constant(&self) -> bool {
        match self {
            TermFactor::Symbol(symbol, _) => {
                symbol.is_constant_between_instants() || matches!(symbol, Symbol::Missing(..))
            }
            TermFactor::Named(_, constant) => *constant,
            TermFactor::Trigonometric(argument, _) => argument.is_constant(),
            TermFactor::Call(_, arguments) => arguments.iter().all(Sum::is_constant),
            TermFactor::Sum(sum) => sum.is_constant(),
        }
    }

    /// Parameters first, then signals, then the motion, then trigonometric functions and sums of it.
    fn rank(&self) -> u8 {
        match self {
            TermFactor::Symbol(symbol, _) => match symbol {
                Symbol::Missing(..) => 0,
                Symbol::Parameter(_) | Symbol::Discrete(_) => 1,
                Symbol::Input(..) => 4,
                Symbol::Time => 5,
                Symbol::Follower(..) | Symbol::State(..) => 6,
                Symbol::Reaction(_) => 7,
                Symbol::Coordinate(_, Order::Position) | Symbol::Argument => 8,
                Symbol::Coordinate(..) => 9,
            },
            TermFactor::Named(..) if self.is_constant() => 2,
            TermFactor::Sum(_) | TermFactor::Call(..) | TermFactor::Trigonometric(..) if self.is_constant() => 3,
            TermFactor::Named(..) => 10,
            TermFactor::Trigonometric(..) => 11,
            TermFactor::Call(..) => 12,
            TermFactor::Sum(_) => 13,
        }
    }

    fn kind(&self) -> u8 {
        match self {
            TermFactor::Symbol(..) => 0,
            TermFactor::Named(..) => 1,
            TermFactor::Trigonometric(..) => 2,
            TermFactor::Call(..) => 3,
            TermFactor::Sum(_) => 4,
        }
    }

    pub fn leaves(&self) -> usize {
        match self {
            TermFactor::Symbol(..) | TermFactor::Named(..) => 1,
            TermFactor::Trigonometric(argument, _) => argument.leaves().max(1),
            TermFactor::Call(_, arguments) => 1 + arguments.iter().map(Sum::leaves).sum::<usize>(),
            TermFactor::Sum(sum) => sum.leaves(),
        }
    }
}

impl ProductTerm {
    pub fn number(value: f64) -> Self {
        ProductTerm { factors: Vec::new(), number: Number(value) }
    }

    pub fn factor(factor: TermFactor) -> Self {
        ProductTerm { factors: vec![(factor, 1)], number: Number(1.0) }
    }

    pub fn leaves(&self) -> usize {
        self.factors.iter().map(|(factor, _)| factor.leaves()).sum::<usize>().max(1)
    }

    pub fn times(&self, other: &ProductTerm) -> ProductTerm {
        let mut powers: BTreeMap<TermFactor, i32> = self.factors.iter().cloned().collect();
        for (factor, power) in &other.factors {
            *powers.entry(factor.clone()).or_default() += power;
        }
        powers.retain(|_, power| *power != 0);
        ProductTerm { factors: powers.into_iter().collect(), number: Number(self.number.0 * other.number.0) }
    }

    pub fn inverse(&self) -> ProductTerm {
        let factors = self.factors.iter().map(|(factor, power)| (factor.clone(), -power)).collect();
        ProductTerm { factors, number: Number(1.0 / self.number.0) }
    }

    pub fn scaled(&self, value: f64) -> ProductTerm {
        ProductTerm { factors: self.factors.clone(), number: Number(value * self.number.0) }
    }

    /// The factors of parameters and those of the motion.
    pub fn split(&self) -> (Factors, Factors) {
        self.factors.iter().cloned().partition(|(factor, _)| factor.is_constant())
    }

    /// The sum that this is but for a number, if it is one.
    fn only_sum(&self) -> Option<&Sum> {
        match self.factors.as_slice() {
            [(TermFactor::Sum(sum), 1)] => Some(sum),
            _ => None,
        }
    }
}

impl Sum {
    pub fn of(term: ProductTerm) -> Self {
        Sum::collect([term])
    }

    /// Adds up terms with the same factors. A sum within the sum loses its parentheses.
    pub fn collect(terms: impl IntoIterator<Item = ProductTerm>) -> Self {
        let mut numbers: BTreeMap<Vec<(TermFactor, i32)>, f64> = BTreeMap::new();
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
        Sum::sorted(
            numbers.into_iter().map(|(factors, number)| ProductTerm { factors, number: Number(number) }).collect(),
        )
    }

    /// The terms in the order in which they are written: short ones first. Their factors differ already.
    pub fn sorted(mut terms: Vec<ProductTerm>) -> Self {
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
        self.0.iter().map(ProductTerm::leaves).sum()
    }

    /// The only symbol or name, if there is nothing else.
    pub fn single(&self) -> Option<&TermFactor> {
        match self.0.as_slice() {
            [ProductTerm { factors, number: Number(1.0) }] => match factors.as_slice() {
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
fn add(numbers: &mut BTreeMap<Vec<(TermFactor, i32)>, f64>, term: ProductTerm) {
    let entry = numbers.entry(term.factors).or_default();
    let sum = *entry + term.number.0;
    let largest = entry.abs().max(term.number.0.abs());
    *entry = if sum.abs() <= 8.0 * f64::EPSILON * largest { 0.0 } else { sum };
}
