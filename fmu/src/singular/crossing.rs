//! Do branches cross in a pose in which loop equations depend on each other?
//!
//! That is geometry, and no matter of how well the motion is known. A combination of the loop equations vanishes there to first order. Where the other equations
//! hold, what is left of it is a saddle, d + x H x / 2, and branches are where it vanishes: they cross in the saddle if the defect d is zero, and turn off before it, at
//! a distance of about the root of d, if it is not. A motion that is known to a tolerance comes by somewhere near, where what is left may have any value. So
//! Newton's method goes to the saddle first; time is one of its unknowns, for drivers have a part in where it is.
//!
//! Each combination touches few coordinates. The independent equations are solved for as many coordinates, which leaves others free: a free coordinate moves with
//! those that depend on it, a short vector. In the vectors that bend a combination its saddle is a small matrix.

use nalgebra::{DMatrix, DVector};

use crate::constraints::poses::{Loops, imposed, scaled};
use crate::linalg::elimination::{Dependent, Elimination, EntryList};
use crate::linalg::lane::{Lane, WIDTH, ZERO, multiply, splat};
use crate::linalg::least_squares::ResidualFunction;
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};
use crate::singular::detect::open_poses;

/// At the pose less than this share of a loop equation is new if it depends on the others. A pose that is known to 1e-3 is off by the root of that in what is
/// new: the larger shares are for those.
const NEW: [f64; 3] = [0.02, 0.1, 0.3];
/// At most so many steps of Newton's method lead to the saddle.
const SADDLE_STEPS: usize = 8;
/// So many of them go to the saddles of all combinations at once, which lie in the same place where the pose is exact.
const STEPS_TO_ALL_SADDLES: usize = 3;
/// It is as good as reached where a step is this small, in units of the scales: what is left there follows from the first and second derivatives but for the cube of
/// the step.
const SADDLE_REACHED: f64 = 1e-5;
/// A step longer than this leads elsewhere.
const LONGEST_SADDLE_STEP: f64 = 0.3;
/// For derivatives by time [s].
const DIFFERENCE: f64 = 1e-5;
/// Directions in which the saddle bends by less than this share of the most do not matter for where it is.
const FLAT_DIRECTION: f64 = 1e-4;
/// A loop equation with a smaller share in a combination does not bend its saddle: what is left is wrong by half of this times the square of a step of [`SADDLE_REACHED`].
const SMALLEST: f64 = 1e-6;

/// Loop equations that depend on each other in a pose.
pub(super) struct Crossing {
    /// The loop equations that count in the pose.
    pub imposed: Vec<usize>,
    /// For each that depends on others the combination that vanishes, by their places in that list; its largest share is 1.
    pub combinations: Vec<EntryList>,
    /// The coordinates in each loop equation that counts.
    pub columns: Vec<Vec<usize>>,
    /// By how much branches miss each other there, relative to the scales of the loop equations.
    pub defect: f64,
}

impl Crossing {
    /// In the pose of a state; none if rounding errors hide it.
    pub fn of(model: &Model, state: &State) -> Option<Self> {
        let mut study = Study::new(model, imposed(model, state));
        let (rows, drives) = (study.rows(state), study.drives(state));
        let mut found = independent(model, &rows, &study.sizes(&rows, state))?;
        if is_driven(&drives) {
            found = study.solve(rows, &drives, &found.independent)?;
        }
        let here = study.pose(state, found, &drives);
        let combinations = here.found.dependent.iter().map(combination).collect();
        let mut defect = 0.0;
        for (place, known) in study.defects_together(&here).into_iter().enumerate() {
            let defect_here = known.unwrap_or_else(|| study.defect(&here, place));
            defect = math::maximum(defect, defect_here.abs());
        }
        let Study { changes, columns, .. } = study;
        Some(Self { imposed: changes.imposed, combinations, columns, defect })
    }
}

fn norm(entries: &[(usize, f64)]) -> f64 {
    entries.iter().map(|(_, value)| value * value).sum::<f64>().sqrt()
}

