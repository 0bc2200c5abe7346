//! The pages of `cotree view` in a real browser: headless Chromium. Without one these tests only say so.

use crate::outside::command;
use crate::support::ROOT;
use crate::support::large_scenes;

mod browser;
mod colours;
mod drawing;
mod watched;

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::random::{Family, random_case};
use browser::{Browser, Seen, Source};
use command::{code, cotree, stderr};
use watched::Watched;

/// The page of a scene, made as a user makes it.
fn page(folder: &Path, scene: &Path, runtimes: &Path) -> String {
    let (scene, runtimes) = (scene.to_str().unwrap(), runtimes.to_str().unwrap());
    let output = cotree(folder, &["view", scene, "-o", "page.html", "--runtimes", runtimes]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    fs::read_to_string(folder.join("page.html")).unwrap()
}

fn model(name: &str) -> PathBuf {
    Path::new(ROOT).join("models").join(name).join("scene.toml")
}

/// What a page says after a script has looked at it; no complaint in the browser's console.
fn seen(page: &str, script: &str) -> Option<serde_json::Value> {
    let browser = Browser::find()?;
    let Seen { verdict, console } = browser.look(page, script);
    assert!(console.is_empty(), "the browser complains:\n{}", console.join("\n"));
    Some(verdict)
}

#[test]
fn a_stored_run_plays_and_the_scrubber_moves_the_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("slider_crank"), folder.path());
    assert!(page.len() < 1 << 20, "{} bytes", page.len());
    let Some(verdict) = seen(&page, include_str!("plays.js")) else { return };
    assert_eq!(verdict["moved"], true, "{verdict}");
    assert_eq!(verdict["played"], true, "{verdict}");
    assert_eq!(verdict["back"], true, "{verdict}");
    assert_eq!(verdict["sliders"], 0, "{verdict}");
    assert_eq!(verdict["restored"], true, "{verdict}");
    assert_stored(&verdict, "cotree view SCENE.toml --serve");
}

/// The page has no empty panel, and says which commands bring the solver.
fn assert_stored(verdict: &serde_json::Value, command: &str) {
    let told = verdict["told"].as_str().unwrap();
    assert!(told.contains("tools/build-runtimes.sh web") && told.contains(command), "{verdict}");
    assert_eq!(verdict["panel"], false, "{verdict}");
}

/// A page of the documentation, out of its archive.
fn documentation(folder: &Path, arguments: &[&str]) -> String {
    let output = cotree(folder, &[&["export", "-o", "model.fmu", "--platform", "linux64"], arguments].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let file = fs::File::open(folder.join("model.fmu")).unwrap();
    let mut archive = zip::ZipArchive::new(file).unwrap();
    std::io::read_to_string(archive.by_name("documentation/index.html").unwrap()).unwrap()
}

/// Documentation and lesson on a phone: what is wide scrolls in a box of its own. In the dark the page is dark.
#[test]
fn pages_to_be_read_fit_a_phone_and_are_dark_in_the_dark() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in ["slider_crank", "vibration", "toggle_press"] {
        let scene = model(name);
        let scene = scene.to_str().unwrap();
        let output = cotree(folder.path(), &["show", scene, "--steps", "html"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let lesson = String::from_utf8(output.stdout).unwrap().replacen("<html", "<html data-ready=\"yes\"", 1);
        for page in [lesson, documentation(folder.path(), &[scene])] {
            for (dark, background) in
                [(false, ["rgb(255, 255, 255)", "rgb(244, 245, 247)"]), (true, ["rgb(14, 18, 22)"; 2])]
            {
                let Seen { verdict, console } = browser.dark(dark).look(&page, include_str!("narrow.js"));
                assert!(console.is_empty(), "{console:?}");
                assert!(verdict["wide"].as_u64().unwrap() <= 390, "{name}: {verdict}");
                assert!(verdict["tables"].as_u64().unwrap() > 3 && verdict["tight"] == 0, "{name}: {verdict}");
                assert!(background.contains(&verdict["background"].as_str().unwrap()), "{name}: {verdict}");
            }
        }
    }
}

/// Rings around what is closed or sticks, a star where something has just struck, names beside them, and what the signs mean.
#[test]
fn what_is_closed_or_sticks_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let look = |name: &str, times: &str| {
        let page = page(folder.path(), &model(name), folder.path());
        seen(&page, &include_str!("holds.js").replace("TIMES", times))
    };
    let Some(stop) = look("end_stop", "[0.1, 0.36, 0.6, 2.5]") else { return };
    let shown = |verdict: &serde_json::Value, what: &str| -> Vec<u64> {
        verdict["looks"].as_array().unwrap().iter().map(|look| look[what].as_u64().unwrap()).collect()
    };
    assert_eq!(shown(&stop, "rings"), [0, 0, 0, 1], "{stop}");
    assert_eq!(shown(&stop, "stars"), [0, 1, 0, 0], "{stop}");
    assert_eq!(stop["looks"][3]["names"], serde_json::json!(["guide.max"]), "{stop}");
    assert_eq!(stop["legend"], "closedstrikes", "{stop}");
    let Some(slip) = look("stick_slip", "[0.4, 0.9, 1.5]") else { return };
    assert_eq!(shown(&slip, "rings"), [1, 0, 1], "{slip}");
    assert_eq!(slip["legend"], "sticks", "{slip}");
    let Some(other) = look("four_bar", "[0.1]") else { return };
    assert_eq!(other["legend"], "", "{other}");
}

#[test]
fn every_model_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(Path::new(ROOT).join("models")).unwrap() {
        let scene = entry.unwrap().path().join("scene.toml");
        let page = page(folder.path(), &scene, folder.path());
        let Some(verdict) = seen(&page, include_str!("shows.js")) else { return };
        assert_eq!(verdict["odd"], serde_json::json!([]), "{}: {verdict}", scene.display());
        assert_eq!(verdict["bodies"], true, "{}: {verdict}", scene.display());
        assert_eq!(verdict["outside"], serde_json::json!([]), "something is cut off, {}: {verdict}", scene.display());
        assert_eq!(verdict["covered"], serde_json::json!([]), "names cover each other, {}: {verdict}", scene.display());
    }
}

