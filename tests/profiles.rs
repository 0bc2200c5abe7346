//! Contacts with profiles: closed forms, a disc that flies at random polygons against a search by brute force, energies over many corners, and what is refused.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use crate::support::run;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::math::Random;
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 2] = [None, Some(Engine::Radau)];

fn refused(text: &str) -> String {
    let compiled = Scene::from_toml(text).and_then(|scene| cotree::compile::compile(&scene));
    compiled.err().unwrap_or_else(|| panic!("is compiled: {text}")).to_string()
}

/// A disc of 1 kg, and a contact.
pub fn disc(contact: &str, [x, y]: [f64; 2], [vx, vy]: [f64; 2], more: &str) -> String {
    format!(
        r#"
name = "disc"
gravity = [0, -9.81]
[bodies.ball]
mass = 1
inertia = 0.02
[joints.edge]
type = "contact"
between = ["ground", "ball"]
{contact}
[initial]
"ball.x" = {x}
"ball.y" = {y}
"ball.angle" = 0
"ball.vx" = {vx}
"ball.vy" = {vy}
"ball.omega" = 0
[experiment]
stop = 2
[outputs]
variables = ["ball.x", "ball.y", "ball.vx", "ball.vy", "edge.gap", "edge.fn", "edge.impulse", "edge.mode", "energy.total"]
{more}"#
    )
}

fn check(text: &str, values: &[(f64, &str, f64)], tolerance: f64) {
    let model = run::model(text);
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 4.0, 1e-11);
        for &(time, name, right) in values {
            if time > instance.time() {
                instance.step_to(time).unwrap();
            }
            let found = run::value(&mut instance, name);
            assert!((found - right).abs() < tolerance, "{name} at {time} by {engine:?}: {found}, not {right}");
        }
    }
}

/// It slides at 0.6 m/s up to the corner of a table, turns about it and lifts off where cos a = 2/3 + v^2/(3 g R): at 0.691033 s, found by quadrature of its energy.
#[test]
fn a_disc_goes_over_the_corner_of_a_table_and_lifts_off() {
    let table = "profile = [[0, -2], [0, 0], [-1, 0]]\nside = \"right\"\nradius = 0.2";
    let text = disc(table, [-0.3, 0.2], [0.6, 0.0], "");
    let values = [
        (0.4, "edge.fn", 9.81),
        (0.4, "edge.mode", 1.0),
        (0.4, "edge.gap", 0.0),
        // Just behind the corner the normal force is less by m v^2/R.
        (0.5 + 1e-9, "edge.fn", 9.81 - 0.36 / 0.2),
        (0.69, "edge.mode", 1.0),
        (0.692, "edge.mode", 0.0),
        (0.8, "ball.x", 0.23192536225161542),
        (0.8, "ball.y", -0.0019704883081744923),
        (0.8, "ball.vy", -1.8884384692634475),
    ];
    check(&text, &values, 1e-7);
}

/// Each pass of the corner of a notch keeps t1.t2 of the speed. It rests there after infinitely many of them.
#[test]
fn each_pass_of_a_notch_is_an_impact_with_its_next_side() {
    let text = disc("profile = [[-1, 1], [0, 0], [1, 0.5]]", [-0.5, 0.5], [0.0, 0.0], "");
    let (slope, other) = ([0.5_f64.sqrt(), -(0.5_f64.sqrt())], [2.0 / 5.0_f64.sqrt(), 1.0 / 5.0_f64.sqrt()]);
    let kept = slope[0] * other[0] + slope[1] * other[1];
    let speed = (2.0 * 9.81 * 0.5_f64).sqrt();
    let first = speed / (9.81 * 0.5_f64.sqrt());
    let top = first + kept * speed / (9.81 * other[1]);
    let rest = [
        (first + 1e-3, "edge.impulse", speed * (1.0 - kept * kept).sqrt()),
        (top, "ball.y", 0.5 * kept * kept),
        (top, "ball.vy", 0.0),
        (1.2, "ball.x", 0.0),
        (1.2, "ball.y", 0.0),
        (1.2, "edge.mode", 2.0),
        (2.0, "ball.y", 0.0),
        (2.0, "ball.vx", 0.0),
    ];
    check(&text, &rest, 1e-7);
}

