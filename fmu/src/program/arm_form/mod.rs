//! The arm form of a mechanism, as data: what is needed to find the Taylor series of a motion.
//!
//! Every position is a constant combination of *arms*: products b = sigma e of a scalar (1, a displacement, a signal of time) and
//! the unit vector e = (cos, sin) of a turning frame (or of the world). The unknowns are the frames' own angles and the
//! displacements, whatever the trees are; the trees say what the coordinates q are. Vectors are complex numbers: an arm z b turns and stretches b
//! by the constant z.
//!
//! Coefficients are named by their place among the results of [`ArmForm::coefficients`], so that they follow the parameters.

mod check;

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Steep;
use crate::tape::Tape;

/// The highest order of the series of positions.
pub const MAX_ORDER: usize = 28;
/// Coefficients of a series.
pub(crate) const ORDERS: usize = MAX_ORDER + 1;
/// Most switching functions of a model: a set of them is one word.
pub const MAX_SWITCHES: usize = 64;

/// Place of a coefficient among the results of [`ArmForm::coefficients`].
pub type Coefficient = u32;
/// Place of a scalar series in [`SeriesTape`].
pub type Slot = u32;

/// One mechanism in arm form. Arms are numbered: one for each frame first, then [`ArmForm::products`], then [`ArmForm::world`]. So are the
/// unknowns: the angle of a frame, the displacement of a product or of a world arm, if they have one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmForm {
    /// The unit of masses and forces [kg], [N]: what accelerations and reactions are found from is well scaled whatever the mechanism's size is.
    pub unit_of_mass: f64,
    /// What each coordinate is made of.
    pub coordinates: Vec<CoordinatePlace>,
    /// Displacements that are no coordinates.
    pub auxiliary: Vec<Auxiliary>,
    /// Frames whose angles are no coordinates.
    pub rods: Vec<Rod>,
    /// Turning frames; their arms are their unit vectors.
    pub frames: Vec<Frame>,
    /// Arms of changing length in turning frames.
    pub products: Vec<Product>,
    /// Arms of changing length along the world's X axis.
    pub world: Vec<Factor>,
    /// Masses: the force on arm k is sum A_kl b_l''.
    pub coupling: Vec<MassCoupling>,
    /// The same of many arms that hang from each other without a loop: instead of the masses of every two, all arms as a tree, each after the one that it
    /// hangs from.
    pub links: Vec<Link>,
    /// Loop equations.
    pub rows: Vec<LoopEquation>,
    /// Loop equations that do not always hold.
    pub contacts: Vec<ContactRow>,
    /// Loads along arms.
    pub loads: Vec<Load>,
    /// Loads on unknowns.
    pub pushes: Vec<Push>,
    /// Scalar series: signals of time and the laws of loads.
    pub tape: SeriesTape,
    /// Yields the coefficients from the parameters, without an instruction: they are results of the parameter stage.
    pub coefficients: Tape,
}

/// Where a coordinate is found among the unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CoordinatePlace {
    /// q = +-(angle of `arm` - angle of `parent`), without the frames' signals.
    Angle {
        /// The frame that the coordinate turns.
        arm: u32,
        /// The frame that it turns it from; the world if there is none.
        parent: Option<u32>,
        /// The sign is minus.
        reversed: bool,
    },
    /// The displacement of an arm.
    Displacement {
        /// The arm.
        arm: u32,
    },
}

/// The displacement of a gap across a held direction: s = -(direction e) . (X, Y), where X and Y are the values of two rows without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Auxiliary {
    /// The product whose displacement it is.
    pub arm: u32,
    /// The row of X; that of Y is the next one.
    pub row: u32,
    /// Components of the direction in the arm's frame.
    pub direction: [Coefficient; 2],
}

/// A frame that turns with a massless rod between two points: length e = (X, Y), the values of two rows without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rod {
    /// The frame.
    pub frame: u32,
    /// The row of X; that of Y is the next one.
    pub row: u32,
    /// The length.
    pub length: Coefficient,
}

/// A turning frame: its angle is an unknown, a signal of time, or their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    /// The frame whose angle is the unknown: this one or an earlier one; none if the signal is all.
    pub unknown: Option<u32>,
    /// The signal.
    pub signal: Option<Slot>,
    /// What resists its angular acceleration: inertia of the bodies that turn with it, and of the masses on its arm.
    pub inertia: Coefficient,
}

/// sigma e of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Product {
    /// sigma
    pub factor: Factor,
    /// e
    pub frame: u32,
}

/// A changing length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Factor {
    /// The unknown that bears the arm's number.
    Unknown,
    /// A signal of time.
    Signal(Slot),
}

/// One entry A_kl of the matrix of masses between arms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MassCoupling {
    /// k
    pub on: u32,
    /// l
    pub from: u32,
    /// Real and imaginary part.
    pub mass: [Coefficient; 2],
}

