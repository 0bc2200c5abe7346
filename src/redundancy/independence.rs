//! Which loop equations are independent, which repeat others, and which restrict in second order only.
//!
//! The rank of Phi_q in a pose that satisfies all loop equations does not decide it: the gradient of one that restricts in second order vanishes there (cos(angle) = 1 at
//! angle = 0), so that it looks like a repetition, though without it the mechanism leaves the pose. What decides is a finite test: poses are
//! left along the directions that Phi_q leaves free, **all** loop equations are closed again, and what survives is the motion. What comes back is a direction that the
//! loop equations forbid in second order; somebody must forbid it by an equation of its own, which the loops imply. Elsewhere than in a pose of the motion,
//! reached like this, where the rank is largest, nothing is counted: the pose at hand may be one where branches meet.
//!
//! Rigidity theory has the conditions of second order (Connelly and Whiteley 1996); for several dependences at once they are a search for a definite combination. The finite
//! test sees all orders, and refuses what it cannot decide: a direction that comes back in fourth order.

use cotree_fmu::constraints::poses::{Loops, scaled, sparse_jacobian};
use cotree_fmu::linalg::least_squares::ResidualFunction;
use cotree_fmu::linalg::singular_values::svd;
use cotree_fmu::linalg::sparse::{self, SparseRow};
use cotree_fmu::machine::Machine;
use cotree_fmu::math::{Random, maximum};
use cotree_fmu::model::{Model, State};
use nalgebra::{DMatrix, DVector};

use super::closing::close;
use super::nearby::consistent_poses;

/// A row counts as dependent when less than this share of it is new.
const NEW: f64 = 1e-8;
/// Where more than this share of each row is new, all are independent. Elsewhere, near a singular pose, rounding errors of the pose make
/// dependent rows look independent: loops that are closed to 1e-9 leave a flat pose open by the square root of that, 3e-5.
const CLEAR: f64 = 1e-4;
/// With more coordinates, and dependent rows, random poses and sparse matrices decide: whole decompositions take minutes.
const LARGEST: usize = 400;
/// How far random poses of large mechanisms are apart, in units of the scales, how many there are, and the parts of the way to them.
const SAMPLES: (f64, usize, usize) = (0.3, 6, 12);
/// How far a pose is left for another one.
const HOP: f64 = 0.1;
/// It must move by this much to be another one, and not by more, or it may be on another branch.
const MOVED: std::ops::Range<f64> = 0.003..0.4;
/// The step of the test of tangents: curvature leaves its square.
const STEP: f64 = 1e-2;
/// What is left of a step along the motion is 1; in second order 1e-3 or less comes back, in fourth order 0.1. Between these bounds nothing is decided.
const BACK: std::ops::Range<f64> = 0.03..0.5;
/// Loop equations that are left out may open by so many gaps where the others are followed.
const OPEN: f64 = 100.0;
/// Random directions in which a pose is left.
const THROWS: usize = 6;
/// Times after the start for poses of driven mechanisms \[s\].
const TIMES: [f64; 5] = [1e-3, 1e-2, 0.05, 0.15, 0.3];
/// Shares of [`HOP`] by which what drives is changed.
const SHARES: [f64; 4] = [1.0, -1.0, 0.2, -0.2];

/// What the loop equations mean for the motion from a pose on.
#[derive(Clone, Debug)]
pub struct Independence {
    /// Directions of motion, time and all that drives standing still.
    pub mobility: usize,
    /// Rows that are independent in a pose of the motion, those asked for first before the others. The rest repeats them, or restricts in second order.
    pub independent: Vec<usize>,
    /// Poses of the motion, the one where the rows were counted first.
    pub poses: Vec<State>,
    /// Directions in that pose, in units of the scales of the coordinates, that the loop equations forbid, but not by their gradients.
    pub forbidden: Vec<Vec<f64>>,
    /// The rows that forbid them: they do not hold where the independent ones are followed.
    pub restricting: Vec<usize>,
}

