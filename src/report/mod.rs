//! What cotree shows: drawings, plots, tables, summaries.

pub mod csv;
pub mod drawing;
pub mod plot;
pub mod summary;
pub mod svg;
