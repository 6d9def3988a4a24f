#![no_main]

const START: &[u8] = b"PAR1";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("parquet", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
