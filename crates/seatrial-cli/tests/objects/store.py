"""A server of S3 (moto), a proxy before it that cuts connections, and a server of HTTPS for a folder.

Prints a line of JSON with their ports. Then each line of standard input is a command, and `done` answers it:
`cut N` cuts so many connections, each in the middle of a list of objects or of an object; `left` answers how many are not cut yet; `put KEY FILE` and
`get KEY FILE` copy.
"""

import datetime
import functools
import http.server
import ipaddress
import json
import logging
import pathlib
import socket
import socketserver
import ssl
import sys
import threading

import boto3
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from moto.server import ThreadedMotoServer

folder = pathlib.Path(sys.argv[1])
bucket = "boats"
# Behind the head of an answer, and before the end of a log and of a list of logs.
CUT_AFTER_BYTES = 4_000
cuts = 0
long_answers = 0
lock = threading.Lock()


class Proxy(socketserver.BaseRequestHandler):
    """Passes bytes on in both directions."""

    def handle(self):
        with socket.create_connection(("127.0.0.1", s3_port)) as server:
            asking = threading.Thread(target=self.ask, args=(server,), daemon=True)
            asking.start()
            self.answered, self.is_long = 0, False
            while piece := server.recv(4096):
                self.answered += len(piece)
                became_long = self.answered > CUT_AFTER_BYTES and not self.is_long
                self.is_long = self.is_long or became_long
                if became_long and take_a_cut():
                    self.request.shutdown(socket.SHUT_RDWR)
                    return
                self.request.sendall(piece)

    def ask(self, server):
        try:
            while piece := self.request.recv(4096):
                self.answered, self.is_long = 0, False
                server.sendall(piece)
            server.shutdown(socket.SHUT_WR)
        except OSError:
            pass


def take_a_cut():
    """Of long answers each fourth one: of two cuts the first is in a list of logs, the second in a log."""
    global cuts, long_answers
    with lock:
        long_answers += 1
        is_cut = cuts > 0 and long_answers % 4 == 1
        cuts -= is_cut
        return is_cut


def certificate():
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "localhost")])
    now = datetime.datetime.now(datetime.timezone.utc)
    address = x509.IPAddress(ipaddress.ip_address("127.0.0.1"))
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([address]), critical=False)
        .sign(key, hashes.SHA256())
    )
    pem = made.public_bytes(serialization.Encoding.PEM)
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    (folder / "certificate.pem").write_bytes(pem)
    (folder / "both.pem").write_bytes(secret + pem)


class Files(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


logging.getLogger("werkzeug").setLevel(logging.ERROR)
moto = ThreadedMotoServer(port=0, verbose=False)
moto.start()
s3_port = moto.get_host_and_port()[1]
client = boto3.client(
    "s3",
    endpoint_url=f"http://127.0.0.1:{s3_port}",
    region_name="us-east-1",
    aws_access_key_id="someone",
    aws_secret_access_key="secret",
)
client.create_bucket(Bucket=bucket)

proxy = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Proxy)
certificate()
web = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Files, directory=folder))
context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
context.load_cert_chain(folder / "both.pem")
web.socket = context.wrap_socket(web.socket, server_side=True)
for server in (proxy, web):
    threading.Thread(target=server.serve_forever, daemon=True).start()
ports = {"s3": s3_port, "proxy": proxy.server_address[1], "https": web.server_address[1]}
print(json.dumps(ports), flush=True)

for line in sys.stdin:
    command, *rest = line.split()
    if command == "cut":
        cuts = int(rest[0])
    elif command == "left":
        print(cuts, flush=True)
        continue
    elif command == "put":
        client.upload_file(rest[1], bucket, rest[0])
    elif command == "get":
        client.download_file(bucket, *rest)
    print("done", flush=True)