/// Nothing could be decided, and the rows concerned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undecided {
    /// Rows that depend on others in the pose.
    pub rows: Vec<usize>,
}

/// Sizes that count as nothing.
#[derive(Clone, Copy)]
struct Limits {
    /// The largest residual of loops that are closed.
    gap: f64,
    /// Singular values below it say nothing: a second-order restriction with a gap is off its pose by the root of it.
    flat: f64,
}

const STRICT: Limits = Limits { gap: 1e-10, flat: 1e-5 };
/// For loops that repeat, but for lengths that are typed with few digits.
const LOOSE: Limits = Limits { gap: 1e-6, flat: 1e-3 };

/// Examines the loop equations at a consistent state. `along`: directions, in units of the scales, in which the mechanism will move first, as far as the loops let it; `first`:
/// rows that are independent before others.
///
/// # Errors
/// Rows of which it cannot be said what they restrict.
pub fn independence(
    model: &Model,
    state: &State,
    along: impl FnOnce() -> Vec<Vec<f64>>,
    first: &[usize],
) -> Result<Independence, Undecided> {
    let mut study = Study::new(model, state, first);
    let n = model.mechanical();
    let rows = study.ordered(sparse_jacobian(model, state));
    let (clear, independent) = sparse::independent_rows(rows, NEW, CLEAR);
    if clear && independent.len() == study.rows.len() {
        return Ok(study.regular(state, independent));
    }
    if n > LARGEST {
        return Ok(study.of_samples(state));
    }
    let along = along();
    let strict = study.examine(state, &along, STRICT);
    let locked = strict.as_ref().is_ok_and(|found| found.mobility == 0 && !found.forbidden.is_empty());
    if strict.is_ok() && !locked {
        return strict;
    }
    match study.examine(state, &along, LOOSE) {
        Ok(loose) if loose.forbidden.is_empty() && loose.independent.len() < study.rows.len() => Ok(loose),
        _ => strict,
    }
}

/// A pose: what drives and time in the state, coordinates in units of their scales.
#[derive(Clone)]
struct Pose {
    state: State,
    x: Vec<f64>,
}

/// What is left of a pose when the Jacobian has been decomposed.
struct Decomposed {
    /// Columns are the directions that the gradients leave free.
    free: DMatrix<f64>,
    /// The smallest singular value that counts, and the largest that does not.
    least: f64,
    nothing: f64,
}

struct Study<'a> {
    model: &'a Model,
    machine: Machine,
    random: Random,
    /// Rows with coordinates, in order.
    rows: Vec<usize>,
    /// The same, those asked for first before the others.
    order: Vec<usize>,
}

impl<'a> Study<'a> {
    fn new(model: &'a Model, state: &State, first: &[usize]) -> Self {
        let program = model.program();
        let entries = program.tapes.jacobian.entries.iter();
        let mut rows: Vec<usize> =
            entries.filter(|entry| (entry.1 as usize) < model.mechanical()).map(|entry| entry.0 as usize).collect();
        rows.sort_unstable();
        rows.dedup();
        let rest = rows.iter().copied().filter(|row| !first.contains(row));
        let order = first.iter().copied().chain(rest).collect();
        let mut machine = Machine::new(model);
        machine.load(model, state);
        Self { model, machine, random: Random::new(2), rows, order }
    }

    /// Rows of a matrix in the order in which they count.
    fn ordered(&self, mut rows: Vec<SparseRow>) -> Vec<SparseRow> {
        self.order.iter().map(|&row| std::mem::take(&mut rows[row])).collect()
    }

    /// Places in the order as rows of the program.
    fn named(&self, places: Vec<usize>) -> Vec<usize> {
        let mut rows: Vec<usize> = places.into_iter().map(|place| self.order[place]).collect();
        rows.sort_unstable();
        rows
    }

    fn regular(&self, state: &State, places: Vec<usize>) -> Independence {
        Independence {
            mobility: self.model.mechanical() - places.len(),
            independent: self.named(places),
            poses: vec![state.clone()],
            forbidden: Vec::new(),
            restricting: Vec::new(),
        }
    }

