//! `cotree show`

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::failure::Failure;
use super::{MessageFormat, output};
use crate::pipeline::{self, Notation};

/// Show a mechanism: its parts, degrees of freedom, coordinates, equations, and a drawing
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree show slider_crank.toml\n  cotree show slider_crank.toml --equations text\n  \
                  cotree show slider_crank.toml --drawing slider_crank.svg"
)]
pub struct Show {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// The summary as JSON, for scripts
    #[arg(long, conflicts_with = "equations")]
    json: bool,
    /// The equations of motion instead of the summary
    #[arg(long, value_name = "NOTATION")]
    equations: Option<EquationsAs>,
    /// Draw the mechanism at its start, as an SVG file
    #[arg(long, value_name = "FILE")]
    drawing: Option<PathBuf>,
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

impl Show {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        if let Some(notation) = self.equations {
            let notation = match notation {
                EquationsAs::Text => Notation::Text,
                EquationsAs::Latex => Notation::Latex,
                EquationsAs::Html => Notation::Html,
                EquationsAs::C => Notation::C,
                EquationsAs::Fortran => Notation::Fortran,
                EquationsAs::Rust => Notation::Rust,
                EquationsAs::Python => Notation::Python,
                EquationsAs::Json => Notation::Json,
            };
            output::print(&pipeline::equations(&output::load(&self.scene)?, notation)?)?;
        }
        if self.equations.is_some() && self.drawing.is_none() {
            return Ok(());
        }
        let compiled = output::compile(&self.scene, format)?;
        if let Some(path) = &self.drawing {
            output::write(path, &compiled.drawing.svg())?;
        }
        if self.equations.is_some() {
            return Ok(());
        }
        match self.json {
            true => {
                let json = serde_json::to_string_pretty(&compiled.summary).map_err(std::io::Error::from)?;
                output::print(&format!("{json}\n"))
            }
            false => output::print(&compiled.summary.to_string()),
        }
    }
}
