// A test runner of one file: the tests have to run where no test framework is installed.
#pragma once

#include <sstream>
#include <string>

namespace check {

struct Test {
  Test(const char* name, void (*run)());
};

void fail(const char* file, int line, const std::string& what);

template <typename A, typename B>
void equal(const A& a, const B& b, const char* expressions, const char* file, int line) {
  if (a == b) return;
  std::ostringstream what;
  what << expressions << ": " << a << " is not " << b;
  fail(file, line, what.str());
}

}  // namespace check

#define TEST(name)                                 \
  static void name();                              \
  static const check::Test name##_test(#name, name); \
  static void name()

#define CHECK(condition)                                        \
  do {                                                          \
    if (!(condition)) check::fail(__FILE__, __LINE__, #condition); \
  } while (false)

#define CHECK_EQ(a, b) check::equal((a), (b), #a " == " #b, __FILE__, __LINE__)
