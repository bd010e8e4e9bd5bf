/* Included before every file of Lua: replaces math functions whose results differ between C libraries or processors
 * with those of `lua_math.rs`. Functions that IEEE 754 defines exactly (sqrt, fmod, floor, ...) are still those of the
 * C library. */
#ifndef TATU_LUA_MATH_H
#define TATU_LUA_MATH_H
#include <math.h>

double tatu_lua_sin(double);
double tatu_lua_cos(double);
double tatu_lua_tan(double);
double tatu_lua_asin(double);
double tatu_lua_acos(double);
double tatu_lua_atan2(double, double);
double tatu_lua_sinh(double);
double tatu_lua_cosh(double);
double tatu_lua_tanh(double);
double tatu_lua_exp(double);
double tatu_lua_log(double);
double tatu_lua_log2(double);
double tatu_lua_log10(double);
double tatu_lua_pow(double, double);

#define sin tatu_lua_sin
#define cos tatu_lua_cos
#define tan tatu_lua_tan
#define asin tatu_lua_asin
#define acos tatu_lua_acos
#define atan2 tatu_lua_atan2
#define sinh tatu_lua_sinh
#define cosh tatu_lua_cosh
#define tanh tatu_lua_tanh
#define exp tatu_lua_exp
#define log tatu_lua_log
#define log2 tatu_lua_log2
#define log10 tatu_lua_log10
#define pow tatu_lua_pow

#endif
