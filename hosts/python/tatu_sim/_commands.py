"""Commands of plugins as methods: `world.sim.getObjectPosition(handle)`."""

import inspect
from typing import Any, Dict


def commands_of(native) -> Dict[str, Dict[str, Any]]:
    """Return the declarations of all commands, by name."""
    return {name: command for command in native.commands() for name in command["names"]}


def signature(command: Dict[str, Any]) -> inspect.Signature:
    """Build the signature of a command from its declaration."""
    parameters, used = [], set()
    for number, p in enumerate(command["parameters"]):
        name = p["name"] if p["name"].isidentifier() and p["name"] not in used else f"arg{number + 1}"
        used.add(name)
        if p["rest"]:
            parameters.append(inspect.Parameter(name, inspect.Parameter.VAR_POSITIONAL))
            break
        optional = p["optional"] or any(q.default is not q.empty for q in parameters)
        default = None if optional else inspect.Parameter.empty
        parameters.append(inspect.Parameter(name, inspect.Parameter.POSITIONAL_ONLY, default=default))
    return inspect.Signature(parameters)


def docstring(command: Dict[str, Any]) -> str:
    """Build the docstring of a command, with its parameters and results."""
    lines = [command["text"]]
    for title, key in (("Args:", "parameters"), ("Returns:", "returns")):
        if command[key]:
            lines += ["", title]
            for p in command[key]:
                unit = f", {p['unit']}" if p["unit"] else ""
                lines.append(f"    {p['name']} ({p['type']}{unit}): {p['text']}")
    if command["notes"]:
        lines += ["", command["notes"]]
    return "\n".join(lines)


class Namespace:
    """A namespace of commands, such as `sim`."""

    def __init__(self, world, prefix: str):
        self._world = world
        self._prefix = prefix

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        full = f"{self._prefix}.{name}"
        known = self._world._known()
        if full not in known:
            if any(other.startswith(full + ".") for other in known):
                return Namespace(self._world, full)
            raise AttributeError(f"no plugin provides the command `{full}`{_near(full, known)}")
        world = self._world

        def command(*args: Any) -> Any:
            return world.call(full, *args)

        command.__name__ = command.__qualname__ = name
        command.__doc__ = docstring(known[full])
        command.__signature__ = signature(known[full])
        # The command is stored as an attribute, so that `__getattr__` is not called again for it.
        self.__dict__[name] = command
        return command

    def __dir__(self):
        start = self._prefix + "."
        return sorted({name[len(start) :].split(".")[0] for name in self._world._known() if name.startswith(start)})

    def __repr__(self) -> str:
        return f"<commands `{self._prefix}`>"


def _near(name: str, known) -> str:
    import difflib

    near = difflib.get_close_matches(name, known, 1)
    return f"; did you mean `{near[0]}`?" if near else ""


class Namespaces:
    """Adds the namespaces of commands as attributes to a class with `call` and `_declarations`."""

    def _known(self) -> Dict[str, Dict[str, Any]]:
        known = self.__dict__.get("_commands")
        if known is None:
            known = self.__dict__["_commands"] = self._declarations()
        return known

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and "_native" in self.__dict__:
            if any(full.startswith(name + ".") for full in self._known()):
                space = self.__dict__[name] = Namespace(self, name)
                return space
        raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")

    def __dir__(self):
        return sorted({*super().__dir__(), *(name.split(".")[0] for name in self._known() if "." in name)})
