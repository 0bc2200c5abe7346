//! The rows of the printed table: at the requested values of the input, and at both ends.

use cotree::typeset::rounded;

use super::drive::{self, COUNT};
use super::figures::{self, Figures, MotionColumn, Subject};
use super::{DrivenJoint, MotionError, unit_of};

/// Without a wish a row every twelfth, of a turn 30 degrees.
const PARTS: f64 = 12.0;
/// Nobody reads more rows than this; all samples are in the files.
const MOST: f64 = 1e5;
/// Places nearer to each other than this share of a step are the same.
const SAME: f64 = 1e-6;

/// Places at equal distances.
struct EvenPlaces {
    first: f64,
    step: f64,
    count: usize,
}

/// The rows of a study, whose table has its samples.
pub(super) fn rows(subject: &Subject, figures: &Figures) -> Result<Vec<MotionColumn>, MotionError> {
    let Some([first, second, .., last]) = figures.table.first().map(|column| &column.values[..]) else {
        return Ok(Vec::new());
    };
    let ends = [*first, *last];
    let places = places(subject, figures.full_turn, ends, second - first)?;
    let [every, begin] = [places.step, places.first - first].map(|way| way / (second - first));
    let on_samples = [every, begin].iter().all(|steps| (steps - steps.round()).abs() < SAME);
    let between: Vec<MotionColumn> = if on_samples {
        let [every, begin] = [every, begin].map(|steps| steps.round() as usize);
        figures.table.iter().map(|column| column.every(begin, every, places.count)).collect()
    } else {
        sampled(subject, &places, ends[1])?
    };
    let is_end = |place: f64, end: f64| (place - end).abs() < SAME * (second - first).abs();
    let at_last = places.first + places.step * (places.count as f64 - 1.0);
    let [head, tail] = [(places.first, ends[0]), (at_last, ends[1])]
        .map(|(place, end)| !figures.full_turn && (places.count == 0 || !is_end(place, end)));
    let with_ends = |column: &MotionColumn| {
        let rows = between
            .iter()
            .find(|column_between| column_between.name == column.name)
            .map_or(&[][..], |column_between| &column_between.values);
        let head = column.values.first().filter(|_| head);
        let values = head.into_iter().chain(rows).chain(column.values.last().filter(|_| tail)).copied();
        MotionColumn { values: values.collect(), ..column.clone() }
    };
    Ok(figures.table.iter().map(with_ends).collect())
}

/// Where rows are wanted: from the beginning of a range on, else at the multiples of the distance; of a turn up to before its end.
fn places(subject: &Subject, full_turn: bool, [first, last]: [f64; 2], sample: f64) -> Result<EvenPlaces, MotionError> {
    let way = (last - first).abs() + if full_turn { sample } else { 0.0 };
    let every = match subject.request.every {
        None => way / PARTS,
        // Beside change points, where samples lie and reactions are.
        Some(every) if subject.drive.between => (every / sample).round().max(1.0) * sample,
        Some(every) => every,
    };
    if !(every > 0.0 && way / every < MOST) {
        let unit = subject.request.units.of(&unit_of(subject.drive.motion));
        let every = rounded(every / unit.factor, 4);
        let message = format!("--every: a step of {every} {} gives no rows, or too many", unit.name);
        return Err(MotionError::Request(message));
    }
    let from_first = subject.request.every.is_none() || subject.drive.between || subject.request.range.is_some();
    let begin = if from_first { first } else { (first / every - SAME).ceil() * every };
    let left = way - (begin - first).abs();
    let near = SAME * sample.abs() / every;
    let count = match full_turn {
        true => (left / every - near).ceil(),
        false => (left / every + near).floor() + 1.0,
    };
    Ok(EvenPlaces { first: begin, step: every * sample.signum(), count: count.max(0.0) as usize })
}

/// What the study has at places beside its samples: the motion once more, through these places, as finely.
fn sampled(subject: &Subject, places: &EvenPlaces, last: f64) -> Result<Vec<MotionColumn>, MotionError> {
    let drive = subject.drive;
    let intervals = places.count.saturating_sub(1);
    if places.count == 0 {
        return Ok(Vec::new());
    }
    let (end, each) = match intervals {
        0 => (last, COUNT),
        _ => (places.first + places.step * intervals as f64, COUNT.div_ceil(intervals)),
    };
    let drive = DrivenJoint { range: Some([places.first, end]), shown: each * intervals.max(1), ..drive.clone() };
    let subject = Subject { drive: &drive, ..*subject };
    let table = drive::sample(subject.moved, &drive, None)?;
    let figures = figures::of(&subject, &table)?;
    Ok(figures.table.iter().map(|column| column.every(0, each, places.count)).collect())
}
