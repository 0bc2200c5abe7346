//! From a scene to a film of it.

use cotree::compile::{Compiled, compile_asking, everything};
use cotree::model::Dimension;
use cotree::model::Quantity::{Angle, X, Y};
use cotree::scene::{Faults, Requested, Scene};
use cotree_draw::drawing::{Drawing, Film, HeldPart, Shows};
use cotree_draw::pose::{draw, frames};
use cotree_fmu::instance::Inaccuracy;

use crate::MotionlessError;
use crate::moving::{SampledRun, sampled};

/// The motion is sampled at least so often, and at a multiple of the pictures.
const SAMPLES: f64 = 1920.0;

/// How a film is taken.
#[derive(Clone, Copy, Debug)]
pub struct Take {
    /// Pictures in a second of the film; as many as it needs if it moves by itself.
    pub rate: Option<f64>,
    /// Seconds of the mechanism in a second of the film.
    pub speed: f64,
}

/// A film, and why it ends early if it does.
#[derive(Clone, Debug)]
pub struct Taken {
    pub film: Film,
    /// Why the motion could not be continued.
    pub cut: Option<String>,
    /// Are rounding errors of the run larger than its tolerance?
    pub inaccuracy: Option<Inaccuracy>,
}

/// A film of the scene's experiment, with the paths of the points that it reports; an error if it does not move at all.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn film(scene: &Scene, take: Take, most: u32) -> Result<(Compiled, Result<Taken, MotionlessError>), Faults> {
    let (names, _) = everything(scene)?;
    let (everything, mut formulated) = compile_asking(scene, &Requested::Also(names))?;
    let (drawing, start) = (draw(&mut formulated), frames(&mut formulated));
    let experiment = everything.description.experiment;
    let duration = (experiment.stop - experiment.start) / take.speed;
    let count = take.rate.map_or(SAMPLES, |rate| (duration * rate).round().max(1.0));
    let step = (SAMPLES / count).ceil().max(1.0);
    let timing = Timing { count: (count * step) as u32, step: step as usize, duration };
    let taken = match count <= f64::from(most) {
        true => taken(scene, &everything, drawing, &start, timing),
        false => Err(MotionlessError(format!(
            "a film of {count:.0} pictures is too long: at most {most}; choose a higher speed or a lower rate"
        ))),
    };
    Ok((everything, taken))
}

/// Samples after the first, those of one picture, and seconds of the film.
struct Timing {
    count: u32,
    step: usize,
    duration: f64,
}

fn taken(
    scene: &Scene,
    everything: &Compiled,
    mut drawing: Drawing,
    start: &[[f64; 3]],
    Timing { count, step, duration }: Timing,
) -> Result<Taken, MotionlessError> {
    let description = &everything.description;
    let variable = |name: &str| description.variables.iter().position(|variable| variable.name == name);
    let pose = if scene.dimension == Dimension::One { &[X][..] } else { &[X, Y, Angle] };
    let places = scene.bodies.iter().map(|body| -> Vec<usize> {
        pose.iter().filter_map(|quantity| variable(&quantity.of(&body.name.text))).collect()
    });
    let places: Vec<Vec<usize>> = places.collect();
    let paths = points(scene).into_iter().filter_map(|point| Some([variable(&X.of(point))?, variable(&Y.of(point))?]));
    let paths: Vec<[usize; 2]> = if scene.dimension == Dimension::One { Vec::new() } else { paths.collect() };
    let modes: Vec<ModeVariables> = drawing.held.iter().map(|held| ModeVariables::new(held, &variable)).collect();
    let seen = places.iter().flatten().chain(paths.iter().flatten()).copied();
    let recorded: Vec<usize> = seen.chain(modes.iter().flat_map(ModeVariables::variables)).collect();
    let SampledRun { times, columns, cut, inaccuracy } = sampled(everything, &recorded, description.experiment, count)?;
    let column = |variable: usize| recorded.iter().position(|&known| known == variable).map(|place| &columns[place]);
    let value = |variable: usize, sample: usize| column(variable).map_or(f64::NAN, |column| column[sample]);
    let pose = |sample: usize| -> Vec<[f64; 3]> {
        let of_body = |(body, start): (&Vec<usize>, &[f64; 3])| {
            let mut pose = *start;
            body.iter().enumerate().for_each(|(axis, &variable)| pose[axis] = value(variable, sample));
            pose
        };
        places.iter().zip(start).map(of_body).collect()
    };
    let mut poses: Vec<Vec<[f64; 3]>> = (0..times.len()).map(pose).collect();
    if scene.dimension == Dimension::One {
        let gain = gain(&drawing, &poses);
        if gain < 1.0 {
            drawing.title += &format!(" (motion x {gain})");
        }
        shrink(&mut poses, gain);
    }
    let curve = |[x, y]: &[usize; 2]| (0..times.len()).map(|sample| [value(*x, sample), value(*y, sample)]).collect();
    let duration = duration * (times.len() - 1) as f64 / f64::from(count);
    let shows = modes.iter().map(|modes| modes.shows(times.len(), &value)).collect();
    let film = Film::new(drawing, poses, paths.iter().map(curve).collect(), duration, step).showing(shows);
    Ok(Taken { film, cut, inaccuracy })
}

