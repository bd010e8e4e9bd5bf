"""Drives the robot /ros of control_types.toml: method 7, ROS over rosbridge. No ROS installation is required.

    pip install websocket-client
    python3 ros_client.py [PORT]

It subscribes to /ros/range (sensor_msgs/Range) and publishes /ros/cmd_vel (geometry_msgs/Twist). `roslibpy` and
`roslibjs` write the same JSON.
"""
import json
import sys

import websocket

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 9090
RADIUS, TRACK = 0.04, 0.2   # m, of the wheels and between them
AHEAD = (5.0, 5.0)          # rad/s, left and right wheel
BACK = (-2.5, -0.625)       # rad/s
BACK_TIME = 3.0             # s

ros = websocket.create_connection(f'ws://127.0.0.1:{PORT}')


def send(**message):
    ros.send(json.dumps(message))


send(op='subscribe', topic='/ros/range', type='sensor_msgs/Range')
send(op='advertise', topic='/ros/cmd_vel', type='geometry_msgs/Twist')
back_until = 0.0            # s, simulation time

while True:
    message = json.loads(ros.recv())['msg']     # one message per measurement
    stamp = message['header']['stamp']
    now = stamp['secs'] + stamp['nsecs'] / 1e9
    if message['range'] is not None:            # JSON has no infinity: null is no echo
        back_until = now + BACK_TIME
    left, right = BACK if now < back_until <= now + BACK_TIME else AHEAD
    linear, angular = RADIUS * (left + right) / 2, RADIUS * (right - left) / TRACK      # m/s, rad/s
    send(op='publish', topic='/ros/cmd_vel', msg={'linear': {'x': linear}, 'angular': {'z': angular}})
