# Builds the plugin with make on Linux, as `tatu plugin build` does.
LIBRARY = build/libtatu_my_plugin.so
CXXFLAGS ?= -O2

$(LIBRARY): $(wildcard *.cpp) $(wildcard sdk/include/*.h sdk/include/tatu/* sdk/include/tatu/cpp/*)
	mkdir -p build
	$(CXX) -std=c++17 $(CXXFLAGS) -Wall -Wextra -shared -fPIC -fvisibility=hidden -I sdk/include -o $@ $(wildcard *.cpp)
