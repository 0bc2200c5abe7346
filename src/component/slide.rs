//! What slides along an axis: r = s u with u fixed in the first body, F . u resists (Eqs 3, 4).

use super::key::{Form, Key, Record};
use crate::model::measure::{FORCE, VELOCITY};
use crate::model::{Part, Pressed, Quantity, Range, measure};
use crate::network::{Direction, Force, Known, Resistance, System, TranslationalRow, table2};

pub(super) const DAMPING: Key =
    Key::optional("damping", Form::Constant(measure::DAMPING, Range::Any), "viscous friction");
pub(super) const ARMATURE: Key = Key::optional(
    "armature",
    Form::Constant(measure::MASS, Range::NotNegative),
    "mass that moves with the displacement only, such as a geared rotor's inertia over the square of its lead",
);
pub(super) const FRICTION: Key = friction(Pressed::Guide { holds_angle: false });
pub(super) const FRICTION_OF_GUIDE: Key = friction(Pressed::Guide { holds_angle: true });

const fn friction(pressed: Pressed) -> Key {
    Key::optional("friction", Form::Record(Record::Friction([FORCE, VELOCITY], pressed)), "dry friction")
}

/// The row of a joint with the keys `axis`, `damping`, `friction` and `armature`.
pub(super) fn row(system: &mut System, part: &Part) -> TranslationalRow {
    let [ux, uy] = system.values(&part.vector("axis"));
    let normal = [system.arena.negate(uy), ux];
    let resistance = Resistance::of(system, part);
    let first = part.between[0].body();
    TranslationalRow {
        ends: part.between.map(|place| system.t_node(place)),
        priority: table2::PRISMATIC,
        known: Known::Zero,
        motion: vec![(Direction::Fixed(first, [ux, uy]), part.owner.motion(Quantity::SLIDE))],
        reaction: vec![Direction::Fixed(first, normal)],
        through: resistance.map_or(Force::None, Force::Resistance),
        armature: system.value(part.formula("armature")),
    }
}
