//! rosbag2 files in SQLite (`.db3`) with ROS 2 messages in CDR.

use std::io::{Read, Seek};
use std::path::Path;

use rusqlite::{Connection, OpenFlags, params};
use tempfile::NamedTempFile;

use crate::bytes::{Bytes, ZSTD};
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::ros2::{Topics, plain};
use crate::table::Known;

/// Messages fetched at once, and bytes of them.
const BATCH: i64 = 256;
const BATCH_BYTES: usize = 4 << 20;
/// Longer messages are images or clouds.
const LONGEST_MESSAGE: i64 = 1 << 20;

/// Definitions for bags from before bags held them.
const DEFINITIONS: [(&str, &str); 6] = [
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Float32", "float32 data"),
    ("sensor_msgs/Imu", IMU),
    ("nav_msgs/Odometry", ODOMETRY),
    ("geometry_msgs/PoseStamped", POSE_STAMPED),
    ("geometry_msgs/Twist", TWIST),
];

macro_rules! header {
    () => {
        "\n=====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id"
    };
}
macro_rules! geometry {
    () => {
        "\n=====\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n=====\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n=====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n=====\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n=====\nMSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n=====\nMSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n=====\nMSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance"
    };
}
const IMU: &str = concat!(
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
    header!(),
    geometry!()
);
const ODOMETRY: &str = concat!(
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist",
    header!(),
    geometry!()
);
const POSE_STAMPED: &str = concat!(
    "std_msgs/Header header\ngeometry_msgs/Pose pose",
    header!(),
    geometry!()
);
const TWIST: &str = concat!("Vector3 linear\nVector3 angular", geometry!());

/// A bag.
pub(crate) struct Bag {
    bytes: Bytes,
    database: Connection,
    topics: Topics,
    length: u64,
    rows: i64,
    /// Number of the last message that was fetched.
    last: i64,
    fetched: std::vec::IntoIter<(u64, i64, Vec<u8>)>,
    read: i64,
    /// Bytes that the database has when it is whole, where there are fewer.
    cut_from: Option<u64>,
    what: Option<String>,
    /// What the database reads in place of the file: it knows files by names, and takes half a page for one.
    _copy: Option<NamedTempFile>,
}

impl Bag {
    /// Finds the topics with messages. What has no name is copied first.
    pub fn open(mut file: Input, path: &Path) -> Result<Self, Fault> {
        let length = file.length().map_err(Fault::read)?;
        let size = Size::of(&mut file)?;
        let cut_from = size.whole().filter(|whole| length < *whole);
        let is_in_page = cut_from.is_some() && length % size.page > 0;
        let copy = match path.as_os_str().is_empty() || is_in_page {
            true => Some(copy_of(&mut file, length - length % size.page).map_err(Fault::read)?),
            false => None,
        };
        let path = copy.as_ref().map_or(path, |copy| copy.path());
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let database = Connection::open_with_flags(path, flags).map_err(damaged)?;
        let mut bag = Self {
            bytes: Bytes::new(file)?,
            topics: Topics::default(),
            length,
            rows: 0,
            last: i64::MIN,
            fetched: Vec::new().into_iter(),
            read: 0,
            cut_from,
            what: None,
            database,
            _copy: copy,
        };
        bag.find_topics().map_err(|error| match cut_from {
            Some(whole) => Fault::Damaged {
                format: "rosbag2",
                what: format!(
                    "{length} of its {whole} bytes are there, and the list of its topics is not among them"
                ),
            },
            None => damaged(error),
        })?;
        if bag.topics.kinds.is_empty() {
            let unknown = bag.topics.unknown.join(", ");
            let found = if unknown.is_empty() {
                "no topics"
            } else {
                &clipped(&unknown)
            };
            return Err(Fault::NothingToRead {
                format: "rosbag2",
                what: format!("expected topics in CDR whose definitions it holds, found {found}"),
            });
        }
        Ok(bag)
    }

    /// Is there a table of this name? Views and computed columns, which can be of any size, are none.
    fn has_table(&self, name: &str) -> Result<bool, rusqlite::Error> {
        self.database.query_row(
            "SELECT count(*) = 1 AND NOT EXISTS (SELECT 1 FROM pragma_table_xinfo(?1) WHERE hidden <> 0)
             FROM sqlite_schema WHERE name = ?1 AND type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%'",
            params![name],
            |row| row.get(0),
        )
    }

