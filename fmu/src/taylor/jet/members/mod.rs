//! The series of several motions of one mechanism at once, each with its own parameters, pose and step: the members of an ensemble.
//!
//! What [`super::orders`] does for four arms of one motion is done here for one arm of several motions, by the same operations for every member, so that its bits do
//! not depend on its neighbours. Mechanisms whose laws are steep or in pieces, whose loop equations turn, or that need pivots or chains, are not taken: their
//! members run one by one.

mod frames;
mod laws;
mod orders;
mod sparse;
mod start;
mod step;
mod variation;

use super::step::Read;
use super::terms::{Plan, Terms};
use super::{Jet, Loads, Shape, groups, row_scales, turned_by, unknowns};
use crate::linalg::factors::{Factors, Pattern};
use crate::linalg::many::{Elementary, Many, Number};
use crate::model::Model;
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{ArmForm, Factor, Slot};
use laws::Laws;
use sparse::{Complex, Pairs};
pub(crate) use start::Begun;
pub(crate) use variation::{DIRECTIONS, Tangents, Variations, variations};

/// More equations are served as well by the four arms of one motion.
const MOST_EQUATIONS: usize = 64;

/// The coefficients of one function of time.
type Series<N> = [N; ORDERS];

/// One arm, and the unknown that bears its number.
#[derive(Clone, Debug)]
struct Arm<N> {
    /// World components.
    x: Series<N>,
    y: Series<N>,
    /// The rate of a frame, the length of another arm.
    rate: Series<N>,
    force: [Series<N>; 2],
    /// The unknown, if there is one.
    value: Series<N>,
    /// At the present order: second derivatives, loads with their signs turned, what is known of a product, the residual of the balance.
    second: [N; 2],
    applied: [N; 2],
    inner: [N; 2],
    residual: N,
    /// What counts of the unknown's rates.
    weight: N,
    /// The unknown and its first two derivatives where the polynomial was last evaluated.
    end: [N; 3],
}

impl<N: Number> Arm<N> {
    const NEW: Self = Self {
        x: [N::ZERO; ORDERS],
        y: [N::ZERO; ORDERS],
        rate: [N::ZERO; ORDERS],
        force: [[N::ZERO; ORDERS]; 2],
        value: [N::ZERO; ORDERS],
        second: [N::ZERO; 2],
        applied: [N::ZERO; 2],
        inner: [N::ZERO; 2],
        residual: N::ZERO,
        weight: N::ZERO,
        end: [N::ZERO; 3],
    };
}

/// How a frame turns.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// The arm that bears the number of its unknown.
    unknown: Option<usize>,
    signal: Option<Slot>,
    inertia: u32,
}

/// An arm of changing length, in a frame or along the world's X axis.
#[derive(Clone, Copy, Debug)]
struct Slide {
    arm: usize,
    factor: Factor,
    frame: Option<usize>,
}

/// The series of several motions.
#[derive(Clone, Debug)]
pub(crate) struct Members<N> {
    form: ArmForm,
    /// Frames, if there is nothing else and few of them, and how their pose responds.
    frames: usize,
    response: Vec<N>,
    /// Coordinates, what carries an angle before what it carries.
    chain: Vec<usize>,
    reads: Vec<Read>,
    /// The arm of each unknown, in the order of their equations, with the least of its rates that counts relative to itself, and its place in a
    /// polynomial.
    unknowns: Vec<usize>,
    least_rates: Vec<f64>,
    stored: Vec<usize>,
    /// Numbers of one order of a polynomial.
    stride: usize,
    turns: Vec<Turn>,
    slides: Vec<Slide>,
    /// The joint and the scale of each loop equation.
    groups: Vec<usize>,
    row_scales: Vec<f64>,
    terms: Terms,
    pushes: Loads,
    loads: Loads,
    coupling: Complex,
    rows: Pairs,
    factors: Factors<N>,
    coefficients: Vec<N>,
    laws: Laws<N>,
    arms: Vec<Arm<N>>,
    /// Gaps of the loops; right-hand sides and solution by equations.
    gaps: Vec<N>,
    vector: Vec<N>,
    solution: Vec<N>,
    /// Derivatives of arms: first by the angle, then by the length.
    derivatives: [Vec<N>; 2],
}

