/* Included before every file of Lua: what C code counts on the budget of a call, so that no loop in C escapes it. `build/charges.rs`
 * puts these calls into Lua's files; `run/budget.rs` sets the limit. */
#ifndef TATU_LUA_CHARGES_H
#define TATU_LUA_CHARGES_H

struct lua_State;

/* Units of one instruction. */
#define TATU_INSTRUCTION 64
/* A byte that is copied or compared with others is one unit; one that is looked at by itself: */
#define TATU_BYTE 16
/* One call of Lua's C interface, one node of a table, one value moved on the stack. */
#define TATU_VALUE 16
/* A number as text, or a text as number. */
#define TATU_NUMERAL (32 * TATU_INSTRUCTION)
/* Nodes of a chain that count nothing: what tables and strings have by chance. */
#define TATU_CHAIN 32

/* Counts, and raises an error once the budget is spent: for functions that may raise one. */
void tatu_lua_charge(struct lua_State *L, unsigned long long units);
/* Counts; the next instruction raises the error. */
void tatu_lua_count(struct lua_State *L, unsigned long long units);
/* Counts for the running thread, in functions that get none. */
void tatu_lua_count_here(unsigned long long units);
/* Sets the running thread, and returns the one before. */
struct lua_State *tatu_lua_enter(struct lua_State *L);
/* `fmod`, which takes longer the more its arguments differ. */
double tatu_lua_fmod(double x, double y);

/* `tatu_lua_charge` within Lua's core. */
#define tatu_charge(L, n) { if (l_unlikely((G(L)->tatu_used += (n)) >= G(L)->tatu_limit)) tatu_lua_charge(L, 0); }

#define fmod tatu_lua_fmod

#endif
