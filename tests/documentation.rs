//! `documentation/index.html` of an FMU: the page that moves, with everything that a user of the FMU wants to read.

use crate::outside::command;
use crate::support::ROOT;

use std::fs;
use std::io::Read;
use std::path::Path;

use command::{code, cotree, stderr};

fn page(folder: &Path, scene: &str, options: &[&str]) -> (String, Vec<u8>) {
    let output = cotree(folder, &[&["export", scene, "-o", "model.fmu"], options].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let file = fs::read(folder.join("model.fmu")).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&file)).unwrap();
    let mut text = String::new();
    archive.by_name("documentation/index.html").unwrap().read_to_string(&mut text).unwrap();
    (text, file)
}

fn model(name: &str) -> String {
    let path = Path::new(ROOT).join("models").join(name).join("scene.toml");
    path.to_str().unwrap().to_owned()
}

/// What stands in a script element of the page.
fn script<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.split_once(&format!("id=\"{id}\">")).unwrap_or_else(|| panic!("no {id}")).1;
    start.split_once("</script>").unwrap().0
}

#[test]
fn it_moves_and_has_everything_to_read() {
    let folder = tempfile::tempdir().unwrap();
    for fmi in ["2", "3"] {
        let (page, file) = page(folder.path(), &model("four_bar"), &["--fmi", fmi]);
        assert!(script(&page, "solver").is_empty() && script(&page, "program").is_empty());
        assert!(script(&page, "run").len() > 1000);
        for text in [
            "<h2>Use</h2>",
            "<h2>Parameters</h2>",
            "<code>stall_torque</code>",
            "<h2>Outputs</h2>",
            "<h2>Accuracy and work</h2>",
            "<h2>Licences</h2>",
            "<math",
            "Linear graphs",
            "fmpy",
            "against a torsion spring",
        ] {
            assert!(page.contains(text), "{text}");
        }
        let (_, again) = self::page(folder.path(), &model("four_bar"), &["--fmi", fmi]);
        assert!(file == again, "the same scene gives the same bytes");
    }
}

#[test]
fn it_has_the_runtime_for_browsers_if_that_is_there_and_is_smaller_if_lean() {
    let folder = tempfile::tempdir().unwrap();
    let web = folder.path().join("runtimes/web");
    fs::create_dir_all(&web).unwrap();
    // Half a megabyte that only looks like it: nobody runs it here.
    let mut state = 1_u64;
    let noise = (0..500_000).map(|_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 56) as u8
    });
    let module: Vec<u8> =
        b"\0asm".iter().copied().chain(cotree_fmu::program::storage::KIND.bytes()).chain(noise).collect();
    fs::write(web.join("cotree_runtime.wasm"), module).unwrap();
    let with = page(folder.path(), &model("pendulum"), &["--runtimes", "runtimes"]);
    let lean = page(folder.path(), &model("pendulum"), &["--runtimes", "runtimes", "--lean"]);
    assert!(script(&with.0, "solver").len() > 400_000 && script(&with.0, "run").is_empty());
    assert!(script(&lean.0, "solver").is_empty() && script(&lean.0, "run").len() > 1000);
    assert!(with.1.len() > lean.1.len() + 400_000, "{} {}", with.1.len(), lean.1.len());
    fs::write(web.join("cotree_runtime.wasm"), b"\0asm of another version").unwrap();
    let output = cotree(folder.path(), &["export", &model("pendulum"), "--runtimes", "runtimes"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("another version"), "{}", stderr(&output));
}

/// A pendulum whose motor drives it faster and faster: nobody waits for the whole run.
#[test]
fn a_stored_run_is_no_longer_than_the_measurement_may_be() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "format = 1\nname = \"spin\"\n[bodies.arm]\nmass = 1\ninertia = 1\npoints = { end = [-1, 0] }\n\
                 [joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm.end\"]\n[loads.motor]\ntype = \"torque\"\n\
                 on = \"arm\"\nvalue = \"sin(1e5*t)\"\n[outputs]\nvariables = [\"arm.angle\"]\n[experiment]\nstop = \"1000 s\"\n";
    fs::write(folder.path().join("spin.toml"), scene).unwrap();
    let (page, _) = page(folder.path(), "spin.toml", &[]);
    assert!(script(&page, "model").contains("The stored run ends at"), "{}", script(&page, "model"));
}

