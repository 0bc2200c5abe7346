//! Laws that are written once under a name: the scene is the one with the laws written out, to the last bit, in parts too; and what is wrong with a
//! signal is said once, where it is.

use crate::support::run;

use cotree::compile::compile;
use cotree::model::Exponents;
use cotree::scene::{Body, Joint, Load, Scene, Signal};
use run::{compiled, sound};

/// An arm on a cylinder whose two chambers are the speeds of two slides, and the valve that a sensor of its length moves.
const ARM: &str = r#"
name = "arm"
[parameters]
reach = "1 m"
rest = "sqrt(0.125)*reach"
area = "0.01 m2"
gain = 0.2
supply = "200 bar"
[inputs]
offset = "0 m"
SIGNALS
[ground.points]
clevis = [0, "-reach/4"]
[bodies.arm]
mass = 120
inertia = 10
points = { hub = ["-reach/2", 0], clevis = ["-reach/4", 0] }
[bodies.low]
mass = 1
[bodies.high]
mass = 1
[joints.hub]
type = "revolute"
between = ["ground", "arm.hub"]
[joints.one]
type = "prismatic"
between = ["ground", "low"]
axis = [1, 0]
[joints.two]
type = "prismatic"
between = ["ground", "high"]
axis = [1, 0]
[loads.cylinder]
type = "actuator"
between = ["ground.clevis", "arm.clevis"]
force = "area*(LOWER - UPPER) - 2e5*rate"
[loads.build_low]
type = "force"
on = "low"
vector = ["INTO*if(SPOOL >= 0, supply - LOWER, LOWER) - 1e3*cylinder.rate", 0]
[loads.build_high]
type = "force"
on = "high"
vector = ["1e3*cylinder.rate - INTO*if(-(SPOOL) >= 0, supply - UPPER, UPPER)", 0]
[initial]
"arm.angle" = 0
"one.v" = 2
"two.v" = 2
[outputs]
variables = ["arm.angle", "cylinder.force", "one.v"]
error = "WANTED - cylinder.length"
[experiment]
stop = "0.05 s"
"#;

/// The names of its signals and what they say, written out with the others.
const LAWS: [(&str, &str); 5] = [
    ("LOWER", "1e6*one.v"),
    ("UPPER", "1e6*two.v"),
    ("WANTED", "rest + offset + 0.1*(max(0.5, min(1.5, 1 - cos(pi*t))) - 0.5)"),
    ("SPOOL", "gain*((WANTED) - cylinder.length)"),
    ("INTO", "1e-6*(SPOOL)"),
];

fn written(signals: bool) -> String {
    let mut text = ARM.to_owned();
    if signals {
        let lines: String = LAWS.iter().rev().map(|(name, law)| format!("{name} = \"{law}\"\n")).collect();
        return text.replace("SIGNALS", &format!("[signals]\n{lines}"));
    }
    for (name, law) in LAWS.iter().rev() {
        text = text.replace(name, &format!("({law})"));
    }
    text.replacen("SIGNALS\n", "", 1)
}

fn bytes(text: &str) -> Vec<u8> {
    compiled(text).program.to_bytes().expect("a program")
}

#[test]
fn a_law_with_a_name_is_the_law_written_out_to_the_last_bit() {
    let (named, copied) = (written(true), written(false));
    assert!(bytes(&named) == bytes(&copied), "\n{named}\n{copied}");
}

