//! Why a record cannot be refined.

use core::error::Error;
use core::fmt::{self, Display, Formatter};

/// Two initial conditions, three parameters and a noise level need some comparisons each.
pub const LEAST_COMPARISONS: usize = 15;

/// Why a record cannot be refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefineFailure {
    /// Fewer comparisons than parameters can bear.
    TooShort {
        /// Comparisons found.
        found: usize,
    },
    /// The responses to rudder, offset and initial state cannot be told apart.
    NotExcited,
}

impl Display for RefineFailure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { found } => {
                write!(f, "{found} comparisons, at least {LEAST_COMPARISONS} are needed")
            }
            Self::NotExcited => f.write_str(
                "the rudder's response cannot be told from the offset and the initial state",
            ),
        }
    }
}

impl Error for RefineFailure {}
