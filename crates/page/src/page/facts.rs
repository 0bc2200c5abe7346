//! What stands under the picture: figures, graphs, equations, assumptions.

use super::preformatted;

/// What stands under the picture.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Counts, coordinates, what is integrated: the summary as a text.
    pub summary: String,
    /// The linear graphs with their trees, as SVG.
    pub graphs: String,
    /// The equations of motion as HTML; empty if nobody could read them.
    pub equations: String,
}

impl Facts {
    /// As sections that open.
    pub fn html(&self) -> String {
        let mut html = format!(
            "<details><summary>Degrees of freedom, coordinates, what is integrated</summary>{}</details>\n\
             <details><summary>Linear graphs and trees</summary>{}</details>\n",
            preformatted(&self.summary),
            self.graphs
        );
        if !self.equations.is_empty() {
            html += &format!("<details><summary>Equations of motion</summary>{}</details>\n", self.equations);
        }
        html
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_keeps_its_lines() {
        let facts = Facts { summary: "a < b\n  c".into(), graphs: String::new(), equations: String::new() };
        assert!(facts.html().contains("<pre>a &lt; b\n  c</pre>"), "{}", facts.html());
    }
}
