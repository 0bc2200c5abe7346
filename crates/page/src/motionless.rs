//! Why there is no motion to be shown or measured.

use cotree::scene::Faults;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::check::Fault;
use cotree_fmu::program::storage::LoadError;
use cotree_study::bench::BenchError;
use thiserror::Error;

/// Why there is no motion to be shown or measured.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct MotionlessError(pub String);

impl From<Faults> for MotionlessError {
    fn from(error: Faults) -> Self {
        MotionlessError(error.to_string())
    }
}

impl From<Fault> for MotionlessError {
    fn from(error: Fault) -> Self {
        MotionlessError(error.to_string())
    }
}

impl From<LoadError> for MotionlessError {
    fn from(error: LoadError) -> Self {
        MotionlessError(error.to_string())
    }
}

impl From<InstanceError> for MotionlessError {
    fn from(error: InstanceError) -> Self {
        MotionlessError(error.to_string())
    }
}

impl From<BenchError> for MotionlessError {
    fn from(error: BenchError) -> Self {
        MotionlessError(error.to_string())
    }
}
