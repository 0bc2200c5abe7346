//! The start of a mechanism whose `[initial]` leaves freedoms open: completed in the recommended trees, for every choice of trees.

use std::collections::HashMap;

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Initial;

use super::explain::size;
use crate::equations::Equations;
use crate::expr::{Expr, Symbol};
use crate::formulate::default_value;
use crate::model::{BodyId, Mechanism, Owner, Place, Quantity, Variable};
use crate::network::{Direction, System, Trees};

/// A pose with its rates, by the nodes of both graphs.
#[derive(Clone, Debug)]
pub struct Start {
    /// Position and velocity of each point, in the world.
    points: Vec<[[f64; 2]; 2]>,
    /// Angle and angular velocity of each body, the ground's first.
    bodies: Vec<[f64; 2]>,
    /// Position and rate of each driver that integrates an input.
    followers: Vec<[f64; 2]>,
    state: State,
}

/// Where positions that nobody gives are looked for, if that is not zero for all of them.
pub(super) fn begin(equations: &mut Equations, initial: &mut Initial) {
    let mechanism = &*equations.system.mechanism.clone();
    if mechanism.begins.is_empty() {
        return;
    }
    let exprs: Vec<Expr> = mechanism.begins.iter().map(|begin| equations.formula(&begin.value)).collect();
    let values = equations.system.arena.evaluate(&exprs, &|symbol: Symbol| default_value(mechanism, symbol));
    let begins = mechanism.begins.iter().map(|begin| begin.variable);
    let values: HashMap<Variable, f64> = begins.zip(values).collect();
    let of = |variable: Variable| values.get(&variable).copied().unwrap_or_default();
    // Integrals of states and what drivers integrate begin at zero.
    let others = equations.states.len() + equations.system.followers.len();
    initial.first_positions = equations.coordinates.iter().map(|coordinate| of(coordinate.variables[0])).collect();
    initial.first_positions.extend(std::iter::repeat_n(0.0, others));
    initial.first_rates = vec![0.0; initial.first_positions.len()];
}

impl Start {
    /// The start in the recommended trees; none if these have none, or are too large.
    pub fn find(mechanism: &Mechanism, length: f64) -> Option<Start> {
        let system = System::new(mechanism);
        let trees = Trees::recommended(&system);
        size::check(&system, &trees).ok()?;
        let mut equations = Equations::new(system, trees);
        let mut program = crate::program::positions(&mut equations, length);
        begin(&mut equations, &mut program.initial);
        let model = Model::of_positions(program).ok()?;
        let mut state = model.default_state(mechanism.experiment.start);
        solve_initial(&model, &mut state).ok()?;
        Some(Start::of(&mut equations, state))
    }

    pub fn of(equations: &mut Equations, state: State) -> Start {
        let mechanism = &equations.system.mechanism;
        let centres = (0..mechanism.bodies.len()).map(|body| Place::Centre(BodyId(body)));
        let arms = mechanism
            .bodies
            .iter()
            .enumerate()
            .flat_map(|(body, data)| (0..data.points.len()).map(move |point| Place::Point(BodyId(body), point)));
        let places: Vec<Place> =
            centres.clone().chain(arms).chain((0..mechanism.ground.len()).map(Place::Ground)).collect();
        let mut start = Start {
            points: vec![[[0.0; 2]; 2]; equations.system.translation.nodes()],
            bodies: vec![[0.0; 2]; equations.system.rotation.nodes()],
            followers: Vec::new(),
            state,
        };
        for place in places {
            if equations.system.has_node(place) {
                let values = start.read(equations, place, [Quantity::X, Quantity::Y, Quantity::Vx, Quantity::Vy]);
                start.points[equations.system.t_node(place).index()] = [[values[0], values[1]], [values[2], values[3]]];
            }
        }
        for (body, place) in centres.enumerate() {
            let node = equations.system.r_node(Some(BodyId(body))).index();
            // On a line nothing turns, and there are no such nodes.
            if node > 0 {
                start.bodies[node] = start.read(equations, place, [Quantity::Angle, Quantity::Omega]);
            }
        }
        let rates = start.state.follower_rates().iter();
        start.followers = start.state.follower_positions().iter().zip(rates).map(|(&x, &v)| [x, v]).collect();
        start
    }

    fn read<const N: usize>(&self, equations: &mut Equations, place: Place, quantities: [Quantity; N]) -> [f64; N] {
        let exprs = quantities.map(|quantity| equations.variable(Variable { owner: Owner::Place(place), quantity }));
        let values = equations.system.arena.evaluate(&exprs, &self.state);
        std::array::from_fn(|index| values[index])
    }

    /// Where the search for the initial state begins, in the coordinates of these equations.
    pub fn begin(&self, equations: &Equations, initial: &mut Initial) {
        let coordinates = self.coordinates(equations);
        let states = vec![[0.0; 2]; equations.states.len()];
        let all = || coordinates.iter().chain(&states).chain(&self.followers);
        initial.first_positions = all().map(|[position, _]| *position).collect();
        initial.first_rates = all().map(|[_, rate]| *rate).collect();
    }

    fn coordinates(&self, equations: &Equations) -> Vec<[f64; 2]> {
        let mut found = Vec::new();
        for &branch in &equations.trees.translation.branches {
            let Some(row) = &equations.system.element(branch).translation else { continue };
            let [a, b] = row.ends.map(|node| self.points[node.index()]);
            let gap: [[f64; 2]; 2] = [0, 1].map(|order| [b[order][0] - a[order][0], b[order][1] - a[order][1]]);
            found.extend(row.motion.iter().map(|(direction, _)| self.along(equations, *direction, gap)));
        }
        for &branch in &equations.trees.rotation.branches {
            let Some(row) = &equations.system.element(branch).rotation else { continue };
            if matches!(row.angle, crate::network::Angle::Free(_)) {
                let [a, b] = row.ends.map(|node| self.bodies[node.index()]);
                found.push([b[0] - a[0], b[1] - a[1]]);
            }
        }
        found
    }

    /// The projection of a displacement on a direction, and its rate.
    fn along(&self, equations: &Equations, direction: Direction, [r, v]: [[f64; 2]; 2]) -> [f64; 2] {
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        match direction {
            Direction::X => [r[0], v[0]],
            Direction::Y => [r[1], v[1]],
            Direction::Fixed(body, axis) => {
                let axis = equations.system.arena.evaluate(&axis, &self.state);
                let [angle, omega] = self.bodies[equations.system.r_node(body).index()];
                let (sine, cosine) = libm::sincos(angle);
                let along = [cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1]];
                let across = [-along[1], along[0]];
                [dot(r, along), dot(v, along) + omega * dot(r, across)]
            }
        }
    }
}
