//! Fields of messages as they stand in a payload.

/// Numbers of one type behind each other.
#[derive(Clone, Copy)]
pub(crate) struct Numbers {
    pub count: usize,
    /// Bytes of one of them.
    pub width: usize,
    /// The number at the start of these bytes.
    pub number: fn(&[u8]) -> f64,
}

/// A field as it stands in a payload, little endian.
pub(crate) trait Field: Sized {
    /// Bytes of the whole field.
    const WIDTH: usize;
    /// The numbers in it.
    const NUMBERS: Numbers;
    fn read(bytes: &[u8]) -> Self;
    fn write(&self, bytes: &mut [u8]);
}

macro_rules! numbers {
    ($($number:ty)*) => { $(
        impl Field for $number {
            const WIDTH: usize = size_of::<$number>();
            const NUMBERS: Numbers = Numbers {
                count: 1,
                width: size_of::<$number>(),
                number: |bytes| Self::read(bytes) as f64,
            };
            fn read(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or_else(Self::default, |bytes| Self::from_le_bytes(*bytes))
            }
            fn write(&self, bytes: &mut [u8]) {
                bytes[..Self::WIDTH].copy_from_slice(&self.to_le_bytes());
            }
        }
    )* };
}

numbers! { u8 i8 u16 i16 u32 i32 u64 i64 f32 }

macro_rules! several {
    ($($number:ty)*) => { $(
        impl<const N: usize> Field for [$number; N] {
            const WIDTH: usize = N * size_of::<$number>();
            const NUMBERS: Numbers = Numbers {
                count: N,
                ..<$number as Field>::NUMBERS
            };
            fn read(bytes: &[u8]) -> Self {
                std::array::from_fn(|k| <$number>::read(&bytes[size_of::<$number>() * k..]))
            }
            fn write(&self, bytes: &mut [u8]) {
                for (number, bytes) in self.iter().zip(bytes.chunks_exact_mut(size_of::<$number>())) {
                    number.write(bytes);
                }
            }
        }
    )* };
}

several! { u16 f32 }

/// A text of at most N bytes, filled up with zeros.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Text<const N: usize>([u8; N]);

impl<const N: usize> Text<N> {
    /// The text up to the first zero.
    pub fn text(&self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap_or(N);
        String::from_utf8_lossy(&self.0[..end]).into_owned()
    }
}

impl<const N: usize> From<&str> for Text<N> {
    /// What goes beyond N bytes is cut off.
    fn from(text: &str) -> Self {
        let mut bytes = [0; N];
        for (to, from) in bytes.iter_mut().zip(text.bytes()) {
            *to = from;
        }
        Self(bytes)
    }
}

impl<const N: usize> std::fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

impl<const N: usize> Field for Text<N> {
    const WIDTH: usize = N;
    const NUMBERS: Numbers = Numbers { count: 0, width: N, number: |_| f64::NAN };
    fn read(bytes: &[u8]) -> Self {
        Self(bytes.first_chunk().copied().unwrap_or([0; N]))
    }
    fn write(&self, bytes: &mut [u8]) {
        bytes[..N].copy_from_slice(&self.0);
    }
}
