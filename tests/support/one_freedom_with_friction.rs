//! A mechanism of one degree of freedom with dry friction and stops, as one equation of motion: inertia x acceleration = force - direction x level while it slides; at rest it sticks while the force is within the level at rest.
//!
//! Steps of the classical Runge-Kutta method that end where a rate falls to zero, a stop is reached, or the force exceeds what holds. However many parts rub at the one degree of freedom, they are one level here: nothing is said
//! of how they share it, and no sets are tried. So it shares no idea with the product.

/// What moves.
pub struct Moving {
    /// Acceleration at a time, place and rate, while it slides one way or the other.
    pub slides: Box<dyn Fn(f64, f64, f64, f64) -> f64>,
    /// At rest: the force that friction has to bear, and how much it can.
    pub rests: Box<dyn Fn(f64, f64) -> [f64; 2]>,
    /// Between these it can move, with the share of the speed with which it comes back.
    pub stops: [f64; 2],
    pub restitution: f64,
    /// The rates that a freewheel permits.
    pub rates: [f64; 2],
    /// Where laws jump.
    pub jumps: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Rests,
    Slides(f64),
}

/// Short beside the way to a corner of the level, within which a step is of first order.
const STEP: f64 = 2e-5;
/// The last stage of a step lies so long before its end, on this side of a law that jumps there \[s\].
const BEFORE: f64 = 1e-11;
const HALVINGS: u32 = 60;
/// A flight that is shorter ends a series of bounces \[s\].
const SHORTEST: f64 = 1e-7;

impl Moving {
    fn step(&self, [t, s, v]: [f64; 3], h: f64, direction: f64) -> [f64; 3] {
        let slope = |t: f64, s: f64, v: f64| [v, (self.slides)(t, s, v, direction)];
        let one = slope(t, s, v);
        let two = slope(t + 0.5 * h, s + 0.5 * h * one[0], v + 0.5 * h * one[1]);
        let three = slope(t + 0.5 * h, s + 0.5 * h * two[0], v + 0.5 * h * two[1]);
        let four = slope(t + h - BEFORE, s + h * three[0], v + h * three[1]);
        let mean = [0, 1].map(|i| (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]) / 6.0);
        [t + h, s + h * mean[0], v + h * mean[1]]
    }

    /// What it does from a state on: at rest it begins to move only where the force overcomes the friction and nothing else is in the way.
    fn mode(&self, [t, s, v]: [f64; 3]) -> Mode {
        if v != 0.0 {
            return Mode::Slides(v.signum());
        }
        let [force, level] = (self.rests)(t, s);
        let blocked = if force > 0.0 {
            s >= self.stops[1] || self.rates[1] <= 0.0
        } else {
            s <= self.stops[0] || self.rates[0] >= 0.0
        };
        if force.abs() <= level || blocked { Mode::Rests } else { Mode::Slides(force.signum()) }
    }

    /// True if a mode has ended at a state.
    fn has_ended(&self, mode: Mode, state: [f64; 3]) -> bool {
        match mode {
            Mode::Rests => self.mode(state) != Mode::Rests,
            Mode::Slides(direction) => {
                direction * state[2] < 0.0 || state[1] < self.stops[0] || state[1] > self.stops[1]
            }
        }
    }

    fn moved(&self, mode: Mode, [t, s, v]: [f64; 3], h: f64) -> [f64; 3] {
        match mode {
            Mode::Rests => [t + h, s, 0.0],
            Mode::Slides(direction) => self.step([t, s, v], h, direction),
        }
    }

    /// The state at a mode's end: it stops, strikes, or breaks away.
    fn after(&self, mode: Mode, [t, s, v]: [f64; 3]) -> [f64; 3] {
        let Mode::Slides(direction) = mode else { return [t, s, 0.0] };
        if direction * v <= 0.0 {
            return [t, s, 0.0];
        }
        let [low, high] = self.stops;
        let stop = if s < low { low } else { high };
        let back = -self.restitution * v;
        let deceleration = (self.slides)(t, stop, back, -direction).abs();
        [t, stop, if back.abs() < SHORTEST * deceleration { 0.0 } else { back }]
    }

    /// Moves a state on to a time.
    pub fn run(&self, mut state: [f64; 3], until: f64) -> [f64; 3] {
        while state[0] < until {
            let next = self.jumps.iter().copied().filter(|jump| *jump > state[0] + 1e-12).fold(until, f64::min);
            let (mode, whole) = (self.mode(state), STEP.min(next - state[0]));
            let reached = self.moved(mode, state, whole);
            if !self.has_ended(mode, reached) {
                state = if whole < STEP { [next, reached[1], reached[2]] } else { reached };
                continue;
            }
            let (mut from, mut to) = (0.0, whole);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (from + to);
                if self.has_ended(mode, self.moved(mode, state, middle)) { to = middle } else { from = middle }
            }
            state = self.after(mode, self.moved(mode, state, to));
        }
        state
    }
}
