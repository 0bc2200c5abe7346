//! `cotree sweep` as it is used: its table against single runs, threads, stopped and resumed.

use crate::outside::command;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use command::{code, cotree, stderr, stdout};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/slider_crank/scene.toml");

/// The rows of a table without quotes, the heading apart.
fn rows(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

fn swept(folder: &Path, arguments: &[&str]) -> String {
    let output = cotree(folder, &[&["sweep", SCENE, "--stop", "0.5"], arguments].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    stdout(&output)
}

/// A column of `cotree simulate`.
fn simulated(folder: &Path, variable: &str, settings: &[&str]) -> Vec<f64> {
    let sets = settings.iter().flat_map(|setting| ["--set", setting]);
    let arguments: Vec<&str> = ["simulate", SCENE, "--stop", "0.5"].into_iter().chain(sets).collect();
    let (names, rows) = rows(&stdout(&cotree(folder, &arguments)));
    let column = names.iter().position(|name| name.split(' ').next() == Some(variable)).unwrap();
    rows.iter().map(|row| row[column].parse().unwrap()).collect()
}

#[test]
fn every_row_is_a_run_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["--set", "crank_length=0.4,0.45", "--set", "rod_length=125..150 cm:3"];
    let measures = ["--output", "max(cylinder.s)", "--output", "when_min(cylinder.s)", "--output", "crank.angle"];
    let (names, found) = rows(&swept(folder.path(), &[&sets[..], &measures].concat()));
    let heading = "run,crank_length [m],rod_length [m],max(cylinder.s) [m],when_min(cylinder.s) [s],last(crank.angle) [rad],failure";
    assert_eq!(names.join(","), heading);
    assert_eq!(found.len(), 6);
    let pairs: Vec<String> = found.iter().map(|row| row[1..3].join(" ")).collect();
    assert_eq!(pairs, ["0.4 1.25", "0.4 1.375", "0.4 1.5", "0.45 1.25", "0.45 1.375", "0.45 1.5"]);
    for row in &found {
        let settings = [format!("crank_length={}", row[1]), format!("rod_length={}", row[2])];
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let s = simulated(folder.path(), "cylinder.s", &settings);
        let angle = simulated(folder.path(), "crank.angle", &settings);
        let times = simulated(folder.path(), "time", &settings);
        let least = (0..s.len()).fold(0, |least, index| if s[index] < s[least] { index } else { least });
        let wanted = [s.iter().copied().fold(f64::MIN, f64::max), times[least], angle[angle.len() - 1]];
        for (value, wanted) in row[3..6].iter().zip(wanted) {
            let value: f64 = value.parse().unwrap();
            assert!((value - wanted).abs() < 1e-6 * wanted.abs().max(1.0), "{value}, not {wanted}: {row:?}");
        }
    }
}

#[test]
fn the_numbers_do_not_depend_on_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    let design = ["--latin", "40", "--seed", "3", "--set", "rod_length=1.5 m~5 mm", "--set", "crank_length=0.5+-0.01"];
    let measure = ["--output", "mean(energy.total)"];
    let [one, three] =
        ["1", "3"].map(|count| swept(folder.path(), &[&design[..], &measure, &["--threads", count]].concat()));
    assert_eq!(one, three);
    let (_, found) = rows(&one);
    assert_eq!(found.len(), 40);
    let other = swept(folder.path(), &[&["--latin", "40", "--seed", "4"], &design[4..], &measure].concat());
    assert_ne!(one, other);
}

