"""Tests all methods of control_types.toml: starts the scene without a window, and the clients; checks that each robot
drives more than 1 m; then kills the clients in turn, and checks that its robot stops and all others continue.

    pip install -r control_types/requirements.txt
    python3 control_types/try.py [--tatu PATH_OF_TATU]

It runs for half a minute, uses free ports, and ends with "all 9 ways work" or an error.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
INSIDE = ['lua', 'addon', 'plugin', 'python']     # robots without a client
CLIENTS = ['socket', 'zeromq', 'legacy', 'ros', 'jsonl']
SPEED = 2.0             # simulated seconds per second
LEAST = 1.0             # m that each robot must drive
PATIENCE = 25.0         # s of real time for LEAST
STOPPED = 2.5           # s of simulation time after which a robot without client must have stopped
WATCH = 2.5             # s of simulation time for which the robots are then observed
MOVED, STOOD = 0.05, 0.005      # m within WATCH


def free_ports(n):
    """Returns free ports. The ZeroMQ API uses the next port as well, so they are not consecutive."""
    taken = [socket.create_server(('127.0.0.1', 0)) for _ in range(n)]
    ports = [s.getsockname()[1] for s in taken]
    for s in taken:
        s.close()
    return ports


class Watcher:
    """Reads true poses, over lines of JSON."""

    def __init__(self, port, patience=10.0):
        end = time.monotonic() + patience
        while True:
            try:
                self.lines = socket.create_connection(('127.0.0.1', port)).makefile('rw')
                break
            except ConnectionRefusedError:
                if time.monotonic() > end:
                    sys.exit('error: the scene has not started')
                time.sleep(0.1)
        self.robots = {name: self.call('sim.getObject', '/' + name) for name in INSIDE + CLIENTS}
        self.ways = dict.fromkeys(self.robots, 0.0)
        self.at = {}

    def call(self, command, *args):
        print(json.dumps({'call': command, 'args': args}), file=self.lines, flush=True)
        return json.loads(self.lines.readline())['result'][0]

    def watch(self, until):
        """Sums up the distances until a condition on the simulation time holds, and returns that time."""
        while True:
            for name, handle in self.robots.items():
                p = self.call('sim.getObjectPosition', handle)
                self.ways[name] += math.dist(p, self.at.get(name, p))
                self.at[name] = p
            now = self.call('sim.getSimulationTime')
            if until(now):
                return now
            time.sleep(0.05)

    def ways_within(self, seconds):
        """Returns the distance that each robot drives within some simulated seconds."""
        before = dict(self.ways)
        end = self.watch(lambda now: True) + seconds
        self.watch(lambda now: now >= end)
        return {name: self.ways[name] - before[name] for name in self.ways}


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--tatu', default=shutil.which('tatu') or 'tatu', help='the program')
    tatu = options.parse_args().tatu

    plugin = HERE / 'plugin'
    for action in ('update-sdk', 'build'):
        done = subprocess.run([tatu, 'plugin', action, plugin], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)

    port = dict(zip(CLIENTS, free_ports(len(CLIENTS))))
    folders = [str(plugin / 'build'), os.environ.get('TATU_PLUGIN_PATH', '')]
    scene = subprocess.Popen(
        [tatu, 'run', HERE.parent / 'control_types.toml', '--speed', str(SPEED), '--addon', HERE / 'addon.lua',
         '--allow', f'net=127.0.0.1:{port["socket"]},python', '--set', f'/socket.data={{port="{port["socket"]}"}}',
         '--service', f'zmq_remote:port={port["zeromq"]}', '--service', f'legacy_remote:port={port["legacy"]}',
         '--service', f'rosbridge:port={port["ros"]}', '--service', f'jsonl:port={port["jsonl"]}'],
        env=dict(os.environ, TATU_PLUGIN_PATH=os.pathsep.join(f for f in folders if f)))
    clients = {}
    failures = []

    def check(holds, text):
        print(f'{"ok   " if holds else "ERROR"} {text}', flush=True)
        if not holds:
            failures.append(text)

    try:
        watcher = Watcher(port['jsonl'])
        for name in CLIENTS:
            clients[name] = subprocess.Popen([sys.executable, HERE / f'{name}_client.py', str(port[name])])
        end = time.monotonic() + PATIENCE
        now = watcher.watch(lambda _: min(watcher.ways.values()) > LEAST or time.monotonic() > end)
        for name, way in watcher.ways.items():
            check(way > LEAST, f'/{name} has driven {way:.2f} m after {now:.1f} s')
        dead = set()
        for name in CLIENTS:
            check(clients[name].poll() is None, f'the client of /{name} runs until it is killed')
            clients[name].kill()
            dead.add(name)
            watcher.ways_within(STOPPED)
            ways = watcher.ways_within(WATCH)
            stray = [n for n in ways if (ways[n] > STOOD if n in dead else ways[n] < MOVED)]
            check(not stray, f'without the client of /{name}, {len(ways) - len(dead)} robots go on'
                  + (f'; not as expected: ' + ', '.join(f'/{n} {ways[n]:.3f} m' for n in stray) if stray else ''))
    finally:
        for client in clients.values():
            client.kill()
        scene.terminate()
        scene.wait(10)
    check(scene.returncode == 0, f'the scene ends without an error (exit code {scene.returncode})')
    if failures:
        sys.exit(f'{len(failures)} errors')
    print(f'all {len(INSIDE + CLIENTS)} ways work')


if __name__ == '__main__':
    main()
