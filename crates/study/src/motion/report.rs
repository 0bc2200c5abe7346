//! The quantities of a motion in sentences and as a table.

use std::f64::consts::TAU;

use cotree::diagnostic::suggest;
use cotree::line;
use cotree::model::Units;
use cotree::report::data::ReliableDigits::Noise;
use cotree::report::data::{Cell, Report, Table, named, number, per, plain, shown, unit as unit_of};

use cotree::typeset::rounded;

use super::cams::Cam;
use super::clearance::PairClearance;
use super::curve::Arc;
use super::figures::{Extent, Figures, MotionColumn, Peak, Speed, TransmissionAngle};
use super::friction::DriveFriction;
use super::growth::Unbounded;
use super::samples::ValueAt;
use super::stops::{Clear, InputLimit, Penetration, Play, Stops};

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
    let at = |at: &ValueAt, unit: &str| line![number(at.value, unit), " at ", number(at.input, "rad")];
    let unit = if cam.turning { "rad" } else { "m" };
    let base = number(cam.base, "m");
    let mut lines =
        vec![line!["cam `", cam.name, "` with ", cam.follower, ", base circle ", base, ", by the cam's angle:"]];
    for phase in &cam.phases {
        let word = if phase.rise > 0.0 { "  rises " } else { "  returns " };
        let [from, to] = [phase.from, phase.to].map(|angle| number(within_turn(angle), "rad"));
        let [velocity, acceleration, jerk] = phase.peaks.map(|peak| plain(peak, 0.0));
        let way = line![word, number(phase.rise.abs(), unit), " from ", from, " to ", to];
        lines.push(line![way, ": peaks ", velocity, " h/beta, ", acceleration, " h/beta^2, ", jerk, " h/beta^3"]);
    }
    let steepest = ValueAt { value: cam.pressure_angle.value.abs(), ..cam.pressure_angle };
    lines.push(line!["  pressure angle up to ", at(&steepest, "rad")]);
    for (what, radius) in [
        ("radius of the pitch curve", &cam.pitch_radius),
        ("convex radius of the profile", &cam.convex_radius),
        ("hollow radius of the profile", &cam.hollow_radius),
    ] {
        lines.extend(radius.iter().map(|smallest| line!["  smallest ", what, " ", at(smallest, "m")]));
    }
    if let Some(ends) = &cam.face {
        let [low, high] = ends.each_ref().map(|end| at(end, "m"));
        lines.push(line!["  touches its face from ", low, " to ", high, " from the follower's point"]);
    }
    if cam.undercut {
        let needed = cam.least_base.map_or_else(
            || "a larger base circle does not help".into(),
            |base| line!["the base circle must be at least ", number(base, "m")],
        );
        lines.push(line!["  UNDERCUT: ", needed]);
    }
    lines
}

/// An angle of a turn, whose end is 360 degrees.
fn within_turn(angle: f64) -> f64 {
    if (0.0..=TAU * (1.0 + PLACE)).contains(&angle) { angle } else { angle.rem_euclid(TAU) }
}

/// Parts with something between them.
fn joined(parts: impl IntoIterator<Item = Cell>, between: &str) -> Cell {
    let parts = parts.into_iter().enumerate();
    Cell::Line(parts.flat_map(|(index, part)| [if index == 0 { "" } else { between }.into(), part]).collect())
}

