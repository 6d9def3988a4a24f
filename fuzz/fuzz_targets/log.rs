//! Logs of the format that `FORMAT` names: `FORMAT=ulog target/release/log corpus/ulog`.
#![no_main]

use std::sync::LazyLock;

use seatrial_fuzz::seeds::FORMATS;

static FORMAT: LazyLock<&(&str, &[u8])> = LazyLock::new(|| {
    let name = std::env::var("FORMAT").unwrap_or_default();
    let names: Vec<&str> = FORMATS.iter().map(|(name, _)| *name).collect();
    let found = FORMATS.iter().find(|(known, _)| *known == name);
    found.unwrap_or_else(|| panic!("FORMAT={name}: expected one of {names:?}"))
});

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant(FORMAT.0, FORMAT.1),
    |data: &[u8]| seatrial_fuzz::read(FORMAT.1, data)
);
