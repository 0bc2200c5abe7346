//! Disc that rolls on a line without slip (o): r = s u + radius n, from the line's point to the disc's centre, with u along the line
//! and n = k x u fixed in the first body; and s + radius theta = displacement. The normal force is the reaction of the edge,
//! the tangential force that of the coupling: with the torque radius x force it acts at the contact.

use super::{
    Angle, CoordinateName, Coupling, Direction, Element, Force, Known, Origin, Port, RotationalRow, System, Term,
    Torque, TranslationalRow, table2, table3,
};
use crate::expr::Expr;
use crate::mechanism::{Formula, JointId};

pub(super) fn element(
    system: &mut System,
    id: JointId,
    axis: &[Formula; 2],
    radius: &Formula,
    displacement: &Formula,
) -> Element {
    let joint = &system.mechanism.joints[id.0];
    let [ux, uy] = system.values(axis);
    let (radius, displacement) = (system.value(radius), system.value(displacement));
    let normal = [system.arena.negate(uy), ux];
    let height = normal.map(|component| system.arena.multiply(radius, component));
    let first = joint.between[0].body();
    let along = Direction::Fixed(first, [ux, uy]);
    let slide = joint.between.map(|place| system.t_node(place));
    let turn = joint.between.map(|place| system.r_node(place.body()));
    Element {
        label: system.label("o"),
        name: joint.name.clone(),
        origin: Origin::Joint(id),
        translation: Some(TranslationalRow {
            ends: slide,
            priority: table2::PRISMATIC,
            known: Known::Fixed(first, height),
            motion: vec![(along, CoordinateName::new(&joint.name, ["s", "v", "a"]))],
            reaction: vec![Direction::Fixed(first, normal)],
            through: Force::None,
        }),
        rotation: Some(RotationalRow {
            ends: turn,
            priority: table3::REVOLUTE,
            angle: Angle::Free(CoordinateName::new(&joint.name, ["angle", "omega", "alpha"])),
            through: Torque::None,
        }),
        coupling: Some(Coupling {
            terms: vec![
                Term { factor: Expr::ONE, port: Port::Along(slide, along) },
                Term { factor: radius, port: Port::Angle(turn) },
            ],
            offset: displacement,
        }),
    }
}
