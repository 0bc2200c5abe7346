//! `cotree draw`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::export::ExportError;
use cotree::export::runtime::{self, Runtime};
use cotree::files;
use cotree::scene::Scene;
use cotree_page::page::DrawingPage;

use super::export::available;
use super::failure::Failure;
use super::{output, serve};

/// Draw a mechanism in a browser, with bars, pins, sliders, springs, motors and loads, and see it move
///
/// The page checks and compiles the scene, shows its motion, finds linkages for poses and paths, and writes the same FMU as `cotree export`.
/// The scene text is next to the drawing, and every tool edits it. With the program for browsers, which a release contains, the page is a single file;
/// without it, this machine serves the page to its own browsers until Ctrl-C.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree draw\n  cotree draw slider_crank.toml\n  cotree draw slider_crank.toml -o draw.html --runtimes target/runtimes"
)]
pub struct DrawCommand {
    /// Scene file (TOML or JSON) to start from [default: an empty drawing]
    scene: Option<PathBuf>,
    /// Output file of the page [default: the name of the scene file with `_draw.html`, or `draw.html`, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Folder with the runtimes, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl DrawCommand {
    pub fn run(self) -> Result<(), Failure> {
        output::is_written_as(self.output.as_deref(), &["html", "htm"])?;
        let folder = self.runtimes.clone().unwrap_or_else(runtime::default_folder);
        let scene = self.scene.as_deref().map(text).transpose()?;
        let (front, solver) = (runtime::front_for_browsers(&folder), runtime::for_browsers(&folder));
        let modules = front.map_err(ExportError::from)?.zip(solver.map_err(ExportError::from)?);
        let Some((front, solver)) = modules else {
            return match self.output {
                None => serve::page(DrawingPage::served_html(scene), serve::desk(&folder)?, |_| ()),
                Some(_) => Err(Failure::Usage(format!(
                    "a page in a file needs the program for browsers, `cotree_front.wasm` and `cotree_runtime.wasm` in `{}`\nWithout -o this machine serves the page; for the file take a \
                     release of cotree, which brings them along, or build them with tools/build-runtimes.sh web, and name their folder with --runtimes or in COTREE_RUNTIMES",
                    folder.join("web").display()
                ))),
            };
        };
        let found = available(&folder).into_iter().map(|platform| Runtime::find(platform, &folder));
        let runtimes: Vec<Runtime> = found.collect::<Result<_, _>>().map_err(ExportError::from)?;
        let runtimes =
            runtimes.iter().map(|runtime| (runtime.platform.folder, runtime.packed_library().into_owned())).collect();
        let stem = self.scene.as_deref().and_then(Path::file_stem);
        let named = || stem.map_or("draw.html".into(), |stem| PathBuf::from(format!("{}_draw.html", stem.display())));
        let path = self.output.clone().unwrap_or_else(named);
        output::apart(&[self.scene.as_deref()], &[Some(&path)])?;
        output::write(&path, DrawingPage { scene, front, solver, runtimes }.html())?;
        output::print(&format!("{}\n", path.display()))
    }
}

/// The text of a scene, whatever is wrong with it: the page says that, and there it can be mended.
fn text(path: &Path) -> Result<String, Failure> {
    let bytes = files::read(path, Scene::LARGEST).map_err(|error| Failure::file("read", path, error))?;
    String::from_utf8(bytes).map_err(|_| Failure::file("read", path, "it is not UTF-8 text"))
}