/// The variables that say whether something holds, each with its value then, and that of the last impulse.
struct ModeVariables {
    while_held: Vec<(usize, f64)>,
    impulse: Option<usize>,
}

impl ModeVariables {
    /// Nothing of what has no variable is shown.
    fn new(held: &HeldPart, variable: &dyn Fn(&str) -> Option<usize>) -> Self {
        let all: Option<Vec<(usize, f64)>> =
            held.while_held.iter().map(|(name, value)| Some((variable(name)?, *value))).collect();
        let impulse = held.impulse.as_ref().and_then(|name| variable(name));
        ModeVariables { while_held: all.unwrap_or_default(), impulse }
    }

    fn variables(&self) -> impl Iterator<Item = usize> {
        self.while_held.iter().map(|(variable, _)| *variable).chain(self.impulse)
    }

    fn shows(&self, samples: usize, value: &dyn Fn(usize, usize) -> f64) -> Shows {
        let is_held =
            |sample: usize| self.while_held.iter().all(|&(variable, wanted)| value(variable, sample) == wanted);
        let struck =
            |sample: usize, variable: usize| sample > 0 && value(variable, sample) != value(variable, sample - 1);
        Shows {
            holds: (0..samples).map(|sample| !self.while_held.is_empty() && is_held(sample)).collect(),
            strikes: (0..samples).map(|sample| self.impulse.is_some_and(|impulse| struck(sample, impulse))).collect(),
        }
    }
}

/// Points of which the scene reports both coordinates.
pub fn points(scene: &Scene) -> Vec<&str> {
    let reported: Vec<&str> = scene.outputs.variables.iter().map(|name| name.text.as_str()).collect();
    let points = reported.iter().filter_map(|name| name.strip_suffix(".x"));
    points.filter(|point| reported.iter().any(|name| name.strip_suffix(".y") == Some(point))).collect()
}

/// How much of the motion of masses on a line is shown: they are drawn where there is room for them, which may be little.
fn gain(drawing: &Drawing, poses: &[Vec<[f64; 3]>]) -> f64 {
    let places = || drawing.bodies.iter().map(|body| body.centre[0]);
    let wide = places().fold(f64::MIN, f64::max) - places().fold(f64::MAX, f64::min);
    let moved = poses.iter().flat_map(|pose| pose.iter().zip(&poses[0]).map(|(now, start)| (now[0] - start[0]).abs()));
    let (far, room) = (moved.fold(0.0, f64::max), 0.4 * wide / (drawing.bodies.len().max(2) - 1) as f64);
    if !(wide > 0.0 && far > room) {
        return 1.0;
    }
    // One digit, so that a reader can say it.
    let size = 10.0_f64.powf((room / far).log10().floor());
    ((room / far / size).floor() * size * 1e12).round() / 1e12
}

fn shrink(poses: &mut [Vec<[f64; 3]>], gain: f64) {
    let Some(start) = poses.first().cloned() else { return };
    for (now, start) in poses.iter_mut().flat_map(|pose| pose.iter_mut().zip(&start)) {
        now[0] = start[0] + gain * (now[0] - start[0]);
    }
}
