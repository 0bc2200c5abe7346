//! The runtime that goes into every FMU, one shared library for each platform.
//!
//! The one for the platform that cotree runs on is embedded: `build.rs` says where it is. Others, and better ones for the same platform
//! (linked against an older C library, say), are read from a folder: `<platform>/cotree_runtime.so` and so on.

use std::borrow::Cow;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use cotree_fmu::program::storage::KIND;

use super::FmiVersion;

/// The shared library for the platform that cotree runs on.
pub static LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), env!("COTREE_EMBEDDED")));

/// Where the build kept the sources of packages.
const PACKAGES: &str = env!("COTREE_PACKAGES");

/// Name of the folder beside the `cotree` program where runtimes are looked for.
const FOLDER: &str = "runtimes";

/// What FMI calls a platform, and how its shared libraries end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder under `binaries/` in FMI 2.0.
    pub folder: &'static str,
    /// The same in FMI 3.0 (2.5.1.4.1): processor and system.
    pub tuple: &'static str,
    /// File name extension.
    pub extension: &'static str,
    /// Operating system and processor in the words of Rust's standard library.
    host: [&'static str; 2],
    /// The kind of shared library, and the number of the processor in its header.
    format: (LibraryFormat, u32),
}

/// A kind of shared library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LibraryFormat {
    Elf,
    Pe,
    MachO,
}

/// Every platform that importers have a name for. FMI 2.0 names the x86 platforms; the others go by their FMI 3.0 names,
/// as importers expect.
pub static PLATFORMS: [Platform; 7] = [
    platform(["linux64", "x86_64-linux"], "so", ["linux", "x86_64"], (LibraryFormat::Elf, 62)),
    platform(["linux32", "x86-linux"], "so", ["linux", "x86"], (LibraryFormat::Elf, 3)),
    platform(["aarch64-linux", "aarch64-linux"], "so", ["linux", "aarch64"], (LibraryFormat::Elf, 183)),
    platform(["win64", "x86_64-windows"], "dll", ["windows", "x86_64"], (LibraryFormat::Pe, 0x8664)),
    platform(["win32", "x86-windows"], "dll", ["windows", "x86"], (LibraryFormat::Pe, 0x14c)),
    platform(
        [Platform::MAC_FOLDER, "x86_64-darwin"],
        "dylib",
        ["macos", "x86_64"],
        (LibraryFormat::MachO, 0x0100_0007),
    ),
    platform(["aarch64-darwin", "aarch64-darwin"], "dylib", ["macos", "aarch64"], (LibraryFormat::MachO, 0x0100_000c)),
];

const fn platform(
    [folder, tuple]: [&'static str; 2],
    extension: &'static str,
    host: [&'static str; 2],
    format: (LibraryFormat, u32),
) -> Platform {
    Platform { folder, tuple, extension, host, format }
}

impl Platform {
    /// The folder for Macs in FMI 2.0, which knows one kind of them.
    pub(super) const MAC_FOLDER: &str = "darwin64";

    /// The platform that cotree was built for, if importers have a name for it.
    pub fn host() -> Option<Self> {
        let host = [std::env::consts::OS, std::env::consts::ARCH];
        PLATFORMS.iter().copied().find(|platform| platform.host == host)
    }

    /// Its folder under `binaries/`.
    pub fn folder(&self, version: FmiVersion) -> &'static str {
        match version {
            FmiVersion::V2 => self.folder,
            FmiVersion::V3 => self.tuple,
        }
    }

    pub(super) fn is_mac(&self) -> bool {
        self.format.0 == LibraryFormat::MachO
    }

    /// The platform of that name.
    ///
    /// # Errors
    /// There is no such platform.
    pub fn named(name: &str) -> Result<Self, RuntimeError> {
        let known = PLATFORMS.iter().copied().find(|platform| [platform.folder, platform.tuple].contains(&name));
        known.ok_or_else(|| {
            let folders = PLATFORMS.map(|platform| platform.folder).join(", ");
            RuntimeError(format!("there is no platform `{name}`; there are: {folders}"))
        })
    }

    /// Where its runtime lies in a folder of runtimes.
    pub fn file(&self, runtimes: &Path) -> PathBuf {
        runtimes.join(self.folder).join(format!("cotree_runtime.{}", self.extension))
    }

    /// Is this a shared library for the platform?
    fn accepts(&self, library: &[u8]) -> bool {
        let (format, processor) = self.format;
        match format {
            LibraryFormat::Elf => library.starts_with(b"\x7fELF") && number(library, 18, 2) == Some(processor),
            LibraryFormat::MachO => {
                library.starts_with(b"\xcf\xfa\xed\xfe") && number(library, 4, 4) == Some(processor)
            }
            LibraryFormat::Pe => {
                let header = number(library, 60, 4).map_or(usize::MAX, |offset| offset as usize);
                let marked = header.checked_add(4).and_then(|end| library.get(header..end)) == Some(b"PE\0\0");
                library.starts_with(b"MZ") && marked && number(library, header + 4, 2) == Some(processor)
            }
        }
    }
}

/// Does a shared library read the programs that this cotree writes?
fn understands(library: &[u8]) -> bool {
    library.windows(KIND.len()).any(|bytes| bytes == KIND.as_bytes())
}

/// Bytes with dots where a text stood.
fn without<'a>(bytes: &'a [u8], text: &[u8]) -> Cow<'a, [u8]> {
    let mut bytes = Cow::Borrowed(bytes);
    let mut from = 0;
    while !text.is_empty()
        && let Some(place) = bytes[from..].windows(text.len()).position(|found| found == text)
    {
        from += place;
        bytes.to_mut()[from..from + text.len()].fill(b'.');
    }
    bytes
}

