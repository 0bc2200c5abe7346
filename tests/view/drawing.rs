//! The page of `cotree draw`: what is drawn in it, what its text is, and that its FMUs are those of the command.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::browser::{Browser, Seen, Source};
use super::watched::Watched;
use super::{model, runtimes};
use crate::outside::command::{code, cotree, stderr, stdout};
use crate::outside::python;

/// What every script has at hand.
const HANDS: &str = include_str!("draws.js");
/// The front end with scripts and styles may be so large, without the runtimes [bytes]: 3.24 MB with friction by series and runs side by side, of which the compressed program is 3.15 MB in base64.
const LARGEST: usize = 3_300_000;

/// The page of a scene, or of an empty sheet; none without the program for browsers.
fn page(folder: &Path, scene: Option<&Path>) -> Option<String> {
    let runtimes = runtimes()?;
    if !runtimes.join("web/cotree_front.wasm").exists() {
        eprintln!("skipped: there is no front end for browsers (tools/build-runtimes.sh web)");
        return None;
    }
    let scene = scene.map(|scene| scene.to_str().unwrap());
    let arguments =
        [&["draw"], scene.as_slice(), &["-o", "draw.html", "--runtimes", runtimes.to_str().unwrap()]].concat();
    let output = cotree(folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output), "draw.html\n");
    Some(fs::read_to_string(folder.join("draw.html")).unwrap())
}

fn seen(page: &str, script: &str) -> Option<serde_json::Value> {
    let Seen { verdict, console } = Browser::find()?.look(page, &format!("{HANDS}{script}"));
    assert!(console.is_empty(), "the browser complains:\n{}", console.join("\n"));
    assert_eq!(verdict["fault"], serde_json::Value::Null, "{verdict}");
    Some(verdict)
}

fn bytes(base64: &serde_json::Value) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let letters = base64.as_str().unwrap().bytes().filter(|letter| *letter != b'=');
    let (mut bits, mut count, mut bytes) = (0_u32, 0, Vec::new());
    for letter in letters {
        let value = LETTERS.iter().position(|own| *own == letter).unwrap();
        (bits, count) = (bits << 6 | value as u32, count + 6);
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    bytes
}

