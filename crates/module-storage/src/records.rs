//! Records by key in NOR flash.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use module_firmware::StorageError;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use crate::blocking::{Blocking, now};

/// Key and value, rounded up to the flash's words, in bytes.
const BUFFER: usize = 32;

type Key = u16;
type Map<F> = MapStorage<Key, Blocking<F>, Cache<Uncached, Uncached, Uncached, Key>>;

/// Records in some pages of a flash.
pub(crate) struct Records<F: NorFlash>(Map<F>);

impl<F: NorFlash> Records<F> {
    pub(crate) fn new(flash: F, pages: Range<u32>) -> Result<Self, StorageError> {
        let config = MapConfig::try_new(pages).map_err(|_| StorageError::Full)?;
        Ok(Self(MapStorage::new(Blocking(flash), config, Cache::new_uncached())))
    }

    pub(crate) fn read(&mut self, key: Key, out: &mut [u8]) -> Result<usize, StorageError> {
        let mut buffer = Buffer::default();
        let record = now(self.0.fetch_item::<&[u8]>(&mut buffer.0, &key)).map_err(|error| failure(&error))?;
        let Some(record) = record else { return Ok(0) };
        let target = out.get_mut(..record.len()).ok_or(StorageError::Medium)?;
        target.copy_from_slice(record);
        Ok(record.len())
    }

    pub(crate) fn write(&mut self, key: Key, value: &[u8]) -> Result<(), StorageError> {
        let mut buffer = Buffer::default();
        now(self.0.store_item(&mut buffer.0, &key, &value)).map_err(|error| failure(&error))
    }

    pub(crate) fn erase(&mut self) -> Result<(), StorageError> {
        now(self.0.erase_all()).map_err(|error| failure(&error))
    }

    pub(crate) fn into_flash(self) -> F {
        self.0.destroy().0.0
    }
}

/// Some flashes want to be read and written from words.
#[derive(Default)]
#[repr(align(4))]
struct Buffer([u8; BUFFER]);

fn failure<E>(error: &Error<E>) -> StorageError {
    match error {
        Error::FullStorage | Error::ItemTooBig | Error::BufferTooBig | Error::BufferTooSmall(_) => {
            StorageError::Full
        }
        _ => StorageError::Medium,
    }
}
