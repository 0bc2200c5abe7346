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
