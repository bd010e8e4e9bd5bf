"""Compares tatu-importers-xacro with xacro of PyPI, on the files of `inputs/` and `refused/`,
on random files, random values in YAML and random expressions.

    cargo build -p tatu-importers-xacro --example expand
    pip install xacro
    python plugins/lib/xacro/tests/against_xacro.py [--expressions 2000] [--random-files 200] [--seed 1] [--record] [FILE.xacro ...]

Trees of elements are compared, not bytes: texts without blanks around them, attributes in any order, no comments. With
`--record`, what xacro makes of `inputs/` is written to `expected/`, with which `cargo test` compares without Python. For
other files, `--package NAME=FOLDER` and `NAME:=VALUE` apply to both programs.
"""

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import types
import warnings
from pathlib import Path
from xml.dom import Node, minidom

import xacro

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[3]
PACKAGES = {"parts_pkg": str(HERE / "inputs" / "parts")}
ARGUMENTS = {"given": "1"}
# Where the last bit of a function of math can change the whole value.
JUMPS = re.compile(r"(sqrt|sin|cos|atan2?|exp|log|pow|hypot)\(.*(%|//)|(%|//).*(sqrt|sin|cos|atan2?|exp|log|pow|hypot)\(")
QUOTED_KEY = "['a']"


def provide_packages(packages):
    """Makes `$(find NAME)` work without ROS."""
    module = types.ModuleType("ament_index_python.packages")
    module.get_package_share_directory = lambda name: packages[name]
    sys.modules["ament_index_python"] = types.ModuleType("ament_index_python")
    sys.modules["ament_index_python.packages"] = module


def program():
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    found = [target / profile / "examples" / "expand" for profile in ("debug", "release")]
    found = [path for path in found if path.exists()]
    if not found:
        sys.exit("build first: cargo build -p tatu-importers-xacro --example expand")
    return str(max(found, key=lambda path: path.stat().st_mtime))


def tree(node):
    """Returns an element as nested tuples: name, attributes, children."""
    attributes = dict(node.attributes.items())
    children = []
    for child in node.childNodes:
        if child.nodeType == Node.ELEMENT_NODE:
            children.append(tree(child))
        elif child.nodeType in (Node.TEXT_NODE, Node.CDATA_SECTION_NODE) and child.data.strip():
            children.append(" ".join(child.data.split()))
    return node.tagName, attributes, children


def difference(expected, found, path=""):
    """Returns the first difference of two trees as text, or None."""
    if isinstance(expected, str) or isinstance(found, str):
        return None if expected == found else f"{path}: expected text {expected!r}, found {found!r}"
    path = f"{path}/{expected[0]}"
    if expected[0] != found[0]:
        return f"{path}: found <{found[0]}>"
    # xacro loses declarations of includes within conditions.
    more = {name for name in found[1] if name.startswith("xmlns:") and name not in expected[1]}
    for name in sorted((set(expected[1]) | set(found[1])) - more):
        if not same(expected[1].get(name), found[1].get(name)):
            return f"{path}@{name}: expected {expected[1].get(name)!r}, found {found[1].get(name)!r}"
    if len(expected[2]) != len(found[2]):
        return f"{path}: expected {len(expected[2])} children, found {len(found[2])}"
    for a, b in zip(expected[2], found[2]):
        if message := difference(a, b, path):
            return message
    return None


def same(expected, found, tolerance=0.0):
    """Whether two values are the same text, or numbers of the same kind within a relative tolerance."""
    if expected == found or expected is None or found is None or tolerance == 0.0:
        return expected == found
    try:
        a, b = float(expected), float(found)
    except ValueError:
        return False
    return ("." in expected or "e" in expected) and abs(a - b) <= tolerance * abs(a)


class EndlessRun(BaseException):
    """Raised when xacro does not end, since it has no bounds."""


def stop_xacro(*_):
    raise EndlessRun


def by_xacro(path, arguments):
    """Returns the tree that xacro makes, or its error."""
    signal.signal(signal.SIGALRM, stop_xacro)
    signal.alarm(3)
    try:
        document = xacro.process_file(str(path), mappings=dict(arguments), verbosity=0)
        return tree(document.documentElement), document
    except (Exception, EndlessRun) as error:
        return f"error: {error}", None
    finally:
        signal.alarm(0)


