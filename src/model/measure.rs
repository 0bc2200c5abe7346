//! What kinds of values there are, with their SI units: a length, a force, a stiffness.

/// What a key wants.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// "a length"
    pub what: &'static str,
    /// "m"; empty for a pure number.
    pub si: &'static str,
    /// None: anything goes.
    pub exponents: Option<[i8; 4]>,
}

impl Wanted {
    /// Is it an angle, or a rate of one?
    pub fn is_turning(&self) -> bool {
        [ANGLE, ANGULAR_VELOCITY, ANGULAR_ACCELERATION].iter().any(|turning| turning.exponents == self.exponents)
    }
}

const fn wanted(what: &'static str, si: &'static str, exponents: [i8; 4]) -> Wanted {
    Wanted { what, si, exponents: Some(exponents) }
}

pub(crate) const ANYTHING: Wanted = Wanted { what: "a number", si: "", exponents: None };
pub(crate) const NUMBER: Wanted = wanted("a pure number", "", [0; 4]);
pub(crate) const TIME: Wanted = wanted("a time", "s", [0, 0, 1, 0]);
pub(crate) const MASS: Wanted = wanted("a mass", "kg", [1, 0, 0, 0]);
pub(crate) const INERTIA: Wanted = wanted("a moment of inertia", "kg.m2", [1, 2, 0, 0]);
pub(crate) const LENGTH: Wanted = wanted("a length", "m", [0, 1, 0, 0]);
pub(crate) const CURVATURE: Wanted = wanted("a curvature", "1/m", [0, -1, 0, 0]);
pub(crate) const AREA: Wanted = wanted("an area", "m2", [0, 2, 0, 0]);
pub(crate) const DENSITY: Wanted = wanted("a density", "kg/m3", [1, -3, 0, 0]);
pub(crate) const AREA_DENSITY: Wanted = wanted("a density per area", "kg/m2", [1, -2, 0, 0]);
pub(crate) const LINE_DENSITY: Wanted = wanted("a density per length", "kg/m", [1, -1, 0, 0]);
pub(crate) const VELOCITY: Wanted = wanted("a velocity", "m/s", [0, 1, -1, 0]);
pub(crate) const ACCELERATION: Wanted = wanted("an acceleration", "m/s2", [0, 1, -2, 0]);
pub(crate) const ANGLE: Wanted = wanted("an angle", "rad", [0, 0, 0, 1]);
pub(crate) const ANGULAR_VELOCITY: Wanted = wanted("an angular velocity", "rad/s", [0, 0, -1, 1]);
pub(crate) const ANGULAR_ACCELERATION: Wanted = wanted("an angular acceleration", "rad/s2", [0, 0, -2, 1]);
pub(crate) const FORCE: Wanted = wanted("a force", "N", [1, 1, -2, 0]);
pub(crate) const TORQUE: Wanted = wanted("a torque", "N.m", [1, 2, -2, 0]);
pub(crate) const ENERGY: Wanted = wanted("an energy", "J", [1, 2, -2, 0]);
pub(crate) const POWER: Wanted = wanted("a power", "W", [1, 2, -3, 0]);
pub(crate) const STIFFNESS: Wanted = wanted("a stiffness", "N/m", [1, 0, -2, 0]);
pub(crate) const TORSION_STIFFNESS: Wanted = wanted("a torsional stiffness", "N.m/rad", [1, 2, -2, -1]);
pub(crate) const CUBIC_STIFFNESS: Wanted = wanted("a cubic stiffness", "N/m3", [1, -2, -2, 0]);
pub(crate) const CUBIC_TORSION_STIFFNESS: Wanted = wanted("a cubic torsional stiffness", "N.m/rad3", [1, 2, -2, -3]);
pub(crate) const DAMPING: Wanted = wanted("a damping coefficient", "N.s/m", [1, 0, -1, 0]);
pub(crate) const TORSION_DAMPING: Wanted = wanted("a torsional damping coefficient", "N.m.s", [1, 2, -1, 0]);
