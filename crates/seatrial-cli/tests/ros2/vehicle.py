"""A first-order vehicle on ROS 2, played with CycloneDDS: an implementation of DDS other than seatrial's.

Steers as psi'' = A22 psi' + B2 delta + C0 through a rudder of limited rate and lag. Everything is published and called by the
names and types that ROS 2's middlewares use; no ROS is installed. Says `ready` and `training` on standard output, and at its
end what it saw.

usage: vehicle.py DOMAIN MISHAP [AT_S]

Mishaps, AT_S seconds after the first training rudder: none; abort and disable call a service of seatrial's; killed ends this
process; second has another publisher of rudders.
"""

import json
import math
import os
import random
import sys
import threading
import time
from dataclasses import dataclass, field

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, bounded_str, float64, int32, int64, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

A22, B2, C0 = -1.3, 1.5, 0.02
INTERVAL_S = 0.05
STEP_S = 0.005
TIMEOUT_S = 0.5
RUDDER_LAG_S = 0.02
SURGE_S = 0.5
HEADING_NOISE_RAD = 0.002


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


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
    position: Vector3 = field(default_factory=Vector3)
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
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


# Requests and responses as rmw_cyclonedds carries them: who asked and which question, then what.
@dataclass
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    client: int64
    number: int64
    structure_needs_at_least_one_member: uint8 = 0


@dataclass
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    client: int64
    number: int64
    success: bool
    message: str


