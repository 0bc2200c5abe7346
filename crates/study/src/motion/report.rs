//! The quantities of a motion in sentences and as a table.

use cotree::line;
use cotree::mechanism::{Unit, Units};
use cotree::output::report::Accuracy::Noise;
use cotree::output::report::{Cell, Report, Table, named, number, per, plain};

use super::cams::Cam;
use super::curve::Arc;
use super::figures::{Column, Extent, Figures, Transmission};
use super::samples::At;

/// Below this the transmission is poor, by a rule of thumb (Norton) \[rad\].
const POOR: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Characters of a line beside the input: with it what a terminal shows.
const WIDTH: usize = 84;
/// Values below this share of the largest in their unit are errors of zero: a hundred tolerances of the run.
const NOISE: f64 = 1e-10;
/// And places of extremes, which are known to about the root of rounding errors only.
const PLACE: f64 = 1e-7;

/// What there is to say of a cam, by its own angle.
fn cam_lines(cam: &Cam) -> Vec<Cell> {
    let at = |at: &At, unit: &str| line![number(at.value, unit), " at ", number(at.input, "rad")];
    let unit = if cam.turning { "rad" } else { "m" };
    let base = number(cam.base, "m");
    let mut lines =
        vec![line!["cam `", cam.name, "` with ", cam.follower, ", base circle ", base, ", by the cam's angle:"]];
    for phase in &cam.phases {
        let word = if phase.rise > 0.0 { "  rises " } else { "  returns " };
        let [from, to] = [phase.from, phase.to].map(|angle| number(angle, "rad"));
        let [velocity, acceleration, jerk] = phase.peaks.map(|peak| plain(peak, 0.0));
        let way = line![word, number(phase.rise.abs(), unit), " from ", from, " to ", to];
        lines.push(line![way, ": peaks ", velocity, " h/beta, ", acceleration, " h/beta^2, ", jerk, " h/beta^3"]);
    }
    lines.push(line!["  pressure angle up to ", at(&cam.pressure_angle, "rad")]);
    for (what, radius) in [
        ("radius of the pitch curve", &cam.pitch_radius),
        ("convex radius of the profile", &cam.convex_radius),
        ("hollow radius of the profile", &cam.hollow_radius),
    ] {
        lines.extend(radius.iter().map(|own| line!["  smallest ", what, " ", at(own, "m")]));
    }
    if let Some(ends) = &cam.face {
        let [low, high] = ends.each_ref().map(|end| at(end, "m"));
        lines.push(line!["  touches its face from ", low, " to ", high, " from the follower's point"]);
    }
    if cam.undercut {
        let needed = cam.least_base.map_or_else(
            || "no larger base circle helps".into(),
            |base| line!["the base circle must be at least ", number(base, "m")],
        );
        lines.push(line!["  UNDERCUT: ", needed]);
    }
    lines
}

/// Parts with something between them.
fn joined(parts: impl IntoIterator<Item = Cell>, between: &str) -> Cell {
    let parts = parts.into_iter().enumerate();
    Cell::Line(parts.flat_map(|(index, part)| [if index == 0 { "" } else { between }.into(), part]).collect())
}

impl Figures {
    /// Of the table for people a row every so much of the input, or a twelfth of its way; as many columns side by side as can be read.
    pub fn report(&self, every: Option<f64>) -> Report {
        let mut title = vec![self.kind()];
        let way = "` backwards; the figures are those of the way forwards, at the same speed";
        title.extend(self.reversed.then(|| line!["the scene moves `", self.input.name, way]));
        title.extend(self.output_lines());
        title.extend(self.transmission.iter().map(|angle| self.transmission_line(angle)));
        if let (Some(index), Some(output)) = (&self.joint_force_index, &self.output) {
            let most = number(index.value, &per("N", if output.angular { "N.m" } else { "N" }));
            title.push(line!["joint-force index up to ", most.within(Noise(0.0)), " at ", self.at(index)]);
        }
        title.extend(self.cams.iter().flat_map(cam_lines));
        title.extend(self.contacts.iter().map(Cell::from));
        title.extend(self.dynamics());
        title.extend(self.path_lines());
        let inputs = self.table.first().map_or(&[][..], |column| &column.values);
        let way = |last: Option<&f64>| last.zip(inputs.first()).map_or(1.0, |(last, first)| (last - first).abs());
        let every = every.unwrap_or_else(|| way(inputs.last()) / 12.0);
        let thinned = self.rows(((every / way(inputs.get(1))).round() as usize).max(1), told);
        Report {
            title,
            tables: vec![Table { width: Some(WIDTH), left: 0, ..thinned }],
            sheet: self.rows(1, |value, column| number(value, &column.unit)),
            noise: NOISE,
            ..Report::default()
        }
    }