    fn find_topics(&mut self) -> Result<(), rusqlite::Error> {
        // A cut database is opened with this alone.
        self.database.pragma_update(None, "writable_schema", true)?;
        self.database.pragma_update(None, "trusted_schema", false)?;
        if !self.has_table("topics")? || !self.has_table("messages")? {
            return Ok(());
        }
        let has_definitions = self.has_table("message_definitions")?;
        let count = "SELECT count(*) FROM messages";
        self.rows = self
            .database
            .query_row(count, [], |row| row.get(0))
            .or_else(|error| self.cut_from.map(|_| 0).ok_or(error))?;
        let mut topics = self.database.prepare(
            "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr' LIMIT 10000",
        )?;
        let mut with_messages = self
            .database
            .prepare("SELECT EXISTS (SELECT 1 FROM messages WHERE topic_id = ?1)")?;
        let found: Vec<(i64, String, String)> = topics
            .query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?
            .collect::<Result<_, _>>()?;
        for (id, topic, type_name) in found {
            let has_messages = with_messages.query_row(params![id], |row| row.get(0));
            // The messages before a cut are found without an answer for those behind it.
            if !has_messages.or_else(|error| self.cut_from.map(|_| true).ok_or(error))? {
                continue;
            }
            let stored: Option<String> = match has_definitions {
                true => self
                    .database
                    .query_row(
                        "SELECT encoded_message_definition FROM message_definitions
                         WHERE topic_type = ?1 AND encoding = 'ros2msg'",
                        params![type_name],
                        |row| row.get(0),
                    )
                    .ok(),
                false => None,
            };
            let plain_name = plain(&type_name);
            let built_in = DEFINITIONS.iter().find(|(name, _)| *name == plain_name);
            let definition = stored.or_else(|| Some(built_in?.1.to_string()));
            self.topics.add(
                id as u64,
                &topic,
                &type_name,
                &definition.unwrap_or_default(),
            );
        }
        Ok(())
    }

    fn fetch(&mut self) -> Result<(), rusqlite::Error> {
        let mut statement = self.database.prepare_cached(
            "SELECT id, topic_id, timestamp, data FROM messages
             WHERE id > ?1 AND length(data) <= ?2 ORDER BY id LIMIT ?3",
        )?;
        let rows = statement.query_map(params![self.last, LONGEST_MESSAGE, BATCH], |row| {
            Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?))
        })?;
        let (mut fetched, mut bytes, mut end) = (Vec::new(), 0, Ok(()));
        for row in rows {
            let (id, topic, time, data): (i64, i64, i64, Vec<u8>) = match row {
                Ok(row) => row,
                Err(error) => {
                    end = Err(error);
                    break;
                }
            };
            // Behind a number a damaged index can lead to it again, and for ever.
            if id <= self.last {
                self.what = Some("its messages are out of order".into());
                break;
            }
            self.last = id;
            let data = unpacked(data);
            bytes += data.len();
            fetched.push((topic as u64, time, data));
            if bytes > BATCH_BYTES {
                break;
            }
        }
        self.fetched = fetched.into_iter();
        end
    }
}

/// What the head of a database says about its size.
struct Size {
    page: u64,
    pages: Option<u64>,
}

impl Size {
    fn of(file: &mut Input) -> Result<Self, Fault> {
        let mut head = Vec::new();
        file.take(100).read_to_end(&mut head).map_err(Fault::read)?;
        file.rewind().map_err(Fault::read)?;
        let page = head
            .get(16..18)
            .map_or(0, |size| u64::from(size[0]) << 8 | u64::from(size[1]));
        let pages = head.get(28..).and_then(|size| size.first_chunk()).copied();
        // Writers of old left the number of pages as it was.
        let is_current = head.len() == 100 && head[24..28] == head[92..96];
        Ok(Self {
            page: if page == 1 { 1 << 16 } else { page.max(512) },
            pages: pages
                .filter(|_| is_current)
                .map(|pages| u32::from_be_bytes(pages).into()),
        })
    }

    fn whole(&self) -> Option<u64> {
        Some(self.page * self.pages?)
    }
}

fn copy_of(file: &mut Input, length: u64) -> std::io::Result<NamedTempFile> {
    let mut copy = NamedTempFile::new()?;
    std::io::copy(&mut file.take(length), &mut copy)?;
    file.rewind()?;
    Ok(copy)
}

/// A message of a bag that packs each by zstd. No message in CDR begins like that; what cannot be unpacked is left as it is,
/// and counted as one that cannot be decoded.
fn unpacked(data: Vec<u8>) -> Vec<u8> {
    match data.starts_with(ZSTD) {
        true => zstd::bulk::decompress(&data, LONGEST_MESSAGE as usize).unwrap_or(data),
        false => data,
    }
}

fn damaged(error: rusqlite::Error) -> Fault {
    Fault::Damaged {
        format: "rosbag2",
        what: clipped(&error.to_string()),
    }
}

impl Messages for Bag {
    fn kinds(&self) -> &[Kind] {
        &self.topics.kinds
    }

    fn known(&self) -> Known {
        self.topics.known()
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            for (topic, time, data) in self.fetched.by_ref() {
                self.read += 1;
                if self
                    .topics
                    .take(topic, time as f64 / 1e9, &data, wanted, message)
                {
                    return Ok(true);
                }
            }
            // What a damaged database gives before its damage counts.
            if self.what.is_some() {
                return Ok(false);
            }
            match self.fetch() {
                Ok(()) if self.fetched.len() == 0 => return Ok(false),
                Ok(()) => {}
                Err(error) => self.what = Some(clipped(&error.to_string())),
            }
        }
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&self) -> u64 {
        (self.length as f64 * self.read as f64 / self.rows.max(1) as f64) as u64
    }

    fn warnings(&self) -> Vec<String> {
        let what = match (self.cut_from, &self.what) {
            (Some(whole), _) => Some(format!(
                "the file is cut off: {} of its {whole} bytes are there; the messages before the first one that is lost are read",
                self.length
            )),
            (None, what) => what.as_ref().map(|what| {
                format!("the database is damaged ({what}); everything before that is read")
            }),
        };
        let mut warnings: Vec<String> = what.into_iter().collect();
        warnings.extend(self.topics.warnings());
        warnings
    }
}
