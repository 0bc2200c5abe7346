//! What the drawing page needs to know of a text: what is wrong with it, the mechanism at its start, and where its numbers are written.

use cotree::compile::{compile_with_equations, quantity};
use cotree::model::{Dimension, DisplayUnit, Exponents, Unit};
use cotree::scene::{Faults, Quantity, Scene, Source, Span, Value};
use cotree::task::Task;
use cotree_draw::drawing::Geometry;
use cotree_study::synthesis::{Solution, synthesize};
use serde::Serialize;
use serde_json::json;

use crate::moving::{picture, values};
use crate::page::{GroundPoint, WrittenPlace};

/// The mechanism at its start.
#[derive(Clone, Debug, Serialize)]
struct Sketch {
    /// None as long as there are no bodies.
    geometry: Option<Geometry>,
    /// Names of the points of each body.
    points: Vec<Vec<String>>,
    ground: Vec<GroundPoint>,
    /// True for a mechanism on a line.
    line: bool,
    /// Degrees of freedom.
    mobility: usize,
    numbers: Vec<Stated>,
}

/// A plain number of the text.
#[derive(Clone, Debug, Serialize)]
struct Stated {
    #[serde(flatten)]
    written: WrittenPlace,
    /// In SI units.
    value: f64,
    /// A zero without a unit: it can be followed by a number in any unit.
    is_bare_zero: bool,
}

/// A scene from a text that has no file.
///
/// # Errors
/// What is wrong with its form.
pub fn scene(text: &str) -> Result<Scene, Faults> {
    Scene::from_toml(text)
}

/// The faults of a text and the mechanism that it describes, as JSON; of a text with faults the ground alone, if that is all there is.
pub fn look(text: &str) -> serde_json::Value {
    let read = scene(text);
    let compiled = read.as_ref().map_err(Faults::clone).and_then(compile_with_equations);
    match (read, compiled) {
        (Ok(scene), Ok((compiled, mut formulated))) => {
            let mobility = cotree::report::figures::summarise(&formulated).mobility;
            let picture = picture(&mut formulated);
            let sketch = Sketch {
                geometry: Some(picture.geometry),
                points: picture.points,
                ground: picture.ground,
                line: picture.line,
                mobility,
                numbers: numbers(&scene, text),
            };
            json!({ "good": true, "name": scene.name.text, "faults": told(compiled.warnings.as_ref()), "sketch": sketch })
        }
        (Ok(scene), Err(faults)) if scene.bodies.is_empty() => {
            let sketch = ground_alone(&scene, text);
            json!({ "good": false, "name": scene.name.text, "faults": told(Some(&faults)), "sketch": sketch })
        }
        (read, Err(faults)) => {
            let name = read.map_or(String::new(), |scene| scene.name.text);
            json!({ "good": false, "name": name, "faults": told(Some(&faults)) })
        }
        (Err(faults), Ok(_)) => json!({ "good": false, "name": "", "faults": told(Some(&faults)) }),
    }
}

/// Faults for the page: places count bytes and characters of its text.
pub fn told(faults: Option<&Faults>) -> serde_json::Value {
    faults.map_or_else(|| json!({ "faults": [], "omitted": 0 }), Faults::to_json)
}

fn ground_alone(scene: &Scene, text: &str) -> Sketch {
    let at = |point: &cotree::scene::Point| -> Option<[f64; 2]> {
        let value = |number: &Quantity| match &number.value {
            Value::Number(number) => Some(*number),
            Value::Text(text) => quantity(text, &Unit::length()).ok(),
        };
        let [x, y] = &point.at.components[..] else { return None };
        Some([value(x)?, value(y)?])
    };
    let ground =
        scene.ground.iter().filter_map(|point| Some(GroundPoint { name: point.name.text.clone(), at: at(point)? }));
    Sketch {
        geometry: None,
        points: Vec::new(),
        ground: ground.collect(),
        line: scene.dimension == Dimension::One,
        mobility: 0,
        numbers: numbers(scene, text),
    }
}

/// Coordinates, parameters and initial values that are plain numbers, and where they are written.
fn numbers(scene: &Scene, text: &str) -> Vec<Stated> {
    let coordinates = scene.loosened().numbers.into_iter().map(|number| (number.name, number.span));
    let others = values(scene).into_iter().map(|(name, span, _)| (name, span));
    coordinates.chain(others).filter_map(|(name, span)| stated(name, span, text)).collect()
}

fn stated(name: String, span: Span, text: &str) -> Option<Stated> {
    let source = Source::new("", text);
    let whole = (!span.is_nowhere() && span.end <= source.own_text().len()).then(|| span.whole(text))?;
    let written = text.get(whole.start..whole.end)?.trim_matches(['"', '\'']);
    let any = Unit { exponents: Exponents::default(), si: String::new(), display: None };
    let value = quantity(written, &any).ok()?;
    let number = written.trim_start().trim_start_matches(|letter: char| "+-.0123456789eE".contains(letter)).trim();
    let unit = (!number.is_empty()).then(|| DisplayUnit {
        name: number.trim_start_matches('[').trim_end_matches(']').to_owned(),
        factor: quantity(&format!("1 {number}"), &any).unwrap_or(1.0),
    });
    let is_bare_zero = value == 0.0 && unit.is_none();
    let unit = unit.unwrap_or_else(|| DisplayUnit { name: "m".to_owned(), factor: 1.0 });
    Some(Stated { written: WrittenPlace::new(name, text, whole, &unit, false), value, is_bare_zero })
}

