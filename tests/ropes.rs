//! Ropes and bands over pulleys and drums, against a geometry of their own (angles, where the program has products), closed forms, energy, and motions by other equations.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use crate::support::run::{model, started, value};

/// A pulley: centre, velocity, signed radius.
type Circle = ([f64; 2], [f64; 2], f64);

/// A generator of numbers between two others.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// Directions of the straight parts, and their lengths: the line of centres turned by asin(k/|e|).
fn straight_parts(circles: &[Circle], time: f64) -> Vec<(f64, f64)> {
    let at = |(at, v, _): &Circle| [at[0] + time * v[0], at[1] + time * v[1]];
    let part = |pair: &[Circle]| {
        let ([a, b], [c, d], k) = (at(&pair[0]), at(&pair[1]), pair[1].2 - pair[0].2);
        let distance = (c - a).hypot(d - b);
        ((d - b).atan2(c - a) - (k / distance).asin(), (distance * distance - k * k).sqrt())
    };
    circles.windows(2).map(part).collect()
}

/// The length of a chain: at the start wraps are from zero to one turn, later next to those.
fn length(circles: &[Circle], time: f64) -> f64 {
    let wraps = |time: f64, before: Option<&[f64]>| -> Vec<f64> {
        let parts = straight_parts(circles, time);
        let wrap = |(number, pair): (usize, &[(f64, f64)])| {
            let side = circles[number + 1].2.signum();
            let wrap = (side * (pair[1].0 - pair[0].0)).rem_euclid(TAU);
            before.map_or(wrap, |before| before[number] + (wrap - before[number] + PI).rem_euclid(TAU) - PI)
        };
        parts.windows(2).enumerate().map(wrap).collect()
    };
    let steps = 40;
    let mut now = wraps(0.0, None);
    for step in 1..=steps {
        now = wraps(time * f64::from(step) / f64::from(steps), Some(&now));
    }
    let straight: f64 = straight_parts(circles, time).iter().map(|(_, length)| length).sum();
    straight + now.iter().zip(&circles[1..]).map(|(wrap, circle)| wrap * circle.2.abs()).sum::<f64>()
}

/// Free bodies in a row, which keep their velocities, with a load over those within.
fn chain(circles: &[Circle], load: &str) -> String {
    let mut text = "name = \"chain\"\n".to_owned();
    let last = circles.len() - 1;
    for (number, ([x, y], [u, v], _)) in circles.iter().enumerate() {
        write!(
            text,
            "[bodies.b{number}]\nmass = 1\ninertia = 0.1\n[initial.b{number}]\nx = {x:?}\ny = {y:?}\nvx = {u:?}\nvy = {v:?}\nangle = 0\nomega = 0\n"
        )
        .unwrap();
    }
    write!(text, "[loads.band]\n{load}\nbetween = [\"b0\", \"b{last}\"]\nover = [").unwrap();
    for (number, (_, _, radius)) in circles.iter().enumerate().take(last).skip(1) {
        let side = if *radius > 0.0 { "left" } else { "right" };
        write!(text, "{{ on = \"b{number}\", radius = {:?}, side = \"{side}\" }}, ", radius.abs()).unwrap();
    }
    text + "]\n"
}

/// A chain that stays clear of wraps of no or one turn for 0.1 s.
fn random_chain(random: &mut Random) -> Vec<Circle> {
    loop {
        let mut circles: Vec<Circle> = Vec::new();
        for number in 0..5 {
            let at = [4.0 * f64::from(number) + random.between(-1.5, 1.5), random.between(-1.5, 1.5)];
            let velocity = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            let side = if random.between(-1.0, 1.0) > 0.0 { 1.0 } else { -1.0 };
            let radius = if number == 0 || number == 4 { 0.0 } else { side * random.between(0.2, 0.9) };
            circles.push((at, velocity, radius));
        }
        let is_clear = [0.0, 0.05, 0.1].iter().all(|&time| {
            let parts = straight_parts(&circles, time);
            let wrap = |(number, pair): (usize, &[(f64, f64)])| {
                (circles[number + 1].2.signum() * (pair[1].0 - pair[0].0)).rem_euclid(TAU)
            };
            parts.windows(2).enumerate().map(wrap).all(|wrap| (0.2..6.0).contains(&wrap))
        });
        if is_clear {
            return circles;
        }
    }
}

