//! Equations, code, drawings, plots, tables, summaries.

pub mod accuracy;
pub mod assumptions;
pub mod bench;
pub mod code;
pub mod compare;
pub mod csv;
pub mod drawing;
pub mod dxf;
pub mod figures;
pub mod graph;
pub mod line;
pub mod page;
pub mod plot;
pub mod png;
pub mod pose;
pub mod statistics;
pub mod summary;
pub mod svg;
pub mod text;
pub mod tikz;
