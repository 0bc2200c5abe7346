//! Linkages whose joint positions follow one after another from the crank angle: four-bars, and six-bars made of two dyads.
//!
//! Each place comes with its derivatives by the angle of the crank and by all dimensions: two circles meet in a dyad, and the differential of that is linear.

use crate::{Point, cross, dot, polar};

/// Most dimensions that a linkage has.
pub(crate) const DIMENSIONS: usize = 20;
/// Most joints and points.
const NODES: usize = 10;

/// How a place follows from others; numbers of dimensions are those of the first one that it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Node {
    /// A pivot in the ground: x and y.
    Ground { at: usize },
    /// A pivot in the ground by its distance and its direction from another one.
    Beside { from: usize, at: usize },
    /// The pin of the crank.
    Crank { pivot: usize, length: usize },
    /// A point of the body from one place to another: along and across.
    Attached { from: usize, to: usize, at: usize },
    /// The pin between two bars, by their lengths; which of the two ways: 1 or -1.
    Dyad { from: usize, to: usize, lengths: [usize; 2], side: f64 },
    /// The end of a rod on a line along x, by the rod's length and the line's y; which of the two ways: 1 or -1.
    Slide { from: usize, rod: usize, offset: usize, side: f64 },
}

/// A place with its derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub at: Point,
    pub by_input: Point,
    pub by: [Point; DIMENSIONS],
}

const ZERO: Point = Point::new(0.0, 0.0);
const NOWHERE: Place = Place { at: ZERO, by_input: ZERO, by: [ZERO; DIMENSIONS] };

/// All places at an angle of the crank.
pub(crate) struct Places {
    pub all: [Place; NODES],
    /// How many derivatives are there: none or those by all dimensions.
    columns: usize,
}

impl Places {
    pub fn new() -> Places {
        Places { all: [NOWHERE; NODES], columns: 0 }
    }
}

/// The cosine of the transmission angle of a dyad, beyond one where it does not close, with its derivatives.
pub(crate) struct Cosine {
    pub value: f64,
    pub by_input: f64,
    pub by: [f64; DIMENSIONS],
}

/// A linkage without its dimensions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chain {
    pub nodes: Vec<Node>,
    /// How many dimensions it has.
    pub dimensions: usize,
}

fn turned(vector: Point) -> Point {
    Point::new(-vector.im, vector.re)
}

impl Chain {
    /// The places at an angle of the crank, with derivatives by the dimensions if they are asked for.
    pub fn place(&self, x: &[f64], input: f64, derivatives: bool, places: &mut Places) {
        places.columns = if derivatives { self.dimensions } else { 0 };
        for (index, node) in self.nodes.iter().enumerate() {
            let columns = places.columns;
            let found = match *node {
                Node::Ground { at } => ground(x, at),
                Node::Beside { from, at } => shifted(x, &places.all[from], at, columns),
                Node::Crank { pivot, length } => crank(x, &places.all[pivot], length, input, columns),
                Node::Attached { from, to, at } => attached(x, &places.all[from], &places.all[to], at, columns),
                Node::Dyad { from, to, lengths, side } => {
                    dyad(x, &places.all[from], &places.all[to], lengths, side, columns)
                }
                Node::Slide { from, rod, offset, side } => slide(x, &places.all[from], [rod, offset], side, columns),
            };
            places.all[index] = found;
        }
    }

