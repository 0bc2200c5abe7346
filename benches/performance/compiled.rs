//! What the C that cotree itself writes takes for the accelerations, compiled with `gcc -O2`.

use std::fmt::Write;
use std::process::Command;

use cotree::scene::Scene;
use cotree_fmu::model::{Model, State};
use cotree_text::written::{EquationFormat, equations};

use crate::Failure;

/// Nanoseconds of one call; none if there is no compiler, or if the scene has inputs.
pub fn accelerations(text: &str, model: &Model, state: &State) -> Result<Option<f64>, Failure> {
    let scene = Scene::from_toml(text).map_err(|faults| faults.render(false, 100))?;
    let program = model.program();
    if !(program.inputs.is_empty() && program.followers.is_empty()) {
        return Ok(None);
    }
    let code = equations(&scene, EquationFormat::C).map_err(|faults| faults.render(false, 100))?;
    let folder = tempfile::tempdir()?;
    let [source, binary] = ["timed.c", "timed"].map(|name| folder.path().join(name));
    std::fs::write(&source, code + &driver(&program.name, model, state))?;
    let compiled = Command::new("gcc").args(["-O2", "-o"]).arg(&binary).arg(&source).arg("-lm").output();
    if !compiled.is_ok_and(|output| output.status.success()) {
        return Ok(None);
    }
    let output = Command::new(&binary).output()?;
    Ok(Some(String::from_utf8_lossy(&output.stdout).trim().parse()?))
}

/// A main function that prints the fastest of many repetitions.
fn driver(name: &str, model: &Model, state: &State) -> String {
    let (registers, layout) = (state.registers(), model.layout());
    let n = model.coordinates();
    let array = |name: &str, values: &[f64]| {
        let values: Vec<String> = values.iter().map(|value| format!("{value:e}")).collect();
        format!(
            "    volatile double {name}_[] = {{{}}};\n",
            if values.is_empty() { "0".into() } else { values.join(", ") }
        )
    };
    let mut text = String::from("\n#include <stdio.h>\n#include <time.h>\n\nint main(void)\n{\n");
    let parameters = &registers[layout.parameters()..layout.inputs()];
    text += &array("p", parameters);
    text += &array("q", &registers[layout.positions()..][..n]);
    text += &array("v", &registers[layout.rates()..][..n]);
    let reactions = model.program().constraints.len().max(1);
    let _ = write!(
        text,
        "    double p[{0}], q[{1}], v[{1}], none[1] = {{0}}, a[{1}], lambda[{2}], sum = 0, best = 1e300;\n    \
         for (int i = 0; i < {3}; i++) p[i] = p_[i];\n    for (int i = 0; i < {1}; i++) {{ q[i] = q_[i]; v[i] = v_[i]; }}\n    \
         for (int round = 0; round < 200; round++) {{\n        struct timespec from, to;\n        clock_gettime(CLOCK_MONOTONIC, &from);\n        \
         for (int i = 0; i < 200; i++) {{ {name}_accelerations(0.0, p, none, none, q, v, a, lambda); q[0] += 1e-12 * a[0]; sum += a[0]; }}\n        \
         clock_gettime(CLOCK_MONOTONIC, &to);\n        \
         double ns = ((to.tv_sec - from.tv_sec) * 1e9 + (to.tv_nsec - from.tv_nsec)) / 200;\n        if (ns < best) best = ns;\n    }}\n    \
         fprintf(stderr, \"%g\\n\", sum);\n    printf(\"%.3f\\n\", best);\n    return 0;\n}}\n",
        parameters.len().max(1),
        n.max(1),
        reactions,
        parameters.len(),
    );
    text
}
