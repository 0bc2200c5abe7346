//! What has happened in a run: the log of `simulate`, the counts of its summary, and what `check` says of the start.

use crate::outside::command::cotree;
use crate::support::run::{compiled, scene_of};

use cotree::run::{Run, What};
use cotree_fmu::model::Model;
use std::sync::Arc;

/// The log of a whole run of a scene.
fn logged(text: &str) -> Vec<cotree::run::Logged> {
    let compiled = compiled(text);
    let description = &compiled.description;
    let (settings, reported) = (Vec::new(), compiled.reported());
    let run = Run { description, experiment: description.experiment, settings, inputs: None, reported };
    run.start(Arc::new(Model::new(compiled.program.clone()).unwrap()), |_, _| Ok(())).unwrap().log
}

/// A ball that is dropped on a pad: impacts at T (1 + 2 (e + ... + e^k)), each with m (1 + e) v, until it stays.
const BALL: &str = r#"
name = "ball"
gravity = [0, -9.81]
[bodies.ball]
mass = 2.0
[joints.rail]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
[joints.pad]
type = "contact"
between = ["ground", "ball"]
axis = [1, 0]
restitution = 0.5
[events.low]
when = "rail.s < 0.5"
once = true
[sampled.memory]
period = 1e3
offset = 1e3
values.n = { start = 0, next = "n" }
[initial]
"rail.s" = 1.0
"rail.v" = 0.0
[outputs]
variables = ["ball.y"]
[experiment]
stop = "2 s"
step = "10 ms"
tolerance = 1e-10
"#;

#[test]
fn a_run_tells_its_impacts_with_times_and_impulses() {
    let ball = BALL.replace("once = true", "set = { n = \"n + 1\" }");
    let log = logged(&ball);
    let (fall, g) = ((2.0 / 9.81_f64).sqrt(), 9.81);
    assert_eq!((log[0].name.as_str(), log[0].what), ("low", What::Event));
    assert!((log[0].time - (1.0 / 9.81_f64).sqrt()).abs() < 1e-10);
    let impacts: Vec<(f64, f64)> = log
        .iter()
        .filter_map(|own| if let What::Impact { impulse, .. } = own.what { Some((own.time, impulse)) } else { None })
        .collect();
    for (place, (time, impulse)) in impacts.iter().take(6).enumerate() {
        let share = 0.5_f64.powi(place as i32);
        let flights: f64 = (1..=place as i32).map(|flight| 2.0 * 0.5_f64.powi(flight)).sum();
        assert!((time - fall * (1.0 + flights)).abs() < 1e-9, "{place}: {time}");
        assert!((impulse - 2.0 * 1.5 * g * fall * share).abs() < 1e-9, "{place}: {impulse}");
    }
    // The series ends after 3 T.
    let last = log.last().unwrap();
    assert_eq!((last.name.as_str(), last.what), ("pad", What::Closes));
    assert!((last.time - 3.0 * fall).abs() < 1e-5);
}

#[test]
fn the_command_counts_and_writes_what_has_happened() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("stop.toml"), scene_of("end_stop")).unwrap();
    let output = cotree(folder.path(), &["simulate", "stop.toml", "--summary", "--log", "log.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.starts_with("guide.max: ")).unwrap_or_else(|| panic!("{text}"));
    assert!(
        line.contains("impacts, the largest of") && line.contains("N.s at t = ") && line.contains("stays closed from"),
        "{line}"
    );
    let log = std::fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let mut rows = log.lines();
    assert_eq!(rows.next(), Some("time,name,what,impulse"));
    let impacts = rows.clone().filter(|row| row.contains(",guide.max,impact,")).count();
    assert!(line.starts_with(&format!("guide.max: {impacts} impacts")), "{impacts}: {line}");
    assert!(rows.next_back().unwrap().contains(",guide.max,closes,"));
    let data = cotree(folder.path(), &["simulate", "stop.toml", "--summary", "--json"]);
    let data: serde_json::Value = serde_json::from_slice(&data.stdout).unwrap();
    assert_eq!(data["happened"].as_array().unwrap().len(), log.lines().count() - 1);
    let checked = cotree(folder.path(), &["check", "stop.toml"]);
    let checked = String::from_utf8(checked.stdout).unwrap();
    assert!(checked.contains("`guide.max`: open at the start, 0.3433 m from the stop"), "{checked}");
}

#[test]
fn what_rubs_is_told_in_its_own_words() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("belt.toml"), scene_of("stick_slip")).unwrap();
    let output = cotree(folder.path(), &["simulate", "belt.toml", "--summary", "--log", "log.csv"]);
    let summary = String::from_utf8(output.stdout).unwrap();
    let log = std::fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let of = |word: &str| log.lines().filter(|row| row.contains(&format!(",{word},"))).count();
    assert!(of("sticks") > 2 && of("sticks").abs_diff(of("slips")) <= 1, "{log}");
    assert_eq!(of("closes") + of("opens") + of("impact"), 0, "{log}");
    let line = summary.lines().find(|line| line.contains(".friction: ")).unwrap_or_else(|| panic!("{summary}"));
    assert!(line.contains(&format!("slips {} times", of("slips"))), "{line}");
    let last = if log.lines().last().unwrap().contains(",slips,") { "slides from t = " } else { "sticks from t = " };
    assert!(line.contains(last), "{line}");
    let checked = cotree(folder.path(), &["check", "belt.toml"]);
    let checked = String::from_utf8(checked.stdout).unwrap();
    assert!(
        checked.contains(".friction`: sticks at the start, with ")
            || checked.contains(".friction`: slides at the start, at "),
        "{checked}"
    );
    assert!(!checked.contains("the stop"), "{checked}");
}

#[test]
fn a_ratchet_tells_that_it_turns_freely() {
    let ratchet = BALL.replace("[joints.pad]", "[bodies.disc]\nmass = 1.0\ninertia = 1.0\n[joints.axle]\ntype = \"revolute\"\nbetween = [\"ground\", \"disc\"]\n[joints.ratchet]\ntype = \"one_way\"\nbetween = [\"ground\", \"disc\"]\n[joints.pad]");
    let ratchet = ratchet.replace("once = true", "stop = true").replace("[initial]", "[initial]\n\"disc.omega\" = 2.0");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ratchet.toml"), ratchet).unwrap();
    let checked = cotree(folder.path(), &["check", "ratchet.toml"]);
    let checked = String::from_utf8(checked.stdout).unwrap();
    assert!(checked.contains("`ratchet`: disengaged at the start, with a relative speed of 2 rad/s"), "{checked}");
}
