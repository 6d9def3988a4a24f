"""Writes expected.txt: what the formats' own Python libraries read in every log of the shared data.

A line is a kind of message: log, kind, messages, and the first 16 digits of the SHA-256 of all numbers of all
messages as little-endian doubles, in the order of the file. Run with requirements.txt installed:

    python expect.py ../../../../../shared/data/native > expected.txt

It also writes ros2.mcap and ros2.db3 beside itself where they are missing.
"""

import hashlib
import math
import pathlib
import struct
import sys

HERE = pathlib.Path(__file__).parent
NAN = struct.pack("<Q", 0x7FF8000000000000)
# Elements of a sequence that become fields.
ELEMENTS = 36


class Kinds:
    """Hashes of the numbers of every kind."""

    def __init__(self):
        self.kinds = {}

    def add(self, kind, values):
        entry = self.kinds.setdefault(kind, [0, hashlib.sha256()])
        entry[0] += 1
        entry[1].update(b"".join(NAN if math.isnan(v) else struct.pack("<d", v) for v in values))

    def show(self, log):
        for kind, (count, digest) in sorted(self.kinds.items()):
            print(f"{log}\t{kind}\t{count}\t{digest.hexdigest()[:16]}")


def dataflash(path):
    from pymavlink import DFReader

    # pymavlink multiplies by 0.01 and 1e-7, which misses the nearest double.
    per_unit = {"c": 1e2, "C": 1e2, "e": 1e2, "E": 1e2, "L": 1e7}
    descriptions = {"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG"}
    kinds = Kinds()
    log = DFReader.DFReader_binary(str(path))
    while (message := log.recv_msg()) is not None:
        fmt = message.fmt
        if fmt.name in descriptions:
            continue
        values = []
        for code, column in zip(fmt.format, fmt.columns):
            if code not in "anNZg":
                value = getattr(message, column)
                scale = per_unit.get(code)
                values.append(float(round(value * scale) / scale if scale else value))
        instance = getattr(message, fmt.instance_field) if fmt.instance_field else 0
        kinds.add(fmt.name if instance == 0 else f"{fmt.name}.{instance}", values)
    return kinds


MAVLINK = {
    "HEARTBEAT",
    "SYSTEM_TIME",
    "PARAM_VALUE",
    "ATTITUDE",
    "LOCAL_POSITION_NED",
    "GLOBAL_POSITION_INT",
    "RC_CHANNELS_SCALED",
    "SERVO_OUTPUT_RAW",
    "RC_CHANNELS",
    "VFR_HUD",
}


def tlog(path):
    from collections import Counter

    from pymavlink import mavutil

    messages = []
    attitudes = Counter()
    log = mavutil.mavlink_connection(str(path))
    while (message := log.recv_match()) is not None:
        name = message.get_type()
        if name in MAVLINK:
            sender = (message.get_srcSystem(), message.get_srcComponent())
            attitudes[sender] += name == "ATTITUDE"
            messages.append((sender, message))
    vehicle = attitudes.most_common(1)[0][0]
    kinds = Kinds()
    for sender, message in messages:
        if sender == vehicle and getattr(message, "port", 0) == 0:
            fields = [getattr(message, name) for name in message.ordered_fieldnames]
            values = [float(value) for value in fields if not isinstance(value, str)]
            kinds.add(message.get_type(), values + [float(round(message._timestamp * 1e6))])
    return kinds


def ulog(path):
    from pyulog import ULog

    kinds = Kinds()
    for topic in ULog(str(path)).data_list:
        columns = [
            topic.data[field.field_name]
            for field in topic.field_data
            if field.type_str != "char" and "_padding" not in field.field_name
        ]
        kind = topic.name if topic.multi_id == 0 else f"{topic.name}.{topic.multi_id}"
        for row in zip(*columns):
            kinds.add(kind, [float(value) for value in row])
    return kinds


def typestore():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    pulses = "std_msgs/Header header\nuint16[] channels\n"
    store.register(get_types_from_msg(pulses, "mavros_msgs/msg/RCOut"))
    return store


def numbers(store, type_name, message):
    """All numbers of a message; arrays of messages and texts are none."""
    from rosbags.interfaces import Nodetype

    values = []
    for name, (node, detail) in store.fielddefs[type_name][1]:
        value = getattr(message, name)
        if node == Nodetype.BASE:
            values += [] if detail[0] in ("string", "wstring") else [float(value)]
        elif node == Nodetype.NAME:
            values += numbers(store, detail, value)
        else:
            (inner, inner_detail), size = detail
            if inner == Nodetype.BASE and inner_detail[0] not in ("string", "wstring"):
                own = [float(v) for v in value]
                if node == Nodetype.SEQUENCE:
                    own = own[:ELEMENTS] + [math.nan] * (ELEMENTS - len(own))
                values += own if len(own) <= ELEMENTS else []
    return values


