//! temp
use cotree::{formulate::formulate, scene::Scene};
use cotree_fmu::{instance::Instance, model::Model};
use std::sync::Arc;
fn main() {
    for path in std::env::args().skip(1) {
        let s = Scene::read(&path).and_then(|s| s.resolve());
        let m = match s {
            Ok(m) => m.mechanism,
            Err(f) => {
                println!("{}", f.render(false, 100));
                continue;
            }
        };
        let f = match formulate(&m) {
            Ok(f) => f,
            Err(f) => {
                for x in f {
                    println!("{path}: {} {} / {}", x.code, x.message, x.help);
                }
                continue;
            }
        };
        println!(
            "{path}: n {} m {} redundant {:?} mobility {} motion {:?} regs {} accel {} instr",
            f.equations.coordinates.len(),
            f.equations.constraints.len(),
            f.redundant,
            f.mobility(),
            f.lowered.program.motion,
            f.lowered.program.registers,
            f.lowered.program.tapes.acceleration.instructions.len()
        );
        for w in &f.warnings {
            println!("   warning {}", w.message);
        }
        let csv = std::path::Path::new(&path).with_file_name("expected.csv");
        let Ok(text) = std::fs::read_to_string(csv) else { continue };
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        let model = Arc::new(Model::new(f.lowered.program.clone()).unwrap());
        let mut i = Instance::new(model);
        let tol: f64 = std::env::var("TOL").ok().map(|x| x.parse().unwrap()).unwrap_or(1e-9);
        i.setup(rows[0][0], None, Some(tol)).unwrap();
        let t0 = std::time::Instant::now();
        if let Err(e) = i.initialise() {
            println!("  {e}");
            continue;
        }
        let vars: Vec<Option<usize>> = head[1..].iter().map(|n| i.variable(n)).collect();
        let mut err = vec![0.0f64; head.len() - 1];
        let mut scale = vec![0.0f64; head.len() - 1];
        for row in &rows {
            if row[0] > i.time() {
                if let Err(e) = i.step_to(row[0]) {
                    println!("  {e}");
                    break;
                }
            }
            for (k, v) in vars.iter().enumerate() {
                if let Some(v) = v {
                    let x = i.get(*v).unwrap();
                    err[k] = err[k].max((x - row[k + 1]).abs());
                    scale[k] = scale[k].max(row[k + 1].abs());
                } else if row[0] == rows[0][0] {
                    println!("   no {}", head[k + 1]);
                }
            }
        }
        println!("   {:?} {:?}", t0.elapsed(), i.statistics());
        for (k, n) in head[1..].iter().enumerate() {
            println!("   {n:30} err {:.2e} scale {:.2e} rel {:.1e}", err[k], scale[k], err[k] / scale[k].max(1e-12));
        }
    }
}
