//! Where searches begin: at the values of the scene, and at points of a scrambled Sobol sequence (Burley, *J. Comput. Graph. Tech.* 9, 2020) in the box of the bounds and in smaller ones around
//! these values. A point depends on the seed and its number only.

use sobol_burley::{NUM_DIMENSIONS, sample};

/// Points of the sequence are 2^16 at most.
const LONGEST: usize = 1 << 16;
/// Where a point has no motion the search takes another, so often.
pub const TRIES: usize = 8;
/// As many searches as the sequence has points for.
pub const MOST_STARTS: usize = LONGEST / TRIES;
/// As many quantities as it has dimensions.
pub const MOST_QUANTITIES: usize = NUM_DIMENSIONS as usize;
/// The boxes: each is this share of the one before, in turns.
const SMALLER: f64 = 0.25;
const BOXES: i32 = 4;

/// The points that a search tries until it finds one with a motion: those of the scene, and of the box.
pub struct Starts<'a> {
    pub scene: &'a [f64],
    pub bounds: &'a [[f64; 2]],
    pub count: usize,
    pub seed: u64,
}

impl Starts<'_> {
    /// The points of a search, by its number.
    pub fn of(&self, number: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
        let tries = if self.is_boxed() { TRIES } else { 1 };
        (0..tries).map(move |again| self.point(number + again * self.count))
    }

    /// Have all quantities two bounds?
    fn is_boxed(&self) -> bool {
        self.bounds.iter().flatten().all(|bound| bound.is_finite())
    }

    fn point(&self, index: usize) -> Vec<f64> {
        if index == 0 || !self.is_boxed() {
            return self.scene.to_vec();
        }
        let share = SMALLER.powi((index % BOXES as usize) as i32);
        // Both halves of the seed count.
        let seed = (self.seed ^ (self.seed >> 32)) as u32;
        let value = |(place, (value, [low, high])): (usize, (&f64, &[f64; 2]))| {
            let width = share * (high - low);
            // Not by `clamp`: rounding may leave the largest beginning below the smallest.
            let begin = (value - 0.5 * width).min(high - width).max(*low);
            (begin + width * f64::from(sample((index % LONGEST) as u32, place as u32, seed))).min(*high)
        };
        self.scene.iter().zip(self.bounds).enumerate().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_within_the_bounds_and_those_of_the_seed() {
        let bounds = [[0.1, 8.0], [-1.0, 1.0]];
        let starts = |seed| Starts { scene: &[7.5, -1.0], bounds: &bounds, count: 16, seed };
        let all = |seed| (0..16).flat_map(|number| starts(seed).of(number).collect::<Vec<_>>()).collect::<Vec<_>>();
        assert_eq!(all(3), all(3));
        assert_ne!(all(3), all(4));
        assert_eq!(starts(3).of(0).next(), Some(vec![7.5, -1.0]));
        for point in all(3) {
            assert!(point.iter().zip(&bounds).all(|(value, [low, high])| (*low..=*high).contains(value)), "{point:?}");
        }
        // One of four is anywhere in the large box: in each eighth of each quantity.
        let large: Vec<Vec<f64>> = (4..=256).step_by(4).map(|index| starts(3).point(index)).collect();
        for eighth in 0..8 {
            let is_there = |start: &Vec<f64>, place: usize| {
                let [low, high] = bounds[place];
                (8.0 * (start[place] - low) / (high - low)) as usize == eighth
            };
            assert!((0..2).all(|place| large.iter().any(|large| is_there(large, place))), "{eighth}: {large:?}");
        }
        let open = Starts { scene: &[2.0], bounds: &[[0.0, f64::INFINITY]], count: 1, seed: 0 };
        assert_eq!(open.of(0).collect::<Vec<_>>(), [vec![2.0]]);
    }
}
