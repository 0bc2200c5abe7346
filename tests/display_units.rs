//! The units of `[display]` and of `--units`, in everything that prints a quantity.

use crate::outside::command;

use std::fs;
use std::path::Path;

use cotree::compile::compile;
use cotree::scene::Scene;
use serde_json::Value;

use command::{code, cotree, stderr, stdout};

const CART: &str = r#"
name = "cart"
gravity = [0, -9.81]
ground.points = { o = [0, 0] }
[parameters]
stiffness = { value = "200 N/m" }
reach = { value = "300 mm" }
[inputs]
shove = { unit = "N" }
[bodies]
cart = { mass = 2 }
arm = { mass = 1, inertia = 0.01, com = [0, "-0.2 m"], points = { o = [0, 0], tip = [0, "-0.4 m"] } }
[joints]
guide = { type = "prismatic", between = ["ground", "cart"], axis = [1, 0] }
pin = { type = "revolute", between = ["cart", "arm.o"] }
[loads]
spring = { type = "spring", between = ["ground.o", "cart"], stiffness = "stiffness", length = "reach", damping = 5 }
push = { type = "force", on = "cart", vector = ["shove", 0] }
[initial]
"cart.x" = "0.5 m"
"arm.angle" = 0.3
[outputs]
variables = ["cart.x", "cart.vx", "arm.angle", "arm.omega", "arm.tip.x", "arm.tip.y", "pin.fy", "energy.total"]
[experiment]
stop = 0.5
step = 0.1
"#;

const DISPLAY: &str = "[display]\nunits = [\"mm\", \"deg\", \"kN\", \"ms\", \"N.mm\", \"kJ\", \"kW\"]\n";
const UNITS: [&str; 2] = ["--units", "mm,deg,kN,ms,N.mm,kJ,kW"];

/// Each unit of SI that other units are asked for instead of.
const SI: [&str; 13] = ["m", "m2", "rad", "s", "N", "N.m", "J", "W", "m/s", "m/s2", "rad/s", "rad/s2", "m/rad"];

