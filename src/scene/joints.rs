//! Builds joints in Rust.

use super::builder::pair;
use super::model::{Friction, Joint, JointKind, Vector};
use super::quantity::Quantity;
use super::span::Text;

impl Joint {
    fn of(kind: JointKind, first: &str, second: &str) -> Joint {
        Joint { name: Text::default(), between: pair(first, second), kind }
    }

    /// Turning about the common point.
    pub fn revolute(first: &str, second: &str) -> Joint {
        Joint::of(JointKind::Revolute { damping: None, friction: None }, first, second)
    }

    /// Sliding along an axis in the first body's frame.
    pub fn prismatic(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::of(JointKind::Prismatic { axis: axis.into(), angle: None, damping: None, friction: None }, first, second)
    }

    /// No motion.
    pub fn weld(first: &str, second: &str) -> Joint {
        Joint::of(JointKind::Weld { angle: None }, first, second)
    }

    /// A pin, the second point, in a slot along an axis in the first body's frame.
    pub fn slot(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::of(JointKind::Slot { axis: axis.into(), damping: None, friction: None }, first, second)
    }

    /// A disc about the second point that rolls on the left of a line through the first point, without slip.
    pub fn rolling(first: &str, second: &str, axis: impl Into<Vector>, radius: impl Into<Quantity>) -> Joint {
        let kind = JointKind::Rolling { axis: axis.into(), radius: radius.into(), displacement: None };
        Joint::of(kind, first, second)
    }

    /// A massless rod between two points.
    pub fn distance(first: &str, second: &str, length: impl Into<Quantity>) -> Joint {
        Joint::of(JointKind::Distance { length: length.into() }, first, second)
    }

    /// Two wheels that turn in a constant ratio, seen from the ground.
    pub fn gear(first: &str, second: &str, ratio: impl Into<Quantity>) -> Joint {
        Joint::of(JointKind::Gear { carrier: None, ratio: ratio.into(), angle: None }, first, second)
    }

    /// A pinion, the first body, that moves a rack, the second point, along an axis in the carrier's frame.
    pub fn rack(pinion: &str, rack: &str, axis: impl Into<Vector>, radius: impl Into<Quantity>) -> Joint {
        let kind = JointKind::Rack { carrier: None, axis: axis.into(), radius: radius.into(), displacement: None };
        Joint::of(kind, pinion, rack)
    }

    /// The body that carries a pair of gears, or the point of it from which a rack's displacement counts; others have none.
    #[must_use]
    pub fn carrier(mut self, name: &str) -> Joint {
        if let JointKind::Gear { carrier, .. } | JointKind::Rack { carrier, .. } = &mut self.kind {
            *carrier = Some(Text::from(name));
        }
        self
    }

    /// Viscous friction of a revolute [N.m.s], prismatic or slot [N.s/m] joint; others have none.
    #[must_use]
    pub fn damping(mut self, value: impl Into<Quantity>) -> Joint {
        if let JointKind::Revolute { damping, .. }
        | JointKind::Prismatic { damping, .. }
        | JointKind::Slot { damping, .. } = &mut self.kind
        {
            *damping = Some(value.into());
        }
        self
    }

    /// Dry friction of a revolute [N.m], prismatic or slot \[N\] joint, and the velocity below which it fades; others have none.
    #[must_use]
    pub fn friction(mut self, coulomb: impl Into<Quantity>, velocity: impl Into<Quantity>) -> Joint {
        if let JointKind::Revolute { friction, .. }
        | JointKind::Prismatic { friction, .. }
        | JointKind::Slot { friction, .. } = &mut self.kind
        {
            *friction = Some(Friction { coulomb: coulomb.into(), velocity: velocity.into() });
        }
        self
    }

    /// The second body's angle minus the first's in a prismatic joint or weld; the second wheel's angle where the first's is zero in
    /// a gear pair; others have none.
    #[must_use]
    pub fn angle(mut self, value: impl Into<Quantity>) -> Joint {
        if let JointKind::Prismatic { angle, .. } | JointKind::Weld { angle } | JointKind::Gear { angle, .. } =
            &mut self.kind
        {
            *angle = Some(value.into());
        }
        self
    }

    /// The displacement of a rack or a rolling disc where the angle is zero \[m\]; others have none.
    #[must_use]
    pub fn displacement(mut self, value: impl Into<Quantity>) -> Joint {
        if let JointKind::Rolling { displacement, .. } | JointKind::Rack { displacement, .. } = &mut self.kind {
            *displacement = Some(value.into());
        }
        self
    }
}