/// One rope over two pulleys: three actuators with the same tension.
#[test]
fn one_tension_of_three_actuators() {
    let law = "max(0, stiffness*(a.length + b.length + c.length - rope) + 40*(a.rate + b.rate + c.rate))";
    let scene = |signals: &str, tension: &str| {
        let actuator = |name: &str, at: &str, to: &str| {
            format!(
                "[loads.{name}]\ntype = \"actuator\"\nbetween = [\"ground.{at}\", \"{to}\"]\nforce = \"-{tension}\"\n"
            )
        };
        let guide = |name: &str, body: &str, x: f64| {
            format!(
                "[bodies.{body}]\nmass = 3\n[joints.{name}]\ntype = \"prismatic\"\nbetween = [\"ground\", \"{body}\"]\naxis = [{x}, 1]\n"
            )
        };
        [
            format!("name = \"rope\"\ngravity = [0, -9.81]\n[parameters]\nrope = \"3 m\"\nstiffness = \"20 kN/m\"\n{signals}"),
            "[ground.points]\nhook = [0, 2]\nleft = [0.2, 2]\nright = [0.5, 2]\n".to_owned(),
            guide("one", "block", 0.0) + &guide("two", "weight", 0.1),
            actuator("a", "hook", "block") + &actuator("b", "left", "block") + &actuator("c", "right", "weight"),
            "[outputs]\nvariables = [\"block.y\", \"weight.y\", \"a.force\"]\n".to_owned(),
        ]
        .concat()
    };
    let named = scene(&format!("[signals]\ntension = {{ value = \"{law}\", unit = \"N\" }}\n"), "tension");
    assert_eq!(bytes(&named), bytes(&scene("", law)));
}

const SLED: &str = r#"
name = "sled"
[parameters]
k = "50 N/m"
[bodies.sled]
mass = 2.0
[joints.guide]
type = "prismatic"
between = ["ground", "sled"]
axis = [1, 0]
"#;
const PUSH: &str = "[loads.push]\ntype = \"force\"\non = \"sled\"\nvector = [\"PUSH\", 0]\n";

fn sled(signals: &str, push: &str, more: &str) -> String {
    format!("{SLED}[signals]\n{signals}\n{}{more}", PUSH.replace("PUSH", push))
}

/// Codes and messages of all that is said of a scene.
fn said(text: &str) -> Vec<String> {
    let found = Scene::from_toml(text).and_then(|scene| compile(&scene));
    let faults = match found {
        Ok(compiled) => compiled.warnings.map(|faults| faults.list).unwrap_or_default(),
        Err(faults) => faults.list,
    };
    let messages = faults.into_iter().map(|fault| format!("{} {}", fault.code, fault.message));
    // Only some of the scenes have a use for it.
    messages.filter(|message| message != "scene::unused nothing uses parameter `k`").collect()
}

fn says(text: &str, wanted: &str) {
    let said = said(text);
    assert!(matches!(&said[..], [one] if one.starts_with(wanted)), "{wanted}: {said:#?}\n{text}");
}

/// It is a variable of the FMU where it is an output, with its own words and unit, and nowhere else.
#[test]
fn a_signal_is_a_variable_only_as_an_output() {
    let table = "pull = { value = \"-k*guide.s\", unit = \"kN\", description = \"back to the middle\" }";
    let named = |text: &str| compiled(text).description.variables.into_iter().find(|variable| variable.name == "pull");
    assert!(named(&sled(table, "pull", "")).is_none());
    let own = named(&sled(table, "pull", "[outputs]\nvariables = [\"pull\", \"guide.s\"]\n")).expect("an output");
    assert_eq!(own.description, "back to the middle");
    assert_eq!(own.unit.display.map(|unit| unit.name).as_deref(), Some("kN"));
    let bare = named(&sled("pull = \"-k*guide.s\"", "0", "[outputs]\nvariables = [\"pull\"]\n")).expect("an output");
    assert_eq!((bare.description.as_str(), bare.unit.exponents), ("-k*guide.s", Exponents::NEWTON));
    let text = sled(table, "pull", "[outputs]\nvariables = [\"pull\"]\n[initial]\n\"guide.s\" = 0.1\n");
    let mut instance = run::started(&run::model(&text), None, 1.0, 1e-9);
    assert_eq!(run::value(&mut instance, "pull"), -5.0);
}