/// Rows solved where they do not depend on those before them. What is new in a row is compared with its size in other poses: a row of rounding errors is no direction, and that of a link much shorter than
/// the mechanism is one.
fn independent(model: &Model, rows: &[EntryList], sizes: &[f64]) -> Option<Elimination> {
    let n = model.coordinates();
    let of = |new: f64| Elimination::new(rows, [n, n + 1], |row, rest| norm(rest) <= new * sizes[row]);
    NEW.iter().try_fold(None, |found: Option<Elimination>, new| match found {
        Some(found) if !found.dependent.is_empty() => Some(Some(found)),
        _ => of(*new).map(Some),
    })?
}

fn is_driven(drives: &[f64]) -> bool {
    drives.iter().any(|drive| *drive != 0.0)
}

/// Of which the largest share is 1.
fn combination(row: &Dependent) -> EntryList {
    let largest = size(row);
    row.shares.iter().map(|(place, share)| (*place, share / largest)).collect()
}

fn size(row: &Dependent) -> f64 {
    row.shares.iter().fold(0.0, |largest, (_, share)| math::maximum(largest, share.abs()))
}

/// A second derivative of a loop equation: by which columns, and the value.
type Curvature = (usize, usize, f64);

/// A pose: the loop equations that count there in units of the scales, and what follows from their rows. The column after those of the coordinates is that of time.
struct Pose {
    state: State,
    open: Vec<f64>,
    found: Elimination,
    /// A change that closes the independent equations while free columns stay, by columns.
    closing: Vec<f64>,
    /// How far all columns move together with each free one.
    lengths: Vec<f64>,
    /// By loop equations.
    curvatures: Vec<Vec<Curvature>>,
}

impl Pose {
    /// What is left of a combination.
    fn value(&self, place: usize) -> f64 {
        self.combined(&self.found.dependent[place].shares) / size(&self.found.dependent[place])
    }

    fn combined(&self, shares: &[(usize, f64)]) -> f64 {
        shares.iter().map(|(row, share)| share * self.open[*row]).sum()
    }

    /// The curvature of a combination and what bends it.
    fn bend(&self, place: usize) -> Bend {
        let row = &self.found.dependent[place];
        let largest = size(row);
        let shares = row.shares.iter().map(|(row, share)| (&self.curvatures[*row], share / largest));
        let bending = shares.filter(|(_, share)| share.abs() > SMALLEST);
        let mut entries = Vec::with_capacity(bending.clone().map(|(curvatures, _)| curvatures.len()).sum());
        for (curvatures, share) in bending {
            entries.extend(curvatures.iter().map(|(a, b, value)| (*a, *b, share * value)));
        }
        let mut columns: Vec<usize> = entries.iter().map(|entry| entry.0).collect();
        columns.sort_unstable();
        columns.dedup();
        let mut free = Vec::new();
        for &column in &columns {
            match self.found.solved_for(column) {
                Some(solved) => free.extend(solved.rest.iter().map(|(column, _)| *column)),
                None => free.push(column),
            }
        }
        free.sort_unstable();
        free.dedup();
        Bend { entries, columns, free }
    }

    /// How far a column moves if the independent equations are closed and free columns move so far.
    fn moved(&self, column: usize, free: &[f64]) -> f64 {
        let Some(solved) = self.found.solved_for(column) else { return free[column] };
        self.closing[column] - solved.rest.iter().map(|(column, value)| value * free[*column]).sum::<f64>()
    }

    /// All columns, moved like that.
    fn way(&self, free: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        (0..free.len()).map(|column| (column, self.moved(column, free)))
    }