/// Lengths and rates of random chains of circles on all sides; the rate is that of the unit tangents, the length has arcs.
#[test]
fn lengths_and_rates_of_random_chains_are_those_of_their_circles() {
    let mut random = Random(1);
    let (mut worst, mut worst_rate) = (0.0_f64, 0.0_f64);
    for _ in 0..500 {
        let circles = random_chain(&mut random);
        let text = chain(&circles, "type = \"actuator\"\nforce = 0")
            + "[outputs]\nvariables = [\"band.length\", \"band.rate\"]\n";
        let mut instance = started(&model(&text), None, 1.0, 1e-10);
        instance.step_to(0.05).unwrap();
        let found = ["band.length", "band.rate"].map(|name| value(&mut instance, name));
        worst = worst.max((found[0] - length(&circles, 0.05)).abs());
        let step = 1e-3;
        let differences = [1.0, 2.0].map(|share: f64| {
            let far = share * step;
            (length(&circles, 0.05 + far) - length(&circles, 0.05 - far)) / (2.0 * far)
        });
        let rate = (4.0 * differences[0] - differences[1]) / 3.0;
        worst_rate = worst_rate.max((found[1] - rate).abs());
    }
    assert!(worst < 1e-9 && worst_rate < 1e-9, "{worst:e}, {worst_rate:e}");
}

/// Springs over random chains, one end wound on a drum that turns: nothing takes energy, so all that acts along the course follows from its length.
#[test]
fn springs_over_pulleys_and_onto_drums_keep_the_energy() {
    let mut random = Random(7);
    for _ in 0..10 {
        let circles = random_chain(&mut random);
        let plain = chain(&circles, "type = \"spring\"\nstiffness = 3\nlength = 12");
        let drum = plain.replace("[\"b0\", \"b4\"]", "[{ drum = \"b0\", radius = 0.3, side = \"right\" }, \"b4\"]");
        for text in [plain, drum] {
            let text =
                text + "[outputs]\nvariables = [\"energy.total\", \"band.length\", \"band.power\", \"b0.omega\"]\n";
            let mut instance = started(&model(&text), None, 1.0, 1e-10);
            let before = value(&mut instance, "energy.total");
            instance.step_to(0.1).unwrap();
            assert_eq!(instance.events().count(), 0, "turns of straight parts are no events of the scene");
            let after = value(&mut instance, "energy.total");
            assert!((after - before).abs() < 1e-9 * before.abs(), "{before} {after}\n{text}");
        }
    }
}

/// A weight on a sheave in a bight of parallel straight parts, at heights that differ by rounding: no branch of the half turn is left.
#[test]
fn a_half_turn_is_no_branch() {
    for off in [0.0, 1e-9, -1e-9, 1e-15, -1e-15] {
        let text = format!(
            "name = \"half\"\n[ground]\npoints = {{ a = [-0.1, 2], b = [{:?}, 2] }}\n[bodies.sheave]\nmass = 1\ninertia = 1\n[loads.band]\ntype = \"actuator\"\nforce = 0\nbetween = [\"ground.a\", \"ground.b\"]\nover = [{{ on = \"sheave\", radius = 0.1, side = \"left\" }}]\n[initial.sheave]\nx = 0\ny = 0\nvx = 0\nvy = 0\nangle = 0\nomega = 0\n[outputs]\nvariables = [\"band.length\"]\n",
            0.1 + off
        );
        let found = value(&mut started(&model(&text), None, 1.0, 1e-10), "band.length");
        assert!((found - (4.0 + 0.1 * PI)).abs() < 2e-9, "{off}: {found}");
    }
}

