//! Scripts in Python that do harm, on purpose or by mistake: each costs only itself.
#![cfg(target_os = "linux")]

use std::time::{Duration, Instant};

use crate::kit::*;

/// Texts of `sysCall_actuation`, and words of the error; empty if there need not be one.
#[rustfmt::skip]
const HOSTILE: &[(&str, &str)] = &[
    ("while True: pass", "took too long"),
    ("while True:\n  try:\n   while True: pass\n  except BaseException: pass", "took too long"),
    ("import os\n[os.fork() for _ in range(1000)]", "PermissionError"),
    ("import os\nwhile True:\n  try: os.fork()\n  except OSError: pass", "took too long"),
    ("import subprocess\nsubprocess.Popen(['sleep','100'])", "PermissionError"),
    ("import os, signal\nos.kill(os.getppid(), signal.SIGKILL)", "PermissionError"),
    ("import os, signal\nos.kill(-1, signal.SIGTERM)", "PermissionError"),
    ("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)", "was killed"),
    ("import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)", "took too long"),
    ("import os, signal\nos.killpg(os.getpgid(os.getppid()), signal.SIGTERM)", "PermissionError"),
    ("import os\nos._exit(0)", "exited with code 0"),
    ("import sys\nsys.exit(1)", ""),
    ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    ("import ctypes\nctypes.string_at(0)", "segmentation fault"),
    ("import os\nos.abort()", "abort"),
    ("import os\nos.closerange(0, 100)", "process of the script has ended"),
    ("import os\nfor fd in range(3, 100):\n  try: os.write(fd, b'garbage' * 10)\n  except OSError: pass", "not a message"),
    ("import os\nfor fd in range(3, 100):\n  try: os.write(fd, b'\\x05\\0\\0\\0\\x14\\0\\0\\0\\0' * 10)\n  except OSError: pass", ""),
    ("import os\nfor fd in range(3, 100):\n  try: os.write(fd, b'\\xff\\xff\\xff\\xff' * 10)\n  except OSError: pass", "not a message"),
    ("import os\nfor fd in range(3, 100):\n  try: os.read(fd, 1)\n  except OSError: pass", "took too long"),
    ("def f(n): return f(n + 1)\nf(0)", "RecursionError"),
    ("import sys\nsys.setrecursionlimit(10**9)\ndef f(n): return f(n + 1)\nf(0)", ""),
    ("def f(n):\n  sim.getSimulationTime()\n  return f(n + 1)\nf(0)", "RecursionError"),
    ("while True: print('x' * 1000)", "took too long"),
    ("import os\nwhile True: os.write(1, b'x' * 10000)", "took too long"),
    ("import sys\nwhile True: sys.stderr.write('no line end')", "took too long"),
    ("a = []\nwhile True: a.append('x' * 10**7)", ""),
    ("bytearray(8 * 10**9)", "memory"),
    ("sim.setStringSignal('a', 'x' * 10**8)\nsim.getStringSignal('a')", ""),
    ("sim.setStringSignal('a', b'x' * 300 * 10**6)", ""),
    ("sim.setObjectPosition(0, {1, 2}, object())", "type set"),
    ("a = []\na.append(a)\nsim.setStringSignal('a', a)", "contains itself"),
    ("a = 1\nfor i in range(100000): a = [a]\nsim.packTable(a)", "contains itself"),
    ("import threading\ndef f():\n  while True: sim.getSimulationTime()\nt = threading.Thread(target=f); t.start(); t.join(0.2)", ""),
    ("import threading\ndef f():\n  while True: pass\nthreading.Thread(target=f).start()", ""),
    ("import threading, time\nwhile True: threading.Thread(target=lambda: __import__('select').select([], [], [], 100)).start()", "can't start new thread"),
    ("class E(Exception):\n  def __str__(self): raise ValueError\nraise E", "cannot be shown"),
    ("class E(BaseException):\n  def __str__(self): return 'x' * 10**8\nraise E", "E: xxx"),
    ("raise Exception('\\ud800')", "Exception"),
    ("sim.callScriptFunction('again', sim.handle_self)", "nested more than 64"),
    ("import sys\nsys.stdout.close(); sys.stderr.close(); print('x')", ""),
    ("import builtins\nfor n in list(vars(builtins)): delattr(builtins, n)", ""),
    ("import tatu_runtime.link as l\nl.Link.send = None\nsim.getSimulationTime()", ""),
    ("import signal\nsignal.signal(signal.SIGALRM, lambda *a: 1/0)\nsignal.setitimer(signal.ITIMER_REAL, 0.01)\nwhile True: sim.getSimulationTime()", "ZeroDivisionError"),
    ("import select\nselect.select([], [], [], 1000)", "took too long"),
    ("input()", "EOFError"),
    ("sim.removeObjects([sim.getObject('.')])", ""),
    ("sim.step()", ""),
];

