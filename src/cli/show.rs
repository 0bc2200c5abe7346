//! `cotree show`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::failure::Failure;
use super::{MessageFormat, output};
use crate::pipeline::{self, Notation};
use crate::print::Prose;
use crate::report::compare::Comparison;
use crate::report::summary::Summary;
use crate::scene::Scene;

/// Show a mechanism: its parts, degrees of freedom, coordinates, equations, graphs, and a drawing
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree show slider_crank.toml\n  cotree show slider_crank.toml --equations text\n  \
                  cotree show slider_crank.toml --steps html > slider_crank.html\n  \
                  cotree show slider_crank.toml --compare\n  \
                  cotree show slider_crank.toml --drawing slider_crank.svg --graph graphs.svg"
)]
pub struct Show {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// The summary (and comparison) as JSON, for scripts
    #[arg(long, conflicts_with_all = ["equations", "steps"])]
    json: bool,
    /// The equations of motion instead of the summary
    #[arg(long, value_name = "NOTATION")]
    equations: Option<EquationsAs>,
    /// How the equations are derived, step by step, instead of the summary
    #[arg(long, value_name = "NOTATION", num_args = 0..=1, default_missing_value = "text", conflicts_with = "equations")]
    steps: Option<StepsAs>,
    /// What other choices of trees would cost: equations, operations, time, condition
    #[arg(long, conflicts_with_all = ["equations", "steps"])]
    compare: bool,
    /// Draw the mechanism at its start, as an SVG file
    #[arg(long, value_name = "FILE")]
    drawing: Option<PathBuf>,
    /// Draw the mechanism and its two linear graphs: an SVG file, or Graphviz if the name ends with .dot
    #[arg(long, value_name = "FILE")]
    graph: Option<PathBuf>,
}

/// What `--json` says.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
}

/// How equations are written.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum EquationsAs {
    /// For people
    Text,
    /// A LaTeX document
    Latex,
    /// A self-contained HTML page
    Html,
    /// C99 source
    C,
    /// Fortran 2008 source
    Fortran,
    /// Rust source
    Rust,
    /// Python source, for numpy
    Python,
    /// Names, and formulas as text and as trees, for other programs
    Json,
}

/// How the derivation is written.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum StepsAs {
    /// For people
    Text,
    /// A LaTeX document
    Latex,
    /// A self-contained HTML page
    Html,
}

impl Show {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(&[Some(&self.scene)], &[self.graph.as_deref(), self.drawing.as_deref()])?;
        for (path, kinds) in [(&self.drawing, ["svg"].as_slice()), (&self.graph, &["svg", "dot"])] {
            path.as_deref().map_or(Ok(()), |path| is_of(path, kinds))?;
        }
        let printed = match (self.equations, self.steps) {
            (Some(notation), _) => Some(pipeline::equations(&output::load(&self.scene)?, notation.into())?),
            (None, Some(prose)) => Some(pipeline::steps(&output::load(&self.scene)?, prose.into())?),
            (None, None) => None,
        };
        if let Some(text) = &printed {
            output::print(text)?;
        }
        if let Some(path) = &self.graph {
            graph(&output::load(&self.scene)?, path)?;
        }
        if printed.is_some() && self.drawing.is_none() {
            return Ok(());
        }
        let compiled = output::compile(&self.scene, format)?;
        if let Some(path) = &self.drawing {
            output::write(path, &compiled.drawing.svg())?;
        }
        if printed.is_some() {
            return Ok(());
        }
        let comparison = self.compare.then(|| pipeline::comparison(&output::load(&self.scene)?).map_err(Failure::from));
        let comparison = comparison.transpose()?;
        if self.json {
            let report = Report { summary: &compiled.summary, comparison };
            let json = serde_json::to_string_pretty(&report).map_err(std::io::Error::from)?;
            return output::print(&format!("{json}\n"));
        }
        match comparison {
            Some(comparison) => output::print(&comparison.to_string()),
            None => output::print(&compiled.summary.to_string()),
        }
    }
}

/// Pictures are written in the format that the end of the name says, never in another.
fn is_of(path: &Path, kinds: &[&str]) -> Result<(), Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    if kinds.iter().any(|kind| extension.eq_ignore_ascii_case(kind)) {
        return Ok(());
    }
    let names: Vec<String> = kinds.iter().map(|kind| format!("`.{kind}`")).collect();
    let name = path.display();
    Err(Failure::Usage(format!("cannot write `{name}`: the name of the picture must end with {}", names.join(" or "))))
}

fn graph(scene: &Scene, path: &Path) -> Result<(), Failure> {
    let (graphs, drawing) = pipeline::graph(scene)?;
    let is_dot = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dot"));
    output::write(path, &if is_dot { graphs.dot() } else { graphs.svg(&drawing) })
}

impl From<EquationsAs> for Notation {
    fn from(notation: EquationsAs) -> Self {
        match notation {
            EquationsAs::Text => Notation::Text,
            EquationsAs::Latex => Notation::Latex,
            EquationsAs::Html => Notation::Html,
            EquationsAs::C => Notation::C,
            EquationsAs::Fortran => Notation::Fortran,
            EquationsAs::Rust => Notation::Rust,
            EquationsAs::Python => Notation::Python,
            EquationsAs::Json => Notation::Json,
        }
    }
}

impl From<StepsAs> for Prose {
    fn from(prose: StepsAs) -> Self {
        match prose {
            StepsAs::Text => Prose::Text,
            StepsAs::Latex => Prose::Latex,
            StepsAs::Html => Prose::Html,
        }
    }
}
