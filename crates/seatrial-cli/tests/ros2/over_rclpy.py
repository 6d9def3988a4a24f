"""Topics and services over ROS 2 itself: a node of rclpy on rmw_fastrtps."""

import collections
import importlib
import os
import threading
from dataclasses import fields, is_dataclass

# This machine alone.
os.environ.update(RMW_IMPLEMENTATION="rmw_fastrtps_cpp", ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, QoSReliabilityPolicy

from messages import ros_name

RELIABLE = QoSProfile(depth=64, reliability=QoSReliabilityPolicy.RELIABLE)
SENSOR = QoSProfile(depth=64, reliability=QoSReliabilityPolicy.BEST_EFFORT)


def ros_type(kind):
    package, folder, name = ros_name(kind).split("/")
    return getattr(importlib.import_module(f"{package}.{folder}"), name)


def ros_service(name):
    return getattr(importlib.import_module("std_srvs.srv"), name)


def filled(message, value):
    """A message of ROS with what a message of the vehicle says."""
    known = message.get_fields_and_field_types()
    for field in fields(value):
        part = getattr(value, field.name)
        if is_dataclass(part):
            filled(getattr(message, field.name), part)
        elif field.name in known:
            setattr(message, field.name, part)
    return message


class Queue:
    """What came since the last look, put in by the thread of the node."""

    def __init__(self):
        self.waiting = collections.deque()

    def put(self, message):
        self.waiting.append(message)

    def taken(self):
        return [self.waiting.popleft() for _ in range(len(self.waiting))]


class Writer:
    def __init__(self, publisher, kind):
        self.publisher, self.kind = publisher, kind

    def write(self, value):
        self.publisher.publish(filled(self.kind(), value))


class Server(Queue):
    def asked(self, request, response):
        is_answered = threading.Event()

        def answer(value):
            filled(response, value)
            is_answered.set()

        self.waiting.append((request, answer))
        is_answered.wait()
        return response


class Client(Queue):
    def __init__(self, client, request):
        super().__init__()
        self.client, self.request = client, request

    def call(self, value):
        future = self.client.call_async(filled(self.request(), value))
        future.add_done_callback(lambda future: self.waiting.append(future.result()))


class Graph:
    def __init__(self, domain):
        rclpy.init(domain_id=domain)
        self.node = rclpy.create_node("boat")
        threading.Thread(target=self.spin, daemon=True).start()

    def spin(self):
        try:
            rclpy.spin(self.node)
        except ExternalShutdownException:
            pass

    def writer(self, name, kind, is_reliable):
        kind = ros_type(kind)
        publisher = self.node.create_publisher(kind, name, RELIABLE if is_reliable else SENSOR)
        return Writer(publisher, kind)

    def reader(self, name, kind):
        queue = Queue()
        self.node.create_subscription(ros_type(kind), name, queue.put, RELIABLE)
        return queue

    def server(self, name, service):
        server = Server()
        self.node.create_service(ros_service(service), name, server.asked)
        return server

    def client(self, name, service):
        kind = ros_service(service)
        return Client(self.node.create_client(kind, name), kind.Request)
