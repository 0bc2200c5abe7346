//! The naming table: which variables there are, and what they are.

use std::collections::HashMap;

use super::Resolver;
use super::names::Named;
use crate::mechanism::{Owner, Place, Quantity, Variable};
use crate::scene::dimension::{
    ACCELERATION, ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, ENERGY, FORCE, LENGTH, POWER, TORQUE, VELOCITY, Wanted,
};
use crate::scene::fault::Fault;
use crate::scene::model::{DriverKind, JointKind, LoadKind};
use crate::scene::span::Text;
use crate::scene::suggest;

use Quantity::{
    A, Alpha, Angle, Ax, Ay, Fn, Force, Ft, Fx, Fy, KineticEnergy, Length, Omega, PositionResidual, PotentialEnergy,
    Power, Rate, S, Torque, TotalEnergy, V, VelocityResidual, Vx, Vy, X, Y,
};

/// What kind of thing a variable is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Class {
    Position,
    Velocity,
    Acceleration,
    Effort,
    System,
}

impl Class {
    pub fn of(quantity: Quantity) -> Class {
        match quantity {
            X | Y | Angle | S | Length => Class::Position,
            Vx | Vy | Omega | V | Rate => Class::Velocity,
            Ax | Ay | Alpha | A => Class::Acceleration,
            Fx | Fy | Fn | Ft | Force | Torque | Power => Class::Effort,
            KineticEnergy | PotentialEnergy | TotalEnergy | PositionResidual | VelocityResidual => Class::System,
        }
    }
}

/// The last word of a variable's name and what it is in words.
pub(super) fn words(quantity: Quantity) -> (&'static str, &'static str) {
    match quantity {
        X => ("x", "x position of"),
        Y => ("y", "y position of"),
        Angle => ("angle", "angle of"),
        Vx => ("vx", "x velocity of"),
        Vy => ("vy", "y velocity of"),
        Omega => ("omega", "angular velocity of"),
        Ax => ("ax", "x acceleration of"),
        Ay => ("ay", "y acceleration of"),
        Alpha => ("alpha", "angular acceleration of"),
        S => ("s", "displacement of"),
        V => ("v", "velocity of"),
        A => ("a", "acceleration of"),
        Fx => ("fx", "x force of"),
        Fy => ("fy", "y force of"),
        Fn => ("fn", "normal force of"),
        Ft => ("ft", "tangential force of"),
        Force => ("force", "force of"),
        Torque => ("torque", "torque of"),
        Power => ("power", "power of"),
        Length => ("length", "length of"),
        Rate => ("rate", "rate of length of"),
        KineticEnergy => ("kinetic", "kinetic energy"),
        PotentialEnergy => ("potential", "potential energy"),
        TotalEnergy => ("total", "total energy"),
        PositionResidual => ("position", "largest residual of the loop equations"),
        VelocityResidual => ("velocity", "largest residual of the rates of the loop equations"),
    }
}

/// The unit of a variable.
pub(super) fn wanted(quantity: Quantity) -> Wanted {
    match quantity {
        X | Y | S | Length | PositionResidual => LENGTH,
        Vx | Vy | V | Rate | VelocityResidual => VELOCITY,
        Ax | Ay | A => ACCELERATION,
        Angle => ANGLE,
        Omega => ANGULAR_VELOCITY,
        Alpha => ANGULAR_ACCELERATION,
        Fx | Fy | Fn | Ft | Force => FORCE,
        Torque => TORQUE,
        Power => POWER,
        KineticEnergy | PotentialEnergy | TotalEnergy => ENERGY,
    }
}

pub(super) const BODY: &[Quantity] = &[X, Y, Angle, Vx, Vy, Omega, Ax, Ay, Alpha];
pub(super) const POINT: &[Quantity] = &[X, Y, Vx, Vy, Ax, Ay];
pub(super) const ENERGIES: &[Quantity] = &[KineticEnergy, PotentialEnergy, TotalEnergy];
pub(super) const RESIDUALS: &[Quantity] = &[PositionResidual, VelocityResidual];