/// Mechanisms that nobody has drawn before: the browser has nothing to complain of, nothing is drawn at no place, no name covers another.
#[test]
fn random_mechanisms_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..2 {
        for family in [Family::Chain, Family::Tree, Family::Loops, Family::Driven, Family::Redundant] {
            let scene = folder.path().join("scene.toml");
            fs::write(&scene, random_case(seed, family).scene).unwrap();
            let page = page(folder.path(), &scene, folder.path());
            let Some(verdict) = seen(&page, include_str!("shows.js")) else { return };
            assert_eq!(verdict["odd"], serde_json::json!([]), "{family:?} {seed}: {verdict}");
            assert_eq!(verdict["bodies"], true, "{family:?} {seed}: {verdict}");
            assert_eq!(
                verdict["covered"],
                serde_json::json!([]),
                "names cover each other, {family:?} {seed}: {verdict}"
            );
        }
    }
}

/// Of straight bars in any direction, with points between their ends, not a piece is missing.
#[test]
fn straight_bars_are_drawn_from_end_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "name = 'bars'\n".to_string();
    for bar in 0..24 {
        let (sine, cosine) = (15.0 * f64::from(bar)).to_radians().sin_cos();
        let at = |s: f64| format!("[{:?}, {:?}]", (s - 0.4) * cosine, (s - 0.4) * sine);
        let points = [("low", 0.0), ("one", 0.61), ("high", 1.0), ("two", 0.07 * f64::from(bar % 13))];
        let points = points.map(|(name, s)| format!("{name} = {}", at(s))).join(", ");
        text += &format!("[bodies.bar{bar}]\nmass = 1.0\ninertia = 0.1\npoints = {{ {points} }}\n");
        text += &format!("[joints.pin{bar}]\ntype = 'revolute'\nbetween = ['ground', 'bar{bar}.two']\n");
    }
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, text).unwrap();
    let page = page(folder.path(), &scene, folder.path());
    let Some(verdict) = seen(&page, include_str!("bars.js")) else { return };
    assert_eq!(verdict["short"], serde_json::json!([]), "{verdict}");
    assert_eq!(verdict["looked"], 24, "{verdict}");
}

#[test]
fn hostile_text_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(model("pendulum")).unwrap();
    let hostile = r#"</script><script>top.hacked = 1</script><img src=x onerror='top.hacked = 2'>{{script}}<!-- \" ' & \u0007 \u2028"#;
    let text: Vec<String> = text
        .lines()
        .map(|line| match line.split_once('=') {
            Some(("description ", _)) => format!("description = \"{hostile}\""),
            _ => line.to_owned(),
        })
        .collect();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, text.join("\n")).unwrap();
    let page = page(folder.path(), &scene, folder.path());
    let Some(verdict) = seen(&page, include_str!("hostile.js")) else { return };
    assert_eq!(verdict["ready"], "yes", "{verdict}");
    assert_eq!(verdict["hacked"], false, "{verdict}");
    assert!(verdict["text"].as_str().unwrap().contains("onerror="), "{verdict}");
}

/// The runtime for browsers, if somebody has built it: see tools/build-runtimes.sh.
fn runtimes() -> Option<PathBuf> {
    let folder = Path::new(ROOT).join("target/runtimes");
    let found = folder.join("web/cotree_runtime.wasm").exists();
    if !found {
        eprintln!("skipped: there is no runtime for browsers (tools/build-runtimes.sh web)");
    }
    found.then_some(folder)
}