#[test]
fn a_large_mechanism_stands_still_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = "format = 1\nname = \"many\"\n".to_owned();
    for index in 0..101 {
        scene += &format!(
            "[bodies.b{index}]\nmass = 1\ninertia = 1\n[joints.j{index}]\ntype = \"prismatic\"\n\
             between = [\"ground\", \"b{index}\"]\naxis = [1, 0]\n"
        );
    }
    fs::write(folder.path().join("many.toml"), scene + "[outputs]\nvariables = [\"b0.x\"]\n").unwrap();
    let (page, _) = page(folder.path(), "many.toml", &[]);
    assert!(page.contains("The picture is not animated: the mechanism has 101 bodies"), "{page:.600}");
    assert!(page.contains("<svg") && page.contains("<h2>Use</h2>") && !page.contains("<script"));
}

/// The job of this name in the workflow of releases.
fn job<'a>(workflow: &'a str, name: &str) -> &'a str {
    let (_, rest) = workflow.split_once(&format!("\n  {name}:\n")).unwrap_or_else(|| panic!("no job {name}"));
    let end = rest.match_indices("\n  ").find(|(at, _)| !rest[at + 3..].starts_with([' ', '#']));
    end.map_or(rest, |(at, _)| &rest[..at])
}

/// A tag publishes what the scripts build and try, for every platform; wheels and archives are made after the runtime for browsers, and have it.
#[test]
fn what_is_released_is_tried_and_has_the_runtime_for_browsers() {
    let workflow = fs::read_to_string(Path::new(ROOT).join(".github/workflows/release.yml")).unwrap();
    let in_order = |name: &str, steps: &[&str]| {
        let job = job(&workflow, name);
        let places: Vec<usize> =
            steps.iter().map(|step| job.find(step).unwrap_or_else(|| panic!("{name}: no `{step}`"))).collect();
        assert!(places.is_sorted(), "{name}: {steps:?}");
    };
    in_order(
        "archives",
        &[
            "apple-darwin",
            "tools/release.sh",
            "tools/test-release.sh",
            "path: target/release-files",
            "cotree export",
            "path: fmus",
        ],
    );
    in_order(
        "macos",
        &[
            "needs: archives",
            "macos-aarch64",
            "macos-x86_64",
            "name: fmus",
            "tests/fmpy/run.py \"$fmu\"",
            "cp -r linux/runtimes",
            "upload-artifact",
        ],
    );
    in_order(
        "wheels",
        &[
            "windows-latest",
            "tools/build-runtimes.sh web",
            "python/cotree/runtimes",
            "maturin build",
            "upload-artifact",
        ],
    );
    for tried in ["artifact: archives", "wheel-windows-x86_64", "wheel-macos-aarch64", "wheel-macos-x86_64"] {
        in_order("try-wheels", &["needs: [archives, wheels]", tried, "download-artifact", "pip install", "page()"]);
    }
    in_order(
        "publish",
        &[
            "needs: [checks, suites, archives, macos, wheels, try-wheels, container]",
            "if: github.ref_type == 'tag'",
            "download-artifact",
            "SHA256SUMS",
            "attest-build-provenance",
            "gh release create",
        ],
    );
    let script = fs::read_to_string(Path::new(ROOT).join("tools/release.sh")).unwrap();
    let wheels = script.split_once("\nwheels() {").unwrap().1.split_once("\n}").unwrap().0;
    assert!(
        wheels.find("cp -r \"$runtimes/web\" python/cotree/runtimes/web").unwrap()
            < wheels.find("maturin build").unwrap()
    );
}
