//! What every target does: give a reader the bytes of a file and hold it to its limits of time and memory.

#[path = "../../crates/seatrial-logs/tests/seeds/mod.rs"]
pub mod seeds;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use seatrial_logs::{ChannelChoice, open};

/// A reader may hold 64 MB and twice its input.
const MOST_BYTES: usize = 64 << 20;
/// A reader may take 1 s, and 1 s for every MB of its input.
const MOST_TIME: Duration = Duration::from_secs(1);

static HELD: AtomicUsize = AtomicUsize::new(0);
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Counts what is held, and ends the program over the limit.
struct Bounded;

impl Bounded {
    fn takes(bytes: usize) {
        let held = HELD.fetch_add(bytes, Ordering::Relaxed) + bytes;
        if held > LIMIT.load(Ordering::Relaxed) {
            LIMIT.store(usize::MAX, Ordering::Relaxed);
            eprintln!("{held} bytes are held: a length was trusted");
            std::process::abort();
        }
    }
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::takes(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Self::takes(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::takes(size);
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

thread_local! {
    static LOG: RefCell<PathBuf> = {
        let memory = PathBuf::from("/dev/shm");
        let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
        RefCell::new(folder.join(format!("seatrial-fuzz-{}", std::process::id())))
    };
}

/// Writes the seeds of a target to its corpus, without the bytes that it puts before every input.
pub fn plant(target: &str, start: &[u8]) {
    for (number, log) in seeds::of(target).iter().enumerate() {
        for option in 0..2 {
            let input = [&[option][..], &log[start.len()..]].concat();
            plant_seed(target, 2 * number + usize::from(option), input);
        }
    }
}

/// Writes a seed of a target to its corpus.
pub fn plant_seed(target: &str, number: usize, input: Vec<u8>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target);
    std::fs::create_dir_all(&folder).expect("a folder for seeds");
    std::fs::write(folder.join(format!("seed-{number}")), input).expect("a folder for seeds");
}

/// Time that this thread had a processor: on a busy machine the others' time does not count.
fn processor_time() -> Duration {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the clock exists and the time is a valid place for it.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Reads a log of these bytes to its end. The first decides whether invalid rows are left out.
pub fn read(start: &[u8], data: &[u8]) {
    static QUIET: Once = Once::new();
    // Panics of libraries that the readers catch are no findings; those that get out end the program.
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let (option, data) = data.split_first().unwrap_or((&0, &[]));
    let length = start.len() + data.len();
    LOG.with_borrow(|path| {
        let mut bytes = Vec::with_capacity(length);
        bytes.extend_from_slice(start);
        bytes.extend_from_slice(data);
        std::fs::write(path, &bytes).expect("a folder for logs");
        drop(bytes);
        let mut choice = ChannelChoice::default();
        choice.drop_invalid = option & 1 == 1;
        let most = HELD.load(Ordering::Relaxed) + MOST_BYTES + 2 * length;
        LIMIT.store(most, Ordering::Relaxed);
        let begun = processor_time();
        match open(path, &choice) {
            Ok(mut reader) => {
                for sample in reader.by_ref().map_while(Result::ok) {
                    assert!(sample.time_s.is_finite() && sample.rudder_rad.is_finite());
                }
                assert!(reader.counts().rows >= reader.counts().samples);
                let _ = reader.warnings();
                reader.sha256().expect("a readable file");
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
        let taken = processor_time() - begun;
        LIMIT.store(usize::MAX, Ordering::Relaxed);
        let most = MOST_TIME.mul_f64(1.0 + length as f64 / 1e6);
        assert!(taken < most, "{length} bytes took {taken:?}");
    });
}
