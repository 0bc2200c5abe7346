//! A progress bar, for those who would wait without one.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Shorter runs show no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Progress on standard error, if that is a terminal and standard output is not: a table scrolling by is progress enough.
pub struct RunProgress {
    begin: Instant,
    done: u64,
    all: u64,
    wanted: bool,
    bar: Option<ProgressBar>,
}

impl RunProgress {
    /// For so many steps.
    pub fn new(all: u64) -> Self {
        let wanted = std::io::stderr().is_terminal() && !std::io::stdout().is_terminal();
        Self { begin: Instant::now(), done: 0, all, wanted, bar: None }
    }

    /// One step is done; the simulated time is shown.
    pub fn step(&mut self, time: f64) {
        self.done += 1;
        if !self.wanted || self.begin.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{wide_bar} {msg}  {eta} left");
            ProgressBar::new(self.all).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        bar.set_message(format!("t = {time:.3} s"));
        bar.set_position(self.done);
    }

    /// Takes the bar away.
    pub fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
