//! Components: each file is one component, with its keys, its row of Table 1 (McPhee 1998), its variables, law, energy and symbol.
//! Nothing else in the program knows what components there are.

mod actuator;
mod angle_driver;
mod arm;
mod belt;
pub(crate) mod body;
mod cam;
mod constant_force;
mod coupled;
mod damper;
mod displacement_driver;
mod distance;
mod element;
mod force;
mod gas_spring;
mod gear;
mod icon;
mod key;
mod line;
mod position_driver;
mod prismatic;
mod rack;
mod reference;
mod resistance;
mod revolute;
mod rolling;
mod schema;
mod screw;
pub(crate) mod shape;
mod slide;
mod slot;
mod spring;
mod system;
mod torque;
mod torsion;
mod torsion_actuator;
mod torsion_damper;
mod torsion_spring;
mod weld;

pub use cam::Phase;
pub(crate) use cam::Profile;
pub use coupled::CoupledEdge;
pub use element::*;
pub(crate) use icon::{Glyph, Icon, RoundGlyph, Stroke};
pub use reference::{examples, reference};
pub use resistance::Resistance;
pub use schema::schema;
pub use system::System;

use crate::diagnostic::Fault;
use crate::mechanism::{Dimension, Formula, Mechanism, Part, Quantity, Variable};
use crate::scene::key::Key;

/// Every component that a scene can name.
pub(crate) const ALL: &[&dyn Component] = &[
    &revolute::Revolute,
    &prismatic::Prismatic,
    &weld::Weld,
    &slot::Slot,
    &rolling::Rolling,
    &distance::Distance,
    &gear::Gear,
    &rack::Rack,
    &belt::Belt,
    &screw::Screw,
    &cam::Cam,
    &angle_driver::AngleDriver,
    &displacement_driver::DisplacementDriver,
    &position_driver::PositionDriver,
    &force::AppliedForce,
    &torque::AppliedTorque,
    &spring::Spring,
    &torsion_spring::TorsionSpring,
    &actuator::Actuator,
    &damper::Damper,
    &torsion_actuator::TorsionActuator,
    &gas_spring::GasSpring,
    &constant_force::ConstantForce,
    &torsion_damper::TorsionDamper,
];

/// The variables `energy.x`.
pub(crate) const ENERGIES: &[Quantity] = &[Quantity::KineticEnergy, Quantity::PotentialEnergy, Quantity::TotalEnergy];

/// The variables `constraint.x`.
pub(crate) const RESIDUALS: &[Quantity] = &[Quantity::PositionResidual, Quantity::VelocityResidual];

/// The section of the scene that a component belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    Joints,
    Drivers,
    Loads,
}

impl Section {
    /// The word for one of its entries.
    pub fn word(self) -> &'static str {
        match self {
            Section::Joints => "joint",
            Section::Drivers => "driver",
            Section::Loads => "load",
        }
    }

    /// Its components.
    pub fn components(self) -> impl Iterator<Item = &'static dyn Component> + Clone {
        ALL.iter().copied().filter(move |component| component.facts().section == self)
    }
}

/// What a component needs of the scene's dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Room {
    /// A line will do.
    Line,
    /// It turns, so it needs the plane.
    Turning,
    /// It needs two directions.
    Plane,
    /// Masses on a line do this without it, as the words say.
    Needless(&'static str),
}

/// What there is to say of a component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facts {
    /// Its `type`; for a driver the key of the motion that it prescribes.
    pub name: &'static str,
    /// Its section.
    pub section: Section,
    /// What it does, in a few words.
    pub about: &'static str,
    /// Its terminal equations (Table 1) as a text.
    pub equations: &'static str,
    /// Its keys, beside `type`.
    pub keys: &'static [Key],
    /// Its variables; each has `power` as well.
    pub variables: &'static [Quantity],
    /// Its variables that its own law may call by their bare names.
    pub own: &'static [Quantity],
    /// What it holds or exerts by a multiplier, in the plane.
    pub reactions: &'static [Quantity],
    /// What a report of an equilibrium says of it beside the reactions.
    pub pose: &'static [Quantity],
    /// Where it can be.
    pub room: Room,
    /// What it is called, such as "a weld", if a driver names it in vain, and what to do then.
    pub undriven: [&'static str; 2],
    /// The drivers that can move it.
    pub drivers: &'static [&'static str],
    /// Does its force on a line count as a pull? Else it pushes.
    pub pulls: bool,
}

impl Facts {
    const fn new(section: Section, name: &'static str) -> Facts {
        Facts {
            name,
            section,
            about: "",
            equations: "",
            keys: &[],
            variables: &[],
            own: &[],
            reactions: &[],
            pose: &[],
            room: Room::Plane,
            undriven: ["", ""],
            drivers: &[],
            pulls: false,
        }
    }

