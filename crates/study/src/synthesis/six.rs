//! Six-bars for a task that four-bars do not meet well enough: written as scenes and driven by the program.

use std::f64::consts::TAU;
use std::fmt::Write;

use cotree::task::{Task, TaskKind};
use cotree_synthesis::path::{CouplerPath, PathEffort, PathFollower};
use cotree_synthesis::six::{SixBar, SixKind, six_bar_followers, six_bar_functions, six_bar_poses};
use cotree_synthesis::within::{Wish, bounded_followers};
use cotree_synthesis::{LinkageLimits, Point, extent, way};

use super::candidates::path_limits;
use super::drive::{DriveError, largest_output_miss};
use super::scene::point;
use super::{MET, Solution};

/// A six-bar that the program has driven through its task.
#[derive(Clone, Debug)]
pub struct SixSolution {
    pub kind: SixKind,
    /// Ground, crank, coupler, second bar, both bars of the dyad \[m\].
    pub lengths: [f64; 6],
    /// The largest distance of two points of one link, the ground and the point that draws a path included \[m\].
    pub size: f64,
    /// The largest error \[m or rad\].
    pub error: f64,
    /// The smallest transmission angle of each loop \[rad\].
    pub transmission: [f64; 2],
    pub full_turn: bool,
    /// How far the driven scene was from the places of the search, as a share of the size or in radians.
    pub driven: f64,
    pub scene: String,
}

/// So many are shown.
const SHOWN: usize = 6;

/// Six-bars for a path, a function or poses, best first. Those for a path start from four-bars for it, those for poses from four-bars for the path of the body's origin.
pub fn six_bars(task: &Task, limits: &LinkageLimits, four_bars: &[Solution]) -> Vec<SixSolution> {
    let found = match &task.kind {
        TaskKind::Path(path) => {
            let known: Vec<PathFollower> = four_bars
                .iter()
                .map(|four_bar| PathFollower {
                    linkage: four_bar.linkage,
                    poses: four_bar.poses.clone(),
                    largest: four_bar.error,
                    rms: four_bar.error,
                })
                .collect();
            six_bar_followers(path, &path_limits(path, limits), &known, 1)
        }
        TaskKind::Function { pairs, is_slider: false, ground, .. } => six_bar_functions(pairs, *ground, limits, 1),
        TaskKind::Poses { at: poses, .. } => {
            let path = CouplerPath { points: poses.iter().map(|pose| pose.at).collect(), ..CouplerPath::default() };
            let free =
                LinkageLimits { transmission: limits.transmission, crank: limits.crank, ..LinkageLimits::default() };
            let known =
                bounded_followers(&path, &path_limits(&path, &free), Wish::Accuracy, &[], &PathEffort::default());
            let known: Vec<PathFollower> = known.into_iter().map(|known| known.follower).collect();
            six_bar_poses(poses, limits, &known, 1)
        }
        TaskKind::Function { .. } | TaskKind::Stroke { .. } => Vec::new(),
    };
    let mut all: Vec<SixSolution> = Vec::new();
    for six_bar in found {
        if all.len() >= SHOWN {
            break;
        }
        let like = |other: &SixSolution| {
            let size = six_bar.lengths.iter().copied().fold(0.0, f64::max);
            other.kind == six_bar.kind && (0..6).all(|i| (other.lengths[i] - six_bar.lengths[i]).abs() < 0.02 * size)
        };
        if !all.iter().any(like) {
            all.extend(driven(task, &six_bar, all.len() + 1));
        }
    }
    all
}

