//! What a picture shows, and what it leaves out.

use cotree::component::Stroke;

use super::*;

/// A slider-crank with everything that can be drawn.
fn slider_crank() -> Drawing {
    let (bearing, pin, wrist, wall) = ([0.0, 0.0], [0.3, 0.4], [1.5, 0.0], [2.5, 0.0]);
    let body = |name: &str, points: &[[f64; 2]], centre| Body {
        name: name.into(),
        points: points.to_vec(),
        centre,
        ..Body::default()
    };
    let joint = |name: &str, kind, between, at| Joint { name: name.into(), kind, between, at };
    Drawing {
        title: "slider & crank".into(),
        bodies: vec![
            body("crank", &[bearing, pin], [0.15, 0.2]),
            body("rod", &[pin, wrist, [0.9, 0.6]], [0.9, 0.2]),
            body("slider", &[], wrist),
        ],
        ground: vec![bearing, wall],
        marks: vec![],
        couplings: vec![],
        joints: vec![
            joint("main_bearing", Hold::Pin, [None, Some(0)], [bearing; 2]),
            joint("crank_pin", Hold::Pin, [Some(0), Some(1)], [pin; 2]),
            joint("wrist_pin", Hold::Fixed, [Some(1), Some(2)], [wrist; 2]),
            joint("cylinder", Hold::Slider([1.0, 0.0]), [None, Some(2)], [bearing, wrist]),
        ],
        springs: vec![Spring {
            name: "return_spring".into(),
            between: [Some(2), None],
            ends: [wrist, wall],
            glyph: |length| vec![Stroke::open(vec![[0.0, 0.0], [length, 0.0]])],
        }],
        forces: vec![Force { name: "gas".into(), on: Some(2), at: wrist, direction: [-5.0, 0.0] }],
        turns: vec![Turn { name: "motor".into(), on: None, at: bearing, glyph: None }],
        gaps: Vec::new(),
        targets: vec![Target { name: "path".into(), on: Some(1), at: wrist, direction: Some([0.0, 1.0]) }],
        range: Range::default(),
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
    let body = Body { name: "mass".into(), points: vec![], centre: [3.0, 3.0], ..Body::default() };
    elements(&Drawing { bodies: vec![body], ..Drawing::default() }.svg());
}

#[test]
fn a_crowd_is_drawn_without_names() {
    let body = |index: usize| {
        let x = index as f64;
        Body {
            name: format!("body{index}"),
            points: vec![[x, 0.0], [x + 1.0, 1.0]],
            centre: [x, 0.5],
            ..Body::default()
        }
    };
    let svg = Drawing { bodies: (0..1000).map(body).collect(), ..Drawing::default() }.svg();
    assert!(!svg.contains("<text"));
}