def by_tatu(path, arguments, packages):
    command = [program(), str(path)]
    command += [f"{name}:={value}" for name, value in arguments.items()]
    command += [word for name, folder in packages.items() for word in ("--package", f"{name}={folder}")]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        return f"error: {run.stderr.strip()}"
    return tree(minidom.parseString(run.stdout).documentElement)


def compare_files(files, arguments, packages, record):
    wrong = 0
    for path in files:
        expected, document = by_xacro(path, arguments)
        found = by_tatu(path, arguments, packages)
        if isinstance(expected, str) or isinstance(found, str):
            message = None if isinstance(expected, str) and isinstance(found, str) else "only one program expands it"
            if message:
                print(f"{path}:\n  xacro: {str(expected)[:300]}\n  tatu:  {str(found)[:300]}")
        else:
            message = difference(expected, found)
            if message:
                print(f"{path}: {message}")
        wrong += message is not None
        if record and document:
            # Texts with the folder of this machine are made independent of it.
            text = document.documentElement.toprettyxml(indent="  ").replace(packages["parts_pkg"], "/parts")
            (HERE / "expected" / f"{path.stem}.xml").write_text(text)
    print(f"{len(files)} files, {wrong} differ")
    return wrong


class Generator:
    """Makes random expressions. Those that no program can evaluate are of use, too: both must refuse them."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def expression(self, depth):
        pick = self.random.choice
        if depth <= 0:
            return pick(self.atoms())
        # Mostly numbers, so that most expressions have a value.
        sub = lambda: self.number() if self.random.random() < 0.4 else self.expression(depth - self.random.randint(1, 2))
        kinds = [
            lambda: f"{sub()} {pick(['+', '-', '*', '/', '//', '%'])} {sub()}",
            lambda: f"({sub()}) {pick(['+', '-', '*', '/', '//', '%'])} ({sub()})",
            lambda: f"({sub()}) ** {pick(['2', '3', '-1', '0.5', '0'])}",
            lambda: f"{pick(['-', '+', 'not ', '~'])}({sub()})",
            lambda: f"({sub()}) {pick(['<', '<=', '==', '!=', '>', '>=', 'in', 'not in'])} ({sub()})",
            lambda: f"{self.number()} < {sub()} <= {self.number()}",
            lambda: f"({sub()}) {pick(['and', 'or'])} ({sub()})",
            lambda: f"{sub()} if {sub()} else {sub()}",
            lambda: f"[{', '.join(sub() for _ in range(self.random.randint(0, 3)))}]",
            lambda: f"({sub()}, {sub()})",
            lambda: f"{pick(self.lists())}[{self.random.randint(-3, 3)}]",
            lambda: f"{pick(self.lists() + self.texts())}[{self.bound()}:{self.bound()}{pick(['', ':-1', ':2'])}]",
            lambda: f"{pick(['len', 'str', 'int', 'float', 'bool', 'round', 'list'])}({sub()})",
            lambda: f"{pick(['min', 'max'])}({sub()}, {sub()})",
            lambda: f"round({self.float()}, {self.random.randint(-3, 6)})",
            lambda: f"python.{pick(['sum', 'sorted', 'tuple', 'any', 'all'])}({pick(self.lists())})",
            lambda: f"python.{pick(['abs', 'repr'])}({sub()})",
            lambda: f"python.divmod({sub()}, {self.number()})",
            lambda: f"list(python.range({self.random.randint(-3, 9)}, {self.random.randint(-3, 9)}, {pick([-2, -1, 1, 3])}))",
            lambda: f"{pick(['sqrt', 'sin', 'cos', 'atan', 'floor', 'ceil', 'fabs', 'radians', 'degrees', 'exp', 'math.log'])}({sub()})",
            lambda: f"{pick(['atan2', 'math.pow', 'math.fmod', 'math.hypot', 'math.copysign'])}({sub()}, {self.number()})",
            lambda: f"{pick(self.texts())}.{pick(['upper()', 'lower()', 'strip()', 'split()', 'title()', 'capitalize()'])}",
            lambda: f"{pick(self.texts())}.{pick(['split', 'startswith', 'endswith', 'find', 'count', 'strip'])}({pick(self.texts())})",
            lambda: f"{pick(self.texts())}.replace({pick(self.texts())}, {pick(self.texts())})",
            lambda: f"{pick(self.texts())}.join({pick(self.lists())})",
            lambda: f"'%s|%{pick(['', '3', '-6', '06', '.2', '8.3'])}{pick('dfegs')}' % ({sub()}, {sub()})",
            lambda: f"dict(a={sub()}, b={sub()}){pick(['', QUOTED_KEY, '.get(1, 2)'])}",
            lambda: f"list(dict(a={sub()}, b={sub()}).{pick(['keys()', 'values()', 'items()'])})",
            lambda: f"python.isinstance({sub()}, {pick(['int', 'float', 'str', 'list', '(int, str)'])})",
            lambda: f"list(map({pick(['float', 'int', 'str', 'len'])}, {pick(self.lists())}))",
            lambda: f"{sub()} {pick(['&', '|', '^', '<<', '>>'])} {self.random.randint(0, 9)}",
        ]
        return pick(kinds)()

    def number(self):
        return self.random.choice([self.float(), str(self.random.randint(-20, 20))])

    def float(self):
        value = self.random.choice([
            self.random.uniform(-10, 10), round(self.random.uniform(-100, 100), 2), self.random.randint(-40, 40) / 8,
            self.random.uniform(1, 10) * 10.0 ** self.random.randint(-20, 25),
        ])
        return f"({value!r})" if value < 0 else repr(value)

    def bound(self):
        return self.random.choice(["", str(self.random.randint(-4, 4))])

    def texts(self):
        return ["'abc'", "''", "'a b  c '", "'B_left'", "'_'", "'1.5'", "' 7 '", "\"it's\"", "'ä→'", "'a'", "r'\\n'", "'x\\ty'"]

    def lists(self):
        return ["[1, 2, 3]", "[]", "['a', 'b']", "(4.5, -1)", "[3, 1.5, True]", "'1 2 30'.split()", "[[1], [2, 'x']]", "'abc'"]

    def atoms(self):
        return [self.number() for _ in range(8)] + ["pi", "True", "False", "None", "1e3", "0x1f", "1_000"] + self.texts()[:6]


class FileGenerator:
    """Makes random files of properties, macros, blocks and conditions whose names often meet."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.macros = {}
        self.is_in_call = False

    def value(self):
        pick = self.random.choice
        name = pick("abc")
        return pick([
            str(self.random.randint(0, 9)), f"${{{name}}}", f"${{{name} * 2}}", f"{name}_${{{pick('abc')}}}", "'q r'", "true",
            f"${{[{name}, {pick('abc')}]}}", f"${{str({name}) + 'x'}}", "1.50", f"${{1 if {name} else 2}}", f"$${{{name}}}",
            "$(arg n)", f"${{len(str({name})) > 1}}",
        ])

    def property(self):
        pick = self.random.choice
        name = pick("abc")
        extra = pick([""] * 6 + [" scope='parent'", " scope='global'", " lazy_eval='false'", " lazy_eval='true'"])
        return pick([
            f'<xacro:property name="{name}" value="{self.value()}"{extra}/>',
            f'<xacro:property name="{name}" value="{self.value()}"{extra}/>',
            f'<xacro:property name="{name}" default="{self.value()}"/>',
            f'<xacro:property name="{name}"{extra}>{self.element(0)}</xacro:property>',
        ])

    def macro(self, depth):
        # In xacro, a macro that is defined anew within its own call has the new parameters in this call.
        if self.is_in_call:
            return ""
        pick = self.random.choice
        name = pick("uvw")
        parameters = {p: pick(["", "", ":=" + pick(["1", "'s t'", "${a}", "x"]), ":=^", ":=^|7"]) for p in "abc" if self.random.random() < 0.5}
        blocks = [p for p in ("*d", "**e") if self.random.random() < 0.3]
        body = "".join(self.part(depth - 1) for _ in range(self.random.randint(1, 3)))
        inserts = "".join(f'<in><xacro:insert_block name="{b.strip("*")}"/></in>' for b in blocks)
        self.macros[name] = (parameters, blocks)
        params = " ".join([p + d for p, d in parameters.items()] + blocks)
        return f'<xacro:macro name="{name}" params="{params}">{body}{inserts}</xacro:macro>'

    def call(self, depth):
        if not self.macros:
            return ""
        name = self.random.choice(sorted(self.macros))
        parameters, blocks = self.macros[name]
        given = [p for p, default in parameters.items() if not default or self.random.random() < 0.5]
        attributes = "".join(f' {p}="{self.value()}"' for p in given)
        outer, self.is_in_call = self.is_in_call, True
        inner = "".join(self.property() if self.random.random() < 0.1 else "" for _ in blocks)
        inner += "".join(f"<bl at='{self.value().replace(chr(39), '')}'>{self.element(depth - 1)}</bl>" for _ in blocks)
        self.is_in_call = outer
        return f"<xacro:{name}{attributes}>{inner}</xacro:{name}>"

    def element(self, depth):
        if depth <= 0:
            return f'<x v="{self.value()}"/>'
        return f'<x v="{self.value()}" w="{self.value()}">{self.part(depth - 1)}{self.part(depth - 1)}</x>'

    def part(self, depth):
        pick = self.random.choice
        kinds = [self.property, self.property, lambda: self.element(depth)]
        if depth > 0:
            kind = pick(["if", "unless"])
            kinds += [
                lambda: self.macro(depth), lambda: self.call(depth), lambda: self.call(depth), lambda: self.call(depth),
                lambda: f'<xacro:{kind} value="{pick(["true", "0", "${a}", "${b == 1}"])}">{self.part(depth - 1)}</xacro:{kind}>',
                lambda: f'<xacro:insert_block name="{pick("abc")}"/>' if self.random.random() < 0.2 else "",
                lambda: f'<t>{self.value()} and {self.value()}</t>',
            ]
        return pick(kinds)()

    def file(self):
        self.macros = {}
        start = "".join(f'<xacro:property name="{n}" value="{i}"/>' for i, n in enumerate("abc"))
        parts = "".join(self.part(3) for _ in range(self.random.randint(3, 10)))
        return f'<r xmlns:xacro="u"><xacro:arg name="n" default="5"/>{start}{parts}</r>'


