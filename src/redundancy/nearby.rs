//! Random poses near one that fulfils the loop equations, which fulfil them too: a rank that is the largest of all of them is that of the motion.

use cotree_fmu::constraints::poses::{Loops, scaled};
use cotree_fmu::linalg::least_squares::project;
use cotree_fmu::machine::Machine;
use cotree_fmu::math::Random;
use cotree_fmu::model::{Model, State};

/// Poses whose loops are closed this well, relative to the scales, satisfy them: as well as those with which runs begin.
pub(super) const CLOSED: f64 = 1e-9;

/// Consistent poses near a state, the state itself first: random moves in all coordinates (up to `reach` in units of
/// their scales) and in time (up to `reach` seconds), then back to the loops, in so many parts of the way. The same every time; moves from which there is
/// no way back are left out.
pub fn consistent_poses(model: &Model, state: &State, samples: usize, reach: f64, parts: usize) -> Vec<State> {
    let mut random = Random::new(2);
    let mut machine = Machine::new(model);
    let mut poses = vec![state.clone()];
    for _ in 0..samples {
        let time = reach * random.symmetric().abs();
        let moves: Vec<f64> = (0..model.mechanical()).map(|_| reach * random.symmetric()).collect();
        poses.extend(moved(model, &mut machine, state, (time, &moves), reach.min(0.5), parts));
    }
    poses
}

/// The pose after a move in so many parts, each followed by the way back to the loops; none if there is no way back.
fn moved(
    model: &Model,
    machine: &mut Machine,
    state: &State,
    (time, moves): (f64, &[f64]),
    longest: f64,
    parts: usize,
) -> Option<State> {
    let mut pose = state.clone();
    let mut x = scaled(model, state);
    for part in 1..=parts {
        model.advance_signals(state, state.time() + time * part as f64 / parts as f64, pose.registers_mut());
        x.iter_mut().zip(moves).for_each(|(x, way)| *x += way / parts as f64);
        let mut loops = Loops { model, machine: &mut *machine, state: &mut pose, only: None };
        let r = project(&mut loops, &mut x, longest);
        // Written so that NaN is no way back.
        if !r.iter().all(|r| r.abs() <= CLOSED) {
            return None;
        }
        loops.load(&x);
    }
    Some(pose)
}