/// A number that stands alone is in the unit of the signal, like that of a parameter; so says the check of anything else.
#[test]
fn units() {
    let value = |signal: &str| {
        let text = sled(&format!("s = {signal}"), "0", "[outputs]\nvariables = [\"s\"]\n");
        run::value(&mut run::started(&run::model(&text), None, 1.0, 1e-9), "s")
    };
    assert_eq!(value("{ value = 5, unit = \"mm\" }"), 0.005);
    assert_eq!(value("{ value = \"5 mm\", unit = \"cm\" }"), 0.005);
    assert_eq!(value("\"2[mm]*2.5\""), 0.005);
    let said = |signal: &str, wanted: &str| says(&sled(&format!("s = {signal}"), "s", ""), wanted);
    said("{ value = \"k*guide.v\", unit = \"N\" }", "scene::wrong_unit signal `s` is in `");
    said("{ value = 3, unit = \"m\" }", "scene::wrong_unit `vector` of force `push` must be a force");
    said(
        "{ value = \"0.1*sin(t)\", unit = \"kN\" }",
        "scene::unit_in_expression signal `s` is an expression without a unit, so it is in `N`",
    );
    said("\"guide.s\"", "scene::wrong_unit");
    said("{ value = 3, unit = \"newtons\" }", "scene::unknown_unit");
}

#[test]
fn one_slip_is_one_fault() {
    let used = "a + 2*a - b";
    says(
        &sled("a = \"b + 1\"\nb = \"2*a\"", used, ""),
        "scene::cycle signals depend on each other in a cycle: `a` -> `b` -> `a`",
    );
    says(&sled("a = \"a\"\nb = 1", used, ""), "scene::cycle signals depend on each other in a cycle: `a` -> `a`");
    says(
        &sled("a = \"kk*t\"\nb = \"a\"", used, ""),
        "scene::unknown_name signal `a` uses a name that is not in the scene: `kk`",
    );
    says(&sled("a = \"k*guide.w\"\nb = \"a\"", used, ""), "scene::unknown_variable signal `a`");
    says(&sled("a = \"2*(t\"\nb = \"a\"", used, ""), "scene::bad_expression");
    says(&sled("a = \"1/0\"\nb = \"a\"", used, ""), "scene::not_finite signal `a` is not a finite number");
    says(
        &sled("a = { valu = 1 }\nb = \"a\"", used, "").replace("valu ", "value = 1, colour "),
        "scene::unknown_key signal `a` has no key `colour`",
    );
    says(&sled("a = true\nb = \"a\"", used, ""), "scene::wrong_type signal `a`");
    says(&sled("a = 1\nb = 2\nc = 3", used, ""), "scene::unused nothing uses signal `c`");
    says(
        &sled("k = 1", "k*guide.s", ""),
        "scene::duplicate_name the name `k` is used twice: as parameter and as signal",
    );
    says(&sled("a = 1", "a", "[outputs]\na = \"2*a\"\n"), "scene::duplicate_name output `a` has the name of a signal");
    says(
        &sled("a = \"energy.kinetic\"", "a + 3*a", ""),
        "scene::load_depends `vector` of force `push` depends on `energy.kinetic` (in signal `a`), a sum over the whole system",
    );
    let spring = "[loads.coil]\ntype = \"spring\"\nbetween = [\"ground\", \"sled\"]\nstiffness = \"a\"\n";
    says(
        &sled("a = 3", "a", spring),
        "scene::not_constant `stiffness` of spring `coil` must be constant, but uses the signal `a`",
    );
    let driver = "[drivers.motor]\njoint = \"guide\"\ndisplacement = \"a\"\n";
    says(&sled("a = \"guide.v*t\"", "0", driver), "scene::driver_depends `displacement` of");
    assert_eq!(said(&sled("a = \"0.1[m]*sin(t)\"", "0", driver)), [""; 0]);
}