#[test]
fn the_page_computes_the_bits_of_the_command_line() {
    let Some(runtimes) = runtimes() else { return };
    for name in ["four_bar", "slider_crank", "gas_strut"] {
        let folder = tempfile::tempdir().unwrap();
        let page = page(folder.path(), &model(name), &runtimes);
        let output = cotree(folder.path(), &["simulate", model(name).to_str().unwrap(), "-o", "run.csv"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let Some(verdict) = seen(&page, include_str!("values.js")) else { return };
        let table = fs::read_to_string(folder.path().join("run.csv")).unwrap();
        let mut lines = table.lines();
        let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
        let mut compared = 0;
        for (column, head) in heads.iter().enumerate() {
            let of_page = verdict["columns"][head].as_array().unwrap_or_else(|| panic!("{name}: no {head}"));
            assert_eq!(of_page.len(), rows.len(), "{name}: {head}");
            for (row, bits) in rows.iter().zip(of_page) {
                let bits = u64::from_str_radix(bits.as_str().unwrap(), 16).unwrap();
                assert_eq!(bits, row[column].to_bits(), "{name}: {head} at {} s", row[0]);
                compared += 1;
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}

#[test]
fn a_slider_changes_the_run_and_reset_gives_the_first_one_back() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("four_bar"), &runtimes);
    let Some(verdict) = seen(&page, include_str!("slides.js")) else { return };
    assert_eq!(verdict["changed"], true, "{verdict}");
    assert_eq!(verdict["reset"], true, "{verdict}");
    assert_eq!(verdict["ground"], true, "{verdict}");
    assert_eq!(verdict["plotted"], true, "{verdict}");
    assert_eq!(verdict["same"], true, "a second run has other bits than the first: {verdict}");
    let told = verdict["told"].as_str().unwrap();
    assert!(told.contains("cannot be assembled"), "{verdict}");
    assert_eq!(verdict["kept"], true, "{verdict}");
}

#[test]
fn values_are_typed_and_spoken_in_the_units_that_are_shown() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(model("cart_pole")).unwrap();
    let length = "pole_length = { value = 1000, unit = \"mm\", min = \"1 mm\" }";
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, text.replace("pole_length = \"1 m\"", length) + "[display]\nunits = [\"kN\"]\n").unwrap();
    let page = page(folder.path(), &scene, &runtimes);
    let Some(verdict) = seen(&page, include_str!("types.js")) else { return };
    assert_eq!((&verdict["spoken"], &verdict["unit"]), (&"1000 mm".into(), &"mm".into()), "{verdict}");
    assert_eq!((&verdict["beyond"], &verdict["answered"]), (&"2500 mm".into(), &true.into()), "{verdict}");
    assert_eq!((&verdict["comma"], &verdict["kept"]), (&1.5.into(), &true.into()), "{verdict}");
    let faults = verdict["faults"].as_array().unwrap();
    for (fault, words) in faults.iter().zip(["at least 1 mm", "\"long\" is not a number", "is not a number"]) {
        assert!(fault.as_str().unwrap().contains(words), "{verdict}");
    }
    assert_eq!(verdict["quiet"], true, "{verdict}");
    assert_eq!((&verdict["push"], &verdict["force"]), (&"push, on cart".into(), &"kN".into()), "{verdict}");
}

#[test]
fn a_force_that_follows_an_input_is_dragged_by_its_tip() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, grips) in [("cart_pole", 1), ("slider_crank", 1), ("four_bar", 0)] {
        let page = page(folder.path(), &model(name), &runtimes);
        let Some(verdict) = seen(&page, include_str!("drags.js")) else { return };
        assert_eq!(verdict["grips"], grips, "{name}: {verdict}");
        for what in ["follows", "shown", "moved", "runs", "later"] {
            assert!(grips == 0 || verdict[what] == true, "{name}: {what}: {verdict}");
        }
    }
}

/// The first and the last values of the outputs, of a scene as the command runs it.
fn ends_of(folder: &Path, text: &str) -> Vec<(String, [f64; 2])> {
    fs::write(folder.join("scene.toml"), text).unwrap();
    let output = cotree(folder, &["simulate", "scene.toml", "-o", "run.csv"]);
    assert_eq!(code(&output), 0, "{}\n{text}", stderr(&output));
    let table = fs::read_to_string(folder.join("run.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let [heads, first, .., last] = &rows[..] else { panic!("{table}") };
    let value = |row: &[&str], column: usize| row[column].parse().unwrap();
    heads.iter().enumerate().skip(1).map(|(k, head)| (head.to_string(), [value(first, k), value(last, k)])).collect()
}

/// The page and the command have the same motion, to the accuracy of the run: a number that is a parameter is calculated with in another order.
fn assert_same_motion(folder: &Path, text: &str, of_page: &serde_json::Value) {
    for (name, values) in ends_of(folder, text) {
        for (k, value) in values.into_iter().enumerate() {
            let own = of_page[&name][k].as_f64().unwrap_or_else(|| panic!("no {name}"));
            assert!(
                (own - value).abs() <= 1e-4 * (1e-2 + value.abs()),
                "{name}, {k}: {own} in the page, {value}\n{text}"
            );
        }
    }
}

/// Lines of a text that are not those of another with as many.
fn other_lines<'t>(text: &'t str, original: &str) -> Vec<&'t str> {
    assert_eq!(text.lines().count(), original.lines().count(), "{text}");
    text.lines().zip(original.lines()).filter(|(own, known)| own != known).map(|(own, _)| own).collect()
}

/// A pull at a body along a path: from the place of its mass centre on.
fn pulled(folder: &Path, name: &str, parts: [&str; 2], path: &str) -> Option<serde_json::Value> {
    pulled_in(folder, &model(name), parts, path)
}

fn pulled_in(folder: &Path, scene: &Path, [body, other]: [&str; 2], path: &str) -> Option<serde_json::Value> {
    let page = page(folder, scene, &runtimes()?);
    let name = scene.display();
    let script = include_str!("pulls.js").replace("PATH(from)", &format!("({path})(from)"));
    let script = script.replace("BODY", &format!("{body:?}")).replace("OTHER", &format!("{other:?}"));
    let verdict = seen(&page, &script)?;
    let number = |key: &str| verdict[key].as_f64().unwrap_or(f64::INFINITY);
    eprintln!("{name}, {body}: {} pulls in {} pictures", verdict["steps"], verdict["pictures"]);
    assert!(number("open") < 1e-9, "loops open, {name}: {verdict}");
    assert!(number("leap") < 0.6, "a jump, {name}: {verdict}");
    assert!(number("apart") < 1e-6, "the run starts elsewhere, {name}: {verdict}");
    for what in ["renewed", "undone", "again"] {
        assert_eq!(verdict[what], true, "{what}, {name}: {verdict}");
    }
    assert_same_motion(folder, verdict["text"].as_str().unwrap(), &verdict["outputs"]);
    Some(verdict)
}

