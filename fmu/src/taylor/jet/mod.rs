//! Taylor series of one motion: one factorisation, then order by order.
//!
//! Virtual work on arms b_k = sigma_k e_k, with forces G_k = sum A_kl b_l'' + sum p lambda - loads, gives for each unknown
//!
//! * an angle: I alpha + sum b_k x G_k = torques, over the arms of its frames;
//! * a displacement: e_k . G_k = loads;
//!
//! and the loop equations are constant combinations of the b_k themselves. At every order the newest coefficients enter linearly, with the
//! matrix \[M J^T; J 0\] of the start: see McPhee's Eq. (22).

mod batch;
mod clearance;
mod curves;
mod flight;
mod frames;
mod friction;
mod normals;
mod orders;
mod pairs;
mod pieces;
mod reactions;
mod response;
mod start;
mod step;
mod terms;
mod variation;

use crate::linalg::columns::{Columns, Entry};
use crate::linalg::inverse::LEFT;
use crate::linalg::lane::{Lane, WIDTH, lanes, splat};
use crate::linalg::matrix::{FOUR_AT_ONCE, Matrix, Solve};
use crate::linalg::number::Elementary;
use crate::linalg::tree::{Limb, Recursion};
use crate::machine::Machine;
use crate::model::Model;
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{ArmForm, Cause, Factor, Link, Load, LoopEquation, Slot, Source, Term};
use crate::taylor::coupling::Coupling;
use crate::taylor::tape::{Scalars, Vectors};
use batch::Found;
pub(crate) use batch::{Batch, MEMBERS};
pub use clearance::Changes;
use curves::CurveSlope;
pub(crate) use friction::FrictionAlong;
use friction::Limits;
use reactions::Reactions;
use response::Response;
pub(crate) use start::CLOSED;
use step::Read;
use terms::{Plan, Terms};
pub(crate) use variation::{SERIES_SAFETY, Tangents, VARIED_DIRECTIONS, Variations, variations};

/// What the beginning and the end of a step cost, in instructions of a tape.
const BEGINNING: f64 = 500.0;

/// Place of one order of a lane: the orders of a lane lie side by side.
#[inline(always)]
fn at(lane: usize, order: usize) -> usize {
    lane * ORDERS + order
}

/// The same for a single number.
#[inline(always)]
fn flat<const L: usize>(place: usize, order: usize) -> usize {
    at(place / L, order) * L + place % L
}

/// Place of one order of a lane whose orders are stored the other way round, so that sums of products with others run forwards in both.
#[inline(always)]
fn back(lane: usize, order: usize) -> usize {
    at(lane, ORDERS - 1 - order)
}

/// All orders of a lane.
type Series<N = f64, const L: usize = WIDTH> = [Lane<N, L>; ORDERS];

/// Orders 0 to k of a lane.
#[inline(always)]
fn series<N, const L: usize>(lanes: &[Lane<N, L>], lane: usize, k: usize) -> &[Lane<N, L>] {
    &lanes[at(lane, 0)..at(lane, 0) + k + 1]
}

/// What the storage of the matrix depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    /// Are masses of the same order?
    alike: bool,
    /// Is there an open chain of frames, and nothing else?
    chained: bool,
}

/// Lanes and places of arms.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Lanes of frames, of products, of world arms.
    lanes: [usize; 3],
    counts: [usize; 3],
    /// Places of a lane.
    width: usize,
}

impl Shape {
    /// In lanes of so many.
    fn new(form: &ArmForm, width: usize) -> Self {
        let counts = [form.frames.len(), form.products.len(), form.world.len()];
        Self { lanes: counts.map(|count| count.div_ceil(width)), counts, width }
    }

    fn all(&self) -> usize {
        self.lanes.iter().sum()
    }

