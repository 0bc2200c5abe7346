//! One test case in a process of its own.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

/// A case that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(300);

/// Comes before the reason why a model has nothing that a case is about.
pub const NOTHING: &str = "nothing to check: ";

/// Runs an ignored test of this program, with these variables and its output in a file. The reason if it fails; if there was nothing
/// to check, the reason for that.
pub fn run<'a>(
    test: &str,
    variables: impl IntoIterator<Item = (&'static str, &'a Path)>,
    output: &Path,
) -> Result<Option<String>, String> {
    let mut command = Command::new(env::current_exe().map_err(|error| error.to_string())?);
    command.args([test, "--exact", "--ignored", "--nocapture"]).envs(variables);
    let file = fs::File::create(output).map_err(|error| error.to_string())?;
    let copy = file.try_clone().map_err(|error| error.to_string())?;
    let mut child =
        command.stdin(Stdio::null()).stdout(file).stderr(copy).spawn().map_err(|error| error.to_string())?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            let printed = fs::read_to_string(output).unwrap_or_default();
            let nothing = printed.lines().find_map(|line| line.split_once(NOTHING));
            return match nothing {
                _ if !status.success() || !printed.contains("1 passed") => Err(format!("{status}\n{printed}")),
                nothing => Ok(nothing.map(|(_, reason)| reason.to_owned())),
            };
        }
        if started.elapsed() > PATIENCE {
            child.kill().map_err(|error| error.to_string())?;
            return Err("it hangs".to_owned());
        }
        thread::sleep(Duration::from_millis(1));
    }
}
