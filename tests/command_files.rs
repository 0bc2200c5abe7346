//! Files that a command is given or leaves behind: endless ones, foreign ones, unfinished ones.
#![cfg(unix)]

use crate::outside::command;

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use command::{code, cotree, stderr, stdout, with_scene};

/// What a command that must fail with exit code 2 says.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = cotree(folder, arguments);
    let message = stderr(&output);
    assert_eq!(code(&output), 2, "{arguments:?}: {message}");
    assert!(message.lines().count() <= 2, "{message}");
    message
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = entries.collect();
    names.sort();
    names
}

/// A sparse file of ten gigabytes, a folder, a pipe that no program writes to.
fn odd_files(folder: &Path) {
    File::create(folder.join("large")).unwrap().set_len(10_000_000_000).unwrap();
    fs::create_dir(folder.join("folder")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap().success());
}

#[test]
fn what_is_no_file_or_never_ends_is_refused() {
    let folder = with_scene();
    odd_files(folder.path());
    let cases = [
        ("/dev/zero", "larger than"),
        ("large", "larger than"),
        ("folder", "a folder"),
        ("pipe", "no program writes to"),
    ];
    for (file, reason) in cases {
        for arguments in [&["check", file][..], &["simulate", "crank.toml", "--input", file]] {
            let message = refused(folder.path(), arguments);
            assert!(message.contains(file) && message.contains(reason), "{message}");
        }
    }
    for (file, reason) in
        [("folder", "a folder"), ("pipe", "a pipe"), ("/dev/zero", "a device"), ("large", "not an FMU")]
    {
        let message = refused(folder.path(), &["info", file]);
        assert!(message.contains(file) && message.contains(reason), "{message}");
    }
}

#[test]
fn a_scene_can_come_through_a_pipe() {
    let folder = with_scene();
    let command = format!("cat crank.toml | {} check /dev/stdin", env!("CARGO_BIN_EXE_cotree"));
    let output = Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn what_is_no_scene_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..60).map(|row| format!("{row},{row}.5,x\n")).collect();
    let program =
        "import math\n\ndef area(r):\n    return math.pi * r ** 2\n\nfor r in range(9):\n    print(area(r))\n";
    let cases: [(&str, &[u8], &str); 6] = [
        ("table.csv", rows.as_bytes(), "neither TOML nor JSON"),
        ("area.py", program.as_bytes(), "neither TOML nor JSON"),
        ("page.html", b"<!doctype html>\n<html>\n<body>name</body>\n</html>\n", "neither TOML nor JSON"),
        ("prose.txt", b"Dear reader,\n\nthe crank is half a metre long.\nYours\n", "neither TOML nor JSON"),
        ("image.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "not a text"),
        ("a.fmu", b"PK\x03\x04\x14\0", "cotree info"),
    ];
    for (name, content, reason) in cases {
        fs::write(folder.path().join(name), content).unwrap();
        let output = cotree(folder.path(), &["check", name]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(name) && message.contains(reason), "{message}");
        assert_eq!(message.matches("scene::").count(), 1, "{message}");
    }
}

