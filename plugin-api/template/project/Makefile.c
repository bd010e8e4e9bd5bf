# Builds the plugin with make on Linux, as `tatu plugin build` does.
LIBRARY = build/libtatu_my_plugin.so
CFLAGS ?= -O2

$(LIBRARY): $(wildcard *.c) $(wildcard sdk/include/*.h sdk/include/tatu/*.h)
	mkdir -p build
	$(CC) -std=c11 $(CFLAGS) -Wall -Wextra -shared -fPIC -fvisibility=hidden -I sdk/include -o $@ $(wildcard *.c) -lm -lpthread
