//! `cotree trace`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use cotree_fmu::model::Model;

use super::MessageFormat;
use super::failure::Failure;
use super::output::{self, Output};
use crate::compile::{self, Compiled};
use crate::diagnostic::suggest;
use crate::mechanism::Dimension;
use crate::output::csv::Writer;
use crate::output::dxf;
use crate::scene::{Scene, Text};
use crate::simulate::{Run, RunError};

/// Trace points: the curves that they draw during the experiment, as CSV, or as DXF for CAD
///
/// A point is `body.point`, or `body` for its mass centre.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree trace four_bar.toml coupler.tracer\n  cotree trace four_bar.toml coupler.tracer crank.pin -o curves.dxf"
)]
pub struct Trace {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// The points [default: those of which the scene reports x and y]
    points: Vec<String>,
    /// Where the curves go: CSV in metres, or DXF in millimetres if the name ends with .dxf; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Trace {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let file = output::file(self.output.as_deref());
        output::apart(&[Some(&self.scene)], &[file])?;
        let mut scene = output::load(&self.scene)?;
        let points = self.points(&scene)?;
        scene.outputs.variables = variables(&points).map(|name| Text::from(name.as_str())).collect();
        scene.outputs.expressions.clear();
        let compiled = compile::compile(&scene)?;
        output::warn_of(&compiled, format);
        match file.filter(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dxf"))) {
            Some(path) => curves(&compiled, &points, path),
            None => table(&compiled, &points, file),
        }
    }

    /// The points that are asked for, each once.
    fn points(&self, scene: &Scene) -> Result<Vec<String>, Failure> {
        if scene.dimension == Dimension::One {
            return Err(Failure::Usage(
                "masses on a line draw no curves; `cotree simulate` gives their motion".to_owned(),
            ));
        }
        let known: Vec<String> = (scene.bodies.iter())
            .flat_map(|body| {
                let name = &body.name.text;
                let points = body.entries("points").iter().map(move |(point, _)| format!("{name}.{}", point.text));
                std::iter::once(name.clone()).chain(points)
            })
            .collect();
        let asked = match &self.points[..] {
            [] => compile::film::points(scene).into_iter().map(str::to_owned).collect(),
            points => points.to_vec(),
        };
        if asked.is_empty() {
            let known = suggest::list(known.iter().map(String::as_str));
            return Err(Failure::Usage(format!("the scene does not report x and y of a point; name points: {known}")));
        }
        let mut points: Vec<String> = Vec::new();
        for point in asked {
            if !known.contains(&point) {
                let known = suggest::known(&point, known.iter().map(String::as_str));
                return Err(Failure::Usage(format!("the scene has no point `{point}`; {known}")));
            }
            if !points.contains(&point) {
                points.push(point);
            }
        }
        Ok(points)
    }
}

/// Both coordinates of each point.
fn variables(points: &[String]) -> impl Iterator<Item = String> {
    points.iter().flat_map(|point| ["x", "y"].map(|axis| format!("{point}.{axis}")))
}

fn run(
    compiled: &Compiled,
    points: &[String],
    report: impl FnMut(f64, &[f64]) -> std::io::Result<()>,
) -> Result<(), RunError> {
    let description = &compiled.description;
    let model = Model::new(compiled.program.clone())?;
    let place = |name: String| description.variables.iter().position(|variable| variable.name == name);
    let reported = variables(points).filter_map(place).collect();
    let run = Run { description, experiment: description.experiment, settings: Vec::new(), inputs: None, reported };
    run.start(Arc::new(model), report).map(drop)
}

fn table(compiled: &Compiled, points: &[String], file: Option<&Path>) -> Result<(), Failure> {
    let columns: Vec<String> = variables(points).collect();
    let mut writer = Writer::new(Output::new(file)?, columns.iter().map(String::as_str))?;
    let mut rows = 0;
    let ended = run(compiled, points, |time, values| {
        rows += 1;
        writer.row(time, values)
    });
    let failure = part(ended, rows)?;
    let named = |error| match file {
        Some(path) => Failure::file("write", path, error),
        None => Failure::from(error),
    };
    writer.finish().map_err(named)?.commit().map_err(named)?;
    failure.map_or(Ok(()), Err)
}

fn curves(compiled: &Compiled, points: &[String], path: &Path) -> Result<(), Failure> {
    let mut curves: Vec<(String, Vec<[f64; 2]>)> = points.iter().map(|point| (point.clone(), Vec::new())).collect();
    let mut rows = 0;
    let ended = run(compiled, points, |_, values| {
        rows += 1;
        curves.iter_mut().zip(values.chunks(2)).for_each(|((_, curve), at)| curve.push([at[0], at[1]]));
        Ok(())
    });
    let failure = part(ended, rows)?;
    output::write(path, &dxf::curves(&curves))?;
    failure.map_or(Ok(()), Err)
}

/// What was worked out before the solver gave up is worth having: the failure is reported after it.
fn part(ended: Result<(), RunError>, rows: u64) -> Result<Option<Failure>, Failure> {
    match ended {
        Ok(()) => Ok(None),
        Err(error @ RunError::Instance(_)) if rows > 0 => {
            Ok(Some(Failure::from(error).with_note(&format!("the curves have the {rows} points before that"))))
        }
        Err(error) => Err(error.into()),
    }
}
