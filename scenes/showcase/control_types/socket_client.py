"""Drives the robot /socket of control_types.toml: method 4, a custom protocol.

    python3 socket_client.py [PORT]

The other side is socket_server.lua, the script of the robot: it sends a line "TIME SEEN" in each step and accepts lines
"LEFT RIGHT".
"""
import socket
import sys

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 20000
AHEAD = (5.0, 5.0)          # rad/s, left and right wheel
BACK = (-2.5, -0.625)       # rad/s
BACK_TIME = 3.0             # s

lines = socket.create_connection(('127.0.0.1', PORT)).makefile('rw')
back_until = 0.0            # s, simulation time

for line in lines:
    now, seen = (float(number) for number in line.split())
    if seen:
        back_until = now + BACK_TIME
    wheels = BACK if now < back_until <= now + BACK_TIME else AHEAD
    print(*wheels, file=lines, flush=True)