#[test]
fn a_body_is_pulled_and_the_run_starts_where_it_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let original = |name: &str| fs::read_to_string(model(name)).unwrap();
    // Around with the crank: it turns as far as the pointer goes, and the one number that says so is another.
    let around = "([x, y]) => Array.from({ length: 39 }, (_, k) => { const s = Math.sin(.15 * (k + 1)), c = Math.cos(.15 * (k + 1)); return [c * x - s * y, s * x + c * y]; })";
    let Some(verdict) = pulled(folder.path(), "four_bar", ["crank", ""], around) else { return };
    let turned = verdict["there"][2].as_f64().unwrap() - (60.0_f64.to_radians() + 39.0 * 0.15);
    assert!(turned.abs() < 1e-6, "{verdict}");
    let text = verdict["text"].as_str().unwrap();
    let lines = other_lines(text, &original("four_bar"));
    assert!(
        matches!(lines[..], [line] if line.starts_with("\"crank.angle\"   = \"") && line.ends_with(" deg\"")),
        "{lines:?}"
    );
    // A driver follows: what the pose adds to its law is written behind it.
    let ring = "([x, y]) => Array.from({ length: 30 }, (_, k) => [x + .006 * Math.sin(.2 * k), y + .006 * (1 - Math.cos(.2 * k))])";
    let verdict = pulled(folder.path(), "jansen", ["foot", ""], ring).unwrap();
    let lines = other_lines(verdict["text"].as_str().unwrap(), &original("jansen"));
    assert!(lines.iter().any(|line| line.starts_with("angle = \"2*pi*t ")), "{lines:?}");
}

#[test]
fn a_pulled_body_stops_at_a_dead_point_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let left = "([x, y]) => Array.from({ length: 30 }, (_, k) => [x - .02 * (k + 1), y])";
    let Some(verdict) = pulled(folder.path(), "four_bar", ["rocker", ""], left) else { return };
    // Crank and coupler folded: 0.5 m - 0.2 m from pivot to pin, and the base of 0.5 m with the rocker of 0.4 m.
    let limit = std::f64::consts::PI - 0.8_f64.acos();
    assert!((verdict["there"][2].as_f64().unwrap() - limit).abs() < 1e-3, "{limit}: {verdict}");
    assert!(verdict["told"].as_str().unwrap().starts_with("Dead point: rocker cannot move farther"), "{verdict}");
}

/// Equal bars in one line: the parallelogram could go on as one, or fold the other way. From 60 degrees down it stops there, and either way back it is the one that it was.
#[test]
fn a_pulled_body_stops_where_branches_meet() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("flat.toml");
    fs::write(&scene, FLAT).unwrap();
    let down = "() => Array.from({ length: 45 }, (_, k) => [.1 * Math.cos(Math.PI / 3 - .05 * k), .1 * Math.sin(Math.PI / 3 - .05 * k)])";
    let Some(verdict) = pulled_in(folder.path(), &scene, ["left", "right"], down) else { return };
    assert!(
        verdict["told"].as_str().unwrap().starts_with("Singular configuration: branches of the motion meet here"),
        "{verdict}"
    );
    let angle = verdict["there"][2].as_f64().unwrap();
    assert!((0.0..0.01).contains(&angle), "{verdict}");
    // The right bar is parallel: it has turned as far.
    assert!((verdict["still"].as_f64().unwrap() - (60.0_f64.to_radians() - angle)).abs() < 1e-6, "{verdict}");
}

const FLAT: &str = r#"
format = 1
name = "flat"
[ground.points]
left = [0, 0]
right = ['0.4 m', 0]
[bodies.left]
mass = 1.0
inertia = 0.01
points = { foot = [-0.1, 0], head = [0.1, 0] }
[bodies.beam]
mass = 1.0
inertia = 0.02
points = { left = [-0.2, 0], right = [0.2, 0] }
[bodies.right]
mass = 1.0
inertia = 0.01
points = { foot = [-0.1, 0], head = [0.1, 0] }
[joints]
a = { type = "revolute", between = ["ground.left", "left.foot"] }
b = { type = "revolute", between = ["left.head", "beam.left"] }
c = { type = "revolute", between = ["beam.right", "right.head"] }
d = { type = "revolute", between = ["ground.right", "right.foot"] }
[initial]
"left.angle" = '60 deg'
"right.angle" = { guess = "60 deg" }
[outputs]
variables = ["left.angle", "right.angle"]
[experiment]
stop = "0.2 s"
"#;

