//! The path of a point: length, area, curvature, cusps, points that it passes twice.

use serde::Serialize;

use super::drive::Table;
use super::samples::{At, Samples};

/// The path of a point.
#[derive(Clone, Debug, Serialize)]
pub struct Path {
    pub point: String,
    /// Its length \[m\].
    pub length: f64,
    /// The area that a closed path encloses, positive if counter-clockwise \[m2\].
    pub area: Option<f64>,
    /// Radius of curvature for each sample, positive where it turns left \[m\]; none where it is straight or stands still.
    pub radius: Vec<Option<f64>>,
    /// Where the curvature changes its sign: the input.
    pub inflections: Vec<f64>,
    /// Where it stands still.
    pub cusps: Vec<f64>,
    /// Where it crosses itself.
    pub crunodes: Vec<Crunode>,
    /// x and y for each sample \[m\].
    pub x: Vec<f64>,
    pub y: Vec<f64>,
}

/// A point that a path passes twice.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Crunode {
    /// Both inputs.
    pub inputs: [f64; 2],
    pub x: f64,
    pub y: f64,
}

/// The path of a point of the table; none if there is no such point.
pub fn path(table: &Table, point: &str) -> Option<Path> {
    let of = |word: &str| table.get(&format!("{point}.{word}"));
    let (x, y, vx, vy, ax, ay) = (of("x")?, of("y")?, of("vx")?, of("vy")?, of("ax")?, of("ay")?);
    let speed = vx.with(&vy, f64::hypot);
    // Rates are by time; the input has constant speed, which cancels in the curvature.
    let across = vx.with(&ay, |v, a| v * a).minus(&vy.with(&ax, |v, a| v * a));
    let [dx, dy] = [x.slope(), y.slope()];
    let way = dx.with(&dy, f64::hypot);
    let span = if table.periodic { std::f64::consts::TAU } else { table.input(table.count() - 1) - table.input(0) };
    let area = x.with(&dy, |x, dy| x * dy).minus(&y.with(&dx, |y, dx| y * dx));
    let least = 1e-9 * speed.max().value;
    let radius = |(&speed, &across): (&f64, &f64)| {
        let radius = speed.powi(3) / across;
        (speed > least && radius.is_finite()).then_some(radius)
    };
    let slow: Vec<f64> =
        minima(&speed).into_iter().filter(|at| at.value < 1e-6 * speed.max().value).map(|at| at.input).collect();
    Some(Path {
        point: point.to_string(),
        length: way.mean() * span,
        area: table.periodic.then(|| 0.5 * area.mean() * span),
        radius: speed.values().iter().zip(across.values()).map(radius).collect(),
        inflections: across.zeros(),
        cusps: slow,
        crunodes: crunodes(table, &x, &y, [&dx, &dy]),
        x: x.values().to_vec(),
        y: y.values().to_vec(),
    })
}

/// Local minima between samples, by the square: a cusp is a kink of the speed.
fn minima(speed: &Samples) -> Vec<At> {
    let square = speed.map(|speed| speed * speed);
    let slope = square.slope();
    let zeros = slope.zeros().into_iter();
    zeros.map(|input| At { input, value: square.at_input(input).max(0.0).sqrt() }).collect()
}

/// Crossings of the polygon, made exact by Newton's method for both inputs.
fn crunodes(table: &Table, x: &Samples, y: &Samples, [dx, dy]: [&Samples; 2]) -> Vec<Crunode> {
    let count = table.count();
    let point = |index: usize| [x.values()[index % count], y.values()[index % count]];
    let segments = if table.periodic { count } else { count - 1 };
    let cross =
        |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    let mut found: Vec<Crunode> = Vec::new();
    for i in 0..segments {
        let (a, b) = (point(i), point(i + 1));
        for j in i + 2..segments {
            if table.periodic && i == 0 && j == segments - 1 {
                continue;
            }
            let (c, d) = (point(j), point(j + 1));
            let apart = cross(a, b, c) * cross(a, b, d) >= 0.0 || cross(c, d, a) * cross(c, d, b) >= 0.0;
            if apart {
                continue;
            }
            let mut inputs = [table.input(i), table.input(j)];
            for _ in 0..20 {
                let [s, t] = inputs;
                let gap = [x.at_input(s) - x.at_input(t), y.at_input(s) - y.at_input(t)];
                let [a, b, c, d] = [dx.at_input(s), -dx.at_input(t), dy.at_input(s), -dy.at_input(t)];
                let determinant = a * d - b * c;
                inputs[0] -= (d * gap[0] - b * gap[1]) / determinant;
                inputs[1] -= (a * gap[1] - c * gap[0]) / determinant;
            }
            let (x, y) = (x.at_input(inputs[0]), y.at_input(inputs[0]));
            if x.is_finite() && y.is_finite() && inputs[0] != inputs[1] {
                found.push(Crunode { inputs, x, y });
            }
        }
    }
    found
}
