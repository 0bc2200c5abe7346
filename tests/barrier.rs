//! The model `barrier`, motor, controller, stop and friction on one freedom, against its equations in the angle, integrated by classical Runge-Kutta steps that end where the barrier strikes, turns or slips.

use std::fmt::Write as _;

use crate::ROOT;
use crate::support::run::{model, scene_of, started, value};
use cotree_fmu::program::Engine;

const OUTPUTS: [&str; 6] = ["hinge.angle", "hinge.omega", "hinge.sliding", "hinge.mode", "volts", "motor.current"];
/// Friction while it slides [N.m], and by how much it is larger at rest.
const FRICTION: [f64; 2] = [6.0, 1.5];
const STOP: f64 = 80.0 * std::f64::consts::PI / 180.0;
const REBOUND: f64 = 0.3;
const GAINS: [f64; 2] = [30.0, 12.0];
/// Length of a step [s].
const STEP: f64 = 2e-5;
/// Slower than this the barrier strikes no more [rad/s].
const RESTS: f64 = 1e-7;

/// Angle, its rate, current, integral of the controller.
type Motion = [f64; 4];

/// The barrier: where it is, which way it slides, if it moves, and whether the stop holds it.
struct Barrier {
    motion: Motion,
    slides: Option<f64>,
    at_stop: bool,
}

/// The torque of motor, weight and spring.
fn torque([angle, _, current, _]: Motion) -> f64 {
    40.0 * 0.06 * current - 7.0 * 9.81 * 0.3 * angle.cos() + 12.0 * (std::f64::consts::FRAC_PI_2 - angle)
}

/// The voltage within its limits, and the one that the controller wants.
fn volts([angle, _, _, integral]: Motion, course: f64) -> [f64; 2] {
    let wanted = GAINS[0] * (course - angle) + integral;
    [wanted.clamp(-24.0, 24.0), wanted]
}

impl Barrier {
    fn rates(&self, motion: Motion, course: f64) -> Motion {
        let [angle, omega, current, _] = motion;
        let [given, wanted] = volts(motion, course);
        let inertia = 2.4 + 7.0 * 0.3 * 0.3;
        let [rate, acceleration] =
            self.slides.map_or([0.0; 2], |way| [omega, (torque(motion) - way * FRICTION[0]) / inertia]);
        let drop = 1.2 * current + 40.0 * 0.06 * rate;
        let integral = GAINS[1] * (course - angle) + (given - wanted) * GAINS[1] / GAINS[0];
        [rate, acceleration, (given - drop) / 3e-3, integral]
    }

    fn stepped(&self, h: f64, course: f64) -> Motion {
        let y = self.motion;
        let along = |k: Motion, share: f64| -> Motion { std::array::from_fn(|i| y[i] + share * h * k[i]) };
        let one = self.rates(y, course);
        let two = self.rates(along(one, 0.5), course);
        let three = self.rates(along(two, 0.5), course);
        let four = self.rates(along(three, 1.0), course);
        std::array::from_fn(|i| y[i] + h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]))
    }

    /// Does it strike or turn until then, or slip?
    fn changes(&self, there: Motion) -> bool {
        let holds = FRICTION[0] * FRICTION[1];
        match self.slides {
            Some(way) => there[1] * way < 0.0 || there[0] > STOP,
            None => torque(there) < -holds || torque(there) > holds && !self.at_stop,
        }
    }

    fn step(&mut self, course: f64) {
        let mut left = STEP;
        while self.changes(self.stepped(left, course)) {
            let [mut before, mut behind] = [0.0, left];
            for _ in 0..60 {
                let middle = 0.5 * (before + behind);
                *(if self.changes(self.stepped(middle, course)) { &mut behind } else { &mut before }) = middle;
            }
            let strikes = self.slides.is_some() && STOP - self.stepped(before, course)[0] < 1e-13;
            self.motion = self.stepped(before, course);
            left -= behind;
            self.change(strikes);
        }
        self.motion = self.stepped(left, course);
    }

    fn change(&mut self, strikes: bool) {
        let torque = torque(self.motion);
        if strikes {
            self.motion[0] = STOP;
            self.motion[1] *= -REBOUND;
            self.at_stop = self.motion[1].abs() < RESTS;
            self.slides = (!self.at_stop).then_some(-1.0);
        } else if self.slides.is_some() {
            self.slides = (torque.abs() > FRICTION[0] * FRICTION[1]).then_some(torque.signum());
        } else {
            (self.slides, self.at_stop) = (Some(torque.signum()), false);
        }
        if self.slides.is_none() || !strikes {
            self.motion[1] = 0.0;
        }
    }

    /// The outputs. Where it rests at the stop, this holds what pushes outwards, and friction the rest.
    fn row(&self, course: f64) -> [f64; 6] {
        let presses = self.at_stop && torque(self.motion) > 0.0;
        let [angle, omega, current, _] = self.motion;
        let [given, _] = volts(self.motion, course);
        [angle, omega, self.slides.unwrap_or(0.0), f64::from(u8::from(presses)), given, current]
    }
}

/// The course: up further than the stop lets it, down after 3.01 s.
fn course(step: usize) -> f64 {
    if step < 150_500 { std::f64::consts::FRAC_PI_2 } else { std::f64::consts::FRAC_PI_6 }
}

#[test]
fn the_barrier_follows_its_equations_in_one_angle() {
    let path = format!("{ROOT}/models/barrier/expected.csv");
    let mut own = Barrier { motion: [0.0; 4], slides: None, at_stop: false };
    let mut rows = vec![own.row(course(0))];
    for step in 0..300_000 {
        own.step(course(step));
        if (step + 1) % 1250 == 0 {
            rows.push(own.row(course(step + 1)));
        }
    }
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let mut text = format!("time,{}\n", OUTPUTS.join(","));
        for (index, row) in rows.iter().enumerate() {
            let cells: Vec<String> = row.iter().map(|cell| format!("{cell:?}")).collect();
            let _ = writeln!(text, "{:?},{}", index as f64 / 40.0, cells.join(","));
        }
        std::fs::write(&path, text).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    let stored: Vec<Vec<f64>> =
        stored.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(stored.len(), rows.len());
    for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
        let mut run = started(&model(&scene_of("barrier")), engine, 6.0, 1e-10);
        for (stored, own) in stored.iter().zip(&rows) {
            if stored[0] > 0.0 {
                run.step_to(stored[0]).unwrap();
            }
            // Which of stop and friction holds what rests is each method's own.
            let shared = engine.is_some() && own[0] > STOP - 1e-9 && own[1] == 0.0;
            for ((name, expected), stored_value) in OUTPUTS.iter().zip(own).zip(&stored[1..]) {
                if shared && ["hinge.sliding", "hinge.mode"].contains(name) {
                    continue;
                }
                let found = value(&mut run, name);
                let close = |other: f64| (other - expected).abs() < 1e-7 * (1.0 + expected.abs());
                let told = format!("{name} at {} s by {engine:?}", stored[0]);
                assert!(close(found) && close(*stored_value), "{told}: {found}, stored {stored_value}, not {expected}");
            }
        }
    }
}
