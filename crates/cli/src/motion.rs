//! `cotree motion`

use std::path::PathBuf;

use clap::Args;
use cotree::compile;
use cotree::model::{Unit, Units};
use cotree::scene::Scene;
use cotree_study::motion::{self, Deviation, Figures, MotionError, MotionRequest};
use serde::Serialize;

use super::failure::Failure;
use super::units::{self, InUnits};
use super::{MessageFormat, output, study};

/// Analyse one turn or stroke of an input: range, limits, transmission angle, drive torque, reactions, shaking forces
///
/// The input moves at constant speed, which the first line reports; with --speed 0 forces are static. Without masses forces are those of the loads. The transmission angle is 90 degrees minus the angle between the
/// static force that a load on the output makes at a joint and the path of that joint; the joint-force index is the largest joint force for a
/// unit load. The shaking moment is about the input joint.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree motion crank_rocker.toml --input O2 --output O4 --speed \"20 rad/s\" --every \"60 deg\"\n  \
                  cotree motion press.toml --plot press.png -o press.csv\n  \
                  cotree motion excavator.toml --input cylinder --range \"0 mm..400 mm\" --json\n  \
                  cotree motion four_bar.toml --point coupler.tracer --fluctuation 0.02\n  \
                  cotree motion four_bar.toml --tolerance length=0.1mm --tolerance pivot=0.05mm"
)]
pub struct MotionCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// The driven joint, or its driver; `pin.s` or `pin.angle` if it both slides and turns [default: the joint with a driver]
    #[arg(long, value_name = "JOINT")]
    input: Option<String>,
    /// The output motion: a joint on the ground, a variable such as `table.y`, or an output of the scene [default: the first other joint that can move]
    #[arg(id = "of_interest", long = "output", value_name = "NAME")]
    of_interest: Option<String>,
    /// Speed of the input, such as "20 rad/s" or "300 rpm"; 0 for static forces [default: the speed at the start of the scene, or 1 rad/s, or 1 m/s]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Option<String>,
    /// Range of the input, such as "-30..60 deg", or backwards "60..-30 deg" [default: one turn, or as far as it can move in both directions]
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    range: Option<String>,
    /// Step of the input between rows of the printed table, such as "30 deg": from the start of --range on, else at its multiples [default: a twelfth of a turn or of the range]
    #[arg(long, value_name = "STEP", allow_hyphen_values = true)]
    every: Option<String>,
    /// A coupler point whose path is analysed: length, area, inflections, cusps, crossings
    #[arg(long, value_name = "POINT")]
    point: Option<String>,
    /// Tolerance of a dwell, such as "0.5 mm": report for how much of the input the output stays that close to an end of its stroke
    #[arg(long, value_name = "TOLERANCE")]
    dwell: Option<String>,
    /// Permitted coefficient of fluctuation of the speed, such as 0.02: report the flywheel for it
    #[arg(long, value_name = "NUMBER")]
    fluctuation: Option<f64>,
    /// Report the effect of deviations on the output and on --point, with the input held: `length=0.1mm` of the distances between joints of bodies, `pivot=0.1mm` of each coordinate of joints on the ground, or a parameter, such as `rod_length=0.2mm`; may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = Deviation::read)]
    tolerance: Vec<Deviation>,
    #[command(flatten)]
    units: InUnits,
    /// Set a parameter or an input, such as rod_length="1.2 m"; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Print everything as JSON, in SI units, with all samples
    #[arg(long)]
    json: bool,
    /// The whole table as CSV
    #[arg(short = 'o', long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Draw the table: an SVG or a PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

impl MotionCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        output::apart(&[Some(&self.scene)], &[self.table.as_deref(), self.plot.as_deref()])?;
        output::is_written_as(self.plot.as_deref(), &["svg", "png"])?;
        output::is_table(output::file(self.table.as_deref()), "; with --json everything is printed as JSON")?;
        let scene = output::load(&self.scene)?;
        let set = study::with_settings(&scene, &self.settings)?;
        let units = self.units(&scene)?;
        let request = MotionRequest { units: units.clone(), ..self.request(&scene)? };
        let figures = motion::study_of(&scene, set.mechanism(), &request)?;
        let report = figures.report();
        let deviating = match &self.tolerance[..] {
            [] => None,
            own => Some(motion::tolerances(&scene, set.mechanism(), &request, own)?.report()),
        };
        if let Some(path) = &self.table {
            output::write(path, report.csv(&units))?;
            output::wrote(path, &format!("{} rows", report.sheet.rows.len()), format);
        }
        if let Some(path) = &self.plot {
            output::picture(
                path,
                &cotree_draw::study::motion::plot(&figures, &units).svg(),
                "the table as curves",
                format,
            )?;
        }
        match (self.json, deviating) {
            (true, None) => output::json(&figures)?,
            (true, Some(found)) => output::json(&WithTolerances { figures: &figures, tolerances: found.data })?,
            (false, found) => {
                output::print(&report.text(&units))?;
                if let Some(found) = found {
                    output::print(&format!("\n{}", found.text(&units)))?;
                }
            }
        }
        match &figures.too_close(&units)[..] {
            [] => Ok(()),
            close => Err(Failure::Limit(close.join("\nerror: "))),
        }
    }

    fn request(&self, scene: &Scene) -> Result<MotionRequest, Failure> {
        let wrong = |option: &str, message: String| Failure::Usage(format!("--{option}: {message}"));
        let names =
            MotionRequest { input: self.input.clone(), output: self.of_interest.clone(), ..MotionRequest::default() };
        let [input, output] = motion::units(scene, &names)?;
        let number = |option: &str, text: &str, unit: &Unit| {
            compile::quantity(text, unit).map_err(|error| wrong(option, error.to_string()))
        };
        let range = match self.range.as_deref().map(|range| range.split_once("..").ok_or(range)) {
            None => None,
            Some(Ok((from, to))) => {
                let both = compile::both(from, to, &input).map_err(|error| wrong("range", error.to_string()))?;
                Some(both)
            }
            Some(Err(range)) => return Err(wrong("range", format!("write `from..to`, not `{range}`"))),
        };
        if self.fluctuation.is_some_and(|share| !(share > 0.0 && share < 2.0)) {
            return Err(wrong("fluctuation", "must be between 0 and 2".to_owned()));
        }
        let dwell = self.dwell.as_deref().map(|near| number("dwell", near, &output)).transpose()?;
        if dwell.is_some_and(|near| !(near > 0.0 && near.is_finite())) {
            return Err(wrong("dwell", "must be positive".to_owned()));
        }
        let speed = self.speed.as_deref().map(|speed| number("speed", speed, &input.per_second())).transpose()?;
        let every = self.every.as_deref().map(|every| number("every", every, &input)).transpose()?;
        Ok(MotionRequest {
            speed,
            range,
            every,
            point: self.point.clone(),
            dwell,
            fluctuation: self.fluctuation,
            ..names
        })
    }

    /// Those of the command line, of the scene, and then those that people think of mechanisms in.
    fn units(&self, scene: &Scene) -> Result<Units, Failure> {
        self.units.before(&units::display(scene)?.before(&motion::usual()))
    }
}

/// The figures, and what deviations do.
#[derive(Serialize)]
struct WithTolerances<'a> {
    #[serde(flatten)]
    figures: &'a Figures,
    tolerances: serde_json::Value,
}

impl From<MotionError> for Failure {
    fn from(error: MotionError) -> Self {
        match error {
            MotionError::Scene(faults) => Failure::Scene(faults),
            MotionError::Request(message) => Failure::Usage(message),
            MotionError::Run(error) => error.into(),
        }
    }
}
