//! One module's file, which nobody else writes while it is open.
//!
//! What a file does not take is kept and tried again, in order, so that the file is always what a power cut leaves. Once that is
//! more than an image, the image itself is less: a new file with what the EEPROM holds by then takes the place of the old one, whole
//! or not at all.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use virtual_bench::Eeprom;
use virtual_bench::eeprom::{IMAGE_LENGTH, Patch};

use super::{ENDING, StateError, lock};

/// How long to wait before a whole image is tried again.
const AGAIN: Duration = Duration::from_secs(1);

/// A file, and what it did not take yet.
#[derive(Debug)]
pub(super) struct StateFile {
    path: PathBuf,
    file: File,
    writes_before: u64,
    pending: Pending,
}

/// What is still to be written.
#[derive(Debug)]
enum Pending {
    /// These, in order, and the memory that they take.
    Patches(VecDeque<Patch>, usize),
    /// All that the EEPROM holds; and when that was tried last, and why it failed.
    Image(Option<(Instant, io::ErrorKind)>),
}

impl Pending {
    fn nothing() -> Self {
        Self::Patches(VecDeque::new(), 0)
    }

    /// No more than an image is kept.
    fn extend(&mut self, patches: Vec<Patch>) {
        let Self::Patches(kept, size) = self else { return };
        *size += patches.iter().map(size_of).sum::<usize>();
        kept.extend(patches);
        if *size > IMAGE_LENGTH {
            *self = Self::Image(None);
        }
    }
}

fn size_of(patch: &Patch) -> usize {
    size_of_val(patch) + patch.bytes.len()
}

impl StateFile {
    /// `file` is open at `path`, and holds what `eeprom` does. Notes from now on what is written to that.
    pub(super) fn new(path: PathBuf, file: File, eeprom: &mut Eeprom) -> Self {
        eeprom.note_patches();
        Self { path, file, writes_before: eeprom.writes(), pending: Pending::nothing() }
    }

    /// How many byte writes the EEPROM had seen when the file was opened.
    pub(super) fn writes_before(&self) -> u64 {
        self.writes_before
    }

    /// Writes what the EEPROM took, and what could not be written before.
    ///
    /// # Errors
    /// [`StateError::File`] while something is left to be written.
    pub(super) fn save(&mut self, eeprom: &mut Eeprom) -> Result<(), StateError> {
        if eeprom.has_patches() {
            self.pending.extend(eeprom.take_patches());
        }
        let written = match &mut self.pending {
            Pending::Patches(patches, size) => write_all(&mut self.file, patches, size),
            Pending::Image(Some((tried, kind))) if tried.elapsed() < AGAIN => Err((*kind).into()),
            Pending::Image(failed) => match renew(&self.path, eeprom) {
                Ok(file) => {
                    self.file = file;
                    self.pending = Pending::nothing();
                    Ok(())
                }
                Err(error) => {
                    *failed = Some((Instant::now(), error.kind()));
                    Err(error)
                }
            },
        };
        written.map_err(|error| StateError::File(self.path.clone(), error))
    }

    /// [`StateFile::save`] without patience, and everything on the disk.
    ///
    /// # Errors
    /// [`StateError::File`] when something could not be written.
    pub(super) fn finish(&mut self, eeprom: &mut Eeprom) -> Result<(), StateError> {
        if let Pending::Image(failed) = &mut self.pending {
            *failed = None;
        }
        self.save(eeprom)?;
        self.file.sync_all().map_err(|error| StateError::File(self.path.clone(), error))
    }
}

/// Writes patches until the file takes no more. One that fails is written again from its beginning.
fn write_all(file: &mut File, patches: &mut VecDeque<Patch>, size: &mut usize) -> io::Result<()> {
    while let Some(patch) = patches.front() {
        write_at(file, patch)?;
        *size = size.saturating_sub(size_of(patch));
        patches.pop_front();
    }
    Ok(())
}

fn write_at(file: &mut File, patch: &Patch) -> io::Result<()> {
    file.seek(SeekFrom::Start(u64::try_from(patch.offset).map_err(io::Error::other)?))?;
    file.write_all(&patch.bytes)
}

/// A new file in the place of the old one. Whoever looks for files meanwhile finds the one or the other, locked.
fn renew(path: &Path, eeprom: &Eeprom) -> io::Result<File> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = File::open(folder.unwrap_or(Path::new(".")))?;
    lock::wait(&folder)?;
    create(path, &eeprom.to_image())
}

