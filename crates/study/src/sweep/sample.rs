//! Random numbers that depend only on the seed, the factor and the number of the run: the runs of a design are never stored, and a part of a sweep costs what its own runs cost.

use super::FactorValues;

/// How random values are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Each by itself.
    Random,
    /// One in each of as many equally likely strata as there are runs: Latin hypercube (McKay, Beckman and Conover 1979).
    Latin,
}

/// The random values of one factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    stream: Stream,
    /// How many runs there are.
    count: usize,
    /// Which stratum each run has; none if runs are drawn by themselves.
    strata: Option<Permutation>,
}

impl Draw {
    /// Of a factor by its place, for so many runs.
    pub fn new(kind: Sampling, count: usize, seed: u64, factor: usize) -> Self {
        // Streams of different factors and seeds have nothing to do with each other: their starts are mixed.
        let stream = Stream(mixed(mixed(seed).wrapping_add(factor as u64)));
        let strata = (kind == Sampling::Latin).then(|| Permutation::new(count as u64, mixed(stream.0)));
        Draw { stream, count, strata }
    }

    /// The value of a run.
    pub fn value(&self, values: &FactorValues, run: usize) -> f64 {
        let within = self.stream.uniform(run as u64);
        values.at(match &self.strata {
            None => within,
            Some(strata) => (strata.at(run as u64) as f64 + within) / self.count as f64,
        })
    }
}