/// An arm of a tree. Masses between an arm k and an arm l further out are A_kl = conj(z) m, where z is the place along k where the way to l goes on, and m what
/// l carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Link {
    /// The arm.
    pub arm: u32,
    /// Its parent, by its place among the links.
    pub parent: Option<u32>,
    /// Where it begins along the arm of that one.
    pub begin: [Coefficient; 2],
    /// The first moment of all masses that move with it, along its arm.
    pub carried: [Coefficient; 2],
    /// What resists its acceleration by itself: the inertia of a frame, or the mass on a line.
    pub inertia: Coefficient,
}

/// A loop equation: the sum of its terms is zero.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopEquation {
    /// The loop equation of the program that it belongs to.
    pub constraint: u32,
    /// It repeats others: in each pose as many rows count as there are without those that do.
    pub repeats: bool,
    /// (arm, p): p . b
    pub arms: Vec<(u32, [Coefficient; 2])>,
    /// (unknown, c): c times the unknown.
    pub unknowns: Vec<(u32, Coefficient)>,
    /// (slot, c): c times a signal, or a function of unknowns whose slopes are [`Cause::Reaction`].
    pub signals: Vec<(Slot, Coefficient)>,
    /// Constant term.
    pub constant: Coefficient,
}

/// A loop equation that holds while a contact is closed, or a friction sticks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactRow {
    /// The loop equation.
    pub row: u32,
    /// What stands on the diagonal of its reaction: 0 while it is closed, else -1.
    pub open: Coefficient,
    /// The friction there.
    pub friction: Option<Friction>,
}

/// A friction limit s = free + share x normal force, and the force on what slides: a load for each unit of the limit. Its series is found together with the accelerations and reactions of each
/// order, from which the normal force follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// The row of the program whose multiplier the limit is.
    pub constraint: u32,
    /// (arm, world components of the force for each unit of the limit); zero while it sticks.
    pub arms: Vec<(u32, [Coefficient; 2])>,
    /// (unknown, generalised force for each unit of the limit)
    pub unknowns: Vec<(u32, Coefficient)>,
    /// The part that does not follow from reactions.
    pub free: Slope,
    /// The coefficient of friction, or its product with a radius.
    pub share: Slope,
    /// The normal force is the sum of these.
    pub normal: Vec<NormalForce>,
}

/// Part of a normal force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum NormalForce {
    /// A sum times its sign, which events keep.
    Signed(Coefficient, SolvedSum),
    /// The magnitude of a vector of one component or two.
    Magnitude(Vec<SolvedSum>),
}

/// An affine function of accelerations, reactions and friction limits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolvedSum {
    /// Its value without them, a series.
    pub rest: Slot,
    /// Its derivatives by them.
    pub terms: Vec<(Solved, Slope)>,
}

/// What is solved for at each order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Solved {
    /// The second derivative of an unknown.
    Unknown(u32),
    /// The second derivative of the x component of the unit vector of a frame whose angle is an unknown.
    X(u32),
    /// The second derivative of its y component.
    Y(u32),
    /// The reaction of a loop equation, in the unit of mass.
    Row(u32),
    /// The friction limit of one of the contacts.
    Limit(u32),
}

/// A factor, or a derivative of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Slope {
    /// It follows from the parameters.
    Constant(Coefficient),
    /// It changes with the motion.
    Series(Slot),
}

/// Part of the force on an arm, as seen from the arm's frame of constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Load {
    /// The arm.
    pub arm: u32,
    /// A series, or 1.
    pub value: Option<Slot>,
    /// World components for each unit of the value.
    pub along: [Coefficient; 2],
}

/// Part of the generalised force on an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Push {
    /// The unknown.
    pub unknown: u32,
    /// What it is a multiple of.
    pub value: Cause,
    /// Its factor.
    pub factor: Coefficient,
}

/// What a generalised force is a multiple of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// 1
    One,
    /// A series.
    Series(Slot),
    /// Minus the reaction of a loop equation, times the series by which that changes with the unknown: one of its signals is a function of unknowns, and this is
    /// its slope.
    Reaction {
        /// The loop equation.
        row: u32,
        /// The slope, a series of positions.
        slope: Slot,
    },
}

/// A straight-line program over scalar series, run order by order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeriesTape {
    /// Number of series.
    pub slots: u32,
    /// Series that are given.
    pub given: Vec<(Slot, Given)>,
    /// Depends on given series only.
    pub signals: Vec<SeriesStep>,
    /// Depends on positions too.
    pub positions: Vec<SeriesStep>,
    /// Depends on rates too.
    pub rates: Vec<SeriesStep>,
    /// Terms of the linear steps.
    pub terms: Vec<Term>,
    /// Switching functions: series whose signs choose between others, at most [`MAX_SWITCHES`].
    pub switches: Vec<Slot>,
}

