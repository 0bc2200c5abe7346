//! Many runs of one program: each with its own settings, in as many threads as are wanted, and in each thread some of them side by side.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cotree_fmu::instance::{Batch, Instance};
use cotree_fmu::model::Model;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::journey::{Journey, travel_all};
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
        let some =
            |batch: &mut Option<Batch>, members: &[Settings]| self.run_some(batch.as_mut(), members, &begin, &point);
        let batch = || Batch::new(&self.model);
        // No thread is to be idle while another one runs several.
        let together =
            members.len().div_ceil(self.threads()).clamp(1, if batch().is_some() { Batch::MEMBERS } else { 1 });
        let groups = members.par_chunks(together);
        match &self.threads {
            Some(threads) => threads.install(|| groups.map_init(batch, some).flatten_iter().collect()),
            None => {
                let mut batch = batch();
                members.chunks(together).flat_map(|members| some(&mut batch, members)).collect()
            }
        }
    }

    /// Runs some members, side by side if there is a batch.
    fn run_some<C>(
        &self,
        batch: Option<&mut Batch>,
        members: &[Settings],
        begin: impl Fn() -> C,
        point: impl Fn(&mut C, f64, &[f64]),
    ) -> Vec<(C, Ended)> {
        let with_settings = |settings: &Settings| {
            let mut run = self.run.clone();
            run.settings.extend_from_slice(settings);
            run
        };
        let runs: Vec<Run> = members.iter().map(with_settings).collect();
        let mut collected: Vec<C> = members.iter().map(|_| begin()).collect();
        if self.is_stopped() {
            // A start takes its time, too.
            let stopped = |collected| (collected, Err(FailedRun { error: interrupted().into(), log: Vec::new() }));
            return collected.into_iter().map(stopped).collect();
        }
        let mut instances: Vec<Instance> = members.iter().map(|_| Instance::new(Arc::clone(&self.model))).collect();
        let mut journeys: Vec<_> = runs
            .iter()
            .zip(&mut collected)
            .map(|(run, collected)| Journey::new(run, self.report(collected, &point)))
            .collect();
        match self.times {
            Some(times) => travel_all(&mut journeys, &mut instances, times.iter().copied(), batch),
            None => travel_all(&mut journeys, &mut instances, points(self.run.experiment), batch),
        }
        let ended: Vec<Ended> =
            journeys.into_iter().zip(&mut instances).map(|(journey, instance)| journey.end(instance)).collect();
        collected.into_iter().zip(ended).collect()
    }

    /// What a member does at a communication point.
    fn report<C>(
        &self,
        collected: &mut C,
        point: &impl Fn(&mut C, f64, &[f64]),
    ) -> impl FnMut(f64, &[f64]) -> io::Result<()> {
        move |time, values| {
            if self.is_stopped() {
                return Err(interrupted());
            }
            point(collected, time, values);
            Ok(())
        }
    }
}

fn interrupted() -> io::Error {
    io::ErrorKind::Interrupted.into()
}