pub(super) fn of_joint(kind: &JointKind) -> (&'static str, &'static [Quantity]) {
    match kind {
        JointKind::Revolute { .. } => ("revolute joint", &[Angle, Omega, Alpha, Fx, Fy, Torque]),
        JointKind::Prismatic { .. } => ("prismatic joint", &[S, V, A, Fn, Force, Torque]),
        JointKind::Weld { .. } => ("weld joint", &[Fx, Fy, Torque]),
        JointKind::Slot { .. } => ("slot joint", &[S, V, A, Angle, Omega, Alpha, Fn, Force]),
        JointKind::Rolling { .. } => ("rolling joint", &[S, V, A, Angle, Omega, Alpha, Fn, Ft]),
        JointKind::Distance { .. } => ("distance joint", &[Force]),
        JointKind::Gear { .. } => ("gear joint", &[Torque]),
        JointKind::Rack { .. } => ("rack joint", &[Force, Torque]),
    }
}

pub(super) fn of_driver(kind: &DriverKind) -> &'static [Quantity] {
    match kind {
        DriverKind::Angle { .. } => &[Torque, Power],
        DriverKind::Displacement { .. } => &[Force, Power],
        DriverKind::Position { .. } => &[Fx, Fy, Power],
    }
}

pub(super) fn of_load(kind: &LoadKind) -> (&'static str, &'static [Quantity]) {
    match kind {
        LoadKind::Force { .. } => ("force", &[]),
        LoadKind::Torque { .. } => ("torque", &[]),
        LoadKind::Spring { .. } => ("spring", &[Length, Rate, Force]),
        LoadKind::Actuator { .. } => ("actuator", &[Length, Rate, Force]),
        LoadKind::TorsionSpring { .. } => ("torsion spring", &[Angle, Omega, Torque]),
        LoadKind::TorsionActuator { .. } => ("torsion actuator", &[Angle, Omega, Torque]),
    }
}

/// Is there such a thing on a line?
pub(super) fn on_a_line(quantity: Quantity) -> bool {
    !matches!(quantity, Y | Vy | Ay | Fy | Angle | Omega | Alpha | Torque)
}

/// An owner of variables, what to call it, and what it has.
struct Found {
    owner: Owner,
    called: String,
    has: &'static [Quantity],
}

