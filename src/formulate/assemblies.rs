//! The ways in which loops can be closed: the poses that are found from many starts.

use std::f64::consts::{PI, TAU};

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Program;

use super::restrictions::{Restrictions, restrictions};
use super::{equations, typical_length};
use crate::diagnostic::{Fault, Span};
use crate::equations::{Coordinate, Equations};
use crate::model::{Class, CoordinateChoice, Formula, Initial, Mechanism, Owner, Variable};
use crate::redundancy::matrices::constraint;

/// More poses than this are no set of single ones.
const MOST: usize = 64;
/// Coordinates that differ by less than this [rad, lengths of the mechanism] are the same.
const SAME: f64 = 1e-6;

/// All assemblies that were found.
#[derive(Clone, Debug)]
pub struct Assemblies {
    /// What was held so that poses are single ones: variables and their values.
    pub held: Vec<CoordinateValue>,
    /// One list of coordinates for each assembly, that of the scene first.
    pub poses: Vec<Vec<CoordinateValue>>,
    /// How many starts led to each.
    pub found: Vec<usize>,
    /// From how many starts none was found.
    pub failed: usize,
    /// From how many starts a pose was found that can move on, though all is held: where bars lie on each other, for example. It is not listed.
    pub loose: usize,
    /// Is the first one that of the scene? Its own guesses may lead to none.
    pub is_own: bool,
}

/// A coordinate with its value, SI.
#[derive(Clone, Debug)]
pub struct CoordinateValue {
    pub variable: Variable,
    pub name: String,
    pub value: f64,
    pub angular: bool,
}

/// Closes the loops of a mechanism from its own start and from so many others. What neither drivers nor known initial values give is held
/// where the scene's own start has it.
///
/// # Errors
/// There are no equations, or the loops cannot be closed from any start.
pub fn assemblies(mechanism: &Mechanism, starts: usize) -> Result<Assemblies, Vec<Fault>> {
    let mut mechanism = mechanism.clone();
    mechanism.coordinates = CoordinateChoice::Recommended;
    let Own { names, state, freedoms, is_own } = own_start(&mechanism, starts)?;
    // Guesses pick one of the ways; here all are wanted.
    let guessed: Vec<Variable> =
        mechanism.initial.iter().filter(|initial| !initial.known).map(|initial| initial.variable).collect();
    mechanism.initial.retain(|initial| initial.known);
    let known = mechanism.initial.iter().filter(|initial| initial.variable.quantity.class() == Class::Position);
    let open = freedoms.saturating_sub(known.count());
    let held = hold(&mut mechanism, &names, &state, open, &guessed);
    Ok(Assemblies { is_own, ..search(&mechanism, held, (&state, freedoms), starts)? })
}

/// A pose in which the loops are closed.
struct Own {
    /// The coordinates there.
    names: Vec<CoordinateValue>,
    state: State,
    /// How many freedoms the loops and drivers leave.
    freedoms: usize,
    /// Is it the start of the scene?
    is_own: bool,
}

/// The scene's own start; where that does not close the loops as it is guessed, the first pose that is found without the guesses.
fn own_start(mechanism: &Mechanism, starts: usize) -> Result<Own, Vec<Fault>> {
    let mut free = mechanism.clone();
    free.initial.retain(|initial| initial.known);
    for (mechanism, last, is_own) in [(mechanism, 0, true), (&free, starts, false)] {
        let mut equations = equations(mechanism, &mechanism.coordinates)?;
        let length = typical_length(&mut equations);
        let (draft, ranges) = (crate::program::positions(&mut equations, length), ranges(&equations, length));
        for start in 0..=last {
            let mut program = draft.clone();
            if start > 0 {
                let others = equations.states.len() + equations.system.followers.len();
                let follow = std::iter::repeat_n(0.0, others);
                begin_at(&mut program, even_place(start, &ranges).chain(follow).collect());
            }
            let (model, Some(state)) = solved(program, mechanism)? else { continue };
            let restrictions = restrictions(equations, (model, state), length, None)?;
            let Restrictions { equations, model, state, .. } = &restrictions;
            let (names, freedoms) = (values(equations, model, state), restrictions.mobility());
            return Ok(Own { names, state: state.clone(), freedoms, is_own });
        }
    }
    let message = format!("the loops closed from none of {starts} starts; `cotree check` reports where they are open");
    Err(vec![Fault::new("assembly::open_loop", message, Span::default())])
}

