//! Assumptions and default values of a scene, in its units.

use cotree::component::Section;
use cotree::expr::{Order, Symbol};
use cotree::formulate::Formulated;
use cotree::formulate::assemblies::assemblies;
use cotree::model::{Body, Dimension, Mechanism, Output, Range, Unit};
use cotree::scene::constant::evaluate;
use cotree::scene::key::{Form, Need};
use cotree::scene::{Part, Scene};
use cotree::typeset::{fixed, rounded};

/// From how many starts other assemblies are looked for, in mechanisms of at most so many coordinates.
const STARTS: usize = 30;
const MOST_COORDINATES: usize = 12;

/// What the scene leaves open, a sentence for each.
pub fn assumptions(formulated: &mut Formulated, scene: &Scene) -> Vec<String> {
    let mut sentences = loose(&formulated.equations.system.mechanism);
    sentences.extend(mass_centres(&formulated.equations.system.mechanism, scene));
    sentences.extend(free_lengths(scene));
    sentences.extend(start(formulated));
    sentences.extend(far_from_guess(formulated));
    sentences.extend(one_of_several(formulated));
    sentences.extend(experiment(formulated, scene));
    sentences.extend(open_units(&formulated.outputs));
    sentences
}

/// Outputs whose units nobody can tell.
fn open_units(outputs: &[Output]) -> Vec<String> {
    let sentence = |name: &String| {
        format!(
            "output `{name}` has no unit, also in the FMU, because numbers, parameters or inputs in its expression have none; give `unit`, or units of the numbers as in `200[N/m]`"
        )
    };
    outputs.iter().filter(|output| output.is_open).map(|output| sentence(&output.name)).collect()
}

/// Bodies that no joint and no driver touches.
fn loose(mechanism: &Mechanism) -> Vec<String> {
    let parts = || mechanism.joints.iter().chain(&mechanism.drivers);
    let is_loose =
        |body: usize| !parts().flat_map(|part| part.places()).any(|place| place.body().is_some_and(|id| id.0 == body));
    let names = mechanism.bodies.iter().enumerate().filter(|(index, _)| is_loose(*index)).map(|(_, body)| &body.name);
    // Masses on a line have no joints.
    let plane = mechanism.dimension == Dimension::Two;
    let sentence = |name: &String| format!("body `{name}` has no joint: it moves freely");
    names.filter(|_| plane).map(sentence).collect()
}

/// Bodies whose mass centre is the origin of their points because nothing else is said, unless that is in the middle of them.
fn mass_centres(mechanism: &Mechanism, scene: &Scene) -> Vec<String> {
    let parameters = mechanism.parameter_values();
    let sentence = |body: &Body| {
        let says = |part: &&Part| part.name.text == body.name;
        let written = scene.bodies.iter().find(says)?;
        let mass = body.mass.as_ref().map_or(0.0, |mass| evaluate(mass, &parameters));
        if mass == 0.0 || body.points.len() < 2 || ["com", "shape"].iter().any(|key| written.get(key).is_some()) {
            return None;
        }
        let places: Vec<[f64; 2]> =
            body.points.iter().map(|point| point.at.each_ref().map(|at| evaluate(at, &parameters))).collect();
        let sum = places.iter().fold([0.0, 0.0], |[x, y], at| [x + at[0], y + at[1]]);
        let largest = places.iter().fold(0.0, |largest: f64, [x, y]| largest.max(x.hypot(*y)));
        if sum[0].hypot(sum[1]) <= 1e-9 * largest {
            return None;
        }
        let point = body.points.iter().zip(&places).find(|(_, at)| **at == [0.0, 0.0]);
        let place = point.map_or(String::new(), |(point, _)| format!(", at its point `{}`", point.name));
        Some(format!("the mass centre of `{}` is its origin{place}", body.name))
    };
    mechanism.bodies.iter().filter_map(sentence).collect()
}

/// Springs whose free length or angle is not given.
fn free_lengths(scene: &Scene) -> Vec<String> {
    let mut sentences = Vec::new();
    for part in &scene.loads {
        let Some(component) = part.component(Section::Loads) else { continue };
        let free = |name: &str| name == "length" || name == "angle";
        for key in component.keys {
            let is_number = matches!((key.form, key.need), (Form::Constant(_, Range::Any), Need::Optional));
            if is_number && free(key.name) && part.get(key.name).is_none() {
                let (words, name) = (component.words(), &part.name.text);
                sentences.push(format!("{words} `{name}` has no `{0}`: its free {0} is 0", key.name));
            }
        }
    }
    sentences
}