    /// One of so many rows of the table.
    fn rows(&self, every: usize, cell: impl Fn(f64, &Column) -> Cell) -> Table {
        let inputs = self.table.first().map_or(0, |column| column.values.len());
        let row = |row: usize| self.table.iter().map(|column| cell(column.values[row], column)).collect();
        let columns = self.table.iter().map(|column| named(&column.name, &column.unit)).collect();
        Table::new(columns, (0..inputs).step_by(every).map(row))
    }

    fn kind(&self) -> Cell {
        let class = self.four_bar.as_ref().map_or(String::new(), |class| format!("{class}; "));
        let input = &self.input.name;
        let motion = match self.range {
            Some([low, high]) => {
                let [low, high] = [low, high].map(|end| number(end, &self.input.unit));
                let ends = if self.dead_points { ", dead points at both ends for this input" } else { "" };
                line![" moves from ", low, " to ", high, ends]
            }
            None if self.change_points => {
                " turns fully, through poses in which branches of the motion cross (change points)".into()
            }
            None if self.full_turn => " turns fully, with no dead point for this input".into(),
            None => " turns fully, but the mechanism is not as before after one turn".into(),
        };
        line![self.name, ": ", class, "`", input, "`", motion]
    }

    fn at(&self, at: &At) -> Cell {
        let reach = self.table.first().map_or(&[][..], |column| &column.values);
        let reach = reach.iter().fold(0.0, |reach: f64, input| reach.max(input.abs()));
        number(at.input, &self.input.unit).within(Noise(PLACE * reach))
    }

    fn output_lines(&self) -> Vec<Cell> {
        let Some(output) = &self.output else { return Vec::new() };
        let (name, unit) = (line!["`", output.name, "`"], &*output.unit);
        let mut lines = Vec::new();
        if let Some(stroke) = self.stroke {
            let word = match unit {
                "rad" => ": swing ",
                "m" => ": stroke ",
                _ => ": range ",
            };
            lines.push(line![name, word, number(stroke, unit)]);
        }
        let limit = |limit: &At| line![number(limit.value, unit), " at ", self.at(limit)];
        if !self.limits.is_empty() {
            lines.push(line![name, " stands still: ", joined(self.limits.iter().map(limit), "; ")]);
        }
        if let Some(ratio) = self.time_ratio {
            lines.push(line!["time ratio ", plain(ratio, 0.0)]);
        }
        if let Some(dwell) = self.dwell {
            let [near, place] = [dwell.tolerance, dwell.position].map(|value| number(value, unit));
            let [from, to, way] = [dwell.from, dwell.to, dwell.to - dwell.from].map(|at| number(at, &self.input.unit));
            let long = line!["dwell: within ", near, " of ", place, " for ", way];
            lines.push(line![long, " of the input, from ", from, " to ", to]);
        }
        lines
    }

    fn transmission_line(&self, angle: &Transmission) -> Cell {
        let poor = if angle.min.value < POOR { line![": below ", number(POOR, "rad")] } else { "".into() };
        line!["transmission angle at `", angle.joint, "` ", self.ends([&angle.min, &angle.max], "rad"), poor]
    }

    /// The smallest and the largest value, with their places.
    fn ends(&self, ends: [&At; 2], unit: &str) -> Cell {
        joined(ends.map(|end| line![number(end.value, unit), " (at ", self.at(end), ")"]), " to ")
    }

