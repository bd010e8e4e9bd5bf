// The function in C++ that plugin.c calls to crash: it throws an exception, which leaves the plugin.
#include <stdexcept>

extern "C" void harm(const char *) { throw std::runtime_error("not caught"); }
