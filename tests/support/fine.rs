//! Models with a tolerance fine enough for the derivatives of their motions.

use super::run;
use crate::support::ROOT;

/// The scene of a model, with a tolerance of 1e-10.
pub fn model(name: &str) -> String {
    let path = format!("{ROOT}/models/{name}/scene.toml");
    let text = run::from_here(name, std::fs::read_to_string(path).unwrap());
    assert!(text.contains("[experiment]"));
    let at = text.find("[experiment]").unwrap();
    let (before, after) = text.split_at(at);
    let mut lines: Vec<String> = after.lines().map(str::to_owned).collect();
    lines.retain(|line| !line.trim_start().starts_with("tolerance"));
    lines.insert(1, "tolerance = 1e-10".to_owned());
    format!("{before}{}\n", lines.join("\n"))
}
