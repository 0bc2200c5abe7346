//! \[M\], \[D\], \[K\] and {F} of masses on a line as numbers, with the values of the parameters.

use cotree::equations::Equations;
use cotree::expr::{Expr, Symbol};
use cotree::formulate::default_value;
use serde_json::{Value, json};

use super::document::{DocumentBlock, Piece};
use super::tree::FormulaTree;

/// The matrices of Eq. (24) at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrices {
    /// When: {F} may depend on time.
    time: f64,
    square: Vec<(&'static str, &'static str, Vec<Vec<f64>>)>,
    /// {F} \[N\], unless it depends on where a driver starts that integrates an input.
    force: Option<Vec<f64>>,
    has_parameters: bool,
}

impl Matrices {
    /// The matrices, if the scene has them and all masses are known.
    pub fn new(equations: &mut Equations) -> Option<Matrices> {
        let vibration = equations.vibration()?;
        let arena = &equations.system.arena;
        let all = [&vibration.mass, &vibration.damping, &vibration.stiffness].into_iter().flatten().flatten();
        let symbols = arena.symbols(all.chain(&vibration.force).copied());
        if symbols.iter().any(|symbol| matches!(symbol, Symbol::Missing(..))) {
            return None;
        }
        let follows = symbols.iter().any(|symbol| matches!(symbol, Symbol::Follower(..)));
        let mechanism = &equations.system.mechanism;
        let numbers = |exprs: &[Expr]| arena.evaluate(exprs, &|symbol| default_value(mechanism, symbol));
        let rows = |matrix: &[Vec<Expr>]| matrix.iter().map(|row| numbers(row)).collect();
        Some(Matrices {
            time: mechanism.experiment.start,
            square: vec![
                ("M", "kg", rows(&vibration.mass)),
                ("D", "N.s/m", rows(&vibration.damping)),
                ("K", "N/m", rows(&vibration.stiffness)),
            ],
            force: (!follows).then(|| numbers(&vibration.force)),
            has_parameters: symbols.iter().any(|symbol| symbol.is_constant_between_instants()),
        })
    }

    /// For people: a table for each matrix, unless the formulas are numbers already.
    pub fn blocks(&self) -> Vec<DocumentBlock> {
        if !self.has_parameters {
            return Vec::new();
        }
        let mut blocks = Vec::new();
        for (name, unit, rows) in &self.square {
            blocks.push(DocumentBlock::Heading(format!("{name} in numbers [{unit}]")));
            blocks.push(DocumentBlock::table(
                Vec::new(),
                rows.iter().map(|row| row.iter().map(number).collect()).collect(),
            ));
        }
        if let Some(force) = &self.force {
            blocks.push(DocumentBlock::Heading(format!("F in numbers [N], at t = {} s", self.time)));
            blocks.push(DocumentBlock::table(Vec::new(), vec![force.iter().map(number).collect()]));
        }
        blocks
    }

    pub fn json(&self) -> Value {
        let mut object = json!({ "time": self.time, "F": self.force });
        for (name, _, rows) in &self.square {
            object[*name] = json!(rows);
        }
        object
    }
}

fn number(value: &f64) -> Piece {
    let size = FormulaTree::Number(value.abs());
    Piece::Math(if *value < 0.0 { FormulaTree::Sum(vec![(true, size)]) } else { size })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::formulate::equations;
    use cotree::scene::Scene;

    /// wall - k1 - a - k2, c2 - b; with the coordinates a.x and the length of k2, which makes b.x = a.x + k2.
    #[test]
    fn the_matrices_of_two_masses_are_those_found_by_hand() {
        let text = r#"
            name = "two"
            dimension = 1
            [parameters]
            ma = 2.0
            mb = 3.0
            k1 = { value = 10.0, unit = "N/m" }
            k2 = { value = 4.0, unit = "N/m" }
            c2 = { value = 0.5, unit = "N.s/m" }
            [bodies.a]
            mass = "ma"
            [bodies.b]
            mass = "mb"
            [loads.left]
            type = "spring"
            between = ["ground", "a"]
            stiffness = "k1"
            length = 1.0
            [loads.right]
            type = "spring"
            between = ["a", "b"]
            stiffness = "k2"
            damping = "c2"
            [loads.push]
            type = "force"
            on = "b"
            vector = ["7 N"]
            [coordinates]
            translation = ["a", "right"]
            [outputs]
            variables = ["a.x"]
        "#;
        let scene = Scene::from_toml(text).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
        let mechanism = scene.resolve().unwrap().mechanism;
        let mut equations = equations(&mechanism, &mechanism.coordinates).unwrap();
        let matrices = Matrices::new(&mut equations).unwrap();
        // T = (2 v1^2 + 3 (v1 + v2)^2)/2, V = (10 (x1 - 1)^2 + 4 x2^2)/2, dissipation 0.5 v2^2/2, force 7 on x1 + x2.
        let expected = json!({
            "time": 0.0,
            "M": [[5.0, 3.0], [3.0, 3.0]],
            "D": [[0.0, 0.0], [0.0, 0.5]],
            "K": [[10.0, 0.0], [0.0, 4.0]],
            "F": [17.0, 7.0],
        });
        assert_eq!(matrices.json(), expected);
        assert!(matrices.has_parameters);
        let page = crate::motion(&mut equations, crate::Prose::Text);
        assert!(page.contains("M in numbers [kg]\n  5  3\n  3  3\n"), "{page}");
        assert!(page.contains("F in numbers [N], at t = 0 s\n  17  7\n"), "{page}");
        let json: Value = serde_json::from_str(&crate::json(&mut equations)).unwrap();
        assert_eq!(json["matrices"], expected);
    }
}