    /// The largest rank over random poses: what restricts in second order is not found.
    fn of_samples(&self, state: &State) -> Independence {
        let (reach, samples, parts) = SAMPLES;
        let poses = consistent_poses(self.model, state, samples, reach, parts);
        let examined = poses
            .iter()
            .map(|pose| sparse::independent_rows(self.ordered(sparse_jacobian(self.model, pose)), NEW, CLEAR));
        let best = examined.fold((false, Vec::new()), |best: (bool, Vec<usize>), other| {
            if (other.0, other.1.len()) > (best.0, best.1.len()) { other } else { best }
        });
        self.regular(state, best.1)
    }

    fn examine(&mut self, state: &State, along: &[Vec<f64>], limits: Limits) -> Result<Independence, Undecided> {
        let mut start = Pose { state: state.clone(), x: scaled(self.model, state) };
        let gap = self.close(&mut start);
        let at_start = self.decompose(&start, limits.flat);
        // Elsewhere singular values count that are ten times those that are nothing here, and what a gap explains.
        let flat = limits.flat.max(10.0 * at_start.nothing).max(10.0 * gap.sqrt());
        let mut reached = self.reached(&start, along, &at_start.free, limits);
        reached.push(start);
        let (place, decomposed) = self.generic(&reached, flat);
        reached.swap(0, place);
        let pose = reached[0].clone();
        let free = decomposed.free.clone();
        let mut moves = free.clone();
        let mut forbidden = DMatrix::zeros(free.nrows(), 0);
        if self.model.mechanical() - free.ncols() < self.rows.len() && free.ncols() > 0 {
            (moves, forbidden) = self.tangents(&pose, &free).ok_or_else(|| self.undecided(&pose, flat))?;
        }
        let independent = self.independent(&pose, flat);
        let restricting = self.opened(&pose, &independent, &free, limits);
        if forbidden.ncols() > 0 {
            self.walk(&mut reached, (&moves, &decomposed), flat, limits);
            self.polish(&mut reached[0], &forbidden, flat);
        } else if !restricting.is_empty() {
            return Err(Undecided { rows: restricting });
        }
        let poses = reached.into_iter().map(|pose| self.load(pose)).collect();
        let forbidden = forbidden.column_iter().map(|column| column.iter().copied().collect()).collect();
        Ok(Independence { mobility: moves.ncols(), independent, poses, forbidden, restricting })
    }

    /// The state of a pose.
    fn load(&mut self, mut pose: Pose) -> State {
        self.loops(&mut pose.state, None).load(&pose.x);
        pose.state
    }

