/* Accesses internals of Lua 5.4. This file is compiled with Lua's own headers and flags. `lua_internals.rs`
 * documents each function, how it is checked, and what happens if the check fails. */

#define LUA_CORE

/* The build renames `strspn` in Lua's files; this file uses the function of the C library. */
#undef strspn
#undef fmod

#include "lprefix.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "lua.h"

#include "ldo.h"
#include "lobject.h"
#include "lstate.h"
#include "lstring.h"
#include "ltable.h"
#include "lundump.h"

#if LUA_VERSION_NUM != 504
#error "written for Lua 5.4"
#endif

#if defined(_MSC_VER)
#define THREAD_LOCAL __declspec(thread)
#else
#define THREAD_LOCAL _Thread_local
#endif

/* ---- number format ---- */

static THREAD_LOCAL int plain_floats;

int tatu_lua_set_plain_floats(int plain) {
  int before = plain_floats;
  plain_floats = plain;
  return before;
}

/* Lua calls `strspn` with this set only to check whether the text of a float looks like an integer. */
size_t tatu_lua_strspn(const char *text, const char *set) {
  if (plain_floats && strcmp(set, "-0123456789") == 0) return 0;
  return strspn(text, set);
}

/* ---- budgets, collector ---- */

int *tatu_lua_hook_count(lua_State *L) {
  return &L->hookcount;
}

/* Returns the address of the used units, which the limit must follow directly in memory; NULL if it does not. */
unsigned long long *tatu_lua_meter(lua_State *L) {
  return offsetof(global_State, tatu_limit) == offsetof(global_State, tatu_used) + sizeof(unsigned long long)
             ? &G(L)->tatu_used : NULL;
}

/* Defined in Rust; ends the call with an error. */
void tatu_lua_spent(lua_State *L);

static THREAD_LOCAL lua_State *running;

lua_State *tatu_lua_enter(lua_State *L) {
  lua_State *before = running;
  running = L;
  return before;
}

void tatu_lua_charge(lua_State *L, unsigned long long units) {
  global_State *g = G(L);
  if (g->tatu_used < g->tatu_limit) {
    if (units < g->tatu_limit - g->tatu_used) {
      g->tatu_used += units;
      return;
    }
    g->tatu_used = g->tatu_limit; /* the refused work is not charged */
  }
  tatu_lua_spent(L);
}

/* This function must not raise an error, so the hook raises it at the next instruction. */
void tatu_lua_count(lua_State *L, unsigned long long units) {
  global_State *g = G(L);
  if ((g->tatu_used += units) >= g->tatu_limit) L->hookcount = 1;
}

void tatu_lua_count_here(unsigned long long units) {
  if (running) tatu_lua_count(running, units);
}

/* `fmod` takes one step per bit by which the exponents differ. Large differences are charged; small ones are free. */
double tatu_lua_fmod(double x, double y) {
  int a, b;
  frexp(x, &a);
  frexp(y, &b);
  if (a - b > TATU_CHAIN) tatu_lua_count_here((unsigned)(a - b) * TATU_VALUE);
  return fmod(x, y);
}

ptrdiff_t tatu_lua_gc_debt(lua_State *L) {
  return G(L)->GCdebt;
}

/* While a stack grows, Lua stores positions in it as offsets from its beginning (`relstack` in ldo.c). */

int tatu_lua_is_stack(lua_State *L, const void *block) {
  return (const void *)L->stack.p == block;
}

void tatu_lua_point_frames(lua_State *L) {
  CallInfo *ci;
  for (ci = L->ci; ci != NULL; ci = ci->previous) ci->func.p = restorestack(L, ci->func.offset);
}

void tatu_lua_unpoint_frames(lua_State *L) {
  CallInfo *ci;
  for (ci = L->ci; ci != NULL; ci = ci->previous) ci->func.offset = savestack(L, ci->func.p);
}

/* ---- hashes ---- */

unsigned int tatu_lua_seed(lua_State *L) {
  return G(L)->seed;
}

/* Returns whether the cache of C strings has a single entry. If Lua was compiled with another size, the field that
 * follows the cache is at another offset, which this function detects. */
int tatu_lua_has_small_string_cache(lua_State *L) {
  lua_setwarnf(L, NULL, L);
  return STRCACHE_N * STRCACHE_M == 1 && G(L)->ud_warn == L;
}