/// A number of a header, lowest byte first.
fn number(bytes: &[u8], from: usize, length: usize) -> Option<u32> {
    let field = bytes.get(from..from.checked_add(length)?)?;
    Some(field.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte)))
}

/// A shared library and the platform it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Runtime {
    pub platform: Platform,
    pub library: Cow<'static, [u8]>,
}

/// Why there is no runtime for a platform.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct RuntimeError(pub String);

impl RuntimeError {
    /// FMI has no name for the platform, so no importer would find the shared library.
    pub fn host() -> Self {
        let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
        RuntimeError(format!("FMI has no folder name for this platform ({system} on {processor})"))
    }

    /// It reads other programs than this cotree writes.
    fn version(file: &Path) -> Self {
        let file = file.display();
        RuntimeError(format!(
            "`{file}` is the runtime of another version of cotree\nBuild it again with tools/build-runtimes.sh"
        ))
    }

    /// The file is for another platform, or no shared library at all.
    fn foreign(file: &Path, platform: &str) -> Self {
        RuntimeError(format!("`{}` is not a shared library for {platform}", file.display()))
    }

    /// No folder of runtimes has it.
    fn missing(file: &Path, platform: &str) -> Self {
        let file = file.display();
        RuntimeError(format!(
            "there is no runtime for {platform}: `{file}` does not exist\nBuild it with tools/build-runtimes.sh, and name its \
             folder with --runtimes or in COTREE_RUNTIMES"
        ))
    }

    fn unreadable(file: &Path, error: &std::io::Error) -> Self {
        RuntimeError(format!("cannot read the runtime `{}`: {error}", file.display()))
    }
}

impl Runtime {
    /// Is it the one that cotree was built with?
    pub(super) fn is_own(&self) -> bool {
        std::ptr::eq(&raw const *self.library, &raw const *LIBRARY)
    }

    /// The library as FMUs have it.
    pub fn packed_library(&self) -> Cow<'_, [u8]> {
        if self.is_own() { Self::own_library() } else { Cow::Borrowed(&*self.library) }
    }

    /// The embedded library as FMUs have it. Its messages say where in the source something is impossible; dots stand there for the folder of whoever built
    /// cotree. Libraries of macOS are signed and stay as they are.
    pub(super) fn own_library() -> Cow<'static, [u8]> {
        let signed = Platform::host().is_none_or(|platform| platform.is_mac());
        if signed { LIBRARY.into() } else { without(LIBRARY, PACKAGES.as_bytes()) }
    }

    /// The runtime that cotree carries inside itself.
    ///
    /// # Errors
    /// FMI has no name for the platform, or cotree was built without a runtime.
    pub fn embedded() -> Result<Self, RuntimeError> {
        let platform = Platform::host().ok_or_else(RuntimeError::host)?;
        if !platform.accepts(LIBRARY) {
            let file = Path::new(concat!(env!("OUT_DIR"), env!("COTREE_EMBEDDED")));
            return Err(RuntimeError::foreign(file, platform.folder));
        }
        Ok(Self { platform, library: Cow::Borrowed(LIBRARY) })
    }

    /// The runtime for a platform: from the folder if it is there, otherwise the embedded one if it fits.
    ///
    /// # Errors
    /// There is none, or the file is none.
    pub fn find(platform: Platform, runtimes: &Path) -> Result<Self, RuntimeError> {
        let file = platform.file(runtimes);
        match fs::read(&file) {
            Ok(library) if platform.accepts(&library) && understands(&library) => {
                Ok(Self { platform, library: library.into() })
            }
            Ok(library) if platform.accepts(&library) => Err(RuntimeError::version(&file)),
            Ok(_) => Err(RuntimeError::foreign(&file, platform.folder)),
            Err(error) if error.kind() == ErrorKind::NotFound && Platform::host() == Some(platform) => Self::embedded(),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(RuntimeError::missing(&file, platform.folder)),
            Err(error) => Err(RuntimeError::unreadable(&file, &error)),
        }
    }
}

