#![no_main]

const START: &[u8] = b"PK\x03\x04";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("xlsx", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
