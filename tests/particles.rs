//! Bodies without inertia that nothing turns.

use std::f64::consts::PI;

use cotree::scene::{Body, Joint, Load, Parameter, Quantity, Scene};
use cotree_study::analysis::{Stability, Study};

use crate::support::motion::Run;
use crate::support::run::sound;

/// Two balls on rods of 0.3 m between an axle and a sleeve: the centrifugal force is a load.
fn governor(inertia: f64) -> Scene {
    let ball = || Body::new().mass(2.0).inertia(inertia);
    let force = |side: &str| {
        let vector: [Quantity; 2] = [format!("2*speed^2*{side}.x").as_str().into(), 0.0.into()];
        Load::force(side, vector)
    };
    Scene::new("governor")
        .gravity([0.0, -9.81])
        .parameter("speed", Parameter::new(14.0).unit("rad/s"))
        .body("right", ball())
        .body("left", ball())
        .body("sleeve", Body::new().mass(9.0).inertia(0.05))
        .joint("upper_right", Joint::distance("ground", "right", 0.3))
        .joint("upper_left", Joint::distance("ground", "left", 0.3))
        .joint("lower_right", Joint::distance("right", "sleeve", 0.3))
        .joint("lower_left", Joint::distance("left", "sleeve", 0.3))
        .prismatic("spindle", "ground", "sleeve", [0.0, -1.0])
        .load("push_right", force("right"))
        .load("push_left", force("left"))
        .guess("right.x", 0.15)
        .guess("right.y", -0.25)
        .guess("left.x", -0.15)
        .guess("left.y", -0.25)
        .guess("spindle.s", 0.5)
        .output("right.x")
        .stop(1.0)
}

/// h = (m + M) g/(m w^2) below the axle, and r^2 + h^2 = L^2; so dr/dw = 2 h^2/(w r).
#[test]
fn a_governor_of_balls_rests_stable_with_derivatives() {
    let h: f64 = 11.0 * 9.81 / (2.0 * 14.0 * 14.0);
    let radius = (0.09 - h * h).sqrt();
    for inertia in [0.0, 0.02] {
        let mut study = Study::new(&governor(inertia)).unwrap();
        let rest = study.equilibrium().unwrap();
        assert!((rest.value("right.x").unwrap() - radius).abs() < 1e-9, "{rest:?}");
        assert_eq!(rest.stability, Stability::Stable);
        let vibration = study.modes(None).unwrap();
        assert_eq!(vibration.modes.len(), 1, "{:?}", vibration.modes);
        assert!(vibration.modes.iter().all(|mode| !mode.is_free()));
        let changes = study.equilibrium_sensitivities(&["speed".to_owned()]).unwrap();
        let (found, expected) = (changes.derivatives[0][(0, 0)], 2.0 * h * h / (14.0 * radius));
        assert!((found - expected).abs() < 1e-8, "{found}, not {expected}");
    }
}

/// A particle on a rod is a pendulum: with small swings it is back after a period of 2 pi sqrt(L/g) (1 + a^2/16).
#[test]
fn a_particle_on_a_rod_swings_as_with_any_inertia() {
    let pendulum = |inertia: f64| {
        Scene::new("particle")
            .gravity([0.0, -9.81])
            .body("bob", Body::new().mass(0.5).inertia(inertia))
            .joint("rod", Joint::distance("ground", "bob", 0.8))
            .initial("bob.x", 0.8 * 0.02_f64.sin())
            .guess("bob.y", -0.8)
            .initial("bob.vx", 0.0)
            .output("bob.x")
            .output("bob.y")
            .output("bob.angle")
            .stop(3.0)
    };
    let period = 2.0 * PI * (0.8_f64 / 9.81).sqrt() * (1.0 + 0.02_f64.powi(2) / 16.0);
    let (mut particle, mut ball) = (Run::new(&pendulum(0.0)), Run::new(&pendulum(0.3)));
    for share in [0.25, 0.5, 0.8, 1.0] {
        for run in [&mut particle, &mut ball] {
            run.to(share * period);
        }
        let [one, other] = [&mut particle, &mut ball].map(|run| [run.get("bob.x"), run.get("bob.y")]);
        one.iter().zip(other).for_each(|(one, other)| assert!((one - other).abs() < 1e-9, "{one} {other}"));
        assert_eq!(particle.get("bob.angle"), 0.0);
    }
    particle.check("bob.x", 0.8 * 0.02_f64.sin());
}

/// What a load turns, or what carries a point beside its centre, is no particle.
#[test]
fn what_something_turns_needs_an_inertia() {
    let bob = |scene: Scene| scene.body("bob", Body::new().mass(0.5).inertia(0.0).point("side", [0.1, 0.0])).stop(1.0);
    let turned = bob(Scene::new("turned")).load("twist", Load::torque("ground", "bob", 0.3)).output("bob.angle");
    let faults = cotree::compile::compile(&turned).expect_err("nothing says how fast it turns");
    assert!(faults.list.iter().any(|fault| fault.code == "scene::massless"), "{faults}");
    // The rod turns it: its moment about the pin is that of the mass.
    let hung = bob(Scene::new("hung").gravity([0.0, -9.81])).revolute("pin", "ground", "bob.side").output("bob.angle");
    sound(cotree::compile::compile(&hung));
}
