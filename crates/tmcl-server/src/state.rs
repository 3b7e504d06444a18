//! Where modules keep their EEPROMs while no process has them: a file each, `NAME.eeprom`, in a folder.
//!
//! A file is an image ([`Eeprom::to_image`]), and every byte write goes to it in order, before the reply that acknowledges it
//! leaves. So a process that is killed leaves what a power cut leaves. Nothing is forced to the disk before the end: what the
//! machine has not written when it crashes itself is lost.

mod file;
mod lock;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use virtual_bench::config::ModuleConfig;
use virtual_bench::eeprom::ImageError;
use virtual_bench::{Bench, BenchConfig, Eeprom, ModuleId};

use file::{StateFile, create};

/// What the name of an image ends in.
const ENDING: &str = "eeprom";

/// How often an image that somebody may be writing is read until it is believed to be damaged.
const READS: u32 = 3;

/// Why modules cannot keep their EEPROMs in a folder.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The folder cannot be made or read.
    #[error("cannot use the folder {0}: {1}")]
    Folder(PathBuf, #[source] io::Error),
    /// A file cannot be made, read or moved.
    #[error("cannot use {0}: {1}")]
    File(PathBuf, #[source] io::Error),
    /// Another process has it.
    #[error("{0} is in use by another process; end that, or name another folder")]
    InUse(PathBuf),
    /// It may be as good as ever, but nobody here can read it.
    #[error("cannot use {0}: {1}; name another folder")]
    Foreign(PathBuf, #[source] ImageError),
    /// It belongs to a module of another kind.
    #[error(
        "{path} is the EEPROM of a {found}, and \"{name}\" is a {wanted}; name another folder, or the module otherwise"
    )]
    OtherModule {
        /// The file.
        path: PathBuf,
        /// The module's name on the bench.
        name: String,
        /// The kind of module that the file belongs to.
        found: &'static str,
        /// The kind of module on the bench.
        wanted: &'static str,
    },
}

/// An image that was damaged. The module starts with factory settings.
#[derive(Debug)]
pub struct SetAside {
    /// The module's name.
    pub name: String,
    /// Where the image was.
    pub from: PathBuf,
    /// Where it is now.
    pub to: PathBuf,
    /// What is wrong with it.
    pub error: ImageError,
}

/// What a module's EEPROM has been through.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wear {
    /// The module's name.
    pub name: String,
    /// Byte writes since the file was opened.
    pub writes_now: u64,
    /// Byte writes since the EEPROM was new.
    pub writes: u64,
    /// Byte writes in its most worn page.
    pub most_worn: u32,
}

/// The files of the modules of a bench.
#[derive(Debug)]
pub struct State {
    files: Vec<StateFile>,
    /// Whether the last attempt to write failed.
    failing: bool,
}

impl State {
    /// Opens the files of all modules, and makes those that are missing. Returns their EEPROMs too, in the order of the
    /// modules, and which images had to be set aside.
    ///
    /// # Errors
    /// [`StateError`] when there is no using them; nothing was changed then but that folder and new files were made.
    pub fn open(
        folder: &Path,
        config: &BenchConfig,
    ) -> Result<(Self, Vec<Eeprom>, Vec<SetAside>), StateError> {
        let in_folder = |error| StateError::Folder(folder.to_owned(), error);
        fs::create_dir_all(folder).map_err(in_folder)?;
        // Whoever else opens or makes files here waits until we are done.
        let folder_lock = File::open(folder).and_then(|file| lock::wait(&file).map(|()| file));
        let _folder_lock = folder_lock.map_err(in_folder)?;
        let mut state = Self { files: Vec::new(), failing: false };
        let (mut eeproms, mut set_aside) = (Vec::new(), Vec::new());
        // Whatever is refused is refused before anything is moved or made.
        let found =
            config.modules.iter().map(|module| Found::look(folder, module)).collect::<Result<Vec<_>, _>>()?;
        for found in found {
            let (file, eeprom, aside) = found.settle()?;
            state.files.push(file);
            eeproms.push(eeprom);
            set_aside.extend(aside);
        }
        Ok((state, eeproms, set_aside))
    }

    /// Writes what the EEPROMs of `bench`, made with those that [`State::open`] gave, took since it was called last. Costs next
    /// to nothing when there is nothing.
    ///
    /// # Errors
    /// When a file takes no more, the first time. What was not written is tried again with the next calls; of what is stored until
    /// then, the newest counts.
    pub fn save(&mut self, bench: &mut Bench) -> Result<(), StateError> {
        let mut result = Ok(());
        for (index, file) in self.files.iter_mut().enumerate() {
            if let Some(eeprom) = bench.eeprom_mut(ModuleId(index)) {
                result = result.and(file.save(eeprom));
            }
        }
        let is_new = !std::mem::replace(&mut self.failing, result.is_err());
        if is_new { result } else { Ok(()) }
    }

    /// [`State::save`], and everything on the disk.
    ///
    /// # Errors
    /// When something could not be written; then it is lost.
    pub fn finish(&mut self, bench: &mut Bench) -> Result<(), StateError> {
        let mut result = Ok(());
        for (index, file) in self.files.iter_mut().enumerate() {
            if let Some(eeprom) = bench.eeprom_mut(ModuleId(index)) {
                result = result.and(file.finish(eeprom));
            }
        }
        result
    }

