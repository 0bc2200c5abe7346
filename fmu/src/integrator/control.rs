//! Lengths of steps, for every engine.

/// A step that would end at most this much further ends at the limit.
pub(crate) const STRETCH: f64 = 1.01;
/// Longest step, for motions that nothing else limits \[s\].
pub(crate) const LONGEST: f64 = 1e4;
/// Shortest step, in units of the spacing of floating-point times.
const SHORTEST: f64 = 16.0;
/// Times nearer to zero than this are spaced as if they were there \[s\].
const EARLY: f64 = 1e-6;

/// The shortest step at a time.
pub(crate) fn shortest(time: f64) -> f64 {
    SHORTEST * f64::EPSILON * time.abs().max(EARLY)
}

/// A proposed step within its limits; one that is no number is as long as they permit.
pub(crate) fn within(proposed: f64, shortest: f64, max_step: f64) -> f64 {
    proposed.min(LONGEST).min(max_step).max(shortest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_proposal_becomes_a_finite_step() {
        let least = shortest(0.0);
        for proposed in [0.0, 1e-300, 1.0, f64::INFINITY, f64::NAN] {
            let step = within(proposed, least, f64::INFINITY);
            assert!((least..=LONGEST).contains(&step), "{proposed} becomes {step}");
        }
        assert_eq!(within(1.0, least, 0.5), 0.5);
        assert!(shortest(1e9) > f64::EPSILON * 1e9);
    }
}
