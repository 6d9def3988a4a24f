//! A file that the page holds: its bytes are fetched where a reader wants them, and never stand in the module's memory as a whole.

use std::io;

use seatrial_logs::Source;

/// A file by the number that the page gave it.
pub struct PageFile {
    number: u32,
    length: u64,
    sha256: Option<[u8; 32]>,
}

impl PageFile {
    /// A file of so many bytes, with its check sum where the page knows it.
    pub fn new(number: u32, length: f64, sha256: Option<[u8; 32]>) -> Self {
        Self { number, length: length as u64, sha256 }
    }
}

impl Source for PageFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, position: u64, buffer: &mut [u8]) -> io::Result<usize> {
        usize::try_from(fetched(self.number, position as f64, buffer)).map_err(|_| {
            io::Error::other("it was changed or removed since it was chosen; choose it again")
        })
    }

    fn sha256(&self) -> Option<[u8; 32]> {
        self.sha256
    }
}

/// Asks the page for bytes of a file; how many there are, negative where it cannot be read.
#[cfg(target_arch = "wasm32")]
#[allow(unsafe_code)]
fn fetched(number: u32, position: f64, buffer: &mut [u8]) -> i32 {
    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        fn read(number: u32, position: f64, address: *mut u8, length: usize) -> i32;
    }
    // SAFETY: the page writes no more than `length` bytes at `address`, which are those of the buffer.
    unsafe { read(number, position, buffer.as_mut_ptr(), buffer.len()) }
}

/// Elsewhere there is no page.
#[cfg(not(target_arch = "wasm32"))]
fn fetched(_: u32, _: f64, _: &mut [u8]) -> i32 {
    -1
}
