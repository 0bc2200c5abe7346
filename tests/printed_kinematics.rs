//! The printed velocities, accelerations and reactions of driven mechanisms are those of the runtime, in each language.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use cotree::element::{Direction, Held};
use cotree::formulate::formulate;
use cotree::pipeline::{self, Notation};
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

#[path = "support/python.rs"]
mod python;

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

/// A scene, where it is at the start, and what is to be found there: rates, accelerations and, with masses, reactions.
struct Case {
    scene: Scene,
    name: String,
    /// t, p, q
    arguments: (f64, Vec<f64>, Vec<f64>),
    reactions: usize,
    expected: Vec<f64>,
}

impl Case {
    fn new(mut scene: Scene) -> Case {
        let mechanism = scene.resolve().unwrap().mechanism;
        let formulated = formulate(&mechanism).unwrap();
        assert!(formulated.lowered.solved.is_empty() && mechanism.inputs.is_empty(), "{}", mechanism.name);
        let state = &formulated.state;
        let arguments =
            (state.time(), state.parameters()[..mechanism.parameters.len()].to_vec(), state.positions().to_vec());
        let coordinates = &formulated.equations.coordinates;
        let mut names: Vec<String> = coordinates.iter().map(|own| own.name.rate.clone()).collect();
        names.extend(coordinates.iter().map(|own| own.name.acceleration.clone()));
        let constraints: Vec<_> = formulated.equations.loops().map(|(_, row)| row).collect();
        if mechanism.bodies.iter().all(|body| body.mass.is_some()) {
            names.extend(constraints.iter().map(|row| {
                let quantity = match row.held {
                    Held::Along(Direction::X) => "fx",
                    Held::Along(Direction::Y) => "fy",
                    other => panic!("{other:?} is not in these scenes"),
                };
                format!("{}.{quantity}", formulated.equations.system.element(row.element).name)
            }));
        }
        let reactions = constraints.len();
        let is_new = |name: &&String| mechanism.outputs.iter().all(|output| output.name != **name);
        scene = names.iter().filter(is_new).fold(scene, |scene, name| scene.output(name));
        let mut instance = Instance::new(Arc::new(Model::new(pipeline::compile(&scene).unwrap().program).unwrap()));
        instance.setup(0.0, None, Some(1e-10)).unwrap();
        instance.initialise().unwrap();
        let value = |name: &String| {
            let variable = instance.variable(name).unwrap_or_else(|| panic!("no variable {name}"));
            instance.get(variable).unwrap()
        };
        let expected = names.iter().map(value).collect();
        Case { name: mechanism.name.clone(), scene, arguments, reactions, expected }
    }