/// Straight parts between equal pulleys: on one side as long as their distance, crossed sqrt(d^2 - 4 r^2).
#[test]
fn equal_pulleys_on_one_side_and_crossed() {
    let (distance, radius): (f64, f64) = (2.0, 0.3);
    for second in ["left", "right"] {
        let text = format!(
            "name = \"pair\"\n[ground]\npoints = {{ a = [0, -3], p = [0.3, 0], q = [2.3, 0], b = [{:?}, {:?}] }}\n[bodies.ball]\nmass = 1\n[loads.band]\ntype = \"actuator\"\nforce = 0\nbetween = [\"ground.a\", \"ball\"]\nover = [{{ on = \"ground.p\", radius = 0.3, side = \"right\" }}, {{ on = \"ground.q\", radius = 0.3, side = \"{second}\" }}]\n[initial.ball]\nx = {:?}\ny = {:?}\nvx = 0\nvy = 0\n[outputs]\nvariables = [\"band.length\"]\n",
            0.0,
            0.0,
            2.6,
            if second == "right" { -3.0 } else { 3.0 }
        )
        .replace(", b = [0.0, 0.0]", "");
        let found = value(&mut started(&model(&text), None, 1.0, 1e-10), "band.length");
        let expected = match second {
            "right" => 3.0 + 0.5 * PI * radius + distance + 0.5 * PI * radius + 3.0,
            _ => {
                let straight = (distance * distance - 4.0 * radius * radius).sqrt();
                let slope = (2.0 * radius / distance).asin();
                // Up, a quarter less the slope around the first, across, and as much around the second.
                3.0 + 2.0 * radius * (0.5 * PI + slope) + straight + 3.0
            }
        };
        assert!((found - expected).abs() < 1e-12, "{second}: {found} {expected}");
    }
}

/// A driven drum winds up ten turns of a band whose free end stands still: the length is less by what is wound up.
#[test]
fn a_drum_of_ten_turns_winds_up_its_circumference() {
    let text = "name = \"drum\"\n[bodies.drum]\nmass = 1\ninertia = 1\n[bodies.ball]\nmass = 1\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"drum\"]\n[loads.band]\ntype = \"actuator\"\nforce = 0\nbetween = [{ drum = \"drum\", radius = 0.1, side = \"left\" }, \"ball\"]\n[initial]\n\"pin.angle\" = 1\n\"pin.omega\" = -6.283185307179586\n\"ball.x\" = 3\n\"ball.y\" = 0\n\"ball.vx\" = 0\n\"ball.vy\" = 0\n[outputs]\nvariables = [\"band.length\"]\n";
    let mut instance = started(&model(text), None, 20.0, 1e-10);
    let before = value(&mut instance, "band.length");
    assert!((before - (9.0_f64 - 0.01).sqrt()).abs() < 1e-12, "{before}");
    instance.step_to(10.0).unwrap();
    // Wound counterclockwise from the drum, its turning back takes the band up.
    let after = value(&mut instance, "band.length");
    assert!((after - before - 10.0 * TAU * 0.1).abs() < 1e-11, "{before} {after}");
}

/// A ball that flies five times around a post on which its band begins: the arc is counted over all turns.
#[test]
fn a_wrap_is_counted_over_many_turns() {
    let text = "name = \"post\"\n[bodies.arm]\nmass = 1\ninertia = 1\npoints = { tip = [2, 0] }\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n[ground]\npoints = { a = [-2, 0] }\n[loads.band]\ntype = \"actuator\"\nforce = 0\nbetween = [\"ground.a\", \"arm.tip\"]\nover = [{ on = \"ground\", radius = 0.2, side = \"left\" }]\n[initial]\n\"pin.angle\" = 0.5\n\"pin.omega\" = 6.283185307179586\n[outputs]\nvariables = [\"band.length\"]\n";
    let mut instance = started(&model(text), None, 20.0, 1e-10);
    let before = value(&mut instance, "band.length");
    instance.step_to(5.0).unwrap();
    let after = value(&mut instance, "band.length");
    assert!((after - before - 5.0 * TAU * 0.2).abs() < 1e-10, "{before} {after}");
}

/// A rope over a fixed drum with two weights: it sticks up to the ratio exp(mu phi) of Euler and Eytelwein, and slides with the acceleration that follows from it.
#[test]
fn weights_on_a_capstan_slide_as_euler_and_eytelwein_say() {
    for (masses, mu) in
        [([1.0, 2.0], 0.3), ([1.0, 4.0], 0.3), ([4.0, 1.0], 0.3), ([1.0, 3.0], 50.0 / PI), ([1.0, 3.0], 0.0)]
    {
        let [first, second]: [f64; 2] = masses;
        let text = capstan(masses, &format!(", mu = {mu:?}"));
        let mut instance = started(&model(&text), None, 1.0, 1e-10);
        instance.step_to(0.5).unwrap();
        let found = value(&mut instance, "right.vy");
        let (grip, g) = ((mu * PI).exp(), 9.81);
        let expected = if second > first * grip {
            -0.5 * g * (second - first * grip) / (second + first * grip)
        } else if first > second * grip {
            0.5 * g * (first - second * grip) / (first + second * grip)
        } else {
            0.0
        };
        assert!((found - expected).abs() < 1e-9, "{masses:?} {mu}: {found} {expected}");
        if mu == 0.0 {
            let mut free = started(&model(&capstan(masses, "")), None, 1.0, 1e-10);
            free.step_to(0.5).unwrap();
            assert!((value(&mut free, "right.vy") - found).abs() < 1e-12);
        }
    }
}

