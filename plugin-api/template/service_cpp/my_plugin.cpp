// my_plugin: a service in C++. A separate thread waits for external events, queues them, and wakes the session. Between
// two steps, the service applies the queued events to the world. In this example the thread waits for the clock, and
// queues a tick every `period`. Replace it with your socket, device or bridge: see `listen`.
//   signal my_plugin.ticks   number of ticks received; the simulation waits until there are `wait_for` of them
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace {

const size_t ROOM = 256;

// A running service. Members that both threads use are protected by the lock.
class ticker {
  const tatu_host_api &host;
  tatu_session *session;
  std::chrono::duration<double> period;
  int64_t wait_for, ticks = 0; // used only by the session's thread
  std::mutex lock;
  std::condition_variable changed;
  bool ending = false;
  std::deque<int64_t> queue; // ticks that have not been applied yet
  std::thread thread;

  // Runs on the service's own thread, which may call only two functions of the host: `wake`, and `write` of the log.
  void listen() {
    std::unique_lock<std::mutex> held(lock);
    for (int64_t tick = 1; !changed.wait_for(held, period, [this] { return ending; }); tick++) {
      if (queue.size() == ROOM) continue; // the queue is full: discard this tick
      queue.push_back(tick);
      host.session->wake(session);
    }
  }

  // Removes the oldest tick from the queue. Returns false if the queue is empty.
  bool take(int64_t &tick) {
    std::lock_guard<std::mutex> held(lock);
    if (queue.empty()) return false;
    tick = queue.front();
    queue.pop_front();
    return true;
  }

public:
  ticker(const tatu_host_api &api, tatu_session *of, const tatu_value *params)
      : host(api), session(of), period(params[0].u.f), wait_for(params[1].u.i), thread([this] { listen(); }) {}

  // The thread must have ended when this returns.
  ~ticker() {
    {
      std::lock_guard<std::mutex> held(lock);
      ending = true;
    }
    changed.notify_all();
    thread.join();
  }

  // Runs between two steps, and must never block. Its calls to commands are recorded in the input log, so that a run can
  // be replayed without the service.
  tatu_hold barrier(tatu_world *world, uint64_t) {
    for (int64_t tick; take(tick);) {
      ticks = tick;
      tatu::run(host, world, "sim.setInt32Signal", {tatu_string("my_plugin.ticks"), tatu_int(tick)});
    }
    return ticks < wait_for ? TATU_HOLD : TATU_GO;
  }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {&tatu::need_commands, &tatu::need_session, nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::service<ticker>("my_plugin", "Counts ticks of the clock in a signal.")
            .takes(tatu::param(TATU_F64, "period", "s", "Real time between two ticks.").range(0.001, 60).fallback(0.01))
            .takes(tatu::param(TATU_I64, "wait_for", nullptr, "The simulation waits for this many ticks.")
                     .at_least(0)
                     .fallback(tatu_int(1))));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
