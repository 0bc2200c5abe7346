//! Parallelograms whose loads switch close to their change points, in which they may start as well: a motor that is pushed on and off, a stop, a pulse in time.
//! Nothing else acts on them, so that the crank turns like a wheel: the reference is in closed form.

use std::f64::consts::PI;

use cotree::scene::Load;

use super::Case;
use super::four_bar::FourBar;
use super::random::Random;
use super::reference::Reference;

/// How long the runs are [s].
const STOP: f64 = 1.0;
const POINTS: usize = 40;

/// Where a piece of the torque ends.
#[derive(Clone, Copy)]
enum End {
    Angle(f64),
    Time(f64),
}

/// The crank as a wheel.
#[derive(Clone, Copy)]
struct Wheel {
    inertia: f64,
    start: f64,
    speed: f64,
}

impl Wheel {
    /// Angle and rate at a time, with pieces of constant torque one after the other, the first of which is zero.
    fn pushed(self, torques: [f64; 2], ends: [End; 2], time: f64) -> [f64; 2] {
        let [mut angle, mut rate, mut now] = [self.start, self.speed, 0.0];
        for (torque, end) in [0.0].into_iter().chain(torques).zip(ends.into_iter().chain([End::Time(f64::INFINITY)])) {
            let acceleration = torque / self.inertia;
            let whole = match end {
                End::Time(end) => end - now,
                End::Angle(end) => {
                    let way = end - angle;
                    2.0 * way / (rate + (rate * rate + 2.0 * acceleration * way).sqrt())
                }
            };
            let part = whole.min(time - now);
            angle += part * (rate + 0.5 * acceleration * part);
            rate += acceleration * part;
            now += part;
        }
        [angle, rate]
    }

    /// The same with a spring from an angle on.
    fn stopped(self, stiffness: f64, at: f64, time: f64) -> [f64; 2] {
        let (frequency, meets) = ((stiffness / self.inertia).sqrt(), (at - self.start) / self.speed);
        let phase = frequency * (time - meets);
        match phase {
            _ if phase <= 0.0 => [self.start + self.speed * time, self.speed],
            _ if phase <= PI => [at + self.speed / frequency * phase.sin(), self.speed * phase.cos()],
            _ => [at - self.speed * (time - meets - PI / frequency), -self.speed],
        }
    }
}

/// A parallelogram with a load that switches at an angle, or at a time, close to a change point.
pub fn switching(seed: u64) -> Case {
    let mut random = Random(seed);
    let [arm, long] = [random.between(0.3, 0.6), random.between(0.8, 1.2)];
    let mut bars = FourBar::new(arm, long, arm, long);
    (bars.masses, bars.gravity) = ([0.0; 3].map(|_| random.between(0.3, 2.0)), 0.0);
    let inertia = ((bars.masses[0] + bars.masses[2]) / 3.0 + bars.masses[1]) * arm * arm;
    let (in_line, side) = (random.unit() < 0.3, (random.unit() - 0.5).signum());
    let (start, pose) = if in_line { (0.0, 0.0) } else { (random.between(0.3, 2.5), PI) };
    let wheel = Wheel { inertia, start, speed: random.between(3.0, 9.0) };
    let before = if in_line || random.unit() < 0.5 { 1.0 } else { -1.0 };
    let at = pose + before * 10.0_f64.powf(random.between(-7.0, -0.6));
    let turned = if side > 0.0 { "crank.angle" } else { "-crank.angle" };
    let energy = 0.5 * inertia * wheel.speed * wheel.speed;
    let then = at + 10.0_f64.powf(random.between(-3.0, -0.3));
    let torques = [random.between(-0.5, 1.0) * energy / (then - at).max(0.05), random.between(-0.02, 0.1) * energy];
    let [one, two] = torques;
    let meets = (at - start) / wheel.speed;
    let ends = match seed % 3 {
        0 => [at, then].map(End::Angle),
        _ => [meets, meets + random.between(1e-3, 0.1)].map(End::Time),
    };
    let stiffness = inertia * (wheel.speed * random.between(1.0, 20.0)).powi(2);
    let law = match (seed % 3, ends) {
        (1, _) => format!("-{stiffness:?}*max(0, ({turned}) - {at:?})"),
        (_, [End::Time(on), End::Time(off)]) => format!("if(t < {on:?}, 0, if(t < {off:?}, {one:?}, {two:?}))"),
        _ => format!("if({turned} < {at:?}, 0, if({turned} < {then:?}, {one:?}, {two:?}))"),
    };
    let motion = |time: f64| match seed % 3 {
        1 => wheel.stopped(stiffness, at, time),
        _ => wheel.pushed(torques, ends, time),
    };
    let name = format!("switch_{seed}");
    let mut scene = bars.scene_from(&name, [side * start, 0.0, side * start], side * wheel.speed);
    if in_line {
        scene = scene.initial("coupler.omega", 0.0);
    }
    let times: Vec<f64> = (1..=POINTS).map(|k| STOP * k as f64 / POINTS as f64).collect();
    let values = times.iter().map(|&time| {
        let [angle, rate] = motion(time).map(|value| side * value);
        vec![angle, rate, 0.0, angle, rate]
    });
    let names = ["crank.angle", "crank.omega", "coupler.angle", "rocker.angle", "rocker.omega"].map(String::from);
    let reference = Reference { names: names.into(), values: values.collect(), times };
    let scene = scene.load("motor", Load::torque("ground", "crank", format!("{side:?}*({law})")));
    Case::new("switch near a change point", scene, STOP, vec![bars.law()]).driven().against(reference)
}
