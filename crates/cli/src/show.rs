//! `cotree show`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::compile;
use cotree::diagnostic::{Fault, Faults};
use cotree::formulate::Formulated;
use cotree::model::Units;
use cotree::report::figures::summarise;
use cotree::report::summary::Summary;
use cotree::scene::Scene;
use cotree_draw::graph::GraphDrawing;
use cotree_draw::pose::{draw, draw_at};
use cotree_study::analysis::state_at;
use cotree_study::compare::{CoordinateComparison, compare};
use cotree_text::Prose;
use cotree_text::SymbolNotation;
use cotree_text::written;
use cotree_text::written::EquationFormat;
use serde::Serialize;

use super::failure::Failure;
use super::words::one_of;
use super::{MessageFormat, output, study};

/// Show a mechanism: its parts, degrees of freedom, coordinates, equations, graphs, and a drawing
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree show slider_crank.toml\n  cotree show slider_crank.toml --equations text\n  \
                  cotree show slider_crank.toml --equations text --symbols --minimal\n  \
                  cotree show slider_crank.toml --steps html > slider_crank.html\n  \
                  cotree show slider_crank.toml --compare\n  \
                  cotree show slider_crank.toml --drawing slider_crank.svg --graph graphs.svg\n  \
                  cotree show slider_crank.toml --drawing pose.png --at \"0.3 s\""
)]
pub struct ShowCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Print the summary (and comparison) as JSON, for scripts
    #[arg(long, conflicts_with_all = ["equations", "steps"])]
    json: bool,
    /// Print the equations of motion instead of the summary
    #[arg(long, value_name = "NOTATION", value_parser = one_of(&EquationFormat::WORDS))]
    equations: Option<EquationFormat>,
    /// With --equations: use symbols such as m_rod and g for numbers, and add a table of their values
    #[arg(long, requires = "equations")]
    symbols: bool,
    /// With --equations: in independent coordinates, with one equation per degree of freedom
    #[arg(long, requires = "equations")]
    minimal: bool,
    /// Print the derivation of the equations, step by step, instead of the summary
    #[arg(long, value_name = "NOTATION", num_args = 0..=1, default_missing_value = "text", conflicts_with = "equations", value_parser = one_of(&Prose::WORDS))]
    steps: Option<Prose>,
    /// Compare the choices of trees: equations, operations, time, condition number
    #[arg(long, conflicts_with_all = ["equations", "steps"])]
    compare: bool,
    /// Draw the mechanism at its start: an SVG, PNG or DXF file, or TikZ for LaTeX if the name ends with .tex
    #[arg(long, value_name = "FILE")]
    drawing: Option<PathBuf>,
    /// Draw it at this time of its motion instead, such as "0.3 s"
    #[arg(long, value_name = "TIME", requires = "drawing", allow_hyphen_values = true)]
    at: Option<String>,
    /// Draw the mechanism and its two linear graphs: an SVG or a PNG file, TikZ if the name ends with .tex, or Graphviz if with .dot
    #[arg(long, value_name = "FILE")]
    graph: Option<PathBuf>,
}

/// What `--json` says.
#[derive(Serialize)]
struct SummaryAndComparison {
    #[serde(flatten)]
    summary: Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<CoordinateComparison>,
}