def compare_random_files(count, seed):
    """Compares expansions of random files; returns how many differ."""
    generator = FileGenerator(seed)
    wrong, refused = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "random.xacro"
        for _ in range(count):
            path.write_text(generator.file())
            expected, _ = by_xacro(path, {})
            found = by_tatu(path, {}, {})
            both_refuse = isinstance(expected, str) and isinstance(found, str)
            refused += both_refuse
            is_one = isinstance(expected, str) or isinstance(found, str)
            message = None if both_refuse else f"{str(expected)[:200]}; {str(found)[:200]}" if is_one else difference(expected, found)
            if message:
                wrong += 1
                print(f"{path.read_text()}\n  {message}")
    print(f"{count} random files: {refused} refused by both, {wrong} differ")
    return wrong


def random_scalar(source):
    """Returns a random value of YAML without quotes, often almost a number."""
    pick = source.choice
    if source.random() < 0.3:
        return pick(["yes", "No", "on", "OFF", "true", "TRUE", "~", "null", "", "y", "n", ".inf", "-.INF", ".nan", "0o17", "1e3", "1.e+3",
                     "0x_1F", "0b11", "+12", "-0", "1:30", "1:30.5", "-1:00:00", "0:60", "190:20:30", "1_000", "._5", "5.", "+.5", "-.5e-3",
                     "a b", "a#b", "a #b", "'q'", '"d\\n"', "[1, a]", "{a: 1, b: [2]}", "!degrees 90", "!radians 2*pi", "!!str 5", "-", "08"])
    text = "".join(pick("0123456789.:_+-eEx ") for _ in range(source.randint(1, 6))).strip()
    # PyYAML refuses a colon after an empty key.
    return "0" if f"{text} ".startswith(": ") else text