#[test]
fn slips_in_a_scene_are_still_told_one_by_one() {
    let folder = with_scene();
    let text = fs::read_to_string(folder.path().join("crank.toml")).unwrap();
    let text = text.replace("format = 1", "format = = 1").replace("mass = 1.0", "mass : 1.0");
    fs::write(folder.path().join("crank.toml"), text).unwrap();
    let output = cotree(folder.path(), &["check", "crank.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(message.matches("scene::syntax").count(), 2, "{message}");
}

#[test]
fn what_is_no_table_or_no_fmu_is_told() {
    let folder = with_scene();
    fs::write(folder.path().join("binary.csv"), b"time,\xff\xfe\n").unwrap();
    let message = refused(folder.path(), &["simulate", "crank.toml", "--input", "binary.csv"]);
    assert!(message.contains("begins with `time,name`"), "{message}");
    assert!(refused(folder.path(), &["info", "crank.toml"]).contains("not a zip archive"));
    assert!(cotree(folder.path(), &["export", "crank.toml"]).status.success());
    let whole = fs::read(folder.path().join("crank.fmu")).unwrap();
    fs::write(folder.path().join("half.fmu"), &whole[..whole.len() / 2]).unwrap();
    assert!(refused(folder.path(), &["info", "half.fmu"]).contains("damaged"));
}

#[test]
fn one_file_is_not_written_twice() {
    let folder = with_scene();
    for plot in ["q.csv", "./q.csv", &format!("{}/q.csv", folder.path().display())] {
        let message = refused(folder.path(), &["simulate", "crank.toml", "-o", "q.csv", "--plot", plot]);
        assert!(message.contains("already written"), "{message}");
    }
    assert_eq!(names(folder.path()), ["crank.toml"]);
}

/// The rod is shorter than the crank: at sin t = 0.8 the mechanism locks up.
#[test]
fn a_table_ends_where_the_solver_gives_up() {
    let folder = with_scene();
    let text = fs::read_to_string(folder.path().join("crank.toml")).unwrap();
    let text = text.replace("crank_length = \"0.5 m\"", "crank_length = \"1 m\"");
    let text = text.replace("{ value = \"1.5 m\", min = \"1 m\",", "{ value = \"0.8 m\",");
    let text = text.replace("\"crank.angle\" = \"60 deg\"", "");
    let text = text.replace("[parameters]", "[parameters]\nlead = 0.0");
    let driver = "[drivers.motor]\njoint = \"main_bearing\"\nangle = \"t + lead\"\n\n[initial]";
    fs::write(folder.path().join("crank.toml"), text.replace("[initial]", driver)).unwrap();
    let arguments = ["simulate", "crank.toml", "-o", "out.csv", "--plot", "out.svg", "--step", "10 ms"];
    let output = cotree(folder.path(), &arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("locks") && message.contains("`out.csv` has the 93 rows before that"), "{message}");
    let table = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert_eq!(table.lines().count(), 94);
    assert!(table.lines().last().unwrap().starts_with("0.92,"), "{table}");
    assert!(fs::read_to_string(folder.path().join("out.svg")).unwrap().ends_with("</svg>\n"));
    assert_eq!(names(folder.path()), ["crank.toml", "out.csv", "out.svg"]);
    // Nothing at all was worked out: what is there stays.
    let none = cotree(folder.path(), &[&arguments[..], &["--set", "lead=1.2"]].concat());
    assert_eq!(none.status.code(), Some(3), "{}", String::from_utf8_lossy(&none.stderr));
    assert_eq!(fs::read_to_string(folder.path().join("out.csv")).unwrap(), table);
}

/// Waits until a process writes to a file in the folder.
#[cfg(target_os = "linux")]
fn wait_for_writing(run: &mut std::process::Child, folder: &Path) {
    let folder = folder.canonicalize().unwrap();
    for _ in 0..3000 {
        assert_eq!(run.try_wait().unwrap(), None, "it ended before anything was written");
        let open = fs::read_dir(format!("/proc/{}/fd", run.id())).unwrap();
        let mut open = open.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
        // The scene is read from the same folder.
        if open.any(|path| path.starts_with(&folder) && !path.ends_with("crank.toml")) {
            return;
        }
        sleep(Duration::from_millis(10));
    }
    panic!("nothing is written");
}

/// Who starts the tests may have them ignore a signal (`nohup`, a job in the background): so does what they start.
#[cfg(target_os = "linux")]
fn is_ignored(process: u32, signal: &str) -> bool {
    let number = match signal {
        "HUP" => 1,
        "INT" => 2,
        "TERM" => 15,
        _ => return false,
    };
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & (1 << (number - 1)) != 0
}

/// A run that is being written, so long that it does not end before it is stopped, however slow this machine is at the moment.
#[cfg(target_os = "linux")]
fn long_run(folder: &Path) -> std::process::Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cotree"));
    command.args(["simulate", "crank.toml", "--stop", "90000", "--step", "1 ms", "-o", "out.csv"]);
    let mut run = command.current_dir(folder).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_writing(&mut run, folder);
    run
}

#[cfg(target_os = "linux")]
fn send(run: &std::process::Child, signal: &str) {
    assert!(Command::new("kill").arg(format!("-{signal}")).arg(run.id().to_string()).status().unwrap().success());
}

#[cfg(target_os = "linux")]
#[test]
fn who_is_stopped_leaves_nothing_behind() {
    let folder = with_scene();
    for signal in ["TERM", "HUP", "KILL"] {
        let mut run = long_run(folder.path());
        let signal = if is_ignored(run.id(), signal) { "KILL" } else { signal };
        send(&run, signal);
        assert!(!run.wait().unwrap().success(), "{signal}");
        assert_eq!(names(folder.path()), ["crank.toml"], "{signal}");
    }
}

/// Who asks it to end has what was worked out: whole rows, as many as it says.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_keeps_the_rows() {
    let folder = with_scene();
    let run = long_run(folder.path());
    send(&run, "INT");
    let output = run.wait_with_output().unwrap();
    let message = stderr(&output);
    assert_eq!(code(&output), 130, "{message}");
    assert_eq!(names(folder.path()), ["crank.toml", "out.csv"]);
    let table = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let (rows, columns) = (table.lines().count() - 1, |line: &str| line.split(',').count());
    assert!(message.contains(&format!("stopped: `out.csv` has the {rows} rows before that")), "{message}");
    assert!(table.ends_with('\n') && table.lines().all(|line| columns(line) == columns(table.lines().next().unwrap())));
    assert!(table.lines().skip(1).enumerate().all(|(row, line)| {
        let time: f64 = line.split(',').next().unwrap().parse().unwrap();
        (time - 1e-3 * row as f64).abs() < 1e-9
    }));
}

