"""Drives the robot /jsonl of control_types.toml: method 8, lines of JSON. It requires only Python's standard library.

    python3 jsonl_client.py [PORT]

Any language with sockets can use this protocol: one line with a call, one line with its result.
"""
import json
import socket
import sys
import time

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 23300
AHEAD = (5.0, 5.0)          # rad/s, left and right wheel
BACK = (-2.5, -0.625)       # rad/s
BACK_TIME = 3.0             # s

lines = socket.create_connection(('127.0.0.1', PORT)).makefile('rw')


def call(command, *args):
    """Calls a command of the simulator, and returns its first result."""
    print(json.dumps({'call': command, 'args': args}), file=lines, flush=True)
    answer = json.loads(lines.readline())
    if 'error' in answer:
        sys.exit(f"{command}: {answer['error']['text']}")
    return (answer['result'] or [None])[0]


left = call('sim.getObject', '/jsonl/leftMotor')
right = call('sim.getObject', '/jsonl/rightMotor')
nose = call('sim.getObject', '/jsonl/sensingNose')
back_until = 0.0            # s, simulation time

while True:
    now = call('sim.getSimulationTime')
    if call('sim.readProximitySensor', nose) == 1:
        back_until = now + BACK_TIME
    wheels = BACK if now < back_until <= now + BACK_TIME else AHEAD
    call('sim.setJointTargetVelocity', left, wheels[0])
    call('sim.setJointTargetVelocity', right, wheels[1])
    call('sim.setInt32Signal', 'jsonl', 1)      # alive: waits.lua stops the robot without it
    time.sleep(0.02)
