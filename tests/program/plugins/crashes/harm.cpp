// The harm that plugin.c does, in C++: an exception leaves the plugin.
#include <stdexcept>

extern "C" void harm(const char *) { throw std::runtime_error("not caught"); }