#[test]
fn a_dash_is_standard_output_and_never_a_file() {
    let folder = with_scene();
    let said = |arguments: &[&str]| {
        let output = cotree(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}");
        output.stdout
    };
    for command in [&["simulate", "crank.toml", "--stop", "0.1"][..], &["equilibrium", "crank.toml"]] {
        let table = said(command);
        assert!(!table.is_empty());
        assert_eq!(said(&[command, &["-o", "-"]].concat()), table, "{command:?}");
    }
    let cases: [&[&str]; 3] = [
        &["export", "crank.toml", "-o", "-"],
        &["simulate", "crank.toml", "-o", "-", "--plot", "-"],
        &["bench", "crank.toml", "--plot", "-"],
    ];
    for arguments in cases {
        let message = refused(folder.path(), arguments);
        assert!(message.contains("cannot write `-`") && message.contains("name a file"), "{message}");
    }
    assert_eq!(names(folder.path()), ["crank.toml"]);
}

#[test]
fn a_pipe_that_nobody_reads_is_told() {
    let folder = with_scene();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap().success());
    let message = refused(folder.path(), &["simulate", "crank.toml", "--stop", "0.1", "-o", "pipe"]);
    assert!(message.contains("no program reads from"), "{message}");
}

/// The files of an FMU, each changed as wanted.
fn repacked(from: &Path, to: &Path, change: impl Fn(&str, Vec<u8>) -> Vec<u8>) {
    let mut archive = zip::ZipArchive::new(File::open(from).unwrap()).unwrap();
    let mut zip = zip::ZipWriter::new(File::create(to).unwrap());
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let (name, mut content) = (file.name().unwrap().into_owned(), Vec::new());
        file.read_to_end(&mut content).unwrap();
        zip.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&change(&name, content)).unwrap();
    }
    zip.finish().unwrap();
}

fn text_changed(content: Vec<u8>, change: impl Fn(&str) -> String) -> Vec<u8> {
    change(std::str::from_utf8(&content).unwrap()).into_bytes()
}

