#include "biss/frame/format.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"

namespace biss::format_test {

using Mistake = FormatMistake;

// Text and canonical text.
struct Spelling {
  const char* text;
  const char* canonical;
};

constexpr std::array spellings{
    Spelling{"pos18,nE,nW,crc6;cds0", "pos18,nE,nW,crc6;cds0"},
    Spelling{"mt12,st20,nE,nW,lc6,crc16", "mt12,st20,nE,nW,lc6,crc16"},
    Spelling{"pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0",
             "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"},
    Spelling{"pos1", "pos1"},
    Spelling{"pos64", "pos64"},
    Spelling{"pos018", "pos18"},
    Spelling{"mt64", "mt64"},
    Spelling{"st64:gray", "st64:gray"},
    Spelling{"st12,mt4", "st12,mt4"},
    Spelling{"mt1,st63", "mt1,st63"},
    Spelling{"mt8,st8:gray,nW,nE", "mt8,st8:gray,nW,nE"},
    Spelling{"E,W", "E,W"},
    Spelling{"W,pos3,nE", "W,pos3,nE"},
    Spelling{"nE", "nE"},
    Spelling{"lc32,pos32", "lc32,pos32"},
    Spelling{"pad64", "pad64"},
    Spelling{"pad1,pad2,pos5,pad3,pad4", "pad3,pos5,pad7"},
    Spelling{"pos8,crc3", "pos8,crc3"},
    Spelling{"pos8,crc3:0xB", "pos8,crc3"},
    Spelling{"pos8,crc3:0xD", "pos8,crc3:0xD"},
    Spelling{"pos8,crc4", "pos8,crc4"},
    Spelling{"pos8,crc5", "pos8,crc5"},
    Spelling{"pos8,crc6:0x43", "pos8,crc6"},
    Spelling{"pos8,crc6:0X00000043:0x0", "pos8,crc6"},
    Spelling{"pos8,crc6:0x43:0x3f", "pos8,crc6:0x43:0x3F"},
    Spelling{"pos8,crc6:plain", "pos8,crc6:plain"},
    Spelling{"pos8,crc6:0x43:plain", "pos8,crc6:plain"},
    Spelling{"pos8,crc6:0x43:0x00:plain", "pos8,crc6:plain"},
    Spelling{"pos8,crc6:0x43:0x01:plain", "pos8,crc6:0x43:0x1:plain"},
    Spelling{"pos8,crc7", "pos8,crc7"},
    Spelling{"pos8,crc8:0x12f", "pos8,crc8"},
    Spelling{"pos8,crc8:0x197", "pos8,crc8:0x197"},
    Spelling{"pos8,crc9:0x211", "pos8,crc9:0x211"},
    Spelling{"pos8,crc16:0x190d9:0xffff", "pos8,crc16:0x190D9:0xFFFF"},
    Spelling{"pos8,crc16:0x11021", "pos8,crc16:0x11021"},
    Spelling{"pos8:gray", "pos8:gray"},
    Spelling{"mt4:gray,st8", "mt4:gray,st8"},
    Spelling{"mt4:lsb,st8:lsb:gray", "mt4:lsb,st8:gray:lsb"},
    Spelling{"pos8:lsb,nE,crc6", "pos8:lsb,nE,crc6"},
    Spelling{"pos8,crc6:reversed", "pos8,crc6:reversed"},
    Spelling{"pos8,nE,crc6:no-flags", "pos8,nE,crc6:no-flags"},
    Spelling{"pos8,crc6:cds;cds0", "pos8,crc6:cds;cds0"},
    Spelling{"pos58,crc6:previous", "pos58,crc6:previous"},
    Spelling{"pos8,crc6:previous:cds:no-flags:reversed:plain",
             "pos8,crc6:plain:reversed:no-flags:cds:previous"},
    Spelling{"pos8,crc6:0x43:cds", "pos8,crc6:cds"},
    Spelling{"pos8,crc6:0x61:0x3:reversed", "pos8,crc6:0x61:0x3:reversed"},
    Spelling{"pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1", "pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1"},
};

struct Wrong {
  const char* text;
  Mistake mistake;
  std::size_t at;
};

constexpr std::array wrongs{
    Wrong{"", Mistake::empty, 0},
    Wrong{"foo", Mistake::unknown_item, 0},
    Wrong{" pos18", Mistake::unknown_item, 0},
    Wrong{",pos18", Mistake::unknown_item, 0},
    Wrong{"+pos18", Mistake::unknown_item, 0},
    Wrong{";cds0", Mistake::unknown_item, 0},
    Wrong{"pos18,", Mistake::unknown_item, 6},
    Wrong{"pos18,,nE", Mistake::unknown_item, 6},
    Wrong{"pos18+", Mistake::unknown_item, 6},
    Wrong{"pos18+;cds0", Mistake::unknown_item, 6},
    Wrong{"pos18,NE", Mistake::unknown_item, 6},
    Wrong{"pos18,n", Mistake::unknown_item, 6},
    Wrong{"Pos18", Mistake::unknown_item, 0},
    Wrong{"pos18 ", Mistake::unexpected_character, 5},
    Wrong{"pos18:gray:gray", Mistake::unexpected_character, 11},
    Wrong{"pos18:lsb:gray:lsb", Mistake::unexpected_character, 15},
    Wrong{"pos18:plain", Mistake::unexpected_character, 6},
    Wrong{"lc6:gray", Mistake::unexpected_character, 3},
    Wrong{"pad6:lsb", Mistake::unexpected_character, 4},
    Wrong{"nE:gray", Mistake::unexpected_character, 2},
    Wrong{"pos8,crc6:reversed:reversed", Mistake::unexpected_character, 18},
    Wrong{"pos8,crc6:cds:0x43", Mistake::unexpected_character, 13},
    Wrong{"pos8,crc6:no-flag", Mistake::number_needs_0x, 10},
    Wrong{"pos8,crc9:reversed", Mistake::polynomial_missing, 8},
    Wrong{"nE,nW,crc6:no-flags", Mistake::no_data_before_crc, 6},
    Wrong{"pos59,crc6:previous", Mistake::too_long_for_previous, 6},
    Wrong{"pos1x", Mistake::unexpected_character, 4},
    Wrong{"mt4:grey", Mistake::unexpected_character, 4},
    Wrong{"lc6:", Mistake::unexpected_character, 3},
    Wrong{"pad6:", Mistake::unexpected_character, 4},
    Wrong{"nE6", Mistake::unexpected_character, 2},
    Wrong{"nE:", Mistake::unexpected_character, 2},
    Wrong{"st4:", Mistake::unexpected_character, 4},
    Wrong{"st4:grey", Mistake::unexpected_character, 4},
    Wrong{"st4:gray2", Mistake::unexpected_character, 8},
    Wrong{"pos8,crc6x", Mistake::unexpected_character, 9},
    Wrong{"pos8,crc6:0x43x", Mistake::unexpected_character, 14},
    Wrong{"pos8,crc6:0x43:0x1:", Mistake::unexpected_character, 18},
    Wrong{"pos8,crc6:0x43:0x1:0x2", Mistake::unexpected_character, 18},
    Wrong{"pos8,crc6:plainer", Mistake::unexpected_character, 15},
    Wrong{"pos8,crc6:plain:0x43", Mistake::unexpected_character, 15},
    Wrong{"pos8;cds0,nE", Mistake::unexpected_character, 9},
    Wrong{"pos8;cds0+pos8", Mistake::unexpected_character, 9},
    Wrong{"pos", Mistake::width_missing, 3},
    Wrong{"mtx", Mistake::width_missing, 2},
    Wrong{"st,nE", Mistake::width_missing, 2},
    Wrong{"pos-1", Mistake::width_missing, 3},
    Wrong{"pos8,lc", Mistake::width_missing, 7},
    Wrong{"pos8,crc", Mistake::width_missing, 8},
    Wrong{"pos8,crc:0x43", Mistake::width_missing, 8},
    Wrong{"pos0", Mistake::width_zero, 3},
    Wrong{"pos8,pad00", Mistake::width_zero, 8},
    Wrong{"pos8,crc0", Mistake::width_zero, 8},
    Wrong{"pos65", Mistake::width_too_large, 3},
    Wrong{"pos99999999999999999999", Mistake::width_too_large, 3},
    Wrong{"pos8,lc33", Mistake::width_too_large, 7},
    Wrong{"pos8,crc65", Mistake::width_too_large, 8},
    Wrong{"pos8,pos8", Mistake::item_twice, 5},
    Wrong{"mt8,mt", Mistake::item_twice, 4},
    Wrong{"st8,st8", Mistake::item_twice, 4},
    Wrong{"lc6,nE,lc6", Mistake::item_twice, 7},
    Wrong{"nE,nE", Mistake::item_twice, 3},
    Wrong{"W,W", Mistake::item_twice, 2},
    Wrong{"pos8,mt4", Mistake::position_twice, 5},
    Wrong{"pos8,st4", Mistake::position_twice, 5},
    Wrong{"mt4,pos8", Mistake::position_twice, 4},
    Wrong{"st4,pos8", Mistake::position_twice, 4},
    Wrong{"nE,E", Mistake::polarity_twice, 3},
    Wrong{"W,nW", Mistake::polarity_twice, 2},
    Wrong{"pos8,crc6,nE", Mistake::data_after_crc, 10},
    Wrong{"pos8,crc6,crc6", Mistake::data_after_crc, 10},
    Wrong{"pos8,crc6,", Mistake::data_after_crc, 10},
    Wrong{"crc6", Mistake::no_data_before_crc, 0},
    Wrong{"pos8,crc6+crc6", Mistake::no_data_before_crc, 10},
    Wrong{"pos64,nE", Mistake::too_many_data_bits, 6},
    Wrong{"mt32,st33", Mistake::too_many_data_bits, 5},
    Wrong{"pos8,pad57", Mistake::too_many_data_bits, 5},
    Wrong{"pos60,lc5", Mistake::too_many_data_bits, 6},
    Wrong{"pos8,crc2", Mistake::crc_width, 8},
    Wrong{"pos8,crc17", Mistake::crc_width, 8},
    Wrong{"pos8,crc9", Mistake::polynomial_missing, 8},
    Wrong{"pos8,crc15:plain", Mistake::polynomial_missing, 8},
    Wrong{"pos8,crc6:43", Mistake::number_needs_0x, 10},
    Wrong{"pos8,crc6:", Mistake::number_needs_0x, 10},
    Wrong{"pos8,crc6:plane", Mistake::number_needs_0x, 10},
    Wrong{"pos8,crc6:0x43:1", Mistake::number_needs_0x, 15},
    Wrong{"pos8,crc6:0x43:", Mistake::number_needs_0x, 15},
    Wrong{"pos8,crc6:0x", Mistake::number_without_digits, 12},
    Wrong{"pos8,crc6:0xg", Mistake::number_without_digits, 12},
    Wrong{"pos8,crc6:0x1000000", Mistake::number_too_large, 10},
    Wrong{"pos8,crc6:0x43:0xFFFFFFFFFFFFFFFFFF", Mistake::number_too_large, 15},
    Wrong{"pos8,crc6:0x42", Mistake::polynomial_form, 10},
    Wrong{"pos8,crc6:0x03", Mistake::polynomial_form, 10},
    Wrong{"pos8,crc6:0x83", Mistake::polynomial_form, 10},
    Wrong{"pos8,crc16:0x100000", Mistake::polynomial_form, 11},
    Wrong{"pos8,crc6:0x43:0x40", Mistake::start_too_large, 15},
    Wrong{"pos8,crc16:0x190D9:0x10000", Mistake::start_too_large, 19},
    Wrong{"pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1", Mistake::too_many_channels, 39},
    Wrong{"pos8;", Mistake::unknown_option, 5},
    Wrong{"pos8;cds1", Mistake::unknown_option, 5},
    Wrong{"pos8;cds01", Mistake::unknown_option, 5},
    Wrong{"pos8;;cds0", Mistake::unknown_option, 5},
    Wrong{"pos8;cds0;cds0", Mistake::option_twice, 10},
};

constexpr bool reads_back(std::string_view text) {
  const auto format = parse_format(text);
  if (!format.ok()) return false;
  const auto again = parse_format(format_text(*format).view());
  return again.ok() && *again == *format;
}

static_assert(reads_back("mt12,st20:gray,nE,nW,lc6,pad3,crc16:0x190D9:0x1:plain+pos8;cds0"));
static_assert(parse_format("pos18,nE,nX").error() == FormatTextError{Mistake::unknown_item, 9});
static_assert(parse_format("pos18,nE,nW,crc6")->payload_bits() == 26);

/// A random text of the grammar, with at most one spelling for each format.
class TextMaker {
 public:
  explicit TextMaker(test::Random& random) : random_(random) {}

