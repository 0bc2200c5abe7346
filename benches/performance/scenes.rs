//! The benchmark scenes.

use std::fmt::Write;
use std::path::Path;

/// The scene of a model.
pub fn model(name: &str) -> String {
    file(&format!("models/{name}/scene.toml"))
}

fn file(path: &str) -> String {
    std::fs::read_to_string(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path)).unwrap_or_default()
}

/// A slider-crank with a spring and damper of 1e9 N/m.
pub fn stiff() -> String {
    file("benches/scenes/stiff_slider_crank.toml")
}

/// All of them: S1 to S6.
pub fn all() -> Vec<(&'static str, String)> {
    vec![
        ("S1 slider-crank, 10 s", model("bench_slider_crank")),
        ("S2 Andrews, 0.03 s", model("andrews")),
        ("S3 one four-bar, 1 s", four_bars(1)),
        ("S3 five four-bars, 1 s", four_bars(5)),
        ("S3 40 four-bars, 1 s", four_bars(40)),
        ("S4 chain of 10, 1 s", chain(10)),
        ("S4 chain of 50, 1 s", chain(50)),
        ("S5 pendulum, 10 s", pendulum()),
        ("S6 stiff slider-crank, 10 s", stiff()),
    ]
}

fn bar(text: &mut String, name: &str, length: f64, mass: f64) {
    let half = length / 2.0;
    let inertia = mass * length * length / 12.0;
    let _ = write!(
        text,
        "[bodies.{name}]\nmass = {mass}\ninertia = {inertia}\npoints = {{ a = [-{half}, 0], b = [{half}, 0] }}\n"
    );
}

fn revolute(text: &mut String, name: &str, first: &str, second: &str) {
    let _ = write!(text, "[joints.{name}]\ntype = \"revolute\"\nbetween = [\"{first}\", \"{second}\"]\n");
}

/// Bars of total length and mass 1 that hang from each other, released at 60 degrees below the horizontal.
pub fn chain(links: usize) -> String {
    let part = 1.0 / links as f64;
    let mut text = String::from("format = 1\nname = \"chain\"\ngravity = [0, -9.81]\n");
    for link in 0..links {
        let before = if link == 0 { "ground".to_string() } else { format!("b{}.b", link - 1) };
        bar(&mut text, &format!("b{link}"), part, part);
        revolute(&mut text, &format!("j{link}"), &before, &format!("b{link}.a"));
    }
    text += "[initial]\n";
    for link in 0..links {
        let _ = write!(text, "\"b{link}.angle\" = \"-60 deg\"\n\"b{link}.omega\" = 0\n");
    }
    text + "[experiment]\nstop = 1\n"
}

/// Upright bars of 1 m and 1 kg side by side, each tied to the next by another, turning at 1 rad/s.
pub fn four_bars(loops: usize) -> String {
    let mut text = String::from("format = 1\nname = \"four_bars\"\ngravity = [0, -9.81]\n[ground.points]\n");
    for pivot in 0..=loops {
        let _ = writeln!(text, "p{pivot} = [{pivot}, 0]");
    }
    for pivot in 0..=loops {
        bar(&mut text, &format!("v{pivot}"), 1.0, 1.0);
        revolute(&mut text, &format!("f{pivot}"), &format!("ground.p{pivot}"), &format!("v{pivot}.a"));
    }
    for tie in 1..=loops {
        bar(&mut text, &format!("h{tie}"), 1.0, 1.0);
        revolute(&mut text, &format!("l{tie}"), &format!("v{}.b", tie - 1), &format!("h{tie}.a"));
        revolute(&mut text, &format!("r{tie}"), &format!("v{tie}.b"), &format!("h{tie}.b"));
    }
    text += "[initial]\n\"v0.angle\" = \"90 deg\"\n\"v0.omega\" = -1\n";
    for pivot in 1..=loops {
        let _ = write!(text, "\"v{pivot}.angle\" = {{ guess = \"90 deg\" }}\n\"h{pivot}.angle\" = {{ guess = 0 }}\n");
    }
    text + "[experiment]\nstop = 1\n"
}

/// A point mass on a massless arm of 1 m, released level.
fn pendulum() -> String {
    String::from(
        "format = 1\nname = \"pendulum\"\ngravity = [0, -9.81]\n[bodies.bob]\nmass = 1\ninertia = 1e-12\npoints = { pin = [-1, 0] }\n",
    ) + "[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob.pin\"]\n[initial]\n\"bob.angle\" = \"180 deg\"\n\"bob.omega\" = 0\n"
        + "[experiment]\nstop = 10\n"
}