impl<N: Elementary> Members<N> {
    /// Storage for a model whose motions can be found together.
    pub fn new(model: &Model) -> Option<Self> {
        let form = model.program().arms.as_ref().filter(|form| serves(form))?.clone();
        let (shape, turned_by) = (Shape::plain(&form), turned_by(&form));
        let plan = Plan::new(&form, &shape, &turned_by, &unknowns(&form, &shape));
        let (mut terms, unknowns) = (Terms::new(&plan), plan.unknowns.clone());
        let size = unknowns.len() + form.rows.len();
        if size > MOST_EQUATIONS || unknowns.is_empty() {
            return None;
        }
        let pattern = Pattern::new(size, unknowns.len(), terms.entries());
        let factors = Factors::new(pattern, unknowns.len(), (0..size).collect());
        terms.aim(|row, column| factors.places(row, column));
        let zero = zeros(model, &form);
        let coupling = form.coupling.iter().map(|entry| (entry.on as usize, entry.from as usize, entry.mass));
        let rows = form.rows.iter().enumerate();
        let rows = rows.flat_map(|(row, data)| data.arms.iter().map(move |&(arm, p)| (row, arm as usize, p)));
        let (coupling, rows): (Vec<_>, Vec<_>) = (coupling.collect(), rows.collect());
        let (padded, arms) = (Shape::new(&form), shape.places());
        let scale = |arm: usize| if arm < form.frames.len() { 1.0 } else { model.program().length };
        let least_rate = |arm: &usize| model.least_rate(None) * scale(*arm);
        let mut members = Self {
            frames: 0,
            response: Vec::new(),
            reads: form.coordinates.iter().map(|&coordinate| Read::new(&shape, coordinate)).collect(),
            chain: form.chain(),
            least_rates: unknowns.iter().map(least_rate).collect(),
            stored: unknowns.iter().map(|arm| padded.place(*arm as u32)).collect(),
            stride: padded.places(),
            turns: turns(&form, &turned_by),
            slides: slides(&form),
            groups: groups(model, &form),
            row_scales: row_scales(model, &form),
            pushes: Loads::of_pushes(&form, &shape),
            loads: Loads::of_arms(&form, &shape),
            coupling: Complex::new(arms, &coupling, &zero),
            rows: Pairs::new(form.rows.len(), arms, &rows, &zero),
            coefficients: vec![N::ZERO; form.coefficients.results.len()],
            laws: Laws::new(&form.tape),
            arms: vec![Arm::NEW; arms],
            gaps: vec![N::ZERO; form.rows.len()],
            vector: vec![N::ZERO; size],
            solution: vec![N::ZERO; size],
            derivatives: [vec![N::ZERO; 2 * arms], vec![N::ZERO; 2 * arms]],
            factors,
            terms,
            unknowns,
            form,
        };
        members.frames = members.few_frames();
        members.response = Self::room(members.frames);
        Some(members)
    }
}

impl Members<Many> {
    /// Takes the coefficients of one member over from its registers, after the parameter stage ran.
    pub fn enter(&mut self, member: usize, registers: &[f64]) {
        for (place, value) in self.coefficients.iter_mut().zip(self.form.coefficients.results(registers)) {
            place.0[member] = value;
        }
    }

    /// One member has what another one has.
    pub fn follow_member(&mut self, member: usize, other: usize) {
        for place in &mut self.coefficients {
            place.0[member] = place.0[other];
        }
        self.laws.follow(member, other);
    }

    /// Are there signals of time, which each start of a series needs from the registers?
    pub fn has_signals(&self) -> bool {
        !self.form.tape.given.is_empty()
    }

    /// Takes the signals of one member at the start of its series over from its registers.
    pub fn signal(&mut self, member: usize, model: &Model, registers: &[f64]) {
        self.laws.give(member, model, registers);
    }

    /// The first coefficients of a scalar series of one member.
    pub fn scalar(&self, member: usize, slot: Slot, series: &mut [f64]) {
        for (k, place) in series.iter_mut().enumerate() {
            *place = self.laws.get(slot, k).0[member];
        }
    }

    /// The polynomial of one member, as [`Jet::polynomial`].
    pub fn polynomial(&self, member: usize, order: usize, polynomial: &mut [f64]) {
        for (&arm, &place) in self.unknowns.iter().zip(&self.stored) {
            let orders = polynomial[place..].iter_mut().step_by(self.stride);
            orders.zip(&self.arms[arm].value[..=order]).for_each(|(place, value)| *place = value.0[member]);
        }
    }
}

impl Jet {
    /// May this motion be one of several that are found together, with its present parameters?
    pub fn joins(&self) -> bool {
        self.layout.is_some_and(|layout| layout.alike && !layout.chained)
    }
}

/// Are all laws analytic and gentle, and no loop equations turning, or repeating others?
fn serves(form: &ArmForm) -> bool {
    let plain = form.rods.is_empty() && form.auxiliary.is_empty() && form.links.is_empty() && form.repeating() == 0;
    plain && form.tape.switches.is_empty() && !form.tape.has_layers()
}

/// Which coefficients are zero whatever the parameters are.
fn zeros(model: &Model, form: &ArmForm) -> Vec<bool> {
    let (first, constants) = (model.layout().constants(), &model.program().constants);
    let constant = |register: u32| (register as usize).checked_sub(first).and_then(|index| constants.get(index));
    form.coefficients.results.iter().map(|register| constant(*register) == Some(&0.0)).collect()
}

fn turns(form: &ArmForm, turned_by: &[Option<usize>]) -> Vec<Turn> {
    let frames = form.frames.iter().zip(turned_by);
    frames.map(|(frame, &unknown)| Turn { unknown, signal: frame.signal, inertia: frame.inertia }).collect()
}

fn slides(form: &ArmForm) -> Vec<Slide> {
    let products = form.products.iter().map(|product| (product.factor, Some(product.frame as usize)));
    let all = products.chain(form.world.iter().map(|&factor| (factor, None))).zip(form.frames.len()..);
    all.map(|((factor, frame), arm)| Slide { arm, factor, frame }).collect()
}
