//! Why there is no motion to be shown or measured.

use cotree::scene::Faults;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::check::ProgramError;
use cotree_fmu::program::storage::LoadError;
use cotree_study::bench::BenchError;
use thiserror::Error;

/// Why there is no motion to be shown or measured.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct MotionlessError(pub String);

cotree::diagnostic::from_messages!(MotionlessError as MotionlessError: Faults, ProgramError, LoadError, InstanceError, BenchError);
