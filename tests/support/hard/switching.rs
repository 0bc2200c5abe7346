//! Forces that jump every two milliseconds.

use cotree::scene::Load;

use super::closed_form::ClosedForm;
use super::dyad::Loop;
use super::flaps::turning;
use super::reference::Reference;
use super::{Case, Input, Random};
use crate::support::jet::Jet;

const PERIOD: f64 = 2e-3;
const COUNT: usize = 1000;

/// A four-bar with change points, whose motor's torque takes another value every two milliseconds.
pub fn torque(seed: u64) -> Case {
    let bars = turning(seed);
    let mut random = Random(seed);
    let torques: Vec<f64> = (0..COUNT).map(|_| random.between(-5.0, 5.0)).collect();
    let chain = Loop::of(&bars);
    let arms = [bars.crank, bars.coupler, bars.rocker];
    let inertias = arms.iter().zip(bars.masses).map(|(l, m)| [m, m * l * l / 12.0]).collect();
    let pose = |q: &[Jet]| chain.arms(q[0]).map(|arm| arm.middle()).to_vec();
    let force = |t: f64, _: &[f64], _: &[f64]| vec![torques[((t / PERIOD + 1e-6) as usize).min(COUNT - 1)]];
    let exact = ClosedForm { inertias, pose, force, gravity: bars.gravity };
    let jumps: Vec<f64> = (1..=COUNT).map(|k| k as f64 * PERIOD).collect();
    let states = exact.states([vec![bars.angle], vec![bars.omega]], &jumps);
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (&time, state) in jumps.iter().zip(&states).skip(249).step_by(250) {
        let [crank, rocker] = [0, 2].map(|body| exact.motion(body, state));
        times.push(time);
        values.push(vec![crank[2], crank[5], rocker[2], rocker[5]]);
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
