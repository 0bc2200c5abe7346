//! The command as a user meets it: usage errors, exit codes, `new`.

use crate::outside::command;
use crate::support::ROOT;

use std::path::{Path, PathBuf};
use std::process::Command;

use command::{code, cotree, stderr, stdout, with_scene};

/// Runs the command with a text at its standard input.
fn with_input(folder: &Path, arguments: &[&str], text: &str) -> std::process::Output {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_cotree"))
        .args(arguments)
        .current_dir(folder)
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // A command that refuses its input may have ended before all of it is written.
    let written = std::io::Write::write_all(&mut child.stdin.take().unwrap(), text.as_bytes());
    assert!(matches!(written.map_err(|error| error.kind()), Ok(()) | Err(std::io::ErrorKind::BrokenPipe)));
    child.wait_with_output().unwrap()
}

#[test]
fn a_scene_comes_from_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let bob = "[bodies.bob]\nmass = 2\ninertia = 1\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"bob\"]\naxis = [1, 0]\n";
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/bob.toml"), bob).unwrap();
    // Parts are looked for in the current folder.
    let scene = "name = \"piped\"\n[parts.one]\nfile = \"parts/bob.toml\"\n[initial]\n\"one_rail.v\" = 3\n[experiment]\nstop = 2\nstep = 1\n";
    for (arguments, expected) in [
        (&["check", "-"][..], "1 body, 1 joint, mobility 1"),
        (&["show", "-"], "piped"),
        (&["simulate", "-", "--variables", "one_bob.x"], "2.0,6.0"),
    ] {
        let output = with_input(folder.path(), arguments, scene);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        assert!(stdout(&output).contains(expected), "{arguments:?}: {}", stdout(&output));
    }
    let wrong = with_input(folder.path(), &["check", "-"], &scene.replace("stop = 2", "stop = \"2 m\""));
    assert!(code(&wrong) == 1 && stderr(&wrong).contains("standard input:7:"), "{}", stderr(&wrong));
    assert!(stderr(&with_input(folder.path(), &["watch", "-"], scene)).contains("needs a file"));
}

#[test]
fn several_scenes_are_checked_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let good = "name = \"a\"\n[bodies.bob]\nmass = 2\ninertia = 1\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob\"]\n";
    for (name, text) in
        [("a.toml", good.to_owned()), ("b.toml", good.replace("mass", "mas")), ("c.toml", good.to_owned())]
    {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let output = cotree(folder.path(), &["check", "a.toml", "b.toml", "missing.toml", "c.toml"]);
    // The first one that is wrong gives the exit code: a fault of a scene.
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert!(stdout(&output).contains("a.toml: no errors") && stdout(&output).contains("c.toml: no errors"));
    assert!(stderr(&output).contains("b.toml:3:") && stderr(&output).contains("missing.toml"), "{}", stderr(&output));
    assert_eq!(code(&cotree(folder.path(), &["check", "a.toml", "c.toml"])), 0);
    let output = cotree(folder.path(), &["check", "a.toml", "c.toml", "--drawing", "x.svg"]);
    assert!(code(&output) == 2 && !folder.path().join("x.svg").exists(), "{}", stderr(&output));
}

