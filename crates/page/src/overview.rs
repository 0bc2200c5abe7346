//! What the pages show that stands still.

use cotree::equations::Equations;
use cotree::formulate::Formulated;
use cotree::report::figures::summarise;
use cotree_draw::drawing::Drawing;
use cotree_draw::graph::GraphDrawing;
use cotree_draw::pose::draw;
use cotree_text as text;

use crate::page::Facts;

/// What the documentation in an FMU shows.
#[derive(Clone, Debug)]
pub struct Overview {
    /// The mechanism at its start.
    pub drawing: Drawing,
    /// Figures, graphs and equations.
    pub facts: Facts,
}

/// What the documentation in an FMU shows of these equations.
pub fn overview(formulated: &mut Formulated) -> Overview {
    let drawing = draw(formulated);
    let facts = Facts {
        summary: summarise(formulated).to_string(),
        graphs: GraphDrawing::new(formulated).svg(&drawing),
        equations: equations_for_the_page(&mut formulated.equations),
    };
    Overview { drawing, facts }
}

/// Pages have no more equations than this.
const MOST_EQUATIONS: usize = 40;

/// The equations of motion as MathML, if they are few enough to be read.
fn equations_for_the_page(equations: &mut Equations) -> String {
    let count = equations.coordinates.len() + equations.constraints.len();
    if count > MOST_EQUATIONS { String::new() } else { text::mathml(equations) }
}
