//! How far the drive can move between limits of joints, contacts and ropes. A driver gives no way to them, so each ends the range where its gap falls to zero; what lies
//! beyond is not reached, and the motion is that without them.

use cotree::diagnostic::suggest;
use cotree::model::{Contact, Formula, JointId, Mechanism, Output, Part, Quantity, Unit, Units, Variable};
use cotree::report::data::shown;
use cotree::scene::constant::evaluate;
use cotree::scene::key::Form;
use cotree::scene::record::Record;
use serde::Serialize;

use super::drive::{self, COUNT, DrivenMechanism, InputTable, Moved};
use super::samples::{ANGULAR, Samples, ValueAt};
use super::{DrivenJoint, MotionError, unit_of};

/// Gaps below this share of the largest are none: what touches is not passed.
const TOUCHING: f64 = 1e-10;
/// Where the motion folds it is looked at up to this share of the way before, the nearest that runs.
const BEFORE: [f64; 4] = [0.0, 1e-9, 1e-6, 1e-3];
/// Steps of a search between two places, at most.
const STEPS: usize = 80;

/// What ends the range of the input, or does not.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stops {
    /// What the input reaches first, going back from the start of the scene and forth.
    pub ends: [Option<InputLimit>; 2],
    /// Where each would be passed, as far as was looked: not reachable.
    pub beyond: Vec<Penetration>,
    /// The least gap of each that does not end the range, within it.
    pub clear: Vec<Clear>,
    /// The range that was asked for, if it is not reachable as a whole.
    #[serde(rename = "asked")]
    pub requested: Option<[f64; 2]>,
    /// Relations with play.
    pub plays: Vec<Play>,
}

/// What stops the input.
#[derive(Clone, Debug, Serialize)]
pub struct InputLimit {
    /// Such as `guide.max`.
    pub name: String,
    /// The input at which its gap is zero [rad] or \[m\].
    pub input: f64,
    /// The unit of what presses: N or N.m.
    pub unit: String,
    /// With how much it presses for each N.m or N that the drive exerts there beyond what the motion takes; none where that has no bound.
    pub presses: Option<f64>,
}

/// Inputs for which the mechanism would be beyond a stop; an end that is absent is beyond what was looked at.
#[derive(Clone, Debug, Serialize)]
pub struct Penetration {
    pub name: String,
    pub from: Option<f64>,
    pub to: Option<f64>,
}

/// The least gap of what is not reached, and where.
#[derive(Clone, Debug, Serialize)]
pub struct Clear {
    pub name: String,
    pub unit: String,
    #[serde(flatten)]
    pub at: ValueAt,
}

/// A relation whose play is left out: it holds as in the middle of it.
#[derive(Clone, Debug, Serialize)]
pub struct Play {
    pub name: String,
    /// Where what it carries changes its sign, so that the other flank presses: the input.
    pub changes: Vec<f64>,
}

/// How far something is open that can stop the drive.
struct ContactGap {
    name: String,
    unit: Unit,
    bound: f64,
    output: Output,
}

/// What of a mechanism holds on one side only.
pub(super) struct ContactGaps {
    gaps: Vec<ContactGap>,
    /// Joints whose relation has play.
    plays: Vec<JointId>,
}

/// None of what couples: that holds always while the drive moves it.
fn gap(mechanism: &Mechanism, contact: &Contact, part: &Part) -> Result<Option<ContactGap>, MotionError> {
    let name = contact.name.clone();
    if contact.gap.of_rate {
        return Err(MotionError::Request(format!(
            "whether freewheel `{name}` is engaged depends on the direction of the drive, not on its position: remove it, or use `simulate` with a force or a torque instead of a driver"
        )));
    }
    let variable = |quantity: Quantity| Formula::Variable(Variable { owner: part.owner, quantity });
    let turns = part.component().keys.iter().find_map(|key| match key.form {
        Form::Record(Record::Limits(wanted)) => Some(wanted.is_turning()),
        _ => None,
    });
    let (value, turns) = match turns {
        _ if part.component().variables.contains(&Quantity::Gap) => (variable(Quantity::Gap), false),
        Some(turns) => {
            let motion = variable(if turns { Quantity::Angle } else { Quantity::S });
            let off = motion + Formula::Number(-1.0) * contact.gap.bound.clone();
            (Formula::Number(contact.gap.sign) * off, turns)
        }
        None => return Ok(None),
    };
    let unit = if turns { Unit::angle() } else { Unit::length() };
    let bound = evaluate(&contact.gap.bound, &mechanism.parameter_values());
    let requested = mechanism.output(Variable { owner: part.owner, quantity: Quantity::Gap });
    let output = Output { name: format!("cotree_gap.{name}"), unit: unit.clone(), value, ..requested };
    Ok(Some(ContactGap { name, unit, bound, output }))
}

