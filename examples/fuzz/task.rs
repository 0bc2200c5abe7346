//! Tasks of linkage synthesis: of every kind, with numbers of any size, with and without units, within limits that may contradict each other; and damaged ones.

use std::fmt::Write;

use cotree::task::Task;
use cotree_study::synthesis::synthesize;

use crate::Target;
use crate::mutate::{self, Random};

/// Makes tasks.
pub struct Tasks;

impl Target for Tasks {
    fn next(&mut self, random: &mut Random) -> Vec<u8> {
        let mut task = task(random).into_bytes();
        if random.below(4) == 0 {
            mutate::bytes(random, &mut task);
        }
        task
    }

    fn attempt(&self, input: &[u8]) -> bool {
        let Ok(text) = std::str::from_utf8(input) else { return false };
        let Ok(task) = Task::from_text(text) else { return false };
        synthesize(&task, true).map(|answer| answer.report().json()).is_ok()
    }
}

/// A length: bare, in millimetres, or out of all proportion.
fn length(random: &mut Random) -> String {
    let whole = random.below(400) as f64 - 100.0;
    match random.below(16) {
        0 => format!("{whole}"),
        1 => format!("{}", *random.pick(&[0.0, 1e-9, -1e6, 1e12, 1e-300, 1e300])),
        2 => format!("\"{whole} km\""),
        _ => format!("\"{whole} mm\""),
    }
}

fn angle(random: &mut Random) -> String {
    format!("\"{} deg\"", random.below(720) as f64 - 180.0)
}

/// A list of what is made so often.
fn list(count: usize, mut one: impl FnMut() -> String) -> String {
    format!("[{}]", (0..count).map(|_| one()).collect::<Vec<_>>().join(", "))
}

fn task(random: &mut Random) -> String {
    let count = 2 + random.below(8);
    let mut text = match random.below(8) {
        0 => {
            let poses = list(count, || format!("[{}, {}, {}]", length(random), length(random), angle(random)));
            format!("[poses]\nat = {poses}\n")
        }
        1 => {
            let slides = random.below(2) == 0;
            let input = list(count, || angle(random));
            let output = list(count, || if slides { length(random) } else { angle(random) });
            format!("[function]\ninput = {input}\noutput = {output}\n")
        }
        2 => {
            let way = if random.below(2) == 0 {
                format!("swing = {}", angle(random))
            } else {
                format!("stroke = {}", length(random))
            };
            format!("[stroke]\ntime_ratio = {}\n{way}\n", random.below(30) as f64 / 10.0)
        }
        _ => {
            let points = list(count, || format!("[{}, {}]", length(random), length(random)));
            let mut path = format!("[path]\npoints = {points}\nclosed = {}\n", random.below(2) == 0);
            if random.below(6) == 0 {
                let _ = writeln!(path, "crank = {}", list(count, || angle(random)));
            }
            if random.below(6) == 0 {
                let _ = writeln!(path, "pivots = {}", list(2, || format!("[{}, {}]", length(random), length(random))));
            }
            path
        }
    };
    limits(random, &mut text);
    text
}

/// Limits; writing to a string cannot fail.
fn limits(random: &mut Random, text: &mut String) {
    let _ = writeln!(text, "[limits]");
    if random.below(3) > 0 {
        let _ = writeln!(text, "length = [\"{} mm\", \"{} mm\"]", random.below(60), 1 + random.below(2000));
    }
    if random.below(3) == 0 {
        let _ = writeln!(text, "ground = {{ x = [{}, {}] }}", length(random), length(random));
    }
    if random.below(2) == 0 {
        let _ = writeln!(text, "crank = true\ntransmission = \"{} deg\"", random.below(90));
    }
    if random.below(4) == 0 {
        let prefer = random.pick(&["size", "transmission"]);
        let _ = writeln!(text, "within = {}\nprefer = \"{prefer}\"", length(random));
    }
    if random.below(8) == 0 {
        let _ = writeln!(text, "bars = 6");
    }
}
