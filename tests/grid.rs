//! Every pair of features on one mechanism, in every command: an answer, or a refusal by name; never a panic. What one of them moves alone, it moves so beside every other one: a cart with an arm and a pair of wheels
//! have nothing in common, so that results of single features are those of pairs.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::support::power::largest_gap;
use crate::support::run;
use cotree::Severity;
use cotree::compile::{Compiled, compile};
use cotree::export::FmiVersion;
use cotree::report::csv::CsvTable;
use cotree::scene::{Faults, Requested, Scene};
use cotree_fmu::contain::contain;
use cotree_fmu::context::listen;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_study::analysis::{LinearisedAt, Study, StudyError};
use cotree_study::fit::{FitRequest, Vary, fit};
use cotree_study::motion::{MotionRequest, study};
use cotree_text::Prose;
use cotree_text::source::{FixedStep, Real, SourceMethod, c_file};
use cotree_text::written::{EquationFormat, equations, steps};

/// On what a feature acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Acts {
    Cart,
    Wheels,
    Both,
    Nothing,
}
use Acts::{Both, Cart, Nothing, Wheels};

/// A feature: what it is called, what it acts on, and the tables that it adds.
struct Feature(&'static str, Acts, &'static str);

const BASE: &str = r#"
name = "grid"
gravity = [0, -9.81]
[parameters]
gain = { value = 1.0, tunable = true }
[ground.points]
floor = [0, -0.35]
peg = [1.0, 0.0]
wall = [-0.5, 0.1]
axle = [2.0, 0.0]
shaft = [3.0, 0.0]
[bodies.box]
mass = 2
inertia = 0.1
[bodies.arm]
mass = 1
inertia = 0.05
points = { root = [-0.3, 0], tip = [0.3, 0] }
[bodies.wheel]
mass = 1
inertia = 0.1
[bodies.drum]
mass = 1
inertia = 0.2
[joints.rail]
type = "prismatic"
between = ["ground", "box"]
axis = [1, 0]
[joints.hinge]
type = "revolute"
between = ["box", "arm.root"]
[joints.axle]
type = "revolute"
between = ["ground.axle", "wheel"]
[joints.shaft]
type = "revolute"
between = ["ground.shaft", "drum"]
[loads.pull]
type = "force"
on = "box"
vector = ["3[N]*gain", 0]
[loads.turn]
type = "torque"
on = "wheel"
value = "0.5[N.m]*gain"
[loads.centring]
type = "force"
on = "box"
vector = ["-20[N/m]*rail.s", 0]
[loads.wheel_spring]
type = "torsion_spring"
between = ["ground", "wheel"]
stiffness = 1.0
[loads.drum_spring]
type = "torsion_spring"
between = ["ground", "drum"]
stiffness = 0.5
[initial]
"rail.s" = 0
"hinge.angle" = 0
[outputs]
variables = ["rail.s", "rail.v", "hinge.angle", "hinge.omega", "axle.angle", "axle.omega", "shaft.angle", "shaft.omega"]
[experiment]
stop = "0.6 s"
step = "0.1 s"
tolerance = 1e-8
"#;

