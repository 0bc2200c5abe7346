//! Masses on a line: laid out so that elements side by side do not hide one another.

use super::drawing::{CouplingKind, Drawing, DrawnBody, DrawnCoupling, DrawnJoint, DrawnSpring, Hold};

/// Distance between elements side by side, as a part of the drawing's width.
const PITCH: f64 = 0.05;
/// Places that are nearer to each other than this part of the width hide one another.
const NEAR: f64 = 0.08;

/// Draws masses as blocks on the ground if all springs have room on the line, otherwise as bars with the springs at
/// different heights between them.
pub fn lay_out(drawing: &mut Drawing) {
    gather(drawing);
    spread(drawing);
    stretch_welds(drawing);
    let lanes = lanes(drawing);
    match lanes.iter().max() {
        Some(&highest) if highest > 0 => draw_bars(drawing, &lanes, highest),
        _ => put_on_rails(drawing),
    }
}

/// The ends of springs and joints, each with its body.
fn ends(drawing: &mut Drawing) -> impl Iterator<Item = (&mut [f64; 2], Option<usize>)> {
    let springs = drawing.springs.iter_mut().flat_map(|spring| spring.ends.iter_mut().zip(spring.between));
    springs.chain(drawing.joints.iter_mut().flat_map(|joint| joint.at.iter_mut().zip(joint.between)))
}

/// Draws masses as points: what is fixed to a point of a mass would else cross the mass.
fn gather(drawing: &mut Drawing) {
    let centres: Vec<[f64; 2]> = drawing.bodies.iter().map(|body| body.centre).collect();
    let centre = |body: Option<usize>, at: &mut [f64; 2]| {
        if let Some(centre) = body.and_then(|body| centres.get(body)) {
            *at = *centre;
        }
    };
    ends(drawing).for_each(|(end, body)| centre(body, end));
    drawing.forces.iter_mut().for_each(|force| centre(force.on, &mut force.at));
    drawing.bodies.iter_mut().for_each(|body| body.points.clear());
}

/// Draws masses and walls at equal distances, in their order, if some are in one place: coordinates of a vibrating system often count from rest.
fn spread(drawing: &mut Drawing) {
    let wall =
        |spring: &DrawnSpring| (0..2).find(|&side| spring.between[side].is_none()).map(|side| spring.ends[side][0]);
    let mut walls: Vec<f64> = drawing.springs.iter().filter_map(wall).collect();
    walls.sort_by(f64::total_cmp);
    walls.dedup();
    let bodies = drawing.bodies.iter().enumerate().map(|(index, body)| (body.centre[0], Some(index)));
    let mut places: Vec<(f64, Option<usize>)> = walls.iter().map(|&x| (x, None)).chain(bodies).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return };
    let width = last.0 - first.0;
    if !width.is_finite() || places.windows(2).all(|pair| pair[1].0 - pair[0].0 > NEAR * width) {
        return;
    }
    let step = if width > 0.0 { width } else { 1.0 } / (places.len() - 1) as f64;
    let shift = |x: f64, body: Option<usize>| {
        let is_it = |place: &(f64, Option<usize>)| place.1 == body && (body.is_some() || place.0 == x);
        let rank = places.iter().position(is_it)?;
        Some(first.0 + step * rank as f64 - places[rank].0)
    };
    ends(drawing).for_each(|(end, body)| end[0] += shift(end[0], body).unwrap_or(0.0));
    for at in &mut drawing.ground {
        at[0] += shift(at[0], None).unwrap_or(0.0);
    }
    for force in &mut drawing.forces {
        force.at[0] += shift(force.at[0], force.on).unwrap_or(0.0);
    }
    for (index, body) in drawing.bodies.iter_mut().enumerate() {
        let by = shift(body.centre[0], Some(index)).unwrap_or(0.0);
        body.points.iter_mut().chain([&mut body.centre]).for_each(|point| point[0] += by);
    }
}

