"""Drives the robot /zeromq of control_types.toml: method 5, the ZeroMQ remote API of CoppeliaSim.

    pip install coppeliasim-zmqremoteapi-client
    python3 zeromq_client.py [PORT]

Each line that begins with `sim.` calls a command in the simulator; its result is returned over the socket.
"""
import sys
import time

from coppeliasim_zmqremoteapi_client import RemoteAPIClient

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 23000
AHEAD = (5.0, 5.0)          # rad/s, left and right wheel
BACK = (-2.5, -0.625)       # rad/s
BACK_TIME = 3.0             # s

sim = RemoteAPIClient(port=PORT).require('sim')
left = sim.getObject('/zeromq/leftMotor')
right = sim.getObject('/zeromq/rightMotor')
nose = sim.getObject('/zeromq/sensingNose')
back_until = 0.0            # s, simulation time

while True:
    now = sim.getSimulationTime()
    if sim.readProximitySensor(nose)[0] == 1:
        back_until = now + BACK_TIME
    wheels = BACK if now < back_until <= now + BACK_TIME else AHEAD
    sim.setJointTargetVelocity(left, wheels[0])
    sim.setJointTargetVelocity(right, wheels[1])
    sim.setInt32Signal('zeromq', 1)     # alive: waits.lua stops the robot without it
    time.sleep(0.02)