const FEATURES: &[Feature] = &[
    Feature("limit", Cart, "[joints.rail.limits]\nmax = 0.05\nrestitution = 0.3"),
    Feature("limits of an angle", Cart, "[joints.hinge.limits]\nmin = \"-20 deg\"\nmax = \"80 deg\""),
    Feature("friction", Cart, "[joints.rail.friction]\ncoulomb = 0.4\nmu = 0.02\nstatic = 1.2"),
    Feature("friction of a pin", Cart, "[joints.hinge.friction]\nmu = 0.2\nradius = \"20 mm\""),
    Feature("smooth friction", Wheels, "[joints.axle.friction]\ncoulomb = 0.1\nvelocity = 0.05"),
    Feature(
        "contact",
        Cart,
        "[joints.pad]\ntype = \"contact\"\nbetween = [\"ground.floor\", \"arm.tip\"]\naxis = [1, 0]",
    ),
    Feature(
        "contact with friction",
        Cart,
        "[joints.shoe]\ntype = \"contact\"\nbetween = [\"ground.floor\", \"arm.tip\"]\naxis = [1, 0]\nrestitution = 0.2\nfriction = { mu = 0.3 }",
    ),
    Feature(
        "contact with a profile",
        Cart,
        "[joints.rim]\ntype = \"contact\"\nbetween = [\"ground.floor\", \"arm.tip\"]\nprofile = [[-2, -0.02], [0.7, -0.02], { to = [0.9, 0.18], radius = 0.2 }, [0.9, 2]]\nradius = 0.01",
    ),
    Feature("rope", Cart, "[joints.cord]\ntype = \"rope\"\nbetween = [\"ground.peg\", \"arm.tip\"]\nlength = 0.45"),
    Feature(
        "rope over a pulley",
        Cart,
        "[joints.line]\ntype = \"rope\"\nbetween = [\"ground.wall\", \"arm.tip\"]\nover = [{ on = \"ground.peg\", radius = 0.05, side = \"right\" }]\nlength = 2.12",
    ),
    Feature(
        "spring over a pulley",
        Cart,
        "[loads.band]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"arm.tip\"]\nover = [{ on = \"ground.peg\", radius = 0.05, side = \"right\" }]\nstiffness = 5\nlength = 1.9",
    ),
    Feature(
        "drum",
        Wheels,
        "[loads.winding]\ntype = \"spring\"\nbetween = [\"ground.peg\", { drum = \"drum\", radius = 0.1, side = \"left\" }]\nstiffness = 5\nlength = 1.8",
    ),
    Feature(
        "capstan",
        Cart,
        "[joints.capstan]\ntype = \"rope\"\nbetween = [\"ground.wall\", \"arm.tip\"]\nover = [{ on = \"ground.peg\", radius = 0.05, side = \"right\", mu = 0.2 }]\nlength = 2.14",
    ),
    Feature("freewheel", Wheels, "[joints.ratchet]\ntype = \"one_way\"\nbetween = [\"wheel\", \"drum\"]"),
    Feature(
        "brake",
        Wheels,
        "[joints.shoes]\ntype = \"brake\"\nbetween = [\"ground\", \"wheel\"]\nlevel = \"if(t < 0.2, 2, 0.1)\"",
    ),
    Feature(
        "brake by a state",
        Wheels,
        "[states]\npressure = { start = 1, rate = \"-10*pressure/1[s]\" }\n[joints.calliper]\ntype = \"brake\"\nbetween = [\"ground\", \"drum\"]\nlevel = \"0.3[N.m]*pressure\"",
    ),
    Feature(
        "brake by a sampled value",
        Wheels,
        "[sampled.controller]\nperiod = \"0.15 s\"\nvalues = { on = { start = 1, next = \"1 - on\" } }\n[joints.lock]\ntype = \"brake\"\nbetween = [\"ground\", \"wheel\"]\nlevel = \"0.2[N.m]*on\"",
    ),
    Feature(
        "clutch",
        Wheels,
        "[joints.plates]\ntype = \"clutch\"\nbetween = [\"wheel\", \"drum\"]\nlevel = \"0.2 N.m\"\nstatic = 1.3",
    ),
    Feature("gear", Wheels, "[joints.mesh]\ntype = \"gear\"\nbetween = [\"wheel\", \"drum\"]\nratio = -0.5"),
    Feature(
        "gear with backlash",
        Wheels,
        "[joints.loose]\ntype = \"gear\"\nbetween = [\"wheel\", \"drum\"]\nratio = -0.5\nbacklash = { play = 0.03, restitution = 0.2 }",
    ),
    Feature(
        "belt",
        Wheels,
        "[joints.band]\ntype = \"belt\"\nbetween = [\"wheel\", \"drum\"]\nfirst_radius = 0.1\nsecond_radius = 0.2",
    ),
    Feature(
        "rack",
        Both,
        "[joints.teeth]\ntype = \"rack\"\nbetween = [\"wheel\", \"box\"]\naxis = [1, 0]\nradius = 0.1",
    ),
    Feature(
        "screw",
        Both,
        "[joints.thread]\ntype = \"screw\"\nbetween = [\"drum\", \"box\"]\naxis = [1, 0]\nlead = 0.05",
    ),
    Feature(
        "spring",
        Cart,
        "[loads.coil]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"box\"]\nstiffness = 60\nlength = 0.4\ndamping = 1",
    ),
    Feature("damper", Cart, "[loads.pot]\ntype = \"damper\"\nbetween = [\"ground.peg\", \"arm.tip\"]\ndamping = 2"),
    Feature(
        "actuator",
        Cart,
        "[loads.ram]\ntype = \"actuator\"\nbetween = [\"ground.wall\", \"box\"]\nforce = \"2[N] - 4[N.s/m]*rate\"",
    ),
    Feature(
        "gas spring",
        Cart,
        "[loads.strut]\ntype = \"gas_spring\"\nbetween = [\"ground.peg\", \"arm.tip\"]\npush = 3\nlength = 0.5\ncolumn = 0.4\nexponent = 1.2",
    ),
    Feature(
        "torsion spring",
        Wheels,
        "[loads.twist]\ntype = \"torsion_spring\"\nbetween = [\"wheel\", \"drum\"]\nstiffness = 1.5",
    ),
    Feature(
        "motor",
        Wheels,
        "[loads.motor]\ntype = \"dc_motor\"\nbetween = [\"ground\", \"wheel\"]\nvoltage = \"6 V\"\nresistance = \"0.8 ohm\"\ninductance = \"4 mH\"\nconstant = \"0.05 N.m/A\"",
    ),
    Feature(
        "cylinder",
        Cart,
        "[loads.oil]\ntype = \"cylinder\"\nbetween = [\"ground.wall\", \"box\"]\nareas = [\"4 cm2\", \"2 cm2\"]\nvolumes = [\"2e-4 m3\", \"2e-4 m3\"]\nretracted = 0.3\nbulk = \"1 GPa\"\nopening = \"0.05 - rail.s/1[m]\"\nvalve = 1e-8\npressures = [\"0.3 MPa\", \"0.6 MPa\"]\nsupply = \"1 MPa\"\ntank = \"0.1 MPa\"",
    ),
    Feature(
        "controller",
        Cart,
        "[signals.force]\ntype = \"pid\"\nerror = \"0.1[m] - rail.s\"\nproportional = \"20 N/m\"\nintegral = \"5 N/m/s\"\nderivative = \"2 N.s/m\"\nfilter = \"20 ms\"\nmin = \"-5 N\"\nmax = \"5 N\"\n[loads.drive]\ntype = \"force\"\non = \"box\"\nvector = [\"force\", 0]",
    ),
    Feature(
        "sampled controller",
        Cart,
        "[signals.push]\ntype = \"pid\"\nerror = \"0.1[m] - rail.s\"\nproportional = \"20 N/m\"\nintegral = \"5 N/m/s\"\nmin = \"-5 N\"\nmax = \"5 N\"\nperiod = \"50 ms\"\n[loads.pusher]\ntype = \"force\"\non = \"box\"\nvector = [\"push\", 0]",
    ),
    Feature(
        "filter",
        Wheels,
        "[signals.smooth]\ntype = \"filter\"\ninput = \"axle.omega\"\ncutoff = \"20 rad/s\"\nunit = \"rad/s\"\n[loads.drag]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"-0.1[N.m.s]*smooth\"",
    ),
    Feature(
        "delay",
        Wheels,
        "[signals.late]\ntype = \"delay\"\ninput = \"axle.angle\"\ntime = \"30 ms\"\n[loads.late_spring]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"-0.5[N.m]*late\"",
    ),
    Feature(
        "state of a load",
        Cart,
        "[states]\nlag = { start = 0, rate = \"(rail.v - lag)/0.1[s]\", unit = \"m/s\" }\n[loads.lagging]\ntype = \"force\"\non = \"box\"\nvector = [\"-3[N.s/m]*lag\", 0]",
    ),
    Feature("state", Nothing, "[states]\nidle = { start = 1, rate = \"-idle/1[s]\" }"),
    Feature(
        "sampled value",
        Nothing,
        "[sampled.clock]\nperiod = \"0.07 s\"\nvalues = { count = { start = 0, next = \"count + 1\" } }",
    ),
    Feature(
        "removed spring",
        Cart,
        "[loads.catch]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"box\"]\nstiffness = 40\nlength = 0.6\n[events.snap]\nwhen = \"t > 0.3\"\nremove = [\"catch\"]",
    ),
    Feature(
        "removed brake",
        Wheels,
        "[joints.hold]\ntype = \"brake\"\nbetween = [\"ground\", \"wheel\"]\nlevel = \"3 N.m\"\n[events.free]\nwhen = \"t > 0.25\"\nremove = [\"hold\"]",
    ),
    Feature(
        "lock by events",
        Wheels,
        "[joints.detent]\ntype = \"lock\"\njoint = \"axle\"\nengaged = false\n[events.detain]\nwhen = \"t > 0.2\"\nengage = [\"detent\"]\n[events.let_go]\nwhen = \"t > 0.4\"\nrelease = [\"detent\"]",
    ),
    Feature(
        "rod by an event",
        Cart,
        "[joints.tie]\ntype = \"distance\"\nbetween = [\"ground.wall\", \"arm.tip\"]\nengaged = false\n[events.tied]\nwhen = \"t > 0.25\"\nengage = [\"tie\"]",
    ),
    Feature(
        "weld by an event",
        Cart,
        "[joints.glue]\ntype = \"weld\"\nbetween = [\"box\", \"arm\"]\nengaged = false\n[events.glued]\nwhen = \"t > 0.35\"\nengage = [\"glue\"]",
    ),
    Feature(
        "gear by an event",
        Wheels,
        "[joints.shift]\ntype = \"gear\"\nbetween = [\"wheel\", \"drum\"]\nratio = -0.5\nengaged = false\n[events.shifted]\nwhen = \"t > 0.2\"\nengage = [\"shift\"]",
    ),
    Feature(
        "belt by an event",
        Wheels,
        "[joints.tightened]\ntype = \"belt\"\nbetween = [\"wheel\", \"drum\"]\nfirst_radius = 0.1\nsecond_radius = 0.2\nengaged = false\n[events.tightens]\nwhen = \"t > 0.3\"\nengage = [\"tightened\"]",
    ),
    Feature(
        "rack by an event",
        Both,
        "[joints.meshed]\ntype = \"rack\"\nbetween = [\"wheel\", \"box\"]\naxis = [1, 0]\nradius = 0.1\nengaged = false\n[events.meshes]\nwhen = \"t > 0.25\"\nengage = [\"meshed\"]",
    ),
    Feature(
        "screw by an event",
        Both,
        "[joints.half_nut]\ntype = \"screw\"\nbetween = [\"drum\", \"box\"]\naxis = [1, 0]\nlead = 0.05\nengaged = false\n[events.closes_nut]\nwhen = \"t > 0.15\"\nengage = [\"half_nut\"]",
    ),
    Feature("rate by an event", Cart, "[events.kick]\nwhen = \"t > 0.15\"\nset = { \"rail.v\" = 0.5 }"),
    Feature(
        "state by an event",
        Wheels,
        "[states]\nfilled = { start = 0, rate = \"1[1/s]\" }\n[loads.filling]\ntype = \"torque\"\non = \"drum\"\nvalue = \"filled*1[N.m]\"\n[events.emptied]\nwhen = \"t > 0.3\"\nset = { filled = 0 }",
    ),
    Feature("friction by a law", Wheels, "[joints.axle.friction]\ncoulomb = \"0.1 + 0.02*abs(axle.omega)\""),
    Feature(
        "belt that slips by its wrap",
        Wheels,
        "[joints.strap]\ntype = \"belt\"\nbetween = [\"wheel\", \"drum\"]\nfirst_radius = 0.1\nsecond_radius = 0.2\nfriction = { mu = 0.3, wrap = 2.8, pretension = \"2 N\" }",
    ),
    Feature(
        "outlines",
        Nothing,
        "[bodies.box.outline]\npolygon = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]\n[ground.outline]\npolygon = [[-5, -2], [5, -2], [5, -1.8], [-5, -1.8]]\n[clearance]\npairs = [[\"box\", \"ground\"]]",
    ),
    Feature("event", Nothing, "[events.late]\nwhen = \"t > 10\"\nstop = true"),
    Feature(
        "input",
        Nothing,
        "[inputs]\nextra = { start = 0 }\n[loads.extra_pull]\ntype = \"force\"\non = \"box\"\nvector = [\"extra*1[N]\", 0]",
    ),
    Feature("driver", Wheels, "[drivers.crank]\njoint = \"shaft\"\nangle = \"2*t\""),
];

