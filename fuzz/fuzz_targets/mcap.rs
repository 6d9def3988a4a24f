#![no_main]

const START: &[u8] = b"\x89MCAP0\r\n";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("mcap", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