/// By how much coordinates differ from zero in the space of poses.
fn ranges(equations: &Equations, length: f64) -> Vec<f64> {
    equations.coordinates.iter().map(|coordinate| if coordinate.angular { PI } else { 2.0 * length }).collect()
}

/// The n-th of places that fill this space evenly.
fn even_place(n: usize, ranges: &[f64]) -> impl Iterator<Item = f64> {
    let place = move |(index, range): (usize, &f64)| (2.0 * even(n, index, ranges.len()) - 1.0) * range;
    ranges.iter().enumerate().map(place)
}

/// Has the search begin at these positions.
fn begin_at(program: &mut Program, positions: Vec<f64>) {
    program.initial.first_rates = vec![0.0; positions.len()];
    program.initial.first_positions = positions;
}

/// The coordinates; an angle without whole turns, unless loop equations such as those of gears and racks count them.
fn values(equations: &Equations, model: &Model, state: &State) -> Vec<CoordinateValue> {
    let mut reduced = state.clone();
    for (index, _) in equations.coordinates.iter().enumerate().filter(|(_, coordinate)| coordinate.angular) {
        let turns = (state.positions()[index] / TAU).round() * TAU;
        let mut turned = state.clone();
        turned.positions_mut()[index] += TAU;
        let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME;
        if constraint(model, state).iter().zip(constraint(model, &turned).iter()).all(same) {
            reduced.positions_mut()[index] -= turns;
        }
    }
    let coordinates = equations.coordinates.iter().zip(reduced.positions());
    let value = |(coordinate, &value): (&Coordinate, &f64)| {
        let (variable, name) = (coordinate.variables[0], coordinate.name.position.clone());
        CoordinateValue { variable, name, value, angular: coordinate.angular }
    };
    coordinates.map(value).collect()
}

fn solved(program: Program, mechanism: &Mechanism) -> Result<(Model, Option<State>), Vec<Fault>> {
    let internal = |fault: &dyn std::fmt::Display| vec![super::internal(mechanism, &fault.to_string())];
    let model = Model::of_positions(program).map_err(|fault| internal(&fault))?;
    let mut state = model.default_state(mechanism.experiment.start);
    let solved = solve_initial(&model, &mut state).is_ok();
    Ok((model, solved.then_some(state)))
}

/// Holds as many coordinates as are open: those that the scene guesses last, for they are what is to be found.
fn hold(
    mechanism: &mut Mechanism,
    names: &[CoordinateValue],
    state: &State,
    open: usize,
    guessed: &[Variable],
) -> Vec<CoordinateValue> {
    let mut candidates: Vec<(bool, usize, Variable)> = names
        .iter()
        .enumerate()
        // No load is held: its ends are.
        .filter(|(_, value)| matches!(value.variable.owner, Owner::Place(_) | Owner::Joint(_)))
        .map(|(index, value)| (index, value.variable))
        .filter(|(_, variable)| mechanism.initial.iter().all(|known| known.variable != *variable))
        .map(|(index, variable)| (guessed.contains(&variable), index, variable))
        .collect();
    candidates.sort_by_key(|(is_guess, index, _)| (*is_guess, *index));
    candidates.truncate(open);
    for &(_, index, variable) in &candidates {
        let value = Formula::Number(state.positions()[index]);
        mechanism.initial.push(Initial { variable, value, display: None, known: true, span: Span::default() });
    }
    candidates.iter().map(|(_, index, _)| names[*index].clone()).collect()
}

