//! How a motion changes with parameters, constant inputs and initial values: the variational equations along the motion (direct differentiation;
//! Haug, Wehage and Mani, *ASME J. Mech. Transm. Autom. Des.* 106, 1984).
//!
//! With K = \[M Phi_q^T; Phi_q 0\] and all derivatives at fixed time,
//!
//! K \[a_p; lambda_p\] = -(d/dq q_p + d/dv v_p + d/dp) \[M a + Phi_q^T lambda - Q; Phi_q a - gamma\].
//!
//! It is linear in q_p and v_p: collocation at the Gauss nodes, with the motion from the program that runs in the FMU, steps that the last
//! coefficients of a_p choose, and q_p and v_p put back onto the varied loop equations after each step.

mod event;
mod rule;
mod start;
mod step;

use nalgebra::{DMatrix, DVector};

use super::{Failure, Study, StudyError};
use crate::diagnostic::suggest;
use crate::expr::{Order, Symbol};
use crate::formulate::Formulated;
use step::{Course, Varied};

/// Derivatives of outputs along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivities {
    /// \[s\]
    pub times: Vec<f64>,
    /// What was differentiated, with its unit.
    pub outputs: Vec<(String, String)>,
    /// With respect to what, with its unit.
    pub parameters: Vec<(String, String)>,
    /// The outputs at each time, SI.
    pub values: Vec<DVector<f64>>,
    /// Their derivatives at fixed time: for each time a row for each output and a column for each parameter, SI.
    pub derivatives: Vec<DMatrix<f64>>,
}

impl Study {
    /// Derivatives of the scene's outputs with respect to parameters, constant inputs and initial values, at these times \[s\], ascending.
    ///
    /// Exact up to the tolerance of the scene: nothing is differenced. Where laws switch, the derivatives of rates jump as they should. A guess only picks the
    /// assembly; of what is left open at the start the pose next to the nominal one counts.
    ///
    /// # Errors
    /// A name that cannot be set, equations that cannot be formulated, a motion that cannot be continued, or derivatives that do not exist: at a
    /// singular pose, where a law is touched without being crossed, or where redundant joints fit for these very lengths only.
    pub fn sensitivities(&mut self, to: &[String], times: &[f64]) -> Result<Sensitivities, StudyError> {
        let mechanism = self.mechanism().clone();
        let outputs = mechanism.outputs.iter().map(|output| (output.name.clone(), output.unit.si.clone())).collect();
        let (parameters, rows) = self.formulated(&mechanism, |formulated| {
            let chosen = to.iter().map(|name| parameter(formulated, name)).collect::<Result<Vec<_>, _>>()?;
            let (symbols, units): (Vec<Symbol>, Vec<String>) = chosen.into_iter().unzip();
            Ok((to.iter().cloned().zip(units).collect(), along(formulated, &symbols, times)?))
        })?;
        let (values, derivatives) = rows.into_iter().unzip();
        Ok(Sensitivities { times: times.to_vec(), outputs, parameters, values, derivatives })
    }
}

fn along(formulated: &mut Formulated, parameters: &[Symbol], times: &[f64]) -> Result<Vec<Varied>, Failure> {
    if !formulated.lowered.program.followers.is_empty() {
        let what = "a driver integrates an input: derivatives of such motions are not computed".to_owned();
        return Err(Failure::NoDerivative { time: formulated.lowered.program.experiment.start, what });
    }
    let mut course = Course::new(formulated, parameters)?;
    let mut values = Vec::with_capacity(times.len());
    course.run(times, |outputs| values.push(outputs))?;
    Ok(values)
}

/// The symbol behind a name, and its unit.
fn parameter(formulated: &Formulated, name: &str) -> Result<(Symbol, String), Failure> {
    let mechanism = formulated.equations.system.mechanism;
    let program = &formulated.lowered.program;
    // In the program, initial values come after the parameters of the scene.
    if let Some(index) = program.parameters.iter().position(|own| own.name == name) {
        let line = || mechanism.initial.iter().find(|line| mechanism.variable_name(line.variable) == name);
        let unit = match mechanism.parameters.get(index) {
            Some(own) => own.unit.si.clone(),
            None => line().map_or_else(String::new, |line| line.variable.quantity.measure().si.to_owned()),
        };
        return Ok((Symbol::Parameter(index), unit));
    }
    if let Some(index) = program.inputs.iter().position(|own| own.name == name) {
        return Ok((Symbol::Input(index, Order::Position), mechanism.inputs[index].unit.si.clone()));
    }
    let names = program.parameters.iter().map(|own| own.name.as_str());
    let names = names.chain(program.inputs.iter().map(|own| own.name.as_str()));
    Err(Failure::Unknown { name: name.to_owned(), known: suggest::known(name, names) })
}
