//! Cases that are hard for other reasons: stiff, fast, without freedom, without ground, out of reach.

use crate::support::ROOT;
use std::f64::consts::PI;
use std::path::Path;

use cotree::scene::{Body, Driver, Load, Scene};

use super::four_bar::bar;
use super::{Case, FourBar, Law};

/// A slider-crank of common proportions.
pub fn slider_crank(name: &str, omega: f64) -> Scene {
    Scene::new(name)
        .gravity([0.0, -9.81])
        .body("crank", bar(1.0, 0.05))
        .body("rod", bar(0.5, 0.15))
        .body("piston", Body::new().mass(0.4))
        .revolute("bearing", "ground", "crank.a")
        .revolute("pin", "crank.b", "rod.a")
        .revolute("wrist", "rod.b", "piston")
        .prismatic("cylinder", "ground", "piston", [1.0, 0.0])
        .initial("crank.angle", 0.5)
        .initial("crank.omega", omega)
        .guess("rod.angle", -0.16)
}

/// A mass on a spring, damped or not, that a slow pendulum shakes.
pub fn stiff(stiffness: f64, damping: f64, stop: f64) -> Case {
    let scene = Scene::new("stiff")
        .gravity([0.0, -9.81])
        .body("carriage", Body::new().mass(1.0))
        .body("bob", bar(1.0, 0.5))
        .prismatic("rail", "ground", "carriage", [1.0, 0.0])
        .revolute("eye", "carriage", "bob.a")
        .ground_point("wall", [-1.0, 0.0])
        .load("spring", Load::spring("ground.wall", "carriage", stiffness).free(1.0).damping(damping))
        .initial("carriage.x", 0.0)
        .initial("carriage.vx", 0.0)
        .initial("bob.angle", 0.3)
        .initial("bob.omega", 1.0);
    let case = Case::new(if damping > 0.0 { "stiff spring, damped" } else { "stiff spring" }, scene, stop, vec![]);
    if damping > 0.0 { case.driven() } else { case }
}

/// A truss and a drive that together leave no freedom.
pub fn no_freedom() -> Case {
    let scene = Scene::new("truss")
        .ground_point("far", [1.0, 0.0])
        .body("left", bar(1.0, 1.0))
        .body("right", bar(1.0, 1.0))
        .revolute("foot", "ground", "left.a")
        .revolute("top", "left.b", "right.a")
        .revolute("other_foot", "right.b", "ground.far")
        .guess("left.angle", 1.0)
        .guess("right.angle", -1.0);
    let law = Law::Constant { terms: vec![("left.angle".into(), 1.0)], value: PI / 3.0, turns: false };
    Case::new("no freedom", scene, 10.0, vec![law])
}

pub fn free_floating() -> Case {
    let scene = Scene::new("floating")
        .body("one", bar(1.0, 1.0))
        .body("two", bar(2.0, 1.5))
        .revolute("pin", "one.b", "two.a")
        .initial("one.x", 0.0)
        .initial("one.y", 0.0)
        .initial("one.angle", 0.2)
        .initial("two.angle", 1.0)
        .initial("one.vx", 1.0)
        .initial("one.vy", -0.5)
        .initial("one.omega", 3.0)
        .initial("two.omega", -4.0);
    Case::new("free-floating", scene, 20.0, vec![])
}

/// A driver that asks a four-bar to go beyond its reach.
pub fn lock_up() -> Case {
    let bars = FourBar { angle: 1.0, ..FourBar::new(1.0, 0.7, 0.8, 1.2) };
    let [coupler, rocker] = bars.angles();
    let scene = Scene::new("lock_up")
        .ground_point("far", [1.2, 0.0])
        .body("crank", bar(1.0, 1.0))
        .body("coupler", bar(1.0, 0.7))
        .body("rocker", bar(1.0, 0.8))
        .revolute("crank_pivot", "ground", "crank.a")
        .revolute("crank_pin", "crank.b", "coupler.a")
        .revolute("rocker_pin", "coupler.b", "rocker.b")
        .revolute("rocker_pivot", "rocker.a", "ground.far")
        .driver("motor", Driver::angle("crank_pivot", "1 + t"))
        .guess("coupler.angle", coupler)
        .guess("rocker.angle", rocker);
    Case::new("lock-up", scene, 3.0, vec![]).driven().refused("lock")
}

/// The same with a load that swings on the rocker, so that there is freedom left.
pub fn lock_up_with_freedom() -> Case {
    let mut case = lock_up();
    case.scene = case
        .scene
        .body("bob", bar(0.3, 0.4))
        .revolute("hook", "rocker.b", "bob.a")
        .initial("bob.angle", 0.0)
        .initial("bob.omega", 0.0);
    case
}

pub fn andrews() -> Case {
    let path = Path::new(ROOT).join("models/andrews/scene.toml");
    let scene = Scene::read(&path).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Case::new("Andrews' mechanism", scene, 0.03, vec![]).driven()
}
