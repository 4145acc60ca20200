// SafetyRating: how often the checks of two words accept a wrong position, and the ratings of the
// named configurations.
#pragma once

#include <array>
#include <cstdint>

namespace biss {

namespace safety_detail {

// A checksum of words. Each step is reversible, so a change within one word always changes it.
class Sum64 {
 public:
  constexpr bool operator==(const Sum64&) const = default;
  constexpr void add(std::uint64_t word) {
    number_ = (number_ ^ word) * 0x100'0000'01B3U;
    number_ ^= number_ >> 32U;
  }
  constexpr std::uint64_t number() const { return number_; }

 private:
  std::uint64_t number_ = 0xCBF2'9CE4'8422'2325U;
};

}  // namespace safety_detail

/// The exact residual error of two words with their comparison, as `biss safety analyse --to c`
/// prints it.
struct SafetyRating {
  /// The words that the rating is for: rated_words().
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
  safety_detail::Sum64 sum;
  sum.add(words);
  sum.add(residual_e24);
  return sum.number();
}

/// The ratings of the named configurations: `biss safety analyse -f NAME --compare BITS --to c` with
/// the bits that the configuration compares. A test compares them with the analysis.
inline constexpr std::array<SafetyRating, 12> safety_ratings{
    // fs-32-32
    SafetyRating{0xC0C3'5FEA'DC5C'4430U, 1'365'348, 0x62AF'0197'A965'2206U},
    // fs-28-24
    SafetyRating{0xD49F'E6D0'8433'DD31U, 3'881'667, 0x5044'0E04'7B1F'E73DU},
    // fs-36-28
    SafetyRating{0x941F'DE94'538F'4D3FU, 6'249'988, 0x6E99'2546'0186'D53AU},
    // rxm
    SafetyRating{0xD5CA'8010'1E34'B184U, 5'377'414, 0x10B9'02D2'520F'C90EU},
    // rxh
    SafetyRating{0xCEC1'82D4'90A3'6FD4U, 16'019'443, 0x8400'E550'B64D'56F6U},
    // rsm
    SafetyRating{0xC80B'D065'403A'5706U, 13'723'210, 0x2532'0711'A3C4'C138U},
    // rsh
    SafetyRating{0x698F'DAAB'62F3'CA39U, 24'017'766, 0x5E17'B633'72C7'4F46U},
    // rlm
    SafetyRating{0x6DF7'3179'F439'EEDDU, 17'565'712, 0x7B21'AD7B'02AD'DA9CU},
    // rlh
    SafetyRating{0x4072'522F'CE87'527EU, 31'719'068, 0xF910'E94D'D3AC'FB1BU},
    // rum
    SafetyRating{0x821C'D240'4404'C1DDU, 18'378'656, 0xB138'D0AC'0161'B922U},
    // ruh
    SafetyRating{0xEEE1'4339'D9BC'EB8DU, 37'669'520, 0x9C93'267B'3DE3'7271U},
    // lmm
    SafetyRating{0xA85C'AA5F'025A'BD6EU, 19'865'317, 0x528B'BB79'BBB5'2C3AU},
};

}  // namespace biss