    /// Place of an arm.
    fn place(&self, arm: u32) -> usize {
        let (mut arm, mut first) = (arm as usize, 0);
        for (count, lanes) in self.counts.into_iter().zip(self.lanes) {
            if arm < count {
                return first + arm;
            }
            arm -= count;
            first += lanes * self.width;
        }
        first
    }

    fn places(&self) -> usize {
        self.all() * self.width
    }
}

/// value x (x, y) on places.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    place: usize,
    value: Option<Slot>,
    factors: [u32; 2],
}

/// Loads of one kind, the constant ones first.
#[derive(Clone, Debug)]
struct Loads {
    entries: Vec<Scatter>,
    /// So many are constant.
    constant: usize,
}

impl Loads {
    /// Those on unknowns.
    fn of_pushes(form: &ArmForm, shape: &Shape) -> Self {
        Self::new(form.pushes.iter().filter_map(|push| {
            let value = match push.value {
                Cause::One => None,
                Cause::Series(slot) => Some(slot),
                Cause::Reaction { .. } => return None,
            };
            Some(Scatter { place: shape.place(push.unknown), value, factors: [push.factor, 0] })
        }))
    }

    /// Those on arms.
    fn of_arms(form: &ArmForm, shape: &Shape) -> Self {
        let place = |load: &Load| Scatter { place: shape.place(load.arm), value: load.value, factors: load.along };
        Self::new(form.loads.iter().map(place))
    }

    fn new(entries: impl Iterator<Item = Scatter>) -> Self {
        let mut entries: Vec<Scatter> = entries.collect();
        entries.sort_by_key(|entry| entry.value.is_some());
        Self { constant: entries.partition_point(|entry| entry.value.is_none()), entries }
    }
}

/// The series of one motion: of plain numbers, four arms side by side, or of numbers that bring their derivatives, arm by arm. (Plain numbers arm by arm would
/// take 0.88 to 1.0 times as long where slides leave lanes half empty, and 1.3 to 2.4 times as long with frames: not enough for a third copy of the code.)
#[derive(Clone, Debug)]
#[expect(private_bounds, reason = "there are two kinds of numbers")]
pub struct Jet<N: Coefficient = f64, const L: usize = WIDTH> {
    /// Lanes of frames, of all unknowns, and of all equations, if there is nothing but frames and states.
    frames: [usize; 3],
    form: ArmForm,
    shape: Shape,
    /// Coordinates, what carries an angle before what it carries.
    chain: Vec<usize>,
    /// Places of the unknowns, in the order of their equations; without those that go with pairs of rows.
    unknowns: Vec<usize>,
    /// The equation of each row; none of the second one of a pair.
    equations: Vec<Option<usize>>,
    /// The residual of each row.
    row_residual: Vec<N>,
    /// Row, series and coefficient of what loop equations contain of signals.
    row_signals: Vec<(usize, Slot, u32)>,
    /// Place of each frame's unknown.
    turned_by: Vec<Option<usize>>,
    /// Frames whose unknown is another frame's, or that have none, or a signal: handled one by one.
    special: Vec<usize>,
    /// Where coordinates lie among the unknowns.
    reads: Vec<Read>,
    terms: Terms<N>,
    /// Loop equations with functions of unknowns.
    curves: Vec<CurveSlope<N>>,
    /// Loop equations that whole turns leave closed.
    direction_rows: Vec<usize>,
    limits: Limits<N, L>,
    pushes: Loads,
    loads: Loads,
    coupling: Coupling<N, L>,
    rows: Columns<N, L>,
    reactions: Columns<N, L>,
    /// Series of reactions.
    reactions_kept: Reactions<N, L>,
    scalars: Scalars<N, L>,
    coefficients: Vec<N>,
    inertia: Vec<Lane<N, L>>,
    /// One where there is a frame.
    present: Vec<Lane<N, L>>,
    matrix: N::Matrix,
    /// Is it laid out for masses that are alike, and for a chain?
    layout: Option<Layout>,
    /// What a batch has found.
    found: Found,
    /// Of a mechanism of frames only.
    response: Response<N, L>,
    /// The joint of each loop equation.
    groups: Vec<usize>,
    /// Scales of the loop equations.
    row_scales: Vec<f64>,
    /// For each joint how close the loop equations that are left out in a flight are to depending on others; empty if none are left out.
    left_out: Vec<f64>,
    /// World components of arms, by orders.
    x: Vec<Lane<N, L>>,
    y: Vec<Lane<N, L>>,
    /// Rates of frames, by orders the other way round.
    omega: Vec<Lane<N, L>>,
    /// Lengths and unit vectors of products, by orders.
    sigma: Vec<Lane<N, L>>,
    unit: [Vec<Lane<N, L>>; 2],
    /// Forces on arms, by orders the other way round.
    force: [Vec<Lane<N, L>>; 2],
    /// Minus the loads on arms at the present order.
    applied: [Vec<Lane<N, L>>; 2],
    /// Unknowns, by orders.
    values: Vec<Lane<N, L>>,
    /// Second derivatives of arms at the present order, and the forces that go with them.
    second: [Vec<Lane<N, L>>; 2],
    forces: [Vec<Lane<N, L>>; 2],
    /// Known part of the second derivatives of products: all but their ends.
    inner: [Vec<Lane<N, L>>; 2],
    /// The residuals of the equations.
    residual: Vec<N>,
    residual_lanes: Vec<Lane<N, L>>,
    gaps: Vec<Lane<N, L>>,
    solution: Vec<Lane<N, L>>,
    /// Derivatives of arms: first by the angle, then by the length.
    derivatives: [Vec<Lane<N, L>>; 2],
    /// So many scales a second are the least rates that count relative to themselves.
    pub least_rate: f64,
    /// Scales of the unknowns of each lane, and what counts of their rates.
    scales: Vec<f64>,
    weights: Vec<Lane<f64, L>>,
    /// Unknowns and their first two derivatives where the polynomial was last evaluated.
    end: [Vec<Lane<N, L>>; 3],
    /// True if no order behind the first has been found.
    at_start: bool,
}

