//! The random families of the hard set that are compared with references: one file and one line each.

use super::{Case, branched, cranks, driven, far_starts, flaps, poles, steep, switches_at_poses, switching, unlike};

/// A family of mechanisms.
pub struct Family {
    /// The row of its members in the table.
    pub name: &'static str,
    /// The member of a seed.
    pub member: fn(u64) -> Case,
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> &'static Self {
        FAMILIES.iter().find(|family| family.name == name).expect("a family of this name")
    }
}

pub const FAMILIES: &[Family] = &[
    Family { name: "stiff flap at change points", member: flaps::flap },
    Family { name: "very stiff flap at change points", member: flaps::very_stiff },
    Family { name: "redundant cranks", member: cranks::redundant },
    Family { name: "redundant cranks from a line", member: cranks::in_line },
    Family { name: "three cranks, nearly flat", member: cranks::three_cranks },
    Family { name: "driven past a change point", member: driven::four_bar },
    Family { name: "driven up to a change point", member: driven::touching },
    Family { name: "driver with a corner", member: driven::corner },
    Family { name: "loop far away", member: far_starts::loop_far_away },
    Family { name: "carriage far away", member: far_starts::carriage_far_away },
    Family { name: "torque that jumps every 2 ms", member: switching::torque },
    Family { name: "switch near a change point", member: switches_at_poses::switching },
    Family { name: "chain with unlike masses", member: unlike::unlike_end },
    Family { name: "unlike masses, branched", member: branched::branched },
    Family { name: "steep: belt", member: steep::belt },
    Family { name: "steep: block on spring", member: steep::rest },
    Family { name: "steep: two contacts", member: steep::two_contacts },
    Family { name: "steep: brake", member: steep::brake },
    Family { name: "steep: pendulum", member: steep::pendulum },
    Family { name: "steep: bump in time", member: steep::bump_in_time },
    Family { name: "steep: bump in position", member: steep::bump_in_position },
    Family { name: "steep: train of bumps", member: steep::train },
    Family { name: "steep: train of bumps in position", member: steep::train_in_position },
    Family { name: "steep: train of pulses", member: steep::pulses },
    Family { name: "steep: logistic", member: steep::logistic },
    Family { name: "steep: stop", member: steep::stop },
    Family { name: "steep: if and min", member: steep::pieces },
    Family { name: "steep: spring past its anchor", member: steep::anchor },
    Family { name: "steep: rational pulse", member: poles::pulse },
    Family { name: "steep: rational bump", member: poles::bump },
    Family { name: "steep: root that turns round", member: poles::root },
];