impl FactorValues {
    /// The value below which this share of all values lies; of levels the one at that share.
    fn at(&self, share: f64) -> f64 {
        match self {
            FactorValues::Levels(levels) => levels[((share * levels.len() as f64) as usize).min(levels.len() - 1)],
            FactorValues::Uniform(low, high) => low + (high - low) * share,
            FactorValues::Normal(mean, deviation) => mean + deviation * normal_quantile(share),
        }
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014), whose state is a counter.
#[derive(Clone, Debug, PartialEq)]
struct Stream(u64);

/// The odd integer closest to 2^64 over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mixed(state: u64) -> u64 {
    let z = state.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Stream {
    /// The number at a place, between 0 and 1, neither of them.
    fn uniform(&self, place: u64) -> f64 {
        let number = mixed(self.0.wrapping_add(place.wrapping_mul(GOLDEN)));
        ((number >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

/// A permutation of the numbers below a count, found for one number at a time: a Feistel network on the next even power of two, applied again until it falls below the count
/// (Black and Rogaway, CT-RSA 2002, "cycle walking").
#[derive(Clone, Debug, PartialEq)]
struct Permutation {
    count: u64,
    /// Bits of one half.
    half: u32,
    key: u64,
}

/// Rounds of the network: four make a random function of each half a random permutation (Luby and Rackoff 1988); halves of few bits take more.
const FEISTEL_ROUNDS: u64 = 8;

impl Permutation {
    fn new(count: u64, key: u64) -> Self {
        let bits = u64::BITS - count.saturating_sub(1).leading_zeros();
        Permutation { count, half: bits.div_ceil(2).max(1), key }
    }

    fn at(&self, place: u64) -> u64 {
        let mut found = self.permuted(place);
        // The way through the larger range comes back below the count, where it began; it is four times as large at most.
        while found >= self.count {
            found = self.permuted(found);
        }
        found
    }

    /// Among all numbers of both halves.
    fn permuted(&self, place: u64) -> u64 {
        let mask = (1 << self.half) - 1;
        let (mut left, mut right) = (place >> self.half, place & mask);
        for round in 0..FEISTEL_ROUNDS {
            let scrambled = mixed(self.key.wrapping_add(round.wrapping_mul(GOLDEN)) ^ mixed(right)) & mask;
            (left, right) = (right, left ^ scrambled);
        }
        (left << self.half) | right
    }
}

/// Inverse of the standard normal distribution: Acklam's rational approximation (relative error 1.2e-9), refined by one step of Halley's method.
fn normal_quantile(share: f64) -> f64 {
    const TAIL: f64 = 0.02425;
    const A: [f64; 6] = [
        -3.969683028665376e1,
        2.209460984245205e2,
        -2.759285104469687e2,
        1.38357751867269e2,
        -3.066479806614716e1,
        2.506628277459239,
    ];
    const B: [f64; 6] = [
        -5.447609879822406e1,
        1.615858368580409e2,
        -1.556989798598866e2,
        6.680131188771972e1,
        -1.328068155288572e1,
        1.0,
    ];
    const C: [f64; 6] = [
        -7.784894002430293e-3,
        -3.223964580411365e-1,
        -2.400758277161838,
        -2.549732539343734,
        4.374664141464968,
        2.938163982698783,
    ];
    const D: [f64; 5] = [7.784695709041462e-3, 3.224671290700398e-1, 2.445134137142996, 3.754408661907416, 1.0];
    let polynomial = |c: &[f64], x: f64| c.iter().fold(0.0, |sum, c| sum * x + c);
    let tail = |q: f64| polynomial(&C, q) / polynomial(&D, q);
    let start = match share {
        low if low < TAIL => tail((-2.0 * libm::log(low)).sqrt()),
        high if high > 1.0 - TAIL => -tail((-2.0 * libm::log(1.0 - high)).sqrt()),
        _ => {
            let (q, r) = (share - 0.5, (share - 0.5) * (share - 0.5));
            polynomial(&A, r) * q / polynomial(&B, r)
        }
    };
    let error = 0.5 * libm::erfc(-start / std::f64::consts::SQRT_2) - share;
    let step = error * (2.0 * std::f64::consts::PI).sqrt() * libm::exp(0.5 * start * start);
    start - step / (1.0 + 0.5 * start * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of one factor for all runs.
    fn drawn(kind: Sampling, values: &FactorValues, count: usize, seed: u64, factor: usize) -> Vec<f64> {
        let draw = Draw::new(kind, count, seed, factor);
        (0..count).map(|run| draw.value(values, run)).collect()
    }

    #[test]
    fn each_stratum_is_met_once_however_many_there_are() {
        for count in (1..70).chain([1000, 4096, 4097]) {
            for key in 0..3 {
                let strata = Permutation::new(count, mixed(key));
                let mut met: Vec<u64> = (0..count).map(|place| strata.at(place)).collect();
                met.sort_unstable();
                assert!(met.into_iter().eq(0..count), "{count}");
            }
        }
    }

    #[test]
    fn strata_are_as_good_as_shuffled() {
        // Of a random permutation of n numbers: the correlation of place and number is normal with variance 1/(n - 1), that of numbers that follow each other about the same,
        // and the number of fixed points has mean and variance 1.
        let (count, keys) = (1000_u64, 200);
        let mean = (count - 1) as f64 / 2.0;
        let variance = ((count * count - 1) as f64) / 12.0;
        let (mut along, mut following, mut fixed) = (0.0, 0.0, 0.0);
        for key in 0..keys {
            let strata = Permutation::new(count, mixed(key));
            let met: Vec<f64> = (0..count).map(|place| strata.at(place) as f64 - mean).collect();
            let places = (0..count).map(|place| place as f64 - mean);
            let with: f64 = met.iter().zip(places).map(|(number, place)| number * place).sum();
            let next: f64 = met.windows(2).map(|pair| pair[0] * pair[1]).sum();
            along += (with / count as f64 / variance).powi(2) * (count - 1) as f64 / keys as f64;
            following += (next / count as f64 / variance).powi(2) * (count - 1) as f64 / keys as f64;
            fixed += (0..count).filter(|&place| strata.at(place) == place).count() as f64 / keys as f64;
        }
        // Means of 200 squares of normal numbers, within four of their standard deviations.
        assert!((along - 1.0).abs() < 0.4 && (following - 1.0).abs() < 0.4, "{along}, {following}");
        assert!((fixed - 1.0).abs() < 0.3, "{fixed}");
    }

    #[test]
    fn a_value_is_found_without_those_before_it() {
        let last = 3_999_999_999;
        for kind in [Sampling::Random, Sampling::Latin] {
            let draw = Draw::new(kind, last + 1, 3, 1);
            let value = draw.value(&FactorValues::Uniform(0.0, 1.0), last);
            assert!((0.0..1.0).contains(&value) && value == draw.value(&FactorValues::Uniform(0.0, 1.0), last));
        }
    }

    #[test]
    fn quantiles_invert_the_distribution() {
        // Abramowitz and Stegun, table 26.5, and symmetry.
        for (share, value) in [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.999, 3.090_232_306_167_813_5)] {
            assert!((normal_quantile(share) - value).abs() < 1e-14, "{share}: {}", normal_quantile(share));
        }
        for index in 1..1000 {
            let share = f64::from(index) / 1000.0;
            let back = 0.5 * libm::erfc(-normal_quantile(share) / std::f64::consts::SQRT_2);
            assert!((back - share).abs() < 1e-15, "{share}");
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_value_in_each_stratum() {
        for factor in 0..3 {
            let mut values = drawn(Sampling::Latin, &FactorValues::Uniform(2.0, 5.0), 1000, 7, factor);
            values.sort_by(f64::total_cmp);
            for (index, value) in values.iter().enumerate() {
                let stratum = 2.0 + 3.0 * index as f64 / 1000.0;
                assert!((stratum..=stratum + 0.003).contains(value));
            }
        }
    }

    #[test]
    fn random_values_have_the_moments_of_their_distribution() {
        let moments = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64)
        };
        let count = 100_000;
        for seed in 0..4 {
            let (mean, variance) = moments(&drawn(Sampling::Random, &FactorValues::Uniform(-1.0, 1.0), count, seed, 0));
            assert!(mean.abs() < 0.01 && (variance - 1.0 / 3.0).abs() < 0.01, "{mean}, {variance}");
            let (mean, variance) = moments(&drawn(Sampling::Random, &FactorValues::Normal(3.0, 0.5), count, seed, 1));
            assert!((mean - 3.0).abs() < 0.01 && (variance - 0.25).abs() < 0.01, "{mean}, {variance}");
        }
    }

    #[test]
    fn streams_differ_by_seed_and_factor_and_repeat() {
        let first = |seed, factor| drawn(Sampling::Random, &FactorValues::Uniform(0.0, 1.0), 4, seed, factor);
        assert_eq!(first(1, 0), first(1, 0));
        assert_ne!(first(1, 0), first(1, 1));
        assert_ne!(first(1, 0), first(2, 0));
        // Levels are each as likely.
        let levels = drawn(Sampling::Latin, &FactorValues::Levels(vec![1.0, 2.0]), 10, 0, 0);
        assert_eq!(levels.iter().filter(|value| **value == 1.0).count(), 5);
    }
}