#[test]
fn every_command_explains_itself_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    let help = stdout(&cotree(folder.path(), &["--help"]));
    for command in ["new", "check", "show", "simulate", "export", "info"] {
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
    let cases: [(&[&str], &str); 12] = [
        (&["--set", "rod_length"], "name=value"),
        (&["--set", "rod=1"], "there are: `crank_length`, `rod_length`, `gas_force`"),
        (&["--set", "rod_lenth=1"], "has no parameter or input `rod_lenth`; did you mean `rod_length`?"),
        (&["--set", "rod_length=2 kg"], "not in m"),
        (&["--set", "rod_length=10 cm"], "at least 1.0 m"),
        (&["--stop", "-1"], "before the start"),
        (&["--step", "0"], "positive"),
        (&["--step", "1 ns", "--stop", "1 min"], "rows"),
        (&["--tolerance", "2"], "the tolerance is 2e0, but must be between 1e-13"),
        (
            &["--tolerance", "1e-30"],
            "the tolerance is 1e-30, but must be between 1e-13 (the limit of double precision) and 0.01",
        ),
        (&["--sensitivity", "rod", "--sensitivity", "gas"], "initial value `gas`"),
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

#[test]
fn info_reads_an_fmu_back() {
    let folder = with_scene();
    assert_eq!(code(&cotree(folder.path(), &["export", "crank.toml"])), 0);
    let info = cotree(folder.path(), &["info", "crank.fmu"]);
    assert_eq!(code(&info), 0, "{}", stderr(&info));
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let row = stdout(&info).lines().map(words).find(|words| words.get(1).is_some_and(|name| name == "crank_length"));
    assert_eq!(row.unwrap()[..5], ["parameter", "crank_length", "m", "start", "0.5"]);
    for text in
        ["crank: ", "  made by     cotree ", "FMI 2.0 Model Exchange, Co-Simulation", "0.0 s to 10.0 s", "  output "]
    {
        assert!(stdout(&info).contains(text), "{text}\n{}", stdout(&info));
    }
    let scene = cotree(folder.path(), &["info", "crank.fmu", "--scene"]);
    assert_eq!(scene.stdout, std::fs::read(folder.path().join("crank.toml")).unwrap());
}

#[test]
fn info_says_what_may_be_set_and_when() {
    let folder = with_scene();
    let scene = r#"
        format = 1
        name = "cart"
        dimension = 1
        [parameters]
        stiffness = { value = "2 kN/m", min = 0, tunable = true }
        free = { value = 0.3, min = 0.1, max = 0.5 }
        [inputs]
        push = { start = 1.0, max = 2.0 }
        [bodies.cart]
        mass = 1.0
        [loads.spring]
        type = "spring"
        between = ["ground", "cart"]
        stiffness = "stiffness"
        length = "free"
        [loads.pusher]
        type = "force"
        on = "cart"
        vector = ["push"]
        [initial]
        "cart.x" = { guess = 0.4 }
    "#;
    std::fs::write(folder.path().join("cart.toml"), scene).unwrap();
    assert_eq!(code(&cotree(folder.path(), &["export", "cart.toml"])), 0);
    let info = stdout(&cotree(folder.path(), &["info", "cart.fmu"]));
    for (name, said) in [
        ("stiffness", "start 2000.0 tunable, at least 0.0"),
        ("free", "start 0.3 0.1 to 0.5"),
        ("push", "start 1.0 at most 2.0"),
        ("cart.x", "guess 0.4"),
    ] {
        let mut words = info.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let line = words.find(|words| words.get(1) == Some(&name)).unwrap().join(" ");
        assert!(line.contains(said), "{said}: {line}");
    }
}

/// An archive with these files.
fn archive(path: &Path, files: &[(&str, &str)]) {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, content) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, content.as_bytes()).unwrap();
    }
    zip.finish().unwrap();
}

#[test]
fn info_says_why_it_cannot_read_a_file() {
    let folder = with_scene();
    let path = folder.path().join("a.fmu");
    let by = |tool: &str| format!("<fmiModelDescription modelName=\"a\" generationTool=\"{tool}\"/>");
    let (other, own) = (by("Other Tool 3"), by("cotree 0.1.0"));
    let cases: [(&[(&str, &str)], &str); 6] = [
        (&[("a.txt", "")], "no modelDescription.xml"),
        (&[("modelDescription.xml", "<a></b>")], "damaged"),
        (&[("modelDescription.xml", "<fmiModelDescription/>")], "made by another program, not by cotree"),
        (&[("modelDescription.xml", &other), ("resources/program.bin", "x")], "made by Other Tool 3, not by cotree"),
        (&[("modelDescription.xml", &own), ("resources/program.bin", "x")], "the program cannot be read"),
        (&[("modelDescription.xml", &own)], "it has no resources/program.bin; export it again"),
    ];
    for (files, message) in cases {
        archive(&path, files);
        let info = cotree(folder.path(), &["info", "a.fmu"]);
        assert_eq!((code(&info), stdout(&info).as_str()), (2, ""));
        assert!(stderr(&info).contains(message), "{message}: {}", stderr(&info));
    }
    for (file, message) in [("crank.toml", "it is not an FMU"), ("missing.fmu", "missing.fmu")] {
        let info = cotree(folder.path(), &["info", file]);
        assert!(code(&info) == 2 && stderr(&info).contains(message), "{}", stderr(&info));
    }
}

