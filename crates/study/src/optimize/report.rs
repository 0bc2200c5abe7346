//! The optimum found, as tables and as JSON.

use cotree::diagnostic::suggest::list;
use cotree::report::data::{Cell, Report, Table, named, number, per, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::{Best, Ended, LimitAt, OptimizedQuantity, Optimum};

/// So many optima are shown.
const SHOWN: usize = 10;

impl Best {
    pub fn report(&self) -> Report {
        let (goal, of) = &self.goal;
        let at = |value: Option<f64>| value.map_or(Cell::from("-"), |value| number(value, of));
        let goals = Table::new(
            row!["", "at the start", "best", "unit"],
            [row![goal, at(self.values[0]), at(self.values[1]), unit(of)]],
        );
        let mut tables = vec![goals, self.values_table()];
        if !self.limits.is_empty() {
            tables.push(self.limits_table());
        }
        tables.push(self.optima_table());
        Report {
            tables,
            notes: self.notes(),
            data: self.data(),
            sheet: self.sheet(),
            ..Report::new(row![format!("{}: best of {} searches", self.name, self.searches.len())])
        }
    }

    fn values_table(&self) -> Table {
        let row = |quantity_data: &OptimizedQuantity| {
            let bound = if quantity_data.is_at_bound { "at its bound" } else { "" };
            row![
                quantity_data.name,
                number(quantity_data.start, &quantity_data.unit),
                number(quantity_data.value, &quantity_data.unit),
                unit(&quantity_data.unit),
                bound
            ]
        };
        Table::new(row!["quantity", "at the start", "best", "unit", ""], self.quantities.iter().map(row))
    }

    /// With what an active limit costs.
    fn limits_table(&self) -> Table {
        let row = |limit: &LimitAt| {
            let costs = limit.multiplier.map_or(Cell::from("not active"), |multiplier| {
                let by = per(&self.goal.1, &limit.unit);
                line![number(multiplier, &by)]
            });
            row![limit.text, number(limit.value, &limit.unit), unit(&limit.unit), costs]
        };
        let title = format!("{} by the limit", self.goal.0);
        Table::new(row!["limit", "best", "unit", title], self.limits.iter().map(row))
    }

    fn optima_table(&self) -> Table {
        let (goal, of) = &self.goal;
        let names = self.quantities.iter().map(|quantity| named(&quantity.name, &quantity.unit));
        let columns = row!["optimum", named(goal, of), "reached"].into_iter().chain(names).collect();
        let row = |(index, optimum): (usize, &Optimum)| {
            let values =
                optimum.values.iter().zip(&self.quantities).map(|(value, quantity)| number(*value, &quantity.unit));
            row![index + 1, number(optimum.goal, of), optimum.reached].into_iter().chain(values).collect()
        };
        Table::new(columns, self.optima.iter().take(SHOWN).enumerate().map(row))
    }

    fn notes(&self) -> Vec<Cell> {
        let ended = match &self.ended {
            Ended::Settled => "the best is a local optimum".to_owned(),
            Ended::Exhausted => "the best is not an optimum: its search reached the limit of motions".to_owned(),
            Ended::Stopped => "the best is not an optimum: it was stopped".to_owned(),
            Ended::Stuck(None) => "the best is not an optimum: steps became too short".to_owned(),
            Ended::Stuck(Some(cause)) => format!("the best is not an optimum: there is no motion beyond it: {cause}"),
        };
        let computed = match self.is_turn {
            true => "turns were computed, with their derivatives",
            false => "motions were computed with their derivatives",
        };
        let mut notes = row![format!("\n{ended}; {} {computed}", self.evaluations)];
        if self.optima.len() > SHOWN {
            notes.push(format!("{} more optima are in --json and --table", self.optima.len() - SHOWN).into());
        }
        let lost = self.searches.iter().filter(|search| search.ended != "optimum").count();
        if lost > 0 {
            notes.push(
                format!("{lost} of {} searches did not end at an optimum: see --table", self.searches.len()).into(),
            );
        }
        if !self.guesses.is_empty() {
            let names = list(self.guesses.iter().map(|guess| &guess.name));
            notes.push(
                format!("the start has moved away from the guess of {names}; -o writes the new guess too").into(),
            );
        }
        notes
    }

    /// A line for each search.
    fn sheet(&self) -> Table {
        let (goal, of) = &self.goal;
        let names = self.quantities.iter().map(|quantity| named(&quantity.name, &quantity.unit));
        let columns = row!["search", "ended", named(goal, of)].into_iter().chain(names).collect();
        let row = |(index, search): (usize, &super::Search)| {
            let value = |place: usize| search.values.get(place).copied().unwrap_or(f64::NAN);
            let values =
                self.quantities.iter().enumerate().map(|(place, quantity)| number(value(place), &quantity.unit));
            row![index, search.ended, number(search.goal.unwrap_or(f64::NAN), of)].into_iter().chain(values).collect()
        };
        Table::new(columns, self.searches.iter().enumerate().map(row))
    }

    fn data(&self) -> Value {
        let ended = match &self.ended {
            Ended::Settled => "optimum",
            Ended::Exhausted => "evaluations",
            Ended::Stopped => "stopped",
            Ended::Stuck(None) => "short",
            Ended::Stuck(Some(_)) => "blocked",
        };
        let quantity = |quantity_data: &OptimizedQuantity| json!({ "name": quantity_data.name, "unit": quantity_data.unit, "start": quantity_data.start, "value": quantity_data.value, "at_bound": quantity_data.is_at_bound });
        let limit = |limit_data: &LimitAt| json!({ "limit": limit_data.text, "unit": limit_data.unit, "bound": limit_data.bound, "value": limit_data.value, "multiplier": limit_data.multiplier });
        let optimum = |optimum_data: &Optimum| json!({ "goal": optimum_data.goal, "values": optimum_data.values, "reached": optimum_data.reached });
        let search = |search_data: &super::Search| json!({ "goal": search_data.goal, "values": search_data.values, "ended": search_data.ended });
        let guess = |guess_data: &crate::analysis::Guess| json!({ "name": guess_data.name, "unit": guess_data.unit.si, "guess": guess_data.guessed, "found": guess_data.found });
        json!({
            "name": self.name, "goal": { "name": self.goal.0, "unit": self.goal.1, "start": self.values[0], "value": self.values[1] },
            "ended": ended, "evaluations": self.evaluations,
            "quantities": self.quantities.iter().map(quantity).collect::<Value>(),
            "limits": self.limits.iter().map(limit).collect::<Value>(),
            "optima": self.optima.iter().map(optimum).collect::<Value>(),
            "searches": self.searches.iter().map(search).collect::<Value>(),
            "guesses": self.guesses.iter().map(guess).collect::<Value>(),
        })
    }
}
