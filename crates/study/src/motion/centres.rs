//! Instant centres: the points about which bodies turn, against the ground and against each other.

use cotree::model::Mechanism;
use cotree::model::Quantity::{Omega, Vx, Vy, X, Y};
use serde::Serialize;

use super::drive::InputTable;
use super::samples::Samples;

/// The instant centres of a body against the ground, for each sample \[m\]; none while it does not turn.
#[derive(Clone, Debug, Serialize)]
pub struct Centres {
    pub body: String,
    pub at: Vec<Option<[f64; 2]>>,
}

/// Those of two bodies against each other; none while they turn alike.
#[derive(Clone, Debug, Serialize)]
pub struct RelativeCentres {
    pub bodies: [String; 2],
    pub at: Vec<Option<[f64; 2]>>,
}

/// How a body moves.
struct MovingBody<'m> {
    name: &'m str,
    /// x, y, vx, vy, omega
    columns: [Samples; 5],
}

impl MovingBody<'_> {
    /// Angular velocity, and the velocity of its point in the origin.
    fn at(&self, index: usize) -> [f64; 3] {
        let [x, y, vx, vy, omega] = self.columns.each_ref().map(|samples| samples.values()[index]);
        [omega, vx + omega * y, vy - omega * x]
    }
}

/// Both kinds; the size of the input's rate is the measure of standing still.
pub fn centres(mechanism: &Mechanism, table: &InputTable, rate: f64) -> (Vec<Centres>, Vec<RelativeCentres>) {
    let bodies: Vec<MovingBody> = mechanism.bodies.iter().filter_map(|body| moving(&body.name, table)).collect();
    let along = |of: &dyn Fn(usize) -> [f64; 3]| (0..table.count()).map(|index| centre(of(index), rate)).collect();
    let centres = |body: &MovingBody| Centres { body: body.name.to_string(), at: along(&|index| body.at(index)) };
    let mut relative = Vec::new();
    for (index, first) in bodies.iter().enumerate() {
        for second in &bodies[index + 1..] {
            let bodies = [first.name, second.name].map(str::to_string);
            let between = |index| {
                let [a, b] = [first.at(index), second.at(index)];
                [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
            };
            relative.push(RelativeCentres { bodies, at: along(&between) });
        }
    }
    (bodies.iter().map(centres).collect(), relative)
}

fn moving<'m>(name: &'m str, table: &InputTable) -> Option<MovingBody<'m>> {
    let [x, y, vx, vy, omega] = [X, Y, Vx, Vy, Omega].map(|quantity| table.get(&quantity.of(name)));
    Some(MovingBody { name, columns: [x?, y?, vx?, vy?, omega?] })
}

/// Where a motion with this angular velocity, and this velocity in the origin, has none: v + omega k x r = 0.
fn centre([omega, vx, vy]: [f64; 3], rate: f64) -> Option<[f64; 2]> {
    (omega.abs() > 1e-12 * rate.abs()).then(|| [-vy / omega, vx / omega])
}
