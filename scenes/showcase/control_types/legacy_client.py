"""Drives the robot /legacy of control_types.toml: method 6, the legacy remote API of V-REP (`simx...`).

    pip install pypot               it contains V-REP's library and its binding, vrep.py
    python3 legacy_client.py [PORT]

With an installation of V-REP or CoppeliaSim, use `import vrep` or `import sim as vrep` beside its library instead.
"""
import sys
import time

from pypot.vrep.remoteApiBindings import vrep

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 19997
AHEAD = (5.0, 5.0)          # rad/s, left and right wheel
BACK = (-2.5, -0.625)       # rad/s
BACK_TIME = 3.0             # s
WAIT, STREAM, BUFFER, SEND = (vrep.simx_opmode_blocking, vrep.simx_opmode_streaming, vrep.simx_opmode_buffer,
                              vrep.simx_opmode_oneshot)

client = vrep.simxStart('127.0.0.1', PORT, True, False, 5000, 5)
if client < 0:
    sys.exit(f'no legacy remote API on port {PORT}')
left, right, nose = (vrep.simxGetObjectHandle(client, '/legacy/' + part, WAIT)[1]
                     for part in ('leftMotor', 'rightMotor', 'sensingNose'))
vrep.simxReadProximitySensor(client, nose, STREAM)      # from now on, the simulator sends it in each step
back_until = 0.0            # s, simulation time

while vrep.simxGetConnectionId(client) >= 0:
    error, seen, *_ = vrep.simxReadProximitySensor(client, nose, BUFFER)      # the last value received, without waiting
    now = vrep.simxGetLastCmdTime(client) / 1000
    if error == vrep.simx_return_ok and seen:
        back_until = now + BACK_TIME
    wheels = BACK if now < back_until <= now + BACK_TIME else AHEAD
    vrep.simxSetJointTargetVelocity(client, left, wheels[0], SEND)
    vrep.simxSetJointTargetVelocity(client, right, wheels[1], SEND)
    vrep.simxSetIntegerSignal(client, 'legacy', 1, SEND)     # alive: waits.lua stops the robot without it
    time.sleep(0.02)
