//! The search for the trees whose equations cost least (`preset = "cheapest"`).
//!
//! The search starts from the recommended trees, which give the fewest coordinates (Tables 2 and 3 are Kruskal's algorithm; all
//! other trees that do follow by exchanging branches for chords of the same weight). The best of those, the recommended
//! ones, and the unsubstituted ones, in which every body moves by coordinates of its own, then exchange single branches for any chord: a coordinate more
//! may well cost less. What trees cost is counted by formulating them;
//! a structural estimate decides which are worth that.

use std::collections::{BTreeSet, HashSet, VecDeque};

use cotree_fmu::model::Model;
use cotree_fmu::program::{Engine, Motion, Program};
use cotree_fmu::taylor::Jet;

use crate::component::System;
use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::formulate::start::Start;
use crate::formulate::{Formulated, formulate_with};
use crate::graph::ElementId;
use crate::lower::Cost;
use crate::mechanism::{Coordinates, Mechanism};
use crate::tree::Trees;

mod estimate;

/// Number of trees of least weight that are compared by the estimate.
const RANKED: usize = 200;
/// Number of the best trees by the estimate that are formulated.
const BEST: usize = 5;
/// Number of exchanges of one branch for one chord that are formulated.
const EXCHANGES: usize = 12;
/// A gain that is worth leaving the recommended trees.
const GAIN: f64 = 0.03;
/// Accelerations in one step of the explicit method.
const STAGES: f64 = 12.0;
/// A step by series is about as long as two explicit steps.
const STEPS_OF_A_SERIES: f64 = 2.0;
pub const LARGEST: usize = 40;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// How many pairs of trees were formulated, the recommended one included.
    pub counted: usize,
    pub recommended: Effort,
    pub chosen: Effort,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Of a kinematic model: the cubes of the sizes of the systems that must be solved one after another, in all.
    pub blocks: usize,
    /// Time by the model of the cost, of the method that will integrate \[ns\]: the accelerations, and a share of the projections, which a step of
    /// the explicit method needs once for its twelve accelerations; or as much of a step by series as carries the motion as far.
    pub nanoseconds: f64,
}

impl Effort {
    pub fn of(formulated: &Formulated) -> Effort {
        let program = &formulated.lowered.program;
        let nanoseconds = |tape| Cost::of(tape).nanoseconds();
        let tapes = &program.tapes;
        match program.motion {
            Motion::Dynamic if let Some(step) = series_cost(program) => {
                Effort { blocks: 0, nanoseconds: step.nanoseconds() / (STEPS_OF_A_SERIES * STAGES) }
            }
            Motion::Dynamic => {
                let projections = nanoseconds(&tapes.project_position) + nanoseconds(&tapes.project_velocity);
                Effort { blocks: 0, nanoseconds: nanoseconds(&tapes.acceleration) + projections / STAGES }
            }
            Motion::Kinematic => {
                let tapes = [&tapes.constraint, &tapes.jacobian.tape, &tapes.gamma];
                let blocks = program.blocks.iter().map(|block| block.columns.len().pow(3)).sum();
                Effort { blocks, nanoseconds: tapes.into_iter().map(nanoseconds).sum() }
            }
        }
    }

    /// Is this less by more than the share `gain`?
    fn is_less_than(&self, other: &Effort, gain: f64) -> bool {
        let cheaper = self.nanoseconds < (1.0 - gain) * other.nanoseconds;
        self.blocks < other.blocks || (self.blocks == other.blocks && cheaper)
    }
}

/// The cost of a step by series, if the motion is integrated by series.
fn series_cost(program: &Program) -> Option<Cost> {
    if program.engine != Engine::Taylor {
        return None;
    }
    let jet = Model::new(program.clone()).ok().and_then(|model| Jet::new(&model))?;
    Some(Cost { operations: jet.cost() as usize, ..Cost::default() })
}

/// Formulates a mechanism in the cheapest trees found.
///
/// # Errors
/// Those of the recommended trees.
pub fn formulate(mechanism: &Mechanism) -> Result<Formulated<'_>, Vec<Fault>> {
    let system = System::new(mechanism);
    let start = Trees::select(&system, &Coordinates::Recommended)?;
    let mut recommended = formulate_with(Equations::new(system.clone(), start.clone()), None)?;
    // Other trees would have drivers as branches again whose rates jump.
    if mechanism.bodies.len() > LARGEST || recommended.equations.trees != start {
        return Ok(recommended);
    }
    let effort = Effort::of(&recommended);
    let state = recommended.state.clone();
    let first = Start::of(&mut recommended.equations, state);
    let seen = HashSet::from([branches(&start)]);
    let mut search = Exploration { system: &system, first, seen, counted: 1, best: None };
    search.count_ranked(&start);
    let from = search.best.as_ref().map_or(&start, |(_, best)| &best.equations.trees).clone();
    let unsubstituted = start.with_bodies(&system, |_| true);
    search.count_new(&unsubstituted);
    for trees in [from, start, unsubstituted] {
        search.exchange(trees, EXCHANGES / 3);
    }
    let (chosen, mut formulated) = match search.best {
        Some((found, formulated)) if found.is_less_than(&effort, GAIN) => (found, *formulated),
        _ => (effort, recommended),
    };
    formulated.search = Some(Search { counted: search.counted, recommended: effort, chosen });
    Ok(formulated)
}

