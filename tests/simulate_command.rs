//! What `cotree simulate` shows of a motion that is known: units, figures, plots, tables of inputs and of measured values.

use crate::outside::command;

use std::path::Path;

use command::{code, cotree, stderr, stdout};

/// A crank that turns once a second; its tip is on a circle of 0.3 m.
const CRANK: &str = r#"
name = "turning"

[inputs]
push = { start = "2 N" }

[bodies.crank]
mass = 1
inertia = 1
points = { centre = [0, 0], tip = ["300 mm", 0] }

[bodies.block]
mass = 2

[joints.bearing]
type = "revolute"
between = ["ground", "crank.centre"]

[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]

[drivers.motor]
joint = "bearing"
angle = "2*pi*t"

[loads.push]
type = "force"
on = "block"
vector = ["push", 0]

[outputs]
variables = ["crank.angle", "crank.tip.x"]

[experiment]
stop = 1
step = 0.001
"#;

fn with(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene.replace("[inputs]\npush", "[inputs]\npressure").replace("[\"push\", 0]", "[\"pressure\", 0]");
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    folder
}

fn simulate(folder: &Path, more: &[&str]) -> String {
    let output = cotree(folder, &[&["simulate", "a.toml"], more].concat());
    assert_eq!(code(&output), 0, "{more:?}: {}", stderr(&output));
    stdout(&output)
}

fn rows(table: &str) -> Vec<Vec<f64>> {
    table.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}