/// The FMU that the command makes of a text.
fn exported(folder: &Path, text: &str, more: &[&str]) -> Vec<u8> {
    fs::write(folder.join("drawn.toml"), text).unwrap();
    let runtimes = runtimes().unwrap();
    let arguments = ["export", "drawn.toml", "-o", "command.fmu", "--runtimes", runtimes.to_str().unwrap()];
    let output = cotree(folder, &[&arguments, more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    fs::read(folder.join("command.fmu")).unwrap()
}

/// The first file of two archives that differs; it says more than that their bytes do.
fn first_difference(one: &[u8], other: &[u8]) -> Option<String> {
    let open = |bytes: &[u8]| zip::ZipArchive::new(std::io::Cursor::new(bytes.to_vec())).unwrap();
    let (mut one, mut other) = (open(one), open(other));
    let names: Vec<String> = one.file_names().map(|name| name.unwrap().into_owned()).collect();
    names.into_iter().find(|name| {
        let read = |archive: &mut zip::ZipArchive<std::io::Cursor<Vec<u8>>>| {
            let mut bytes = Vec::new();
            archive.by_name(name).map(|mut file| std::io::Read::read_to_end(&mut file, &mut bytes)).ok().map(|_| bytes)
        };
        read(&mut one) != read(&mut other)
    })
}

fn assert_same_archive(page: &[u8], command: &[u8], what: &str) {
    assert_eq!(first_difference(page, command), None, "{what}: the file with other content");
    assert!(page == command, "{what}: the archives differ though their files do not");
}

const FMPY: &str = "
import sys, fmpy
result = fmpy.simulate_fmu(sys.argv[1], stop_time=0.39, output_interval=0.01, output=['bar2.tracer.x'])
print(*[float(x).hex() for x in result['bar2.tracer.x']])
";

#[test]
fn a_four_bar_is_drawn_from_nothing_and_its_fmu_is_that_of_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(folder.path(), None) else { return };
    let Some(verdict) = seen(&page, include_str!("draws_four_bar.js")) else { return };
    let text = verdict["text"].as_str().unwrap();
    assert_eq!(
        (&verdict["bodies"], &verdict["four"], &verdict["mobility"]),
        (&3.into(), &1.into(), &0.into()),
        "{text}"
    );
    assert_eq!((&verdict["begun"]["error"], &verdict["moving"]), (&false.into(), &true.into()), "{verdict}");
    assert_eq!(
        (&verdict["empty"], &verdict["again"]),
        (&true.into(), &true.into()),
        "undone to the empty sheet, and done again"
    );
    assert_eq!((&verdict["faults"], &verdict["traced"]), (&serde_json::json!([]), &1.into()));
    let own = bytes(&verdict["fmu"]);
    assert_same_archive(&own, &exported(folder.path(), text, &[]), "FMI 2.0");
    assert_same_archive(&bytes(&verdict["fmu3"]), &exported(folder.path(), text, &["--fmi", "3"]), "FMI 3.0");

    // The frame shows what the FMU does.
    let Some((_, python)) = python::python("fmpy", include_str!("../fmpy/requirements.txt")) else { return };
    fs::write(folder.path().join("page.fmu"), &own).unwrap();
    let printed = python::run(Command::new(python).args(["-c", FMPY, "page.fmu"]).current_dir(folder.path())).unwrap();
    let simulated = {
        let arguments =
            ["simulate", "drawn.toml", "--variables", "bar2.tracer.x", "--step", "10 ms", "--stop", "0.39 s"];
        let output = cotree(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stdout(&output)
    };
    let numbers: Vec<f64> =
        simulated.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let shown: Vec<f64> = verdict["column"].as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect();
    assert_eq!(numbers.len(), 40);
    // The program of a page has more variables, whose sums may be added up in another order.
    let alike = shown.iter().zip(&numbers).all(|(shown, number)| (shown - number).abs() < 1e-15);
    assert!(alike && shown.len() == numbers.len(), "the moving page: {shown:?}, not {numbers:?}");
    let of_fmpy: Vec<&str> = printed.split_whitespace().collect();
    assert_eq!(of_fmpy.len(), 40);
    let hex = |text: &str| {
        // Python's `float.hex`: 0x1.mantissap+exponent.
        let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
        let (mantissa, exponent) = rest.strip_prefix("0x").unwrap().split_once('p').unwrap();
        let digits = mantissa.replace('.', "");
        let value = u64::from_str_radix(&digits, 16).unwrap() as f64;
        sign * value * 2f64.powi(exponent.parse::<i32>().unwrap() - 4 * (digits.len() as i32 - 1))
    };
    assert_eq!(of_fmpy.into_iter().map(hex).collect::<Vec<_>>(), numbers, "fmpy");
}

#[test]
fn every_tool_edits_the_text_by_mouse_and_by_keys_and_faults_are_at_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(folder.path(), None) else { return };
    let Some(mut verdict) = seen(&page, include_str!("draws_more.js")) else { return };
    let seen = verdict.as_object_mut().unwrap();
    assert_eq!(seen.remove("faults"), Some(serde_json::json!([])));
    let selected = seen.remove("selected").unwrap();
    assert!(["density", "furlong"].iter().any(|own| selected.as_str().unwrap().contains(own)), "{selected}");
    let said = seen.remove("said").unwrap();
    assert!(said.as_str().unwrap().contains("Bar done"), "{said}");
    let failed: Vec<_> = seen.iter().filter(|(_, done)| **done != true).collect();
    assert!(failed.is_empty() && seen.len() == 18, "{failed:?} of {}", seen.len());
}

#[test]
fn templates_have_no_faults_and_a_moved_point_changes_its_numbers_only() {
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(folder.path(), Some(&model("slider_crank"))) else { return };
    let Some(verdict) = seen(&page, include_str!("draws_gallery.js")) else { return };
    assert_eq!(verdict["bad"], serde_json::json!([]), "{verdict}");
    assert!(verdict["count"].as_u64().unwrap() > 30, "{verdict}");
    assert_eq!((&verdict["refused"], &verdict["near"]), (&true.into(), &true.into()), "{verdict}");
    let [text, plain] = ["text", "plain"].map(|key| verdict[key].as_str().unwrap());
    let changed: Vec<_> = text.lines().zip(plain.lines()).filter(|(one, other)| one != other).collect();
    assert_eq!((changed.len(), text.lines().count()), (1, plain.lines().count()), "{text}");
    let (head, tail) = changed[0].0.split_once("eye = [").unwrap();
    assert!(changed[0].1.starts_with(head) && tail.ends_with("], low = [0, 0] }"), "{text}");
}

#[test]
fn linkages_for_poses_and_for_a_path_come_into_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(folder.path(), None) else { return };
    let Some(verdict) = seen(&page, include_str!("draws_wishes.js")) else { return };
    assert_eq!(verdict["poses"], 3, "{verdict}");
    assert!(verdict["found"].as_u64().unwrap() > 0 && verdict["found"] == verdict["listed"], "{verdict}");
    assert!(verdict["paths"].as_u64().unwrap() > 0 && verdict["error"].as_f64().unwrap() < 5e-3, "{verdict}");
    for key in ["good", "scene", "pathGood"] {
        assert_eq!(verdict[key], true, "{key}: {verdict}");
    }
    // The command finds as many.
    for (key, found) in [("task", "found"), ("pathTask", "paths")] {
        fs::write(folder.path().join("task.toml"), verdict[key].as_str().unwrap()).unwrap();
        let output = cotree(folder.path(), &["synthesize", "task.toml", "--json"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let answer: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        let [by_command, by_page] =
            [answer["solutions"].as_array().unwrap().len() as u64, verdict[found].as_u64().unwrap()];
        // Of a path the page may list fewer than the command. Why is open.
        assert!(by_command == by_page || key == "pathTask" && by_command > 0, "{key}: {by_command}, {by_page}");
    }
}

#[test]
fn fmus_of_models_are_those_of_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let Some(page) = page(folder.path(), None) else { return };
    let script =
        "const made = {}; for (const name of ['slider_crank', 'jansen', 'excavator', 'planetary_gear', 'gas_strut']) {
        const { text } = (await draw.front.json('front_gallery', '')).find(own => own.name === name);
        draw.put(text); made[name] = { text, fmu: base64((await draw.exportFmu(2)).bytes) }; } return made;";
    let Some(verdict) = seen(&page, script) else { return };
    for (name, made) in verdict.as_object().unwrap() {
        assert_same_archive(&bytes(&made["fmu"]), &exported(folder.path(), made["text"].as_str().unwrap(), &[]), name);
    }
}