/// A scene with features; tables that several of them add to are joined.
fn scene(features: &[&Feature]) -> String {
    let mut text = BASE.to_owned();
    let mut tables: BTreeMap<&str, String> = BTreeMap::new();
    for Feature(_, _, added) in features {
        let mut table = "";
        for line in added.lines() {
            match line.starts_with('[') {
                true => table = line,
                false => tables.entry(table).or_default().push_str(&format!("{line}\n")),
            }
        }
    }
    for (table, lines) in tables {
        let _ = write!(text, "{table}\n{lines}");
    }
    text
}

/// What a command gives: nothing that matters here, or the name of its refusal.
type Answer = Result<(), String>;

fn codes(faults: &Faults) -> String {
    run::message(faults);
    faults
        .list
        .iter()
        .find(|own| own.severity == Severity::Error)
        .map_or_else(|| "none".to_owned(), |fault| fault.code.to_owned())
}

fn of_study<T>(result: Result<T, StudyError>) -> Answer {
    result.map(|_| ()).map_err(|error| match error {
        StudyError::Scene(faults) => codes(&faults),
        StudyError::Analysis(failure) => {
            run::message(&failure);
            named(&format!("{failure:?}"))
        }
    })
}

/// The name of a variant.
fn named(debug: &str) -> String {
    debug.split(|own: char| !own.is_alphanumeric() && own != '_').next().unwrap_or_default().to_owned()
}

