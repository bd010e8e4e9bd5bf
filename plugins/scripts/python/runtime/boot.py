# The first program of a script's process: reads the modules of the runtime from a pipe, and runs them.
import os, sys, types

def read(fd, n):
    parts = b""
    while len(parts) < n:
        part = os.read(fd, n - len(parts))
        if not part:
            os._exit(0)
        parts += part
    return parts

def boot(parent, memory):
    # Messages come by the standard input, and leave by the standard output. Scripts get an empty input, and what
    # libraries write to the output goes where errors go.
    fd, out = os.dup(0), os.dup(1)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.dup2(2, 1)
    os.close(null)
    length = int.from_bytes(read(fd, 4), "little")
    rest = memoryview(read(fd, length))[1:]
    def text():
        nonlocal rest
        end = 4 + int.from_bytes(rest[:4], "little")
        found, rest = bytes(rest[4:end]).decode(), rest[end:]
        return found
    package = types.ModuleType("tatu_runtime")
    package.__path__ = []
    sys.modules["tatu_runtime"] = package
    while rest:
        name, source = text(), text()
        module = types.ModuleType("tatu_runtime." + name)
        module.__package__ = "tatu_runtime"
        sys.modules[module.__name__] = module
        setattr(package, name, module)
        exec(compile(source, "<tatu>/" + name + ".py", "exec"), module.__dict__)
    package.main.run(fd, out, parent, memory)

if sys.path and sys.path[0] == "":
    # The working folder is not searched for modules.
    del sys.path[0]
parent, memory = int(sys.argv[1]), int(sys.argv[2])
sys.argv[1:] = []
boot(parent, memory)
