//! Components: each file is one component, with its keys, its row of Table 1 (McPhee 1998), its variables, law, energy and symbol.
//! Nothing else in the program knows what components there are.

pub mod body;
pub(crate) mod course;
mod frame;
mod icon;
mod key;
pub(crate) mod kinds;
mod limits;
mod line;
pub(crate) mod outline;
mod reference;
mod schema;
pub(crate) mod shape;
mod slide;
mod torsion;
pub(crate) mod transfer;

pub(crate) use frame::{PartFrame, Placed, minus, sum};
pub use icon::{Glyph, Icon, IconStroke, RoundGlyph};
pub(crate) use kinds::ALL;
pub use kinds::{Phase, Profile};
pub use outline::outline_at;
pub use reference::{examples, reference};
pub(crate) use schema::object_of;
pub use schema::schema;

use std::sync::Arc;

use crate::diagnostic::{Fault, Span};
use crate::expr::Expr;
use crate::model::{
    Captured, Dimension, Formula, Friction, GapLaw, KeyValue, Mechanism, Owner, Part, Place, Pressed, Quantity, State,
    Unit, Variable,
};
use crate::network::{Coupling, Rows, System};
use crate::scene::constant;
use crate::scene::key::Key;

/// The variables `energy.x`.
pub(crate) const ENERGIES: &[Quantity] = &[Quantity::KineticEnergy, Quantity::PotentialEnergy, Quantity::TotalEnergy];

/// The variables `constraint.x`.
pub(crate) const RESIDUALS: &[Quantity] = &[Quantity::PositionResidual, Quantity::VelocityResidual];

/// The section of the scene that a component belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
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

    pub fn components(self) -> impl Iterator<Item = &'static Component> + Clone {
        ALL.iter().copied().filter(move |component| component.section == self)
    }
}

/// What a component needs of the scene's dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Room {
    /// A line will do.
    Line,
    /// It turns, so it needs the plane.
    Turning,
    /// It needs two directions.
    Plane,
    /// Masses on a line do this without it, as the words say.
    Needless(&'static str),
}

/// One component, in one place.
#[derive(Clone, Copy, Debug)]
pub struct Component {
    /// Its `type`; for a driver the key of the motion that it prescribes.
    pub name: &'static str,
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
    pub law_variables: &'static [Quantity],
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
    /// Its rows of Table 1.
    pub rows: RowsOf,
    /// The force that pushes its ends apart \[N\], or the torque on its second body [N.m], in terms of its keys and own variables.
    pub law: fn(&Part) -> Option<Formula>,
    /// The energy that it stores \[J\], likewise.
    pub energy: fn(&Part) -> Option<Formula>,
    /// The states that it brings.
    pub states: fn(&Part) -> Vec<OwnState>,
    /// What it holds on one side only.
    pub gaps: fn(&Part, &Mechanism) -> Vec<GapLaw>,
    /// What its gap is for each unit by which that relation is off: a length for an angle.
    pub gap_lever: fn(&Part, &mut System) -> Expr,
    /// The relation that may be off as far as those say.
    pub relation: fn(&Part, &mut System) -> Option<Coupling>,
    /// How its dry friction acts, if it can have any.
    pub rubs: Option<Rubs>,
    /// What it takes from where an event engages it.
    pub captures: &'static [Captured],
    /// Its variables if events engage it; one that none can engage has none.
    pub engaging: &'static [Quantity],
    /// What is wrong with it that only the whole mechanism shows.
    pub check: fn(&Part, &Mechanism) -> Vec<Fault>,
    /// The profile of a body that it stands for, at these parameters.
    pub profile: fn(&Part, &Mechanism, &[f64]) -> Option<Profile>,
    /// What it is where a part is placed.
    pub placed: PlacedOf,
    /// What is drawn for it.
    pub icon: IconOf,
}

/// How dry friction acts.
#[derive(Clone, Copy, Debug)]
pub struct Rubs {
    /// The relation along which it slides.
    pub along: fn(&Part, &mut System) -> Option<Coupling>,
    pub pressed: Pressed,
    pub law: fn(&Part) -> Option<Friction>,
}

impl Rubs {
    /// Of a joint with the key `friction`.
    const fn joint(pressed: Pressed, along: fn(&Part, &mut System) -> Option<Coupling>) -> Option<Rubs> {
        Some(Rubs { along, pressed, law: |part| part.friction().filter(|friction| friction.sticks()).cloned() })
    }
}

