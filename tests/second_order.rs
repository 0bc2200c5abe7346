//! Joints that hold a direction in second order only: bars between parallel guides, beams between carriages, lifts on Scott-Russell legs, taut chains. A parameter passes through the
//! value where this happens. References are closed forms, energy and geometry; all loop equations must hold, whatever is imposed.

use crate::support::hard::random as split_mix;
use crate::support::run;

use std::fmt::Write;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use split_mix::Random;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];
const TOLERANCES: [f64; 3] = [1e-3, 1e-6, 1e-10];
const GRAVITY: f64 = 9.81;
/// Half of what the beams and bars are long.
const HALF: f64 = 0.6;

/// A scene with what must be true of it.
struct Member {
    name: String,
    text: String,
    stop: f64,
    /// Variables and their values at the end.
    ends: Vec<(&'static str, f64)>,
    /// Must the energy stay?
    conserves: bool,
    /// Can it be assembled at all?
    closes: Option<bool>,
}

/// Tables of a scene in random order: which joint closes a loop decides which equations there are.
fn shuffled(random: &mut Random, mut tables: Vec<String>) -> String {
    for last in (1..tables.len()).rev() {
        let other = ((last + 1) as f64 * random.unit()) as usize;
        tables.swap(last, other.min(last));
    }
    tables.concat()
}

/// A beam between two carriages on columns that are 1.2 m less `defect` apart; a damped ram lifts one of them. The beam keeps its angle.
fn gantry(random: &mut Random, defect: f64) -> Member {
    let apart = 2.0 * HALF - defect;
    let angle = (apart / (2.0 * HALF)).min(1.0).acos();
    let rise = 2.0 * HALF * angle.sin();
    let joints = vec![
        "[joints.column1]\ntype = \"prismatic\"\nbetween = [\"ground.left\", \"c1\"]\naxis = [0, 1]\n".to_owned(),
        "[joints.column2]\ntype = \"prismatic\"\nbetween = [\"ground.right\", \"c2\"]\naxis = [0, 1]\n".to_owned(),
        "[joints.pin1]\ntype = \"revolute\"\nbetween = [\"c1\", \"beam.l\"]\n".to_owned(),
        "[joints.pin2]\ntype = \"revolute\"\nbetween = [\"c2\", \"beam.r\"]\n".to_owned(),
    ];
    let joints = shuffled(random, joints);
    let text = format!(
        r#"
name = "gantry"
gravity = [0, -{GRAVITY}]
[ground.points]
left = [0, 0]
right = [{apart:?}, 0]
[bodies.c1]
mass = 5
inertia = 0.1
[bodies.c2]
mass = 5
inertia = 0.1
[bodies.beam]
mass = 20
inertia = 2.4
points = {{ l = [-{HALF}, 0], r = [{HALF}, 0] }}
{joints}
[loads.ram]
type = "force"
on = "c1"
vector = [0, "450 - 200*c1.vy"]
[initial]
"column1.s" = 0
"column1.v" = 0
"column2.s" = {{ guess = {rise:?} }}
"beam.angle" = {{ guess = {angle:?} }}
[outputs]
variables = ["column1.s", "column1.v", "beam.omega", "constraint.position"]
[experiment]
stop = 1
"#
    );
    let (stop, decay, speed) = (1.0, 200.0 / 30.0, (450.0 - 30.0 * GRAVITY) / 200.0);
    let end = speed * (stop - (1.0 - f64::exp(-decay * stop)) / decay);
    let ends = vec![("column1.s", end), ("column1.v", speed * (1.0 - f64::exp(-decay * stop))), ("beam.omega", 0.0)];
    let closes = if defect < -1e-8 { Some(false) } else { (defect >= 0.0).then_some(true) };
    Member { name: format!("gantry {defect:e}"), text, stop, ends, conserves: false, closes }
}

/// A bar whose points slide on parallel rails that are `share` of their distance apart, all of it turned by an angle: it falls along the rails.
fn guides(random: &mut Random, count: usize, share: f64) -> Member {
    let turn = random.between(-1.2, 1.2);
    let tilt = share.min(1.0).acos();
    let place = |index: usize| index as f64 / (count - 1) as f64 * 2.0 * HALF;
    let (mut points, mut ground) = (String::new(), String::new());
    let mut joints = Vec::new();
    for index in 0..count {
        let along = share * place(index);
        let _ = write!(points, "p{index} = [{:?}, 0], ", place(index) - HALF);
        let _ = writeln!(ground, "g{index} = [{:?}, {:?}]", along * turn.cos(), along * turn.sin());
        joints.push(format!(
            "[joints.s{index}]\ntype = \"slot\"\nbetween = [\"ground.g{index}\", \"bar.p{index}\"]\naxis = [{:?}, {:?}]\n",
            -turn.sin(),
            turn.cos()
        ));
    }
    let joints = shuffled(random, joints);
    let at = [HALF * share, 0.0];
    let centre = [at[0] * turn.cos(), at[0] * turn.sin()];
    let angle = turn + tilt;
    let text = format!(
        r#"
name = "guides"
gravity = [0, -{GRAVITY}]
[ground.points]
{ground}
[bodies.bar]
mass = 3
inertia = 0.4
points = {{ {points} }}
{joints}
[initial]
"bar.x" = {{ guess = {:?} }}
"bar.y" = {{ guess = {:?} }}
"bar.angle" = {{ guess = {angle:?} }}
[outputs]
variables = ["bar.vx", "bar.vy", "bar.omega", "energy.total", "constraint.position"]
[experiment]
stop = 0.5
"#,
        centre[0], centre[1]
    );
    let stop = 0.5;
    let speed = -GRAVITY * turn.cos() * stop;
    let ends = vec![("bar.vx", -speed * turn.sin()), ("bar.vy", speed * turn.cos()), ("bar.omega", 0.0)];
    let closes = if share > 1.0 + 1e-8 { Some(false) } else { (share <= 1.0).then_some(true) };
    Member { name: format!("guides {count} {share:?}"), text, stop, ends, conserves: true, closes }
}

/// Links in line between two points of the ground: nothing moves.
fn taut(random: &mut Random, count: usize) -> Member {
    let half = 0.5 / count as f64;
    let (mut bodies, mut initial) = (String::new(), String::new());
    let mut joints = Vec::new();
    for index in 0..count {
        let _ = write!(
            bodies,
            "[bodies.l{index}]\nmass = 1\ninertia = 0.01\npoints = {{ a = [-{half:?}, 0], b = [{half:?}, 0] }}\n"
        );
        let from = if index == 0 { "ground".to_owned() } else { format!("l{}.b", index - 1) };
        joints.push(format!("[joints.p{index}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"l{index}.a\"]\n"));
        let _ = writeln!(initial, "\"l{index}.angle\" = {{ guess = {:?} }}", random.between(-1e-3, 1e-3));
    }
    joints.push(format!("[joints.end]\ntype = \"revolute\"\nbetween = [\"l{}.b\", \"ground.right\"]\n", count - 1));
    let joints = shuffled(random, joints);
    let text = format!(
        "name = \"taut\"\ngravity = [0, -{GRAVITY}]\n[ground.points]\nright = [1, 0]\n{bodies}{joints}[initial]\n{initial}[outputs]\nvariables = [\"l0.angle\", \"l1.angle\", \
         \"l1.y\", \"constraint.position\"]\n[experiment]\nstop = 1\n"
    );
    let ends = vec![("l0.angle", 0.0), ("l1.angle", 0.0), ("l1.y", 0.0)];
    Member { name: format!("taut {count}"), text, stop: 1.0, ends, conserves: false, closes: Some(true) }
}

/// A platform on two Scott-Russell legs, which keep it level.
fn lift(random: &mut Random) -> Member {
    let [arm, width, angle] = [[0.2, 0.4], [0.4, 0.9], [0.4, 1.1]].map(|[low, high]| random.between(low, high));
    let leg = |index: usize| {
        format!(
            "[bodies.short{index}]\nmass = 0.5\ninertia = 2.6e-3\ncom = [{:?}, 0]\npoints = {{ foot = [0, 0], mid = [{arm:?}, 0] }}\n[bodies.long{index}]\nmass = 1\ninertia = 0.02\npoints = \
             {{ foot = [{arm:?}, 0], mid = [0, 0], top = [-{arm:?}, 0] }}\n",
            0.5 * arm
        )
    };
    let mut joints = Vec::new();
    for index in [1, 2] {
        joints.push(format!(
            "[joints.p{index}]\ntype = \"revolute\"\nbetween = [\"ground.o{index}\", \"short{index}.foot\"]\n"
        ));
        joints.push(format!(
            "[joints.m{index}]\ntype = \"revolute\"\nbetween = [\"short{index}.mid\", \"long{index}.mid\"]\n"
        ));
        joints.push(format!(
            "[joints.s{index}]\ntype = \"slot\"\nbetween = [\"ground.o{index}\", \"long{index}.foot\"]\naxis = [1, 0]\n"
        ));
    }
    joints.push("[joints.t1]\ntype = \"revolute\"\nbetween = [\"long1.top\", \"platform.left\"]\n".to_owned());
    joints.push("[joints.t2]\ntype = \"revolute\"\nbetween = [\"long2.top\", \"platform.right\"]\n".to_owned());
    let joints = shuffled(random, joints);
    let text = format!(
        r#"
name = "lift"
gravity = [0, -{GRAVITY}]
[ground.points]
o1 = [0, 0]
o2 = [{width:?}, 0]
{}{}
[bodies.platform]
mass = 4
inertia = 0.12
points = {{ left = [{:?}, 0], right = [{:?}, 0] }}
{joints}
[initial]
"short1.angle" = {angle:?}
"short2.angle" = {{ guess = {angle:?} }}
"long1.angle" = {{ guess = {:?} }}
"long2.angle" = {{ guess = {:?} }}
"platform.angle" = {{ guess = 0 }}
[outputs]
variables = ["platform.angle", "platform.omega", "platform.vx", "energy.total", "constraint.position"]
[experiment]
stop = 0.1
"#,
        leg(1),
        leg(2),
        -0.5 * width,
        0.5 * width,
        -angle,
        -angle,
    );
    let ends = vec![("platform.angle", 0.0), ("platform.omega", 0.0), ("platform.vx", 0.0)];
    Member {
        name: format!("lift {arm:.3} {width:.3} {angle:.3}"),
        text,
        stop: 0.1,
        ends,
        conserves: true,
        closes: Some(true),
    }
}

fn members() -> Vec<Member> {
    let mut random = Random(43);
    let mut members = Vec::new();
    let defects: Vec<f64> = (3..=10).map(|power| 10f64.powi(-power)).collect();
    for defect in defects.iter().copied().chain([0.0; 6]).chain(defects.iter().map(|defect| -defect)) {
        members.extend((0..3).map(|_| gantry(&mut random, defect)));
        if defect != 0.0 {
            members.extend((2..=4).map(|count| guides(&mut random, count, 1.0 - defect)));
        }
    }
    members.extend((0..30).map(|index| guides(&mut random, 2 + index % 3, 1.0)));
    members.extend((0..24).map(|index| taut(&mut random, 2 + index % 4)));
    members.extend((0..32).map(|_| lift(&mut random)));
    assert_eq!(members.len(), 200);
    members
}

/// What is wrong with the end of a run.
fn wrong(member: &Member, instance: &mut Instance, tolerance: f64, energy: Option<f64>) -> Vec<String> {
    let mut wrong = Vec::new();
    for &(name, end) in &member.ends {
        let found = run::value(instance, name);
        // Written so that NaN is wrong.
        let right = (found - end).abs() <= 100.0 * tolerance + 1e-9;
        if !right {
            wrong.push(format!("{name} = {found:e}, right {end:e}"));
        }
    }
    let open = run::value(instance, "constraint.position");
    if open > tolerance.max(1e-9) {
        wrong.push(format!("loops are open by {open:e}"));
    }
    if let Some(before) = energy {
        let now = run::value(instance, "energy.total");
        if (now - before).abs() > 1e3 * tolerance + 1e-8 {
            wrong.push(format!("energy {before:e} becomes {now:e}"));
        }
    }
    wrong
}

fn tried(member: &Member, engine: Option<Engine>, tolerance: f64) -> Vec<String> {
    let compiled = match Scene::from_toml(&member.text).and_then(|scene| compile(&scene)) {
        Ok(compiled) => compiled,
        Err(faults) if member.closes == Some(true) => return vec![faults.render(false, 100)],
        Err(faults) => {
            let said = faults.render(false, 100);
            return if said.contains("cannot be closed") { Vec::new() } else { vec![said] };
        }
    };
    if member.closes == Some(false) {
        return vec!["closes, though it cannot".to_owned()];
    }
    let model = std::sync::Arc::new(Model::new(compiled.program).expect("a sound program"));
    let mut instance = run::started(&model, engine, member.stop, tolerance);
    let energy = member.conserves.then(|| run::value(&mut instance, "energy.total"));
    for step in 1..=4 {
        if let Err(error) = instance.step_to(member.stop * f64::from(step) / 4.0) {
            return vec![error.to_string()];
        }
    }
    wrong(member, &mut instance, tolerance, energy)
}

#[test]
fn guides_lifts_and_taut_chains_move_as_geometry_demands() {
    let mut wrong = Vec::new();
    for (index, member) in members().iter().enumerate() {
        // Each member by one method at one tolerance, and all of them by all over the family.
        let (engine, tolerance) = (ENGINES[index % 3], TOLERANCES[index / 3 % 3]);
        let found = tried(member, engine, tolerance);
        if !found.is_empty() {
            wrong.push(format!("{} {engine:?} {tolerance:e}: {}", member.name, found.join("; ")));
        }
    }
    assert!(wrong.is_empty(), "{} of 200:\n{}", wrong.len(), wrong.join("\n"));
}
