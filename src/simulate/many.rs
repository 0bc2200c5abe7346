//! Many runs of one program: each with its own settings, several at a time in the lanes of a processor, in as many threads as are wanted.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cotree_fmu::instance::{self, Inaccuracy, Instance, Lanes};
use cotree_fmu::model::Model;
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSlice;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::simulation::Simulation;
use super::{Run, RunError};

/// Members that a thread takes at a time, at most: enough that its lanes are seldom empty.
const SHARE: usize = 64;
/// More threads than this only cost memory.
const MOST_THREADS: usize = 256;

/// Runs that differ in their settings only. A member's result is that of a single run within the tolerance, and has the same bits whatever its neighbours are and
/// however many lanes and threads there are: members share the program and nothing else.
#[derive(Debug)]
pub struct Ensemble<'a> {
    run: Run<'a>,
    model: Arc<Model>,
    threads: ThreadPool,
    lanes: usize,
    stop: &'a AtomicBool,
}

/// The settings of a member: variables and their values, SI.
pub type Settings = Vec<(usize, f64)>;

/// Why a member ended early, or whether rounding errors are larger than its tolerance.
pub type Ended = Result<Option<Inaccuracy>, RunError>;

impl<'a> Ensemble<'a> {
    /// `threads`: 0 for one a processor; 256 at most. `lanes`: 1 to [`instance::MOST_LANES`] members at a time in each; 0 for runs with the very bits of single ones. Once `stop` is set, members end at their next
    /// communication point.
    ///
    /// # Errors
    /// The operating system gives no threads.
    pub fn new(
        run: Run<'a>,
        model: Arc<Model>,
        (threads, lanes): (usize, usize),
        stop: &'a AtomicBool,
    ) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            run,
            model,
            threads: ThreadPoolBuilder::new().num_threads(threads.min(MOST_THREADS)).build()?,
            lanes,
            stop,
        })
    }

    /// How many threads run.
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
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
        let share = members.len().div_ceil(self.threads()).clamp(1, SHARE);
        let some = |members: &[Settings]| self.run_some(members, &begin, &point);
        self.threads.install(|| members.par_chunks(share).with_max_len(1).flat_map_iter(some).collect())
    }

    /// The same in one thread.
    fn run_some<C>(
        &self,
        members: &[Settings],
        begin: &impl Fn() -> C,
        point: &impl Fn(&mut C, f64, &[f64]),
    ) -> Vec<(C, Ended)> {
        let mut runs: Vec<Run> = members.iter().map(|_| self.run.clone()).collect();
        runs.iter_mut().zip(members).for_each(|(run, settings)| run.settings.extend_from_slice(settings));
        let mut collected: Vec<(C, Ended)> = members.iter().map(|_| (begin(), Ok(None))).collect();
        let started = runs.iter().zip(&mut collected).filter_map(|(run, (collected, ended))| {
            if self.is_stopped() {
                *ended = Err(RunError::Output(io::ErrorKind::Interrupted.into())); // a start takes its time, too
                return None;
            }
            let report = |time: f64, values: &[f64]| {
                if self.is_stopped() {
                    return Err(io::ErrorKind::Interrupted.into());
                }
                point(collected, time, values);
                Ok(())
            };
            match Simulation::new(run, Arc::clone(&self.model), report) {
                Ok(simulation) => Some(Member { simulation, ended }),
                Err(error) => {
                    *ended = Err(error);
                    None
                }
            }
        });
        Lanes::new(&self.model, self.run.experiment.tolerance, self.lanes).run(started, Member::end);
        collected
    }
}

/// A run in a lane, and how it ends.
struct Member<'a, R> {
    simulation: Simulation<'a, R>,
    ended: &'a mut Ended,
}

impl<R> Member<'_, R> {
    fn end(mut self) {
        if let Ok(inaccuracy) = self.ended {
            *inaccuracy = self.simulation.instance.take_inaccuracy();
        }
    }
}

impl<R: FnMut(f64, &[f64]) -> io::Result<()>> instance::Member for Member<'_, R> {
    fn instance(&mut self) -> &mut Instance {
        &mut self.simulation.instance
    }

    fn next(&mut self) -> Option<f64> {
        if self.ended.is_ok() { self.simulation.next_time() } else { None }
    }

    fn reach(&mut self) {
        if let Err(error) = self.simulation.advance() {
            *self.ended = Err(error);
        }
    }
}