impl Figures {
    /// Of the table for people the rows that were asked for; as many columns side by side as can be read.
    pub fn report(&self) -> Report {
        let mut title = vec![self.kind()];
        let way = "` backwards; the figures are for the forward direction, at the same speed";
        title.extend(self.reversed.then(|| line!["the scene moves `", self.input.name, way]));
        title.extend(self.stops.iter().flat_map(|stop| self.stop_lines(stop)));
        title.extend(self.output_lines());
        title.extend(self.transmission.iter().map(|angle| self.transmission_line(angle)));
        if let (Some(index), Some(output)) = (&self.joint_force_index, &self.output) {
            let most = number(index.at.value, &per("N", if output.angular { "N.m" } else { "N" }));
            let name = self.told_of("joint-force index".into(), index.unbounded.as_ref());
            title.push(line![name, " up to ", most.within(Noise(0.0)), " at ", self.at(&index.at)]);
        }
        title.extend(self.cams.iter().flat_map(cam_lines));
        title.extend(self.contacts.iter().map(Cell::from));
        title.extend(self.clearance.iter().flatten().map(|clearance| self.clearance_line(clearance)));
        title.extend(self.missing());
        title.extend(self.dynamic_lines());
        title.extend(self.path_lines());
        let read = rows(&self.rows, told);
        Report {
            title,
            tables: vec![Table { width: Some(WIDTH), left: 0, ..read }],
            sheet: rows(&self.table, |value, column| number(value, &column.unit)),
            noise: NOISE,
            ..Report::default()
        }
    }

    fn kind(&self) -> Cell {
        let class = self.four_bar.as_ref().map_or(String::new(), |class| format!("{class}; "));
        let input = &self.input.name;
        let motion = match self.range {
            Some([low, high]) => {
                let [low, high] = [low, high].map(|end| number(end, &self.input.unit));
                line![" moves from ", low, self.end(0), " to ", high, self.end(1)]
            }
            None if self.change_points => {
                " turns fully, through change points, where branches of the motion cross".into()
            }
            None if self.full_turn => " turns fully, with no dead point for this input".into(),
            None => " turns fully, but the mechanism does not return to its start after one turn".into(),
        };
        line![self.name, ": ", class, "`", input, "`", motion, self.pace()]
    }

    /// What is at an end of the range.
    fn end(&self, index: usize) -> Cell {
        let both = self.folds.iter().all(Option::is_some);
        match (self.folds[index], index) {
            (Some(_), 0) if both => "".into(),
            (Some(_), _) if both => ", dead points at both ends for this input".into(),
            (Some(_), _) => " (a dead point for this input)".into(),
            (None, _) => self.stop_at(index).map_or("".into(), |end| line![" (`", end.name, "`)"]),
        }
    }

    /// What stops the input at an end of the range, which may go backwards.
    fn stop_at(&self, index: usize) -> Option<&InputLimit> {
        let at = self.range?[index];
        self.stops.iter().flat_map(|stop| stop.ends.iter().flatten()).find(|end| end.input == at)
    }

    /// How far the drive goes between stops, and what is not said of it.
    fn stop_lines(&self, stops: &Stops) -> Vec<Cell> {
        let unit = &*self.input.unit;
        let mut lines = Vec::new();
        if let Some([from, to]) = stops.requested.map(|range| range.map(|end| number(end, unit))) {
            lines.push(line!["the rest of the range from ", from, " to ", to, " is not reachable and not analysed"]);
        }
        let ends = stops.ends.iter().zip(["less", "more"]);
        lines.extend(ends.filter_map(|(end, word)| Some(self.end_line(end.as_ref()?, word))));
        lines.extend(stops.beyond.iter().map(|beyond| self.beyond_line(beyond)));
        lines.extend(stops.clear.iter().map(|Clear { name, unit, at }| {
            let least = number(at.value, unit).within(Noise(NOISE));
            line!["`", name, "` is not reached: open by ", least, " or more, least at ", self.at(at)]
        }));
        lines.extend(stops.plays.iter().map(|play| self.play_line(play)));
        lines
    }

    /// A relation that has play, in which the motion is the same but for that.
    fn play_line(&self, Play { name, changes }: &Play) -> Cell {
        let as_without = line!["`", name, "` is analysed in the middle of its backlash"];
        if changes.is_empty() {
            return as_without;
        }
        let changes = changes.iter().map(|input| number(self.place(*input), &self.input.unit));
        line![as_without, "; the other flank is in contact from ", joined(changes, ", "), " on"]
    }