    /// One step of Newton's method from the pose, free columns moved so far, to where a combination does not change along what the independent equations leave free.
    fn saddle(&self, place: usize, shift: &[f64]) -> Option<Saddle> {
        let Bend { entries, columns, free } = self.bend(place);
        let along = |column: &usize, free: &usize| self.found.along(*column, *free) / self.lengths[*free];
        let parts = columns.iter().flat_map(|column| free.iter().map(move |free| (column, free)));
        let mut vectors = Vec::with_capacity(columns.len() * free.len());
        vectors.extend(parts.map(|(column, free)| along(column, free)));
        let vector = |column: usize| &vectors[column * free.len()..][..free.len()];
        let moved: Vec<f64> = columns.iter().map(|&column| self.moved(column, shift)).collect();
        let (row, largest) = (&self.found.dependent[place], size(&self.found.dependent[place]));
        let slope = |column: usize| {
            row.rest.iter().find(|(other, _)| *other == column).map_or(0.0, |(_, value)| value / largest)
        };
        let mut sloping = DVector::from_iterator(free.len(), free.iter().map(|&free| slope(free) / self.lengths[free]));
        let (mut bend, mut left) = (DMatrix::zeros(free.len(), free.len()), self.value(place));
        left += row.rest.iter().map(|(column, value)| value / largest * shift[*column]).sum::<f64>();
        for (a, b, value) in entries {
            let (Ok(a), Ok(b)) = (columns.binary_search(&a), columns.binary_search(&b)) else { continue };
            left += 0.5 * value * moved[a] * moved[b];
            for (i, one) in vector(a).iter().enumerate().filter(|(_, one)| **one != 0.0) {
                sloping[i] += value * moved[b] * one;
                vector(b).iter().enumerate().for_each(|(j, other)| bend[(i, j)] += value * one * other);
            }
        }
        let finite = bend.iter().chain(&sloping).all(|entry: &f64| entry.is_finite());
        if !finite {
            return None;
        }
        let eigen = bend.symmetric_eigen();
        let least = FLAT_DIRECTION * eigen.eigenvalues.amax();
        let inverse = eigen.eigenvalues.map(|value| if value.abs() > least { 1.0 / value } else { 0.0 });
        let weights = -(&eigen.eigenvectors * eigen.eigenvectors.tr_mul(&sloping).component_mul(&inverse));
        left += 0.5 * sloping.dot(&weights);
        let part = |column: usize| moved[column] + vector(column).iter().zip(&weights).map(|(a, b)| a * b).sum::<f64>();
        let length = (0..moved.len()).map(part).fold(0.0, |most, part| math::maximum(most, part.abs()));
        Some(Saddle { weights: free.into_iter().zip(weights.iter().copied()).collect(), length, left })
    }

    /// Adds a step to how far free columns move.
    fn go(&self, saddle: &Saddle, free: &mut [f64]) {
        saddle.weights.iter().for_each(|&(column, weight)| free[column] += weight / self.lengths[column]);
    }
}

/// Second derivatives of a combination of the loop equations, its shares fixed.
struct Bend {
    entries: Vec<Curvature>,
    /// Columns that they are by.
    columns: Vec<usize>,
    /// Free columns that these move with.
    free: Vec<usize>,
}

/// A step of Newton's method to a saddle.
struct Saddle {
    /// By free columns, in units of how far all columns move with them.
    weights: EntryList,
    /// The largest part of the whole way among the columns that bend the saddle.
    length: f64,
    /// What is left of the combination in the saddle, up to second order: with the multipliers of the pose it is stationary there (Nocedal and Wright, Numerical
    /// Optimization, 2006, 18.1).
    left: f64,
}

/// How an entry of a loop equation's row changes along four directions: row and column, in units of the scales.
pub(super) type Change = (usize, usize, Lane);

/// Second derivatives of the loop equations, exact, along directions.
pub(super) struct Changes<'a> {
    model: &'a Model,
    /// The loop equations whose rows are asked for.
    imposed: Vec<usize>,
    machine: Machine,
    /// Four for each register.
    tangents: Vec<f64>,
}

impl<'a> Changes<'a> {
    pub fn new(model: &'a Model, imposed: Vec<usize>) -> Self {
        let tangents = vec![0.0; WIDTH * model.program().registers as usize];
        Self { model, imposed, machine: Machine::new(model), tangents }
    }

