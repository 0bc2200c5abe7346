//! What wakes whoever watches files: the events of the file system, and a clock where it has none.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// Folders whose changes are heard of. Editors put another file in the place of the old one, so a file alone is not enough.
pub struct FolderChanges {
    /// None where the system reports no changes: then only the clock wakes.
    watcher: Option<RecommendedWatcher>,
    folders: BTreeSet<PathBuf>,
    heard: Receiver<()>,
}

impl FolderChanges {
    pub fn new() -> Self {
        let (tell, heard) = mpsc::channel();
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            // Reading the files is an event too, and no news.
            if !event.is_ok_and(|event| matches!(event.kind, EventKind::Access(_))) {
                // Nobody listens any more only when the program ends.
                let _ = tell.send(());
            }
        });
        FolderChanges { watcher: watcher.ok(), folders: BTreeSet::new(), heard }
    }

    /// Listens to the folders of these files, and of those to which links lead, and to no others.
    pub fn follow(&mut self, files: &[PathBuf]) {
        let Some(watcher) = &mut self.watcher else { return };
        let wanted: BTreeSet<PathBuf> = files
            .iter()
            .flat_map(|file| [folder(file), file.canonicalize().ok().and_then(|place| folder(&place))])
            .flatten()
            .collect();
        // A folder that went away, or that the system cannot follow, is left to the clock.
        self.folders.difference(&wanted).for_each(|folder| drop(watcher.unwatch(folder)));
        let followed = |folder: &&PathBuf| {
            self.folders.contains(*folder) || watcher.watch(folder, RecursiveMode::NonRecursive).is_ok()
        };
        self.folders = wanted.iter().filter(followed).cloned().collect();
    }

    /// Until something changes, or the time is over.
    pub fn wait(&self, longest: Duration) {
        match self.heard.recv_timeout(longest) {
            // All that has happened is looked at together.
            Ok(()) => while self.heard.try_recv().is_ok() {},
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => std::thread::sleep(longest),
        }
    }
}

fn folder(file: &Path) -> Option<PathBuf> {
    let folder = file.parent()?;
    Some(if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Far longer than any machine needs: whoever waits so long has heard nothing.
    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn a_file_that_is_written_replaced_or_removed_is_heard_of() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        let mut changes = FolderChanges::new();
        changes.follow(std::slice::from_ref(&file));
        assert_eq!(changes.folders.len(), if changes.watcher.is_some() { 1 } else { 0 });
        let other = folder.path().join("other");
        let steps: [&dyn Fn(); 4] = [
            &|| std::fs::write(&file, "a").unwrap(),
            &|| std::fs::write(&other, "b").unwrap(),
            &|| std::fs::rename(&other, &file).unwrap(),
            &|| std::fs::remove_file(&file).unwrap(),
        ];
        for step in steps {
            step();
            let begin = std::time::Instant::now();
            changes.wait(LONG);
            assert!(changes.watcher.is_none() || begin.elapsed() < LONG, "nothing was heard");
        }
    }

    #[test]
    fn folders_that_are_not_there_do_no_harm_and_those_of_other_files_are_left() {
        let folder = tempfile::tempdir().unwrap();
        let mut changes = FolderChanges::new();
        changes.follow(&[folder.path().join("nowhere/scene.toml")]);
        assert!(changes.folders.is_empty());
        changes.follow(&[folder.path().join("scene.toml"), PathBuf::from("part.toml")]);
        changes.follow(&[folder.path().join("scene.toml")]);
        assert!(changes.folders.len() <= 1);
    }
}
