#!/usr/bin/env python3
"""Sends random commands from eight clients of four protocols, and checks for panics and memory growth.

    tests/soak/clients.py target/release/tatu --minutes 30

Two clients each of jsonl, the ZeroMQ remote API, the legacy remote API and rosbridge call commands (except those that
`NOT` matches) with mostly meaningless arguments; every few seconds, one of them is killed and replaced. The exit code
is 1 if the program ends, panics, no longer answers, or uses much more memory at the end than after a quarter of the
time. Packages from PyPI are installed into a folder next to that of the program."""

import argparse, glob, json, os, random, re, signal, socket, subprocess, sys, threading, time, zipfile

KINDS = ["jsonl", "zmq_remote", "legacy_remote", "rosbridge"]
SCENE = "scenes/first/pioneer_for_ros.toml"
# Commands that end the run, wait for a user, start programs, or accumulate data in the world.
NOT = r"quit|close|load|open|save|export|launch|Dialog|[sS]cript|create|copy|import|add|duplicate|wait|moveTo|sim\.step|switchThread|yield"
# Allowed growth of memory, MiB. It is not 0 because the allocator does not return all freed memory.
GROWTH_MB = 24


def anything(r):
    return r.choice([
        lambda: r.randrange(-3, 60), lambda: r.randrange(-3, 60), lambda: r.uniform(-10, 10), lambda: r.choice(["", "a", "/Pioneer_p3dx", "é" * 9]),
        lambda: None, lambda: r.random() < 0.5, lambda: 1 << 60, lambda: [r.uniform(-1, 1) for _ in range(r.choice([0, 3, 4, 7, 12]))],
        lambda: {"a": 1, "b": [None, "x"]}, lambda: [[1, "x"], {}],
    ])()


def fitting(r, parameter):
    """Returns a random argument, which usually has the declared type."""
    kind = parameter["type"]
    if r.random() < 0.2:
        return anything(r)
    if "integer" in kind or "object" in kind:
        return r.randrange(-3, 60)
    if "numbers" in kind or "list" in kind or "table" in kind:
        return [r.uniform(-1, 1) for _ in range(r.choice([3, 3, 4, 7, 12]))]
    if "number" in kind:
        return r.uniform(-2, 2)
    if "text" in kind:
        return r.choice(["a", "b", "/Pioneer_p3dx", "Pioneer_p3dx_leftMotor", "geometry_msgs/Twist"])
    return anything(r)


def some_call(r, commands):
    c = r.choice(commands)
    parameters = [p for p in c["parameters"] if not p["optional"] or r.random() < 0.5]
    return c["name"], [fitting(r, p) for p in parameters]


def jsonl(port, r, commands):
    s = socket.create_connection(("127.0.0.1", port))
    threading.Thread(target=lambda: [None for _ in iter(lambda: s.recv(1 << 16), b"")], daemon=True).start()
    while True:
        name, args = some_call(r, commands)
        line = r.choices(
            [{"call": name, "args": args}, {"request": r.choice(["start", "pause", "stop"])}, {"stepping": r.random() < 0.3}, {"step": r.randrange(1, 5)},
             {"events": True}, {"state": True}, anything(r)], [80, 2, 1, 5, 1, 3, 2])[0]
        if isinstance(line, dict):
            line["id"] = anything(r)
        s.sendall(json.dumps(line).encode() + b"\n")
        time.sleep(r.choice([0, 0, 0.001, 0.01]))


def zmq_remote(port, r, commands):
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient
    client = RemoteAPIClient("localhost", port)
    client.require("sim")
    while True:
        name, args = some_call(r, commands)
        if r.random() < 0.03:
            name, args = r.choice([("sim.setStepping", [r.random() < 0.3]), ("sim.step", []), ("sim.startSimulation", [])])
        try:
            client.call(name, args)
        except Exception as e:
            if "not" in type(e).__name__.lower() and "found" in str(e):
                raise


