//! The live view of a seatrial that was built without it: there is none.

use super::Picture;

/// Nothing to draw on.
pub enum View {}

impl View {
    /// Says where the live view is to be had.
    pub fn start() -> Option<Self> {
        eprintln!(
            "no live view: this seatrial was built without; build it with `--features live-view`"
        );
        None
    }

    pub fn draw(&mut self, _: &Picture) {
        match *self {}
    }

    pub fn lines(&mut self, _: &str) {
        match *self {}
    }

    pub fn end(&mut self) {
        match *self {}
    }
}