/// Numbers that series are made of, with what solves their equations.
pub(crate) trait Coefficient: Elementary {
    type Matrix: Solve<Self>;
}

impl Coefficient for f64 {
    type Matrix = Matrix;
}

fn row_signals(form: &ArmForm) -> Vec<(usize, Slot, u32)> {
    let signals = form.rows.iter().enumerate();
    signals.flat_map(|(row, data)| data.signals.iter().map(move |&(slot, factor)| (row, slot, factor))).collect()
}

/// There is no inverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

#[expect(private_bounds, reason = "as above")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// Storage for an arm form of a model, whose coefficients are still to be taken over.
    fn with_storage(model: &Model, form: &ArmForm) -> Self {
        let form = form.clone();
        let shape = Shape::new(&form, L);
        let all = shape.all();
        let turned_by = turned_by(&form);
        let special = (0..form.frames.len())
            .filter(|&index| turned_by[index] != Some(index) || form.frames[index].signal.is_some())
            .collect();
        let plan = Plan::new(&form, &shape, &turned_by, &unknowns(&form, &shape));
        let coupling = coupling(&form, &shape, &plan);
        let curves = curves::curves(&form, |arm| shape.place(arm));
        let (terms, unknowns, equations) = (Terms::new(&plan, &curves), plan.unknowns, plan.rows);
        let row_lanes = form.rows.len().div_ceil(L);
        let count = form.coefficients.results.len();
        let place = |arm: u32| shape.place(arm);
        let arms_of_rows: Vec<Entry> = form
            .rows
            .iter()
            .enumerate()
            .flat_map(|(row, data)| data.arms.iter().map(move |&(arm, p)| (row, shape.place(arm), p)))
            .collect();
        let transposed: Vec<Entry> = arms_of_rows.iter().map(|&(row, arm, p)| (arm, row, p)).collect();
        let zeros = |lanes: usize| vec![splat(N::ZERO); lanes];
        let pair = |lanes: usize| [zeros(lanes), zeros(lanes)];
        let orders = |lanes: usize| zeros(ORDERS * lanes);
        Self {
            frames: [0; 3],
            coupling,
            rows: Columns::new(row_lanes, &arms_of_rows),
            reactions: Columns::new(all, &transposed),
            reactions_kept: Reactions::new(model, &form),
            scalars: Scalars::new(&form.tape, count, place, |arm| flat::<L>(place(arm), 0)),
            coefficients: vec![N::all(f64::NAN); count],
            inertia: zeros(shape.lanes[0]),
            present: present(&shape),
            matrix: N::Matrix::none(),
            layout: None,
            found: Found::default(),
            response: Response::default(),
            groups: groups(model, &form),
            row_scales: row_scales(model, &form),
            left_out: Vec::new(),
            terms,
            direction_rows: curves::direction_rows(model, &form),
            limits: Limits::new(&form, &shape),
            curves,
            pushes: Loads::of_pushes(&form, &shape),
            loads: Loads::of_arms(&form, &shape),
            applied: pair(all),
            chain: form.chain(),
            x: orders(all),
            y: orders(all),
            omega: orders(shape.lanes[0]),
            sigma: orders(shape.lanes[1]),
            unit: [orders(shape.lanes[1]), orders(shape.lanes[1])],
            force: [orders(all), orders(all)],
            values: orders(all),
            second: pair(all),
            forces: pair(all),
            inner: pair(shape.lanes[1]),
            residual: vec![N::ZERO; unknowns.len() + equations.iter().flatten().count()],
            row_residual: vec![N::ZERO; row_lanes * L],
            row_signals: row_signals(&form),
            equations,
            residual_lanes: zeros(all),
            gaps: zeros(row_lanes),
            solution: zeros(all + row_lanes),
            derivatives: pair(2 * all),
            reads: form.coordinates.iter().map(|&coordinate| Read::new(&shape, coordinate)).collect(),
            scales: scales(model, &shape),
            least_rate: model.least_rate(None),
            weights: vec![splat(1.0); all],
            end: [zeros(all), zeros(all), zeros(all)],
            at_start: false,
            unknowns,
            turned_by,
            special,
            shape,
            form,
        }
    }

    /// Takes the coefficients at hand over to what is made of them.
    fn fill(&mut self) {
        let c = &self.coefficients;
        self.coupling.fill(c);
        self.rows.fill(c);
        self.reactions.fill(c);
        self.scalars.fill(c);
        self.reactions_kept.detect_closed(&self.form, c);
        for (place, frame) in self.inertia.as_flattened_mut().iter_mut().zip(&self.form.frames) {
            *place = c[frame.inertia as usize];
        }
    }

    /// What the storage of the matrix has to be, and the limbs of a chain.
    fn wanted_layout(&mut self) -> (Layout, Vec<Limb<N>>) {
        let frames = self.shape.lanes[0] * L;
        let alike = self.terms.are_alike(&self.coefficients, self.unknowns.len(), frames);
        let limbs = self.limbs();
        (Layout { alike, chained: !limbs.is_empty() }, limbs)
    }

    /// The arms as a tree, if its factors are the only ones, or cheaper than the inverse, or better where little is left of a mass.
    fn limbs(&self) -> Vec<Limb<N>> {
        if let Some(tree) = self.coupling.tree() {
            return tree.limbs().to_vec();
        }
        let Some(chain) = self.coupling.chain().filter(|_| self.form.rows.is_empty() && self.form.has_only_frames())
        else {
            return Vec::new();
        };
        let limbs = chain.limbs(&self.inertia);
        if self.coupling.is_long() || Recursion::share_left(&limbs) < LEFT { limbs } else { Vec::new() }
    }

    /// Storage for how a pose of frames only responds.
    fn make_response(&mut self) {
        let counts = [self.form.frames.len(), self.form.rows.len()];
        self.response = Response::new(counts, [self.shape.lanes[0], self.solution.len()]);
    }

    /// Where the solution of each equation goes, and how much room there is.
    fn targets(&self) -> (Vec<usize>, usize) {
        let first = self.shape.places();
        let rows = (first..).zip(&self.equations).filter_map(|(place, equation)| equation.map(|_| place));
        (self.unknowns.iter().copied().chain(rows).collect(), self.solution.len() * L)
    }

    /// A matrix of values for solutions at these places, among so much room.
    fn matrix_for(&self, layout: Layout, targets: Vec<usize>, room: usize) -> Matrix {
        let unknowns = self.unknowns.len();
        match self.form.repeating() {
            0 => Matrix::new(&targets, room, unknowns, self.terms.entries(), layout.alike),
            repeating => Matrix::with_repeating(targets, room, unknowns, repeating, &self.row_scales),
        }
    }
}