@dataclass
class SetBoolRequest(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Request_"):
    client: int64
    number: int64
    data: bool


@dataclass
class SetBoolResponse(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Response_"):
    client: int64
    number: int64
    success: bool
    message: str


# This machine alone: no multicast, nothing announced elsewhere.
CONFIGURATION = """<CycloneDDS><Domain><General>
<Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""

RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(64))
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(64))


class Vehicle:
    def __init__(self, domain, mishap, at_s):
        self.mishap, self.at_s = mishap, at_s
        self.domain = Domain(domain, CONFIGURATION)
        self.participant = DomainParticipant(domain)
        self.odometry = self.writer("rt/odom", Odometry, SENSOR)
        self.joints = self.writer("rt/joint_states", JointState, SENSOR)
        self.rudder = self.reader("rt/rudder/command", Float64)
        self.thrust = self.reader("rt/thrust/command", Float64)
        self.estimates = self.reader("rt/seatrial/estimate", Float64MultiArray)
        self.diagnostics = self.reader("rt/diagnostics", DiagnosticArray)
        self.enable_request = self.reader("rq/boat/enableRequest", SetBoolRequest)
        self.enable_response = self.writer("rr/boat/enableReply", SetBoolResponse, RELIABLE)
        self.abort_request = self.writer("rq/seatrial/abortRequest", TriggerRequest, RELIABLE)
        self.abort_response = self.reader("rr/seatrial/abortReply", TriggerResponse)
        self.trial_request = self.writer("rq/seatrial/enableRequest", SetBoolRequest, RELIABLE)
        self.trial_response = self.reader("rr/seatrial/enableReply", SetBoolResponse)
        self.random = random.Random(1)
        self.yaw_rad, self.rate_rad_s = 0.4, 0.0
        self.rudder_rad, self.speed_m_s = 0.0, 0.0
        self.asked_rad, self.asked_thrust = 0.0, 0.0
        self.heard_s = -math.inf
        self.is_enabled = False
        self.mishap_s = None
        self.second = None
        self.seen = {"rudders": 0, "estimates": 0, "diagnoses": [], "enables": [], "answers": []}

    def writer(self, name, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, name, kind), qos=qos)

    def reader(self, name, kind):
        return DataReader(self.participant, Topic(self.participant, name, kind), qos=RELIABLE)

    def stamp(self):
        sec, rest = divmod(time.time(), 1.0)
        return Header(Time(int(sec), int(rest * 1e9)), "odom")

    def step(self, span_s):
        if time.monotonic() - self.heard_s > TIMEOUT_S:
            self.asked_rad, self.asked_thrust = 0.0, 0.0
        wanted_rad = self.asked_rad if self.is_enabled else 0.0
        thrust = self.asked_thrust if self.is_enabled else 0.0
        # The exact step of the lag, and of the yaw rate under the rudder's mean.
        before_rad = self.rudder_rad
        self.rudder_rad = wanted_rad + (before_rad - wanted_rad) * math.exp(-span_s / RUDDER_LAG_S)
        mean_rad = 0.5 * (before_rad + self.rudder_rad)
        self.speed_m_s += (1.5 * thrust - self.speed_m_s) * (1.0 - math.exp(-span_s / SURGE_S))
        steady = -(B2 * mean_rad + C0) / A22
        before = self.rate_rad_s
        self.rate_rad_s = steady + (before - steady) * math.exp(A22 * span_s)
        # A heading grows to starboard, a yaw of ROS to port.
        self.yaw_rad -= steady * span_s + (self.rate_rad_s - before) / A22

    def publish_rudder(self):
        self.joints.write(JointState(self.stamp(), ["rudder"], [-math.degrees(self.rudder_rad)], [], []))

    def publish_odometry(self):
        half = 0.5 * (self.yaw_rad + self.random.gauss(0.0, HEADING_NOISE_RAD))
        message = Odometry(header=self.stamp())
        message.pose.pose.orientation = Quaternion(0.0, 0.0, math.sin(half), math.cos(half))
        message.twist.twist = Twist(Vector3(self.speed_m_s), Vector3(z=-self.rate_rad_s))
        self.odometry.write(message)

    @staticmethod
    def taken(reader):
        """What came; the end of a publisher comes as a sample without data."""
        return [sample for sample in reader.take(64) if sample.sample_info.valid_data]

    def listen(self):
        now_s = time.monotonic()
        for command in self.taken(self.rudder):
            # Degrees, positive to port.
            self.asked_rad = -math.radians(command.data)
            self.heard_s = now_s
            self.seen["rudders"] += 1
            self.seen["last_rudder"] = command.data
            if command.data != 0.0:
                self.seen["steered_at"] = time.time()
            if self.mishap_s is None and abs(command.data) > 12.0:
                self.mishap_s = now_s + self.at_s
                print("training", flush=True)
        for command in self.taken(self.thrust):
            self.asked_thrust = command.data
            self.seen["last_thrust"] = command.data
        for request in self.taken(self.enable_request):
            self.is_enabled = request.data
            self.seen["enables"].append(request.data)
            self.enable_response.write(SetBoolResponse(request.client, request.number, True, "done"))
        for estimate in self.taken(self.estimates):
            self.seen["estimates"] += 1
            numbers = (number if math.isfinite(number) else None for number in estimate.data)
            self.seen["estimate"] = dict(zip(estimate.layout.dim[0].label.split(","), numbers))
        for diagnosis in self.taken(self.diagnostics):
            text = diagnosis.status[0].message
            if [text] != self.seen["diagnoses"][-1:]:
                self.seen["diagnoses"].append(text)
        for response in self.taken(self.abort_response) + self.taken(self.trial_response):
            self.seen["answers"].append([response.number, response.success])

    def befall(self):
        if self.mishap_s is None or time.monotonic() < self.mishap_s:
            return
        self.mishap_s = math.inf
        self.seen["mishap_at"] = time.time()
        if self.mishap == "abort":
            self.abort_request.write(TriggerRequest(77, 1))
        elif self.mishap == "disable":
            self.trial_request.write(SetBoolRequest(78, 2, False))
        elif self.mishap == "killed":
            self.say()
            os.kill(os.getpid(), 9)
        elif self.mishap == "second":
            self.second = self.writer("rt/rudder/command", Float64, RELIABLE)

    def say(self):
        print(json.dumps(self.seen), flush=True)

    def run(self, is_over):
        begin_s = last_s = time.monotonic()
        due = 0
        while not is_over.is_set():
            self.listen()
            now_s = time.monotonic()
            self.step(now_s - last_s)
            last_s = now_s
            self.publish_rudder()
            if now_s - begin_s >= due * INTERVAL_S:
                due += 1
                self.publish_odometry()
            self.befall()
            time.sleep(STEP_S)


def main():
    is_over = threading.Event()
    vehicle = Vehicle(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]) if len(sys.argv) > 3 else 1.0)

    # Ends with a line on, or the end of, standard input.
    def wait():
        sys.stdin.readline()
        is_over.set()

    threading.Thread(target=wait, daemon=True).start()
    print("ready", flush=True)
    vehicle.run(is_over)
    vehicle.say()


main()