def compare_yaml(count, seed):
    """Compares random values in YAML; returns how many differ."""
    source = random.Random(seed)
    wrong, refused = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "random.xacro"
        path.write_text("""<r xmlns:xacro="u"><a v="${python.repr(xacro.load_yaml('y.yaml'))}"/></r>""")
        for _ in range(count):
            text = f"k: {random_scalar(source)}\nl:\n  - {random_scalar(source)}\n"
            (Path(folder) / "y.yaml").write_text(text)
            expected, _ = by_xacro(path, {})
            found = by_tatu(path, {}, {})
            if isinstance(found, str) and (isinstance(expected, str) or "is a date" in found):
                refused += 1
            elif isinstance(expected, str) or isinstance(found, str) or difference(expected, found):
                wrong += 1
                print(f"{text}  {str(expected)[:150]}; {str(found)[:250]}")
    print(f"{count} files of YAML: {refused} refused by both, {wrong} differ")
    return wrong


def compare_expressions(count, seed):
    """Compares values of random expressions; returns how many differ."""
    generator = Generator(seed)
    expressions = [generator.expression(generator.random.randint(1, 4)) for _ in range(count)]
    run = subprocess.run([program(), "--expressions"], input="\n".join(expressions) + "\n", capture_output=True, text=True)
    answers = run.stdout.rstrip("\n").split("\n")
    if run.returncode or len(answers) != count:
        sys.exit(f"{len(answers)} of {count} answers: {run.stderr[-2000:]}")
    warnings.simplefilter("ignore")
    wrong, values, refused, larger, last_bits = 0, 0, 0, 0, 0
    for expression, answer in zip(expressions, answers):
        symbols = xacro.Table(xacro._global_symbols)
        try:
            expected = str(xacro.eval_text("${" + expression + "}", symbols))
        except Exception as error:
            expected = None
            reason = error
        if answer.startswith("!"):
            found = None
        else:
            found = minidom.parseString(answer).documentElement.getAttribute("v")
        if expected is None:
            refused += 1
            if found is not None:
                wrong += 1
                print(f"{expression}\n  only Tatu has a value: {found}; xacro: {reason}")
        elif found is None and ("more than 64 bits" in answer or "is a complex number" in answer):
            larger += 1
        elif found is None:
            wrong += 1
            print(f"{expression}\n  expected {expected}, Tatu refuses: {answer}")
        elif expected == found:
            values += 1
        elif same_numbers(expected, found) or (JUMPS.search(expression) and same_numbers(expected, found, 1e99)):
            last_bits += 1
        else:
            wrong += 1
            print(f"{expression}\n  expected {expected}\n  found    {found}")
    print(f"{count} expressions: {values} equal, {last_bits} equal but for the last bits of functions of math, "
          f"{refused} refused by both, {larger} with complex numbers or integers of more than 64 bits, {wrong} differ")
    return wrong