/// The runtime for browsers, if the folder has it: `web/cotree_runtime.wasm`.
///
/// # Errors
/// The file cannot be read, is something else, or belongs to another version.
pub fn for_browsers(runtimes: &Path) -> Result<Option<Vec<u8>>, RuntimeError> {
    web_module(runtimes, "cotree_runtime.wasm")
}

/// The way from a scene to its FMU for browsers, if the folder has it: `web/cotree_front.wasm`.
///
/// # Errors
/// The file cannot be read, is something else, or belongs to another version.
pub fn front_for_browsers(runtimes: &Path) -> Result<Option<Vec<u8>>, RuntimeError> {
    web_module(runtimes, "cotree_front.wasm")
}

fn web_module(runtimes: &Path, name: &str) -> Result<Option<Vec<u8>>, RuntimeError> {
    let file = runtimes.join("web").join(name);
    match fs::read(&file) {
        Ok(module) if !module.starts_with(b"\0asm") => Err(RuntimeError::foreign(&file, "browsers")),
        Ok(module) if !understands(&module) => Err(RuntimeError::version(&file)),
        Ok(module) => Ok(Some(module)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(RuntimeError::unreadable(&file, &error)),
    }
}

/// The folder beside the `cotree` program where runtimes are looked for if no other is named.
pub fn default_folder() -> PathBuf {
    let program = std::env::current_exe().and_then(|program| program.canonicalize());
    program.ok().and_then(|program| Some(program.parent()?.join(FOLDER))).unwrap_or_else(|| FOLDER.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_runtime_is_for_this_platform() {
        let runtime = Runtime::embedded().unwrap();
        for platform in PLATFORMS {
            assert_eq!(platform.accepts(&runtime.library), platform == runtime.platform, "{platform:?}");
        }
    }

    #[test]
    fn the_embedded_runtime_does_not_name_who_built_it() {
        let names = |library: &[u8]| library.windows(PACKAGES.len()).any(|found| found == PACKAGES.as_bytes());
        assert!(!PACKAGES.is_empty() && !names(&Runtime::own_library()));
        assert!(Platform::host().unwrap().accepts(&Runtime::own_library()));
        assert_eq!(Runtime::own_library().len(), LIBRARY.len());
        assert_eq!(*without(b"ab/a/ab", b"ab"), *b"../a/..");
    }

    #[test]
    fn headers_of_other_platforms_are_known() {
        let mut dll = vec![0; 0x90];
        dll[..2].copy_from_slice(b"MZ");
        dll[60] = 0x80;
        dll[0x80..0x86].copy_from_slice(b"PE\0\0\x64\x86");
        assert!(Platform::named("win64").unwrap().accepts(&dll));
        assert!(!Platform::named("win32").unwrap().accepts(&dll));
        assert!(Platform::named("aarch64-darwin").unwrap().accepts(b"\xcf\xfa\xed\xfe\x0c\0\0\x01"));
    }

    #[test]
    fn cut_off_libraries_are_refused() {
        let mut far = vec![0xff; 64];
        far[..2].copy_from_slice(b"MZ");
        for bytes in [&b""[..], b"MZ", b"\x7fELF", b"\xcf\xfa\xed\xfe", &far] {
            assert!(PLATFORMS.iter().all(|platform| !platform.accepts(bytes)), "{bytes:?}");
        }
    }

    #[test]
    fn the_runtime_for_browsers_is_checked() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(for_browsers(folder.path()), Ok(None)));
        let file = folder.path().join("web/cotree_runtime.wasm");
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "text").unwrap();
        assert!(for_browsers(folder.path()).unwrap_err().to_string().contains("is not a shared library for browsers"));
        fs::write(&file, b"\0asm of long ago").unwrap();
        assert!(for_browsers(folder.path()).unwrap_err().to_string().contains("of another version of cotree"));
        let module = [b"\0asm", KIND.as_bytes()].concat();
        fs::write(&file, &module).unwrap();
        assert_eq!(for_browsers(folder.path()).unwrap(), Some(module));
    }

    #[test]
    fn a_folder_comes_before_the_embedded_runtime() {
        let folder = tempfile::tempdir().unwrap();
        let host = Platform::host().unwrap();
        assert_eq!(Runtime::find(host, folder.path()).unwrap().library, LIBRARY);
        let file = host.file(folder.path());
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        let mine = [LIBRARY, b"mine"].concat();
        fs::write(&file, &mine).unwrap();
        assert_eq!(Runtime::find(host, folder.path()).unwrap().library, mine);
        let at = mine.windows(KIND.len()).position(|bytes| bytes == KIND.as_bytes()).unwrap();
        let mut other = mine.clone();
        other[at + KIND.len() - 1] ^= 1;
        fs::write(&file, other).unwrap();
        assert!(Runtime::find(host, folder.path()).unwrap_err().to_string().contains("of another version of cotree"));
        fs::write(&file, b"text").unwrap();
        assert!(Runtime::find(host, folder.path()).unwrap_err().to_string().contains("is not a shared library for"));
    }
}
