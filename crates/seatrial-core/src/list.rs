//! A list of fixed capacity, for configuration without a heap.

use core::ops::Deref;

/// Up to `N` values, without a heap.
#[derive(Clone, Copy, Debug)]
pub struct List<T, const N: usize> {
    items: [T; N],
    len: usize,
}

impl<T: Copy + Default, const N: usize> List<T, N> {
    /// The values of a slice; `None` where there are more than `N`.
    ///
    /// ```
    /// use seatrial_core::List;
    ///
    /// assert_eq!(List::<f64, 2>::from_slice(&[0.6, 1.0]).as_deref(), Some(&[0.6, 1.0][..]));
    /// assert_eq!(List::<f64, 2>::from_slice(&[0.6, 0.8, 1.0]), None);
    /// ```
    pub fn from_slice(values: &[T]) -> Option<Self> {
        let mut list = Self::default();
        values.iter().all(|value| list.push(*value).is_ok()).then_some(list)
    }

    /// Appends a value. The error holds the value that a full list has no room for.
    ///
    /// ```
    /// use seatrial_core::List;
    ///
    /// let mut thrusts = List::<f64, 1>::default();
    /// assert_eq!(thrusts.push(0.6), Ok(()));
    /// assert_eq!(thrusts.push(0.8), Err(0.8));
    /// ```
    pub fn push(&mut self, value: T) -> Result<(), T> {
        let Some(place) = self.items.get_mut(self.len) else {
            return Err(value);
        };
        *place = value;
        self.len += 1;
        Ok(())
    }

    /// Takes the first value out.
    ///
    /// ```
    /// use seatrial_core::List;
    ///
    /// let mut list = List::<u8, 4>::from_slice(&[1, 2]).unwrap_or_default();
    /// assert_eq!([list.pop_front(), list.pop_front(), list.pop_front()], [Some(1), Some(2), None]);
    /// ```
    pub fn pop_front(&mut self) -> Option<T> {
        let first = self.first().copied()?;
        self.items.rotate_left(1);
        self.len -= 1;
        Some(first)
    }
}

impl<T: Copy + Default, const N: usize> Default for List<T, N> {
    fn default() -> Self {
        Self { items: [T::default(); N], len: 0 }
    }
}

impl<T, const N: usize> Deref for List<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.items.get(..self.len).unwrap_or_default()
    }
}

impl<T: PartialEq, const N: usize> PartialEq for List<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(feature = "serde")]
mod serialisation {
    use core::fmt;
    use core::marker::PhantomData;

    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{Serialize, Serializer};

    use super::List;

    impl<T: Serialize, const N: usize> Serialize for List<T, N> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_seq(self.iter())
        }
    }

    struct ListVisitor<T, const N: usize>(PhantomData<T>);

    impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Visitor<'de> for ListVisitor<T, N> {
        type Value = List<T, N>;

        fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
            write!(formatter, "a list of at most {N} values")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Self::Value, A::Error> {
            let mut list = List::default();
            while let Some(value) = values.next_element()? {
                if list.push(value).is_err() {
                    return Err(A::Error::invalid_length(N + 1, &self));
                }
            }
            Ok(list)
        }
    }

    impl<'de, T: Copy + Default + Deserialize<'de>, const N: usize> Deserialize<'de> for List<T, N> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_seq(ListVisitor(PhantomData))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_first_in_first_out_and_full() {
        let mut list = List::<u8, 2>::from_slice(&[1, 2]).unwrap();
        assert_eq!(list.push(3), Err(3));
        assert_eq!(list.pop_front(), Some(1));
        assert_eq!(list.push(3), Ok(()));
        assert_eq!(*list, [2, 3]);
        assert_eq!(List::<u8, 2>::from_slice(&[1, 2, 3]), None);
    }
}
