//! One instance lives many times: after each reset, and each time that a saved state is put back, the motion has the bits of the first. Importers do so in sweeps, pages at each start, and
//! Python where the state of a run is set. What an instance knows beside its snapshot must not come along.

use crate::support::{exchange, run};

use cotree_fmu::instance::{Instance, InstanceError, Snapshot};
use run::{model, models, scene_of};

/// Models whose modes change: an instance counts and remembers that.
const WITH_MODES: [&str; 6] = ["end_stop", "play_train", "valve_train", "barrier", "stick_slip", "gripper"];
/// Communication points of a life in Co-Simulation, and steps of one in Model Exchange.
const POINTS: [u32; 2] = [40, 200];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Interface {
    CoSimulation,
    ModelExchange,
}

#[derive(Clone, Copy, Debug)]
enum Return {
    Reset,
    Restored,
}

/// All variables, or what ended the motion.
type Life = Result<Vec<u64>, String>;

fn begin(instance: &mut Instance, interface: Interface) -> Result<(), InstanceError> {
    let start = instance.model().program().experiment.start;
    instance.setup(start, None, None)?;
    match interface {
        Interface::CoSimulation => instance.initialise(),
        Interface::ModelExchange => instance.initialise_exchange(),
    }
}

/// The rest of a life that has begun.
fn live(instance: &mut Instance, interface: Interface, span: f64) -> Life {
    let start = instance.time();
    let done = match interface {
        Interface::CoSimulation => (1..=POINTS[0])
            .try_for_each(|point| instance.step_to(start + span * f64::from(point) / f64::from(POINTS[0]))),
        Interface::ModelExchange => exchange::go_on(instance, start + span, span / f64::from(POINTS[1])),
    };
    done.map_err(|error| error.to_string())?;
    let variables = 0..instance.model().program().variables.len();
    Ok(variables.map(|variable| instance.reading(variable).map_or(0, f64::to_bits)).collect())
}

/// A life that follows others.
fn again(instance: &mut Instance, how: (Interface, Return), saved: &Snapshot, span: f64) -> Life {
    let begun = match how.1 {
        Return::Reset => {
            instance.reset();
            begin(instance, how.0)
        }
        Return::Restored => instance.restore(saved),
    };
    begun.map_err(|error| error.to_string())?;
    live(instance, how.0, span)
}

/// Lives of one instance of a model; each must be like that of an instance of its own.
fn lives(name: &str, lives: u32, share: f64) {
    let model = model(&scene_of(name));
    let experiment = &model.program().experiment;
    let span = share * (experiment.stop - experiment.start);
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        for back in [Return::Reset, Return::Restored] {
            let mut instance = Instance::new(model.clone());
            if begin(&mut instance, interface).is_err() {
                assert_eq!(interface, Interface::ModelExchange, "{name}");
                continue;
            }
            let saved = instance.save();
            let first = live(&mut instance, interface, span);
            assert!(interface == Interface::ModelExchange || first.is_ok(), "{name}: {first:?}");
            for life in 2..=lives {
                let found = again(&mut instance, (interface, back), &saved, span);
                assert!(found == first, "{name}, {interface:?}, {back:?}, life {life}: {:?}", found.err());
            }
        }
    }
}

#[test]
fn each_life_of_a_model_with_modes_is_the_first() {
    for name in WITH_MODES {
        lives(name, 70, 0.2);
    }
}

#[test]
#[ignore = "minutes: each night"]
fn a_hundred_lives_of_every_model() {
    for name in models() {
        println!("{name}");
        lives(&name, 100, 1.0);
    }
}
