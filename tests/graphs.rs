//! Pictures of the linear graphs, and the comparison of coordinates.

use crate::support::{ROOT, run};

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use cotree::model::Units;
use cotree::scene::Scene;
use cotree_draw::graph;
use cotree_study::compare;
use cotree_study::compare::{Choice, ChoiceCost, CostOrFault};

use run::{models, scene_of, sound};

fn scenes() -> Vec<(String, Scene)> {
    models().into_iter().map(|name| (name.clone(), sound(Scene::from_toml(&scene_of(&name))))).collect()
}

#[test]
fn every_element_is_in_the_picture() {
    for (name, scene) in scenes() {
        let (graphs, drawing) = graph::linear_graphs(&scene).unwrap_or_else(|faults| panic!("{faults}"));
        let svg = graphs.svg(&drawing);
        let mut reader = quick_xml::Reader::from_str(&svg);
        while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        for (label, own) in &graphs.elements {
            let label = label.replace("Theta", "Θ");
            for text in [label.as_str(), own] {
                assert!(svg.contains(&format!(">{text}</text>")), "{name}: {text}");
            }
        }
        assert_eq!(svg, graphs.svg(&drawing), "{name}: the same every time");
    }
}

/// Lines between nodes, both graphs: `T0 -> T1 [label="h9", ...]`.
#[test]
fn the_dot_file_has_every_edge_with_its_direction() {
    for (name, scene) in scenes() {
        let (graphs, _) = graph::linear_graphs(&scene).unwrap_or_else(|faults| panic!("{faults}"));
        let dot = graphs.dot();
        let all = [Some(("T", &graphs.translation)), graphs.rotation.as_ref().map(|graph| ("R", graph))];
        for (prefix, graph) in all.into_iter().flatten() {
            assert_eq!(graph.edges.iter().filter(|edge| edge.branch).count(), graph.nodes.len() - 1, "{name}: a tree");
            for edge in &graph.edges {
                let [a, b] = edge.ends;
                let style = if edge.branch { "penwidth=2.5" } else { "style=dashed" };
                let line = dot.lines().find(|line| {
                    line.contains(&format!("{prefix}{a} -> {prefix}{b} "))
                        && line.contains(&format!("label=\"{}\"", edge.label))
                });
                assert!(line.is_some_and(|line| line.contains(style)), "{name}: {edge:?}");
            }
        }
        check_with_graphviz(&name, &dot);
    }
}

/// Graphviz itself must accept the file, where it is installed.
fn check_with_graphviz(name: &str, dot: &str) {
    let started = Command::new("dot").arg("-Tcanon").stdin(Stdio::piped()).stdout(Stdio::null()).spawn();
    let Ok(mut child) = started else {
        eprintln!("{name}: graphviz is not installed, its verdict is not asked");
        return;
    };
    child.stdin.take().unwrap().write_all(dot.as_bytes()).unwrap();
    assert!(child.wait().unwrap().success(), "{name}: graphviz does not read\n{dot}");
}

#[test]
fn nodes_keep_their_distance() {
    for (name, scene) in scenes() {
        let (graphs, _) = graph::linear_graphs(&scene).unwrap_or_else(|faults| panic!("{faults}"));
        for graph in [Some(&graphs.translation), graphs.rotation.as_ref()].into_iter().flatten() {
            for (a, first) in graph.places.iter().enumerate() {
                for (b, second) in graph.places[..a].iter().enumerate() {
                    let apart = (first[0] - second[0]).hypot(first[1] - second[1]);
                    assert!(apart > 0.5, "{name}: {} and {} are {apart} apart", graph.nodes[a], graph.nodes[b]);
                }
            }
        }
    }
}

fn costs(model: &str) -> Vec<(Choice, ChoiceCost)> {
    let path = Path::new(ROOT).join("models").join(model).join("scene.toml");
    let scene = Scene::read(&path).unwrap_or_else(|faults| panic!("{faults}"));
    let comparison = compare::comparison(&scene).unwrap_or_else(|faults| panic!("{faults}"));
    let good = |choice: Choice| match choice.figures.clone() {
        CostOrFault::Good(cost) => (choice, cost),
        CostOrFault::Bad { fault } => panic!("{}: {fault}", choice.name),
    };
    comparison.choices.into_iter().map(good).collect()
}

