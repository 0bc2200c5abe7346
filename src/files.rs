//! Files that are whole or not there: written without a name or beside their place, then renamed. And files read with a limit.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// A file under way. It takes its place at [`commit`](Self::commit); dropped before, it leaves nothing behind. Nor does a process that is
/// killed, where files can be without a name (Linux, on its own file systems).
#[derive(Debug)]
pub struct Draft {
    writer: Option<BufWriter<File>>,
    place: PathBuf,
    stage: DraftStage,
}

/// Where a file is before it takes its place.
#[derive(Debug)]
enum DraftStage {
    /// In its place already: a pipe or a device is written to, not replaced.
    Placed,
    /// In the right folder, without a name.
    Nameless,
    /// Under another name in the right folder.
    Beside(PathBuf),
}

impl Draft {
    /// Starts a file that will replace whatever is at `path`.
    pub fn new(path: &Path) -> io::Result<Self> {
        // A link is followed, so that the file it points to is replaced and not the link.
        let place = followed(path)?;
        match fs::metadata(&place) {
            Ok(data) if data.is_dir() => return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a directory")),
            // To be replaced it need not be writable, but whoever made it read-only does not expect that.
            Ok(data) if data.is_file() => drop(OpenOptions::new().write(true).open(&place)?),
            Ok(_) => {
                let file = open_patiently(OpenOptions::new().write(true), &place, "no program reads from")?;
                return Ok(Self { writer: Some(BufWriter::new(file)), place, stage: DraftStage::Placed });
            }
            Err(_) => {}
        }
        let file = nameless(&place);
        Self::staged(place, file)
    }

    /// Starts a file in a file without a name, if there is one.
    fn staged(place: PathBuf, nameless: Option<File>) -> io::Result<Self> {
        let (file, stage) = match nameless {
            Some(file) => (file, DraftStage::Nameless),
            None => {
                let (file, beside) = beside(&place, |path| OpenOptions::new().write(true).create_new(true).open(path))?;
                (file, DraftStage::Beside(beside))
            }
        };
        if let Ok(old) = fs::metadata(&place) {
            // Whoever could not read the old file shall not read the new one.
            let _ = file.set_permissions(old.permissions());
        }
        Ok(Self { writer: Some(BufWriter::new(file)), place, stage })
    }

    /// Puts the finished file in its place.
    pub fn commit(mut self) -> io::Result<()> {
        let Some(writer) = self.writer.take() else { return Ok(()) };
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        if matches!(self.stage, DraftStage::Placed) {
            return Ok(());
        }
        file.sync_all()?;
        if matches!(self.stage, DraftStage::Nameless) {
            let ((), beside) = beside(&self.place, |path| name(&file, path))?;
            self.stage = DraftStage::Beside(beside);
        }
        if let DraftStage::Beside(beside) = &self.stage {
            fs::rename(beside, &self.place)?;
            self.stage = DraftStage::Placed;
        }
        Ok(())
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if let DraftStage::Beside(beside) = &self.stage {
            self.writer = None; // closed first: an open file cannot be removed everywhere
            let _ = fs::remove_file(beside); // nobody to tell, and the reason for dropping is told already
        }
    }
}

/// Writes a whole file at once.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut draft = Draft::new(path)?;
    draft.write_all(bytes)?;
    draft.commit()
}

/// Where a file with this name is or will be: at the end of all links, of which the last may lead to nothing yet.
fn followed(path: &Path) -> io::Result<PathBuf> {
    /// As many links in a row as Linux follows.
    const LINKS: usize = 40;
    let mut place = path.to_path_buf();
    for _ in 0..LINKS {
        if let Ok(found) = fs::canonicalize(&place) {
            return Ok(found);
        }
        match fs::read_link(&place) {
            Ok(target) => place = place.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("its links form a cycle"))
}

/// Makes something under a free name in the same folder, so that renaming does not copy. The name is short: the place's own may be as long as names
/// can be.
fn beside<T>(place: &Path, mut make: impl FnMut(&Path) -> io::Result<T>) -> io::Result<(T, PathBuf)> {
    /// More than this are not left over.
    const NAMES: usize = 1000;
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    if place.file_name().is_none() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "is not a file name"));
    }
    let mut taken = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..NAMES {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = place.with_file_name(format!(".cotree-{}-{number}.part", std::process::id()));
        match make(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => taken = error,
            made => return Ok((made?, path)),
        }
    }
    Err(taken)
}

/// A new file without a name in the folder of another, if it can get one later.
#[cfg(target_os = "linux")]
fn nameless(place: &Path) -> Option<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let flags = rustix::fs::OFlags::TMPFILE.bits().cast_signed();
    let file = OpenOptions::new().write(true).custom_flags(flags).open(folder).ok()?;
    handle(&file).exists().then_some(file)
}