#[test]
fn all_means_every_variable() {
    let folder = with_scene();
    let lines = |arguments: &[&str]| {
        let export = cotree(folder.path(), &[&["export", "crank.toml"], arguments].concat());
        assert_eq!(code(&export), 0, "{}", stderr(&export));
        stdout(&cotree(folder.path(), &["info", "crank.fmu"])).lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let (requested, all) = (lines(&[]), lines(&["--all"]));
    for name in ["rod.small_end.vx", "crank_pin.fy", "main_bearing.torque", "energy.kinetic", "constraint.position"] {
        let is_there = |lines: &[String]| lines.iter().any(|line| line.split_whitespace().nth(1) == Some(name));
        assert!(is_there(&all) && !is_there(&requested), "{name}");
    }
    let first = |lines: &[String]| lines.iter().find(|line| line.starts_with("  output")).cloned();
    assert_eq!(
        first(&requested).map(|line| line.split_whitespace().nth(1).map(str::to_owned)),
        first(&all).map(|line| line.split_whitespace().nth(1).map(str::to_owned)),
        "what the scene asks for comes first"
    );
}

/// A rod without inertia that does not turn: the plain export needs none, and some of its variables do not exist.
#[test]
fn all_leaves_out_what_cannot_be_computed_and_says_so() {
    let folder = with_scene();
    let scene = r#"
        format = 1
        name = "lift"
        [bodies.cage]
        points = { hook = [0, 1] }
        [bodies.wheel]
        mass = 1.0
        inertia = 0.1
        points = { rim = [0.2, 0] }
        [joints.rail]
        type = "prismatic"
        between = ["ground", "cage"]
        axis = [0, 1]
        [drivers.winch]
        joint = "rail"
        displacement = "0.1*sin(t)"
        [joints.axle]
        type = "revolute"
        between = ["cage", "wheel"]
        [drivers.motor]
        joint = "axle"
        angle = "t"
        [outputs]
        variables = ["cage.y"]
    "#;
    std::fs::write(folder.path().join("lift.toml"), scene).unwrap();
    assert_eq!(code(&cotree(folder.path(), &["export", "lift.toml"])), 0);
    let all = cotree(folder.path(), &["export", "lift.toml", "--all"]);
    let said = stderr(&all);
    assert_eq!(code(&all), 0, "{said}");
    for part in ["left out, because body `cage` has no `mass`", "winch.force", "energy.kinetic"] {
        assert!(said.replace(['\n', '\u{2502}'], " ").contains(part), "{part}: {said}");
    }
    let info = stdout(&cotree(folder.path(), &["info", "lift.fmu"]));
    for (name, there) in
        [("wheel.rim.ax", true), ("cage.hook.vy", true), ("winch.force", false), ("energy.total", false)]
    {
        assert_eq!(info.lines().any(|line| line.split_whitespace().nth(1) == Some(name)), there, "{name}: {info}");
    }
}

/// The official schema wants at least one variable.
#[test]
fn a_scene_without_variables_has_time() {
    let folder = with_scene();
    let scene = r#"
        format = 1
        name = "empty"
        [bodies.post]
        mass = 1.0
        [joints.foot]
        type = "weld"
        between = ["ground", "post"]
    "#;
    std::fs::write(folder.path().join("empty.toml"), scene).unwrap();
    let export = cotree(folder.path(), &["export", "empty.toml"]);
    assert_eq!(code(&export), 0, "{}", stderr(&export));
    let info = stdout(&cotree(folder.path(), &["info", "empty.fmu"]));
    assert!(info.lines().any(|line| line.split_whitespace().nth(1) == Some("time")), "{info}");
}

#[test]
fn platforms_come_from_a_folder_of_runtimes() {
    let folder = with_scene();
    let library = folder.path().join("lib/win64/cotree_runtime.dll");
    let export = |arguments: &[&str]| {
        cotree(folder.path(), &[&["export", "crank.toml", "--runtimes", "lib"], arguments].concat())
    };
    let missing = export(&["--platform", "win64"]);
    assert_eq!(code(&missing), 2);
    assert!(stderr(&missing).contains("tools/build-runtimes.sh"), "{}", stderr(&missing));
    std::fs::create_dir_all(library.parent().unwrap()).unwrap();
    std::fs::write(&library, "text").unwrap();
    let foreign = export(&["--platform", "win64"]);
    assert!(stderr(&foreign).contains("is not a shared library for win64"), "{}", stderr(&foreign));
    assert!(stderr(&export(&["--platform", "win"])).contains("there are: linux64, "));
    let mut dll = vec![0; 0x90];
    dll[..2].copy_from_slice(b"MZ");
    dll[60] = 0x80;
    dll[0x80..0x86].copy_from_slice(b"PE\0\0\x64\x86");
    std::fs::write(&library, &dll).unwrap();
    let older = export(&["--platform", "win64"]);
    assert!(stderr(&older).contains("another version of cotree"), "{}", stderr(&older));
    dll.extend_from_slice(cotree_fmu::program::storage::KIND.as_bytes());
    std::fs::write(&library, &dll).unwrap();
    let host = cotree::export::runtime::Platform::host().unwrap().folder;
    let both = format!("{host},win64");
    for arguments in [&["--platform", &both][..], &["--platform", "all"], &[]] {
        let all = export(arguments);
        assert_eq!(code(&all), 0, "{}", stderr(&all));
        let info = stdout(&cotree(folder.path(), &["info", "crank.fmu"]));
        let line = info.lines().find(|line| line.starts_with("  platforms")).unwrap();
        assert!(line.contains(host) && line.contains("win64 (1 kB)"), "{line}");
    }
}

#[cfg(unix)]
#[test]
fn what_is_not_written_to_the_end_is_no_success() {
    let folder = with_scene();
    let program = env!("CARGO_BIN_EXE_cotree");
    let run = |command: &str| {
        let command = command.replace("cotree", program);
        Command::new("bash").args(["-c", &command]).current_dir(folder.path()).output().unwrap()
    };
    // A reader that has seen enough: nobody is told, but a script can ask.
    let output = run("cotree simulate crank.toml --step '0.1 ms' | head -n 1; exit ${PIPESTATUS[0]}");
    assert!(stdout(&output).starts_with("time,"));
    assert_eq!((code(&output), stderr(&output)), (1, String::new()));
    for command in ["check crank.toml", "simulate crank.toml", "export crank.toml", "--help", "help check"] {
        let output = run(&format!("cotree {command} >&-"));
        assert_eq!((code(&output), stderr(&output)), (1, String::new()), "{command}");
        assert_eq!(code(&run(&format!("cotree {command} >/dev/null"))), 0, "{command}");
    }
    // Nothing goes to standard output here.
    assert_eq!(code(&run("cotree simulate crank.toml -o table.csv >&-")), 0);
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

/// No command writes over what it reads, or writes one file twice.
#[test]
fn nothing_that_is_read_is_written_over() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("written_over");
    std::fs::create_dir_all(&folder).unwrap();
    let scene = folder.join("scene.toml");
    let text = std::fs::read_to_string(Path::new(ROOT).join("models/pendulum/scene.toml")).unwrap();
    std::fs::write(&scene, &text).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_cotree")).current_dir(&folder).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for arguments in [
        ["export", "scene.toml", "-o", "scene.toml"],
        ["simulate", "scene.toml", "-o", "./scene.toml"],
        ["simulate", "scene.toml", "--plot", "scene.toml"],
        ["show", "scene.toml", "--graph", "scene.toml"],
        ["show", "scene.toml", "--drawing", "scene.toml"],
        ["bench", "scene.toml", "--plot", "scene.toml"],
        ["modes", "scene.toml", "-o", "scene.toml"],
    ] {
        let (code, message) = run(&arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
        assert!(message.contains("it is read by this command"), "{message}");
        assert_eq!(std::fs::read_to_string(&scene).unwrap(), text, "{arguments:?}");
    }
}
