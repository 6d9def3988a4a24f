//! What common messages consist of, for bags from before bags held definitions.

/// Names of types and their definitions.
pub(super) const DEFINITIONS: [(&str, &str); 6] = [
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
const POSE_STAMPED: &str =
    concat!("std_msgs/Header header\ngeometry_msgs/Pose pose", header!(), geometry!());
const TWIST: &str = concat!("Vector3 linear\nVector3 angular", geometry!());