    /// Of the rows at a state along these changes of coordinates, in units of the scales.
    pub fn along(&mut self, state: &State, directions: impl Iterator<Item = (usize, Lane)>) -> Vec<Change> {
        let (model, program) = (self.model, self.model.program());
        let (jacobian, first) = (&program.tapes.jacobian, model.layout().positions());
        let scale = |column: usize| program.coordinates[column].scale;
        self.machine.load(model, state);
        let (tangents, _) = self.tangents.as_chunks_mut();
        tangents[first..][..model.coordinates()].fill(ZERO);
        directions.for_each(|(column, parts)| tangents[first + column] = multiply(splat(scale(column)), parts));
        self.machine.run_tangents(&jacobian.tape, tangents);
        let entries = jacobian.entries.iter().zip(&jacobian.tape.results);
        let entries = entries.filter(|((_, column), _)| (*column as usize) < model.coordinates());
        let change = |(&(row, column), &result): (&(u32, u32), &u32)| {
            let (row, column) = (row as usize, column as usize);
            let factor = scale(column) / program.constraints[row].scale;
            let place = self.imposed.binary_search(&row).ok()?;
            Some((place, column, multiply(splat(factor), tangents[result as usize])))
        };
        entries.filter_map(change).filter(|(.., changes)| *changes != ZERO).collect()
    }
}

/// The storage for studying the poses of a model.
struct Study<'a> {
    model: &'a Model,
    changes: Changes<'a>,
    /// Columns of the same colour are in no loop equation together: the entries of a row that change along all of them tell which one it is.
    colours: Vec<usize>,
    /// By loop equations.
    columns: Vec<Vec<usize>>,
}

impl<'a> Study<'a> {
    fn new(model: &'a Model, imposed: Vec<usize>) -> Self {
        let columns = columns(model, &imposed);
        let colours = colours(model.coordinates(), &columns);
        Self { model, changes: Changes::new(model, imposed), colours, columns }
    }

    fn loops<'b>(&'b mut self, state: &'b mut State) -> Loops<'b> {
        let Changes { model, imposed, machine, .. } = &mut self.changes;
        Loops { model, machine, state, only: Some(imposed) }
    }

    /// The rows of the loop equations at a state.
    fn rows(&mut self, state: &State) -> Vec<EntryList> {
        let (x, mut state, mut entries) = (scaled(self.model, state), state.clone(), Vec::new());
        self.loops(&mut state).jacobian(&x, &mut entries);
        let mut rows: Vec<EntryList> =
            self.columns.iter().map(|column| EntryList::with_capacity(column.len() + 1)).collect();
        entries.iter().for_each(|&(row, column, value)| rows[row].push((column, value)));
        rows.iter_mut().for_each(|row| row.sort_unstable_by_key(|entry| entry.0));
        rows
    }

    /// How large each row is where it is largest, in this pose and in others.
    fn sizes(&mut self, rows: &[EntryList], state: &State) -> Vec<f64> {
        let mut sizes: Vec<f64> = rows.iter().map(|row| norm(row)).collect();
        let (mut entries, mut squares) = (Vec::new(), vec![0.0; rows.len()]);
        for mut pose in open_poses(self.model, state) {
            let x = scaled(self.model, &pose);
            self.loops(&mut pose).jacobian(&x, &mut entries);
            squares.fill(0.0);
            entries.iter().for_each(|(row, _, value)| squares[*row] += value * value);
            // A law may have no value there.
            let others = sizes.iter_mut().zip(&squares).filter(|(_, square)| square.is_finite());
            others.for_each(|(size, square)| *size = math::maximum(*size, square.sqrt()));
        }
        sizes
    }

    /// How fast drivers open the loop equations at a state.
    fn drives(&mut self, state: &State) -> Vec<f64> {
        let (model, mut resting) = (self.model, state.clone());
        resting.rates_mut().fill(0.0);
        let Changes { imposed, machine, .. } = &mut self.changes;
        machine.load(model, &resting);
        let tape = &model.program().tapes.constraint_rate;
        machine.run(tape);
        imposed.iter().map(|&row| machine.result(tape, row) / model.program().constraints[row].scale).collect()
    }

