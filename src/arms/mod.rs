//! The arm form of the equations of motion, from which their Taylor series follow (`docs/arm-form.md`).
//!
//! Every position is a constant combination of products sigma e: a scalar (1, a displacement, a signal of time) times the unit vector
//! of a frame. Virtual work then needs masses between arms, loads along arms and nothing else; see `cotree_fmu::taylor`.

mod armatures;
mod form;
mod friction;
mod linear;
mod loads;
mod masses;
mod rows;
mod series;
mod states;
mod tree;

use std::collections::BTreeMap;

use crate::equations::vector::FrameId;
use crate::equations::{Constraint, Equations};
use crate::expr::Expr;
use crate::model::BodyId;
use crate::network::ElementId;

pub(crate) use form::{arm_form, mass_form, repeat_exactly};
pub use linear::conjugate_product;
pub use tree::ArmLink;

/// Why the motion is not integrated by series: a clause about the mechanism.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoSeries(pub String);

/// Up to so many masses between arms, or arms that loads work along, the arm form is formulated.
const MOST: usize = 1_000_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ArmFactor {
    /// 1
    One,
    /// A displacement: that coordinate, beyond their number the integral of a state, and beyond these an auxiliary one.
    Displacement(usize),
    Signal(Expr),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Arm {
    pub frame: FrameId,
    pub factor: ArmFactor,
}

impl Arm {
    pub fn of(frame: FrameId) -> Self {
        Arm { frame, factor: ArmFactor::One }
    }

    pub fn is_constant(&self) -> bool {
        *self == Arm::of(FrameId::WORLD)
    }
}

/// A vector: constant complex numbers by arms.
pub type Arms = BTreeMap<Arm, [Expr; 2]>;

#[derive(Clone, Debug)]
pub struct Turning {
    pub frame: FrameId,
    /// Coordinates that its angle is made of, with their signs.
    pub coordinates: BTreeMap<usize, f64>,
    /// The part of its angle that is a function of time.
    pub signal: Expr,
    pub inertia: Expr,
    pub unit: [Expr; 2],
}

#[derive(Clone, Debug, Default)]
pub struct ArmLoopEquation {
    pub constraint: usize,
    pub arms: Arms,
    pub displacements: Vec<(usize, Expr)>,
    /// Angles of frames, without their signals.
    pub angles: Vec<(FrameId, Expr)>,
    /// Functions of time, and of coordinates.
    pub signals: Vec<(Expr, Expr)>,
    /// How the latter change with the angles of frames.
    pub slopes: Vec<(FrameId, Expr, Expr)>,
    pub constant: Vec<Expr>,
    /// 1 while it is closed, if it holds on one side only: everything above has it as a factor.
    pub closed: Option<Expr>,
    /// What friction does here while it slides.
    pub friction: Option<ArmFriction>,
}

/// What a friction limit acts on: what the reaction of the loop equation would act on, times the direction of sliding.
#[derive(Clone, Debug, Default)]
pub struct ArmFriction {
    pub arms: Arms,
    pub displacements: Vec<(usize, Expr)>,
    pub angles: Vec<(FrameId, Expr)>,
}

/// value x along, acting along a displacement.
#[derive(Clone, Debug)]
pub struct ArmLoad {
    pub across: Arms,
    pub value: Expr,
    pub along: Arms,
}

#[derive(Clone, Debug)]
pub struct ArmPush {
    /// Works on the angle of a frame, or on a displacement.
    pub on: Result<FrameId, usize>,
    pub value: Expr,
    pub factor: Expr,
}

/// A gap that is constrained along a direction fixed in a turning frame: the displacement across is free.
#[derive(Clone, Debug)]
pub struct ArmAuxiliary {
    pub displacement: usize,
    pub free: [Expr; 2],
    pub row: usize,
}

/// A massless rod between two points: its angle follows from theirs.
#[derive(Clone, Debug)]
pub struct ArmRod {
    pub frame: FrameId,
    pub row: usize,
    pub length: Expr,
}

#[derive(Clone, Debug, Default)]
pub struct ArmEquations {
    pub frames: Vec<Turning>,
    pub coupling: BTreeMap<(Arm, Arm), [Expr; 2]>,
    /// Instead of the masses of every two arms, where many bodies hang from each other without a loop.
    pub links: Vec<ArmLink>,
    /// Arms that loads work along, at most.
    spanned: usize,
    pub rows: Vec<ArmLoopEquation>,
    pub auxiliary: Vec<ArmAuxiliary>,
    pub rods: Vec<ArmRod>,
    pub loads: Vec<ArmLoad>,
    pub pushes: Vec<ArmPush>,
    pub lines: Vec<(Expr, Expr, Arms)>,
}

impl ArmEquations {
    /// The place of a frame that turns, as long as the frames stand in the order of their numbers: a tree gives them its own at the end.
    fn place(&self, frame: FrameId) -> Option<usize> {
        self.frames.binary_search_by_key(&frame, |turning| turning.frame).ok()
    }
}

impl Equations {
    /// The arm form of the loop equations that count.
    ///
    /// # Errors
    /// A displacement that is no constant combination of arms, or too many masses between arms.
    pub fn arms(&mut self, counts: fn(&Constraint) -> bool) -> Result<ArmEquations, NoSeries> {
        let mut arms = self.arms_without_loads(counts)?;
        self.weights(&mut arms);
        for index in 0..self.system.elements.len() {
            self.force(ElementId(index), &mut arms)?;
            self.torque(ElementId(index), &mut arms);
        }
        Ok(arms)
    }

    /// Masses, and the loop equations that count.
    ///
    /// # Errors
    /// As [`Equations::arms`].
    pub fn arms_without_loads(&mut self, counts: fn(&Constraint) -> bool) -> Result<ArmEquations, NoSeries> {
        let mut arms = ArmEquations { frames: self.turning()?, ..ArmEquations::default() };
        if !self.constraints.iter().any(counts) {
            self.tree(&mut arms)?;
        }
        if arms.links.is_empty() {
            self.are_few()?;
            self.masses(&mut arms)?;
        }
        self.armatures(&mut arms)?;
        self.rows(counts, &mut arms)?;
        Ok(arms)
    }

    /// The arm form of a driven mechanism with unit masses on its unknowns, and no loads: no mass matters where loop equations determine
    /// the motion. `length`: the natural size of a displacement.
    ///
    /// # Errors
    /// As [`Equations::arms`].
    pub fn arms_of_loops(&mut self, counts: fn(&Constraint) -> bool, length: f64) -> Result<ArmEquations, NoSeries> {
        let mut arms = ArmEquations { frames: self.turning()?, ..ArmEquations::default() };
        for turning in arms.frames.iter_mut().filter(|turning| !turning.coordinates.is_empty()) {
            turning.inertia = Expr::ONE;
        }
        self.rows(counts, &mut arms)?;
        // Each displacement along the arm that it has in the loop equations.
        let used: BTreeMap<ArmFactor, Arm> =
            arms.rows.iter().flat_map(|row| row.arms.keys()).map(|arm| (arm.factor, *arm)).collect();
        let mass = self.system.arena.constant(1.0 / (length * length));
        for (index, _) in self.coordinates.iter().enumerate().filter(|(_, coordinate)| !coordinate.angular) {
            let factor = ArmFactor::Displacement(index);
            let arm = used.get(&factor).copied().unwrap_or(Arm { frame: FrameId::WORLD, factor });
            arms.coupling.insert((arm, arm), [mass, Expr::ZERO]);
        }
        Ok(arms)
    }

    fn rows(&mut self, counts: fn(&Constraint) -> bool, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let rows: Vec<usize> = (0..self.constraints.len()).filter(|&row| counts(&self.constraints[row])).collect();
        rows.into_iter().try_for_each(|row| self.row(row, arms))
    }

    /// Are the masses between every two arms few enough?
    fn are_few(&self) -> Result<(), NoSeries> {
        let bodies = self.system.mechanism.bodies.len();
        let couplings: usize = (0..bodies).map(|body| self.depth(BodyId(body)).pow(2)).sum();
        if couplings > MOST {
            Err(NoSeries("it has many equations that are weakly coupled".to_owned()))
        } else {
            Ok(())
        }
    }
}
