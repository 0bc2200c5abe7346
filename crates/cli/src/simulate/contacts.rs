//! What a summary says of contacts that would not hold: the run once more, with their forces.

use std::collections::HashMap;
use std::sync::Arc;

use cotree::report::csv::CsvTable;
use cotree::scene::{Faults, Scene};
use cotree_fmu::model::Model;
use cotree_study::contact::{self, ContactFindings};

use super::super::failure::Failure;
use super::super::units::ShownUnits;
use super::super::{MessageFormat, output};
use super::{SimulateCommand, request};

impl SimulateCommand {
    /// Says it: what friction must be beside the figures, what would lift off as a warning.
    pub(super) fn say_contacts(
        &self,
        scene: &Scene,
        input: Option<&CsvTable>,
        shown: &ShownUnits,
        format: MessageFormat,
    ) -> Result<(), Failure> {
        let Some(ContactFindings { faults, needed, .. }) = self.contacts(scene, input, shown) else { return Ok(()) };
        if !self.json {
            needed.iter().try_for_each(|sentence| output::print(&format!("{sentence}\n")))?;
        }
        if !faults.is_empty() {
            output::warn(Some(&Faults::new(scene.source.clone(), faults)), format);
        }
        Ok(())
    }

    /// None if there are none, or the run cannot be made with their forces: without masses there are none.
    fn contacts(&self, scene: &Scene, input: Option<&CsvTable>, shown: &ShownUnits) -> Option<ContactFindings> {
        let (requested, mechanism) = contact::requested(scene)?;
        let compiled = self.compiled(scene, &requested).ok()?;
        let reported = compiled.reported();
        let names: Vec<&str> =
            reported.iter().map(|&index| compiled.description.variables[index].name.as_str()).collect();
        let run = request::run(self, &compiled.description, input, reported.clone()).ok()?;
        let (mut times, mut columns) = (Vec::new(), vec![Vec::new(); names.len()]);
        let model = Model::new(compiled.program.clone()).ok()?;
        // A run that ends early is told of by the run itself; what there is of it counts.
        let _ = run.start(Arc::new(model), |time, values| {
            times.push(time);
            columns.iter_mut().zip(values).for_each(|(column, value): (&mut Vec<f64>, _)| column.push(*value));
            Ok(())
        });
        let columns: HashMap<&str, Vec<f64>> = names.into_iter().zip(columns).collect();
        Some(contact::over_time(&mechanism, &shown.units, &times, |name| columns.get(name).cloned()))
    }
}