#[test]
fn of_several_freedoms_those_that_are_not_needed_stay() {
    let folder = tempfile::tempdir().unwrap();
    let swing = "([x, y]) => Array.from({ length: 20 }, (_, k) => [x + .02 * (k + 1), y])";
    let Some(verdict) = pulled(folder.path(), "double_pendulum", ["upper", "lower"], swing) else { return };
    assert_eq!(verdict["still"].as_f64(), Some(0.0), "{verdict}");
    // Two drivers take the stick where the pointer is.
    let down = "([x, y]) => Array.from({ length: 20 }, (_, k) => [x - .01 * (k + 1), y - .02 * (k + 1)])";
    let verdict = pulled(folder.path(), "excavator", ["stick", ""], down).unwrap();
    let start = verdict["there"].as_array().unwrap();
    assert!(start.iter().all(|value| value.as_f64().unwrap().is_finite()), "{verdict}");
    assert_eq!(verdict["told"], "", "{verdict}");
}

#[test]
fn points_and_numbers_are_changed_undone_and_written_into_the_text() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("four_bar"), &runtimes);
    let Some(verdict) = seen(&page, include_str!("changes.js")) else { return };
    let said = verdict["said"].as_object().unwrap();
    let failed: Vec<_> = said.iter().filter(|(_, done)| **done != true).collect();
    assert!(failed.is_empty() && said.len() > 15, "{failed:?} {verdict}");
    let original = fs::read_to_string(model("four_bar")).unwrap();
    let lines = other_lines(verdict["text"].as_str().unwrap(), &original);
    assert!(
        matches!(lines[..], [base, pivot] if base.starts_with("base_length    = \"0.5") && pivot.starts_with("rocker_pivot = [\"base_length\", 0.0")),
        "{lines:?}"
    );
    let written = verdict["written"].as_str().unwrap();
    assert_eq!(other_lines(written, &original), ["rocker_pivot = [\"base_length\", -0.012]", "mass    = 0.9"]);
    assert_same_motion(folder.path(), written, &verdict["columns"]);
    assert_eq!(verdict["address"], "set=[[[\"ground.rocker_pivot.y\",-0.012],[\"rocker.mass\",0.9]]]");
}

/// In each frame that the browser offers, the picture of the pointer's last place is drawn, with the motion of what is changed. How often it offers frames is printed, compared with when nothing is done: that
/// depends on what else the machine does.
#[test]
fn what_is_pulled_and_changed_is_drawn_in_every_frame() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, body, point) in [
        ("four_bar", "crank", "ground.rocker_pivot"),
        ("jansen", "foot", "ground.hip"),
        ("excavator", "boom", "ground.boom_foot"),
    ] {
        let page = page(folder.path(), &model(name), &runtimes);
        let script = include_str!("frames.js").replace("BODY", &format!("{body:?}"));
        let Some(verdict) = seen(&page, &script.replace("POINT", &format!("{point:?}"))) else { return };
        assert_eq!(verdict["idle"], 0, "{name} moves by itself: {verdict}");
        for way in ["pull", "change"] {
            let of = |key: &str| {
                let rounds = verdict[way].as_array().unwrap_or_else(|| panic!("{name}: {verdict}")).iter();
                rounds.map(|round| round[key].as_f64().unwrap()).fold(0.0, f64::max)
            };
            eprintln!("{name}, {way}: drawn in {:.2} of the frames, at {:.2} of their rate", of("drawn"), of("rate"));
            assert!(of("drawn") >= 0.9 && of("solved") >= 0.9, "{name}, {way}: {verdict}");
            // As many poses as a picture leaves time for, no fewer than curves need, and never more than the run has when it is let go.
            let whole = verdict["whole"].as_f64().unwrap();
            assert!(way == "pull" || (72.0..=whole).contains(&of("poses")), "{name}: {verdict}");
            assert_eq!(verdict["released"], true, "{name}: {verdict}");
        }
    }
}

#[test]
fn a_long_run_is_solved_beside_the_page_with_the_same_bits() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("four_bar"), &runtimes);
    let Some(verdict) = seen(&page, include_str!("besides.js")) else { return };
    assert_eq!(verdict, serde_json::json!({ "worker": true, "other": true, "same": true }));
}

#[test]
fn every_key_does_what_it_says_and_a_narrow_page_does_not_scroll_sideways() {
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("four_bar"), folder.path());
    let Some(verdict) = seen(&page, include_str!("keys.js")) else { return };
    let failed: Vec<_> = verdict.as_object().unwrap().iter().filter(|(_, done)| **done != true).collect();
    assert!(failed.is_empty() && verdict.as_object().unwrap().len() > 15, "{failed:?} {verdict}");
}

/// A hundred bodies: what moves is painted on a canvas, and the document stays as it is.
#[test]
fn a_crowd_is_painted_without_touching_the_document() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, large_scenes::two_chains(50) + "[experiment]\nstop = \"0.2 s\"\n").unwrap();
    let page = page(folder.path(), &scene, folder.path());
    let Some(verdict) = seen(&page, include_str!("crowds.js")) else { return };
    let failed: Vec<_> = verdict.as_object().unwrap().iter().filter(|(_, done)| **done != true).collect();
    assert!(failed.is_empty() && verdict.as_object().unwrap().len() == 11, "{failed:?} {verdict}");
}

