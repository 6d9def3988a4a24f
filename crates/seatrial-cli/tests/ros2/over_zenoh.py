"""Topics and services over zenoh, as rmw_zenoh has them; listens on the loopback, as its router would."""

import hashlib
import itertools
import struct
import time

import zenoh

from messages import SERVICES, message_hash, service_hash

ROUTER_PORT = 7447
# What is attached to each message: its number, the time, who.
ATTACHMENT = struct.Struct("<qqB16s")


def read_attachment(attachment):
    """None: rmw_zenoh does not take such a message."""
    if attachment is None or len(attachment.to_bytes()) != ATTACHMENT.size:
        return None
    number, time_ns, length, who = ATTACHMENT.unpack(attachment.to_bytes())
    return (number, who) if length == 16 and number > 0 and time_ns > 0 else None


def attachment(number, who):
    return ATTACHMENT.pack(number, time.time_ns(), 16, who)


def drained(channel):
    """What has come, until nothing has or nothing more can."""
    try:
        while (item := channel.try_recv()) is not None:
            yield item
    except zenoh.ZError:
        return


class Writer:
    def __init__(self, publisher, token, who):
        self.publisher, self.token, self.who = publisher, token, who
        self.numbers = itertools.count(1)

    def write(self, message):
        self.publisher.put(message.serialize(), attachment=attachment(next(self.numbers), self.who))


class Reader:
    def __init__(self, subscriber, token, kind):
        self.subscriber, self.token, self.kind = subscriber, token, kind

    def taken(self):
        samples = [sample for sample in drained(self.subscriber) if read_attachment(sample.attachment)]
        return [self.kind.deserialize(sample.payload.to_bytes()) for sample in samples]


class Server:
    def __init__(self, queryable, token, request):
        self.queryable, self.token, self.request = queryable, token, request

    def taken(self):
        queries = [query for query in drained(self.queryable) if read_attachment(query.attachment)]
        return [(self.request.deserialize(query.payload.to_bytes()), self.answer(query)) for query in queries]

    @staticmethod
    def answer(query):
        def reply(response):
            origin = attachment(*read_attachment(query.attachment))
            query.reply(query.key_expr, response.serialize(), attachment=origin)
            query.drop()

        return reply


class Client:
    def __init__(self, session, key, token, who, response):
        self.session, self.key, self.token, self.who, self.response = session, key, token, who, response
        self.numbers = itertools.count(1)
        self.replies = None

    def call(self, request):
        self.replies = self.session.get(
            self.key,
            payload=request.serialize(),
            attachment=attachment(next(self.numbers), self.who),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
        )

    def taken(self):
        answers = [reply.ok for reply in drained(self.replies) if reply.ok] if self.replies else []
        ours = [answer for answer in answers if (read_attachment(answer.attachment) or [None, None])[1] == self.who]
        return [self.response.deserialize(answer.payload.to_bytes()) for answer in ours]


class Graph:
    def __init__(self, domain):
        self.domain = domain
        configuration = {
            "mode": '"peer"',
            "listen/endpoints": f'["tcp/127.0.0.1:{ROUTER_PORT + domain}"]',
            "scouting/multicast/enabled": "false",
        }
        config = zenoh.Config()
        for key, value in configuration.items():
            config.insert_json5(key, value)
        self.session = zenoh.open(config)
        self.entities = itertools.count(1)
        self.node = self.session.liveliness().declare_token(self.token_key("0/0/NN"))

    def token_key(self, what, *rest):
        return "/".join([f"@ros2_lv/{self.domain}/{self.session.zid()}/{what}/%/%/vehicle", *rest])

    def announced(self, role, name, type_name, type_hash, reliability=""):
        """The token of an entity and who it is."""
        what = f"0/{next(self.entities)}/{role}"
        key = self.token_key(what, name.replace("/", "%"), type_name, type_hash, f"{reliability}::,64:,:,:,,")
        return self.session.liveliness().declare_token(key), hashlib.md5(key.encode()).digest()

    def topic(self, kind):
        return kind.__idl__.idl_transformed_typename, message_hash(kind)

    def service(self, service):
        return f"std_srvs::srv::dds_::{service}_", service_hash(service)

    def key(self, name, type_name, type_hash):
        return f"{self.domain}{name}/{type_name}/{type_hash}"

    def writer(self, name, kind, is_reliable):
        topic = self.topic(kind)
        publisher = self.session.declare_publisher(self.key(name, *topic))
        return Writer(publisher, *self.announced("MP", name, *topic, "" if is_reliable else "2"))

    def reader(self, name, kind):
        topic = self.topic(kind)
        subscriber = self.session.declare_subscriber(self.key(name, *topic), zenoh.handlers.RingChannel(64))
        return Reader(subscriber, self.announced("MS", name, *topic), kind)

    def server(self, name, service):
        entity, (request, _) = self.service(service), SERVICES[service]
        channel = zenoh.handlers.FifoChannel(64)
        queryable = self.session.declare_queryable(self.key(name, *entity), channel, complete=True)
        return Server(queryable, self.announced("SS", name, *entity), request)

    def client(self, name, service):
        entity, (_, response) = self.service(service), SERVICES[service]
        return Client(self.session, self.key(name, *entity), *self.announced("SC", name, *entity), response)
