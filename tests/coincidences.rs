//! What happens at one instant: ticks beside events and impacts, laws that change over together, impacts that follow each other over several contacts. Against closed forms, by every method.

use crate::support::run::{model, started, value};
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// A ball above a floor, with a counter of samples and one of events.
fn counted(period: f64, event: f64, height: f64) -> String {
    format!(
        r#"
name = "counted"
gravity = [0, -10]
[bodies.ball]
mass = 1
[joints.rail]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
limits = {{ min = 0 }}
[initial]
"rail.s" = {height:?}
[sampled.clock]
period = {period:?}
values = {{ n = {{ start = 0, next = "n + 1" }} }}
[sampled.never]
period = 1000
offset = 999
values = {{ m = {{ start = 0 }} }}
[events.at]
when = "t >= {event:?}"
set = {{ m = "m + 1" }}
[outputs]
variables = ["rail.s", "n", "m"]
[experiment]
stop = 3
"#
    )
}

/// floor(t / period) + 1 samples, wherever events and impacts are.
#[test]
fn no_tick_is_lost_beside_an_event_or_an_impact() {
    for period in [0.1, 0.2, 0.07, 1.0 / 3.0] {
        for event in [3.0 * period, 5.0 * period, 0.55] {
            // The impact is at the fourth tick: a fall of g t^2 / 2.
            for height in [5.0 * (4.0 * period) * (4.0 * period), 0.3] {
                let model = model(&counted(period, event, height));
                for engine in ENGINES {
                    let mut instance = started(&model, engine, 3.0, 1e-8);
                    // Between two ticks.
                    let ticks = (2.5 / period).floor();
                    instance.step_to((ticks + 0.5) * period).unwrap();
                    let found = ["n", "m", "rail.s"].map(|name| value(&mut instance, name));
                    assert_eq!(found[..2], [ticks + 1.0, 1.0], "{period} {event} {height} {engine:?}");
                    assert!(found[2].abs() < 1e-9, "{found:?}");
                }
            }
        }
    }
}

/// Written in either order, pieces that meet at 1 s have the rate of what follows.
#[test]
fn pieces_that_change_over_at_one_instant_are_those_that_follow() {
    for law in ["min(t, 1) + max(0, t - 1)", "min(1, t) + max(t - 1, 0)", "abs(t - 1) + 2*min(t, 1) - 1"] {
        let text = format!(
            "name = \"pieces\"\n[bodies.slide]\nmass = 2\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"slide\"]\naxis = [1, 0]\n\
             [drivers.motor]\njoint = \"rail\"\ndisplacement = \"{law}\"\n[outputs]\nvariables = [\"rail.s\", \"rail.v\"]\n[experiment]\nstop = 2\n"
        );
        let model = model(&text);
        for time in [0.5, 1.0, 1.5] {
            let mut instance = started(&model, None, 2.0, 1e-9);
            instance.step_to(time).unwrap();
            assert_eq!(
                [value(&mut instance, "rail.s"), value(&mut instance, "rail.v")],
                [time, 1.0],
                "{law} at {time}"
            );
        }
    }
}

/// A disc of 2 kg falls into a groove, from one side to the other in ever shorter flights, and rests on both: each side carries m g / (2 cos a).
#[test]
fn a_disc_comes_to_rest_in_a_groove() {
    for (across, up) in [(0.8, 0.6), (0.6, 0.8)] {
        let text = format!(
            "name = \"groove\"\ngravity = [0, -9.81]\n[bodies.disc]\nmass = 2\ninertia = 0.01\n\
             [joints.left]\ntype = \"contact\"\nbetween = [\"ground\", \"disc\"]\naxis = [{up}, -{across}]\nradius = 0.1\n\
             [joints.right]\ntype = \"contact\"\nbetween = [\"ground\", \"disc\"]\naxis = [{up}, {across}]\nradius = 0.1\n\
             [initial]\n\"disc.x\" = 0.04\n\"disc.y\" = 0.35\n[outputs]\nvariables = [\"disc.x\", \"disc.y\", \"left.fn\", \"right.fn\"]\n[experiment]\nstop = 3\n"
        );
        let mut instance = started(&model(&text), None, 3.0, 1e-8);
        instance.step_to(3.0).unwrap();
        let found = ["disc.x", "disc.y", "left.fn", "right.fn"].map(|name| value(&mut instance, name));
        let force = 2.0 * 9.81 / (2.0 * up);
        for (found, right) in found.into_iter().zip([0.0, 0.1 / up, force, force]) {
            assert!((found - right).abs() < 1e-8, "{found} for {right}");
        }
    }
}
