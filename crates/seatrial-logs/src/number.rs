//! Little-endian numbers of binary messages.

/// A number as formats write it.
pub(crate) trait Number: Sized {
    /// At the start of these bytes; `None` where they are too few.
    fn little_endian(bytes: &[u8]) -> Option<Self>;
}

macro_rules! numbers {
    ($($number:ty)*) => { $(
        impl Number for $number {
            fn little_endian(bytes: &[u8]) -> Option<Self> {
                bytes.first_chunk().map(|bytes| Self::from_le_bytes(*bytes))
            }
        }
    )* };
}

numbers! { u8 i8 u16 i16 u32 i32 u64 i64 f32 f64 }

/// The little-endian number at a byte of a message; `None` behind its end.
pub(crate) fn number<N: Number>(message: &[u8], at: usize) -> Option<N> {
    N::little_endian(message.get(at..)?)
}