fn of_run<T>(result: Result<T, InstanceError>) -> Answer {
    result.map(|_| ()).map_err(|error| {
        run::message(&error);
        format!("run {}", named(&format!("{error:?}")))
    })
}

fn simulated(compiled: &Compiled, engine: Engine) -> Result<Instance, InstanceError> {
    let model = Arc::new(Model::new(compiled.program.clone()).expect("a sound program"));
    let mut instance = Instance::new(model);
    let stop = compiled.description.experiment.stop;
    instance.setup(0.0, Some(stop), None)?;
    if engine != Engine::Taylor {
        instance.set_engine(engine)?;
    }
    instance.initialise()?;
    for step in 1..=6 {
        instance.step_to(stop * f64::from(step) / 6.0)?;
    }
    Ok(instance)
}

/// A call that has not ended by then never does.
const PATIENCE: Duration = Duration::from_secs(60);

thread_local! {
    static UNTIL: Cell<Option<Instant>> = const { Cell::new(None) };
}

fn has_lost_patience() -> bool {
    UNTIL.get().is_some_and(|until| Instant::now() > until)
}

/// A call of a command: its answer or refusal, or why there is neither.
fn called(run: impl FnOnce() -> Answer) -> Result<Answer, String> {
    UNTIL.set(Some(Instant::now() + PATIENCE));
    let answer = contain(run);
    let lost = has_lost_patience();
    UNTIL.set(None);
    if lost { Err("does not end".to_owned()) } else { answer }
}

