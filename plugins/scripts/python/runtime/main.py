"""The loop that serves the simulator."""

import faulthandler
import sys

from tatu_runtime import api as apis, errors, limits, link as links, output as outputs, repeat, script as scripts
from tatu_runtime import source as sources, threads as threads_module, wire

CLEANUP = {"cmd": "cleanup"}


class Server:
    def __init__(self, fd, out, parent, memory):
        self.problems = limits.begin(parent, memory)
        self.link = links.Link(fd, out)
        self.output = outputs.Output(self.link)
        self.threads = threads_module.Threads(self.link)
        self.functions = apis.Functions()
        self.api = apis.Api(self.link, self.threads, self.functions)
        self.script = scripts.Script(self.api, self.threads)
        self.link.serve, self.link.wait, self.link.lines = self.serve, self.threads.wait, self.output.take
        self.link.pending = self.output.pending
        self.stdout = sys.stdout = outputs.Stream(self.output, outputs.INFO)
        self.stderr = sys.stderr = outputs.Stream(self.output, outputs.WARNING)
        self.depth = 0
        # A crash is reported with the lines of the script that were running.
        faulthandler.enable(file=2)
        self.answers = {
            links.LOAD: self.load, links.FIND: self.find, links.CALL: self.call,
            links.CALL_FUNCTION: self.call_function, links.RESUME: self.resume, links.SAVE: self.save,
            links.RESTORE: self.restore, links.PLACE: self.place,
        }

    def run(self):
        while True:
            try:
                kind, body = self.link.receive()
            except EOFError:
                # The interpreter ends, and writes out the files of the script.
                return
            self.output.begin()
            self.serve(kind, body)

    def serve(self, kind, body):
        """Serves a question of the simulator."""
        if kind == links.KEEP:
            self.functions.keep(wire.unpack_u32(body)[0], wire.unpack_u32(body, 4)[0])
        elif kind == links.DROP:
            self.functions.drop(wire.unpack_u32(body)[0])
        elif kind == links.REFRESH:
            self.api.refresh()
        else:
            self.answer(kind, body)

    def answer(self, kind, body):
        if self.depth == 0 and kind in (links.CALL, links.RESUME):
            # Functions that were results of earlier calls, and have not been kept.
            self.functions.release(self.functions.scope)
        self.depth += 1
        try:
            answer = self.threads.nested(self.answers[kind], self.api.reader(body))
        except SystemExit:
            # The script asks for its end, which is not an error.
            answer = links.DONE, self.values(CLEANUP)
        except BaseException as error:
            answer = self.failed(error)
        self.depth -= 1
        if self.depth == 0:
            self.stdout.end()
            self.stderr.end()
        try:
            self.link.send(answer[0], *answer[1])
        except wire.Unsendable as error:
            answer = self.failed(error)
            self.link.send(answer[0], *answer[1])

    def failed(self, error):
        try:
            return links.FAILED, errors.failure(error)
        except BaseException:
            trace = error.__traceback__ = None
            text = "%s, which cannot be described" % type(error).__name__
            return links.FAILED, errors.report(errors.SCRIPT_ERROR, text, "", "", 0, trace or "")

    def values(self, result):
        """Returns the parts of the result of a function: a tuple is several values."""
        values = () if result is None else result if type(result) is tuple else (result,)
        try:
            return self.api.write(values)
        except wire.Unsendable as error:
            text = str(error)
            raise wire.Unsendable("result" + text[len("argument"):] if text.startswith("argument") else text) from None

    def load(self, reader):
        text, chunk, dialect, kind, folder = (reader.text() for _ in range(5))
        seed, may_start_programs = reader.u64(), reader.byte() != 0
        preludes = [reader.text() for _ in range(reader.u32())]
        for problem in self.problems + limits.apply(may_start_programs):
            self.output.add(outputs.WARNING, problem)
        repeat.seed(seed, self.api)
        source = sources.Source(text, chunk, folder)
        for one in source.problems:
            self.output.add(outputs.WARNING, "%s: %s" % (chunk, one))
        parts = [wire.text(self.script.load(source, dialect, kind, preludes).encode())]
        orders = self.script.rules.get("orders", ())
        parts.append(wire.pack_u32(len(orders)))
        parts += [wire.text(str(one).encode()) for order in orders for one in order]
        return links.DONE, parts

    def find(self, reader):
        how = reader.byte()
        return links.DONE, [b"\1" if self.script.defines(how, reader.text()) else b"\0"]

    def call(self, reader):
        how, name = reader.byte(), reader.text()
        return self.outcome(self.script.call(how, name, reader.values()))

    def call_function(self, reader):
        function = self.functions.get(reader.u32())
        if function is None:
            raise links.SimError("the function can no longer be called, because it was passed only for the duration "
                                 "of a call that has ended", -4)
        return self.outcome((True, function(*reader.values())))

    def resume(self, reader):
        token, failed = reader.u64(), reader.byte()
        if failed:
            outcome = links.error(reader)
        else:
            outcome = reader.data[reader.at:]
        return self.outcome(self.threads.resume(token, outcome))

    def outcome(self, ended_and_result):
        ended, result = ended_and_result
        return (links.DONE, self.values(result)) if ended else (links.WAITING, [])

    def save(self, _reader):
        parts = []
        self.api.writer.value(parts, self.script.save())
        return links.DONE, parts

    def restore(self, reader):
        same = reader.byte() != 0
        self.script.restore(same, reader.value())
        return links.DONE, self.values(None)

    def place(self, _reader):
        return links.FAILED, errors.place(sys._getframe())


def run(fd, out, parent, memory):
    Server(fd, out, parent, memory).run()
