#![no_main]

use seatrial_fuzz::seeds::{ARRIVAL_US, MAVLINK, tlog_frame};

// Checksums are hard to guess: half the inputs become sound frames, the others are taken as they are.
libfuzzer_sys::fuzz_target!(init: seatrial_fuzz::plant("tlog", b""), |data: &[u8]| {
    let start = tlog_frame(ARRIVAL_US, true, MAVLINK[0], &[0, 0, 0, 0, 11, 3, 0, 4, 3]);
    let Some((option, mut rest)) = data.split_first().filter(|(option, _)| **option & 2 != 0) else {
        return seatrial_fuzz::read(&start, data);
    };
    let mut log = vec![*option];
    while let [kind, length, payload @ ..] = rest {
        let (payload, behind) = payload.split_at(usize::from(*length).min(payload.len()));
        let message = MAVLINK[usize::from(*kind) % MAVLINK.len()];
        log.extend(tlog_frame(ARRIVAL_US, kind & 0x80 != 0, message, payload));
        rest = behind;
    }
    seatrial_fuzz::read(&start, &log);
});
