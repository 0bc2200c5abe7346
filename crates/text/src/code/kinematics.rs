//! Functions of a model whose motion the drivers prescribe: velocities and accelerations from the loop equations, by a template for each language.

use super::Sizes;

#[derive(Clone, Copy, Debug)]
pub struct KinematicsCode<'a> {
    pub name: &'a str,
    pub sizes: Sizes,
    /// The loop equations that determine the motion: as many as there are coordinates.
    pub rows: &'a [usize],
    /// Are there masses, and with them reactions?
    pub masses: bool,
}

impl KinematicsCode<'_> {
    /// The template with names and sizes in their places; `name` as the language writes it, rows counted from `first`.
    pub fn fill(&self, template: &str, name: &str, first: usize) -> String {
        let rows: Vec<String> = self.rows.iter().map(|row| (row + first).to_string()).collect();
        let Sizes { parameters, inputs, followers, coordinates, constraints, .. } = self.sizes;
        let mut text = self.chosen(template).replace("@NAME@", name).replace("@ROWS@", &rows.join(", "));
        let numbers =
            [("P", parameters), ("U", 3 * inputs), ("F", 3 * followers), ("N", coordinates), ("M", constraints)];
        for (place, number) in numbers {
            text = text.replace(&format!("@{place}@"), &number.to_string());
        }
        text
    }

    /// Without the lines that need masses if there are none.
    fn chosen(&self, template: &str) -> String {
        let mut kept = true;
        let mut text = String::new();
        for line in template.lines() {
            match line {
                "@MASSES@" => kept = self.masses,
                "@END@" => kept = true,
                line if kept => {
                    text.push_str(line);
                    text.push('\n');
                }
                _ => {}
            }
        }
        text
    }
}
