#include "check.h"

#include <cstdio>
#include <cstring>
#include <vector>

namespace check {
namespace {

struct Entry {
  const char* name;
  void (*run)();
};

// In a function: tests register before main, in any order.
std::vector<Entry>& entries() {
  static std::vector<Entry> all;
  return all;
}

int failures = 0;

}  // namespace

Test::Test(const char* name, void (*run)()) { entries().push_back(Entry{name, run}); }

void fail(const char* file, int line, const std::string& what) {
  std::printf("%s:%d: %s\n", file, line, what.c_str());
  ++failures;
}

}  // namespace check

// Without arguments all tests, otherwise those whose name contains the argument. Fails if there is none.
int main(int argc, char** argv) {
  int run = 0;
  int failed = 0;
  for (const check::Entry& entry : check::entries()) {
    if (argc > 1 && std::strstr(entry.name, argv[1]) == nullptr) continue;
    const int before = check::failures;
    entry.run();
    ++run;
    if (check::failures > before) {
      ++failed;
      std::printf("FAILED %s\n", entry.name);
    }
  }
  std::printf("%d tests, %d failed\n", run, failed);
  return run > 0 && failed == 0 ? 0 : 1;
}
