//! The runtime that goes into every FMU: the shared library of `fmu/`, embedded by `build.rs`.

/// The shared library for the platform that cotree runs on.
pub static LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/runtime"));

/// What FMI 2.0 calls a platform, and how its shared libraries end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder under `binaries/`.
    pub folder: &'static str,
    /// File name extension.
    pub extension: &'static str,
}

/// The platform that cotree was built for, if importers have a name for it. FMI 2.0 names the x86 platforms; the
/// others go by their FMI 3.0 names, as importers expect.
pub fn platform() -> Option<Platform> {
    let (folder, extension) = match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => ("linux64", "so"),
        ("linux", "x86") => ("linux32", "so"),
        ("linux", "aarch64") => ("aarch64-linux", "so"),
        ("windows", "x86_64") => ("win64", "dll"),
        ("windows", "x86") => ("win32", "dll"),
        ("macos", "x86_64") => ("darwin64", "dylib"),
        ("macos", "aarch64") => ("aarch64-darwin", "dylib"),
        _ => return None,
    };
    Some(Platform { folder, extension })
}
