//! Sparse constants between arms, without those that are zero whatever the parameters are.

use super::Arm;
use crate::linalg::number::Number;

/// Row, column, components.
pub(super) type Entry = (usize, usize, [u32; 2]);

/// A coefficient times what a column has.
#[derive(Clone, Copy, Debug)]
struct Part {
    from: u32,
    coefficient: u32,
}

/// One component of some entries, by rows.
#[derive(Clone, Debug)]
struct Rows {
    parts: Vec<Part>,
    /// First part of each row, and the end.
    first: Vec<u32>,
}

impl Rows {
    fn new(rows: usize, entries: &[Entry], component: usize, zero: &[bool]) -> Self {
        let mut rest: Vec<&Entry> = entries.iter().filter(|(_, _, c)| !zero[c[component] as usize]).collect();
        rest.sort_by_key(|(row, _, _)| *row);
        let first = (0..=rows).map(|row| rest.partition_point(|entry| entry.0 < row) as u32).collect();
        let part = |&&(_, from, c): &&Entry| Part { from: from as u32, coefficient: c[component] };
        Self { parts: rest.iter().map(part).collect(), first }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> &[Part] {
        &self.parts[self.first[row] as usize..self.first[row + 1] as usize]
    }
}

/// A matrix of complex constants: masses between arms.
#[derive(Clone, Debug)]
pub(super) struct Complex {
    real: Rows,
    imaginary: Rows,
}

impl Complex {
    pub fn new(rows: usize, entries: &[Entry], zero: &[bool]) -> Self {
        Self { real: Rows::new(rows, entries, 0, zero), imaginary: Rows::new(rows, entries, 1, zero) }
    }

    /// The force on an arm, and the forces that go with the second derivatives of all.
    #[inline(always)]
    pub fn add<N: Number>(&self, c: &[N], arms: &[Arm<N>], to: usize, [mut fx, mut fy]: [N; 2]) -> [N; 2] {
        for part in self.real.row(to) {
            let (arm, mass) = (&arms[part.from as usize], c[part.coefficient as usize]);
            fx += mass * arm.second[0];
            fy += mass * arm.second[1];
        }
        for part in self.imaginary.row(to) {
            let (arm, mass) = (&arms[part.from as usize], c[part.coefficient as usize]);
            fx -= mass * arm.second[1];
            fy += mass * arm.second[0];
        }
        [fx, fy]
    }
}

/// Sums of scalar products: loop equations.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    x: Rows,
    y: Rows,
    /// The same by arms.
    reactions: [Rows; 2],
}

impl Pairs {
    pub fn new(rows: usize, arms: usize, entries: &[Entry], zero: &[bool]) -> Self {
        let turned: Vec<Entry> = entries.iter().map(|&(row, arm, p)| (arm, row, p)).collect();
        Self {
            x: Rows::new(rows, entries, 0, zero),
            y: Rows::new(rows, entries, 1, zero),
            reactions: [0, 1].map(|axis| Rows::new(arms, &turned, axis, zero)),
        }
    }

    /// The sum of one row over what each arm has.
    #[inline(always)]
    pub fn sum<N: Number>(&self, c: &[N], arms: &[Arm<N>], row: usize, of: impl Fn(&Arm<N>) -> [N; 2]) -> N {
        let mut sum = N::ZERO;
        for part in self.x.row(row) {
            sum += c[part.coefficient as usize] * of(&arms[part.from as usize])[0];
        }
        for part in self.y.row(row) {
            sum += c[part.coefficient as usize] * of(&arms[part.from as usize])[1];
        }
        sum
    }

    /// The force on an arm, and the reactions on it.
    #[inline(always)]
    pub fn react<N: Number>(&self, c: &[N], reactions: &[N], arm: usize, [mut fx, mut fy]: [N; 2]) -> [N; 2] {
        for part in self.reactions[0].row(arm) {
            fx += c[part.coefficient as usize] * reactions[part.from as usize];
        }
        for part in self.reactions[1].row(arm) {
            fy += c[part.coefficient as usize] * reactions[part.from as usize];
        }
        [fx, fy]
    }
}
