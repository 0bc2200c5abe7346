//! Forces that jump every two milliseconds.

use std::cell::Cell;

use cotree::scene::Load;

use super::closed_form::ClosedForm;
use super::dyad::Loop;
use super::flaps::turning;
use super::reference::Reference;
use super::{Case, Input, Random};
use crate::support::jet::Jet;

const PERIOD: f64 = 2e-3;
const COUNT: usize = 1000;
/// Results are compared after so many of the forces, and so on.
const COMPARED: i32 = 250;

/// A four-bar with change points, whose motor's torque takes another value every two milliseconds.
pub fn torque(seed: u64) -> Case {
    let bars = turning(seed);
    let mut random = Random(seed);
    let torques: Vec<f64> = (0..COUNT).map(|_| random.between(-5.0, 5.0)).collect();
    let chain = Loop::of(&bars);
    let arms = [bars.crank, bars.coupler, bars.rocker];
    let inertias = arms.iter().zip(bars.masses).map(|(l, m)| [m, m * l * l / 12.0]).collect();
    let pose = |q: &[Jet]| chain.arms(q[0]).map(|arm| arm.middle()).to_vec();
    let torque = Cell::new(0.0);
    let force = |_: f64, _: &[f64], _: &[f64]| vec![torque.get()];
    let exact = ClosedForm { inertias, pose, force, gravity: bars.gravity };
    let mut state = [vec![bars.angle], vec![bars.omega]];
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (k, &now) in (1..).zip(&torques) {
        torque.set(now);
        state = exact.states(state, &[PERIOD]).remove(0);
        if k % COMPARED == 0 {
            let [crank, rocker] = [0, 2].map(|body| exact.motion(body, &state));
            times.push(f64::from(k) * PERIOD);
            values.push(vec![crank[2], crank[5], rocker[2], rocker[5]]);
        }
    }
    let names = ["crank.angle", "crank.omega", "rocker.angle", "rocker.omega"].map(String::from).into();
    let scene = bars
        .scene(&format!("switching_{seed}"))
        .input("torque", 0.0)
        .load("motor", Load::torque("ground", "crank", "torque"));
    Case::new("torque that jumps every 2 ms", scene, PERIOD * COUNT as f64, vec![bars.law()])
        .driven()
        .input(Input { name: "torque", period: PERIOD, values: torques })
        .against(Reference { names, times, values })
}
