//! Why there is no motion to be shown or measured.

use cotree::scene::Faults;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::check::Fault;
use cotree_fmu::program::storage::LoadError;
use cotree_study::bench::BenchError;
use thiserror::Error;

/// Why there is no motion to be shown or measured.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MotionlessError {
    /// The scene with every variable is at fault.
    #[error(transparent)]
    Scene(#[from] Faults),
    /// The runtime refuses the program.
    #[error(transparent)]
    Program(#[from] Fault),
    /// The program cannot be stored.
    #[error(transparent)]
    Storage(#[from] LoadError),
    /// The motion cannot be found or continued.
    #[error(transparent)]
    Motion(#[from] InstanceError),
    /// A run that cannot be measured.
    #[error(transparent)]
    Run(#[from] BenchError),
    /// The documentation of an FMU moves so many bodies at most.
    #[error("the mechanism has {count} bodies, more than {most}; `cotree view` makes a page of it that moves")]
    TooManyBodies {
        /// How many there are.
        count: usize,
        /// How many there can be.
        most: usize,
    },
    /// A film of too many pictures.
    #[error("a film of {count:.0} pictures is too long: at most {most}; choose a higher speed or a lower rate")]
    TooLong {
        /// How many there would be.
        count: f64,
        /// How many there can be.
        most: u32,
    },
}
