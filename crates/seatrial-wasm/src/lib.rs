#![doc = include_str!("../README.md")]

mod page_file;
mod request;
mod simulated;

use std::sync::{Mutex, MutexGuard, PoisonError};

use seatrial_logs::FileMap;

use page_file::PageFile;
pub use request::{Request, answer};

/// What passes between a page and this module.
struct Exchange {
    inbox: Vec<u8>,
    outbox: Vec<u8>,
    files: FileMap,
}

static EXCHANGE: Mutex<Option<Exchange>> = Mutex::new(None);

fn with_exchange<T>(work: impl FnOnce(&mut Exchange) -> T) -> T {
    let mut exchange: MutexGuard<Option<Exchange>> =
        EXCHANGE.lock().unwrap_or_else(PoisonError::into_inner);
    work(exchange.get_or_insert_with(|| Exchange {
        inbox: Vec::new(),
        outbox: Vec::new(),
        files: FileMap::default(),
    }))
}

/// Makes room for a message of this many bytes; the address of the room.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn inbox(length: usize) -> *mut u8 {
    with_exchange(|exchange| {
        exchange.inbox.clear();
        exchange.inbox.resize(length, 0);
        exchange.inbox.as_mut_ptr()
    })
}

/// Holds a file of the page: the message is its name of so many bytes and, where the page knows it, the SHA-256 of the file; its number is
/// that by which the page is asked for its bytes, of which there are `length`.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn hold(number: u32, length: f64, name_length: usize) {
    with_exchange(|exchange| {
        let message = std::mem::take(&mut exchange.inbox);
        let (name, sha256) = message.split_at(name_length.min(message.len()));
        let file = PageFile::new(number, length, sha256.try_into().ok());
        let name = String::from_utf8_lossy(name).into_owned();
        exchange.files.insert(name, file);
    });
}

/// Answers the message; the number of bytes of the answer.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> usize {
    std::panic::set_hook(Box::new(|panic| {
        // Whoever panics holds the exchange, so what is said of it has a place of its own.
        if let Ok(mut said) = PANIC.lock() {
            *said = panic.to_string().into_bytes();
        }
    }));
    with_exchange(|exchange| {
        let message = std::mem::take(&mut exchange.inbox);
        exchange.outbox = answer(&message, &mut exchange.files).into_bytes();
        exchange.outbox.len()
    })
}

static PANIC: Mutex<Vec<u8>> = Mutex::new(Vec::new());

/// The address of the answer.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn outbox() -> *const u8 {
    with_exchange(|exchange| exchange.outbox.as_ptr())
}

/// After a trap: the number of bytes of what was said of it.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn broken() -> usize {
    PANIC.lock().map_or(0, |said| said.len())
}

/// The address of what was said of a trap.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn broken_text() -> *const u8 {
    PANIC.lock().map_or(std::ptr::null(), |said| said.as_ptr())
}
