//! Linkages for a task, side by side: each in its first pose, with the curve of the body's origin, and the task in it.

use cotree_study::synthesis::{Answer, Solution};
use cotree_synthesis::{Dyad, Point, Pose};

use crate::svg::{PictureFrame, Pixel, Svg};

/// Size of one picture, the space around its drawing, and that for its title \[px\].
const CELL: [f64; 2] = [300.0, 280.0];
const MARGIN: f64 = 18.0;
const TITLE: f64 = 40.0;
const COLUMNS: usize = 4;
const BAR: &str = "stroke=\"#1f4e79\" stroke-width=\"4\" stroke-linecap=\"round\" fill=\"none\"";
const BODY: &str =
    "fill=\"#9dc3e6\" fill-opacity=\"0.55\" stroke=\"#1f4e79\" stroke-width=\"1.5\" stroke-linejoin=\"round\"";
const CURVE: &str = "fill=\"none\" stroke=\"#7f7f7f\" stroke-width=\"1.2\" stroke-dasharray=\"4 3\"";
const LINE: &str = "stroke=\"#7f7f7f\" stroke-width=\"1.5\"";
const TASK: &str = "stroke=\"#c00000\" stroke-width=\"1.5\" fill=\"none\"";
const PIN: &str = "fill=\"#ffffff\" stroke=\"#1f4e79\" stroke-width=\"2\"";
const GROUND: &str = "fill=\"#1f4e79\"";

/// All solutions in one picture.
pub fn picture(answer: &Answer) -> String {
    let mut svg = Svg::default();
    let count = answer.solutions.len();
    let columns = count.clamp(1, COLUMNS);
    for (index, solution) in answer.solutions.iter().enumerate() {
        let [x, y] = [(index % columns) as f64 * CELL[0], (index / columns) as f64 * CELL[1]];
        cell(&mut svg, PictureFrame { x, y, width: CELL[0], height: CELL[1] }, index + 1, solution);
    }
    let rows = count.div_ceil(columns).max(1);
    let frame = PictureFrame { x: 0.0, y: 0.0, width: columns as f64 * CELL[0], height: rows as f64 * CELL[1] };
    svg.finish(frame, &format!("linkages for {}", answer.task.name))
}

/// Where the points of a drawing are in its frame.
struct Scale {
    frame: PictureFrame,
    middle: Point,
    factor: f64,
}

impl Scale {
    fn of(points: &[Point], frame: PictureFrame) -> Scale {
        let edge = |pick: fn(f64, f64) -> f64, of: fn(&Point) -> f64| points.iter().map(of).reduce(pick).unwrap_or(0.0);
        let [left, right] = [edge(f64::min, |point| point.re), edge(f64::max, |point| point.re)];
        let [low, high] = [edge(f64::min, |point| point.im), edge(f64::max, |point| point.im)];
        let room = [frame.width - 2.0 * MARGIN, frame.height - 2.0 * MARGIN - TITLE];
        let fits = |room: f64, size: f64| if size > 0.0 { room / size } else { f64::INFINITY };
        let factor = fits(room[0], right - left).min(fits(room[1], high - low));
        let factor = if factor.is_finite() { factor } else { 1.0 };
        Scale { frame, middle: Point::new(0.5 * (left + right), 0.5 * (low + high)), factor }
    }

    fn at(&self, point: Point) -> Pixel {
        let off = (point - self.middle) * self.factor;
        [self.frame.x + 0.5 * self.frame.width + off.re, self.frame.y + 0.5 * (self.frame.height + TITLE) - off.im]
    }

    fn path(&self, points: &[Point], closed: bool) -> String {
        let part = |(index, point): (usize, &Point)| {
            let [x, y] = self.at(*point);
            format!("{}{x:.1} {y:.1}", if index == 0 { "M" } else { "L" })
        };
        let line: String = points.iter().enumerate().map(part).collect();
        if closed { line + "Z" } else { line }
    }
}

