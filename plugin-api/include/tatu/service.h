/* tatu/service.h: services: components that run beside worlds, such as a socket, a bridge or a view. */
#ifndef TATU_SERVICE_H
#define TATU_SERVICE_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SERVICE "tatu.service/draft.4"

enum tatu_hold { TATU_GO = 0, TATU_HOLD = 1 };

/* A component that runs beside worlds: a remote API, a bridge, a viewer, a recorder. It is created once per session,
 * while worlds come and go. It may block only in its own threads, and these may call only session.wake and log.write.
 * Its calls of commands.call and session.request are recorded in the input log, from which a run can be replayed; calls
 * of other functions are not. Numeric arrays in arguments are recorded as f64 or i64. A negative
 * status from `barrier`, `event` or `resume` switches the service off and is reported once. */
typedef struct tatu_service {
  uint32_t size;
  uint32_t flags; /* 0 */
  const char *id;
  const char *text;
  const tatu_param *const *params;
  /* The life cycle of the service: `create` starts it in tatu_instance.session; `destroy` ends it, and joins its
   * threads before it returns. `save` and `load` [step]: its state concerning one world, for snapshots of that world; a
   * restored world ignores this state if the service is not running. `configure` is not called. */
  const tatu_life *life;
  /* [step] Before each step, and while stopped or paused, but not in the passes that follow a stop: executes requests
   * that are queued, never blocks, returns TATU_GO or TATU_HOLD. While any service holds, the session sleeps until
   * session.wake, at most 0.1 s, and calls all again. */
  tatu_status(TATU_CALL *barrier)(void *data, tatu_world *, uint64_t step, tatu_error *);
  /* [step] An event: name and payload, valid during the call. Delivered at the barrier: "started", "paused", "resumed",
   * "fault" (a map: code, message, and where known plugin, object, file, line); at the end "stopped". Null: it receives
   * no events. */
  tatu_status(TATU_CALL *event)(void *data, tatu_world *, tatu_str name, const tatu_value *payload, tatu_error *);
  /* [step] A command that this service called with a wait token, and that returned TATU_WAIT, has finished: its results
   * are in the frame, or `status` is negative and frame->error has the reason. Null: its commands cannot wait. */
  tatu_status(TATU_CALL *resume)(void *data, tatu_world *, uint64_t token, tatu_status status, const tatu_call *frame,
                                 tatu_error *);
  /* Names of the events that it receives, null-terminated; "*": all except the expensive ones ("collision",
   * "separation", "contact"), which must be named. Null: the five above. */
  const char *const *events;
  /* [step] Calls a client's function that this service passed as an argument; `local` is the number given to
   * session.function. Arguments are in the frame; results go into it, in memory from commands.alloc. Only this call may
   * block for a client: simulation time stands still, so poll session.interrupted. Commands that the client calls
   * before it returns run nested in this call, and cannot wait. The results are recorded in the input log.
   * TATU_ERR_GONE: the client has disconnected. Null: the service passes no functions. */
  tatu_status(TATU_CALL *call_func)(void *data, tatu_world *, uint32_t local, tatu_call *frame);
  /* [step] The last barrier: this world ends, and its pointer with it. The world is read-only; pending requests can
   * still be answered. Null: nothing to do. */
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
