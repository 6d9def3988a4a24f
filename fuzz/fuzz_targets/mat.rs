#![no_main]

const START: &[u8] = b"MATLAB 5.0 MAT-file";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("mat", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
