//! How often paths of thirty points give back the four-bar that made them or a cognate, by its class, and how long that takes; and what is left of noise.
//!
//! `cargo run --release -p cotree-synthesis --example paths -- 100`

#[path = "../tests/made/mod.rs"]
mod made;

use std::time::Instant;

use cotree_synthesis::path::{CouplerPath, PathEffort, PathFollower, followers};
use cotree_synthesis::{Point, RandomNumbers, extent};

const POINTS: usize = 30;
const NOISE: f64 = 1e-3;

fn main() {
    let number =
        |place: usize, other: usize| std::env::args().nth(place).and_then(|text| text.parse().ok()).unwrap_or(other);
    let (count, seed) = (number(1, 20), number(2, 1) as u64);
    println!(
        "{:16} {:8} {:>10} {:>12} {:>12} {:>10}",
        "class", "path", "known", "median [s]", "nine of ten", "longest"
    );
    for closed in [true, false] {
        for class in ["crank", "double rocker", "rocker", "no Grashof"] {
            paths(class, closed, count, seed);
        }
    }
    for closed in [true, false] {
        noise(closed, count, seed);
    }
}

fn searched(points: Vec<Point>, closed: bool, times: &mut Vec<f64>) -> Vec<PathFollower> {
    let begin = Instant::now();
    let found = followers(&CouplerPath { points, closed, ..CouplerPath::default() }, &PathEffort::default());
    times.push(begin.elapsed().as_secs_f64());
    found
}

fn paths(class: &str, closed: bool, count: usize, seed: u64) {
    let (mut random, mut known, mut times) = (RandomNumbers::new(100 + seed), 0, Vec::new());
    for _ in 0..count {
        let linkage = made::of_class(&mut random, class);
        let pose = made::somewhere(&linkage, &mut random);
        let points = if closed {
            made::closed(&linkage, &pose, POINTS)
        } else {
            made::piece(&linkage, &pose, POINTS, &mut random)
        };
        let found = searched(points, closed, &mut times);
        known +=
            usize::from(found.first().is_some_and(|best| made::is_it_or_a_cognate(&best.linkage, &linkage, &pose)));
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((count as f64 * share) as usize).min(count - 1)];
    let kind = if closed { "closed" } else { "open" };
    println!(
        "{class:16} {kind:8} {:>10} {:12.2} {:12.2} {:10.2}",
        format!("{known}/{count}"),
        at(0.5),
        at(0.9),
        at(1.0)
    );
}

fn noise(closed: bool, count: usize, seed: u64) {
    let (mut random, mut shares, mut times) = (RandomNumbers::new(200 + seed), Vec::new(), Vec::new());
    for _ in 0..count {
        let linkage = made::of_class(&mut random, "crank");
        let pose = made::somewhere(&linkage, &mut random);
        let exact = if closed {
            made::closed(&linkage, &pose, POINTS)
        } else {
            made::piece(&linkage, &pose, POINTS, &mut random)
        };
        let size = extent(exact.iter().copied()).1;
        let points = exact.iter().map(|point| point + random.normal() * (NOISE * size)).collect();
        let best = searched(points, closed, &mut times).first().map_or(f64::INFINITY, |best| best.rms / (NOISE * size));
        shares.push(best);
    }
    shares.sort_by(f64::total_cmp);
    times.sort_by(f64::total_cmp);
    let kind = if closed { "closed" } else { "open" };
    println!(
        "noise of {NOISE}, {kind}: rms {:.2} of it in the median, {:.2} at most; {:.2} s",
        shares[count / 2],
        shares[count - 1],
        times[count / 2]
    );
}
