//! Four-bars of every class, places on their curves, and whether one is another one or its cognate.

use std::f64::consts::TAU;

use cotree_synthesis::{Dyad, Linkage, Point, Pose, RandomNumbers, coupler_cognates, polar};

/// A four-bar of a class, its point at the origin of the body.
pub fn of_class(random: &mut RandomNumbers, class: &str) -> Linkage {
    loop {
        let lengths: [f64; 4] = std::array::from_fn(|_| random.between(0.1, 1.0));
        let shortest = (0..4).min_by(|&a, &b| lengths[a].total_cmp(&lengths[b])).expect("four");
        let (sum, longest) = (lengths.iter().sum::<f64>(), lengths.iter().copied().fold(0.0, f64::max));
        let grashof = 2.0 * (lengths[shortest] + longest) < sum;
        let fits = match class {
            "crank" => grashof && shortest < 2,
            "double rocker" => grashof && shortest == 2,
            "rocker" => grashof && shortest == 3,
            _ => !grashof && 2.0 * longest < sum,
        };
        if fits {
            let tracer = (polar(1.5 * random.between(0.0, 1.0).sqrt(), random.between(0.0, TAU)) + 0.5) * lengths[2];
            let zero = Point::new(0.0, 0.0);
            return Linkage {
                first: Dyad::Bar { moving: -tracer, ground: zero, length: lengths[1] },
                second: Dyad::Bar {
                    moving: Point::new(lengths[2], 0.0) - tracer,
                    ground: Point::new(lengths[0], 0.0),
                    length: lengths[3],
                },
            };
        }
    }
}

/// A pose somewhere on the linkage's curve.
pub fn somewhere(linkage: &Linkage, random: &mut RandomNumbers) -> Pose {
    loop {
        if let Some(pose) = linkage.pose(random.between(0.0, TAU), 1.0) {
            return pose;
        }
    }
}

/// Lengths and the distances of the point from both pins.
pub fn signature(linkage: &Linkage) -> [f64; 6] {
    let [a, b, c, d] = linkage.lengths().map(|length| length.expect("a four-bar"));
    let pin = |dyad: &Dyad| if let Dyad::Bar { moving, .. } = dyad { moving.norm() } else { 0.0 };
    [a, b, c, d, pin(&linkage.first), pin(&linkage.second)]
}

pub fn is_it_or_a_cognate(found: &Linkage, known: &Linkage, pose: &Pose) -> bool {
    let [(one, _), (other, _)] = coupler_cognates(known, Point::new(0.0, 0.0), pose).expect("a four-bar");
    let own = signature(found);
    let near = |linkage: &Linkage| {
        let other = signature(linkage);
        (0..6).all(|i| (own[i] - other[i]).abs() < 1e-5)
    };
    [*known, one, other].iter().any(|linkage| near(linkage) || near(&linkage.swapped()))
}

/// Points of a closed curve, one after the other.
pub fn closed(linkage: &Linkage, pose: &Pose, count: usize) -> Vec<Point> {
    let circuit = linkage.circuit(pose, count);
    circuit.into_iter().filter_map(|(input, side)| linkage.pose(input, side)).map(|pose| pose.at).collect()
}

/// Points of a piece of the curve, at inputs that are not quite even: of a fifth to four fifths of a turn, or of most of the way between two dead points.
pub fn piece(linkage: &Linkage, pose: &Pose, count: usize, random: &mut RandomNumbers) -> Vec<Point> {
    let [from, to] = match linkage.range(linkage.input(pose)) {
        None => {
            let from = random.between(0.0, TAU);
            [from, from + TAU * random.between(0.2, 0.8)]
        }
        Some([low, high]) => {
            let (way, share) = (0.98 * (high - low), random.between(0.3, 0.95));
            let from = low + 0.01 * (high - low) + random.between(0.0, (1.0 - share) * way);
            [from, from + share * way]
        }
    };
    let mut places: Vec<f64> = (0..count).map(|index| index as f64 + random.between(-0.3, 0.3)).collect();
    places.sort_by(f64::total_cmp);
    let input = |place: &f64| from + (to - from) * (place / (count - 1) as f64).clamp(0.0, 1.0);
    let side = linkage.side(pose);
    places.iter().filter_map(|place| linkage.pose(input(place), side)).map(|pose| pose.at).collect()
}