impl Jet {
    /// Storage for a model with an arm form.
    pub fn new(model: &Model) -> Option<Self> {
        Some(Self::of(model, model.program().arms.as_ref()?))
    }

    /// The same on the heap. Its parts move through several frames on their way: they are not to be those of the caller.
    pub fn boxed(model: &Model) -> Option<Box<Self>> {
        model.program().arms.as_ref().map(|form| Self::boxed_of(model, form))
    }

    /// The same of an arm form.
    #[inline(never)]
    fn boxed_of(model: &Model, form: &ArmForm) -> Box<Self> {
        Box::new(Self::of(model, form))
    }

    /// Storage for an arm form of a model.
    pub fn of(model: &Model, form: &ArmForm) -> Self {
        let mut jet = Self::with_storage(model, form);
        let mut machine = Machine::new(model);
        machine.load(model, &model.default_state(0.0));
        jet.update(machine.registers());
        let with_states = || jet.form.has_only_frames_and_states() && jet.limits.is_empty();
        if jet.form.has_only_frames() || with_states() {
            let ([frames, ..], lanes) = (jet.shape.lanes, jet.solution.len());
            jet.frames = [frames, jet.shape.all(), lanes];
            if frames == 1 {
                jet.make_response();
            }
        }
        jet
    }

    /// The same without the kernels of mechanisms of few frames, which do not keep reactions.
    pub fn without_kernels(mut self) -> Self {
        self.frames = [0; 3];
        self
    }

