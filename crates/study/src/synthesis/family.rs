//! Families of linkages for two to four poses: free pins are moved until the limits hold and the transmission angle is as large as it gets.
//!
//! The search goes by steps at random whose size follows its success (I. Rechenberg 1973): judgement is cheap, and neither smooth nor even continuous.

use cotree::task::{Task, TaskKind};
use cotree_synthesis::{
    Dyad, DyadCondition, Linkage, LinkageLimits, Point, Pose, RandomNumbers, circle_dyad, dyads, extent,
};

use super::candidates::settled;
use super::{CandidateLinkage, Judged, best};

/// Linkages from which a search begins, and its steps.
const STARTS: usize = 12;
const STEPS: usize = 240;
/// The first step, and the smallest, in sizes of the task.
const FIRST: f64 = 0.2;
const LEAST: f64 = 1e-4;

/// The linkages of a family to which the best of those that were tried lead, and their dyads.
pub fn refined(task: &Task, limits: &LinkageLimits, judged: &[Judged]) -> Vec<CandidateLinkage> {
    let TaskKind::Poses { at: poses, tolerance: None, weight: None } = &task.kind else { return Vec::new() };
    if poses.len() > 4 {
        return Vec::new();
    }
    let chosen = task.choose != cotree::task::Choose::default();
    let mut ranked: Vec<&Judged> = judged.iter().filter(|judged| is_four_bar(&judged.linkage)).collect();
    ranked.sort_by(|a, b| merit(a, poses).total_cmp(&merit(b, poses)));
    let mut random = RandomNumbers::new(11);
    let starts = ranked.into_iter().take(if chosen { 0 } else { STARTS });
    starts.filter_map(|start| climbed(task, limits, start, poses, &mut random)).collect()
}

fn is_four_bar(linkage: &Linkage) -> bool {
    matches!((linkage.first, linkage.second), (Dyad::Bar { .. }, Dyad::Bar { .. }))
}

/// The less the better: defects, then what limits are missed by, then the transmission angle.
fn merit(judged: &Judged, poses: &[Pose]) -> f64 {
    let size = extent(poses.iter().map(|pose| pose.at)).1;
    let missed: f64 =
        judged.misses.iter().map(|(limit, miss)| if limit.is_length() { miss / size } else { miss.min(1.0) }).sum();
    let defects = 10.0 * judged.verdict.defects.len() as f64;
    let nothing = if judged.reason.is_some() && missed == 0.0 && defects == 0.0 { 100.0 } else { 0.0 };
    let angle = if missed + defects == 0.0 { -judged.verdict.transmission } else { 0.0 };
    nothing + defects + missed + angle
}

/// The end of a search from one linkage; none if it led nowhere.
fn climbed(
    task: &Task,
    limits: &LinkageLimits,
    from: &Judged,
    poses: &[Pose],
    random: &mut RandomNumbers,
) -> Option<CandidateLinkage> {
    let size = extent(poses.iter().map(|pose| pose.at)).1;
    let (mut linkage, mut value, mut step) = (from.linkage, merit(from, poses), FIRST);
    let mut end = None;
    for _ in 0..STEPS {
        let scale = step * size;
        let moved = |dyad: Dyad, random: &mut RandomNumbers| {
            beside(dyad, poses, random.normal() * scale, random.normal().re * scale)
        };
        let next = moved(linkage.first, random).zip(moved(linkage.second, random));
        let next = next.map(|(first, second)| Linkage { first, second });
        let candidate = next.map(|linkage| candidate(linkage, poses));
        let judged = candidate.as_ref().and_then(|candidate| Some((best(candidate, limits, task)?, candidate)));
        match judged.filter(|(better, _)| merit(better, poses) < value) {
            Some((better, candidate)) => {
                (linkage, value) = (candidate.linkage, merit(&better, poses));
                end = Some(linkage);
                step = (2.0 * step).min(FIRST);
            }
            None => step = (0.84 * step).max(LEAST),
        }
    }
    end.map(|linkage| candidate(linkage, poses))
}

fn candidate(linkage: Linkage, poses: &[Pose]) -> CandidateLinkage {
    let (exact, error) = settled(&linkage, poses);
    CandidateLinkage { linkage, poses: exact, error, dyads: None, both: true, price: 0.0 }
}

/// A dyad beside another one in its family: its pin moved, its pivot where it then has to be.
fn beside(dyad: Dyad, poses: &[Pose], by: Point, along: f64) -> Option<Dyad> {
    let Dyad::Bar { moving, ground, .. } = dyad else { return None };
    match *poses {
        [first, second] => {
            let pin = moving + by;
            let [from, to] = [first, second].map(|pose| pose.carry(pin));
            let across = (to - from) * Point::new(0.0, 1.0) / (to - from).norm().max(f64::MIN_POSITIVE);
            let before = ((ground - (from + to) * 0.5) * across.conj()).re;
            let pivot = (from + to) * 0.5 + across * (before + along);
            Some(Dyad::Bar { moving: pin, ground: pivot, length: (pivot - from).norm() })
        }
        [a, b, c] => circle_dyad(moving + by, &[a, b, c]),
        _ => {
            let line = DyadCondition::Ground { direction: Point::new(1.0, 0.0), value: ground.re + along };
            let far = |dyad: &Dyad| match dyad {
                Dyad::Bar { moving: pin, ground: pivot, .. } => (pin - moving).norm() + (pivot - ground).norm(),
                Dyad::Slider { .. } | Dyad::Slot { .. } => f64::INFINITY,
            };
            let found = dyads(poses, &[line]).ok()?;
            found.into_iter().filter(|linkage| far(linkage).is_finite()).min_by(|a, b| far(a).total_cmp(&far(b)))
        }
    }
}
