//! Numbers of binary messages.

/// A number as formats write it.
pub(crate) trait Number: Sized {
    /// At the start of these bytes; `None` where they are too few.
    fn little_endian(bytes: &[u8]) -> Option<Self>;
}

macro_rules! numbers {
    ($($kind:ident $number:ident $name:literal)*) => {
        /// A kind of number.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) enum Primitive { $($kind,)* }

        impl Primitive {
            /// By its name, as in `uint16` and `float32`.
            pub fn named(name: &str) -> Option<Self> {
                match name { $($name => Some(Self::$kind),)* _ => None }
            }

            /// Bytes of it.
            pub fn width(self) -> usize {
                match self { $(Self::$kind => size_of::<$number>(),)* }
            }

            /// The little-endian number at a byte of a message; `None` behind its end.
            pub fn number(self, message: &[u8], at: usize) -> Option<f64> {
                match self { $(Self::$kind => number::<$number>(message, at).map(|n| n as f64),)* }
            }

            /// As [`number`](Self::number); the three largest values mean that there is none.
            pub fn below_none(self, message: &[u8], at: usize) -> Option<f64> {
                match self { $(Self::$kind => {
                    let number = number::<$number>(message, at);
                    number.filter(|n| *n < $number::MAX - 2 as $number).map(|n| n as f64)
                })* }
            }

            /// Reads numbers that stand one behind the other into as many places.
            pub fn read_all(self, bytes: &[u8], is_little_endian: bool, places: &mut [f64]) {
                match self { $(Self::$kind => {
                    for (place, bytes) in places.iter_mut().zip(bytes.as_chunks().0) {
                        *place = match is_little_endian {
                            true => $number::from_le_bytes(*bytes),
                            false => $number::from_be_bytes(*bytes),
                        } as f64;
                    }
                })* }
            }
        }

        $(impl Number for $number {
            fn little_endian(bytes: &[u8]) -> Option<Self> {
                bytes.first_chunk().map(|bytes| Self::from_le_bytes(*bytes))
            }
        })*
    };
}

numbers! {
    U8 u8 "uint8" I8 i8 "int8" U16 u16 "uint16" I16 i16 "int16" U32 u32 "uint32" I32 i32 "int32"
    U64 u64 "uint64" I64 i64 "int64" F32 f32 "float32" F64 f64 "float64"
}

/// The middle one, or the upper of the two; `None` of none.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The little-endian number at a byte of a message; `None` behind its end.
pub(crate) fn number<N: Number>(message: &[u8], at: usize) -> Option<N> {
    N::little_endian(message.get(at..)?)
}