/// Gives a file without a name a name.
#[cfg(target_os = "linux")]
fn name(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    Ok(linkat(CWD, handle(file), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

/// What an open file can be named by.
#[cfg(target_os = "linux")]
fn handle(file: &File) -> PathBuf {
    use std::os::fd::AsRawFd;
    PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &Path) -> Option<File> {
    None
}

#[cfg(not(target_os = "linux"))]
fn name(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// How long somebody may take to open the other end of a pipe.
const PATIENCE: Duration = Duration::from_secs(5);

/// Reads a whole file of at most so many bytes, or what comes through a pipe.
///
/// # Errors
/// It cannot be read, is a folder, larger, or a pipe that nobody opens for writing.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let data = fs::metadata(path)?;
    let large = || io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than {} MB", most >> 20));
    if data.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if data.len() > most {
        return Err(large());
    }
    let mut bytes = Vec::new();
    let reading = || open_patiently(OpenOptions::new().read(true), path, "no program writes to");
    let file = if data.is_file() { File::open(path)? } else { reading()? };
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(large()) } else { Ok(bytes) }
}

/// Opens a pipe or a device. Opening a pipe waits for the other end, who may never come.
fn open_patiently(options: &OpenOptions, path: &Path, missing: &str) -> io::Result<File> {
    let (opened, result) = mpsc::channel();
    let (options, path) = (options.clone(), path.to_owned());
    thread::spawn(move || opened.send(options.open(path)));
    let nobody = || io::Error::new(io::ErrorKind::TimedOut, format!("it is a pipe that {missing}"));
    result.recv_timeout(PATIENCE).map_err(|_| nobody())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_appears_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        write(&path, b"old").unwrap();
        let mut draft = Draft::new(&path).unwrap();
        draft.write_all(b"new").unwrap();
        draft.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        draft.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_abandoned_draft_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut draft = Draft::new(&folder.path().join("out.csv")).unwrap();
        draft.write_all(b"half").unwrap();
        drop(draft);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_draft_has_no_name() {
        let folder = tempfile::tempdir().unwrap();
        let mut draft = Draft::new(&folder.path().join("out.csv")).unwrap();
        draft.write_all(b"half").unwrap();
        draft.flush().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "whoever is killed now leaves nothing");
    }

    #[test]
    fn without_nameless_files_a_draft_lies_beside_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        let begin = || {
            let mut draft = Draft::staged(path.clone(), None).unwrap();
            draft.write_all(b"new").unwrap();
            draft.flush().unwrap();
            assert_eq!((path.exists(), fs::read_dir(folder.path()).unwrap().count()), (false, 1));
            draft
        };
        drop(begin());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        begin().commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_read_has_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in");
        fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read(&path, 100).unwrap(), [7; 100]);
        assert_eq!(read(&path, 99).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read(folder.path(), 99).unwrap_err().kind(), io::ErrorKind::IsADirectory);
    }

    #[cfg(unix)]
    #[test]
    fn an_endless_file_has_an_end() {
        assert_eq!(read(Path::new("/dev/zero"), 1 << 20).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(read(Path::new("/dev/null"), 10).unwrap().is_empty());
    }

    #[test]
    fn a_folder_or_a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write(folder.path(), b"").is_err());
        assert!(write(&folder.path().join("missing/out.csv"), b"").is_err());
    }

    /// What other programs can name, this one can write.
    #[test]
    fn a_name_may_be_as_long_as_names_can_be() {
        let folder = tempfile::tempdir().unwrap();
        for nameless in [true, false] {
            let path = folder.path().join("a".repeat(255));
            let file = if nameless { self::nameless(&path) } else { None };
            let mut draft = Draft::staged(path.clone(), file).unwrap();
            draft.write_all(b"new").unwrap();
            draft.commit().unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"new");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
            fs::remove_file(path).unwrap();
        }
    }

    #[test]
    fn what_others_left_over_is_no_obstacle() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("out");
        let mut calls = 0;
        let (_, path) = beside(&place, |path| {
            calls += 1;
            if calls == 1 { Err(io::ErrorKind::AlreadyExists.into()) } else { fs::write(path, b"") }
        })
        .unwrap();
        assert!(calls == 2 && path.exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_what_is_not_there_yet_is_followed_too() {
        let folder = tempfile::tempdir().unwrap();
        let [first, second, place] = ["first", "second", "out"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("second", &first).unwrap();
        std::os::unix::fs::symlink("out", &second).unwrap();
        write(&first, b"new").unwrap();
        assert!(
            fs::symlink_metadata(&first).unwrap().is_symlink() && fs::symlink_metadata(&second).unwrap().is_symlink()
        );
        assert_eq!(fs::read(&place).unwrap(), b"new");
        let circle = folder.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        assert!(write(&circle, b"new").is_err());
    }

    /// Renaming would replace it all the same. The superuser may write everything.
    #[cfg(unix)]
    #[test]
    fn what_may_not_be_written_is_not_replaced() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        let may = OpenOptions::new().write(true).open(&path).is_ok();
        assert_eq!(write(&path, b"new").is_ok(), may);
        assert_eq!(fs::read(&path).unwrap(), if may { b"new" } else { b"old" });
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, b"old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