    /// How worn the EEPROMs are.
    pub fn wear(&self, bench: &Bench) -> Vec<Wear> {
        let files = self.files.iter().enumerate();
        let wear = files.filter_map(|(index, file)| {
            let eeprom = bench.eeprom(ModuleId(index))?;
            let name = bench.name(ModuleId(index))?.to_owned();
            let writes = eeprom.writes();
            let (_, most_worn) = eeprom.most_worn();
            Some(Wear { name, writes_now: writes.saturating_sub(file.writes_before()), writes, most_worn })
        });
        wear.collect()
    }
}

/// What there is where a module's file belongs.
struct Found<'a> {
    module: &'a ModuleConfig,
    path: PathBuf,
    file: Option<(File, Result<Eeprom, ImageError>)>,
}

impl<'a> Found<'a> {
    /// Changes nothing.
    fn look(folder: &Path, module: &'a ModuleConfig) -> Result<Self, StateError> {
        let path = folder.join(format!("{}.{ENDING}", module.name));
        match File::options().read(true).write(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self { module, path, file: None }),
            Err(error) => Err(StateError::File(path, error)),
            Ok(mut file) => {
                let image = read_module(&mut file, &path, module)?;
                Ok(Self { module, path, file: Some((file, image)) })
            }
        }
    }

    /// The module's file: what was found, or a new one.
    fn settle(self) -> Result<(StateFile, Eeprom, Option<SetAside>), StateError> {
        let Self { module, path, file } = self;
        let in_file = |error| StateError::File(path.clone(), error);
        let mut set_aside = None;
        let (file, mut eeprom) = match file {
            Some((file, Ok(eeprom))) => (file, eeprom),
            other => {
                if let Some((_, Err(error))) = other {
                    let to = free_name(&path);
                    fs::rename(&path, &to).map_err(in_file)?;
                    set_aside = Some(SetAside { name: module.name.clone(), from: path.clone(), to, error });
                }
                let eeprom = Eeprom::new(module.kind);
                (create(&path, &eeprom.to_image()).map_err(in_file)?, eeprom)
            }
        };
        Ok((StateFile::new(path, file, &mut eeprom), eeprom, set_aside))
    }
}

/// The EEPROM in a module's file, or what is wrong with the image.
fn read_module(
    file: &mut File,
    path: &Path,
    module: &ModuleConfig,
) -> Result<Result<Eeprom, ImageError>, StateError> {
    let in_file = |error| StateError::File(path.to_owned(), error);
    if !lock::try_now(file).map_err(in_file)? {
        return Err(StateError::InUse(path.to_owned()));
    }
    let mut image = Vec::new();
    file.read_to_end(&mut image).map_err(in_file)?;
    match Eeprom::from_image(&image) {
        Err(error) if error.is_foreign() => Err(StateError::Foreign(path.to_owned(), error)),
        Ok(eeprom) if eeprom.kind() != module.kind => Err(StateError::OtherModule {
            path: path.to_owned(),
            name: module.name.clone(),
            found: eeprom.kind().spec().id,
            wanted: module.kind.spec().id,
        }),
        read => Ok(read),
    }
}

/// `NAME.eeprom.corrupt`, or `.corrupt.1` and so on where there are such already.
fn free_name(path: &Path) -> PathBuf {
    let names = (0_u32..).map(|number| match number {
        0 => path.with_extension(format!("{ENDING}.corrupt")),
        number => path.with_extension(format!("{ENDING}.corrupt.{number}")),
    });
    let mut free = names.filter(|name| name.symlink_metadata().is_err());
    free.next().unwrap_or_else(|| path.with_extension(format!("{ENDING}.corrupt")))
}

/// The images in a folder, by their names; or the one file that `path` names.
///
/// # Errors
/// [`StateError`] when the path cannot be read.
pub fn images(path: &Path) -> Result<Vec<PathBuf>, StateError> {
    if path.is_file() {
        return Ok(vec![path.to_owned()]);
    }
    let in_folder = |error| StateError::Folder(path.to_owned(), error);
    let entries = fs::read_dir(path).and_then(Iterator::collect::<io::Result<Vec<_>>>).map_err(in_folder)?;
    let paths = entries.into_iter().map(|entry| entry.path());
    let mut images: Vec<_> =
        paths.filter(|path| path.extension().is_some_and(|ending| ending == ENDING)).collect();
    images.sort();
    Ok(images)
}

/// The image in a file, which a server may be writing meanwhile.
///
/// # Errors
/// [`StateError`] when it cannot be read; what is wrong with the image is no such error.
pub fn read_image(path: &Path) -> Result<Result<Eeprom, ImageError>, StateError> {
    let read = || -> Result<Result<Eeprom, ImageError>, StateError> {
        let image = fs::read(path).map_err(|error| StateError::File(path.to_owned(), error))?;
        Ok(Eeprom::from_image(&image))
    };
    let mut found = read()?;
    for _ in 1..READS {
        if found.is_ok() {
            break;
        }
        // A slot may have been read half before and half after a write.
        found = read()?;
    }
    Ok(found)
}
