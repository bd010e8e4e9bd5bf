#!/usr/bin/env python3
"""Sends images of 640 x 480 pixels, 30 per second, by each protocol, and measures the received rate and the cost.

    bench/remote/images.py target/release/tatu

A camera in an arena measures 30 times per second in real time, and one client at a time requests its images: the real
libraries of the ZeroMQ and the legacy remote API, and a plain WebSocket for rosbridge. The cost is the program's
additional processor time with a client, as a fraction of a core; `socket` is the cost of a process that writes the same
bytes to a plain socket, and `camera` the cost of the camera itself. PyPI packages are installed into a folder beside
the program."""

import json, os, re, socket, struct, subprocess, sys, tempfile, time

RATE, SECONDS, PASSES = 30, 8, 2
BYTES = 640 * 480 * 3
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../tests/soak"))

import clients  # noqa: E402

SCENE = """format = 1
[scene]
dt_s = %r
[[model]]
model = "%s"
[[object]]
kind = "sensor"
alias = "eye"
sensor = "depth_camera"
columns = 640
rows = 480
position_m = [-1.5, 0.0, 0.4]
quaternion = [0.5, 0.5, 0.5, 0.5]
%s"""
OFF = """script = { text = '''
function sysCall_init()
    sim.setExplicitHandling(sim.getObject('..'), 1)
end
''' }
"""


def paced(get):
    """Calls a function 30 times per second, and returns the number of images received per second."""
    got, begin = 0, time.monotonic()
    while (now := time.monotonic()) < begin + SECONDS:
        got += get()
        time.sleep(max(0, begin + got / RATE - time.monotonic()) if got else 0.001)
    return got / (now - begin)


def zmq_remote(port):
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    sim = RemoteAPIClient("localhost", port).require("sim")
    eye = sim.getObject("/eye")
    return paced(lambda: len(sim.getVisionSensorImg(eye)[0]) == BYTES)


def legacy_remote(port):
    import ctypes

    v = clients.legacy_binding()
    client = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
    eye = v.simxGetObjectHandle(client, "eye", v.simx_opmode_blocking)[1]
    size, image = (ctypes.c_int * 2)(), ctypes.POINTER(ctypes.c_byte)()
    # The binding converts each image to a list, which takes longer than the period of an image, so the underlying
    # library is called directly.
    get = lambda mode: v.c_GetVisionSensorImage(client, eye, size, ctypes.byref(image), 0, mode)
    get(v.simx_opmode_streaming)
    last = [None]

    def new():
        good = get(v.simx_opmode_buffer) == 0 and list(size) == [640, 480]
        stamp = v.simxGetLastCmdTime(client)
        fresh, last[0] = good and stamp != last[0], stamp
        return fresh

    got, begin = 0, time.monotonic()
    while time.monotonic() < begin + SECONDS:
        got += new()
        time.sleep(0.005)
    return got / (time.monotonic() - begin)


def rosbridge(port, compression="none"):
    s = socket.create_connection(("127.0.0.1", port))
    key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
    s.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n{key}\r\n".encode())
    stream = s.makefile("rb", 1 << 20)
    while stream.readline() != b"\r\n":
        pass
    text = json.dumps({"op": "subscribe", "topic": "/eye/image", "compression": compression}).encode()
    s.sendall(bytes([0x81, 0x80 | 126]) + struct.pack(">H", len(text)) + bytes(4) + text)
    got, begin = 0, time.monotonic()
    while time.monotonic() < begin + SECONDS:
        n = stream.read(2)[1] & 127
        if n >= 126:
            n = int.from_bytes(stream.read(2 if n == 126 else 8), "big")
        got += len(stream.read(n)) >= BYTES
    return got / (time.monotonic() - begin)


def rosbridge_cbor(port):
    return rosbridge(port, "cbor")


def writer(port):
    """Writes images to the first client, which gives a lower bound of the cost."""
    listener = socket.create_server(("127.0.0.1", port))
    print("listening", flush=True)
    s, image, begin, i = listener.accept()[0], bytes(BYTES), time.monotonic(), 0
    while True:
        s.sendall(image)
        i += 1
        time.sleep(max(0, begin + i / RATE - time.monotonic()))


def reader(port):
    stream = socket.create_connection(("127.0.0.1", port)).makefile("rb", 1 << 20)
    got, begin = 0, time.monotonic()
    while time.monotonic() < begin + SECONDS:
        got += len(stream.read(BYTES)) == BYTES
    return got / (time.monotonic() - begin)


def cpu_s(pid):
    fields = open(f"/proc/{pid}/stat").read().rsplit(") ", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(command, pattern, client):
    """Returns the images per second, and the fraction of a core that a program uses with a client or without one."""
    told = tempfile.TemporaryFile("w+")
    process = subprocess.Popen(command, stdout=told, stderr=told)
    try:
        port = None
        while port is None:
            time.sleep(0.05)
            told.seek(0)
            said = told.read()
            port = re.search(pattern, said)
            if process.poll() is not None:
                sys.exit(f"the program ended: {said}")
        time.sleep(1.5)
        begin, used = time.monotonic(), cpu_s(process.pid)
        got = "0"
        if client:
            got = subprocess.check_output([*client, port[1] if port.groups() else PLAIN], text=True)
        else:
            time.sleep(SECONDS)
        return float(got), (cpu_s(process.pid) - used) / (time.monotonic() - begin)
    finally:
        process.kill()


PLAIN = "23987"
KINDS = [("ZeroMQ", "zmq_remote", "zmq_remote"), ("legacy", "legacy_remote", "legacy_remote"),
         ("rosbridge, JSON", "rosbridge", "rosbridge"), ("rosbridge, CBOR", "rosbridge", "rosbridge_cbor")]


def main():
    tatu = os.path.abspath(sys.argv[1])
    interpreter = clients.python(os.path.join(os.path.dirname(tatu), "image-clients"))
    client = lambda kind: [interpreter, __file__, "--client", kind]
    with tempfile.TemporaryDirectory() as folder:
        arena = os.path.relpath(os.path.join(HERE, "../../scenes/course/parts/arena.toml"), folder)
        for name, more in (("on", ""), ("off", OFF)):
            open(f"{folder}/{name}.toml", "w").write(SCENE % (1 / RATE, arena, more))

        def served(service, kind, scene="on"):
            command = [tatu, "run", f"{folder}/{scene}.toml", "--realtime", "--seconds", "600", "--service", service + ":port=0"]
            return measure(command, service + r": listening on 127\.0\.0\.1:(\d+)", kind and client(kind))

        for _ in range(PASSES):
            rate, cost = measure([sys.executable, __file__, "--client", "writer", PLAIN], "listening", client("reader"))
            print(f"socket: {rate:.1f} images/s, {100 * cost:.1f} % of a core")
            idle = served("rosbridge", None)[1]
            print(f"camera: {100 * (idle - served('rosbridge', None, 'off')[1]):.1f} % of a core")
            for name, service, kind in KINDS:
                rate, cost = served(service, kind)
                print(f"{name}: {rate:.1f} images/s, {100 * (cost - idle):.1f} % of a core", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "--client":
        told = globals()[sys.argv[2]](int(sys.argv[3]))
        print(told)
    else:
        main()
