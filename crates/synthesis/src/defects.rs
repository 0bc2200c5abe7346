//! Defects of a linkage that reaches all poses but cannot move from one to the next.
//!
//! Circuit: without taking the linkage apart. In a Grashof linkage the sines of the joint angles that do not touch the shortest bar keep their sign on a
//! circuit; other linkages have one circuit. Branch: without passing a dead point of the input, where the body could go either way.
//! Order: in the order in which they are given.
//!
//! Source: T. R. Chase, J. A. Mirth, *Circuits and branches of single-degree-of-freedom planar linkages*, J. Mech. Des. 115, 1993; with a slider: the
//! limit of a four-bar whose ground and second bar are long.

use std::f64::consts::TAU;

use crate::dyad::Dyad;
use crate::linkage::{Linkage, Side};
use crate::poses::Pose;
use crate::{Point, cross, dot};

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Defect {
    /// Poses on different circuits.
    Circuit,
    /// A dead point of the input between poses.
    Branch,
    /// Poses in another order.
    Order,
}

impl Defect {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Defect::Circuit => "circuit",
            Defect::Branch => "branch",
            Defect::Order => "order",
        }
    }
}

/// What a linkage is and does, with its first dyad for the input.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What is wrong; nothing: the linkage is good.
    pub defects: Vec<Defect>,
    /// Is the sum of the shortest and the longest bar below that of the others? None within a change point: all bars can lie on one line.
    pub grashof: Option<bool>,
    /// Does the input turn fully?
    pub full_turn: bool,
    /// The inputs at the poses, one after the other without a jump \[rad or m\].
    pub inputs: Vec<f64>,
    /// The side at the first pose.
    pub side: Side,
    /// The smallest transmission angle between the first and the last pose \[rad\]; over the whole turn if the input turns fully and it is asked for.
    pub transmission: f64,
}

/// Change points: the sums of lengths are equal up to this share.
const CHANGE_POINT: f64 = 1e-9;

/// Judges a linkage that meets all poses; the transmission angle counts over the whole turn if `turn` is set.
pub fn judge(linkage: &Linkage, poses: &[Pose], turn: bool) -> Verdict {
    let grashof = grashof(linkage);
    let full_turn = linkage.turns_fully();
    let sides: Vec<Side> = poses.iter().map(|pose| linkage.side(pose)).collect();
    let side = sides.first().copied().unwrap_or(1.0);
    let (inputs, in_order) = in_order(linkage, poses, full_turn);
    let circuit = grashof.is_none_or(|(grashof, shortest)| !grashof || one_circuit(linkage, poses, shortest));
    let one_side = sides.iter().all(|other| *other == side);
    let branch = one_side && (!circuit || one_reach(linkage, &inputs));
    let found = [(circuit, Defect::Circuit), (branch, Defect::Branch), (in_order, Defect::Order)];
    let defects: Vec<Defect> = found.into_iter().filter(|(good, _)| !good).map(|(_, defect)| defect).collect();
    let ends = |inputs: &[f64]| Some([*inputs.first()?, *inputs.last()?]);
    let whole = (turn && full_turn).then_some([0.0, TAU]);
    let way = whole.or_else(|| ends(&inputs)).unwrap_or([0.0, 0.0]);
    let transmission = if circuit && branch { linkage.smallest_transmission(way, side) } else { 0.0 };
    Verdict { defects, grashof: grashof.map(|(class, _)| class), full_turn, inputs, side, transmission }
}

/// Inputs at the poses without a jump over what cannot be reached, and whether they are in order.
fn in_order(linkage: &Linkage, poses: &[Pose], full_turn: bool) -> (Vec<f64>, bool) {
    let mut inputs: Vec<f64> = poses.iter().map(|pose| linkage.input(pose)).collect();
    let Some(&first) = inputs.first() else { return (inputs, true) };
    let ordered = |inputs: &[f64]| {
        let all = |sign: f64| inputs.windows(2).all(|pair| sign * (pair[1] - pair[0]) > 0.0);
        all(1.0) || all(-1.0)
    };
    if full_turn {
        let turned = |sign: f64| -> Vec<f64> {
            inputs.iter().map(|input| first + sign * (sign * (input - first)).rem_euclid(TAU)).collect()
        };
        let [forth, back] = [1.0, -1.0].map(turned);
        let forwards = ordered(&forth);
        let good = forwards || ordered(&back);
        return (if forwards || !good { forth } else { back }, good);
    }
    if let (Dyad::Bar { .. }, Some(&gap)) = (&linkage.first, linkage.gaps().first()) {
        inputs.iter_mut().for_each(|input| *input = gap + (*input - gap).rem_euclid(TAU));
    }
    let good = ordered(&inputs);
    (inputs, good)
}