/// Coordinates of the start that are neither given nor guessed, and velocities.
fn start(formulated: &mut Formulated) -> Vec<String> {
    let mobility = formulated.mobility();
    let follows_recommended = !formulated.lowered.program.initial.first_positions.is_empty();
    let state = formulated.state.clone();
    let equations = &mut formulated.equations;
    let mechanism = &*equations.system.mechanism.clone();
    let values: Vec<_> = mechanism.initial.iter().map(|initial| equations.variable(initial.variable)).collect();
    let said = equations.system.arena.symbols(values);
    let mut sentences = Vec::new();
    for (index, coordinate) in equations.coordinates.iter().enumerate() {
        if said.binary_search(&Symbol::Coordinate(index, Order::Position)).is_ok() {
            continue;
        }
        let unit = mechanism.units.of(&if coordinate.angular { Unit::angle() } else { Unit::length() });
        let name = &coordinate.name.position;
        let value = fixed(state.positions()[index] / unit.factor);
        let from = match follows_recommended {
            true if mechanism.begins.is_empty() => "as in the recommended trees",
            true => "searched from its position in the part, at 0",
            false => "searched from 0",
        };
        sentences.push(format!("`{name}` is neither given nor guessed: {from}, found at {value} {}", unit.name));
    }
    let known = said.iter().filter(|symbol| matches!(symbol, Symbol::Coordinate(_, Order::Velocity))).count();
    if known < mobility {
        sentences.push("velocities that are not given are zero as far as loops and drivers permit".to_string());
    }
    sentences
}

/// Poses that were found far from where they were guessed: farther than the longest arm, or turned by more than a right angle.
fn far_from_guess(formulated: &mut Formulated) -> Vec<String> {
    let state = formulated.state.clone();
    let longest = formulated.lowered.program.length;
    let equations = &mut formulated.equations;
    let mechanism = &*equations.system.mechanism.clone();
    let mut sentences = Vec::new();
    for initial in mechanism.initial.iter().filter(|initial| !initial.known) {
        let exprs = [equations.formula(&initial.value), equations.variable(initial.variable)];
        let [guess, found] = equations.system.arena.evaluate(&exprs, &state)[..] else { continue };
        let (unit, most) = match initial.variable.quantity.measure().si {
            "rad" => (Unit::angle(), std::f64::consts::FRAC_PI_2),
            "m" => (Unit::length(), longest),
            // A guessed rate is no place.
            _ => continue,
        };
        if (found - guess).abs() > most {
            let unit = initial.display.clone().unwrap_or_else(|| mechanism.units.of(&unit));
            let [guess, found] =
                [guess, found].map(|value| format!("{} {}", rounded(value / unit.factor, 6), unit.name));
            let name = mechanism.variable_name(initial.variable);
            sentences.push(format!("`{name}` is {found} at the start, far from its guess of {guess}: another assembly mode may be closer, see `cotree assemblies`"));
        }
    }
    sentences
}

/// That the loops close in other ways too, where no guess has picked one of them.
fn one_of_several(formulated: &Formulated) -> Option<String> {
    let mechanism = &formulated.equations.system.mechanism;
    let has_loops = !formulated.equations.constraints.is_empty();
    let is_small = formulated.equations.coordinates.len() <= MOST_COORDINATES;
    if !has_loops || !is_small || mechanism.initial.iter().any(|initial| !initial.known) {
        return None;
    }
    let found = assemblies(mechanism, STARTS).ok().filter(|found| !found.is_continuous() && found.poses.len() > 1)?;
    let count = found.poses.len();
    Some(format!("no guess chooses the assembly mode: this is one of {count}; `cotree assemblies` lists them"))
}

/// What is run and reported by default.
fn experiment(formulated: &Formulated, scene: &Scene) -> Vec<String> {
    let mechanism = &formulated.equations.system.mechanism;
    let second = mechanism.units.of(&Unit::time());
    let time = |value: f64| format!("{} {}", rounded(value / second.factor, 6), second.name);
    let (given, run) = (&scene.experiment, &mechanism.experiment);
    let mut open = Vec::new();
    if given.stop.is_none() {
        open.push(format!("it ends at {}", time(run.stop)));
    }
    if given.step.is_none() {
        open.push(format!("a row every {}", time(run.step)));
    }
    if given.tolerance.is_none() {
        open.push(format!("tolerance {:e}", run.tolerance));
    }
    let mut sentences = Vec::new();
    if !open.is_empty() {
        let what = if given == &Default::default() { "no `[experiment]`" } else { "`[experiment]` does not give" };
        sentences.push(format!("{what}: {}", open.join(", ")));
    }
    if formulated.outputs.is_empty() {
        sentences.push("no `[outputs]`: coordinates and their rates are reported".to_string());
    }
    sentences
}