#[test]
fn a_table_of_runs_may_have_units_and_failing_runs() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("runs.csv");
    fs::write(&table, "rod_length [m],crank.angle\n1.5,30 deg\n60 cm,0.1\n\"1.4\",0.2\n").unwrap();
    let text = swept(folder.path(), &["--table", "runs.csv", "--set", "crank_length=0.7", "--output", "crank.angle"]);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[1].starts_with("0,1.5,0.5235987755982988,0.7,") && lines[1].ends_with(','), "{text}");
    // A rod shorter than the crank cannot follow it all the way round, but from here it can start.
    assert!(lines[2].starts_with("1,0.6,0.1,0.7,"), "{text}");
    fs::write(&table, "rod_length,crank.angle\n1.5,0\n1 kg,0\n").unwrap();
    let output = cotree(folder.path(), &["sweep", SCENE, "--table", "runs.csv"]);
    assert!(
        code(&output) == 2 && stderr(&output).contains("line 3") && stderr(&output).contains("kg"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_run_that_fails_does_not_end_the_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--set", "rod_length=1.5,0.61,1.4", "--set", "crank_length=2.9", "--set", "crank.angle=90 deg"];
    let text = swept(folder.path(), &[&arguments[..], &["--output", "cylinder.s"]].concat());
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4, "{text}");
    assert!(lines[1..].iter().all(|line| line.contains("the mechanism cannot start")), "{text}");
}