unsigned int tatu_lua_hash_text(const char *text, size_t len) {
  return luaS_hash(text, len, luai_makeseed(L));
}

/* A copy of `l_hashfloat` in ltable.c. */
unsigned int tatu_lua_hash_float(double n) {
  int exponent;
  lua_Integer mantissa;
  unsigned int hash;
  n = frexp(n, &exponent) * -cast_num(INT_MIN);
  if (!lua_numbertointeger(n, &mantissa)) return 0;
  hash = cast_uint(exponent) + cast_uint(mantissa);
  return hash <= cast_uint(INT_MAX) ? hash : ~hash;
}

/* ---- tables ---- */

typedef struct {
  uint8_t kind; /* KEY_* of lua_internals.rs */
  uint8_t has_value;
  uint64_t bits; /* a boolean, an integer, the bits of a float, the length of a text */
  const char *text;
} tatu_lua_node;

enum { KEY_NIL, KEY_BOOL, KEY_INT, KEY_FLOAT, KEY_TEXT, KEY_OBJECT, KEY_DEAD };

size_t tatu_lua_nodes(const Table *t) {
  return (size_t)allocsizenode(t);
}

size_t tatu_lua_array_size(const Table *t) {
  return luaH_realasize(t);
}

unsigned int tatu_lua_limit(const Table *t, int *is_hint) {
  *is_hint = !isrealasize(t);
  return t->alimit;
}

/* Sets the limit of the array part. Returns 0, and sets nothing, if that would change the array's size. */
int tatu_lua_set_limit(Table *t, unsigned int limit, int is_hint) {
  Table changed = *t;
  changed.alimit = limit;
  if (is_hint)
    setnorealasize(&changed);
  else
    setrealasize(&changed);
  if (luaH_realasize(&changed) != luaH_realasize(t)) return 0;
  *t = changed;
  return 1;
}

void tatu_lua_node_at(const Table *t, size_t i, tatu_lua_node *out) {
  const Node *n = gnode(t, i);
  out->has_value = !isempty(gval(n));
  out->bits = 0;
  out->text = NULL;
  switch (keytt(n)) {
    case LUA_VFALSE: out->kind = KEY_BOOL; break;
    case LUA_VTRUE: out->kind = KEY_BOOL; out->bits = 1; break;
    case LUA_VNUMINT: out->kind = KEY_INT; out->bits = (uint64_t)keyival(n); break;
    case LUA_VNUMFLT: out->kind = KEY_FLOAT; memcpy(&out->bits, &keyval(n).n, sizeof(out->bits)); break;
    case ctb(LUA_VSHRSTR):
    case ctb(LUA_VLNGSTR): {
      const TString *text = keystrval(n);
      out->kind = KEY_TEXT;
      out->text = getstr(text);
      out->bits = tsslen(text);
      break;
    }
    case LUA_TDEADKEY: out->kind = KEY_DEAD; break;
    default: out->kind = novariant(keytt(n)) == LUA_TNIL ? KEY_NIL : KEY_OBJECT;
  }
}

/* Marks the key of an empty node as dead, as the collector does. */
void tatu_lua_kill_key(Table *t, size_t i) {
  setdeadkey(gnode(t, i));
}

/* Exchanges the contents of two tables: everything except identity, colour and metatable. */
void tatu_lua_exchange(Table *a, Table *b) {
  Table was = *a;
  int hint_a = !isrealasize(a), hint_b = !isrealasize(b);
  a->lsizenode = b->lsizenode, a->alimit = b->alimit, a->array = b->array, a->node = b->node, a->lastfree = b->lastfree;
  b->lsizenode = was.lsizenode, b->alimit = was.alimit, b->array = was.array, b->node = was.node, b->lastfree = was.lastfree;
  /* The other flags cache which metamethods are missing; clearing them makes Lua look them up again. */
  a->flags = cast_byte(hint_b ? BITRAS : 0);
  b->flags = cast_byte(hint_a ? BITRAS : 0);
}

/* ---- functions ---- */

static const Proto *find(const Proto *p, unsigned int *n) {
  int i;
  if ((*n)-- == 0) return p;
  for (i = 0; i < p->sizep; i++) {
    const Proto *found = find(p->p[i], n);
    if (found) return found;
  }
  return NULL;
}

