//! Dry friction: a force or torque against sliding, of a level that may follow from what presses.
//!
//! With a `velocity` it is smooth through zero and creeps at rest. Without one it sticks: at rest it is what it must be, up to its level (Pfeiffer and Glocker 1996, section 5.3). Which of the two
//! holds, and in which direction it slides, are discrete variables: events alone change them.

use super::{Formula, Quantity};

/// Dry friction as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Constant part of the level while it slides [N.m] or \[N\].
    pub coulomb: Formula,
    /// Velocity at which three quarters of the level act [rad/s] or [m/s]; without it friction sticks.
    pub velocity: Option<Formula>,
    /// Share of what presses in the level while it slides.
    pub mu: Formula,
    /// Level at rest by level while it slides.
    pub ratio: Formula,
    /// Radius of a pin \[m\].
    pub radius: Option<Formula>,
    /// Length of a guide \[m\]; without it the guide is short: its torque does not press.
    pub length: Option<Formula>,
    /// Angle of wrap \[rad\] and mean tension \[N\] of a belt.
    pub belt: Option<[Formula; 2]>,
}

/// What presses where something rubs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// Nothing that depends on reactions.
    Nothing,
    /// The force in a pin, |R|, at its radius.
    Pin,
    /// The normal force of a guide, |fn|; of one that holds the angle, those at both its ends if it has a length.
    Guide { holds_angle: bool },
    /// The normal force of what is held on one side.
    Contact,
    /// A reaction of the part: the torque of a mesh, or the force of a thread at its radius.
    Reaction(Quantity),
    /// The tension of a belt, which is given.
    Belt,
}

/// What rubs, in its mechanism: its relation between across variables is a loop equation while it sticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Slip {
    pub law: Friction,
    pub pressed: Pressed,
    /// The place, among all of them, of what must be closed for it to rub.
    pub on: Option<usize>,
}

impl Pressed {
    /// How friction is written where this presses.
    pub(crate) fn example(self) -> &'static str {
        match self {
            Pressed::Nothing => "{ coulomb = 0.1 }",
            Pressed::Belt => "{ mu = 0.4, wrap = \"150 deg\", pretension = \"200 N\" }",
            Pressed::Pin => "{ mu = 0.1, radius = \"10 mm\" }",
            Pressed::Guide { .. } | Pressed::Contact => "{ mu = 0.3 }",
            Pressed::Reaction(Quantity::Force) => "{ mu = 0.15, radius = \"10 mm\" }",
            Pressed::Reaction(_) => "{ mu = 0.02 }",
        }
    }
}

impl Friction {
    /// A level that nothing presses for.
    pub(crate) fn of_level(coulomb: Formula, ratio: Formula) -> Self {
        Self { coulomb, velocity: None, mu: Formula::Number(0.0), ratio, radius: None, length: None, belt: None }
    }

    pub fn sticks(&self) -> bool {
        self.velocity.is_none()
    }

    /// Every formula in it.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let optional = [&self.velocity, &self.radius, &self.length];
        let belt = self.belt.iter().flatten();
        [&self.coulomb, &self.mu, &self.ratio].into_iter().chain(optional.into_iter().flatten()).chain(belt)
    }
}
