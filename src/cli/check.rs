//! `cotree check`

use std::path::PathBuf;

use clap::Args;

use super::failure::{self, Failure};
use super::{MessageFormat, output};
use crate::compile::{Compiled, compile_with};
use crate::output::assumptions::assumptions;
use crate::output::figures::summarise;
use crate::output::summary::Summary;

/// Check a scene: every fault at once, with its place and what to do
///
/// A scene without faults is described in a few lines, with what was assumed because the scene does not say it.
#[derive(Args)]
#[command(after_help = "Example:\n  cotree check slider_crank.toml")]
pub struct Check {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
}

impl Check {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let scene = output::load(&self.scene)?;
        let (compiled, (summary, assumptions)) =
            compile_with(&scene, |formulated| (summarise(formulated), assumptions(formulated, &scene)))?;
        match format {
            MessageFormat::Human => {
                if let Some(warnings) = &compiled.warnings {
                    failure::warn(warnings);
                }
                output::print(&self.verdict(&summary, &assumptions))
            }
            MessageFormat::Json => output::print(&format!("{:#}\n", self.json(&compiled, assumptions))),
        }
    }

    fn verdict(&self, summary: &Summary, assumptions: &[String]) -> String {
        let mut text = format!(
            "{}: no errors: {}, {}, mobility {}\n",
            self.scene.display(),
            counted(summary.bodies.len(), "body", "bodies"),
            counted(summary.joints.len(), "joint", "joints"),
            summary.mobility
        );
        for assumption in assumptions {
            text += &format!("  assumed: {assumption}\n");
        }
        text
    }

    fn json(&self, compiled: &Compiled, assumptions: Vec<String>) -> serde_json::Value {
        let mut json = compiled.warnings.as_ref().map_or_else(
            || serde_json::json!({ "file": self.scene.display().to_string(), "faults": [], "omitted": 0 }),
            |warnings| warnings.to_json(),
        );
        json["assumptions"] = assumptions.into();
        json
    }
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}