static const Proto *on_top(lua_State *L) {
  const TValue *o = s2v(L->top.p - 1);
  return ttisLclosure(o) ? clLvalue(o)->p : NULL;
}

/* Writes the n-th function nested in the one on top of the stack (0: the function itself; depth first), in the format
 * in which `lua_dump` writes its closure. Returns 0 if there is no such function. */
int tatu_lua_dump_nested(lua_State *L, unsigned int n, lua_Writer writer, void *data) {
  const Proto *p = on_top(L);
  if (p) p = find(p, &n);
  return p && luaU_dump(L, p, writer, data, 0) == 0;
}

static void hash_bytes(uint64_t *h, const void *bytes, size_t n) {
  const unsigned char *at = bytes;
  while (n-- > 0) *h = (*h ^ *at++) * UINT64_C(0x100000001b3);
}

static void hash_byte(uint64_t *h, int byte) {
  unsigned char b = (unsigned char)byte;
  hash_bytes(h, &b, 1);
}

/* Hashes the bytes that `dumpSize` in ldump.c writes for a size. */
static void hash_size(uint64_t *h, size_t size) {
  unsigned char digits[(sizeof(size_t) * CHAR_BIT + 6) / 7];
  size_t first = sizeof(digits);
  do {
    digits[--first] = (unsigned char)(size & 0x7F);
    size >>= 7;
  } while (size != 0);
  digits[sizeof(digits) - 1] |= 0x80;
  hash_bytes(h, digits + first, sizeof(digits) - first);
}

static void hash_function(uint64_t *h, const Proto *f) {
  int i;
  hash_size(h, 0); /* no source, and no lines after it */
  hash_byte(h, f->numparams);
  hash_byte(h, f->is_vararg);
  hash_byte(h, f->maxstacksize);
  hash_size(h, (size_t)f->sizecode);
  hash_bytes(h, f->code, (size_t)f->sizecode * sizeof(f->code[0]));
  hash_size(h, (size_t)f->sizek);
  for (i = 0; i < f->sizek; i++) {
    const TValue *k = &f->k[i];
    hash_byte(h, ttypetag(k));
    if (ttisinteger(k)) {
      hash_bytes(h, &val_(k).i, sizeof(lua_Integer));
    } else if (ttisfloat(k)) {
      hash_bytes(h, &val_(k).n, sizeof(lua_Number));
    } else if (ttisstring(k)) {
      const TString *text = tsvalue(k);
      hash_size(h, tsslen(text) + 1);
      hash_bytes(h, getstr(text), tsslen(text));
    }
  }
  hash_size(h, (size_t)f->sizeupvalues);
  for (i = 0; i < f->sizeupvalues; i++) {
    hash_byte(h, f->upvalues[i].instack);
    hash_byte(h, f->upvalues[i].idx);
    hash_byte(h, f->upvalues[i].kind);
  }
  hash_size(h, (size_t)f->sizep);
  for (i = 0; i < f->sizep; i++) hash_function(h, f->p[i]);
  for (i = 0; i < 4; i++) hash_size(h, 0); /* no debug information */
}

/* Returns the FNV-1a hash of the bytes that `lua_dump` writes for the function on top of the stack, without debug
 * information and line numbers; 0 if it is not a Lua function. */
uint64_t tatu_lua_hash_code(lua_State *L) {
  const Proto *p = on_top(L);
  const lua_Integer an_integer = LUAC_INT;
  const lua_Number a_number = LUAC_NUM;
  uint64_t h = UINT64_C(0xcbf29ce484222325);
  if (!p) return 0;
  hash_bytes(&h, LUA_SIGNATURE, sizeof(LUA_SIGNATURE) - 1);
  hash_byte(&h, LUAC_VERSION);
  hash_byte(&h, LUAC_FORMAT);
  hash_bytes(&h, LUAC_DATA, sizeof(LUAC_DATA) - 1);
  hash_byte(&h, sizeof(Instruction));
  hash_byte(&h, sizeof(lua_Integer));
  hash_byte(&h, sizeof(lua_Number));
  hash_bytes(&h, &an_integer, sizeof(an_integer));
  hash_bytes(&h, &a_number, sizeof(a_number));
  hash_byte(&h, p->sizeupvalues);
  hash_function(&h, p);
  return h;
}