impl ShowCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(&[Some(&self.scene)], &[self.graph.as_deref(), self.drawing.as_deref()])?;
        let [drawing, graph] = [["svg", "png", "tex", "dxf"], ["svg", "png", "tex", "dot"]];
        for (path, kinds) in [(&self.drawing, drawing), (&self.graph, graph)] {
            output::is_written_as(path.as_deref(), &kinds)?;
        }
        let scene = output::load(&self.scene)?;
        let (compiled, mut formulated) = compile::compile_with_equations(&scene)?;
        let shown = self.shown(&scene, &mut formulated)?;
        if let Some(text) = &shown.text {
            output::print(text)?;
        }
        for (path, picture, what) in
            [(&self.graph, &shown.graph, "the linear graphs"), (&self.drawing, &shown.drawing, "the drawing")]
        {
            let Some((path, picture)) = path.as_ref().zip(picture.as_ref()) else { continue };
            output::picture(path, picture, what, format)?;
        }
        if shown.text.is_none() || shown.drawing.is_some() {
            output::warn(compiled.warnings.as_ref(), format);
        }
        shown.figures.map_or(Ok(()), |figures| figures.print(self.json))
    }

    /// Everything that is asked for, of one set of equations.
    fn shown(&self, scene: &Scene, formulated: &mut Formulated) -> Result<ShownMechanism, Failure> {
        let faults = |list: Vec<Fault>| Faults::new(scene.source.clone(), list);
        let text = match (self.equations, self.steps) {
            (Some(notation), _) if self.minimal => {
                let written = prose(notation, "--minimal")?;
                let reduced = written::reduced(formulated, written, self.symbols).map_err(faults)?;
                Some(reduced.map_err(|why| Failure::Numerical(format!("there are no reduced equations: {why}")))?)
            }
            (Some(notation), _) if self.symbols => {
                Some(written::named(formulated, prose(notation, "--symbols")?).map_err(faults)?)
            }
            (Some(notation), _) => Some(written::written(formulated, notation).map_err(faults)?),
            (None, Some(prose)) => Some(written::derived(formulated, prose).map_err(faults)?),
            (None, None) => None,
        };
        let graph = self.graph.as_deref().map(|path| graph(formulated, path));
        let drawing = self.drawing.as_deref().map(|path| self.drawn(formulated, path)).transpose()?;
        let figures = text.is_none().then(|| SummaryAndComparison {
            summary: summarise(formulated),
            comparison: self.compare.then(|| compare(&formulated.equations.system.mechanism, &formulated.outputs)),
        });
        Ok(ShownMechanism { text, graph, drawing, figures })
    }

    /// The drawing at the start or at another time: for CAD, or as a picture.
    fn drawn(&self, formulated: &mut Formulated, path: &Path) -> Result<String, Failure> {
        let drawing = match &self.at {
            Some(text) => {
                let time = study::time("at", text, formulated.lowered.program.experiment.start)?;
                let state = state_at(formulated, time).map_err(|error| Failure::Numerical(error.to_string()))?;
                draw_at(formulated, &state)
            }
            None => draw(formulated),
        };
        Ok(if output::has_extension(path, "dxf") { drawing.dxf() } else { drawing.svg() })
    }
}

/// How equations for people and for other programs are written; `option` is not for code.
fn prose(notation: EquationFormat, option: &str) -> Result<SymbolNotation, Failure> {
    match notation {
        EquationFormat::Text => Ok(SymbolNotation::Prose(Prose::Text)),
        EquationFormat::Latex => Ok(SymbolNotation::Prose(Prose::Latex)),
        EquationFormat::Html => Ok(SymbolNotation::Prose(Prose::Html)),
        EquationFormat::Json => Ok(SymbolNotation::Json),
        EquationFormat::C | EquationFormat::Fortran | EquationFormat::Rust | EquationFormat::Python => {
            Err(Failure::Usage(format!(
                "`{option}` is for text, latex, html and json: generated code uses all coordinates and exact numbers"
            )))
        }
    }
}

/// What is shown of a mechanism.
struct ShownMechanism {
    text: Option<String>,
    graph: Option<String>,
    drawing: Option<String>,
    figures: Option<SummaryAndComparison>,
}

impl SummaryAndComparison {
    fn print(&self, as_json: bool) -> Result<(), Failure> {
        if as_json {
            return output::json(self);
        }
        match &self.comparison {
            Some(comparison) => output::print(&comparison.report().text(&Units::default())),
            None => output::print(&self.summary.to_string()),
        }
    }
}

fn graph(formulated: &mut Formulated, path: &Path) -> String {
    let graphs = GraphDrawing::new(formulated);
    if output::has_extension(path, "dot") { graphs.dot() } else { graphs.svg(&draw(formulated)) }
}
