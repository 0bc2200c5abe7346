//! Laws that read accelerations or reactions: where these have no value of their own, or act at an instant, the laws are refused.

use crate::diagnostic::{Fault, Span};
use crate::equations::Equations;
use crate::formulate::impulses;
use crate::laws::Jump;
use crate::model::{Class, Formula, Mechanism, Part, Variable};
use crate::solve::Shared;

/// A law that reads accelerations or reactions: whose it is, what is read, and where it stands.
struct ReadingLaw<'m> {
    what: String,
    read: Vec<Variable>,
    /// The load; none for the rate of a state, which acts on nothing at once.
    load: Option<&'m Part>,
    span: Span,
}

/// What such laws may not do: say how much something holds or rubs, or act where impulses may, which drivers that determine the motion do not give way to.
pub(super) fn check_acts(equations: &Equations, jumps: &[Jump]) -> Vec<Fault> {
    let moves_freely = !equations.is_driven();
    let mechanism = &equations.system.mechanism;
    let mut faults = Vec::new();
    for reading in readings(mechanism) {
        let Some(load) = reading.load else { continue };
        let holds = mechanism.contacts.iter().any(|contact| contact.owner == load.owner);
        let impacts = mechanism.contacts.iter().find(|contact| contact.slip.is_none() && moves_freely);
        let jumps =
            jumps.iter().find(|jump| jump.of_rate && moves_freely).map(|jump| &mechanism.drivers[jump.driver].name);
        let (why, help) = match (holds, impacts, jumps) {
            (true, ..) => (
                "but it is a friction torque or force limit".to_owned(),
                "let it depend on positions, velocities, states and inputs; for friction in proportion to the normal force give `mu`",
            ),
            (_, Some(contact), _) => (
                format!("which are impulsive where `{}` closes", contact.name),
                "remove one of the two, or let the load depend on a state that follows the reading with a lag",
            ),
            (.., Some(driver)) => (
                format!("which are impulsive where the law of driver `{driver}` is discontinuous"),
                "make the law smooth (`smoothstep`, `spline`)",
            ),
            (false, None, None) => continue,
        };
        let read = mechanism.variable_name(reading.read[0]);
        let message = format!("{} reads `{read}`, an acceleration or a reaction, {why}", reading.what);
        faults.push(Fault::new("scene::load_depends", message, reading.span).label("reads it").help(help));
    }
    faults
}

/// Drivers whose rates may jump, as importers set them: such loads take no part in the impulses.
pub(super) fn warnings(equations: &Equations) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let Some(reading) = readings(mechanism).into_iter().find(|reading| reading.load.is_some()) else {
        return Vec::new();
    };
    let warning = |driver: &Part| {
        let by = impulses::set_by(mechanism, driver)?;
        let message = format!(
            "driver `{}` follows {by}, whose rate may be discontinuous: {} is left out of the impulse",
            driver.name, reading.what
        );
        let help = "let the input change smoothly; where it is discontinuous reactions are impulses, of which a law has no value";
        Some(Fault::warning("scene::driver_jump", message, driver.span).label("may jump").help(help))
    };
    mechanism.drivers.iter().filter_map(warning).collect()
}

/// Reactions that are shared or grow without bound have no value that a law could read.
pub(super) fn check_determined(equations: &Equations, shared: &Shared) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let open = |variable: &Variable| shared.owners.contains(&variable.owner) || shared.undetermined.contains(variable);
    let fault = |reading: ReadingLaw| {
        let read = reading.read.iter().find(|variable| reads_reaction(variable) && open(variable))?;
        let read = mechanism.variable_name(*read);
        let message = format!(
            "{} reads `{read}`, which the equations of motion do not determine: the joint is redundant",
            reading.what
        );
        let help = "read a reaction that is determined, or remove a redundant joint (`check` lists them)";
        Some(Fault::new("scene::undetermined_reaction", message, reading.span).label("reads it").help(help))
    };
    readings(mechanism).into_iter().filter_map(fault).collect()
}

fn reads_reaction(variable: &Variable) -> bool {
    Formula::Variable(*variable).reads_the_motion() && variable.quantity.class() == Class::Effort
}

/// All such laws of a mechanism: those of loads, and the rates of states.
fn readings(mechanism: &Mechanism) -> Vec<ReadingLaw<'_>> {
    let mut all = Vec::new();
    for load in &mechanism.loads {
        let formulas = load.values.iter().flat_map(|(_, value)| value.formulas());
        let read: Vec<Variable> = formulas.flat_map(read).collect();
        let what = format!("load `{}`", load.name);
        all.push(ReadingLaw { what, read, load: Some(load), span: load.span });
    }
    for state in &mechanism.states {
        let what = format!("`rate` of state `{}`", state.name);
        all.push(ReadingLaw { what, read: read(&state.rate).collect(), load: None, span: state.span });
    }
    all.retain(|reading| !reading.read.is_empty());
    all
}

/// The accelerations and reactions in a law.
fn read(law: &Formula) -> impl Iterator<Item = Variable> + use<> {
    let mut found = Vec::new();
    law.visit(&mut |part| {
        if let Formula::Variable(variable) = part
            && part.reads_the_motion()
        {
            found.push(*variable);
        }
    });
    found.into_iter()
}