/// How far the power balance of a run may be open, as a share of the largest power, and where it is looked at.
const OPEN: f64 = 1e-7;
const PLACES: u32 = 7;

/// What commands are asked for by name.
struct Names<'a> {
    parameter: &'a str,
    input: &'a str,
}

/// The names in scenes with features.
const OF_FEATURES: Names = Names { parameter: "gain", input: "axle" };

/// Every command of a scene, with its name.
fn commands(text: &str, names: &Names) -> Vec<(&'static str, Result<Answer, String>)> {
    let Ok(scene) = Scene::from_toml(text) else { panic!("not a scene: {text}") };
    let compiled = contain(|| compile(&scene));
    let compiled = match compiled {
        Ok(Ok(compiled)) => compiled,
        Ok(Err(faults)) => return vec![("check", Ok(Err(codes(&faults))))],
        Err(panic) => return vec![("check", Err(panic))],
    };
    if let Ok(Some(gap)) = contain(|| largest_gap(&scene, compiled.description.experiment.stop, PLACES))
        && (gap.is_nan() || gap > OPEN)
    {
        return vec![("power balance", Err(format!("open by {gap:e}")))];
    }
    let opened = || Study::new(&scene);
    let engines = [("simulate", Engine::Taylor), ("explicit", Engine::Dop853), ("implicit", Engine::Radau)];
    let mut done = vec![("check", Ok(Ok(())))];
    for (name, engine) in engines {
        done.push((name, called(|| of_run(simulated(&compiled, engine)))));
        if done.last().is_some_and(|(_, answer)| answer.is_err()) {
            // What does not end here ends nowhere.
            return done;
        }
    }
    let exported =
        |version| compiled.pack_fmu(version, Vec::new(), &[]).map(|_| ()).map_err(|error| named(&format!("{error:?}")));
    done.push(("export 2", called(|| exported(FmiVersion::V2))));
    done.push(("export 3", called(|| exported(FmiVersion::V3))));
    let sourced = |method, real| {
        let mechanism = scene.resolve().map_err(|faults| codes(&faults))?.mechanism;
        let step = FixedStep { step: 1e-4, substeps: 1, method, real };
        let text = c_file(&compiled.program, &mechanism, &compiled.description, &scene.source, step);
        text.map(|_| ()).map_err(|faults| codes(&faults))
    };
    done.push(("sources", called(|| sourced(SourceMethod::RungeKutta, Real::Double))));
    done.push(("sources by series", called(|| sourced(SourceMethod::Taylor, Real::Double))));
    done.push(("sources in single precision", called(|| sourced(SourceMethod::RungeKutta, Real::Float))));
    let study_of = |run: &dyn Fn(&mut Study) -> Answer| match opened() {
        Ok(mut study) => run(&mut study),
        Err(faults) => Err(codes(&faults)),
    };
    done.push(("linearize", called(|| study_of(&|own| of_study(own.linearize(&LinearisedAt::Times(vec![0.1])))))));
    done.push(("modes", called(|| study_of(&|own| of_study(own.modes(Some(0.1)))))));
    done.push(("modes at rest", called(|| study_of(&|own| of_study(own.modes(None))))));
    done.push(("equilibrium", called(|| study_of(&|own| of_study(own.equilibrium())))));
    done.push((
        "sensitivities",
        called(|| study_of(&|own| of_study(own.sensitivities(&[names.parameter.to_owned()], &[0.1, 0.4])))),
    ));
    let request = MotionRequest { input: Some(names.input.to_owned()), speed: Some(1.0), ..MotionRequest::default() };
    let moved = || study(&scene, &request).map(|_| ()).map_err(|error| named(&format!("{error:?}")));
    done.push(("motion", called(moved)));
    let swept = || compiled.simulate_many(&[vec![(names.parameter, 0.9)], vec![(names.parameter, 1.1)]]);
    done.push(("sweep", called(|| swept().map(|_| ()).map_err(|error| named(&format!("{error:?}"))))));
    done.push(("fit", called(|| fitted(&scene, &compiled, names))));
    done.push(("equations", called(|| equations(&scene, EquationFormat::Text).map(|_| ()).map_err(|own| codes(&own)))));
    done.push(("code", called(|| equations(&scene, EquationFormat::C).map(|_| ()).map_err(|own| codes(&own)))));
    done.push(("lesson", called(|| steps(&scene, Prose::Text).map(|_| ()).map_err(|own| codes(&own)))));
    done.push(("page", called(|| cotree_page::moving::page(&scene, None).map(|_| ()).map_err(|own| codes(&own)))));
    done
}

