/* A plugin that crashes on request. The environment variable CRASH_AT names the function, CRASH_HOW the kind of
 * crash (see harm.c). */
#include "tatu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void harm(const char *how);

static void at(const char *place) {
  const char *wanted = getenv("CRASH_AT"), *how = getenv("CRASH_HOW");
  if (wanted && how && strcmp(wanted, place) == 0) harm(how);
}

__attribute__((constructor)) static void loaded(void) { at("constructor"); }

/* ---- a command: crash.now() */

static tatu_status TATU_CALL now(tatu_call *call) {
  at("command");
  return tatu_return(call, tatu_float(1));
}
static const tatu_name now_name = {.size = sizeof(tatu_name), .name = "crash.now"};
static const tatu_name *const now_names[] = {&now_name, NULL};
static const tatu_command now_command = {.size = sizeof(tatu_command), .flags = TATU_COMMAND_RAW | TATU_COMMAND_SIDE_BY_SIDE,
  .names = now_names, .text = "Does harm.", .example = "crash.now()", .call = now};
static const tatu_command *const commands[] = {&now_command, NULL};
static const tatu_ext_command command_offer = {.size = sizeof(tatu_ext_command), .commands = commands};

/* ---- a sensor: crash_sensor, which works normally before step 3 */

static tatu_status TATU_CALL create(void *self, const tatu_instance *info, void **data, tatu_error *error) {
  (void)self; (void)info; (void)error;
  *data = NULL;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { (void)data; }
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *b, tatu_error *error) {
  (void)self; (void)error;
  if (b->step >= 3) at("measure");
  for (uint32_t i = 0; i < b->n; i++) *(double *)b->fields[i] = b->time;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .create = create, .destroy = destroy, .version = 1};
static const tatu_field field = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1},
  .name = "crash_sensor.time", .text = "When it measured."};
static const tatu_field *const fields[] = {&field, NULL};
static const char *const schemas[] = {"crash_sensor/1", NULL};
static const tatu_sensor sensor = {.size = sizeof(tatu_sensor), .id = "crash_sensor", .text = "Does harm.",
  .schemas = schemas, .fields = fields, .life = &life, .measure = measure};
static const tatu_sensor *const sensors[] = {&sensor, NULL};
static const tatu_ext_sensor sensor_offer = {.size = sizeof(tatu_ext_sensor), .kinds = sensors};

/* ---- a service: crash_service */

static tatu_status TATU_CALL start(void *self, const tatu_instance *instance, void **data, tatu_error *error) {
  (void)self; (void)instance; (void)error;
  *data = NULL;
  return TATU_OK;
}
static void TATU_CALL stop(void *data) { (void)data; }
static const tatu_life service_life = {.size = sizeof(tatu_life), .create = start, .destroy = stop};
static tatu_status TATU_CALL barrier(void *data, tatu_world *world, uint64_t step, tatu_error *error) {
  (void)data; (void)world; (void)error;
  if (step >= 3) at("barrier");
  return TATU_GO;
}
static const tatu_service service = {.size = sizeof(tatu_service), .id = "crash_service", .text = "Does harm.",
  .life = &service_life, .barrier = barrier};
static const tatu_service *const services[] = {&service, NULL};
static const tatu_ext_service service_offer = {.size = sizeof(tatu_ext_service), .services = services};

/* ---- the plugin */

static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  (void)host; (void)error;
  *self = NULL;
  at("init");
  return TATU_OK;
}
static void TATU_CALL ended(void *self) {
  (void)self;
  at("shutdown");
}
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  if (strcmp(id, TATU_COMMAND) == 0) return &command_offer;
  if (strcmp(id, TATU_SENSOR) == 0) return &sensor_offer;
  if (strcmp(id, TATU_SERVICE) == 0) return &service_offer;
  return NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.crashes", .name = "Crashes", .version = "1.0.0", .licence = "MIT",
  .init = init, .shutdown = ended, .extension = extension};