  FormatText frame() {
    FormatText text;
    const std::uint32_t channels = 1 + random_.below(max_channels);
    for (std::uint32_t k = 0; k < channels; ++k) {
      if (k != 0) text.append("+");
      channel(text);
    }
    if (random_.flip()) text.append(";cds0");
    return text;
  }

 private:
  void item(FormatText& text, std::string_view name, std::uint32_t bits) {
    if (left_ < bits) return;
    left_ -= bits;
    if (!first_) text.append(",");
    first_ = false;
    text.append(name);
  }

  void sized(FormatText& text, std::string_view name, std::uint32_t limit) {
    const std::uint32_t bits = 1 + random_.below(limit);
    if (left_ < bits) return;
    item(text, name, bits);
    text.append_number(bits, 10);
  }

  void coded(FormatText& text, std::string_view name, std::uint32_t limit) {
    sized(text, name, limit);
    if (random_.flip()) text.append(":gray");
    if (random_.flip()) text.append(":lsb");
  }

  void channel(FormatText& text) {
    left_ = max_data_bits;
    first_ = true;
    if (random_.flip()) {
      coded(text, "pos", 40);
    } else {
      coded(text, "mt", 20);
      coded(text, "st", 20);
    }
    if (random_.flip()) item(text, random_.flip() ? "nE" : "E", 1);
    if (random_.flip()) sized(text, "pad", 9);
    if (random_.flip()) item(text, random_.flip() ? "nW" : "W", 1);
    if (random_.flip()) sized(text, "lc", 32);
    if (random_.flip()) crc(text);
  }

