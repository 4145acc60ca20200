// A FixedSafetyPlan for every SafetySetupError, and an unknown configuration name. No such line
// compiles, and wrong_plans.cmake compares the compiler's message with the text at each line.
#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/plan.hpp"

namespace biss {

template <FrameFormat Format, auto Setup = SafetySetup{}>
inline constexpr auto payload_bits = FixedSafetyPlan<Format, Setup>::payload_bits();

constexpr FrameFormat format(const char* text) { return parse_format(text).value(); }

constexpr SafetySetup with(auto change) {
  SafetySetup setup;
  change(setup);
  return setup;
}

constexpr FrameFormat good = safety_configuration("fs-36-28").frame_format();
constexpr FrameFormat gray = [] {
  FrameFormat format = good;
  format.channel_list[1].singleturn_gray = true;
  return format;
}();

constexpr SafetySetup one_word = with([](SafetySetup& setup) { setup.cpw = 1; });
constexpr SafetySetup wide = with([](SafetySetup& setup) { setup.comparison.compare_bits = 29; });
constexpr SafetySetup tolerant =
    with([](SafetySetup& setup) { setup.comparison = {.compare_bits = 2, .tolerance_lsb = 2}; });
constexpr SafetySetup hasty = with([](SafetySetup& setup) { setup.start_frames = 1; });
constexpr SafetySetup far = with([](SafetySetup& setup) { setup.counter.near_frames = 31; });
constexpr SafetySetup lenient = with([](SafetySetup& setup) { setup.budget.faults = 5; });
constexpr SafetySetup patient =
    with([](SafetySetup& setup) { setup.frame_gap_max = milliseconds(2); });

constexpr SafetySetup drifting =
    with([](SafetySetup& setup) { setup.clocks.tolerance = setup.frame_gap_max; });
constexpr SafetySetup two_bits =
    with([](SafetySetup& setup) { setup.comparison.compare_bits = 2; });
constexpr SafetySetup demanding =
    with([](SafetySetup& setup) { setup.residual_max_e15 = 100'000; });

constexpr auto right = payload_bits<good>;
// A type that says so permits them.
constexpr auto unrated = payload_bits<good, UnratedSafetySetup(two_bits)>;

// says: a word has no CRC
constexpr auto wrong_1 = payload_bits<format("pos9,nE,nW+pos9,nE,nW,lc6,crc16")>;
// says: a word has no nE
constexpr auto wrong_2 = payload_bits<format("pos9,crc6+pos9,nE,nW,lc6,crc16")>;
// says: a word has no position
constexpr auto wrong_3 = payload_bits<format("pos9,nE,nW,crc6+nE,nW,lc6,crc16")>;
// says: a word's position is in Gray code
constexpr auto wrong_4 = payload_bits<gray>;
// says: the SPW has no sign-of-life counter
constexpr auto wrong_5 = payload_bits<format("pos9,nE,nW,crc6+pos9,nE,nW,crc16")>;
// says: or CPW and SPW are the same channel
constexpr auto wrong_6 = payload_bits<good, one_word>;
// says: compare_bits is more than both words have
constexpr auto wrong_7 = payload_bits<good, wide>;
// says: tolerance_lsb accepts every position
constexpr auto wrong_8 = payload_bits<good, tolerant>;
// says: start_frames is less than 2
constexpr auto wrong_9 = payload_bits<good, hasty>;
// says: near_frames is above 30
constexpr auto wrong_10 = payload_bits<good, far>;
// says: too many faults in the budget
constexpr auto wrong_11 = payload_bits<good, lenient>;
// says: shorter than the counter's period
constexpr auto wrong_12 = payload_bits<good, patient>;
// says: the clocks' tolerance is not from 0 to below frame_gap_max
constexpr auto wrong_13 = payload_bits<good, drifting>;
// says: the CPW's CRC is not 0x43, or the SPW's is not 0x190D9
constexpr auto wrong_14 = payload_bits<format("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc3;cds0")>;
// says: fewer than 9 bits are compared, or tolerance_lsb is above 1
constexpr auto wrong_15 = payload_bits<good, two_bits>;
// says: the words have no rating
constexpr auto wrong_16 = payload_bits<format("pos35,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0")>;
// says: more undetected errors an hour than residual_max_e15
constexpr auto wrong_17 = payload_bits<good, demanding>;
// says: no_safety_configuration_of_this_name
constexpr auto unknown = safety_configuration("fs-36-27");

}  // namespace biss
