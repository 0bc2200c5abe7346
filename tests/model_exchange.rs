//! Model Exchange as integrators outside use it: singular poses, which are errors that name them, and events, at whichever end of its search an importer handles them.

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::support::ROOT;
use crate::support::exchange::integrate;

use cotree::compile::compile;
use cotree::scene::{Body, Scene};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

fn bar(length: f64) -> Body {
    let body = Body::new().mass(1.0).inertia(length * length / 12.0);
    body.point("a", [-length / 2.0, 0.0]).point("b", [length / 2.0, 0.0])
}

fn slider_crank(rod: f64, angle: f64) -> Instance {
    let scene = Scene::new("slider_crank")
        .body("crank", bar(1.0))
        .body("rod", bar(rod))
        .body("slider", Body::new().mass(0.7))
        .revolute("bearing", "ground", "crank.a")
        .revolute("pin", "crank.b", "rod.a")
        .revolute("wrist", "rod.b", "slider")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", angle)
        .initial("crank.omega", 3.0)
        .guess("rod.angle", -angle)
        .output("crank.angle");
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")))
}

/// With crank and rod of the same length the slider could stay in the bearing once the crank is upright.
#[test]
fn a_step_through_a_singular_pose_is_an_error_that_names_the_joints() {
    let mut inside = slider_crank(1.0, 0.5);
    inside.initialise().expect("consistent");
    inside.step_to(1.0).expect("passes");
    let passage = inside.take_passages().remove(0);
    for h in [1e-3, 3.7e-3, 1e-2, 3e-2] {
        let mut instance = slider_crank(1.0, 0.5);
        let found = integrate(&mut instance, 2.0, h).expect_err("two branches cross");
        let InstanceError::Crossing(crossing) = &found else { panic!("{found:?}") };
        assert!((crossing.time - passage.time).abs() < 1e-3, "{found}, but it is at {}", passage.time);
        assert!(found.to_string().contains("use Co-Simulation"), "{found}");
        assert!(passage.joints.iter().any(|joint| crossing.joints.contains(joint)), "{found}");
        assert!(instance.time() - h <= crossing.time && crossing.time <= instance.time(), "in the last step");
    }
}

#[test]
fn no_other_step_is() {
    for (rod, h) in [(1.01, 1e-3), (1.2, 1e-2), (2.0, 3e-2)] {
        let mut instance = slider_crank(rod, 0.5);
        instance.setup(0.0, None, Some(1e-5)).expect("possible");
        integrate(&mut instance, 6.0, h).unwrap_or_else(|failure| panic!("{rod}: {failure}"));
        assert!(instance.take_passages().is_empty());
    }
}

/// The tumbling mechanism of Andrews turns once in some 8 ms: long steps open its loops farther than can be closed, which is no lock-up, and shorter ones do not.
#[test]
fn steps_that_are_too_long_for_a_fast_mechanism_are_said_to_be() {
    let path = Path::new(ROOT).join("models/andrews/scene.toml");
    let compiled = compile(&Scene::from_toml(&fs::read_to_string(path).unwrap()).unwrap()).unwrap();
    let model = Arc::new(Model::new(compiled.program).expect("a sound program"));
    for h in [5e-3, 1e-2] {
        let mut instance = Instance::new(Arc::clone(&model));
        let found = integrate(&mut instance, 0.1, h).expect_err("the loops are torn");
        assert!(matches!(found, InstanceError::Apart { .. }), "{h}: {found:?}");
        let said = found.to_string();
        for part in
            ["steps of the importer's solver are too long", "shorter steps", "step size control", "Co-Simulation"]
        {
            assert!(said.contains(part), "{said}");
        }
        assert!(!said.contains("change the lengths"), "{said}");
    }
    integrate(&mut Instance::new(model), 0.03, 1e-5).expect("short steps keep the loops closed");
}

#[test]
fn a_start_in_a_singular_pose_is_refused() {
    let mut instance = slider_crank(1.0, FRAC_PI_2);
    let found = integrate(&mut instance, 1.0, 1e-3).expect_err("nobody knows where to go");
    assert!(matches!(found, InstanceError::Crossing(_) | InstanceError::Solver(_)), "{found}");
    // Other values may then be tried.
    let angle = instance.variable("crank.angle").expect("known");
    instance.set(angle, 0.3).expect("settable");
    instance.initialise_exchange().expect("regular");
}