    /// Has the mechanism no loops?
    pub fn is_open(&self) -> bool {
        self.form.rows.is_empty()
    }

    /// Are there laws of positions or rates?
    pub fn has_laws(&self) -> bool {
        !self.scalars.is_still() || !self.scalars.is_steady()
    }

    /// Has the mechanism no loops, and no laws of positions or rates?
    pub fn is_even(&self) -> bool {
        self.is_open() && !self.has_laws()
    }

    /// The name of one of them.
    pub fn joint<'a>(&self, model: &'a Model, joint: usize) -> &'a str {
        let row = self.groups.iter().position(|group| *group == joint).map(|row| self.form.rows[row].constraint);
        row.map_or("", |row| &model.program().constraints[row as usize].owner)
    }

    /// Joints and drivers that loops are closed at.
    pub fn groups(&self) -> usize {
        self.groups.last().map_or(0, |last| last + 1)
    }

    /// About what a step costs, in instructions of a tape.
    pub fn cost(&self) -> f64 {
        let form = &self.form;
        let scalars = form.tape.signals.len() + form.tape.positions.len() + form.tape.rates.len();
        let constants = self.coupling.count() + form.rows.iter().map(|row| row.arms.len()).sum::<usize>();
        // Twice at each order, by complex numbers; four sums of products over all orders below.
        let vectors = 8 * lanes(constants) + 2 * ORDERS * self.shape.all();
        let orders = ORDERS as f64 * (FOUR_AT_ONCE * vectors as f64 + (scalars * ORDERS) as f64 / 2.0);
        BEGINNING + self.matrix.cost() + orders
    }

    /// Takes the coefficients over from the registers, after the parameter stage ran.
    pub fn update(&mut self, registers: &[f64]) {
        let results = self.form.coefficients.results(registers);
        let same = self.coefficients.iter().zip(results).all(|(old, new)| old.to_bits() == new.to_bits());
        if same && self.layout.is_some() {
            return;
        }
        for (place, value) in self.coefficients.iter_mut().zip(self.form.coefficients.results(registers)) {
            *place = value;
        }
        self.fill();
        let (layout, limbs) = self.wanted_layout();
        if self.layout != Some(layout) {
            self.layout = Some(layout);
            self.lay_out(layout, &limbs);
        }
        if let Matrix::Chained(recursion) = &mut self.matrix {
            recursion.renew(&limbs);
        }
    }

    /// Storage for the matrix. It allocates: once for a model, and when a changed parameter makes masses alike that were not, or the other way
    /// round.
    fn lay_out(&mut self, layout: Layout, limbs: &[Limb]) {
        if layout.chained {
            self.matrix = Matrix::Chained(Recursion::new(limbs));
            return;
        }
        let (targets, room) = self.targets();
        self.matrix = self.matrix_for(layout, targets, room);
        self.terms.aim(|row, column| self.matrix.places(row, column));
    }
}

