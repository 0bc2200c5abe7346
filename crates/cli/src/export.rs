//! `cotree export`

use std::path::{Path, PathBuf};

use clap::Args;
use cotree::Scene;
use cotree::export::description::SourceSolver;
use cotree::export::runtime::{self, PLATFORMS, Platform, Runtime, RuntimeError};
use cotree::export::{ExportError, FmiVersion};
use cotree_page::Made;
use cotree_text::source::{self, FixedStep, Real, SourceMethod};

use super::failure::Failure;
use super::times;
use super::words::one_of;
use super::{MessageFormat, output};

/// Export an FMU for any tool that reads FMI 2.0, or 3.0 with --fmi 3
///
/// The FMU contains its solver and needs no other program. The same scene gives the same file.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  cotree export slider_crank.toml\n  cotree export slider_crank.toml -o fmus/crank.fmu\n  cotree export slider_crank.toml --fmi 3\n  \
                  cotree export slider_crank.toml --platform linux64,win64 --runtimes target/runtimes\n  cotree export slider_crank.toml --sources --step \"1 ms\"\n  \
                  cotree export slider_crank.toml --c slider_crank.c --step \"1 ms\" --substeps 2"
)]
pub struct ExportCommand {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Output file of the FMU [default: the name of the scene file, .fmu, in the current folder; for `scene.toml` the name in it]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Export every variable of the mechanism, not only the outputs of the scene
    #[arg(long)]
    all: bool,
    /// Version of FMI
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = one_of(&FmiVersion::WORDS))]
    fmi: FmiVersion,
    /// Platforms on which the FMU runs, such as linux64,win64 [default: all for which there is a runtime]
    #[arg(long, value_name = "PLATFORMS", value_delimiter = ',')]
    platform: Vec<String>,
    /// Write a smaller file: the page in its documentation plays a stored run and does not include the runtime for browsers (400 kB)
    #[arg(long)]
    lean: bool,
    /// Write an FMU with C99 sources and a solver of fixed step, for real-time targets; it has no binaries unless --platform names some
    #[arg(long, conflicts_with = "c")]
    sources: bool,
    /// Write the C99 sources alone, without FMI, to this file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "platform", "lean", "runtimes", "fmi"])]
    c: Option<PathBuf>,
    /// Step of the sources, such as "1 ms" [default: the step of the scene's experiment]
    #[arg(long, value_name = "TIME")]
    step: Option<String>,
    /// Divide each step of the sources into so many steps of the solver
    #[arg(long, value_name = "NUMBER", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    substeps: u32,
    /// Order of the solver of the sources
    #[arg(long, value_name = "ORDER", default_value = "4", value_parser = one_of(&SourceMethod::WORDS))]
    order: SourceMethod,
    /// Floating-point type of the sources
    #[arg(long, value_name = "TYPE", default_value = "double", value_parser = one_of(&Real::WORDS))]
    real: Real,
    /// Folder with the runtimes of other platforms, made by tools/build-runtimes.sh [default: `runtimes` beside the program]
    #[arg(long, value_name = "FOLDER", env = "COTREE_RUNTIMES")]
    runtimes: Option<PathBuf>,
}

impl ExportCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let scene = output::load(&self.scene)?;
        let has_sources = self.sources || self.c.is_some();
        let has_options = self.step.is_some()
            || self.substeps > 1
            || self.order != SourceMethod::default()
            || self.real != Real::default();
        if !has_sources && has_options {
            return Err(Failure::Usage("--step, --substeps, --order and --real are for --sources and --c".to_owned()));
        }
        // Sources need no library.
        let runtimes = match has_sources && self.platform.is_empty() {
            true => Vec::new(),
            false => self.runtimes().map_err(ExportError::from)?,
        };
        let mut made = Made::of(&scene, self.all)?;
        let sources = if has_sources { Some(self.sources_of(&scene, &mut made)?) } else { None };
        let compiled = &made.compiled;
        output::warn(compiled.warnings.as_ref(), format);
        if let Some(inaccuracy) = made.accuracy.as_ref().ok().and_then(|accuracy| accuracy.inaccuracy.as_ref()) {
            output::warn_inaccurate(compiled, "", inaccuracy, format);
        }
        if let (Some(path), Some((text, _))) = (&self.c, &sources) {
            output::apart(&[Some(&self.scene)], &[Some(path)])?;
            output::write(path, text)?;
            return output::print(&format!("{}\n", path.display()));
        }
        let module = if self.lean || runtimes.is_empty() {
            None
        } else {
            runtime::for_browsers(&self.folder()).map_err(ExportError::from)?
        };
        let mut extras = made.extras(self.fmi, module)?;
        if let Some((text, step)) = sources {
            extras.extend(source::fmu_sources(&compiled.program, &compiled.description, step, self.fmi, text));
        }
        let named = || output::after(&self.scene, &compiled.description.identifier, "fmu", format);
        let path = self.output.clone().unwrap_or_else(named);
        output::apart(&[Some(&self.scene)], &[Some(&path)])?;
        compiled.write_fmu(self.fmi, extras, &runtimes, &path)?;
        output::print(&format!("{}\n", path.display()))
    }

    /// The C source of the mechanism, and its step; the description becomes that of an FMU with sources.
    fn sources_of(&self, scene: &Scene, made: &mut Made) -> Result<(String, FixedStep), Failure> {
        let (program, mechanism) = (&made.compiled.program, scene.resolve()?.mechanism);
        let step = self.fixed_step(mechanism.experiment.step)?;
        let description = &mut made.compiled.description;
        let text = source::c_file(program, &mechanism, description, &scene.source, step)?;
        let compiled = source::wrapper_name(self.fmi);
        let solver = SourceSolver { step: step.step, solver_step: step.solver_step(), compiled };
        description.offer_sources(solver, !program.instants.events.is_empty());
        Ok((text, step))
    }

    fn fixed_step(&self, default: f64) -> Result<FixedStep, Failure> {
        let step = self.step.as_deref().map_or(Ok(default), |text| times::seconds("step", text))?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(Failure::Usage(format!("--step: {step} s, but must be more than 0 s")));
        }
        Ok(FixedStep { step, substeps: self.substeps, method: self.order, real: self.real })
    }

    fn folder(&self) -> PathBuf {
        self.runtimes.clone().unwrap_or_else(runtime::default_folder)
    }

    /// The runtimes for the platforms asked for.
    fn runtimes(&self) -> Result<Vec<Runtime>, RuntimeError> {
        let folder = self.folder();
        let platforms = match &self.platform[..] {
            names if names.is_empty() || names == ["all"] => available(&folder),
            names => names.iter().map(|name| Platform::named(name)).collect::<Result<_, _>>()?,
        };
        if platforms.is_empty() {
            return Err(RuntimeError::host());
        }
        platforms.into_iter().map(|platform| Runtime::find(platform, &folder)).collect()
    }
}

/// The platforms that there is a runtime for.
pub(super) fn available(folder: &Path) -> Vec<Platform> {
    let is_there = |platform: &Platform| Platform::host() == Some(*platform) || platform.file(folder).exists();
    PLATFORMS.iter().copied().filter(is_there).collect()
}
