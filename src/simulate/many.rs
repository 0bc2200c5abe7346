//! Many runs of one program: each with its own settings, in as many threads as are wanted.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cotree_fmu::model::Model;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::{Run, RunError};

/// Runs that differ in their settings only. A member's result is that of a single run, bit for bit: members share the program and
/// nothing else, so neither their neighbours nor the number of threads matter.
#[derive(Debug)]
pub struct Ensemble<'a> {
    run: Run<'a>,
    model: Arc<Model>,
    threads: ThreadPool,
    stop: &'a AtomicBool,
}

/// The settings of a member: variables and their values, SI.
pub type Settings = Vec<(usize, f64)>;

impl<'a> Ensemble<'a> {
    /// `threads`: 0 for one a processor. Once `stop` is set, members end at their next communication point.
    ///
    /// # Errors
    /// The operating system gives no threads.
    pub fn new(
        run: Run<'a>,
        model: Arc<Model>,
        threads: usize,
        stop: &'a AtomicBool,
    ) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self { run, model, threads: ThreadPoolBuilder::new().num_threads(threads).build()?, stop })
    }

    /// How many members run at a time.
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Is the ensemble to end?
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Runs the members. What is collected from each, with `point` at every communication point: time \[s\] and the reported values; and why the run ended
    /// early if it did. In the order of the members.
    pub fn run<C: Send>(
        &self,
        members: &[Settings],
        begin: impl Fn() -> C + Sync,
        point: impl Fn(&mut C, f64, &[f64]) + Sync,
    ) -> Vec<(C, Result<(), RunError>)> {
        let member = |settings: &Settings| {
            let mut collected = begin();
            let ended = self.member(settings, |time, values| point(&mut collected, time, values));
            (collected, ended)
        };
        self.threads.install(|| members.par_iter().with_max_len(1).map(member).collect())
    }

    fn member(&self, settings: &[(usize, f64)], mut point: impl FnMut(f64, &[f64])) -> Result<(), RunError> {
        let mut run = self.run.clone();
        run.settings.extend_from_slice(settings);
        run.start(Arc::clone(&self.model), |time, values| {
            if self.is_stopped() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            point(time, values);
            Ok(())
        })
        .map(drop)
    }
}
