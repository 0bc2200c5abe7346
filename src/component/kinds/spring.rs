//! Spring and damper (F, on a line k or d as in the paper's Fig. 5) between two points, and what it has in common with the torsion
//! spring: -k x - k3 x^3 - c v with x from the free length. One-sided springs act above or below their free length only, and then only
//! towards it: damping never makes a rope push or a stop pull.

use crate::component::course::{ENDS, OVER, placed};
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, IconStroke, line};
use crate::model::measure::{CUBIC_STIFFNESS, DAMPING, LENGTH, STIFFNESS};
use crate::model::{Comparison, Formula, Part, Quantity as Q, Range};
use crate::network::{Rows, System};
use crate::scene::{Load, Quantity, Side};

pub(crate) const SPRING: Component = Component {
    about: "a spring and damper along the line between two points",
    equations: "F = -stiffness x - cubic x^3 - damping x', x = |r| - length",
    keys: &[
        ENDS,
        Key::required(
            "stiffness",
            Form::Constant(STIFFNESS, Range::Any),
            "the stiffness",
            "give the stiffness [N/m]: `stiffness = 800`; 0 makes it a damper",
        ),
        Key::optional("length", Form::Constant(LENGTH, Range::Any), "the free length"),
        Key::optional("damping", Form::Constant(DAMPING, Range::Any), "the damping coefficient"),
        Key::optional("cubic", Form::Constant(CUBIC_STIFFNESS, Range::Any), "the cubic stiffness"),
        SIDE,
        OVER,
    ],
    variables: &[Q::Length, Q::Rate, Q::Force],
    pose: &[Q::Length, Q::Force],
    pulls: true,
    law: |part| Some(law(part, "length", [Q::Length, Q::Rate])),
    energy: |part| Some(energy(part, "length", Q::Length)),
    ..Component::load("spring", rows, placed, |_| Icon::Line(zigzag))
};

/// On which side of the free length or angle a spring acts.
pub(crate) const SIDE: Key = Key::optional(
    "side",
    Form::Choice(
        &["both", "above", "below"],
        "a spring acts \"both\" above and below its free length or angle, or only \"above\" or \"below\" it",
    ),
    "whether it acts above its free length or angle, below it, or both",
);

fn rows(part: &Part, system: &mut System) -> Rows {
    let is_zero = |key| matches!(part.formula(key), Formula::Number(0.0));
    line::rows(system, part, if is_zero("stiffness") && is_zero("cubic") { "d" } else { "k" })
}

fn side(part: &Part) -> &'static str {
    part.choice("side").unwrap_or("both")
}

/// -k x - k3 x^3 - c v, where the spring acts; x is what its length or angle is more than the free one.
pub(crate) fn law(part: &Part, free: &str, [place, rate]: [Q; 2]) -> Formula {
    let x = part.variable(place) - part.key(free);
    let (elastic, cubic) = (part.key("stiffness") * x.clone(), part.key("cubic") * x.clone().raised(3.0));
    let law = -(elastic + cubic + part.key("damping") * part.variable(rate));
    let zero = Formula::Number(0.0);
    match side(part) {
        "above" => one_sided(part, x, law.smaller(zero)),
        "below" => one_sided(part, x, law.larger(zero)),
        _ => law,
    }
}

/// k x^2 / 2 + k3 x^4 / 4, where the spring acts.
pub(crate) fn energy(part: &Part, free: &str, place: Q) -> Formula {
    let x = part.variable(place) - part.key(free);
    let elastic = part.key("stiffness") * x.clone().raised(2.0);
    let cubic = part.key("cubic") * x.clone().raised(4.0);
    one_sided(part, x, Formula::Number(0.5) * elastic + Formula::Number(0.25) * cubic)
}

fn one_sided(part: &Part, x: Formula, value: Formula) -> Formula {
    let zero = Formula::Number(0.0);
    let comparison = match side(part) {
        "above" => Comparison::Greater,
        "below" => Comparison::Less,
        _ => return value,
    };
    Formula::If(comparison, Box::new([x, zero.clone(), value, zero]))
}

/// A zigzag between straight ends.
pub(crate) fn zigzag(length: f64) -> Vec<IconStroke> {
    let straight = (0.18 * length).min(4.0);
    let coils = ((length - 2.0 * straight) / 1.5).round().clamp(4.0, 24.0);
    let pitch = (length - 2.0 * straight) / coils;
    let mut points = vec![[0.0, 0.0], [straight, 0.0]];
    for coil in 0..coils as usize {
        let side = if coil % 2 == 0 { 1.25 } else { -1.25 };
        points.push([straight + pitch * (coil as f64 + 0.5), side]);
    }
    points.extend([[length - straight, 0.0], [length, 0.0]]);
    vec![IconStroke::open(points)]
}

impl Load {
    /// A spring between two points.
    pub fn spring(first: &str, second: &str, stiffness: impl Into<Quantity>) -> Load {
        Load::new("spring").set("between", [first, second]).set("stiffness", stiffness.into())
    }

    /// The free length of a spring \[m\], or the free angle of a torsion spring or bushing \[rad\].
    #[must_use]
    pub fn free(self, value: impl Into<Quantity>) -> Load {
        let key = if self.is("spring") { "length" } else { "angle" };
        self.set(key, value.into())
    }

    /// The damping of a spring or bushing [N.s/m] or torsion spring [N.m.s].
    #[must_use]
    pub fn damping(self, value: impl Into<Quantity>) -> Load {
        self.set("damping", value.into())
    }

    /// The cubic stiffness of a spring [N/m3] or torsion spring [N.m/rad3].
    #[must_use]
    pub fn cubic(self, value: impl Into<Quantity>) -> Load {
        self.set("cubic", value.into())
    }

    /// Lets a spring or torsion spring act on one side of its free length or angle only.
    #[must_use]
    pub fn side(self, value: Side) -> Load {
        let side = match value {
            Side::Both => "both",
            Side::Above => "above",
            Side::Below => "below",
        };
        self.set("side", side)
    }
}