/// Fits what the scene itself has moved with, from elsewhere.
fn fitted(scene: &Scene, compiled: &Compiled, names: &Names) -> Answer {
    let run = |error: &dyn std::fmt::Debug| named(&format!("{error:?}"));
    let results = compiled.simulate().map_err(|error| run(&error))?;
    let Some(output) = results.columns().first() else { return Err("no outputs".to_owned()) };
    let (name, seen) = (output.name.clone(), output.values.clone());
    let table = CsvTable::new(vec![name.clone()], results.times().to_vec(), vec![seen]).expect("a table");
    let vary = vec![Vary::read(names.parameter).expect("a name")];
    let request = FitRequest { tables: vec![table], vary, deviations: Vec::new() };
    let mut study = Study::asking(scene, &Requested::these([&*name])).map_err(|faults| codes(&faults))?;
    fit(&mut [std::mem::replace(&mut study, Study::new(scene).map_err(|own| codes(&own))?)], &request)
        .map(|_| ())
        .map_err(|error| run(&error))
}

/// What has come of all calls.
#[derive(Default)]
struct Counts {
    answers: usize,
    refusals: BTreeMap<String, usize>,
    panics: Vec<String>,
}

impl Counts {
    fn add(&mut self, name: &str, text: &str, names: &Names) {
        for (command, answer) in commands(text, names) {
            match answer {
                Ok(Ok(())) => self.answers += 1,
                Ok(Err(code)) => *self.refusals.entry(format!("{command}: {code}")).or_default() += 1,
                Err(panic) => self.panics.push(format!("{name}, {command}: {panic}")),
            }
        }
    }

    fn say(&self, of: &str) {
        let refused: usize = self.refusals.values().sum();
        println!(
            "{of}: {} answers, {refused} refusals, {} panics or calls without an end",
            self.answers,
            self.panics.len()
        );
        self.refusals.iter().for_each(|(code, count)| println!("    {count:5} {code}"));
        assert!(self.panics.is_empty(), "{}", self.panics.join("\n"));
    }
}

/// The last values of the outputs of the cart and of the wheels; none if it does not run.
fn last(text: &str) -> Option<[Vec<f64>; 2]> {
    let compiled = compile(&Scene::from_toml(text).ok()?).ok()?;
    let results = compiled.simulate().ok()?;
    let of = |names: &[&str]| {
        names.iter().map(|name| *results.get(name).expect("an output").last().expect("a row")).collect()
    };
    Some([
        of(&["rail.s", "rail.v", "hinge.angle", "hinge.omega"]),
        of(&["axle.angle", "axle.omega", "shaft.angle", "shaft.omega"]),
    ])
}