def same_numbers(expected, found, tolerance=1e-12):
    """Whether two texts are the same but for the last bits of the floats in them, which powers amplify."""
    number = re.compile(r"-?\d+\.\d+(?:e[+-]\d+)?|-?\d+e[+-]\d+")
    if number.sub("#", expected) != number.sub("#", found):
        return False
    return all(same(a, b, tolerance) for a, b in zip(number.findall(expected), number.findall(found)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--expressions", type=int, default=2000)
    parser.add_argument("--random-files", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--package", action="append", default=[])
    options = parser.parse_args()
    packages = {**PACKAGES, **dict(pair.split("=", 1) for pair in options.package)}
    provide_packages(packages)
    given = dict(word.split(":=", 1) for word in options.files if ":=" in word)
    files = [Path(word) for word in options.files if ":=" not in word]
    if files:
        wrong = compare_files(files, given, packages, False)
    else:
        wrong = compare_files(sorted((HERE / "inputs").glob("*.xacro")), ARGUMENTS, packages, options.record)
        wrong += compare_files(sorted((HERE / "refused").glob("*.xacro")), ARGUMENTS, packages, False)
        wrong += compare_random_files(options.random_files, options.seed)
        wrong += compare_yaml(options.random_files, options.seed)
        wrong += compare_expressions(options.expressions, options.seed)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
