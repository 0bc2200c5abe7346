//! `cotree trace`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::compile::Compiled;
use cotree::component::Profile;
use cotree::diagnostic::suggest;
use cotree::model::{Dimension, Quantity, Unit, Units};
use cotree::run::RunError;
use cotree::scene::{Requested, Scene};
use cotree::typeset::{counted, titled};
use cotree_draw::dxf;
use cotree_page::film;

use super::failure::Failure;
use super::units::{InUnits, ShownUnits};
use super::{MessageFormat, output};

/// Trace the curves of points during the experiment, and cam profiles, as CSV or as DXF for CAD
///
/// A point is `body.point`, or `body` for its mass centre. The name of a cam's joint means its profile, in the cam's axes with the shaft
/// as origin.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree trace four_bar.toml coupler.tracer\n  cotree trace four_bar.toml coupler.tracer crank.pin -o curves.dxf\n  \
                  cotree trace cam_oscillating.toml cam -o profile.dxf"
)]
pub struct TraceCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// The points, or cams [default: the points of which the scene reports x and y]
    points: Vec<String>,
    #[command(flatten)]
    units: InUnits,
    /// Output file of the curves: CSV, or DXF in millimetres if the name ends with .dxf; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl TraceCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let file = output::file(self.output.as_deref());
        output::apart(&[Some(&self.scene)], &[file])?;
        output::is_table(file.filter(|path| !output::has_extension(path, "dxf")), " or `.dxf`")?;
        let scene = output::load(&self.scene)?;
        let shown = self.units.of(&scene)?;
        let mechanism = scene.resolve()?.mechanism;
        let cams = mechanism.profiles(&mechanism.parameter_values());
        let (cams, points) = self.requested(&scene, cams)?;
        let compiled = output::compile_asking(&scene, &Requested::these(variables(&points)), format)?;
        match file.filter(|path| output::has_extension(path, "dxf")) {
            Some(path) => curves(&compiled, (&points, &cams), path, format),
            None => match &cams[..] {
                [] => table(&compiled, &points, &shown, file, format),
                [cam] if points.is_empty() => profile_table(cam, &shown.units, file, format),
                _ => Err(Failure::Usage(
                    "a table has one cam or the points of a run; a drawing (.dxf) takes them together".to_owned(),
                )),
            },
        }
    }

    /// The cams and the points that are asked for, each once.
    fn requested(&self, scene: &Scene, cams: Vec<Profile>) -> Result<(Vec<Profile>, Vec<String>), Failure> {
        let (of_cams, points): (Vec<String>, Vec<String>) =
            self.points.iter().cloned().partition(|name| cams.iter().any(|cam| cam.name == **name));
        let cams: Vec<Profile> = cams.into_iter().filter(|cam| of_cams.contains(&cam.name)).collect();
        let points = if points.is_empty() && !cams.is_empty() { Vec::new() } else { self.points(scene, points)? };
        Ok((cams, points))
    }

    /// The points that are asked for, each once.
    fn points(&self, scene: &Scene, named: Vec<String>) -> Result<Vec<String>, Failure> {
        if scene.dimension == Dimension::One {
            return Err(Failure::Usage(
                "masses on a line do not trace curves; `cotree simulate` gives their motion".to_owned(),
            ));
        }
        let known: Vec<String> = (scene.bodies.iter())
            .flat_map(|body| {
                let name = &body.name.text;
                let points = body.entries("points").iter().map(move |(point, _)| format!("{name}.{}", point.text));
                std::iter::once(name.clone()).chain(points)
            })
            .collect();
        let requested = match named.is_empty() {
            true => film::points(scene).into_iter().map(str::to_owned).collect(),
            false => named,
        };
        if requested.is_empty() {
            let known = suggest::list(known.iter().map(String::as_str));
            return Err(Failure::Usage(format!("the scene reports x and y of no point; name the points: {known}")));
        }
        let mut points: Vec<String> = Vec::new();
        for point in requested {
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
    points.iter().flat_map(|point| [Quantity::X, Quantity::Y].map(|quantity| quantity.of(point)))
}

/// Time, then x and y of each point, SI.
type Sample = Vec<f64>;

/// The rows of a run, and what ended it early: what was worked out before is worth having.
fn rows(compiled: &Compiled, format: MessageFormat) -> Result<(Vec<Sample>, Result<(), Failure>), Failure> {
    let mut rows = Vec::new();
    let ended = compiled.run(|time, values| {
        rows.push([&[time], values].concat());
        Ok(())
    });
    let failure = match ended {
        Ok(finish) => {
            output::tell_end(compiled, &finish, format);
            Ok(())
        }
        Err(error @ RunError::Instance(_)) if !rows.is_empty() => {
            Err(Failure::from(error).with_note(&format!("the curves have the {} points before that", rows.len())))
        }
        Err(error) => return Err(error.into()),
    };
    Ok((rows, failure))
}

fn table(
    compiled: &Compiled,
    points: &[String],
    shown: &ShownUnits,
    file: Option<&Path>,
    format: MessageFormat,
) -> Result<(), Failure> {
    let columns = variables(points).map(|name| shown.column(&name, &Unit::length()));
    let columns = std::iter::once(shown.column("time", &Unit::time())).chain(columns);
    let mut writer = output::begin(file, columns)?;
    let (rows, failure) = rows(compiled, format)?;
    rows.iter().try_for_each(|row| writer.row(row))?;
    output::finish(writer, file)?;
    wrote(file, &format!("{} of {}", counted(rows.len(), "row"), suggest::list(points)), format);
    failure
}

/// A profile with the curve of the follower's point, for each half degree of the cam's angle.
fn profile_table(cam: &Profile, units: &Units, file: Option<&Path>, format: MessageFormat) -> Result<(), Failure> {
    let [metre, radian] = [Unit::length(), Unit::angle()].map(|unit| units.of(&unit));
    let place = |axis| (titled(&format!("{}.{axis}", cam.name), &metre.name), metre.factor);
    let places = ["x", "y", "pitch_x", "pitch_y"].map(place);
    let columns = std::iter::once((titled("angle", &radian.name), radian.factor)).chain(places);
    let mut writer = output::begin(file, columns)?;
    for sample in cam.samples(PROFILE) {
        let [[x, y], [pitch_x, pitch_y]] = [sample.contact, sample.point].map(|at| from_shaft(cam, at));
        writer.row(&[sample.angle, x, y, pitch_x, pitch_y])?;
    }
    output::finish(writer, file)?;
    wrote(file, &format!("the profile of cam `{}`", cam.name), format);
    Ok(())
}

/// What is on standard output tells of itself.
fn wrote(file: Option<&Path>, what: &str, format: MessageFormat) {
    if let Some(file) = file {
        output::wrote(file, what, format);
    }
}

/// Points of a profile.
const PROFILE: usize = 720;

fn from_shaft(cam: &Profile, [x, y]: [f64; 2]) -> [f64; 2] {
    [x - cam.hub[0], y - cam.hub[1]]
}

/// A profile as a curve that closes.
fn outline(cam: &Profile) -> (String, Vec<[f64; 2]>) {
    let mut curve: Vec<[f64; 2]> = cam.samples(PROFILE).iter().map(|sample| from_shaft(cam, sample.contact)).collect();
    curve.extend(curve.first().copied());
    (cam.name.clone(), curve)
}

fn curves(
    compiled: &Compiled,
    (points, cams): (&[String], &[Profile]),
    path: &Path,
    format: MessageFormat,
) -> Result<(), Failure> {
    if points.is_empty() {
        output::write(path, dxf::curves(&cams.iter().map(outline).collect::<Vec<_>>()))?;
        output::wrote(path, &drawn(points, cams), format);
        return Ok(());
    }
    let (rows, failure) = rows(compiled, format)?;
    let curve = |(index, point): (usize, &String)| {
        (point.clone(), rows.iter().map(|row| [row[2 * index + 1], row[2 * index + 2]]).collect())
    };
    let curves: Vec<(String, Vec<[f64; 2]>)> =
        points.iter().enumerate().map(curve).chain(cams.iter().map(outline)).collect();
    output::write(path, dxf::curves(&curves))?;
    output::wrote(path, &drawn(points, cams), format);
    failure
}

fn drawn(points: &[String], cams: &[Profile]) -> String {
    let names = points.iter().map(String::as_str).chain(cams.iter().map(|cam| &*cam.name));
    format!("the curves of {}", suggest::list(names))
}