/// A pendulum on a trolley that an input moves: no loop, but the trolley's rates, which an importer cannot tell. As a force it is no obstacle.
#[test]
fn a_driver_that_follows_an_input_is_for_co_simulation_only() {
    let scene = |follows: &str| {
        let text = format!(
            r#"
            format = 1
            name = "trolley"
            gravity = [0, -9.81]
            [inputs]
            signal = 0.1
            [bodies.trolley]
            mass = 1.0
            [bodies.rod]
            mass = 1.0
            inertia = 0.1
            points = {{ top = [0, 0.5] }}
            [joints.rail]
            type = "prismatic"
            between = ["ground", "trolley"]
            axis = [1, 0]
            [joints.hook]
            type = "revolute"
            between = ["trolley", "rod.top"]
            {follows}
            [outputs]
            variables = ["rod.alpha"]
            "#
        );
        compile(&Scene::from_toml(&text).expect("a scene")).expect("a model")
    };
    let force = scene("[loads.push]\ntype = \"force\"\non = \"trolley\"\nvector = [\"signal\", 0]");
    assert!(force.description.exchange.is_some());
    for order in ["position", "velocity", "acceleration"] {
        let driver =
            format!("[drivers.winch]\njoint = \"rail\"\ndisplacement = {{ input = \"signal\", as = \"{order}\" }}");
        let driven = scene(&driver);
        assert_eq!(driven.description.exchange, None, "{order}");
        let mut instance = Instance::new(Arc::new(Model::new(driven.program).expect("a sound program")));
        assert!(matches!(instance.initialise_exchange(), Err(InstanceError::NoExchange)), "{order}");
    }
}

/// A cart whose drive turns round where it comes to a level, on either side.
fn relay(high: &str, low: &str) -> Arc<Model> {
    let text = format!(
        r#"
        name = "relay"
        [bodies.cart]
        mass = 1.5
        [joints.rail]
        type = "prismatic"
        between = ["ground", "cart"]
        axis = [1, 0]
        damping = "0.7 N.s/m"
        [sampled.relay]
        period = "1e4 s"
        offset = "5e3 s"
        values = {{ push = 1, turns = 0 }}
        [events.high]
        when = "{high}"
        set = {{ push = "-push", turns = "turns + 1" }}
        [events.low]
        when = "{low}"
        set = {{ push = "-push", turns = "turns + 1" }}
        [loads.drive]
        type = "force"
        on = "cart"
        vector = ["push*2.5[N]", 0]
        [initial]
        "rail.s" = 0.0
        "rail.v" = 0.0
        [outputs]
        variables = ["rail.s", "turns"]
        [experiment]
        stop = "10 s"
        step = "10 ms"
        "#
    );
    compiled(&text)
}

fn compiled(text: &str) -> Arc<Model> {
    let compiled =
        compile(&Scene::from_toml(text).unwrap()).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Arc::new(Model::new(compiled.program).expect("a sound program"))
}

/// An importer with Runge-Kutta steps of one length, which halves a step in which an indicator changes its sign until its ends are so close, and handles the event at the later or the earlier one.
struct Master {
    instance: Instance,
    enclosed: f64,
    after: bool,
    events: usize,
}

impl Master {
    fn place(&mut self, time: f64, states: &[f64]) {
        self.instance.set_time(time).unwrap();
        self.instance.set_states(states).unwrap();
    }

    fn step(&mut self, time: f64, states: &[f64], h: f64) -> Vec<f64> {
        let (mut end, mut slope) = (states.to_vec(), vec![0.0; states.len()]);
        for (share, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let point: Vec<f64> = states.iter().zip(&slope).map(|(x, k)| x + share * h * k).collect();
            self.place(time + share * h, &point);
            self.instance.state_derivatives(&mut slope).unwrap();
            end.iter_mut().zip(&slope).for_each(|(x, k)| *x += h * weight * k / 6.0);
        }
        end
    }

    fn signs(&mut self, time: f64, states: &[f64]) -> Vec<bool> {
        let mut indicators = vec![0.0; self.instance.model().program().indicators()];
        self.place(time, states);
        self.instance.indicators(&mut indicators).unwrap();
        indicators.iter().map(|value| *value > 0.0).collect()
    }

    fn run(&mut self, duration: f64, h: f64) {
        self.instance.initialise_exchange().unwrap();
        self.instance.handle_event().unwrap();
        let end = self.instance.time() + duration;
        let mut states = vec![0.0; self.instance.state_count()];
        self.instance.states(&mut states).unwrap();
        let mut time = self.instance.time();
        while time < end - 1e-6 * h {
            let mut length = h.min(end - time);
            let signs = self.signs(time, &states);
            let changed = |own: &mut Self, length: f64| {
                let states = own.step(time, &states, length);
                own.signs(time + length, &states) != signs
            };
            let found = changed(self, length);
            if found {
                let [mut low, mut high] = [0.0, length];
                while high - low > self.enclosed && 0.5 * (low + high) > low {
                    let middle = 0.5 * (low + high);
                    if changed(self, middle) { high = middle } else { low = middle }
                }
                length = if self.after { high } else { low };
            }
            states = self.step(time, &states, length);
            time += length;
            self.place(time, &states);
            if self.instance.complete_step().unwrap() || found {
                self.instance.handle_event().unwrap();
                self.events += 1;
                assert!(self.events < 200, "events at t = {time} s have no end");
            }
            self.instance.states(&mut states).unwrap();
        }
    }

    fn read(&mut self, name: &str) -> f64 {
        let variable = self.instance.variable(name).unwrap();
        self.instance.get(variable).unwrap()
    }
}

