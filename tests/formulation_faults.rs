//! Scenes whose faults show only in their equations: what each is told, as reviewed in the snapshots.

use crate::support::ROOT;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use cotree::compile::compile;
use cotree::redundancy::independence::independence;
use cotree::redundancy::matrices::{constraint, jacobian};
use cotree::redundancy::nearby::consistent_poses;
use cotree::scene::{Faults, Scene, Source};
use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::model::Model;

/// The scenes, in alphabetical order.
fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(ROOT).join("tests/faults/equations");
    let files = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    paths.sort();
    paths
}

/// Errors, or warnings.
fn faults(name: &str, text: String) -> Option<Faults> {
    match Scene::from_source(Source::new(name, text), false).and_then(|scene| compile(&scene)) {
        Err(faults) => Some(faults),
        Ok(compiled) => compiled.warnings,
    }
}

#[test]
fn each_scene_is_told_what_to_do() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("faults/equations");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for path in scenes() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        let faults = faults(&name, text).unwrap_or_else(|| panic!("{name} has no fault"));
        settings.bind(|| insta::assert_snapshot!(name, faults.render(false, 100)));
    }
}

/// Scenes with a warning work all the same.
#[test]
fn redundant_joints_are_solved() {
    let path = Path::new(ROOT).join("tests/faults/equations/redundant_rod.toml");
    let compiled = compile(&Scene::read(&path).unwrap()).unwrap();
    assert!(compiled.warnings.is_some());
    let active = compiled.program.constraints.iter().filter(|row| row.is_imposed()).count();
    assert_eq!(compiled.program.coordinates.len() - active, 1, "one degree of freedom");
}

/// A redundant rod with a motor: nothing moves while time stands still.
#[test]
fn redundant_equations_are_found_at_every_pose_or_not_at_all() {
    let path = Path::new(ROOT).join("tests/faults/equations/redundant_rod.toml");
    let motor = "[drivers.motor]\njoint = \"left_foot\"\nangle = \"pi/3 + 2*t\"\n\n[initial]\n";
    let text = std::fs::read_to_string(&path).unwrap().replace("[initial]\n\"left.angle\" = \"60 deg\"\n", motor);
    let scene = Scene::from_source(Source::new("driven.toml", text), false).unwrap();
    let model = Model::of_positions(compile(&scene).unwrap().program).unwrap();
    let mut state = model.default_state(0.0);
    solve_initial(&model, &mut state).unwrap();
    let poses = consistent_poses(&model, &state, 8, 0.3, 1);
    assert!(poses.len() > 4);
    for pose in &poses {
        assert!(constraint(&model, pose).amax() < 1e-9);
    }
    assert_eq!(jacobian(&model, &state).shape(), (4, 3));
    let found = independence(&model, &state, Vec::new, &[]).unwrap();
    assert_eq!((found.mobility, found.independent.len()), (0, 3));
    assert_eq!(poses, consistent_poses(&model, &state, 8, 0.3, 1), "the same every time");
}

fn free_bodies(count: usize) -> String {
    let mut text = String::from("name = \"many\"\ngravity = [0, -9.81]\n");
    for index in 0..count {
        let _ = writeln!(text, "[bodies.b{index}]\nmass = 1\ninertia = 0.1");
    }
    text
}

fn chain(count: usize, preset: &str) -> String {
    let mut text = String::from("name = \"chain\"\ngravity = [0, -9.81]\n");
    for index in 0..count {
        let before = if index == 0 { "ground".to_string() } else { format!("b{}.end", index - 1) };
        let _ = writeln!(
            text,
            "[bodies.b{index}]\nmass = 1\ninertia = 0.1\npoints = {{ start = [-0.1, 0], end = [0.1, 0] }}\n\
             [joints.j{index}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{index}.start\"]"
        );
    }
    let _ = writeln!(text, "[coordinates]\npreset = \"{preset}\"");
    text
}

#[test]
fn thousands_of_free_bodies_are_no_problem() {
    assert_eq!(faults("many.toml", free_bodies(5000)), None);
}

