//! What cotree shows: drawings, plots, tables, summaries.

pub mod accuracy;
pub mod assumptions;
pub mod compare;
pub mod csv;
pub mod curve;
pub mod drawing;
pub mod economy;
pub mod figures;
pub mod graph;
pub mod line;
pub mod plot;
pub mod pose;
pub mod summary;
pub mod svg;