/// A new file of this name is there whole or not at all.
pub(super) fn create(path: &Path, image: &[u8]) -> io::Result<File> {
    let new = path.with_extension(format!("{ENDING}.new"));
    let created = fill(&new, image).and_then(|file| fs::rename(&new, path).map(|()| file));
    if created.is_err() {
        // It takes room that is needed, and says nothing.
        let _ = fs::remove_file(&new);
    }
    created
}

fn fill(path: &Path, image: &[u8]) -> io::Result<File> {
    let mut file = File::options().read(true).write(true).create(true).truncate(true).open(path)?;
    file.write_all(image)?;
    file.sync_all()?;
    // Nobody can have it yet: we have the folder.
    lock::try_now(&file)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use virtual_bench::{ModuleKind, RecordKey, Storage};

    use super::*;

    /// A folder that is gone when the test is.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("tmcl-server-{}-{name}", std::process::id()));
            fs::create_dir_all(&path).expect("there is room for a folder");
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    /// An EEPROM in a file that takes nothing, since it is open for reading only.
    fn stuck(path: &Path) -> (StateFile, Eeprom) {
        let mut eeprom = Eeprom::new(ModuleKind::Tmcm1311);
        fs::write(path, eeprom.to_image()).expect("the folder takes it");
        let file = StateFile::new(path.to_owned(), File::open(path).expect("it is there"), &mut eeprom);
        (file, eeprom)
    }

    fn store(eeprom: &mut Eeprom, value: i32) {
        eeprom.write(RecordKey::Axis(4), &value.to_le_bytes()).expect("there is room");
    }

    fn kept(file: &StateFile) -> Option<usize> {
        match &file.pending {
            Pending::Patches(patches, size) => {
                assert_eq!(*size, patches.iter().map(size_of).sum());
                Some(*size)
            }
            Pending::Image(_) => None,
        }
    }

    #[test]
    fn what_a_file_does_not_take_is_written_once_it_does() {
        let folder = Folder::new("later");
        let path = folder.0.join("m.eeprom");
        let (mut file, mut eeprom) = stuck(&path);
        let new = fs::read(&path).expect("it is there");
        for value in 0..10 {
            store(&mut eeprom, value);
            assert!(matches!(file.save(&mut eeprom), Err(StateError::File(..))));
        }
        assert!(kept(&file).is_some_and(|size| size > 0));
        assert_eq!(fs::read(&path).expect("it is there"), new);
        file.file = File::options().write(true).open(&path).expect("it is there");
        file.save(&mut eeprom).expect("it takes it now");
        assert_eq!(kept(&file), Some(0));
        assert_eq!(fs::read(&path).expect("it is there"), eeprom.to_image());
    }

    #[test]
    fn no_more_than_an_image_is_kept_and_the_newest_is_written_whole() {
        let folder = Folder::new("whole");
        let (before, path) = (folder.0.join("m.eeprom"), folder.0.join("away/m.eeprom"));
        let (mut file, mut eeprom) = stuck(&before);
        file.path.clone_from(&path);
        let mut stores = 0;
        while let Some(size) = kept(&file) {
            assert!(size <= IMAGE_LENGTH);
            stores += 1;
            store(&mut eeprom, stores);
            file.save(&mut eeprom).expect_err("it takes nothing");
        }
        assert!(stores > 100, "{stores}");
        // There is no folder for the new file either; what is stored now is not kept apart from the EEPROM.
        store(&mut eeprom, -1);
        file.save(&mut eeprom).expect_err("it takes nothing");
        assert!(!eeprom.has_patches());
        fs::create_dir(folder.0.join("away")).expect("there is room for a folder");
        file.finish(&mut eeprom).expect("it takes it now");
        assert_eq!(fs::read(&path).expect("it is there"), eeprom.to_image());
        // And it goes on from there.
        store(&mut eeprom, -2);
        file.save(&mut eeprom).expect("it takes it");
        assert_eq!(kept(&file), Some(0));
        assert_eq!(fs::read(&path).expect("it is there"), eeprom.to_image());
        let names = fs::read_dir(folder.0.join("away")).expect("it is there").count();
        assert_eq!(names, 1, "nothing is left lying about");
    }
}
