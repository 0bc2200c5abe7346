//! Where loops close: the configuration at the start, and which joint coordinates are independent there. The same constraints that the scene has, in the joint
//! coordinates of the file's tree; only their values are used, as guesses of the scene.

use super::planar::{LinkPoint, PlanarClosure, PlanarCoordinate, PlanarModel};

/// Steps of Newton's method from a configuration that is nearly closed.
const STEPS: usize = 50;
/// Closed: residuals relative to the size.
const CLOSED: f64 = 1e-12;
/// A column with less of its own is a combination of the others.
const INDEPENDENT: f64 = 1e-6;

/// The start that the loops allow.
pub struct ClosedStart {
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
    /// Which coordinates are given; the others follow.
    pub independent: Vec<bool>,
    /// The largest change of a coordinate that closed the loops.
    pub moved: f64,
    /// The largest contradiction between given rates.
    pub contradiction: f64,
    /// The largest residual that is left, relative.
    pub open: f64,
}

/// A position and an angle.
type PlanarPose = ([f64; 2], f64);

/// Poses of all links; the first is the ground.
pub fn poses(model: &PlanarModel, values: &[f64]) -> Vec<PlanarPose> {
    let mut poses = vec![([0.0; 2], 0.0); model.links.len()];
    for (index, coordinate) in model.coordinates.iter().enumerate() {
        let value = values[index];
        let child = coordinate.child();
        match *coordinate {
            PlanarCoordinate::Turn { parent, at, sign, .. } => {
                let place = place_of(&poses[parent], model.links[parent].origin, at);
                let angle = poses[parent].1 + sign * value;
                let arm = turned(difference(model.links[child].origin, at), angle);
                poses[child] = ([place[0] + arm[0], place[1] + arm[1]], angle);
            }
            PlanarCoordinate::Slide { parent, along, .. } => {
                let origin = model.links[child].origin;
                let at = [origin[0] + value * along[0], origin[1] + value * along[1]];
                poses[child] = (place_of(&poses[parent], model.links[parent].origin, at), poses[parent].1);
            }
            PlanarCoordinate::FreeX(_) => poses[child].0[0] = model.links[child].origin[0] + value,
            PlanarCoordinate::FreeY(_) => poses[child].0[1] = model.links[child].origin[1] + value,
            PlanarCoordinate::FreeAngle(_) => poses[child].1 = value,
        }
    }
    poses
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Where a point is now that was at a place in the reference configuration.
pub fn place_of(pose: &PlanarPose, origin: [f64; 2], at: [f64; 2]) -> [f64; 2] {
    let arm = turned(difference(at, origin), pose.1);
    [pose.0[0] + arm[0], pose.0[1] + arm[1]]
}

/// What the loops and couplings are off by; lengths relative to the size.
pub fn residuals(model: &PlanarModel, values: &[f64]) -> Vec<f64> {
    let poses = poses(model, values);
    let at = |&(link, at): &LinkPoint| place_of(&poses[link], model.links[link].origin, at);
    let mut rows = Vec::new();
    for closure in &model.closures {
        let ends = closure.ends();
        let gap = difference(at(&ends[1]), at(&ends[0])).map(|part| part / model.size);
        let angle = poses[ends[1].0].1 - poses[ends[0].0].1;
        match *closure {
            PlanarClosure::Pin(_) => rows.extend(gap),
            PlanarClosure::Weld(_, held) => rows.extend([gap[0], gap[1], angle - held]),
            PlanarClosure::Slide(_, along) => {
                let along = turned(along, poses[ends[0].0].1);
                rows.extend([gap[1] * along[0] - gap[0] * along[1], angle]);
            }
        }
    }
    rows.extend(model.followers.iter().map(|follower| {
        let unit = if model.coordinates[follower.joint].turns() { 1.0 } else { model.size };
        (values[follower.joint] - follower.offset - follower.ratio * values[follower.leader]) / unit
    }));
    rows
}

/// The Jacobian by columns, with central differences: it picks coordinates and leads Newton's method, whose residuals are exact.
fn columns(model: &PlanarModel, values: &[f64]) -> Vec<Vec<f64>> {
    if model.closures.is_empty() && model.followers.is_empty() {
        return vec![Vec::new(); values.len()];
    }
    let mut values = values.to_vec();
    let mut columns = Vec::new();
    for index in 0..values.len() {
        let unit = if model.coordinates[index].turns() { 1.0 } else { model.size };
        let (value, step) = (values[index], 1e-6);
        let mut side = |sign: f64| {
            values[index] = value + sign * step * unit;
            residuals(model, &values)
        };
        let (above, below) = (side(1.0), side(-1.0));
        values[index] = value;
        columns.push(above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect());
    }
    columns
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The coordinates that follow, from the last: those whose columns are no combinations of later ones. With an orthonormal basis of their columns.
fn dependent(columns: &[Vec<f64>]) -> Vec<usize> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut chosen = Vec::new();
    for (index, column) in columns.iter().enumerate().rev() {
        let size = dot(column, column).sqrt();
        let mut rest = column.clone();
        for _ in 0..2 {
            for vector in &basis {
                let part = dot(&rest, vector);
                rest.iter_mut().zip(vector).for_each(|(x, y)| *x -= part * y);
            }
        }
        let left = dot(&rest, &rest).sqrt();
        if size > INDEPENDENT && left > INDEPENDENT * size {
            rest.iter_mut().for_each(|part| *part /= left);
            basis.push(rest);
            chosen.push(index);
        }
    }
    chosen
}

/// The least squares solution of sum x_k column_k = wanted, by the normal equations of an orthogonalisation.
fn solve(columns: &[&Vec<f64>], wanted: &[f64]) -> Vec<f64> {
    let rows = wanted.len();
    let matrix = nalgebra::DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row]);
    let wanted = nalgebra::DVector::from_column_slice(wanted);
    let solved = matrix.svd(true, true).solve(&wanted, 1e-10);
    solved.map(|values| values.iter().copied().collect()).unwrap_or_else(|_| vec![0.0; columns.len()])
}

