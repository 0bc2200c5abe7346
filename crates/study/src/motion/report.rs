//! The quantities of a motion as a text, a table and a plot.

use std::collections::HashMap;

use cotree::columns::{self, aligned, titled};
use cotree::compile::shown;
use cotree::mechanism::{DisplayUnit, Unit, Units};

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

/// Writes values in the units that are asked for.
pub struct Shown<'u> {
    units: &'u Units,
    /// The largest value of the table in each unit in SI.
    largest: HashMap<&'u str, f64>,
}

impl<'u> Shown<'u> {
    /// In these units, of a table in SI.
    pub fn new(units: &'u Units, table: &'u [Column]) -> Self {
        let mut largest: HashMap<&str, f64> = HashMap::new();
        // Next to a limit the advantage is as large as rounding errors let it be.
        for column in table.iter().filter(|column| column.name != "advantage") {
            let own = largest.entry(&column.unit).or_default();
            *own = column.values.iter().filter(|value| value.is_finite()).fold(*own, |own, value| own.max(value.abs()));
        }
        Self { units, largest }
    }

    /// A unit in SI as it is shown. Of ratios lengths and forces are; radians stay, for the derivatives are by the radian.
    pub fn of(&self, si: &str) -> DisplayUnit {
        let Some((above, below @ ("rad" | "rad2" | "m" | "m2"))) = si.split_once('/') else {
            return shown(self.units, si);
        };
        let part = |si: &str| match si {
            "rad" | "rad2" | "1" => DisplayUnit { name: si.to_owned(), factor: 1.0 },
            "m2" => {
                let metre = shown(self.units, "m");
                DisplayUnit { name: format!("{}2", metre.name), factor: metre.factor * metre.factor }
            }
            si => shown(self.units, si),
        };
        let [above, below] = [part(above), part(below)];
        DisplayUnit { name: format!("{}/{}", above.name, below.name), factor: above.factor / below.factor }
    }

    fn value(&self, value: f64, si: &str) -> String {
        format!("{} {}", self.bare(value, si), self.of(si).name).trim_end().to_owned()
    }

    /// Nothing for what rounding errors make of it.
    fn bare(&self, value: f64, si: &str) -> String {
        // Energy by torque and angle.
        let largest = self.largest.get(if si == "J" { "N.m" } else { si }).copied().unwrap_or_default();
        let factor = self.of(si).factor;
        number(value / factor, NOISE * largest / factor)
    }
}

/// What there is to say of a cam, by its own angle.
fn cam_lines(cam: &Cam, shown: &Shown) -> Vec<String> {
    let at = |at: &At, unit: &str| format!("{} at {}", shown.value(at.value, unit), shown.value(at.input, "rad"));
    let unit = if cam.turning { "rad" } else { "m" };
    let base = shown.value(cam.base, "m");
    let mut lines = vec![format!("cam `{}` with {}, base circle {base}, by the cam's angle:", cam.name, cam.follower)];
    for phase in &cam.phases {
        let word = if phase.rise > 0.0 { "rises" } else { "returns" };
        let [from, to] = [phase.from, phase.to].map(|angle| shown.value(angle, "rad"));
        let [velocity, acceleration, jerk] = phase.peaks.map(|peak| number(peak, 0.0));
        let rise = shown.value(phase.rise.abs(), unit);
        lines.push(format!(
            "  {word} {rise} from {from} to {to}: peaks {velocity} h/beta, {acceleration} h/beta^2, {jerk} h/beta^3"
        ));
    }
    lines.push(format!("  pressure angle up to {}", at(&cam.pressure_angle, "rad")));
    for (what, radius) in [
        ("radius of the pitch curve", &cam.pitch_radius),
        ("convex radius of the profile", &cam.convex_radius),
        ("hollow radius of the profile", &cam.hollow_radius),
    ] {
        lines.extend(radius.iter().map(|own| format!("  smallest {what} {}", at(own, "m"))));
    }
    if let Some([low, high]) = &cam.face {
        lines.push(format!("  touches its face from {} to {} from the follower's point", at(low, "m"), at(high, "m")));
    }
    if cam.undercut {
        let needed = cam.least_base.map_or_else(
            || "no larger base circle helps".to_string(),
            |base| format!("the base circle must be at least {}", shown.value(base, "m")),
        );
        lines.push(format!("  UNDERCUT: {needed}"));
    }
    lines
}

impl Figures {
    fn input_unit(&self) -> &str {
        &self.input.unit
    }

