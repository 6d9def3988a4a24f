//! Objects in the caller's memory, and values that pass through pointers. Nothing is read or written before the
//! pointer is known not to be null and to be aligned; that it points where the caller says only the caller knows.

use core::ffi::c_void;

use seatrial_core::InvalidSetting;

use crate::status::{SeatrialFault, SeatrialStatus};

/// What C calls an object: its kind, then the core's own.
pub struct Object<C> {
    tag: u32,
    content: C,
}

/// A kind of object.
pub trait Kind {
    /// Four letters that no uninitialised memory is likely to hold.
    const TAG: u32;
}

pub type Outcome<V> = Result<V, SeatrialStatus>;

/// The status of an outcome that has no value.
pub fn status(outcome: Outcome<()>) -> SeatrialStatus {
    match outcome {
        Ok(()) => SeatrialStatus::Ok,
        Err(status) => status,
    }
}

fn sound<V>(pointer: *const V) -> Outcome<()> {
    if pointer.is_null() {
        Err(SeatrialStatus::NullPointer)
    } else if !pointer.is_aligned() {
        Err(SeatrialStatus::Misaligned)
    } else {
        Ok(())
    }
}

/// Makes an object in memory of the caller.
///
/// # Safety
/// `memory` is null or `size` bytes of the caller's, `object` null or the caller's.
pub unsafe fn place<C: Kind>(
    memory: *mut c_void,
    size: usize,
    content: C,
    object: *mut *mut Object<C>,
) -> Outcome<()> {
    let place = memory.cast::<Object<C>>();
    sound(place)?;
    sound(object)?;
    if size < size_of::<Object<C>>() {
        return Err(SeatrialStatus::WrongSize);
    }
    let tag = C::TAG;
    // SAFETY: not null, aligned, large enough, the caller's.
    unsafe {
        place.write(Object { tag, content });
        object.write(place);
    }
    Ok(())
}

/// The object at an address.
///
/// # Safety
/// `object` is null or what [`place`] returned, still valid and not used elsewhere meanwhile.
pub unsafe fn reach<'a, C: Kind>(object: *mut Object<C>) -> Outcome<&'a mut C> {
    sound(object)?;
    // SAFETY: not null, aligned, the caller's; any bits are a tag.
    if unsafe { (&raw const (*object).tag).read() } != C::TAG {
        return Err(SeatrialStatus::NotMade);
    }
    // SAFETY: and an object of this kind.
    Ok(unsafe { &mut (*object).content })
}

/// Reads a value of numbers only, for which any bits are good.
///
/// # Safety
/// `pointer` is null or the caller's.
pub unsafe fn take<V: Copy>(pointer: *const V) -> Outcome<V> {
    sound(pointer)?;
    // SAFETY: not null, aligned, the caller's.
    Ok(unsafe { pointer.read() })
}

/// The values at an address, of numbers only.
///
/// # Safety
/// `pointer` is null or `count` values of the caller's.
pub unsafe fn take_all<'a, V: Copy>(pointer: *const V, count: usize) -> Outcome<&'a [V]> {
    sound(pointer)?;
    if count > isize::MAX as usize / size_of::<V>() {
        return Err(SeatrialStatus::WrongSize);
    }
    // SAFETY: not null, aligned, the caller's, of a size that exists.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// Writes a value to the memory of the caller.
///
/// # Safety
/// `pointer` is null or the caller's.
pub unsafe fn give<V>(pointer: *mut V, value: V) -> Outcome<()> {
    sound(pointer)?;
    // SAFETY: not null, aligned, the caller's.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes to `fault` which setting is wrong; a null `fault` is left out.
///
/// # Safety
/// `fault` is null or the caller's.
pub unsafe fn refuse(setting: InvalidSetting, fault: *mut SeatrialFault) -> SeatrialStatus {
    // SAFETY: the caller's promise. Without a place for it the explanation is left out.
    let _ = unsafe { give(fault, setting.into()) };
    SeatrialStatus::InvalidSetting
}

/// Whether a number that stands for an enum is one of its values.
pub fn one_of<V: Copy>(
    number: u32,
    values: &[V],
    field: &'static str,
) -> Result<V, InvalidSetting> {
    let value = values.get(number as usize).copied();
    value.ok_or(InvalidSetting { field, requirement: "one of its constants" })
}
