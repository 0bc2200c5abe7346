//! The graphs in the language of Graphviz.

use std::fmt::Write;

use super::{Graph, GraphDrawing};

/// Two clusters; branches are bold.
pub fn dot(drawing: &GraphDrawing) -> String {
    let mut text = format!(
        "digraph {} {{\n  compound=true;\n  node [shape=ellipse, fontsize=11];\n  edge [fontsize=11];\n",
        quoted(&drawing.title)
    );
    cluster(&mut text, "T", "translational graph", &drawing.translation);
    if let Some(rotation) = &drawing.rotation {
        cluster(&mut text, "R", "rotational graph", rotation);
    }
    text.push_str("}\n");
    text
}

fn cluster(text: &mut String, prefix: &str, title: &str, graph: &Graph) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  subgraph cluster_{prefix} {{\n    label={};", quoted(title));
    for (index, node) in graph.nodes.iter().enumerate() {
        let shape = if index == 0 { ", shape=box, style=filled, fillcolor=lightgrey" } else { "" };
        let _ = writeln!(text, "    {prefix}{index} [label={}{shape}];", quoted(node));
    }
    for edge in &graph.edges {
        let [a, b] = edge.ends;
        let style = if edge.branch { "penwidth=2.5" } else { "style=dashed" };
        let (label, name) = (quoted(&edge.label), quoted(&edge.name));
        let _ = writeln!(text, "    {prefix}{a} -> {prefix}{b} [label={label}, tooltip={name}, {style}];");
    }
    text.push_str("  }\n");
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
