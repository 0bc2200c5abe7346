//! Many runs of one program: each with its own settings, in as many threads as are wanted.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::{FailedRun, Finish, Run, points};

/// More threads than this only cost memory.
const MOST_THREADS: usize = 256;

/// Runs that differ in their settings only. A member's result has the bits of a single run, however many threads there are: members share the program and nothing
/// else.
#[derive(Debug)]
pub struct Ensemble<'a> {
    run: Run<'a>,
    /// Communication points, if not those of the experiment \[s\].
    times: Option<&'a [f64]>,
    model: Arc<Model>,
    /// None for the calling thread.
    threads: Option<ThreadPool>,
    stop: &'a AtomicBool,
}

/// The settings of a member: variables and their values, SI.
pub type Settings = Vec<(usize, f64)>;

/// How a member ended, or why it failed.
pub type Ended = Result<Finish, FailedRun>;

impl<'a> Ensemble<'a> {
    /// `threads`: 0 for one a processor, 1 for the calling one; 256 at most. Once `stop` is set, members end at their next communication point.
    ///
    /// # Errors
    /// The operating system gives no threads.
    pub fn new(
        run: Run<'a>,
        model: Arc<Model>,
        threads: usize,
        stop: &'a AtomicBool,
    ) -> Result<Self, ThreadPoolBuildError> {
        let pool = || ThreadPoolBuilder::new().num_threads(threads.min(MOST_THREADS)).build();
        let threads = (threads != 1).then(pool).transpose()?;
        Ok(Self { run, times: None, model, threads, stop })
    }

    /// The same with other communication points: ascending times within the experiment \[s\].
    #[must_use]
    pub fn at(self, times: &'a [f64]) -> Self {
        Self { times: Some(times), ..self }
    }

    /// How many threads run.
    pub fn threads(&self) -> usize {
        self.threads.as_ref().map_or(1, ThreadPool::current_num_threads)
    }

    /// Is the ensemble to end?
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Runs the members. What is collected from each, with `point` at every communication point: time \[s\] and the reported values; and how the run ended.
    /// In the order of the members.
    pub fn run<C: Send>(
        &self,
        members: &[Settings],
        begin: impl Fn() -> C + Sync,
        point: impl Fn(&mut C, f64, &[f64]) + Sync,
    ) -> Vec<(C, Ended)> {
        let one = |settings: &Settings| self.run_one(settings, begin(), &point);
        match &self.threads {
            Some(threads) => threads.install(|| members.par_iter().map(one).collect()),
            None => members.iter().map(one).collect(),
        }
    }

    fn run_one<C>(&self, settings: &Settings, mut collected: C, point: &impl Fn(&mut C, f64, &[f64])) -> (C, Ended) {
        if self.is_stopped() {
            let error = io::Error::from(io::ErrorKind::Interrupted).into();
            return (collected, Err(FailedRun { error, log: Vec::new() })); // a start takes its time, too
        }
        let mut run = self.run.clone();
        run.settings.extend_from_slice(settings);
        let report = |time, values: &[f64]| {
            if self.is_stopped() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            point(&mut collected, time, values);
            Ok(())
        };
        let mut instance = Instance::new(Arc::clone(&self.model));
        let ended = match self.times {
            Some(times) => run.start_at(&mut instance, times.iter().copied(), report),
            None => run.start_at(&mut instance, points(run.experiment), report),
        };
        (collected, ended)
    }
}
