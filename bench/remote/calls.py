"""Measures a call by the real ZeroMQ client, alternately to Tatu and to a pyzmq server with fixed answers.

    python bench/remote/calls.py [--program target/release/tatu] [--calls 3000]

Requires the package coppeliasim-zmqremoteapi-client. Prints the ratio of the two times, which was 0.85 to 1.01 on two
cores.
"""
import argparse
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = os.path.join(HERE, "../../scenes/first/pioneer_avoids_walls.toml")

CANNED = """
import sys, cbor, zmq
socket = zmq.Context().socket(zmq.REP)
socket.bind('tcp://127.0.0.1:' + sys.argv[1])
while True:
    func = cbor.loads(socket.recv())['func']
    if func == 'zmqRemoteApi.info':
        result = [{'getObjectPosition': {'func': {}}}]
    else:
        result = [] if func == 'zmqRemoteApi.require' else [[1.0, 2.0, 3.0]]
    socket.send(cbor.dumps({'ret': result}))
"""


def per_call(sim, handle, calls):
    begin = time.perf_counter()
    for _ in range(calls):
        sim.getObjectPosition(handle)
    return (time.perf_counter() - begin) / calls * 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", default=os.path.join(HERE, "../../target/release/tatu"))
    parser.add_argument("--calls", type=int, default=3000)
    parser.add_argument("--port", type=int, default=23050)
    args = parser.parse_args()
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    service = "zmq_remote:port=%d" % args.port
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    servers = [
        subprocess.Popen([args.program, "serve", SCENE, "--service", service], **quiet),
        subprocess.Popen([sys.executable, "-c", CANNED, str(args.port + 10)], **quiet),
    ]
    try:
        time.sleep(1.5)
        ours = RemoteAPIClient("localhost", args.port).require("sim")
        canned = RemoteAPIClient("localhost", args.port + 10).require("sim")
        robot = ours.getObject("/Pioneer_p3dx")
        for _ in range(5):
            a, b = per_call(ours, robot, args.calls), per_call(canned, robot, args.calls)
            print("tatu %.0f us, canned answers %.0f us, ratio %.2f" % (a, b, a / b))
        client = RemoteAPIClient("localhost", args.port)
        sim = client.require("sim")
        client.setStepping(True)
        sim.startSimulation()
        begin = time.perf_counter()
        for _ in range(args.calls // 3):
            sim.getObjectPosition(robot)
            sim.getSimulationTime()
            client.step()
        print("a step and two reads: %.0f a second" % (args.calls // 3 / (time.perf_counter() - begin)))
        sim.stopSimulation()
    finally:
        for server in servers:
            server.kill()


if __name__ == "__main__":
    main()
