//! Comparisons whose sides stay equal to within rounding errors for longer than a step.
//!
//! In a parallelogram `if(crank.angle < rocker.angle, 1, -1)` is decided by rounding errors, and no step is wrong about it: the motion is one of several, and the user should know. Where the sides
//! are equal to the last bit nothing is open, for the comparison says what holds; nor where both pieces accelerate the mechanism alike, as those of `abs` and `max` do.

use crate::context::Context;
use crate::events::sliding::JUMPS;
use crate::machine::ROUNDING;
use crate::math;
use crate::model::Model;
use crate::motion::Run;
use crate::program::Steep;

/// So many ends of steps in a row, at which sides are equal to within rounding errors, are longer than a step.
const ENDS: u32 = 3;
/// Sides further apart are not looked at more closely, whatever their size is.
const SIDES_APART: f64 = 1e-9;
/// Both sides of a comparison are looked at this share of time, coordinates and rates away: far more than their rounding errors.
const PERTURBATION: f64 = 1e-9;
/// A smaller share of an acceleration is no jump.
const FELT: f64 = 1e-6;
/// Directions in which time, coordinates and rates change by a share of themselves: parts of a side that cancel in one do not in another.
const PERTURBED_DIRECTIONS: u32 = 2;

/// What is known of the comparisons of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Comparisons {
    all: Vec<Comparison>,
    /// The last end of a step that was looked at \[s\].
    time: f64,
    tangents: Vec<f64>,
    changes: Vec<f64>,
    motion: Vec<f64>,
    /// Before the comparison changes over, behind it, and as far on again.
    accelerations: [Vec<f64>; 3],
    found: Option<(f64, usize)>,
    reported: bool,
}

/// A switching function of the laws.
#[derive(Clone, Copy, Debug, Default)]
struct Comparison {
    law: usize,
    /// So many ends of steps in a row its sides have been equal to within rounding errors; since when \[s\], and have they ever differed?
    ends: u32,
    since: f64,
    differs: bool,
    /// By how much it changes if everything changes by all of itself, and in which direction.
    size: f64,
    direction: u32,
}

