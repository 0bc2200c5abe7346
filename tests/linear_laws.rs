//! Stiffness and damping are read off the law of a load: whichever component has a linear law, its share of a linear system and its force where its ends come together are those of a spring; a law that is flat there keeps its force.

use crate::support::run::{formulated, model, resolved, started, value};
use cotree::expr::{Order, Symbol};

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
    for law in
        ["-800*length^3", "-800*length*rate", "-800*abs(length)", "if(rate > 0, -3*rate, -5*rate)", "-3*rate*abs(rate)"]
    {
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
