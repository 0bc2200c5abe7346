//! Linkages of PMKS+ and pylinkage as scenes: they move as elementary geometry, or pylinkage itself, says.

use crate::outside::command;
use crate::support::ROOT;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};

fn example(name: &str) -> String {
    Path::new(ROOT).join("tests/import").join(name).to_str().unwrap().to_owned()
}

/// Imports a file, checks the scene, and gives the values of its variables at a time of its run.
fn moved<const N: usize>(folder: &Path, file: &str, options: &[&str], time: f64, names: [&str; N]) -> [f64; N] {
    let output = cotree(folder, &["import", file, "-o", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("cotree check scene.toml"));
    let output = cotree(folder, &["check", "scene.toml"]);
    let scene = fs::read_to_string(folder.join("scene.toml")).unwrap();
    assert_eq!(code(&output), 0, "{}\n{scene}", stderr(&output));
    let output = cotree(folder, &[&["simulate", "scene.toml"], options].concat());
    assert_eq!(code(&output), 0, "{}\n{scene}", stderr(&output));
    let table = stdout(&output);
    let mut lines = table.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows = lines.map(|line| line.split(',').map(|value| value.parse().unwrap()).collect::<Vec<f64>>());
    let row = rows.into_iter().find(|row| (row[0] - time).abs() < 1e-9).unwrap();
    names.map(|name| {
        row[heads.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no {name} in {heads:?}"))]
    })
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn a_four_bar_of_pmks_moves_as_its_circles_meet() {
    let folder = tempfile::tempdir().unwrap();
    let [crank, x, y] =
        moved(folder.path(), &example("four_bar.pmks"), &[], 0.24, ["crank.angle", "coupler.tip.x", "coupler.tip.y"]);
    let turned = PI * 0.24; // 30 revolutions a minute
    assert!(close(crank, turned), "{crank}");
    // In centimetres: O1 (-4, 0), B (-4, 2), C (1, 4), O2 (3, 0.5), tip (-1, 5).
    let b = [-4.0 - 2.0 * turned.sin(), 2.0 * turned.cos()];
    let (coupler, rocker) = (29.0_f64.sqrt(), 16.25_f64.sqrt());
    let away = [3.0 - b[0], 0.5 - b[1]];
    let distance = away[0].hypot(away[1]);
    let along = (distance * distance + coupler * coupler - rocker * rocker) / (2.0 * distance);
    let across = (coupler * coupler - along * along).sqrt();
    let axis = away.map(|x| x / distance);
    let c = [b[0] + along * axis[0] - across * axis[1], b[1] + along * axis[1] + across * axis[0]];
    // The tip in the axes of the coupler: (3, 3) from B, where C is (5, 2).
    let (p, q) = ((3.0 * 5.0 + 3.0 * 2.0) / 29.0, (5.0 * 3.0 - 2.0 * 3.0) / 29.0);
    let arm = [c[0] - b[0], c[1] - b[1]];
    let tip = [b[0] + p * arm[0] - q * arm[1], b[1] + p * arm[1] + q * arm[0]];
    assert!(close(x, 0.01 * tip[0]) && close(y, 0.01 * tip[1]), "{x} {y} is not {tip:?} cm");
    let scene = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    for text in [
        "# From PMKS+",
        "gravity = [0, -9.81]",
        "mass    = 0.5\n",
        "inertia = 2.5e-5\n",
        "[loads.F1]",
        "vector = [3.0, 0.0]",
    ] {
        assert!(scene.contains(text), "{text}\n{scene}");
    }
}

/// An address of the older form: a crank with 30 revolutions a minute, a coupler, a rocker.
const OLDER: &str = "https://example.org/?j=O1,-4,0,crank,R,t,0,0.1,t,%0AB,-4,2,crank%7Ccoupler,R,f,0,0.1,f,%0A\
C,1,4,coupler%7Crocker,R,f,0,0.1,f,%0AO2,3,0.5,rocker,R,t,0,0.1,f,%0A&l=crank,0.5,1,-4,1,O1%7CB,,l,0,0,1,1%0A\
coupler,1,2,-1.5,3,B%7CC,,l,0,0,1,1%0Arocker,1,1,2,2.25,C%7CO2,,l,0,0,1,1%0A&f=&pp=&tp=&s=30,false,false,cm";

#[test]
fn an_older_address_of_pmks_has_the_same_pose() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("older.pmks"), OLDER).unwrap();
    let options =
        ["--stop", "0.24", "--step", "0.24", "--variables", "crank.angle,coupler.C.x,coupler.C.y,rocker.x,rocker.y"];
    let names = ["crank.angle", "coupler.C.x", "coupler.C.y", "rocker.x", "rocker.y"];
    let [_, x, y, centre_x, centre_y] = moved(folder.path(), "older.pmks", &options, 0.0, names);
    assert!(
        close(x, 0.01) && close(y, 0.04) && close(centre_x, 0.02) && close(centre_y, 0.0225),
        "{x} {y} {centre_x} {centre_y}"
    );
    fs::remove_file(folder.path().join("scene.toml")).unwrap();
    let [crank, x, y, ..] = moved(folder.path(), "older.pmks", &options, 0.24, names);
    let turned = PI * 0.24;
    assert!(close(crank, turned), "{crank}");
    // Both links keep their lengths.
    let b = [-0.04 - 0.02 * turned.sin(), 0.02 * turned.cos()];
    assert!(close((x - b[0]).hypot(y - b[1]), 0.01 * 29.0_f64.sqrt()), "{x} {y}");
    assert!(close((x - 0.03).hypot(y - 0.005), 0.01 * 16.25_f64.sqrt()), "{x} {y}");
    let scene = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    assert!(scene.contains("mass    = 0.5\n") && scene.contains("inertia = 0.0001\n"), "{scene}");
}

#[test]
fn what_an_older_address_does_not_say_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (old, new, why) in [
        ("C,1,4,coupler%7Crocker,R", "C,1,4,coupler%7Crocker,P", "joint `C` slides"),
        ("false,false,cm", "false,true,cm", "which of the two is not known"),
        ("false,false,cm", "false,false,in", "lengths are in `in`"),
        ("30,false,false,cm", "30", "cut"),
        ("&f=", "&f=F1,1", "with forces"),
        ("B%7CC,,l", "B%7CX,,l", "has the joint `X`"),
        ("-4,2,crank", "-4,x,crank", "has no place"),
        (
            "C,1,4,coupler%7Crocker,R,f,0,0.1,f",
            "C,1,4,coupler%7Crocker,R,f,0,0.1,t",
            "does not join a link to the ground",
        ),
    ] {
        assert!(OLDER.contains(old), "{old}");
        fs::write(folder.path().join("older.pmks"), OLDER.replace(old, new)).unwrap();
        let output = cotree(folder.path(), &["import", "older.pmks", "-o", "scene.toml"]);
        assert!(code(&output) != 0 && stderr(&output).contains(why), "{new}: {}", stderr(&output));
        assert!(!folder.path().join("scene.toml").exists());
    }
}

