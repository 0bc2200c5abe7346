//! `cotree check`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::compile::{Compiled, compile_with_equations};
use cotree::formulate::Formulated;
use cotree::formulate::explain::attempt::attempt;
use cotree::report::figures::summarise;
use cotree::report::summary::Summary;
use cotree::run::Gaps;
use cotree::scene::{Fault, Scene};
use cotree::typeset::{counted, short};
use cotree_draw::pose::{draw, draw_attempt};
use cotree_study::analysis::at_start;
use cotree_study::contact;
use cotree_text::assumptions::assumptions;

use super::failure::{Failure, say};
use super::{MessageFormat, output};

/// Check scenes: list all errors and warnings with their places and what to do
///
/// A scene without errors is described in a few lines, with the assumptions made for missing values. Several scenes are checked independently.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree check slider_crank.toml\n  cotree check slider_crank.toml --drawing attempt.png\n  \
                  cotree check *.toml\n  cat slider_crank.toml | cotree check -"
)]
pub struct CheckCommand {
    /// Scene files (TOML or JSON); `-` is standard input
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Draw it into an SVG, PNG or TikZ (.tex) file; if it cannot be assembled as it is written, the configuration that was found, with gaps in red
    #[arg(long, value_name = "FILE")]
    drawing: Option<PathBuf>,
}

impl CheckCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::is_written_as(self.drawing.as_deref(), &["svg", "png", "tex"])?;
        let [scene] = &self.scenes[..] else { return self.run_each(format) };
        output::apart(&[Some(scene)], &[self.drawing.as_deref()])?;
        self.one(scene, format)
    }

    /// One scene after the other; the exit code is that of the first one that is wrong.
    fn run_each(&self, format: MessageFormat) -> Result<(), Failure> {
        if self.drawing.is_some() {
            return Err(Failure::Usage("--drawing is one file: give one scene".to_owned()));
        }
        let mut first = None;
        for scene in &self.scenes {
            match self.one(scene, format) {
                Ok(()) => {}
                Err(Failure::ClosedPipe) => return Err(Failure::ClosedPipe),
                Err(failure) => {
                    let code = failure.report(format);
                    first.get_or_insert(code);
                }
            }
        }
        first.map_or(Ok(()), |code| Err(Failure::Told(code)))
    }

    fn one(&self, path: &Path, format: MessageFormat) -> Result<(), Failure> {
        let scene = output::load(path)?;
        let (mut compiled, mut formulated) = match compile_with_equations(&scene) {
            Ok(made) => made,
            Err(faults) => {
                self.draw_attempt(&scene, format)?;
                return Err(faults.into());
            }
        };
        if let Some(path) = &self.drawing {
            output::picture(path, &draw(&mut formulated).svg(), "the drawing", format)?;
        }
        let (summary, mut assumptions) = (summarise(&formulated), assumptions(&mut formulated, &scene));
        let mechanism = &formulated.equations.system.mechanism;
        let mut modes: Vec<String> = at_start(&formulated).iter().map(|mode| mode.told(mechanism)).collect();
        modes.extend(wraps(&mut formulated));
        let contacts = contact::of_experiment(&scene);
        assumptions.extend(contacts.needed);
        assumptions.extend(contacts.unseen);
        compiled.warn(contacts.faults);
        let missing: Vec<Fault> = compiled.without_value_at_start().iter().map(|name| no_value(&scene, name)).collect();
        compiled.warn(missing);
        match format {
            MessageFormat::Human => {
                output::warn(compiled.warnings.as_ref(), format);
                output::print(&verdict(path, &summary, (&modes, &assumptions)))
            }
            MessageFormat::Json => output::print(&format!("{:#}\n", json(path, &compiled, (modes, assumptions)))),
        }
    }

    /// Draws what comes closest to a mechanism that cannot be assembled, or says that it does not.
    fn draw_attempt(&self, scene: &Scene, format: MessageFormat) -> Result<(), Failure> {
        let Some(path) = &self.drawing else { return Ok(()) };
        let Some(mut attempt) = scene.resolve().ok().and_then(|resolved| attempt(&resolved.mechanism)) else {
            say(&format!("`{}` is not written: with these errors there is no configuration to draw\n", path.display()));
            return Ok(());
        };
        let what = if attempt.is_closed {
            "the configuration that was found"
        } else {
            "the best attempt, with the gap in red"
        };
        output::picture(path, &draw_attempt(&mut attempt).svg(), what, format)
    }
}

/// How far ropes and bands lie around their pulleys at the start.
fn wraps(formulated: &mut Formulated) -> Vec<String> {
    let mechanism = formulated.equations.system.mechanism.clone();
    let mut lines = Vec::new();
    for part in mechanism.parts().filter(|part| part.course().is_some_and(|course| !course.over.is_empty())) {
        let wraps = formulated.equations.wraps(part.owner);
        let wraps = formulated.equations.system.arena.evaluate(&wraps, &formulated.state);
        let degrees = |wrap: &f64| format!("{} deg", short(wrap.to_degrees()));
        let wraps: Vec<String> = wraps.iter().map(degrees).collect();
        lines.push(format!("`{}` wraps its pulleys by {}", part.name, wraps.join(", ")));
    }
    lines
}

fn verdict(path: &Path, summary: &Summary, (modes, assumptions): (&[String], &[String])) -> String {
    let mut text = format!(
        "{}: no errors: {}, {}, mobility {}\n",
        path.display(),
        counted(summary.bodies.len(), "body"),
        counted(summary.joints.len(), "joint"),
        summary.mobility
    );
    if summary.mobility == 0 && summary.drivers.is_empty() {
        text += "  nothing can move: the joints leave 0 degrees of freedom\n";
    }
    for mode in modes {
        text += &format!("  {mode}\n");
    }
    for assumption in assumptions {
        text += &format!("  assumed: {assumption}\n");
    }
    text
}

fn json(path: &Path, compiled: &Compiled, (modes, assumptions): (Vec<String>, Vec<String>)) -> serde_json::Value {
    let mut json = compiled.warnings.as_ref().map_or_else(
        || serde_json::json!({ "file": path.display().to_string(), "faults": [], "omitted": 0 }),
        |warnings| warnings.to_json(),
    );
    json["assumptions"] = assumptions.into();
    if !modes.is_empty() {
        json["one_sided"] = modes.into();
    }
    json
}

fn no_value(scene: &Scene, name: &str) -> Fault {
    let message = format!("output `{name}` has no value at the start");
    Fault::warning("solver::no_value", message, output::output_span(scene, name)).help(Gaps::HELP)
}