/// The scene and how far it is from the places of the search; none if the program does not drive it there.
fn driven(task: &Task, six_bar: &SixBar, number: usize) -> Option<SixSolution> {
    let (first, last) = (*six_bar.inputs.first()?, *six_bar.inputs.last()?);
    let sense = if last < first { -1.0 } else { 1.0 };
    let start = six_bar.inputs.iter().map(|input| sense * input).fold(f64::INFINITY, f64::min) * sense;
    let end = six_bar.inputs.iter().map(|input| sense * input).fold(f64::NEG_INFINITY, f64::max) * sense;
    let end = if six_bar.full_turn { start + sense * TAU } else { end };
    let duration = (end - start).abs();
    let scene = text(task, six_bar, number, [start, end], duration);
    let angular = task.is_angular();
    let size = if angular { 1.0 } else { extent(six_bar.outputs.iter().copied()).1 };
    let at = |input: f64| (input - start) / (end - start) * duration;
    let mut stations: Vec<(f64, Point)> =
        six_bar.inputs.iter().zip(&six_bar.outputs).map(|(input, output)| (at(*input), *output)).collect();
    stations.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut off = miss(&scene, &stations, angular, size).ok()?;
    if !six_bar.turns.is_empty() {
        let mut turns: Vec<(f64, Point)> = six_bar
            .inputs
            .iter()
            .zip(&six_bar.turns)
            .map(|(input, turn)| (at(*input), Point::new(*turn, 0.0)))
            .collect();
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        let turned = |index: usize, [angle, _]: [f64; 2]| way(turns[index].1.re, angle).abs();
        off = off.max(largest_output_miss(&scene, ["link.angle", "crank.angle"], &turns, turned).ok()?);
    }
    let miss = Some(off).filter(|miss| *miss <= MET)?;
    Some(SixSolution {
        kind: six_bar.kind,
        lengths: six_bar.lengths,
        size: six_bar.size(task.limits.linkage.tracer),
        error: six_bar.largest,
        transmission: six_bar.transmission,
        full_turn: six_bar.full_turn,
        driven: miss,
        scene,
    })
}

fn miss(scene: &str, stations: &[(f64, Point)], angular: bool, size: f64) -> Result<f64, DriveError> {
    if !angular {
        let off = |index: usize, [x, y]: [f64; 2]| (Point::new(x, y) - stations[index].1).norm() / size;
        return largest_output_miss(scene, ["link.tracer.x", "link.tracer.y"], stations, off);
    }
    // Outputs of the search are turns from the angle where they are zero, which is the same at all stations.
    let mut zero = None;
    let off = |index: usize, [angle, _]: [f64; 2]| {
        let real_angle = angle - stations[index].1.re;
        way(*zero.get_or_insert(real_angle), real_angle).abs()
    };
    largest_output_miss(scene, ["output.angle", "crank.angle"], stations, off)
}

/// The scene: bodies, pins, a driver that turns the crank evenly.
fn text(task: &Task, six_bar: &SixBar, number: usize, [from, to]: [f64; 2], duration: f64) -> String {
    let name = format!("{}_six_{number}", cotree::model::identifier(&task.name));
    let about = format!("{} six-bar for the task {}", six_bar.kind.name(), task.name);
    let mut text = format!("format      = 1\nname        = {name:?}\ndescription = {about:?}\n\n[ground.points]\n");
    // Writing to a string cannot fail.
    for (name, place) in &six_bar.ground {
        let _ = writeln!(text, "{name} = {}", point(*place));
    }
    let mut guesses = String::new();
    for body in &six_bar.bodies {
        let points: Vec<String> =
            body.points.iter().map(|(name, place)| format!("{name} = {}", point(*place))).collect();
        let points = points.join(", ");
        let _ = writeln!(text, "\n[bodies.{}]\nmass    = 1.0\ninertia = 0.01\npoints  = {{ {points} }}", body.name);
        let _ = writeln!(guesses, "\"{}.angle\" = {{ guess = {:?} }}", body.name, body.angle);
    }
    for (index, [one, other]) in six_bar.joints.iter().enumerate() {
        let name = if index == 0 { "first_pivot".to_owned() } else { format!("pin_{index}") };
        let _ = writeln!(text, "\n[joints.{name}]\ntype    = \"revolute\"\nbetween = [{one:?}, {other:?}]");
    }
    let rate = (to - from) / duration;
    let outputs = if task.is_angular() {
        "\"crank.angle\", \"output.angle\""
    } else {
        "\"link.tracer.x\", \"link.tracer.y\", \"link.angle\""
    };
    let _ = write!(
        text,
        "\n[drivers.motor]\njoint = \"first_pivot\"\nangle = \"{from:?} + ({rate:?})*t\"\n\n[initial]\n{guesses}\n[outputs]\nvariables = [{outputs}]\n\n\
         [experiment]\nstop = {duration:?}\nstep = {:?}\n",
        duration / 200.0,
    );
    text
}
