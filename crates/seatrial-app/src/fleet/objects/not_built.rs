//! In place of object stores where they are not built in.

use std::fs::File;

use super::{Address, ObjectError};
use crate::fleet::Source;

fn refused<T>(address: Address) -> Result<T, ObjectError> {
    Err(address.error(
        "this seatrial was built without object stores",
        "build it with `--features object-stores`, or download the log",
    ))
}

pub fn look(address: Address) -> Result<Option<Source>, ObjectError> {
    refused(address)
}

pub fn look_at_all(addresses: &[Address]) -> Result<Vec<Source>, ObjectError> {
    addresses.iter().map(|&address| refused(address)).collect()
}

pub fn list(address: Address, _: &str) -> Result<Vec<Source>, ObjectError> {
    refused(address)
}

pub fn download(address: Address, _: Option<&Source>, _: &mut File) -> Result<(), ObjectError> {
    refused(address)
}

pub fn upload(address: Address, _: &mut File) -> Result<(), ObjectError> {
    refused(address)
}