impl Resolver<'_> {
    /// The variable with a name such as `crank.angle` or `rod.small_end.x`; a fault with this code if there is none.
    pub(super) fn variable(&mut self, name: &Text, user: &str, code: &'static str) -> Option<Variable> {
        let (owner, last) = name.text.rsplit_once('.').unwrap_or((&name.text, ""));
        let Some(found) = self.find_owner(owner) else {
            self.unknown_owner(name, user, code);
            return None;
        };
        let one_dimensional = self.one_dimensional();
        let mut has = found.has.iter().copied().filter(|quantity| !one_dimensional || on_a_line(*quantity));
        if let Some(quantity) = has.clone().find(|quantity| words(*quantity).0 == last) {
            return Some(Variable { owner: found.owner, quantity });
        }
        if self.is_reported(name, &name.text) {
            return None;
        }
        let names: Vec<&str> = has.by_ref().map(|quantity| words(quantity).0).collect();
        let has = match names.is_empty() {
            true => format!("{} has no variables", found.called),
            false => format!("{} has {}", found.called, suggest::list(names.iter().copied())),
        };
        let near = suggest::nearest(last, names.iter().copied());
        let help = match near {
            _ if name.text.contains('.') && self.find_owner(&name.text).is_some() => {
                format!("`{0}` is a point; write `{0}.x` or `{0}.y`", name.text)
            }
            Some(near) => format!("did you mean `{owner}.{near}`? {has}"),
            None => has,
        };
        let message = format!("{user} names a variable that does not exist: `{}`", name.text);
        self.faults.push_about(&name.text, Fault::new(code, message, name.span).label("no such variable").help(help));
        None
    }

    fn find_owner(&self, owner: &str) -> Option<Found> {
        let place = |place, called: String, has| Some(Found { owner: Owner::Place(place), called, has });
        if let Some((body, point)) = owner.split_once('.') {
            return match (body, self.names.get(body)) {
                ("ground", _) => {
                    let index = *self.names.ground.get(point)?;
                    place(Place::Ground(index), format!("point `{owner}`"), POINT)
                }
                (_, Some(Named::Body(id))) => {
                    let index = *self.names.points[id.0].get(point)?;
                    place(Place::Point(id, index), format!("point `{owner}`"), POINT)
                }
                _ => None,
            };
        }
        let system = |has| Some(Found { owner: Owner::System, called: format!("`{owner}`"), has });
        match owner {
            "energy" => return system(ENERGIES),
            "constraint" => return system(RESIDUALS),
            _ => {}
        }
        match self.names.get(owner)? {
            Named::Body(id) => place(Place::Centre(id), format!("body `{owner}`"), BODY),
            Named::Joint(id) => {
                let (word, has) = of_joint(&self.scene.joints[id.0].kind);
                Some(Found { owner: Owner::Joint(id), called: format!("{word} `{owner}`"), has })
            }
            Named::Driver(id) => {
                let has = of_driver(&self.scene.drivers[id.0].kind);
                Some(Found { owner: Owner::Driver(id), called: format!("driver `{owner}`"), has })
            }
            Named::Load(id) => {
                let (word, has) = of_load(&self.scene.loads[id.0].kind);
                Some(Found { owner: Owner::Load(id), called: format!("{word} `{owner}`"), has })
            }
            Named::Parameter(_) | Named::Input(_) => None,
        }
    }

    fn unknown_owner(&mut self, name: &Text, user: &str, code: &'static str) {
        let (first, rest) = name.text.split_once('.').unwrap_or((&name.text, ""));
        let named = self.names.get(first);
        // One fault for each point or element that is missing, wherever it is used.
        let owner = name.text.rsplit_once('.').map_or(name.text.as_str(), |(owner, _)| owner);
        let subject = if named.is_some() || first == "ground" { owner } else { first };
        if self.is_reported(name, subject) {
            return;
        }
        let help = match named {
            Some(Named::Body(id)) => points_hint(first, rest, &self.names.points[id.0]),
            _ if first == "ground" => points_hint(first, rest, &self.names.ground),
            Some(Named::Input(_)) => {
                format!("`{first}` is an input: it is a variable of the FMU anyway")
            }
            Some(Named::Parameter(_)) => {
                format!("`{first}` is a parameter: it is a variable of the FMU anyway")
            }
            _ => {
                let known = self.names.all(|named| !matches!(named, Named::Parameter(_) | Named::Input(_)));
                let otherwise =
                    "variables are named like `crank.angle`, `rod.small_end.x`, `wrist_pin.fx`, `energy.total`";
                suggest::hint(first, known.into_iter().chain(["energy", "constraint", "ground"]), otherwise.to_string())
            }
        };
        let message = format!("{user} names a variable that does not exist: `{}`", name.text);
        self.faults.push_about(subject, Fault::new(code, message, name.span).label("no such variable").help(help));
    }

    /// The last words of the variables of what has this name.
    pub(super) fn variables_of(&self, owner: &str) -> Vec<&'static str> {
        let one_dimensional = self.one_dimensional();
        let has = self.find_owner(owner).map_or(&[][..], |found| found.has);
        has.iter()
            .filter(|quantity| !one_dimensional || on_a_line(**quantity))
            .map(|quantity| words(*quantity).0)
            .collect()
    }

    /// "angle of `crank`"
    pub(super) fn describe(variable: Variable, name: &str) -> String {
        let (_, words) = words(variable.quantity);
        match variable.owner {
            Owner::System => words.to_string(),
            _ => format!("{words} `{}`", name.rsplit_once('.').map_or(name, |(owner, _)| owner)),
        }
    }
}

/// Which point may have been meant, or which there are.
fn points_hint(owner: &str, rest: &str, points: &HashMap<&str, usize>) -> String {
    let point = rest.split('.').next().unwrap_or_default();
    let mut points: Vec<&str> = points.keys().copied().collect();
    points.sort_unstable();
    match (suggest::nearest(point, points.iter().copied()), points.first()) {
        (Some(near), _) => format!("did you mean `{owner}.{near}`?"),
        (None, None) => format!("`{owner}` has no points"),
        (None, Some(first)) => {
            let list = suggest::list(points.iter().copied());
            format!("`{owner}` has the points {list}, with variables such as `{owner}.{first}.x`")
        }
    }
}
