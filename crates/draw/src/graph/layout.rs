//! Layout of a graph: force-directed near given places, or on a circle. Both are deterministic.

use std::collections::BTreeSet;

use super::Graph;
use crate::alike::Alike;

type Point = [f64; 2];

const ROOM: f64 = 1.0;
const ROUNDS: usize = 600;
/// Beyond so many nodes the local search takes too long.
const LARGE: usize = 60;
/// Beyond so many nodes they stay at their places: a picture of them is not read, and the forces between every two of them would take minutes.
const CROWD: usize = 300;

/// Near given places, with room between the nodes; the datum is at the bottom.
pub fn near(graph: &Graph, places: &[Point]) -> Vec<Point> {
    let count = graph.nodes.len();
    let mut home = scaled(places);
    let low = home.iter().skip(1).map(|place| place[1]).fold(f64::INFINITY, f64::min);
    let middle = home.iter().skip(1).map(|place| place[0]).sum::<f64>() / (count.max(2) - 1) as f64;
    if let Some(datum) = home.first_mut().filter(|_| low.is_finite()) {
        *datum = [middle, low - 1.6 * ROOM];
    }
    let mut now: Vec<Point> = home.iter().enumerate().map(|(index, place)| nudged(*place, index)).collect();
    let rounds = if count > CROWD { 0 } else { ROUNDS };
    for round in 0..rounds {
        let cooling = 1.0 - round as f64 / ROUNDS as f64;
        let mut forces = vec![[0.0; 2]; count];
        repel(&now, &mut forces);
        clear_edges(graph, &now, &mut forces);
        for (index, force) in forces.iter_mut().enumerate() {
            let pull = if index == 0 { 0.5 } else { 0.06 };
            for axis in 0..2 {
                force[axis] += pull * (home[index][axis] - now[index][axis]);
            }
        }
        for edge in &graph.edges {
            attract(&now, edge.ends, &mut forces);
        }
        for (place, force) in now.iter_mut().zip(&forces) {
            for axis in 0..2 {
                place[axis] += (0.3 * force[axis]).clamp(-0.2, 0.2) * cooling;
            }
        }
        let floor = now.iter().skip(1).map(|place| place[1]).fold(f64::INFINITY, f64::min);
        if let Some(datum) = now.first_mut().filter(|_| floor.is_finite()) {
            datum[1] = datum[1].min(floor - 1.2 * ROOM);
        }
    }
    untangle(graph, &home, &mut now);
    now
}

/// The datum at the bottom of a circle, the others around it.
pub fn around(graph: &Graph) -> Vec<Point> {
    let order = circular_order(graph);
    let count = order.len();
    let radius = (0.32 * count as f64).max(0.09 * graph.edges.len() as f64).max(1.0);
    let mut places = vec![[0.0; 2]; count];
    for (position, node) in order.into_iter().enumerate() {
        let angle = -std::f64::consts::FRAC_PI_2 - std::f64::consts::TAU * position as f64 / count as f64;
        places[node] = [1.35 * radius * angle.cosine(), radius * angle.sine()];
    }
    places
}

/// An order with few crossings and short edges: nodes change places while that helps.
fn circular_order(graph: &Graph) -> Vec<usize> {
    let count = graph.nodes.len();
    let mut order: Vec<usize> = (0..count).collect();
    // Each round costs (nodes x edges)^2: many bodies keep their order.
    if count > LARGE {
        return order;
    }
    let pairs = pairs(graph);
    let mut best = tangle(&pairs, &order);
    loop {
        let before = best;
        for a in 1..count {
            for b in a + 1..count {
                order.swap(a, b);
                match tangle(&pairs, &order) {
                    less if less < best => best = less,
                    _ => order.swap(a, b),
                }
            }
        }
        if best == before {
            return order;
        }
    }
}

/// Crossings of chords of the circle, then their lengths; the datum is at the first place.
fn tangle(pairs: &[[usize; 2]], order: &[usize]) -> (usize, usize) {
    let mut position = vec![0; order.len()];
    order.iter().enumerate().for_each(|(index, &node)| position[node] = index);
    let chords: Vec<[usize; 2]> = pairs
        .iter()
        .map(|pair| {
            let [a, b] = pair.map(|node| position[node]);
            [a.min(b), a.max(b)]
        })
        .collect();
    let crosses = |[a, b]: [usize; 2], [c, d]: [usize; 2]| (a < c && c < b && b < d) || (c < a && a < d && d < b);
    let crossings = (0..chords.len()).map(|i| chords[..i].iter().filter(|other| crosses(chords[i], **other)).count());
    let lengths = chords.iter().filter(|[a, _]| *a > 0).map(|[a, b]| (b - a) * (b - a));
    (crossings.sum(), lengths.sum())
}

