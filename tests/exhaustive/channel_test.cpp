// Every legal shape of a channel, at every width from 1 to 64 bits and with every width of CRC:
// encode then decode is the identity, and the oracle agrees bit for bit and value for value.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive::channel_test {

using oracle::Item;
using oracle::Kind;
using Items = std::vector<Item>;
using Codec = biss::FrameCodec<biss::CrcFast, 1>;

// How the position's bits are shared between multiturn and singleturn.
enum class Split { one_turn_bit, half, one_angle_bit };

struct PositionLayout {
  const char* name;
  std::vector<Kind> kinds;
  Split split = Split::half;
};

const std::array<PositionLayout, 10> position_layouts{{
    {"pos", {Kind::position}},
    {"mt", {Kind::multiturn}},
    {"st", {Kind::singleturn}},
    {"gray", {Kind::gray_singleturn}},
    {"mt1_st", {Kind::multiturn, Kind::singleturn}, Split::one_turn_bit},
    {"mt_st", {Kind::multiturn, Kind::singleturn}},
    {"mt_st1", {Kind::multiturn, Kind::singleturn}, Split::one_angle_bit},
    {"mt_gray", {Kind::multiturn, Kind::gray_singleturn}},
    {"st_mt", {Kind::singleturn, Kind::multiturn}},
    {"none", {}},
}};

const std::array<std::vector<Kind>, 9> flag_layouts{{{},
                                                     {Kind::nE},
                                                     {Kind::nW},
                                                     {Kind::nE, Kind::nW},
                                                     {Kind::E, Kind::W},
                                                     {Kind::nW, Kind::nE},
                                                     {Kind::nE, Kind::W},
                                                     {Kind::E, Kind::nW},
                                                     {Kind::W}}};

constexpr std::array<std::size_t, 4> counter_bits{0, 1, 6, 32};

// Bits of padding before, between and after the other items.
constexpr std::array<std::array<std::size_t, 3>, 5> paddings{
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {1, 2, 1}}};

struct Shape {
  const PositionLayout& position;
  const std::vector<Kind>& flags;
  std::size_t counter = 0;
  std::array<std::size_t, 3> padding{};
  bool flags_first = false;
};

void add(Items& items, Kind kind, std::size_t bits) {
  if (bits != 0) items.push_back({kind, bits});
}

// The position of `bits` in its layout; false when it does not fit.
bool add_position(Items& items, const PositionLayout& layout, std::size_t bits) {
  if (layout.kinds.empty()) {
    add(items, Kind::padding, bits);
    return true;
  }
  if (bits < layout.kinds.size()) return false;
  if (layout.kinds.size() == 1) {
    add(items, layout.kinds[0], bits);
    return true;
  }
  const std::size_t turns = layout.split == Split::half           ? bits / 2
                            : layout.split == Split::one_turn_bit ? 1
                                                                  : bits - 1;
  for (const Kind kind : layout.kinds) {
    add(items, kind, kind == Kind::multiturn ? turns : bits - turns);
  }
  return true;
}

/// The items of a shape of `data_bits`, the position taking what the others leave.
std::optional<Items> items_of(const Shape& shape, std::size_t data_bits) {
  const std::size_t others =
      shape.flags.size() + shape.counter + shape.padding[0] + shape.padding[1] + shape.padding[2];
  if (others > data_bits) return std::nullopt;
  Items items;
  add(items, Kind::padding, shape.padding[0]);
  if (!shape.flags_first && !add_position(items, shape.position, data_bits - others)) {
    return std::nullopt;
  }
  add(items, Kind::padding, shape.padding[1]);
  for (const Kind flag : shape.flags) items.push_back({flag, 1});
  add(items, Kind::counter, shape.counter);
  if (shape.flags_first && !add_position(items, shape.position, data_bits - others)) {
    return std::nullopt;
  }
  add(items, Kind::padding, shape.padding[2]);
  return items;
}

// Index 0 is not a CRC, then the widths from 3 to 16; inversion and start take turns.
std::optional<oracle::Checksum> checksum_at(std::uint64_t index) {
  const auto width = static_cast<unsigned>(index % 15);
  if (width == 0) return std::nullopt;
  const std::uint64_t turn = index / 15;
  return checksum_of(width + 2, turn % 2 == 0,
                     turn % 4 < 2 ? 0 : 0xA53C & biss::low_mask(width + 2));
}

/// The identity, the oracle, and the verdict on a damaged line of the same format.
std::string judge(const oracle::Description& description, biss::test::Random& random) {
  const Twin twin = twin_of(description);
  const Codec codec(twin.format);
  const Sent sent = random_sent(description, random);
  std::string what = judge_frame(twin, codec, sent);
  if (!what.empty()) return what;
  const oracle::Bits line = oracle::encode(description, sent.values, sent.lead, sent.ack, sent.cds);
  return judge_line(twin, codec, damaged(line, random));
}

class EveryChannel : public testing::TestWithParam<std::size_t> {};

// Every shape at every width meets no CRC and each width of CRC; inverted or plain and the two
// starts take turns.
TEST_P(EveryChannel, EncodedAndDecoded_IsTheIdentityForBothReaders) {
  const std::uint64_t seed = 0xC4A0'0000 + GetParam();
  BISS_RANDOM(random, seed);
  std::uint64_t shapes = 0;
  std::uint64_t judged = 0;
  std::uint64_t index = 0;
  for (std::size_t bits = 1; bits <= 64; ++bits) {
    for (const auto& flags : flag_layouts) {
      for (const std::size_t counter : counter_bits) {
        for (std::size_t variant = 0; variant < 2 * paddings.size(); ++variant) {
          const Shape shape{position_layouts[GetParam()], flags, counter, paddings[variant / 2],
                            variant % 2 == 1};
          const auto items = items_of(shape, bits);
          if (!items) continue;
          ++shapes;
          for (std::uint64_t width = 0; width < 15; ++width) {
            if (++index % thin != 0) continue;
            ++judged;
            const std::string what =
                judge({{{*items, checksum_at(width + 15 * (shapes % 4))}}, index % 2 == 0}, random);
            ASSERT_EQ(what, "") << "shape " << shapes << " of " << bits << " bits";
          }
        }
      }
    }
  }
  RecordProperty("channels", std::to_string(judged));
  EXPECT_GT(shapes, 17'000U);
  EXPECT_EQ(judged, shapes * 15 / thin);
}

INSTANTIATE_TEST_SUITE_P(Layouts, EveryChannel,
                         testing::Range(std::size_t{0}, position_layouts.size()),
                         [](const auto& layout) { return position_layouts[layout.param].name; });

TEST(EveryCrc, AtEveryDataWidth_IsTheIdentityForBothReaders) {
  BISS_RANDOM(random, 0xC4C0'0001);
  for (std::size_t bits = 1; bits <= 64; ++bits) {
    for (std::uint64_t index = 0; index < 60; ++index) {
      const std::string what =
          judge({{{{{Kind::position, bits}}, checksum_at(index)}}, false}, random);
      ASSERT_EQ(what, "") << "CRC " << index << " of " << bits << " bits";
    }
  }
}

}  // namespace exhaustive::channel_test