/// Is no gap between any two inputs?
fn one_reach(linkage: &Linkage, inputs: &[f64]) -> bool {
    let turns = matches!(linkage.first, Dyad::Bar { .. });
    let low = inputs.iter().copied().fold(f64::INFINITY, f64::min);
    let high = inputs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    !linkage.gaps().iter().any(|gap| {
        let ahead = if turns { (gap - low).rem_euclid(TAU) } else { gap - low };
        ahead > 0.0 && ahead < high - low
    })
}

/// Which bar is the shortest.
#[derive(Clone, Copy, PartialEq)]
enum Shortest {
    Ground,
    First,
    Body,
    Second,
}

/// Whether a linkage is of Grashof's kind, and its shortest bar; none at a change point and where no bar turns.
fn grashof(linkage: &Linkage) -> Option<(bool, Shortest)> {
    let names = [Shortest::Ground, Shortest::First, Shortest::Body, Shortest::Second];
    let bars: Vec<(f64, Shortest)> =
        linkage.lengths().into_iter().zip(names).filter_map(|(length, name)| Some((length?, name))).collect();
    let shortest = bars.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let longest = bars.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let sum: f64 = bars.iter().map(|(length, _)| length).sum();
    // Two long bars differ by the offset of the slider from the pin in the ground, or of the slot from that in the body.
    let spare = match (bars.len(), offset(linkage)) {
        (4, _) => sum - 2.0 * (shortest.0 + longest.0),
        (2, Some(offset)) => longest.0 - shortest.0 - offset,
        _ => return None,
    };
    if spare.abs() < CHANGE_POINT * sum { None } else { Some((spare > 0.0, shortest.1)) }
}

fn offset(linkage: &Linkage) -> Option<f64> {
    match (linkage.first, linkage.second) {
        (Dyad::Bar { ground, .. }, Dyad::Slider { normal, offset, .. })
        | (Dyad::Slider { normal, offset, .. }, Dyad::Bar { ground, .. }) => Some((dot(normal, ground) - offset).abs()),
        (Dyad::Bar { moving, .. }, Dyad::Slot { normal, offset, .. })
        | (Dyad::Slot { normal, offset, .. }, Dyad::Bar { moving, .. }) => Some((dot(normal, moving) - offset).abs()),
        _ => None,
    }
}

/// Do the sines of the joints that do not touch the shortest bar keep their signs?
fn one_circuit(linkage: &Linkage, poses: &[Pose], shortest: Shortest) -> bool {
    let signs = |pose: &Pose| sines(linkage, pose, shortest).map(|sine| sine > 0.0);
    let mut all = poses.iter().map(signs);
    all.next().is_none_or(|first| all.all(|other| other == first))
}

/// The sines at a pose that keep their signs on a circuit of a Grashof linkage.
fn sines(linkage: &Linkage, pose: &Pose, shortest: Shortest) -> [f64; 2] {
    let sine = |a: Point, b: Point| cross(a, b);
    let (bar, other) = match (linkage.first, linkage.second) {
        (Dyad::Bar { moving, ground, .. }, Dyad::Bar { moving: other, ground: pin, .. }) => {
            let (a, b) = (pose.carry(moving), pose.carry(other));
            let [at_ground, at_first] = [sine(a - ground, pin - ground), sine(ground - a, b - a)];
            let [at_second, at_pin] = [sine(a - b, pin - b), sine(ground - pin, b - pin)];
            return match shortest {
                Shortest::Ground => [at_first, at_second],
                Shortest::First => [at_second, at_pin],
                Shortest::Body => [at_ground, at_pin],
                Shortest::Second => [at_ground, at_first],
            };
        }
        (bar @ Dyad::Bar { .. }, other) | (other, bar) => (bar, other),
    };
    // With a slider the joint of the longer bar with its line, turned by a right angle, keeps its sign.
    let Dyad::Bar { moving, ground, .. } = bar else { return [0.0; 2] };
    let pin = pose.carry(moving);
    let is_bar = matches!(shortest, Shortest::First | Shortest::Second);
    let across = match other {
        Dyad::Slider { moving, normal, .. } => {
            let longer = if is_bar { pose.carry(moving) - pin } else { pin - ground };
            cross(normal, longer)
        }
        Dyad::Slot { ground: pivot, normal, .. } => {
            let longer = if is_bar { pivot - ground } else { pin - ground };
            cross(normal * pose.turn(), longer)
        }
        Dyad::Bar { .. } => 0.0,
    };
    [across; 2]
}