impl ContactGaps {
    /// # Errors
    /// Freewheels: what they hold is no place.
    pub fn of(mechanism: &Mechanism) -> Result<ContactGaps, MotionError> {
        let stops = mechanism.contacts.iter().filter(|contact| contact.slip.is_none());
        let parts = stops.filter_map(|stop| Some((stop, mechanism.parts().find(|part| part.owner == stop.owner)?)));
        let gaps =
            parts.filter_map(|(joint, part)| gap(mechanism, joint, part).transpose()).collect::<Result<_, _>>()?;
        let has_play = |joint: &Part| {
            joint.limits().is_some()
                && joint.component().keys.iter().any(|key| matches!(key.form, Form::Record(Record::Play(_))))
        };
        let joints = mechanism.joints.iter().enumerate().filter(|(_, joint)| has_play(joint));
        Ok(ContactGaps { gaps, plays: joints.map(|(index, _)| JointId(index)).collect() })
    }

    /// What of it the drive meets, all along its range or as far as it goes from its start; none if there is nothing.
    ///
    /// # Errors
    /// The driven mechanism is at fault, starts beyond a stop, or moves freely besides.
    pub fn met(&self, moved: &Moved, drive: &DrivenJoint, units: &Units) -> Result<Option<Stops>, MotionError> {
        let joints = &moved.mechanism.joints;
        let play = |joint: &JointId| Play { name: joints[joint.0].name.clone(), changes: Vec::new() };
        let mut stops = Stops { plays: self.plays.iter().map(play).collect(), ..Stops::default() };
        if self.gaps.is_empty() {
            return Ok((!self.plays.is_empty()).then_some(stops));
        }
        let ways = match drive.range {
            Some([from, to]) => [drive.start - from.min(to), from.max(to) - drive.start].map(|way| way.max(0.0)),
            None => [self.farthest(moved, drive); 2],
        };
        let courses = [
            GapCourse::along(&self.gaps, (moved, drive), -1.0, ways[0])?,
            GapCourse::along(&self.gaps, (moved, drive), 1.0, ways[1])?,
        ];
        for (index, gap) in self.gaps.iter().enumerate() {
            courses[1].check_start(index, gap, units)?;
            stops.meet(index, gap, &courses, drive.start);
        }
        for (index, gap) in self.gaps.iter().enumerate() {
            stops.pass(index, gap, &courses, drive.start);
        }
        stops.within_a_turn(drive);
        stops.requested = drive.range.filter(|range| *range != stops.within(*range));
        Ok(Some(stops))
    }

    /// A way at whose end a slide is beyond all limits of its own.
    fn farthest(&self, moved: &Moved, drive: &DrivenJoint) -> f64 {
        if drive.motion == ANGULAR {
            return std::f64::consts::TAU;
        }
        let lengths = self.gaps.iter().filter(|gap| gap.unit.si == "m");
        let bounds = lengths.map(|gap| gap.bound.abs()).sum::<f64>();
        drive::size(&moved.mechanism) + 2.0 * (drive.start.abs() + bounds)
    }
}

/// From the crossings back and forth, each of which begins within, where it is beyond.
fn beyond(gap: &ContactGap, start: f64, [back, forth]: &[Vec<f64>; 2]) -> Vec<Penetration> {
    let name = || gap.name.clone();
    let at = |way: Option<&f64>, direction: f64| way.map(|way| start + direction * way);
    let below = back.chunks(2).rev();
    let below = below.map(|pair| Penetration { name: name(), from: at(pair.get(1), -1.0), to: at(pair.first(), -1.0) });
    let above = forth.chunks(2);
    let above = above.map(|pair| Penetration { name: name(), from: at(pair.first(), 1.0), to: at(pair.get(1), 1.0) });
    below.chain(above).collect()
}

impl ContactGap {
    /// The unit of what presses where it is closed.
    fn effort(&self) -> String {
        if self.unit.si == "rad" { "N.m" } else { "N" }.to_owned()
    }
}

