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
        ("30,false,false,cm", "30", "truncated"),
        ("&f=", "&f=F1,1", "with forces"),
        ("B%7CC,,l", "B%7CX,,l", "has the joint `X`"),
        ("-4,2,crank", "-4,x,crank", "has no position"),
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

/// The block that the crank carries slides in a slot of the lever: the lever points to the crank's pin.
#[test]
fn a_slot_in_a_moving_link_leads_it() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ["--stop", "0.3", "--step", "0.3", "--variables", "Crank.angle,Lever.D.x,Lever.D.y,Block.angle,Lever.angle"];
    let names = ["Crank.angle", "Lever.D.x", "Lever.D.y", "Block.angle", "Lever.angle"];
    let [crank, x, y, block, lever] = moved(folder.path(), &example("slotted_lever.pmks"), &options, 0.3, names);
    let turned = 0.3 * 20.0 * PI / 30.0;
    assert!(close(crank, turned), "{crank}");
    // In centimetres: the crank's pin is 2 from (0, 0), the lever turns about (0, -5), and D is as far from there as (3.2, 3).
    let arm = [2.0 * turned.cos(), 2.0 * turned.sin() + 5.0];
    let share = 3.2_f64.hypot(8.0) / arm[0].hypot(arm[1]);
    assert!(close(x, 0.01 * share * arm[0]) && close(y, 0.01 * (share * arm[1] - 5.0)), "{x} {y}");
    assert!(close(block, lever), "{block} {lever}");
}

/// A ram: its rod is welded to the piston, which slides in the barrel at a speed of its own, until rod and barrel lie in the boom's line.
#[test]
fn a_cylinder_between_moving_links_raises_a_boom() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--stop", "2", "--step", "1", "--variables", "Boom.angle,Barrel.angle,Rod.angle"];
    let names = ["Boom.angle", "Barrel.angle", "Rod.angle"];
    let [boom, barrel, rod] = moved(folder.path(), &example("cylinder.pmks"), &options, 2.0, names);
    // In centimetres: the boom is 5 long, the pins on the ground are 3 apart, the ram is 4 long and grows by 0.5 in a second.
    let angle = |ram: f64| ((34.0 - ram * ram) / 30.0).acos();
    assert!(close(boom, angle(5.0) - angle(4.0)), "{boom}");
    assert!(close(rod, barrel), "{rod} {barrel}");
    let output = cotree(folder.path(), &["import", &example("cylinder.pmks"), "-o", "again.toml"]);
    let note = stderr(&output);
    let cut = note.split("the run stops at ").nth(1).and_then(|rest| rest.split(' ').next()).map(str::parse::<f64>);
    assert!(cut.is_some_and(|time| time.is_ok_and(|time| (7.9..=8.0).contains(&time))), "{note}");
}

/// A motor between crank and coupler; names with blanks, also as browsers copy them.
#[test]
fn a_drive_between_two_moving_links_turns_the_second_against_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ["--stop", "0.1", "--step", "0.1", "--variables", "Long_crank.angle,Tie_rod.angle,Tie_rod.C.x,Tie_rod.C.y"];
    let names = ["Long_crank.angle", "Tie_rod.angle", "Tie_rod.C.x", "Tie_rod.C.y"];
    let plain = fs::read_to_string(example("between_links.pmks")).unwrap();
    for text in
        [plain.clone(), plain.replace(' ', "%20"), format!("https://example.org/?{}", plain.replace(' ', "%20"))]
    {
        fs::write(folder.path().join("linkage.pmks"), text).unwrap();
        let [crank, rod, x, y] = moved(folder.path(), "linkage.pmks", &options, 0.1, names);
        assert!(close(rod - crank, 0.1 * 20.0 * PI / 30.0) && crank.abs() > 1e-3, "{rod} {crank}");
        // In centimetres: C is where the tie rod, (4, 1) from the crank's pin, ends, and as far from (5, 0) as at first.
        let b = [-2.0 * crank.sin(), 2.0 * crank.cos()];
        let c = [b[0] + 4.0 * rod.cos() - rod.sin(), b[1] + 4.0 * rod.sin() + rod.cos()];
        assert!(close(x, 0.01 * c[0]) && close(y, 0.01 * c[1]), "{x} {y} {c:?}");
        assert!(close(0.01 * (c[0] - 5.0).hypot(c[1]), 0.01 * 10.0_f64.sqrt()), "{c:?}");
        fs::remove_file(folder.path().join("scene.toml")).unwrap();
    }
}

