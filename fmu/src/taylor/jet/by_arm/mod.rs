//! The series of a motion in any kind of numbers, such as numbers that bring their derivatives by parameters.
//!
//! What [`super::orders`] does for four arms at a time in plain numbers is done here for one arm. Mechanisms whose laws are steep or in pieces, whose loop equations
//! turn or repeat others, or that are trees of many arms, are not taken.

mod laws;
mod orders;
mod sparse;
mod start;
mod step;
mod variation;

use super::step::Read;
use super::terms::{Plan, Terms};
use super::{Loads, Shape, turned_by, unknowns};
use crate::linalg::factors::{Factors, Pattern};
use crate::linalg::number::{Elementary, Number};
use crate::model::Model;
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{ArmForm, Factor, Slot};
use laws::Laws;
use sparse::{Complex, Pairs};
pub(crate) use variation::{DIRECTIONS, Tangents, Variations, variations};

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

/// The series of a motion.
#[derive(Clone, Debug)]
pub(crate) struct ByArm<N> {
    form: ArmForm,
    /// Coordinates, what carries an angle before what it carries.
    chain: Vec<usize>,
    reads: Vec<Read>,
    /// The arm of each unknown, in the order of their equations, with the least of its rates that counts relative to itself.
    unknowns: Vec<usize>,
    least_rates: Vec<f64>,
    turns: Vec<Turn>,
    slides: Vec<Slide>,
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

impl<N: Elementary> ByArm<N> {
    /// Storage for a model, if the series of its motions are of this kind.
    pub fn new(model: &Model) -> Option<Self> {
        let form = model.program().arms.as_ref().filter(|form| serves(form))?.clone();
        let (shape, turned_by) = (Shape::plain(&form), turned_by(&form));
        let plan = Plan::new(&form, &shape, &turned_by, &unknowns(&form, &shape));
        let (mut terms, unknowns) = (Terms::new(&plan), plan.unknowns.clone());
        let size = unknowns.len() + form.rows.len();
        if unknowns.is_empty() {
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
        let arms = shape.places();
        let scale = |arm: usize| if arm < form.frames.len() { 1.0 } else { model.program().length };
        let least_rate = |arm: &usize| model.least_rate(None) * scale(*arm);
        let series = Self {
            reads: form.coordinates.iter().map(|&coordinate| Read::new(&shape, coordinate)).collect(),
            chain: form.chain(),
            least_rates: unknowns.iter().map(least_rate).collect(),
            turns: turns(&form, &turned_by),
            slides: slides(&form),
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
        Some(series)
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
