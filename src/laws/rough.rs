//! Where a function of one variable turns at once: between two places its slope changes by far more than around them, or its value by
//! what the slopes do not explain.

/// A place with the value and the slope there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughPlace {
    pub at: f64,
    pub value: [f64; 2],
}

/// What counts as rough.
pub(crate) struct Roughness {
    /// A slope that changes so many times as much from one place to the next as it does two places away may jump between them.
    pub bends: f64,
    /// Below this share of the largest value, or of the largest slope, a change is none.
    pub least: f64,
    /// So many halvings find the place.
    pub halvings: usize,
    /// The largest value and slope.
    pub largest: [f64; 2],
}

impl Roughness {
    /// The steps from one of these spots to the next in which the function may turn at once.
    pub fn steps(&self, spots: &[RoughPlace]) -> Vec<usize> {
        let pairs: Vec<[RoughPlace; 2]> = spots.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let change = |[one, other]: &[RoughPlace; 2]| (other.value[1] - one.value[1]).abs();
        let is_rough = |step: usize, pair: &[RoughPlace; 2]| {
            let around = [step.checked_sub(2), Some(step + 2)].into_iter().flatten().filter_map(|near| pairs.get(near));
            let around = around.map(change).fold(0.0, f64::max);
            let bent = change(pair);
            let way = pair[1].at - pair[0].at;
            // Written so that what is not finite may be a jump.
            let is_smooth = bent <= self.bends * around || bent <= self.least * self.largest[1];
            let is_explained = unexplained(pair) <= way * around + self.least * self.largest[0];
            !(is_smooth && is_explained)
        };
        pairs.iter().enumerate().filter(|(step, pair)| is_rough(*step, pair)).map(|(step, _)| step).collect()
    }

    /// The two places next to each other, between these, where the function turns most.
    pub fn sharpest(&self, mut sides: [RoughPlace; 2], of: impl Fn(f64) -> [f64; 2]) -> [RoughPlace; 2] {
        let size = self.largest.map(|largest| largest.max(f64::MIN_POSITIVE));
        let turns = |pair: [RoughPlace; 2]| {
            unexplained(&pair) / size[0] + (pair[1].value[1] - pair[0].value[1]).abs() / size[1]
        };
        for _ in 0..self.halvings {
            let [low, high] = sides;
            let at = 0.5 * (low.at + high.at);
            let middle = RoughPlace { at, value: of(at) };
            sides = if turns([low, middle]) <= turns([middle, high]) { [middle, high] } else { [low, middle] };
        }
        sides
    }
}

/// By how much a value changes between two places beyond what the slopes there make of it.
fn unexplained([one, other]: &[RoughPlace; 2]) -> f64 {
    let way = other.at - one.at;
    (other.value[0] - one.value[0] - 0.5 * way * (one.value[1] + other.value[1])).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The places of jumps and corners of a function from 0 to 1, looked at in a hundred steps.
    fn found(of: impl Fn(f64) -> [f64; 2]) -> Vec<f64> {
        let rough = Roughness { bends: 3.0, least: 1e-5, halvings: 50, largest: [1.0, 10.0] };
        let spots: Vec<RoughPlace> =
            (0..=100).map(|step| step as f64 / 100.0).map(|at| RoughPlace { at, value: of(at) }).collect();
        let sides = |step: usize| rough.sharpest([spots[step], spots[step + 1]], &of);
        rough.steps(&spots).into_iter().map(sides).map(|[low, high]| 0.5 * (low.at + high.at)).collect()
    }

    #[test]
    fn jumps_and_corners_are_where_they_are() {
        assert!(found(|x| [(7.0 * x).sin(), 7.0 * (7.0 * x).cos()]).is_empty());
        let step = found(|x| [f64::from(u8::from(x > 0.4321)), 0.0]);
        assert!(!step.is_empty() && step.iter().all(|place| (place - 0.4321).abs() < 1e-12), "{step:?}");
        let corner = found(|x| [(x - 0.777).abs(), (x - 0.777).signum()]);
        assert!(!corner.is_empty() && corner.iter().all(|place| (place - 0.777).abs() < 1e-12), "{corner:?}");
    }
}
