//! What becomes of the impulse where the rate of a driver jumps. Where the driver is a loop equation, closing the loops behind the jump is the impulse on all
//! that is not driven; where it is a branch of a tree, what depends on its coordinate follows, and all else keeps the rates of its coordinates.

use crate::diagnostic::Fault;
use crate::equations::Equations;
use crate::laws::{Jump, laws};
use crate::model::{CoordinateChoice, Formula, KeyValue, Mechanism, Motion, Part};
use crate::network::{ElementId, Origin, Trees};

/// The recommended trees, but with drivers as loop equations whose rates jump, or may, as importers set them; none if these are the scene's own, or like that
/// already.
pub(super) fn trees(equations: &Equations, jumps: &[Jump]) -> Option<Trees> {
    let system = &equations.system;
    let jumping = |id: ElementId| match system.element(id).origin {
        Origin::Driver(driver) => {
            let jumps = jumps.iter().any(|jump| jump.of_rate && jump.driver == driver.0);
            jumps || set_by(&system.mechanism, &system.mechanism.drivers[driver.0]).is_some()
        }
        _ => false,
    };
    let trees = Trees::recommended_but(system, jumping);
    let is_chosen = matches!(system.mechanism.coordinates, CoordinateChoice::Chosen { .. });
    let recommended = !is_chosen && equations.trees == Trees::recommended(system);
    (recommended && equations.trees != trees).then_some(trees)
}

/// Which drivers' laws jump, or may, and what becomes of the impulses.
pub(super) fn warnings(equations: &Equations, jumps: &[Jump]) -> Vec<Fault> {
    let mechanism = &equations.system.mechanism;
    let laws = jumps.iter().map(|jump| {
        let part = &mechanism.drivers[jump.driver];
        let help = if !jump.of_rate || is_branch(equations, jump.driver) {
            "the other coordinates keep their rates there, without the impulse; make the law smooth (`smoothstep`, `spline`)"
        } else {
            "the impulse changes the speeds of the other coordinates at once; if that is not meant, make the law smooth (`smoothstep`, `spline`)"
        };
        jumps_there(part, jump).help(help)
    });
    let branches = mechanism.drivers.iter().enumerate().filter(|(driver, _)| is_branch(equations, *driver));
    let set = branches.filter_map(|(_, part)| {
        let message = format!("driver `{}` follows {}, whose rate may be discontinuous", part.name, set_by(mechanism, part)?);
        let help = "the other coordinates keep their rates there, without the impulse; give the driven body a mass and an inertia, and keep the driver out of the trees, as the recommended trees do";
        Some(Fault::warning("scene::driver_jump", message, part.span).label("may jump").help(help))
    });
    laws.chain(set).collect()
}

/// Laws that jump themselves where drivers prescribe the whole motion.
pub(super) fn leaps(mechanism: &Mechanism, jumps: &[Jump]) -> Vec<Fault> {
    let leap = |jump: &Jump| {
        let help = "a mechanism cannot follow a jump: the loops are closed again after it where possible, without a speed; make the law smooth (`smoothstep`, `spline`)";
        jumps_there(&mechanism.drivers[jump.driver], jump).help(help)
    };
    jumps.iter().filter(|jump| !jump.of_rate).map(leap).collect()
}

fn jumps_there(driver: &Part, jump: &Jump) -> Fault {
    let message = format!("the law of driver `{}` is discontinuous: at t = {} s {}", driver.name, jump.time, jump.what);
    Fault::warning("scene::driver_jump", message, driver.span).label("jumps")
}

/// What importers set in steps, or along lines with corners, and what the speed or the position of a driver follows: an input, or a tunable parameter.
pub(super) fn set_by(mechanism: &Mechanism, part: &Part) -> Option<&'static str> {
    const INPUT: &str = "an input";
    if part.values.iter().any(|(_, value)| matches!(value, KeyValue::Motion(Motion::Velocity(_)))) {
        return Some(INPUT);
    }
    let mut found = None;
    for law in laws(part) {
        law.visit(&mut |formula| match formula {
            Formula::Input(_) | Formula::Discrete(_) => found = Some(INPUT),
            Formula::Parameter(id) if mechanism.parameters[id.0].tunable => found = Some("a tunable parameter"),
            _ => {}
        });
    }
    found
}

/// Is the motion of a driver substituted, not imposed by a loop equation?
fn is_branch(equations: &Equations, driver: usize) -> bool {
    let is_here =
        |id: &ElementId| matches!(equations.system.element(*id).origin, Origin::Driver(other) if other.0 == driver);
    let trees = &equations.trees;
    trees.translation.branches.iter().chain(&trees.rotation.branches).any(is_here)
}