    /// Rows with the rates at which drivers open them, solved for the independent ones; none if these are not.
    fn solve(&self, mut rows: Vec<EntryList>, drives: &[f64], independent: &[bool]) -> Option<Elimination> {
        let n = self.model.coordinates();
        rows.iter_mut().zip(drives).filter(|(_, drive)| **drive != 0.0).for_each(|(row, drive)| row.push((n, *drive)));
        Elimination::new(&rows, [n, n + 1], |row, _| !independent[row])
    }

    /// Evaluates a pose; none if its independent rows are not.
    fn at(&mut self, independent: &[bool], state: &State) -> Option<Pose> {
        let (rows, drives) = (self.rows(state), self.drives(state));
        let found = self.solve(rows, &drives, independent)?;
        Some(self.pose(state, found, &drives))
    }

    /// What follows from solved rows.
    fn pose(&mut self, state: &State, found: Elimination, drives: &[f64]) -> Pose {
        let (n, x, mut open) = (self.model.coordinates(), scaled(self.model, state), Vec::new());
        self.loops(&mut state.clone()).residuals(&x, &mut open);
        let (mut closing, mut lengths) = (vec![0.0; n + 1], vec![1.0; n + 1]);
        for solved in &found.solved {
            closing[solved.column] = -solved.shares.iter().map(|(row, share)| share * open[*row]).sum::<f64>();
            solved.rest.iter().for_each(|(free, value)| lengths[*free] += value * value);
        }
        lengths.iter_mut().for_each(|length| *length = length.sqrt());
        let mut curvatures = self.curvatures(state);
        self.bend_in_time(state, drives, &mut curvatures);
        Pose { state: state.clone(), open, found, closing, lengths, curvatures }
    }

    /// Second derivatives of all loop equations by the coordinates, exact.
    fn curvatures(&mut self, state: &State) -> Vec<Vec<Curvature>> {
        let mut curvatures = vec![Vec::new(); self.columns.len()];
        let most = self.colours.iter().max().map_or(0, |most| most + 1);
        for four in 0..most.div_ceil(WIDTH) {
            let of_four = self.colours.iter().enumerate().filter(|(_, colour)| **colour / WIDTH == four);
            let directions = of_four.map(|(column, colour)| (column, unit(colour % WIDTH)));
            for (row, column, change) in self.changes.along(state, directions) {
                let of_row = self.columns[row].iter().filter(|by| self.colours[**by] / WIDTH == four);
                let changes = of_row.map(|by| (column, *by, change[self.colours[*by] % WIDTH]));
                curvatures[row].extend(changes.filter(|(.., change)| *change != 0.0));
            }
        }
        curvatures
    }

    /// Those by time, of the equations that drivers are in.
    fn bend_in_time(&mut self, state: &State, drives: &[f64], curvatures: &mut [Vec<Curvature>]) {
        if !is_driven(drives) {
            return;
        }
        let (model, n) = (self.model, self.model.coordinates());
        let [before, after] = [-DIFFERENCE, DIFFERENCE].map(|shift| {
            let moved = moved(model, state, [(n, 1.0)], shift);
            (self.rows(&moved), self.drives(&moved))
        });
        for (row, curvatures) in curvatures.iter_mut().enumerate().filter(|(row, _)| drives[*row] != 0.0) {
            for ((column, after), (_, before)) in after.0[row].iter().zip(&before.0[row]) {
                let mixed = (after - before) / (2.0 * DIFFERENCE);
                curvatures.extend([(*column, n, mixed), (n, *column, mixed)]);
            }
            curvatures.push((n, n, (after.1[row] - before.1[row]) / (2.0 * DIFFERENCE)));
        }
    }