/// A point in a half circle is a pendulum: compared with one.
#[test]
fn a_point_in_a_bowl_is_a_pendulum() {
    let bowl = "profile = [[-1, 0], { to = [1, 0], radius = 1 }]";
    let at = |angle: f64| [angle.sin(), -angle.cos()];
    let text = disc(bowl, at(-0.8), [0.0, 0.0], "");
    let pendulum = "name = \"p\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 1\ninertia = 0\npoints = { top = [0, 1] }\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"ball.top\"]\n[initial]\n\"pin.angle\" = -0.8\n\"pin.omega\" = 0\n[outputs]\nvariables = [\"ball.x\", \"ball.y\"]\n";
    let (bowl, pendulum) = (run::model(&text), run::model(pendulum));
    let [mut bowl, mut pendulum] = [bowl, pendulum].map(|model| run::started(&model, None, 4.0, 1e-11));
    for time in [0.3, 0.9, 1.7, 3.9] {
        for name in ["ball.x", "ball.y"] {
            let [found, right] = [&mut bowl, &mut pendulum].map(|instance| {
                if instance.time() < time {
                    instance.step_to(time).unwrap();
                }
                run::value(instance, name)
            });
            assert!((found - right).abs() < 1e-8, "{name} at {time}: {found}, not {right}");
        }
    }
}

/// A ramp goes over into the floor by an arc with the same tangent: nothing is lost.
#[test]
fn a_smooth_way_keeps_the_energy() {
    // 45 degrees down, then an arc of radius 0.5 whose end is level.
    let (sine, radius) = (0.5_f64.sqrt(), 0.5);
    let [x, y] = [radius * sine, radius * (1.0 - sine)];
    let profile = format!(
        "profile = [[{}, {}], [{}, {y}], {{ to = [0, 0], radius = {radius} }}, [4, 0]]\nradius = 0.1",
        -x - 1.0,
        y + 1.0,
        -x
    );
    // The centre of the disc, half a metre up the ramp.
    let start = [-x - 0.5 + 0.1 * sine, y + 0.5 + 0.1 * sine];
    let text = disc(&profile, start, [0.0, 0.0], "");
    let speed = (2.0 * 9.81 * (start[1] - 0.1)).sqrt();
    check(&text, &[(1.2, "ball.y", 0.1), (1.2, "ball.vx", speed), (1.2, "edge.impulse", 0.0)], 1e-8);
}

/// Held by a spring to the centre of a polygon a disc slides around it; over its corners nothing is lost.
#[test]
fn a_hundred_convex_corners_cost_no_energy() {
    let corners: Vec<String> = (0..12)
        .map(|corner| {
            let (sine, cosine) = (TAU * f64::from(corner) / 12.0).sin_cos();
            format!("[{cosine}, {sine}]")
        })
        .collect();
    let outline = format!("profile = [{}]\nclosed = true\nside = \"right\"\nradius = 0.1", corners.join(", "));
    let apothem = (PI / 12.0).cos();
    let (sine, cosine) = (PI / 12.0).sin_cos();
    let [out, speed] = [apothem + 0.1, 3.0];
    let spring = "[loads.pull]\ntype = \"spring\"\nbetween = [\"ground\", \"ball\"]\nstiffness = 100\nlength = 0\n";
    let text =
        disc(&outline, [out * cosine, out * sine], [-speed * sine, speed * cosine], spring).replace("-9.81", "0");
    let model = run::model(&text);
    let mut instance = run::started(&model, None, 30.0, 1e-12);
    let start = run::value(&mut instance, "energy.total");
    let mut turns = 0;
    let mut before = run::value(&mut instance, "ball.y");
    for step in 1..=3000 {
        instance.step_to(0.01 * f64::from(step)).unwrap();
        let (y, x) = (run::value(&mut instance, "ball.y"), run::value(&mut instance, "ball.x"));
        turns += i32::from(before < 0.0 && y >= 0.0 && x > 0.0);
        before = y;
    }
    assert!(turns >= 9, "{turns} turns have 12 corners each");
    let [energy, mode] = ["energy.total", "edge.mode"].map(|name| run::value(&mut instance, name));
    assert!((energy - start).abs() < 1e-9 * start && mode == 1.0, "{energy}, {start}, {mode}");
}

