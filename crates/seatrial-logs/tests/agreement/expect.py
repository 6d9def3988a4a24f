"""Prints what other libraries read in every log of a folder and in those beside this file.

A line is a kind of message: log, kind, messages, and the first 16 digits of the SHA-256 of all numbers of all
messages as little-endian doubles, in the order of the file. Run with requirements.txt installed:

    python expect.py ../../../../../shared/data/native > expected.txt

It also writes ros2.mcap, ros2.db3 and sentences.nmea beside itself where they are missing.
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


# Parameter groups: our name, does the first byte number instruments, fields.
NMEA2000 = {
    127237: ("heading_control", False, ["commandedRudderAngle", "vesselHeading"]),
    127245: ("rudder", True, ["angleOrder", "position"]),
    127250: ("vessel_heading", False, ["heading"]),
    127251: ("rate_of_turn", False, ["rate"]),
    127252: ("heave", False, ["heave"]),
    127488: ("engine", True, ["speed"]),
    127489: ("engine_dynamic", True, ["percentEngineLoad", "percentEngineTorque"]),
    127257: ("attitude", False, ["yaw", "pitch", "roll"]),
    128259: ("speed", False, ["speedWaterReferenced", "speedGroundReferenced"]),
    128267: ("water_depth", False, ["depth"]),
    129025: ("position", False, ["latitude", "longitude"]),
    129026: ("cog_sog", False, ["sog"]),
    129029: ("gnss_position", False, ["latitude", "longitude"]),
}


def canboat(path):
    from nmea2000 import NMEA2000Decoder

    kinds, decoder = Kinds(), NMEA2000Decoder()
    for line in path.read_text().splitlines():
        cells = line.split(",")
        if line.startswith("#") or len(cells) < 7 or int(cells[2]) not in NMEA2000:
            continue
        message = decoder.decode(line)
        if message is None:
            continue
        name, has_instance, fields = NMEA2000[message.PGN]
        kind = f"{name}.{message.source}"
        if has_instance:
            kind += f".{int(cells[6], 16)}"
        values = {field.id.lower(): field.value for field in message.fields}
        values = [values[field.lower()] for field in fields]
        kinds.add(kind, [math.nan if value is None else float(value) for value in values])
    return kinds


def is_measured(sensor):
    """Of some two thousand sensors: attitude, depth, speed, position and fin, and their times."""
    words = ("heading", "pitch", "roll", "depth", "fin", "speed", "lat", "lon", "time", "rate", "altitude")
    return sensor.startswith("m_") and any(word in sensor for word in words)


def slocum(path):
    import dbdreader

    kinds = Kinds()
    cache = str(path.parent / "cac")
    log = dbdreader.DBD(str(path), cacheDir=cache, skip_initial_line=False)
    for sensor in filter(is_measured, log.parameterNames):
        for value in log.get(sensor, decimalLatLon=False, discardBadLatLon=False)[1]:
            kinds.add(sensor, [value])
    log.close()
    return kinds


# Attributes of pynmea2; of a pair the second is the letter without which the first does not count.
NMEA0183 = {
    "HDT": ["heading"],
    "HDG": ["heading"],
    "HDM": ["heading"],
    "ROT": [("rate_of_turn", "status")],
    "RSA": [("rsa_starboard", "rsa_starboard_status"), ("rsa_port", "rsa_port_status")],
    "VHW": ["heading_true", "water_speed_knots"],
    "VTG": ["spd_over_grnd_kts"],
    "RMC": ["spd_over_grnd", "latitude", "longitude"],
    "DPT": ["depth"],
    "DBT": ["depth_meters"],
}


def write_sentences():
    """A minute of a bridge: every number another, some empty, some not valid, some sentences damaged."""
    lines = []
    for k in range(240):
        sentences = [
            f"GPRMC,1200{k / 4:05.2f},A,5000.0,N,00100.0,W,{4 + k / 100:.2f},81.0,080626,,,A",
            f"HEHDT,{80 + k / 7:.3f},T",
            f"HCHDG,{79.5 + k / 7:.1f},,,1.5,W",
            f"HCHDM,{79.5 + k / 7:.1f},M",
            f"TIROT,{12 - k / 3:.2f},{'AV'[k % 5 == 0]}",
            f"IIRSA,{-3.5 + k / 9:.2f},A,{k / 11:.2f},{'VA'[k % 2]}",
            f"VWVHW,{81 + k / 7:.2f},T,80.0,M,{4 + k / 50:.2f},N,7.6,K",
            f"GPVTG,81.0,T,80.0,M,{'' if k % 4 == 0 else f'{4 + k / 100:.2f}'},N,7.6,K",
            f"SDDPT,{20 + k / 13:.2f},0.5",
            f"SDDBT,65.6,f,{20 + k / 13:.2f},M,10.9,F",
        ]
        for number, sentence in enumerate(sentences):
            total = 0
            for character in sentence:
                total ^= ord(character)
            total ^= (k + number) % 37 == 20
            lines.append(f"${sentence}*{total:02X}")
    (HERE / "sentences.nmea").write_text("\r\n".join(lines) + "\r\n")


def nmea0183(path):
    import pynmea2

    kinds = Kinds()
    for line in path.read_text().splitlines():
        try:
            sentence = pynmea2.parse(line[line.index("$") :], check=True)
        except pynmea2.ParseError:
            continue
        values = []
        for field in NMEA0183.get(sentence.sentence_type, []):
            number, flag = field if isinstance(field, tuple) else (field, None)
            value = getattr(sentence, number)
            counts = flag is None or getattr(sentence, flag) == "A"
            values.append(math.nan if value in (None, "") or not counts else float(value))
        if values:
            kinds.add(sentence.sentence_type, values)
    return kinds


def main(folder):
    write_ros2()
    if not (HERE / "sentences.nmea").exists():
        write_sentences()
    readers = {
        ".BIN": dataflash,
        ".tlog": tlog,
        ".ulg": ulog,
        ".mcap": mcap,
        ".db3": bag,
        ".dbd": slocum,
        ".nmea": nmea0183,
    }
    for path in sorted(folder.rglob("*")):
        if path.suffix in readers:
            readers[path.suffix](path).show(path.relative_to(folder))
        # The times of the third capture are those of a copy: it is refused.
        elif path.suffix in (".raw", ".all") and not path.name.startswith("raymarine"):
            canboat(path).show(path.relative_to(folder))
    for path in sorted(HERE.iterdir()):
        if path.suffix in readers:
            readers[path.suffix](path).show(path.name)


main(pathlib.Path(sys.argv[1]))