/// The place of each frame's unknown.
fn turned_by(form: &ArmForm) -> Vec<Option<usize>> {
    form.frames.iter().map(|frame| frame.unknown.map(|unknown| unknown as usize)).collect()
}

impl ArmForm {
    /// Is every arm a frame whose angle is an unknown of its own, and does no loop equation depend on signals?
    fn has_only_frames(&self) -> bool {
        self.world.is_empty() && self.has_frames_beside_world()
    }

    fn has_frames_beside_world(&self) -> bool {
        let turns_alone = |(index, frame): (usize, &crate::program::arm_form::Frame)| {
            frame.unknown == Some(index as u32) && frame.signal.is_none()
        };
        self.products.is_empty()
            && self.frames.iter().enumerate().all(turns_alone)
            && self.rows.iter().all(|row| row.signals.is_empty())
    }

    /// The same, but for arms in the world that have a mass of their own and take part in nothing but what pushes them: those of states.
    fn has_only_frames_and_states(&self) -> bool {
        let is_frame = |arm: u32| (arm as usize) < self.frames.len();
        let is_apart = |source: &Term| match source.source {
            Source::X(arm) | Source::Y(arm) => is_frame(arm),
            Source::Slot(_) | Source::Unknown(_) | Source::UnknownRate(_) => true,
        };
        let turns = |row: &LoopEquation| {
            row.arms.iter().all(|(arm, _)| is_frame(*arm)) && row.unknowns.iter().all(|(arm, _)| is_frame(*arm))
        };
        self.has_frames_beside_world()
            && self.world.iter().all(|factor| *factor == Factor::Unknown)
            && self.coupling.iter().all(|mass| mass.on == mass.from || is_frame(mass.on) && is_frame(mass.from))
            && self.loads.iter().all(|load| is_frame(load.arm))
            && self.rows.iter().all(turns)
            && self.tape.terms.iter().all(is_apart)
    }

    /// Angles, displacements and loop equations of the linear equations that each order is found by: without those that one component of a gap across a
    /// turning direction says.
    pub fn unknowns_and_equations(&self) -> [usize; 3] {
        let (shape, turned_by) = (Shape::new(self, WIDTH), turned_by(self));
        let plan = Plan::new(self, &shape, &turned_by, &unknowns(self, &shape));
        let angles = plan.unknowns.iter().filter(|place| **place < shape.lanes[0] * WIDTH).count();
        [angles, plan.unknowns.len() - angles, plan.rows.iter().flatten().count() - self.repeating()]
    }
}

