//! Feeds damaged scenes or programs to cotree, tasks to its synthesis, or calls in any order to a runtime, and looks for panics and for inputs that take too long.
//!
//! usage: fuzz scene|program|calls|task SECONDS [SEED]
//!        fuzz scene|program|calls|task FILE             tries one input again
//!
//! What is found is saved in `target/fuzz/`, and the exit code is 1. The same seed gives the same inputs. A build with debug
//! assertions also finds arithmetic that overflows.

mod calls;
mod mutate;
mod program;
mod scene;
mod task;

use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use std::{env, fs};

use mutate::Random;

/// The folder of the whole project.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// An input that takes longer is reported.
const SLOW: Duration = Duration::from_secs(60);

/// What is fed: it makes an input, and tries it.
trait Target: Send {
    fn next(&mut self, random: &mut Random) -> Vec<u8>;
    /// True if the input got beyond the first checks.
    fn attempt(&self, input: &[u8]) -> bool;
}

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (target, seconds, seed) = match words[..] {
        [target, seconds] => (target, seconds.parse(), Ok(1)),
        [target, seconds, seed] => (target, seconds.parse(), seed.parse()),
        _ => return usage(),
    };
    let worker: Box<dyn Target> = match target {
        "scene" => Box::new(scene::Scenes::new()),
        "program" => Box::new(program::Programs::new()),
        "calls" => Box::new(calls::Calls::new()),
        "task" => Box::new(task::Tasks),
        _ => return usage(),
    };
    if let (Err(_), [_, file]) = (&seconds, &words[..]) {
        return again(worker.as_ref(), file);
    }
    let (Ok(seconds), Ok(seed)) = (seconds, seed) else {
        return usage();
    };
    fuzz(target, worker, Duration::from_secs(seconds), seed)
}

fn usage() -> ExitCode {
    eprintln!("usage: fuzz scene|program|calls|task SECONDS [SEED]\n       fuzz scene|program|calls|task FILE");
    ExitCode::from(2)
}

/// Tries one input, without catching anything.
fn again(target: &dyn Target, file: &str) -> ExitCode {
    match fs::read(file) {
        Ok(input) => println!("{file}: {}", if target.attempt(&input) { "runs" } else { "is refused" }),
        Err(error) => {
            eprintln!("error: cannot read `{file}`: {error}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

/// The inputs are tried in a thread of their own, so that one that never ends can be reported.
fn fuzz(name: &str, mut target: Box<dyn Target>, time: Duration, seed: u64) -> ExitCode {
    let (inputs, started) = mpsc::channel::<Vec<u8>>();
    let (finished, results) = mpsc::channel::<Option<bool>>();
    let end = Instant::now() + time;
    std::thread::spawn(move || {
        let mut random = Random::new(seed);
        while Instant::now() < end {
            let input = target.next(&mut random);
            let attempt = AssertUnwindSafe(|| target.attempt(&input));
            let told = inputs.send(input.clone());
            let result = panic::catch_unwind(attempt).ok();
            if told.is_err() || finished.send(result).is_err() {
                return;
            }
        }
    });
    let (mut count, mut deep, mut found) = (0u64, 0u64, 0u64);
    while let Ok(input) = started.recv() {
        let result = match results.recv_timeout(SLOW) {
            Ok(result) => result,
            Err(_) => {
                found += 1;
                report(name, "slow", count, &input);
                match results.recv_timeout(5 * SLOW) {
                    Ok(result) => result,
                    Err(_) => break,
                }
            }
        };
        match result {
            Some(beyond) => deep += u64::from(beyond),
            None => {
                found += 1;
                report(name, "panic", count, &input);
            }
        }
        count += 1;
    }
    println!("{name}: {count} inputs, {deep} beyond the first checks, {found} findings (seed {seed})");
    if found == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Saves an input that makes trouble.
fn report(name: &str, what: &str, number: u64, input: &[u8]) {
    let folder = PathBuf::from(ROOT).join("target/fuzz");
    let path = folder.join(format!("{name}-{what}-{number}"));
    let saved = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, input));
    println!(
        "{what} at input {number}: {} {}",
        path.display(),
        saved.err().map(|error| error.to_string()).unwrap_or_default()
    );
}
