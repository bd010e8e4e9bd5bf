"""Tests of the modules in `runtime/`, without the simulator."""

import importlib
import os
import struct
import sys
import types
import unittest
from pathlib import Path

RUNTIME = Path(__file__).resolve().parent.parent / "runtime"
package = types.ModuleType("tatu_runtime")
package.__path__ = [str(RUNTIME)]
sys.modules["tatu_runtime"] = package
api, wire, links, threads, source, errors, output, limits = (
    importlib.import_module("tatu_runtime." + name)
    for name in ("api", "wire", "link", "threads", "source", "errors", "output", "limits")
)


class Values(unittest.TestCase):
    def setUp(self):
        self.functions = []
        self.writer = wire.Writer(self.number, lambda value: None)

    def number(self, function):
        self.functions.append(function)
        return len(self.functions)

    def there_and_back(self, value):
        parts = []
        self.writer.value(parts, value)
        return wire.Reader(b"".join(parts), lambda n: self.functions[n - 1]).value()

    def test_values_survive_the_way_there_and_back(self):
        for value in (None, False, True, 0, -1 << 63, 2.5, float("inf"), "", "ção", b"\xff\0", [1, 2], [1.0, 2.0],
                      [True, 1], [[], ["a"]], {"a": {"b": [1]}, 2: None}, print):
            again = self.there_and_back(value)
            self.assertEqual(repr(again), repr(value))

    def test_subclasses_and_arrays_become_plain_values(self):
        import array
        import collections
        import enum
        kind = enum.IntEnum("kind", "A B")
        point = collections.namedtuple("point", "x y")
        self.assertEqual(self.there_and_back(kind.B), 2)
        self.assertEqual(self.there_and_back(point(1, 2.5)), [1.0, 2.5])
        self.assertEqual(self.there_and_back(collections.OrderedDict(a=1)), {"a": 1})
        self.assertEqual(self.there_and_back(array.array("i", [1, 2])), [1, 2])
        self.assertEqual(self.there_and_back(memoryview(b"ab")), b"ab")

    def test_values_that_cannot_pass_are_refused_with_their_place(self):
        loop = {}
        loop["again"] = loop
        for value, words in ((1 << 63, "64 bits"), (1 << 100000, "64 bits"), ([1 << 63], "64 bits"),
                             ({"a": [1, {2}]}, "['a']: [1]: a value of type set"), (loop, "contains itself"),
                             ({(1,): 2}, "the key (1,)"), (1j, "type complex")):
            with self.assertRaises(wire.Unsendable) as caught:
                self.writer.value([], value)
            self.assertIn(words, str(caught.exception))


class Links(unittest.TestCase):
    def setUp(self):
        self.from_host, self.to_script = os.pipe()
        self.to_host, self.from_script = os.pipe()
        self.link = links.Link(self.from_host, self.from_script)
        self.link.pending = ()

    def tearDown(self):
        for fd in (self.from_host, self.to_script, self.to_host, self.from_script):
            os.close(fd)

    def say(self, kind, body):
        os.write(self.to_script, struct.pack("<IB", len(body) + 1, kind) + body)

    def test_questions_of_the_simulator_are_served_until_it_answers(self):
        served = []
        self.link.serve = lambda kind, body: served.append((kind, body))
        self.say(links.FIND, b"ab")
        self.say(links.KEEP, b"cd")
        self.say(links.RESULT, b"done")
        self.assertEqual(self.link.ask(links.COMMAND, b"xy"), b"done")
        self.assertEqual(served, [(links.FIND, b"ab"), (links.KEEP, b"cd")])
        self.assertEqual(os.read(self.to_host, 100), b"\x03\0\0\0\x01xy")

    def test_errors_of_commands_are_raised(self):
        self.say(links.ERROR, struct.pack("<i", -3) + wire.text(b"no object") + wire.text(b"look"))
        with self.assertRaises(links.SimError) as caught:
            self.link.ask(links.COMMAND)
        found = caught.exception
        self.assertEqual((str(found), found.code, found.help), ("no object", -3, "look"))

    def test_a_thread_waits_for_its_token_while_others_run(self):
        all_threads = threads.Threads(self.link)
        self.link.wait = all_threads.wait
        steps = []

        def run(word):
            steps.append(word)
            steps.append(self.link.ask(links.COMMAND))
            return "ended"

        self.say(links.WAIT, struct.pack("<Q", 7))
        self.assertEqual(all_threads.start(run, ["begun"]), (False, None))
        self.assertEqual(steps, ["begun"])
        self.assertEqual(all_threads.resume(7, b"results"), (True, "ended"))
        self.assertEqual(steps, ["begun", b"results"])
        with self.assertRaises(links.SimError):
            all_threads.resume(7, b"again")


