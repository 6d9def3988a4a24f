"""A boat that speaks MAVLink through pymavlink: what ArduPilot's Rover does, around a first-order plant.

Its clock is its own: it waits for the ground station's command after every attitude, so that a trial takes as long as the
two need to compute. A mishap comes in mid doublet, half a second after the rudder first goes beyond what steering and the
preflight ask for. A line "back" on its input ends a mishap that lasts; the end of its input ends the boat, which then tells
what it did as one line of JSON.
"""

import argparse
import json
import math
import os
import random
import select
import socket
import sys
import time

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import ardupilotmega as m

A22, B2, C0 = -0.91, 1.75, 0.02
FULL = math.radians(35)
STEP = 0.01
PER_ATTITUDE = 5
PER_OUTPUT = 2
MANUAL, HOLD = 0, 4
# Wall time in which a command must answer an attitude, s: while there are commands, and otherwise.
ANSWER = 0.02
ALONE = 0.004
# Of full rudder: beyond this it is a doublet.
DOUBLET = 0.4

options = argparse.ArgumentParser()
options.add_argument("--udp", type=int)
options.add_argument("--tcp", type=int)
options.add_argument("--key")
options.add_argument("--lag", type=float, default=0.0, help="of the rudder behind its output, s")
options.add_argument("--loss", type=float, default=0.0)
options.add_argument("--disorder", type=float, default=0.0, help="share of datagrams doubled or followed by garbage, then shuffled")
options.add_argument("--latency", type=float, default=0.0, help="there and back together, s")
options.add_argument("--mishap", default="none")
options = options.parse_args()

draw = random.Random(5)
noise = random.Random(6)


class Line:
    """UDP to a port, or TCP on a port, with what bad weather does to datagrams."""

    def __init__(self):
        self.held, self.coming, self.leaving = [], [], []
        self.clock, self.is_cut = 0.0, False
        self.socket, self.listener = None, None
        if options.udp:
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.connect(("127.0.0.1", options.udp))
        else:
            self.listener = socket.socket()
            self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self.listener.bind(("127.0.0.1", options.tcp))
            self.listener.listen()
            print("listening", flush=True)

    def write(self, data):
        if self.is_cut or draw.random() < options.loss:
            return
        self.held.append(data)
        if draw.random() < options.disorder:
            self.held.append(draw.choice([data, bytes(draw.randrange(256) for _ in range(40))]))
            if len(self.held) < 4:
                return
            draw.shuffle(self.held)
        self.leaving += [(self.clock + options.latency / 2, held) for held in self.held]
        self.held = []
        self.flush()

    def flush(self):
        while self.leaving and self.leaving[0][0] <= self.clock:
            data = self.leaving.pop(0)[1]
            try:
                if self.socket:
                    self.socket.send(data)
            except OSError:
                self.close()

    def read(self, seconds):
        """What has come, and whether anything else may."""
        ready = [each for each in (self.socket, self.listener if not self.socket else None, sys.stdin) if each]
        ready = select.select(ready, [], [], seconds)[0]
        word = None
        if sys.stdin in ready:
            word = sys.stdin.readline()
        if self.listener in ready and not self.is_cut:
            self.socket = self.listener.accept()[0]
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        elif self.socket in ready:
            try:
                data = self.socket.recv(65536)
                if not data and self.listener:
                    self.close()
                if data and not self.is_cut and draw.random() >= options.loss:
                    self.coming.append((self.clock + options.latency / 2, data))
            except OSError:
                self.close()
        data = b""
        while self.coming and self.coming[0][0] <= self.clock:
            data += self.coming.pop(0)[1]
        return data, word

    def close(self):
        if self.listener and self.socket:
            self.socket.close()
            self.socket = None

    def cut(self, is_cut):
        self.is_cut = is_cut
        self.coming, self.leaving, self.held = [], [], []
        if is_cut:
            self.close()


