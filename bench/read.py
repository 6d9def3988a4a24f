"""Reads a log to its end with its format's own library; prints messages, seconds of processor time and MB of memory."""

import resource
import sys
import time

path = sys.argv[1]
count = 0
if path.endswith(".mcap"):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _ in reader.iter_decoded_messages():
            count += 1
else:
    from pymavlink import mavutil

    log = mavutil.mavlink_connection(path)
    while log.recv_match() is not None:
        count += 1
seconds = time.process_time()
print(count, f"{seconds:.3f}", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1000)