    /// The pins of the dyads and of the rods on lines, in order.
    pub fn dyads(&self) -> impl Iterator<Item = usize> + '_ {
        let is_dyad = |node: &Node| matches!(node, Node::Dyad { .. } | Node::Slide { .. });
        self.nodes.iter().enumerate().filter(move |(_, node)| is_dyad(node)).map(|(index, _)| index)
    }

    /// The cosine of the transmission angle between the bars of a dyad, or between a rod and the normal of its line.
    pub fn cosine(&self, x: &[f64], pin: usize, places: &Places) -> Cosine {
        let mut cosine = Cosine { value: 0.0, by_input: 0.0, by: [0.0; DIMENSIONS] };
        if let Node::Slide { from, rod, offset, .. } = self.nodes[pin] {
            let base = &places.all[from];
            cosine.value = (x[offset] - base.at.im) / x[rod];
            cosine.by_input = -base.by_input.im / x[rod];
            (0..places.columns).for_each(|column| cosine.by[column] = -base.by[column].im / x[rod]);
            cosine.by[offset] += 1.0 / x[rod];
            cosine.by[rod] -= cosine.value / x[rod];
        }
        let Node::Dyad { from, to, lengths: [first, second], .. } = self.nodes[pin] else { return cosine };
        let (p, q) = (&places.all[from], &places.all[to]);
        let (a, b, between) = (x[first], x[second], q.at - p.at);
        cosine.value = (a * a + b * b - between.norm_sqr()) / (2.0 * a * b);
        cosine.by_input = -dot(between, q.by_input - p.by_input) / (a * b);
        for column in 0..places.columns {
            cosine.by[column] = -dot(between, q.by[column] - p.by[column]) / (a * b);
        }
        cosine.by[first] += 1.0 / b - cosine.value / a;
        cosine.by[second] += 1.0 / a - cosine.value / b;
        cosine
    }
}

fn ground(x: &[f64], at: usize) -> Place {
    let mut place = Place { at: Point::new(x[at], x[at + 1]), ..NOWHERE };
    place.by[at] = Point::new(1.0, 0.0);
    place.by[at + 1] = Point::new(0.0, 1.0);
    place
}

fn shifted(x: &[f64], from: &Place, at: usize, columns: usize) -> Place {
    let along = polar(1.0, x[at + 1]);
    let mut place = Place { at: from.at + along * x[at], ..NOWHERE };
    place.by[..columns].copy_from_slice(&from.by[..columns]);
    place.by[at] += along;
    place.by[at + 1] += turned(along) * x[at];
    place
}

fn crank(x: &[f64], pivot: &Place, length: usize, input: f64, columns: usize) -> Place {
    let along = polar(1.0, input);
    let mut place = Place { at: pivot.at + along * x[length], by_input: turned(along) * x[length], ..NOWHERE };
    place.by[..columns].copy_from_slice(&pivot.by[..columns]);
    place.by[length] += along;
    place
}

fn attached(x: &[f64], from: &Place, to: &Place, at: usize, columns: usize) -> Place {
    let way = to.at - from.at;
    let size = way.norm().max(f64::MIN_POSITIVE);
    let along = way / size;
    let arm = along * Point::new(x[at], x[at + 1]);
    let moved = |p: Point, q: Point| p + turned(arm) * (cross(along, q - p) / size);
    let mut place = Place { at: from.at + arm, by_input: moved(from.by_input, to.by_input), ..NOWHERE };
    for column in 0..columns {
        place.by[column] = moved(from.by[column], to.by[column]);
    }
    place.by[at] += along;
    place.by[at + 1] += turned(along);
    place
}

/// Where the rod does not reach the line: on the line, straight above or below its start.
fn slide(x: &[f64], from: &Place, [rod, offset]: [usize; 2], side: f64, columns: usize) -> Place {
    let rise = x[offset] - from.at.im;
    let square = x[rod] * x[rod] - rise * rise;
    let mut place = NOWHERE;
    place.by[offset].im = 1.0;
    place.at = Point::new(from.at.re + side * square.max(0.0).sqrt(), x[offset]);
    place.by_input.re = from.by_input.re;
    (0..columns).for_each(|column| place.by[column].re = from.by[column].re);
    if square > 0.0 {
        let share = side / square.sqrt();
        place.by_input.re += share * rise * from.by_input.im;
        (0..columns).for_each(|column| place.by[column].re += share * rise * from.by[column].im);
        place.by[offset].re -= share * rise;
        place.by[rod].re += share * x[rod];
    }
    place
}