impl Comparisons {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let laws = &model.program().tapes.laws;
        let switching = laws.kinds.iter().enumerate().filter(|(_, kind)| **kind == Steep::Switching);
        let all: Vec<Comparison> = switching.map(|(law, _)| Comparison { law, ..Comparison::default() }).collect();
        if all.is_empty() {
            return Self::default();
        }
        let n = model.coordinates();
        Self {
            all,
            tangents: vec![0.0; model.program().registers as usize],
            changes: vec![0.0; laws.kinds.len()],
            motion: vec![0.0; 2 * n],
            accelerations: [(); 3].map(|()| vec![0.0; n]),
            ..Self::default()
        }
    }

    /// The motion goes on from elsewhere.
    pub fn forget(&mut self) {
        self.all.iter_mut().for_each(|pair| pair.ends = 0);
    }

    /// Since when sides stay together, and which coordinate that accelerates; once.
    pub fn take(&mut self) -> Option<(f64, usize)> {
        let found = self.found.take();
        self.reported |= found.is_some();
        found
    }

    /// Looks at the end of the last step.
    pub fn note(&mut self, context: &mut Context, run: &Run) {
        let time = run.last.end_time;
        if self.all.is_empty() || self.reported || self.found.is_some() || self.time == time {
            return;
        }
        self.time = time;
        self.load(context, run, [0.0; 2], 0);
        let tape = &context.model.program().tapes.laws.tape;
        context.machine.run(tape);
        let near =
            self.all.iter().any(|pair| (1e-300..SIDES_APART).contains(&context.machine.result(tape, pair.law).abs()));
        if near {
            self.measure(context);
        }
        for index in 0..self.all.len() {
            let Comparison { law, size, .. } = self.all[index];
            let apart = context.machine.result(tape, law).abs();
            let together = apart == 0.0 || near && apart <= ROUNDING * size;
            if self.all[index].counts(time, together, apart != 0.0) && self.decides(context, run, index) {
                return;
            }
        }
    }

    /// By how much each comparison changes if time, coordinates and rates change by all of themselves: the size of its sides.
    fn measure(&mut self, context: &mut Context) {
        let Context { model, machine, .. } = context;
        let tape = &model.program().tapes.laws.tape;
        self.all.iter_mut().for_each(|law| law.size = 0.0);
        for direction in 0..PERTURBED_DIRECTIONS {
            self.tangents.fill(0.0);
            for register in moving(model) {
                self.tangents[register] = sign(register, direction) * machine.registers()[register];
            }
            machine.differentiate(tape, &mut self.tangents, &mut self.changes);
            for law in &mut self.all {
                let size = self.changes[law.law].abs();
                if size > law.size {
                    (law.size, law.direction) = (size, direction);
                }
            }
        }
    }

    /// Do rounding errors of a comparison decide how the mechanism accelerates? Then that is noted.
    fn decides(&mut self, context: &mut Context, run: &Run, index: usize) -> bool {
        let Comparison { law, direction, since, .. } = self.all[index];
        let tapes = &context.model.program().tapes;
        let mut sides = [0.0; 3];
        for (place, (share, side)) in
            [-PERTURBATION, PERTURBATION, 3.0 * PERTURBATION].into_iter().zip(&mut sides).enumerate()
        {
            self.load(context, run, [share; 2], direction);
            context.machine.run(&tapes.laws.tape);
            *side = context.machine.result(&tapes.laws.tape, law);
            context.machine.evaluate(&tapes.acceleration, &mut self.accelerations[place]);
        }
        if sides[0] * sides[1] >= 0.0 {
            return false;
        }
        let [before, behind, beyond] = &self.accelerations;
        let jump = |index: usize| (behind[index] - before[index]).abs();
        let jumps = |index: &usize| {
            let (jump, on) = (jump(*index), (beyond[*index] - behind[*index]).abs());
            jump > JUMPS * on && jump > FELT * math::maximum(before[*index].abs(), behind[*index].abs())
        };
        let most = (0..before.len()).filter(jumps).max_by(|&a, &b| jump(a).total_cmp(&jump(b)));
        self.found = most.map(|coordinate| (since, coordinate));
        self.found.is_some()
    }

    /// Brings the end of the last step into the registers, with time and motion changed by a share of themselves.
    fn load(&mut self, context: &mut Context, run: &Run, [of_time, share]: [f64; 2], direction: u32) {
        let Context { model, machine, .. } = context;
        let (layout, last) = (model.layout(), &run.last);
        let changed = |register: usize, value: f64, share: f64| value * (1.0 + share * sign(register, direction));
        let time = changed(layout.time(), last.end_time, of_time);
        machine.load_signals(model, &run.signals.origin, time);
        let registers = layout.positions()..;
        for ((place, value), register) in self.motion.iter_mut().zip(&last.end).zip(registers) {
            *place = changed(register, *value, share);
        }
        machine.load_motion(model, &self.motion);
    }
}

impl Comparison {
    /// Counts an end of a step; says whether the sides have stayed together for long, but not equal.
    fn counts(&mut self, time: f64, together: bool, differs: bool) -> bool {
        if !together {
            self.ends = 0;
            return false;
        }
        if self.ends == 0 {
            (self.since, self.differs) = (time, false);
        }
        self.differs |= differs;
        self.ends += 1;
        let is_long = self.differs && self.ends >= ENDS;
        if is_long {
            self.ends = 0;
        }
        is_long
    }
}

/// The registers of time, coordinates and rates.
fn moving(model: &Model) -> impl Iterator<Item = usize> {
    let layout = model.layout();
    std::iter::once(layout.time()).chain(layout.positions()..layout.accelerations())
}

/// 1 or -1, as if by chance.
fn sign(register: usize, direction: u32) -> f64 {
    let mixed = (register as u32 + 1).wrapping_mul(2_654_435_761).wrapping_mul(2 * direction + 1);
    if mixed >> 15 & 1 == 0 { 1.0 } else { -1.0 }
}
