//! The direction of a point's path. Where the body rests its path still has one: the limit of its direction on the way there.

use cotree::model::Quantity::{Omega, Vx, Vy, X, Y};

use super::drive::InputTable;
use super::samples::Samples;

/// A point that is slower than this share of its largest speed rests.
const RESTS: f64 = 1e-6;

/// Along the path of a point of a body, in any length: its velocity, or that of the same motion of the body next to a rest. None if it never moves.
pub fn directions(table: &InputTable, [point, body]: [&str; 2]) -> Option<[Samples; 2]> {
    let [x, y, vx, vy] = [X, Y, Vx, Vy].map(|quantity| table.get(&quantity.of(point)));
    let [x, y, vx, vy, omega] = [x?, y?, vx?, vy?, table.get(&Omega.of(body))?];
    let speed = vx.with(&vy, f64::hypot);
    let least = RESTS * speed.values().iter().copied().fold(0.0, f64::max);
    let moving: Vec<usize> = (0..table.count()).filter(|&index| speed.values()[index] > least).collect();
    let count = table.count();
    let apart = |one: usize, other: usize| {
        let way = one.abs_diff(other);
        if table.periodic { way.min(count - way) } else { way }
    };
    let ends = [*moving.first()?, *moving.last()?];
    let at = |index: usize| {
        let next = moving.partition_point(|&moving| moving < index);
        // Of a turn the first one comes after the last one.
        let neighbours = moving[next.saturating_sub(1)..].iter().take(2).chain(&ends);
        let Some(&near) = neighbours.min_by_key(|&&place| apart(place, index)) else { return [f64::NAN; 2] };
        // The body goes on about the same centre, or in the same direction.
        let [rx, ry] = [&x, &y].map(|samples| samples.values()[index] - samples.values()[near]);
        let turn = omega.values()[near];
        [vx.values()[near] - turn * ry, vy.values()[near] + turn * rx]
    };
    let all: Vec<[f64; 2]> = (0..count).map(at).collect();
    Some([0, 1].map(|part| vx.made_of(all.iter().map(|direction| direction[part]).collect())))
}
