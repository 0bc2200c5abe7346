//! Derivatives along directions, of inputs and of outputs.

use fmi_rs::fmi2::types::fmi2Status::{Error, Ok as OK};
use fmi_rs::model_description::fmi2::Causality;

use super::Outcome::{self, Nothing, Passed};
use super::values::UNKNOWN;
use crate::fmu::*;

pub(super) fn capabilities(fmu: &Fmu) -> Outcome {
    let description = &fmu.description;
    let slave = description.coSimulation.as_ref().expect("Co-Simulation");
    assert!(slave.canGetAndSetFMUstate && slave.canSerializeFMUstate && slave.providesDirectionalDerivative);
    assert!(slave.canInterpolateInputs && !slave.canRunAsynchronuously);
    if let Some(exchange) = &description.modelExchange {
        assert!(exchange.canGetAndSetFMUstate && exchange.canSerializeFMUstate);
        assert!(exchange.providesDirectionalDerivative);
    }
    assert_eq!(fmu.started().raw.cancelStep(), Error);
    Passed
}

pub(super) fn directional(fmu: &Fmu) -> Outcome {
    let knowns = [fmu.inputs(), fmu.tunable()].concat();
    if knowns.is_empty() {
        return Nothing("it has no input and no tunable parameter");
    }
    let unknowns = fmu.references(|one| matches!(one.causality, Causality::Output | Causality::Local));
    let slave = fmu.started();
    // An input that a driver follows has rested here: what is set then has no rate.
    slave.run(0..9);
    for known in knowns {
        let exact = slave.derivatives(&unknowns, known);
        let before = slave.get(known).expect("readable");
        let at = |change: f64| {
            assert_eq!(slave.put(known, before + change), OK);
            slave.read(&unknowns)
        };
        let found = difference(at, 1e-2);
        assert_eq!(slave.put(known, before), OK);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
    for (unknown, known) in [(unknowns[0], UNKNOWN), (UNKNOWN, unknowns[0])] {
        assert_eq!(slave.raw.getDirectionalDerivative(&[unknown], &[known], &[1.0], &mut [0.0]), Error);
    }
    Passed
}
