//! Equilibria against statics by hand.

use super::support::*;
use cotree_study::analysis::report::Statics;
use cotree_study::analysis::{AnalysisFailure, Stability};

const G: f64 = 9.81;

/// The equilibrium with everything that holds it.
fn statics(text: &str) -> Statics {
    resting(text, |formulated, _, equilibrium| Statics::new(formulated, &equilibrium.unwrap()))
}

fn value(statics: &Statics, name: &str) -> f64 {
    statics.value(name).unwrap_or_else(|| panic!("{name} is not reported"))
}

fn hanging_slider_crank() -> String {
    scene_of("slider_crank").replace("\"0.6 rad\"", "\"-70 deg\"").replace("-0.19 rad", "0.2 rad")
}

#[test]
fn a_slider_crank_hangs_and_its_reactions_are_its_weights() {
    let found = statics(&hanging_slider_crank());
    assert_eq!(found.stability, Stability::Stable);
    let (crank, rod, slider) = (2.0 * G, 3.0 * G, 1.0 * G);
    for (name, expected) in [
        ("crank.angle", -std::f64::consts::FRAC_PI_2),
        ("rod.angle", (0.5_f64 / 1.5).asin()),
        ("main_bearing.fx", 0.0),
        ("main_bearing.fy", crank + rod / 2.0),
        ("crank_pin.fy", rod / 2.0),
        ("wrist_pin.fy", -rod / 2.0),
        ("cylinder.fn", slider + rod / 2.0),
        ("cylinder.torque", 0.0),
    ] {
        close(name, value(&found, name), expected, 1e-12, 10.0);
    }
}

#[test]
fn trees_do_not_change_equilibrium_and_reactions() {
    let text = hanging_slider_crank().replace("value = 0.0, unit = \"N/m\"", "value = 25.0, unit = \"N/m\"");
    let expected = statics(&text);
    assert!(value(&expected, "return_spring.force").abs() > 1.0);
    for preset in ["absolute", "joint"] {
        let found = statics(&format!("{text}\n[coordinates]\npreset = \"{preset}\"\n"));
        assert_eq!(found.stability, expected.stability);
        for group in expected.groups.iter().filter(|group| group.title != "coordinates") {
            for (name, expected, _) in &group.values {
                close(name, value(&found, name), *expected, 1e-10, 10.0);
            }
        }
    }
}

#[test]
fn the_guess_picks_the_equilibrium_and_tells_stable_from_unstable() {
    let hanging = statics(&PENDULUM.replace("GUESS", "-50 deg"));
    assert_eq!(hanging.stability, Stability::Stable);
    close("hanging", value(&hanging, "arm.angle"), -std::f64::consts::FRAC_PI_2, 1e-12, 1.0);
    close("stiffness", hanging.stiffness[0], 2.0 * G * 0.7, 1e-12, 1.0);
    let upright = statics(&PENDULUM.replace("GUESS", "60 deg"));
    assert_eq!(upright.stability, Stability::Unstable("arm.angle".into()));
    close("upright", value(&upright, "arm.angle"), std::f64::consts::FRAC_PI_2, 1e-12, 1.0);
    close("weight", value(&upright, "pivot.fy"), 2.0 * G, 1e-12, 1.0);
}

/// Level, the stiffness is zero: Newton's method has no direction to go.
#[test]
fn a_level_pendulum_is_let_go_and_found_hanging() {
    let found = statics(&PENDULUM.replace("GUESS", "0 deg"));
    close("hanging", value(&found, "arm.angle").sin(), -1.0, 1e-12, 1.0);
}

