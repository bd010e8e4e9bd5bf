"""Threads of the script, which wait in commands.

`sysCall_thread` runs in a thread of Python, but never beside the script's other functions: whoever starts or resumes it
waits until it waits in a command, or ends.
"""

import threading

from tatu_runtime import link as links, wire

# Commands that a thread calls in a step before it lets the simulation continue, unless it is stepping.
SLICE = 1000


class Threads:
    """The threads of a script."""

    def __init__(self, link):
        self.link = link
        self.running = None
        self.waiting = {}
        # Name and caller of the command by which a thread waits for the next step.
        self.switch = None

    def start(self, function, args):
        """Runs a function as a thread. Returns True and its result when it ends, or False and None when it waits."""
        thread = Thread(self, function, args)
        thread.os_thread.start()
        return self.transfer(thread)

    def resume(self, token, outcome):
        """Ends a wait; `outcome` is the contents of the answer, or an exception."""
        thread = self.waiting.pop(token, None)
        if thread is None:
            raise links.SimError("no thread of the script waits for this token", -4)
        thread.outcome = outcome
        return self.transfer(thread)

    def transfer(self, thread):
        link = self.link
        outer, owner = self.running, link.owner
        self.running, thread.used = thread, 0
        link.owner = thread.os_thread.ident
        thread.go.release()
        thread.back.acquire()
        link.owner, self.running = owner, outer
        if not thread.ended:
            return False, None
        thread.os_thread.join()
        if thread.error is not None:
            raise thread.error
        return True, thread.result

    def nested(self, function, *args):
        """Calls a function of the script while a thread waits for a command: the function itself cannot wait."""
        outer, self.running = self.running, None
        try:
            return function(*args)
        finally:
            self.running = outer

    def wait(self, token):
        """Waits for the end of a wait; called in a thread."""
        thread = self.running
        self.waiting[token] = thread
        thread.back.release()
        thread.go.acquire()
        outcome = thread.outcome
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome

    def count(self):
        """Counts a command of a thread, and lets the simulation continue after `SLICE` of them."""
        thread = self.running
        thread.used += 1
        if thread.used > SLICE and thread.held == 0 and self.switch is not None:
            thread.used = 0
            self.switch()

    def hold(self, level=None):
        """Returns how many times the thread has asked not to be switched, after setting it if a level is given."""
        thread = self.running
        if thread is None:
            return 0
        before = thread.held
        if level is not None:
            thread.held = max(int(level), 0)
        return before


class Thread:
    def __init__(self, threads, function, args):
        self.go, self.back = threading.Semaphore(0), threading.Semaphore(0)
        self.function, self.args = function, args
        self.ended = False
        self.error = self.result = self.outcome = None
        self.used = self.held = 0
        self.os_thread = threading.Thread(target=self.run, name="sysCall_thread", daemon=True)

    def run(self):
        self.go.acquire()
        try:
            self.result = self.function(*self.args)
        except BaseException as error:
            self.error = error
        self.ended = True
        self.back.release()
