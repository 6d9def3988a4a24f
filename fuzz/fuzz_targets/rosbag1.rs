#![no_main]

const START: &[u8] = b"#ROSBAG V2.0\n";

libfuzzer_sys::fuzz_target!(
    init: seatrial_fuzz::plant("rosbag1", START),
    |data: &[u8]| seatrial_fuzz::read(START, data)
);
