//! Derivatives along directions, of inputs and of outputs.

use cotree_fmu::fmi2::types::fmi2Status::{fmi2Error, fmi2OK};
use cotree_fmu::fmi2::types::*;

use super::super::fmu::*;
use super::nothing;
use super::values::UNKNOWN;

// SAFETY of all calls: the component is alive, and arrays are as long as announced.

pub(super) fn capabilities(fmu: &Fmu) {
    for interface in ["CoSimulation", "ModelExchange"] {
        if fmu.below(&format!("fmiModelDescription/{interface}")).is_empty() {
            continue;
        }
        for flag in ["canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative"] {
            assert!(fmu.flag(interface, flag), "{flag}");
        }
    }
    assert!(fmu.flag("CoSimulation", "canInterpolateInputs"));
    assert!(!fmu.flag("CoSimulation", "canRunAsynchronuously"));
    assert_eq!(unsafe { (fmu.library.cancel_step)(fmu.started().c) }, fmi2Error);
}

/// Central differences of fourth order.
pub(super) fn difference(values_at: impl Fn(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| values_at(k * h));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h)).collect()
}

pub(super) fn agree(fmu: &Fmu, unknowns: &[u32], exact: &[f64], found: &[f64], limit: f64) {
    for ((&unknown, exact), found) in unknowns.iter().zip(exact).zip(found) {
        let name = &fmu.variable(unknown).name;
        assert!((exact - found).abs() <= limit * exact.abs().max(1.0), "{name}: {exact}, by differences {found}");
    }
}

pub(super) fn directional(fmu: &Fmu) {
    if nothing(&[fmu.inputs(), fmu.parameters("tunable")].concat(), "input and no tunable parameter") {
        return;
    }
    let unknowns = fmu.references(|variable| matches!(variable.causality.as_str(), "output" | "local"));
    let slave = fmu.started();
    // An input that a driver follows has rested here: what is set then has no rate.
    slave.run(0..9);
    for known in fmu.inputs().into_iter().chain(fmu.parameters("tunable")) {
        let exact = slave.derivatives(&unknowns, known);
        let before = slave.get(known).expect("readable");
        let at = |change: f64| {
            assert_eq!(slave.put(known, before + change), fmi2OK);
            slave.read(&unknowns)
        };
        let found = difference(at, 1e-2);
        assert_eq!(slave.put(known, before), fmi2OK);
        agree(fmu, &unknowns, &exact, &found, 1e-7);
    }
    let (mut value, unknown) = (0.0, unknowns[0]);
    let wrong = |unknown: u32, known: u32, value: &mut f64| unsafe {
        (slave.fmi().directional_derivative)(slave.c, &unknown, 1, &known, 1, &1.0, value)
    };
    assert_eq!([wrong(unknown, UNKNOWN, &mut value), wrong(UNKNOWN, unknown, &mut value)], [fmi2Error; 2]);
}

pub(super) fn input_derivatives(fmu: &Fmu) {
    if nothing(&fmu.inputs(), "input") {
        return;
    }
    let slave = fmu.started();
    let set = |reference: u32, order: i32| unsafe {
        (slave.fmi().set_input_derivatives)(slave.c, &reference, 1, &order, &1.0)
    };
    assert_eq!([set(UNKNOWN, 1), set(fmu.of_causality("output")[0], 1)], [fmi2Error; 2]);
    for input in fmu.inputs() {
        assert_eq!([set(input, 1), set(input, 0), set(input, 3)], [fmi2OK, fmi2Error, fmi2Error]);
        let before = slave.get(input).expect("readable");
        assert_eq!(slave.step(0.0, 0.5), fmi2OK);
        assert_eq!(slave.get(input), Ok(before + 0.5), "the derivative acts");
    }
}

/// Outputs of a run that ends at a time, or their derivatives by time; the status if they are refused.
fn outputs_at(slave: &Slave, start: fmi2FMUstate, time: f64, order: i32) -> Result<Vec<f64>, fmi2Status> {
    let outputs = slave.fmu.of_causality("output");
    assert_eq!([slave.restore(start), slave.step(0.0, time)], [fmi2OK; 2]);
    let (orders, mut values) = (vec![order; outputs.len()], vec![f64::NAN; outputs.len()]);
    let (references, count) = (outputs.as_ptr(), outputs.len());
    let status = unsafe {
        match order {
            0 => (slave.fmi().get_real)(slave.c, references, count, values.as_mut_ptr()),
            _ => {
                let call = slave.fmi().get_output_derivatives;
                call(slave.c, references, count, orders.as_ptr(), values.as_mut_ptr())
            }
        }
    };
    if status == fmi2OK { Ok(values) } else { Err(status) }
}

pub(super) fn output_derivatives(fmu: &Fmu) {
    const H: f64 = 1e-3;
    let runs = [1e-12, 1e-11, 1e-10].map(|tolerance| {
        let slave = fmu.slave();
        assert_eq!([slave.setup(0.0, None, Some(tolerance)), slave.enter(), slave.exit()], [fmi2OK; 3]);
        (slave.save(), slave)
    });
    let at =
        |(start, slave): &(fmi2FMUstate, Slave), time, order| outputs_at(slave, *start, time, order).expect("provided");
    // What another tolerance changes is not known any better: stiff motion multiplies every error of the state.
    let unknown = |values: &[Vec<f64>; 3], index: usize| {
        values[1..].iter().fold(0.0, |most: f64, again| most.max((again[index] - values[0][index]).abs()))
    };
    let declared = fmu.below("fmiModelDescription/CoSimulation")[0];
    let highest: i32 = attribute(declared, "maxOutputDerivativeOrder").expect("declared").parse().expect("a number");
    for order in 1..=highest {
        let exact = [0, 1, 2].map(|run| at(&runs[run], 0.1, order));
        let lower = [0, 1, 2].map(|run| at(&runs[run], 0.1, order - 1));
        let found = difference(|change| at(&runs[0], 0.1 + change, order - 1), H);
        for (index, &output) in fmu.of_causality("output").iter().enumerate() {
            let unknown = unknown(&exact, index) + unknown(&lower, index) / H;
            let (exact, lower, found) = (exact[0][index], lower[0][index], found[index]);
            let limit = 1e-5 * exact.abs().max(lower.abs()).max(1.0) + 10.0 * unknown;
            let name = &fmu.variable(output).name;
            assert!((exact - found).abs() <= limit, "{name}, order {order}: {exact}, by differences {found}");
        }
    }
    let fine = &runs[0];
    for order in [-1, highest + 1] {
        assert_eq!(outputs_at(&fine.1, fine.0, 0.1, order), Err(fmi2Error));
    }
    let (output, mut value) = (fmu.of_causality("output")[0], 0.0);
    let zero = unsafe { (fmu.library.get_output_derivatives)(fine.1.c, &output, 1, &0, &mut value) };
    assert_eq!(zero, fmi2Error);
    runs.into_iter().for_each(|(state, slave)| slave.free(state));
}
