//! Files that are parts of scenes: a wishbone written once and used twice is the scene that is written out, to the last bit; faults of a part's file
//! show that file; what cannot be combined is refused.

use crate::support::run;

use std::io::Read;
use std::path::{Path, PathBuf};

use cotree::compile::compile;
use cotree::scene::{Faults, Scene};

use run::sound;

const WISHBONE: &str = r#"
[parameters]
length = "0.36 m"
stiffness = { value = "22 kN/m", unit = "N/m" }
torque = "3 N.m"

[ground.points]
lower = ["340 mm", "-0.09 m"]
strut = [0.44, "length"]

[bodies.arm]
mass = 4.0
inertia = 0.05
com = ["10 mm", 0]
points = { pivot = ["-length/2", 0], ball = ["length/2", 0] }

[joints.pivot]
type = "revolute"
between = ["ground.lower", "arm.pivot"]

[loads.strut]
type = "spring"
between = ["arm.ball", "ground.strut"]
stiffness = "stiffness"
length = "0.5*length"

[loads.bush]
type = "torsion_actuator"
between = ["ground", "arm"]
torque = "torque - 2*angle - 0.3*omega + 0.1*arm.vx"

[loads.wind]
type = "force"
on = "arm.ball"
vector = ["12 N", "-5*arm.angle"]

[initial]
"arm.angle" = "5 deg"

[outputs]
variables = ["arm.angle", "strut.force", "pivot.fx"]
"#;

