//! The client that reads FMUs with fmi-rs: a package of its own, built under `target/`.

use crate::support::ROOT;
use std::path::Path;
use std::process::Command;

/// A command that builds and runs the client.
pub fn client() -> Command {
    let package = Path::new(ROOT).join("tests/fmi-rs-client/Cargo.toml");
    let mut client = Command::new(env!("CARGO"));
    client.args(["run", "--quiet", "--locked", "--manifest-path"]).arg(package);
    client.arg("--target-dir").arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("fmi-rs/target")).arg("--");
    client
}