#[test]
fn a_stopped_sweep_goes_on_and_ends_as_an_undisturbed_one() {
    let folder = tempfile::tempdir().unwrap();
    let design = ["--set", "rod_length=1.2..1.6:400", "--output", "max(cylinder.s)"];
    let long = ["--stop", "20"];
    let arguments = [&["sweep", SCENE][..], &design, &long].concat();
    let whole = cotree(folder.path(), &[&arguments[..], &["-o", "whole.csv", "--plot", "whole.svg"]].concat());
    assert_eq!(code(&whole), 0, "{}", stderr(&whole));
    let stopped = [&arguments[..], &["-o", "out.csv"]].concat();
    let mut child = Command::new(env!("CARGO_BIN_EXE_cotree"))
        .current_dir(folder.path())
        .args(&stopped)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let part = folder.path().join("out.csv.part");
    let some = || fs::read_to_string(&part).is_ok_and(|text| text.lines().count() > 5);
    while !some() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    if part.exists() {
        // Cut off in the middle of a line, as a crash may leave it.
        let text = fs::read(&part).unwrap();
        fs::write(&part, &text[..text.len() - 3]).unwrap();
        let again = cotree(folder.path(), &stopped);
        assert!(code(&again) == 2 && stderr(&again).contains("--resume"), "{}", stderr(&again));
        let other = [
            &arguments[..2],
            &["--set", "rod_length=1.2..1.5:400", "--output", "max(cylinder.s)", "-o", "out.csv", "--resume"],
        ];
        let other = cotree(folder.path(), &other.concat());
        assert!(code(&other) == 2 && stderr(&other).contains("another sweep"), "{}", stderr(&other));
    }
    let resumed = cotree(folder.path(), &[&stopped[..], &["--resume", "--plot", "out.svg"]].concat());
    assert_eq!(code(&resumed), 0, "{}", stderr(&resumed));
    assert!(!part.exists());
    for names in [["whole.csv", "out.csv"], ["whole.svg", "out.svg"]] {
        let [whole, out] = names.map(|name| fs::read(folder.path().join(name)).unwrap());
        assert!(whole == out, "{names:?}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, exit, message) in [
        (&["--set", "rod_lenght=1..2:3"][..], 2, "did you mean `rod_length`"),
        (&["--set", "rod_length=1..2"], 2, "give a count"),
        (&["--set", "rod_length=1..2:3", "--set", "rod_length=1"], 2, "twice"),
        (&["--set", "rod_length=1..2 kg:3"], 2, "kg"),
        (&["--output", "largest(cylinder.s)"], 2, "not one of max"),
        (&["--output", "max(cylinder.z)"], 1, "cylinder"),
        (&["--output", "max(cylinder.z)"], 1, "the request"),
        (&["--set", "rod_length=0.1,1.5"], 2, "0.1 must be at least 0.6 m"),
        (&["--random", "10", "--latin", "3"], 2, "cannot be used with"),
        (&["--random", "0", "--set", "rod_length=1.4..1.5"], 2, "number of runs is 0"),
        (&["--resume"], 2, "--csv"),
        (&["--stop", "-1"], 2, "before the start"),
    ] {
        let output = cotree(folder.path(), &[&["sweep", SCENE], arguments].concat());
        assert!(code(&output) == exit && stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn everything_that_is_wrong_is_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |command: &str, arguments: &[&str], messages: &[&str]| {
        let output = cotree(folder.path(), &[&[command, SCENE], arguments].concat());
        let text = stderr(&output);
        assert_eq!(code(&output), 2, "{text}");
        assert!(messages.iter().all(|message| text.contains(message)), "{text}");
    };
    let sets = ["--set", "rod_lenght=1", "--set", "crank_length=1 kg", "--set", "gas_force=x"];
    let said = ["`rod_length`", "1 kg", "`x`"];
    wrong("simulate", &sets, &said);
    wrong("equilibrium", &sets, &said);
    wrong("sweep", &sets, &said);
    let measures = ["--output", "mox(cylinder.s)", "--output", "max(cylinder.s"];
    wrong("sweep", &[&sets[..], &measures].concat(), &[&said[..], &["`mox`", "max(variable)"]].concat());
    fs::write(folder.path().join("runs.csv"), "rod_length;gas_force [kN]\n1,5\n1,4;x\n1,3;2\n0,5;0\n").unwrap();
    wrong(
        "sweep",
        &["--table", "runs.csv"],
        &["line 2: 1 fields", "line 3, `gas_force`", "line 5, `rod_length`: 0.5 must"],
    );
    fs::write(folder.path().join("names.csv"), "rod,gas_force [kg],crank\n1,2,3\n").unwrap();
    wrong("sweep", &["--table", "names.csv"], &["`rod`", "in kg, not in N", "`crank`"]);
    fs::write(folder.path().join("none.csv"), "rod_length\n").unwrap();
    wrong("sweep", &["--table", "none.csv"], &["no runs"]);
    wrong("simulate", &["--sensitivity", "rod_lenght"], &["`rod_length`"]);
}

#[test]
fn tables_and_tolerances_are_written_as_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let measure = ["--output", "cylinder.s"];
    let table = |text: &str| {
        fs::write(folder.path().join("runs.csv"), text).unwrap();
        swept(folder.path(), &[&["--table", "runs.csv"][..], &measure].concat())
    };
    let wanted = table("rod_length,crank.angle\n1.5,0.5\n1.25,1\n");
    assert_eq!(table("rod_length [mm];crank.angle [rad]\n1500;0,5\n1,25 m;1\n"), wanted);
    assert_eq!(table("rod_length [cm]\tcrank.angle\n150\t0.5\n125\t1\n"), wanted);
    let drawn = |within: &str| {
        let set = format!("rod_length=1.5 m{within}");
        swept(folder.path(), &[&["--random", "3", "--set", set.as_str()][..], &measure].concat())
    };
    assert_eq!(drawn("+-2 %"), drawn("+-0.03 m"));
    assert_eq!(drawn("~2%"), drawn("~30 mm"));
    assert_eq!(drawn("+-2 %").lines().count(), 4);
}

#[test]
fn a_picture_is_a_curve_a_map_or_a_histogram() {
    let folder = tempfile::tempdir().unwrap();
    let measure = ["--output", "max(cylinder.fn)", "--stop", "0.1"];
    let drawn = |design: &[&str]| {
        let output = cotree(
            folder.path(),
            &[&["sweep", SCENE, "--plot", "out.svg", "-o", "out.csv"], design, &measure].concat(),
        );
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        fs::read_to_string(folder.path().join("out.svg")).unwrap()
    };
    let curves = drawn(&["--set", "rod_length=1.5,1.3", "--set", "crank_length=0.6,0.5,0.4,0.55,0.45"]);
    for text in ["10 runs", ">crank_length [m]<", "max(cylinder.fn) [N]", "rod_length = 1.3 m", "rod_length = 1.5 m"] {
        assert!(curves.contains(text), "{text}: {curves}");
    }
    let paths: Vec<&str> = curves.split("<path d=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(paths.len(), 2);
    for path in paths {
        let right: Vec<f64> =
            path.split(['M', 'L']).skip(1).map(|pair| pair.split(' ').next().unwrap().parse().unwrap()).collect();
        assert!(right.len() == 5 && right.is_sorted(), "{path}");
    }
    let map = drawn(&["--set", "rod_length=1.3..1.5:5", "--set", "crank_length=0.4..0.6:6", "--set", "crank.angle=1"]);
    assert!(map.contains(">crank_length [m]<") && map.contains(">rod_length [m]<"), "{map}");
    // The first group has the cells, all of them different.
    let cells = map.split("<g shape-rendering").nth(1).unwrap().split("</g>").next().unwrap();
    assert_eq!(cells.matches("<rect").count(), 30);
    assert!(cells.contains("#440154") && cells.contains("#fde725") && !cells.contains("#c9ced6"));
    let failing = drawn(&[
        "--set",
        "rod_length=0.61,1.2,1.3,1.4,1.5",
        "--set",
        "crank_length=0.5..2:5",
        "--set",
        "crank.angle=90 deg",
    ]);
    assert!(failing.contains("failed (grey)") && failing.contains("#c9ced6"), "{failing}");
    let histogram = drawn(&["--latin", "50", "--set", "rod_length=1.5 m~5 mm"]);
    assert!(histogram.contains(">runs<") && histogram.contains(">max(cylinder.fn) [N]<") && histogram.contains(">50<"));
    for (design, message) in [
        (vec![], "nothing is varied"),
        (
            vec!["--set", "rod_length=1.4,1.5", "--set", "crank_length=0.4,0.5", "--set", "crank.angle=1,2"],
            "3 quantities",
        ),
    ] {
        let output = cotree(folder.path(), &[&["sweep", SCENE, "--plot", "no.png"], &design[..]].concat());
        assert!(code(&output) == 2 && stderr(&output).contains(message), "{}", stderr(&output));
    }
}

/// Parts as an array of jobs makes them, one of them stopped and continued: together they are the bytes of one sweep.
#[test]
fn parts_are_joined_to_the_table_of_one_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let random = ["--random", "20", "--set", "rod_length=1.5~0.01", "--output", "max(cylinder.s)"];
    let whole = swept(folder.path(), &[&random[..], &["--seed", "7"]].concat());
    let part = |part: &str, seed: &str, more: &[&str]| {
        let name = format!("{seed}_{}.csv", part.replace('/', "of"));
        swept(folder.path(), &[&random[..], &["--seed", seed, "--part", part, "-o", &name], more].concat());
        name
    };
    let names: Vec<String> = ["1/3", "2/3", "3/3"].map(|number| part(number, "7", &[])).into();
    let path = |name: &str| folder.path().join(name);
    // The second one is stopped within its third row.
    let second = fs::read_to_string(path(&names[1])).unwrap();
    let rows: Vec<&str> = second.split_inclusive('\n').collect();
    let (mark, _) = rows[0].rsplit_once(", rows ").unwrap();
    fs::write(path(&format!("{}.part", names[1])), format!("{mark}\n{}{}", rows[1..4].concat(), &rows[4][..2]))
        .unwrap();
    fs::remove_file(path(&names[1])).unwrap();
    let join = |names: &[&str]| cotree(folder.path(), &[&["join", "-o", "joined.csv"], names].concat());
    let [one, two, three] = [&names[0], &names[1], &names[2]].map(String::as_str);
    assert!(stderr(&join(&[one, three])).contains("parts 2 are missing"));
    part("2/3", "7", &["--resume"]);
    assert_eq!(stdout(&join(&[three, one, two])), "joined.csv: 20 runs\n");
    assert_eq!(fs::read_to_string(path("joined.csv")).unwrap(), whole);
    // A number that was edited.
    fs::write(path("edited.csv"), second.replacen("1.5", "1.6", 1)).unwrap();
    assert_ne!(fs::read_to_string(path("edited.csv")).unwrap(), second);
    let refused = join(&[one, "edited.csv", three]);
    assert!(code(&refused) == 2 && stderr(&refused).contains("`edited.csv` has been changed"), "{}", stderr(&refused));
    // Other values of as many runs.
    let other = part("2/3", "8", &[]);
    let refused = join(&[one, &other, three]);
    assert!(code(&refused) == 2 && stderr(&refused).contains("different sweeps"), "{}", stderr(&refused));
}