/// Where the circles do not meet: the end of the first bar, as near to the second circle as it gets.
fn dyad(x: &[f64], from: &Place, to: &Place, [first, second]: [usize; 2], side: f64, columns: usize) -> Place {
    let (a, b, between) = (x[first], x[second], to.at - from.at);
    let distance = between.norm().max(f64::MIN_POSITIVE);
    let along = between / distance;
    let cosine = (a * a + distance * distance - b * b) / (2.0 * a * distance);
    let mut place = NOWHERE;
    if cosine.abs() < 1.0 {
        let arm = along * Point::new(cosine, side * (1.0 - cosine * cosine).sqrt()) * a;
        place.at = from.at + arm;
        let other = place.at - to.at;
        let across = cross(arm, other);
        // arm . dx = arm . dp + a da, other . dx = other . dq + b db
        let moved = |p: Point, q: Point, da: f64, db: f64| {
            let (u, v) = (dot(arm, p) + a * da, dot(other, q) + b * db);
            Point::new((u * other.im - v * arm.im) / across, (v * arm.re - u * other.re) / across)
        };
        place.by_input = moved(from.by_input, to.by_input, 0.0, 0.0);
        for column in 0..columns {
            let by = |dimension: usize| if column == dimension { 1.0 } else { 0.0 };
            place.by[column] = moved(from.by[column], to.by[column], by(first), by(second));
        }
        return place;
    }
    let arm = along * (a * cosine.signum());
    place.at = from.at + arm;
    let moved = |p: Point, q: Point| p + turned(arm) * (cross(along, q - p) / distance);
    place.by_input = moved(from.by_input, to.by_input);
    for column in 0..columns {
        place.by[column] = moved(from.by[column], to.by[column]);
    }
    place.by[first] += along * cosine.signum();
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Stephenson six-bar, a dyad between the coupler of a four-bar and the ground, with a rod to a slider.
    fn stephenson() -> Chain {
        let nodes = vec![
            Node::Ground { at: 0 },
            Node::Beside { from: 0, at: 2 },
            Node::Crank { pivot: 0, length: 4 },
            Node::Dyad { from: 2, to: 1, lengths: [5, 6], side: 1.0 },
            Node::Attached { from: 2, to: 3, at: 7 },
            Node::Beside { from: 0, at: 9 },
            Node::Dyad { from: 4, to: 5, lengths: [11, 12], side: -1.0 },
            Node::Attached { from: 5, to: 6, at: 13 },
            Node::Slide { from: 7, rod: 15, offset: 16, side: 1.0 },
        ];
        Chain { nodes, dimensions: 17 }
    }

    #[test]
    fn derivatives_are_the_limits_of_differences() {
        let chain = stephenson();
        let x = [0.1, -0.2, 1.0, 0.3, 0.35, 0.9, 0.8, 0.5, 0.4, 1.6, 0.9, 0.9, 1.1, 0.2, 0.3, 1.7, 0.4];
        let at = |x: &[f64], input: f64| {
            let mut places = Places::new();
            chain.place(x, input, true, &mut places);
            places
        };
        let here = at(&x, 0.7);
        let step = 1e-6;
        for pin in chain.dyads() {
            assert!(chain.cosine(&x, pin, &here).value.abs() < 1.0, "dyad {pin} does not close");
        }
        for column in 0..=chain.dimensions {
            let [ahead, behind] = [step, -step].map(|step| {
                let mut other = x;
                let mut input = 0.7;
                if column < chain.dimensions {
                    other[column] += step
                } else {
                    input += step
                }
                (at(&other, input), other)
            });
            for node in 0..chain.nodes.len() {
                let difference = (ahead.0.all[node].at - behind.0.all[node].at) / (2.0 * step);
                let found = here.all[node];
                let exact = if column < chain.dimensions { found.by[column] } else { found.by_input };
                assert!((difference - exact).norm() < 1e-8, "node {node} by {column}: {difference} {exact}");
            }
            for pin in chain.dyads() {
                let value = |(places, x): &(Places, [f64; 17])| chain.cosine(x, pin, places).value;
                let difference = (value(&ahead) - value(&behind)) / (2.0 * step);
                let found = chain.cosine(&x, pin, &here);
                let exact = if column < chain.dimensions { found.by[column] } else { found.by_input };
                assert!((difference - exact).abs() < 1e-8, "dyad {pin} by {column}: {difference} {exact}");
            }
        }
    }
}
