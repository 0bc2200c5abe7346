//! Loads.

use super::Resolver;
use super::lower::Context;
use crate::mechanism::{Load, LoadId, LoadKind, SpringLaw};
use crate::scene::dimension::{
    ANGLE, CUBIC_STIFFNESS, CUBIC_TORSION_STIFFNESS, DAMPING, FORCE, LENGTH, STIFFNESS, TORQUE, TORSION_DAMPING,
    TORSION_STIFFNESS,
};
use crate::scene::model;

impl Resolver<'_> {
    pub(super) fn loads(&mut self) -> Vec<Load> {
        let scene = self.scene;
        scene.loads.iter().enumerate().filter_map(|(index, load)| self.load(LoadId(index), load)).collect()
    }

    fn load(&mut self, id: LoadId, load: &model::Load) -> Option<Load> {
        let law = Context::Law(id);
        let name = &load.name.text;
        let span = load.name.span;
        let kind = match &load.kind {
            model::LoadKind::Force { on, vector, in_body } => {
                let user = format!("force `{name}`");
                let vector = self.vector(vector, &format!("`vector` of {user}"), &FORCE, law);
                self.moving_place(on, &user).map(|on| LoadKind::Force { on, vector, in_body: *in_body })
            }
            model::LoadKind::Torque { between, value } => {
                let user = format!("torque `{name}`");
                self.must_not_turn(&user, span);
                let value = self.formula(value, &format!("`value` of {user}"), &TORQUE, law);
                self.body_pair(between, &user).map(|between| LoadKind::Torque { between, value })
            }
            model::LoadKind::Spring { .. } => self.spring(load),
            model::LoadKind::TorsionSpring { .. } => self.torsion_spring(load),
            model::LoadKind::Actuator { between, force } => {
                let user = format!("actuator `{name}`");
                let force = self.formula(force, &format!("`force` of {user}"), &FORCE, law);
                self.places(between, &user).map(|between| LoadKind::Actuator { between, force })
            }
            model::LoadKind::TorsionActuator { between, torque } => {
                let user = format!("torsion actuator `{name}`");
                self.must_not_turn(&user, span);
                let torque = self.formula(torque, &format!("`torque` of {user}"), &TORQUE, law);
                self.body_pair(between, &user).map(|between| LoadKind::TorsionActuator { between, torque })
            }
        };
        Some(Load { name: name.clone(), kind: kind?, span })
    }

    fn spring(&mut self, load: &model::Load) -> Option<LoadKind> {
        let model::LoadKind::Spring { between, stiffness, length, damping, cubic, side } = &load.kind else {
            return None;
        };
        let user = format!("spring `{}`", load.name.text);
        let of = |key: &str| format!("`{key}` of {user}");
        let stiffness = self.constant(stiffness, &of("stiffness"), &STIFFNESS);
        let free = self.constant_or_zero(length.as_ref(), &of("length"), &LENGTH);
        let damping = self.constant_or_zero(damping.as_ref(), &of("damping"), &DAMPING);
        let cubic = self.constant_or_zero(cubic.as_ref(), &of("cubic"), &CUBIC_STIFFNESS);
        let law = SpringLaw { stiffness, cubic, damping, free, side: *side };
        self.places(between, &user).map(|between| LoadKind::Spring { between, law })
    }

    fn torsion_spring(&mut self, load: &model::Load) -> Option<LoadKind> {
        let model::LoadKind::TorsionSpring { between, stiffness, angle, damping, cubic, side } = &load.kind else {
            return None;
        };
        let user = format!("torsion spring `{}`", load.name.text);
        self.must_not_turn(&user, load.name.span);
        let of = |key: &str| format!("`{key}` of {user}");
        let stiffness = self.constant(stiffness, &of("stiffness"), &TORSION_STIFFNESS);
        let free = self.constant_or_zero(angle.as_ref(), &of("angle"), &ANGLE);
        let damping = self.constant_or_zero(damping.as_ref(), &of("damping"), &TORSION_DAMPING);
        let cubic = self.constant_or_zero(cubic.as_ref(), &of("cubic"), &CUBIC_TORSION_STIFFNESS);
        let law = SpringLaw { stiffness, cubic, damping, free, side: *side };
        self.body_pair(between, &user).map(|between| LoadKind::TorsionSpring { between, law })
    }
}