/// Nodes that have an edge between them, each pair once.
fn pairs(graph: &Graph) -> Vec<[usize; 2]> {
    let pairs = graph.edges.iter().map(|edge| [edge.ends[0].min(edge.ends[1]), edge.ends[0].max(edge.ends[1])]);
    pairs.filter(|[a, b]| a != b).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Local search: moves one node after another to the best of some places around it until the strain no longer decreases.
fn untangle(graph: &Graph, home: &[Point], now: &mut [Point]) {
    if now.len() > LARGE {
        return;
    }
    let pairs = pairs(graph);
    for _ in 0..30 {
        let mut moved = false;
        for node in 1..now.len() {
            let start = now[node];
            let mut best = (strain(&pairs, home, now, node), start);
            for (radius, turn) in
                [0.15, 0.4, 0.8, 1.4, 2.2].into_iter().flat_map(|r| (0..16).map(move |turn| (r, turn)))
            {
                let (sine, cosine) = (f64::from(turn) * std::f64::consts::TAU / 16.0).sine_and_cosine();
                now[node] = [start[0] + radius * cosine, start[1] + radius * sine];
                let strain = strain(&pairs, home, now, node);
                if strain < best.0 - 1e-9 {
                    best = (strain, now[node]);
                    moved = true;
                }
            }
            now[node] = best.1;
        }
        if !moved {
            break;
        }
    }
}

/// The strain of a node's place: crossings, nearness to other nodes and edges, long edges, distance from home.
fn strain(pairs: &[[usize; 2]], home: &[Point], now: &[Point], node: usize) -> f64 {
    let at = now[node];
    let mut strain = 0.12 * (square(at, home[node])) + 20.0 * (1.0 + now[0][1] - at[1]).max(0.0);
    for (other, place) in now.iter().enumerate().filter(|(other, _)| *other != node) {
        strain += 14.0 * (ROOM - square(at, *place).sqrt()).max(0.0).powi(2) * if other == 0 { 2.0 } else { 1.0 };
    }
    let near =
        |point: Point, [a, b]: [usize; 2]| 25.0 * (0.42 * ROOM - distance(point, now[a], now[b])).max(0.0).powi(2);
    for &pair in pairs {
        if !pair.contains(&node) {
            strain += near(at, pair);
            continue;
        }
        let other = pair[0] + pair[1] - node;
        if other != 0 {
            strain += 0.35 * (square(at, now[other]).sqrt() - 1.3 * ROOM).max(0.0).powi(2);
        }
        strain += (0..now.len()).filter(|third| !pair.contains(third)).map(|third| near(now[third], pair)).sum::<f64>();
        let crossed = pairs.iter().filter(|[a, b]| !pair.contains(a) && !pair.contains(b));
        strain += 1.6 * crossed.filter(|[a, b]| cross([at, now[other]], [now[*a], now[*b]])).count() as f64;
    }
    strain
}

fn square(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

fn cross([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |p: Point, q: Point, r: Point| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Distance of a point from the line between two others.
pub fn distance(point: Point, a: Point, b: Point) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let length = (along[0] * along[0] + along[1] * along[1]).max(1e-9);
    let share = ((to[0] * along[0] + to[1] * along[1]) / length).clamp(0.0, 1.0);
    (to[0] - share * along[0]).length_with(to[1] - share * along[1])
}

/// Centred, and so large that the area has room for all nodes.
fn scaled(places: &[Point]) -> Vec<Point> {
    let bodies = places.get(1..).unwrap_or_default();
    let range = |axis: usize| {
        let low = bodies.iter().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
        let high = bodies.iter().map(|place| place[axis]).fold(f64::NEG_INFINITY, f64::max);
        (low, high - low)
    };
    let ((left, width), (low, height)) = (range(0), range(1));
    let size = width.max(height);
    if !(size > 0.0 && size.is_finite()) {
        // All in one place: side by side.
        return (0..places.len()).map(|index| [1.5 * index as f64 * ROOM, 0.0]).collect();
    }
    let scale = 1.15 * ROOM * (places.len() as f64).sqrt().max(3.0) / size;
    places.iter().map(|place| [scale * (place[0] - left), scale * (place[1] - low)]).collect()
}

/// Points in one place move in different directions.
fn nudged([x, y]: Point, index: usize) -> Point {
    let angle = 2.399963 * index as f64; // the golden angle: no two directions are alike
    [x + 0.08 * angle.cosine(), y + 0.08 * angle.sine()]
}

fn repel(now: &[Point], forces: &mut [Point]) {
    for a in 0..now.len() {
        for b in a + 1..now.len() {
            pull(now, [a, b], forces, |distance| -0.8 * (1.5 * ROOM / distance - 1.0).clamp(0.0, 4.0));
        }
    }
}

/// Edges other than those of the datum keep their nodes together.
fn attract(now: &[Point], [a, b]: [usize; 2], forces: &mut [Point]) {
    if a == 0 || b == 0 || a == b {
        return;
    }
    pull(now, [a, b], forces, |distance| 0.08 * (distance - 1.4 * ROOM).max(0.0));
}

/// Two nodes pull each other by a force that depends on their distance.
fn pull(now: &[Point], [a, b]: [usize; 2], forces: &mut [Point], size: impl Fn(f64) -> f64) {
    let (dx, dy) = (now[b][0] - now[a][0], now[b][1] - now[a][1]);
    let distance = dx.length_with(dy).max(1e-3);
    for (axis, component) in [dx, dy].into_iter().enumerate() {
        let force = size(distance) * component / distance;
        forces[a][axis] += force;
        forces[b][axis] -= force;
    }
}

/// No edge runs through a node that is not its own.
fn clear_edges(graph: &Graph, now: &[Point], forces: &mut [Point]) {
    for edge in &graph.edges {
        let [a, b] = edge.ends.map(|node| now[node]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        if square < 1e-9 {
            continue;
        }
        for (node, place) in now.iter().enumerate().skip(1).filter(|(node, _)| !edge.ends.contains(node)) {
            let share = ((place[0] - a[0]) * along[0] + (place[1] - a[1]) * along[1]) / square;
            if !(0.0..=1.0).contains(&share) {
                continue;
            }
            let away = [place[0] - a[0] - share * along[0], place[1] - a[1] - share * along[1]];
            let distance = away[0].length_with(away[1]);
            let push = 0.5 * (0.45 * ROOM - distance).max(0.0);
            // A node exactly on the edge leaves to its left.
            let direction = if distance > 1e-6 {
                away.map(|x| x / distance)
            } else {
                [-along[1], along[0]].map(|x| x / square.sqrt())
            };
            for axis in 0..2 {
                forces[node][axis] += push * direction[axis];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::DrawnEdge;

    fn ring(count: usize) -> Graph {
        let edge = |index: usize| DrawnEdge {
            label: format!("h{index}"),
            name: format!("joint{index}"),
            ends: [index, (index + 1) % count],
            branch: index > 0,
        };
        Graph {
            nodes: (0..count).map(|index| format!("n{index}")).collect(),
            places: Vec::new(),
            edges: (0..count).map(edge).collect(),
        }
    }

    fn closest(places: &[Point]) -> f64 {
        let pairs = (0..places.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        pairs
            .map(|(a, b)| (places[a][0] - places[b][0]).length_with(places[a][1] - places[b][1]))
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn nodes_in_one_place_are_separated_and_the_datum_is_at_the_bottom() {
        for count in [2, 3, 8, 20] {
            let graph = ring(count);
            let crowded: Vec<Point> = (0..count).map(|index| [(index / 2) as f64, 0.0]).collect();
            let places = near(&graph, &crowded);
            assert!(closest(&places) > 0.6 * ROOM, "{count}: {places:?}");
            assert!(places[1..].iter().all(|place| place[1] > places[0][1]), "{places:?}");
        }
    }

    #[test]
    fn nothing_but_the_ground_is_a_graph_too() {
        let alone = Graph { nodes: vec!["ground".into()], ..Graph::default() };
        assert_eq!(near(&alone, &[[0.0; 2]]).len(), 1);
        assert_eq!(around(&alone).len(), 1);
    }

    #[test]
    fn neighbours_stand_side_by_side_on_the_circle() {
        let mut graph = ring(6);
        // The ring visits the nodes in another order than they are numbered.
        let visit = [0, 3, 1, 5, 2, 4];
        graph.edges.iter_mut().for_each(|edge| edge.ends = edge.ends.map(|node| visit[node]));
        let order = circular_order(&graph);
        let position = |node: usize| order.iter().position(|&other| other == node).unwrap();
        for edge in graph.edges.iter().filter(|edge| !edge.ends.contains(&0)) {
            let apart = position(edge.ends[0]).abs_diff(position(edge.ends[1]));
            assert!(apart.min(6 - apart) == 1, "{order:?}");
        }
    }
}
