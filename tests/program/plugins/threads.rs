//! Tests of commands whose results are computed by threads of their plugin.

use std::process::Command;

use crate::kit::*;

/// A plugin with four commands: `slow.square(x)` squares a number on a thread that sleeps for a while; `slow.twice()`
/// uses a ticket twice; `slow.early()` delivers its result before it waits; `slow.lost()` waits without a ticket.
const SLOW_PLUGIN: &str = r#"
#define _POSIX_C_SOURCE 200809L
#include "tatu.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
static const tatu_host *host;
static const tatu_host_commands *commands;
struct work { uint64_t ticket; double x; };
static void *run(void *arg) {
  struct work *w = arg;
  struct timespec nap = {0, 30 * 1000 * 1000};
  nanosleep(&nap, 0);
  char text[64];
  tatu_str result = {text, (uint64_t)snprintf(text, sizeof text, "%.17g", w->x * w->x)};
  commands->wake(host, w->ticket, result);
  free(w);
  return 0;
}
static tatu_status square(tatu_call *call) {
  if (call->resume) {
    tatu_str result;
    tatu_status status = call->api->woken(call, &result);
    char text[64] = {0};
    if (status < 0) return status;
    memcpy(text, result.ptr, result.len < 63 ? result.len : 63);
    return tatu_return(call, tatu_float(strtod(text, 0)));
  }
  uint64_t ticket;
  tatu_status status = call->api->ticket(call, &ticket);
  if (status < 0) return status;
  if (ticket) {
    struct work *w = malloc(sizeof *w);
    pthread_t thread;
    w->ticket = ticket, w->x = tatu_arg_float(call, 0);
    pthread_create(&thread, 0, run, w);
    pthread_detach(thread);
    fprintf(stderr, "a thread was started\n");
  }
  return call->api->wait(call, TATU_UNTIL_WAKE, 0, tatu_text(""), 1);
}
static tatu_status twice(tatu_call *call) {
  uint64_t ticket;
  if (call->resume) return tatu_return(call, tatu_float(7));
  call->api->ticket(call, &ticket);
  tatu_status first = commands->wake(host, ticket, tatu_text("one")), second = commands->wake(host, ticket, tatu_text("two"));
  if (ticket && (first != TATU_OK || second != TATU_ERR_MISSING)) return tatu_fail(call->error, TATU_ERR, "used twice");
  return call->api->wait(call, TATU_UNTIL_WAKE, 0, tatu_text(""), 1);
}
static tatu_status lost(tatu_call *call) { return call->api->wait(call, TATU_UNTIL_WAKE, 0, tatu_text(""), 1); }
static const tatu_param x = {.size = sizeof x, .type = TATU_F64, .key = "x", .text = "A number."};
static const tatu_param *const params[] = {&x, 0};
#define COMMAND(Name) static const tatu_command Name##_command = {.size = sizeof Name##_command, \
  .names = TATU_NAME("slow." #Name), .text = "For tests.", .call = Name,
COMMAND(square) .params = params};
COMMAND(twice)};
COMMAND(lost)};
static const tatu_command *const all[] = {&square_command, &twice_command, &lost_command, 0};
static const tatu_ext_command command = {.size = sizeof command, .commands = all};
static tatu_status init(const tatu_host *h, void **self, tatu_error *error) {
  (void)self; (void)error;
  host = h;
  commands = h->service(h, TATU_HOST_COMMANDS);
  return TATU_OK;
}
static const void *extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_COMMAND) ? 0 : &command;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.slow", .name = "Slow", .version = "0.1.0", .licence = "MIT",
  .init = init, .extension = extension};
"#;

fn with_slow(script: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\".\"]\n{}", watcher("pilot", script)));
    place.write("slow.c", SLOW_PLUGIN);
    let (include, out) = (root().join("plugin-api/include"), library("tatu_slow"));
    let mut cc = Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"]);
    succeed(cc.arg(include).args(["-o", &out, "slow.c", "-pthread"]).current_dir(place.path()));
    place
}

#[test]
fn a_result_of_a_thread_is_replayed_without_the_thread() {
    let script = "function sysCall_thread()
            for i = 1, 4 do
                local y = slow.square(i + 0.5)
                sim.setFloatSignal('y' .. i, y)
                print(string.format('%d: %g at %.2f', i, y, sim.getSimulationTime()))
            end
        end";
    let place = with_slow(script);
    let args = ["--log", "run.log", "--trace", "t.jsonl", "--hashes", "--steps", "20", "--realtime"];
    let done = place.run(&args).good();
    let told = |err: &str| err.lines().filter(|l| l.contains(" at 0.")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(done.err.matches("a thread was started").count(), 4, "{}", done.err);
    for (i, y) in [2.25, 6.25, 12.25, 20.25].iter().enumerate() {
        assert!(done.err.contains(&format!("{}: {y} at", i + 1)), "{}", done.err);
    }
    let again = place.tatu(&["run", "--replay", "run.log", "--trace", "again.jsonl", "--hashes"]).good();
    assert_eq!(again.err.matches("a thread was started").count(), 0, "{}", again.err);
    assert_eq!(told(&again.out), told(&done.err), "the replay has different results or times");
    assert_eq!(place.read("t.jsonl"), place.read("again.jsonl"));
}

#[test]
fn a_ticket_is_used_once_and_a_wait_needs_one() {
    let script = "function sysCall_thread() print('twice ' .. slow.twice()) slow.lost() end";
    let done = with_slow(script).run(&["--steps", "10"]);
    done.reports(&["twice 7", "a wait for a wake requires a ticket"]);
    // A script can wait only in its thread, not in `init`.
    let script = "function sysCall_init() slow.square(2) end";
    with_slow(script).run(&["--steps", "3"]).reports(&["no ticket was issued, because the caller cannot wait"]);
}

#[test]
fn a_script_that_has_ended_gets_no_result() {
    let script = "function sysCall_thread() slow.square(2) print('never') end";
    let done = with_slow(script).run(&["--steps", "1"]).good();
    assert!(!done.err.contains("never"), "{}", done.err);
}

#[test]
fn a_wait_from_a_snapshot_ends_with_an_error() {
    let script = "function sysCall_thread()
            local ok, text = pcall(slow.square, 2)
            print('it says ' .. tostring(text))
        end";
    let place = with_slow(script);
    // The snapshot is taken in the first step, while the thread is still computing, which takes 30 ms.
    place.run(&["--steps", "1", "--snapshot-at", "0.05", "half"]);
    let done = place.run(&["--from", "half", "--steps", "10"]);
    done.reports(&["it says", "the result of the thread was lost"]);
}
