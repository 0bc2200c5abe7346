//! Results for people, spreadsheets and scripts: reports, summaries, statistics, and what is in an FMU.

pub mod csv;
pub mod data;
pub mod figures;
pub mod inspect;
pub mod statistics;
pub mod summary;