/// Three links stretched between two pins: no drive moves them.
#[test]
fn what_locks_up_at_once_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let stretched = "0S.Fe.K.1011.MA,A,0,0,0.GB,B,VG,0,0.GC,C,_W,0,0.KD,D,1jO,0,0..YRAB,AB,Fe,Fe,Fe,0,c5cae9,A,B,,.YRBC,BC,Fe,Fe,ku,0,c5cae9,B,C,,.YRCD,CD,Fe,Fe,1Tm,0,c5cae9,C,D,,...Nc";
    fs::write(folder.path().join("stretched.pmks"), stretched).unwrap();
    let output = cotree(folder.path(), &["import", "stretched.pmks"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("note: it does not move: "), "{}", stderr(&output));
}

#[test]
fn guides_and_drives_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let slotted = fs::read_to_string(example("slotted_lever.pmks")).unwrap();
    let (_, slotted) = slotted.split_once('?').unwrap();
    let letters: Vec<char> = ('0'..='9').chain('A'..='Z').chain('a'..='z').collect();
    for (old, new, why) in [
        (",CD,C,D.", ",XY,C,D.", "of the link `XY`, but there is no such link"),
        (",CD,C,D.", ",CD,C,B.", "along `C` and `B` of the link `CD`, but there is no such link with these joints"),
        (",CD,C,D.", ".", "slides, but neither on the ground nor on a link"),
        ("GB,B,VG,0,0.", "QB,B,VG,0,0.", "joint `B` is driven, but welded"),
        (
            "YRCD,Lever,Fe,Fe,Fe,0Fe,c5cae9,C,D,,",
            "YRCD,Lever,Fe,Fe,Fe,0Fe,c5cae9,A,C,D,,",
            "joint `A` is driven, but joins 3 bodies",
        ),
        (".YPBP", ".ZPBP", "is not as PMKS+ writes one"),
    ] {
        assert!(slotted.contains(old), "{old}");
        let body = slotted[..slotted.len() - 1].replace(old, new);
        let text = format!("{body}{}", letters[body.len() % 62]);
        fs::write(folder.path().join("odd.pmks"), text).unwrap();
        let output = cotree(folder.path(), &["import", "odd.pmks", "-o", "odd.toml"]);
        assert!(code(&output) == 2 && stderr(&output).contains(why), "{new}: {}", stderr(&output));
    }
}

/// A crank to and fro within its arc, as pylinkage bounces it: here from 0.2 rad above its lower end, 0.6 below the upper one, at 0.2 rad/s.
#[test]
fn an_arc_driver_of_pylinkage_goes_to_and_fro() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--stop", "12", "--step", "1", "--variables", "wiper.angle"];
    for (time, angle) in [(2.0, 0.4), (3.0, 0.6), (5.0, 0.2), (7.0, -0.2), (8.0, 0.0), (11.0, 0.6), (12.0, 0.4)] {
        let [wiper] = moved(folder.path(), &example("to_and_fro.json"), &options, time, ["wiper.angle"]);
        assert!(close(wiper, angle), "{wiper} for {angle} at {time}");
        fs::remove_file(folder.path().join("scene.toml")).unwrap();
    }
    let outside = fs::read_to_string(example("to_and_fro.json")).unwrap().replace("1.3853981633974484", "0.7");
    fs::write(folder.path().join("outside.json"), outside).unwrap();
    let output = cotree(folder.path(), &["import", "outside.json"]);
    assert!(code(&output) == 2 && stderr(&output).contains("but its arc is from"), "{}", stderr(&output));
}

#[test]
fn what_cannot_be_read_is_refused_with_every_reason() {
    let folder = tempfile::tempdir().unwrap();
    let good = fs::read_to_string(example("four_bar.pmks")).unwrap();
    let json = fs::read_to_string(example("four_bar.json")).unwrap();
    let odd = json.replace("\"driver\"", "\"servo\"").replace("\"coupler.1_rocker.0\"\n", "\"nowhere\"\n");
    for (text, words) in [
        (good.replace("crank", "crankshaft"), vec!["truncated or changed"]),
        (good[..40].to_owned(), vec!["neither a file or address of PMKS+"]),
        (json[..60].to_owned(), vec!["not JSON of pylinkage"]),
        ("{}".to_owned(), vec!["not JSON of pylinkage"]),
        (odd, vec!["type `servo`, which is not supported", "joint `nowhere`, which is not there"]),
        ("{\"joints\": [], \"links\": []}".to_owned(), vec!["no link that moves"]),
        (String::new(), vec!["it is empty"]),
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
    assert!(stderr(&cotree(folder.path(), &["import", "odd.txt"])).contains("neither a file"));
    fs::write(folder.path().join("four_bar.toml"), "mine").unwrap();
    let output = cotree(folder.path(), &["import", &example("four_bar.pmks")]);
    assert!(stderr(&output).contains("exists already"), "{}", stderr(&output));
    assert_eq!(fs::read_to_string(folder.path().join("four_bar.toml")).unwrap(), "mine");
}