pub fn capstan([first, second]: [f64; 2], friction: &str) -> String {
    format!(
        "name = \"capstan\"\ngravity = [0, -9.81]\n[ground]\npoints = {{ l = [-0.1, 0], r = [0.1, 0] }}\n[bodies.left]\nmass = {first:?}\ninertia = 0.1\n[bodies.right]\nmass = {second:?}\ninertia = 0.1\n[joints.guide_1]\ntype = \"prismatic\"\nbetween = [\"ground.l\", \"left\"]\naxis = [0, 1]\n[joints.guide_2]\ntype = \"prismatic\"\nbetween = [\"ground.r\", \"right\"]\naxis = [0, 1]\n[joints.line]\ntype = \"rope\"\nbetween = [\"left\", \"right\"]\nover = [{{ on = \"ground\", radius = 0.1, side = \"right\"{friction} }}]\n[initial]\n\"guide_1.s\" = -10\n\"guide_1.v\" = 0\n\"guide_2.s\" = -10\n\"guide_2.v\" = 0\n[outputs]\nvariables = [\"right.vy\", \"line.force\", \"line.gap\", \"left.vy\"]\n"
    )
}

/// One weight that is thrown up makes the rope slack: no tension is left on either side, whatever rubs.
#[test]
fn a_rope_with_friction_is_slack_on_both_sides() {
    let text = capstan([1.0, 2.0], ", mu = 0.3").replace("\"guide_2.v\" = 0", "\"guide_2.v\" = 3");
    let mut instance = started(&model(&text), None, 1.0, 1e-10);
    instance.step_to(0.2).unwrap();
    let [left, right] = ["left.vy", "right.vy"].map(|name| value(&mut instance, name));
    assert!((left + 9.81 * 0.2).abs() < 1e-10 && (right - 3.0 + 9.81 * 0.2).abs() < 1e-10, "{left} {right}");
    assert!(value(&mut instance, "line.force") == 0.0 && value(&mut instance, "line.gap") > 0.1);
}

