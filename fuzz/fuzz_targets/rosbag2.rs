#![no_main]

const START: &[u8] = b"SQLite format 3\0";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("rosbag2", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
