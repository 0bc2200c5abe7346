//! Processor time of the present thread: independent of other programs.

use std::time::{Duration, Instant};

/// Does this platform measure the processor time of a thread? Otherwise it is wall time.
const OF_THE_THREAD: bool = cfg!(any(target_os = "linux", target_os = "macos"));
pub(crate) const NAME: &str = if OF_THE_THREAD { "processor time" } else { "wall time" };

#[derive(Clone, Copy)]
pub(crate) struct Clock {
    processor: Duration,
    wall: Instant,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Elapsed {
    pub processor: Duration,
    pub wall: Duration,
}

impl Elapsed {
    pub fn add(&mut self, other: Elapsed) {
        self.processor += other.processor;
        self.wall += other.wall;
    }

    /// The share of a processor that the thread had; 1 if nothing was measured.
    pub fn share(&self) -> f64 {
        if self.wall.is_zero() { 1.0 } else { self.processor.as_secs_f64() / self.wall.as_secs_f64() }
    }
}

impl Clock {
    pub fn now() -> Self {
        let wall = Instant::now();
        Self { processor: processor_time(), wall }
    }

    pub fn elapsed(&self) -> Elapsed {
        let wall = self.wall.elapsed();
        let processor = if OF_THE_THREAD { processor_time().saturating_sub(self.processor) } else { wall };
        Elapsed { processor, wall }
    }
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
fn processor_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    // Never negative: the clock begins with the thread.
    Duration::try_from(clock_gettime(ClockId::ThreadCPUTime)).unwrap_or_default()
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn processor_time() -> Duration {
    Duration::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_sleeps_uses_no_processor() {
        let clock = Clock::now();
        std::thread::sleep(Duration::from_millis(30));
        let Elapsed { processor, wall } = clock.elapsed();
        assert!(wall >= Duration::from_millis(30));
        assert!(!OF_THE_THREAD || processor < wall / 2, "{processor:?} of {wall:?}");
    }
}