    fn dynamics(&self) -> Vec<Cell> {
        let mut lines = Vec::new();
        let extent = |name: &str, extent: &Option<Extent>, unit: &str| {
            let told =
                |own: &Extent| line![name, " ", self.ends([&own.min, &own.max], unit), ", RMS ", number(own.rms, unit)];
            extent.as_ref().map(told)
        };
        let [effort, word, inertia] =
            if self.input.angular { ["N.m", "drive torque", "kg.m2"] } else { ["N", "drive force", "kg"] };
        lines.extend(extent(word, &self.drive, effort));
        lines.extend(extent("drive power", &self.power, "W"));
        let peak = |name: Cell, max: &At, rms: f64| {
            line![name, ": peak ", number(max.value, "N"), " at ", self.at(max), ", RMS ", number(rms, "N")]
        };
        let joints = self.joints.iter();
        lines.extend(joints.map(|joint| peak(line!["joint `", joint.joint, "`"], &joint.max, joint.rms)));
        lines.extend(self.shaking_force.iter().map(|force| peak("shaking force".into(), &force.max, force.rms)));
        lines.extend(extent("shaking moment", &self.shaking_moment, "N.m"));
        lines.extend(extent("generalised inertia", &self.inertia, inertia));
        if let Some(own) = &self.fluctuation {
            let free = line!["coefficient of fluctuation without drive and loads ", plain(own.free, 0.0)];
            let [torque, energy] = [number(own.mean_torque, "N.m"), number(own.energy, "J")];
            lines.push(line![free, "; the loads need ", torque, " and vary by ", energy]);
            let wheels = own.flywheel.zip(own.added_inertia);
            lines.extend(wheels.map(|(loads, added)| {
                let [loads, added] = [loads, added].map(|inertia| number(inertia, "kg.m2"));
                line!["flywheel ", added, " beside the inertia of the mechanism; ", loads, " for the loads alone"]
            }));
        }
        lines
    }

    fn path_lines(&self) -> Vec<Cell> {
        let Some(path) = &self.path else { return Vec::new() };
        let none = || Cell::from("");
        let area = path.area.map_or_else(none, |area| line![", encloses ", number(area, "m2")]);
        let way = path.arc.map_or_else(none, |Arc { x, y, radius }| {
            let [x, y] = [x, y].map(|value| number(value, "m").within(Noise(PLACE * radius)));
            line![", on an arc of radius ", number(radius, "m"), " about (", x, ", ", y, ")"]
        });
        let fro = if path.to_and_fro { ", to and fro" } else { "" };
        let mut lines = vec![line!["path of `", path.point, "`: length ", number(path.length, "m"), area, fro, way]];
        let inputs = |inputs: &[f64]| joined(inputs.iter().map(|input| number(*input, &self.input.unit)), ", ");
        for (what, found) in [("inflections", &path.inflections), ("cusps", &path.cusps)] {
            lines.extend((!found.is_empty()).then(|| line!["  ", what, " at ", inputs(found)]));
        }
        lines.extend(path.crunodes.iter().map(|node| {
            let [x, y] = [node.x, node.y].map(|at| number(at, "m"));
            line!["  crosses itself at (", x, ", ", y, "), input ", inputs(&node.inputs)]
        }));
        lines
    }
}

/// A value of the table. Next to a limit the advantage is as large as rounding errors let it be, and no measure of the others.
fn told(value: f64, column: &Column) -> Cell {
    let value = if value.abs() >= INFINITE { f64::INFINITY.copysign(value) } else { value };
    let own = number(value, &column.unit);
    if column.name == "advantage" { own.within(Noise(NOISE)) } else { own }
}

/// The column of the radius of curvature where a cam touches.
pub fn radius_of(cam: &str) -> String {
    format!("{cam}.radius")
}

/// A ratio that is larger than this is on its way to infinity.
const INFINITE: f64 = 1e9;

/// The units that people think of mechanisms in, where they ask for no others.
pub fn usual() -> Units {
    let mut units = Units::default();
    for name in ["deg", "mm"] {
        if let Ok(unit) = cotree::compile::unit(name) {
            units.add(unit);
        }
    }
    units
}

/// Degrees or millimetres as SI if the text has no unit of its own.
pub fn step(text: &str, angular: bool) -> Result<f64, String> {
    cotree::compile::quantity(text, &if angular { Unit::angle() } else { Unit::length() })
}