/// A free length is dragged along its spring, by half of what it grows; a mass centre, where it is.
#[test]
fn a_free_length_and_a_mass_centre_have_handles() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &model("gas_strut"), &runtimes);
    let script = "cotree.pause(); cotree.PATIENCE.ms = Infinity; cotree.seek(0);
        const { state, MODEL, touching, knobs } = cotree, S = MODEL.geometry.scale, next = () => new Promise(done => page.requestAnimationFrame(() => page.requestAnimationFrame(() => page.requestAnimationFrame(done))));
        page.document.querySelector('[data-mode-of=change]').click();
        const middle = button => { const { x, y, width, height } = button.getBoundingClientRect(); return [x + width / 2, y + height / 2]; };
        const drag = async (name, by) => {
          const { button } = touching.handles.find(handle => handle.name === name), from = middle(button);
          button.setPointerCapture = () => {};
          const send = (kind, part) => button.dispatchEvent(new page.PointerEvent(kind, { pointerId: 5, clientX: from[0] + part * by[0], clientY: from[1] + part * by[1], bubbles: true }));
          send('pointerdown', 0);
          for (const part of [.3, .6, 1]) { send('pointermove', part); await next(); }
          for (let k = 0; k < 4; k++) await next();
          send('pointerup', 1); await next();
          return middle(button).map((value, axis) => value - from[axis]);
        };
        const value = title => knobs.find(knob => knob.title === title).value, ctm = $('scene').getScreenCTM().a;
        const metre = S * ctm, length = value('strut.length'), [a, b] = ['ground.foot', 'hatch.lug'].map(name => middle(touching.handles.find(handle => handle.name === name).button)), size = Math.hypot(b[0] - a[0], b[1] - a[1]);
        await drag('strut.length', [20 * (b[0] - a[0]) / size, 20 * (b[1] - a[1]) / size]);
        const grown = (value('strut.length') - length) * metre, x = value('hatch.com.x'), y = value('hatch.com.y');
        const moved = await drag('hatch.com', [12, -9]), com = Math.hypot(value('hatch.com.x') - x, value('hatch.com.y') - y) * metre;
        return { grown, moved, com, text: cotree.sceneText(), columns: Object.fromEntries(MODEL.outputs.map(name => [name, [state.run.columns.get(name)[0], state.run.columns.get(name).at(-1)]])) };";
    let Some(verdict) = seen(&page, script) else { return };
    assert!((verdict["grown"].as_f64().unwrap() - 40.0).abs() < 0.1, "{verdict}");
    assert!((verdict["com"].as_f64().unwrap() - 15.0).abs() < 0.6, "{verdict}");
    assert!((verdict["moved"][0].as_f64().unwrap() - 12.0).abs() < 1.0, "{verdict}");
    assert_same_motion(folder.path(), verdict["text"].as_str().unwrap(), &verdict["columns"]);
}

/// Values stand in the text as they did: in the unit that a table gives to bare numbers, in their quotes, with their own unit. An address brings them back.
#[test]
fn changed_values_are_written_as_they_were() {
    let Some(runtimes) = runtimes() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(model("cart_pole")).unwrap();
    let text = text.replace("pole_length = \"1 m\"", "pole_length = { value = 1000, unit = \"mm\" } # bare");
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, &text).unwrap();
    let page = page(folder.path(), &scene, &runtimes);
    let script = "cotree.pause(); cotree.PATIENCE.ms = Infinity;
        const set = { pole_length: 1.5 }, next = () => new Promise(done => page.requestAnimationFrame(() => page.requestAnimationFrame(done)));
        cotree.adoptAddress(JSON.stringify([Object.entries(set)]));
        await next();
        const changed = cotree.sceneText(), address = new URLSearchParams(cotree.shareAddress().split('#')[1]).get('set');
        const columns = Object.fromEntries(cotree.MODEL.outputs.map(name => [name, [cotree.state.run.columns.get(name)[0], cotree.state.run.columns.get(name).at(-1)]]));
        cotree.resetSliders(); await next();
        const same = cotree.sceneText() === cotree.MODEL.touch.text;
        cotree.adoptAddress(address); await next();
        const again = cotree.sceneText() === changed;
        cotree.adoptAddress('[[[\"nothing\", 1]]]'); await next();
        return { changed, columns, same, again, lost: $('notice').textContent };";
    let Some(verdict) = seen(&page, script) else { return };
    assert_eq!((&verdict["same"], &verdict["again"]), (&true.into(), &true.into()), "{verdict}");
    assert!(verdict["lost"].as_str().unwrap().contains("nothing"), "{verdict}");
    let changed = verdict["changed"].as_str().unwrap();
    assert!(changed.contains("pole_length = { value = 1500, unit = \"mm\" } # bare"), "{changed}");
    assert_same_motion(folder.path(), changed, &verdict["columns"]);
}

/// The page in an FMU moves, with the solver inside and without.
#[test]
fn the_documentation_of_an_fmu_moves() {
    let folder = tempfile::tempdir().unwrap();
    let mut kinds = vec![(folder.path().to_path_buf(), 0)];
    kinds.extend(runtimes().map(|runtimes| (runtimes, 1)));
    for (runtimes, sliders) in kinds {
        let scene = model("slider_crank");
        let page = documentation(folder.path(), &[scene.to_str().unwrap(), "--runtimes", runtimes.to_str().unwrap()]);
        assert!(page.contains("id=\"loose\"></script>"), "what can be touched makes the page of an FMU larger");
        let Some(verdict) = seen(&page, include_str!("plays.js")) else { return };
        assert_eq!((&verdict["moved"], &verdict["played"]), (&true.into(), &true.into()), "{verdict}");
        assert_eq!(verdict["sliders"].as_u64().unwrap() > 0, sliders > 0, "{verdict}");
        match sliders {
            0 => assert_stored(&verdict, "cotree view SCENE.toml --serve"),
            _ => assert_eq!((&verdict["told"], &verdict["panel"]), (&"".into(), &true.into()), "{verdict}"),
        }
    }
}

