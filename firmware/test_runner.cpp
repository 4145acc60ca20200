// Runs every test of the image and prints one line for each: `ok NAME` or `FAILED NAME`.
#include <cstdint>

#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"
#include "tests/core/test_target.hpp"

extern "C" {
extern const biss::test::Record __start_biss_tests[];
extern const biss::test::Record __stop_biss_tests[];
}

namespace biss::test {
namespace {

constexpr std::uint32_t shown_failures = 10;
std::uint32_t failures_in_test = 0;

bool quiet() { return failures_in_test > shown_failures; }

}  // namespace

void print_seed(std::uint64_t seed) { firmware::print("seed ", firmware::Hex{seed}, "\n"); }

Report::Report(const char* file, int line, const char* expression) {
  ++failures_in_test;
  *this << file << ":" << line << ": FAILURE " << expression << " ";
}

Report::Report(const char* file, int line, const char* left, Shown a, const char* right, Shown b)
    : Report(file, line, left) {
  if (a.is_number) *this << "= " << a << " ";
  *this << "is not " << right;
  if (b.is_number) *this << " = " << b;
  *this << " ";
}

Report::~Report() { *this << "\n"; }

Report& Report::operator<<(const char* text) {
  if (!quiet()) firmware::write(text);
  return *this;
}

Report& Report::operator<<(const Shown& value) {
  if (quiet()) return *this;
  if (value.negative) firmware::write("-");
  firmware::write(value.magnitude);
  return *this;
}

}  // namespace biss::test

namespace std {

// The function that a checked call of the library (string_view::substr) uses without exceptions.
// Only test images have it: in firmware it would link the exceptions.
[[noreturn]] void __throw_out_of_range_fmt(const char* what, ...);
void __throw_out_of_range_fmt(const char* what, ...) {
  firmware::print("OUT OF RANGE: ", what, "\n");
  firmware::exit(1);
}

}  // namespace std

int firmware_main() {
  using biss::test::failures_in_test;
  std::uint32_t passed = 0;
  std::uint32_t failed = 0;
  for (const auto* test = __start_biss_tests; test != __stop_biss_tests; ++test) {
    failures_in_test = 0;
    firmware::print("run ", test->name, "\n");
    test->run();
    const bool good = failures_in_test == 0;
    (good ? passed : failed) += 1;
    firmware::print(good ? "ok " : "FAILED ", test->name, "\n");
  }
  firmware::print(passed, " passed, ", failed, " failed\n");
  return failed == 0 && passed > 0 ? 0 : 1;
}
