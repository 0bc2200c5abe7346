//! The C sources for real-time targets: they compile without a warning, keep to their rules, and move as the runtime does.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::ROOT;

const WARNINGS: [&str; 8] =
    ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wdouble-promotion", "-Wvla"];

fn cotree(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cotree")).args(arguments).output().unwrap()
}

fn scene(model: &str) -> PathBuf {
    Path::new(ROOT).join("models").join(model).join("scene.toml")
}

/// The sources of a scene, in a folder; or why there are none.
fn sources(scene: &Path, folder: &Path, step: &str) -> Result<PathBuf, String> {
    sources_with(scene, folder, step, &[])
}

/// The same with options of the solver.
fn sources_with(scene: &Path, folder: &Path, step: &str, options: &[&str]) -> Result<PathBuf, String> {
    let file = folder.join("model.c");
    let export = ["export", scene.to_str().unwrap(), "--c", file.to_str().unwrap(), "--step", step];
    let output = cotree(&[&export, options].concat());
    if output.status.success() { Ok(file) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// Compiles with all warnings, as C and as C++.
fn compile(file: &Path) {
    let folder = file.parent().unwrap();
    let object = folder.join("model.o");
    let mut gcc = Command::new("gcc");
    gcc.args(WARNINGS).args(["-O1", "-c", "-o"]).arg(&object).arg(file);
    let mut gpp = Command::new("g++");
    gpp.args(["-x", "c++", "-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror", "-c", "-o"])
        .arg(&object)
        .arg(file);
    for command in [&mut gcc, &mut gpp] {
        let output = match command.output() {
            // A machine with gcc alone; .ci/run installs it.
            Err(error) if error.kind() == ErrorKind::NotFound && command.get_program() == "g++" => {
                println!("skipped: g++ is not installed");
                continue;
            }
            output => output.unwrap(),
        };
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// The values at the end of so many steps, or the message of the step that failed.
fn run(file: &Path, coordinates: usize, steps: u32) -> Result<Vec<f64>, String> {
    run_with(file, "run.c", &[&format!("-DCOORDINATES={coordinates}")], steps)
}

/// What a program of tests/c_sources prints of a model.
fn run_with(file: &Path, main: &str, definitions: &[&str], steps: u32) -> Result<Vec<f64>, String> {
    let program = file.with_extension("run");
    let main = Path::new(ROOT).join("tests/c_sources").join(main);
    let name = format!("-DMODEL_FILE=\"{}\"", file.display());
    let output = Command::new("gcc")
        .args(["-std=c99", "-O1", &name])
        .args(definitions)
        .arg("-o")
        .arg(&program)
        .arg(main)
        .arg("-lm")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(program).arg(steps.to_string()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        return Err(text);
    }
    Ok(text.split_whitespace().map(|value| value.parse().unwrap()).collect())
}

/// Coordinates after two seconds by the runtime, in their order: each value, then its rate.
fn reference(scene: &Path, variables: &str) -> Vec<f64> {
    let scene = scene.to_str().unwrap();
    let limits = ["--stop", "2 s", "--step", "2 s", "--tolerance", "1e-11"];
    let output = cotree(&[&["simulate", scene, "--variables", variables][..], &limits].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().last().unwrap().split(',').skip(1).map(|value| value.parse().unwrap()).collect()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

fn error(model: &str, variables: &str, step: &str, steps: u32) -> f64 {
    largest(&end(&scene(model), variables, step, steps, &[]), &reference(&scene(model), variables))
}

fn end(scene: &Path, variables: &str, step: &str, steps: u32, options: &[&str]) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let file = sources_with(scene, folder.path(), step, options).unwrap();
    run(&file, variables.split(',').count() / 2, steps).unwrap()
}

#[test]
fn the_error_at_a_millisecond_is_small_and_of_fourth_order() {
    let cases = [("bench_slider_crank", SLIDER_CRANK, 1e-6), ("cart_pole", CART_POLE, 1e-9)];
    for (model, variables, most) in cases {
        let found = error(model, variables, "1 ms", 2000);
        assert!(found <= most, "{model}: {found:e}");
        let halved = error(model, variables, "0.5 ms", 4000);
        assert!((10.0..=30.0).contains(&(found / halved)), "{model}: {found:e} {halved:e}");
    }
}

const SLIDER_CRANK: &str = "crank.angle,crank.omega,rod.angle,rod.omega";
const FOUR_BAR: &str = "crank.angle,crank.omega,coupler.angle,coupler.omega,rocker.angle,rocker.omega";
const CART_POLE: &str = "rail.s,rail.v,pole.angle,pole.omega";

#[test]
fn taylor_series_of_order_8_are_right_at_five_milliseconds() {
    let of = |variables: &str, step: &str, steps: u32, model: &str| {
        largest(&end(&scene(model), variables, step, steps, &["--order", "8"]), &reference(&scene(model), variables))
    };
    let long = of(SLIDER_CRANK, "5 ms", 400, "bench_slider_crank");
    let short = of(SLIDER_CRANK, "2.5 ms", 800, "bench_slider_crank");
    assert!(long < 1e-7 && long / short > 100.0, "{long:e} {short:e}");
    let four_bar = of(FOUR_BAR, "5 ms", 400, "four_bar");
    assert!(four_bar < 2e-6, "{four_bar:e}");
    let cart_pole = of(CART_POLE, "5 ms", 400, "cart_pole");
    assert!(cart_pole < 1e-10, "{cart_pole:e}");
}

#[test]
fn a_series_that_does_not_converge_within_the_step_is_an_error() {
    for (model, coordinates) in [("bench_slider_crank", 2), ("four_bar", 3), ("motor_four_bar", 3)] {
        let folder = tempfile::tempdir().unwrap();
        let file = sources_with(&scene(model), folder.path(), "10 ms", &["--order", "8"]).unwrap();
        let ended = run(&file, coordinates, 200);
        assert!(ended.as_ref().is_err_and(|failed| failed.contains("does not converge")), "{model}: {ended:?}");
    }
}

#[test]
fn a_law_without_a_series_at_the_start_is_refused_for_order_8() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("root.toml");
    fs::write(&scene, LAWS.replace("(roots + angles + powers + sides)", "sqrt(t/1[s])")).unwrap();
    let refused = sources_with(&scene, folder.path(), "1 ms", &["--order", "8"]).unwrap_err();
    assert!(refused.contains("infinite slope") && refused.contains("`wheel.angle`"), "{refused}");
    assert!(sources(&scene, folder.path(), "1 ms").is_ok());
    // A moment later it has one.
    fs::write(&scene, LAWS.replace("(roots + angles + powers + sides)", "sqrt(t/1[s] + 0.1)")).unwrap();
    assert!(sources_with(&scene, folder.path(), "1 ms", &["--order", "8"]).is_ok());
}

#[test]
fn single_precision_is_as_near_to_double_as_compensated_sums_allow() {
    for (model, variables) in [("bench_slider_crank", SLIDER_CRANK), ("four_bar", FOUR_BAR), ("cart_pole", CART_POLE)] {
        for order in ["4", "8"] {
            let of = |real| end(&scene(model), variables, "0.5 ms", 4000, &["--order", order, "--real", real]);
            let apart = largest(&of("float"), &of("double"));
            assert!(apart < 5e-5, "{model}, order {order}: {apart:e}");
        }
    }
}

/// Every function of laws, of what moves.
const LAWS: &str = r#"
name = "laws"
gravity = [0, 0]
[parameters]
square = 2
[signals]
x = { value = "1*wheel.angle" }
y = { value = "wheel.omega*1[s]" }
z = { value = "t/1[s]" }
roots = "-3*x - 0.2*atan(2*x) - 0.1*tanh(3*y) + 0.3*exp(-x^2) + 0.1*log(2 + x/3) + 0.2*sqrt(1 + y^2)"
angles = "0.3*asin(0.5*sin(z)) - 0.4*acos(0.2*x) + 0.2*atan2(x, 9 + y) + 0.1*tan(0.3*cos(y))"
powers = "(1.5 + 0.1*sin(x))^1.7 - 0.3*(2 + 0.1*cos(x))^(0.5 + 0.1*sin(z)) - 0.05*y^square/(4 + cos(x))"
sides = "0.1*min(x, 50 + z) + 0.1*max(y, -60 + x) + 0.1*if(z > -1, sin(2*z), z) + 0.1*abs(3 + sin(x)) + floor(0.1 + z/100)"
[bodies.wheel]
mass = 1.3
inertia = 0.9
points = { hub = [0, 0] }
[joints.axle]
type = "revolute"
between = ["ground", "wheel.hub"]
[loads.spring]
type = "torque"
between = ["ground", "wheel"]
value = "(roots + angles + powers + sides)*1[N.m]"
[initial]
"wheel.angle" = 0.4
"wheel.omega" = 0
[experiment]
stop = "2 s"
step = "10 ms"
"#;

#[test]
fn series_of_every_function_of_laws_are_right() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("laws.toml");
    fs::write(&file, LAWS).unwrap();
    let by_series = end(&file, "wheel.angle,wheel.omega", "5 ms", 400, &["--order", "8"]);
    let apart = largest(&by_series, &reference(&file, "wheel.angle,wheel.omega"));
    assert!(apart < 1e-9, "{apart:e}");
}

#[test]
fn loops_are_closed_after_every_step() {
    for (real, residual) in [("double", "1e-12"), ("float", "1e-6")] {
        for (model, rows, order) in [
            ("bench_slider_crank", 1, "4"),
            ("bench_slider_crank", 1, "8"),
            ("four_bar", 2, "4"),
            ("four_bar", 2, "8"),
            ("motor_four_bar", 2, "4"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let options = ["--real", real, "--order", order];
            let file = sources_with(&scene(model), folder.path(), "1 ms", &options).unwrap();
            let definitions = [
                "-DCOORDINATES=1".to_owned(),
                format!("-DCONSTRAINT={model}_constraint"),
                format!("-DROWS={rows}"),
                format!("-DREAL={real}"),
                format!("-DRESIDUAL={residual}"),
            ];
            let definitions: Vec<&str> = definitions.iter().map(String::as_str).collect();
            let end = run_with(&file, "run.c", &definitions, 2000);
            assert!(end.is_ok(), "{model}, {real}, order {order}: {end:?}");
        }
    }
}

/// A cart that a force moves, and one that a driver accelerates, with a pendulum.
const CART: &str = r#"
name = "cart"
gravity = [0, 0]
[parameters]
gain = { value = 1, tunable = true }
[inputs]
pull = { start = 1, unit = "N" }
[bodies.cart]
mass = 2
inertia = 0.1
points = { at = [0, 0] }
[joints.rail]
type = "prismatic"
between = ["ground", "cart.at"]
axis = [1, 0]
[loads.push]
type = "force"
on = "cart.at"
vector = ["gain*pull", 0]
[experiment]
stop = "1 s"
step = "1 ms"
"#;
const ACCELERATED: &str = r#"
name = "accelerated"
gravity = [0, 0]
[inputs]
pull = { start = 0, unit = "m/s^2" }
[bodies.cart]
mass = 2
inertia = 0.1
points = { at = [0, 0] }
[bodies.pendulum]
mass = 1
inertia = 0.1
points = { pin = [0, 0.5] }
[joints.rail]
type = "prismatic"
between = ["ground", "cart.at"]
axis = [1, 0]
[joints.pin]
type = "revolute"
between = ["cart.at", "pendulum.pin"]
[drivers.push]
joint = "rail"
displacement = { input = "pull", as = "acceleration" }
[experiment]
stop = "1 s"
step = "1 ms"
"#;

#[test]
fn what_is_set_between_steps_acts_from_the_next_step_on() {
    let rates = |text: &str, printed: &str, options: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        fs::write(&file, text).unwrap();
        let file = sources_with(&file, folder.path(), "1 ms", options).unwrap();
        run_with(&file, "between_steps.c", &[printed], 0).unwrap()
    };
    for order in ["4", "8"] {
        let pushed = rates(CART, "-DPRINTED=0", &["--order", order]);
        assert!(largest(&pushed, &[0.5e-3, 2.0e-3, 5.0e-3, 8.0e-3]) < 1e-14, "{pushed:?}");
        // m L / (I + m L^2) times the acceleration.
        let turned = rates(ACCELERATED, "-DPRINTED=0", &["--order", order]);
        let each = 0.5 / 0.35 * 3e-3;
        let expected = [0.0, each, 2.0 * each, 3.0 * each];
        let sizes: Vec<f64> = turned.iter().map(|rate| rate.abs()).collect();
        assert!(largest(&sizes, &expected) < 1e-6, "{turned:?} {expected:?}");
    }
}

/// An importer that gives no array, or one that is too short, gets an error; the process goes on.
#[test]
fn arrays_that_are_not_there_are_errors() {
    for version in ["2", "3"] {
        let folder = tempfile::tempdir().unwrap();
        let fmu = folder.path().join("model.fmu");
        let [place, archive] = [scene("pendulum"), fmu.clone()].map(|path| path.to_str().unwrap().to_owned());
        let output = cotree(&["export", &place, "--sources", "--step", "1 ms", "--fmi", version, "-o", &archive]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        zip::ZipArchive::new(std::fs::File::open(&fmu).unwrap()).unwrap().extract(folder.path()).unwrap();
        let sources = folder.path().join("sources");
        let file = sources.join(format!("fmi{version}.c"));
        let text = std::fs::read_to_string(&file).unwrap();
        let token = text
            .split("_is_text(")
            .filter_map(|call| call.split_once(", \""))
            .find(|(name, _)| ["guid", "token"].contains(name));
        let token = token.unwrap().1.split_once('"').unwrap().0;
        let definitions =
            [format!("-DFMI={version}"), format!("-DFMI_FILE=\"{}\"", file.display()), format!("-DTOKEN=\"{token}\"")];
        let program = folder.path().join("run");
        let output = Command::new("gcc")
            .args(["-std=c99", "-O1", "-I"])
            .arg(&sources)
            .args(definitions)
            .arg("-o")
            .arg(&program)
            .arg(Path::new(ROOT).join("tests/c_sources/arrays.c"))
            .arg("-lm")
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let output = Command::new(program).output().unwrap();
        assert!(
            output.status.success(),
            "FMI {version}: {:?} {}",
            output.status,
            String::from_utf8_lossy(&output.stdout)
        );
    }
}

#[test]
fn sources_keep_to_their_rules_and_compile_without_warnings() {
    let of = ["four_bar", "motor_four_bar", "vibration", "metronome"];
    let all = [&[][..], &["--real", "float"], &["--order", "8"], &["--order", "8", "--real", "float"]];
    for (model, options) in of.iter().flat_map(|model| all.map(|options| (model, options))) {
        check_sources(&scene(model), options);
    }
    check_sources(&scene("klann"), &["--real", "float"]);
}

fn check_sources(scene: &Path, options: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let file = sources_with(scene, folder.path(), "1 ms", options).unwrap();
    let text = fs::read_to_string(&file).unwrap();
    check_text(&text);
    let is_single = options.contains(&"float");
    assert!(!(is_single && text.lines().any(|line| line.contains("double "))));
    compile(&file);
}

/// No allocation, no recursion, no loop without a bound, no function pointers, no variables but those of the caller.
fn check_text(text: &str) {
    for word in [
        "malloc", "calloc", "realloc", "free(", "goto", "setjmp", "while (", "do {", "for (;;", "(*", "alloca(",
        "<stdlib", "<stdio",
    ] {
        assert!(!text.contains(word), "`{word}`");
    }
    assert!(text.lines().filter(|line| line.starts_with("#include")).eq(["#include <math.h>"]));
    let variables = text.lines().map(str::trim_start).filter(|line| line.starts_with("static ") && !line.contains('('));
    variables.for_each(|line| assert!(line.starts_with("static const "), "{line}"));
    let defined: Vec<(&str, &str)> = text.split("\n}\n").filter_map(function).collect();
    assert!(defined.len() > 8, "{}", defined.len());
    // What stands behind is called by the start only: nothing calls itself, not by others either.
    for (index, (name, body)) in defined.iter().enumerate().filter(|(_, (name, _))| !name.ends_with("_reset")) {
        for (behind, _) in &defined[index..] {
            assert!(!body.contains(&format!("{behind}(")), "`{name}` calls `{behind}`");
        }
    }
}

/// The name of the function with which a text ends, and what stands in it.
fn function(text: &str) -> Option<(&str, &str)> {
    let (head, body) = text.rsplit_once(")\n{\n")?;
    let name = head.lines().last()?.split('(').next()?;
    Some((name.rsplit([' ', '*']).next()?, body))
}

#[test]
fn what_presses_and_steps_that_are_too_long_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = sources(&scene("end_stop"), folder.path(), "1 ms").unwrap_err();
    assert!(refused.contains("unilateral constraint") && refused.contains("scene.toml:"), "{refused}");
    // Another inductance: a pole a hundred times faster.
    let text = fs::read_to_string(scene("motor_four_bar")).unwrap();
    let line = text.lines().find(|line| line.trim_start().starts_with("inductance")).unwrap();
    let stiff = folder.path().join("stiff.toml");
    fs::write(&stiff, text.replace(line, "inductance = \"0.02 mH\"")).unwrap();
    let refused = sources(&stiff, folder.path(), "1 ms").unwrap_err();
    assert!(refused.contains("too long for `motor.current`") && refused.contains("--substeps"), "{refused}");
}

/// A sampled damper whose first value is a formula: what is computed of it once for all steps is that of the start, too.
const SAMPLED_DAMPER: &str = r#"
format = 1
name = "damper"
[parameters]
opening = 90
[bodies.block]
mass = 2.0
inertia = 0.1
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[sampled.valve]
period = "20 ms"
[sampled.valve.values]
drag = { start = "opening*(1 + 0*rail.s)", next = "drag", unit = "1" }
[loads.oil]
type = "force"
on = "block"
vector = ["-(drag^2)*rail.v*1[N.s/m]", 0]
[initial]
"rail.v" = "1 m/s"
[outputs]
variables = ["rail.s"]
"#;

#[test]
fn poles_at_the_start_follow_from_the_first_sampled_values() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("damper.toml");
    fs::write(&file, SAMPLED_DAMPER).unwrap();
    let refused = sources(&file, folder.path(), "1 ms").unwrap_err();
    // -drag^2/m
    assert!(refused.contains("a pole at -4050.0000 /s") && refused.contains("`--substeps 2`"), "{refused}");
    assert!(sources(&file, folder.path(), "0.5 ms").is_ok());
}

#[test]
fn the_page_of_the_refusal_shows_what_export_says() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/faults/export_sources.md")).unwrap();
    let block = |kind: &str| page.split(kind).nth(1).unwrap().split("```").next().unwrap().trim();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), block("```toml\n")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cotree"));
    let output = command.current_dir(folder.path()).args(["export", "scene.toml", "--sources"]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr).trim(), block("```text\n"));
}

