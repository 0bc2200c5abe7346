//! `cotree view`

use std::ffi::OsStr;
use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use cotree::compile::Compiled;
use cotree::export::{ExportError, runtime};
use cotree::scene::Scene;
use cotree_draw::png::{Size, png};
use cotree_page::film::{self, Take, Taken};
use cotree_page::moving;

use super::failure::Failure;
use super::{MessageFormat, output, serve};

/// More pictures than this are a mistake in the rate or the speed.
const MOST_PICTURES: u32 = 100_000;

/// Show the motion in a browser: one page with the mechanism, plots and sliders
///
/// The page needs no network. It contains the solver of the FMU if the runtime for browsers is there (`web/cotree_runtime.wasm` in
/// the folder of runtimes, made by tools/build-runtimes.sh). Otherwise this machine serves the page and solves it; a file without a solver plays a
/// stored run, with a note.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree view slider_crank.toml\n  cotree view slider_crank.toml -o crank.html --runtimes target/runtimes\n  \
                  cotree view slider_crank.toml --svg --speed 0.25\n  cotree view slider_crank.toml --frames film --fps 30"
)]
pub struct ViewCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Output file of the page [default: the name of the scene file, .html (.svg with --svg), in the current folder; for `scene.toml` the name in it]
    #[arg(short, long, value_name = "FILE", conflicts_with = "frames")]
    output: Option<PathBuf>,
    /// Write an animated SVG that loops, for a README, instead of the page (as with `-o film.svg`)
    #[arg(long, group = "film", conflicts_with = "frames")]
    svg: bool,
    /// Write single frames, frame_0000.png and so on, into this folder instead of the page
    #[arg(long, value_name = "FOLDER", group = "film")]
    frames: Option<PathBuf>,
    /// Frames per second of the film
    #[arg(long, value_name = "NUMBER", default_value_t = 25.0, requires = "frames")]
    fps: f64,
    /// Speed of the film: 0.25 is a quarter of the true speed
    #[arg(long, value_name = "NUMBER", default_value_t = 1.0, requires = "film")]
    speed: f64,
    /// Width of the frames in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1280, requires = "frames", value_parser = clap::value_parser!(u16).range(16..=8192))]
    width: u16,
    /// Serve the page on this machine until Ctrl-C, with this program as its solver [default if there is a terminal, no runtime for browsers and no -o]
    #[arg(long, conflicts_with_all = ["output", "film"])]
    serve: bool,
    /// Folder with the runtimes, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl ViewCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let named = self.output.as_deref();
        let is_film = self.svg || self.frames.is_some() || named.is_some_and(|path| output::has_extension(path, "svg"));
        output::is_written_as(named, if is_film { &["svg"] } else { &["html", "htm"] })?;
        let scene = output::load(&self.scene)?;
        if is_film { self.film(&scene, format) } else { self.page(&scene, format) }
    }

    fn page(&self, scene: &Scene, format: MessageFormat) -> Result<(), Failure> {
        let folder = self.runtimes.clone().unwrap_or_else(runtime::default_folder);
        let module = runtime::for_browsers(&folder).map_err(ExportError::from)?;
        let is_served = self.serve || module.is_none() && self.output.is_none() && std::io::stdout().is_terminal();
        let module = if is_served { Some(Vec::new()) } else { module };
        let (compiled, page) = moving::page(scene, module)?;
        output::warn(compiled.warnings.as_ref(), format);
        let page = page.map_err(|error| Failure::Numerical(error.to_string()))?;
        if is_served {
            return serve::page(page.served_html(), serve::desk(&folder)?, |_| ());
        }
        self.write(&compiled, "html", &page.html(), format)
    }

    fn film(&self, scene: &Scene, format: MessageFormat) -> Result<(), Failure> {
        for (name, value) in [("fps", self.fps), ("speed", self.speed)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Failure::Usage(format!("--{name}: {value:?} must be positive")));
            }
        }
        let take = Take { rate: self.frames.is_some().then_some(self.fps), speed: self.speed };
        let (compiled, taken) = film::film(scene, take, MOST_PICTURES)?;
        output::warn(compiled.warnings.as_ref(), format);
        let Taken { film, cut, inaccuracy } = taken.map_err(|error| Failure::Numerical(error.to_string()))?;
        inaccuracy.iter().for_each(|found| output::warn_inaccurate(&compiled, "", found, format));
        match &self.frames {
            Some(folder) => {
                self.write_frames(folder, film.len(), |sample| film.frame(sample))?;
                output::print(&format!("{}\n", folder.display()))?;
            }
            None => self.write(&compiled, "svg", &film.svg(), format)?,
        }
        let pictures = film.len();
        cut.map_or(Ok(()), |error| {
            Err(Failure::Numerical(error).with_note(&format!("the film has the {pictures} pictures before that")))
        })
    }

    /// Writes the page or the film, and prints where it is.
    fn write(&self, compiled: &Compiled, kind: &str, text: &str, format: MessageFormat) -> Result<(), Failure> {
        let named = || output::after(&self.scene, &compiled.description.identifier, kind, format);
        let path = self.output.clone().unwrap_or_else(named);
        output::apart(&[Some(&self.scene)], &[Some(&path)])?;
        output::write(&path, text)?;
        output::print(&format!("{}\n", path.display()))
    }

    /// One file for each picture. Those of a longer film, left in the folder, would be taken for its end.
    fn write_frames(&self, folder: &Path, count: usize, frame: impl Fn(usize) -> String) -> Result<(), Failure> {
        fs::create_dir_all(folder).map_err(|error| Failure::file("make", folder, error))?;
        let entries = fs::read_dir(folder).map_err(|error| Failure::file("read", folder, error))?;
        for name in entries.flatten().map(|entry| entry.file_name()) {
            if number(&name).is_some_and(|number| number >= count) {
                let left = "it is of a longer film; remove it, or choose another folder";
                return Err(Failure::file("leave", &folder.join(name), left));
            }
        }
        let width = f32::from(self.width);
        for sample in 0..count {
            let path = folder.join(format!("frame_{sample:04}.png"));
            let picture = png(&frame(sample), Size::Wide(width));
            output::write(&path, picture.map_err(|error| Failure::file("draw", &path, error))?)?;
        }
        Ok(())
    }
}

/// The number of a picture, by its name.
fn number(name: &OsStr) -> Option<usize> {
    name.to_str()?.strip_prefix("frame_")?.strip_suffix(".png")?.parse().ok()
}