class Boat:
    def __init__(self, line):
        self.line = line
        self.link = m.MAVLink(line, srcSystem=1, srcComponent=1)
        self.link.robust_parsing = True
        if options.key:
            self.link.signing.secret_key = bytes.fromhex(open(options.key).read().strip())
            self.link.signing.link_id = 1
            self.link.signing.timestamp = int((time.time() - 1420070400) * 1e5)
            self.link.signing.sign_outgoing = True
            self.link.signing.allow_unsigned_callback = self.refuse
        self.parameters = {"MAV_GCS_SYSID": 255, "RC_OVERRIDE_TIME": 3, "FS_GCS_ENABLE": 0, "FS_ACTION": 2, "SCHED_LOOP_RATE": 100}
        for n in range(1, 17):
            self.parameters[f"SERVO{n}_FUNCTION"] = {1: 26, 3: 70}.get(n, 0)
        for name in ("RC1", "RC3", "SERVO1", "SERVO3"):
            self.parameters.update({f"{name}_MIN": 1100, f"{name}_TRIM": 1500, f"{name}_MAX": 1900, f"{name}_REVERSED": 0})
        self.parameters.update({"RC1_DZ": 30, "RC3_DZ": 30})
        self.original = dict(self.parameters)
        self.refused = 0
        self.told = {"happened_s": None, "held_s": 0.0, "releases": 0, "overrides": 0, "longest_gap_s": 0.0}
        self.beat_wall = None
        self.commanded = False
        self.over = False
        self.deflected = 0.0
        self.start()

    def start(self):
        self.time = 10.0
        self.line.clock = max(self.line.clock, self.time)
        self.step_number = 0
        self.mode, self.armed = HOLD, True
        self.override, self.override_time = None, -9.0
        self.heading, self.rate, self.fin, self.speed = 0.3, 0.0, 0.0, 0.0
        self.aux, self.battery = 1500, 80

    def refuse(self, link, message_id):
        self.refused += 1
        return False

    def pulse(self, channel):
        fresh = self.time - self.override_time <= self.parameters["RC_OVERRIDE_TIME"]
        if self.override and fresh and self.override[channel] not in (0, 65535):
            return self.override[channel]
        return 1500

    def stick(self, channel, name):
        off = self.pulse(channel) - 1500
        dead = self.parameters[name + "_DZ"]
        return math.copysign(min(1.0, max(0.0, abs(off) - dead) / (400.0 - dead)), off)

    def outputs(self):
        if self.mode != MANUAL or not self.armed:
            return 1500, 1500
        return round(1500 + 400 * self.stick(0, "RC1")), round(1500 + 400 * self.stick(2, "RC3"))

    def hear(self, message):
        kind = message.get_type()
        link = self.link
        if kind == "HEARTBEAT":
            now = time.monotonic()
            if self.beat_wall:
                self.told["longest_gap_s"] = max(self.told["longest_gap_s"], now - self.beat_wall)
            self.beat_wall = now
        elif kind == "RC_CHANNELS_OVERRIDE" and message.get_srcSystem() == self.parameters["MAV_GCS_SYSID"]:
            self.commanded = True
            self.told["overrides"] += 1
            self.override = [getattr(message, f"chan{n}_raw") for n in range(1, 9)]
            self.override_time = self.time
            self.told["releases"] += self.override[0] == 0 and self.override[2] == 0
        elif kind == "PARAM_REQUEST_READ" and message.param_id in self.parameters:
            link.param_value_send(message.param_id.encode(), self.parameters[message.param_id], 9, len(self.parameters), 0)
        elif kind == "PARAM_SET" and message.param_id in self.parameters:
            self.parameters[message.param_id] = message.param_value
            link.param_value_send(message.param_id.encode(), message.param_value, 9, len(self.parameters), 0)
        elif kind == "COMMAND_LONG":
            if message.command == m.MAV_CMD_DO_SET_MODE:
                self.mode = int(message.param2)
                self.beat()
            link.command_ack_send(message.command, 0)
        elif kind == "TIMESYNC" and message.tc1 == 0:
            link.timesync_send(int(self.time * 1e9), message.ts1)

    def listen(self, seconds):
        data, word = self.line.read(seconds)
        if word == "back\n":
            self.line.cut(False)
        elif word == "":
            self.over = True
        for message in self.link.parse_buffer(data) or []:
            if message.get_type() != "BAD_DATA":
                self.hear(message)

    def beat(self):
        armed = m.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        self.link.heartbeat_send(m.MAV_TYPE_SURFACE_BOAT, m.MAV_AUTOPILOT_ARDUPILOTMEGA, 1 | armed, self.mode, m.MAV_STATE_ACTIVE)

    def channels(self):
        channels = [self.pulse(0), 1500, self.pulse(2), 1500, 1500, 1500, self.aux, 1500] + [0] * 10
        self.link.rc_channels_send(round(1000 * self.time), 8, *channels, 255)

    def charge(self):
        self.link.sys_status_send(0, 0, 0, 0, 12000, -1, self.battery, 0, 0, 0, 0, 0, 0)

    def suffer(self):
        """The mishap, and what tells of it."""
        mishap = options.mishap
        self.told["held_s"] = 0.0
        if mishap == "mode":
            self.mode = HOLD
            self.beat()
        elif mishap == "stick":
            self.aux = 1900
            self.channels()
        elif mishap == "battery":
            self.battery = 3
            self.charge()
        elif mishap == "failsafe":
            self.link.statustext_send(2, b"EKF failsafe")
        elif mishap == "disarm":
            self.armed = False
            self.beat()
            self.beat()
        elif mishap == "reboot":
            self.start()
        elif mishap == "cut":
            self.line.cut(True)
        elif mishap == "station":
            station = m.MAVLink(self.line, srcSystem=255, srcComponent=1)
            station.heartbeat_send(m.MAV_TYPE_GCS, m.MAV_AUTOPILOT_INVALID, 0, 0, 4)
        elif mishap == "unsigned":
            forged = m.MAVLink(self.line, srcSystem=1, srcComponent=1)
            forged.heartbeat_send(m.MAV_TYPE_SURFACE_BOAT, m.MAV_AUTOPILOT_ARDUPILOTMEGA, 1, 15, 4)
            forged.attitude_send(1, 0, 0, 2.0, 0, 0, 0)
        self.told["happened_s"] = self.time

    def step(self):
        steering, throttle = self.outputs()
        self.report(steering, throttle)
        asked = FULL * (steering - 1500) / 400
        is_doublet = abs(steering - 1500) > 400 * DOUBLET
        self.deflected = self.deflected + STEP if is_doublet else 0.0
        if self.told["happened_s"] is None and options.mishap != "none" and self.deflected >= 0.5:
            self.suffer()
        elif self.told["happened_s"] is not None and abs(self.pulse(0) - 1500) > 50:
            # Whatever its mode makes of it: this is what it is still asked for.
            self.told["held_s"] = self.time - self.told["happened_s"]
        self.turn(asked if self.mode == MANUAL else -0.5 * self.heading - self.rate)
        self.speed += (1.2 * (throttle - 1500) / 400 - self.speed) * STEP / 2
        self.time = round(self.time + STEP, 6)
        self.line.clock = max(self.line.clock + STEP, self.time)
        self.line.flush()
        self.step_number += 1

    def turn(self, asked):
        """Exactly, for a rudder that comes behind what it is asked for like exp(-t / lag)."""
        lag = options.lag
        level = -(B2 * asked + C0) / A22
        if lag > 0:
            # The part of the rate that decays with the rudder's own lag.
            swing = B2 * (self.fin - asked) / (-1 / lag - A22)
            fast, self.fin = math.exp(-STEP / lag), asked + (self.fin - asked) * math.exp(-STEP / lag)
        else:
            swing, fast, self.fin = 0.0, 0.0, asked
        slow = self.rate - level - swing
        decay = math.exp(A22 * STEP)
        self.heading += level * STEP + slow * (decay - 1) / A22 + swing * lag * (1 - fast)
        self.heading = (self.heading + math.pi) % (2 * math.pi) - math.pi
        self.rate = level + swing * fast + slow * decay

    def report(self, steering, throttle):
        n, link = self.step_number, self.link
        if n % PER_OUTPUT == 0:
            link.servo_output_raw_send(round(1e6 * self.time) % 2**32, 0, steering, 0, throttle, 0, 0, 0, 0, 0)
        if n % 100 == 0:
            self.beat()
            self.charge()
            link.gps_raw_int_send(0, 3, 0, 0, 0, 80, 80, 0, 0, 12)
            link.ekf_status_report_send(0x1F, 0.1, 0.1, 0.1, 0.1, 0)
        if n % 20 == 0:
            link.vfr_hud_send(0, self.speed, 0, 0, 0, 0)
            self.channels()
        if n % PER_ATTITUDE == 0:
            heading = self.heading + noise.gauss(0, 0.002)
            link.attitude_send(round(1000 * self.time), 0, 0, heading, 0, 0, self.rate)
            self.answer()

    def answer(self):
        """Waits for the command that answers the attitude, not for ever."""
        is_commanded = self.time - self.override_time < 0.5
        end = time.monotonic() + (ANSWER if is_commanded else ALONE)
        self.commanded = False
        while not self.over:
            left = end - time.monotonic()
            if left <= 0 or self.commanded:
                return
            self.listen(left)

    def run(self):
        while not self.over:
            self.step()
        changed = {name: value for name, value in self.parameters.items() if value != self.original[name]}
        self.told.update(changed=changed, mode=self.mode, steering=self.outputs()[0], throttle=self.outputs()[1])
        self.told.update(refused=self.refused, time_s=self.time)
        print(json.dumps(self.told), flush=True)


Boat(Line()).run()
