//! Random cams of all kinds as scenes, with what a test must know of them.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::fmt::Write;

pub use super::hard::random::Random;

impl Random {
    pub fn index(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }
}

pub type Place = [f64; 2];

pub fn turned(angle: f64, [x, y]: Place) -> Place {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// What touches the cam.
#[derive(Clone, Copy, Debug)]
pub enum Touch {
    /// A roller of this radius \[m\]; an edge if it is zero.
    Roller(f64),
    /// A face along this direction of the follower's frame \[rad\].
    Face(f64),
}

/// A cam whose shaft is at rest.
#[derive(Clone, Debug)]
pub struct Cam {
    pub shaft: Place,
    pub base: f64,
    pub touch: Touch,
    /// The follower's point in its frame.
    pub tip: Place,
    /// The cam's point at the shaft, in its frame.
    pub hub: Place,
    pub turning: bool,
    pub law: String,
    guide: String,
    ground: Place,
}

/// A rise by one of the laws, a dwell, and a return by another.
fn law(random: &mut Random, rise: f64) -> String {
    const LAWS: [&str; 5] = ["cycloidal", "poly345", "poly4567", "modified_sine", "modified_trapezoid"];
    if random.index(4) == 0 {
        return format!("{rise}*(1 - cos(angle))/2 + {}*sin(2*angle)", 0.05 * rise);
    }
    let [up, down] = [0; 2].map(|_| LAWS[random.index(LAWS.len())]);
    let [first, beta] = [random.between(0.0, 0.5), random.between(1.7, 2.3)];
    let [second, gamma] = [first + beta + random.between(0.0, 0.3), random.between(1.8, 2.4)];
    format!("{rise}*({up}((angle - {first})/{beta}) - {down}((angle - {second})/{gamma}))")
}

impl Cam {
    /// A follower that slides, with an offset, an inclined axis, a guide that turns it.
    pub fn sliding(random: &mut Random, flat: bool) -> Cam {
        let base = random.between(0.03, 0.06);
        let shaft = [random.between(-0.1, 0.1), random.between(-0.1, 0.1)];
        let (axis, delta) = (random.between(-3.0, 3.0), random.between(-1.0, 1.0));
        let touch = match flat {
            // About across the axis.
            true => Touch::Face(axis - 0.5 * std::f64::consts::PI + random.between(-0.1, 0.1) - delta),
            false => Touch::Roller([0.0, random.between(0.005, 0.02)][random.index(2)]),
        };
        let rise = base * random.between(0.15, 0.35);
        let law = law(random, rise);
        let [beside, below] = [random.between(-0.008, 0.008), random.between(0.0, 0.05)];
        let [across, along] = [turned(axis, [0.0, 1.0]), turned(axis, [1.0, 0.0])];
        let ground = [0, 1].map(|k| shaft[k] + beside * across[k] + 0.01 * along[k]);
        let [ax, ay] = along;
        Cam {
            shaft,
            base,
            touch,
            tip: turned(axis - delta, [-below, 0.0]),
            hub: [random.between(-0.01, 0.01), random.between(-0.01, 0.01)],
            turning: false,
            law,
            guide: format!("type = \"prismatic\"\naxis = [{ax}, {ay}]\nangle = {delta}"),
            ground,
        }
    }

    /// A follower that turns, on the left or on the right.
    pub fn turning(random: &mut Random, flat: bool) -> Cam {
        let base = random.between(0.03, 0.05);
        let shaft = [random.between(-0.1, 0.1), random.between(-0.1, 0.1)];
        let away = turned(random.between(-3.0, 3.0), [random.between(2.4, 3.0) * base, 0.0]);
        let own = random.between(-3.0, 3.0);
        let rise = random.between(0.08, 0.16);
        let law = law(random, rise);
        let (touch, tip) = match flat {
            true => (Touch::Face(own), turned(own, [0.02, random.between(-0.004, 0.004)])),
            false => {
                let roller = random.between(0.005, 0.012);
                (Touch::Roller(roller), turned(own, [random.between(0.85, 0.95) * (away[0].hypot(away[1])), 0.0]))
            }
        };
        Cam {
            shaft,
            base,
            touch,
            tip,
            hub: [random.between(-0.01, 0.01), random.between(-0.01, 0.01)],
            turning: true,
            law,
            guide: "type = \"revolute\"".to_string(),
            ground: [0, 1].map(|k| shaft[k] + away[k]),
        }
    }

    /// The scene; `side` for a follower that turns, and more text such as drivers.
    pub fn scene(&self, side: &str, more: &str) -> String {
        let mut text = String::from("name = \"cam\"\n");
        let ([sx, sy], [gx, gy], [hx, hy], [tx, ty]) = (self.shaft, self.ground, self.hub, self.tip);
        let _ = writeln!(text, "ground.points = {{ shaft = [{sx}, {sy}], guide = [{gx}, {gy}] }}");
        let _ = writeln!(
            text,
            "[bodies]\ncam = {{ mass = 1.5, inertia = 2e-3, com = [0.004, -0.003], points = {{ hub = [{hx}, {hy}] }} }}"
        );
        let _ = writeln!(
            text,
            "follower = {{ mass = 0.4, inertia = 3e-4, com = [0.01, 0.002], points = {{ guide = [0, 0], tip = [{tx}, {ty}] }} }}"
        );
        let _ = writeln!(text, "[joints.shaft]\ntype = \"revolute\"\nbetween = [\"ground.shaft\", \"cam.hub\"]");
        let _ = writeln!(text, "[joints.guide]\nbetween = [\"ground.guide\", \"follower.guide\"]\n{}", self.guide);
        let _ = writeln!(text, "[joints.contact]\ntype = \"cam\"\nbetween = [\"cam\", \"follower.tip\"]");
        let _ = writeln!(text, "shaft = \"shaft\"\nguide = \"guide\"\nbase = {}\nlaw = \"{}\"", self.base, self.law);
        let _ = match self.touch {
            Touch::Roller(radius) if radius > 0.0 => writeln!(text, "roller = {radius}"),
            Touch::Roller(_) => Ok(()),
            Touch::Face(angle) => writeln!(text, "face = [{}, {}]", angle.cos(), angle.sin()),
        };
        if self.turning {
            let _ = writeln!(text, "side = \"{side}\"");
        }
        text + more
    }
}
