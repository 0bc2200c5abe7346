//! The picture: the mechanism, its two graphs below, and a legend of the labels.

use std::collections::BTreeMap;

use super::covered::Covered;
use super::layout::distance;
use super::{DrawnEdge, Graph, GraphDrawing};
use crate::alike::Alike;
use crate::drawing::Drawing;
use crate::svg::{PictureFrame, Pixel, Svg, number, text_width};

const SCALE: f64 = 92.0;
/// Radius of a node [px].
const NODE: f64 = 4.5;
/// Space around everything and between the parts [px].
const MARGIN: f64 = 24.0;
const INK: &str = "#1f2933";
const BRANCH: &str = "#1d4ed8";
const CHORD: &str = "#8a94a3";
const FAINT: &str = "#5b6673";

/// The mechanism above, if it is shown, the graphs below it, then the names of the elements.
pub fn svg(drawing: &GraphDrawing, mechanism: Option<&Drawing>) -> String {
    let mut svg = Svg::default();
    let (inside, size) = mechanism.map_or_else(|| (String::new(), [0.0, -MARGIN]), Drawing::nested);
    let parts = [
        Some(("translational graph", &drawing.translation)),
        drawing.rotation.as_ref().map(|graph| ("rotational graph", graph)),
    ];
    let panels: Vec<GraphPanel> =
        parts.into_iter().flatten().map(|(title, graph)| GraphPanel::new(title, graph)).collect();
    let graphs_width: f64 =
        panels.iter().map(|panel| panel.frame.width).sum::<f64>() + MARGIN * (panels.len() as f64 - 1.0);
    let width = graphs_width.max(size[0]).max(480.0);
    let mut y = MARGIN;
    svg.raw(&format!(
        r#"<g transform="translate({} {})">{inside}</g>"#,
        number(MARGIN + 0.5 * (width - size[0])),
        number(y)
    ));
    y += size[1] + MARGIN;
    let mut x = MARGIN + 0.5 * (width - graphs_width);
    let height = panels.iter().map(|panel| panel.frame.height).fold(0.0, f64::max);
    for panel in &panels {
        panel.draw(&mut svg, [x, y + 0.5 * (height - panel.frame.height)]);
        x += panel.frame.width + MARGIN;
    }
    y += height + MARGIN;
    y = legend(&mut svg, drawing, [MARGIN, y], width);
    svg.finish(PictureFrame { x: 0.0, y: 0.0, width: width + 2.0 * MARGIN, height: y + MARGIN }, &drawing.title)
}

struct GraphPanel<'a> {
    title: &'a str,
    graph: &'a Graph,
    curves: Vec<EdgeCurve>,
    /// Around nodes, edges and names; pixels about the graph's own origin.
    frame: PictureFrame,
    names: Vec<PictureFrame>,
    labels: Vec<PictureFrame>,
}

/// An edge as a quadratic Bezier curve, or a loop.
#[derive(Clone, Copy, Debug)]
struct EdgeCurve {
    from: Pixel,
    over: Pixel,
    to: Pixel,
}

impl<'a> GraphPanel<'a> {
    fn new(title: &'a str, graph: &'a Graph) -> Self {
        let nodes: Vec<Pixel> = graph.places.iter().map(|[x, y]| [SCALE * x, -SCALE * y]).collect();
        let curves = curves(graph, &nodes);
        let mut covered = Covered::default();
        nodes.iter().for_each(|&at| covered.add(PictureFrame::centred(at, 3.2 * NODE, 3.2 * NODE)));
        for curve in &curves {
            (1..12).for_each(|step| covered.add(PictureFrame::centred(curve.at(f64::from(step) / 12.0), 4.0, 4.0)));
        }
        let labels: Vec<PictureFrame> =
            curves.iter().zip(&graph.edges).map(|(curve, edge)| place_label(curve, edge, &mut covered)).collect();
        let names: Vec<PictureFrame> =
            nodes.iter().zip(&graph.nodes).map(|(&at, name)| place_name(at, name, &mut covered)).collect();
        let frame = PictureFrame::around(covered.frames().iter());
        let heading = text_width(title, 13.0);
        let frame =
            PictureFrame { y: frame.y - 26.0, height: frame.height + 26.0, width: frame.width.max(heading), ..frame };
        GraphPanel { title, graph, curves, frame, names, labels }
    }