/// Each signal uses the last one twice: nobody could write that out.
#[test]
fn long_chains_of_signals_are_refused() {
    let chain = |count: usize, law: &dyn Fn(usize) -> String| {
        let mut lines = String::from("s0 = \"t\"\n");
        (1..count).for_each(|index| lines += &format!("s{index} = \"{}\"\n", law(index - 1)));
        sled(&lines, &format!("s{}", count - 1), "")
    };
    says(&chain(60, &|last| format!("s{last}*s{last}")), "scene::too_large the scene is too large: signal `s16`");
    says(&chain(5000, &|last| format!("-s{last}")), "scene::too_large");
    assert_eq!(said(&chain(200, &|last| format!("-s{last}"))), [""; 0]);
}

#[test]
fn built_in_rust_and_read_from_json() {
    let built = Scene::new("sled")
        .parameter("k", "50 N/m")
        .signal("pull", Signal::new("-k*guide.s").unit("N").description("back"))
        .signal("twice", "2*pull")
        .body("sled", Body::new().mass(2.0))
        .joint("guide", Joint::prismatic("ground", "sled", [1, 0]))
        .load("push", Load::force("sled", ("twice", 0)))
        .output("pull");
    let table = "pull = { value = \"-k*guide.s\", unit = \"N\", description = \"back\" }\ntwice = \"2*pull\"";
    let read = sound(Scene::from_toml(&sled(table, "twice", "[outputs]\nvariables = [\"pull\"]\n")));
    let json = r#"{ "name": "sled", "parameters": { "k": "50 N/m" },
        "signals": { "pull": { "value": "-k*guide.s", "unit": "N", "description": "back" }, "twice": "2*pull" },
        "bodies": { "sled": { "mass": 2.0 } },
        "joints": { "guide": { "type": "prismatic", "between": ["ground", "sled"], "axis": [1, 0] } },
        "loads": { "push": { "type": "force", "on": "sled", "vector": ["twice", 0] } },
        "outputs": { "variables": ["pull"] } }"#;
    let programs = [built, read, sound(Scene::from_json(json))]
        .map(|scene| sound(compile(&scene)).program.to_bytes().expect("a program"));
    assert!(programs[0] == programs[1] && programs[1] == programs[2]);
}

/// Files that are removed again, and the scene in the last of them.
fn scene_of(files: [&str; 2]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let [part, scene] = ["part.toml", "scene.toml"].map(|name| folder.path().join(name));
    std::fs::write(part, files[0]).expect("a file");
    std::fs::write(&scene, files[1]).expect("a file");
    said_of(&scene)
}

/// The program in words, or what is wrong.
fn said_of(path: &std::path::Path) -> String {
    match Scene::read(path).and_then(|scene| compile(&scene)) {
        Ok(compiled) => format!("{:?} {:?}", compiled.warnings.map(|faults| faults.list), compiled.program.to_bytes()),
        Err(faults) => faults.list.iter().map(|fault| format!("{} {}\n", fault.code, fault.message)).collect(),
    }
}

const PART: &str = r#"
[parameters]
k = 3.0
[signals]
speed = "rod.omega - 2*coil.torque"
brake = "-k*speed + 0.1*rod.y"
[ground.points]
o = [0.1, 0.2]
[bodies.rod]
mass = 1
inertia = 0.2
points = { end = [0.5, 0] }
[joints.pin]
type = "revolute"
between = ["ground.o", "rod.end"]
[loads.coil]
type = "torsion_spring"
between = ["ground", "rod"]
stiffness = 4
[loads.motor]
type = "torque"
on = "rod"
value = "brake + 2*speed"
[initial]
"rod.angle" = "10 deg"
[outputs]
variables = ["rod.angle", "motor.torque"]
"#;