#[test]
fn an_fmu_whose_parts_do_not_belong_together_is_damaged() {
    let folder = with_scene();
    let at = |name: &str| folder.path().join(name);
    let text = fs::read_to_string(at("crank.toml")).unwrap();
    fs::write(at("other.toml"), text.replace("crank_length", "throw")).unwrap();
    for scene in ["crank", "other"] {
        let output = cotree(folder.path(), &["export", &format!("{scene}.toml"), "-o", &format!("{scene}.fmu")]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let mut other = zip::ZipArchive::new(File::open(at("other.fmu")).unwrap()).unwrap();
    let mut program = Vec::new();
    other.by_name("resources/program.bin").unwrap().read_to_end(&mut program).unwrap();
    type Change<'a> = Box<dyn Fn(&str) -> String + 'a>;
    let guid = text_between(&at("crank.fmu"), "guid=\"", "\"");
    let descriptions: [(&str, Change); 3] = [
        ("truncated", Box::new(|text| text[..text.find("</ModelVariables>").unwrap()].to_owned())),
        ("GUIDs differ", Box::new(|text| text.replace(&guid, "{0}"))),
        ("variables differ", Box::new(|text| text.replace("\"crank_length\"", "\"crank_size\""))),
    ];
    for (reason, change) in &descriptions {
        repacked(&at("crank.fmu"), &at("odd.fmu"), |name, content| match name {
            "modelDescription.xml" => text_changed(content, change),
            _ => content,
        });
        let message = refused(folder.path(), &["info", "odd.fmu"]);
        assert!(message.contains(reason) && message.contains("damaged"), "{message}");
    }
    repacked(&at("crank.fmu"), &at("odd.fmu"), |name, content| match name {
        "resources/program.bin" => program.clone(),
        _ => content,
    });
    let message = refused(folder.path(), &["info", "odd.fmu"]);
    assert!(message.contains("GUIDs differ"), "{message}");
    repacked(&at("crank.fmu"), &at("odd.fmu"), |_, content| content);
    assert!(cotree(folder.path(), &["info", "odd.fmu"]).status.success());
}

/// What stands between two texts in a model description.
fn text_between(fmu: &Path, begin: &str, end: &str) -> String {
    let mut archive = zip::ZipArchive::new(File::open(fmu).unwrap()).unwrap();
    let mut text = String::new();
    archive.by_name("modelDescription.xml").unwrap().read_to_string(&mut text).unwrap();
    text.split_once(begin).unwrap().1.split_once(end).unwrap().0.to_owned()
}

/// What others wrote can neither command the terminal nor look like what it is not.
#[test]
fn foreign_text_shows_what_is_in_it() {
    let folder = with_scene();
    let at = |name: &str| folder.path().join(name);
    let text = fs::read_to_string(at("crank.toml")).unwrap();
    let odd = "a\\u001b]0;owned\\u0007\\u009b2Jb\u{202e}\u{9b}31m";
    let text = text.lines().map(|line| match line.split_once('=') {
        Some((key, _)) if key.trim_end() == "name" => format!("name = \"{odd}\""),
        _ => line.to_owned(),
    });
    let text = text.collect::<Vec<_>>().join("\n");
    fs::write(at("odd.toml"), &text).unwrap();
    fs::write(at("wrong.toml"), format!("\"{odd}\" = 2\n{text}")).unwrap();
    fs::write(at("odd.csv"), "time,\u{1b}[31m\u{202e}\n0,1\n").unwrap();
    assert!(cotree(folder.path(), &["export", "odd.toml", "-o", "odd.fmu"]).status.success());
    repacked(&at("odd.fmu"), &at("foreign.fmu"), |name, content| match name {
        "modelDescription.xml" => {
            text_changed(content, |text| text.replace("\"cotree ", "\"\u{202e}\u{9b}31m&#10;cotree "))
        }
        _ => content,
    });
    let commands: [&[&str]; 9] = [
        &["check", "odd.toml"],
        &["show", "odd.toml"],
        &["show", "odd.toml", "--json"],
        &["modes", "odd.toml"],
        &["modes", "odd.toml", "--json"],
        &["check", "wrong.toml"],
        &["info", "odd.fmu"],
        &["info", "foreign.fmu"],
        &["simulate", "odd.toml", "--input", "odd.csv"],
    ];
    let hidden = |c: char| (c.is_control() && c != '\n') || matches!(c, '\u{202a}'..='\u{202e}');
    let mut shown = 0;
    for arguments in commands {
        let output = cotree(folder.path(), arguments);
        for text in [String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap()] {
            assert!(!text.contains(hidden), "{arguments:?}: {text:?}");
            shown += text.matches("\\u202e").count();
        }
    }
    assert!(shown >= 7, "{shown}");
    let output = cotree(folder.path(), &["info", "odd.fmu", "--scene"]);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), text, "a file's own text stays what it is");
}

const SWINGING: &str = r#"
name = "swinging"
gravity = [0, -9.81]
[parameters]
m = "1 kg"
[bodies.bar]
mass = "m"
inertia = 0.02
points = { top = ["-0.25 m", 0], end = ["0.25 m", 0] }
[joints.pivot]
type = "revolute"
between = ["ground", "bar.top"]
[outputs]
variables = ["bar.angle", "bar.end.x", "bar.end.y"]
[experiment]
stop = 1
"#;