impl ArmForm {
    /// Coordinates, what carries an angle before what it carries.
    pub(crate) fn chain(&self) -> Vec<usize> {
        let mut known = vec![false; self.frames.len()];
        let mut rest: Vec<usize> = (0..self.coordinates.len()).collect();
        let mut chain = Vec::new();
        while !rest.is_empty() {
            let before = rest.len();
            rest.retain(|&index| {
                let ready = match self.coordinates[index] {
                    CoordinatePlace::Angle { parent: Some(parent), .. } => known[parent as usize],
                    _ => true,
                };
                if let (true, CoordinatePlace::Angle { arm, .. }) = (ready, self.coordinates[index]) {
                    known[arm as usize] = true;
                }
                if ready {
                    chain.push(index);
                }
                !ready
            });
            if rest.len() == before {
                break;
            }
        }
        chain
    }

    /// How many rows repeat others.
    pub fn repeating(&self) -> usize {
        self.rows.iter().filter(|row| row.repeats).count()
    }
}

impl SeriesTape {
    /// How laws are steep, and their arguments, each once. (Steps end where switching functions change sign.) An exponential in a divisor saturates:
    /// 1/(1 + exp a) is constant but for a layer about a = 0, as tanh is. A divisor without exponentials may nearly vanish, that of 1 + a^2 and
    /// of 1 + a^4 where a does: the least value of a square is not as well known.
    pub fn steep_laws(&self) -> Vec<(Steep, Slot)> {
        let (divides, algebraic, is_root) = (self.divisors(), self.algebraic(), self.roots());
        let laws = |step: &SeriesStep| match step.operation {
            SeriesOperation::HyperbolicTangent(a, _) => [Some((Steep::Saturating, a)), None],
            SeriesOperation::Exponential(a) => {
                [Some((Steep::Growing, a)), divides[step.target as usize].then_some((Steep::Saturating, a))]
            }
            SeriesOperation::Divide(_, a) if !is_root[a as usize] => [Some((Steep::Vanishing, a)), None],
            SeriesOperation::Multiply(a, b) if a == b && divides[step.target as usize] => {
                [Some((Steep::Vanishing, a)), None]
            }
            SeriesOperation::SquareRoot(a)
            | SeriesOperation::Power(a, _)
            | SeriesOperation::Logarithm(a)
            | SeriesOperation::ArcTangent(_, _, a) => [Some((Steep::Vanishing, a)), None],
            _ => [None; 2],
        };
        let found = self.steps().flat_map(laws).flatten();
        let found: BTreeSet<_> = found.filter(|&(kind, a)| kind != Steep::Vanishing || algebraic[a as usize]).collect();
        found.into_iter().collect()
    }

    /// Which series are roots: they are small where their arguments are.
    fn roots(&self) -> Vec<bool> {
        let mut roots = vec![false; self.slots as usize];
        for step in self.steps() {
            roots[step.target as usize] = matches!(step.operation, SeriesOperation::SquareRoot(_));
        }
        roots
    }

    /// Which series are found without exponentials.
    fn algebraic(&self) -> Vec<bool> {
        let mut algebraic = vec![true; self.slots as usize];
        for step in self.steps() {
            let transcendent =
                matches!(step.operation, SeriesOperation::Exponential(_) | SeriesOperation::HyperbolicTangent(..));
            algebraic[step.target as usize] = !transcendent && self.operands(step).all(|slot| algebraic[slot as usize]);
        }
        algebraic
    }

    pub(crate) fn steps(&self) -> impl DoubleEndedIterator<Item = &SeriesStep> {
        self.signals.iter().chain(&self.positions).chain(&self.rates)
    }

    /// On which series something depends that is divided by, or raised to a power, or whose root or logarithm is taken.
    fn divisors(&self) -> Vec<bool> {
        let mut divides = vec![false; self.slots as usize];
        for step in self.steps().rev() {
            let divisor = match step.operation {
                SeriesOperation::Divide(_, a) | SeriesOperation::Power(a, _) => Some(a),
                SeriesOperation::SquareRoot(a) | SeriesOperation::Logarithm(a) => Some(a),
                _ => None,
            };
            divisor.into_iter().for_each(|slot| divides[slot as usize] = true);
            if divides[step.target as usize] {
                self.operands(step).for_each(|slot| divides[slot as usize] = true);
            }
        }
        divides
    }