#[test]
fn the_page_is_small_fits_a_phone_and_a_file_needs_the_program_for_browsers() {
    let folder = tempfile::tempdir().unwrap();
    let output = cotree(folder.path(), &["draw", "--runtimes", "nowhere", "-o", "draw.html"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("tools/build-runtimes.sh web"), "{}", stderr(&output));
    let Some(page) = page(folder.path(), None) else { return };
    let is_runtime = |part: &&str| part.contains("data-platform=") || part.contains("id=\"solver\"");
    let without: usize = page.split("<script").filter(|part| !is_runtime(part)).map(str::len).sum();
    assert!(without < LARGEST, "{without} bytes");
    let script = "frame.width = 390; frame.height = 800; await wait(200);
        const root = page.document.documentElement, small = [...page.document.querySelectorAll('#tools button')].filter(own => !own.textContent || own.getBoundingClientRect().width < 24);
        return { wide: root.scrollWidth, small: small.length, board: board.getBoundingClientRect().width };";
    let Some(verdict) = seen(&page, script) else { return };
    assert!(verdict["wide"].as_u64().unwrap() <= 390 && verdict["board"].as_f64().unwrap() > 300.0, "{verdict}");
    assert_eq!(verdict["small"], 0, "{verdict}");
}

/// A site of files that refer to each other, and to nothing else.
#[test]
fn a_site_has_the_gallery_and_the_page_to_draw_in() {
    let folder = tempfile::tempdir().unwrap();
    if page(folder.path(), None).is_none() {
        return;
    }
    let root = Path::new(crate::support::ROOT);
    let mut site = Command::new("python3");
    site.arg(root.join("tools/site.py")).arg(folder.path().join("site")).args(["--models", "four_bar,cam_follower"]);
    site.args(["--cotree", env!("CARGO_BIN_EXE_cotree"), "--runtimes"]).arg(root.join("target/runtimes"));
    let output = site.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let index = fs::read_to_string(folder.path().join("site/index.html")).unwrap();
    let places: Vec<&str> = ["href=\"", "src=\""]
        .iter()
        .flat_map(|key| index.split(key).skip(1))
        .filter_map(|rest| rest.split('"').next())
        .collect();
    for place in places.iter().filter(|place| !place.starts_with("data:")) {
        assert!(folder.path().join("site").join(place.split('#').next().unwrap()).is_file(), "{place}");
    }
    assert_eq!(index.matches("draw.html#scene=").count(), 1, "a scene with a table in a file of its own is not drawn");
    let shared = places.iter().find_map(|place| place.split_once("#scene=")).unwrap().1;
    let page = fs::read_to_string(folder.path().join("site/draw.html")).unwrap();
    let script = format!(
        "page.location.hash = 'scene={shared}'; page.location.reload(); await wait(500); await until(() => page.document?.documentElement?.dataset.ready === 'yes'); return page.cotreeDraw.drawing.text;"
    );
    let Some(verdict) = seen(&page, &script) else { return };
    assert_eq!(verdict, fs::read_to_string(model("four_bar")).unwrap());
}

/// Without modules for browsers the program itself is the page's front end and solver: what is drawn moves, is held, and becomes the FMU of the command.
#[test]
fn a_served_page_draws_moves_and_exports() {
    let Some(browser) = Browser::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cotree"));
    command.args(["draw", "--runtimes", "nowhere"]).arg(model("four_bar"));
    let served = Watched::serving(command);
    let script = "await until(() => page.document.documentElement.dataset.moving === draw.drawing.text);
        const inner = draw.motion.frame.contentWindow.cotree, { state, MODEL } = inner;
        inner.pause();
        const names = MODEL.touch.coordinates, pose = names.map(name => state.run.columns.get(name)[0]);
        state.loose.prepare([], 0);
        const grip = state.loose.grip(pose, [], MODEL.geometry.bodies[0].name), held = [...grip.values(names)];
        const { requestAnimationFrame, PointerEvent, DOMPoint } = draw.motion.frame.contentWindow, inside = draw.motion.frame.contentDocument;
        const stage = inside.querySelector('#stage'), body = MODEL.geometry.bodies.findIndex(({ name }) => name === 'coupler'), scale = MODEL.geometry.scale;
        stage.setPointerCapture = () => {};
        const shown = async (count) => { while (count-- > 0) await new Promise(done => requestAnimationFrame(done)); };
        const touch = (kind, [x, y]) => {
            const { x: clientX, y: clientY } = new DOMPoint(scale * x, -scale * y).matrixTransform(inside.querySelector('#scene').getScreenCTM());
            stage.dispatchEvent(new PointerEvent(kind, { pointerId: 5, clientX, clientY, pointerType: 'mouse', bubbles: true }));
        };
        const [x, y] = inner.pose[body];
        let seen = 0;
        touch('pointerdown', [x, y]);
        for (let k = 1; k <= 20; k++) {
            const before = inner.pose[body][2];
            touch('pointermove', [x + .002 * k, y]);
            await shown(2);
            if (inner.pose[body][2] !== before) seen++;
        }
        const steps = inner.touching.hold.steps;
        touch('pointerup', [x + .04, y]);
        await shown(2);
        const moved = Math.hypot(inner.pose[body][0] - x, inner.pose[body][1] - y);
        return { last: state.run.last, error: state.run.error, apart: Math.max(...held.map((value, k) => Math.abs(value - pose[k]))), seen, steps, moved,
            text: draw.drawing.text, fmu: base64((await draw.exportFmu(2)).bytes) };";
    let source = Source { page: "", server: &served.page, edit: &|_| () };
    let Seen { verdict, console } = browser.look_at(&source, &format!("{HANDS}{script}"));
    assert!(console.is_empty() && verdict["fault"].is_null(), "{verdict}\n{}", console.join("\n"));
    assert!(verdict["last"].as_u64().unwrap() > 100 && verdict["error"].is_null(), "{verdict}");
    assert!(verdict["apart"].as_f64().unwrap() < 1e-9, "{verdict}");
    // The coupler follows the pointer while it is pulled, and stays where it was let go.
    assert!(verdict["steps"].as_u64().unwrap() >= 5 && verdict["seen"].as_u64().unwrap() >= 5, "{verdict}");
    assert!(verdict["moved"].as_f64().unwrap() > 0.002, "{verdict}");
    fs::write(folder.path().join("drawn.toml"), verdict["text"].as_str().unwrap()).unwrap();
    let output = cotree(folder.path(), &["export", "drawn.toml", "-o", "command.fmu", "--runtimes", "nowhere"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(bytes(&verdict["fmu"]), fs::read(folder.path().join("command.fmu")).unwrap());
}
