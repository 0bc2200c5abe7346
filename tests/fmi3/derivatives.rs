//! Derivatives in Co-Simulation: one function for each case, run in a process of its own.

use cotree_fmu::fmi3::types::fmi3Status::{fmi3Error, fmi3OK};

use super::cases::logged;
use super::fmu::*;
use super::{Case, nothing};

// SAFETY of all calls: the instance is alive, and arrays are as long as announced.

pub const CASES: &[Case] = &[
    ("3D61", "derivatives are linear in the seed, and the adjoint agrees", |fmu| {
        let instance = fmu.started();
        instance.run(0..3);
        let unknowns = fmu.structure("Output");
        let knowns = [fmu.parameters("tunable"), fmu.of_causality("input"), fmu.of_causality("independent")].concat();
        let (ones, twos) = (vec![1.0; knowns.len()], vec![2.0; knowns.len()]);
        let once = instance.directional(&unknowns, &knowns, &ones).expect("regular");
        let twice = instance.directional(&unknowns, &knowns, &twos).expect("regular");
        let weights: Vec<f64> = (0..unknowns.len()).map(|place| 1.0 + 0.2 * place as f64).collect();
        let back = instance.adjoint(&unknowns, &knowns, &weights).expect("regular");
        let size = once.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        assert!(once.iter().zip(&twice).all(|(one, two)| (2.0 * one - two).abs() <= 1e-12 * size));
        let forth: f64 = once.iter().zip(&weights).map(|(entry, weight)| entry * weight).sum();
        assert!((forth - back.iter().sum::<f64>()).abs() <= 1e-10 * size, "{forth} {back:?}");
    }),
    ("3D62", "wrong numbers of seeds and sensitivities", |fmu| {
        let (output, time) = (fmu.structure("Output"), fmu.of_causality("independent"));
        let output = &output[..1];
        for (unknowns, knowns, seed) in
            [(output, &time[..], &[][..]), (output, &[u32::MAX], &[1.0]), (&[u32::MAX], &time, &[1.0])]
        {
            assert_eq!(fmu.started().directional(unknowns, knowns, seed), Err(fmi3Error));
        }
        let instance = fmu.started();
        let (mut found, one) = ([0.0; 2], 1.0);
        let status = unsafe {
            (instance.fmi().directional)(
                instance.c,
                output.as_ptr(),
                1,
                time.as_ptr(),
                1,
                &one,
                1,
                found.as_mut_ptr(),
                2,
            )
        };
        assert_eq!(status, fmi3Error);
    }),
    ("3D64", "derivatives of outputs by time", |fmu| {
        let instance = fmu.started();
        instance.run(0..3);
        let most: i32 = attribute(fmu, "maxOutputDerivativeOrder").parse().expect("a number");
        for output in fmu.structure("Output") {
            let found = |order: i32| {
                let mut value = f64::NAN;
                match unsafe { (instance.fmi().output_derivatives)(instance.c, &output, 1, &order, &mut value, 1) } {
                    fmi3OK => value,
                    status => panic!("{status:?}"),
                }
            };
            assert!((1..=most).all(|order| found(order).is_finite()));
            let [time] = fmu.of_causality("independent")[..] else { panic!("one") };
            assert!(instance.get(time).is_ok());
        }
        for order in [0, most + 1] {
            let (instance, output) = (fmu.started(), fmu.structure("Output")[0]);
            let status = unsafe { (instance.fmi().output_derivatives)(instance.c, &output, 1, &order, &mut 0.0, 1) };
            assert_eq!(status, fmi3Error);
        }
    }),
    ("3X02", "a step ends early where a law changes over", |fmu| {
        let pieces = fmu.structure("EventIndicator");
        if nothing(&pieces, "law in pieces") {
            return;
        }
        let instance = fmu.make(&Making { events: true, early_return: true, ..logged() }).expect("instantiates");
        instance.start();
        assert_eq!(instance.call(instance.fmi().enter_step), fmi3OK);
        let step = instance.step(0.0, 0.5);
        assert!(step.status == fmi3OK && step.event && step.early && step.time > 0.0 && step.time < 0.5, "{step:?}");
        let indicators = instance.read(&fmu.structure("EventIndicator"));
        assert!(indicators.iter().any(|indicator| indicator.abs() < 1e-9), "at the corner itself: {indicators:?}");
        assert_eq!(instance.call(instance.fmi().enter_event), fmi3OK);
        assert_eq!((instance.update(), instance.call(instance.fmi().enter_step)), (Ok((false, false)), fmi3OK));
        instance.go(step.time, 0.5 - step.time);
        let undivided = fmu.started();
        undivided.go(0.0, 0.5);
        assert_eq!(instance.all(), undivided.all());
    }),
    ("3X01", "inputs with their derivatives beat held ones", |fmu| {
        let rates =
            |input| fmu.references(|variable| variable.derivative == Some(input) && variable.causality == "input");
        let inputs: Vec<u32> = fmu.inputs().into_iter().filter(|&input| !rates(input).is_empty()).collect();
        let outputs = fmu.of_causality("output");
        if nothing(&inputs, "input that a driver follows") {
            return;
        }
        // u = sin(3 t) with its derivatives times a share, or without them, in long steps and in short ones.
        let run = |steps: u32, share: Option<f64>| {
            let instance = fmu.make(&logged()).expect("instantiates");
            instance.start();
            let h = 0.2 / f64::from(steps);
            for step in 0..steps {
                let t = h * f64::from(step);
                let (sine, cosine) = (3.0 * t).sin_cos();
                let derivatives = share.map(|share| [0.9 * share * cosine, -2.7 * share * sine]);
                for &input in &inputs {
                    let first = rates(input);
                    let second = rates(first[0]);
                    assert_eq!(instance.put(input, 0.3 * sine), fmi3OK);
                    for (reference, value) in [first[0], second[0]].into_iter().zip(derivatives.into_iter().flatten()) {
                        assert_eq!(instance.put(reference, value), fmi3OK);
                    }
                }
                instance.go(t, h);
            }
            instance.read(&outputs)
        };
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Accelerations of a driven mechanism are those of the input's polynomial, and no better.
        let exact = run(400, Some(1.0));
        let [known, held, differences] = [Some(1.0), Some(0.0), None].map(|share| difference(&run(10, share), &exact));
        assert!(known < 0.2 * held, "{known:e} with derivatives, {held:e} at rest");
        assert!(known < differences && differences < held, "{differences:e} with differences for derivatives");
    }),
];

fn attribute<'a>(fmu: &'a Fmu, key: &str) -> &'a str {
    super::xml::attribute(fmu.below("/CoSimulation")[0], key).expect("written")
}
