//! Edits that the build makes to Lua's files, so that work in C code is charged to the budget of a call
//! (`src/lua_charges.h`).
//!
//! Lua calls its hook only after instructions. These edits also charge all work that a script can make arbitrarily
//! long: calls of the C interface that may run metamethods (and thereby every library loop over a table), loops over
//! bytes, nodes, values and tokens, and conversions of numbers. When the budget is spent, functions that may raise an
//! error do so; after all other functions, the next instruction raises it. `docs/reference/script-costs.md` lists the
//! functions.
//!
//! Each original text must occur exactly once in its file. Otherwise the build fails, because every edit must be
//! reviewed when Lua is updated.

/// The edits: file, original text, and its replacement.
pub(crate) const CHARGES: &[(&str, &str, &str)] = &[
    // The counters, in the global state that all threads share.
    (
        "lstate.h",
        "  struct lua_State *mainthread;\n",
        "  struct lua_State *mainthread;\n  unsigned long long tatu_used, tatu_limit;\n",
    ),
    ("lstate.c", "  g->mainthread = L;\n", "  g->mainthread = L;\n  g->tatu_used = 0;\n  g->tatu_limit = ~0ULL;\n"),
    // Tracking of the running thread.
    (
        "ldo.c",
        "  luai_userstateresume(L, nargs);\n",
        "  luai_userstateresume(L, nargs);\n  struct lua_State *tatu_before = tatu_lua_enter(L);\n",
    ),
    (
        "ldo.c",
        "  *nresults = (status == LUA_YIELD) ?",
        "  tatu_lua_enter(tatu_before);\n  *nresults = (status == LUA_YIELD) ?",
    ),
    (
        "lstate.c",
        "  status = luaE_resetthread(L, L->status);\n  lua_unlock(L);",
        "  struct lua_State *tatu_before = tatu_lua_enter(L);\n  status = luaE_resetthread(L, L->status);\n  \
         tatu_lua_enter(tatu_before);\n  lua_unlock(L);",
    ),
    // The C interface: functions that may run a metamethod or a function, and that may therefore raise an error.
    (
        "lapi.c",
        "void lua_arith (lua_State *L, int op) {\n  lua_lock(L);\n",
        "void lua_arith (lua_State *L, int op) {\n  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n",
    ),
    (
        "lapi.c",
        "  lua_lock(L);  /* may call tag method */\n  o1 =",
        "  lua_lock(L);  /* may call tag method */\n  tatu_charge(L, TATU_VALUE);\n  o1 =",
    ),
    (
        "lapi.c",
        "void lua_concat (lua_State *L, int n) {\n  lua_lock(L);\n",
        "void lua_concat (lua_State *L, int n) {\n  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n",
    ),
    (
        "lapi.c",
        "  lua_lock(L);\n  t = index2value(L, idx);\n  luaV_objlen(",
        "  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n  t = index2value(L, idx);\n  luaV_objlen(",
    ),
    (
        "lapi.c",
        "  lua_lock(L);\n  t = index2value(L, idx);\n  if (luaV_fastget(L, t, s2v(L->top.p - 1), slot, luaH_get))",
        "  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n  t = index2value(L, idx);\n  if (luaV_fastget(L, t, s2v(L->top.p - 1), slot, luaH_get))",
    ),
    (
        "lapi.c",
        "  lua_lock(L);\n  t = index2value(L, idx);\n  if (luaV_fastgeti(",
        "  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n  t = index2value(L, idx);\n  if (luaV_fastgeti(",
    ),
    (
        "lapi.c",
        "  lua_lock(L);\n  api_checknelems(L, 2);\n  t = index2value(L, idx);\n",
        "  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n  api_checknelems(L, 2);\n  t = index2value(L, idx);\n",
    ),
    (
        "lapi.c",
        "  lua_lock(L);\n  api_checknelems(L, 1);\n  t = index2value(L, idx);\n  if (luaV_fastgeti(",
        "  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n  api_checknelems(L, 1);\n  t = index2value(L, idx);\n  if (luaV_fastgeti(",
    ),
    ("lapi.c", "  StkId func;\n  lua_lock(L);\n", "  StkId func;\n  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n"),
    (
        "lapi.c",
        "  ptrdiff_t func;\n  lua_lock(L);\n",
        "  ptrdiff_t func;\n  lua_lock(L);\n  tatu_charge(L, TATU_VALUE);\n",
    ),
    // Values moved on the stack, in calls with many arguments or results.
    (
        "ldo.c",
        "  lua_unlock(L);\n  n = (*f)(L);  /* do the actual call */\n",
        "  if (L->top.p - func > TATU_CHAIN) tatu_charge(L, (unsigned)(L->top.p - func) * TATU_VALUE)\n  lua_unlock(L);\n  n = (*f)(L);  /* do the actual call */\n",
    ),
    (
        "ldo.c",
        "    nres = wanted;  /* don't need them */\n",
        "    nres = wanted;  /* don't need them */\n  if (wanted > TATU_CHAIN) tatu_lua_count(L, (unsigned)wanted * TATU_VALUE);\n",
    ),
    (
        "ldo.c",
        "      for (i = 0; i < narg1; i++)  /* move down",
        "      if (narg1 > TATU_CHAIN) tatu_lua_count(L, (unsigned)narg1 * TATU_VALUE);\n      for (i = 0; i < narg1; i++)  /* move down",
    ),
    (
        "ltm.c",
        "  for (i = 0; i < wanted && i < nextra; i++)\n",
        "  if (wanted > TATU_CHAIN) tatu_lua_count(L, (unsigned)wanted * TATU_VALUE);\n  for (i = 0; i < wanted && i < nextra; i++)\n",
    ),
    // Nested calls.
    (
        "ldo.c",
        "    if (lim < ci->top.p) lim = ci->top.p;\n",
        "    if (lim < ci->top.p) lim = ci->top.p;\n    G(L)->tatu_used += TATU_VALUE;\n",
    ),
    (
        "ldebug.c",
        "  lua_lock(L);\n  for (ci = L->ci; level > 0 &&",
        "  lua_lock(L);\n  if (level > TATU_CHAIN) tatu_lua_count(L, (unsigned)level * TATU_VALUE);\n  for (ci = L->ci; level > 0 &&",
    ),
    // Chains of metatables.
    (
        "lvm.c",
        "    t = tm;  /* else try to access 'tm[key]' */\n",
        "    t = tm;  /* else try to access 'tm[key]' */\n    if (loop > 0) tatu_lua_count(L, TATU_INSTRUCTION);\n",
    ),
    (
        "lvm.c",
        "    t = tm;  /* else repeat assignment over 'tm' */\n",
        "    t = tm;  /* else repeat assignment over 'tm' */\n    if (loop > 0) tatu_lua_count(L, TATU_INSTRUCTION);\n",
    ),
    // Tables: collision chains of hash nodes, and nodes without a value.
    (
        "ltable.c",
        "  Node *n = mainpositionTV(t, key);\n  for (;;) {",
        "  Node *n = mainpositionTV(t, key);\n  int tatu_steps = 0;\n  for (;;) {",
    ),
    (
        "ltable.c",
        "        return &absentkey;  /* not found */\n      n += nx;\n    }\n  }\n}\n\n\n/*\n** returns the index for 'k'",
        "        return &absentkey;  /* not found */\n      n += nx;\n      if (++tatu_steps > TATU_CHAIN) tatu_lua_count_here(TATU_VALUE);\n    }\n  }\n}\n\n\n/*\n** returns the index for 'k'",
    ),
    (
        "ltable.c",
        "    Node *n = hashint(t, key);\n    for (;;) {",
        "    Node *n = hashint(t, key);\n    int tatu_steps = 0;\n    for (;;) {",
    ),
    (
        "ltable.c",
        "        if (nx == 0) break;\n        n += nx;\n",
        "        if (nx == 0) break;\n        n += nx;\n        if (++tatu_steps > TATU_CHAIN) tatu_lua_count_here(TATU_VALUE);\n",
    ),
    (
        "ltable.c",
        "  Node *n = hashstr(t, key);\n  lua_assert(key->tt == LUA_VSHRSTR);\n",
        "  Node *n = hashstr(t, key);\n  int tatu_steps = 0;\n  lua_assert(key->tt == LUA_VSHRSTR);\n",
    ),
    (
        "ltable.c",
        "        return &absentkey;  /* not found */\n      n += nx;\n    }\n  }\n}\n\n\nconst TValue *luaH_getstr",
        "        return &absentkey;  /* not found */\n      n += nx;\n      if (++tatu_steps > TATU_CHAIN) tatu_lua_count_here(TATU_VALUE);\n    }\n  }\n}\n\n\nconst TValue *luaH_getstr",
    ),
    (
        "ltable.c",
        "        othern += gnext(othern);\n",
        "        othern += gnext(othern), tatu_lua_count(L, TATU_VALUE);\n",
    ),
    (
        "ltable.c",
        "  for (; i < asize; i++) {  /* try first array part */\n",
        "  for (; i < asize; i++, tatu_lua_count(L, TATU_VALUE)) {  /* try first array part */\n",
    ),
    (
        "ltable.c",
        "  for (i -= asize; cast_int(i) < sizenode(t); i++) {  /* hash part */\n",
        "  for (i -= asize; cast_int(i) < sizenode(t); i++, tatu_lua_count(L, TATU_VALUE)) {  /* hash part */\n",
    ),
    // Strings.
    (
        "lstring.c",
        "  lua_assert(str != NULL);  /* otherwise 'memcmp'/'memcpy' are undefined */\n",
        "  int tatu_steps = 0;\n  lua_assert(str != NULL);  /* otherwise 'memcmp'/'memcpy' are undefined */\n",
    ),
    (
        "lstring.c",
        "      return ts;\n    }\n  }\n  /* else must create",
        "      return ts;\n    }\n    if (++tatu_steps > TATU_CHAIN) tatu_lua_count(L, TATU_VALUE);\n  }\n  /* else must create",
    ),
    (
        "lstring.c",
        "  lua_assert(a->tt == LUA_VLNGSTR && b->tt == LUA_VLNGSTR);\n",
        "  lua_assert(a->tt == LUA_VLNGSTR && b->tt == LUA_VLNGSTR);\n  if (a != b && len == b->u.lnglen) tatu_lua_count_here(len);\n",
    ),
    (
        "lvm.c",
        "  size_t rl2 = tsslen(ts2);\n",
        "  size_t rl2 = tsslen(ts2);\n  size_t tatu_least = rl1 < rl2 ? rl1 : rl2;\n  if (tatu_least > TATU_CHAIN) tatu_lua_count_here(tatu_least * TATU_BYTE);\n",
    ),
    (
        "lobject.c",
        "static int tostringbuff (TValue *obj, char *buff) {\n  int len;\n",
        "static int tostringbuff (TValue *obj, char *buff) {\n  int len;\n  tatu_lua_count_here(TATU_NUMERAL);\n",
    ),
    (
        "lobject.c",
        "  lua_Integer i; lua_Number n;\n  const char *e;\n",
        "  lua_Integer i; lua_Number n;\n  const char *e;\n  tatu_lua_count_here(TATU_NUMERAL + strlen(s) * TATU_BYTE);\n",
    ),
    (
        "lobject.c",
        "    const char *nl = strchr(source, '\\n');",
        "    tatu_lua_count_here(srclen);\n    const char *nl = strchr(source, '\\n');",
    ),
    // Source texts and bytecode.
    (
        "lzio.c",
        "    return EOZ;\n  z->n = size - 1;",
        "    return EOZ;\n  tatu_charge(L, (unsigned long long)size * TATU_BYTE);\n  z->n = size - 1;",
    ),
    (
        "lparser.c",
        "  int i;\n  for (i = cast_int(fs->nactvar) - 1;",
        "  int i;\n  tatu_lua_count(fs->ls->L, (fs->nactvar + fs->nups) * (TATU_VALUE / 4));\n  for (i = cast_int(fs->nactvar) - 1;",
    ),
    (
        "lparser.c",
        "  for (i = g; i < gl->n - 1; i++)  /* remove goto",
        "  tatu_charge(ls->L, (unsigned)(gl->n - g) * TATU_VALUE);\n  for (i = g; i < gl->n - 1; i++)  /* remove goto",
    ),
    (
        "lparser.c",
        "  /* check labels in current function for a match */\n",
        "  /* check labels in current function for a match */\n  tatu_charge(ls->L, (unsigned)(dyd->label.n - ls->fs->firstlabel) * TATU_VALUE);\n",
    ),
    (
        "lparser.c",
        "  int needsclose = 0;\n  while (i < gl->n) {\n",
        "  int needsclose = 0;\n  tatu_charge(ls->L, (unsigned)(gl->n - i) * TATU_VALUE);\n  while (i < gl->n) {\n",
    ),
    (
        "lparser.c",
        "  /* correct pending gotos to current block */\n",
        "  /* correct pending gotos to current block */\n  tatu_charge(fs->ls->L, (unsigned)(gl->n - bl->firstgoto) * TATU_VALUE);\n",
    ),
    (
        "lcode.c",
        "      list = next;\n    fixjump(fs, list, l2);",
        "      { list = next; tatu_charge(fs->ls->L, TATU_VALUE); }\n    fixjump(fs, list, l2);",
    ),
    (
        "ldebug.c",
        "  int jmptarget = 0;  /* any code before this address is conditional */\n",
        "  int jmptarget = 0;  /* any code before this address is conditional */\n  tatu_lua_count_here((unsigned)lastpc * TATU_VALUE);\n",
    ),
    (
        "ldebug.c",
        "      setbtvalue(&v);  /* boolean 'true' to be the value of all indices */\n",
        "      setbtvalue(&v);  /* boolean 'true' to be the value of all indices */\n      tatu_lua_count(L, (unsigned)p->sizelineinfo * TATU_INSTRUCTION);\n",
    ),
    // `convergeephemerons` runs in the collector's atomic phase, which cannot be interrupted. It visits all ephemeron
    // tables (with weak keys) until nothing changes, which takes many passes if their entries refer to each other in an
    // unfavourable order. After 64 passes, the tables are treated as strong.
    ("lgc.c", "  int changed;\n  int dir = 0;\n", "  int changed;\n  int dir = 0;\n  int tatu_passes = 0;\n"),
    (
        "lgc.c",
        "      if (traverseephemeron(g, h, dir)) {  /* marked some value? */\n",
        "      if (tatu_passes >= 64) {\n        traversestrongtable(g, h);\n        propagateall(g);\n        changed = 1;\n      }\n      else if (traverseephemeron(g, h, dir)) {  /* marked some value? */\n",
    ),
    (
        "lgc.c",
        "    dir = !dir;  /* invert direction next time */\n",
        "    dir = !dir;  /* invert direction next time */\n    tatu_passes++;\n",
    ),
    // The basic library.
    (
        "lbaselib.c",
        "    luaL_argcheck(L, 2 <= base && base <= 36, 2, \"base out of range\");\n",
        "    luaL_argcheck(L, 2 <= base && base <= 36, 2, \"base out of range\");\n    tatu_lua_charge(L, l * TATU_BYTE);\n",
    ),
    // The string library.
    (
        "lstrlib.c",
        "  char *p = luaL_buffinitsize(L, &b, l);\n  for (i = 0; i < l; i++)\n",
        "  tatu_lua_charge(L, l * TATU_BYTE);\n  char *p = luaL_buffinitsize(L, &b, l);\n  for (i = 0; i < l; i++)\n",
    ),
    (
        "lstrlib.c",
        "  char *p = luaL_buffinitsize(L, &b, l);\n  for (i=0; i<l; i++)\n    p[i] = tolower",
        "  tatu_lua_charge(L, l * TATU_BYTE);\n  char *p = luaL_buffinitsize(L, &b, l);\n  for (i=0; i<l; i++)\n    p[i] = tolower",
    ),
    (
        "lstrlib.c",
        "  char *p = luaL_buffinitsize(L, &b, l);\n  for (i=0; i<l; i++)\n    p[i] = toupper",
        "  tatu_lua_charge(L, l * TATU_BYTE);\n  char *p = luaL_buffinitsize(L, &b, l);\n  for (i=0; i<l; i++)\n    p[i] = toupper",
    ),
    (
        "lstrlib.c",
        "  if (n <= 0)\n    lua_pushliteral(L, \"\");\n",
        "  if (n <= 0 || l + lsep == 0)\n    lua_pushliteral(L, \"\");\n",
    ),
    // The charge follows the allocation, so that a string that exceeds the memory is refused first.
    (
        "lstrlib.c",
        "    char *p = luaL_buffinitsize(L, &b, totallen);\n",
        "    char *p = luaL_buffinitsize(L, &b, totallen);\n    tatu_lua_charge(L, totallen + (unsigned long long)n * (TATU_VALUE / 4));\n",
    ),
    (
        "lstrlib.c",
        "  luaL_checkstack(L, n, \"string slice too long\");\n",
        "  luaL_checkstack(L, n, \"string slice too long\");\n  tatu_lua_charge(L, (unsigned long long)n * TATU_BYTE);\n",
    ),
    (
        "lstrlib.c",
        "  luaL_addchar(b, '\"');\n  while (len--) {\n",
        "  tatu_lua_count_here(len * TATU_INSTRUCTION);\n  luaL_addchar(b, '\"');\n  while (len--) {\n",
    ),
    (
        "lstrlib.c",
        "  luaL_Buffer b;\n  luaL_buffinit(L, &b);\n  while (strfrmt < strfrmt_end) {\n",
        "  luaL_Buffer b;\n  tatu_lua_charge(L, sfl * TATU_BYTE);\n  luaL_buffinit(L, &b);\n  while (strfrmt < strfrmt_end) {\n",
    ),
    (
        "lstrlib.c",
        "      strfrmt = getformat(L, strfrmt, form);\n",
        "      tatu_lua_charge(L, TATU_NUMERAL);\n      strfrmt = getformat(L, strfrmt, form);\n",
    ),
    // `%f` needs the larger buffer: `MAX_ITEMF`, 418 bytes.
    (
        "lstrlib.c",
        "          maxitem = MAX_ITEMF;  /* extra space for '%f' */\n",
        "          maxitem = MAX_ITEMF;  /* extra space for '%f' */\n          tatu_lua_charge(L, 4 * TATU_NUMERAL);\n",
    ),
    (
        "lstrlib.c",
        "            luaL_argcheck(L, l == strlen(s), arg,",
        "            tatu_lua_charge(L, l);\n            luaL_argcheck(L, l == strlen(s), arg,",
    ),
    (
        "lstrlib.c",
        "  lua_pushnil(L);  /* mark to separate arguments from string buffer */\n",
        "  tatu_lua_charge(L, strlen(fmt) * TATU_INSTRUCTION);\n  lua_pushnil(L);  /* mark to separate arguments from string buffer */\n",
    ),
    (
        "lstrlib.c",
        "        while (len++ < (size_t)size)  /* pad extra space */\n",
        "        tatu_lua_charge(L, (size - len) * TATU_BYTE);\n        while (len++ < (size_t)size)  /* pad extra space */\n",
    ),
    (
        "lstrlib.c",
        "        luaL_argcheck(L, strlen(s) == len, arg, \"string contains zeros\");\n        luaL_addlstring",
        "        tatu_lua_charge(L, len);\n        luaL_argcheck(L, strlen(s) == len, arg, \"string contains zeros\");\n        luaL_addlstring",
    ),
    (
        "lstrlib.c",
        "  size_t totalsize = 0;  /* accumulate total size of result */\n  initheader(L, &h);\n  while",
        "  size_t totalsize = 0;  /* accumulate total size of result */\n  initheader(L, &h);\n  tatu_lua_charge(L, strlen(fmt) * TATU_INSTRUCTION);\n  while",
    ),
    (
        "lstrlib.c",
        "  luaL_argcheck(L, pos <= ld, 3, \"initial position out of string\");\n",
        "  luaL_argcheck(L, pos <= ld, 3, \"initial position out of string\");\n  tatu_lua_charge(L, strlen(fmt) * TATU_INSTRUCTION);\n",
    ),
    (
        "lstrlib.c",
        "        size_t len = strlen(data + pos);\n",
        "        size_t len = strlen(data + pos);\n        tatu_lua_charge(L, len);\n",
    ),
    // The UTF-8 library.
    (
        "lutf8lib.c",
        "                   \"final position out of bounds\");\n",
        "                   \"final position out of bounds\");\n  if (posi <= posj) tatu_lua_charge(L, (unsigned long long)(posj - posi + 1) * TATU_BYTE);\n",
    ),
    (
        "lutf8lib.c",
        "  luaL_checkstack(L, n, \"string slice too long\");\n",
        "  luaL_checkstack(L, n, \"string slice too long\");\n  tatu_lua_charge(L, (unsigned long long)n * TATU_BYTE);\n",
    ),
    (
        "lutf8lib.c",
        "  lua_pushfstring(L, \"%U\", (long)code);\n",
        "  tatu_lua_charge(L, TATU_NUMERAL);\n  lua_pushfstring(L, \"%U\", (long)code);\n",
    ),
    (
        "lutf8lib.c",
        "    while (posi > 0 && iscontp(s + posi)) posi--;\n  }",
        "    while (posi > 0 && iscontp(s + posi)) { posi--; tatu_lua_charge(L, TATU_BYTE); }\n  }",
    ),
    ("lutf8lib.c", "           posi--;\n", "           posi--; tatu_lua_charge(L, TATU_BYTE);\n"),
    ("lutf8lib.c", "           posi++;\n", "           posi++; tatu_lua_charge(L, TATU_BYTE);\n"),
    (
        "lutf8lib.c",
        "    while (iscontp(s + n)) n++;  /* go to next character */\n",
        "    while (iscontp(s + n)) { n++; tatu_lua_charge(L, TATU_BYTE); }  /* go to next character */\n",
    ),
];