fn text(folder: &Path, arguments: &[&str]) -> String {
    let output = cotree(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

fn no_si(text: &str, arguments: &[&str]) {
    let words = text.split(|c: char| !(c.is_alphanumeric() || matches!(c, '.' | '/' | '_')));
    let left: Vec<&str> = words.map(|word| word.trim_end_matches('.')).filter(|word| SI.contains(word)).collect();
    assert!(left.is_empty(), "{arguments:?} has {left:?}\n{text}");
}

/// The scene with and without `[display]`, and its motion in SI as if it were measured.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plain.toml"), CART).unwrap();
    fs::write(folder.path().join("shown.toml"), format!("{CART}{DISPLAY}")).unwrap();
    let measured = ["simulate", "plain.toml", "--variables", "cart.x,arm.angle", "-o", "measured.csv"];
    text(folder.path(), &measured);
    folder
}

/// Each command by the scene's units and by its option says the same, without a unit of SI, and with this in it.
#[test]
fn every_command_shows_its_quantities_in_the_units_that_are_asked_for() {
    let folder = folder();
    let commands: [(&str, &[&str], &[&str]); 15] = [
        ("simulate", &[], &["time [ms],cart.x [mm]", "0.0,500.0,"]),
        ("simulate", &["--summary"], &["at [ms]", "deg/s"]),
        (
            "sweep",
            &["--set", "reach=200 mm,300 mm", "--output", "max(cart.x)", "--output", "max(pin.fy)"],
            &["run,reach [mm],max(cart.x) [mm],max(pin.fy) [kN],failure", "1,300.0,500.0,"],
        ),
        ("fit", &["--to", "measured.csv", "--vary", "reach"], &["300.0000000", "mm"]),
        ("trace", &["arm.tip"], &["time [ms],arm.tip.x [mm],arm.tip.y [mm]", "0.0,618.20808266"]),
        ("equilibrium", &[], &["t = 0 ms", "N.mm"]),
        ("equilibrium", &["--csv"], &["joints,guide.s,300.0,mm"]),
        ("equilibrium", &["--sensitivity", "reach"], &["d/d(reach [mm])"]),
        ("linearize", &["--at", "0.1 s"], &["t = 100 ms", "mm/s"]),
        ("modes", &["--at", "100 ms"], &["t = 100 ms"]),
        ("modes", &["--sensitivity", "reach"], &["reach [mm]"]),
        ("motion", &["--input", "guide", "--range", "100..600 mm"], &["`guide` moves from 100 mm to 600 mm"]),
        ("motion", &["--input", "guide", "--range", "0.1 m..0.6 m", "--output", "arm.tip.x"], &["arm.tip.x [mm]"]),
        (
            "motion",
            &["--input", "pin", "--output", "guide", "--range", "-0.1..0.5", "--point", "arm.tip"],
            &["guide'' [mm/rad2]"],
        ),
        ("motion", &["--input", "guide", "--output", "pin.angle", "--range", "0.1 m..0.6 m"], &["pin.angle' [rad/mm]"]),
    ];
    for (command, more, wanted) in commands {
        let shown = text(folder.path(), &[&[command, "shown.toml"], more].concat());
        no_si(&shown, &[&[command], more].concat());
        for part in wanted {
            assert!(shown.contains(part), "{command} {more:?}: no `{part}` in\n{shown}");
        }
        assert_eq!(
            shown,
            text(folder.path(), &[&[command, "plain.toml"], more, &UNITS].concat()),
            "{command} {more:?}"
        );
        let si = text(folder.path(), &[&[command, "shown.toml"], more, &["--units", "si"]].concat());
        assert!(si != shown && !si.contains("mm"), "{command} {more:?} --units si\n{si}");
    }
    for more in [&["--sensitivity", "reach"][..], &["--sensitivity", "reach", "--summary"]] {
        let shown = text(folder.path(), &[&["simulate", "shown.toml"], more].concat());
        no_si(&shown, more);
    }
}

/// A length by a length and an angle by an angle do not change with their units; others by the ratio of these.
#[test]
fn derivatives_are_in_the_units_of_what_they_are_made_of() {
    let folder = folder();
    let json = text(folder.path(), &["linearize", "shown.toml", "--json"]);
    let si: Value = serde_json::from_str(&json).unwrap();
    let shown = text(folder.path(), &["linearize", "shown.toml"]);
    // The rates of the point come first, then the matrices.
    let row = |start: &str| {
        let matrices = shown.lines().skip_while(|line| !line.trim_start().starts_with("A "));
        let line = matrices.clone().find(|line| line.trim_start().starts_with(start)).expect(start);
        line.split_whitespace().skip(1).map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<f64>>()
    };
    // d(guide.v)/dt: mm/s2 by mm and by deg; arm.tip.x: mm by deg.
    let degree = std::f64::consts::PI / 180.0;
    let a = row("d(guide.v)/dt");
    for (found, wanted) in a.iter().zip([
        si["A"][2][0].as_f64().unwrap(),
        si["A"][2][1].as_f64().unwrap() * 1e3 * degree,
        si["A"][2][2].as_f64().unwrap(),
        si["A"][2][3].as_f64().unwrap() * 1e3 * degree,
    ]) {
        assert!((found - wanted).abs() < 1e-5 * (1e-3 + wanted.abs()), "{found}, not {wanted}\n{shown}");
    }
    let both = text(folder.path(), &["simulate", "shown.toml", "--sensitivity", "reach", "--step", "0.5"]);
    let plain = text(folder.path(), &["simulate", "plain.toml", "--sensitivity", "reach", "--step", "0.5"]);
    let last = |table: &str, name: &str| {
        let place = table.lines().next().unwrap().split(',').position(|head| head.starts_with(name)).expect(name);
        table.lines().last().unwrap().split(',').nth(place).unwrap().parse::<f64>().unwrap()
    };
    for (name, factor) in
        [("d(cart.x)/d(reach)", 1.0), ("d(arm.angle)/d(reach)", 1e-3 / degree), ("d(pin.fy)/d(reach)", 1e-6)]
    {
        let (found, wanted) = (last(&both, name), factor * last(&plain, name));
        assert!((found - wanted).abs() < 1e-12 * (1e-3 + wanted.abs()), "{name}: {found}, not {wanted}");
    }
    assert!(both.contains("d(arm.angle)/d(reach) [deg/(mm)]"), "{both:.600}");
}

/// A sweep that is stopped is continued in the units it was begun in, and only in these.
#[test]
fn a_sweep_with_units_has_its_rows_in_them() {
    let folder = folder();
    let run = |more: &[&str]| {
        let sweep =
            ["sweep", "plain.toml", "--set", "reach=200 mm,300 mm", "--output", "last(cart.x)", "-o", "out.csv"];
        cotree(folder.path(), &[&sweep, more].concat())
    };
    assert_eq!(code(&run(&UNITS)), 0);
    let whole = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert_eq!(code(&run(&[])), 0);
    let si = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let cell =
        |table: &str, row: usize| table.lines().nth(row).unwrap().split(',').nth(2).unwrap().parse::<f64>().unwrap();
    for row in [1, 2] {
        assert!((cell(&whole, row) - 1e3 * cell(&si, row)).abs() < 1e-9, "{whole}\n{si}");
    }
}

/// What follows is shown from the description: the page of an FMU, the page that moves, the units that importers show.
#[test]
fn the_description_of_an_fmu_has_the_units_of_the_scene() {
    let compiled = compile(&Scene::from_toml(&format!("{CART}{DISPLAY}")).unwrap()).unwrap();
    let unit = |name: &str| {
        let variable = compiled.description.variables.iter().find(|own| own.name == name).unwrap();
        variable.unit.display.as_ref().map(|display| display.name.clone())
    };
    for (name, shown) in [
        ("arm.tip.y", "mm"),
        ("arm.omega", "deg/s"),
        ("pin.fy", "kN"),
        ("energy.total", "kJ"),
        ("reach", "mm"),
        ("cart.vx", "mm/s"),
    ] {
        assert_eq!(unit(name).as_deref(), Some(shown), "{name}");
    }
    assert_eq!(unit("stiffness"), None);
    let plain = compile(&Scene::from_toml(CART).unwrap()).unwrap();
    assert_eq!(plain.program, compiled.program, "units change no result");
}