#[test]
fn thousands_of_bodies_in_one_chain_are_no_problem() {
    for preset in ["recommended", "absolute"] {
        assert_eq!(faults("chain.toml", chain(3000, preset)), None);
    }
}

/// Nothing that would take hours and all the memory is begun.
#[test]
fn what_is_too_large_is_refused_before_it_is_tried() {
    let implicit = chain(2500, "recommended") + "[solver]\nmethod = \"implicit\"\n";
    for (name, text) in [("joint", chain(5000, "joint")), ("implicit", implicit)] {
        let faults = faults("chain.toml", text).unwrap();
        assert_eq!(faults.list.iter().map(|fault| fault.code).collect::<Vec<_>>(), ["scene::too_large"], "{name}");
        insta::assert_snapshot!(format!("too_large_{name}"), faults.render(false, 100));
    }
}

#[test]
fn chains_of_moderate_length_are_formulated() {
    for preset in ["recommended", "absolute", "joint"] {
        assert_eq!(faults("chain.toml", chain(40, preset)), None);
    }
}

/// Ten megabytes: a hundred thousand bodies in chains of two.
#[test]
fn a_huge_file_is_answered() {
    let mut text = String::from("name = \"huge\"\n");
    let mut index = 0;
    while text.len() < 10_000_000 {
        let _ = writeln!(
            text,
            "[bodies.upper{index}]\nmass = 1\ninertia = 0.1\npoints = {{ pin = [0.1, 0] }}\n\
             [bodies.lower{index}]\nmass = 1\ninertia = 0.1\npoints = {{ pin = [-0.1, 0] }}\n\
             [joints.pin{index}]\ntype = \"revolute\"\nbetween = [\"upper{index}.pin\", \"lower{index}.pin\"]"
        );
        index += 1;
    }
    let faults = faults("huge.toml", text).unwrap();
    assert_eq!(faults.list.iter().map(|fault| fault.code).collect::<Vec<_>>(), ["scene::too_large"]);
}

/// What jumps stays as large however near one looks; what turns on a short way, or is as good as still, does not.
#[test]
fn a_law_of_a_driver_is_said_to_jump_where_it_does() {
    let laws = [
        ("abs(t - 0.7)", Some("its rate goes from -0.300000 to 0.300000")),
        ("abs(t - 0.7)^0.5", Some("its rate is unbounded")),
        ("sign(t - 0.7)*abs(t - 0.7)^0.5", Some("its rate is unbounded")),
        ("if(t < 0.7, 0, 1e-3)", Some("it goes from 0.000000 to 0.000300")),
        ("sin(500*t) + if(t < 0.7, 0, 1e-2)", Some("it goes from")),
        ("if(t < 0.7, 0, 2*(t - 0.7))", Some("its rate goes from 0.000000 to 0.600000")),
        ("abs(t - 0.7)^1.5", None),
        ("abs(t - 0.7)^2.5", None),
        ("max(0, t - 0.7)^2", None),
        ("1000*abs(t - 0.7)^3", None),
        ("if(t < 0.7, sin(t - 0.7)*(t - 0.7), (t - 0.7)^2)", None),
    ];
    for (law, expected) in laws {
        let text = format!(
            "name = \"cart\"\ngravity = [0, -9.81]\n[bodies.cart]\nmass = 1\n[bodies.bob]\nmass = 1\ninertia = 0.1\n\
             points = {{ top = [0, 0.5] }}\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\n\
             axis = [1, 0]\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"cart\", \"bob.top\"]\n[drivers.motor]\n\
             joint = \"rail\"\ndisplacement = \"0.3*({law})\"\n[experiment]\nstop = 1.5\n"
        );
        let said = faults(law, text).map(|faults| faults.render(false, 400));
        match (expected, &said) {
            (None, None) => {}
            (Some(expected), Some(said)) => assert!(said.contains(expected), "{law}: {said}"),
            _ => panic!("{law}: {said:?}"),
        }
    }
}