    /// Where a stop ends what the drive can do; how hard it is driven against the stop is nobody's to say.
    fn end_line(&self, input_stop: &InputLimit, word: &str) -> Cell {
        let InputLimit { name, input, unit, presses } = input_stop;
        let effort = unit_of(if self.input.angular { "N.m" } else { "N" });
        let presses = match presses {
            Some(presses) => line![
                "each ",
                effort,
                " of the drive beyond the motion's need gives a force of ",
                number(*presses, unit)
            ],
            None => "it is at rest there, and the force of the drive is unbounded".into(),
        };
        let place = line!["`", name, "` stops `", self.input.name, "` at ", self.exactly(*input)];
        line![place, ": ", word, " is not reachable, and the force of the hard stop is not determined; ", presses]
    }

    /// Where the mechanism would be beyond a stop.
    fn beyond_line(&self, beyond: &Penetration) -> Cell {
        let name = &beyond.name;
        match [beyond.from, beyond.to].map(|at| at.map(|at| self.exactly(at))) {
            [Some(from), Some(to)] => line!["beyond `", name, "` it would be from ", from, " to ", to],
            [Some(from), None] => line!["beyond `", name, "` it would be from ", from, " on"],
            [None, Some(to)] => line!["beyond `", name, "` it would be up to ", to],
            [None, None] => line!["beyond `", name, "` it would be everywhere"],
        }
    }

    /// An input that is known to rounding errors.
    fn exactly(&self, input: f64) -> Cell {
        number(input, &self.input.unit).within(Noise(0.0))
    }

    /// How fast the input moves, on which forces depend.
    fn pace(&self) -> Cell {
        let speed = number(self.speed, &format!("{}/s", self.input.unit));
        match self.origin {
            Speed::Requested if self.speed == 0.0 => ", static forces in each configuration".into(),
            Speed::Requested => line![", at ", speed],
            Speed::OfScene => line![", at ", speed, " as at the start of the scene"],
            Speed::Assumed => line![", at ", speed, " (assumed; give --speed)"],
        }
    }

    /// What is without masses.
    fn missing(&self) -> Option<Cell> {
        let bodies = suggest::list(&self.lacking);
        let without = match self.no_forces {
            true => ", and there are no loads: there are no forces",
            false => ": forces are without their weight and inertia; shaking and generalised inertia are left out",
        };
        (!self.lacking.is_empty()).then(|| line!["no mass or no inertia is given for ", bodies, without])
    }

    /// What a quantity is called before its figures, which are those of the rest where it grows without bound.
    fn told_of(&self, name: Cell, unbounded: Option<&Unbounded>) -> Cell {
        let Some(Unbounded { at, distance }) = unbounded else { return name };
        let at = joined(at.iter().map(|input| number(*input, &self.input.unit)), " and ");
        let distance = number(*distance, &self.input.unit);
        line![name, " grows without bound towards ", at, "; at least ", distance, " from there:"]
    }

    fn at(&self, at: &ValueAt) -> Cell {
        let reach = self.table.first().map_or(&[][..], |column| &column.values);
        let reach = reach.iter().fold(0.0, |reach: f64, input| reach.max(input.abs()));
        number(self.place(at.input), &self.input.unit).within(Noise(PLACE * reach))
    }

    /// An input that may lie beyond the turn, by rounding errors too.
    fn place(&self, input: f64) -> f64 {
        if self.full_turn && input.abs() > PLACE { within_turn(input) } else { input }
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
        let limit = |limit: &ValueAt| line![number(limit.value, unit), " at ", self.at(limit)];
        if !self.limits.is_empty() {
            lines.push(line![name, " stands still: ", joined(self.limits.iter().map(limit), "; ")]);
        }
        if let Some(ratio) = self.time_ratio {
            lines.push(line!["time ratio ", plain(ratio, 0.0)]);
        }
        if let Some(dwell) = self.dwell {
            let [near, place] = [dwell.tolerance, dwell.position].map(|value| number(value, unit));
            let way = (dwell.to - dwell.from).abs();
            let [from, to, way] =
                [self.place(dwell.from), self.place(dwell.to), way].map(|at| number(at, &self.input.unit));
            let long = line!["dwell: within ", near, " of ", place, " for ", way];
            lines.push(line![long, " of the input, from ", from, " to ", to]);
        }
        lines
    }

