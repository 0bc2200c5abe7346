//! Columns of tables by other names than those of their variables.

use clap::Args;
use cotree::model::Unit;
use cotree::report::csv::Naming;

use super::failure::Failure;

/// As an option.
#[derive(Args)]
pub struct Columns {
    /// Map a column to a variable, such as "crank.angle=Angle"; may be given several times; then no other columns are read [default: columns have the names of variables]
    #[arg(long = "column", value_name = "NAME=COLUMN")]
    columns: Vec<String>,
}

/// The variables of columns that are called otherwise.
pub struct Chosen(Vec<(String, String)>);

impl Columns {
    pub fn chosen(&self) -> Result<Chosen, Failure> {
        let pair = |text: &String| {
            let pair = text.split_once('=').map(|(name, column)| (name.trim().to_owned(), column.trim().to_owned()));
            pair.filter(|(name, column)| !name.is_empty() && !column.is_empty()).ok_or_else(|| {
                Failure::Usage(format!("--column {text}: write name=column, such as \"crank.angle=Angle\""))
            })
        };
        self.columns.iter().map(pair).collect::<Result<_, _>>().map(Chosen)
    }
}

impl Chosen {
    /// With the units of variables.
    pub fn naming<'a>(&'a self, unit_of: &'a dyn Fn(&str) -> Option<Unit>) -> Naming<'a> {
        Naming { unit_of, chosen: &self.0 }
    }
}