def legacy_binding():
    """Loads the binding of the legacy library as a module, without the package that contains it."""
    import importlib.util, types
    folder = os.environ["LEGACY"] + "/"
    for name in ("pypot", "pypot.vrep", "pypot.vrep.remoteApiBindings"):
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__path__ = [folder] if name.endswith("Bindings") else []
    for name in ("vrepConst", "vrep"):
        spec = importlib.util.spec_from_file_location("pypot.vrep.remoteApiBindings." + name, folder + name + ".py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
    return module


def legacy_remote(port, r, _):
    v = legacy_binding()
    client = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
    modes = [v.simx_opmode_oneshot_wait] * 6 + [v.simx_opmode_streaming, v.simx_opmode_buffer, v.simx_opmode_oneshot, v.simx_opmode_discontinue]
    n = lambda: r.randrange(-3, 60)
    x = lambda: r.uniform(-2, 2)
    while True:
        mode = r.choice(modes)
        r.choice([
            lambda: v.simxGetObjectHandle(client, r.choice(["Pioneer_p3dx", "nope", ""]), mode), lambda: v.simxGetObjectPosition(client, n(), n(), mode),
            lambda: v.simxSetJointTargetVelocity(client, n(), x(), mode), lambda: v.simxGetJointPosition(client, n(), mode),
            lambda: v.simxReadProximitySensor(client, n(), mode), lambda: v.simxGetObjectGroupData(client, n(), r.randrange(0, 20), mode),
            lambda: v.simxSetFloatSignal(client, "f", x(), mode), lambda: v.simxGetStringSignal(client, "s", mode), lambda: v.simxSetStringSignal(client, "s", b"abc" * 99, mode),
            lambda: v.simxGetObjects(client, n(), mode), lambda: v.simxSetObjectPosition(client, n(), n(), [x(), x(), x()], mode), lambda: v.simxGetVisionSensorImage(client, n(), 0, mode),
            lambda: v.simxGetPingTime(client), lambda: v.simxStartSimulation(client, mode), lambda: v.simxSynchronous(client, r.random() < 0.2), lambda: v.simxSynchronousTrigger(client),
            lambda: v.simxGetIntegerParameter(client, n(), mode), lambda: v.simxAddStatusbarMessage(client, "m", mode),
        ])()


def rosbridge(port, r, _):
    import websocket
    s = websocket.create_connection(f"ws://127.0.0.1:{port}/", timeout=30)
    threading.Thread(target=lambda: [None for _ in iter(s.recv, None)], daemon=True).start()
    topics = ["/odom", "/scan", "/tf", "/clock", "/joint_states", "/pose", "/nowhere", "/chat"]
    services = ["/rosapi/topics", "/rosapi/services", "/rosapi/topic_type", "/simulation/start", "/nowhere", "/rosapi/get_param"]
    while True:
        topic = r.choice(topics)
        message = r.choice([
            {"op": "subscribe", "topic": topic, "throttle_rate": r.randrange(200), "compression": r.choice(["none", "cbor"])}, {"op": "unsubscribe", "topic": topic},
            {"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": r.uniform(-1, 1)}, "angular": {"z": r.uniform(-1, 1)}}},
            {"op": "advertise", "topic": topic, "type": "std_msgs/String"}, {"op": "publish", "topic": topic, "msg": {"data": anything(r)}},
            {"op": "call_service", "service": r.choice(services), "args": anything(r), "id": "x"}, {"op": anything(r), "topic": anything(r)}, anything(r),
        ])
        s.send(json.dumps(message))
        time.sleep(r.choice([0, 0.001, 0.02]))


def python(folder):
    """Creates an environment with the clients' packages and the legacy library; returns its interpreter."""
    program = os.path.join(folder, "bin/python")
    if not os.path.exists(program):
        subprocess.check_call([sys.executable, "-m", "venv", folder])
    subprocess.check_call([program, "-m", "pip", "install", "-q", "coppeliasim-zmqremoteapi-client==2.0.4", "websocket-client"])
    legacy = os.path.join(folder, "pypot/vrep/remoteApiBindings")
    if not os.path.isdir(legacy):
        subprocess.check_call([program, "-m", "pip", "download", "-q", "--no-deps", "pypot==5.0.2", "-d", folder])
        zipfile.ZipFile(glob.glob(folder + "/pypot*.whl")[0]).extractall(folder)
    os.environ["LEGACY"] = legacy
    return program