/// Upright between a torsion spring k: stiffness k - m g l.
#[test]
fn a_torsion_spring_holds_a_pendulum_upright_if_it_is_stiff_enough() {
    let critical = 2.0 * G * 0.7;
    for (share, stable) in [(0.9, false), (1.1, true)] {
        let stiffness = share * critical;
        let spring = format!(
            "[loads.hinge]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"arm\"]\nstiffness = {stiffness:?}\nangle = \"90 deg\"\n[initial]"
        );
        let found = statics(&PENDULUM.replace("[initial]", &spring).replace("GUESS", "89 deg"));
        close("stiffness", found.stiffness[0], stiffness - critical, 1e-9, 1.0);
        assert_eq!(found.stability == Stability::Stable, stable);
    }
}

#[test]
fn a_mass_on_a_spring_sinks_until_the_spring_carries_it() {
    let found = statics(
        r#"
        format = 1
        name = "hanging"
        gravity = [0, -9.81]
        [bodies.weight]
        mass = 3.0
        inertia = 0.1
        [joints.guide]
        type = "prismatic"
        between = ["ground", "weight"]
        axis = [0, -1]
        [loads.spring]
        type = "spring"
        between = ["ground", "weight"]
        stiffness = 200.0
        length = 0.5
        [initial]
        "guide.s" = 0.4
        "#,
    );
    assert_eq!(found.stability, Stability::Stable);
    close("length", value(&found, "spring.length"), 0.5 + 3.0 * G / 200.0, 1e-12, 1.0);
    close("force", value(&found, "spring.force"), -3.0 * G, 1e-12, 1.0);
    close("normal force", value(&found, "guide.fn"), 0.0, 1e-12, 1.0);
}

#[test]
fn what_falls_is_named() {
    let falling = "format = 1\nname = \"falling\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 1.0\ninertia = 0.1\n";
    resting(falling, |_, _, found| {
        let failure = found.unwrap_err();
        assert!(matches!(failure, AnalysisFailure::NoEquilibrium { .. }), "{failure}");
        let text = failure.to_string();
        assert!(text.contains("`ball.y` (-9.81 m/s2)") && !text.contains("ball.x"), "{text}");
    });
}

/// Four bars of one length, folded into one line, which springs would open either way.
#[test]
fn a_pose_in_which_branches_cross_is_said_to_be_one() {
    let bar = |name: &str| format!("{name} = {{ mass = 1, inertia = 0.1, points = {{ s = [-1, 0], e = [1, 0] }} }}\n");
    let text = format!(
        "name = \"folded\"\nground.points = {{ a = [0, 0], d = [2, 0], k = [1, 0] }}\n[bodies]\n{}{}{}\
         [joints]\na = {{ type = \"revolute\", between = [\"ground.a\", \"b1.s\"] }}\n\
         b = {{ type = \"revolute\", between = [\"b1.e\", \"b2.s\"] }}\n\
         c = {{ type = \"revolute\", between = [\"b2.e\", \"b3.e\"] }}\n\
         d = {{ type = \"revolute\", between = [\"ground.d\", \"b3.s\"] }}\n[loads]\n\
         sp = {{ type = \"spring\", between = [\"ground.k\", \"b2\"], stiffness = 1, length = 3 }}\n\
         ts = {{ type = \"torsion_spring\", between = [\"b1\", \"b2\"], stiffness = 1, angle = 1 }}\n[initial]\n\
         \"b1.angle\" = \"180 deg\"\n\"b2.angle\" = {{ guess = 0 }}\n\"b3.angle\" = {{ guess = \"180 deg\" }}\n",
        bar("b1"),
        bar("b2"),
        bar("b3")
    );
    resting(&text, |_, _, found| {
        let failure = found.unwrap_err();
        assert!(matches!(failure, AnalysisFailure::Crossing { .. }), "{failure}");
        let text = failure.to_string();
        assert!(
            text.contains("singular configuration") && text.contains("`b1.angle` (") && !text.contains("s2"),
            "{text}"
        );
    });
}