  void crc(FormatText& text) {
    const std::uint32_t width = min_crc_bits + random_.below(max_crc_bits - min_crc_bits + 1);
    text.append(",crc");
    text.append_number(width, 10);
    if (default_polynomial(width) == 0 || random_.flip()) {
      text.append(":0x");
      const auto middle = static_cast<std::uint32_t>(random_.bits(width - 1));
      text.append_number((1U << width) | (middle << 1U) | 1U, 16);
      if (random_.flip()) {
        text.append(":0x");
        text.append_number(static_cast<std::uint32_t>(random_.bits(width)), 16);
      }
    }
    for (const char* suffix : {":plain", ":reversed", ":no-flags", ":cds", ":previous"}) {
      if (random_.below(4) == 0) text.append(suffix);
    }
  }

  test::Random& random_;
  std::uint32_t left_ = 0;
  bool first_ = true;
};

BISS_TEST(FormatText, EachSpelling_HasItsCanonicalText) {
  for (const Spelling& spelling : spellings) {
    const auto format = parse_format(spelling.text);
    BISS_EXPECT(format.ok()) << spelling.text;
    if (!format.ok()) continue;
    BISS_EXPECT_EQ(format_text(*format).view(), std::string_view(spelling.canonical))
        << spelling.text;
    BISS_EXPECT(reads_back(spelling.text)) << spelling.text;
  }
}

BISS_TEST(FormatText, EachMistake_PointsAtItsCharacter) {
  for (const Wrong& wrong : wrongs) {
    const auto format = parse_format(wrong.text);
    BISS_EXPECT(!format.ok()) << wrong.text;
    if (format.ok()) continue;
    BISS_EXPECT_EQ(format.error().mistake, wrong.mistake) << wrong.text;
    BISS_EXPECT_EQ(format.error().at, wrong.at) << wrong.text;
  }
}

BISS_TEST(FormatText, EveryKindOfMistake_IsTriedAndHasWords) {
  std::uint32_t tried = 0;
  for (const Wrong& wrong : wrongs) tried |= 1U << static_cast<unsigned>(wrong.mistake);
  const unsigned kinds = static_cast<unsigned>(Mistake::option_twice) + 1U;
  BISS_EXPECT_EQ(tried, (1U << kinds) - 1U);
  for (unsigned i = 0; i < kinds; ++i) {
    const std::string_view text = text_of(static_cast<Mistake>(i));
    BISS_EXPECT(text.size() > 8 && text.back() != '.') << "mistake " << i;
    for (unsigned k = 0; k < i; ++k) BISS_EXPECT(text != text_of(static_cast<Mistake>(k)));
  }
}

BISS_TEST(FormatText, EveryPrefixOfAFormat_ReadsOrPointsInside) {
  const std::string_view text =
      "mt12,pad2,st18:gray,nE,W,lc6,crc16:0x190D9:0xA5:plain+pos8,crc6:0x43;cds0";
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const auto format = parse_format(text.substr(0, size));
    BISS_EXPECT(format.ok() ? reads_back(text.substr(0, size)) : format.error().at <= size)
        << "size " << size;
  }
}

