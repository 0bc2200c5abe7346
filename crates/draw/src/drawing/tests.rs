//! What a picture shows, and what it leaves out.

use cotree::component::IconStroke;

use super::*;

/// A slider-crank with everything that can be drawn.
fn slider_crank() -> Drawing {
    let (bearing, pin, wrist, wall) = ([0.0, 0.0], [0.3, 0.4], [1.5, 0.0], [2.5, 0.0]);
    let body = |name: &str, points: &[[f64; 2]], centre| DrawnBody {
        name: name.into(),
        points: points.to_vec(),
        centre,
        ..DrawnBody::default()
    };
    let joint = |name: &str, kind, between, at| DrawnJoint { name: name.into(), kind, between, at, open: false };
    Drawing {
        title: "slider & crank".into(),
        bodies: vec![
            body("crank", &[bearing, pin], [0.15, 0.2]),
            body("rod", &[pin, wrist, [0.9, 0.6]], [0.9, 0.2]),
            body("slider", &[], wrist),
        ],
        ground: vec![bearing, wall],
        ground_shapes: vec![],
        marks: vec![],
        stops: vec![],
        held: vec![],
        couplings: vec![],
        joints: vec![
            joint("main_bearing", Hold::Pin, [None, Some(0)], [bearing; 2]),
            joint("crank_pin", Hold::Pin, [Some(0), Some(1)], [pin; 2]),
            joint("wrist_pin", Hold::Fixed, [Some(1), Some(2)], [wrist; 2]),
            joint("cylinder", Hold::Slider([1.0, 0.0]), [None, Some(2)], [bearing, wrist]),
        ],
        springs: vec![DrawnSpring {
            name: "return_spring".into(),
            between: [Some(2), None],
            ends: [wrist, wall],
            glyph: |length| vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])],
            beside: 0.0,
        }],
        forces: vec![DrawnForce { name: "gas".into(), on: Some(2), at: wrist, direction: [-5.0, 0.0] }],
        turns: vec![Turn { name: "motor".into(), on: None, at: bearing, glyph: None }],
        gaps: Vec::new(),
        targets: vec![Target { name: "path".into(), on: Some(1), at: wrist, direction: Some([0.0, 1.0]) }],
        range: FilmRange::default(),
    }
}

/// Panics if the picture is not well-formed XML.
fn elements(svg: &str) -> usize {
    let mut reader = quick_xml::Reader::from_str(svg);
    let mut count = 0;
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => return count,
            _ => count += 1,
        }
    }
}

