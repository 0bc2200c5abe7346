//! From a scene to a film of it.

use cotree::compile::{Compiled, compile_asking, everything};
use cotree::model::Dimension;
use cotree::model::Quantity::{Angle, X, Y};
use cotree::report::csv::CsvTable;
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
    let set = FilmSet::new(scene)?;
    let experiment = set.compiled.description.experiment;
    let run = |set: &FilmSet, count| sampled(&set.compiled, &set.seen.variables(), experiment, count);
    let taken = set.taken(take, most, experiment.stop - experiment.start, run);
    Ok((set.compiled, taken))
}

/// A film of a motion that is given: the values of [`film_variables`] over time, straight in between. What only marks parts that hold or strike may be missing.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn film_of(
    scene: &Scene,
    motion: &CsvTable,
    take: Take,
    most: u32,
) -> Result<Result<Taken, MotionlessError>, Faults> {
    let set = FilmSet::new(scene)?;
    let [Some(&begin), Some(&end)] = [motion.times().first(), motion.times().last()] else {
        return Ok(Err(MotionlessError("the motion has no points".to_owned())));
    };
    let place = |name: &String| motion.names().iter().position(|known| known == name);
    if let Some(lacking) = set.names(&set.seen.poses()).iter().find(|name| place(name).is_none()) {
        return Ok(Err(MotionlessError(format!("the motion has no `{lacking}`"))));
    }
    Ok(set.taken(take, most, end - begin, |set, count| {
        let time = |index: u32| begin + (end - begin) * f64::from(index) / f64::from(count);
        let times: Vec<f64> = (0..=count).map(time).collect();
        let column = |name: &String| match place(name) {
            Some(place) => times.iter().map(|&time| motion.at(place, time).0).collect(),
            None => vec![f64::NAN; times.len()],
        };
        let columns = set.names(&set.seen.variables()).iter().map(column).collect();
        Ok(SampledRun { times, columns, cut: None, inaccuracy: None })
    }))
}

/// The names of the variables that a film shows: of bodies where they are; then of points whose paths are drawn, and of what marks parts that hold or strike.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn film_variables(scene: &Scene) -> Result<[Vec<String>; 2], Faults> {
    let set = FilmSet::new(scene)?;
    let (poses, all) = (set.seen.poses(), set.seen.variables());
    Ok([&all[..poses.len()], &all[poses.len()..]].map(|variables| set.names(variables)))
}

/// A scene that is ready to be filmed.
struct FilmSet<'s> {
    scene: &'s Scene,
    compiled: Compiled,
    drawing: Drawing,
    /// Where the bodies are drawn.
    start: Vec<[f64; 3]>,
    seen: SeenVariables,
}

/// The variables that a film shows.
struct SeenVariables {
    /// Of each body where it is.
    places: Vec<Vec<usize>>,
    /// Of each point whose path is drawn x and y.
    paths: Vec<[usize; 2]>,
    modes: Vec<ModeVariables>,
}

impl SeenVariables {
    fn poses(&self) -> Vec<usize> {
        self.places.iter().flatten().copied().collect()
    }

    fn variables(&self) -> Vec<usize> {
        let seen = self.places.iter().flatten().chain(self.paths.iter().flatten()).copied();
        seen.chain(self.modes.iter().flat_map(ModeVariables::variables)).collect()
    }
}

impl<'s> FilmSet<'s> {
    fn new(scene: &'s Scene) -> Result<Self, Faults> {
        let (names, _) = everything(scene)?;
        let (compiled, mut formulated) = compile_asking(scene, &Requested::Also(names))?;
        let (drawing, start) = (draw(&mut formulated), frames(&mut formulated));
        let variables = &compiled.description.variables;
        let variable = |name: &str| variables.iter().position(|variable| variable.name == name);
        let is_line = scene.dimension == Dimension::One;
        let pose = if is_line { &[X][..] } else { &[X, Y, Angle] };
        let places = scene.bodies.iter().map(|body| -> Vec<usize> {
            pose.iter().filter_map(|quantity| variable(&quantity.of(&body.name.text))).collect()
        });
        let places: Vec<Vec<usize>> = places.collect();
        let drawn = points(scene).into_iter().filter(|_| !is_line);
        let paths = drawn.filter_map(|point| Some([variable(&X.of(point))?, variable(&Y.of(point))?])).collect();
        let modes = drawing.held.iter().map(|held| ModeVariables::new(held, &variable)).collect();
        Ok(FilmSet { scene, compiled, drawing, start, seen: SeenVariables { places, paths, modes } })
    }

    fn names(&self, variables: &[usize]) -> Vec<String> {
        let all = &self.compiled.description.variables;
        variables.iter().map(|&variable| all[variable].name.clone()).collect()
    }

    /// A film of a motion that is so long \[s\]; `run` gives its variables at that many equal steps.
    fn taken(
        &self,
        take: Take,
        most: u32,
        length: f64,
        run: impl FnOnce(&Self, u32) -> Result<SampledRun, MotionlessError>,
    ) -> Result<Taken, MotionlessError> {
        let duration = length / take.speed;
        let pictures: f64 = take.rate.map_or(SAMPLES, |rate| (duration * rate).round().max(1.0));
        if pictures > f64::from(most) {
            return Err(MotionlessError(format!(
                "a film of {pictures:.0} pictures is too long: at most {most}; choose a higher speed or a lower rate"
            )));
        }
        let step = (SAMPLES / pictures).ceil().max(1.0);
        let count = (pictures * step) as u32;
        let run = run(self, count)?;
        let duration = duration * (run.times.len() - 1) as f64 / f64::from(count);
        Ok(self.shown(run, duration, step as usize))
    }

    /// The film of a run, of so many seconds and with a picture after so many samples.
    fn shown(&self, run: SampledRun, duration: f64, step: usize) -> Taken {
        let SampledRun { times, columns, cut, inaccuracy } = run;
        let recorded = self.seen.variables();
        let column =
            |variable: usize| recorded.iter().position(|&known| known == variable).map(|place| &columns[place]);
        let value = |variable: usize, sample: usize| column(variable).map_or(f64::NAN, |column| column[sample]);
        let pose = |sample: usize| -> Vec<[f64; 3]> {
            let of_body = |(body, start): (&Vec<usize>, &[f64; 3])| {
                let mut pose = *start;
                body.iter().enumerate().for_each(|(axis, &variable)| pose[axis] = value(variable, sample));
                pose
            };
            self.seen.places.iter().zip(&self.start).map(of_body).collect()
        };
        let mut poses: Vec<Vec<[f64; 3]>> = (0..times.len()).map(pose).collect();
        let mut drawing = self.drawing.clone();
        if self.scene.dimension == Dimension::One {
            let gain = gain(&drawing, &poses);
            if gain < 1.0 {
                drawing.title += &format!(" (motion x {gain})");
            }
            shrink(&mut poses, gain);
        }
        let curve =
            |[x, y]: &[usize; 2]| (0..times.len()).map(|sample| [value(*x, sample), value(*y, sample)]).collect();
        let paths = self.seen.paths.iter().filter(|path| path.iter().all(|&axis| !value(axis, 0).is_nan()));
        let shows = self.seen.modes.iter().map(|modes| modes.shows(times.len(), &value)).collect();
        let film = Film::new(drawing, poses, paths.map(curve).collect(), duration, step).showing(shows);
        Taken { film, cut, inaccuracy }
    }
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
        let struck = |sample: usize, variable: usize| {
            sample > 0 && (value(variable, sample) - value(variable, sample - 1)).abs() > 0.0
        };
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
