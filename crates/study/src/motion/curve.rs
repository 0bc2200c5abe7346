//! The path of a point: length, area, curvature, cusps, points that it passes twice.

use cotree::model::Quantity;
use cotree::model::Quantity::{Ax, Ay, Vx, Vy, X, Y};
use serde::Serialize;

use super::drive::InputTable;
use super::samples::{Samples, ValueAt};

/// Two ways that differ by less than this share of their length are the same.
const SAME: f64 = 1e-8;

/// The path of a point.
#[derive(Clone, Debug, Serialize)]
pub struct PointPath {
    pub point: String,
    /// Its length \[m\].
    pub length: f64,
    /// The area that a closed path encloses, positive if counter-clockwise \[m2\].
    pub area: Option<f64>,
    /// Does the point go to and fro on the same way?
    pub to_and_fro: bool,
    /// The circle on which it stays, if there is one.
    pub arc: Option<Arc>,
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

/// A circle.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Arc {
    /// Its centre and its radius \[m\].
    pub x: f64,
    pub y: f64,
    pub radius: f64,
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
pub fn path(table: &InputTable, point: &str) -> Option<PointPath> {
    let of = |quantity: Quantity| table.get(&quantity.of(point));
    let (x, y, vx, vy, ax, ay) = (of(X)?, of(Y)?, of(Vx)?, of(Vy)?, of(Ax)?, of(Ay)?);
    let speed = vx.with(&vy, f64::hypot);
    // Rates are by time; the input has constant speed, which cancels in the curvature.
    let across = vx.with(&ay, |v, a| v * a).minus(&vy.with(&ax, |v, a| v * a));
    let [dx, dy] = [x.slope(), y.slope()];
    let way = dx.with(&dy, f64::hypot);
    let span = x.span();
    let area = x.with(&dy, |x, dy| x * dy).minus(&y.with(&dx, |y, dx| y * dx));
    let least = 1e-9 * speed.max().value;
    let radius = |(&speed, &across): (&f64, &f64)| {
        let radius = speed.powi(3) / across;
        (speed > least && radius.is_finite()).then_some(radius)
    };
    let slow: Vec<f64> =
        minima(&speed).into_iter().filter(|at| at.value < 1e-6 * speed.max().value).map(|at| at.input).collect();
    let length = way.mean() * span;
    let area = table.periodic.then(|| 0.5 * area.mean() * span);
    // It turns round where it stands still, and encloses nothing.
    let to_and_fro = slow.len() >= 2 && area.is_some_and(|area| area.abs() < SAME * length * length);
    let arc = Arc::through(x.values(), y.values());
    let bends = arc.is_none() || !to_and_fro;
    Some(PointPath {
        point: point.to_string(),
        length,
        area: area.filter(|_| !to_and_fro),
        to_and_fro,
        arc,
        radius: speed.values().iter().zip(across.values()).map(radius).collect(),
        inflections: if bends { across.zeros() } else { Vec::new() },
        cusps: if to_and_fro { Vec::new() } else { slow },
        crunodes: if to_and_fro { Vec::new() } else { crunodes(table, &x, &y, [&dx, &dy]) },
        x: x.values().to_vec(),
        y: y.values().to_vec(),
    })
}

impl Arc {
    /// The circle through three places of a path, if all others are on it.
    fn through(x: &[f64], y: &[f64]) -> Option<Arc> {
        let at = |index: usize| [x[index], y[index]];
        let far = |from: [f64; 2]| {
            let distance = |index: &usize| (x[*index] - from[0]).hypot(y[*index] - from[1]);
            (0..x.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let one = at(far(at(x.len().checked_sub(1)?))?);
        let two = at(far(one)?);
        let [bx, by] = [two[0] - one[0], two[1] - one[1]];
        let chord = bx.hypot(by);
        let off = |index: &usize| (bx * (y[*index] - one[1]) - by * (x[*index] - one[0])).abs();
        let three = at((0..x.len()).max_by(|a, b| off(a).total_cmp(&off(b)))?);
        let [cx, cy] = [three[0] - one[0], three[1] - one[1]];
        let twice = 2.0 * (bx * cy - by * cx);
        let [b, c] = [bx * bx + by * by, cx * cx + cy * cy];
        let [ux, uy] = [(cy * b - by * c) / twice, (bx * c - cx * b) / twice];
        let (radius, x0, y0) = (ux.hypot(uy), one[0] + ux, one[1] + uy);
        let is_on = |(x, y): (&f64, &f64)| ((x - x0).hypot(y - y0) - radius).abs() <= SAME * chord;
        let all = radius < chord / SAME && x.iter().zip(y).all(is_on);
        all.then_some(Arc { x: x0, y: y0, radius })
    }
}

/// Local minima between samples, by the square: a cusp is a kink of the speed.
fn minima(speed: &Samples) -> Vec<ValueAt> {
    let square = speed.map(|speed| speed * speed);
    let slope = square.slope();
    let zeros = slope.zeros().into_iter();
    zeros.map(|input| ValueAt { input, value: square.at_input(input).max(0.0).sqrt() }).collect()
}

/// Crossings of the polygon, made exact by Newton's method for both inputs.
fn crunodes(table: &InputTable, x: &Samples, y: &Samples, [dx, dy]: [&Samples; 2]) -> Vec<Crunode> {
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
