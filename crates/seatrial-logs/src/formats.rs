//! Log formats that a program brings along, beside the built-in ones.
//!
//! A format says by the first bytes of a file whether it is one of its own, and reads it as [`Messages`]; rows of columns are messages of one
//! kind. Names, units, signs and time are then the same code as for every other format, and everything that reads a log by a
//! [`ChannelChoice`](crate::ChannelChoice) reads the new format, too: one log, many logs and their runs.
//!
//! ```
//! use seatrial_logs::formats::{Bytes, Formats, Kind, LogFormat, Message, Messages};
//! use seatrial_logs::{ChannelChoice, Fault, FileMap, Format, open_in};
//!
//! /// Lines of time, heading and rudder, in SI units, below the line `#helm`.
//! struct Helm;
//!
//! impl LogFormat for Helm {
//!     fn name(&self) -> &'static str {
//!         "helm"
//!     }
//!
//!     fn is_start(&self, start: &[u8], _path: &std::path::Path) -> bool {
//!         start.starts_with(b"#helm\n")
//!     }
//!
//!     fn open(&self, bytes: Bytes) -> Result<Box<dyn Messages>, Fault> {
//!         let kinds = [Kind {
//!             name: String::new(),
//!             fields: vec!["heading_rad".into(), "rudder_rad".into()],
//!         }];
//!         Ok(Box::new(HelmLog { bytes, kinds }))
//!     }
//! }
//!
//! struct HelmLog {
//!     bytes: Bytes,
//!     kinds: [Kind; 1],
//! }
//!
//! impl Messages for HelmLog {
//!     fn kinds(&self) -> &[Kind] {
//!         &self.kinds
//!     }
//!
//!     fn next(&mut self, _wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
//!         while let Some(line) = self.bytes.line()? {
//!             let text = String::from_utf8_lossy(line);
//!             let mut numbers = text.split(' ').filter_map(|word| word.parse().ok());
//!             let [Some(time_s), Some(heading_rad), Some(rudder_rad)] =
//!                 [numbers.next(), numbers.next(), numbers.next()]
//!             else {
//!                 continue;
//!             };
//!             message.time_s = time_s;
//!             message.values = vec![heading_rad, rudder_rad];
//!             return Ok(true);
//!         }
//!         Ok(false)
//!     }
//!
//!     fn bytes(&mut self) -> &mut Bytes {
//!         &mut self.bytes
//!     }
//! }
//!
//! let mut files = FileMap::default();
//! files.insert("my.log", *b"#helm\n0.0 1.5 0.1\n0.1 1.6 0.1\n");
//! let mut choice = ChannelChoice::default();
//! choice.formats = Formats::default().with(Helm);
//! let log = open_in("my.log".as_ref(), &files, &choice)?;
//! assert_eq!(log.description().format, Format::Other("helm".into()));
//! assert_eq!(log.count(), 2);
//! # Ok::<(), seatrial_logs::ReadError>(())
//! ```

use std::fmt;
use std::path::Path;
use std::sync::Arc;

pub use crate::bytes::{Bytes, Damage};
use crate::error::Fault;
pub use crate::message_table::{Kind, Message, Messages};
pub use crate::table::{Known, KnownChannel};

/// A log format that a program brings.
pub trait LogFormat: Send + Sync {
    /// Its name in documents, of letters and `_`; not that of a built-in format.
    fn name(&self) -> &'static str;

    /// Is this the start of such a file? `start` is its first 4096 bytes, or all there are; `path` as it was named, empty for standard
    /// input. It is asked of every log, so it answers `true` only to what no other format begins with.
    fn is_start(&self, start: &[u8], path: &Path) -> bool;

    /// Opens a file from its first byte.
    ///
    /// # Errors
    /// A file that cannot be read: where, what was found and what to do, as [`Fault::Damaged`] has it.
    fn open(&self, bytes: Bytes) -> Result<Box<dyn Messages>, Fault>;
}

/// The formats that a program brings. The default has none; the built-in ones are always there, and are asked after these.
#[derive(Clone, Default)]
pub struct Formats(Vec<Arc<dyn LogFormat>>);

impl Formats {
    /// With one more, asked after those that are there.
    #[must_use]
    pub fn with(mut self, format: impl LogFormat + 'static) -> Self {
        self.0.push(Arc::new(format));
        self
    }

    /// The first of them that a file with this start is one of.
    pub(crate) fn of(&self, start: &[u8], path: &Path) -> Option<&dyn LogFormat> {
        let found = self.0.iter().find(|format| format.is_start(start, path));
        found.map(|format| &**format)
    }
}

impl fmt::Debug for Formats {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names = self.0.iter().map(|format| format.name());
        f.debug_list().entries(names).finish()
    }
}

impl PartialEq for Formats {
    fn eq(&self, other: &Self) -> bool {
        let pairs = self.0.iter().zip(&other.0);
        self.0.len() == other.0.len() && pairs.into_iter().all(|(one, two)| Arc::ptr_eq(one, two))
    }
}