/// Pins of a dyad in a pose: in the ground, if there is one, and in the body.
fn pins(dyad: &Dyad, pose: &Pose) -> (Option<Point>, Point) {
    match *dyad {
        Dyad::Bar { moving, ground, .. } => (Some(ground), pose.carry(moving)),
        Dyad::Slider { moving, .. } => (None, pose.carry(moving)),
        Dyad::Slot { ground, .. } => (Some(ground), ground),
    }
}

fn cell(svg: &mut Svg, frame: PictureFrame, number: usize, solution: &Solution) {
    let Some(first) = solution.poses.first() else { return };
    let dyads = [solution.linkage.first, solution.linkage.second];
    let curve = solution.curve();
    let mut all: Vec<Point> = solution.poses.iter().map(|pose| pose.at).collect();
    all.extend(&curve);
    for (ground, moving) in dyads.iter().map(|dyad| pins(dyad, first)) {
        all.extend(ground);
        all.push(moving);
    }
    let scale = Scale::of(&all, frame);
    let size = 18.0 / scale.factor;
    let title = format!("{number}  {}", solution.class);
    svg.text([frame.x + MARGIN, frame.y + 20.0], "font-size=\"13\" font-weight=\"600\" fill=\"#1f2937\"", &title);
    let note = solution
        .reason
        .clone()
        .unwrap_or_else(|| format!("transmission angle {:.1}° at least", solution.transmission.to_degrees()));
    let colour = if solution.reason.is_some() { "#c00000" } else { "#4b5563" };
    svg.text([frame.x + MARGIN, frame.y + 36.0], &format!("font-size=\"10.5\" fill=\"{colour}\""), &note);
    svg.path(&scale.path(&curve, false), CURVE);
    body(svg, &scale, solution, first);
    for dyad in &dyads {
        guide(svg, &scale, dyad, first, size);
    }
    task(svg, &scale, solution, size);
}

/// The body between both pins and its origin.
fn body(svg: &mut Svg, scale: &Scale, solution: &Solution, pose: &Pose) {
    let corners = [pins(&solution.linkage.first, pose).1, pins(&solution.linkage.second, pose).1, pose.at];
    svg.path(&scale.path(&corners, true), BODY);
}

fn guide(svg: &mut Svg, scale: &Scale, dyad: &Dyad, pose: &Pose, size: f64) {
    let (ground, moving) = pins(dyad, pose);
    let along = match *dyad {
        Dyad::Bar { .. } => None,
        Dyad::Slider { normal, .. } => Some(normal * Point::new(0.0, 1.0)),
        Dyad::Slot { normal, .. } => Some(normal * pose.turn() * Point::new(0.0, 1.0)),
    };
    match (along, ground) {
        (Some(along), _) => {
            svg.line(scale.at(moving - along * (3.0 * size)), scale.at(moving + along * (3.0 * size)), LINE)
        }
        (None, Some(ground)) => svg.line(scale.at(ground), scale.at(moving), BAR),
        (None, None) => {}
    }
    svg.circle(scale.at(moving), 4.0, PIN);
    if let Some([x, y]) = ground.map(|ground| scale.at(ground)) {
        svg.path(&format!("M{x:.1} {y:.1}l-7 11h14z"), GROUND);
        svg.circle([x, y], 4.0, PIN);
    }
}

/// The poses of the task as small axes, or its points.
fn task(svg: &mut Svg, scale: &Scale, solution: &Solution, size: f64) {
    let few = solution.poses.len() <= 8;
    for pose in &solution.poses {
        if few {
            let turn = pose.turn();
            svg.line(scale.at(pose.at), scale.at(pose.at + turn * size), TASK);
            svg.line(scale.at(pose.at), scale.at(pose.at + turn * Point::new(0.0, 0.6 * size)), TASK);
        }
        svg.circle(scale.at(pose.at), 2.5, TASK);
    }
}