/// Files that were saved before PMKS+ wrote what is selected.
#[test]
fn older_files_of_pmks_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let new = fs::read_to_string(example("four_bar.pmks")).unwrap();
    let old = new.trim_end().strip_suffix(".Nj").unwrap();
    let letters: Vec<char> = ('0'..='9').chain('A'..='Z').chain('a'..='z').collect();
    for (name, text) in [("old", format!("{old}{}", letters[old.len() % 62])), ("new", new.clone())] {
        let (file, scene) = (format!("{name}.pmks"), format!("{name}/linkage.toml"));
        fs::write(folder.path().join(&file), text).unwrap();
        fs::create_dir(folder.path().join(name)).unwrap();
        let output = cotree(folder.path(), &["import", &file, "-o", &scene]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let scene = |name: &str| fs::read_to_string(folder.path().join(name).join("linkage.toml")).unwrap();
    assert_eq!(scene("old"), scene("new"));
}

#[test]
fn a_slider_crank_comes_out_of_a_shared_address() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--step", "0.01", "--stop", "1"];
    let [crank, rod] = moved(folder.path(), &example("slider_crank.pmks"), &options, 0.5, ["AB.angle", "BC.angle"]);
    let turned = -20.0 * PI / 30.0 * 0.5; // clockwise
    assert!(close(crank, turned), "{crank}");
    let height = 0.3 * turned.sin() + 0.4 * turned.cos();
    assert!(close(rod, ((0.4 - height) / 1.2).asin()), "{rod}");
}