impl Stops {
    /// Adds what is met of one gap.
    fn meet(&mut self, index: usize, gap: &ContactGap, courses: &[GapCourse; 2], start: f64) {
        let crossings = courses.each_ref().map(|course| course.crossings(index));
        for ((course, crossings), end) in courses.iter().zip(&crossings).zip(&mut self.ends) {
            let Some(&way) = crossings.first() else { continue };
            let input = start + course.direction * way;
            if end.as_ref().is_none_or(|end| course.direction * (end.input - input) > 0.0) {
                let (name, unit, presses) = (gap.name.clone(), gap.effort(), course.presses(index, way));
                *end = Some(InputLimit { name, input, unit, presses });
            }
        }
        self.beyond.extend(beyond(gap, start, &crossings));
    }

    /// Adds the least gap within what is reachable, if this is not what ends that.
    fn pass(&mut self, index: usize, gap: &ContactGap, courses: &[GapCourse; 2], start: f64) {
        if self.ends.iter().flatten().any(|end| end.name == gap.name) {
            return;
        }
        let least = courses.iter().zip(&self.ends).filter_map(|(course, end)| {
            let way = end.as_ref().map(|end| (end.input - start).abs());
            let ValueAt { input, value } = course.least(index, way)?;
            Some(ValueAt { input: start + course.direction * input, value })
        });
        let least = least.reduce(|a, b| if b.value < a.value { b } else { a });
        self.clear.extend(least.map(|at| Clear { name: gap.name.clone(), unit: gap.unit.si.clone(), at }));
    }

    /// What of a range is reachable, in its order.
    pub(super) fn within(&self, requested: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.ends.each_ref().map(|end| end.as_ref().map(|end| end.input));
        requested.map(|at| at.max(low.unwrap_or(f64::NEG_INFINITY)).min(high.unwrap_or(f64::INFINITY)))
    }

    /// Keeps the places of one way round: a turn is looked at both ways, and each place is found twice.
    fn within_a_turn(&mut self, drive: &DrivenJoint) {
        let Some(first) = self.ends[0].as_ref().map(|end| end.input) else { return };
        if drive.motion == ANGULAR && drive.range.is_none() {
            self.beyond.retain(|passage| passage.from.is_some_and(|from| from >= first));
        }
    }

    /// The part of a range that is reachable.
    ///
    /// # Errors
    /// There is none.
    pub(super) fn clipped(
        &self,
        requested: [f64; 2],
        mechanism: &Mechanism,
        drive: &DrivenJoint,
        units: &Units,
    ) -> Result<[f64; 2], MotionError> {
        let range = self.within(requested);
        if range[0] != range[1] {
            return Ok(range);
        }
        let unit = shown(units, &unit_of(drive.motion).si);
        let [from, to] = requested.map(|at| unit.show(at));
        let stopped = |end: &InputLimit| format!("`{}` stops it at {}", end.name, unit.show(end.input));
        let ends = suggest::joined(self.ends.iter().flatten().map(stopped), suggest::MOST);
        let name = drive::called(&mechanism.joints[drive.joint.0], drive.motion);
        Err(MotionError::Request(format!(
            "`{name}` cannot reach the range from {from} to {to}: from the start of the scene {ends}"
        )))
    }

    /// With the places where what relations with play carry changes its sign.
    pub(super) fn with_changes(mut self, mechanism: &Mechanism, table: &InputTable) -> Stops {
        for play in &mut self.plays {
            let joint = mechanism.joints.iter().find(|joint| joint.name == play.name);
            let reactions = joint.map_or(&[][..], |joint| joint.component().reactions);
            let carried = reactions.iter().find_map(|reaction| table.get(&reaction.of(&play.name)));
            play.changes = carried.map(|carried| carried.zeros()).unwrap_or_default();
        }
        self
    }
}

/// Gaps along the way of the input from its start in one direction.
struct GapCourse {
    direction: f64,
    driven: DrivenMechanism,
    /// Samples of each gap at equal steps of the input; none if it does not move.
    gaps: Vec<Samples>,
    names: Vec<String>,
}

