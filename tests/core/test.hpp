// The thin layer that lets one test source run on the host and on a microcontroller.
//
//   #include "tests/core/test.hpp"
//   BISS_TEST(Bits, WordAcrossBytes_ReadsInLineOrder) {
//     BISS_RANDOM(random, 0x5EED);                        // prints its seed
//     BISS_ASSERT(view.size_bits() >= 8);                 // leaves the test when false
//     BISS_EXPECT_EQ(view.word(4, 8), 0xA5) << "at " << 4;
//   }
//
// On the host this is GoogleTest; with BISS_TARGET defined a test is a record in the linker section
// `biss_tests` and a failure is a line through semihosting. A test source keeps to the headers that
// the core may use, so that both builds have the same tests. This header includes most of them.
//
// EXPECT_EQ and ASSERT_EQ compare integers by value, for all types and signs, and show integers,
// bools and enumerators (as their number); of any other type with == the expression is shown.
// Context streamed after a check is limited to integers and C strings.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "tests/core/compare.hpp"
#include "tests/core/random.hpp"

#ifdef BISS_TARGET
#include "tests/core/test_target.hpp"
#else
#include "tests/core/test_host.hpp"
#endif

namespace biss::test {

/// Rounds of a long loop: the first number on the host, the second under emulation and in the tests
/// of every change.
constexpr std::uint64_t rounds([[maybe_unused]] std::uint64_t host,
                               [[maybe_unused]] std::uint64_t target) {
#if defined(BISS_TARGET) || defined(BISS_FEW_ROUNDS)
  return target;
#else
  return host;
#endif
}

}  // namespace biss::test

/// A random source with the name `name`; prints its seed.
#define BISS_RANDOM(name, seed)   \
  ::biss::test::print_seed(seed); \
  ::biss::test::Random name { seed }  // NOLINT(bugprone-macro-parentheses)
