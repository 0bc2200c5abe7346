//! Comparisons in laws of time whose sides differ by rounding errors alone for a while: which piece holds there is chance.

use std::collections::BTreeSet;

use super::jumps::{PLACES, TimeLaw, formulas, share};
use crate::diagnostic::Fault;
use crate::expr::{Binary, Expr, ExprNode};
use crate::model::{Mechanism, Part};
use crate::typeset::rounded;

/// Sides that differ by less than this share of their sizes do so by the rounding errors of a few operations.
const ROUNDING: f64 = 1e-14;
/// That counts if it lasts longer than this share of the experiment on both sides.
const LASTS: f64 = 1e-6;
/// Sections of an interval in which the sides come closest to each other.
const SECTIONS: usize = 40;

/// A warning for each load or driver whose law has such a comparison.
pub(crate) fn touches(mechanism: &Mechanism) -> Vec<Fault> {
    let kinds = [("load", &mechanism.loads), ("driver", &mechanism.drivers)];
    let parts = kinds.into_iter().flat_map(|(kind, parts)| parts.iter().map(move |part| (kind, part)));
    parts.filter_map(|(kind, part)| Some(warning(kind, part, first_touch(mechanism, part)?))).collect()
}

fn warning(kind: &str, part: &Part, time: f64) -> Fault {
    let message = format!(
        "the law of {kind} `{}` compares two sides that differ by rounding errors only near t = {} s: which piece is active there is not determined",
        part.name,
        rounded(time, 4)
    );
    Fault::warning("scene::equal_sides", message, part.span).label("compares them").help(
        "compare the difference of the sides, such as `0 < t^4` for `1 - t^4 < 1`, or compare with a limit that is clearly crossed, such as 0.999 for 1",
    )
}

/// When the sides of a comparison come so close first.
fn first_touch(mechanism: &Mechanism, part: &Part) -> Option<f64> {
    let experiment = mechanism.experiment;
    let span = [experiment.start, experiment.stop - experiment.start];
    let laws = formulas(part).into_iter().filter_map(|formula| TimeLaw::of_time(mechanism, formula));
    let times = laws
        .flat_map(|law| comparisons(&law).into_iter().filter_map(|sides| touch(&law, sides, span)).collect::<Vec<_>>());
    times.min_by(f64::total_cmp)
}

/// The sides of the comparisons in a law.
fn comparisons(law: &TimeLaw) -> BTreeSet<[Expr; 2]> {
    let sides = |expr: Expr| match law.arena.node(expr) {
        ExprNode::Binary(Binary::Less | Binary::LessEqual, a, b) => Some([a, b]),
        _ => None,
    };
    law.arena.reachable([law.value[0]]).into_iter().filter_map(sides).collect()
}

fn touch(law: &TimeLaw, sides: [Expr; 2], [start, span]: [f64; 2]) -> Option<f64> {
    let apart = |place: f64| {
        let values = law.at(&sides, start + span * place);
        (values[0] - values[1]).abs() / f64::max(values[0].abs() + values[1].abs(), f64::MIN_POSITIVE)
    };
    // Written so that what is no number does not touch. Where both sides are equal they mean to be.
    let lasts = |place: f64| {
        let around = [place - LASTS, place, place + LASTS].map(apart);
        around.iter().all(|gap| *gap <= ROUNDING) && around.iter().any(|gap| *gap > 0.0)
    };
    let gaps: Vec<f64> = (0..=PLACES).map(|place| apart(share(place))).collect();
    (0..=PLACES).find_map(|place| {
        let here = share(place);
        if gaps[place] <= ROUNDING && lasts(here) {
            return Some(start + span * here);
        }
        let [before, behind] = [gaps.get(place.wrapping_sub(1))?, gaps.get(place + 1)?];
        let lowest = gaps[place] > 0.0 && gaps[place] <= *before && gaps[place] <= *behind;
        // Towards sides that are equal from somewhere on, too.
        let ends = gaps[place] > 0.0 && *behind == 0.0;
        let closest = (lowest || ends).then(|| closest(apart, [share(place - 1), share(place + 1)]))?;
        lasts(closest).then_some(start + span * closest)
    })
}

/// Where two sides come closest to each other without being equal, between two places.
fn closest(apart: impl Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    let mut best = (f64::INFINITY, 0.5 * (from + to));
    for _ in 0..SECTIONS {
        let inner = [from + (to - from) / 3.0, to - (to - from) / 3.0];
        let gaps = inner.map(&apart);
        for (gap, place) in gaps.into_iter().zip(inner) {
            if gap > 0.0 && gap < best.0 {
                best = (gap, place);
            }
        }
        // What is equal lies behind.
        match gaps[1] == 0.0 || gaps[0] < gaps[1] {
            true => to = inner[1],
            false => from = inner[0],
        }
    }
    best.1
}