    fn transmission_line(&self, angle: &TransmissionAngle) -> Cell {
        let poor = if angle.min.value < POOR { line![": below ", number(POOR, "rad")] } else { "".into() };
        line!["transmission angle at `", angle.joint, "` ", self.ends([&angle.min, &angle.max], "rad"), poor]
    }

    /// The smallest and the largest value, with their places.
    fn ends(&self, ends: [&ValueAt; 2], unit: &str) -> Cell {
        joined(ends.map(|end| line![number(end.value, unit), " (at ", self.at(end), ")"]), " to ")
    }

    fn dynamic_lines(&self) -> Vec<Cell> {
        let mut lines = Vec::new();
        let extent = |name: &str, extent: &Option<Extent>, unit: &str| {
            extent.as_ref().map(|extent| {
                let name = self.told_of(name.into(), extent.unbounded.as_ref());
                line![name, " ", self.ends([&extent.min, &extent.max], unit), ", RMS ", number(extent.rms, unit)]
            })
        };
        let [effort, word, inertia] =
            if self.input.angular { ["N.m", "drive torque", "kg.m2"] } else { ["N", "drive force", "kg"] };
        lines.extend(extent(word, &self.drive, effort));
        lines.extend(extent("drive power", &self.power, "W"));
        lines.extend(self.friction.iter().map(|friction| self.friction_line(friction)));
        let peak = |name: Cell, Peak { max, rms, unbounded }: &Peak| {
            let name = match unbounded {
                Some(_) => self.told_of(name, unbounded.as_ref()),
                None => line![name, ":"],
            };
            line![name, " peak ", number(max.value, "N"), " at ", self.at(max), ", RMS ", number(*rms, "N")]
        };
        let joints = self.joints.iter();
        lines.extend(joints.map(|joint| peak(line!["joint `", joint.joint, "`"], &joint.peak)));
        lines.extend(self.shaking_force.iter().map(|force| peak("shaking force".into(), force)));
        lines.extend(extent("shaking moment", &self.shaking_moment, "N.m"));
        lines.extend(extent("generalised inertia", &self.inertia, inertia));
        if let Some(fluctuation) = &self.fluctuation {
            let free = line!["coefficient of fluctuation without drive and loads ", plain(fluctuation.free, 0.0)];
            let [torque, energy] = [number(fluctuation.mean_torque, "N.m"), number(fluctuation.energy, "J")];
            lines.push(line![free, "; the loads need ", torque, " and vary by ", energy]);
            let wheels = fluctuation.flywheel.zip(fluctuation.added_inertia);
            lines.extend(wheels.map(|(loads, added)| {
                let [loads, added] = [loads, added].map(|inertia| number(inertia, "kg.m2"));
                line![
                    "flywheel ",
                    added,
                    " in addition to the inertia of the mechanism; ",
                    loads,
                    " for the loads alone"
                ]
            }));
        }
        lines
    }

    /// What friction takes, and whether it holds what has been moved.
    fn friction_line(&self, drive_friction: &DriveFriction) -> Cell {
        let way = if self.full_turn { "turn" } else { "range" };
        let work = if drive_friction.work < 0.0 { "give" } else { "take" };
        let line = line![
            "friction takes ",
            number(drive_friction.loss, "J"),
            " over the ",
            way,
            ", loads and masses ",
            work,
            " ",
            number(drive_friction.work.abs(), "J")
        ];
        let line = match drive_friction.efficiency {
            Some(efficiency) => line![line, ": efficiency ", percent(efficiency)],
            None => line,
        };
        match drive_friction.locked {
            Some(locked) if locked >= 1.0 => line![line, "; loads do not move it back (self-locking)"],
            Some(locked) if locked > 0.0 => {
                let share = percent(locked);
                line![
                    line,
                    "; in ",
                    share,
                    " of the configurations in which the loads would move it back it is self-locking"
                ]
            }
            Some(_) | None => line,
        }
    }

