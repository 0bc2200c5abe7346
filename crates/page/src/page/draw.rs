//! The page in which a mechanism is drawn: the front end, the solver and the runtimes for FMUs inside, so that it needs no server.

use super::pack::{inert, packed};
use super::{COMMON, STYLE, fill, scope, served};

const TEMPLATE: &str = include_str!("draw/draw.html");
const DRAW_STYLE: &str = include_str!("draw/draw.css");
/// Modules that become one script, in this order.
pub(super) const SCRIPTS: [&str; 6] = [
    COMMON,
    include_str!("draw/front.js"),
    include_str!("draw/stage.js"),
    include_str!("draw/tools.js"),
    include_str!("draw/find.js"),
    include_str!("draw/main.js"),
];

/// What a drawing page has inside.
#[derive(Clone, Debug)]
pub struct DrawingPage {
    /// The text that it begins with; none: an empty sheet.
    pub scene: Option<String>,
    /// The front end as a WebAssembly module.
    pub front: Vec<u8>,
    /// The runtime for browsers.
    pub solver: Vec<u8>,
    /// The shared libraries for its FMUs, by the names of their platforms. They are in the page and not beside it: a page that is opened from a disk may not
    /// read files.
    pub runtimes: Vec<(&'static str, Vec<u8>)>,
}

impl DrawingPage {
    /// The page as this machine serves it: the program that does is its front end and its solver.
    pub fn served_html(scene: Option<String>) -> String {
        served(&DrawingPage { scene, front: Vec::new(), solver: Vec::new(), runtimes: Vec::new() }.html(), None)
    }

    pub fn html(&self) -> String {
        let library = |(platform, library): &(&str, Vec<u8>)| {
            format!(
                "<script type=\"text/plain\" id=\"runtime-{platform}\" data-platform=\"{platform}\">{}</script>\n",
                packed(library)
            )
        };
        let parts = [
            ("style", STYLE.to_owned()),
            ("draw_style", DRAW_STYLE.to_owned()),
            ("begin", inert(&serde_json::to_string(&self.scene).unwrap_or_default())),
            ("solver", packed(&self.solver)),
            ("front", packed(&self.front)),
            ("runtimes", self.runtimes.iter().map(library).collect()),
            ("script", scope(&SCRIPTS)),
        ];
        fill(TEMPLATE, &parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_in_the_page_is_text() {
        let scene = Some("# </script><script>alert(1)</script>".to_owned());
        let page = DrawingPage { scene, front: vec![1], solver: vec![2], runtimes: vec![("linux64", vec![3])] };
        let html = page.html();
        assert!(!html.contains("connect-src"), "a page on a disk asks nobody");
        assert!(!html.contains("alert(1)</script>") && !html.contains("{{"), "the scene ends no element");
        assert!(html.contains("data-platform=\"linux64\""));
    }
}
