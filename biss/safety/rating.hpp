// SafetyRating: how often the checks of two words accept a wrong position, and the ratings of the
// named configurations.
#pragma once

#include <array>
#include <cstdint>

namespace biss {

/// The exact residual error of two words with their comparison, as `biss safety analyse --to c`
/// prints it.
struct SafetyRating {
  /// What the rating is for: rated_words().
  std::uint64_t words = 0;
  /// The share of frames that are accepted although the compared bits of the CPW are wrong by more
  /// than the tolerance, at a bit error rate of 1e-2; times 1e24, rounded up.
  std::uint64_t residual_e24 = 0;
  /// rating_check() of the other two, so that a rating that was copied wrongly is refused.
  std::uint64_t check = 0;

  constexpr bool operator==(const SafetyRating&) const = default;
};

constexpr std::uint64_t rating_check(std::uint64_t words, std::uint64_t residual_e24) {
  std::uint64_t sum = 0x9E37'79B9'7F4A'7C15U;
  for (const std::uint64_t each : {words, residual_e24}) {
    sum = (sum ^ each) * 0xBF58'476D'1CE4'E5B9U;
    sum ^= sum >> 29U;
  }
  return sum;
}

/// The ratings of the named configurations: `biss safety analyse -f NAME --compare BITS --to c` with
/// the bits that the configuration compares. A test compares them with the analysis.
inline constexpr std::array safety_ratings{
    // fs-32-32
    SafetyRating{0xC0C3'5FEA'DC5C'4430U, 1'365'348, 0x4F48'BF4E'73C7'14F7U},
    // fs-28-24
    SafetyRating{0xD49F'E6D0'8433'DD31U, 3'881'667, 0x0711'A664'3E4B'1428U},
    // fs-36-28
    SafetyRating{0x941F'DE94'538F'4D3FU, 6'249'988, 0x2B6A'641D'8C55'0EA1U},
    // rxm
    SafetyRating{0xD5CA'8010'1E34'B184U, 4'753'908, 0x679E'66D6'4A2F'0710U},
    // rxh
    SafetyRating{0xCEC1'82D4'90A3'6FD4U, 15'704'130, 0x13A7'2E5B'1393'2BA3U},
    // rsm
    SafetyRating{0xC80B'D065'403A'5706U, 13'233'335, 0x635D'2744'4A46'6C92U},
    // rsh
    SafetyRating{0x698F'DAAB'62F3'CA39U, 23'770'031, 0x3E41'0591'DD30'F71FU},
    // rlm
    SafetyRating{0x6DF7'3179'F439'EEDDU, 17'180'828, 0xA493'4353'52B1'58E9U},
    // rlh
    SafetyRating{0x4072'522F'CE87'527EU, 31'524'428, 0x1C81'50D7'3BA8'C431U},
    // rum
    SafetyRating{0x821C'D240'4404'C1DDU, 16'647'809, 0x6C22'8653'3A1E'D9EAU},
    // ruh
    SafetyRating{0xEEE1'4339'D9BC'EB8DU, 35'832'318, 0x25B0'01B4'2CBB'1DA1U},
    // lmm
    SafetyRating{0xA85C'AA5F'025A'BD6EU, 19'865'317, 0x8B16'36F0'0A89'3A55U},
};

}  // namespace biss