/// Runs of a pair against those of its features alone; how many were compared, and what differs.
fn compare(singles: &[Option<[Vec<f64>; 2]>], [a, b]: [usize; 2]) -> (usize, Vec<String>) {
    let (one, other) = (&FEATURES[a], &FEATURES[b]);
    let acts = [one.1, other.1];
    if acts.contains(&Both) {
        return (0, Vec::new());
    }
    let Some(both) = last(&scene(&[one, other])) else { return (0, Vec::new()) };
    let mut wrong = Vec::new();
    let mut compared = 0;
    for (place, side) in [Cart, Wheels].into_iter().enumerate() {
        // The feature that acts on this side alone says how it moves; what couples both sides says nothing of either.
        let acting: Vec<usize> = [0, 1].into_iter().filter(|&own| acts[own] == side).collect();
        let single = match acting[..] {
            [] => &singles[[a, b][0]],
            [own] => &singles[[a, b][own]],
            _ => continue,
        };
        let Some(single) = single else { continue };
        compared += 1;
        if run::distance(&both[place], &single[place]) > 1e-5 {
            wrong.push(format!("{} beside {}: {:?} is {:?} alone", one.0, other.0, both[place], single[place]));
        }
    }
    (compared, wrong)
}

fn pairs() -> Vec<[usize; 2]> {
    (0..FEATURES.len()).flat_map(|a| (0..a).map(move |b| [b, a])).collect()
}

