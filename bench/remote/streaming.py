#!/usr/bin/env python3
"""Measures how much twenty streaming clients slow down a step, in runs with and without them, alternately.

    bench/remote/streaming.py target/release/tatu

Each rosbridge client subscribes to odometry, pose, joints and one sonar, in a run in real time. Requires only Python.
On two cores, the ratio was 1.2 to 1.4: 0.16 ms for 80 messages, compared with a step of 0.45 ms."""

import json, re, select, socket, statistics, subprocess, sys, threading

TATU = sys.argv[1]
SCENE = "scenes/first/pioneer_avoids_walls.toml"
CLIENTS, SECONDS, PAIRS = 20, 10, 3
TOPICS = ["/odom", "/pose", "/joint_states", "/Pioneer_p3dx/Pioneer_p3dx_ultrasonicSensor4/range"]


def frame(text):
    """Returns a WebSocket text frame of a client, with the mask 0."""
    data = text.encode()
    return bytes([0x81, 0x80 | len(data)]) + bytes(4) + data


def client(port):
    s = socket.create_connection(("127.0.0.1", port))
    key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
    s.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n{key}\r\n".encode())
    while b"\r\n\r\n" not in s.recv(1):
        if s.recv(4096).endswith(b"\r\n\r\n"):
            break
    for topic in TOPICS:
        s.sendall(frame(json.dumps({"op": "subscribe", "topic": topic})))
    return s


def run(clients):
    """Returns the median duration of a step in ms, and the number of bytes received."""
    args = [TATU, "run", SCENE, "--seconds", str(SECONDS), "--realtime", "--json", "--service", "rosbridge:port=0"]
    process = subprocess.Popen(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    port = None
    while port is None:
        port = re.search(r"listening on 127\.0\.0\.1:(\d+)", process.stderr.readline())
    threading.Thread(target=process.stderr.read, daemon=True).start()
    sockets = [client(int(port[1])) for _ in range(clients)]
    came = 0
    while sockets and process.poll() is None:
        for s in select.select(sockets, [], [], 0.5)[0]:
            data = s.recv(1 << 16)
            came += len(data)
            if not data:
                sockets.remove(s)
    told = json.loads(process.stdout.read())
    return told["step_wall_s"]["median"] * 1e3, came


pairs = []
for _ in range(PAIRS):
    (without, _), (streaming, came) = run(0), run(CLIENTS)
    pairs.append(streaming / without)
    print(f"without {without:.3f} ms, with {CLIENTS} clients {streaming:.3f} ms: {pairs[-1]:.3f} ({came / SECONDS / 1e3:.0f} kB/s)")
print(f"median of {PAIRS}: {statistics.median(pairs):.3f}")