type RowsOf = fn(&Part, &mut System) -> Rows;
type PlacedOf = fn(&mut Placed<'_>);
type IconOf = fn(&Part) -> Icon;

impl Component {
    const fn new(section: Section, name: &'static str, rows: RowsOf, placed: PlacedOf, icon: IconOf) -> Component {
        Component {
            name,
            section,
            about: "",
            equations: "",
            keys: &[],
            variables: &[],
            law_variables: &[],
            reactions: &[],
            pose: &[],
            room: Room::Plane,
            undriven: ["", ""],
            drivers: &[],
            pulls: false,
            rows,
            law: |_| None,
            energy: |_| None,
            states: |_| Vec::new(),
            gaps: |_, _| Vec::new(),
            gap_lever: |_, _| Expr::ONE,
            relation: |_, _| None,
            rubs: None,
            captures: &[],
            engaging: &[],
            check: |_, _| Vec::new(),
            profile: |_, _, _| None,
            placed,
            icon,
        }
    }

    const fn joint(name: &'static str, rows: RowsOf, placed: PlacedOf, icon: IconOf) -> Component {
        Component::new(Section::Joints, name, rows, placed, icon)
    }

    const fn driver(name: &'static str, rows: RowsOf, placed: PlacedOf, icon: IconOf) -> Component {
        Component::new(Section::Drivers, name, rows, placed, icon)
    }

    const fn load(name: &'static str, rows: RowsOf, placed: PlacedOf, icon: IconOf) -> Component {
        Component { room: Room::Line, ..Component::new(Section::Loads, name, rows, placed, icon) }
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
            (Section::Loads, Room::Turning, _) if self.variables.contains(&X) => {
                &[X, Y, Vx, Vy, Ax, Ay, Angle, Omega, Alpha]
            }
            (Section::Loads, Room::Turning, _) => &[Angle, Omega, Alpha],
            (Section::Loads, _, Dimension::One) => &[Length, Rate, Acceleration],
            (Section::Loads, _, Dimension::Two) => &[X, Y, Vx, Vy, Ax, Ay],
            _ => &[],
        }
    }

    /// One of this kind, which belongs to nothing yet.
    pub(crate) fn part(&self, name: &str, between: [Place; 2], values: Vec<(&'static str, KeyValue)>) -> Part {
        let owner = Owner::System;
        Part { name: name.to_owned(), kind: self.kind(), owner, between, values, span: Span::default() }
    }

    /// Its place among all of them.
    pub(crate) fn kind(&self) -> usize {
        ALL.iter().take_while(|other| other.name != self.name).count()
    }

    /// Its reactions in a scene of this dimension.
    pub fn reactions(&self, dimension: Dimension) -> impl Iterator<Item = Quantity> {
        let is_there = move |quantity: &Quantity| dimension == Dimension::Two || quantity.is_on_a_line();
        self.reactions.iter().copied().filter(is_there)
    }
}

impl Part {
    /// What it is: its keys, its variables, its equations.
    pub fn component(&self) -> &'static Component {
        ALL[self.kind]
    }

    /// The force that pushes its ends apart \[N\] or the torque on its second body [N.m], if it has such a law.
    pub fn law(&self) -> Option<Formula> {
        (self.component().law)(self)
    }

    /// The energy that it stores \[J\], if it stores any.
    pub fn energy(&self) -> Option<Formula> {
        (self.component().energy)(self)
    }

    /// One of its variables.
    pub(crate) fn variable(&self, quantity: Quantity) -> Formula {
        Formula::Variable(Variable { owner: self.owner, quantity })
    }

    /// The number of a key, to calculate with; zero if it is absent.
    pub(crate) fn key(&self, key: &str) -> Formula {
        self.formula(key).clone()
    }

    /// Does its law or motion turn? Else it is a force or a displacement.
    pub fn is_angular(&self) -> bool {
        self.component().room == Room::Turning
    }
}

impl System {
    /// The elements of a mechanism and both graphs.
    pub fn new(mechanism: &Mechanism) -> Self {
        let rows = |part: &Part, system: &mut System| (part.component().rows)(part, system);
        let relation = |part: &Part, slips: bool, system: &mut System| {
            let component = part.component();
            match component.rubs.filter(|_| slips) {
                Some(rubs) => (rubs.along)(part, system),
                None => (component.relation)(part, system),
            }
        };
        Self::of(Arc::new(mechanism.clone()), rows, relation)
    }
}

/// A state that a component brings: one of its variables.
#[derive(Clone, Debug)]
pub struct OwnState {
    pub quantity: Quantity,
    /// Its value at the start.
    pub start: Formula,
    pub rate: Formula,
    /// Its usual size, SI, where its start says none.
    pub nominal: f64,
}

impl Mechanism {
    /// Adds the states that components bring.
    pub(crate) fn add_own_states(&mut self) {
        let parameters = self.parameter_values();
        let of = |part: &Part| {
            let state = |state: OwnState| {
                let size = constant::evaluate(&state.start, &parameters).abs();
                State {
                    name: state.quantity.of(&part.name),
                    description: format!("{} `{}`", state.quantity.words(), part.name),
                    unit: Unit::of(&state.quantity.measure(), None),
                    start: state.start,
                    rate: state.rate,
                    nominal: if size > 0.0 { size } else { state.nominal },
                    variable: Some(Variable { owner: part.owner, quantity: state.quantity }),
                    span: part.span,
                }
            };
            (part.component().states)(part).into_iter().map(state).collect::<Vec<State>>()
        };
        let states: Vec<State> = self.parts().flat_map(of).collect();
        self.states.extend(states);
    }

    /// What is wrong with parts that only the whole mechanism shows.
    pub(crate) fn check(&self) -> Vec<Fault> {
        self.parts().flat_map(|part| (part.component().check)(part, self)).collect()
    }

    /// The profiles of its cams, at these parameters.
    pub fn profiles(&self, parameters: &[f64]) -> Vec<Profile> {
        self.joints.iter().filter_map(|part| (part.component().profile)(part, self, parameters)).collect()
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
        part.component().reactions(self.dimension).map(move |quantity| Variable { owner, quantity })
    }
}
