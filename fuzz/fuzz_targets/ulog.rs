#![no_main]

const START: &[u8] = b"ULog\x01\x12\x35";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("ulog", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
