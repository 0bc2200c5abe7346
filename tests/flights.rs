//! Flights between impacts: what is found from the polynomials of gaps is what is found by looking at places of a step, and what closed forms say.
//!
//! A scene with an event that never happens is searched place by place.

use crate::support::run::{model, motion, started, value};

use cotree_fmu::math::Random;
use cotree_fmu::program::Engine;

const NEVER: &str = "\n[events.never]\nwhen = \"t > 1e6[s]\"\nstop = true\n";

/// Discs that fall onto the ground, each from another height, with rates along it.
pub fn discs(count: usize, restitution: f64, random: &mut Random) -> (String, Vec<f64>) {
    let heights: Vec<f64> = (0..count).map(|_| 0.06 + 2.0 * random.unit()).collect();
    let mut text = "format = 1\nname = \"discs\"\ngravity = [0, -9.81]\n".to_owned();
    for index in 0..count {
        text += &format!("[bodies.disc{index}]\nmass = 1.3\ninertia = 0.02\n");
        text += &format!(
            "[joints.pad{index}]\ntype = \"contact\"\nbetween = [\"ground\", \"disc{index}\"]\naxis = [1, 0]\nradius = 0.05\nrestitution = {restitution}\n"
        );
    }
    text += "[initial]\n";
    for (index, height) in heights.iter().enumerate() {
        text += &format!("\"disc{index}.x\" = {index}\n\"disc{index}.y\" = {height}\n\"disc{index}.angle\" = 0.3\n");
        text += &format!("\"disc{index}.vx\" = 0.2\n\"disc{index}.vy\" = 0.0\n\"disc{index}.omega\" = 1.0\n");
    }
    text += "[outputs]\nvariables = [\"disc0.y\"]\n[experiment]\nstop = 2.5\n";
    (text, heights)
}

/// The height of a disc that bounces.
fn bounced(height: f64, restitution: f64, time: f64) -> f64 {
    let (gravity, mut begin, mut above, mut rate) = (9.81, 0.0, height - 0.05, 0.0_f64);
    loop {
        let flight = (rate + (rate * rate + 2.0 * gravity * above).sqrt()) / gravity;
        if begin + flight > time || flight < 1e-7 {
            let since = time - begin;
            return 0.05 + if flight < 1e-7 { 0.0 } else { above + rate * since - 0.5 * gravity * since * since };
        }
        (begin, above, rate) = (begin + flight, 0.0, restitution * (gravity * flight - rate));
    }
}

