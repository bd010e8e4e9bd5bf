/* tatu/event.h: declarations of the events that a plugin publishes with tatu_host_events (host.h), and of those that it
 * receives. */
#ifndef TATU_EVENT_H
#define TATU_EVENT_H

#include "core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_EVENT "tatu.event/draft.4"

/* Declaration of an event by the plugin that publishes it; `tatu list events` prints it. Names without a dot
 * ("collision") are reserved for the host; those of plugins begin with a name space ("gripper.closed"). */
typedef struct tatu_event {
  uint32_t size;
  uint32_t reserved;
  const char *name;
  const char *text;                /* when it is published, one sentence */
  const tatu_param *const *fields; /* entries of the payload, which is a map; null: the payload is empty */
} tatu_event;

typedef struct tatu_ext_event {
  uint32_t size;
  uint32_t reserved;
  const tatu_event *const *events; /* may be null if `heard` is set */
  /* [step] Receives an event of a world: `name` and `payload`, a map, are valid during the call. `instance` and `state`
   * are the data and the state block of the plugin's instance in the world (tatu_ext_command.per_world), or null. Called where events are delivered, after
   * scripts and parts, in the order of the plugins. If it fails, it is reported and not called again in this world. Null
   * or absent in older plugins: the plugin receives no events. */
  tatu_status(TATU_CALL *heard)(void *self, void *instance, void *state, tatu_world *, tatu_str name,
                                const tatu_value *payload, tatu_error *);
  const char *const *listens; /* names of the events that `heard` receives; "*" as in tatu_service.events. Null: none */
} tatu_ext_event;

#ifndef __cplusplus
/* Receives events, for TATU_PLUGIN: the function and the names of the events. A plugin that also publishes events fills
 * tatu_ext_event itself, with TATU_OFFER. */
#  define TATU_LISTENS(Function, ...) TATU_OFFER(TATU_EVENT, tatu_ext_event, .heard = (Function), .listens = TATU_TEXTS(__VA_ARGS__))
/* Events of a plugin, for TATU_PLUGIN: pointers to tatu_event. */
#  define TATU_EVENTS(...) TATU_OFFER(TATU_EVENT, tatu_ext_event, .events = TATU_LIST_OF(tatu_event, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