/// A parallelogram that turns evenly and ends a step on its dead point: there its loop does not determine the rates.
const PARALLELOGRAM: &str = r#"
name = "parallelogram"
gravity = [0, 0]
[ground.points]
left = [0, 0]
right = [0.7, 0]
[bodies.front]
mass = 2
inertia = 0.05
points = { foot = [0, 0], head = [0.3, 0] }
[bodies.rear]
mass = 2
inertia = 0.05
points = { foot = [0, 0], head = [0.3, 0] }
[bodies.bridge]
mass = 1
inertia = 0.02
points = { one = [0, 0], two = [0.7, 0] }
[joints.first]
type = "revolute"
between = ["ground.left", "front.foot"]
[joints.second]
type = "revolute"
between = ["front.head", "bridge.one"]
[joints.third]
type = "revolute"
between = ["bridge.two", "rear.head"]
[joints.fourth]
type = "revolute"
between = ["ground.right", "rear.foot"]
[initial]
"front.angle" = -0.4
"front.omega" = 2
"rear.angle" = { guess = -0.4 }
"bridge.angle" = { guess = 0 }
[experiment]
stop = "1 s"
step = "1 ms"
"#;

/// How far from evenly it has turned 0.21 s later, or what failed.
fn turned(begin: f64) -> Result<f64, String> {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("parallelogram.toml");
    fs::write(&scene, PARALLELOGRAM.replace("-0.4", &format!("{begin:?}"))).unwrap();
    let file = sources(&scene, folder.path(), "1 ms").unwrap();
    let end = run(&file, 3, 210)?;
    Ok(largest(&end, &[begin + 0.42, 2.0, begin + 0.42, 2.0, 0.0, 0.0]))
}

