//! Time at a wanted error, as a multiple of what a program by hand takes in the same run.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use cotree_fmu::instance::Instance;

use crate::{Failure, error_at_end, fastest, model, scenes, started};

/// A scene with the error that is wanted.
struct Target {
    title: &'static str,
    scene: String,
    error: f64,
    /// Time over that of the program by hand.
    ratio: f64,
    /// What the runner of other programs calls the scene, and its row.
    peer: [&'static str; 2],
}

fn list() -> [Target; 5] {
    let ten_seconds = scenes::four_bars(40).replace("stop = 1\n", "stop = 10\n");
    let target = |title, scene, error, ratio, peer| Target { title, scene, error, ratio, peer };
    [
        target("S1 slider-crank, 10 s", scenes::model("bench_slider_crank"), 1e-6, 0.75, ["S1", "S1"]),
        target("S2 Andrews, 0.03 s", scenes::model("andrews"), 1e-8, 0.85, ["S2", "S2"]),
        target("S3 40 four-bars, 10 s", ten_seconds, 1e-5, 1.8, ["S3", "S3_40"]),
        target("S4 chain of 50, 1 s", scenes::chain(50), 1e-8, 1.2, ["S4", "S4_50"]),
        target("S6 stiff slider-crank, 10 s", scenes::stiff(), 1e-6, 1.0, ["S6", "S6_1e9"]),
    ]
}

/// Table of the targets.
pub fn write(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Targets\n\nTime at the loosest tolerance of 1e-3, 3e-4, 1e-4, ... whose error at the end, in coordinates and against a run at 1e-12, is the wanted one. By \
              hand: the fastest of the programs in C++ that were written for the one mechanism, Runge-Kutta of order 8 or Radau, at the error found, run by `COTREE_PEERS` between \
              two of our measurements, of which the faster counts; `-` without.\n\n\
              | scene | error | tolerance | error found | time [ms] | by hand [ms] | ratio | target |\n|---|---|---|---|---|---|---|---|\n";
    for Target { title, scene, error: wanted, ratio, peer } in list() {
        let model = model(&scene)?;
        let stop = model.program().experiment.stop;
        let run = |instance: &mut Instance| -> Result<(), Failure> { Ok(instance.step_to(stop)?) };
        let mut exact = started(&model, None, 1e-12)?;
        run(&mut exact)?;
        for tolerance in (3..=11).flat_map(|exponent| [1.0, 0.3].map(|part| part * 10.0_f64.powi(-exponent))) {
            let mut instance = started(&model, None, tolerance)?;
            run(&mut instance)?;
            let error = error_at_end(&instance, &exact);
            if error <= wanted {
                let measure = || Ok::<f64, Failure>(1e3 * fastest(|| started(&model, None, tolerance), run)?);
                let before = measure()?;
                let hand = by_hand(peer, error);
                let time = before.min(measure()?);
                let by_hand = hand.map_or_else(|| "-".into(), |hand| format!("{hand:.3}"));
                let found = hand.map_or_else(|| "-".into(), |hand| format!("{:.2}", time / hand));
                writeln!(
                    text,
                    "| {title} | {wanted:.0e} | {tolerance:.0e} | {error:.0e} | {time:.3} | {by_hand} | {found} | {ratio} |"
                )?;
                break;
            }
        }
    }
    *text += REASONS;
    Ok(())
}

/// Milliseconds of the fastest program by hand at an error, from the runner's table: a row for each program, a column for each error. Between two columns times are powers of the
/// error.
fn by_hand([scene, row]: [&str; 2], error: f64) -> Option<f64> {
    let folder = std::env::var_os("COTREE_PEERS")?;
    let output =
        Command::new(Path::new(&folder).join("run.sh")).args([scene, "hand"]).current_dir(&folder).output().ok()?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let mut lines = said.lines().skip_while(|line| !line.starts_with(&format!("| {row} peer |")));
    let errors: Vec<Option<f64>> = cells(lines.next()?).iter().map(|cell| cell.parse().ok()).collect();
    let table = lines.take_while(|line| line.starts_with('|')).map(cells);
    let programs = table.filter(|row| row.get(1).is_some_and(|name| name.starts_with("hand")));
    programs.filter_map(|row| at(error, &errors, &row)).min_by(f64::total_cmp)
}

/// The time in a row of the table at an error.
fn at(error: f64, errors: &[Option<f64>], row: &[String]) -> Option<f64> {
    let points =
        errors.iter().zip(row).filter_map(|(error, time)| Some([(*error)?.ln(), time.parse::<f64>().ok()?.ln()]));
    let points: Vec<[f64; 2]> = points.collect();
    let between = points.windows(2).find(|pair| (pair[1][0]..=pair[0][0]).contains(&error.ln()))?;
    let share = (error.ln() - between[0][0]) / (between[1][0] - between[0][0]);
    Some((between[0][1] + share * (between[1][1] - between[0][1])).exp())
}

/// Why some targets are missed.
const REASONS: &str = "
Where a target is missed:

- **S1, S2.** Each order depends on the accelerations of the one before: products of series, the inverse, the motion of the arms, their forces, in sequence. This latency,
  not the number of instructions, determines the time of an order: a version with all orders in one loop and all operands loaded before it took 6 % fewer instructions and the same time.
  Effective: registers for mechanisms of frames only, vectors of four numbers, sums in two halves with the newest terms last, the response of a small pose to an order computed
  once a step, orders that grow with the tolerance (16 became 20 at 1e-6), inverses four rows at a time. Ineffective: factors instead of the inverse, one function for each number of
  loops, the response of more than four frames, forces directly from the moments. A step also tests for singular configurations, verifies the equations at its end, and stores its polynomial,
  which programs by hand do not.
- **S3.** The matrix is factored as a sparse matrix (before, its inverse took fifteen times as long). Elimination works from both ends of the row towards its middle, so that half as
  many results wait for each other, and each result is found at once, with its sum in a register. A quarter of the time goes to ten passages through the flat pose, in
  which all forty loops are singular at once: each passage is located to six digits, the dependent loop equations are found by one elimination, and of each of the forty
  combinations one step of Newton's method says by how much branches miss each other. A program by hand goes straight on and does not ask: where branches miss, it would be wrong
  without a word. Half of the time goes to the orders, two fifths of it to their solutions. The error of 1e-6 is what steps at 1e-3 leave: they end next to the passages, and are no longer
  than those at 1e-6.
- **S4.** In branch coordinates the mass matrix of a chain is full, but each of its entries is a product of a link and the mass that the other body carries: the forces of an
  order are sums along the chain, and the accelerations follow from recursive factors. Before, every order multiplied twice with the full
  matrix, and every step inverted it. The rest is latency: each link depends on the one before, twice an order.
- **S6** is met. The same method as by hand, Radau IIA of order 5; but the stiff direction turns within a step, and one Jacobian for all stages made Newton's iterations slow: 5.2
  a step, and shorter steps where they did not converge. With a Jacobian at each stage there are 2 to 3, and steps as long as the error permits. The three stages are evaluated by the
  interpreter together, in vectors of four numbers, the derivatives in two passes with them. Half of the time is latency of the interpreter, each
  instruction depending on the one before.
- **Kernels** (twice the time of `gcc -O2`). An instruction that waits for another one waits for memory: a multiplication after another takes 3.6 ns through the registers of the
  tape, 13 cycles, of which the processor (AMD EPYC, 3.7 GHz) needs ten to forward what was stored; in its own registers 0.8 ns. Along the longest chain of S2 these are 250 of 460 ns.
  Effective: products subtracted in one instruction, of two products the one that is waited for (14 to 21 % fewer instructions), four sines and cosines at once; S2 went from 570 to 460 ns.
  Ineffective: operands packed into words of 64 bits, code for 2, 4 and 8 instructions of a kind, loops of four (all within 5 %), one jump for each instruction (10 to 75 % slower).
";
