//! Laws with poles or branch points close to the motion: rational pulses and bumps, roots that turn round. Between them a law is as good as constant, or as good
//! as another branch of itself. The reference's parts are shorter than the way to the next pole in the complex plane.

use cotree::scene::{Load, Scene};

use super::closed_form::extrapolate;
use super::steep::{BLOCK, motion_of_one, push, size, smooth_guide, spring};
use super::{Case, Random};

/// A part of the reference's motion is no longer than this share of the time to the next pole, nor than so many seconds.
const SHARE: f64 = 0.25;
const LONGEST: f64 = 5e-3;
const STOP: f64 = 2.0;

/// The motion of one coordinate: its acceleration, and how far from a pole it is.
struct Motion<A, D> {
    acceleration: A,
    distance: D,
}

/// What is at a distance: in time, or on the way of the coordinate.
enum Distance {
    Time(f64),
    Way(f64),
}

impl<A: Fn(f64, f64, f64) -> f64, D: Fn(f64, f64) -> Distance> Motion<A, D> {
    /// x and its rate at these times.
    fn states(&self, start: [f64; 2], times: &[f64]) -> Vec<Vec<f64>> {
        let rates = |t: f64, y: &[f64]| vec![y[1], (self.acceleration)(t, y[0], y[1])];
        let (mut time, mut y) = (0.0, start.to_vec());
        let mut state = |&target: &f64| {
            while time < target {
                let end = f64::min(time + self.part(time, &y), target);
                y = extrapolate(&rates, [time, end], &y);
                time = end;
            }
            y.clone()
        };
        times.iter().map(&mut state).collect()
    }

    fn part(&self, time: f64, y: &[f64]) -> f64 {
        let far = match (self.distance)(time, y[0]) {
            Distance::Time(far) => far,
            // As fast as it is, or will be by the force that acts.
            Distance::Way(far) => {
                let force = (self.acceleration)(time, y[0], y[1]).abs();
                f64::min(far / y[1].abs(), (far / force).sqrt())
            }
        };
        f64::min(LONGEST, SHARE * far)
    }

    fn case(&self, family: &'static str, scene: Scene, start: [f64; 2]) -> Case {
        motion_of_one(family, scene, (BLOCK, STOP), start, |times| Some(self.states(start, times)))
    }
}

/// A peak of height one about u = 0.
struct Peak {
    text: &'static str,
    value: fn(f64) -> f64,
    /// Its integral, about.
    area: f64,
}

const PEAKS: [Peak; 7] = [
    Peak { text: "1/(1+U^2)", value: |u| 1.0 / (1.0 + u * u), area: 3.1 },
    Peak { text: "1/(1+U^4)", value: |u| 1.0 / (1.0 + u.powi(4)), area: 2.2 },
    Peak { text: "1/(1+U^8)", value: |u| 1.0 / (1.0 + u.powi(8)), area: 2.1 },
    Peak { text: "(1+U^2)^(-1.5)", value: |u| (1.0 + u * u).powf(-1.5), area: 2.0 },
    Peak { text: "1/(1+abs(U)^3)", value: |u| 1.0 / (1.0 + u.abs().powi(3)), area: 2.4 },
    Peak { text: "1/sqrt(1+U^6)", value: |u| 1.0 / (1.0 + u.powi(6)).sqrt(), area: 2.8 },
    Peak { text: "1/((1+U^2)*(1+(U-5)^2))", value: |u| 1.0 / ((1.0 + u * u) * (1.0 + (u - 5.0).powi(2))), area: 0.2 },
];

/// A push at some time.
pub fn pulse(seed: u64) -> Case {
    let mut random = Random(8100 + seed);
    let peak = &PEAKS[seed as usize % PEAKS.len()];
    let (center, width) = (random.between(0.2, 1.8), size(&mut random, 1e-6, 1e-2));
    let (force, k) = (random.between(0.3, 3.0) / (width * peak.area), size(&mut random, 5.0, 200.0));
    let law = format!("{force}*{}", peak.text.replace('U', &format!("((t-{center})/{width})")));
    let acceleration = |t: f64, x: f64, _: f64| force * (peak.value)((t - center) / width) - k * x;
    let motion = Motion { acceleration, distance: |t: f64, _| Distance::Time((t - center).hypot(width)) };
    let start = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
    motion.case("steep: rational pulse", spring(push(smooth_guide("pulse", seed), &law), k), start)
}

/// A push at some place on the way of an oscillating block, often where it turns round shortly after.
pub fn bump(seed: u64) -> Case {
    let mut random = Random(8200 + seed);
    let peak = &PEAKS[seed as usize % PEAKS.len()];
    let (k, far, width) = (size(&mut random, 2.0, 60.0), random.between(0.2, 1.0), size(&mut random, 1e-6, 1e-2));
    let center =
        if seed.is_multiple_of(3) { random.between(-0.8, 0.8) } else { 1.0 - size(&mut random, 1e-3, 0.3) } * far;
    let share = [0.2, -0.2, 0.05][seed as usize / PEAKS.len() % 3];
    let force = share * 0.5 * k * (far * far - center * center) / (width * peak.area);
    let law = format!("{force}*{}", peak.text.replace('U', &format!("((block.x-{center})/{width})")));
    let acceleration = |_: f64, x: f64, _: f64| force * (peak.value)((x - center) / width) - k * x;
    let motion = Motion { acceleration, distance: |_, x: f64| Distance::Way((x - center).hypot(width)) };
    motion.case("steep: rational bump", spring(push(smooth_guide("bump", seed), &law), k), [-far, 0.0])
}

/// A block that passes the point where its spring is fixed and comes back soon, or that hardly touches a stop that is a root.
pub fn root(seed: u64) -> Case {
    let mut random = Random(8300 + seed);
    let aside = size(&mut random, 1e-8, 1e-2);
    if seed.is_multiple_of(2) {
        let (k, free) = (random.between(10.0, 60.0), random.between(0.1, 0.6));
        let (x, v) = (random.between(0.3, 0.7), random.between(0.0, 5.0));
        let scene = smooth_guide("root", seed).ground_point("anchor", [0.0, aside]);
        let scene = scene.load("spring", Load::spring("ground.anchor", "block", k).free(free));
        let acceleration = |_: f64, x: f64, _: f64| -k * (1.0 - free / x.hypot(aside)) * x;
        let motion = Motion { acceleration, distance: |_, x: f64| Distance::Way(x.hypot(aside)) };
        return motion.case("steep: root that turns round", scene, [x, -v]);
    }
    let (k, stiff, far) = (size(&mut random, 5.0, 60.0), size(&mut random, 1e2, 1e4), random.between(0.2, 1.0));
    let edge = far * (1.0 - size(&mut random, 1e-3, 0.3));
    let u = format!("(block.x-{edge})");
    let law = format!("-{}*({u}+sqrt({u}^2+{}))", 0.5 * stiff, aside * aside);
    let acceleration = |_: f64, x: f64, _: f64| -k * x - 0.5 * stiff * ((x - edge) + (x - edge).hypot(aside));
    let motion = Motion { acceleration, distance: |_, x: f64| Distance::Way((x - edge).hypot(aside)) };
    motion.case("steep: root that turns round", spring(push(smooth_guide("edge", seed), &law), k), [-far, 0.0])
}