    const fn joint(name: &'static str) -> Facts {
        Facts::new(Section::Joints, name)
    }

    const fn driver(name: &'static str) -> Facts {
        Facts::new(Section::Drivers, name)
    }

    const fn load(name: &'static str) -> Facts {
        Facts { room: Room::Line, ..Facts::new(Section::Loads, name) }
    }

    /// What an entry is called: "revolute joint", "driver", "torsion spring".
    pub fn words(&self) -> String {
        match self.section {
            Section::Joints => format!("{} joint", self.name),
            Section::Drivers => "driver".to_string(),
            Section::Loads => self.name.replace('_', " "),
        }
    }

    /// The coordinates that it brings as a branch of a tree, with their rates and accelerations, beside its variables.
    pub fn coordinates(&self, dimension: Dimension) -> &'static [Quantity] {
        use Quantity::{Acceleration, Alpha, Angle, Ax, Ay, Length, Omega, Rate, Vx, Vy, X, Y};
        match (self.section, self.room, dimension) {
            (Section::Loads, Room::Turning, _) => &[Angle, Omega, Alpha],
            (Section::Loads, _, Dimension::One) => &[Length, Rate, Acceleration],
            (Section::Loads, _, Dimension::Two) => &[X, Y, Vx, Vy, Ax, Ay],
            _ => &[],
        }
    }

    /// Its reactions in a scene of this dimension.
    pub fn reactions(&self, dimension: Dimension) -> impl Iterator<Item = Quantity> {
        let is_there = move |quantity: &Quantity| dimension == Dimension::Two || quantity.is_on_a_line();
        self.reactions.iter().copied().filter(is_there)
    }
}

/// Stiffness, damping and free length of a linear component on a line.
pub(crate) type Linear = [Formula; 3];

/// One component, in one place.
pub(crate) trait Component: Sync {
    /// What there is to say of it.
    fn facts(&self) -> &'static Facts;

    /// Its rows of Table 1.
    fn rows(&self, part: &Part, system: &mut System) -> Rows;

    /// The force that pushes its ends apart, or the torque on its second body, in terms of its keys and own variables.
    fn law(&self, _part: &Part) -> Option<String> {
        None
    }

    /// The energy that it stores, likewise.
    fn energy(&self, _part: &Part) -> Option<String> {
        None
    }

    /// Its share of a linear vibrating system; none if its law is to be taken as it is, an error if it can never be linear.
    fn linear(&self, _part: &Part) -> Result<Option<Linear>, String> {
        Ok(None)
    }

    /// What is wrong with it that only the whole mechanism shows.
    fn check(&self, _part: &Part, _mechanism: &Mechanism) -> Vec<Fault> {
        Vec::new()
    }

    /// The profile of a body that it stands for, at these parameters.
    fn profile(&self, _part: &Part, _mechanism: &Mechanism, _parameters: &[f64]) -> Option<Profile> {
        None
    }

    /// What is drawn for it.
    fn icon(&self, part: &Part) -> Icon;
}

/// The component with a name.
pub(crate) fn named(name: &str) -> Option<&'static dyn Component> {
    ALL.iter().copied().find(|component| component.facts().name == name)
}

/// The component of a part.
pub(crate) fn of(part: &Part) -> &'static dyn Component {
    // Parts are made with the names of components only.
    named(part.kind).unwrap_or(&weld::Weld)
}

impl Part {
    /// What there is to say of its component.
    pub(crate) fn facts(&self) -> &'static Facts {
        of(self).facts()
    }

    /// Does its law or motion turn? Else it is a force or a displacement.
    pub fn is_angular(&self) -> bool {
        self.facts().room == Room::Turning
    }
}

impl Mechanism {
    /// What is wrong with parts that only the whole mechanism shows.
    pub(crate) fn check(&self) -> Vec<Fault> {
        self.parts().flat_map(|part| of(part).check(part, self)).collect()
    }

    /// The profiles of its cams, at these parameters.
    pub(crate) fn profiles(&self, parameters: &[f64]) -> Vec<Profile> {
        self.joints.iter().filter_map(|part| of(part).profile(part, self, parameters)).collect()
    }

    /// The reactions of each joint.
    pub fn joint_reactions(&self) -> Vec<Variable> {
        self.joints.iter().flat_map(|joint| self.reactions(joint)).collect()
    }

    /// What each driver must exert.
    pub fn driver_efforts(&self) -> Vec<Variable> {
        self.drivers.iter().flat_map(|driver| self.reactions(driver)).collect()
    }

    fn reactions(&self, part: &Part) -> impl Iterator<Item = Variable> {
        let owner = part.owner;
        part.facts().reactions(self.dimension).map(move |quantity| Variable { owner, quantity })
    }
}
