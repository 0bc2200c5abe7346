//! Couplings of two joints as gears and racks: on the body that both have in common, else over massless wheels.

use super::planar::{PlanarCoordinate, PlanarFollower};
use super::write::{RobotWriter, number, pair};

/// A slide: its parent and child, its place and direction.
type SlideParts = (usize, usize, [f64; 2], [f64; 2]);

/// A coordinate as the turn of a wheel against a parent, both by the scene's names.
struct WheelTurn {
    parent: String,
    wheel: String,
    sign: f64,
}

impl RobotWriter<'_> {
    /// q_joint = offset + ratio q_leader.
    pub fn follower(&mut self, follower: &PlanarFollower) {
        let planar = self.planar;
        let name = planar.file.followers[follower.source].name.clone();
        let (offset, ratio) = (follower.offset, follower.ratio);
        match (planar.coordinates[follower.joint], planar.coordinates[follower.leader]) {
            (
                PlanarCoordinate::Turn { parent: other, child: pinion, sign, .. },
                PlanarCoordinate::Slide { parent, child, at, along, .. },
            ) if parent == other => {
                let pinion = self.links[pinion].clone();
                self.rack(&name, (parent, child, at, along), &pinion, sign / ratio, -offset / ratio);
            }
            (
                PlanarCoordinate::Slide { parent, child, at, along, .. },
                PlanarCoordinate::Turn { parent: other, .. } | PlanarCoordinate::Slide { parent: other, .. },
            ) if parent == other => {
                let leader = self.wheel_turn(&name, follower.leader);
                self.rack(&name, (parent, child, at, along), &leader.wheel, ratio * leader.sign, offset);
            }
            _ => {
                let [follower_turn, leader] =
                    [follower.joint, follower.leader].map(|index| self.wheel_turn(&name, index));
                self.gears(&name, &follower_turn, &leader, ratio, offset);
            }
        }
        self.report.exact("coupling of two joints");
    }

    /// A hinge turns its child; a slide turns a massless pinion on its parent by 1 rad per metre.
    fn wheel_turn(&mut self, name: &str, index: usize) -> WheelTurn {
        match self.planar.coordinates[index] {
            PlanarCoordinate::Slide { parent, child, at, along, .. } => {
                let on = self.links[parent].clone();
                let wheel = self.wheel(name, &on);
                self.rack(name, (parent, child, at, along), &wheel, 1.0, 0.0);
                WheelTurn { parent: on, wheel, sign: 1.0 }
            }
            PlanarCoordinate::Turn { parent, child, sign, .. } => {
                WheelTurn { parent: self.links[parent].clone(), wheel: self.links[child].clone(), sign }
            }
            // A free body at whose coordinates something acts is no free body, but has three joints.
            PlanarCoordinate::FreeX(child) | PlanarCoordinate::FreeY(child) | PlanarCoordinate::FreeAngle(child) => {
                WheelTurn { parent: self.links[0].clone(), wheel: self.links[child].clone(), sign: 1.0 }
            }
        }
    }

    /// A massless body that turns on another.
    fn wheel(&mut self, name: &str, on: &str) -> String {
        let body_name = self.fresh("", "body", &format!("{}_wheel", if name.is_empty() { "coupling" } else { name }));
        let pin = self.fresh("", "joint", &format!("{body_name}_pin"));
        self.wheel_text += &format!("\n[bodies.{body_name}]\nmass    = 0\ninertia = 0\n");
        self.joint_text +=
            &format!("\n[joints.{pin}]\ntype    = \"revolute\"\nbetween = [\"{on}\", \"{body_name}\"]\n");
        body_name
    }

    /// own = offset + ratio leader. Two turns without a common body need three gears: the first makes a wheel x with x - p2 = ratio (w2 - p2) + offset; then
    /// w1 - p1 = x - p2 holds where a carrier is in the middle of w1 and p2, and of x and p1.
    fn gears(&mut self, name: &str, turn: &WheelTurn, leader: &WheelTurn, ratio: f64, offset: f64) {
        let (same, angle) = (turn.sign * leader.sign * ratio, turn.sign * offset);
        let (p1, w1, p2, w2) = (&turn.parent, &turn.wheel, &leader.parent, &leader.wheel);
        if p1 == p2 {
            self.gear(name, p1, [w2, w1], same, angle);
        } else if w2 == p1 {
            self.gear(name, p1, [p2, w1], -same, angle);
        } else if w1 == p2 {
            self.gear(name, p2, [w2, p1], -same, -angle);
        } else {
            let [x, middle] = [0; 2].map(|_| self.wheel(name, "ground"));
            self.gear(name, p2, [w2, &x], same, angle);
            // The ground is the second wheel, where it is one.
            self.gear(name, &middle, [w1, p2], -1.0, 0.0);
            self.gear(name, &middle, [&x, p1], -1.0, 0.0);
        }
    }

    /// A name for one of the gears and racks of a coupling of the file: its own for the first.
    fn coupling(&mut self, name: &str) -> String {
        self.fresh("", "coupling", if name.is_empty() { "coupling" } else { name })
    }

    /// b - carrier = ratio (a - carrier) + angle.
    fn gear(&mut self, name: &str, carrier: &str, [a, b]: [&str; 2], ratio: f64, angle: f64) {
        let name = self.coupling(name);
        let on = if carrier == "ground" { String::new() } else { format!("carrier = \"{carrier}\"\n") };
        self.joint_text += &format!(
            "\n[joints.{name}]\ntype    = \"gear\"\nbetween = [\"{a}\", \"{b}\"]\n{on}ratio   = {}\nangle   = {}\n",
            number(ratio),
            number(angle)
        );
    }

    /// The displacement of a slide is radius times the turn of a pinion against the slide's parent, and a displacement.
    fn rack(&mut self, name: &str, slide: SlideParts, pinion: &str, radius: f64, displacement: f64) {
        let (parent, child, at, along) = slide;
        let coupling = self.coupling(name);
        let [carrier, rack] = [parent, child].map(|link| self.place(link, &coupling, at));
        self.joint_text += &format!(
            "\n[joints.{coupling}]\ntype    = \"rack\"\nbetween = [\"{pinion}\", \"{rack}\"]\ncarrier = \"{carrier}\"\naxis    = {}\nradius  = {}\ndisplacement = {}\n",
            pair(along),
            number(radius),
            number(displacement)
        );
    }
}