/// A polygon that turns about the origin, and a disc that flies at it.
pub struct Flight {
    corners: Vec<[f64; 2]>,
    radius: f64,
    omega: f64,
    at: [f64; 2],
    rate: [f64; 2],
}

impl Flight {
    pub fn new(random: &mut Random) -> Flight {
        let count = 12;
        // Without a gap of half a turn no side passes on the other side of the origin, where it could cross others.
        let mut angles = vec![0.0, PI];
        while (0..angles.len()).any(|at| (angles[(at + 1) % angles.len()] - angles[at]).rem_euclid(TAU) > 3.0) {
            angles = (0..count).map(|_| TAU * random.unit()).collect();
            angles.sort_by(f64::total_cmp);
        }
        let corner = |angle: &f64| {
            let out = 0.3 + 0.7 * random.unit();
            [out * angle.cos(), out * angle.sin()]
        };
        let corners = angles.iter().map(corner).collect();
        let radius = [0.01, 0.05, 0.1][(3.0 * random.unit()) as usize % 3];
        let at = [0, 1].map(|_| 3.0 * random.symmetric());
        let rate = at.map(|from| 2.0 * (random.symmetric() - from));
        Flight { corners, radius, omega: 6.0 * random.symmetric(), at, rate }
    }

    /// The distance of the disc from the outline, negative inside: by distances from its sides and how often a ray crosses them.
    pub fn gap(&self, time: f64) -> f64 {
        let (sine, cosine) = (self.omega * time).sin_cos();
        let fall = [0.0, -0.5 * 9.81 * time * time];
        let [x, y] = [0, 1].map(|axis| self.at[axis] + self.rate[axis] * time + fall[axis]);
        self.distance([cosine * x + sine * y, cosine * y - sine * x])
    }