    /// What is left of the combinations in their saddles, as far as a few steps towards all of them at once tell.
    fn defects_together(&mut self, here: &Pose) -> Vec<Option<f64>> {
        let mut defects = vec![None; here.found.dependent.len()];
        let (still, mut moved_on) = (vec![0.0; here.closing.len()], None);
        for _ in 0..STEPS_TO_ALL_SADDLES {
            let pose = moved_on.as_ref().unwrap_or(here);
            let mut free = vec![0.0; pose.closing.len()];
            let mut far = false;
            for (place, defect) in defects.iter_mut().enumerate().filter(|(_, defect)| defect.is_none()) {
                let Some(saddle) = pose.saddle(place, &still) else { continue };
                if saddle.length < SADDLE_REACHED {
                    *defect = Some(saddle.left);
                } else if let Some(saddle) = pose.saddle(place, &free) {
                    far |= saddle.length > LONGEST_SADDLE_STEP;
                    pose.go(&saddle, &mut free);
                }
            }
            if far || defects.iter().all(Option::is_some) {
                break;
            }
            let next = moved(self.model, &pose.state, pose.way(&free), 1.0);
            let Some(next) = self.at(&here.found.independent, &next) else { break };
            moved_on = Some(next);
        }
        defects
    }

    /// What is left of one of the combinations in its saddle.
    fn defect(&mut self, here: &Pose, place: usize) -> f64 {
        let (still, mut moved_on) = (vec![0.0; here.closing.len()], None);
        for _ in 0..SADDLE_STEPS {
            let pose = moved_on.as_ref().unwrap_or(here);
            let Some(saddle) = pose.saddle(place, &still) else { return pose.value(place) };
            if saddle.length < SADDLE_REACHED {
                return saddle.left;
            }
            // Written so that NaN leads elsewhere too.
            let near = saddle.length <= LONGEST_SADDLE_STEP;
            if !near {
                return pose.value(place);
            }
            let mut free = vec![0.0; pose.closing.len()];
            pose.go(&saddle, &mut free);
            let next = moved(self.model, &pose.state, pose.way(&free), 1.0);
            let Some(next) = self.at(&here.found.independent, &next) else { return pose.value(place) };
            moved_on = Some(next);
        }
        moved_on.as_ref().unwrap_or(here).value(place)
    }
}

/// The coordinates in each loop equation, whatever the pose.
fn columns(model: &Model, imposed: &[usize]) -> Vec<Vec<usize>> {
    let mut columns = vec![Vec::new(); imposed.len()];
    for &(row, column) in &model.program().tapes.jacobian.entries {
        if let (Ok(place), true) = (imposed.binary_search(&(row as usize)), (column as usize) < model.coordinates()) {
            columns[place].push(column as usize);
        }
    }
    columns.iter_mut().for_each(|columns| {
        columns.sort_unstable();
        columns.dedup();
    });
    columns
}

/// Colours of so many columns: the first that no column has that is in a row with it (Curtis, Powell and Reid, IMA J. Appl. Math. 13, 1974).
fn colours(count: usize, rows: &[Vec<usize>]) -> Vec<usize> {
    let mut rows_of = vec![Vec::new(); count];
    rows.iter().enumerate().for_each(|(row, columns)| columns.iter().for_each(|column| rows_of[*column].push(row)));
    let mut colours = vec![usize::MAX; count];
    let mut taken = Vec::new();
    for column in 0..count {
        taken.clear();
        taken.extend(rows_of[column].iter().flat_map(|row| &rows[*row]).map(|other| colours[*other]));
        taken.sort_unstable();
        taken.dedup();
        colours[column] =
            taken.iter().enumerate().find(|(place, colour)| place != *colour).map_or(taken.len(), |(place, _)| place);
    }
    colours
}

/// One in one of four places.
fn unit(place: usize) -> Lane {
    std::array::from_fn(|lane| if lane == place { 1.0 } else { 0.0 })
}

/// A pose so many times a way further, in units of the scales and in time.
fn moved(model: &Model, pose: &State, way: impl IntoIterator<Item = (usize, f64)>, times: f64) -> State {
    let mut moved = pose.clone();
    for (column, part) in way.into_iter().filter(|(_, part)| *part != 0.0) {
        match model.program().coordinates.get(column) {
            Some(coordinate) => moved.positions_mut()[column] += times * part * coordinate.scale,
            None => model.advance_signals(pose, pose.time() + times * part, moved.registers_mut()),
        }
    }
    moved
}
