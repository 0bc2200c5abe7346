//! The constants at run time: what each is multiplied by, and the work that has been done.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

static FACTORS: [AtomicU64; NAMES.len()] = [const { AtomicU64::new(0x3FF0_0000_0000_0000) }; NAMES.len()];
static WORK: AtomicU64 = AtomicU64::new(0);
static LOOKS: AtomicU64 = AtomicU64::new(0);
/// Most work and most looks at constants.
static MOST: [AtomicU64; 2] = [const { AtomicU64::new(u64::MAX) }; 2];

/// Multiplies a constant by a factor.
pub fn set(constant: usize, factor: f64) {
    FACTORS[constant].store(factor.to_bits(), Relaxed);
}

/// Begins to count; panics when so much has been done.
pub fn begin(most: [u64; 2]) {
    (WORK.store(0, Relaxed), LOOKS.store(0, Relaxed));
    (MOST[0].store(most[0], Relaxed), MOST[1].store(most[1], Relaxed));
}

/// The work and the looks at constants since it began.
pub fn done() -> [u64; 2] {
    [WORK.load(Relaxed), LOOKS.load(Relaxed)]
}

fn count(counter: &AtomicU64, by: u64, most: &AtomicU64) {
    let now = counter.load(Relaxed) + by;
    counter.store(now, Relaxed);
    if now > most.load(Relaxed) {
        most.store(u64::MAX, Relaxed);
        panic!("endless");
    }
}

/// So many numbers have been computed.
pub(crate) fn work(amount: usize) {
    count(&WORK, amount as u64, &MOST[0]);
}

#[inline]
pub(crate) fn real(constant: usize, value: f64) -> f64 {
    count(&LOOKS, 1, &MOST[1]);
    value * f64::from_bits(FACTORS[constant].load(Relaxed))
}

/// At least 1.
#[inline]
pub(crate) fn count_of(constant: usize, value: u64) -> u64 {
    count(&LOOKS, 1, &MOST[1]);
    let factor = f64::from_bits(FACTORS[constant].load(Relaxed));
    if factor == 1.0 { value } else { ((value as f64 * factor).round() as u64).max(1) }
}
