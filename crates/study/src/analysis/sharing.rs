//! Distribution of a friction force among redundant frictional contacts: one of many solutions.
//!
//! Where n of them hold one freedom, each may carry between all that it can one way and the other. They are filled one after the other: the first k carry all that they can, the next one sticks and carries
//! the rest, and those after it nothing. What all of them can is the same in any order.

use cotree::formulate::Formulated;
use cotree::model::Mechanism;
use nalgebra::DMatrix;

use super::contacts::{ContactKind, static_ratio, statuses};
use super::search::null_space;
use super::supports::{ELSEWHERE, Outcome, Rest, attempt, mask, not_determined, ranked, rows};
use super::variation::Variation;
use super::{AnalysisFailure, OperatingPoint};

/// Singular values of the loop equations count as zero below this share of the largest.
const DETERMINED: f64 = 1e-10;

/// Directions are the same within this share.
const PARALLEL: f64 = 1e-9;

/// What holds one freedom together.
struct SharedFreedom {
    /// What rubs: its place among what the mechanism holds, and 1 if it slides forwards as the first does, else -1.
    rubbing: Vec<(usize, f64)>,
    /// How many of them carry all that they can.
    full: usize,
    /// The sign of the force that is needed along the first.
    way: f64,
}

/// What holds something that fewer would hold.
pub(super) struct Sharing {
    groups: Vec<SharedFreedom>,
    /// What rubs where stops or freewheels hold it already.
    stopped: Vec<usize>,
    /// The names of everything in the groups, and of what is stopped.
    names: Vec<String>,
}

impl Sharing {
    /// Which of them slides first depends on how they share.
    pub fn has_no_verge(&self) -> AnalysisFailure {
        let names: Vec<String> = self.names.iter().map(|name| format!("`{name}`")).collect();
        AnalysisFailure::Other(format!(
            "{} share one load: which of them is at its friction limit is not determined; set the others by `--mode NAME=idle`",
            names.join(", ")
        ))
    }
}

