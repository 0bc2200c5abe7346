//! Random laws in pieces in the commands that take derivatives: linear systems, equilibria and derivatives of motions, against the laws evaluated here and a motion integrated here.

use std::rc::Rc;

use super::run::block_with_law;
use crate::support::hard::random::Random;
use cotree::scene::Scene;
use cotree_study::analysis::{LinearisedAt, Study};

/// Of length \[m\], rate \[m/s\] and time \[s\], a force \[N\].
type Value = Rc<dyn Fn([f64; 3]) -> f64>;

/// A law as a scene has it, and its value.
struct Law {
    text: String,
    value: Value,
}

impl Law {
    /// One of pieces; with jumps if that is wanted.
    fn random(random: &mut Random, depth: u32, jumps: bool) -> Self {
        let number = random.between(0.5, 6.0) * if random.unit() < 0.5 { 1.0 } else { -1.0 };
        if depth == 0 {
            let which = random.next() as usize % 3;
            let name = ["length", "rate", "t"][which];
            return Self::of(format!("{number:?}*{name}"), move |read| number * read[which]);
        }
        let [a, b] = [(); 2].map(|()| Self::random(random, depth - 1, jumps));
        let (one, two) = (a.value.clone(), b.value.clone());
        match random.next() % if jumps { 7 } else { 4 } {
            0 => Self::of(format!("min({}, {})", a.text, b.text), move |read| one(read).min(two(read))),
            1 => Self::of(format!("max({}, {})", a.text, b.text), move |read| one(read).max(two(read))),
            2 => Self::of(format!("abs({}) + {}", a.text, b.text), move |read| one(read).abs() + two(read)),
            3 => Self::of(format!("({}) + ({})", a.text, b.text), move |read| one(read) + two(read)),
            4 => Self::of(format!("{number:?}*sign({})", a.text), move |read| {
                let inner = one(read);
                number * if inner > 0.0 { 1.0 } else { -f64::from(u8::from(inner < 0.0)) }
            }),
            5 => Self::of(format!("floor({})", a.text), move |read| one(read).floor()),
            _ => Self::of(format!("if({} < {}, {number:?}, {})", a.text, b.text, b.text), move |read| {
                if one(read) < two(read) { number } else { two(read) }
            }),
        }
    }

    fn of(text: String, value: impl Fn([f64; 3]) -> f64 + 'static) -> Self {
        Self { text, value: Rc::new(value) }
    }

    /// The acceleration of the block of 1 kg at the spring of 100 N/m, 1 m away from the wall.
    fn acceleration(&self, gain: f64, [x, v]: [f64; 2], t: f64) -> f64 {
        gain * (self.value)([1.0 + x, v, t]) - 100.0 * x
    }

    fn scene(&self) -> String {
        let more = "[parameters]\ngain = { value = 1.0, tunable = true }\n[initial]\n\"guide.s\" = 0.1\n\"guide.v\" = 0.4\n[outputs]\nvariables = [\"guide.s\"]\n[experiment]\nstop = \"0.3 s\"\ntolerance = 1e-10\n";
        block_with_law(&format!("gain*({})", self.text), more)
    }

    /// The place after 0.3 s, by Runge and Kutta's method of order 4.
    fn moves_to(&self, gain: f64) -> f64 {
        const STEPS: u32 = 30_000;
        let h = 0.3 / f64::from(STEPS);
        let mut y = [0.1, 0.4];
        let rates = |y: [f64; 2], t: f64| [y[1], self.acceleration(gain, y, t)];
        let moved = |y: [f64; 2], slope: [f64; 2], by: f64| [y[0] + by * slope[0], y[1] + by * slope[1]];
        for step in 0..STEPS {
            let t = h * f64::from(step);
            let one = rates(y, t);
            let two = rates(moved(y, one, 0.5 * h), t + 0.5 * h);
            let three = rates(moved(y, two, 0.5 * h), t + 0.5 * h);
            let four = rates(moved(y, three, h), t + h);
            let sum = [0, 1].map(|part| (one[part] + 2.0 * (two[part] + three[part]) + four[part]) / 6.0);
            y = moved(y, sum, h);
        }
        y[0]
    }
}

