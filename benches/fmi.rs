//! What the calls of an importer cost, through the C interface of exported FMUs: `cargo bench --bench fmi`.
#![allow(missing_docs, reason = "a program, not a library")]
#![allow(dead_code, unused_imports, reason = "the conformance tests use the rest of the modules")]

#[path = "../tests/conformance/fmu.rs"]
mod fmu;
#[path = "../tests/outside/fmu_description.rs"]
mod fmu_description;
#[path = "../tests/outside/xml.rs"]
mod xml;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Instant;

use cotree::scene::Scene;
use cotree_fmu::fmi2::types::fmi2Status::fmi2OK;
use cotree_fmu::fmi2::types::fmi2True;
use fmu::{Fmu, Slave};

const MODELS: [&str; 4] = ["bench_slider_crank", "slider_crank", "cart_pole", "andrews"];
/// Fastest of so many rounds.
const ROUNDS: usize = 20;
/// Steps in a round.
const STEPS: u32 = 1000;

fn main() {
    let work = tempfile::tempdir().expect("a folder");
    println!(
        "{:20}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>12}{:>10}",
        "", "1 ms", "step", "+ get", "+ set", "save", "restore", "start", "size"
    );
    for model in MODELS {
        measure(model, work.path());
    }
    println!(
        "\n1 ms: fmi2DoStep by 1 ms, constant inputs; step: by the default step; + get: with all outputs read; + set: with an input or tunable parameter\n\
         that changes before each step; save, restore: the state, into an existing one; start: instantiate, initialise, free; size: the\n\
         archive for this platform"
    );
}

fn measure(model: &str, work: &Path) {
    let archive = work.join(format!("{model}.fmu"));
    let fmu = Fmu::open(&unpacked(model, &archive));
    let experiment = fmu.below("/DefaultExperiment")[0];
    let h: f64 = fmu::attribute(experiment, "stepSize").and_then(|text| text.parse().ok()).expect("a step");
    let slave = fmu.slave();
    let outputs = fmu.of_causality("output");
    let settable = fmu.inputs().into_iter().chain(fmu.parameters("tunable")).next();
    // Longer than the experiment, some mechanisms spin up for ever.
    let stop: f64 = fmu::attribute(experiment, "stopTime").and_then(|text| text.parse().ok()).expect("a stop");
    let millisecond = (stop > 1.0).then(|| stepping(&slave, 1e-3, |_| {}));
    let plain = stepping(&slave, h, |_| {});
    let read = stepping(&slave, h, |_| drop(slave.read(&outputs)));
    let set = settable.map(|known| {
        let start = fmu.default(known);
        stepping(&slave, h, |k| assert_eq!(slave.put(known, start + 1e-3 * f64::from(k % 7)), fmi2OK))
    });
    let mut state = slave.save();
    let save = each(|| assert_eq!(unsafe { (slave.fmi().get_state)(slave.c, &mut state) }, fmi2OK));
    let restore = each(|| assert_eq!(slave.restore(state), fmi2OK));
    slave.free(state);
    let start = fastest(|| drop(fmu.started()), 1);
    let size = fs::metadata(&archive).expect("a file").len();
    let set = set.map_or("-".to_owned(), nanoseconds);
    println!(
        "{model:20}{:>10}{:>10}{:>10}{set:>10}{:>10}{:>10}{:>9.1} us{:>7} kB",
        millisecond.map_or("-".to_owned(), nanoseconds),
        nanoseconds(plain),
        nanoseconds(read),
        nanoseconds(save),
        nanoseconds(restore),
        start / 1e3,
        size / 1000
    );
}

fn nanoseconds(time: f64) -> String {
    format!("{time:.0} ns")
}

/// Exports a model and unpacks it.
fn unpacked(model: &str, archive: &Path) -> PathBuf {
    let scene = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("models").join(model).join("scene.toml");
    let text = fs::read_to_string(scene).expect("a scene");
    Scene::from_toml(&text).expect("a sound scene").export_fmu(archive).expect("an FMU");
    let folder = archive.with_extension("");
    let mut zip = zip::ZipArchive::new(File::open(archive).expect("a file")).expect("an archive");
    zip.extract(&folder).expect("a folder");
    folder
}

/// Time of one communication step with something before it [ns]; the rounds go on from each other.
fn stepping(slave: &Slave, h: f64, before: impl Fn(u32)) -> f64 {
    assert_eq!(slave.reset(), fmi2OK);
    slave.start();
    let mut k = 0;
    let round = || {
        for _ in 0..STEPS {
            before(k);
            let t = f64::from(k) * h;
            assert_eq!(unsafe { (slave.fmi().do_step)(slave.c, t, h, fmi2True) }, fmi2OK);
            k += 1;
        }
    };
    fastest(round, STEPS)
}

fn each(mut call: impl FnMut()) -> f64 {
    fastest(|| (0..STEPS).for_each(|_| call()), STEPS)
}

/// Time of the fastest round, for each of so many parts [ns].
fn fastest(mut round: impl FnMut(), parts: u32) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        round();
        start.elapsed().as_secs_f64() * 1e9
    });
    times.fold(f64::INFINITY, f64::min) / f64::from(parts)
}
