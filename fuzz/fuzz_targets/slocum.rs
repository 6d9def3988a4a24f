#![no_main]

const START: &[u8] = b"dbd_label:";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("slocum", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
