//! Equations that were formulated and differentiated once, for the studies of the same scene that follow.

use std::sync::{Arc, Mutex, PoisonError};

use cotree::model::Experiment;

use super::sensitivity::Differentiated;

/// So many are kept for the outputs of a scene: other parameters to differentiate by, other times, another tolerance.
const MOST_KEPT: usize = 8;

/// What was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Key {
    /// With respect to what it is differentiated.
    pub to: Vec<String>,
    /// The inputs that are given over time.
    pub driven: Vec<usize>,
    pub experiment: Experiment,
}

/// Equations and what they were made for.
type Entry = (Key, Arc<Differentiated>);

/// Copies of a study share what they have formulated, in any thread; the last first.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept(Arc<Mutex<Vec<Entry>>>);

impl Kept {
    pub fn find(&self, key: &Key) -> Option<Arc<Differentiated>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(own, _)| own == key).map(|(_, found)| Arc::clone(found))
    }

    pub fn keep(&self, key: Key, made: &Arc<Differentiated>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(0, (key, Arc::clone(made)));
        kept.truncate(MOST_KEPT);
    }
}