    fn code(&self, notation: Notation) -> String {
        pipeline::equations(&self.scene, notation).unwrap()
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

fn cases() -> Vec<Case> {
    let quick_return = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/quick_return/scene.toml");
    vec![Case::new(Scene::read(quick_return).unwrap()), Case::new(Scene::from_toml(FOUR_BAR).unwrap())]
}

fn list(values: &[f64], suffix: &str) -> String {
    values.iter().map(|value| format!("{value:e}{suffix}")).collect::<Vec<_>>().join(", ")
}

fn run(command: &mut Command) -> Vec<f64> {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?} cannot be started: {error}"));
    assert!(output.status.success(), "{command:?} fails:\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect()
}

fn in_c(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let main = format!(
        "#include \"code.c\"\n#include <stdio.h>\nint main(void)\n{{\n\
         const double p[] = {{{}}}, q[] = {{{}}}, none[1] = {{0}};\ndouble v[{n}], a[{n}], lambda[{m}] = {{0}};\n\
         {name}_velocities({t:e}, p, none, none, q, v);\n{name}_accelerations({t:e}, p, none, none, q, v, a, lambda);\n\
         for (int i = 0; i < {n}; i++) printf(\"%.17g\\n\", v[i]);\nfor (int i = 0; i < {n}; i++) printf(\"%.17g\\n\", a[i]);\n\
         for (int i = 0; i < {m}; i++) printf(\"%.17g\\n\", lambda[i]);\nreturn 0;\n}}\n",
        list(p, ""),
        list(q, ""),
        name = case.name,
    );
    std::fs::write(folder.join("code.c"), case.code(Notation::C)).unwrap();
    std::fs::write(folder.join("main.c"), main).unwrap();
    let flags =
        ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "main.c", "-o", "main_c", "-lm"];
    run(Command::new("gcc").current_dir(folder).args(flags));
    run(&mut Command::new(folder.join("main_c")))
}

fn in_rust(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let main = format!(
        "mod code;\nfn main() {{\nlet (p, q) = ([{}], [{}]);\nlet (mut v, mut a, mut lambda) = ([0.0; {n}], [0.0; {n}], [0.0; {m}]);\n\
         code::{name}_velocities({t:e}, &p, &[], &[], &q, &mut v);\n\
         code::{name}_accelerations({t:e}, &p, &[], &[], &q, &v, &mut a, &mut lambda);\n\
         v.iter().chain(&a).chain(&lambda).for_each(|x| println!(\"{{x:e}}\"));\n}}\n",
        list(p, "_f64"),
        list(q, "_f64"),
        name = case.name,
    );
    std::fs::write(folder.join("code.rs"), case.code(Notation::Rust)).unwrap();
    std::fs::write(folder.join("main.rs"), main).unwrap();
    let flags = ["--edition", "2021", "-D", "warnings", "main.rs", "-o", "main_rust"];
    run(Command::new("rustc").current_dir(folder).args(flags));
    run(&mut Command::new(folder.join("main_rust")))
}

fn in_fortran(case: &Case, folder: &Path) -> Vec<f64> {
    let (t, p, q) = &case.arguments;
    let (n, m) = (case.n(), case.reactions);
    let mut main = format!(
        "program test\n  use {name}_model\n  use, intrinsic :: iso_fortran_env, only: real64\n  implicit none\n  \
         real(real64) :: p({}), none(0), q({n}), v({n}), a({n}), lambda({m})\n  lambda = 0\n",
        p.len(),
        name = case.name,
    );
    for (array, values) in [("p", p), ("q", q)] {
        for (index, value) in values.iter().enumerate() {
            let _ = writeln!(main, "  {array}({}) = {value:e}_real64", index + 1);
        }
    }
    let _ = write!(
        main,
        "  call {name}_velocities({t:e}_real64, p, none, none, q, v)\n  \
         call {name}_accelerations({t:e}_real64, p, none, none, q, v, a, lambda)\n  \
         print '(es25.17e3)', v, a, lambda\nend program test\n",
        name = case.name
    );
    std::fs::write(folder.join("code.f90"), case.code(Notation::Fortran)).unwrap();
    std::fs::write(folder.join("main.f90"), main).unwrap();
    let flags = ["-std=f2008", "-O1", "code.f90", "main.f90", "-o", "main_fortran"];
    run(Command::new("gfortran").current_dir(folder).args(flags));
    run(&mut Command::new(folder.join("main_fortran")))
}

fn in_python(case: &Case, folder: &Path, python: &Path) -> Vec<f64> {
    let (t, p, q) = &case.arguments;
    let main = format!(
        "import code_ as code\np, q = [{}], [{}]\nv = code.{name}_velocities({t:e}, p, [], [], q)\n\
         a, lambda_ = code.{name}_accelerations({t:e}, p, [], [], q, v)\nfor x in [*v, *a, *lambda_]: print(repr(float(x)))\n",
        list(p, ""),
        list(q, ""),
        name = case.name,
    );
    std::fs::write(folder.join("code_.py"), case.code(Notation::Python)).unwrap();
    std::fs::write(folder.join("main.py"), main).unwrap();
    run(Command::new(python).current_dir(folder).arg("main.py"))
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
