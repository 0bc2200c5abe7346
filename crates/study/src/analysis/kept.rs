//! Cache of formulated and differentiated equations for further studies of the same scene.

use std::sync::{Arc, Mutex, PoisonError};

use cotree::model::Experiment;

/// So many are kept for the outputs of a scene: other parameters to differentiate by, other times, another tolerance.
const MOST_KEPT: usize = 8;

/// For what derivatives of a motion were asked.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DerivativesKey {
    /// With respect to what it is differentiated.
    pub to: Vec<String>,
    /// The inputs that are given over time.
    pub driven: Vec<usize>,
    pub experiment: Experiment,
}

/// For what analyses at a point were asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PoseKey {
    /// True for the mechanism at rest, else a pose of its motion.
    pub rests: bool,
    pub experiment: Experiment,
}

/// What was made, and what for.
type Entry<K, T> = (K, Arc<T>);

/// Equations, with what they were made for. Copies share what they keep, in any thread; the last first.
#[derive(Debug)]
pub(super) struct Kept<K, T>(Arc<Mutex<Vec<Entry<K, T>>>>);

impl<K, T> Default for Kept<K, T> {
    fn default() -> Self {
        Kept(Arc::default())
    }
}

impl<K, T> Clone for Kept<K, T> {
    fn clone(&self) -> Self {
        Kept(Arc::clone(&self.0))
    }
}

impl<K: PartialEq, T> Kept<K, T> {
    pub fn find(&self, key: &K) -> Option<Arc<T>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(candidate, _)| candidate == key).map(|(_, found)| Arc::clone(found))
    }

    pub fn keep(&self, key: K, made: &Arc<T>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(0, (key, Arc::clone(made)));
        kept.truncate(MOST_KEPT);
    }
}
