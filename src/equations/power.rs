//! The power that joints, drivers and loads put into the mechanism: effort times flow of their edges, F . v + T omega. The reactions
//! of joints and couplings do no work. The power that a spring stores or a damper dissipates is negative.

use super::Equations;
use crate::expr::{Expr, Order};
use crate::model::{Owner, Quantity, Variable};
use crate::network::{Direction, ElementId, Force, Origin, RotationalRow, Torque, TranslationalRow};

impl Equations {
    pub(super) fn power(&mut self, id: ElementId) -> Expr {
        if let Origin::Load(load) = self.system.element(id).origin
            && let Some(rate) = self.course_length(Owner::Load(load), Order::Velocity)
        {
            let force = self.variable(Variable { owner: Owner::Load(load), quantity: Quantity::Force });
            return self.system.arena.multiply(force, rate);
        }
        let element = self.system.element(id);
        let (translation, rotation) = (element.translation.clone(), element.rotation.clone());
        let origin = element.origin;
        let is_driver = matches!(origin, Origin::Driver(_));
        let moving = translation.map_or(Expr::ZERO, |row| self.moving_power(id, &row, is_driver));
        let turning = rotation.map_or(Expr::ZERO, |row| self.turning_power(id, &row, is_driver));
        let rubbing = self.rubbing_power(origin);
        self.system.arena.sum([moving, turning, rubbing])
    }

    /// What dry friction that sticks takes while it slips.
    fn rubbing_power(&mut self, origin: Origin) -> Expr {
        let force = self.rubbing(origin);
        let Origin::Joint(joint) = origin else { return Expr::ZERO };
        let rate = self.slip(joint, Order::Velocity);
        self.system.arena.multiply(force, rate)
    }

    fn moving_power(&mut self, id: ElementId, row: &TranslationalRow, is_driver: bool) -> Expr {
        let plane = [Direction::X, Direction::Y];
        let (directions, force) = match &row.through {
            _ if is_driver => (&row.reaction[..], None),
            Force::Resistance(_) => {
                let Some(&(direction, _)) = row.motion.first() else { return Expr::ZERO };
                let force = self.resisting_force(Some(row));
                let speed = self.kinematics.speed_along(&mut self.system, row.ends, direction);
                return self.system.arena.multiply(force, speed);
            }
            Force::World(_) | Force::InBody(..) | Force::Line(_) | Force::Tangent(..) => {
                (&plane[..], self.laws.forces.get(&id).cloned())
            }
            Force::None | Force::Inertia(_) => return Expr::ZERO,
        };
        let mut total = Expr::ZERO;
        for &direction in directions {
            let effort = match &force {
                Some(force) => {
                    let (_, along) = self.kinematics.direction(&mut self.system, direction);
                    self.component(force, &along)
                }
                None => self.force_along(id, direction),
            };
            let speed = self.kinematics.speed_along(&mut self.system, row.ends, direction);
            total = self.system.arena.add_product(total, effort, speed);
        }
        total
    }

    fn turning_power(&mut self, id: ElementId, row: &RotationalRow, is_driver: bool) -> Expr {
        let torque = match row.through {
            _ if is_driver => self.torque_of(id),
            Torque::Resistance(_) => self.resisting_torque(Some(row)),
            Torque::Law(_) => self.laws.torques.get(&id).copied().unwrap_or(Expr::ZERO),
            Torque::None | Torque::Inertia(_) => return Expr::ZERO,
        };
        let arena = &mut self.system.arena;
        let rate = self.kinematics.angle_across(arena, row.ends).velocity.total(arena);
        arena.multiply(torque, rate)
    }
}