#[test]
fn discs_bounce_as_parabolas_say() {
    let mut random = Random::new(41);
    for restitution in [0.0, 0.4, 0.8, 1.0] {
        for count in [1, 7] {
            let (text, heights) = discs(count, restitution, &mut random);
            let model = model(&text);
            for tolerance in [1e-4, 1e-8] {
                let mut run = started(&model, None, 2.5, tolerance);
                for time in [0.3, 0.9, 1.7, 2.5] {
                    run.step_to(time).unwrap();
                    for (index, height) in heights.iter().enumerate() {
                        let (found, expected) =
                            (value(&mut run, &format!("disc{index}.y")), bounced(*height, restitution, time));
                        let error = (found - expected).abs();
                        assert!(
                            error < 100.0 * tolerance * tolerance.max(1e-5),
                            "{restitution} {index} {time}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}

/// An impact costs a step: discs fall in parabolas, which have few orders and no limit but the next impact.
#[test]
fn an_impact_costs_a_step() {
    let (text, _) = discs(5, 0.6, &mut Random::new(42));
    let mut run = started(&model(&text), None, 2.5, 1e-6);
    run.step_to(1.2).unwrap();
    let impacts: u32 = run.events().map(|(_, count)| count).sum();
    let steps = run.statistics().steps;
    assert!(impacts >= 10 && steps <= u64::from(impacts) + 3, "{steps} steps, {impacts} impacts");
}

pub fn pendulum_between_stops(length: f64, limit: f64, restitution: f64) -> String {
    format!(
        "format = 1\nname = \"stops\"\ngravity = [0, -9.81]\n[bodies.arm]\nmass = 1.2\ninertia = 0.03\npoints = {{ pin = [{:?}, 0] }}\n[bodies.link]\nmass = 0.4\ninertia = 0.01\npoints = {{ pin = [-0.2, 0] }}\n\
         [joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm.pin\"]\nlimits = {{ min = {:?}, max = 2.5, restitution = {restitution} }}\n\
         [joints.knee]\ntype = \"revolute\"\nbetween = [\"arm\", \"link.pin\"]\nlimits = {{ min = -1.1, max = {limit}, restitution = {restitution} }}\n\
         [initial]\n\"hinge.angle\" = 0.1\n\"hinge.omega\" = 1.0\n\"knee.angle\" = 0.2\n\"knee.omega\" = -2.0\n[outputs]\nvariables = [\"hinge.angle\"]\n[experiment]\nstop = 3\n",
        -length, -2.0
    )
}

pub fn rope(length: f64) -> String {
    format!(
        "format = 1\nname = \"rope\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 0.7\ninertia = 0.002\n[joints.tie]\ntype = \"rope\"\nbetween = [\"ground\", \"ball\"]\nlength = {length}\nrestitution = 0.3\n\
         [initial]\n\"ball.x\" = 0.3\n\"ball.y\" = 0.1\n\"ball.angle\" = 0.0\n\"ball.vx\" = 1.5\n\"ball.vy\" = 0.4\n\"ball.omega\" = 0.0\n[outputs]\nvariables = [\"ball.y\"]\n[experiment]\nstop = 3\n"
    )
}

pub fn train(play: f64, restitution: f64) -> String {
    format!(
        "format = 1\nname = \"rattle\"\n[ground.points]\nsecond = [0.15, 0]\n[bodies]\nmotor = {{ mass = 0.5, inertia = 5e-4 }}\nwheel = {{ mass = 2.0, inertia = 8e-3 }}\n\
         [joints.one]\ntype = \"revolute\"\nbetween = [\"ground\", \"motor\"]\n[joints.two]\ntype = \"revolute\"\nbetween = [\"ground.second\", \"wheel\"]\ndamping = \"0.02 N.m.s/rad\"\n\
         [joints.mesh]\ntype = \"gear\"\nbetween = [\"motor\", \"wheel\"]\nratio = -0.5\nbacklash = {{ play = {play}, restitution = {restitution} }}\n\
         [loads.drive]\ntype = \"torque\"\non = \"motor\"\nvalue = \"0.6[N.m]*sin(2*pi*1.5[Hz]*t)\"\n\
         [initial]\n\"motor.angle\" = 0.0\n\"motor.omega\" = 0.0\n\"wheel.angle\" = 0.0\n\"wheel.omega\" = 0.0\n[outputs]\nvariables = [\"wheel.angle\"]\n[experiment]\nstop = 2\n"
    )
}

/// A valve that its cam throws off: its law counts turns, and the cam presses most of the time.
pub fn valve(rate: f64) -> String {
    format!(
        "format = 1\nname = \"valve\"\n[bodies]\ncamshaft = {{ mass = 1.0, inertia = 2e-3 }}\nvalve = {{ mass = 0.12 }}\n\
         [joints.bearing]\ntype = \"revolute\"\nbetween = [\"ground\", \"camshaft\"]\ndamping = \"0.004 N.m.s/rad\"\n\
         [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"valve\"]\naxis = [0, 1]\ndamping = \"4 N.s/m\"\n\
         [joints.cam]\ntype = \"cam\"\nbetween = [\"camshaft\", \"valve\"]\nshaft = \"bearing\"\nguide = \"guide\"\nbase = \"25 mm\"\nroller = \"8 mm\"\n\
         law = \"9[mm]*(1 - cos(angle))/2\"\nunilateral = {{ restitution = 0.35 }}\n\
         [loads.motor]\ntype = \"torque\"\non = \"camshaft\"\nvalue = \"2 N.m\"\n\
         [loads.spring]\ntype = \"force\"\non = \"valve\"\nvector = [0, \"2500[N/m]*(26[mm] - valve.y)\"]\n\
         [initial]\n\"camshaft.angle\" = 0.0\n\"camshaft.omega\" = {rate:?}\n\"guide.s\" = \"33 mm\"\n\"guide.v\" = 0.0\n[outputs]\nvariables = [\"guide.s\"]\n[experiment]\nstop = 3\n"
    )
}

/// The same motion and the same events, whichever way they are found: to rounding errors, which impacts multiply.
#[test]
fn polynomials_find_what_places_find() {
    let mut random = Random::new(43);
    let mut scenes: Vec<String> = [0.3, 0.6, 1.0].map(|restitution| discs(4, restitution, &mut random).0).into();
    scenes.extend(
        [0.2, 0.5].iter().flat_map(|length| [0.0, 0.5, 0.9].map(|e| pendulum_between_stops(*length, 0.7 + 0.1 * e, e))),
    );
    scenes.extend([0.4, 0.6].map(rope));
    scenes.extend([(0.02, 0.4), (0.05, 0.7), (0.01, 0.0)].map(|(play, restitution)| train(play, restitution)));
    scenes.push(valve(260.0));
    for text in scenes {
        let models = [model(&text), model(&(text.clone() + NEVER))];
        for tolerance in [1e-5, 1e-9] {
            let mut runs = models.each_ref().map(|model| started(model, Some(Engine::Taylor), 3.0, tolerance));
            let mut apart: f64 = 0.0;
            for step in 1..=15 {
                let time = 0.1 * f64::from(step);
                let motions = runs.each_mut().map(|run| {
                    run.step_to(time).unwrap();
                    motion(run)
                });
                apart = motions[0].iter().zip(&motions[1]).fold(apart, |apart, (a, b)| apart.max((a - b).abs()));
            }
            let events = runs.each_ref().map(|run| run.events().map(|(_, count)| count).sum::<u32>());
            // The last flights before rest are as high as rounding errors: there may be one more or less.
            assert!(events[0] > 0 && events[0].abs_diff(events[1]) <= 2, "{text}\n{events:?}");
            assert!(apart < 100.0 * tolerance, "{text}\n{apart:e}");
        }
    }
}

/// A cam that presses is not looked at in many places of a step.
#[test]
fn a_reaction_is_searched_by_its_polynomial() {
    let text = valve(220.0);
    let [polynomials, places] = [text.clone(), text + NEVER].map(|text| {
        let mut run = started(&model(&text), None, 0.25, 1e-6);
        run.step_to(0.25).unwrap();
        run.statistics().work as f64
    });
    assert!(polynomials < 0.85 * places, "{polynomials} {places}");
}

/// A cart that friction brings to rest at the very instant at which another one hits it does not stick: it goes on with what the impact gives it.
#[test]
fn what_comes_to_rest_where_it_is_hit_moves_on() {
    let mut random = Random::new(7);
    for side in [1.0, -1.0].into_iter().cycle().take(8) {
        let [mass, other, speed, friction, restitution, coming] =
            [1.0, 2.0, 1.0, 2.0, 0.5, 3.0].map(|size| size * (0.5 + random.unit()));
        let stops = speed * mass / friction;
        let place = 0.5 * speed * stops;
        let scene = format!(
            r#"
name = "hit"
[bodies]
a = {{ mass = {mass}, inertia = 1 }}
b = {{ mass = {other}, inertia = 1 }}
[joints]
rail = {{ type = "prismatic", between = ["ground", "a"], axis = [{side}, 0], friction = {{ coulomb = {friction} }} }}
apart = {{ type = "prismatic", between = ["a", "b"], axis = [{side}, 0], limits = {{ min = 0.1, restitution = {restitution} }} }}
[initial]
"rail.s" = 0
"rail.v" = {speed}
"apart.s" = {}
"apart.v" = {}
[outputs]
variables = ["rail.s", "rail.v", "apart.v"]
[experiment]
stop = 10
"#,
            place + 0.1 + coming * stops,
            -coming - speed
        );
        // The relative speed turns round; the impulse is that of two masses.
        let impulse = (1.0 + restitution) * coming / (1.0 / mass + 1.0 / other);
        let (after, since) = (-impulse / mass, 0.25 * impulse / friction);
        let model = model(&scene);
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            let mut instance = started(&model, engine, 10.0, 1e-9);
            instance.step_to(stops + since).unwrap();
            let [s, v] = ["rail.s", "rail.v"].map(|name| value(&mut instance, name));
            let brake = friction / mass;
            let right = [place + after * since + 0.5 * brake * since * since, after + brake * since];
            assert!(
                (s - right[0]).abs() < 1e-8 && (v - right[1]).abs() < 1e-8,
                "{scene} {engine:?}: {s} {v} {right:?}"
            );
        }
    }
}
