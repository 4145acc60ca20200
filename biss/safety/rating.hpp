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
  /// The share of frames that are accepted although the compared bits of the CPW or of the SPW,
  /// whichever is worse, are wrong by more than the tolerance; at a bit error rate of 1e-2, times
  /// 1e24, rounded up.
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
    SafetyRating{0xD5CA'8010'1E34'B184U, 5'377'414, 0xEE9A'F7E9'9D8B'736EU},
    // rxh
    SafetyRating{0xCEC1'82D4'90A3'6FD4U, 16'019'443, 0xDE4B'7E73'61DB'203AU},
    // rsm
    SafetyRating{0xC80B'D065'403A'5706U, 13'723'210, 0x64DE'C14C'B42E'4F51U},
    // rsh
    SafetyRating{0x698F'DAAB'62F3'CA39U, 24'017'766, 0xE327'72DE'EC4E'BB80U},
    // rlm
    SafetyRating{0x6DF7'3179'F439'EEDDU, 17'565'712, 0xF6F6'E5F6'8D1E'487FU},
    // rlh
    SafetyRating{0x4072'522F'CE87'527EU, 31'719'068, 0xCB89'085D'EC10'9502U},
    // rum
    SafetyRating{0x821C'D240'4404'C1DDU, 18'378'656, 0x81A4'5D69'65D5'406AU},
    // ruh
    SafetyRating{0xEEE1'4339'D9BC'EB8DU, 37'669'520, 0xE806'6A63'9CBE'8F21U},
    // lmm
    SafetyRating{0xA85C'AA5F'025A'BD6EU, 19'865'317, 0x8B16'36F0'0A89'3A55U},
};

}  // namespace biss