    fn draw(&self, svg: &mut Svg, [x, y]: Pixel) {
        svg.raw(&format!(r#"<g transform="translate({} {})">"#, number(x - self.frame.x), number(y - self.frame.y)));
        let style = format!(r#"font-size="13" font-weight="600" fill="{INK}""#);
        svg.text([self.frame.x, self.frame.y + 13.0], &style, self.title);
        for (curve, edge) in self.curves.iter().zip(&self.graph.edges) {
            curve.draw(svg, edge.branch);
        }
        for (at, edge) in self.labels.iter().zip(&self.graph.edges) {
            let (colour, weight) = if edge.branch { (BRANCH, "600") } else { (FAINT, "400") };
            text(svg, at, &printed(&edge.label), 12.0, &format!(r#"fill="{colour}" font-weight="{weight}""#));
        }
        for (index, (name, at)) in self.graph.nodes.iter().zip(&self.names).enumerate() {
            let [nx, ny] = self.graph.places[index];
            let node = [SCALE * nx, -SCALE * ny];
            let fill = if index == 0 { INK } else { "#ffffff" };
            svg.circle(
                node,
                if index == 0 { 1.3 * NODE } else { NODE },
                &format!(r#"fill="{fill}" stroke="{INK}" stroke-width="1.5""#),
            );
            text(svg, at, name, 10.5, &format!(r#"fill="{INK}""#));
        }
        svg.raw("</g>");
    }
}

fn printed(label: &str) -> String {
    label.replace("Theta", "Θ")
}

/// Parallel edges bend to either side; all edges of a pair of nodes are spread evenly.
fn curves(graph: &Graph, nodes: &[Pixel]) -> Vec<EdgeCurve> {
    let mut parallel: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (index, edge) in graph.edges.iter().enumerate() {
        let [a, b] = edge.ends;
        parallel.entry([a.min(b), a.max(b)]).or_default().push(index);
    }
    let mut by_x: Vec<usize> = (0..nodes.len()).collect();
    by_x.sort_by(|&a, &b| nodes[a][0].total_cmp(&nodes[b][0]));
    let blank = EdgeCurve { from: [0.0; 2], over: [0.0; 2], to: [0.0; 2] };
    let mut curves = vec![blank; graph.edges.len()];
    for ([low, high], edges) in parallel {
        let (a, b) = (nodes[low], nodes[high]);
        let length = (b[0] - a[0]).length_with(b[1] - a[1]).max(1.0);
        let side = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
        // A single edge bends only where a node stands in its way.
        let [left, right] = [a[0].min(b[0]) - 4.0 * NODE, a[0].max(b[0]) + 4.0 * NODE];
        let first = by_x.partition_point(|&node| nodes[node][0] < left);
        let mut around = by_x[first..].iter().take_while(|&&node| nodes[node][0] <= right);
        let blocked = around.any(|&node| node != low && node != high && distance(nodes[node], a, b) < 4.0 * NODE);
        for (position, &index) in edges.iter().enumerate() {
            let offset = position as f64 - 0.5 * (edges.len() as f64 - 1.0);
            let offset = if blocked && edges.len() == 1 { 0.6 } else { offset };
            let bend = 46.0_f64.min(0.55 * length) * 1.6 * offset;
            let over = [0.5 * (a[0] + b[0]) + bend * side[0], 0.5 * (a[1] + b[1]) + bend * side[1]];
            let [from, to] = graph.edges[index].ends.map(|node| nodes[node]);
            curves[index] = EdgeCurve { from, over, to };
        }
    }
    curves
}

impl EdgeCurve {
    fn at(&self, s: f64) -> Pixel {
        let r = 1.0 - s;
        [0, 1].map(|axis| r * r * self.from[axis] + 2.0 * r * s * self.over[axis] + s * s * self.to[axis])
    }

    /// Direction of travel, of length 1.
    fn direction(&self, s: f64) -> Pixel {
        let step =
            [0, 1].map(|axis| (1.0 - s) * (self.over[axis] - self.from[axis]) + s * (self.to[axis] - self.over[axis]));
        let length = step[0].length_with(step[1]).max(1e-9);
        step.map(|x| x / length)
    }

    fn draw(&self, svg: &mut Svg, branch: bool) {
        let (colour, width) = if branch { (BRANCH, 2.8) } else { (CHORD, 1.3) };
        let [from, over, to] = [self.from, self.over, self.to].map(|[x, y]| format!("{} {}", number(x), number(y)));
        svg.path(&format!("M{from}Q{over} {to}"), &format!(r#"fill="none" stroke="{colour}" stroke-width="{width}""#));
        // The arrowhead is a little behind the middle, where no node covers it.
        let (tip, direction) = (self.at(0.6), self.direction(0.6));
        let size = if branch { 10.0 } else { 8.0 };
        let corner = |across: f64| {
            let x = tip[0] - size * direction[0] - across * size * direction[1];
            let y = tip[1] - size * direction[1] + across * size * direction[0];
            format!("{} {}", number(x), number(y))
        };
        let head = format!("M{} {}L{}L{}Z", number(tip[0]), number(tip[1]), corner(0.45), corner(-0.45));
        svg.path(&head, &format!(r#"fill="{colour}""#));
    }
}

fn place_label(curve: &EdgeCurve, edge: &DrawnEdge, covered: &mut Covered) -> PictureFrame {
    let (width, height) = (text_width(&printed(&edge.label), 12.0), 14.0);
    let shares = [0.45, 0.36, 0.54, 0.28, 0.68, 0.2, 0.78];
    let candidates = shares.iter().enumerate().flat_map(|(order, &share)| {
        let (at, direction) = (curve.at(share), curve.direction(share));
        let reach = 4.0 + 0.5 * (width * direction[1].abs() + height * direction[0].abs());
        [1.0, -1.0].map(move |side| {
            let centre = [at[0] + side * reach * direction[1], at[1] - side * reach * direction[0]];
            (PictureFrame::centred(centre, width, height), order)
        })
    });
    choose(candidates.map(|(frame, order)| (frame, 4.0 * order as f64)), covered)
}

fn place_name(at: Pixel, name: &str, covered: &mut Covered) -> PictureFrame {
    let (width, height) = (text_width(name, 10.5), 12.5);
    let candidates = (0..36).map(|turn| {
        let (ring, turn) = (turn / 12, turn % 12);
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(turn) / 12.0).sine_and_cosine();
        let gap = 2.2 * NODE + 7.0 * f64::from(ring);
        let centre = [
            at[0] + gap * cosine + (1.5 * cosine).clamp(-0.5, 0.5) * width,
            at[1] - gap * sine - (1.5 * sine).clamp(-0.5, 0.5) * height,
        ];
        (PictureFrame::centred(centre, width, height), 12.0 * f64::from(ring))
    });
    choose(candidates, covered)
}

/// The candidate with the least cost and common area with the covered ones; it is covered from now on.
fn choose(candidates: impl Iterator<Item = (PictureFrame, f64)>, covered: &mut Covered) -> PictureFrame {
    let costs = candidates.map(|(frame, cost)| (frame, cost + covered.overlap(&frame)));
    let best = costs.min_by(|(_, a), (_, b)| a.total_cmp(b));
    let frame = best.map_or(PictureFrame { x: 0.0, y: 0.0, width: 0.0, height: 0.0 }, |(frame, _)| frame);
    covered.add(frame);
    frame
}

/// Text in the middle of its box, on a white halo.
fn text(svg: &mut Svg, at: &PictureFrame, text: &str, size: f64, style: &str) {
    let middle = [at.x + 0.5 * at.width, at.y + 0.78 * at.height];
    let common = format!(r#"font-size="{size}" text-anchor="middle""#);
    let halo = r##"fill="none" stroke="#ffffff" stroke-width="3" stroke-linejoin="round""##;
    svg.text(middle, &format!("{common} {halo}"), text);
    svg.text(middle, &format!("{common} {style}"), text);
}

/// Labels and names in columns; returns the lower end.
fn legend(svg: &mut Svg, drawing: &GraphDrawing, [x, y]: Pixel, width: f64) -> f64 {
    let branch = format!(r#"stroke="{BRANCH}" stroke-width="2.8""#);
    let chord = format!(r#"stroke="{CHORD}" stroke-width="1.3""#);
    let style = format!(r#"font-size="11.5" fill="{FAINT}""#);
    svg.line([x, y], [x + 26.0, y], &branch);
    svg.text([x + 32.0, y + 4.0], &style, "branch of the tree");
    svg.line([x + 160.0, y], [x + 186.0, y], &chord);
    svg.text([x + 192.0, y + 4.0], &style, "chord");
    let longest = drawing.elements.iter().map(|(_, name)| text_width(name, 11.5)).fold(60.0, f64::max);
    let columns = (width / (longest + 62.0)).floor().max(1.0) as usize;
    let rows = drawing.elements.len().div_ceil(columns);
    for (index, (label, name)) in drawing.elements.iter().enumerate() {
        let at = [x + (longest + 62.0) * (index / rows.max(1)) as f64, y + 24.0 + 17.0 * (index % rows.max(1)) as f64];
        svg.text(at, &format!(r#"font-size="11.5" font-weight="600" fill="{INK}""#), &printed(label));
        svg.text([at[0] + 46.0, at[1]], &style, name);
    }
    y + 24.0 + 17.0 * rows as f64
}