def memory_mb(pid):
    return int(re.search(r"VmRSS:\s+(\d+)", open(f"/proc/{pid}/status").read())[1]) / 1024


def main():
    args = argparse.ArgumentParser()
    args.add_argument("tatu")
    args.add_argument("--minutes", type=float, default=30)
    args.add_argument("--seed", type=int, default=1)
    args.add_argument("--kinds", nargs="*", choices=KINDS, help="instead of all")
    args.add_argument("--worker", nargs=2, help=argparse.SUPPRESS)
    args = args.parse_args()
    r = random.Random(args.seed)
    kinds = args.kinds or KINDS
    all_commands = json.loads(subprocess.check_output([args.tatu, "list", "commands", "--json"], stderr=subprocess.DEVNULL))
    commands = [c for c in all_commands if c["name"].startswith("sim") and not re.search(NOT, c["name"])]
    if args.worker:
        return globals()[args.worker[0]](int(args.worker[1]), r, commands)

    interpreter = python(os.path.abspath(os.path.join(os.path.dirname(args.tatu), "soak-clients")))
    more = [a for kind in KINDS for a in ("--service", kind + ":port=0")]
    told = open(args.tatu + "-soak.log", "w+")
    served = subprocess.Popen([args.tatu, "serve", SCENE, *more], stderr=told)
    ports = {}
    while len(ports) < len(KINDS):
        time.sleep(0.1)
        ports = dict(re.findall(r"(\w+): listening on 127\.0\.0\.1:(\d+)", open(told.name).read()))
    number = 0

    def come(kind):
        nonlocal number
        number += 1
        command = [interpreter, __file__, args.tatu, "--worker", kind, ports[kind], "--seed", str(args.seed * 1000 + number)]
        return kind, subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def answers():
        """Returns whether a new client gets answers and can restart the simulation, even if others have stopped it."""
        s = socket.create_connection(("127.0.0.1", int(ports["jsonl"])), 10)
        s.settimeout(30)
        s.sendall(b'{"id":1,"state":true}\n{"id":2,"request":"start"}\n')
        return s.recv(1 << 16)

    workers = [come(kind) for kind in kinds for _ in range(2)]
    begin, after_quarter, killed, wrong = time.time(), None, 0, None
    while time.time() - begin < args.minutes * 60 and not wrong:
        time.sleep(2)
        i = r.randrange(len(workers))
        kind, worker = workers[i]
        worker.send_signal(signal.SIGKILL)
        worker.wait()
        killed += 1
        workers[i] = come(kind)
        for i, (kind, worker) in enumerate(workers):
            if worker.poll() is not None:
                workers[i] = come(kind)
        try:
            answers()
        except OSError as e:
            wrong = f"the program no longer answers: {e}"
        if served.poll() is not None:
            wrong = f"the program ended with exit code {served.returncode}"
        elif after_quarter is None and time.time() - begin > args.minutes * 15:
            after_quarter = memory_mb(served.pid)
    end = memory_mb(served.pid) if served.poll() is None else 0
    for _, worker in workers:
        worker.kill()
    served.kill()
    text = open(told.name).read()
    if "panicked" in text:
        wrong = "the program panicked"
    elif not wrong and end > after_quarter + GROWTH_MB:
        wrong = f"the memory grew by more than {GROWTH_MB} MiB"
    print(f"{(time.time() - begin) / 60:.1f} min, {killed} clients killed, {number} in total; memory {after_quarter or 0:.0f} MiB after a quarter of the time, {end:.0f} MiB at the end")
    if wrong:
        print(f"{wrong}; see {told.name}")
        sys.exit(1)


if __name__ == "__main__":
    main()