#[test]
fn a_step_that_ends_on_a_dead_point_is_right_or_an_error() {
    let ends = [-0.1, -0.2, -0.3, -0.4, -0.36, -1.0].map(turned);
    for end in &ends {
        match end {
            Ok(apart) => assert!(*apart < 1e-9, "{ends:?}"),
            Err(failed) => assert!(failed.contains("dead point"), "{ends:?}"),
        }
    }
    assert!(ends[5].is_ok(), "nothing is singular there: {ends:?}");
}

#[test]
#[ignore = "all models: .ci/nightly"]
fn every_model_has_sources_or_is_refused_by_name() {
    let mut accepted = 0;
    let mut models: Vec<PathBuf> =
        fs::read_dir(Path::new(ROOT).join("models")).unwrap().map(|own| own.unwrap().path()).collect();
    models.sort();
    for model in models.iter().filter(|model| model.join("scene.toml").is_file()) {
        let folder = tempfile::tempdir().unwrap();
        match sources(&model.join("scene.toml"), folder.path(), "0.1 ms") {
            Ok(file) => {
                check_text(&fs::read_to_string(&file).unwrap());
                compile(&file);
                accepted += 1;
            }
            Err(refused) => assert!(refused.contains("export::sources") && refused.contains('`'), "{refused}"),
        }
    }
    println!("{accepted} of {} accepted", models.len());
}