/// What sticks at a point and holds with others what fewer of them would hold; none if there is no such thing.
///
/// # Errors
/// They hold more freedoms together than can be told apart.
pub(super) fn sharing(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<Option<Sharing>, AnalysisFailure> {
    let [count, all] = ranked(formulated, variation, point)?;
    if count == all {
        return Ok(None);
    }
    let mechanism = &*formulated.equations.system.mechanism;
    let without = |left_out: &[usize]| {
        let mut point = point.clone();
        left_out.iter().for_each(|&index| point.set_discrete(mask(mechanism, index, false)));
        point
    };
    let mut concerned = Vec::new();
    for status in statuses(formulated, point).into_iter().filter(|status| status.closed) {
        if ranked(formulated, variation, &without(&[status.index]))?[1] == all {
            concerned.push(status);
        }
    }
    let rubbing = concerned.iter().filter(|concerned| matches!(concerned.kind, ContactKind::Friction { .. }));
    let rubbing: Vec<usize> = rubbing.map(|rubbing| rubbing.index).collect();
    let others = without(&rubbing);
    let freedoms = all - ranked(formulated, variation, &others)?[1];
    let along = along(formulated, variation, (point, &others), &rubbing)?;
    let names: Vec<String> = concerned.into_iter().map(|concerned| concerned.name).collect();
    let (groups, stopped) = groups(&along, &rubbing);
    match () {
        () if rubbing.is_empty() => Ok(None),
        () if groups.len() != freedoms => Err(not_determined(&names)),
        () => Ok(Some(Sharing { groups, stopped, names })),
    }
}

/// How fast each that rubs slides with what the others leave free, in natural units.
fn along(
    formulated: &Formulated,
    variation: &Variation,
    (point, others): (&OperatingPoint, &OperatingPoint),
    rubbing: &[usize],
) -> Result<DMatrix<f64>, AnalysisFailure> {
    let ((all, places), (without, _)) = (rows(formulated, variation, point)?, rows(formulated, variation, others)?);
    let rows = rubbing.iter().filter_map(|&index| formulated.equations.row_of_contact(index));
    let rows: Vec<usize> = rows.filter_map(|row| places.iter().position(|place| *place == row)).collect();
    Ok(all.select_rows(&rows) * null_space(&without, DETERMINED)?)
}

/// Those that slide together, and those that cannot.
fn groups(along: &DMatrix<f64>, rubbing: &[usize]) -> (Vec<SharedFreedom>, Vec<usize>) {
    let (mut groups, mut stopped): (Vec<(usize, SharedFreedom)>, Vec<usize>) = (Vec::new(), Vec::new());
    let fastest = along.row_iter().map(|row| row.norm()).fold(1.0, f64::max);
    for (place, &index) in rubbing.iter().enumerate() {
        let row = along.row(place);
        if row.norm() <= PARALLEL * fastest {
            stopped.push(index);
            continue;
        }
        let cosine = |first: usize| row.dot(&along.row(first)) / (row.norm() * along.row(first).norm());
        let known = groups.iter_mut().find(|(first, _)| cosine(*first).abs() > 1.0 - PARALLEL);
        match known {
            Some((first, group)) => group.rubbing.push((index, cosine(*first).signum())),
            None => groups.push((place, SharedFreedom { rubbing: vec![(index, 1.0)], full: 0, way: 0.0 })),
        }
    }
    (groups.into_iter().map(|(_, group)| group).collect(), stopped)
}

/// Searches for a rest in which they share what they hold.
pub(super) fn share(
    formulated: &Formulated,
    variation: &Variation,
    mut point: OperatingPoint,
    mut sharing: Sharing,
) -> Result<Outcome, AnalysisFailure> {
    let mechanism = &*formulated.equations.system.mechanism;
    let rubbing = sharing.groups.iter().flat_map(|group| &group.rubbing).map(|(index, _)| index);
    rubbing.chain(&sharing.stopped).for_each(|&index| point.set_discrete(mask(mechanism, index, false)));
    loop {
        let mut tried = point.clone();
        for group in &sharing.groups {
            tried.set_discrete(mask(mechanism, group.rubbing[group.full].0, true));
        }
        let (failure, found) = match attempt(formulated, variation, tried) {
            Outcome::Slides(failure, found) => (failure, found),
            Outcome::Rests(rest) => return Ok(Outcome::Rests(Rest { shared: sharing.names, ..rest })),
            Outcome::Fails(failure) => return Ok(Outcome::Fails(failure)),
        };
        let here = statuses(formulated, &found);
        let overloaded = |group: &SharedFreedom| {
            let status = here.iter().find(|status| status.index == group.rubbing[group.full].0);
            status.filter(|status| status.carries_too_much()).map(|status| status.force * group.rubbing[group.full].1)
        };
        let next = sharing.groups.iter_mut().find_map(|group| overloaded(group).map(|force| (group, force)));
        // What slides shares nothing.
        let Some((group, force)) = next else { return Ok(Outcome::Slides(failure, found)) };
        if group.full == 0 {
            group.way = force.signum();
        }
        if force * group.way < 0.0 {
            return Err(not_determined(&sharing.names));
        }
        if group.full + 1 == group.rubbing.len() {
            return Ok(Outcome::Slides(too_little(mechanism, group), found));
        }
        let (index, sign) = group.rubbing[group.full];
        let way = sign * group.way;
        group.full += 1;
        // From there: the forces, and the signs of what presses, are nearly what they will be.
        point = *found;
        for (index, _) in sharing.groups.iter().flat_map(|group| &group.rubbing) {
            let_go(formulated, &mut point, *index);
        }
        carry_all(formulated, &mut point, index, -way);
    }
}

/// Lets something that rubs carry all that it can, against sliding this way.
pub(super) fn carry_all(formulated: &Formulated, point: &mut OperatingPoint, index: usize, way: f64) {
    let mechanism = &*formulated.equations.system.mechanism;
    let friction = &mechanism.contacts[index];
    let (Some(slip), Some(direction)) = (&friction.slip, friction.state.direction) else { return };
    // Its level at rest.
    point.set_discrete((direction.0, way * static_ratio(formulated, point, slip)));
    let_go(formulated, point, index);
}

/// Lets something no longer hold.
fn let_go(formulated: &Formulated, point: &mut OperatingPoint, index: usize) {
    point.set_discrete(mask(&formulated.equations.system.mechanism, index, false));
    if let Some(row) = formulated.equations.row_of_contact(index) {
        point.reactions_mut()[row] = 0.0;
    }
}

/// All that they can is not enough.
fn too_little(mechanism: &Mechanism, group: &SharedFreedom) -> AnalysisFailure {
    let name = |(index, _): &(usize, f64)| format!("`{}`", mechanism.contacts[*index].name);
    let why = match &group.rubbing.iter().map(name).collect::<Vec<_>>()[..] {
        [one] => format!("{one} would exceed its friction limit"),
        all => format!("{} would exceed their friction limits together", all.join(", ")),
    };
    AnalysisFailure::Unfit { why: format!("{why} and slides from this configuration; {ELSEWHERE}") }
}
