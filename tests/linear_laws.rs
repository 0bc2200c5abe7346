//! Stiffness and damping are read off the law of a load: whichever component has a linear law, its share of a linear system and its force where its ends come together are those of a spring; a law that is flat there keeps its force.

use crate::support::run::{block_with_law, formulated, model, resolved, started, value};
use cotree::expr::{Order, Symbol};
use cotree_fmu::program::Engine;

/// Two masses on a line.
fn on_a_line(load: &str) -> String {
    format!(
        r#"
name = "line"
dimension = 1
[bodies.a]
mass = 1
[bodies.b]
mass = 2
[loads.link]
between = ["a", "b"]
{load}
[loads.anchor]
type = "spring"
between = ["ground", "a"]
stiffness = 300
"#
    )
}

const SPRING: &str = "type = 'spring'\nstiffness = 800\ndamping = 5\nlength = 0.3";

/// The matrices of a linear system and its forces, or why there are none.
fn matrices(load: &str) -> Result<Vec<f64>, String> {
    let mut equations = formulated(&resolved(&on_a_line(load))).equations;
    let vibration = equations.linear().unwrap().map_err(|why| why.to_string())?;
    let entries = [vibration.mass.concat(), vibration.damping.concat(), vibration.stiffness.concat(), vibration.force];
    let at = |symbol: Symbol| match symbol {
        Symbol::Coordinate(_, Order::Position) => 0.4,
        other => panic!("{other:?} is no constant"),
    };
    Ok(equations.system.arena.evaluate(&entries.concat(), &at))
}

#[test]
fn an_actuator_with_a_linear_law_is_a_spring_of_a_linear_system() {
    let spring = matrices(SPRING).unwrap();
    assert!(spring.contains(&240.0) && spring.contains(&1100.0), "{spring:?}");
    for law in ["-800*(length - 0.3) - 5*rate", "240 - 5*rate - 400*length - length*400"] {
        assert_eq!(matrices(&format!("type = 'actuator'\nforce = '{law}'")).unwrap(), spring, "{law}");
    }
}

#[test]
fn other_laws_are_refused_by_name() {
    for law in [
        "-800*length^3",
        "-800*length*rate",
        "-800*abs(length)",
        "if(rate > 0, -3*rate, -5*rate)",
        "-3*rate*abs(rate)",
        "-5*sign(rate)",
        "-5*floor(10*rate)",
        "-800*length - 5*sign(rate)",
        "if(length > 1.2, -40, 0)",
        "-8*length*floor(rate)",
    ] {
        let why = matrices(&format!("type = 'actuator'\nforce = '{law}'")).unwrap_err();
        assert_eq!(why, "the law of `link` is not linear", "{law}");
    }
}

/// A ball on a line through the point to which a load ties it.
fn through_the_centre(load: &str) -> String {
    format!(
        r#"
name = "centre"
[bodies.ball]
mass = 2
inertia = 1
[loads.link]
between = ["ground", "ball"]
{load}
[initial]
"ball.x" = 0.3
[outputs]
variables = ["ball.x", "ball.vx", "link.force"]
"#
    )
}

/// Its motion is 0.3 cos(20 t), which passes the centre, where the direction of the force has no limit.
#[test]
fn an_actuator_with_a_linear_law_acts_through_the_centre() {
    for load in ["type = 'spring'\nstiffness = 800", "type = 'actuator'\nforce = '-800*length'"] {
        let mut instance = started(&model(&through_the_centre(load)), None, 1.0, 1e-10);
        for step in 1..=40 {
            let time = 0.025 * f64::from(step);
            instance.step_to(time).unwrap();
            let error = value(&mut instance, "ball.x") - 0.3 * (20.0 * time).cos();
            assert!(error.abs() < 1e-8, "{load}, {time}: {error:e}");
        }
    }
}

/// The law has no slope at the centre, but a force elsewhere: m x'' = -c x^3 has the energy m v^2/2 + c x^4/4.
#[test]
fn a_law_that_is_flat_at_the_centre_keeps_its_force() {
    let load = "type = 'actuator'\nforce = '-800*length^3'";
    let mut instance = started(&model(&through_the_centre(load)), None, 1.0, 1e-10);
    assert!((value(&mut instance, "link.force") + 800.0 * 0.3_f64.powi(3)).abs() < 1e-12);
    instance.step_to(0.05).unwrap();
    let [x, v] = ["ball.x", "ball.vx"].map(|name| value(&mut instance, name));
    assert!(x < 0.29);
    assert!((v * v + 200.0 * (x.powi(4) - 0.3_f64.powi(4))).abs() < 1e-9, "{x} {v}");
}

/// The block with a law, released 0.33 m from the middle.
fn on_a_spring(law: &str) -> String {
    let rest = "[initial]\n\"block.x\" = 0.33\n[outputs]\nvariables = [\"block.x\", \"block.vx\", \"rub.force\"]\n";
    block_with_law(law, rest)
}

/// The derivatives of these laws are zero, but not the forces. x'' = -100 x + F has the solution x = F/100 + A cos(10 t + phase) in each piece.
#[test]
fn a_law_in_pieces_without_slopes_keeps_its_force() {
    let leaving = (0.6_f64 / 0.73).acos();
    let speed = 7.3 * leaving.sin();
    let free = |angle: f64| [0.2 * angle.cos() - speed / 10.0 * angle.sin(), -2.0 * angle.sin() - speed * angle.cos()];
    let cases = [
        ("-5*sign(rate)", [0.05 + 0.28 * 2.0_f64.cos(), -2.8 * 2.0_f64.sin()]),
        ("if(length > 1.2, -40, 0)", free(2.0 - leaving)),
        ("if(1.2 < length, -40, 0)", free(2.0 - leaving)),
    ];
    for (law, expected) in cases {
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            let mut instance = started(&model(&on_a_spring(law)), engine, 1.0, 1e-9);
            instance.step_to(0.2).unwrap();
            for (name, expected) in ["block.x", "block.vx"].into_iter().zip(expected) {
                let found = value(&mut instance, name);
                assert!((found - expected).abs() < 1e-6, "{law}, {engine:?}: {name} = {found}, not {expected}");
            }
        }
    }
}
