//! Rules for archives and shared libraries that hold for every version of FMI: lists of complaints.

use std::collections::HashSet;
use std::path::Path;
use std::process::Command;

/// A header of the central directory.
#[derive(Debug)]
pub struct Entry {
    version: u16,
    flags: u16,
    method: u16,
    mode: u32,
    pub name: String,
}

/// The headers of the central directory.
pub fn entries(bytes: &[u8]) -> Vec<Entry> {
    let short = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let long = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let end = bytes.len() - 22;
    assert_eq!(long(end), 0x0605_4b50, "no comment at the end");
    let mut at = long(end + 16) as usize;
    let mut entries = Vec::new();
    for _ in 0..short(end + 10) {
        assert_eq!(long(at), 0x0201_4b50);
        let [name, extra, comment] = [28, 30, 32].map(|field| short(at + field) as usize);
        let text = String::from_utf8_lossy(&bytes[at + 46..at + 46 + name]).into_owned();
        let (flags, mode) = (short(at + 8), long(at + 38) >> 16);
        entries.push(Entry { version: short(at + 6), flags, method: short(at + 10), mode, name: text });
        at += 46 + name + extra + comment;
    }
    entries
}

/// Stored or deflated; no encryption, links, foreign paths, or names twice; sizes after the data only where it is deflated.
pub fn plain_zip(bytes: &[u8]) -> Vec<String> {
    let mut seen = HashSet::new();
    let bad = entries(bytes).into_iter().filter(|Entry { version, flags, method, mode, name }| {
        let link = mode & 0o170_000 == 0o120_000;
        let path = name.contains('\\') || name.starts_with('/') || name.split('/').any(|part| part == "..");
        let streamed = flags & 8 != 0 && *method != 8;
        let strange = *version & 0xff > 20 || flags & 1 != 0 || ![0, 8].contains(method) || streamed;
        strange || link || path || !seen.insert(name.clone())
    });
    bad.map(|entry| format!("{entry:?}")).collect()
}

/// What a tool prints about a library.
fn printed(tool: &str, arguments: &[&str], library: &Path) -> String {
    let output = Command::new(tool).args(arguments).arg(library).output();
    let output = output.unwrap_or_else(|error| panic!("{tool} (package binutils): {error}"));
    assert!(output.status.success(), "{tool}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Everything that it exports.
pub fn symbols(library: &Path) -> Vec<String> {
    let text = printed("nm", &["-D", "--defined-only"], library);
    text.lines().filter_map(|line| line.split_whitespace().next_back()).map(str::to_owned).collect()
}

/// The C library of Debian 10 and RHEL 8.
const NEWEST_GLIBC: &str = "GLIBC_2.28";

/// The newest version of the C library that it asks for.
pub fn glibc(library: &Path) -> String {
    let symbols = printed("objdump", &["-T"], library);
    let versions = symbols.split(|c: char| c.is_whitespace() || "()".contains(c));
    let versions = versions.filter(|word| word.starts_with("GLIBC_") && !word.ends_with("PRIVATE"));
    let newest = versions.reduce(|newest, version| if newer(version, newest) { version } else { newest });
    newest.expect("it uses the C library").to_owned()
}

/// Is the first version newer than the second?
fn newer(version: &str, other: &str) -> bool {
    let numbers = |text: &str| -> Vec<u32> {
        let number = |part: &str| part.parse().expect("a number");
        text.trim_start_matches("GLIBC_").split('.').map(number).collect()
    };
    numbers(version) > numbers(other)
}

/// The C library is all that it needs, an old one will do, and nothing can be put onto its stack and run.
pub fn needs_little(library: &Path) -> Vec<String> {
    const PERMITTED: [&str; 6] = ["libc.so", "libm.so", "libdl.so", "libpthread.so", "libgcc_s.so", "ld-linux"];
    let dynamic = printed("readelf", &["-dW"], library);
    let libraries = dynamic.lines().filter(|line| line.contains("(NEEDED)"));
    let foreign = libraries.filter(|line| !PERMITTED.iter().any(|name| line.contains(name)));
    let mut complaints: Vec<String> = foreign.map(str::to_owned).collect();
    complaints.extend(dynamic.lines().filter(|line| line.contains("PATH)")).map(str::to_owned));
    let newest = glibc(library);
    complaints.extend(newer(&newest, NEWEST_GLIBC).then(|| format!("needs {newest}")));
    let segments = printed("readelf", &["-lW"], library);
    let stack = segments.lines().find(|line| line.contains("GNU_STACK"));
    complaints.extend(stack.filter(|line| line.contains("RWE")).map(str::to_owned));
    complaints
}
