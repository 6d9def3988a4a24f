"""Messages of ROS 2 that the vehicle of the tests uses, and the hashes of their types."""

import hashlib
import json
import typing
from dataclasses import dataclass, field

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, byte, float64, int32, int64, sequence, uint8, uint32


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose = field(default_factory=Pose)
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist = field(default_factory=Twist)
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header = field(default_factory=Header)
    child_frame_id: str = "base_link"
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: float64 = 0.0


@dataclass
class Dimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    label: str
    size: uint32
    stride: uint32


@dataclass
class Layout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    dim: sequence[Dimension]
    data_offset: uint32


@dataclass
class Float64MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Float64MultiArray_"):
    layout: Layout
    data: sequence[float64]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: byte
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    structure_needs_at_least_one_member: uint8 = 0


@dataclass
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    success: bool = False
    message: str = ""


@dataclass
class SetBoolRequest(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Request_"):
    data: bool = False


@dataclass
class SetBoolResponse(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Response_"):
    success: bool = False
    message: str = ""


@dataclass
class ServiceEventInfo(IdlStruct, typename="service_msgs::msg::dds_::ServiceEventInfo_"):
    event_type: uint8
    stamp: Time
    client_gid: array[uint8, 16]
    sequence_number: int64


SERVICES = {"Trigger": (TriggerRequest, TriggerResponse), "SetBool": (SetBoolRequest, SetBoolResponse)}

# type_description_interfaces/FieldType.
NUMBERS = {"uint8": 3, "int32": 6, "uint32": 7, "int64": 8, "float64": 11, "byte": 16}
NESTED, BOOLEAN, STRING = 1, 15, 17
ARRAY, BOUNDED, UNBOUNDED = 48, 96, 144


def ros_name(kind):
    """std_msgs/msg/Header of std_msgs::msg::dds_::Header_."""
    package, folder, _, name = kind.__idl__.idl_transformed_typename.split("::")
    return f"{package}/{folder}/{name.removesuffix('_')}"


def field_type(kind, offset=0, capacity=0, nested=None):
    """A field's description; the nested types that it needs are put into `nested`."""
    for note in typing.get_args(kind)[1:]:
        if isinstance(note, array):
            return field_type(note.subtype, ARRAY, note.length, nested)
        if isinstance(note, sequence):
            return field_type(note.subtype, UNBOUNDED, 0, nested)
        kind = note
    name = ""
    if kind in (bool, str):
        number = BOOLEAN if kind is bool else STRING
    elif isinstance(kind, str):
        number = NUMBERS[kind]
    else:
        number, name = NESTED, ros_name(kind)
        describe(kind, nested)
    return {"type_id": number + offset, "capacity": capacity, "string_capacity": 0, "nested_type_name": name}


def describe(kind, nested):
    hints = typing.get_type_hints(kind, include_extras=True)
    fields = [{"name": name, "type": field_type(hint, nested=nested)} for name, hint in hints.items()]
    nested[ros_name(kind)] = fields


def digest(name, described):
    fields = described.pop(name)
    described = [{"type_name": name, "fields": described[name]} for name in sorted(described)]
    text = {"type_description": {"type_name": name, "fields": fields}, "referenced_type_descriptions": described}
    return "RIHS01_" + hashlib.sha256(json.dumps(text).encode()).hexdigest()


def message_hash(kind):
    """REP 2016."""
    described = {}
    describe(kind, described)
    return digest(ros_name(kind), described)


def service_hash(service):
    """Likewise of a service: its request, response, and what is told of them."""
    name, described = f"std_srvs/srv/{service}", {}
    for kind in (*SERVICES[service], ServiceEventInfo):
        describe(kind, described)

    def nested(name, offset=0, capacity=0):
        return {"type_id": NESTED + offset, "capacity": capacity, "string_capacity": 0, "nested_type_name": name}

    described[f"{name}_Event"] = [
        {"name": "info", "type": nested(ros_name(ServiceEventInfo))},
        {"name": "request", "type": nested(f"{name}_Request", BOUNDED, 1)},
        {"name": "response", "type": nested(f"{name}_Response", BOUNDED, 1)},
    ]
    described[name] = [
        {"name": f"{part.lower()}_message", "type": nested(f"{name}_{part}")}
        for part in ("Request", "Response", "Event")
    ]
    return digest(name, described)