/// Draws a weld between separate masses as a rigid link.
fn stretch_welds(drawing: &mut Drawing) {
    let stretched = |joint: &DrawnJoint| joint.kind == Hold::Fixed && joint.at[0] != joint.at[1];
    let (welds, others) = std::mem::take(&mut drawing.joints).into_iter().partition(stretched);
    drawing.joints = others;
    let link =
        |weld: DrawnJoint| DrawnCoupling { name: weld.name, between: weld.between, kind: CouplingKind::Link(weld.at) };
    drawing.couplings.extend(Vec::into_iter(welds).map(link));
}

fn put_on_rails(drawing: &mut Drawing) {
    let rail = |(index, body): (usize, &DrawnBody)| DrawnJoint {
        name: String::new(),
        kind: Hold::Slider([1.0, 0.0]),
        between: [None, Some(index)],
        at: [body.centre; 2],
        open: false,
    };
    drawing.joints.extend(drawing.bodies.iter().enumerate().map(rail));
}

fn draw_bars(drawing: &mut Drawing, lanes: &[usize], highest: usize) {
    let springs = drawing.springs.iter().flat_map(|spring| spring.ends);
    let xs: Vec<f64> = drawing.bodies.iter().map(|body| body.centre).chain(springs).map(|at| at[0]).collect();
    let width = xs.iter().copied().fold(f64::MIN, f64::max) - xs.iter().copied().fold(f64::MAX, f64::min);
    let pitch = if width > 0.0 { PITCH * width } else { 1.0 };
    let top = pitch * (highest + usize::from(!drawing.forces.is_empty())) as f64;
    for body in &mut drawing.bodies {
        let x = body.centre[0];
        body.points = vec![[x, 0.0], [x, top]];
        body.centre = [x, 0.5 * top];
    }
    let fixed = std::mem::take(&mut drawing.ground);
    for (spring, &lane) in drawing.springs.iter_mut().zip(lanes) {
        for end in &mut spring.ends {
            let is_fixed = fixed.contains(end);
            end[1] = pitch * lane as f64;
            if is_fixed {
                drawing.ground.push(*end);
            }
        }
    }
    for (coupling, &lane) in drawing.couplings.iter_mut().zip(&lanes[drawing.springs.len()..]) {
        if let CouplingKind::Link(ends) = &mut coupling.kind {
            ends.iter_mut().for_each(|end| end[1] = pitch * lane as f64);
        }
    }
    for force in &mut drawing.forces {
        force.at[1] = top;
    }
}

