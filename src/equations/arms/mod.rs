//! The same mechanism once more, as arms: what its Taylor series are found from.
//!
//! Every position is a constant combination of products sigma e: a scalar (1, a displacement, a signal of time) times the unit vector
//! of a frame. Virtual work then needs masses between arms, loads along arms and nothing else; see `cotree_fmu::taylor`.

mod linear;
mod loads;
mod masses;
mod rows;

use std::collections::BTreeMap;

use super::Equations;
use super::vector::FrameId;
use crate::expr::Expr;
use crate::graph::ElementId;

pub use linear::conjugate_product;

/// Why there is no arm form: a clause about the mechanism.
pub type Reason = String;

/// The scalar of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Factor {
    /// 1
    One,
    /// A displacement: that coordinate, or beyond their number an auxiliary one.
    Displacement(usize),
    /// A function of time.
    Signal(Expr),
}

/// sigma e
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arm {
    /// e
    pub frame: FrameId,
    /// sigma
    pub factor: Factor,
}

impl Arm {
    /// The unit vector of a frame.
    pub fn of(frame: FrameId) -> Self {
        Arm { frame, factor: Factor::One }
    }

    /// Fixed in the world?
    pub fn is_constant(&self) -> bool {
        *self == Arm::of(FrameId::WORLD)
    }
}

/// A vector: constant complex numbers by arms.
pub type Arms = BTreeMap<Arm, [Expr; 2]>;

/// A turning frame.
#[derive(Clone, Debug)]
pub struct Turning {
    /// Which.
    pub frame: FrameId,
    /// Coordinates that its angle is made of, with their signs.
    pub coordinates: BTreeMap<usize, f64>,
    /// The part of its angle that is a function of time.
    pub signal: Expr,
    /// Inertia of what turns with it.
    pub inertia: Expr,
    /// cos and sin.
    pub unit: [Expr; 2],
}

/// A loop equation.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Which.
    pub constraint: usize,
    /// p . b
    pub arms: Arms,
    /// Displacements with their factors.
    pub displacements: Vec<(usize, Expr)>,
    /// Angles of frames, without their signals.
    pub angles: Vec<(FrameId, Expr)>,
    /// Signals with their factors.
    pub signals: Vec<(Expr, Expr)>,
    /// Constant term.
    pub constant: Vec<Expr>,
}

/// value x along, acting along a displacement.
#[derive(Clone, Debug)]
pub struct Load {
    /// The displacement that the force works along.
    pub across: Arms,
    /// A scalar of the motion.
    pub value: Expr,
    /// A vector.
    pub along: Arms,
}

/// A scalar load on what it works along.
#[derive(Clone, Debug)]
pub struct Push {
    /// Works on the angle of a frame, or on a displacement.
    pub on: Result<FrameId, usize>,
    /// The load.
    pub value: Expr,
    /// Its factor.
    pub factor: Expr,
}

/// A gap that a direction fixed in a turning frame holds: the displacement across is free.
#[derive(Clone, Debug)]
pub struct Auxiliary {
    /// Number of the displacement.
    pub displacement: usize,
    /// Frame of the direction.
    pub frame: FrameId,
    /// Direction in which the gap is free.
    pub free: [Expr; 2],
    /// First of its two rows.
    pub row: usize,
}

/// A massless rod between two points: its angle follows from theirs.
#[derive(Clone, Debug)]
pub struct Rod {
    /// The frame that turns with it.
    pub frame: FrameId,
    /// First of its two rows.
    pub row: usize,
    /// Its length.
    pub length: Expr,
}

/// A mechanism as arms.
#[derive(Clone, Debug, Default)]
pub struct ArmEquations {
    /// Frames but the world.
    pub frames: Vec<Turning>,
    /// A_kl
    pub coupling: BTreeMap<(Arm, Arm), [Expr; 2]>,
    /// Loop equations.
    pub rows: Vec<Row>,
    /// Displacements that are no coordinates.
    pub auxiliary: Vec<Auxiliary>,
    /// Frames whose angles are no coordinates.
    pub rods: Vec<Rod>,
    /// Forces.
    pub loads: Vec<Load>,
    /// Torques, and forces along a displacement.
    pub pushes: Vec<Push>,
    /// Lengths of lines with their rates.
    pub lines: Vec<(Expr, Expr, Arms)>,
}

impl Equations<'_> {
    /// The arm form; only the `active` loop equations enter.
    ///
    /// # Errors
    /// A displacement that is no constant combination of arms.
    pub fn arms(&mut self, active: &[bool]) -> Result<ArmEquations, Reason> {
        let mut arms = ArmEquations { frames: self.turning()?, ..ArmEquations::default() };
        self.masses(&mut arms)?;
        for (index, _) in active.iter().enumerate().filter(|(_, active)| **active) {
            self.row(index, &mut arms)?;
        }
        for index in 0..self.system.elements.len() {
            self.force(ElementId(index), &mut arms)?;
            self.torque(ElementId(index), &mut arms);
        }
        Ok(arms)
    }
}