/// An editor saves: a new page comes, or what is wrong with the file and where.
#[test]
fn a_watched_scene_is_served_to_this_machine_only_and_news_come_by_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let good = fs::read_to_string(model("pendulum")).unwrap();
    fs::write(&scene, &good).unwrap();
    let watched = Watched::start(&scene);
    let mut events = watched.events();
    let first = events.next();
    assert_eq!((&first["good"], &first["fault"]), (&1.into(), &serde_json::Value::Null));
    let page = watched.get("/", &watched.host);
    assert!(page.contains("IFToMM") && page.contains("connect-src 'self'"), "{page:.400}");
    assert!(watched.get("/", "rebound.example").starts_with("HTTP/1.1 403"));

    fs::write(&scene, good.replace("gravity", "gravty")).unwrap();
    let faulty = events.next();
    let fault = faulty["fault"].as_str().unwrap();
    assert!(fault.contains("gravty") && fault.contains("scene.toml:5"), "{fault}");
    assert_eq!(faulty["good"], 1);
    assert!(watched.get("/", &watched.host).contains("IFToMM"), "the last good page stays");

    fs::write(&scene, good.replace("IFToMM", "mended")).unwrap();
    let mended = events.next();
    assert_eq!((&mended["good"], &mended["fault"]), (&3.into(), &serde_json::Value::Null));
    assert!(watched.get("/", &watched.host).contains("mended"));
}

/// A bar that turns to and fro, and jerks for a moment: the arrow of its bearing would be many times as long as usual.
const JERK: &str = r#"
name = "jerk"
gravity = [0, -9.81]
[parameters]
length = "500 mm"
still = 1
[bodies.bar]
mass = "2 kg"
inertia = 0.05
points = { foot = ["-length/2", 0] }
[joints.bearing]
type = "revolute"
between = ["ground", "bar.foot"]
[drivers.hand]
joint = "bearing"
angle = "still*(0.3*sin(t*1[rad/s]) + 0.05*exp(-((t - 2[s])/0.015[s])^2))"
[outputs]
variables = ["bar.angle", "bearing.fx"]
[display]
units = ["lbf", "mm", "ms"]
[experiment]
stop = "10 s"
step = "10 ms"
"#;

#[test]
fn arrows_stay_in_the_picture_with_free_heads_and_values_in_the_units_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("jerk.toml");
    fs::write(&scene, JERK).unwrap();
    let page = page(folder.path(), &scene, folder.path());
    let Some(verdict) = seen(&page, include_str!("arrows.js")) else { return };
    assert_eq!((&verdict["left"], &verdict["covered"]), (&0.into(), &0.into()), "{verdict}");
    assert!(verdict["shown"].as_u64().unwrap() > 500, "{verdict}");
    for text in [&verdict["scale"], &verdict["values"][0]] {
        assert!(text.as_str().unwrap().contains("lbf"), "{verdict}");
    }
    // 3 N are 0.674427 lbf; a bar with a number for its name keeps it.
    assert_eq!(verdict["told"], "at t = 500 ms it is 0.674427 lbf above 2000 mm, rod 2 stays");
    let found = verdict["found"].as_str().unwrap();
    assert_eq!(found, "[parameters]\nlength = \"750 mm\"\n# --set length=\"750 mm\"\n", "{verdict}");
}

#[test]
fn warnings_of_a_watched_scene_come_with_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let good = fs::read_to_string(model("pendulum")).unwrap();
    fs::write(&scene, format!("{good}\n[inputs]\npush = \"0 N\"\n")).unwrap();
    let watched = Watched::start(&scene);
    let mut events = watched.events();
    let first = events.next();
    assert_eq!(first["fault"], serde_json::Value::Null);
    assert!(first["warnings"].as_str().unwrap().contains("nothing uses input `push`"), "{first}");
    fs::write(&scene, &good).unwrap();
    assert_eq!(events.next()["warnings"], serde_json::Value::Null);
}

/// Whatever is in the file, and whatever becomes of it, the server goes on and says what is wrong.
#[test]
fn a_watched_file_may_hold_anything_and_go_away() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let good = fs::read_to_string(model("pendulum")).unwrap();
    fs::write(&scene, &good).unwrap();
    let watched = Watched::start(&scene);
    let mut events = watched.events();
    assert_eq!(events.next()["fault"], serde_json::Value::Null);
    let long = "# a comment that never ends\n".repeat(400_000);
    for (content, word) in [(vec![0, 159, 146, 150, 255], ""), (Vec::new(), "name"), (long.into_bytes(), "")] {
        fs::write(&scene, &content).unwrap();
        let event = events.next();
        let fault = event["fault"].as_str().unwrap_or_else(|| panic!("no fault with {} bytes: {event}", content.len()));
        assert!(!fault.is_empty() && fault.contains(word), "{fault}");
    }
    fs::remove_file(&scene).unwrap();
    assert!(events.next()["fault"].as_str().unwrap().contains("scene.toml"));
    fs::write(&scene, &good).unwrap();
    assert_eq!(events.next()["fault"], serde_json::Value::Null, "it came back");
    // As many editors save: another file takes the place.
    fs::write(folder.path().join("new.toml"), good.replace("IFToMM", "renamed")).unwrap();
    fs::rename(folder.path().join("new.toml"), &scene).unwrap();
    events.next();
    assert!(watched.get("/", &watched.host).contains("renamed"));
    #[cfg(unix)]
    {
        let other = folder.path().join("other.toml");
        fs::write(&other, good.replace("IFToMM", "linked")).unwrap();
        std::os::unix::fs::symlink(&other, folder.path().join("link")).unwrap();
        fs::rename(folder.path().join("link"), &scene).unwrap();
        events.next();
        assert!(watched.get("/", &watched.host).contains("linked"));
    }
}