struct Exploration<'s, 'm> {
    system: &'s System<'m>,
    /// The start of the mechanism, the same for all trees.
    first: Start,
    seen: HashSet<Vec<ElementId>>,
    counted: usize,
    best: Option<(Effort, Box<Formulated<'m>>)>,
}

impl Exploration<'_, '_> {
    /// Formulates the best of all trees of least weight, unless these are too many to enumerate.
    fn count_ranked(&mut self, start: &Trees) {
        let Some(all) = all_minimal(self.system, start) else { return };
        for trees in self.ranked(all).into_iter().take(BEST) {
            self.count(trees);
        }
    }

    /// Formulates trees unless they were formulated before.
    fn count_new(&mut self, trees: &Trees) {
        if !self.seen.contains(&branches(trees)) {
            self.count(trees.clone());
        }
    }

    /// Walks from tree to tree as long as one exchange makes them cheaper.
    fn exchange(&mut self, start: Trees, most: usize) {
        let mut around = Some(start);
        let limit = self.counted + most;
        while let Some(trees) = around.take() {
            let pairs = trees.exchanges(self.system).into_iter();
            let around_it = pairs.map(|pair| trees.exchanged(self.system, pair)).collect();
            for trees in self.ranked(around_it) {
                if self.counted >= limit {
                    return;
                }
                if self.count(trees.clone()) {
                    around = Some(trees);
                    break;
                }
            }
        }
    }

    /// Trees that were not formulated yet, the cheapest by the estimate first.
    fn ranked(&self, trees: Vec<Trees>) -> Vec<Trees> {
        let fresh = trees.into_iter().filter(|trees| !self.seen.contains(&branches(trees)));
        let mut ranked: Vec<(usize, Trees)> = fresh
            .map(|trees| (estimate::estimate(&mut Equations::new(self.system.clone(), trees.clone())), trees))
            .collect();
        ranked.sort_by_key(|(estimate, _)| *estimate);
        ranked.into_iter().map(|(_, trees)| trees).collect()
    }

    /// Formulates trees; are they the cheapest so far? Trees in which the scene cannot be formulated are not.
    fn count(&mut self, trees: Trees) -> bool {
        self.seen.insert(branches(&trees));
        self.counted += 1;
        let Ok(formulated) = formulate_with(Equations::new(self.system.clone(), trees), Some(&self.first)) else {
            return false;
        };
        let effort = Effort::of(&formulated);
        let better = self.best.as_ref().is_none_or(|(best, _)| effort.is_less_than(best, 0.0));
        if better {
            self.best = Some((effort, Box::new(formulated)));
        }
        better
    }
}

/// All trees of the same weight, found by exchanges from one of them; `None` if there are too many.
fn all_minimal(system: &System, start: &Trees) -> Option<Vec<Trees>> {
    let mut seen = HashSet::from([branches(start)]);
    let mut all = vec![start.clone()];
    let mut queue = VecDeque::from([start.clone()]);
    while let Some(trees) = queue.pop_front() {
        for other in neighbours(system, &trees) {
            if seen.insert(branches(&other)) {
                if all.len() == RANKED {
                    return None;
                }
                all.push(other.clone());
                queue.push_back(other);
            }
        }
    }
    Some(all)
}

/// The translational trees with one branch exchanged for a chord that brings as many coordinates.
fn neighbours(system: &System, trees: &Trees) -> impl Iterator<Item = Trees> {
    let weight = |id: ElementId| system.element(id).translation.as_ref().map_or(0, |row| row.motion.len());
    let alike = move |pair: &[ElementId; 2]| weight(pair[0]) == weight(pair[1]);
    trees.exchanges(system).into_iter().filter(alike).map(|pair| trees.exchanged(system, pair))
}

fn branches(trees: &Trees) -> Vec<ElementId> {
    let sorted: BTreeSet<ElementId> = trees.translation.branches.iter().copied().collect();
    sorted.into_iter().collect()
}