impl GapCourse {
    fn along(
        gaps: &[ContactGap],
        (moved, drive): (&Moved, &DrivenJoint),
        direction: f64,
        way: f64,
    ) -> Result<GapCourse, MotionError> {
        let outputs: Vec<Output> = gaps.iter().map(|gap| gap.output.clone()).collect();
        let names: Vec<String> = outputs.iter().map(|output| output.name.clone()).collect();
        let driven = DrivenMechanism::watching(moved, drive, direction, outputs)?;
        if !driven.model.is_driven() {
            return Err(MotionError::Request(format!(
                "the drive leaves other degrees of freedom, so whether `{}` closes depends on the motion before: use `simulate`, or let joints and drivers determine the motion",
                gaps.first().map_or("", |gap| &gap.name)
            )));
        }
        let mut course = GapCourse { direction, driven, gaps: Vec::new(), names };
        let mut sampled = course.sampled(way);
        if sampled.is_none() {
            let reach = drive::reach(moved, drive, direction, way)?.min(way);
            sampled = BEFORE.iter().find_map(|share| course.sampled(reach * (1.0 - share)));
        }
        course.gaps = sampled.unwrap_or_default();
        Ok(course)
    }

    fn sampled(&self, way: f64) -> Option<Vec<Samples>> {
        // A way of no length has its start only.
        let step = way.max(f64::MIN_POSITIVE) / COUNT as f64;
        let mut columns = self.driven.run(step, COUNT as f64).ok()?;
        let samples = self.names.iter().map(|name| Some(Samples::new([0.0, step], columns.remove(name)?, false)));
        samples.collect()
    }

    fn check_start(&self, index: usize, gap: &ContactGap, units: &Units) -> Result<(), MotionError> {
        let Some(start) = self.gaps.get(index).and_then(|gap| gap.values().first()) else { return Ok(()) };
        if *start >= -self.touching(index) {
            return Ok(());
        }
        let by = shown(units, &gap.unit.si).show(-start);
        Err(MotionError::Request(format!(
            "the scene starts beyond `{}`, by {by}: start within it, or move it by that much",
            gap.name
        )))
    }

    /// Less of a gap than this is none.
    fn touching(&self, index: usize) -> f64 {
        let values = self.gaps.get(index).map_or(&[][..], Samples::values);
        TOUCHING * values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
    }

    /// The gap at the end of a way.
    fn at(&self, index: usize, way: f64) -> Option<f64> {
        self.driven.run(way, 1.0).ok()?.get(&self.names[index])?.last().copied()
    }

    /// The ways at which the gap closes, opens, and so on.
    fn crossings(&self, index: usize) -> Vec<f64> {
        let Some(gap) = self.gaps.get(index) else { return Vec::new() };
        let least = self.touching(index);
        let mut places: Vec<[f64; 2]> =
            gap.values().iter().enumerate().map(|(place, value)| [gap.input(place), *value]).collect();
        // Between two samples it may close and open.
        places.extend(gap.slope().zeros().into_iter().map(|way| [way, gap.at_input(way)]));
        places.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut crossings = Vec::new();
        for pair in places.windows(2) {
            let is_within = crossings.len() % 2 == 0;
            let [_, value] = pair[1];
            if is_within && value < -least || !is_within && value > least {
                crossings.push(self.crossing(index, [pair[0], pair[1]]));
            }
        }
        crossings
    }

    /// Where it is zero between two places (Illinois).
    fn crossing(&self, index: usize, [mut a, mut b]: [[f64; 2]; 2]) -> f64 {
        if a[1] * b[1] > 0.0 {
            return a[0];
        }
        for _ in 0..STEPS {
            let middle = b[0] - b[1] * (b[0] - a[0]) / (b[1] - a[1]);
            let Some(value) = self.at(index, middle) else { break };
            if value * b[1] <= 0.0 {
                a = b
            } else {
                a[1] *= 0.5
            }
            let step = (middle - b[0]).abs();
            b = [middle, value];
            if value == 0.0 || step <= f64::EPSILON * (1.0 + middle.abs()) {
                break;
            }
        }
        b[0]
    }

    /// 1 over the rate of the gap by the input.
    fn presses(&self, index: usize, way: f64) -> Option<f64> {
        let rate = self.gaps.get(index)?.slope().at_input(way).abs();
        (rate > self.touching(index)).then(|| 1.0 / rate)
    }

    /// The least gap up to a way, or all along.
    fn least(&self, index: usize, way: Option<f64>) -> Option<ValueAt> {
        let gap = self.gaps.get(index)?;
        let Some(way) = way else { return Some(gap.min()) };
        let is_before: Vec<bool> = (0..gap.values().len()).map(|place| gap.input(place) <= way).collect();
        let end = ValueAt { input: way, value: gap.at_input(way) };
        let before = gap.pieces(&is_before).first().map_or(end, Samples::min);
        Some(if end.value < before.value { end } else { before })
    }
}
