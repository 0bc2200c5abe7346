//! Many runs of a scene, by the names of what differs.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cotree_fmu::model::Model;

use super::{Ensemble, Results, Run, RunError, SettingError, Settings, SimulateError, settings};
use crate::compile::{Compiled, compile};
use crate::diagnostic::every;
use crate::scene::Scene;

impl Compiled {
    /// Runs the experiment of the scene for many values, on all processors. A member names parameters, constant inputs and initial values \[SI\]; the rest is the scene's.
    ///
    /// Its results have the bits of a single run. A member that fails leaves the others alone.
    ///
    /// # Errors
    /// Every name that is unknown and every value that is not permitted; a program that the runtime refuses. What is wrong with a single motion is with its results.
    pub fn simulate_many(&self, members: &[Vec<(&str, f64)>]) -> Result<Vec<Result<Results, RunError>>, SimulateError> {
        let settings = self.members(members)?;
        let model = Arc::new(Model::new(self.program.clone()).map_err(RunError::from)?);
        let (description, reported) = (&self.description, self.reported());
        let experiment = description.experiment;
        let run = Run { description, experiment, settings: Vec::new(), inputs: None, reported };
        let stop = AtomicBool::new(false);
        let ensemble = Ensemble::new(run, model, 0, &stop);
        let ensemble = ensemble.map_err(|error| RunError::from(io::Error::other(error)))?;
        let empty = Results::of(self);
        let ended = ensemble.run(&settings, || empty.clone(), Results::push);
        Ok(ended.into_iter().map(|(results, ended)| Ok(results.with(ended.map_err(|failed| failed.error)?))).collect())
    }

    /// The variables of the names; or everything that is wrong with them.
    fn members(&self, members: &[Vec<(&str, f64)>]) -> Result<Vec<Settings>, SimulateError> {
        let setting = |&(name, value): &(&str, f64)| {
            let variable = settings::settable(&self.description, name)?;
            settings::permitted(&self.description.variables[variable], value)
                .map_err(|cause| SettingError(format!("{name}: {value:?} {cause}")))?;
            Ok((variable, value))
        };
        every(members.iter().map(|member| every(member.iter().map(setting)))).map_err(
            |wrong: Vec<Vec<SettingError>>| {
                let mut wrong = wrong.concat();
                wrong.dedup();
                SimulateError::Settings(wrong)
            },
        )
    }
}

impl Scene {
    /// Runs the experiment of the scene for many values at once, as [`Compiled::simulate_many`] does.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or with names and values.
    pub fn simulate_many(&self, members: &[Vec<(&str, f64)>]) -> Result<Vec<Result<Results, RunError>>, SimulateError> {
        compile(self)?.simulate_many(members)
    }
}
