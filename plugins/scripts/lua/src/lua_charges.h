/* Included before every file of Lua. Declares functions by which C code charges its work to the budget of a call, so
 * that scripts cannot run long loops in C without a charge. `build/charges.rs` inserts calls of these functions into
 * Lua's files; `run/budget.rs` sets the limit. */
#ifndef TATU_LUA_CHARGES_H
#define TATU_LUA_CHARGES_H

struct lua_State;

/* Units per instruction. */
#define TATU_INSTRUCTION 64
/* Units per byte that is examined individually; a byte that is only copied or compared costs 1. */
#define TATU_BYTE 16
/* Units per call of Lua's C interface, per table node, and per value moved on the stack. */
#define TATU_VALUE 16
/* Units per conversion between a number and text. */
#define TATU_NUMERAL (32 * TATU_INSTRUCTION)
/* Length up to which a collision chain is not charged, because such chains occur by chance. */
#define TATU_CHAIN 32

/* Charges units, and raises an error if the budget is spent. Only functions that may raise errors can call this. */
void tatu_lua_charge(struct lua_State *L, unsigned long long units);
/* Charges units; once the budget is spent, the next instruction raises the error. */
void tatu_lua_count(struct lua_State *L, unsigned long long units);
/* Charges units to the running thread, for functions that have no `lua_State`. */
void tatu_lua_count_here(unsigned long long units);
/* Sets the running thread, and returns the previous one. */
struct lua_State *tatu_lua_enter(struct lua_State *L);
/* `fmod` that charges its work, which increases with the ratio of its arguments. */
double tatu_lua_fmod(double x, double y);

/* `tatu_lua_charge` for use in Lua's core. */
#define tatu_charge(L, n) { if (l_unlikely((G(L)->tatu_used += (n)) >= G(L)->tatu_limit)) tatu_lua_charge(L, 0); }

#define fmod tatu_lua_fmod

#endif