/// A folder for files that is removed again.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, files: &[(&str, &str)]) -> Folder {
        let folder = std::env::temp_dir().join(format!("cotree_parts_{name}_{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        for (file, text) in files {
            let path = folder.join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        Folder(folder)
    }

    fn read(&self, file: &str) -> Result<Scene, Faults> {
        Scene::read(self.0.join(file))
    }

    fn faults(&self, file: &str) -> Faults {
        match self.read(file).and_then(|scene| scene.resolve()) {
            Ok(_) => panic!("{file} is no fault"),
            Err(faults) => faults,
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const HOST: &str = r#"
name = "axle"
gravity = [0.0, -9.81]

[parameters]
half = "0.2 m"
"#;

fn bits(scene: &Scene) -> Vec<u64> {
    let mut instance = run::started(
        &std::sync::Arc::new(cotree_fmu::model::Model::new(sound(compile(scene)).program).expect("sound")),
        None,
        0.5,
        1e-9,
    );
    instance.step_to(0.5).expect("regular");
    run::motion(&instance).into_iter().map(f64::to_bits).collect()
}

/// The same as a scene would say it that has no parts; `@` stands for the name of the part.
const WRITTEN: &str = r#"
[parameters]
@_length = "0.36 m"
@_stiffness = { value = "22 kN/m", unit = "N/m" }
@_torque = "3 N.m"

[ground.points]
@_lower = ["340 mm", "-0.09 m"]
@_strut = [0.44, "@_length"]

[bodies.@_arm]
mass = 4.0
inertia = 0.05
com = ["10 mm", 0]
points = { pivot = ["-@_length/2", 0], ball = ["@_length/2", 0] }

[joints.@_pivot]
type = "revolute"
between = ["ground.@_lower", "@_arm.pivot"]

[loads.@_strut]
type = "spring"
between = ["@_arm.ball", "ground.@_strut"]
stiffness = "@_stiffness"
length = "0.5*@_length"

[loads.@_bush]
type = "torsion_actuator"
between = ["ground", "@_arm"]
torque = "@_torque - 2*angle - 0.3*omega + 0.1*@_arm.vx"

[loads.@_wind]
type = "force"
on = "@_arm.ball"
vector = ["12 N", "-5*@_arm.angle"]

[initial]
"@_arm.angle" = "5 deg"

[outputs]
variables = ["@_arm.angle", "@_strut.force", "@_pivot.fx"]
"#;

fn written_out(part: &str, changes: &[(&str, &str)]) -> String {
    let mut text = WRITTEN.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text.replace('@', part)
}

/// Puts the tables of two scenes together: TOML wants each header once.
fn merged(texts: &[String]) -> String {
    let mut sections: Vec<(String, String)> = Vec::new();
    for text in texts {
        let mut header = String::new();
        for line in text.lines() {
            if line.starts_with('[') {
                line.clone_into(&mut header);
            } else {
                match sections.iter_mut().find(|(own, _)| *own == header) {
                    Some((_, body)) if line.starts_with("variables") => {
                        let more = line.split_once('[').expect("a list").1;
                        *body = body.replacen(']', &format!(", {more}"), 1);
                    }
                    Some((_, body)) => *body += &format!("{line}\n"),
                    None => sections.push((header.clone(), format!("{line}\n"))),
                }
            }
        }
    }
    sections.iter().map(|(header, body)| format!("{header}\n{body}\n")).collect()
}

#[test]
fn a_wishbone_used_twice_is_the_scene_written_out_to_the_last_bit() {
    let parts = r#"
[parts.right]
file = "parts/wishbone.toml"

[parts.left]
file = "parts/wishbone.toml"
parameters = { length = "half + 0.1" }
mirror = true
"#;
    let files = [("axle.toml", &*format!("{HOST}{parts}")), ("parts/wishbone.toml", WISHBONE)];
    let folder = Folder::new("twice", &files);
    let twice = sound(folder.read("axle.toml"));
    let mirrored = [
        ("length = \"0.36 m\"", "length = \"half + 0.1\""),
        ("\"340 mm\"", "\"-340 mm\""),
        ("[0.44, ", "[-0.44, "),
        ("[\"10 mm\", 0]", "[\"-10 mm\", 0]"),
        ("[\"-@_length/2\", 0]", "[\"-(-@_length/2)\", 0]"),
        ("ball = [\"@_length/2\", 0]", "ball = [\"-(@_length/2)\", 0]"),
        ("@_torque - 2*angle - 0.3*omega + 0.1*@_arm.vx", "-(@_torque - 2*(-angle) - 0.3*(-omega) + 0.1*(-@_arm.vx))"),
        ("[\"12 N\", \"-5*@_arm.angle\"]", "[\"-12 N\", \"-5*(-@_arm.angle)\"]"),
        ("\"5 deg\"", "\"-5 deg\""),
    ];
    let text = merged(&[HOST.to_owned(), written_out("right", &[]), written_out("left", &mirrored)]);
    let out = sound(Scene::from_toml(&text));
    assert_eq!(sound(twice.resolve()).mechanism, sound(out.resolve()).mechanism, "\n{text}");
    assert_eq!(bits(&twice), bits(&out));
    // The mirror image of itself, if nothing else differs.
    let files =
        [("axle.toml", &*format!("{HOST}{}", parts.replace("half + 0.1", "0.36"))), ("parts/wishbone.toml", WISHBONE)];
    let folder = Folder::new("same", &files);
    let motion: Vec<f64> = bits(&sound(folder.read("axle.toml"))).into_iter().map(f64::from_bits).collect();
    assert!((motion[0] + motion[1]).abs() < 1e-9 && motion[0].abs() > 1e-3, "{motion:?}");
}

/// A part that is turned and moved does what the part alone does, seen from elsewhere.
#[test]
fn a_part_that_is_placed_moves_as_it_does_alone() {
    // No gravity: it would not turn with the part.
    let alone =
        WISHBONE.replace("[\"12 N\", \"-5*arm.angle\"]", "[\"3*arm.x - 2*arm.vy\", \"-5*arm.angle + 2*arm.y\"]");
    let placed =
        "name = \"placed\"\n[parts.it]\nfile = \"w.toml\"\nat = [\"0.7 m\", -0.4]\nangle = \"75 deg\"\nmirror = true\n";
    let files = [("alone.toml", &*format!("name = \"alone\"\n{alone}")), ("placed.toml", placed), ("w.toml", &alone)];
    let folder = Folder::new("placed", &files);
    let run = |file: &str, names: [&str; 3]| {
        let mut scene = sound(folder.read(file)).with_every_output();
        scene.experiment.stop = Some("0.4 s".into());
        let model = std::sync::Arc::new(cotree_fmu::model::Model::new(sound(compile(&scene)).program).expect("sound"));
        let mut instance = run::started(&model, None, 0.4, 1e-10);
        instance.step_to(0.4).expect("regular");
        names.map(|name| run::value(&mut instance, name))
    };
    let [x, y, angle] = run("alone.toml", ["arm.x", "arm.y", "arm.angle"]);
    let [px, py, placed_angle] = run("placed.toml", ["it_arm.x", "it_arm.y", "it_arm.angle"]);
    let turn = 75_f64.to_radians();
    let expected = [0.7 - x * turn.cos() - y * turn.sin(), -0.4 - x * turn.sin() + y * turn.cos(), turn - angle];
    for (found, expected) in [px, py, placed_angle].into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
}

#[test]
fn a_part_on_a_body_moves_with_it() {
    let host = r#"
name = "cart"
[bodies.cart]
mass = 1e6
inertia = 1.0
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[parts.arm]
file = "arm.toml"
on = "cart"
at = [0.5, 0.1]
[initial]
"rail.v" = 2
[outputs]
variables = ["arm.link.x", "arm.link.y"]
"#;
    let arm = r#"
[bodies.link]
mass = 0.001
inertia = 0.001
[joints.pin]
type = "revolute"
between = ["ground", "link"]
[initial]
"pin.angle" = 0.3
"#;
    let folder = Folder::new("cart", &[("cart.toml", host), ("arm.toml", arm)]);
    let scene = sound(folder.read("cart.toml"));
    let resolved = sound(scene.resolve());
    let names: Vec<&str> = resolved.outputs.iter().map(|output| output.name.as_str()).collect();
    assert_eq!(names, ["arm_link.x", "arm_link.y"]);
    let model = std::sync::Arc::new(cotree_fmu::model::Model::new(sound(compile(&scene)).program).expect("sound"));
    let mut instance = run::started(&model, None, 1.0, 1e-9);
    instance.step_to(1.0).expect("regular");
    let place = ["arm_link.x", "arm_link.y"].map(|name| run::value(&mut instance, name));
    assert!((place[0] - 2.5).abs() < 1e-9 && (place[1] - 0.1).abs() < 1e-12, "{place:?}");
}

/// What is wrong, files by name, the fault, and where.
type Wrong<'a> = (&'a str, &'a [(&'a str, &'a str)], &'a str, &'a str);

/// What two parts and the scene report alike, the energy of everything, is one output.
#[test]
fn outputs_that_parts_share_are_listed_once() {
    let part = format!("name = \"wishbone\"\n{}", WISHBONE.replace("\"pivot.fx\"]", "\"pivot.fx\", \"energy.total\"]"));
    let uses = "name = \"two\"\n[parts.left]\nfile = \"wishbone.toml\"\n[parts.right]\nfile = \"wishbone.toml\"\n";
    let scene = format!("{uses}[outputs]\nvariables = [\"left.arm.angle\"]\n");
    let folder = Folder::new("shared_outputs", &[("wishbone.toml", &part), ("two.toml", &scene)]);
    let resolved = sound(folder.read("two.toml").and_then(|scene| scene.resolve()));
    let names: Vec<&str> = resolved.outputs.iter().map(|output| output.name.as_str()).collect();
    let expected = [
        "left_arm.angle",
        "left_strut.force",
        "left_pivot.fx",
        "energy.total",
        "right_arm.angle",
        "right_strut.force",
        "right_pivot.fx",
    ];
    assert_eq!(names, expected);
}

#[test]
fn faults_show_the_file_that_they_are_in() {
    let host = "name = \"host\"\n[parts.a]\nfile = \"sub/part.toml\"\n";
    let cases: [Wrong; 9] = [
        ("syntax", &[("h.toml", host), ("sub/part.toml", "\n[bodies.x\nmass = 1\n")], "scene::syntax", "part.toml:2:"),
        (
            "key",
            &[("h.toml", host), ("sub/part.toml", "[bodies.x]\nmess = 1\n")],
            "scene::unknown_key",
            "part.toml:2:1",
        ),
        (
            "name",
            &[
                ("h.toml", host),
                (
                    "sub/part.toml",
                    "[bodies.x]\nmass = 1\n\n[joints.p]\ntype = \"revolute\"\nbetween = [\"ground\", \"y\"]\n",
                ),
            ],
            "scene::unknown_body",
            "part.toml:6:",
        ),
        ("missing", &[("h.toml", host)], "scene::unreadable", "h.toml:3:9"),
        (
            "circle",
            &[("h.toml", host), ("sub/part.toml", "[parts.b]\nfile = \"../sub/part.toml\"\n")],
            "part.toml -> part.toml",
            "part.toml:2:9",
        ),
        (
            "parameter",
            &[
                ("h.toml", "name = \"h\"\n[parts.a]\nfile = \"p.toml\"\nparameters = { lenght = 2 }\n"),
                ("p.toml", "[parameters]\nlength = 1\n"),
            ],
            "did you mean `length`",
            "h.toml:4:16",
        ),
        (
            "body",
            &[
                ("h.toml", "name = \"h\"\n[parts.a]\nfile = \"p.toml\"\non = \"cra\"\n"),
                ("p.toml", "[parameters]\nlength = 1\n"),
            ],
            "scene::unknown_body",
            "h.toml:4:7",
        ),
        (
            "taken",
            &[
                ("h.toml", "name = \"h\"\n[bodies.a]\nmass = 1\n[parts.a]\nfile = \"p.toml\"\n"),
                ("p.toml", "[parameters]\nlength = 1\n"),
            ],
            "scene::duplicate_name",
            "h.toml:4:8",
        ),
        (
            "placed",
            &[
                (
                    "h.toml",
                    "name = \"h\"\n[bodies.c]\nmass = 1\n[parts.a]\nfile = \"p.toml\"\non = \"c\"\nmirror = true\n",
                ),
                ("p.toml", "[bodies.x]\nmass = 1\n[loads.f]\ntype = \"force\"\non = \"x\"\nvector = [\"x.vx\", 0]\n"),
            ],
            "scene::placed_part",
            "p.toml:6:",
        ),
    ];
    for (name, files, what, place) in cases {
        let folder = Folder::new(name, files);
        let faults = folder.faults("h.toml");
        let text = faults.to_string();
        assert!(text.contains(what) && text.contains(place), "{name}: {text}");
        assert!(
            faults.render(false, 100).contains(place.split(':').next().unwrap()),
            "{name}: {}",
            faults.render(false, 100)
        );
        // The same place for programs; the file is named where it is not the scene's own.
        let line: u64 = place.split(':').nth(1).and_then(|line| line.parse().ok()).expect("a line");
        let listed = faults.to_json();
        let mut places = listed["faults"].as_array().expect("faults").iter().map(|fault| &fault["place"]);
        let in_part = !place.starts_with("h.toml");
        assert!(places.any(|found| found["line"] == line && found["file"].is_string() == in_part), "{name}: {listed}");
    }
}

/// A scene may name any file of the machine that reads it: nothing of what is no scene is shown.
#[test]
fn a_file_that_is_not_a_scene_is_not_quoted() {
    for secret in ["root:secret:0:0\nuser,secret\n", "KEY = \"secret\"\n", "secret", "{\"secret\": 1}"] {
        let folder =
            Folder::new("not_quoted", &[("a.toml", "name = \"a\"\n[parts.x]\nfile = \"b.txt\"\n"), ("b.txt", secret)]);
        let text = folder.faults("a.toml").render(false, 1000);
        assert!(text.contains("b.txt` is not a scene") && !text.contains("secret"), "{text}");
    }
    let part = "[bodies.b]\nmass = = 1\n";
    let folder = Folder::new("quoted", &[("a.toml", "name = \"a\"\n[parts.x]\nfile = \"b.txt\"\n"), ("b.txt", part)]);
    let text = folder.faults("a.toml").render(false, 1000);
    assert!(text.contains("mass = = 1"), "{text}");
}

#[test]
fn the_fmu_keeps_every_file() {
    let host = "name = \"host\"\n[parts.a]\nfile = \"sub/part.toml\"\n[initial]\n\"a.arm.angle\" = 0.1\n";
    let part = WISHBONE.replace("[initial]\n\"arm.angle\" = \"5 deg\"\n", "");
    let folder = Folder::new("fmu", &[("h.toml", host), ("sub/part.toml", &part)]);
    let path = folder.0.join("h.fmu");
    sound_export(&folder.0.join("h.toml"), &path);
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&path).expect("a file")).expect("an archive");
    for (name, expected) in [("resources/scene.toml", host), ("resources/sub/part.toml", &*part)] {
        let mut text = String::new();
        archive.by_name(name).expect(name).read_to_string(&mut text).expect("a text");
        assert_eq!(text, expected, "{name}");
    }
}

/// What has been read is not read again, whatever became of the files.
#[test]
fn a_scene_is_restored_from_the_files_that_were_read() {
    let host = "name = \"host\"\n[parts.a]\nfile = \"sub/part.toml\"\n[initial]\n\"a.arm.angle\" = 0.1\n";
    let part = WISHBONE.replace("[initial]\n\"arm.angle\" = \"5 deg\"\n", "");
    let folder = Folder::new("restored", &[("h.toml", host), ("sub/part.toml", &part)]);
    let scene = sound(Scene::read(folder.0.join("h.toml")));
    let files: Vec<(String, String)> =
        scene.source.files().map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
    let bytes = |scene: &Scene| compile(scene).expect("sound").program.to_bytes().expect("bytes");
    std::fs::write(folder.0.join("sub/part.toml"), part.replace("mass = 4.0", "mass = 5.0")).expect("a file");
    let again = sound(Scene::from_files(&files));
    assert_eq!(bytes(&again), bytes(&scene));
    assert!(again.source.files().eq(scene.source.files()));
    assert_ne!(bytes(&sound(Scene::read(folder.0.join("h.toml")))), bytes(&scene));
}

/// A part and tables outside of the scene's folder: the scene inside the FMU finds them there, and does the same; no path of its author's is in it.
#[test]
fn the_scene_in_an_fmu_finds_files_from_elsewhere() {
    let part = WISHBONE.replace("[initial]\n\"arm.angle\" = \"5 deg\"\n", "").replace(
        "\"torque - 2*angle - 0.3*omega + 0.1*arm.vx\"",
        "'torque + table(\"../laws/push.csv\", t) - 2*angle - 0.3*omega'",
    );
    assert!(part.contains("push.csv"));
    let host = "name = \"host\"\n[parts.a]\nfile = \"../parts/arm.toml\"\n[initial]\n\"a.arm.angle\" = 0.1\n[experiment]\nstop = 0.2\n";
    let push = "t [s], torque [N.m]\n0, 1\n1, 2\n";
    let files = [("scenes/h.toml", host), ("parts/arm.toml", &part), ("laws/push.csv", push)];
    let folder = Folder::new("elsewhere", &files);
    let (scene, fmu) = (folder.0.join("scenes/h.toml"), folder.0.join("h.fmu"));
    sound_export(&scene, &fmu);
    let unpacked = folder.0.join("unpacked");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&fmu).expect("a file")).expect("an archive");
    archive.extract(&unpacked).expect("a folder");
    std::fs::remove_dir_all(folder.0.join("parts")).expect("the author's files are away");
    std::fs::remove_dir_all(folder.0.join("laws")).expect("the author's files are away");
    let again = sound(Scene::read(unpacked.join("resources/scene.toml")));
    let mut program = Vec::new();
    archive.by_name("resources/program.bin").expect("a program").read_to_end(&mut program).expect("bytes");
    assert_eq!(compile(&again).expect("sound").program.to_bytes().expect("bytes"), program);
    let author = folder.0.display().to_string();
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).expect("a file");
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).expect("bytes");
        assert!(
            !bytes.windows(author.len()).any(|found| found == author.as_bytes()),
            "the file with the number {index}"
        );
    }
}

fn sound_export(scene: &Path, fmu: &Path) {
    let scene = sound(Scene::read(scene));
    scene.export_fmu(fmu).expect("an FMU");
}