/// Closes the loops from the start that the file gives, by the coordinates that are not independent.
pub fn close(model: &PlanarModel) -> ClosedStart {
    let mut values: Vec<f64> = model.starts.iter().map(|start| start.0).collect();
    let largest = |rows: &[f64]| rows.iter().fold(0.0, |most: f64, row| most.max(row.abs()));
    let mut columns_now = columns(model, &values);
    let chosen = dependent(&columns_now);
    let before = values.clone();
    let units: Vec<f64> =
        model.coordinates.iter().map(|coordinate| if coordinate.turns() { 1.0 } else { model.size }).collect();
    let mut open = largest(&residuals(model, &values));
    for _ in 0..STEPS {
        if open < CLOSED || chosen.is_empty() {
            break;
        }
        let chosen_columns: Vec<&Vec<f64>> = chosen.iter().map(|&index| &columns_now[index]).collect();
        let steps = solve(&chosen_columns, &residuals(model, &values));
        let mut next = values.clone();
        chosen.iter().zip(steps).for_each(|(&index, step)| next[index] -= units[index] * step);
        let left = largest(&residuals(model, &next));
        if !left.is_finite() || left >= open {
            break;
        }
        (values, open) = (next, left);
        columns_now = columns(model, &values);
    }
    let moved = values.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let mut independent = vec![true; values.len()];
    chosen.iter().for_each(|&index| independent[index] = false);
    let mut rates: Vec<f64> = model.starts.iter().map(|start| start.1).collect();
    let mut contradiction = 0.0;
    if !chosen.is_empty() && rates.iter().any(|rate| *rate != 0.0) {
        let given = (0..rates.len()).filter(|&index| independent[index]);
        let mut wanted = vec![0.0; columns_now[0].len()];
        for index in given {
            let rate = rates[index] / units[index];
            wanted.iter_mut().zip(&columns_now[index]).for_each(|(sum, part)| *sum -= rate * part);
        }
        let columns: Vec<&Vec<f64>> = chosen.iter().map(|&index| &columns_now[index]).collect();
        for (&index, rate) in chosen.iter().zip(solve(&columns, &wanted)) {
            contradiction = f64::max(contradiction, (rate * units[index] - rates[index]).abs());
            rates[index] = rate * units[index];
        }
    }
    ClosedStart { values, rates, independent, moved, contradiction, open }
}