def some_messages(store):
    """A second of messages of the types that matter, every number another."""
    import itertools

    import numpy as np
    from rosbags.interfaces import Nodetype

    counter = itertools.count(1)
    widths = {"bool": 1, "octet": 7, "uint8": 8, "int8": 7, "uint16": 15, "int16": 15}

    def base(kind):
        number = next(counter)
        if kind == "string":
            return "x" * (number % 7)
        if kind.startswith("float"):
            return number / 8
        return number % (1 << widths.get(kind, 31))

    def make(type_name):
        fields = {}
        for name, (node, detail) in store.fielddefs[type_name][1]:
            if node == Nodetype.BASE:
                fields[name] = base(detail[0])
            elif node == Nodetype.NAME:
                fields[name] = make(detail)
            else:
                (inner, inner_detail), size = detail
                size = size if node == Nodetype.ARRAY else next(counter) % 5
                if inner == Nodetype.NAME:
                    fields[name] = [make(inner_detail) for _ in range(size)]
                elif inner_detail[0] == "string":
                    fields[name] = [base("string") for _ in range(size)]
                else:
                    own = [base(inner_detail[0]) for _ in range(size)]
                    fields[name] = np.array(own, dtype=inner_detail[0])
        return store.types[type_name](**fields)

    for k in range(10):
        for topic, type_name in [
            ("/imu", "sensor_msgs/msg/Imu"),
            ("/odometry", "nav_msgs/msg/Odometry"),
            ("/pose", "geometry_msgs/msg/PoseStamped"),
            ("/rudder", "std_msgs/msg/Float64"),
            ("/cmd_vel", "geometry_msgs/msg/Twist"),
            ("/joints", "sensor_msgs/msg/JointState"),
            ("/rc_out", "mavros_msgs/msg/RCOut"),
            ("/fix", "sensor_msgs/msg/NavSatFix"),
            ("/battery", "sensor_msgs/msg/BatteryState"),
        ]:
            yield topic, type_name, 10**18 + k * 10**8, make(type_name)


def plain(value):
    """A message as dictionaries and lists."""
    import dataclasses

    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, list):
        return [plain(element) for element in value]
    return value.tolist() if hasattr(value, "tolist") else value


def write_ros2():
    import shutil

    from mcap.writer import CompressionType
    from mcap_ros2.writer import Writer as McapWriter
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as BagWriter

    store = typestore()
    if not (HERE / "ros2.mcap").exists():
        with open(HERE / "ros2.mcap", "wb") as file:
            writer = McapWriter(file, chunk_size=2048, compression=CompressionType.LZ4)
            schemas = {}
            for topic, type_name, time, message in some_messages(store):
                text, _ = store.generate_msgdef(type_name, ros_version=2)
                if type_name not in schemas:
                    schemas[type_name] = writer.register_msgdef(type_name, text)
                writer.write_message(topic, schemas[type_name], plain(message), time)
            writer.finish()
    if not (HERE / "ros2.db3").exists():
        folder = HERE / "bag"
        with BagWriter(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
            topics = {}
            for topic, type_name, time, message in some_messages(store):
                if topic not in topics:
                    topics[topic] = bag.add_connection(topic, type_name, typestore=store)
                bag.write(topics[topic], time, store.serialize_cdr(message, type_name))
        (folder / "bag.db3").rename(HERE / "ros2.db3")
        shutil.rmtree(folder)


def mcap(path):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    store, kinds = typestore(), Kinds()
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
            kinds.add(channel.topic.lstrip("/"), numbers(store, schema.name, message))
    return kinds


def bag(path):
    import sqlite3

    store, kinds = typestore(), Kinds()
    rows = sqlite3.connect(path).execute(
        "SELECT topics.name, topics.type, data FROM messages"
        " JOIN topics ON topics.id = topic_id ORDER BY messages.id"
    )
    for topic, type_name, data in rows:
        message = store.deserialize_cdr(data, type_name)
        kinds.add(topic.lstrip("/"), numbers(store, type_name, message))
    return kinds


def main(native):
    write_ros2()
    readers = {".BIN": dataflash, ".tlog": tlog, ".ulg": ulog}
    for path in sorted(native.rglob("*")):
        if path.suffix in readers:
            readers[path.suffix](path).show(path.relative_to(native))
    mcap(HERE / "ros2.mcap").show("ros2.mcap")
    bag(HERE / "ros2.db3").show("ros2.db3")


main(pathlib.Path(sys.argv[1]))
