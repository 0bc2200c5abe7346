//! The command as a user meets it: usage errors, exit codes, `new`.

use std::path::Path;
use std::process::{Command, Output};

fn cotree(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cotree")).args(arguments).current_dir(folder).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn every_command_explains_itself_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    let help = stdout(&cotree(folder.path(), &["--help"]));
    for command in ["new", "check", "show", "simulate", "export"] {
        assert!(help.contains(command), "{command}\n{help}");
        let output = cotree(folder.path(), &[command, "--help"]);
        assert_eq!(code(&output), 0);
        assert!(stdout(&output).contains("Example"), "{}", stdout(&output));
        assert!(stdout(&output).contains(&format!("cotree {command} ")), "{}", stdout(&output));
    }
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [&[&str]; 5] =
        [&[], &["fly"], &["check"], &["check", "a", "--message-format", "xml"], &["show", "a", "--bad"]];
    for arguments in cases {
        assert_eq!(code(&cotree(folder.path(), arguments)), 2, "{arguments:?}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("folder.toml")).unwrap();
    for (command, file) in [("check", "missing.toml"), ("export", "missing.toml"), ("check", "folder.toml")] {
        let output = cotree(folder.path(), &[command, file]);
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(stderr(&output).contains(file), "{}", stderr(&output));
    }
}

#[test]
fn new_writes_a_scene_once() {
    let folder = tempfile::tempdir().unwrap();
    let output = cotree(folder.path(), &["new", "quick return"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let path = folder.path().join("quick return.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let scene: toml::Table = text.parse().unwrap();
    assert_eq!(scene["name"].as_str(), Some("quick_return"));

    std::fs::write(&path, "mine").unwrap();
    let again = cotree(folder.path(), &["new", "quick return.toml"]);
    assert_eq!(code(&again), 2);
    assert!(stderr(&again).contains("exists already"), "{}", stderr(&again));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
}

/// A folder with the scene that `new` writes, as `crank.toml`.
fn with_scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(code(&cotree(folder.path(), &["new", "crank"])), 0);
    folder
}

#[test]
fn a_new_scene_is_right_and_moves() {
    let folder = with_scene();
    let check = cotree(folder.path(), &["check", "crank.toml"]);
    assert_eq!((code(&check), stderr(&check).as_str()), (0, ""));
    assert!(stdout(&check).contains("3 bodies, 4 joints, mobility 1"), "{}", stdout(&check));
    let run = cotree(folder.path(), &["simulate", "crank.toml", "--stop", "100 ms"]);
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    let table = stdout(&run);
    assert!(table.starts_with("time,crank.angle,crank.omega,cylinder.s,"), "{table}");
    assert_eq!(table.lines().count(), 12);
}

#[test]
fn files_are_written_where_they_are_wanted() {
    let folder = with_scene();
    let here = |file: &str| folder.path().join(file);
    let arguments = ["simulate", "crank.toml", "--stop", "1", "-o", "a.csv", "--plot", "a.svg"];
    let run = cotree(folder.path(), &arguments);
    assert_eq!((code(&run), stdout(&run).as_str()), (0, ""), "{}", stderr(&run));
    assert!(std::fs::read_to_string(here("a.csv")).unwrap().starts_with("time,"));
    assert!(std::fs::read_to_string(here("a.svg")).unwrap().contains("<svg"));
    assert_eq!(code(&cotree(folder.path(), &["show", "crank.toml", "--drawing", "b.svg"])), 0);
    assert!(std::fs::read_to_string(here("b.svg")).unwrap().contains(">crank</text>"));
    assert_eq!(stdout(&cotree(folder.path(), &["export", "crank.toml"])), "crank.fmu\n");
    let first = std::fs::read(here("crank.fmu")).unwrap();
    assert_eq!(code(&cotree(folder.path(), &["export", "crank.toml", "-o", "again.fmu"])), 0);
    assert!(first == std::fs::read(here("again.fmu")).unwrap(), "the same scene gives the same bytes");
}

#[test]
fn parameters_and_inputs_are_set_with_units() {
    let folder = with_scene();
    let stroke = |settings: &[&str]| {
        let arguments = [&["simulate", "crank.toml", "--stop", "0"], settings].concat();
        let run = cotree(folder.path(), &arguments);
        assert_eq!(code(&run), 0, "{}", stderr(&run));
        stdout(&run).lines().nth(1).unwrap().split(',').nth(3).unwrap().parse::<f64>().unwrap()
    };
    let at = |crank: f64, rod: f64| {
        let (sine, cosine) = (std::f64::consts::PI / 3.0).sin_cos();
        crank * cosine + (rod * rod - (crank * sine).powi(2)).sqrt()
    };
    assert!((stroke(&[]) - at(0.5, 1.5)).abs() < 1e-9);
    assert!((stroke(&["--set", "rod_length=120 cm", "--set", "crank_length = 0.4"]) - at(0.4, 1.2)).abs() < 1e-9);
}

#[test]
fn settings_that_make_no_sense_say_why() {
    let folder = with_scene();
    std::fs::write(folder.path().join("table.csv"), "time,gas_force\n0,x\n").unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&["--set", "rod_length"], "name=value"),
        (&["--set", "rod=1"], "there are: `crank_length`, `rod_length`, `gas_force`"),
        (&["--set", "rod_length=2 kg"], "not in m"),
        (&["--set", "rod_length=10 cm"], "at least 1.0 m"),
        (&["--stop", "-1"], "before the start"),
        (&["--step", "0"], "above zero"),
        (&["--step", "1 ns", "--stop", "1 min"], "rows"),
        (&["--tolerance", "2"], "between 0 and 1"),
        (&["--input", "table.csv"], "line 2, column 2"),
    ];
    for (arguments, message) in cases {
        let run = cotree(folder.path(), &[&["simulate", "crank.toml"], arguments].concat());
        assert_eq!(code(&run), 2, "{arguments:?}");
        assert!(stderr(&run).contains(message), "{arguments:?}: {}", stderr(&run));
        assert_eq!(stdout(&run), "");
    }
}

#[test]
fn faults_of_a_scene_are_exit_code_1_and_json_on_request() {
    let folder = with_scene();
    let path = folder.path().join("crank.toml");
    let text = std::fs::read_to_string(&path).unwrap().replace("crank.outer\"", "crank.outr\"");
    std::fs::write(&path, text).unwrap();
    let human = cotree(folder.path(), &["export", "crank.toml"]);
    assert_eq!((code(&human), stdout(&human).as_str()), (1, ""));
    assert!(stderr(&human).contains("crank.outr"), "{}", stderr(&human));
    let json = cotree(folder.path(), &["check", "crank.toml", "--message-format", "json"]);
    let report: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((code(&json), stderr(&json).as_str()), (1, ""));
    assert_eq!(report["faults"][0]["severity"], "error");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no half of an FMU");
}

#[test]
fn show_gives_figures_to_scripts() {
    let folder = with_scene();
    let shown = cotree(folder.path(), &["show", "crank.toml", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(summary["mobility"], 1);
    assert_eq!(summary["counts"]["absolute"]["coordinates"], 9);
    assert_eq!(summary["counts"]["recommended"]["constraints"], 1);
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let folder = with_scene();
    let command = format!("{} simulate crank.toml --step '0.1 ms' | head -n 1", env!("CARGO_BIN_EXE_cotree"));
    let output = Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output().unwrap();
    assert!(stdout(&output).starts_with("time,"));
    assert_eq!(stderr(&output), "");
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = with_scene();
    for arguments in [["export", "crank.toml", "-o", "no/a.fmu"], ["simulate", "crank.toml", "-o", "no/a.csv"]] {
        let output = cotree(folder.path(), &arguments);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains(arguments[3]), "{}", stderr(&output));
    }
}
