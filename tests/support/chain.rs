//! Long mechanisms of equal bars.

use cotree::scene::{Body, Scene};

fn bar([mass, inertia]: [f64; 2]) -> Body {
    Body::new().mass(mass).inertia(inertia).point("a", [-0.5, 0.0]).point("b", [0.45, 0.1])
}

/// `n` bars that hang from each other, none in line with the one before.
pub fn chain(n: usize) -> Scene {
    chain_of(n, |_| [1.3, 0.09])
}

/// The same with the mass and the moment of inertia of each bar.
pub fn chain_of(n: usize, properties: impl Fn(usize) -> [f64; 2]) -> Scene {
    let mut scene = Scene::new(&format!("chain_{n}")).gravity([0.0, -9.81]).stop(1.0);
    for i in 0..n {
        let before = if i == 0 { "ground".to_string() } else { format!("b{}.b", i - 1) };
        scene = scene
            .body(&format!("b{i}"), bar(properties(i)))
            .revolute(&format!("j{i}"), &before, &format!("b{i}.a"))
            .initial(&format!("b{i}.angle"), -1.2 + 0.37 * (i % 7) as f64)
            .initial(&format!("b{i}.omega"), 0.5 - 0.11 * (i % 5) as f64);
    }
    scene
}

/// A chain whose last bar is held by the ground too, in the pose of a regular polygon with one side on the ground.
pub fn ring(n: usize) -> Scene {
    let turn = std::f64::consts::TAU / (n + 1) as f64;
    let mut scene = Scene::new(&format!("ring_{n}")).gravity([0.0, -9.81]).stop(1.0).ground_point("end", [1.0, 0.0]);
    for i in 0..n {
        let before = if i == 0 { "ground.end".to_string() } else { format!("b{}.b", i - 1) };
        let side = Body::new().mass(1.3).inertia(0.09).point("a", [-0.5, 0.0]).point("b", [0.5, 0.0]);
        let name = format!("b{i}");
        scene = scene.body(&name, side).revolute(&format!("j{i}"), &before, &format!("b{i}.a"));
        let angle = turn * (i + 1) as f64;
        let held = i + 2 < n;
        scene = if held {
            scene.initial(&format!("{name}.angle"), angle)
        } else {
            scene.guess(&format!("{name}.angle"), angle)
        };
        if held {
            scene = scene.initial(&format!("{name}.omega"), 0.3 - 0.1 * (i % 3) as f64);
        }
    }
    scene.revolute("last", &format!("b{}.b", n - 1), "ground")
}