/// Signals of a part are its own, and see what it sees where it is mirrored and turned: it is the part with the laws written out.
#[test]
fn signals_of_parts() {
    let laws = [("brake", "(-k*speed + 0.1*rod.y)"), ("speed", "(rod.omega - 2*coil.torque)")];
    let (signals, rest) = PART.split_once("[ground.points]").expect("points");
    let mut rest = format!("[ground.points]{rest}");
    laws.iter().for_each(|(name, law)| rest = rest.replace(name, law));
    let copied = format!("{}{rest}", signals.split_once("[signals]").expect("signals").0);
    let twice = "name = \"twice\"\n[parts.one]\nfile = \"part.toml\"\n[parts.two]\nfile = \"part.toml\"\nparameters = { k = 5 }\nPLACE";
    for place in ["", "mirror = true\nangle = \"40 deg\"\nat = [0.3, -0.2]\n"] {
        let host = twice.replace("PLACE", place);
        let (named, written) = (scene_of([PART, &host]), scene_of([&copied, &host]));
        assert!(named.starts_with("None Ok"), "{named}");
        assert_eq!(named, written, "{place}");
    }
    let host = "name = \"turned\"\n[signals]\nseen = \"p.brake\"\n[parts.p]\nfile = \"part.toml\"\nangle = \"40 deg\"\n[outputs]\nvariables = [\"seen\", \"p.speed\"]\n";
    assert!(scene_of([PART, host]).starts_with("None Ok"), "{}", scene_of([PART, host]));
    let reaction =
        PART.replace("value = \"brake + 2*speed\"", "value = 0").replace("rod.omega - 2*coil.torque", "pin.fx");
    let refused = scene_of([&reaction, host]);
    assert!(refused.starts_with("scene::placed_part") && refused.lines().count() == 1, "{refused}");
}

/// The law of another load stands where its force is named: in the plane positive in compression, on a line the tension of a spring.
#[test]
fn laws_use_the_forces_of_other_loads() {
    let coil = "[loads.coil]\ntype = \"spring\"\nbetween = [\"ground\", \"sled\"]\nstiffness = \"k\"\nlength = \"0.3 m\"\ndamping = 2\n";
    let plane = |law: &str| format!("{SLED}{coil}{}[initial]\n\"guide.s\" = 0.5\n", PUSH.replace("PUSH", law));
    let law = "-(k*(coil.length - 0.3[m]) + 0*(coil.length - 0.3[m])^3 + 2*coil.rate)";
    assert_eq!(bytes(&plane("0.3*coil.force")), bytes(&plane(&format!("0.3*({law})"))));
    let line = |law: &str| {
        let force = PUSH.replace("[\"PUSH\", 0]", &format!("[\"{law}\"]"));
        let scene = format!(
            "name = \"line\"\ndimension = 1\n[parameters]\nk = \"50 N/m\"\n[bodies.sled]\nmass = 2\n{coil}{force}[initial]\n\"sled.x\" = 0.5\n[outputs]\nvariables = [\"push.fx\"]\n"
        );
        let mut instance = run::started(&run::model(&scene), None, 1.0, 1e-9);
        run::value(&mut instance, "push.fx")
    };
    assert!((line("0.3*coil.force") - 0.3 * 50.0 * 0.2).abs() < 1e-12);
    let other = "[loads.other]\ntype = \"actuator\"\nbetween = [\"ground\", \"sled\"]\nforce = \"2*third.force\"\n\
        [loads.third]\ntype = \"actuator\"\nbetween = [\"ground\", \"sled\"]\nforce = \"FORCE\"\n";
    let both = |law: &str| {
        format!("{SLED}{}[initial]\n\"guide.s\" = 0.5\n", other.replace("FORCE", law))
            + "[outputs]\nvariables = [\"other.force\"]\n"
    };
    says(&both("other.force - 1"), "scene::cycle loads depend on each other in a cycle: `other` -> `third` -> `other`");
    let mut instance = run::started(&run::model(&both("-20*length")), None, 1.0, 1e-9);
    assert_eq!(run::value(&mut instance, "other.force"), -20.0);
    says(&both("third.force"), "scene::cycle `force` of actuator `third` depends on itself: `third.force`");
    says(&both("other.power"), "scene::load_depends");
}