/// A file has the kind that its name promises, or is not written.
#[test]
fn files_are_what_their_names_say() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), SWINGING).unwrap();
    let run = |arguments: &[&str]| {
        let output = cotree(folder.path(), arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        stdout(&output)
    };
    let begins = |name: &str, with: &[u8]| {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes.starts_with(with), "{name}: {}", String::from_utf8_lossy(&bytes[..20]));
    };
    run(&["bench", "a.toml", "--plot", "b.png"]);
    begins("b.png", b"\x89PNG");
    run(&["view", "a.toml", "-o", "film.svg"]);
    begins("film.svg", b"<svg");
    // A plot without a table does not fill the terminal; who wants both says so.
    assert_eq!(run(&["simulate", "a.toml", "--plot", "c.svg"]), "");
    assert!(run(&["simulate", "a.toml", "--plot", "c.svg", "-o", "-"]).starts_with("time"));
    for (arguments, wanted) in [
        (&["bench", "a.toml", "--plot", "b.pdf"][..], "`.svg` or `.png`"),
        (&["view", "a.toml", "-o", "page.png"], "`.html`"),
        (&["view", "a.toml", "--svg", "-o", "film.html"], "`.svg`"),
        (&["simulate", "a.toml", "-o", "a.json"], "`.csv`; with --summary --json"),
        (&["motion", "a.toml", "--input", "pivot", "-o", "a.xlsx"], "`.csv`"),
        (&["trace", "a.toml", "-o", "a.svg"], "`.csv` or `.dxf`"),
        (&["sweep", "a.toml", "--set", "m=1..2:2", "--output", "last(bar.angle)", "-o", "a.json"], "`.csv`"),
    ] {
        let output = cotree(folder.path(), arguments);
        assert!(code(&output) == 2 && stderr(&output).contains(wanted), "{arguments:?}: {}", stderr(&output));
        assert!(!folder.path().join(arguments[arguments.len() - 1]).exists(), "{arguments:?}");
    }
}

/// A slide that two bars of 0.1 m and 0.3 m pull along: they are straight at 0.4 m, after 0.75 s.
const REACH: &str = r#"
name = "puller"
[bodies.crank]
points = { a = [0, 0], b = [0.1, 0] }
[bodies.bar]
points = { b = [0, 0], c = [0.3, 0] }
[bodies.slide]
[joints.foot]
type = "revolute"
between = ["ground", "crank.a"]
[joints.knee]
type = "revolute"
between = ["crank.b", "bar.b"]
[joints.head]
type = "revolute"
between = ["bar.c", "slide"]
[joints.guide]
type = "prismatic"
between = ["ground", "slide"]
axis = [1, 0]
[drivers.pull]
joint = "guide"
displacement = "0.25[m] + t*0.2[m/s]"
[initial]
"crank.angle" = { guess = 1 }
"bar.angle" = { guess = -0.4 }
[experiment]
stop = "1 s"
step = "10 ms"
"#;

#[test]
fn pages_and_archives_of_a_run_that_ends_early_say_so() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("puller.toml"), REACH).unwrap();
    for command in ["view", "export"] {
        let output = cotree(folder.path(), &[command, "puller.toml", "--runtimes", "."]);
        let said = stderr(&output);
        assert_eq!(code(&output), 0, "{said}");
        let is_told =
            said.contains("scene::ends_early") && said.contains("the motion ends before the experiment: at t = 0.7");
        assert!(is_told, "{command}: {said}");
    }
    fs::write(folder.path().join("puller.toml"), REACH.replace("1 s", "0.5 s")).unwrap();
    for command in ["view", "export"] {
        let said = stderr(&cotree(folder.path(), &[command, "puller.toml", "--runtimes", "."]));
        assert!(!said.contains("scene::ends_early"), "{command}: {said}");
    }
}

/// Two designs that were copied from each other have one name in them.
#[test]
fn scenes_of_one_name_have_files_of_their_own() {
    let folder = with_scene();
    fs::copy(folder.path().join("crank.toml"), folder.path().join("longer.toml")).unwrap();
    fs::copy(folder.path().join("crank.toml"), folder.path().join("scene.toml")).unwrap();
    for (scene, file) in [("crank.toml", "crank.fmu"), ("longer.toml", "longer.fmu")] {
        let output = cotree(folder.path(), &["export", scene]);
        assert_eq!((stdout(&output).trim(), stderr(&output).contains("existed and is overwritten")), (file, false));
    }
    let again = cotree(folder.path(), &["export", "longer.toml"]);
    assert!(stderr(&again).contains("longer.fmu existed and is overwritten"), "{}", stderr(&again));
    let page = stdout(&cotree(folder.path(), &["view", "longer.toml"]));
    assert_eq!(page.trim(), "longer.html");
    // What every scene may be called says nothing.
    let named = stdout(&cotree(folder.path(), &["export", "scene.toml"]));
    assert_ne!(named.trim(), "scene.fmu");
}