class Calls(unittest.TestCase):
    def test_a_function_is_valid_until_the_command_that_got_it_returns_even_if_that_waits(self):
        functions = api.Functions()
        asked = []

        class Host:
            def ask(self, kind, *parts):
                asked.append(functions.get(1) is print)
                if len(asked) == 1:
                    # Another call of the script, while this one waits.
                    calls.call(links.COMMAND, b"1234", [len])
                return wire.pack_u32(0)

        class NoThreads:
            running = None

        calls = api.Api(Host(), NoThreads(), functions)
        calls.call(links.COMMAND, b"1234", [print])
        self.assertEqual((asked, functions.table), ([True, True], {}))


class Sources(unittest.TestCase):
    def test_settings_in_lua_are_read_and_other_code_is_named(self):
        text = ("#python\n#luaExec additionalPaths = {'a', \"b\"}\n#luaExec wrapper='pythonWrapper'\n"
                "'''luaExec\nfunction f() end\n'''\n")
        found = source.Source(text, "a.py", "/scene")
        self.assertEqual(found.paths, ["/scene", "a", "b"])
        self.assertEqual(found.settings["wrapper"], "'pythonWrapper'")
        self.assertEqual(len(found.problems), 1)
        self.assertIn("function f() end", found.problems[0])

    def test_names_of_nested_code_are_found(self):
        code = compile("def f():\n    return lambda: sim.getObject(x.y)", "a", "exec")
        self.assertLessEqual({"sim", "getObject", "x", "y"}, source.names(code))


class Outputs(unittest.TestCase):
    def test_lines_are_collected_and_limited(self):
        collected = output.Output(None)
        stream = output.Stream(collected, output.INFO)
        print("a", "b", file=stream)
        print("half", end="", file=stream)
        self.assertEqual(collected.take(), [b"\x03a b"])
        stream.end()
        self.assertEqual(collected.take(), [b"\x03half"])
        for _ in range(2 * output.MAX_LINES):
            stream.write("x\n")
        self.assertLess(len(collected.take()), output.MAX_LINES)


class Errors(unittest.TestCase):
    def test_the_position_is_that_of_the_script_and_not_of_a_library(self):
        try:
            exec(compile("import json\n\njson.loads('{')", "robot.py", "exec"), {})
        except ValueError as error:
            reader = wire.Reader(b"".join(errors.failure(error)))
        self.assertEqual(reader.i32(), errors.SCRIPT_ERROR)
        self.assertIn("JSONDecodeError", reader.text())
        self.assertEqual((reader.text(), reader.text(), reader.u32()), ("", "robot.py", 3))


class Limits(unittest.TestCase):
    def test_jumps_of_the_filter_stay_within_it_and_reach_a_return(self):
        for machine, (architecture, _, numbers) in limits.NUMBERS.items():
            for exec_allowed in (False, True):
                program = limits.filter_program(architecture, numbers, exec_allowed)
                for at, (code, yes, no, _) in enumerate(program):
                    if code in (limits.EQUAL, limits.SET):
                        self.assertLess(at + 1 + max(yes, no), len(program), machine)
                self.assertEqual(program[-1], (limits.RETURN, 0, 0, limits.ALLOW))


if __name__ == "__main__":
    unittest.main()