    fn loops<'b>(&'b mut self, state: &'b mut State, only: Option<&'b [usize]>) -> Loops<'b> {
        Loops { model: self.model, machine: &mut self.machine, state, only }
    }

    /// Closes all loop equations; returns the largest residual that is left.
    fn close(&mut self, pose: &mut Pose) -> f64 {
        let rows = std::mem::take(&mut self.rows);
        let gap = close(&mut self.loops(&mut pose.state, Some(&rows)), &mut pose.x);
        self.rows = rows;
        gap
    }

    /// The Jacobian, with rows of zeros so that it has at least as many rows as columns.
    fn jacobian(&mut self, pose: &Pose) -> DMatrix<f64> {
        let n = self.model.mechanical();
        let all = self.loops(&mut pose.state.clone(), None).rows(&pose.x);
        let mut matrix = DMatrix::zeros(self.order.len().max(n), n);
        for (place, row) in self.ordered(all).into_iter().enumerate() {
            row.into_iter().for_each(|(column, value)| matrix[(place, column)] = value);
        }
        matrix
    }

    fn decompose(&mut self, pose: &Pose, flat: f64) -> Decomposed {
        let n = self.model.mechanical();
        let svd = svd(self.jacobian(pose), false, true);
        let values = &svd.singular_values;
        let is_free = |place: &usize| values[*place] <= flat;
        let directions: Vec<usize> = (0..n).filter(is_free).collect();
        let free = match &svd.v_t {
            Some(v_t) => DMatrix::from_fn(n, directions.len(), |row, column| v_t[(directions[column], row)]),
            None => DMatrix::zeros(n, 0),
        };
        let least = values.iter().copied().filter(|value| *value > flat).fold(f64::INFINITY, f64::min);
        let nothing = values.iter().copied().filter(|value| *value <= flat).fold(0.0, f64::max);
        Decomposed { free, least, nothing }
    }

    /// Poses that the motion reaches from the start: left along free directions, or with what drives elsewhere, and closed again.
    fn reached(&mut self, start: &Pose, along: &[Vec<f64>], free: &DMatrix<f64>, limits: Limits) -> Vec<Pose> {
        let mut found = Vec::new();
        for direction in self.directions(along, free) {
            let mut pose = start.clone();
            pose.x.iter_mut().zip(direction.iter()).for_each(|(x, way)| *x += HOP * way);
            self.keep(start, pose, limits, &mut found);
        }
        for pose in self.driven_elsewhere(start) {
            self.keep(start, pose, limits, &mut found);
        }
        found
    }

    /// Closes a pose and keeps it, if it closes near enough.
    fn keep(&mut self, start: &Pose, mut pose: Pose, limits: Limits, found: &mut Vec<Pose>) {
        if self.close(&mut pose) <= limits.gap && MOVED.contains(&apart(&pose, start)) {
            found.push(pose);
        }
    }

    /// Directions of largest component 1 in a space: those given, as far as they lie in it, forwards and backwards, then random ones.
    fn directions(&mut self, along: &[Vec<f64>], space: &DMatrix<f64>) -> Vec<DVector<f64>> {
        let given = along.iter().map(|way| space * space.tr_mul(&DVector::from_column_slice(way)));
        let given: Vec<DVector<f64>> = given.flat_map(|way| [way.clone(), -way]).collect();
        let random = (0..THROWS).map(|_| space * DVector::from_fn(space.ncols(), |_, _| self.random.symmetric()));
        let unit = |way: DVector<f64>| {
            let size = way.amax();
            (size > 1e-6 && size.is_finite()).then(|| way / size)
        };
        given.into_iter().chain(random.collect::<Vec<_>>()).filter_map(unit).collect()
    }

    /// The start at other times, and with other inputs and positions of what follows them, not yet closed.
    fn driven_elsewhere(&mut self, start: &Pose) -> Vec<Pose> {
        let model = self.model;
        let mut poses = Vec::new();
        let mut r = Vec::new();
        let mut residuals = |study: &mut Self, pose: &Pose| {
            study.loops(&mut pose.state.clone(), None).residuals(&pose.x, &mut r);
            DVector::from_column_slice(&r)
        };
        let here = residuals(self, start);
        let changes = |study: &mut Self, pose: &Pose| (residuals(study, pose) - &here).amax();
        let mut changes = changes;
        for time in TIMES {
            let mut pose = start.clone();
            model.advance_signals(&start.state, start.state.time() + time, pose.state.registers_mut());
            if changes(self, &pose) > 0.0 {
                poses.push(pose);
            }
        }
        let (inputs, followers) = (start.state.inputs().len(), start.state.follower_positions().len());
        for signal in 0..inputs + followers {
            let moved = |by: f64| {
                let mut pose = start.clone();
                match signal.checked_sub(inputs) {
                    None => pose.state.inputs_mut()[signal] += by,
                    Some(follower) => pose.state.follower_positions_mut()[follower] += by,
                }
                model.follow(pose.state.registers_mut());
                pose
            };
            /// A step of a slope by differences, of whatever unit.
            const SMALL: f64 = 1e-6;
            let slope = changes(self, &moved(SMALL)) / SMALL;
            if slope > 0.0 && slope.is_finite() {
                poses.extend(SHARES.map(|share| moved(share * HOP / slope)));
            }
        }
        poses
    }

    /// The pose of the largest rank, of these the clearest one.
    fn generic(&mut self, poses: &[Pose], flat: f64) -> (usize, Decomposed) {
        let least = self.model.mechanical().saturating_sub(self.rows.len());
        let mut best: Option<(usize, Decomposed)> = None;
        for (place, pose) in poses.iter().enumerate() {
            let found = self.decompose(pose, flat);
            let better = best.as_ref().is_none_or(|(_, best)| {
                let (a, b) = (found.free.ncols(), best.free.ncols());
                a < b || a == b && found.least > best.least
            });
            let full = found.free.ncols() == least;
            if better {
                best = Some((place, found));
            }
            if full {
                break;
            }
        }
        best.unwrap_or_else(|| (0, Decomposed { free: DMatrix::zeros(0, 0), least: 0.0, nothing: 0.0 }))
    }

    /// The free directions along which closed poses go on, and those from which they come back; none if neither can be said of one.
    fn tangents(&mut self, pose: &Pose, free: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let k = free.ncols();
        let turned = DMatrix::from_fn(k, k, |_, _| self.random.symmetric()).qr().q();
        let basis = free * turned;
        let mut slopes = DMatrix::zeros(free.nrows(), k);
        for (column, way) in basis.column_iter().enumerate() {
            let mut closed = [1.0, -1.0].map(|sign| {
                let mut moved = pose.clone();
                moved.x.iter_mut().zip(way.iter()).for_each(|(x, way)| *x += sign * STEP * way);
                moved
            });
            for pose in &mut closed {
                self.close(pose);
            }
            let [ahead, behind] = &closed;
            for row in 0..free.nrows() {
                slopes[(row, column)] = (ahead.x[row] - behind.x[row]) / (2.0 * STEP);
            }
        }
        let svd = svd(free.tr_mul(&slopes), true, false);
        let values = &svd.singular_values;
        if values.iter().any(|value| BACK.contains(value) || !value.is_finite()) {
            return None;
        }
        let u = svd.u?;
        let part = |goes_on: bool| {
            let columns: Vec<usize> = (0..k).filter(|&column| (values[column] >= BACK.end) == goes_on).collect();
            free * u.select_columns(&columns)
        };
        Some((part(true), part(false)))
    }

    /// Rows that are independent of those before them in a pose.
    fn independent(&mut self, pose: &Pose, flat: f64) -> Vec<usize> {
        let all = self.loops(&mut pose.state.clone(), None).rows(&pose.x);
        let places = sparse::independent_rows(self.ordered(all), flat, CLEAR).1;
        self.named(places)
    }

    fn undecided(&mut self, pose: &Pose, flat: f64) -> Undecided {
        let independent = self.independent(pose, flat);
        Undecided { rows: self.rows.iter().copied().filter(|row| independent.binary_search(row).is_err()).collect() }
    }

    /// Rows that are left out and do not hold where the others are followed.
    fn opened(&mut self, pose: &Pose, kept: &[usize], free: &DMatrix<f64>, limits: Limits) -> Vec<usize> {
        let mut open = Vec::new();
        if kept.len() == self.rows.len() {
            return open;
        }
        for way in self.directions(&[], free).into_iter().take(THROWS / 2) {
            let mut moved = pose.clone();
            moved.x.iter_mut().zip(way.iter()).for_each(|(x, way)| *x += 0.3 * HOP * way);
            let gap = close(&mut self.loops(&mut moved.state, Some(kept)), &mut moved.x);
            let mut r = Vec::new();
            self.loops(&mut moved.state, None).residuals(&moved.x, &mut r);
            let opens = |row: &usize| gap <= limits.gap && r[*row].abs() > OPEN * limits.gap && !open.contains(row);
            let more: Vec<usize> = self.rows.iter().copied().filter(opens).collect();
            open.extend(more);
        }
        open
    }

    /// Makes a pose exact in the directions that are forbidden in second order: there, loops that are closed to rounding leave the root of it. The gradient of what restricts, l Phi_q w with
    /// l from the left null space and w forbidden, has a simple root where the loop equations have a double one.
    fn polish(&mut self, pose: &mut Pose, forbidden: &DMatrix<f64>, flat: f64) {
        /// Newton steps from next to a simple root: the digits double with each, so that four reach rounding.
        const STEPS: usize = 4;
        /// Singular values below it are of directions that nothing determines.
        const RANK: f64 = 1e-4;
        let m = self.order.len();
        let here = svd(self.jacobian(pose), true, false);
        let Some(u) = &here.u else { return };
        let left: Vec<DVector<f64>> = (0..u.ncols())
            .filter(|&column| here.singular_values[column] <= flat)
            .map(|column| u.column(column).into_owned())
            .collect();
        let mut polished = pose.clone();
        for _ in 0..STEPS {
            let jacobian = self.jacobian(&polished);
            let mut r = Vec::new();
            self.loops(&mut polished.state.clone(), None).residuals(&polished.x, &mut r);
            let mut rows: Vec<DVector<f64>> = (0..m).map(|place| jacobian.row(place).transpose()).collect();
            let mut right: Vec<f64> = self.order.iter().map(|&row| -r[row]).collect();
            for way in forbidden.column_iter() {
                let [ahead, behind] = [STEP, -STEP].map(|step| {
                    let mut moved = polished.clone();
                    moved.x.iter_mut().zip(way.iter()).for_each(|(x, way)| *x += step * way);
                    self.jacobian(&moved)
                });
                for l in &left {
                    rows.push((ahead.tr_mul(l) - behind.tr_mul(l)) / (2.0 * STEP));
                    right.push(-(jacobian.tr_mul(l)).dot(&way));
                }
            }
            let matrix = DMatrix::from_fn(rows.len(), jacobian.ncols(), |row, column| rows[row][column]);
            let Ok(step) = svd(matrix, true, true).solve(&DVector::from_vec(right), RANK) else { return };
            polished.x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x += step);
        }
        if apart(&polished, pose) < STEP {
            *pose = polished;
        }
    }

    /// More poses of the motion, step by step from the first one, but not through poses where branches begin.
    fn walk(
        &mut self,
        poses: &mut Vec<Pose>,
        (moves, decomposed): (&DMatrix<f64>, &Decomposed),
        flat: f64,
        limits: Limits,
    ) {
        let from = poses[0].clone();
        let (mut at, mut tangents) = (from.clone(), moves.clone());
        for step in 0..2 * self.model.mechanical().min(24) + 12 {
            let mut next = match moves.ncols() {
                0 => match self.driven_elsewhere(&at) {
                    ways if ways.is_empty() => break,
                    ways => ways[step % ways.len()].clone(),
                },
                _ => {
                    let way = tangents.clone() * DVector::from_fn(tangents.ncols(), |_, _| self.random.symmetric());
                    let mut next = at.clone();
                    let size = way.amax();
                    next.x.iter_mut().zip(way.iter()).for_each(|(x, way)| *x += HOP * way / size);
                    next
                }
            };
            let closes = self.close(&mut next) <= limits.gap;
            let there = self.decompose(&next, flat);
            let near = apart(&next, &at) < 2.0 * HOP && apart(&next, &from) < 4.0 * HOP;
            let alike = there.free.ncols() == decomposed.free.ncols() && there.least > 0.3 * decomposed.least;
            if closes && near && alike {
                poses.push(next.clone());
                at = next;
                // Along what is free there and goes on from here.
                let projected = there.free.tr_mul(&tangents);
                tangents = &there.free * projected;
            } else {
                (at, tangents) = (from.clone(), moves.clone());
            }
        }
    }
}

/// The largest difference of two poses.
fn apart(a: &Pose, b: &Pose) -> f64 {
    a.x.iter().zip(&b.x).fold(0.0, |largest, (a, b)| maximum(largest, (a - b).abs()))
}
