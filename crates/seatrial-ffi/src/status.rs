//! What a call answers.

use core::ffi::c_char;

use seatrial_core::InvalidSetting;

/// What became of a call.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum SeatrialStatus {
    /// Done.
    Ok = 0,
    /// A pointer is null.
    NullPointer = 1,
    /// The memory is smaller than the object.
    WrongSize = 2,
    /// A pointer is not aligned for what it points to.
    Misaligned = 3,
    /// There is no such object at this address.
    NotMade = 4,
    /// A setting is out of range; SeatrialFault says which.
    InvalidSetting = 5,
    /// The sample is no number, or does not follow on the one before; nothing was learnt from it.
    Refused = 6,
    /// No event is waiting.
    NoEvent = 7,
    /// The model is unstable on course: no gain, no steady turn.
    CourseUnstable = 8,
    /// The rudder does not turn the vehicle, or not to this side.
    NoAuthority = 9,
    /// Outside the schedule's range, and not to be extrapolated, or not so far.
    OutsideRange = 10,
    /// No schedule can be made of these points.
    InvalidSchedule = 11,
    /// The library is of another ABI, or its numbers are of another size.
    WrongLibrary = 12,
}

/// Which setting is out of range, and what it has to be: texts that live as long as the program, not ended by a zero.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SeatrialFault {
    /// The field.
    pub field: *const c_char,
    /// Its length.
    pub field_length: usize,
    /// What it has to be.
    pub requirement: *const c_char,
    /// Its length.
    pub requirement_length: usize,
}

impl From<InvalidSetting> for SeatrialFault {
    fn from(setting: InvalidSetting) -> Self {
        Self {
            field: setting.field.as_ptr().cast(),
            field_length: setting.field.len(),
            requirement: setting.requirement.as_ptr().cast(),
            requirement_length: setting.requirement.len(),
        }
    }
}

/// A status as a text, ended by a zero; that of an unknown number, too.
#[unsafe(no_mangle)]
pub extern "C" fn seatrial_status_text(status: u32) -> *const c_char {
    let text = match status {
        0 => c"done",
        1 => c"a pointer is null",
        2 => c"the memory is smaller than the object",
        3 => c"a pointer is not aligned",
        4 => c"there is no such object at this address",
        5 => c"a setting is out of range",
        6 => c"the sample is no number or does not follow on the one before",
        7 => c"no event is waiting",
        8 => c"the model is unstable on course",
        9 => c"the rudder does not turn the vehicle to this side",
        10 => c"outside the range of the schedule",
        11 => c"no schedule can be made of these points",
        12 => c"the library is of another ABI, or its numbers are of another size",
        _ => c"unknown status",
    };
    text.as_ptr()
}