/// A robot that drives, and far from it an object with a script in Python.
fn scene(way: &str) -> TestFolder {
    let drive = "function sysCall_actuation()
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 2)
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), 1)
    end";
    // 5000000 instructions stand for one second.
    let place = TestFolder::scene(&format!(
        "[scene.budget]\ninstructions = 5000000\n{}[[object]]\nkind = \"dummy\"\nalias = \"bad\"\n\
         position_m = [50.0, 0.0, 0.0]\nscript = \"bad.py\"\n",
        pioneer(drive, "")
    ));
    let body: String = way.split('\n').map(|line| format!("  {line}\n")).collect();
    let again = "def again(): return sim.callScriptFunction('again', sim.handle_self)";
    place.write(
        "bad.py",
        &format!("{again}\ndef sysCall_init():\n  sim = require('sim')\ndef sysCall_actuation():\n{body}"),
    );
    place
}

/// Returns the hashes of the robot in each step.
fn hashes(place: &TestFolder) -> Vec<String> {
    place.lines("t.jsonl").iter().map(|l| l.0["hashes"]["/Pioneer_p3dx"].to_string()).collect()
}

/// Returns the processes whose environment or command line contains a word.
fn processes(word: &str) -> Vec<String> {
    let all = std::fs::read_dir("/proc").unwrap().filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let has = |id: &String| {
        std::fs::read(format!("/proc/{id}/environ")).is_ok_and(|e| String::from_utf8_lossy(&e).contains(word))
    };
    all.filter(|id| id.bytes().all(|b| b.is_ascii_digit())).filter(has).collect()
}

#[test]
fn a_hostile_script_costs_only_itself() {
    const ARGS: &[&str] = &["--steps", "4", "--allow", "python", "--trace", "t.jsonl", "--hashes"];
    let place = scene("pass");
    place.run(ARGS).good();
    let alone = hashes(&place);
    for (n, (way, words)) in HOSTILE.iter().enumerate() {
        let (place, begun) = (scene(way), Instant::now());
        let mark = format!("TATU_TEST_HOSTILE_{}_{n}", std::process::id());
        let args = [&["run", "scene.toml", "--json"], ARGS].concat();
        let done = run(program(), place.path(), &args, &[(&mark, "1")]);
        assert!(done.signal.is_none() && done.code < 2, "{way}: {:?} {}", done.signal, done.err);
        assert!(begun.elapsed() < Duration::from_secs(60), "{way}: {:?}", begun.elapsed());
        assert_eq!(hashes(&place), alone, "{way}");
        let errors = done.json()["errors"].to_string();
        assert!(errors.contains(words) || done.err.contains(words), "{way}: {errors} {}", done.err);
        assert!(words.is_empty() || errors.contains("/bad"), "{way}: {errors}");
        assert_eq!(processes(&mark), [""; 0], "{way}");
    }
}

#[test]
fn the_process_of_a_script_ends_with_the_program_even_if_that_is_killed() {
    let place = scene("while True: pass");
    let mark = format!("TATU_TEST_KILLED_{}", std::process::id());
    let mut program = std::process::Command::new(program())
        .args(["run", "scene.toml", "--allow", "python", "--set", "scene.script_budget=1000000000"])
        .current_dir(place.path())
        .env(&mark, "1")
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while processes(&mark).len() < 2 && begun.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(processes(&mark).len(), 2);
    program.kill().unwrap();
    program.wait().unwrap();
    while !processes(&mark).is_empty() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(processes(&mark), [""; 0]);
}