#[test]
fn units_are_in_the_header_and_the_values_in_them() {
    let folder = with(CRANK);
    let plain = simulate(folder.path(), &["--every", "250"]);
    assert_eq!(plain.lines().next(), Some("time,crank.angle,crank.tip.x"), "as it has always been");
    let shown = simulate(folder.path(), &["--every", "250", "--units", "deg,mm,ms"]);
    assert_eq!(shown.lines().next(), Some("time [ms],crank.angle [deg],crank.tip.x [mm]"));
    for (index, (plain, shown)) in rows(&plain).iter().zip(rows(&shown)).enumerate() {
        let quarter = index as f64;
        let wanted = [250.0 * quarter, 90.0 * quarter, 300.0 * (quarter * std::f64::consts::FRAC_PI_2).cos()];
        assert!(shown.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{shown:?} {wanted:?}");
        assert!((plain[1].to_degrees() - shown[1]).abs() < 1e-9);
    }
    assert_eq!(rows(&shown).len(), 5);
    assert!(simulate(folder.path(), &["--units", "si"]).starts_with("time [s],crank.angle [rad],crank.tip.x [m]\n"));
    let scene = with(&format!("{CRANK}[display]\nangle = \"deg\"\n"));
    assert!(simulate(scene.path(), &[]).starts_with("time [s],crank.angle [deg],crank.tip.x [m]\n"));
    let speeds = simulate(folder.path(), &["--units", "deg,mm", "--variables", "crank.omega,crank.tip.vy,bearing.fx"]);
    assert!(speeds.starts_with("time [s],crank.omega [deg/s],crank.tip.vy [mm/s],bearing.fx [N]\n"), "{speeds:.80}");
    let wrong = cotree(folder.path(), &["simulate", "a.toml", "--units", "Nm"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("write `N.m`"), "{}", stderr(&wrong));
}

#[test]
fn figures_are_those_of_the_closed_form() {
    let folder = with(CRANK);
    let text = simulate(folder.path(), &["--summary", "--json", "--units", "mm"]);
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let tip = &summary["variables"][1];
    let figure = |key: &str| tip[key].as_f64().unwrap();
    assert_eq!((tip["name"].as_str(), tip["unit"].as_str()), (Some("crank.tip.x"), Some("mm")));
    let extreme = |key: &str, value: f64, at: f64| {
        let found = [tip[key][0].as_f64().unwrap(), tip[key][1].as_f64().unwrap()];
        assert!((found[0] - value).abs() < 1e-9 && (found[1] - at).abs() < 1e-9, "{key} {found:?}");
    };
    extreme("min", -300.0, 0.5);
    extreme("max", 300.0, 0.0);
    assert!(figure("mean").abs() < 1e-9 && (figure("rms") - 300.0 / 2f64.sqrt()).abs() < 1e-2, "{tip}");
    let table = simulate(folder.path(), &["--summary", "--units", "mm"]);
    assert!(table.starts_with("variable") && table.contains("crank.tip.x  mm") && table.contains("212.13"), "{table}");
    let both = simulate(folder.path(), &["--summary", "-o", "table.csv"]);
    assert!(both.starts_with("variable") && folder.path().join("table.csv").exists());
}

#[test]
fn other_variables_can_be_asked_for() {
    let folder = with(CRANK);
    let table = simulate(folder.path(), &["--variables", "crank.tip.y,pressure,crank.angle", "--every", "100 ms"]);
    assert_eq!(table.lines().next(), Some("time,crank.tip.y,pressure,crank.angle"));
    let rows = rows(&table);
    assert_eq!((rows.len(), rows[1][2]), (11, 2.0));
    assert!((rows[1][1] - 0.3 * (0.2 * std::f64::consts::PI).sin()).abs() < 1e-9);
    let varied = ["--sensitivity", "pressure", "--variables", "guide.v", "--stop", "0.1", "--step", "0.1"];
    let table = simulate(folder.path(), &varied);
    assert_eq!(table.lines().next(), Some("time,guide.v,d(guide.v)/d(pressure)"));
    let wrong = cotree(folder.path(), &["simulate", "a.toml", "--variables", "crank.angel"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("did you mean `crank.angle`"), "{}", stderr(&wrong));
}

#[test]
fn angles_are_wrapped_on_request() {
    let folder = with(CRANK);
    let row = rows(&simulate(folder.path(), &["--wrap", "--units", "deg", "--every", "250"]));
    let angles: Vec<f64> = row.iter().map(|row| row[1]).collect();
    assert!(
        angles.iter().zip([0.0, 90.0, 180.0, -90.0]).all(|(a, b)| (a.abs() - f64::abs(b)).abs() < 1e-9),
        "{angles:?}"
    );
    assert!(angles[3] < 0.0 && angles[4].abs() < 1e-9, "{angles:?}");
}

#[test]
fn what_is_written_can_be_read_as_an_input() {
    let folder = with(CRANK);
    let path = |name: &str| folder.path().join(name);
    let value = |file: &str| {
        let table = simulate(folder.path(), &["--input", file, "--variables", "pressure,block.vx", "--every", "500"]);
        rows(&table).iter().map(|row| (row[1], row[2])).collect::<Vec<_>>()
    };
    std::fs::write(path("plain.csv"), "time,pressure\n0,0\n1,4000\n").unwrap();
    std::fs::write(path("german.csv"), "pressure [kN];time [ms]\n0;0\n4,0;1000\n").unwrap();
    std::fs::write(path("short.csv"), "t [s]\tpressure [N]\n0\t0\n1\t4000\n").unwrap();
    let plain = value("plain.csv");
    // 2 kg under 4000 N/s t: v = 1000 t^2
    assert!(
        plain
            .iter()
            .zip([0.0, 0.5, 1.0])
            .all(|((p, v), t)| (p - 4000.0 * t).abs() < 1e-9 && (v - 1000.0 * t * t).abs() < 1e-6)
    );
    assert_eq!(value("german.csv"), plain);
    assert_eq!(value("short.csv"), plain);
    for text in [
        "Time (s),pressure (kN)\n0,0\n1,4\n",
        "time_ms pressure_kN\n0 0\n1000 4,0\n",
        "# t, pressure [kN]\n0,0\n1,4\n",
        "time;pressure\nms;kN\n0;0\n1000;4,0\n;\n",
        "\"time / s\",\"pressure / N\"\n0,0\n1,4000\n",
    ] {
        std::fs::write(path("other.csv"), text).unwrap();
        assert_eq!(value("other.csv"), plain, "{text}");
    }
    std::fs::write(path("named.csv"), "Zeit (ms);Kanal 1 (kN);Kanal 2 (V)\n0;0;7,5\n1000;4;7,5\n").unwrap();
    let chosen =
        ["--column", "time=Zeit", "--column", "pressure=Kanal 1", "--every", "500", "--variables", "pressure,block.vx"];
    let table = rows(&simulate(folder.path(), &[&["--input", "named.csv"][..], &chosen].concat()));
    assert_eq!(table.iter().map(|row| (row[1], row[2])).collect::<Vec<_>>(), plain);
    simulate(
        folder.path(),
        &["--input", "plain.csv", "--variables", "pressure", "--units", "kN,ms", "-o", "again.csv"],
    );
    assert!(std::fs::read_to_string(path("again.csv")).unwrap().starts_with("time [ms],pressure [kN]\n0.0,0.0\n"));
    let again = value("again.csv");
    assert!(again.iter().zip(&plain).all(|(a, b)| (a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6), "{again:?}");
    std::fs::write(path("wrong.csv"), "time,pressure [mm]\n0,0\n").unwrap();
    let wrong = cotree(folder.path(), &["simulate", "a.toml", "--input", "wrong.csv"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("is in `mm`, but the input in `N`"), "{}", stderr(&wrong));
    for (text, said) in [
        ("time,pressure (furlong)\n0,0\n", "unknown unit `furlong`"),
        ("time,pressure\n0,0\n1,\n", "line 3, column 2: the cell is empty"),
        ("0,0\n1,4000\n", "no line of names"),
    ] {
        std::fs::write(path("wrong.csv"), text).unwrap();
        let wrong = cotree(folder.path(), &["simulate", "a.toml", "--input", "wrong.csv"]);
        assert!(code(&wrong) == 2 && stderr(&wrong).contains(said), "{text}: {}", stderr(&wrong));
    }
}

/// The last row is still on the way: what is fed by a table has the rate of the table's last rows there, not that of a table that has ended.
#[test]
fn rates_of_a_table_last_until_the_stop() {
    let folder = with(
        r#"
format = 1
name = "fed"
[inputs]
way = { unit = "m" }
[bodies.block]
mass = 1
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[drivers.feed]
joint = "guide"
displacement = { input = "way", as = "position" }
[outputs]
variables = ["block.x", "block.vx"]
"#,
    );
    std::fs::write(folder.path().join("way.csv"), "time,way\n0,0\n0.5,1\n1,4\n").unwrap();
    let fed = |stop: &str| rows(&simulate(folder.path(), &["--input", "way.csv", "--step", "0.25", "--stop", stop]));
    let speeds = |stop: &str| fed(stop).iter().map(|row| row[2]).collect::<Vec<_>>();
    assert_eq!(speeds("1"), [2.0, 2.0, 6.0, 6.0, 6.0]);
    assert_eq!(speeds("0.5"), [2.0, 2.0, 2.0]);
    assert_eq!(speeds("1.25"), [2.0, 2.0, 6.0, 6.0, 0.0, 0.0]);
    assert_eq!(fed("1").last().unwrap()[1], 4.0);
}

#[test]
fn pictures_are_svg_or_png() {
    let folder = with(CRANK);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let output = cotree(folder.path(), &["simulate", "a.toml", "--plot", "a.png", "-o", "a.csv"]);
    assert_eq!((code(&output), stdout(&output).as_str()), (0, ""));
    let said = stderr(&output);
    for part in ["wrote a.png", "wrote a.csv: 1001 rows", "cotree view a.toml"] {
        assert!(said.contains(part), "{said}");
    }
    let picture = resvg::tiny_skia::Pixmap::decode_png(&bytes("a.png")).unwrap();
    assert_eq!(picture.width(), 1600);
    let is_dark = |x: u32, y: u32| picture.pixel(x, y).is_some_and(|pixel| pixel.red() < 100 && pixel.blue() < 100);
    let letters = (0..400).flat_map(|x| (20..70).map(move |y| (x, y))).filter(|&(x, y)| is_dark(x, y)).count();
    assert!(letters > 100, "the title has letters");
    assert_eq!(code(&cotree(folder.path(), &["show", "a.toml", "--drawing", "b.png", "--graph", "c.png"])), 0);
    assert!(bytes("b.png").starts_with(b"\x89PNG") && bytes("c.png").starts_with(b"\x89PNG"));
    let wrong = cotree(folder.path(), &["simulate", "a.toml", "--plot", "a.pdf"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("`.svg` or `.png`"), "{}", stderr(&wrong));
}

#[test]
fn curves_can_be_drawn_over_another_variable() {
    let folder = with(CRANK);
    simulate(
        folder.path(),
        &["--x", "crank.tip.x", "--y", "crank.tip.y", "--units", "mm", "--plot", "curve.svg", "-o", "c.csv"],
    );
    let svg = std::fs::read_to_string(folder.path().join("curve.svg")).unwrap();
    assert!(svg.contains(">crank.tip.x [mm]</text>") && svg.contains("crank.tip.y"), "{svg:.2000}");
    let one = cotree(folder.path(), &["simulate", "a.toml", "--x", "crank.tip.x", "--plot", "curve.svg"]);
    assert_eq!(code(&one), 2);
}

#[test]
fn measured_values_are_compared() {
    let folder = with(CRANK);
    let angle = |time: f64| 360.0 * time + if time > 0.55 { 3.0 } else { 0.0 };
    let lines: Vec<String> =
        (0..=10).map(|index| format!("{},{}", 100 * index, angle(0.1 * f64::from(index)))).collect();
    std::fs::write(folder.path().join("m.csv"), format!("time [ms],crank.angle [deg]\n{}\n", lines.join("\n")))
        .unwrap();
    let said = simulate(folder.path(), &["--overlay", "m.csv", "--plot", "a.svg", "--summary", "--units", "deg"]);
    let rms = (5.0 * 9.0 / 11.0f64).sqrt();
    assert!(said.contains(&format!("11 measured values by RMS {rms:.4e} deg, at most 3.0000e0 deg")), "{said}");
    let svg = std::fs::read_to_string(folder.path().join("a.svg")).unwrap();
    assert!(svg.matches("<circle").count() == 12 && svg.contains("measured"), "eleven dots and one in the legend");
    std::fs::write(folder.path().join("m.csv"), "time,crank.angel\n0,0\n").unwrap();
    let wrong = cotree(folder.path(), &["simulate", "a.toml", "--overlay", "m.csv"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("did you mean `crank.angle`?"), "{}", stderr(&wrong));
}

/// A pendulum between spring and weight: at rest it stays.
#[test]
fn a_run_can_begin_at_rest() {
    let scene = "name = \"hanging\"\ngravity = [0, -9.81]\n[parameters]\nk = \"20 N.m/rad\"\n[bodies.bar]\nmass = 2\ninertia = 0.05\n\
                 points = { top = [-0.5, 0] }\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"bar.top\"]\n\
                 [loads.coil]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"bar\"]\nstiffness = \"k\"\n\
                 [initial]\n\"bar.angle\" = 0.3\n\"bar.omega\" = 1\n[outputs]\nvariables = [\"bar.angle\", \"bar.omega\"]\n\
                 [experiment]\nstop = 1\nstep = 0.1\n";
    let folder = with(scene);
    for (stiffness, set) in [(20.0, None), (40.0, Some("k=40"))] {
        let settings: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
        let rows = rows(&simulate(folder.path(), &[&["--from-equilibrium"], &settings[..]].concat()));
        for row in rows {
            // k angle + m g r cos(angle) = 0
            let residual = stiffness * row[1] + 2.0 * 9.81 * 0.5 * row[1].cos();
            assert!(residual.abs() < 1e-6 && row[2].abs() < 1e-6, "{row:?} {residual}");
        }
    }
}

/// Two light links that carry what is a hundred million times heavier: what rounding leaves of their accelerations is coarser than some tolerances.
#[test]
fn a_tolerance_finer_than_rounding_errors_permit_is_warned_of() {
    let mut scene = String::from("name = \"hanging\"\ngravity = [0, -9.81]\n");
    for (body, mass, inertia) in [("a", 1e-4, 1e-6), ("b", 1e-4, 1e-6), ("c", 1e-4, 1e-6), ("load", 1e4, 1e2)] {
        scene += &format!(
            "[bodies.{body}]\nmass = {mass}\ninertia = {inertia}\npoints = {{ p = [-0.2, 0], q = [0.2, 0] }}\n"
        );
    }
    for (joint, ends) in [
        ("j0", "\"ground\", \"a.p\""),
        ("j1", "\"a.q\", \"b.p\""),
        ("j2", "\"b.q\", \"c.p\""),
        ("j3", "\"c.q\", \"load.p\""),
    ] {
        scene += &format!("[joints.{joint}]\ntype = \"revolute\"\nbetween = [{ends}]\n");
    }
    scene += "[initial]\n\"a.angle\" = 0.1\n\"b.angle\" = 0.2\n\"c.angle\" = 0.1\n\"load.angle\" = 0.3\n";
    scene += "[outputs]\nvariables = [\"load.angle\"]\n[experiment]\nstop = 0.01\nstep = 0.005\n";
    let folder = with(&scene);
    let methods = ["auto", "explicit", "implicit"];
    for (method, tolerance, warned) in
        methods.into_iter().flat_map(|name| [(name, "1e-9", true), (name, "1e-4", false)])
    {
        let text = format!("{scene}[solver]\nmethod = \"{method}\"\n");
        std::fs::write(folder.path().join("a.toml"), text).unwrap();
        let output = cotree(folder.path(), &["simulate", "a.toml", "--tolerance", tolerance]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let said = stderr(&output);
        assert_eq!(said.contains("solver::accuracy"), warned, "{method} {tolerance}: {said}");
        assert_eq!(said.contains("the attainable accuracy of about"), warned, "{method} {tolerance}: {said}");
    }
    // A law with more pieces than series can have.
    let law = (0..70).map(|k| format!("sign(t - {k})")).collect::<Vec<String>>().join(" + ");
    let lawful = scene.clone() + "tolerance = 1e-9\n[loads.push]\ntype = \"torque\"\non = \"load\"\n";
    std::fs::write(folder.path().join("a.toml"), lawful + &format!("value = \"1e-3*({law})\"\n")).unwrap();
    let commands: [&[&str]; 6] = [
        &["simulate", "a.toml"],
        &["sweep", "a.toml", "--set", "load.angle=0.3,0.31"],
        &["trace", "a.toml", "load.q"],
        &["trace", "a.toml", "load.q", "-o", "a.dxf"],
        &["view", "a.toml", "--svg"],
        &["export", "a.toml"],
    ];
    for command in commands {
        let output = cotree(folder.path(), command);
        let said = stderr(&output);
        assert_eq!(code(&output), 0, "{command:?}: {said}");
        assert!(said.contains("solver::accuracy"), "{command:?}: {said}");
    }
    let measured = cotree(folder.path(), &["bench", "a.toml"]);
    assert!(stdout(&measured).contains("rounding errors leave a relative accuracy of about"), "{}", stdout(&measured));
}