#[test]
fn every_part_is_drawn_and_named() {
    let svg = slider_crank().svg();
    assert!(elements(&svg) > 50);
    for name in ["crank", "rod", "slider", "main_bearing", "cylinder", "return_spring", "gas", "motor", "path"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
    assert_eq!(svg, slider_crank().svg());
}

#[test]
fn what_is_not_finite_is_left_out() {
    let mut drawing = slider_crank();
    drawing.bodies[0].centre[0] = f64::NAN;
    drawing.joints[1].at[0][1] = f64::INFINITY;
    drawing.springs[0].ends[1][0] = f64::NAN;
    drawing.forces[0].direction = [f64::NAN; 2];
    drawing.targets[0].direction = Some([f64::NAN; 2]);
    drawing.ground.push([f64::NAN; 2]);
    let svg = drawing.svg();
    elements(&svg);
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn nothing_is_still_a_picture() {
    elements(&Drawing::default().svg());
    let body = DrawnBody { name: "mass".into(), points: vec![], centre: [3.0, 3.0], ..DrawnBody::default() };
    elements(&Drawing { bodies: vec![body], ..Drawing::default() }.svg());
}

/// Radii of circles in the picture, in order.
fn radii(svg: &str) -> Vec<f64> {
    let circles = svg.split("<circle ").skip(1);
    circles.map(|circle| circle.split(" r=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()).collect()
}

/// Mass centre of the crank in its bearing, of the slider in the wrist, which is a weld: their marks lie around the pin, under it.
#[test]
fn a_mass_centre_in_a_joint_is_seen_around_it() {
    let mut drawing = slider_crank();
    let pin = View::fit(&drawing).pin;
    let count =
        |drawing: &Drawing, pins: f64| radii(&drawing.svg()).iter().filter(|r| (*r - pins * pin).abs() < 0.02).count();
    assert_eq!((count(&drawing, 0.72), count(&drawing, 1.45)), (2, 1));
    drawing.bodies[0].centre = drawing.bodies[0].points[0];
    assert_eq!((count(&drawing, 0.72), count(&drawing, 1.45)), (1, 2));
    let radii = radii(&drawing.svg());
    let [mark, joint] = [1.45, 0.85].map(|pins| radii.iter().position(|r| (r - pins * pin).abs() < 0.02).unwrap());
    assert!(mark < joint, "the pin covers the middle of the mark: {radii:?}");
    // Two in one place: the second lies around the first.
    drawing.bodies[1].centre = drawing.bodies[0].centre;
    assert_eq!((count(&drawing, 1.45), count(&drawing, 2.05)), (2, 1));
    let covered =
        |drawing: &Drawing| [0, 1, 2].map(|body| drawing.is_covered(drawing.bodies[body].centre, &View::fit(drawing)));
    assert_eq!(covered(&drawing), [true, true, true]);
    // A slide has no sign that could cover it.
    drawing.joints.retain(|joint| matches!(joint.kind, Hold::Slider(_)));
    assert_eq!(covered(&drawing), [false; 3]);
}

#[test]
fn a_spring_and_a_damper_between_the_same_points_lie_side_by_side() {
    let mut drawing = slider_crank();
    let [a, b] = drawing.springs[0].ends;
    let other = |ends, name: &str| DrawnSpring { name: name.into(), ends, ..drawing.springs[0].clone() };
    let others = [other([a, b], "damper"), other([b, a], "rubber"), other([a, [0.0, 3.0]], "alone")];
    drawing.springs.extend(others);
    drawing.part_springs();
    // What goes from b to a has its left where the others have their right.
    let sides: Vec<f64> = drawing.springs.iter().map(|spring| spring.beside).collect();
    assert_eq!(sides, [-4.4, 0.0, -4.4, 0.0]);
    let sign = drawing.springs[0].strokes(20.0).swap_remove(0);
    assert!(sign.points.iter().all(|point| point[1] == -4.4), "{sign:?}");
    let ends: Vec<[f64; 2]> =
        drawing.springs[0].strokes(20.0).iter().flat_map(|stroke| stroke.points.clone()).collect();
    assert!(ends.contains(&[0.0, 0.0]) && ends.contains(&[20.0, 0.0]), "the feet stand at the points: {ends:?}");
    assert!(drawing.svg().contains(">damper</text>"));
}

#[test]
fn nodes_of_a_graph_are_marked_and_those_in_one_place_share_their_mark() {
    let mut drawing = slider_crank();
    let at = drawing.joints[0].at[0];
    let node = |at, name: &str| Mark::Node { at, name: name.into() };
    drawing.marks =
        vec![node(at, "O"), node(at, "A"), node([1.5, 0.0], "D"), node([f64::NAN, 0.0], "X"), node([90.0, 0.0], "Y")];
    let svg = drawing.svg();
    assert!(svg.contains(">O, A</text>") && svg.contains(">D</text>") && !svg.contains(">X</text>"));
    assert!(!svg.contains(">Y</text>"), "too far away");
}

#[test]
fn a_crowd_is_drawn_without_names() {
    let body = |index: usize| {
        let x = index as f64;
        DrawnBody {
            name: format!("body{index}"),
            points: vec![[x, 0.0], [x + 1.0, 1.0]],
            centre: [x, 0.5],
            ..DrawnBody::default()
        }
    };
    let svg = Drawing { bodies: (0..1000).map(body).collect(), ..Drawing::default() }.svg();
    assert!(!svg.contains("<text"));
}
