// The levels are those that the processor has, by the flags that the system prints.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <fstream>
#include <initializer_list>
#include <set>
#include <sstream>
#include <string>

namespace targets_test {

// The flags of the first core in /proc/cpuinfo; none if it has no such line.
std::set<std::string> cpu_flags() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("flags")) continue;
    std::istringstream words(line.substr(line.find(':') + 1));
    return {std::istream_iterator<std::string>(words), {}};
  }
  return {};
}

TEST(SimdTargets, OfThisProcessor_AreThoseOfItsFlags) {
  const std::set<std::string> flags = cpu_flags();
  const auto has = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) {
      if (flags.count(name) == 0) return false;
    }
    return true;
  };
  std::int64_t expected = HWY_EMU128 | HWY_SCALAR | HWY_STATIC_TARGET;
#if HWY_ARCH_X86
  if (has({"ssse3"})) {
    expected |= HWY_SSSE3;
    if (has({"sse4_1", "sse4_2", "pclmulqdq", "aes"})) {
      expected |= HWY_SSE4;
      // Also abm, which every processor with bmi2 has, but some virtual machines do not list.
      if (has({"avx2", "fma", "bmi1", "bmi2", "f16c"})) {
        expected |= HWY_AVX2;
        if (has({"avx512f", "avx512vl", "avx512dq", "avx512bw"})) {
          expected |= HWY_AVX3;
          if (has({"avx512_vnni", "vpclmulqdq", "avx512vbmi", "avx512_vbmi2", "avx512_vpopcntdq",
                   "avx512_bitalg", "vaes"})) {
            expected |= HWY_AVX3_DL;
          }
        }
      }
    }
  }
#endif
  EXPECT_EQ(hwy::SupportedTargets() | HWY_STATIC_TARGET, expected);
}

TEST(SimdTargets, ForATest_AreThoseUntilTheyAreReset) {
  const std::int64_t detected = hwy::SupportedTargets();
  hwy::SetSupportedTargetsForTest(HWY_STATIC_TARGET);
  EXPECT_EQ(hwy::SupportedTargets(), HWY_STATIC_TARGET);
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_EQ(hwy::SupportedTargets(), detected);
}

}  // namespace targets_test
