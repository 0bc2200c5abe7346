//! Tables, statistics, summaries, reports.

pub mod csv;
pub mod figures;
pub mod report;
pub mod statistics;
pub mod summary;