/// Particles: what nothing turns may have any inertia, and all of them are named at once.
#[test]
fn particles_without_inertia_are_told_of_together() {
    let scene = |inertia: &str| {
        format!(
            "name = \"particles\"\ngravity = [0, -9.81]\nground.points = {{ p = [1, 0] }}\n[bodies]\n\
             a = {{ mass = 1, inertia = {inertia} }}\nb = {{ mass = 2, inertia = {inertia} }}\n\
             c = {{ mass = 1, inertia = 0, points = {{ end = [1, 0] }} }}\n\
             [joints.pin]\ntype = \"revolute\"\nbetween = [\"ground.p\", \"c.end\"]\n[loads]\n\
             s1 = {{ type = \"spring\", between = [\"ground\", \"a\"], stiffness = 100, length = 0.5 }}\n\
             s2 = {{ type = \"spring\", between = [\"a\", \"b\"], stiffness = 100, length = 0.5 }}\n\
             [initial]\n\"a.x\" = 0.3\n\"b.x\" = 0.7\n\"a.omega\" = 1.0\n\"b.omega\" = 2.0\n[outputs]\nvariables = [\"a.x\", \"b.y\", \"c.x\"]\n[experiment]\nstop = 0.2\n"
        )
    };
    let said = faults("particles.toml", scene("0")).unwrap();
    let messages: Vec<&str> = said.list.iter().map(|fault| &*fault.message).collect();
    assert_eq!(
        messages,
        ["no joint or load turns `a`, `b`, and their inertias are zero: the angular acceleration is not determined"]
    );
    assert!(said.list[0].help.contains("give any positive inertia"), "{}", said.list[0].help);
    let ends = |inertia: &str| {
        let results = Scene::from_toml(&scene(inertia)).unwrap().simulate().unwrap();
        ["a.x", "b.y", "c.x"].map(|name| *results.column(name).unwrap().values.last().unwrap())
    };
    for (one, other) in ends("1").into_iter().zip(ends("5")) {
        assert!((one - other).abs() < 1e-9, "{one} {other}");
    }
}

/// Drivers that keep the loops open are named first, whether they are more than the freedoms or the same one twice; a single one is out of its reach.
#[test]
fn drivers_that_contradict_each_other_are_named() {
    let four_bar =
        std::fs::read_to_string(Path::new(ROOT).join("tests/faults/equations/two_drivers_one_freedom.toml")).unwrap();
    let first = |text: String| {
        let faults = faults("four_bar.toml", text).unwrap();
        let [fault] = &faults.list[..] else { panic!("{}", faults.render(false, 100)) };
        format!("{} {}", fault.code, fault.message)
    };
    let open = "the smallest gap is 12.89 mm at `rocker_pin`";
    let said = first(four_bar.clone());
    let why = "the joints leave 1 degree of freedom, but drivers prescribe 2 motions";
    assert_eq!(said, format!("assembly::conflict drivers `motor`, `brake` conflict: {why}; {open}"));
    let pendulum =
        "[bodies.bob]\nmass = 1\ninertia = 1\n[joints.swing]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob\"]\n";
    let said = first(format!("{pendulum}{four_bar}").replacen("name = \"four_bar\"\n", "", 1).replacen(
        "[bodies.bob]",
        "name = \"x\"\n[bodies.bob]",
        1,
    ));
    assert_eq!(
        said,
        format!(
            "assembly::conflict drivers `motor`, `brake` conflict: without any one of them the loops close; {open}"
        )
    );
    let (rest, _) = four_bar.split_once("[drivers.motor]").unwrap();
    let said = first(format!("{rest}[drivers.path]\non = \"crank.pin\"\nposition = [0.3, 0.3]\n"));
    assert!(
        said.starts_with(&format!("assembly::conflict driver `path` overconstrains the mechanism: {why}")),
        "{said}"
    );
    let said = first(format!("{rest}[drivers.motor]\njoint = \"rocker_pivot\"\nangle = \"10 deg\"\n"));
    assert!(said.starts_with("assembly::open_loop the loops cannot be closed"), "{said}");
}
