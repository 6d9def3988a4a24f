#![no_main]

const START: &[u8] = b"{";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("signal_k", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