/// A falling body beside a stiff spring: its weight is nothing beside the spring's energy, and still no equilibrium.
#[test]
fn a_stiff_spring_does_not_hide_what_falls() {
    let text = format!(
        "{}\n[bodies.ball]\nmass = 1e-3\ninertia = 1e-6\n[loads.stop]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"arm\"]\nstiffness = 1e9\nangle = 0.3\n",
        PENDULUM.replace("GUESS", "20 deg")
    );
    resting(&text, |_, _, found| assert!(found.unwrap_err().to_string().contains("ball.y")));
}

#[test]
fn free_chains_are_neutral() {
    let found = statics(
        "format = 1\nname = \"free\"\ndimension = 1\n[bodies.a]\nmass = 1.0\n[bodies.b]\nmass = 2.0\n\
         [loads.k]\ntype = \"spring\"\nbetween = [\"a\", \"b\"]\nstiffness = 5.0\nlength = 0.2\n",
    );
    assert!(matches!(found.stability, Stability::Neutral(_)), "{:?}", found.stability);
    close("length", value(&found, "k.length"), 0.2, 1e-12, 1.0);
}

/// The driver turns; statics sees it where it starts, and no centrifugal force.
#[test]
fn drivers_are_held_where_they_start() {
    let text = scene_of("double_pendulum")
        .replace("[initial]", "[drivers.motor]\njoint = \"shoulder\"\nangle = \"0.3 + 5*t + 7*t^2\"\n\n[initial]")
        .replace("\"upper.angle\" = \"-20 deg\"", "")
        .replace("\"upper.omega\" = 0.0", "")
        .replace("\"40 deg\"", "\"-60 deg\"");
    let found = statics(&text);
    assert_eq!(found.stability, Stability::Stable);
    close("upper", value(&found, "upper.angle"), 0.3, 1e-12, 1.0);
    close("lower", value(&found, "lower.angle"), -std::f64::consts::FRAC_PI_2, 1e-12, 1.0);
    let moment = (1.0 * 0.5 + 0.7 * 1.0) * G * 0.3_f64.cos();
    close("torque", value(&found, "motor.torque"), moment, 1e-12, 1.0);
    close("bearing", value(&found, "shoulder.fy"), 1.7 * G, 1e-12, 1.0);
}

#[test]
fn without_masses_reactions_are_known_only_without_gravity() {
    let found = statics(&scene_of("quick_return"));
    assert_eq!(found.stability, Stability::Held);
    assert_eq!(value(&found, "motor.torque"), 0.0);
    let heavy = statics(&scene_of("quick_return").replace("[parameters]", "gravity = [0, -9.81]\n[parameters]"));
    assert!(heavy.weightless.is_some() && heavy.value("motor.torque").is_none());
}

/// Masses a and b on springs of 10 and 20 N/m to the ground, with further loads.
fn two_masses(more: &str) -> Statics {
    let spring = |name: &str, stiffness: f64| {
        format!(
            "[bodies.{name}]\nmass = 1.0\n[loads.spring_{name}]\ntype = \"spring\"\nbetween = [\"ground\", \"{name}\"]\n\
             stiffness = {stiffness:?}\nlength = 0.0\n"
        )
    };
    let masses = [spring("a", 10.0), spring("b", 20.0)].concat();
    statics(&format!("format = 1\nname = \"two\"\ndimension = 1\n{masses}{more}"))
}

fn force(name: &str, on: &str, law: &str) -> String {
    format!("[loads.{name}]\ntype = \"force\"\non = \"{on}\"\nvector = [\"{law}\"]\n")
}

#[test]
fn negative_damping_is_unstable_however_stiff_the_spring() {
    assert_eq!(two_masses("").stability, Stability::Stable);
    let damped = two_masses(&force("drag", "b", "-0.1*b.vx"));
    assert_eq!(damped.stability, Stability::Stable);
    let driven = two_masses(&force("push", "b", "0.1*b.vx"));
    assert_eq!(driven.stability, Stability::Unstable("b.x".into()));
    assert!(driven.stiffness.iter().all(|&stiffness| stiffness > 0.0) && driven.by_motion);
}

