//! The printed velocities, accelerations, reactions, slides and efforts are those of the runtime, in each language.

use crate::outside::{command, python};
use crate::support::ROOT;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use cotree::compile;
use cotree::equations::Constraint;
use cotree::formulate::formulate;
use cotree::network::{Constrained, Direction};
use cotree::scene::{Resolved, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_text::written::{self, EquationFormat};

use command::printed;

/// A driven four-bar with masses.
const FOUR_BAR: &str = r#"
name    = "driven_four_bar"
gravity = [0, -9.81]

[parameters]
speed = "3 rad/s"

[ground.points]
right = [0.5, 0]

[bodies.crank]
mass = 1.0
inertia = 0.01
points = { pivot = [-0.1, 0], pin = [0.1, 0] }

[bodies.coupler]
mass = 0.8
inertia = 0.017
points = { left = [-0.25, 0], right = [0.25, 0] }

[bodies.rocker]
mass = 0.6
inertia = 0.008
points = { pin = [0.2, 0], pivot = [-0.2, 0] }

[joints.crank_pivot]
type = "revolute"
between = ["ground", "crank.pivot"]

[joints.crank_pin]
type = "revolute"
between = ["crank.pin", "coupler.left"]

[joints.rocker_pin]
type = "revolute"
between = ["rocker.pin", "coupler.right"]

[joints.rocker_pivot]
type = "revolute"
between = ["ground.right", "rocker.pivot"]

[drivers.motor]
joint = "crank_pivot"
angle = "1 + speed*t + 0.4*t^2"

[initial]
"coupler.angle" = { guess = "20 deg" }
"rocker.angle" = { guess = "90 deg" }
"#;

/// A scene, where it is at the start, and what is to be found there: rates, accelerations, reactions (zero without masses), slides
/// and efforts.
struct Case {
    scene: Scene,
    name: String,
    /// t, p, q, v
    arguments: (f64, Vec<f64>, Vec<f64>, Vec<f64>),
    /// Do the drivers prescribe every motion?
    driven: bool,
    reactions: usize,
    slides: usize,
    efforts: usize,
    expected: Vec<f64>,
}

impl Case {
    /// The names of what follows from the motion are listed in the order in which they are printed.
    fn new(mut scene: Scene, slides: &[&str], efforts: &[&str]) -> Case {
        let Resolved { mechanism, outputs, .. } = scene.resolve().unwrap();
        let formulated = formulate(&mechanism, &outputs).unwrap();
        let driven = formulated.lowered.solved.is_empty();
        assert!(mechanism.inputs.is_empty(), "{}", mechanism.name);
        let state = &formulated.state;
        let parameters = [&state.parameters()[..mechanism.parameters.len()], state.discrete()].concat();
        let arguments = (state.time(), parameters, state.positions().to_vec(), state.rates().to_vec());
        let coordinates = &formulated.equations.coordinates;
        let mut names: Vec<String> = coordinates.iter().map(|own| own.name.rate.clone()).collect();
        names.extend(coordinates.iter().map(|own| own.name.acceleration.clone()));
        let constraints: Vec<_> = formulated.equations.loops().map(|(_, row)| row).collect();
        let has_masses = mechanism.bodies.iter().all(|body| body.mass.is_some());
        let reaction = |row: &&Constraint| {
            let quantity = match row.constrained {
                Constrained::Along(Direction::X) => "fx",
                Constrained::Along(Direction::Y) => "fy",
                Constrained::Along(Direction::Fixed(..)) => "fn",
                other => panic!("{other:?} is not in these scenes"),
            };
            format!("{}.{quantity}", formulated.equations.system.element(row.element).name)
        };
        let before = names.len();
        if has_masses {
            names.extend(constraints.iter().map(reaction));
        }
        names.extend(slides.iter().chain(efforts).map(|&name| name.to_owned()));
        let requested: BTreeSet<&String> = names.iter().collect();
        let reactions = constraints.len();
        let is_new = |name: &&String| outputs.iter().all(|output| output.name != **name);
        scene = requested.into_iter().filter(is_new).fold(scene, |scene, name| scene.output(name));
        let mut instance = Instance::new(Arc::new(Model::new(compile::compile(&scene).unwrap().program).unwrap()));
        instance.setup(0.0, None, Some(1e-10)).unwrap();
        instance.initialise().unwrap();
        let value = |name: &String| {
            let variable = instance.variable(name).unwrap_or_else(|| panic!("no variable {name}"));
            instance.get(variable).unwrap()
        };
        let mut expected: Vec<f64> = names.iter().map(value).collect();
        if !has_masses {
            expected.splice(before..before, vec![0.0; reactions]);
        }
        let (slides, efforts) = (slides.len(), efforts.len());
        Case { name: mechanism.name.clone(), scene, arguments, driven, reactions, slides, efforts, expected }
    }

    fn code(&self, notation: EquationFormat) -> String {
        written::equations(&self.scene, notation).unwrap()
    }

    fn n(&self) -> usize {
        self.arguments.2.len()
    }

    fn check(&self, language: &str, found: &[f64]) {
        let scale = self.expected.iter().fold(1.0_f64, |scale, value| scale.max(value.abs()));
        for (index, expected) in self.expected.iter().enumerate() {
            let error = (found[index] - expected).abs();
            assert!(
                error <= 1e-9 * scale,
                "{} in {language}, {index}: {} instead of {expected}",
                self.name,
                found[index]
            );
        }
    }
}

/// Driven without and with masses, and free.
fn cases() -> Vec<Case> {
    let model = |name: &str| Scene::read(Path::new(ROOT).join("models").join(name).join("scene.toml")).unwrap();
    let four_bar = Scene::from_toml(FOUR_BAR).unwrap();
    let held = [
        "crank_pivot.fx",
        "crank_pivot.fy",
        "crank_pin.fx",
        "crank_pin.fy",
        "rocker_pin.fx",
        "rocker_pin.fy",
        "rocker_pivot.fx",
        "rocker_pivot.fy",
        "motor.torque",
    ];
    vec![
        Case::new(model("quick_return"), &["rocker_slot.s", "tool_slide.s"], &[]),
        Case::new(four_bar, &[], &held),
        Case::new(
            model("scotch_yoke"),
            &["slot.s"],
            &["main_bearing.fx", "main_bearing.fy", "guide.fn", "guide.torque", "slot.fn"],
        ),
    ]
}

fn list(values: &[f64], suffix: &str) -> String {
    values.iter().map(|value| format!("{value:e}{suffix}")).collect::<Vec<_>>().join(", ")
}

fn numbers(command: &mut Command) -> Vec<f64> {
    printed(command).split_whitespace().map(|word| word.parse().unwrap()).collect()
}

/// The functions of a case: without its name, and what they are given behind t, p, u, f, q.
fn functions(case: &Case) -> Vec<(&'static str, &'static [&'static str], &'static [&'static str])> {
    let mut functions: Vec<(_, &[_], &[_])> = Vec::new();
    if case.driven {
        functions.push(("velocities", &[], &["v"]));
    }
    functions.push(("accelerations", &["v"], &["a", "lambda"]));
    if case.slides > 0 {
        functions.push(("slides", &["v"], &["s"]));
    }
    if case.efforts > 0 {
        functions.push(("efforts", &["v", "a", "lambda"], &["effort"]));
    }
    functions
}

fn in_c(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q, v) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let mut main = format!(
        "#include \"code.c\"\n#include <stdio.h>\nint main(void)\n{{\n\
         const double p[] = {{{}}}, q[] = {{{}}}, none[1] = {{0}};\ndouble v[{n}] = {{{}}}, a[{n}], lambda[{m}];\n\
         double s[{}], effort[{}];\n",
        list(p, ""),
        list(q, ""),
        list(v, ""),
        case.slides + 1,
        case.efforts + 1,
    );
    for (function, given, found) in functions(case) {
        let arrays = [given, found].concat().join(", ");
        let _ = writeln!(main, "{}_{function}({t:e}, p, none, none, q, {arrays});", case.name);
    }
    for (array, size) in [("v", n), ("a", n), ("lambda", m), ("s", case.slides), ("effort", case.efforts)] {
        let _ = writeln!(main, "for (int i = 0; i < {size}; i++) printf(\"%.17g\\n\", {array}[i]);");
    }
    main.push_str("return 0;\n}\n");
    std::fs::write(folder.join("code.c"), case.code(EquationFormat::C)).unwrap();
    std::fs::write(folder.join("main.c"), main).unwrap();
    let flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-ffp-contract=off"];
    printed(Command::new("gcc").current_dir(folder).args(flags).args(["main.c", "-o", "main_c", "-lm"]));
    numbers(&mut Command::new(folder.join("main_c")))
}

fn in_rust(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q, v) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let mut main = format!(
        "mod code;\n#[allow(unused_mut)]\nfn main() {{\nlet (p, q, mut v): ([f64; {}], [f64; {n}], [f64; {n}]) = ([{}], [{}], [{}]);\n\
         let (mut a, mut lambda, mut s, mut effort) = ([0.0_f64; {n}], [0.0_f64; {m}], [0.0_f64; {}], [0.0_f64; {}]);\n",
        p.len(),
        list(p, "_f64"),
        list(q, "_f64"),
        list(v, "_f64"),
        case.slides,
        case.efforts,
    );
    for (function, given, found) in functions(case) {
        let given = given.iter().map(|array| format!("&{array}"));
        let arrays: Vec<String> = given.chain(found.iter().map(|array| format!("&mut {array}"))).collect();
        let _ = writeln!(main, "code::{}_{function}({t:e}, &p, &[], &[], &q, {});", case.name, arrays.join(", "));
    }
    main.push_str("v.iter().chain(&a).chain(&lambda).chain(&s).chain(&effort).for_each(|x| println!(\"{x:e}\"));\n}\n");
    std::fs::write(folder.join("code.rs"), case.code(EquationFormat::Rust)).unwrap();
    std::fs::write(folder.join("main.rs"), main).unwrap();
    let flags = ["--edition", "2021", "-D", "warnings", "main.rs", "-o", "main_rust"];
    printed(Command::new("rustc").current_dir(folder).args(flags));
    numbers(&mut Command::new(folder.join("main_rust")))
}

fn in_fortran(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q, v) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let mut main = format!(
        "program test\n  use {name}_model\n  use, intrinsic :: iso_fortran_env, only: real64\n  implicit none\n  \
         real(real64) :: p({}), none(0), q({n}), v({n}), a({n}), lambda({m}), s({}), effort({})\n",
        p.len(),
        case.slides,
        case.efforts,
        name = case.name,
    );
    for (array, values) in [("p", p), ("q", q), ("v", v)] {
        for (index, value) in values.iter().enumerate() {
            let _ = writeln!(main, "  {array}({}) = {value:e}_real64", index + 1);
        }
    }
    for (function, given, found) in functions(case) {
        let arrays = [given, found].concat().join(", ");
        let _ = writeln!(main, "  call {}_{function}({t:e}_real64, p, none, none, q, {arrays})", case.name);
    }
    main.push_str("  print '(es25.17e3)', v, a, lambda, s, effort\nend program test\n");
    std::fs::write(folder.join("code.f90"), case.code(EquationFormat::Fortran)).unwrap();
    std::fs::write(folder.join("main.f90"), main).unwrap();
    let flags = ["-std=f2008", "-O1", "code.f90", "main.f90", "-o", "main_fortran"];
    printed(Command::new("gfortran").current_dir(folder).args(flags));
    numbers(&mut Command::new(folder.join("main_fortran")))
}