/// The expected places are those of pylinkage 1.3 after so many steps.
#[test]
fn linkages_of_pylinkage_move_as_there() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--step", "1", "--stop", "30"];
    let angle = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]).atan2(b[0] - a[0]);
    let start = angle([0.8775825618903728, 0.479425538604203], [2.020779667684897, -1.7438828919341742]);
    for (step, crank, joint) in [
        (10, [0.07073720166770268, 0.9974949866040544], [1.359849286158874, -1.144511090329161]),
        (30, [-0.9364566872907957, -0.3507832276896215], [1.4100497297956878, -1.213284030339655]),
    ] {
        let file = example("four_bar.json");
        fs::remove_file(folder.path().join("scene.toml")).ok();
        let [coupler] = moved(folder.path(), &file, &options, f64::from(step), ["coupler.angle"]);
        let off = (coupler - (angle(crank, joint) - start)) / (2.0 * PI);
        assert!(close(off, off.round()), "{coupler} after {step} steps");
    }
    fs::remove_file(folder.path().join("scene.toml")).unwrap();
    let [rod] = moved(folder.path(), &example("slider_crank.json"), &options, 10.0, ["rod.angle"]);
    let start = angle([0.7648421872844885, 0.644217687237691], [-2.1651720740204152, 0.0]);
    let end = angle([-0.9040721420170612, 0.4273798802338298], [-3.873473838987567, 0.0]);
    let off = (rod - (end - start)) / (2.0 * PI);
    assert!(close(off, off.round()), "{rod}");
    let scene = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    assert!(scene.contains("type    = \"slot\"") && scene.contains("# assumed"), "{scene}");
}

#[test]
fn what_cannot_be_read_is_refused_with_every_reason() {
    let folder = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(example("four_bar.pmks")).unwrap();
    let json = fs::read_to_string(example("four_bar.json")).unwrap();
    let odd = json.replace("\"driver\"", "\"arc_driver\"").replace("\"coupler.1_rocker.0\"\n", "\"nowhere\"\n");
    for (text, words) in [
        (good.replace("crank", "crankshaft"), vec!["cut or changed"]),
        (good[..40].to_owned(), vec!["neither a file or address of PMKS+"]),
        (json[..60].to_owned(), vec!["not JSON of pylinkage"]),
        ("{}".to_owned(), vec!["not JSON of pylinkage"]),
        (odd, vec!["type `arc_driver`, which is not supported", "joint `nowhere`, which is not there"]),
        ("{\"joints\": [], \"links\": []}".to_owned(), vec!["no link that moves"]),
        (String::new(), vec!["neither"]),
    ] {
        fs::write(folder.path().join("odd.txt"), &text).unwrap();
        let output = cotree(folder.path(), &["import", "odd.txt"]);
        assert_eq!(code(&output), 2, "{text}");
        for word in words {
            assert!(stderr(&output).contains(word), "{word}\n{}", stderr(&output));
        }
        assert!(!folder.path().join("odd.toml").exists());
    }
    fs::write(folder.path().join("odd.txt"), [0xff, 0xfe, 0]).unwrap();
    assert!(stderr(&cotree(folder.path(), &["import", "odd.txt"])).contains("not a text"));
    fs::write(folder.path().join("four_bar.toml"), "mine").unwrap();
    let output = cotree(folder.path(), &["import", &example("four_bar.pmks")]);
    assert!(stderr(&output).contains("exists already"), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(folder.path().join("four_bar.toml")).unwrap(), "mine");
}
