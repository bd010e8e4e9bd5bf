/* tatu/event.h: declarations of the events that a plugin publishes with tatu_host_events (host.h). */
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
  const tatu_event *const *events;
} tatu_ext_event;

#ifndef __cplusplus
/* Events of a plugin, for TATU_PLUGIN: pointers to tatu_event. */
#  define TATU_EVENTS(...) TATU_OFFER(TATU_EVENT, tatu_ext_event, .events = TATU_LIST_OF(tatu_event, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