/// Parts and tables lie in files of their own: they are watched as the scene is.
#[test]
fn files_of_parts_and_tables_are_watched_and_a_file_that_is_saved_as_it_was_is_no_news() {
    for (name, further) in [("double_wishbone", "corner.toml"), ("cam_follower", "lift.csv")] {
        let folder = tempfile::tempdir().unwrap();
        for entry in fs::read_dir(model(name).parent().unwrap()).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
        }
        let file = folder.path().join(further);
        let good = fs::read(&file).unwrap();
        let watched = Watched::start(&folder.path().join("scene.toml"));
        let mut events = watched.events();
        let mut until = |is_wanted: &dyn Fn(&serde_json::Value) -> bool| {
            std::iter::repeat_with(|| events.next()).find(|event| is_wanted(event)).unwrap()
        };
        let is_good = |event: &serde_json::Value| event["fault"].is_null();
        until(&is_good);
        fs::write(&file, "?").unwrap();
        let fault = until(&|event| !is_good(event));
        assert!(fault["fault"].as_str().unwrap().contains(further), "{name}: {fault}");
        fs::write(folder.path().join("saved"), &good).unwrap();
        fs::rename(folder.path().join("saved"), &file).unwrap();
        let mended = until(&is_good)["good"].as_u64().unwrap();
        fs::write(&file, &good).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(300));
        fs::remove_file(&file).unwrap();
        let gone = until(&|event| !is_good(event));
        assert_eq!(gone["good"], mended, "{name}: nothing had changed");
        fs::write(&file, &good).unwrap();
        until(&is_good);
    }
}

/// An editor saves a fault, and mends it: the page says what is wrong, and moves on with its time and its view.
#[test]
fn faults_appear_and_disappear_in_a_watched_page() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let good = fs::read_to_string(model("pendulum")).unwrap();
    fs::write(&scene, &good).unwrap();
    let watched = Watched::start(&scene);
    assert_eq!(watched.events().next()["good"], 1);
    let texts = [good.replace("IFToMM", "mended"), good.replace("gravity", "gravty")];
    let edit = |number: usize| fs::write(&scene, &texts[number]).unwrap();
    let Seen { verdict, .. } =
        browser.look_at(&Source { page: "", server: &watched.page, edit: &edit }, include_str!("watches.js"));
    let said = verdict["said"].as_str().unwrap_or_else(|| panic!("{verdict}"));
    assert!(said.contains("gravty") && said.contains("scene.toml:5") && said.contains("did you mean"), "{verdict}");
    assert_eq!(
        (&verdict["stays"], &verdict["mended"], &verdict["quiet"]),
        (&true.into(), &true.into(), &true.into()),
        "{verdict}"
    );
    assert_eq!((&verdict["time"], &verdict["view"]), (&true.into(), &true.into()), "{verdict}");
}

/// What is changed in a page goes into the file, what an editor saves into the page; where both change it, nothing is lost.
#[test]
fn a_watched_page_and_its_file_keep_in_step() {
    let (Some(runtimes), Some(browser)) = (runtimes(), Browser::find()) else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let good = fs::read_to_string(model("pendulum")).unwrap();
    fs::write(&scene, &good).unwrap();
    let watched = Watched::start_with(&scene, Some(&runtimes));
    assert_eq!(watched.events().next()["good"], 1);
    let (mended, again) = (good.replace("IFToMM", "mended"), good.replace("IFToMM", "again"));
    let long = |text: &str, length: &str| text.replace("\"1 m\"", &format!("\"{length} m\""));
    let faults = std::cell::RefCell::new(Vec::new());
    let expect = |text: &str, what: &str| {
        if fs::read_to_string(&scene).unwrap() != text {
            faults.borrow_mut().push(what.to_owned());
        }
    };
    let edit = |number: usize| match number {
        1 => expect(&long(&good, "1.25"), "the change is not in the file"),
        2 => expect(&good, "what was undone is still in the file"),
        3 => fs::write(&scene, &mended).unwrap(),
        4 => fs::write(&scene, &again).unwrap(),
        5 => expect(&again, "the page has written over what the editor saved"),
        _ => expect(&long(&again, "1.5"), "the file has not what was asked for"),
    };
    let Seen { verdict, .. } =
        browser.look_at(&Source { page: "", server: &watched.page, edit: &edit }, include_str!("watches_both.js"));
    assert_eq!(*faults.borrow(), Vec::<String>::new(), "{verdict}");
    assert_eq!(
        verdict,
        serde_json::json!({ "stays": true, "followed": true, "told": true, "kept": true, "quiet": true })
    );
}
