// The test layer on the host: GoogleTest.
#pragma once

#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>

#include "tests/core/compare.hpp"

namespace biss::test {

inline void print_seed(std::uint64_t seed) { std::printf("[   seed   ] 0x%" PRIX64 "\n", seed); }

inline ::testing::Message& operator<<(::testing::Message& out, const Shown& value) {
  return out << (value.negative ? " = -" : " = ") << value.magnitude;
}

template <class A, class B>
::testing::AssertionResult check_equal(const char* left, const char* right, const A& a,
                                       const B& b) {
  if (equal(a, b)) return ::testing::AssertionSuccess();
  ::testing::Message text;
  text << left;
  if (show(a).is_number) text << show(a);
  text << " is not " << right;
  if (show(b).is_number) text << show(b);
  return ::testing::AssertionFailure(text);
}

}  // namespace biss::test

#define BISS_TEST(suite, name) TEST(suite, name)
#define BISS_EXPECT(...) EXPECT_TRUE((__VA_ARGS__))
#define BISS_ASSERT(...) ASSERT_TRUE((__VA_ARGS__))
#define BISS_EXPECT_EQ(left, right) EXPECT_PRED_FORMAT2(::biss::test::check_equal, left, right)
#define BISS_ASSERT_EQ(left, right) ASSERT_PRED_FORMAT2(::biss::test::check_equal, left, right)