    /// Everything for people; of the table a row every so much of the input.
    pub fn text(&self, every: f64, units: &Units) -> String {
        let shown = Shown::new(units, &self.table);
        let mut lines = vec![self.kind(&shown)];
        if self.reversed {
            let input = &self.input.name;
            lines.push(format!(
                "the scene moves `{input}` backwards; the figures are those of the way forwards, at the same speed"
            ));
        }
        lines.extend(self.output_lines(&shown));
        lines.extend(self.transmission.iter().map(|angle| self.transmission_line(angle, &shown)));
        if let (Some(index), Some(output)) = (&self.joint_force_index, &self.output) {
            let [force, load] = ["N", if output.angular { "N.m" } else { "N" }].map(|si| shown.of(si));
            let most = number(index.value * load.factor / force.factor, 0.0);
            let at = self.at(index, &shown);
            lines.push(format!("joint-force index up to {most} {} per {} at {at}", force.name, load.name));
        }
        lines.extend(self.cams.iter().flat_map(|cam| cam_lines(cam, &shown)));
        lines.extend(self.contacts.iter().cloned());
        lines.extend(self.dynamics(&shown));
        lines.extend(self.path_lines(&shown));
        format!("{}\n\n{}", lines.join("\n"), self.rows(every, &shown))
    }

    fn kind(&self, shown: &Shown) -> String {
        let class = self.four_bar.as_ref().map_or(String::new(), |class| format!("{class}; "));
        let input = &self.input.name;
        let motion = match self.range {
            Some([low, high]) => {
                let [low, high] = [low, high].map(|end| shown.value(end, self.input_unit()));
                let ends = if self.dead_points { ", dead points at both ends for this input" } else { "" };
                format!("`{input}` moves from {low} to {high}{ends}")
            }
            None if self.change_points => {
                format!("`{input}` turns fully, through poses in which branches of the motion cross (change points)")
            }
            None if self.full_turn => format!("`{input}` turns fully, with no dead point for this input"),
            None => format!("`{input}` turns fully, but the mechanism is not as before after one turn"),
        };
        format!("{}: {class}{motion}", self.name)
    }

    fn at(&self, at: &At, shown: &Shown) -> String {
        let reach = self.table.first().map_or(&[][..], |column| &column.values);
        let reach = reach.iter().fold(0.0, |reach: f64, input| reach.max(input.abs()));
        let input = if at.input.abs() < PLACE * reach { 0.0 } else { at.input };
        shown.value(input, self.input_unit())
    }

    fn output_lines(&self, shown: &Shown) -> Vec<String> {
        let Some(output) = &self.output else { return Vec::new() };
        let unit = &output.unit;
        let mut lines = Vec::new();
        if let Some(stroke) = self.stroke {
            let word = match &*output.unit {
                "rad" => "swing",
                "m" => "stroke",
                _ => "range",
            };
            lines.push(format!("`{}`: {word} {}", output.name, shown.value(stroke, unit)));
        }
        let limit = |limit: &At| format!("{} at {}", shown.value(limit.value, unit), self.at(limit, shown));
        if !self.limits.is_empty() {
            let limits: Vec<String> = self.limits.iter().map(limit).collect();
            lines.push(format!("`{}` stands still: {}", output.name, limits.join("; ")));
        }
        if let Some(ratio) = self.time_ratio {
            lines.push(format!("time ratio {}", number(ratio, 0.0)));
        }
        if let Some(dwell) = self.dwell {
            let [near, place] = [dwell.tolerance, dwell.position].map(|value| shown.value(value, unit));
            let [from, to, way] =
                [dwell.from, dwell.to, dwell.to - dwell.from].map(|at| shown.value(at, self.input_unit()));
            lines.push(format!("dwell: within {near} of {place} for {way} of the input, from {from} to {to}"));
        }
        lines
    }

    fn transmission_line(&self, angle: &Transmission, shown: &Shown) -> String {
        let poor = if angle.min.value < POOR { format!(": below {}", shown.value(POOR, "rad")) } else { String::new() };
        let ends = self.ends([&angle.min, &angle.max], "rad", shown);
        format!("transmission angle at `{}` {ends}{poor}", angle.joint)
    }

    /// The smallest and the largest value, with their places.
    fn ends(&self, ends: [&At; 2], unit: &str, shown: &Shown) -> String {
        ends.map(|end| format!("{} (at {})", shown.value(end.value, unit), self.at(end, shown))).join(" to ")
    }

