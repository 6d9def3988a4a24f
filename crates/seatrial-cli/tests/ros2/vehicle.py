"""A first-order vehicle on ROS 2, played with implementations of its middlewares other than seatrial's: CycloneDDS,
Eclipse's zenoh for Python, or ROS 2's own rclpy.

Steers as psi'' = A22 psi' + B2 delta + C0 through a rudder of limited rate and lag. Everything is published and called by the
names and types that ROS 2's middlewares use; only rclpy needs an installed ROS. Says `ready` and `training` on standard output, and at its
end what it saw.

usage: vehicle.py dds|zenoh|rclpy DOMAIN MISHAP [AT_S]

Mishaps, AT_S seconds after the first training rudder: none; abort and disable call a service of seatrial's; killed ends this
process; second has another publisher of rudders. two_thrusters and two_thrusters_abort: the boat is in the namespace /boat, steers by its
two thrusters and measures no rudder.
"""

import importlib
import json
import math
import os
import random
import sys
import threading
import time

from messages import (
    DiagnosticArray,
    Float64,
    Float64MultiArray,
    Header,
    JointState,
    Odometry,
    Quaternion,
    SetBoolRequest,
    SetBoolResponse,
    Time,
    TriggerRequest,
    Twist,
    Vector3,
)

A22, B2, C0 = -1.3, 1.5, 0.02
INTERVAL_S = 0.05
STEP_S = 0.005
TIMEOUT_S = 0.5
RUDDER_LAG_S = 0.02
SURGE_S = 0.5
HEADING_NOISE_RAD = 0.002


class Vehicle:
    def __init__(self, graph, mishap, at_s):
        self.graph, self.at_s = graph, at_s
        self.has_thrusters = mishap.startswith("two_thrusters")
        self.mishap = mishap.removeprefix("two_thrusters").lstrip("_")
        namespace = "/boat" if self.has_thrusters else ""
        self.odometry = graph.writer("/boat/odometry" if self.has_thrusters else "/odom", Odometry, False)
        self.joints = graph.writer("/joint_states", JointState, False)
        sides = ("thrusters/left/thrust", "thrusters/right/thrust")
        commands = sides if self.has_thrusters else ("rudder/command", "thrust/command")
        self.rudder, self.thrust = (graph.reader(f"{namespace}/{name}", Float64) for name in commands)
        self.estimates = graph.reader(f"{namespace}/seatrial/estimate", Float64MultiArray)
        self.diagnostics = graph.reader("/diagnostics", DiagnosticArray)
        self.enable = graph.server("/boat/enable", "SetBool")
        self.abort = graph.client(f"{namespace}/seatrial/abort", "Trigger")
        self.trial = graph.client(f"{namespace}/seatrial/enable", "SetBool")
        self.left, self.right = 0.0, 0.0
        self.random = random.Random(1)
        self.yaw_rad, self.rate_rad_s = 0.4, 0.0
        self.rudder_rad, self.speed_m_s = 0.0, 0.0
        self.asked_rad, self.asked_thrust = 0.0, 0.0
        self.heard_s = -math.inf
        self.is_enabled = False
        self.mishap_s = None
        self.second = None
        self.seen = {"rudders": 0, "estimates": 0, "diagnoses": [], "enables": [], "answers": []}

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

    def commands(self):
        """Rudders in degrees to port, and thrusts."""
        if not self.has_thrusters:
            rudders = [command.data for command in self.rudder.taken()]
            return rudders, [command.data for command in self.thrust.taken()]
        left, right = self.rudder.taken(), self.thrust.taken()
        if not left and not right:
            return [], []
        self.left = left[-1].data if left else self.left
        self.right = right[-1].data if right else self.right
        return [-math.degrees(0.5 * (self.left - self.right))], [0.5 * (self.left + self.right)]

    def listen(self):
        now_s = time.monotonic()
        rudders, thrusts = self.commands()
        for rudder in rudders:
            self.asked_rad = -math.radians(rudder)
            self.heard_s = now_s
            self.seen["rudders"] += 1
            self.seen["last_rudder"] = rudder
            if rudder != 0.0:
                self.seen["steered_at"] = time.time()
            if self.mishap_s is None and abs(rudder) > 12.0:
                self.mishap_s = now_s + self.at_s
                print("training", flush=True)
        for thrust in thrusts:
            self.asked_thrust = thrust
            self.seen["last_thrust"] = thrust
        for request, answer in self.enable.taken():
            self.is_enabled = request.data
            self.seen["enables"].append(request.data)
            answer(SetBoolResponse(True, "done"))
        for estimate in self.estimates.taken():
            self.seen["estimates"] += 1
            numbers = (number if math.isfinite(number) else None for number in estimate.data)
            self.seen["estimate"] = dict(zip(estimate.layout.dim[0].label.split(","), numbers))
        for diagnosis in self.diagnostics.taken():
            text = diagnosis.status[0].message
            if [text] != self.seen["diagnoses"][-1:]:
                self.seen["diagnoses"].append(text)
        for response in self.abort.taken() + self.trial.taken():
            self.seen["answers"].append(response.success)

    def befall(self):
        if self.mishap_s is None or time.monotonic() < self.mishap_s:
            return
        self.mishap_s = math.inf
        self.seen["mishap_at"] = time.time()
        if self.mishap == "abort":
            self.abort.call(TriggerRequest())
        elif self.mishap == "disable":
            self.trial.call(SetBoolRequest(False))
        elif self.mishap == "killed":
            self.say()
            os.kill(os.getpid(), 9)
        elif self.mishap == "second":
            self.second = self.graph.writer("/rudder/command", Float64, True)

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
    middleware, domain, mishap, *at_s = sys.argv[1:]
    graph = importlib.import_module(f"over_{middleware}").Graph(int(domain))
    vehicle = Vehicle(graph, mishap, float(at_s[0]) if at_s else 1.0)

    # Ends with a line on, or the end of, standard input.
    def wait():
        sys.stdin.readline()
        is_over.set()

    threading.Thread(target=wait, daemon=True).start()
    print("ready", flush=True)
    vehicle.run(is_over)
    vehicle.say()


main()
