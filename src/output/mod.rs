//! Tables, statistics, summaries.

pub mod csv;
pub mod figures;
pub mod statistics;
pub mod summary;
