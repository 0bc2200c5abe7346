//! A quantity over two others, in colours.

use super::panel::{AXIS, TICK, TITLE, axes, place};
use super::ticks::Ticks;
use super::{BOTTOM, LEFT, RIGHT, TOP, WIDTH, headed};
use crate::svg::{PictureFrame, Svg};

/// Fields over a grid of two quantities, one below the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    pub title: String,
    /// What is along the axes, such as `rod_length [m]`.
    pub axes: [String; 2],
    /// The values of both that there are, in any order.
    pub levels: [Vec<f64>; 2],
    pub fields: Vec<Field>,
}

/// What is shown as colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Its name, with its unit.
    pub name: String,
    /// Its value for each pair of levels, the second fastest; what is not finite is grey.
    pub values: Vec<f64>,
}

/// Height of one map [px].
const HEIGHT: f64 = 330.0;
/// Above each map: the name of the field [px].
const NAME: f64 = 24.0;
/// More levels than this cannot be seen: so many of them are drawn.
const MOST_LEVELS: usize = 150;
/// From the lowest to the highest value: viridis (van der Walt and Smith 2015), which has the same order for all eyes and in print.
const SCALE: [[u8; 3]; 10] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x49, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6e, 0xce, 0x58],
    [0xb5, 0xde, 0x2b],
    [0xfd, 0xe7, 0x25],
];
const NOTHING: &str = "#c9ced6";
/// Cells of the colour scale.
const SHADES: usize = 128;

impl Map {
    pub fn svg(&self) -> String {
        let mut svg = headed(&self.title);
        let cells = [0, 1].map(|axis| Cells::new(&self.levels[axis]));
        let [x, y] = [0, 1].map(|axis| Ticks::over(cells[axis].edges.iter().copied(), 6));
        let mut top = TOP + 4.0;
        for field in &self.fields {
            svg.text([LEFT, top + 12.0], TITLE, &field.name);
            let frame = PictureFrame { x: LEFT, y: top + NAME, width: WIDTH - LEFT - RIGHT, height: HEIGHT };
            self.draw(&mut svg, frame, field, &cells, [&x, &y]);
            top = frame.y + HEIGHT + BOTTOM;
        }
        svg.finish(PictureFrame { x: 0.0, y: 0.0, width: WIDTH, height: top }, &self.title)
    }

    fn draw(&self, svg: &mut Svg, frame: PictureFrame, field: &Field, cells: &[Cells; 2], [x, y]: [&Ticks; 2]) {
        let colours = Ticks::over(field.values.iter().copied(), 5);
        svg.raw(r#"<g shape-rendering="crispEdges">"#);
        for (right, column) in cells[0].edges.windows(2).zip(&cells[0].levels) {
            for (up, row) in cells[1].edges.windows(2).zip(&cells[1].levels) {
                let value = field.values.get(column * self.levels[1].len() + row).copied().unwrap_or(f64::NAN);
                let low = place(frame, x.part(right[0]), y.part(up[0]));
                let high = place(frame, x.part(right[1]), y.part(up[1]));
                let cell = PictureFrame { x: low[0], y: high[1], width: high[0] - low[0], height: low[1] - high[1] };
                svg.rectangle(cell, 0.0, &format!(r#"fill="{}""#, colour(colours.part(value))));
            }
        }
        svg.raw("</g>");
        axes(svg, frame, [x, y], [&self.axes[0], &self.axes[1]]);
        scale(svg, frame, &colours);
    }
}

/// The cells along an axis.
struct Cells {
    /// Places of the levels among those of the map, ascending by value.
    levels: Vec<usize>,
    /// One more than cells: midway between the levels.
    edges: Vec<f64>,
}

impl Cells {
    fn new(values: &[f64]) -> Self {
        let mut levels: Vec<usize> = (0..values.len()).collect();
        levels.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        levels.dedup_by_key(|level| values[*level]);
        let count = levels.len().min(MOST_LEVELS);
        levels = (0..count).map(|index| levels[index * levels.len() / count]).collect();
        let at = |index: usize| values[levels[index]];
        let middle = |index: usize| 0.5 * (at(index - 1) + at(index));
        let edges = match count {
            0 => Vec::new(),
            1 => vec![at(0) - 0.5, at(0) + 0.5],
            _ => {
                let inner = (1..count).map(middle);
                let ends = [2.0 * at(0) - middle(1), 2.0 * at(count - 1) - middle(count - 1)];
                [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect()
            }
        };
        Cells { levels, edges }
    }
}

/// The colour scale, beside its map.
fn scale(svg: &mut Svg, frame: PictureFrame, colours: &Ticks) {
    let bar = PictureFrame { x: frame.x + frame.width + 26.0, width: 18.0, ..frame };
    svg.raw(r#"<g shape-rendering="crispEdges">"#);
    for shade in 0..SHADES {
        let height = bar.height / SHADES as f64;
        let y = bar.y + bar.height - (shade + 1) as f64 * height;
        let style = format!(r#"fill="{}""#, colour((shade as f64 + 0.5) / SHADES as f64));
        svg.rectangle(PictureFrame { y, height: height + 0.5, ..bar }, 0.0, &style);
    }
    svg.raw("</g>");
    for &at in &colours.at {
        let [x, y] = place(bar, 1.0, colours.part(at));
        svg.line([x, y], [x + 4.0, y], AXIS);
        svg.text([x + 8.0, y + 4.2], TICK, &colours.label(at));
    }
}

/// The colour at a part of the scale.
fn colour(part: f64) -> String {
    if !part.is_finite() {
        return NOTHING.to_owned();
    }
    let place = part.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let share = place - below as f64;
    let mixed = |part: usize| {
        let [low, high] = [SCALE[below][part], SCALE[below + 1][part]].map(f64::from);
        (low + share * (high - low)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_meet_midway_between_the_levels() {
        let cells = Cells::new(&[4.0, 1.0, 2.0, 2.0]);
        assert_eq!((cells.levels, cells.edges), (vec![1, 2, 0], vec![0.5, 1.5, 3.0, 5.0]));
        let many: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(Cells::new(&many).levels.len(), MOST_LEVELS);
    }

    #[test]
    fn colours_go_from_dark_to_light() {
        let light = |part: f64| {
            let text = colour(part);
            let [r, g, b] = [1, 3, 5].map(|at| f64::from(u8::from_str_radix(&text[at..at + 2], 16).unwrap()));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let all: Vec<f64> = (0..=100).map(|index| light(f64::from(index) / 100.0)).collect();
        assert!(all.windows(2).all(|pair| pair[1] >= pair[0] - 0.5), "{all:?}");
        assert_eq!([colour(0.0), colour(2.0), colour(f64::NAN)], ["#440154", "#fde725", NOTHING]);
    }

    #[test]
    fn a_map_has_a_cell_for_each_pair_and_its_names() {
        let field = Field { name: "max(x) [m]".into(), values: vec![0.0, 1.0, 2.0, f64::NAN, 4.0, 5.0] };
        let axes = ["a [m]".to_owned(), "b <c>".to_owned()];
        let map = Map { title: "t".into(), axes, levels: [vec![1.0, 2.0], vec![1.0, 2.0, 3.0]], fields: vec![field] };
        let svg = map.svg();
        assert_eq!(svg.matches("<rect").count(), 1 + 6 + SHADES);
        assert!(svg.contains("a [m]") && svg.contains("b &lt;c&gt;") && svg.contains("max(x) [m]"));
        assert_eq!(svg.matches(NOTHING).count(), 1);
        assert!(Map::default().svg().ends_with("</svg>\n"));
    }
}