/// For each spring, then for each link, the lowest height at which it meets no other.
fn lanes(drawing: &Drawing) -> Vec<usize> {
    let links = drawing.couplings.iter().filter_map(|coupling| <[[f64; 2]; 2]>::try_from(coupling.link_ends()).ok());
    let ends = drawing.springs.iter().map(|spring| spring.ends).chain(links);
    let spans: Vec<[f64; 2]> = ends.map(|ends| ends.map(|end| end[0])).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    let mut order: Vec<usize> = (0..spans.len()).collect();
    order.sort_by(|&a, &b| (spans[a][1] - spans[a][0]).total_cmp(&(spans[b][1] - spans[b][0])));
    let mut taken: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut lanes = vec![0; spans.len()];
    for index in order {
        let [low, high] = spans[index];
        let free = taken.iter().position(|lane| lane.iter().all(|other| high <= other[0] || other[1] <= low));
        let lane = free.unwrap_or_else(|| {
            taken.push(Vec::new());
            taken.len() - 1
        });
        taken[lane].push(spans[index]);
        lanes[index] = lane;
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::component::Glyph;

    fn line(springs: &[[f64; 2]]) -> Drawing {
        let body = |x: f64| DrawnBody { name: "m".into(), points: vec![], centre: [x, 0.0], ..DrawnBody::default() };
        let body_at = |x: f64| (x > 0.0).then(|| x as usize - 1);
        let glyph: Glyph = |_| Vec::new();
        let spring = |ends: &[f64; 2]| DrawnSpring {
            name: "k".into(),
            between: ends.map(body_at),
            ends: ends.map(|x| [x, 0.0]),
            glyph,
            beside: 0.0,
        };
        Drawing {
            bodies: [1.0, 2.0].map(body).to_vec(),
            springs: springs.iter().map(spring).collect(),
            ground: vec![[0.0, 0.0]],
            ..Drawing::default()
        }
    }

    #[test]
    fn springs_in_a_row_stay_on_the_line() {
        let mut drawing = line(&[[0.0, 1.0], [1.0, 2.0]]);
        lay_out(&mut drawing);
        assert_eq!(drawing.joints.len(), 2);
        assert!(drawing.springs.iter().flat_map(|spring| spring.ends).all(|end| end[1] == 0.0));
    }

    #[test]
    fn springs_on_points_of_a_mass_end_at_the_mass() {
        let mut drawing = line(&[[0.0, 1.0], [1.0, 2.0]]);
        drawing.bodies[0].points = vec![[0.7, 0.0], [1.3, 0.0]];
        drawing.springs[0].ends[1] = [1.3, 0.0];
        drawing.springs[1].ends[0] = [0.7, 0.0];
        lay_out(&mut drawing);
        assert_eq!(drawing.springs[0].ends[1], [1.0, 0.0]);
        assert_eq!(drawing.springs[1].ends[0], [1.0, 0.0]);
        assert!(drawing.bodies[0].points.is_empty());
    }

    #[test]
    fn springs_side_by_side_get_their_own_heights() {
        let mut drawing = line(&[[0.0, 2.0], [0.0, 1.0], [1.0, 2.0]]);
        lay_out(&mut drawing);
        let heights: Vec<f64> = drawing.springs.iter().map(|spring| spring.ends[0][1]).collect();
        assert_eq!(heights, [0.1, 0.0, 0.0]);
        assert_eq!(drawing.ground, [[0.0, 0.1], [0.0, 0.0]]);
        assert_eq!(drawing.bodies[1].points, [[2.0, 0.0], [2.0, 0.1]]);
    }

    #[test]
    fn welded_masses_that_are_drawn_apart_are_linked() {
        let mut drawing = line(&[[0.0, 1.0], [0.0, 2.0]]);
        let weld =
            |at| DrawnJoint { name: "w".into(), kind: Hold::Fixed, between: [Some(0), Some(1)], at, open: false };
        drawing.joints.push(weld([[1.0, 0.0]; 2]));
        drawing.bodies[1].centre[0] = 1.0;
        lay_out(&mut drawing);
        assert_eq!(drawing.joints, []);
        assert_eq!(drawing.couplings[0].name, "w");
        // The short spring and the link stand in one row, the long spring above.
        assert_eq!(drawing.couplings[0].link_ends(), [[0.5, 0.0], [1.0, 0.0]]);
        assert_eq!(drawing.springs[1].ends[1], [1.0, 0.05]);
    }

    #[test]
    fn masses_in_one_place_are_drawn_apart() {
        let mut drawing = line(&[[0.0, 1.0], [1.0, 2.0]]);
        for body in &mut drawing.bodies {
            body.centre = [0.0; 2];
        }
        for end in drawing.springs.iter_mut().flat_map(|spring| &mut spring.ends) {
            *end = [0.0; 2];
        }
        lay_out(&mut drawing);
        let centres: Vec<f64> = drawing.bodies.iter().map(|body| body.centre[0]).collect();
        assert_eq!(centres, [0.5, 1.0]);
        let ends: Vec<[f64; 2]> = drawing.springs.iter().map(|spring| spring.ends.map(|end| end[0])).collect();
        assert_eq!(ends, [[0.0, 0.5], [0.5, 1.0]]);
        assert_eq!(drawing.ground, [[0.0, 0.0]]);
    }
}
