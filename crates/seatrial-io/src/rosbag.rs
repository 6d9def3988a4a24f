//! rosbag2 files in SQLite (`.db3`) with ROS 2 messages in CDR.

use std::fs::File;
use std::path::Path;

use rusqlite::{Connection, OpenFlags, params};

use crate::bytes::Bytes;
use crate::error::{Fault, clipped};
use crate::joined::{Kind, Message, Messages};
use crate::reader::Format;
use crate::ros2::{Topics, plain};
use crate::table::Known;

/// Messages fetched at once.
const BATCH: i64 = 256;
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
    what: Option<String>,
}

impl Bag {
    /// Finds the topics with messages.
    pub fn open(file: File, path: &Path) -> Result<Self, Fault> {
        let length = file.metadata().map_err(Fault::read)?.len();
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
            what: None,
            database,
        };
        bag.find_topics().map_err(damaged)?;
        if bag.topics.kinds.is_empty() {
            return Err(Fault::NothingToRead {
                format: "rosbag2",
                what: format!(
                    "expected topics in CDR whose definitions it holds, found {}",
                    clipped(&bag.topics.unknown.join(", "))
                ),
            });
        }
        Ok(bag)
    }

    fn find_topics(&mut self) -> Result<(), rusqlite::Error> {
        let has_definitions: bool = self.database.query_row(
            "SELECT count(*) > 0 FROM sqlite_master WHERE name = 'message_definitions'",
            [],
            |row| row.get(0),
        )?;
        self.rows = self
            .database
            .query_row("SELECT count(*) FROM messages", [], |row| row.get(0))?;
        let mut topics = self.database.prepare(
            "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'
             AND EXISTS (SELECT 1 FROM messages WHERE topic_id = topics.id LIMIT 1) LIMIT 10000",
        )?;
        let found: Vec<(i64, String, String)> = topics
            .query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?
            .collect::<Result<_, _>>()?;
        for (id, topic, type_name) in found {
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
        let mut fetched = Vec::new();
        for row in rows {
            let (id, topic, time, data): (i64, i64, i64, Vec<u8>) = row?;
            self.last = id;
            fetched.push((topic as u64, time, data));
        }
        self.fetched = fetched.into_iter();
        Ok(())
    }
}

fn damaged(error: rusqlite::Error) -> Fault {
    Fault::Damaged {
        format: "rosbag2",
        what: clipped(&error.to_string()),
    }
}

impl Messages for Bag {
    fn format(&self) -> Format {
        Format::Rosbag
    }

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
            if let Err(error) = self.fetch() {
                self.what = Some(clipped(&error.to_string()));
                return Ok(false);
            }
            if self.fetched.len() == 0 {
                return Ok(false);
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
        let what = self.what.iter();
        let mut warnings: Vec<String> = what
            .map(|what| format!("the database is damaged ({what}); everything before that is read"))
            .collect();
        warnings.extend(self.topics.warnings());
        warnings
    }
}