    /// Visits every series that a step reads.
    pub fn each_read(&self, step: &SeriesStep, mut visit: impl FnMut(Slot)) {
        let slots = match step.operation {
            SeriesOperation::Linear { first, count, .. } => {
                for term in &self.terms[first as usize..][..count as usize] {
                    if let Source::Slot(slot) = term.source {
                        visit(slot);
                    }
                }
                [None; 4]
            }
            SeriesOperation::Multiply(a, b) | SeriesOperation::SquareSum(a, b) | SeriesOperation::Divide(a, b) => {
                [Some(a), Some(b), None, None]
            }
            SeriesOperation::ArcTangent(y, x, square) => [Some(y), Some(x), Some(square), None],
            SeriesOperation::Choose { switch, above, equal, below } => {
                [self.switches[switch as usize], above, equal, below].map(Some)
            }
            SeriesOperation::Power(a, _)
            | SeriesOperation::SquareRoot(a)
            | SeriesOperation::SineCosine(a, _)
            | SeriesOperation::Exponential(a)
            | SeriesOperation::Logarithm(a)
            | SeriesOperation::HyperbolicTangent(a, _)
            | SeriesOperation::Rate(a)
            | SeriesOperation::Floor { argument: a, .. } => [Some(a), None, None, None],
        };
        slots.into_iter().flatten().for_each(visit);
    }

    /// The series that an algebraic step reads.
    fn operands(&self, step: &SeriesStep) -> impl Iterator<Item = Slot> {
        let (terms, few) = match step.operation {
            SeriesOperation::Linear { first, count, .. } => {
                (&self.terms[first as usize..][..count as usize], [None; 3])
            }
            SeriesOperation::Multiply(a, b) | SeriesOperation::SquareSum(a, b) | SeriesOperation::Divide(a, b) => {
                (&[][..], [Some(a), Some(b), None])
            }
            SeriesOperation::Choose { above, equal, below, .. } => (&[][..], [Some(above), Some(equal), Some(below)]),
            SeriesOperation::Power(a, _) | SeriesOperation::SquareRoot(a) | SeriesOperation::Logarithm(a) => {
                (&[][..], [Some(a), None, None])
            }
            _ => (&[][..], [None; 3]),
        };
        let read = |term: &Term| if let Source::Slot(slot) = term.source { Some(slot) } else { None };
        terms.iter().filter_map(read).chain(few.into_iter().flatten())
    }
}

/// A series that is given by the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Given {
    /// Time.
    Time,
    /// An input, or its first or second derivative.
    Input(u32, u8),
    /// The position of a follower, or its first or second derivative.
    Follower(u32, u8),
}

/// `target = operation`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SeriesStep {
    /// Series written.
    pub target: Slot,
    /// What to do.
    pub operation: SeriesOperation,
}

impl SeriesStep {
    /// Series that it writes.
    pub(crate) fn targets(&self) -> impl Iterator<Item = Slot> {
        let second = match self.operation {
            SeriesOperation::SineCosine(_, second)
            | SeriesOperation::HyperbolicTangent(_, second)
            | SeriesOperation::Floor { function: second, .. } => Some(second),
            _ => None,
        };
        core::iter::once(self.target).chain(second)
    }
}

/// What a step does. Every operation is analytic where it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SeriesOperation {
    /// constant + sum of `count` terms from `first` on.
    Linear {
        /// First term.
        first: u32,
        /// Number of terms.
        count: u32,
        /// Constant term.
        constant: Option<Coefficient>,
    },
    /// a b
    Multiply(Slot, Slot),
    /// a^2 + b^2
    SquareSum(Slot, Slot),
    /// a / b
    Divide(Slot, Slot),
    /// a^exponent, exponent constant
    Power(Slot, Coefficient),
    /// sqrt a
    SquareRoot(Slot),
    /// sin a; the second series receives cos a
    SineCosine(Slot, Slot),
    /// e^a
    Exponential(Slot),
    /// ln a
    Logarithm(Slot),
    /// tanh a; the second series receives 1 - tanh^2 a
    HyperbolicTangent(Slot, Slot),
    /// atan2(y, x); the third series is x^2 + y^2
    ArcTangent(Slot, Slot, Slot),
    /// Time derivative of a series of positions.
    Rate(Slot),
    /// The largest integer n that is no larger than the argument a: an even one while its switching function is positive.
    Floor {
        /// The argument.
        argument: Slot,
        /// Number of the switching function.
        switch: u32,
        /// Receives that function: (a - n) (n + 1 - a), with a minus sign for odd n.
        function: Slot,
    },
    /// One of three series, by a switching function.
    Choose {
        /// Number of the switching function.
        switch: u32,
        /// While it is positive.
        above: Slot,
        /// While it is zero.
        equal: Slot,
        /// While it is negative.
        below: Slot,
    },
}

/// factor x source
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Term {
    /// A series.
    pub source: Source,
    /// Its factor.
    pub factor: Coefficient,
}

/// A series that a linear step may read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// Another scalar series.
    Slot(Slot),
    /// World x of an arm.
    X(u32),
    /// World y of an arm.
    Y(u32),
    /// An unknown.
    Unknown(u32),
    /// Its rate.
    UnknownRate(u32),
}
