//! Equations with their first variation, for analyses at a point.

use cotree::formulate::Formulated;
use cotree::model::Mechanism;
use cotree_fmu::model::Model;

use super::sensitivity::counts_as_imposed;
use super::variation::Variation;
use super::{AnalysisFailure, OperatingPoint};

#[derive(Clone, Debug)]
pub(super) struct Local {
    pub formulated: Formulated,
    pub variation: Variation,
}

impl Local {
    pub fn new(mut formulated: Formulated) -> Self {
        let variation = Variation::new(&mut formulated);
        Local { formulated, variation }
    }

    /// Local equations of a mechanism that differs in values only; none where its program does not take them, or other loop equations would count with them than it imposes.
    pub fn with_values(&self, mechanism: &Mechanism) -> Option<Self> {
        let formulated = self.formulated.with_values(mechanism.clone())?;
        let local = Local { formulated, variation: self.variation.clone() };
        local.counts_as_imposed().unwrap_or(false).then_some(local)
    }

    fn counts_as_imposed(&self) -> Result<bool, AnalysisFailure> {
        let model = Model::new(self.formulated.lowered.program.clone())?;
        let point = OperatingPoint::resting(&model, &self.formulated.state);
        counts_as_imposed(&self.variation.loops_at(&self.formulated.equations, &point)?)
    }
}
