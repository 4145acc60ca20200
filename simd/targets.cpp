// The run-time part of Highway: the SIMD levels that the processor has, and the level in use. It
// replaces Highway's shared library, which measures a clock for 3 ms at the start of every process.
#include <hwy/targets.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#if HWY_ARCH_X86
#include <cpuid.h>
#endif

namespace {

#if HWY_ARCH_X86

// A bit of the registers EAX, EBX, ECX, EDX (0 to 3) that CPUID fills.
bool has_cpuid_bit(unsigned leaf, unsigned which, unsigned bit) {
  unsigned registers[4]{};
  return __get_cpuid_count(leaf, 0, &registers[0], &registers[1], &registers[2], &registers[3]) !=
             0 &&
         ((registers[which] >> bit) & 1U) != 0;
}

// Highway's definitions of its levels. __builtin_cpu_supports() also checks the operating system,
// but does not support LZCNT, F16C and VAES in every compiler.
std::int64_t detected_targets() {
  constexpr unsigned features = 7;
  constexpr unsigned ecx = 2;
  __builtin_cpu_init();
  std::int64_t targets = HWY_EMU128 | HWY_SCALAR;
  if (!__builtin_cpu_supports("ssse3")) return targets;
  targets |= HWY_SSSE3;
  if (!__builtin_cpu_supports("sse4.1") || !__builtin_cpu_supports("sse4.2") ||
      !__builtin_cpu_supports("pclmul") || !__builtin_cpu_supports("aes")) {
    return targets;
  }
  targets |= HWY_SSE4;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") ||
      !__builtin_cpu_supports("bmi") || !__builtin_cpu_supports("bmi2") ||
      !has_cpuid_bit(0x8000'0001, ecx, 5) || !has_cpuid_bit(1, ecx, 29)) {
    return targets;
  }
  targets |= HWY_AVX2;
  if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512vl") ||
      !__builtin_cpu_supports("avx512dq") || !__builtin_cpu_supports("avx512bw")) {
    return targets;
  }
  targets |= HWY_AVX3;
  if (!__builtin_cpu_supports("avx512vnni") || !__builtin_cpu_supports("vpclmulqdq") ||
      !__builtin_cpu_supports("avx512vbmi") || !__builtin_cpu_supports("avx512vbmi2") ||
      !__builtin_cpu_supports("avx512vpopcntdq") || !__builtin_cpu_supports("avx512bitalg") ||
      !has_cpuid_bit(features, ecx, 9)) {
    return targets;
  }
  return targets | HWY_AVX3_DL;
}

#else

// The level of the compiler's options: NEON on 64-bit Arm.
std::int64_t detected_targets() { return HWY_STATIC_TARGET | HWY_EMU128 | HWY_SCALAR; }

#endif

// BISS_SIMD=none: only what every processor of this kind has.
std::int64_t wanted_targets() {
  const char* const wanted = std::getenv("BISS_SIMD");
  if (wanted != nullptr && std::string_view(wanted) == "none") {
    return HWY_STATIC_TARGET | HWY_EMU128 | HWY_SCALAR;
  }
  return detected_targets();
}

std::atomic<std::int64_t> targets_for_test = 0;

}  // namespace

namespace hwy {

std::int64_t SupportedTargets() {
  static const std::int64_t at_start = wanted_targets();
  const std::int64_t for_test = targets_for_test;
  return for_test != 0 ? for_test : at_start;
}

void SetSupportedTargetsForTest(std::int64_t targets) { targets_for_test = targets; }

ChosenTarget& GetChosenTarget() {
  static constinit ChosenTarget chosen;
  return chosen;
}

}  // namespace hwy
