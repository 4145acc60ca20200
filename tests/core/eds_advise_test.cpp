#include "biss/eds/advise.hpp"

#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"

namespace biss::eds_advise_test {

static_assert(advise({.resolution_bits = 20, .turns_bits = 12})->identifier == 0x6222);

BISS_TEST(EdsAdvice, UsualEncoders_GetTheUsualFrames) {
  auto advice = advise({.resolution_bits = 20, .turns_bits = 12});
  BISS_ASSERT(advice.ok());
  BISS_EXPECT_EQ(advice->identifier, 0x6222);
  BISS_EXPECT(advice->channel == parse_format("mt12,st20,nE,nW,crc6")->channel_list[0]);
  BISS_EXPECT_EQ(advice->hamming_distance, 3);
  BISS_EXPECT(advice->feasible && advice->clock_needed == Hertz{});
  BISS_EXPECT_EQ(advise({.resolution_bits = 26})->identifier, 0x621C);
  BISS_EXPECT_EQ(advise({.resolution_bits = 26, .in_safety_encoder = true})->identifier, 0x6322);
  BISS_EXPECT_EQ(advise({.resolution_bits = 31, .turns_bits = 24})->identifier, 0x6239);
  advice = advise({.resolution_bits = 32, .turns_bits = 24});
  BISS_EXPECT_EQ(advice->identifier, 0);
  BISS_EXPECT(advice->channel.crc == crc16);
  BISS_EXPECT_EQ(advice->hamming_distance, 6);
  advice = advise({.resolution_bits = 17,
                   .turns_bits = 10,
                   .resolution_field_bits = 20,
                   .turns_field_bits = 12});
  BISS_EXPECT_EQ(advice->leading_zeros, 2);
  BISS_EXPECT_EQ(advice->trailing_zeros, 3);
  BISS_EXPECT_EQ(advice->identifier, 0x6222);
  BISS_EXPECT(advice->channel == parse_format("pad2,mt10,st17,pad3,nE,nW,crc6")->channel_list[0]);
  const Bp3Part part = parse_bp3_part(bp3_bank_of(*advice));
  BISS_EXPECT_EQ(part.mt_len, 12);
  BISS_EXPECT_EQ(part.fi_len, 20);
  BISS_EXPECT_EQ(part.mt_cnt, 1024U);
  BISS_EXPECT_EQ(part.sip_cnt * part.sip_res, std::uint32_t{1} << 17U);
}

BISS_TEST(EdsAdvice, Rate_NeedsAClock) {
  const DeviceTiming timing{.ack_max = microseconds(16),
                            .timeout = {.rule = TimeoutRule::cycle, .time = nanoseconds(31'250)},
                            .cycle_min = nanoseconds(31'250)};
  AdviceWish wish{.resolution_bits = 26, .rate = kilohertz(32), .timing = timing};
  auto advice = advise(wish);
  BISS_ASSERT(advice.ok());
  BISS_EXPECT(advice->feasible);
  // 39 clocks and 16 us in 31.25 us: between 2.5 and 2.8 MHz.
  BISS_EXPECT(advice->clock_needed > kilohertz(2500) && advice->clock_needed < kilohertz(2800));
  wish.clock = advice->clock_needed;
  BISS_EXPECT(advise(wish)->feasible);
  wish.clock = Hertz{advice->clock_needed.count - 1};
  BISS_EXPECT(!advise(wish)->feasible);
  wish.rate = kilohertz(33);
  wish.clock = {};
  advice = advise(wish);
  BISS_EXPECT(!advice->feasible && advice->clock_needed == Hertz{});
  wish.rate = hertz(100);
  BISS_EXPECT(advise(wish)->clock_needed == biss_clock_min);
}

BISS_TEST(EdsAdvice, ImpossibleWishes_SayWhy) {
  BISS_EXPECT_EQ(advise({}).error(), AdviceError::nothing_to_send);
  BISS_EXPECT_EQ(advise({.resolution_bits = 20, .resolution_field_bits = 19}).error(),
                 AdviceError::field_too_short);
  BISS_EXPECT_EQ(advise({.turns_bits = 20, .turns_field_bits = 19}).error(),
                 AdviceError::field_too_short);
  BISS_EXPECT_EQ(advise({.resolution_bits = 63}).error(), AdviceError::too_long);
  BISS_EXPECT_EQ(advise({.resolution_bits = 4'294'967'295U, .turns_bits = 1}).error(),
                 AdviceError::too_long);
  BISS_EXPECT_EQ(advise({.resolution_bits = 20, .clock = megahertz(11)}).error(),
                 AdviceError::clock_refused);
  BISS_EXPECT_EQ(advise({.resolution_bits = 20, .clock = hertz(1)}).error(),
                 AdviceError::clock_refused);
}

}  // namespace biss::eds_advise_test