    /// The same where the disc is there in the axes of the polygon.
    fn distance(&self, [px, py]: [f64; 2]) -> f64 {
        let (mut least, mut inside) = (f64::INFINITY, false);
        for (index, [ax, ay]) in self.corners.iter().enumerate() {
            let [bx, by] = self.corners[(index + 1) % self.corners.len()];
            let [dx, dy] = [bx - ax, by - ay];
            let share = (((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            least = least.min((px - ax - share * dx).hypot(py - ay - share * dy));
            inside ^= (*ay > py) != (by > py) && px < (bx - ax) * (py - ay) / (by - ay) + ax;
        }
        if inside { -least - self.radius } else { least - self.radius }
    }

    /// When it is touched first, by very many places; the least gap before.
    fn first(&self) -> (Option<f64>, f64) {
        const PLACES: u32 = 20_000;
        let time = |place: u32| f64::from(place) / f64::from(PLACES);
        let mut least = f64::INFINITY;
        let gaps: Vec<f64> = (0..=PLACES).map(|place| self.gap(time(place))).collect();
        for place in 1..PLACES as usize {
            let [before, now, after] = [gaps[place - 1], gaps[place], gaps[place + 1]];
            least = least.min(now);
            let mut touched = (now <= 0.0).then(|| time(place as u32));
            if touched.is_none() && now <= before && now <= after {
                let (mut from, mut to) = (time(place as u32 - 1), time(place as u32 + 1));
                for _ in 0..60 {
                    let [a, b] = [from + 0.382 * (to - from), from + 0.618 * (to - from)];
                    if self.gap(a) < self.gap(b) { to = b } else { from = a }
                }
                let dip = self.gap(0.5 * (from + to));
                least = least.min(dip);
                touched = (dip <= 0.0).then_some(0.5 * (from + to));
            }
            if let Some(mut to) = touched {
                let mut from = time(place as u32 - 1);
                for _ in 0..60 {
                    let middle = 0.5 * (from + to);
                    if self.gap(middle) <= 0.0 { to = middle } else { from = middle }
                }
                return (Some(to), least);
            }
        }
        (None, least)
    }

    pub fn scene(&self) -> String {
        let mut corners = String::new();
        for [x, y] in &self.corners {
            write!(corners, "[{x:?}, {y:?}], ").unwrap();
        }
        let Flight { radius, omega, at, rate, .. } = self;
        format!(
            r#"
name = "flight"
gravity = [0, -9.81]
[bodies]
wheel = {{ mass = 1, inertia = 1e9 }}
ball = {{ mass = 1, inertia = 0.02 }}
[joints]
pin = {{ type = "revolute", between = ["ground", "wheel"] }}
tooth = {{ type = "contact", between = ["wheel", "ball"], profile = [{corners}], closed = true, side = "right", radius = {radius} }}
[initial]
"pin.angle" = 0
"pin.omega" = {omega:?}
"ball.x" = {:?}
"ball.y" = {:?}
"ball.angle" = 0
"ball.vx" = {:?}
"ball.vy" = {:?}
"ball.omega" = 0
[experiment]
stop = 1
[outputs]
variables = ["tooth.gap", "pin.angle", "ball.x", "ball.y"]
"#,
            at[0], at[1], rate[0], rate[1]
        )
    }

    /// When the program finds that it touches first, to a thousandth of a second, and the gap that it had there; none if the run is refused, by the name of the contact.
    fn found(&self, tolerance: f64) -> Option<(Option<f64>, f64)> {
        let model = run::model(&self.scene());
        let mut instance = run::started(&model, None, 1.0, tolerance);
        let touched = |instance: &Instance| instance.events().any(|(_, count)| count > 0);
        let mut least = f64::INFINITY;
        for step in 1..=1000 {
            let time = f64::from(step) / 1000.0;
            if let Err(failure) = instance.step_to(time) {
                assert!(failure.to_string().contains("`tooth`"), "{failure}\n{}", self.scene());
                return None;
            }
            if touched(&instance) {
                return Some((Some(time), least));
            }
            least = least.min(run::value(&mut instance, "tooth.gap"));
        }
        Some((None, least))
    }
}

/// What happens after the first contact: impacts, sliding, corners. The disc never enters the polygon, and its gap is the distance.
#[test]
fn a_disc_never_enters_the_polygon_that_it_touches() {
    let mut random = Random::new(5);
    let mut flown = 0;
    while flown < 30 {
        let flight = Flight::new(&mut random);
        if flight.gap(0.0) <= 1e-3 {
            continue;
        }
        flown += 1;
        let model = run::model(&flight.scene());
        let mut instance = run::started(&model, None, 2.0, 1e-8);
        for step in 1..=200 {
            instance.step_to(0.01 * f64::from(step)).unwrap_or_else(|failure| panic!("{failure}\n{}", flight.scene()));
            let [gap, angle, x, y] =
                ["tooth.gap", "pin.angle", "ball.x", "ball.y"].map(|name| run::value(&mut instance, name));
            let (sine, cosine) = angle.sin_cos();
            let right = flight.distance([cosine * x + sine * y, cosine * y - sine * x]);
            assert!(right > -1e-9 && (gap - right).abs() < 1e-9, "{gap}, not {right}: {}", flight.scene());
        }
    }
}

/// How many touch, fly and are refused.
fn flights(count: usize, seed: u64) -> (usize, usize, usize) {
    let mut random = Random::new(seed);
    let (mut hits, mut flown, mut refused) = (0, 0, 0);
    while flown < count {
        let flight = Flight::new(&mut random);
        if flight.gap(0.0) <= 1e-3 {
            continue;
        }
        flown += 1;
        let (right, least) = flight.first();
        let Some((found, seen)) = flight.found(1e-9) else {
            refused += 1;
            continue;
        };
        match (right, found) {
            (Some(right), Some(found)) => {
                assert!((found - right).abs() < 1.1e-3, "touches at {right}, not {found}: {}", flight.scene());
                hits += 1;
            }
            (None, None) => {}
            // What it grazes by less than the tolerance may be either.
            (Some(_), None) => assert!(least > -1e-7 && seen.abs() < 1e-3, "missed: {right:?}, {}", flight.scene()),
            (None, Some(_)) => assert!(least < 1e-7, "touches nothing: {least}, {}", flight.scene()),
        }
    }
    (hits, flown, refused)
}

/// Of a dozen numbers that hit a polygon, one is not seen by twenty looks in a second.
#[test]
fn no_flight_at_a_polygon_misses_it() {
    let (hits, flown, refused) = flights(60, 7);
    assert!(hits > 20 && refused == 0, "{hits} of {flown}, {refused} refused");
}

#[test]
#[ignore = "all flights: some minutes"]
fn no_flight_of_two_thousand_misses_its_polygon() {
    let (hits, flown, refused) = flights(2000, 1);
    println!("{hits} of {flown} flights touch their polygon, {refused} are refused");
    assert!(hits > 500 && refused < 20);
}

/// A disc falls into a gap that is narrower than it is, and rests on both of its corners; with a radius of half the gap it touches three sides.
#[test]
fn a_disc_rests_on_two_corners_or_in_a_corner() {
    let gap = "profile = [[-1, 0], [-0.1, 0], [-0.1, -1], [0.1, -1], [0.1, 0], [1, 0]]\nradius = 0.125";
    let text = disc(gap, [0.0, 1.0], [0.0, 0.0], "");
    let deep = (0.125_f64.powi(2) - 0.1_f64.powi(2)).sqrt();
    check(&text, &[(2.0, "ball.y", deep), (2.0, "ball.x", 0.0), (2.0, "edge.mode", 2.0), (2.0, "ball.vy", 0.0)], 1e-9);
    let corner = "profile = [[0, 1], [0, 0], [1, 0]]\nradius = 0.125";
    let text = disc(corner, [0.5, 0.3], [-1.0, 0.0], "");
    check(&text, &[(2.0, "ball.x", 0.125), (2.0, "ball.y", 0.125), (2.0, "edge.mode", 2.0)], 1e-9);
}

/// It bounces on a floor with a step, and loses what its restitution says.
#[test]
fn bounces_on_a_profile_are_those_on_a_line() {
    let floor = "profile = [[-1, 0], [0.5, 0], [0.5, 0.2], [3, 0.2]]\nradius = 0.1\nrestitution = 0.7";
    let text = disc(floor, [0.0, 0.6], [0.0, 0.0], "");
    let line = disc("axis = [1, 0]\nradius = 0.1\nrestitution = 0.7", [0.0, 0.6], [0.0, 0.0], "");
    let (text, line) = (run::model(&text), run::model(&line));
    let [mut on_profile, mut on_line] = [text, line].map(|model| run::started(&model, None, 4.0, 1e-11));
    for time in [0.2, 0.5, 0.9, 1.3, 1.7, 2.0] {
        let [found, right] = [&mut on_profile, &mut on_line].map(|instance| {
            instance.step_to(time).unwrap();
            run::value(instance, "ball.y")
        });
        assert!((found - right).abs() < 1e-9, "at {time}: {found}, not {right}");
    }
}

/// A run that is saved in the middle of a corner goes on as if it had not been.
#[test]
fn a_saved_state_holds_the_feature_that_is_touched() {
    let table = "profile = [[0, -2], [0, 0], [-1, 0]]\nside = \"right\"\nradius = 0.2";
    let model = run::model(&disc(table, [-0.3, 0.2], [0.6, 0.0], ""));
    let mut instance = run::started(&model, None, 1.0, 1e-10);
    instance.step_to(0.6).unwrap();
    let saved = instance.save();
    instance.step_to(0.8).unwrap();
    let right = run::value(&mut instance, "ball.x");
    instance.restore(&saved).unwrap();
    instance.step_to(0.8).unwrap();
    assert_eq!(run::value(&mut instance, "ball.x"), right);
}

#[test]
fn what_comes_from_behind_and_starts_inside_is_refused_by_name() {
    let inside = disc("profile = [[-1, 0], [1, 0]]\nradius = 0.1", [0.0, 0.05], [0.0, 0.0], "");
    let message = refused(&inside);
    assert!(message.contains("`edge` starts inside its profile"), "{message}");
    let below = disc("profile = [[-1, 0], [1, 0]]\nradius = 0.1", [0.0, -0.5], [0.0, 5.0], "");
    let message = refused(&below);
    assert!(message.contains("`edge` starts inside its profile"), "{message}");
    // It begins beyond the end, and comes back under the line.
    let around = disc("profile = [[-1, 0], [1, 0]]\nradius = 0.1", [1.2, -0.5], [-2.0, 3.0], "");
    let model = run::model(&around);
    let mut instance = run::started(&model, None, 4.0, 1e-10);
    let failure = instance.step_to(2.0).unwrap_err().to_string();
    assert!(failure.contains("edge") && failure.contains("from behind"), "{failure}");
}

#[test]
fn profiles_are_refused_by_name_where_they_are_not_supported() {
    let table = "profile = [[0, -2], [0, 0], [-1, 0]]\nside = \"right\"\nradius = 0.2";
    let model = run::model(&disc(table, [-0.3, 0.2], [0.6, 0.0], ""));
    assert!(!model.program().offers_exchange() && !model.program().offers_exchange_with_rates());
    let named: BTreeSet<&str> = model.program().instants.contacts().iter().map(|contact| &*contact.name).collect();
    assert_eq!(named, BTreeSet::from(["edge"]));
}

/// A wheel with a polygon as its outline, about an axle, and a disc on its upper edge that slides off it without friction.
fn sliding_off(seed: u64) -> String {
    let mut random = Random::new(seed);
    let mut number = |scale: f64| scale * random.symmetric();
    let corners = 5 + seed % 4;
    let corner = |angle: f64| [0.25 * angle.cos(), 0.25 * angle.sin()];
    let angles = (0..corners).map(|index| (index as f64 + number(0.15)) * TAU / corners as f64);
    let points: Vec<[f64; 2]> = angles.map(corner).collect();
    let ends = (0..points.len()).map(|index| [points[index], points[(index + 1) % points.len()]]);
    let top = |[a, b]: &[[f64; 2]; 2]| a[1] + b[1];
    let [a, b] = ends.max_by(|one, other| top(one).total_cmp(&top(other))).unwrap();
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    let (radius, share) = (0.04 + number(0.02), 0.5 + number(0.3));
    let [x, y] = [0, 1].map(|k| a[k] + share * length * along[k] + radius * [along[1], -along[0]][k]);
    let (speed, omega) = (number(0.5), number(1.0));
    format!(
        r#"
name = "slides_off{seed}"
gravity = [0, -9.81]
[bodies]
wheel = {{ mass = 2, inertia = {:?} }}
disc = {{ mass = 1, inertia = 0.001 }}
[joints]
axle = {{ type = "revolute", between = ["ground", "wheel"] }}
edge = {{ type = "contact", between = ["wheel", "disc"], radius = {radius:?}, side = "right", closed = true, profile = {points:?} }}
[initial]
"axle.angle" = 0
"axle.omega" = {omega:?}
"disc.x" = {x:?}
"disc.y" = {y:?}
"disc.angle" = 0
"disc.vx" = {:?}
"disc.vy" = {:?}
"disc.omega" = 0
[outputs]
variables = ["axle.angle", "disc.x", "disc.y", "energy.total", "edge.impulse", "edge.mode"]
[experiment]
stop = 0.8
"#,
        0.12 + number(0.07),
        speed * along[0] - omega * y,
        speed * along[1] + omega * x,
    )
}

/// By the implicit method, whose rates within a step have errors, as by series: the disc goes over a corner or leaves there, and energy stays. Two of the 24 runs by the
/// implicit method end as chattering where a slot has just opened, which is open.
#[test]
fn discs_leave_outlines_at_their_corners() {
    let (mut left, mut refused) = (0, 0);
    for seed in 0..24 {
        let model = run::model(&sliding_off(seed));
        let ends = ENGINES.map(|engine| {
            let mut instance = run::started(&model, engine, 0.8, 1e-8);
            let energy = run::value(&mut instance, "energy.total");
            if let Err(failure) = instance.step_to(0.8) {
                assert!(
                    engine == Some(Engine::Radau) && failure.to_string().contains("chattering"),
                    "{seed} {engine:?}: {failure}"
                );
                refused += 1;
                return None;
            }
            left += usize::from(run::value(&mut instance, "edge.mode") == 0.0);
            let (found, struck) =
                (run::value(&mut instance, "energy.total"), run::value(&mut instance, "edge.impulse"));
            let stays = found - energy < 1e-6 && (struck > 0.0 || energy - found < 1e-6);
            assert!(stays, "{seed} {engine:?}: {found}, not {energy}");
            Some(["axle.angle", "disc.x", "disc.y"].map(|name| run::value(&mut instance, name)))
        });
        if let [Some(one), Some(other)] = ends {
            assert!(run::distance(&one, &other) < 1e-5, "{seed}: {ends:?}");
        }
    }
    assert!(left > 24 && refused <= 2, "{left} {refused}");
}