/// The counts of the paper: 9 + 8, 3 + 2, 2 + 1 (section 5.3); 15 + 15, 5 + 5, 2 + 2 with the driver's equation (section 5.2).
#[test]
fn the_paper_counts_the_same_equations() {
    for (model, expected) in [("slider_crank", [(9, 8), (3, 2), (2, 1)]), ("quick_return", [(15, 15), (5, 5), (2, 2)])]
    {
        let found: Vec<(usize, usize)> =
            costs(model).iter().take(3).map(|(_, cost)| (cost.coordinates, cost.loop_equations)).collect();
        assert_eq!(found, expected, "{model}");
    }
}

#[test]
fn costs_are_complete_and_fewer_equations_cost_less() {
    for model in ["slider_crank", "quick_return", "andrews", "vibration"] {
        let costs = costs(model);
        let names: Vec<&str> = costs.iter().map(|(choice, _)| choice.name).collect();
        let own: &[&str] = if model == "vibration" { &["chosen"] } else { &[] };
        assert_eq!(names, [&["absolute", "joint", "recommended"], own].concat(), "{model}");
        assert_eq!(costs.iter().filter(|(choice, _)| choice.used).count(), 1, "{model}");
        let work = |cost: &ChoiceCost| cost.operations.additions + cost.operations.multiplications;
        assert!(work(&costs[2].1) <= work(&costs[0].1), "{model}: {costs:?}");
        for (choice, cost) in &costs {
            assert!(cost.nanoseconds > 0.0, "{model} {}", choice.name);
            assert!(cost.condition.is_some_and(|number| number >= 1.0), "{model} {}: {cost:?}", choice.name);
        }
    }
}

#[test]
fn the_table_has_a_line_for_each_choice() {
    let path = Path::new(ROOT).join("models/slider_crank/scene.toml");
    let comparison = compare::comparison(&Scene::read(&path).unwrap()).unwrap();
    let text = comparison.report().text(&Units::default());
    for name in ["absolute", "joint", "recommended *"] {
        assert!(text.lines().any(|line| line.trim_start().starts_with(name)), "{text}");
    }
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["choices"][2]["coordinates"], 2);
    assert_eq!(json["choices"][2]["used"], true);
}

/// The drawing of a body whose tip is led.
fn led(position: &str, dimension: usize) -> cotree_draw::drawing::Drawing {
    let text = match dimension {
        1 => format!(
            "name = 'led'\ndimension = 1\nbodies.a = {{}}\ndrivers.hand = {{ on = 'a', position = [{position}] }}"
        ),
        _ => format!(
            "name = 'led'\nbodies.a = {{ mass = 1, inertia = 1, points = {{ tip = [1, 0] }} }}\ndrivers.hand = {{ on = 'a.tip', position = [{position}] }}"
        ),
    };
    let scene = Scene::from_toml(&text).unwrap_or_else(|faults| panic!("{faults}"));
    let drawing = graph::linear_graphs(&scene).unwrap_or_else(|faults| panic!("{faults}")).1;
    assert!(drawing.svg().contains(">hand</text>"));
    drawing
}

#[test]
fn a_led_point_is_drawn_with_the_direction_in_which_it_leaves() {
    let [x, y] = led("'1 + 3*t', '2 - 4*t'", 2).targets[0].direction.unwrap();
    assert!((x - 3.0).abs() < 1e-12 && (y + 4.0).abs() < 1e-12, "{x} {y}");
    assert_eq!(led("'1', 'cos(2*t)'", 2).targets[0].direction, Some([0.0, -4.0]), "at rest: where it accelerates to");
    assert_eq!(led("1, 2", 2).targets[0].direction, None);
    assert_eq!(led("1, 2", 2).targets[0].at, [1.0, 2.0]);
}

#[test]
fn on_a_line_a_led_mass_is_pushed() {
    let drawing = led("'2 - t'", 1);
    assert_eq!((drawing.targets.len(), drawing.forces[0].direction), (0, [-1.0, 0.0]));
}