/// Forces across each other have no potential. With K = [10 -c; c 20] the squares of the frequencies are 15 +- sqrt(25 - c^2).
#[test]
fn loads_without_a_potential_flutter_or_leave_it_open() {
    let crossed = |c: f64| two_masses(&(force("f", "a", &format!("{c}*b.x")) + &force("g", "b", &format!("-{c}*a.x"))));
    assert!(matches!(crossed(6.0).stability, Stability::Unstable(_)), "{:?}", crossed(6.0).stability);
    assert!(matches!(crossed(4.0).stability, Stability::Undecided(_)), "{:?}", crossed(4.0).stability);
}

#[test]
fn a_weld_on_a_line_carries_one_component() {
    let found = statics(
        "format = 1\nname = \"glued\"\ndimension = 1\ngravity = [-9.81]\n[bodies.a]\nmass = 1.0\n[bodies.b]\nmass = 2.0\n\
         [joints.glue]\ntype = \"weld\"\nbetween = [\"a\", \"b\"]\n\
         [loads.k]\ntype = \"spring\"\nbetween = [\"ground\", \"a\"]\nstiffness = 50.0\nlength = 0.2\n",
    );
    close("weight of b", value(&found, "glue.fx").abs(), 2.0 * G, 1e-9, 1.0);
    assert_eq!((found.value("glue.fy"), found.value("glue.torque")), (None, None));
}

/// From this pose the search falls back into the same trap whenever it is let go for a short while; the rest pose is where a run of 60 s comes to.
#[test]
fn a_trap_beside_the_way_is_left() {
    let found = statics(
        "format = 1\nname = \"trap\"\ngravity = [0.3, -9.81]\n[ground.points]\nO = [0.1, -0.05]\nW = [1.9, 0.3]\nG = [0.0, 0.05]\n\
         [bodies.crank]\nmass = 2.0\ninertia = 0.04\ncom = [0.05, 0.02]\npoints = { a = [-0.2, 0], b = [0.2, 0] }\n\
         [bodies.rod]\nmass = 3.0\ninertia = 0.5\npoints = { a = [-0.55, 0.03], b = [0.55, 0], c = [0, 0.2] }\n\
         [bodies.slider]\nmass = 1.0\ninertia = 0.02\npoints = { q = [0.05, 0.1] }\n\
         [bodies.flap]\nmass = 0.7\ninertia = 0.03\ngravity = false\npoints = { h = [-0.2, 0], t = [0.2, 0.01] }\n\
         [joints.bear]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"crank.a\"]\n\
         [joints.pin]\ntype = \"revolute\"\nbetween = [\"crank.b\", \"rod.a\"]\n\
         [joints.wrist]\ntype = \"revolute\"\nbetween = [\"slider\", \"rod.b\"]\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground.G\", \"slider.q\"]\naxis = [1.0, 0.2]\nangle = 0.1\n\
         [joints.hinge]\ntype = \"revolute\"\nbetween = [\"rod.c\", \"flap.h\"]\n\
         [loads.sp]\ntype = \"spring\"\nbetween = [\"ground.W\", \"flap.t\"]\nstiffness = 30.0\ncubic = 12.0\nlength = 0.6\n\
         [loads.tsp]\ntype = \"torsion_spring\"\nbetween = [\"crank\", \"flap\"]\nstiffness = 2.0\ncubic = 0.4\nangle = 0.2\n\
         [initial]\n\"crank.angle\" = 1.2955362697925854\n\"rod.angle\" = { guess = -0.15366210400617908 }\n\
         \"flap.angle\" = -1.4117427702670615\n[outputs]\nvariables = [\"crank.angle\", \"rod.angle\", \"flap.angle\"]\n",
    );
    assert_eq!(found.stability, Stability::Stable);
    for (name, expected) in [("crank.angle", -1.14175), ("rod.angle", 0.60873), ("flap.angle", -0.13952)] {
        close(name, value(&found, name), expected, 2e-5, 1.0);
    }
}
