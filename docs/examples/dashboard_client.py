"""Runs a trial on the simulator over the dashboard's programming interface: python3 dashboard_client.py http://127.0.0.1:8042"""

import json, sys, time, urllib.request

def call(method, path, body=None, lease=""):
    headers = {"Content-Type": "application/json", "seatrial-lease": lease}
    data = json.dumps(body).encode() if body is not None else None
    request = urllib.request.Request(sys.argv[1].rstrip("/") + "/api/v1" + path, data, headers, method=method)
    return json.load(urllib.request.urlopen(request, timeout=30))

lease = call("POST", "/control", {"name": "example"})["lease"]
trial = call("POST", "/trial", {"vehicle": "sim:starfish", "seed": 1}, lease)
while call("GET", "/status", lease=lease)["trial"]["running"]:
    time.sleep(0.1)
for run in call("GET", f"/campaigns/{trial['campaign']}")["runs"]:
    a22, word = run["model"]["a22_per_s"], "accepted" if run["accepted"] else "rejected"
    print(f"{run['thrust']:.0%} thrust: a22 {a22['value']:.3f} 1/s, 95 % {a22['interval_95']}, {word}")
call("DELETE", "/control", lease=lease)