/// Where a comparison ceases to hold nothing happens, however well an importer finds that, and on whichever side. Co-Simulation, whose searches have nothing in common with those of
/// importers, says what is right.
#[test]
fn an_event_happens_only_where_its_comparison_begins_to_hold() {
    let scenes = [relay("rail.s > 0.4", "rail.s < -0.4"), relay("rail.s - 0.4[m] > 0", "rail.s + 0.4[m] < 0")];
    for model in scenes {
        let mut inside = Instance::new(Arc::clone(&model));
        inside.initialise().unwrap();
        inside.step_to(10.0).unwrap();
        let [right, turns] = ["rail.s", "turns"].map(|name| {
            let variable = inside.variable(name).unwrap();
            inside.get(variable).unwrap()
        });
        assert!(turns >= 3.0, "{turns}");
        for (enclosed, after, start) in [1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13].into_iter().flat_map(|enclosed| {
            [(enclosed, true, 0.0), (enclosed, false, 0.0), (enclosed, true, 1000.0), (enclosed, false, 1000.0)]
        }) {
            let mut instance = Instance::new(Arc::clone(&model));
            instance.setup(start, None, None).unwrap();
            let mut master = Master { instance, enclosed, after, events: 0 };
            master.run(10.0, 1e-2);
            let found = ["rail.s", "turns"].map(|name| master.read(name));
            assert_eq!(found[1], turns, "searches to {enclosed:e}, {after}, from {start} s");
            assert!((found[0] - right).abs() < 1e-6, "{enclosed:e}, {after}, from {start} s: {found:?}, not {right}");
        }
    }
}

/// A step whose end rounding errors have taken behind the stop is one step, and not one for each unit of rounding.
#[test]
fn a_step_ends_a_little_behind_the_stop() {
    let text = r#"
        name = "ball"
        gravity = [0, -9.81]
        [bodies.ball]
        mass = 1.0
        [joints.fall]
        type = "prismatic"
        between = ["ground", "ball"]
        axis = [0, 1]
        limits = { min = "0 m", restitution = 0.5 }
        [initial]
        "fall.s" = 2.0
        "fall.v" = 0.0
        [outputs]
        variables = ["fall.s"]
        [experiment]
        stop = "1 s"
        step = "10 ms"
    "#;
    let model = compiled(text);
    for behind in [1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 9e-6] {
        for in_parts in [false, true] {
            let mut instance = Instance::new(Arc::clone(&model));
            instance.setup(0.0, Some(0.3), None).unwrap();
            instance.initialise().unwrap();
            instance.step_to(0.29).unwrap();
            instance.step_to(0.3).unwrap();
            let mut again = Instance::new(Arc::clone(&model));
            again.setup(0.0, Some(0.3), None).unwrap();
            again.initialise().unwrap();
            again.step_to(0.29).unwrap();
            let end = 0.3 + behind;
            if in_parts {
                while again.time() < end {
                    again.step_towards(end).unwrap();
                }
            } else {
                again.step_to(end).unwrap();
            }
            assert!(again.statistics().steps <= instance.statistics().steps + 2, "{behind:e}");
            let height = again.variable("fall.s").unwrap();
            let right = 2.0 - 0.5 * 9.81 * end * end;
            assert!((again.get(height).unwrap() - right).abs() < 1e-12, "{behind:e}");
        }
    }
    let mut instance = Instance::new(model);
    instance.setup(0.0, Some(0.3), None).unwrap();
    instance.initialise().unwrap();
    instance.step_to(0.29).unwrap();
    assert!(matches!(instance.step_to(0.31), Err(InstanceError::Stop { .. })));
}

/// A shaft that drives itself the faster the faster it turns: the steps of its motion are ever shorter, and each is taken by a call of its own.
#[test]
fn a_freewheel_that_runs_away_is_too_much_work() {
    let text = r#"
        name = "overspeed"
        [bodies]
        rotor = { mass = 1.0, inertia = 0.02 }
        shaft = { mass = 1.0, inertia = 0.1 }
        [joints.a]
        type = "revolute"
        between = ["ground", "rotor"]
        [joints.b]
        type = "revolute"
        between = ["ground", "shaft"]
        [joints.clutch]
        type = "one_way"
        between = ["shaft", "rotor"]
        direction = "clockwise"
        [loads.drive]
        type = "torque"
        on = "rotor"
        value = "1[N.m]*cos(4*t)"
        [loads.grows]
        type = "torque"
        on = "shaft"
        value = "3.7[N.m.s]*shaft.omega"
        [initial]
        "rotor.angle" = 0.0
        "rotor.omega" = 0.0
        "shaft.angle" = 0.0
        "shaft.omega" = 0.0
        [experiment]
        stop = "2 s"
        step = "10 ms"
    "#;
    let mut instance = Instance::new(compiled(text));
    instance.limit_work(30_000_000);
    instance.initialise().unwrap();
    let mut failed = None;
    for step in 1..200 {
        let before = instance.statistics().work;
        failed = instance.step_to(0.01 * f64::from(step)).err();
        let done = instance.statistics().work - before;
        assert!(done < 60_000_000, "{done} instructions in one step");
        if failed.is_some() {
            break;
        }
    }
    let failure = failed.expect("it runs away");
    assert!(failure.is_unfinished(), "{failure}");
}