/// The masses between arms: of a tree by its links, else of every two.
fn coupling<N: Elementary, const L: usize>(form: &ArmForm, shape: &Shape, plan: &Plan) -> Coupling<N, L> {
    let (all, frames) = (shape.all(), form.frames.len());
    let place = |arm: u32| shape.place(arm);
    if form.links.is_empty() {
        let masses: Vec<Entry> =
            form.coupling.iter().map(|entry| (place(entry.on), place(entry.from), entry.mass)).collect();
        return Coupling::new(all, frames, &masses);
    }
    let limb = |link: &Link| {
        let (place, lines) = (place(link.arm), link.arm as usize >= frames);
        let derivative = if lines { shape.places() + place } else { place };
        let parent = link.parent.map(|parent| parent as usize);
        Limb {
            place,
            derivative,
            parent,
            equation: plan.equation(place),
            begin: [N::ZERO; 2],
            carried: [N::ZERO; 2],
            inertia: N::ZERO,
        }
    };
    let masses = form.links.iter().map(|link| (link.begin, link.carried, link.inertia)).collect();
    Coupling::of_tree(all, shape.lanes[0] * L, form.links.iter().map(limb).collect(), masses)
}

/// What scalar series read of the others.
#[inline(always)]
fn vectors<'a, N: Elementary, const L: usize>(
    x: &'a [Lane<N, L>],
    y: &'a [Lane<N, L>],
    values: &'a [Lane<N, L>],
    lanes: usize,
) -> Vectors<'a, N, L> {
    Vectors { x: x.as_flattened(), y: y.as_flattened(), unknowns: values.as_flattened(), stride: lanes * L }
}

/// For each loop equation the number of the joint that it belongs to.
fn groups(model: &Model, form: &ArmForm) -> Vec<usize> {
    let owner = |row: &LoopEquation| &model.program().constraints[row.constraint as usize].owner;
    let mut group = 0;
    let mut groups = Vec::with_capacity(form.rows.len());
    for (index, row) in form.rows.iter().enumerate() {
        group += usize::from(index > 0 && owner(row) != owner(&form.rows[index - 1]));
        groups.push(group);
    }
    groups
}

/// The scale of each loop equation.
fn row_scales(model: &Model, form: &ArmForm) -> Vec<f64> {
    form.rows.iter().map(|row| model.program().constraints[row.constraint as usize].scale).collect()
}

/// Places of the unknowns: angles, then displacements.
fn unknowns(form: &ArmForm, shape: &Shape) -> Vec<usize> {
    let unknown_of = |(index, frame): (usize, &crate::program::arm_form::Frame)| {
        (frame.unknown == Some(index as u32)).then_some(index as u32)
    };
    let frames = form.frames.iter().enumerate().filter_map(unknown_of);
    let products = form.products.iter().map(|product| product.factor);
    let lengths = products.chain(form.world.iter().copied()).enumerate();
    let displacements = lengths.filter(|(_, factor)| *factor == Factor::Unknown);
    let displacements = displacements.map(|(index, _)| (form.frames.len() + index) as u32);
    frames.chain(displacements).map(|arm| shape.place(arm)).collect()
}

/// One for each frame, zero for places that are left over.
fn present<N: Elementary, const L: usize>(shape: &Shape) -> Vec<Lane<N, L>> {
    let mut present = vec![splat(N::ZERO); shape.lanes[0]];
    present.as_flattened_mut()[..shape.counts[0]].fill(N::all(1.0));
    present
}

/// Scales of the unknowns of each lane: 1 for angles, the length of the mechanism for displacements.
fn scales(model: &Model, shape: &Shape) -> Vec<f64> {
    let frames = shape.lanes[0];
    (0..shape.all()).map(|lane| if lane < frames { 1.0 } else { model.program().length }).collect()
}
