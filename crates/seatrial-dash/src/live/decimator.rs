//! Long series, thinned out.

/// Samples, estimates and points of the track in a snapshot.
const MOST_DRAWN: usize = 2048;

/// At most so many values: of more every second, fourth, ... is kept.
#[derive(Debug)]
pub struct Decimator<T> {
    /// The points that are kept.
    pub kept: Vec<T>,
    stride: usize,
    seen: usize,
}

impl<T> Default for Decimator<T> {
    fn default() -> Self {
        Self { kept: Vec::new(), stride: 1, seen: 0 }
    }
}

impl<T> Decimator<T> {
    pub fn push(&mut self, value: T) {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == MOST_DRAWN {
                let mut place = 0;
                self.kept.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.stride *= 2;
            }
            if self.seen.is_multiple_of(self.stride) {
                self.kept.push(value);
            }
        }
        self.seen += 1;
    }
}
