//! The poles of a mechanism at its start, and the longest step of the method that is stable with them.

use cotree_fmu::program::Program;
use nalgebra::{Complex, DMatrix, DVector};

/// A pole that limits the step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepLimit {
    /// The longest stable step \[s\].
    pub step: f64,
    /// [1/s]
    pub pole: [f64; 2],
    /// The coordinate, rate or state that has most of it.
    pub part: String,
}

/// Where the amplification of the method is looked at, in units of the distance of a pole from zero; none is stable beyond.
const SPACING: f64 = 1e-3;
const FURTHEST: f64 = 6.0;
/// A pole is growing, not stiff, if its real part is positive by this share.
const GROWING: f64 = 1e-6;

/// The pole that allows the shortest step; none if nothing decays or oscillates. `registers` hold the start, with all that the parameters determine.
pub fn limit(program: &Program, registers: &[f64], order: usize) -> Option<StepLimit> {
    let matrix = derivatives(program, registers)?;
    let poles = matrix.complex_eigenvalues();
    let bounded = poles.iter().filter_map(|&pole| Some((longest(pole, order)?, pole)));
    let (step, pole) = bounded.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(StepLimit { step, pole: [pole.re, pole.im], part: name(program, participant(&matrix, pole)) })
}

/// The derivatives of positions, rates and states by each other.
fn derivatives(program: &Program, registers: &[f64]) -> Option<DMatrix<f64>> {
    let (layout, tape) = (program.layout(), &program.tapes.acceleration);
    let (mechanical, rates) = (program.mechanical(), program.coordinates.len());
    let mut matrix = DMatrix::zeros(mechanical + rates, mechanical + rates);
    for column in 0..mechanical + rates {
        let register =
            if column < mechanical { layout.positions() + column } else { layout.rates() + column - mechanical };
        let (mut values, mut tangents) = (registers.to_vec(), vec![0.0; registers.len()]);
        *tangents.get_mut(register)? = 1.0;
        if let Some(row) = column.checked_sub(mechanical).filter(|row| *row < mechanical) {
            matrix[(row, column)] = 1.0;
        }
        // What the parameters determine is constant along every direction.
        tape.run_tangent(&mut values, &mut tangents);
        for (row, result) in tape.results.iter().take(rates).enumerate() {
            matrix[(mechanical + row, column)] = *tangents.get(*result as usize)?;
        }
    }
    matrix.iter().all(|value| value.is_finite()).then_some(matrix)
}

/// The longest step at which this pole does not grow, by a method whose amplification is the series of e^z up to this order.
fn longest(pole: Complex<f64>, order: usize) -> Option<f64> {
    let size = pole.norm();
    if size == 0.0 || pole.re > GROWING * size {
        return None;
    }
    let direction = Complex::new(pole.re.min(0.0), pole.im) / size;
    let places = (1..).map(|number| SPACING * f64::from(number)).take_while(|place| *place < FURTHEST);
    let grows = |place: &f64| {
        let z = direction * *place;
        let one = Complex::new(1.0, 0.0);
        let amplification = (1..=order).rev().fold(one, |sum, power| one + z / power as f64 * sum);
        amplification.norm() > 1.0 + 1e-9
    };
    let first = places.into_iter().find(grows).unwrap_or(FURTHEST);
    Some((first - SPACING) / size)
}

/// The variable that takes most part in a pole: by inverse iteration from both sides.
fn participant(matrix: &DMatrix<f64>, pole: Complex<f64>) -> usize {
    let shift = pole * (1.0 + 1e-7);
    let shifted = |matrix: &DMatrix<f64>| {
        let shifted = matrix.map(|value| Complex::new(value, 0.0))
            - DMatrix::from_diagonal_element(matrix.nrows(), matrix.nrows(), shift);
        let mut vector = DVector::from_element(matrix.nrows(), Complex::new(1.0, 0.0));
        let factors = shifted.lu();
        for _ in 0..3 {
            if let Some(next) = factors.solve(&vector) {
                let size = next.iter().fold(0.0_f64, |most, value| most.max(value.norm()));
                vector = next / Complex::new(size, 0.0);
            }
        }
        vector
    };
    let (right, left) = (shifted(matrix), shifted(&matrix.transpose()));
    let share = |index: usize| (right[index] * left[index]).norm();
    (0..matrix.nrows()).max_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(0)
}

fn name(program: &Program, variable: usize) -> String {
    let mechanical = program.mechanical();
    let index = if variable < mechanical { variable } else { variable - mechanical };
    program.coordinates.get(index).map_or_else(String::new, |coordinate| coordinate.name.clone())
}
