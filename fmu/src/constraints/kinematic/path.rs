//! What carries a driven mechanism along: time, or the change of what has been set.

use crate::constraints::loops::Loops;
use crate::machine::Machine;
use crate::model::{Model, State};

/// A curve of poses q(s), given by loop equations that depend on s.
#[derive(Clone, Copy, Debug)]
pub(super) enum Path<'a> {
    /// s is time; inputs and what follows them continue from this state.
    Time(&'a State),
    /// s goes from 0 to 1, and with it time, parameters and inputs from one state to another.
    Change(&'a State, &'a State),
}

/// Storage for derivatives along a path.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    tangents: Vec<f64>,
    residuals: Vec<f64>,
}

impl Directions {
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        Self { tangents: vec![0.0; program.registers as usize], residuals: vec![0.0; program.constraints.len()] }
    }

    /// dq/ds at the registers, which the loops are factored at. Along time it is left there as v.
    pub fn slope(
        &mut self,
        path: Path,
        (model, machine): (&Model, &mut Machine),
        loops: &mut Loops,
        slope: &mut [f64],
    ) {
        match path {
            Path::Time(_) => {
                slope.fill(0.0);
                machine.load_rates(model, slope);
                machine.evaluate(&model.program().tapes.constraint_rate, &mut self.residuals);
            }
            Path::Change(before, after) => {
                let signals = model.layout().positions();
                self.tangents.fill(0.0);
                let ends = before.registers()[..signals].iter().zip(&after.registers()[..signals]);
                self.tangents.iter_mut().zip(ends).for_each(|(tangent, (from, to))| *tangent = to - from);
                machine.differentiate(&model.program().tapes.parameters, &mut self.tangents, &mut []);
                machine.differentiate(&model.program().tapes.constraint, &mut self.tangents, &mut self.residuals);
            }
        }
        slope.iter_mut().zip(loops.solve(&self.residuals)).for_each(|(slope, value)| *slope = -value);
        if matches!(path, Path::Time(_)) {
            machine.load_rates(model, slope);
        }
    }

    /// d2q/ds2 at the registers, where the slope is known; of a change the first derivative must do.
    pub fn curvature(
        &mut self,
        path: Path,
        (model, machine): (&Model, &mut Machine),
        loops: &mut Loops,
        curvature: &mut [f64],
    ) {
        match path {
            Path::Time(_) => {
                machine.evaluate(&model.program().tapes.gamma, &mut self.residuals);
                curvature.copy_from_slice(loops.solve(&self.residuals));
            }
            Path::Change(..) => curvature.fill(0.0),
        }
    }
}

impl Path<'_> {
    /// Writes time, parameters and inputs at s.
    pub fn signals(&self, model: &Model, s: f64, state: &mut State) {
        match self {
            Path::Time(origin) => model.advance_signals(origin, s, state.registers_mut()),
            Path::Change(before, after) => {
                let ends = before.registers().iter().zip(after.registers()).take(model.layout().positions());
                for (place, (from, to)) in state.registers_mut().iter_mut().zip(ends) {
                    *place = if s < 1.0 { from + s * (to - from) } else { *to };
                }
            }
        }
    }
}
