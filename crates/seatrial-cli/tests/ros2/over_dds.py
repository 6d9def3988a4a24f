"""Topics and services over CycloneDDS, as rmw_cyclonedds has them."""

import itertools
import typing

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import int64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from messages import SERVICES

# This machine alone: no multicast, nothing announced elsewhere.
CONFIGURATION = """<CycloneDDS><Domain><General>
<Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""

RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(64))
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(64))


def numbered(kind):
    """A request or response as rmw_cyclonedds carries it: who asked and which question, then what."""
    fields = typing.get_type_hints(kind, include_extras=True)
    fields = {"client": int64, "number": int64, **fields}
    return make_idl_struct(kind.__name__, kind.__idl__.idl_transformed_typename, fields)


def content(message, kind):
    return kind(*(getattr(message, name) for name in typing.get_type_hints(kind)))


class Reader:
    def __init__(self, reader):
        self.reader = reader

    def taken(self):
        """What came; the end of a publisher comes as a sample without data."""
        return [sample for sample in self.reader.take(64) if sample.sample_info.valid_data]


class Server:
    def __init__(self, requests, responses, request, response):
        self.requests, self.responses = requests, responses
        self.request, self.response = request, response

    def taken(self):
        return [(content(asked, self.request), self.answer(asked)) for asked in self.requests.taken()]

    def answer(self, asked):
        def write(response):
            fields = vars(response).values()
            self.responses.write(self.response(asked.client, asked.number, *fields))

        return write


class Client:
    def __init__(self, requests, responses, request):
        self.requests, self.responses, self.request = requests, responses, request
        self.numbers = itertools.count(1)

    def call(self, request):
        self.requests.write(self.request(77, next(self.numbers), *vars(request).values()))

    def taken(self):
        return self.responses.taken()


class Graph:
    def __init__(self, domain):
        self.domain = Domain(domain, CONFIGURATION)
        self.participant = DomainParticipant(domain)

    def raw_writer(self, name, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, name, kind), qos=qos)

    def raw_reader(self, name, kind):
        return Reader(DataReader(self.participant, Topic(self.participant, name, kind), qos=RELIABLE))

    def writer(self, name, kind, is_reliable):
        return self.raw_writer(f"rt{name}", kind, RELIABLE if is_reliable else SENSOR)

    def reader(self, name, kind):
        return self.raw_reader(f"rt{name}", kind)

    def server(self, name, service):
        request, response = SERVICES[service]
        requests = self.raw_reader(f"rq{name}Request", numbered(request))
        response = numbered(response)
        return Server(requests, self.raw_writer(f"rr{name}Reply", response, RELIABLE), request, response)

    def client(self, name, service):
        request, response = map(numbered, SERVICES[service])
        requests = self.raw_writer(f"rq{name}Request", request, RELIABLE)
        return Client(requests, self.raw_reader(f"rr{name}Reply", response), request)