    /// How close two outlines come, or where they overlap.
    fn clearance_line(&self, clearance: &PairClearance) -> Cell {
        let PairClearance { pair: [first, second], least, at, points, overlaps } = clearance;
        let names = line!["`", first, "` and `", second, "`"];
        if !overlaps.is_empty() {
            let ends = |ends: &[f64; 2]| {
                let [from, to] = ends.map(|end| self.exactly(self.place(end)));
                line!["from ", from, " to ", to]
            };
            return line![names, " overlap ", joined(overlaps.iter().map(ends), ", ")];
        }
        let place = self.at(&ValueAt { input: at.input, value: *least });
        let place = match at.time {
            Some(time) => line![place, " (", number(time, "s"), ")"],
            None => place,
        };
        let [from, to] = points.map(|point| {
            let [x, y] = point.map(|at| number(at, "m"));
            line!["(", x, ", ", y, ")"]
        });
        line![names, ": least distance ", number(*least, "m"), " at ", place, ", between ", from, " and ", to]
    }

    /// Pairs of outlines that come closer than is permitted, each as a sentence.
    pub fn too_close(&self, units: &Units) -> Vec<String> {
        let Some(permitted) = self.least_clearance else { return Vec::new() };
        let unit = shown(units, "m");
        let close = self
            .clearance
            .iter()
            .flatten()
            .filter(|clearance| !clearance.overlaps.is_empty() || clearance.least < permitted);
        close
            .map(|PairClearance { pair: [first, second], least, overlaps, .. }| {
                let permitted = unit.show(permitted);
                match overlaps.is_empty() {
                    true => format!(
                        "the distance of `{first}` and `{second}` falls to {}, but `least` of `[clearance]` is {permitted}",
                        unit.show(*least)
                    ),
                    false => format!("`{first}` and `{second}` overlap, but `least` of `[clearance]` is {permitted}"),
                }
            })
            .collect()
    }

    fn path_lines(&self) -> Vec<Cell> {
        let Some(path) = &self.path else { return Vec::new() };
        let none = || Cell::from("");
        let area = path.area.map_or_else(none, |area| {
            let sense = if area < 0.0 { " clockwise" } else { " counter-clockwise" };
            line![", encloses ", number(area.abs(), "m2"), sense]
        });
        let way = path.arc.map_or_else(none, |Arc { x, y, radius }| {
            let [x, y] = [x, y].map(|value| number(value, "m").within(Noise(PLACE * radius)));
            line![", on an arc of radius ", number(radius, "m"), " about (", x, ", ", y, ")"]
        });
        let fro = if path.to_and_fro { ", to and fro" } else { "" };
        let mut lines = vec![line!["path of `", path.point, "`: length ", number(path.length, "m"), area, fro, way]];
        let inputs =
            |inputs: &[f64]| joined(inputs.iter().map(|input| number(self.place(*input), &self.input.unit)), ", ");
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

/// A share of a whole.
fn percent(share: f64) -> String {
    format!("{} %", rounded(100.0 * share, 3))
}

/// Columns as a table.
fn rows(columns: &[MotionColumn], cell: impl Fn(f64, &MotionColumn) -> Cell) -> Table {
    let count = columns.first().map_or(0, |column| column.values.len());
    let row = |row: usize| {
        columns.iter().map(|column| column.values.get(row).map_or("-".into(), |value| cell(*value, column))).collect()
    };
    Table::new(columns.iter().map(|column| named(&column.name, &column.unit)).collect(), (0..count).map(row))
}

/// A value of the table. Next to a limit the advantage is as large as rounding errors let it be, and no measure of the others.
fn told(value: f64, column: &MotionColumn) -> Cell {
    let value = if value.abs() >= INFINITE { f64::INFINITY.copysign(value) } else { value };
    let cell = number(value, &column.unit);
    if column.name == "advantage" { cell.within(Noise(NOISE)) } else { cell }
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
