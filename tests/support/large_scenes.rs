//! Scenes of many bodies, whose dependencies must be as exact as those of few.
#![allow(dead_code, reason = "not every test needs every scene")]

use std::fmt::Write;

/// Bars that hang from each other.
fn chain(text: &mut String, name: &str, count: usize, torque: &str) {
    for link in 0..count {
        let before = if link == 0 { "ground".to_owned() } else { format!("{name}{}.end", link - 1) };
        let _ = writeln!(
            text,
            "[bodies.{name}{link}]\nmass = 1.0\ninertia = 0.1\npoints = {{ pin = [-0.5, 0], end = [0.5, 0] }}\n\
             [joints.{name}pin{link}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"{name}{link}.pin\"]"
        );
    }
    let _ = writeln!(text, "[loads.{name}_motor]\ntype = \"torque\"\non = \"{name}0\"\nvalue = \"{torque}\"");
}

/// Two chains of so many bars that hang side by side and have nothing to do with each other.
pub fn two_chains(count: usize) -> String {
    let mut text =
        "format = 1\nname = \"two_chains\"\ngravity = [0, -9.81]\n[inputs]\nleft = 0.1\nright = 0.2\n".to_owned();
    chain(&mut text, "a", count, "left");
    chain(&mut text, "b", count, "right");
    text += "[initial]\n";
    for link in 0..count {
        let _ =
            writeln!(text, "\"a{link}.angle\" = {}\n\"b{link}.angle\" = {}", 0.01 * link as f64, -0.02 * link as f64);
    }
    let last = count - 1;
    text + &format!("[outputs]\nvariables = [\"a{last}.end.x\", \"b{last}.end.ay\", \"apin0.fx\"]\n")
}

/// Arms of three links in the angles of their joints, without gravity: where the first joint stands changes nothing but sines and cosines that
/// cancel.
pub fn arms(count: usize) -> String {
    let mut text =
        "format = 1\nname = \"arms\"\n[coordinates]\npreset = \"joint\"\n[inputs]\ntorque = 0.3\n".to_owned();
    (0..count).for_each(|arm| chain(&mut text, &format!("arm{arm}_"), 3, "torque"));
    text += "[initial]\n";
    for arm in 0..count {
        let angle = 0.1 + 0.01 * arm as f64;
        let _ = writeln!(
            text,
            "\"arm{arm}_pin0.angle\" = {angle}\n\"arm{arm}_pin1.angle\" = 0.7\n\"arm{arm}_pin2.angle\" = 0.4"
        );
    }
    text + "[outputs]\nvariables = [\"arm0_2.end.x\"]\n"
}

/// Parallelograms that do not know of each other: their couplers do not turn.
pub fn parallelograms(count: usize) -> String {
    let mut text =
        "format = 1\nname = \"parallelograms\"\ngravity = [0, -9.81]\n[ground.points]\nfar = [1, 0]\n".to_owned();
    for index in 0..count {
        let bar = |name: &str, points: &str| {
            format!("[bodies.{name}{index}]\nmass = 1.0\ninertia = 0.1\npoints = {points}\n")
        };
        let pin = |name: &str, a: &str, b: &str| {
            format!("[joints.{name}{index}]\ntype = \"revolute\"\nbetween = [\"{a}\", \"{b}\"]\n")
        };
        text += &bar("left", "{ foot = [0, -0.25], head = [0, 0.25] }");
        text += &bar("right", "{ foot = [0, -0.25], head = [0, 0.25] }");
        text += &bar("coupler", "{ left = [-0.5, 0], right = [0.5, 0] }");
        text += &pin("a", "ground", &format!("left{index}.foot"));
        text += &pin("b", "ground.far", &format!("right{index}.foot"));
        text += &pin("c", &format!("left{index}.head"), &format!("coupler{index}.left"));
        text += &pin("d", &format!("right{index}.head"), &format!("coupler{index}.right"));
    }
    text += "[initial]\n";
    for index in 0..count {
        let _ = writeln!(
            text,
            "\"left{index}.angle\" = {}\n\"coupler{index}.angle\" = {{ guess = 0.0 }}\n\"right{index}.angle\" = {{ guess = 0.3 }}",
            0.3 + 0.01 * index as f64
        );
    }
    text + "[outputs]\nvariables = [\"coupler0.angle\", \"coupler1.alpha\", \"a0.fx\", \"coupler3.y\"]\n"
}
