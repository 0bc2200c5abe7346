//! What FMI 2.0 alone asks of a component.

use super::types::{fmi2LastSuccessfulTime, fmi2Status, fmi2StatusKind};
use crate::fmi::component::{self, Interface, Mode, Outcome, READABLE, Refusal, Version};
use crate::fmi::logging::{Category, LogSeverity};

/// This version of the standard.
pub struct Fmi2;

/// An instance of this version.
pub type Fmi2Component = component::FmiComponent<Fmi2>;

impl Version for Fmi2 {
    type Status = fmi2Status;
    const OK: fmi2Status = fmi2Status::fmi2OK;
    const WARNING: fmi2Status = fmi2Status::fmi2Warning;
    const ERROR: fmi2Status = fmi2Status::fmi2Error;
    const NUMBER: u8 = 2;
    const READABLE: &'static [Mode] = &READABLE;

    fn refuse(component: &mut Fmi2Component, refusal: &Refusal) -> fmi2Status {
        let (severity, status) = match refusal.discards {
            true => (LogSeverity::Discard, fmi2Status::fmi2Discard),
            false => (LogSeverity::Error, fmi2Status::fmi2Error),
        };
        component.logger.log(severity, Category::Errors, &refusal.reason);
        status
    }
}

impl Fmi2Component {
    pub fn enter_initialization(&mut self) -> Outcome {
        self.allow(&[Mode::Instantiated])?;
        if !self.set_up {
            return Err("fmi2SetupExperiment must be called before fmi2EnterInitializationMode".into());
        }
        self.mode = Mode::Initialization;
        Ok(())
    }

    /// All derivatives or none.
    pub fn set_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::Step];
        self.allow_only(Interface::CoSimulation, &modes)?;
        let all = || references.iter().zip(orders).zip(values);
        for ((&reference, &order), &value) in all() {
            self.instance.check_set_derivative(reference as usize, order, value)?;
        }
        for ((&reference, &order), &value) in all() {
            self.instance.set_derivative(reference as usize, order, value)?;
        }
        Ok(())
    }

    /// The last communication point reached, if that is what is asked for.
    pub fn real_status(&self, kind: fmi2StatusKind) -> Option<f64> {
        let known = kind == fmi2LastSuccessfulTime && self.mode != Mode::Instantiated;
        known.then(|| self.instance.time())
    }
}