fn meet(pairs: &[[usize; 2]], name: &str) {
    listen(has_lost_patience);
    let singles: Vec<_> = FEATURES.iter().map(|own| last(&scene(&[own]))).collect();
    for (own, single) in FEATURES.iter().zip(&singles) {
        assert!(single.is_some(), "`{}` does not run alone", own.0);
    }
    let (mut counts, mut compared, mut wrong) = (Counts::default(), 0, Vec::new());
    for &[a, b] in pairs {
        counts.add(
            &format!("{} and {}", FEATURES[a].0, FEATURES[b].0),
            &scene(&[&FEATURES[a], &FEATURES[b]]),
            &OF_FEATURES,
        );
        let (more, differ) = compare(&singles, [a, b]);
        compared += more;
        wrong.extend(differ);
    }
    println!("{compared} motions compared with those of one feature alone");
    counts.say(name);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_feature_alone_runs() {
    for own in FEATURES {
        let text = scene(&[own]);
        let compiled = run::compiled(&text);
        compiled.simulate().unwrap_or_else(|error| panic!("{}: {error}", own.0));
    }
}

/// Each feature with its neighbours and with those far from it.
#[test]
fn pairs_of_features_are_answered_or_refused() {
    let sample: Vec<[usize; 2]> =
        pairs().into_iter().enumerate().filter(|(place, _)| place % 61 == 5).map(|(_, pair)| pair).collect();
    meet(&sample, "pairs, a sample");
}

/// Pairs that change modes without end where what they hold together is not shared.
#[test]
fn pairs_that_hold_one_motion_together_end() {
    let place = |name: &str| FEATURES.iter().position(|own| own.0 == name).expect("a feature");
    let pairs = [["limit", "limits of an angle"], ["limit", "contact"], ["friction of a pin", "contact with friction"]];
    meet(&pairs.map(|pair| pair.map(place)), "pairs that hold one motion");
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn all_pairs_of_features_are_answered_or_refused() {
    meet(&pairs(), "all pairs");
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn triples_of_features_are_answered_or_refused() {
    listen(has_lost_patience);
    let mut counts = Counts::default();
    for (place, [a, b]) in pairs().into_iter().enumerate().filter(|(place, _)| place % 3 == 0) {
        let c = (a + b + 1 + place) % FEATURES.len();
        if c != a && c != b {
            let names = [a, b, c].map(|own| FEATURES[own].0).join(", ");
            counts.add(&names, &scene(&[&FEATURES[a], &FEATURES[b], &FEATURES[c]]), &OF_FEATURES);
        }
    }
    counts.say("triples");
}

/// A state that nobody reads changes nothing, in no scene and by no method.
#[test]
fn a_state_that_nobody_reads_changes_no_result() {
    const IDLE: &str = "\n[states.unread]\nstart = 1\nrate = \"-unread/1[s]\"\n";
    let mut compared = 0;
    for name in run::models() {
        let text = run::scene_of(&name);
        if text.contains("\n[states]") || text.trim_start().starts_with('{') {
            continue;
        }
        let plain = run::compiled(&text);
        if plain.program.is_driven() {
            continue;
        }
        let more = run::compiled(&format!("{text}{IDLE}"));
        for engine in [Engine::Dop853, Engine::Radau] {
            let end = |compiled: &Compiled| {
                let model = Arc::new(Model::new(compiled.program.clone()).expect("a sound program"));
                let stop = compiled.description.experiment.stop.min(0.5);
                let mut instance = run::started(&model, Some(engine), stop, 1e-9);
                instance.step_to(stop).unwrap_or_else(|error| panic!("{name} by {engine:?}: {error}"));
                let n = model.program().mechanical();
                let state = instance.state();
                [&state.positions()[..n], &state.rates()[..n]].concat()
            };
            let apart = run::distance(&end(&more), &end(&plain));
            assert!(apart < 1e-6, "{name} by {engine:?}: {apart:e}");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

/// What is added to a model of the gallery, at its first joint that turns, JOINT, with its body, BODY.
const ADDITIONS: &[(&str, &str)] = &[
    ("friction", "[joints.JOINT.friction]\ncoulomb = \"0.01[N.m]*crossed\""),
    ("limit", "[joints.JOINT.limits]\nmax = 1.5\nrestitution = 0.3"),
    (
        "brake",
        "[joints.crossed_brake]\ntype = \"brake\"\nbetween = [\"ground\", \"BODY\"]\nlevel = \"if(t < 0.1, 0.05, 0.01)[N.m]*crossed\"",
    ),
    ("freewheel", "[joints.crossed_ratchet]\ntype = \"one_way\"\nbetween = [\"ground\", \"BODY\"]"),
    ("rope", "[joints.crossed_rope]\ntype = \"rope\"\nbetween = [\"ground\", \"BODY\"]\nlength = 20"),
    (
        "motor",
        "[loads.crossed_motor]\ntype = \"dc_motor\"\nbetween = [\"ground\", \"BODY\"]\nvoltage = \"0.1 V\"\nresistance = \"0.8 ohm\"\ninductance = \"4 mH\"\nconstant = \"0.05 N.m/A\"",
    ),
    (
        "controller",
        "[signals.crossed_torque]\ntype = \"pid\"\nerror = \"0.2[rad] - BODY.angle\"\nproportional = \"0.1 N.m/rad\"\nintegral = \"0.1 N.m/rad/s\"\nmin = \"-0.1 N.m\"\nmax = \"0.1 N.m\"\n[loads.crossed_drive]\ntype = \"torque\"\non = \"BODY\"\nvalue = \"crossed_torque\"",
    ),
    ("state", "[states.crossed_state]\nstart = 1\nrate = \"-crossed_state/1[s]\""),
    (
        "sampled value",
        "[sampled.crossed_clock]\nperiod = \"0.07 s\"\nvalues = { crossed_count = { start = 0, next = \"crossed_count + 1\" } }",
    ),
    ("event", "[events.crossed_event]\nwhen = \"BODY.angle > 0.4\"\nstop = true"),
];

/// The first joint that turns, with neither friction nor limits, in a scene whose joints have tables with headers, and its body.
fn turning_joint(text: &str) -> Option<(&str, &str)> {
    text.split("\n[joints.").skip(1).find_map(|table| {
        let (name, rest) = table.split_once(']')?;
        let keys = rest.split("\n[").next()?;
        let ends = keys.lines().find(|line| line.starts_with("between"))?;
        let body = ends.split('"').skip(1).step_by(2).map(|end| end.split('.').next().unwrap_or(end));
        let body = body.into_iter().find(|body| *body != "ground")?;
        let is_plain = !name.contains('.') && !keys.contains("friction") && !keys.contains("limits");
        (keys.contains("\"revolute\"") && is_plain).then_some((name, body))
    })
}

/// Models of the gallery with additions; how many scenes there were.
fn cross(wanted: impl Fn(usize, usize) -> bool) -> usize {
    listen(has_lost_patience);
    let (mut counts, mut scenes) = (Counts::default(), 0);
    for (place, model) in run::models().iter().enumerate() {
        let text = run::scene_of(model);
        let Some((joint, body)) = turning_joint(&text) else { continue };
        for (_, (name, addition)) in ADDITIONS.iter().enumerate().filter(|(which, _)| wanted(place, *which)) {
            let addition = addition.replace("JOINT", joint).replace("BODY", body);
            let crossed = format!(
                "{text}\n[parameters.crossed]\nvalue = 1.0\ntunable = true\n[loads.crossed_load]\ntype = \"torque\"\non = \"{body}\"\nvalue = \"0.001[N.m]*crossed\"\n{addition}\n"
            );
            counts.add(&format!("{model} with {name}"), &crossed, &Names { parameter: "crossed", input: joint });
            scenes += 1;
        }
    }
    counts.say("models with additions");
    assert!(counts.answers > 5 * scenes, "hardly anything is answered");
    scenes
}

#[test]
fn some_models_with_additions_are_answered_or_refused() {
    assert!(cross(|place, which| place % 16 == 3 && which == place % ADDITIONS.len()) > 1);
}

#[test]
#[ignore = "minutes: .ci/nightly"]
fn models_with_additions_are_answered_or_refused() {
    assert!(cross(|place, which| (which + place) % 3 == 0) > 100);
}
