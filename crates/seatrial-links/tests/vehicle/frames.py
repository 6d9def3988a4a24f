"""Frames as pymavlink writes them: for every message a line of id, sequence, version 2, version 1 and signed, in hexadecimal."""

import os
import random
import struct
import sys

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v10 import ardupilotmega as version_1
from pymavlink.dialects.v20 import ardupilotmega as version_2

# Fields that version 2 has added and nobody here reads stay 0, which is not sent.
ADDED = {"SERVO_OUTPUT_RAW": 0}
KEY = bytes(range(32))


def value(draw, kind):
    if kind in "fd":
        return struct.unpack("<f", struct.pack("<f", draw.choice([0.0, draw.uniform(-1e6, 1e6)])))[0]
    bits = 8 * struct.calcsize("<" + kind)
    number = draw.choice([0, draw.getrandbits(bits)])
    return number - (1 << bits) if kind.islower() and number >= 1 << (bits - 1) else number


def arguments(draw, message):
    kinds = [c for c in message.unpacker.format if c.isalpha()]
    values = {}
    for name, length, kind in zip(message.ordered_fieldnames, message.array_lengths, kinds):
        is_added = name in message.ordered_fieldnames[message.first_added :]
        if kind == "s":
            text = "".join(draw.choice("ABC_09") for _ in range(draw.randint(0, length)))
            values[name] = text.encode()
        elif length:
            values[name] = [0 if is_added else value(draw, kind) for _ in range(length)]
        else:
            values[name] = 0 if is_added else value(draw, kind)
    return values


class Sink:
    def write(self, data):
        pass


def frame(module, name, values, sequence, key=None, timestamp=0):
    link = module.MAVLink(Sink(), srcSystem=7, srcComponent=190)
    link.seq = sequence
    if key:
        link.signing.secret_key = key
        link.signing.link_id = 3
        link.signing.timestamp = timestamp
        link.signing.sign_outgoing = True
    known = getattr(module, "MAVLink_" + name.lower() + "_message")
    names = known.fieldnames
    packed = known(**{key: value for key, value in values.items() if key in names})
    return packed.pack(link).hex()


def main():
    draw = random.Random(20)
    ids = [int(number) for number in sys.argv[2].split(",")]
    for number in range(int(sys.argv[1])):
        for identity in ids:
            message = version_2.mavlink_map[identity]
            name = message.msgname
            fields = message.ordered_fieldnames
            old = version_1.mavlink_map.get(identity)
            first_added = len(old.ordered_fieldnames) if old else len(fields)
            message.first_added = len(fields) if name in ADDED else first_added
            values = arguments(draw, message)
            sequence = draw.getrandbits(8)
            timestamp = 10_000_000_000_000 + 1000 * number
            new = frame(version_2, name, values, sequence)
            signed = frame(version_2, name, values, sequence, KEY, timestamp)
            plain = frame(version_1, name, values, sequence) if old and name not in ADDED else "-"
            print(identity, sequence, timestamp, new, plain, signed)


main()
