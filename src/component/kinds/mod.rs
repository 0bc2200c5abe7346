//! Components that a scene can name, one file each.

mod actuator;
mod angle_driver;
mod belt;
mod brake;
mod bushing;
mod cam;
mod constant_force;
mod contact;
mod cylinder;
mod damper;
mod dc_motor;
mod displacement_driver;
mod distance;
mod force;
mod gas_spring;
mod gear;
mod lock;
mod one_way;
mod position_driver;
mod prismatic;
mod rack;
mod revolute;
mod rolling;
mod rope;
mod screw;
mod slot;
mod spring;
mod torque;
mod torsion_actuator;
mod torsion_damper;
mod torsion_spring;
mod weld;

pub use cam::{Phase, Profile};

use crate::component::Component;

/// Every component that a scene can name.
pub(crate) const ALL: &[&Component] = &[
    &revolute::REVOLUTE,
    &prismatic::PRISMATIC,
    &weld::WELD,
    &slot::SLOT,
    &rolling::ROLLING,
    &distance::DISTANCE,
    &lock::LOCK,
    &contact::CONTACT,
    &rope::ROPE,
    &brake::BRAKE,
    &brake::CLUTCH,
    &one_way::ONE_WAY,
    &gear::GEAR,
    &rack::RACK,
    &belt::BELT,
    &screw::SCREW,
    &cam::CAM,
    &angle_driver::ANGLE_DRIVER,
    &displacement_driver::DISPLACEMENT_DRIVER,
    &position_driver::POSITION_DRIVER,
    &force::APPLIED_FORCE,
    &torque::APPLIED_TORQUE,
    &spring::SPRING,
    &torsion_spring::TORSION_SPRING,
    &actuator::ACTUATOR,
    &damper::DAMPER,
    &torsion_actuator::TORSION_ACTUATOR,
    &gas_spring::GAS_SPRING,
    &constant_force::CONSTANT_FORCE,
    &torsion_damper::TORSION_DAMPER,
    &bushing::BUSHING,
    &dc_motor::DC_MOTOR,
    &cylinder::CYLINDER,
];
