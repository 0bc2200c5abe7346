//! The pages of `cotree view` in a real browser: headless Chromium. Without one these tests only say so.

mod browser;
#[path = "../support/command.rs"]
mod command;
mod watched;

use std::fs;
use std::path::{Path, PathBuf};

use browser::{Browser, Seen};
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
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name).join("scene.toml")
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
}

#[test]
fn every_model_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("models")).unwrap() {
        let scene = entry.unwrap().path().join("scene.toml");
        let page = page(folder.path(), &scene, folder.path());
        let Some(verdict) = seen(&page, include_str!("shows.js")) else { return };
        assert_eq!(verdict["odd"], serde_json::json!([]), "{}: {verdict}", scene.display());
        assert_eq!(verdict["bodies"], true, "{}: {verdict}", scene.display());
    }
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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/runtimes");
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
