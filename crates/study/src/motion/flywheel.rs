//! How much the speed fluctuates under a constant drive torque, and the flywheel that keeps it within a bound.

use serde::Serialize;

use super::samples::Samples;

/// How much the speed fluctuates: the coefficient of fluctuation is (w_max - w_min)/w_mean with w_mean = (w_max + w_min)/2.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Fluctuation {
    /// That without drive and loads.
    pub free: f64,
    /// What loads take out of a constant drive torque and give back \[J\].
    pub energy: f64,
    /// The constant drive torque that the loads need [N.m].
    pub mean_torque: f64,
    /// The inertia that the loads alone need for the permitted fluctuation, energy/(C w^2), as if that of the mechanism were 0 [kg.m2].
    pub flywheel: Option<f64>,
    /// The inertia to add to that of the mechanism, which varies, for the permitted fluctuation; 0 if none is needed [kg.m2].
    pub added_inertia: Option<f64>,
}

/// The mechanism at constant drive torque: J(phi) and W(phi), the work of the drive less that of the loads.
struct FlywheelTurn<'a> {
    inertia: &'a Samples,
    work: Samples,
    speed: f64,
}

impl Fluctuation {
    /// The drive's effort at constant speed less that of the masses, J' w^2/2, is that of the loads (Eksergian 1930).
    pub(super) fn of(effort: &Samples, inertia: &Samples, speed: f64, permitted: Option<f64>) -> Fluctuation {
        let square = speed * speed;
        let load = effort.minus(&inertia.slope().map(|slope| 0.5 * slope * square));
        let taken = load.fluctuation();
        let energy = taken.max().value - taken.min().value;
        let [least, most] = [inertia.min().value.sqrt(), inertia.max().value.sqrt()];
        let turn = FlywheelTurn { inertia, work: taken.map(|taken| -taken), speed };
        Fluctuation {
            free: 2.0 * (most - least) / (most + least),
            energy,
            mean_torque: load.mean(),
            flywheel: permitted.map(|permitted| energy / (permitted * square)),
            added_inertia: permitted.map(|permitted| turn.added(permitted)),
        }
    }
}

impl FlywheelTurn<'_> {
    /// The inertia to add, by halving.
    fn added(&self, permitted: f64) -> f64 {
        let is_enough = |added: f64| self.fluctuation(added) <= permitted;
        if is_enough(0.0) {
            return 0.0;
        }
        let mut high = self.inertia.max().value;
        while !is_enough(high) && high.is_finite() {
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if is_enough(middle) { high = middle } else { low = middle }
        }
        high
    }

    /// The coefficient of fluctuation with more inertia: (J + J_f) w^2/2 = E + W, with the energy E for which the mean speed is the wanted one. That rises with E, from where
    /// the mechanism just stops in one pose.
    fn fluctuation(&self, added: f64) -> f64 {
        let ends = |energy: f64| {
            let speeds = self.inertia.with(&self.work, |inertia, work| {
                let square = 2.0 * (energy + work) / (inertia + added);
                square.max(0.0).sqrt()
            });
            [speeds.min().value, speeds.max().value]
        };
        let mean = |energy: f64| ends(energy).iter().sum::<f64>() / 2.0;
        let least = -self.work.min().value;
        let (mut low, mut high) = (least, least + 0.5 * (self.inertia.max().value + added) * self.speed * self.speed);
        for _ in 0..45 {
            let middle = 0.5 * (low + high);
            if mean(middle) < self.speed { low = middle } else { high = middle }
        }
        let [slowest, fastest] = ends(high);
        2.0 * (fastest - slowest) / (fastest + slowest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::samples::wave;

    /// With constant J the energy is (J + J_f) w^2 C, without loads w is as 1/sqrt(J + J_f).
    #[test]
    fn closed_forms() {
        let (constant, varying) = (wave(|_| 0.3), wave(|x| 0.5 + 0.2 * x.cos()));
        let loaded = Fluctuation::of(&wave(|x| 4.0 + 9.0 * x.sin()), &constant, 5.0, Some(0.1));
        assert!((loaded.added_inertia.unwrap() - (18.0 / (0.1 * 25.0) - 0.3)).abs() < 1e-8, "{loaded:?}");
        assert!((loaded.flywheel.unwrap() - 18.0 / (0.1 * 25.0)).abs() < 1e-8, "{loaded:?}");
        let effort = wave(|x| -0.1 * x.sin() * 25.0);
        let free = Fluctuation::of(&effort, &varying, 5.0, Some(0.1));
        let added = free.added_inertia.unwrap();
        let [least, most] = [0.3 + added, 0.7 + added].map(f64::sqrt);
        assert!((2.0 * (most - least) / (most + least) - 0.1).abs() < 1e-8, "{free:?}");
        assert_eq!(Fluctuation::of(&effort, &varying, 5.0, Some(0.5)).added_inertia, Some(0.0));
    }
}
