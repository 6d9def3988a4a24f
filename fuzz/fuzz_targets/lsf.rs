#![no_main]

const START: &[u8] = b"\x54\xfe";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("lsf", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