/// A counterweight in a guide and a swinging bob over a pulley, by the two coordinates arc and angle: the free length is l, the bob hangs on the tangent at the angle a from the vertical.
#[test]
fn a_swinging_atwood_machine() {
    let text = "name = \"atwood\"\ngravity = [0, -9.81]\n[bodies.counterweight]\nmass = 2\ninertia = 0.1\n[bodies.bob]\nmass = 1.5\ninertia = 0.1\n[joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground.left\", \"counterweight\"]\naxis = [0, 1]\n[joints.line]\ntype = \"rope\"\nbetween = [\"counterweight\", \"bob\"]\nover = [{ on = \"ground\", radius = 0.1, side = \"right\" }]\n[ground]\npoints = { left = [-0.1, 0] }\n[initial]\n\"guide.s\" = -1\n\"guide.v\" = 0\n\"bob.x\" = 0.6\n\"bob.y\" = -0.8\n\"bob.angle\" = 0\n\"bob.vx\" = 0\n\"bob.vy\" = 0\n\"bob.omega\" = 0\n[outputs]\nvariables = [\"counterweight.y\", \"bob.x\", \"bob.y\", \"bob.vx\"]\n";
    let mut instance = started(&model(text), None, 1.0, 1e-11);
    instance.step_to(0.8).unwrap();
    let found = ["counterweight.y", "bob.x", "bob.y"].map(|name| value(&mut instance, name));
    // The tangent at the angle a: the rope leaves at R (cos a, sin a) along (sin a, -cos a), so the bob is at R (cos a, sin a) + l (sin a, -cos a), and the arc is R (pi - a).
    let (big, m, r, g) = (2.0, 1.5, 0.1, 9.81);
    let (distance, heading) = (0.6_f64.hypot(0.8), (-0.8_f64).atan2(0.6));
    let free = (distance * distance - r * r).sqrt();
    let angle = heading + (free / r).atan();
    let total = 1.0 + r * (PI - angle) + free;
    // Velocity of the bob: l a' along (cos a, sin a), (l' - R a') along (sin a, -cos a); the counterweight rises by l' - R a'. With s = l - R a the kinetic energy is (M + m) s'^2/2 + m l^2 a'^2/2.
    let f = |[s, a, u, w]: [f64; 4]| {
        let l = s + r * a;
        let along = (m * l * w * w + m * g * a.cos() - big * g) / (big + m);
        let across = (-g * a.sin() - 2.0 * u * w - r * w * w) / l;
        [u, w, along, across]
    };
    let mut z = [free - r * angle, angle, 0.0, 0.0];
    let steps = 4000;
    let h = 0.8 / f64::from(steps);
    for _ in 0..steps {
        let moved = |k: [f64; 4], h: f64| std::array::from_fn(|i| z[i] + h * k[i]);
        let k1 = f(z);
        let k2 = f(moved(k1, 0.5 * h));
        let k3 = f(moved(k2, 0.5 * h));
        let k4 = f(moved(k3, h));
        z = std::array::from_fn(|i| z[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let (l, a) = (z[0] + r * z[1], z[1]);
    let expected = [-(total - l - r * (PI - a)), r * a.cos() + l * a.sin(), r * a.sin() - l * a.cos()];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
}

/// A band from an anchor over the top of a pulley to a ball that rises on a guide: its wrap is zero where the ball is on the tangent from the anchor, and there the run ends with the names of both.
#[test]
fn a_band_that_would_leave_its_pulley_ends_the_run() {
    let scene = r#"
name = "lift"
[ground.points]
anchor = [-1, -0.2]
rail = [1, 0]
[bodies.ball]
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
between = ["ground.rail", "ball"]
axis = [0, 1]
[loads.band]
type = "spring"
between = ["ground.anchor", "ball"]
over = [{ on = "ground", radius = 0.1, side = "right" }]
stiffness = 1e-12
length = 1
[initial]
"guide.s" = -0.5
"guide.v" = 1
[outputs]
variables = ["guide.s"]
"#;
    let slope = (0.2_f64.atan() + (0.1 / 1.04_f64.sqrt()).asin()).tan();
    let leaves = 0.5 - 0.2 + 2.0 * slope;
    for engine in [None, Some(cotree_fmu::program::Engine::Radau)] {
        let mut instance = started(&model(scene), engine, 2.0, 1e-10);
        let told = instance.step_to(2.0).unwrap_err().to_string();
        assert!(told.contains("the wrap of `band` on its pulley 1"), "{told}");
        let time: f64 = told.split_whitespace().nth(3).unwrap().parse().unwrap();
        assert!((time - leaves).abs() < 1e-8, "{time}, not {leaves}: {told}");
    }
}

/// A point comes down on a circle until the rope lies along its tangent, and goes up again: the wrap reaches zero within rounding errors and nothing happens; the length is that of the tangent and the arc all the time.
#[test]
fn a_wrap_that_only_reaches_zero_changes_nothing() {
    let text = r#"
name = "grazes"
[ground]
points = { a = [-1, 0.1], peg = [0, 0] }
[bodies.ball]
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
[drivers.lift]
joint = "guide"
displacement = "0.1 - 0.05*(1 - 2*t)^2"
[loads.band]
type = "actuator"
force = 0
between = ["ground.a", "ball"]
over = [{ on = "ground.peg", radius = 0.1, side = "right" }]
[outputs]
variables = ["band.length", "guide.s"]
[experiment]
stop = 1
"#;
    let text = text
        .replace("points = { a = [-1, 0.1], peg = [0, 0] }", "points = { a = [-1, 0.1], peg = [0, 0], rail = [1, 0] }");
    let text = text.replace("between = [\"ground\", \"ball\"]\naxis", "between = [\"ground.rail\", \"ball\"]\naxis");
    let mut instance = started(&model(&text), None, 1.0, 1e-10);
    for step in 1..=20 {
        instance.step_to(0.05 * f64::from(step)).unwrap();
        let [found, y] = ["band.length", "guide.s"].map(|name| value(&mut instance, name));
        // The tangent from (1, y) to the circle, and the arc from its top.
        let square = 1.0 + y * y - 0.01;
        let straight = f64::sqrt(square);
        let wrap = f64::max(0.0, f64::atan2(0.1, straight) - f64::atan2(y, 1.0));
        let right = 1.0 + straight + 0.1 * wrap;
        assert!((found - right).abs() < 1e-12, "{y}: {found}, not {right}");
    }
    assert_eq!(instance.events().count(), 0);
}
