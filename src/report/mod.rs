//! What cotree shows: drawings, plots, tables, summaries.

pub mod drawing;
pub mod plot;
pub mod svg;
