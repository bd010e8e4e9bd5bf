/* tatu/service.h: services, which are components that run beside worlds, such as a socket, a bridge or a viewer. */
#ifndef TATU_SERVICE_H
#define TATU_SERVICE_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SERVICE "tatu.service/draft.4"

enum tatu_hold { TATU_GO = 0, TATU_HOLD = 1 };

/* A component that runs beside worlds: a remote API, a bridge, a viewer, a recorder. It is created once per session,
 * and outlives the worlds of the session. It may block only in its own threads, and these may call only session.wake,
 * session.stop, commands.wake and log.write. Its calls to commands.call and session.request are recorded in the input
 * log, from which a run can be replayed; calls to other functions are not. Numeric arrays in arguments are recorded as
 * f64 or i64. If `barrier`, `event` or `resume` returns a negative status, the error is reported once and the service is
 * switched off. */
typedef struct tatu_service {
  uint32_t size;
  uint32_t flags; /* 0 */
  const char *id;
  const char *text;
  const tatu_param *const *params;
  /* The life cycle of the service. `create` starts it in tatu_instance.session; `destroy` ends it, and must join its
   * threads before it returns. `save` and `load` are [step]: they write and restore the service's state that concerns
   * one world, for snapshots of that world. If the service is not running when a world is restored, this state is
   * ignored. `configure` is not called. */
  const tatu_life *life;
  /* [step] Executes queued requests, must not block, and returns TATU_GO or TATU_HOLD. Called before each step and
   * while the world is stopped or paused, but not in the passes that follow a stop. While any service holds, the
   * session sleeps until session.wake is called, for at most 0.1 s, and then calls all barriers again. */
  tatu_status(TATU_CALL *barrier)(void *data, tatu_world *, uint64_t step, tatu_error *);
  /* [step] Receives an event; name and payload are valid during the call. Events are delivered at the barrier:
   * "started", "paused", "resumed", "fault" (a map with code and message, and with plugin, object, file and line if
   * they are known) and, at the end of a run, "stopped". A service that lists it also receives "held" (a map with
   * text), when a service has held the session for 5 s. Null: the service receives no events. */
  tatu_status(TATU_CALL *event)(void *data, tatu_world *, tatu_str name, const tatu_value *payload, tatu_error *);
  /* [step] Called when a command has finished that this service called with a wait token and that returned TATU_WAIT:
   * its results are in the frame, or `status` is negative and frame->error contains the reason. Null: commands that
   * this service calls cannot wait. */
  tatu_status(TATU_CALL *resume)(void *data, tatu_world *, uint64_t token, tatu_status status, const tatu_call *frame,
                                 tatu_error *);
  /* Names of the events that the service receives, null-terminated; "*": all except the expensive ones ("collision",
   * "separation", "contact"), which must be listed explicitly. Null: the five listed for `event`. */
  const char *const *events;
  /* [step] Calls a client's function that this service passed as an argument; `local` is the number passed to
   * session.function. Reads the arguments from the frame, and writes the results to it, in memory from commands.alloc.
   * This is the only call that may block to wait for a client. Simulation time does not advance meanwhile, so poll
   * session.interrupted. Commands that the client calls before it returns run nested in this call, and cannot wait. The
   * results are recorded in the input log. TATU_ERR_GONE: the client has disconnected. Null: the service does not pass
   * functions as arguments. */
  tatu_status(TATU_CALL *call_func)(void *data, tatu_world *, uint32_t local, tatu_call *frame);
  /* [step] The last barrier of a world, whose pointer is invalid afterwards. The world is read-only; pending requests
   * can still be answered. Null: nothing to do. */
  tatu_status(TATU_CALL *last)(void *data, tatu_world *, tatu_error *);
} tatu_service;

typedef struct tatu_ext_service {
  uint32_t size;
  uint32_t reserved;
  const tatu_service *const *services;
} tatu_ext_service;

#ifndef __cplusplus
/* Services of a plugin, for TATU_PLUGIN: pointers to tatu_service. */
#  define TATU_SERVICES(...) TATU_OFFER(TATU_SERVICE, tatu_ext_service, .services = TATU_LIST_OF(tatu_service, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