BISS_TEST(FormatText, LongestText_Fits) {
  FormatText text;
  for (std::size_t k = 0; k < max_channels; ++k) {
    if (k != 0) text.append("+");
    text.append("pad10,mt10:gray:lsb,pad9,st1:gray:lsb,pad1,nE,pad1,nW,pad1,lc10,pad1");
    text.append(",crc16:0x1FFFF:0xFFFF:plain:reversed:no-flags:cds:previous");
  }
  text.append(";cds0");
  const auto format = parse_format(text.view());
  BISS_ASSERT(format.ok());
  BISS_EXPECT_EQ(format_text(*format).view(), text.view());
}

BISS_TEST(FormatText, RandomFormats_ReadBackFromTheirCanonicalText) {
  BISS_RANDOM(random, 0xF0'0001);
  TextMaker maker(random);
  const std::uint64_t rounds = test::rounds(5'000, 50);
  std::uint64_t read = 0;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const FormatText text = maker.frame();
    if (!parse_format(text.view()).ok()) continue;
    ++read;
    BISS_ASSERT(reads_back(text.view())) << "round " << round;
  }
  BISS_EXPECT(read > rounds / 4 * 3) << "read " << read;
}

BISS_TEST(FrameFormat, EveryItem_StandsAtItsPlace) {
  const auto format = parse_format("pad1,mt3,W,st5:gray,pad2,nE,lc6,pad1,crc9:0x211:0x5:plain+nW");
  BISS_ASSERT(format.ok());
  BISS_EXPECT_EQ(format->channel_count, 2);
  BISS_EXPECT(!format->cds0);
  const ChannelFormat& first = format->channel_list[0];
  BISS_EXPECT_EQ(first.data_bits, 20);
  BISS_EXPECT(first.multiturn == Field{16, 3});
  BISS_EXPECT(first.warning == FlagField{15, true, true});
  BISS_EXPECT(first.singleturn == Field{10, 5});
  BISS_EXPECT(first.singleturn_gray);
  BISS_EXPECT(first.error == FlagField{7, true, false});
  BISS_EXPECT(first.life_counter == Field{1, 6});
  BISS_EXPECT(first.crc == CrcSpec{0x211, 5, 9, false});
  BISS_EXPECT(!first.position.present());
  BISS_EXPECT_EQ(first.position_bits(), 8);
  BISS_EXPECT_EQ(first.total_bits(), 29);
  const ChannelFormat& second = format->channel_list[1];
  BISS_EXPECT_EQ(second.data_bits, 1);
  BISS_EXPECT_EQ(second.position_bits(), 0);
  BISS_EXPECT(!second.crc.present());
  BISS_EXPECT_EQ(format->payload_bits(), 30);
}

}  // namespace biss::format_test
