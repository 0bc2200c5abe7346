//! How fast things can change.

use super::Implicit;
use crate::context::Context;
use crate::linalg::lane::ZERO;
use crate::math;
use crate::model::Model;
use crate::motion::Run;

/// Steps of the power method.
const POWERS: usize = 3;
impl Implicit {
    /// How fast anything can change at most, judging by the last Jacobian \[1/s\].
    pub fn rate(&self, model: &Model) -> f64 {
        self.radau.rate(|index| model.program().coordinates[index].scale)
    }

    /// About how fast anything can change where the step begins \[1/s\]: a few steps of the power method with the derivatives by q, and by v beside them. That
    /// state's signals must have been loaded before.
    pub fn fastest_rate(&mut self, context: &mut Context, run: &Run) -> f64 {
        let Context { model, machine, .. } = context;
        let (n, first) = (model.coordinates(), model.layout().positions());
        let tape = &model.program().tapes.acceleration;
        machine.load_signals(model, &run.signals.origin, run.last.end_time);
        machine.load_motion(model, &run.last.end);
        let scale = |index: usize| model.program().coordinates[index].scale;
        (0..n).for_each(|index| self.powers[index] = [scale(index) / (1.0 + index as f64); 2]);
        let sizes = |columns: &[[f64; 2]]| {
            [0, 1].map(|by| {
                let sizes = columns.iter().enumerate().map(|(index, column)| column[by].abs() / scale(index));
                sizes.fold(0.0, math::maximum)
            })
        };
        for _ in 0..POWERS {
            for (by, size) in sizes(&self.powers).into_iter().enumerate() {
                for (place, column) in self.tangents[first + by * n..].iter_mut().zip(&self.powers) {
                    place[by] = if size > 0.0 { column[by] / size } else { 0.0 };
                }
            }
            machine.run_tangents(tape, &mut self.tangents);
            for (column, &result) in self.powers.iter_mut().zip(&tape.results) {
                *column = [0, 1].map(|by| self.tangents[result as usize][by]);
            }
        }
        self.tangents[first..][..2 * n].fill(ZERO);
        let [by_q, by_v] = sizes(&self.powers);
        by_q.sqrt().max(by_v)
    }
}
