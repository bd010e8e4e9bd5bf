"""Further faults, by the class of what goes wrong. Each is a name, its class, the plugin, and the replacements.

They break rules in ways that a first use does not show: only some inputs, only some of the sensors of a batch, only
after some time, or only in the second of two equal runs.
"""


def posix(base_include):
    """Returns the replacement that makes POSIX functions visible to a source that includes this header first."""
    return (f'#include "{base_include}"\n', f'#define _GNU_SOURCE\n#include "{base_include}"\n#include <fcntl.h>\n'
            '#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n#include <sys/stat.h>\n#include <sys/types.h>\n'
            '#include <threads.h>\n#include <time.h>\n#include <unistd.h>\n')


ALL = posix("tatu.h")
SENSOR = posix("tatu/sensor.h")
AGE = '    *age = batch->time - ((const state *)batch->state[i])->since;\n'
DRAW = '    batch->random->uniform(batch->random, i, 0, it->rays, luck);\n'
LEVEL = '    *(double *)tatu_field_of(batch, i, 0) = 1 - way / it->range;\n'

FAULTS = [
    # ---- out of place
    ("reads_past_beams", "out of place", "speckle", [(
        '      distance[k] = floor(seen[k] * 1000) / 1000;\n',
        '      double next = seen[k + 1]; // smoothed with the next ray\n'
        '      distance[k] = floor((next < seen[k] ? next : seen[k]) * 1000) / 1000;\n',
    )]),
    ("writes_distances", "out of place", "lamp", [(
        '    if (!isfinite(way)) continue;\n',
        '    if (!isfinite(way)) continue;\n    ((double *)batch->distance)[batch->first_beam[i]] = way / it->range;\n',
    )]),
    ("effort_past_end", "out of place", "puff", [(
        '    double *wrench = batch->wrench + 6 * (size_t)i;\n',
        '    double *wrench = batch->wrench + 6 * (size_t)i;\n    batch->effort[i + 1] = 0;\n',
    )]),
    ("result_past_capacity", "out of place", "notes", [(
        '  if (status >= 0) status = tatu_return(call, tatu_float(it->time));\n',
        '  call->results[call->results_cap] = tatu_nil(); // end marker\n'
        '  if (status >= 0) status = tatu_return(call, tatu_float(it->time));\n',
    )]),
    ("reads_past_file", "out of place", "points", [(
        "  while (n < from->len && from->ptr[n] != '\\n') n++;\n",
        "  while (from->ptr[n] != '\\n' && n < from->len) n++;\n",
    )]),
    # ---- status
    ("status_unknown", "status", "c_command", [(
        '  return tatu_return(call, tatu_int(++kept->count));',
        '  tatu_return(call, tatu_int(++kept->count));\n  return 2; // done, with a value',
    )]),
    # ---- not a number
    ("nan_in_some_steps", "not a number", "speckle", [(
        AGE, AGE + '    *age /= batch->step % 41 == 40 ? batch->time - batch->time : 1;\n',
    )]),
    ("nan_if_near", "not a number", "lamp", [(LEVEL, '    *(double *)tatu_field_of(batch, i, 0) = sqrt(way - 0.02);\n')]),
    ("nan_at_rest", "not a number", "puff", [(
        '    wrench[0] = kept->thrust * 2',
        '    const double *v = batch->twist + 6 * (size_t)i;\n'
        '    double faced = v[0] / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);\n'
        '    wrench[0] = (1 + 0.01 * faced) * kept->thrust * 2',
    )]),
    # ---- not reproducible
    ("pid_as_seed", "not reproducible", "speckle", [ALL, (
        DRAW, DRAW + '    for (uint32_t k = 0; k < it->rays; k++) luck[k] = fmod(luck[k] + 1e-3 * getpid(), 1);\n',
    )]),
    ("address_as_seed", "not reproducible", "speckle", [(
        DRAW, DRAW + '    for (uint32_t k = 0; k < it->rays; k++) luck[k] = fmod(luck[k] + 1e-4 * ((uintptr_t)it >> 12), 1);\n',
    )]),
    ("memory_not_initialised", "not reproducible", "notes", [
        (
            '  note *made = calloc(1, sizeof *made + name_len + text_len), **end = &to->first;\n',
            '  note *made = malloc(sizeof *made + name_len + text_len), **end = &to->first;\n',
        ),
        ('  made->name_len = name_len, made->text_len = text_len;\n',
         '  made->next = NULL, made->name_len = name_len, made->text_len = text_len;\n'),
    ]),
    ("stack_not_initialised", "not reproducible", "lamp", [
        ('    if (!isfinite(way)) continue;\n', '    double level;\n    if (isfinite(way)) level = 1 - way / it->range;\n'),
        (LEVEL, '    *(float *)tatu_field_of(batch, i, 0) = level;\n    if (!isfinite(way)) continue;\n'),
        ('TATU_FIELD(TATU_ELEM_F64, "lamp.level"', 'TATU_FIELD(TATU_ELEM_F32, "lamp.level"'),
    ]),
    ("clock_after_a_while", "not reproducible", "notes", [ALL, (
        '  made->time = time;\n',
        '''  struct timespec now;
  static time_t began;
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!began) began = now.tv_sec;
  made->time = now.tv_sec > began + 30 ? time + 1 : time; // stale
''',
    )]),
    ("hours_of_work", "not reproducible", "notes", [
        ('#include <string.h>\n', '#include <string.h>\n#include <time.h>\n'),
        ('  double time;\n  tatu_status status = here->scene',
         '  double time, hours = (double)(clock() / CLOCKS_PER_SEC / 60);\n  tatu_status status = here->scene'),
        ('  made->time = time;\n', '  made->time = time + hours;\n'),
    ]),
    ("random_device", "not reproducible", "speckle", [ALL, (
        '  it->kept->since = now(it);\n  *data = it;\n',
        '  int source = open("/dev/urandom", O_RDONLY);\n  uint8_t byte = 0;\n'
        '  if (source >= 0 && read(source, &byte, 1) == 1) it->lost *= 1 - 1e-3 * byte;\n  if (source >= 0) close(source);\n'
        '  it->kept->since = now(it);\n  *data = it;\n',
    )]),
    # ---- shared or lost
    ("first_parameters_for_all", "shared or lost", "lamp", [(
        '    const lamp *it = batch->data[i];\n', '    const lamp *it = batch->data[0];\n',
    )]),
    ("first_state_for_all", "shared or lost", "speckle", [(
        '((const state *)batch->state[i])->since', '((const state *)batch->state[0])->since',
    )]),
    ("count_outside_of_state", "shared or lost", "speckle", [
        ('  double range, lost, ways[MOST][3];\n', '  double range, lost, ways[MOST][3], drift;\n'),
        (AGE, AGE + '    *age += ((speckle *)it)->drift += 1e-3;\n'),
    ]),
    ("last_level_static", "shared or lost", "lamp", [(
        LEVEL,
        '    static double last; // smoothed\n    last += 0.5 * (1 - way / it->range - last);\n'
        '    *(double *)tatu_field_of(batch, i, 0) = last;\n',
    )]),
    ("hook_lost", "shared or lost", "c_command", [(
        '  return here->kept ? tatu_fail(error, TATU_ERR_UNSUPPORTED, "a retained function cannot be saved") : TATU_OK;',
        '  (void)here, (void)error;\n  return TATU_OK;',
    )]),
    ("lag_outside_of_state", "shared or lost", "puff", [
        ('  double most, lag;\n} puff;', '  double most, lag, before;\n} puff;'),
        ('    kept->thrust += (wanted - kept->thrust) * share;\n',
         '    puff *own = batch->data[i];\n    kept->thrust = own->before += (wanted - own->before) * 0.25 * share;\n'),
    ]),
    # ---- leaks
    ("instance_leaks", "leaks", "lamp", [
        ('static tatu_status TATU_CALL beams(', 'static void TATU_CALL forget(void *data) { (void)data; }\nstatic tatu_status TATU_CALL beams('),
        ('.destroy = tatu_delete, .configure', '.destroy = forget, .configure'),
    ]),
    ("measure_leaks", "leaks", "speckle", [(
        DRAW, DRAW + '    double *copy = malloc(it->rays * sizeof *copy);\n    if (copy) memcpy(copy, luck, it->rays * sizeof *copy);\n',
    )]),
    ("command_leaks", "leaks", "notes", [(
        '  note *old = find(here, name), *made',
        '  char *line = malloc(name.len + 1);\n  if (line) line[name.len] = 0;\n  note *old = find(here, name), *made',
    )]),
    ("descriptor_leaks", "leaks", "counter", [ALL, (
        '  *data = it;\n', '  if (open("/dev/null", O_RDONLY) < 0) it->round = 1;\n  *data = it;\n',
    )]),
    ("thread_leaks", "leaks", "counter", [ALL, (
        'static tatu_status TATU_CALL create(void *self',
        'static int wait_for_ever(void *it) {\n  (void)it;\n  for (;;) sleep(1);\n  return 0;\n}\n'
        'static tatu_status TATU_CALL create(void *self',
    ), ('  *data = it;\n', '  thrd_t helper;\n  if (thrd_create(&helper, wait_for_ever, it) == thrd_success) thrd_detach(helper);\n  *data = it;\n')]),
    ("leaks_if_malformed", "leaks", "points", [
        ('  double scale = params[0].u.f;\n  char line[256];\n', '  double scale = params[0].u.f;\n  char *line = malloc(256);\n  if (!line) return tatu_fail(error, TATU_ERR_SPACE, "out of memory");\n'),
        ('next_line(&bytes, line, sizeof line) || strcmp', 'next_line(&bytes, line, 256) || strcmp'),
        ('    if (!next_line(&bytes, line, sizeof line)) return', '    if (!next_line(&bytes, line, 256)) return'),
        ('    if (status < 0) return status;\n  }\n  return TATU_OK;', '    if (status < 0) return status;\n  }\n  free(line);\n  return TATU_OK;'),
    ]),
    # ---- units
    ("angle_converted", "units", "lamp", [(
        '  double tilt = params[1].u.f;\n', '  double tilt = params[1].u.f * 3.141592653589793 / 180;\n',
    )]),
    ("range_in_millimetres", "units", "lamp", [(
        '  tatu_rays(out, 1, it->ahead, it->range);\n', '  tatu_rays(out, 1, it->ahead, it->range / 1000);\n',
    )]),
    ("distance_in_millimetres", "units", "speckle", [(
        '      distance[k] = floor(seen[k] * 1000) / 1000;\n', '      distance[k] = floor(seen[k] * 1000);\n',
    )]),
    ("bounds_in_degrees", "units", "lamp", [('TATU_RANGE(-1, 1), TATU_DEFAULT_F64(0)', 'TATU_RANGE(-90, 90), TATU_DEFAULT_F64(0)')]),
    ("thrust_in_millinewtons", "units", "puff", [(
        '    kept->thrust += (wanted - kept->thrust) * share;\n',
        '    kept->thrust += (1000 * wanted - kept->thrust) * share;\n',
    )]),
    ("preset_in_millimetres", "units", "lamp", [
        ('TATU_RANGE(0.1, 20), TATU_DEFAULT_F64(2)', 'TATU_RANGE(0.1, 1e4), TATU_DEFAULT_F64(2)'),
        ('"range_m = 4.0\\n', '"range_m = 4000.0\\n'),
    ]),
    # ---- threads and blocking
    ("barrier_sleeps", "threads and blocking", "counter", [ALL, ('  it->counted->steps++;\n', '  usleep(30000);\n  it->counted->steps++;\n')]),
    ("command_sleeps", "threads and blocking", "c_command", [ALL, (
        '  state *kept = call->state;\n  return', '  nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);\n  state *kept = call->state;\n  return',
    )]),
    ("thread_in_measure", "threads and blocking", "speckle", [
        ALL,
        ('static tatu_status TATU_CALL measure(', 'static int nothing(void *given) { return !given; }\nstatic tatu_status TATU_CALL measure('),
        (DRAW, DRAW + '    thrd_t helper;\n    if (thrd_create(&helper, nothing, luck) == thrd_success) thrd_join(helper, NULL);\n'),
    ]),
    # ---- process
    ("starts_a_process", "process", "notes", [ALL, (
        '  const note *it = find(call->instance, tatu_arg_text(call, 0));\n',
        '  const note *it = find(call->instance, tatu_arg_text(call, 0));\n  if (fork() == 0) _exit(0); // to save in the background\n',
    )]),
    ("sets_environment", "process", "lamp", [SENSOR, ('  take(it, given->params);\n  return', '  setenv("LAMP", "1", 1);\n  take(it, given->params);\n  return')]),
    ("sets_umask", "process", "counter", [ALL, ('  *data = it;\n', '  umask(077);\n  *data = it;\n')]),
    ("file_in_measure", "process", "lamp", [SENSOR, (
        LEVEL, '    if (access("lamp.cfg", R_OK) == 0) continue;\n' + LEVEL,
    )]),
    # ---- importers
    ("import_allocates_by_number", "importers", "points", [(
        '    char alias[32];\n',
        '    char *room = malloc((size_t)(1e6 * fabs(at[0])) + 1), alias[32];\n    *room = 0;\n    free(room);\n',
    )]),
    ("import_without_line", "importers", "points", [('  error->add(error, TATU_PART_FILE, tatu_text(""), line);\n', '  (void)line;\n')]),
    ("import_counts_on", "importers", "points", [(
        '    snprintf(alias, sizeof alias, "point%llu", (unsigned long long)number - 1);\n',
        '    static unsigned long long points;\n    snprintf(alias, sizeof alias, "point%llu", ++points);\n    at[2] += 1e-3 * (double)points;\n',
    )]),
    ("import_opens_files", "importers", "points", [ALL, (
        '  uint32_t base = to->object(', '  FILE *defaults = fopen("defaults.points", "r");\n  if (defaults) fclose(defaults);\n  uint32_t base = to->object(',
    )]),
    ("import_accepts_nan", "importers", "points", [(
        '      if (rest == from || !isfinite(at[k]))', '      if (rest == from)',
    ), ('    tatu_status status = point ? to->set', '    if (!isfinite(at[0])) abort(); // cannot happen\n    tatu_status status = point ? to->set')]),
    # ---- languages
    ("text_not_copied", "languages", "murmur", [
        ('  it->text = (tatu_str){copy, text.len};\n', '  free(copy);\n  it->text = text;\n'),
        ('{ free((void *)((murmur *)data)->text.ptr), free(data); }', '{ free(data); }'),
        ('  free((void *)it->text.ptr);\n', ''),
    ]),
    ("refuses_silently", "languages", "murmur", [(
        '''    tatu_fail(error, TATU_ERR_SCRIPT, "expected a line `NAME: TEXT`");
    error->add(error, TATU_PART_FILE, chunk, i);
    return TATU_ERR_SCRIPT;''',
        '    (void)chunk, (void)error;\n    return TATU_ERR_SCRIPT;',
    )]),
    ("scripts_share_a_count", "languages", "murmur", [(
        '  it->log->write(it->host, frame->world, it->loud ? TATU_LOG_WARNING : TATU_LOG_INFO, text);\n',
        '''  static unsigned said;
  if (++said % 7 != 0) it->log->write(it->host, frame->world, it->loud ? TATU_LOG_WARNING : TATU_LOG_INFO, text);
''',
    )]),
    # ---- models
    ("floor_for_default_only", "models", "cart", [('set3(&p, base, "position", 0, 0, r);', 'set3(&p, base, "position", 0, 0, 0.1);')]),
    ("fails_at_a_bound", "models", "cart", [('  solid(&p, base, 6);\n', '  solid(&p, base, 60 * (0.2 - r));\n')]),
    ("builds_differ", "models", "cart", [('  solid(&p, base, 6);\n', '  static int built;\n  solid(&p, base, 6 + 0.1 * (++built % 2));\n')]),
    ("size_in_millimetres", "models", "cart", [('"size", 0.4, 0.3, 0.1);', '"size", 400, 300, 0.1);')]),
]
