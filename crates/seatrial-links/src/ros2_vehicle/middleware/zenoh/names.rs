//! What `rmw_zenoh` calls topics, services and those who use them.
//!
//! Source: its design, <https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>, and `liveliness_utils.cpp`; REP 2016 for
//! the hashes of types, which a peer of the tests computes from the fields.

use crate::ros2_vehicle::middleware::wire::{self, Kind};

/// Where a type has no hash, as on Humble.
const NO_HASH: &str = "TypeHashNotSupported";

/// A topic or a service with its type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entity {
    /// Whole, with a slash before it.
    pub name: String,
    type_name: String,
    hash: &'static str,
}

impl Entity {
    pub fn topic(name: &str, [package, kind]: Kind, has_hashes: bool) -> Self {
        Self {
            name: name.into(),
            type_name: format!("{package}::msg::dds_::{kind}_"),
            hash: hash([package, kind], has_hashes),
        }
    }

    pub fn service(name: &str, [package, kind]: Kind, has_hashes: bool) -> Self {
        Self {
            name: name.into(),
            type_name: format!("{package}::srv::dds_::{kind}_"),
            hash: hash([package, kind], has_hashes),
        }
    }

    /// The key of its messages or queries.
    pub fn key(&self, domain: u16) -> String {
        let name = self.name.trim_matches('/');
        format!("{domain}/{name}/{}/{}", self.type_name, self.hash)
    }
}

/// The hash of a type that we use.
fn hash(kind: Kind, has_hashes: bool) -> &'static str {
    if !has_hashes {
        return NO_HASH;
    }
    match kind {
        wire::IMU => "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
        wire::ODOMETRY => "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
        ["sensor_msgs", "JointState"] => {
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
        }
        ["std_msgs", "Float64"] => {
            "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a"
        }
        ["std_msgs", "Float32"] => {
            "RIHS01_7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2"
        }
        wire::FLOAT64_MULTI_ARRAY => {
            "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"
        }
        ["geometry_msgs", "Twist"] => {
            "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
        }
        ["geometry_msgs", "TwistStamped"] => {
            "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"
        }
        wire::DIAGNOSTIC_ARRAY => {
            "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"
        }
        wire::TRIGGER => "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
        wire::SET_BOOL => "RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
        _ => NO_HASH,
    }
}

/// What somebody does with a topic or a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Publisher,
    Subscriber,
    Server,
    Client,
}

impl Role {
    fn code(self) -> &'static str {
        match self {
            Self::Publisher => "MP",
            Self::Subscriber => "MS",
            Self::Server => "SS",
            Self::Client => "SC",
        }
    }
}

/// Every token of a domain.
pub fn tokens(domain: u16) -> String {
    format!("@ros2_lv/{domain}/**")
}

/// The token of our node.
pub fn node_token(domain: u16, session: &str) -> String {
    format!("@ros2_lv/{domain}/{session}/0/0/NN/%/%/seatrial")
}

/// The token of one who uses a topic or a service: reliably or not, volatile, the last few messages only.
pub fn token(
    domain: u16,
    session: &str,
    number: usize,
    role: Role,
    entity: &Entity,
    (is_reliable, depth): (bool, usize),
) -> String {
    let Entity { name, type_name, hash } = entity;
    let (code, name) = (role.code(), name.replace('/', "%"));
    let reliability = if is_reliable { "" } else { "2" };
    format!(
        "@ros2_lv/{domain}/{session}/0/{number}/{code}/%/%/seatrial/{name}/{type_name}/{hash}/{reliability}::,{depth}:,:,:,,"
    )
}

/// What a token says of the one who has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Announcement<'a> {
    pub session: &'a str,
    code: &'a str,
    name: &'a str,
    type_name: &'a str,
    hash: &'a str,
}

impl<'a> Announcement<'a> {
    /// `None`: not of a topic or service.
    pub fn parse(token: &'a str) -> Option<Self> {
        let parts: Vec<&str> = token.split('/').collect();
        let [
            "@ros2_lv",
            _domain,
            session,
            _node,
            _number,
            code,
            _enclave,
            _namespace,
            _name,
            name,
            type_name,
            hash,
            ..,
        ] = parts[..]
        else {
            return None;
        };
        Some(Self { session, code, name, type_name, hash })
    }

    /// Has it this name and role?
    pub fn is_on(&self, role: Role, name: &str) -> bool {
        self.code == role.code() && self.name.replace('%', "/") == name
    }

    /// Has it this name, role and type?
    pub fn uses(&self, role: Role, entity: &Entity) -> bool {
        self.is_on(role, &entity.name)
            && self.type_name == entity.type_name
            && self.hash == entity.hash
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_keys_and_tokens_are_those_of_rmw_zenoh() {
        let twist = ["geometry_msgs", "Twist"];
        let entity = Entity::topic("/boat/cmd_vel", twist, true);
        assert_eq!(
            entity.key(7),
            "7/boat/cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
        );
        let token = token(7, "a1", 3, Role::Subscriber, &entity, (false, 10));
        assert_eq!(
            token,
            "@ros2_lv/7/a1/0/3/MS/%/%/seatrial/%boat%cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a/2::,10:,:,:,,"
        );
        let announced = Announcement::parse(&token).unwrap();
        assert_eq!(announced.session, "a1");
        assert!(announced.uses(Role::Subscriber, &entity));
        assert!(!announced.uses(Role::Publisher, &entity));
        let on_humble = Entity::topic("/boat/cmd_vel", twist, false);
        assert!(on_humble.key(7).ends_with("Twist_/TypeHashNotSupported"));
        assert!(announced.is_on(Role::Subscriber, &on_humble.name));
        assert!(!announced.uses(Role::Subscriber, &on_humble));
        assert_eq!(Announcement::parse(&node_token(7, "a1")), None);
    }
}