fn in_python(case: &Case, folder: &Path, python: &Path) -> Vec<f64> {
    let (t, p, q, v) = &case.arguments;
    let mut main = format!(
        "import code_ as code\np, q, v, s, effort = [{}], [{}], [{}], [], []\n",
        list(p, ""),
        list(q, ""),
        list(v, "")
    );
    for (function, given, found) in functions(case) {
        let given: String = given.iter().map(|array| format!(", {array}")).collect();
        let _ = writeln!(main, "{} = code.{}_{function}({t:e}, p, [], [], q{given})", found.join(", "), case.name);
    }
    let main = main.replace("lambda", "lambda_") + "for x in [*v, *a, *lambda_, *s, *effort]: print(repr(float(x)))\n";
    std::fs::write(folder.join("code_.py"), case.code(EquationFormat::Python)).unwrap();
    std::fs::write(folder.join("main.py"), main).unwrap();
    numbers(Command::new(python).current_dir(folder).arg("main.py"))
}

/// Functions do not leave what they are given as it is.
#[test]
fn without_masses_their_matrices_are_zero() {
    let text = "joints.j = { type = 'revolute', between = ['ground', 'a.p'] }\nbodies.a = { points = { p = [1, 0] } }\n\
                drivers.d = { joint = 'j', angle = 't' }\nname = 'bare'\n\
                coordinates = { translation = ['j'], rotation = ['a'] }";
    let scene = Scene::from_toml(text).unwrap();
    for (notation, load) in [
        (EquationFormat::C, "Q[0] = 0e0;"),
        (EquationFormat::Rust, "Q[0] = 0e0_f64;"),
        (EquationFormat::Fortran, "load(1) = 0e0_real64"),
    ] {
        let code = written::equations(&scene, notation).unwrap();
        assert!(code.contains(load) && code.contains("The scene gives no masses"), "{code}");
    }
}

#[test]
fn c_and_rust_give_the_motion_of_the_runtime_and_the_same_bits() {
    for case in cases() {
        let folder = tempfile::tempdir().unwrap();
        let [c, rust] = [in_c(&case, folder.path()), in_rust(&case, folder.path())];
        case.check("C", &c);
        assert_eq!(c, rust, "{}", case.name);
    }
}

#[test]
fn fortran_gives_the_motion_of_the_runtime() {
    if Command::new("gfortran").arg("--version").output().is_err() {
        eprintln!("gfortran is missing: the printed Fortran was not run");
        return;
    }
    for case in cases() {
        let folder = tempfile::tempdir().unwrap();
        case.check("Fortran", &in_fortran(&case, folder.path()));
    }
}

#[test]
fn python_gives_the_motion_of_the_runtime() {
    let Some((_, python)) = python::python("numpy", "numpy==2.4.6") else { return };
    for case in cases() {
        let folder = tempfile::tempdir().unwrap();
        case.check("Python", &in_python(&case, folder.path(), &python));
    }
}
