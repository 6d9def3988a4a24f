#![no_main]

const START: &[u8] = &[0xa3, 0x95, 0x80];

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("dataflash", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
