// The test layer on a microcontroller: records in a linker section, results through semihosting.
#pragma once

#include <concepts>
#include <cstdint>

#include "tests/core/compare.hpp"

namespace biss::test {

struct Record {
  const char* name;
  void (*run)();
};

/// Supplied by the firmware's runner.
void print_seed(std::uint64_t seed);

/// One failed check, printed as it is built: `file:line: FAILURE expression …`. The runner counts
/// them and keeps quiet after the first few of a test.
class Report {
 public:
  Report(const char* file, int line, const char* expression);
  Report(const char* file, int line, const char* left, Shown a, const char* right, Shown b);
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;
  ~Report();

  Report& operator<<(const char* text);
  Report& operator<<(const Shown& value);
  Report& operator<<(std::integral auto value) { return *this << show(value); }
};

/// Gives `return report << …;` the type void.
struct Leave {
  void operator=(const Report&) const {}
};

}  // namespace biss::test

// `for` and not `if`, so that no `else` of the caller can belong to it.
#define BISS_CHECK_(passed, fail, ...)                                \
  for (bool biss_passed = (passed); !biss_passed; biss_passed = true) \
  fail ::biss::test::Report(__FILE__, __LINE__, __VA_ARGS__)

#define BISS_CHECK_EQ_(left, right, fail)                                                   \
  for (::biss::test::Pair biss_pair(left, right); !biss_pair.equal; biss_pair.equal = true) \
  fail ::biss::test::Report(__FILE__, __LINE__, #left, biss_pair.a, #right, biss_pair.b)

namespace biss::test {

/// Two values compared once, with their text for a failure.
struct Pair {
  template <class A, class B>
  constexpr Pair(const A& left, const B& right)
      : a(show(left)), b(show(right)), equal(::biss::test::equal(left, right)) {}

  Shown a;
  Shown b;
  bool equal;
};

}  // namespace biss::test

#define BISS_TEST(suite, name)                                                     \
  static void biss_test_##suite##_##name();                                        \
  [[gnu::used, gnu::section("biss_tests")]] static constexpr ::biss::test::Record  \
      biss_record_##suite##_##name{#suite "." #name, &biss_test_##suite##_##name}; \
  static void biss_test_##suite##_##name()

#define BISS_EXPECT(...) BISS_CHECK_(static_cast<bool>(__VA_ARGS__), , #__VA_ARGS__)
#define BISS_ASSERT(...) \
  BISS_CHECK_(static_cast<bool>(__VA_ARGS__), return ::biss::test::Leave{} =, #__VA_ARGS__)
#define BISS_EXPECT_EQ(left, right) BISS_CHECK_EQ_(left, right, )
#define BISS_ASSERT_EQ(left, right) BISS_CHECK_EQ_(left, right, return ::biss::test::Leave{} =)