    fn dynamics(&self, shown: &Shown) -> Vec<String> {
        let mut lines = Vec::new();
        let extent = |name: &str, extent: &Option<Extent>, unit: &str| {
            let written = |own: &Extent| {
                format!("{name} {}, RMS {}", self.ends([&own.min, &own.max], unit, shown), shown.value(own.rms, unit))
            };
            extent.as_ref().map(written)
        };
        let effort = if self.input.angular { "N.m" } else { "N" };
        let word = if self.input.angular { "drive torque" } else { "drive force" };
        lines.extend(extent(word, &self.drive, effort));
        lines.extend(extent("drive power", &self.power, "W"));
        let peak = |name: &str, max: &At, rms: f64| {
            let [peak, rms] = [max.value, rms].map(|force| shown.value(force, "N"));
            format!("{name}: peak {peak} at {}, RMS {rms}", self.at(max, shown))
        };
        let joints = self.joints.iter();
        lines.extend(joints.map(|joint| peak(&format!("joint `{}`", joint.joint), &joint.max, joint.rms)));
        lines.extend(self.shaking_force.iter().map(|force| peak("shaking force", &force.max, force.rms)));
        lines.extend(extent("shaking moment", &self.shaking_moment, "N.m"));
        lines.extend(extent("generalised inertia", &self.inertia, if self.input.angular { "kg.m2" } else { "kg" }));
        if let Some(own) = &self.fluctuation {
            let free = format!("coefficient of fluctuation without drive and loads {}", number(own.free, 0.0));
            let energy = shown.value(own.energy, "J");
            lines.push(format!("{free}; the loads need {} and vary by {energy}", shown.value(own.mean_torque, "N.m")));
            let wheels = own.flywheel.zip(own.added_inertia);
            lines.extend(wheels.map(|(loads, added)| {
                let [loads, added] = [loads, added].map(|inertia| shown.value(inertia, "kg.m2"));
                format!("flywheel {added} beside the inertia of the mechanism; {loads} for the loads alone")
            }));
        }
        lines
    }

    fn path_lines(&self, shown: &Shown) -> Vec<String> {
        let Some(path) = &self.path else { return Vec::new() };
        let area = path.area.map_or(String::new(), |area| format!(", encloses {}", shown.value(area, "m2")));
        let way = path.arc.map_or(String::new(), |Arc { x, y, radius }| {
            let clear = |value: f64| if value.abs() < PLACE * radius { 0.0 } else { value };
            let [x, y, radius] = [clear(x), clear(y), radius].map(|value| shown.value(value, "m"));
            format!(", on an arc of radius {radius} about ({x}, {y})")
        });
        let way = if path.to_and_fro { format!(", to and fro{way}") } else { way };
        let mut lines = vec![format!("path of `{}`: length {}{area}{way}", path.point, shown.value(path.length, "m"))];
        let inputs = |inputs: &[f64]| {
            let inputs: Vec<String> = inputs.iter().map(|input| shown.value(*input, self.input_unit())).collect();
            inputs.join(", ")
        };
        if !path.inflections.is_empty() {
            lines.push(format!("  inflections at {}", inputs(&path.inflections)));
        }
        if !path.cusps.is_empty() {
            lines.push(format!("  cusps at {}", inputs(&path.cusps)));
        }
        for node in &path.crunodes {
            let [x, y] = [node.x, node.y].map(|at| shown.value(at, "m"));
            lines.push(format!("  crosses itself at ({x}, {y}), input {}", inputs(&node.inputs)));
        }
        lines
    }

    /// The rows of the table, one every so much of the input; as many columns side by side as can be read.
    fn rows(&self, every: f64, shown: &Shown) -> String {
        let [inputs, others @ ..] = &self.table[..] else { return String::new() };
        let step = (inputs.values.get(1).unwrap_or(&1.0) - inputs.values.first().unwrap_or(&0.0)).abs();
        let thin = ((every / step).round() as usize).max(1);
        let written = |column: &Column| {
            let head = titled(&column.name, &shown.of(&column.unit).name);
            let values = column.values.iter().step_by(thin).map(|value| shown.bare(*value, &column.unit));
            std::iter::once(head).chain(values).collect::<Vec<String>>()
        };
        let first: Vec<Vec<String>> = written(inputs).into_iter().map(|cell| vec![cell]).collect();
        let mut tables = vec![first.clone()];
        let mut room = WIDTH;
        for column in others.iter().map(written) {
            let width = column.iter().map(|cell| cell.chars().count()).max().unwrap_or(0) + 2;
            if width > room {
                tables.push(first.clone());
                room = WIDTH;
            }
            room = room.saturating_sub(width);
            tables.last_mut().into_iter().flatten().zip(column).for_each(|(row, cell)| row.push(cell));
        }
        tables.iter().map(|table| aligned(table, 0, "")).collect::<Vec<String>>().join("\n")
    }

    /// The columns of the table as they are shown: their headings, and the SI value of one in each.
    pub fn columns(&self, units: &Units) -> Vec<(String, f64)> {
        let shown = Shown::new(units, &[]);
        let column = |own: &Column| {
            let unit = shown.of(&own.unit);
            (titled(&own.name, &unit.name), unit.factor)
        };
        self.table.iter().map(column).collect()
    }
}

/// The column of the radius of curvature where a cam touches.
pub fn radius_of(cam: &str) -> String {
    format!("{cam}.radius")
}

/// A ratio that is larger than this is on its way to infinity.
const INFINITE: f64 = 1e9;

fn number(value: f64, noise: f64) -> String {
    match value {
        value if value.is_nan() => "-".to_owned(),
        value if value.abs() >= INFINITE => f64::INFINITY.copysign(value).to_string(),
        value => columns::number(value, noise),
    }
}

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