/// Solves from the start of the scene, with its number of degrees of freedom, and from others that fill the space of positions evenly.
fn search(
    mechanism: &Mechanism,
    held: Vec<CoordinateValue>,
    (known_state, freedoms): (&State, usize),
    starts: usize,
) -> Result<Assemblies, Vec<Fault>> {
    let mut equations = equations(mechanism, &mechanism.coordinates)?;
    let length = typical_length(&mut equations);
    let draft = crate::program::positions(&mut equations, length);
    let ranges = ranges(&equations, length);
    let known: Vec<Variable> = mechanism.initial.iter().map(|initial| initial.variable).collect();
    let mut found = Assemblies { held, poses: Vec::new(), found: Vec::new(), failed: 0, loose: 0, is_own: true };
    for start in 0..=starts {
        // Each solution ends by itself when whoever waits wants that, and would count as failed.
        if cotree_fmu::context::is_interrupted() {
            break;
        }
        let mut program = draft.clone();
        let stays = |index: usize| start == 0 || known.contains(&equations.coordinates[index].variables[0]);
        let place = |(index, place): (usize, f64)| if stays(index) { known_state.positions()[index] } else { place };
        let mut positions: Vec<f64> = even_place(start, &ranges).enumerate().map(place).collect();
        positions.extend(known_state.positions().iter().skip(ranges.len()).chain(known_state.follower_positions()));
        begin_at(&mut program, positions);
        match solved(program, mechanism)? {
            (_, None) => found.failed += 1,
            // A disturbed search may leave what is known; that is no pose of the scene.
            (_, Some(state)) if !keeps(&equations, &known, known_state, &state) => found.failed += 1,
            (model, Some(state)) => {
                let pose = values(&equations, &model, &state);
                match found.place(&pose, length) {
                    Some(index) => found.found[index] += 1,
                    None if is_loose(&equations, (model, state), length, freedoms) => found.loose += 1,
                    None => found.add(pose),
                }
            }
        }
        if found.poses.len() > MOST {
            break;
        }
    }
    Ok(found)
}

/// Has a pose more freedoms than that of the scene? Where that cannot be decided it counts as a single one.
fn is_loose(equations: &Equations, pose: (Model, State), length: f64, freedoms: usize) -> bool {
    restrictions(equations.clone(), pose, length, None).is_ok_and(|found| found.mobility() > freedoms)
}

/// Has a pose the known coordinates of the scene's own start?
fn keeps(equations: &Equations, known: &[Variable], state: &State, pose: &State) -> bool {
    let coordinates = equations.coordinates.iter().zip(state.positions().iter().zip(pose.positions()));
    let apart = |(coordinate, (a, b)): (&Coordinate, (&f64, &f64))| {
        known.contains(&coordinate.variables[0]) && (a - b).abs() > SAME
    };
    !coordinates.into_iter().any(apart)
}

impl Assemblies {
    /// Are there so many that the poses are not single ones?
    pub fn is_continuous(&self) -> bool {
        self.poses.len() > MOST
    }

    /// Where a pose is in the list.
    fn place(&self, pose: &[CoordinateValue], length: f64) -> Option<usize> {
        let same = |a: &CoordinateValue, b: &CoordinateValue| {
            let apart = (a.value - b.value).abs();
            // Half a turn is the same either way; whole turns that matter are not.
            if a.angular {
                apart < SAME || (apart - TAU).abs() < SAME && (a.value.abs() - PI).abs() < SAME
            } else {
                apart < SAME * length
            }
        };
        self.poses.iter().position(|known| known.iter().zip(pose).all(|(a, b)| same(a, b)))
    }

    fn add(&mut self, pose: Vec<CoordinateValue>) {
        self.poses.push(pose);
        self.found.push(1);
    }
}

/// A coordinate of the n-th of points that fill a cube of any dimension evenly: additive recurrence with the powers of the root of
/// x^(d+1) = x + 1 (Roberts 2018).
fn even(n: usize, index: usize, dimension: usize) -> f64 {
    let power = dimension as f64 + 1.0;
    let root = (0..60).fold(1.5f64, |root, _| libm::pow(1.0 + root, 1.0 / power));
    (0.5 + n as f64 * libm::pow(root, -(index as f64 + 1.0))).fract()
}

#[cfg(test)]
mod tests {
    use super::even;

    #[test]
    fn points_fill_the_square_evenly() {
        let mut cells = [0; 16];
        for n in 1..=160 {
            let [x, y] = [0, 1].map(|index| (4.0 * even(n, index, 2)) as usize);
            cells[4 * x + y] += 1;
        }
        assert!(cells.iter().all(|&count| (7..=13).contains(&count)), "{cells:?}");
    }
}