fn study(text: &str) -> Study {
    let scene = Scene::from_toml(text).unwrap_or_else(|faults| panic!("{}\n{text}", faults.render(false, 100)));
    Study::new(&scene).unwrap_or_else(|faults| panic!("{}\n{text}", faults.render(false, 100)))
}

/// A slope at a place, by differences of two sizes; none at a kink or a jump.
fn slope(value: impl Fn(f64) -> f64) -> Option<f64> {
    let [coarse, fine] = [1e-5, 1e-6].map(|h| (value(h) - value(-h)) / (2.0 * h));
    let halves = [(value(1e-6) - value(0.0)) / 1e-6, (value(0.0) - value(-1e-6)) / 1e-6];
    let size = 1.0 + fine.abs();
    ((coarse - fine).abs() < 1e-5 * size && (halves[0] - halves[1]).abs() < 1e-4 * size).then_some(fine)
}

#[test]
fn linear_systems_have_the_slopes_of_laws_in_pieces() {
    let mut compared = 0;
    for seed in 0..150 {
        let law = Law::random(&mut Random(seed), 3, seed % 2 == 0);
        let Ok(found) = study(&law.scene()).linearize(&LinearisedAt::Times(vec![0.02])) else { continue };
        let system = &found.points[0];
        let [x, v] = [0, 1].map(|state| system.states[state].value);
        let exact = law.acceleration(1.0, [x, v], 0.02);
        assert!((system.rates[1] - exact).abs() < 1e-9 * (1.0 + exact.abs()), "{seed}: {} is {}", law.text, exact);
        let slopes =
            [slope(|h| law.acceleration(1.0, [x + h, v], 0.02)), slope(|h| law.acceleration(1.0, [x, v + h], 0.02))];
        for (column, right) in slopes.into_iter().enumerate() {
            let Some(right) = right else { continue };
            let found = system.a[(1, column)];
            assert!(
                (found - right).abs() < 1e-4 * (1.0 + right.abs()),
                "{seed}, {column}: {found}, {right}\n{}",
                law.text
            );
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn equilibria_balance_laws_in_pieces() {
    let mut compared = 0;
    for seed in 0..150 {
        let law = Law::random(&mut Random(seed), 3, seed % 2 == 0);
        let Ok(found) = study(&law.scene()).equilibrium() else { continue };
        let x = found.value("guide.s").expect("a place");
        // At a jump both sides press against it.
        let [left, here, right] = [-1e-6, 0.0, 1e-6].map(|h| law.acceleration(1.0, [x + h, 0.0], 0.0));
        let balances = here.abs() < 1e-5 || left * right <= 0.0;
        assert!(balances, "{seed}: {here} at {x}\n{}", law.text);
        compared += 1;
    }
    assert!(compared > 70, "{compared}");
}

#[test]
fn derivatives_of_motions_are_those_of_laws_in_pieces() {
    let mut compared = 0;
    for seed in 0..40 {
        let law = Law::random(&mut Random(1000 + seed), 2, false);
        let Ok(found) = study(&law.scene()).sensitivities(&["gain".to_owned()], &[0.3]) else { continue };
        let derivative = found.derivatives[0][(0, 0)];
        let right = (law.moves_to(1.0 + 1e-4) - law.moves_to(1.0 - 1e-4)) / 2e-4;
        assert!((found.values[0][0] - law.moves_to(1.0)).abs() < 1e-7, "{seed}: {}", law.text);
        assert!((derivative - right).abs() < 1e-4 * (1.0 + right.abs()), "{seed}: {derivative}, {right}\n{}", law.text);
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}
