//! Four-bars and slider-cranks whose output follows their input as well as it can within limits.

use std::f64::consts::TAU;

use crate::bounded::{Goal, Inequalities};
use crate::chain::{Chain, DIMENSIONS, Node};
use crate::function::{Coupler, Pair, Zero, coupler_starts, slider_starts};
use crate::limits::LinkageLimits;
use crate::random::RandomNumbers;
use crate::within::{Candidate, EXACT, Plan, Sides, Wish, cosine, drawn_in, searched};

/// What the dimensions are: of a four-bar the ground is one; of a slider-crank the last length is the offset of its line.
const GROUND: usize = 2;
const CRANK: usize = 4;
const COUPLER: usize = 5;
const SECOND: usize = 6;
const PHASE: usize = 7;
const ZERO: usize = 8;
const COUNT: usize = 9;

/// Without a limit bars are between these shares of the ground, or of the slider's way.
const LENGTHS: [f64; 2] = [1e-2, 20.0];
/// Starts at random beside those that meet some pairs exactly.
const ANYWHERE: usize = 200;

fn four_bar([side, _]: Sides) -> Chain {
    let nodes = vec![
        Node::Ground { at: 0 },
        Node::Beside { from: 0, at: GROUND },
        Node::Crank { pivot: 0, length: CRANK },
        Node::Dyad { from: 2, to: 1, lengths: [COUPLER, SECOND], side },
    ];
    Chain { nodes, dimensions: COUNT }
}

fn slider_crank([side, _]: Sides) -> Chain {
    let nodes = vec![
        Node::Ground { at: 0 },
        Node::Crank { pivot: 0, length: CRANK },
        Node::Slide { from: 1, rod: COUPLER, offset: SECOND, side },
    ];
    Chain { nodes, dimensions: COUNT }
}

/// The four-bars with this ground, or the slider-cranks, that follow pairs best within limits, best first.
pub fn bounded_couplers(
    pairs: &[Pair],
    zero: Zero,
    ground: Option<f64>,
    limits: &LinkageLimits,
    wish: Wish,
) -> Vec<Coupler> {
    if pairs.len() < 3 {
        return Vec::new();
    }
    let largest = pairs.iter().map(|pair| pair.output.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let size = ground.unwrap_or(largest);
    let scaled: Vec<Pair> = match ground {
        Some(_) => pairs.to_vec(),
        None => pairs.iter().map(|pair| Pair { output: pair.output / size, ..*pair }).collect(),
    };
    let plan = plan(&scaled, zero, ground.is_none(), size, limits);
    let all = starts(&plan, &scaled, zero, ground.is_none());
    let unit = if ground.is_some() { 1.0 } else { size };
    // The root of the sum of squares is at least the largest error.
    let most = |candidate: &Candidate| unit * candidate.trial.sum.sqrt();
    let within = match wish {
        Wish::Accuracy => f64::INFINITY,
        Wish::Size(within) | Wish::Transmission(within) => within,
    };
    let settled = searched(&plan, all, 1);
    let drawn = settled.iter().filter_map(|candidate| {
        let is_exact = wish == Wish::Accuracy && candidate.trial.sum.sqrt() < EXACT;
        let (wish, within) = if is_exact { (Wish::Transmission(EXACT), EXACT * unit) } else { (wish, within) };
        drawn_in(&plan, candidate, wish, |candidate| most(candidate) <= within)
    });
    let drawn: Vec<Candidate> = drawn.collect();
    let chosen = if drawn.is_empty() { &settled } else { &drawn };
    chosen.iter().map(|curve| coupler(curve, ground, size)).collect()
}

fn coupler(candidate: &Candidate, ground: Option<f64>, size: f64) -> Coupler {
    let x = &candidate.trial.x;
    match ground {
        Some(ground) => {
            Coupler::four_bar([1.0, x[CRANK], x[COUPLER], x[SECOND]], x[PHASE], x[ZERO]).with_ground(ground)
        }
        None => Coupler::slider_crank(
            [x[CRANK], x[COUPLER], x[SECOND]].map(|length| length * size),
            x[PHASE],
            x[ZERO] * size,
        ),
    }
}

fn plan<'p>(pairs: &'p [Pair], zero: Zero, is_slider: bool, size: f64, limits: &LinkageLimits) -> Plan<'p> {
    let [low, high] = limits.length.map_or(LENGTHS, |[low, high]| [(low / size).max(LENGTHS[0]), high / size]);
    let [mut lower, mut upper] = [[f64::NEG_INFINITY; DIMENSIONS], [f64::INFINITY; DIMENSIONS]];
    for (dimension, value) in [0.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
        (lower[dimension], upper[dimension]) = (value, value);
    }
    let lengths: &[usize] = if is_slider { &[CRANK, COUPLER] } else { &[CRANK, COUPLER, SECOND] };
    lengths.iter().for_each(|&i| (lower[i], upper[i]) = (low, high.max(low)));
    for (dimension, given) in [(PHASE, zero.input), (ZERO, zero.output)] {
        if let Some(value) = given {
            (lower[dimension], upper[dimension]) = (value, value);
        }
    }
    let zeros = [PHASE, ZERO];
    let goal = if is_slider {
        Goal::Slider { pin: 2, pairs, zeros }
    } else {
        Goal::Function { pivot: 1, pin: 3, pairs, zeros }
    };
    let chain: fn(Sides) -> Chain = if is_slider { slider_crank } else { four_bar };
    let inequalities = Inequalities { cosine: cosine(limits), turn: limits.crank, ..Inequalities::default() };
    Plan { chain, goal, low: lower, high: upper, inequalities, lengths, order: None }
}

/// Linkages that meet some pairs, lengths drawn into their bounds, and others at random.
fn starts(plan: &Plan<'_>, pairs: &[Pair], zero: Zero, is_slider: bool) -> Vec<Candidate> {
    let inputs = vec![0.0; pairs.len()];
    let list = if is_slider { slider_starts(pairs, zero.input) } else { coupler_starts(pairs, zero) };
    let mut all: Vec<Candidate> = Vec::new();
    let mut x = [0.0; DIMENSIONS];
    for coupler in list {
        let lengths = coupler.linkage.lengths();
        let third = if is_slider { Some(coupler.output_pin(0.0).im) } else { lengths[3] };
        let (Some(a), Some(b), Some(c)) = (lengths[1], lengths[2], third) else { continue };
        x[CRANK..COUNT].copy_from_slice(&[a, b, c, coupler.input_zero, coupler.output_zero]);
        for side in [1.0, -1.0] {
            all.push(Candidate::new(x, inputs.clone(), [side, 1.0], plan));
        }
    }
    let mut random = RandomNumbers::new(5);
    for _ in 0..ANYWHERE {
        for i in [CRANK, COUPLER, SECOND] {
            let [low, high] = if plan.lengths.contains(&i) { [plan.low[i], plan.high[i]] } else { LENGTHS };
            x[i] = low * (high / low).powf(random.between(0.0, 1.0));
        }
        (x[PHASE], x[ZERO]) = (random.between(0.0, TAU), random.between(0.0, TAU));
        let side = if random.integer().is_multiple_of(2) { 1.0 } else { -1.0 };
        all.push(Candidate::new(x, inputs.clone(), [side, 1.0], plan));
    }
    all
}
