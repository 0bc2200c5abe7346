//! From a scene to the page that shows it.

use std::sync::Arc;

use cotree_fmu::model::Model as Runnable;

use crate::compile::{self, Compiled};
use crate::diagnostic::span::Text;
use crate::export::description::{Causality, Description, ScalarVariable, Start};
use crate::formulate::Formulated;
use crate::mechanism::{Dimension, Place};
use crate::output::drawing::Geometry;
use crate::output::figures::summarise;
use crate::output::graph::GraphDrawing;
use crate::output::page::{Facts, GroundPoint, Model, Motion, Page, Variable, point_names};
use crate::output::pose::{draw, frames, position};
use crate::scene::{Faults, Scene};
use crate::simulate::{self, Run, RunError};

/// A stored run has about so many samples.
const SAMPLES: u64 = 1000;
/// What is recorded of bodies, joints and loads for the picture, by the last word of a variable's name.
const SEEN: [&str; 10] = ["x", "y", "angle", "vx", "vy", "fx", "fy", "fn", "force", "torque"];

/// What is made of the equations before they go.
struct Picture {
    geometry: Geometry,
    points: Vec<Vec<String>>,
    ground: Vec<GroundPoint>,
    line: bool,
}

/// The scene as it was asked for, and its page, with the solver inside if there is a module for it.
///
/// # Errors
/// Everything that is wrong with the scene; the page is an error if its motion cannot be computed at all.
pub fn page(scene: &Scene, module: Option<Vec<u8>>) -> Result<(Compiled, Result<Page, String>), Faults> {
    let (compiled, facts) = compile::compile_with(scene, facts)?;
    let (mut whole, _) = compile::with_everything(scene)?;
    if scene.dimension == Dimension::Two {
        let ground =
            scene.ground.iter().flat_map(|point| ["x", "y"].map(|axis| format!("ground.{}.{axis}", point.name.text)));
        let known: Vec<String> = whole.outputs.variables.iter().map(|variable| variable.text.clone()).collect();
        whole
            .outputs
            .variables
            .extend(ground.filter(|name| !known.contains(name)).map(|name| Text::from(name.as_str())));
    }
    let (everything, picture) = compile::compile_with(&whole, picture)?;
    let made = assemble(&compiled, &everything, picture, facts, module);
    Ok((compiled, made))
}

fn facts(formulated: &mut Formulated) -> Facts {
    let drawing = draw(formulated);
    Facts {
        summary: summarise(formulated).to_string(),
        graphs: GraphDrawing::new(formulated).svg(&drawing),
        equations: compile::front(formulated).equations,
    }
}

fn picture(formulated: &mut Formulated) -> Picture {
    let mechanism = formulated.equations.system.mechanism;
    let frames = frames(formulated);
    let ground = mechanism.ground.iter().enumerate();
    Picture {
        points: point_names(mechanism),
        line: mechanism.dimension == Dimension::One,
        ground: ground
            .map(|(index, point)| GroundPoint {
                name: point.name.clone(),
                at: position(formulated, Place::Ground(index)),
            })
            .collect(),
        geometry: draw(formulated).geometry(&frames),
    }
}

fn assemble(
    compiled: &Compiled,
    everything: &Compiled,
    picture: Picture,
    facts: Facts,
    module: Option<Vec<u8>>,
) -> Result<Page, String> {
    let description = &everything.description;
    let named = |indices: Vec<usize>, of: &Description| -> Vec<String> {
        indices.into_iter().map(|index| of.variables[index].name.clone()).collect()
    };
    let outputs = named(compiled.reported(), &compiled.description);
    let has = |name: &String| description.variables.iter().any(|variable| variable.name == *name);
    let recorded: Vec<usize> = (0..description.variables.len())
        .filter(|&index| {
            let variable = &description.variables[index];
            variable.causality.is_calculated() && (outputs.contains(&variable.name) || is_seen(&variable.name))
        })
        .collect();
    let mut model = Model {
        geometry: picture.geometry,
        points: picture.points,
        ground: picture.ground,
        line: picture.line,
        variables: description.variables.iter().map(variable).collect(),
        outputs: outputs.iter().filter(|name| has(name)).cloned().collect(),
        recorded: named(recorded.clone(), description),
        stored: Vec::new(),
        cut: None,
        experiment: description.experiment.into(),
    };
    let motion = match module {
        Some(module) => {
            let program = everything.program.to_bytes().map_err(|error| error.to_string())?;
            Motion::Solver { module, program }
        }
        None => {
            let (columns, cut) = stored(everything, recorded)?;
            model.stored = model.recorded.clone();
            model.cut = cut;
            Motion::Stored(columns)
        }
    };
    let Description { model_name, description, .. } = &compiled.description;
    Ok(Page { title: model_name.clone(), description: description.clone(), model, facts, motion })
}

/// Of points the places only.
fn is_seen(name: &str) -> bool {
    let words: Vec<&str> = name.split('.').collect();
    match words[..] {
        [_, _, last] => matches!(last, "x" | "y"),
        [_, last] => SEEN.contains(&last),
        _ => false,
    }
}

fn variable(variable: &ScalarVariable) -> Variable {
    let (start, min, max) = match variable.causality {
        Causality::Parameter { start, min, max, .. } | Causality::Input { start, min, max } => (Some(start), min, max),
        _ => (None, None, None),
    };
    let known = match variable.start {
        Some(Start::Exact(value)) => Some(value),
        _ => None,
    };
    Variable {
        name: variable.name.clone(),
        text: variable.description.clone(),
        kind: variable.causality.name(),
        unit: variable.unit.si.clone(),
        display: variable.unit.display.is_some().then(|| (&variable.unit).into()),
        start: start.or(known),
        min,
        max,
        initial: known.is_some() && start.is_none(),
    }
}

/// Times and columns of a run with the scene's values, and why it ends early if it does.
fn stored(compiled: &Compiled, reported: Vec<usize>) -> Result<(Vec<Vec<f64>>, Option<String>), String> {
    let description = &compiled.description;
    let experiment = description.experiment;
    let count = simulate::count(experiment);
    let every = count.div_ceil(SAMPLES).max(1);
    let model = Runnable::new(compiled.program.clone()).map_err(|error| error.to_string())?;
    let mut columns = vec![Vec::new(); reported.len() + 1];
    let run = Run { description, experiment, settings: Vec::new(), inputs: None, reported };
    let mut index = 0;
    let ended = run.start(Arc::new(model), |time, values| {
        if index % every == 0 || index + 1 == count {
            columns[0].push(time);
            columns[1..].iter_mut().zip(values).for_each(|(column, &value)| column.push(value));
        }
        index += 1;
        Ok(())
    });
    match ended {
        Ok(()) => Ok((columns, None)),
        Err(RunError::Instance(error)) if !columns[0].is_empty() => Ok((columns, Some(error.to_string()))),
        Err(error) => Err(error.to_string()),
    }
}