/// The linkages for a task, best first, each with its scene and the curve of its body; as JSON.
pub fn answers(task: &str) -> serde_json::Value {
    let answer = Task::from_text(task).and_then(|task| synthesize(&task, false));
    let solution = |solution: &Solution| {
        let curve: Vec<[f64; 2]> = solution.curve().iter().map(|point| [point.re, point.im]).collect();
        json!({
            "class": solution.class, "lengths": solution.lengths, "size": solution.size, "error": solution.error, "transmission": solution.transmission,
            "turns": solution.full_turn, "scene": solution.scene, "curve": curve,
        })
    };
    match answer {
        Ok(answer) => json!({
            "solutions": answer.good().map(solution).collect::<Vec<_>>(),
            "shorter": answer.shorter.iter().map(solution).collect::<Vec<_>>(),
            "left_out": answer.left_out, "last": answer.last, "costs": answer.costs, "faults": told(None),
        }),
        Err(faults) => json!({
            "solutions": [], "shorter": [], "left_out": {}, "last": null, "costs": [], "faults": told(Some(&faults)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAR: &str = "name = 'bar'\n[ground.points]\npivot = ['100 mm', 0]\n[bodies.bar]\npoints = { a = [0, 0], b = ['300 mm', 0] }\n\
                       shape = { rod = ['a', 'b'], density = '1 kg/m' }\n[joints.hinge]\ntype = 'revolute'\nbetween = ['ground.pivot', 'bar.a']\n\
                       [initial]\n'bar.angle' = { guess = '90 deg' }\n";

    #[test]
    fn numbers_are_found_where_they_are_written() {
        let look = look(BAR);
        assert_eq!((&look["good"], &look["sketch"]["mobility"]), (&true.into(), &1.into()), "{look}");
        let numbers = look["sketch"]["numbers"].as_array().unwrap();
        let of = |name: &str| {
            numbers.iter().find(|number| number["name"] == name).unwrap_or_else(|| panic!("{name}: {look}"))
        };
        for (name, text, value, after) in [
            ("ground.pivot.x", "'100 mm'", 0.1, " mm'"),
            ("bar.b.x", "'300 mm'", 0.3, " mm'"),
            ("bar.angle", "'90 deg'", std::f64::consts::FRAC_PI_2, " deg'"),
        ] {
            let number = of(name);
            let place = [0, 1].map(|end| number["place"][end].as_u64().unwrap() as usize);
            assert_eq!(&BAR[place[0]..place[1]], text);
            assert!((number["value"].as_f64().unwrap() - value).abs() < 1e-15 && number["after"] == after, "{number}");
        }
        let [x, y] = [0, 1].map(|axis| look["sketch"]["geometry"]["bodies"][0]["start"][axis].as_f64().unwrap());
        assert!((x - 0.1).abs() < 1e-12 && (y - 0.15).abs() < 1e-12, "the middle of the bar, which stands upright");
    }

    #[test]
    fn ground_points_are_seen_before_there_are_bodies_and_faults_have_their_line() {
        let empty = look("name = 'new'\n[ground.points]\npivot = ['100 mm', 0.2]\n");
        assert_eq!(empty["good"], false);
        assert_eq!(empty["sketch"]["ground"][0], json!({ "name": "pivot", "at": [0.1, 0.2] }), "{empty}");
        assert_eq!(empty["faults"]["faults"][0]["code"], "scene::no_bodies");
        let faulty = look(&BAR.replace("bar.a", "bar.c"));
        assert_eq!((&faulty["good"], &faulty["sketch"]), (&false.into(), &serde_json::Value::Null));
        assert_eq!(faulty["faults"]["faults"][0]["place"]["line"], 9, "{faulty}");
        assert_eq!(look("name = ")["good"], false);
    }

    #[test]
    fn a_task_has_answers_with_scenes_that_can_be_drawn() {
        let task = "[poses]\nat = [[0, 0, 0], ['35 mm', '20 mm', '14 deg'], ['80 mm', '60 mm', '38 deg']]\n\
                    [choose]\nground_a = ['-60 mm', '-20 mm']\n";
        let answer = answers(task);
        let solutions = answer["solutions"].as_array().unwrap();
        assert!(!solutions.is_empty(), "{answer}");
        assert_eq!(look(solutions[0]["scene"].as_str().unwrap())["good"], true);
        assert_eq!(answers("[poses]\nat = 3\n")["faults"]["faults"].as_array().unwrap().len(), 1);
    }
}
