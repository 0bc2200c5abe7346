//! What kinds of values there are, with their SI units: a length, a force, a stiffness.

use super::Exponents;

/// What a key wants.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// "a length"
    pub what: &'static str,
    /// "m"; empty for a pure number.
    pub si: &'static str,
    /// None: anything goes.
    pub exponents: Option<Exponents>,
}

impl Wanted {
    /// Is it an angle, or a rate of one?
    pub fn is_turning(&self) -> bool {
        [ANGLE, ANGULAR_VELOCITY, ANGULAR_ACCELERATION].iter().any(|turning| turning.exponents == self.exponents)
    }
}

const fn wanted(what: &'static str, si: &'static str, exponents: Exponents) -> Wanted {
    Wanted { what, si, exponents: Some(exponents) }
}

const KG: Exponents = Exponents::KILOGRAM;
const M: Exponents = Exponents::METRE;
const S: Exponents = Exponents::SECOND;
const RAD: Exponents = Exponents::RADIAN;
const A: Exponents = Exponents::AMPERE;
const N: Exponents = Exponents::NEWTON;
const J: Exponents = Exponents::JOULE;

pub(crate) const ANYTHING: Wanted = Wanted { what: "a number", si: "", exponents: None };
pub(crate) const NUMBER: Wanted = wanted("a pure number", "", Exponents::NONE);
pub(crate) const TIME: Wanted = wanted("a time", "s", S);
pub(crate) const MASS: Wanted = wanted("a mass", "kg", KG);
pub(crate) const INERTIA: Wanted = wanted("a moment of inertia", "kg.m2", KG.times(M.squared()));
pub(crate) const LENGTH: Wanted = wanted("a length", "m", M);
pub(crate) const CURVATURE: Wanted = wanted("a curvature", "1/m", Exponents::NONE.over(M));
pub(crate) const AREA: Wanted = wanted("an area", "m2", M.squared());
pub(crate) const DENSITY: Wanted = wanted("a density", "kg/m3", KG.over(M).over(M.squared()));
pub(crate) const AREA_DENSITY: Wanted = wanted("a density per area", "kg/m2", KG.over(M.squared()));
pub(crate) const LINE_DENSITY: Wanted = wanted("a density per length", "kg/m", KG.over(M));
pub(crate) const VELOCITY: Wanted = wanted("a velocity", "m/s", M.over(S));
pub(crate) const ACCELERATION: Wanted = wanted("an acceleration", "m/s2", M.over(S.squared()));
pub(crate) const ANGLE: Wanted = wanted("an angle", "rad", RAD);
pub(crate) const ANGULAR_VELOCITY: Wanted = wanted("an angular velocity", "rad/s", RAD.over(S));
pub(crate) const ANGULAR_ACCELERATION: Wanted = wanted("an angular acceleration", "rad/s2", RAD.over(S.squared()));
pub(crate) const FORCE: Wanted = wanted("a force", "N", N);
pub(crate) const TORQUE: Wanted = wanted("a torque", "N.m", J);
pub(crate) const IMPULSE: Wanted = wanted("an impulse", "N.s", N.times(S));
pub(crate) const ANGULAR_IMPULSE: Wanted = wanted("an angular impulse", "N.m.s", J.times(S));
pub(crate) const ENERGY: Wanted = wanted("an energy", "J", J);
pub(crate) const POWER: Wanted = wanted("a power", "W", J.over(S));
pub(crate) const CURRENT: Wanted = wanted("an electric current", "A", A);
pub(crate) const VOLTAGE: Wanted = wanted("a voltage", "V", J.over(S).over(A));
pub(crate) const RESISTANCE: Wanted = wanted("a resistance", "ohm", J.over(S).over(A).over(A));
pub(crate) const INDUCTANCE: Wanted = wanted("an inductance", "H", J.over(A).over(A));
pub(crate) const MOTOR_CONSTANT: Wanted = wanted("a torque per current", "N.m/A", J.over(A));
pub(crate) const PRESSURE: Wanted = wanted("a pressure", "Pa", N.over(M.squared()));
pub(crate) const VOLUME: Wanted = wanted("a volume", "m3", M.times(M.squared()));
pub(crate) const STIFFNESS: Wanted = wanted("a stiffness", "N/m", N.over(M));
pub(crate) const TORSION_STIFFNESS: Wanted = wanted("a torsional stiffness", "N.m/rad", J.over(RAD));
pub(crate) const CUBIC_STIFFNESS: Wanted = wanted("a cubic stiffness", "N/m3", N.over(M).over(M.squared()));
pub(crate) const CUBIC_TORSION_STIFFNESS: Wanted =
    wanted("a cubic torsional stiffness", "N.m/rad3", J.over(RAD).over(RAD.squared()));
pub(crate) const DAMPING: Wanted = wanted("a damping coefficient", "N.s/m", N.times(S).over(M));
pub(crate) const TORSION_DAMPING: Wanted = wanted("a torsional damping coefficient", "N.m.s", J.times(S));
