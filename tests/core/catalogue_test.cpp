#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "tests/core/test.hpp"

namespace biss::catalogue_test {

static_assert(find_encoder("resolute-26")->frame_format() ==
              parse_format("pos26,nE,nW,crc6;cds0").value());

BISS_TEST(Catalogue, EveryEntry_IsComplete) {
  for (const CatalogueEntry& entry : catalogue) {
    BISS_EXPECT(!entry.name.empty() && !entry.vendor.empty() && !entry.product.empty());
    BISS_EXPECT(!entry.source.empty());
    BISS_EXPECT(find_encoder(entry.name) == &entry);
    const auto format = parse_format(entry.format);
    BISS_ASSERT(format.ok());
    BISS_EXPECT(format_text(*format).view() == entry.format);
    // A gap in the list would hide what follows.
    const auto first_empty = std::find(entry.uncertain.begin(), entry.uncertain.end(), "");
    BISS_EXPECT(std::all_of(first_empty, entry.uncertain.end(),
                            [](std::string_view text) { return text.empty(); }));
    BISS_EXPECT_EQ(entry.certain(), first_empty == entry.uncertain.begin());
  }
}

BISS_TEST(Catalogue, EveryEntry_HasPossibleTiming) {
  for (const CatalogueEntry& entry : catalogue) {
    const DeviceTiming& timing = entry.timing;
    BISS_EXPECT(timing.clock_min < timing.clock_max);
    BISS_EXPECT(timing.clock_max <= megahertz(10));
    BISS_EXPECT(timing.ack_max > Picoseconds{} && timing.ack_max <= biss_busy_max);
    BISS_EXPECT(timing.sampling_min <= timing.sampling_typical);
    BISS_EXPECT(timing.sampling_typical <= timing.sampling_max);
  }
}

BISS_TEST(Catalogue, SafetyConfigurationOfAnEncoder_HasItsTiming) {
  unsigned of_encoders = 0;
  for (const SafetyConfiguration& each : safety_configurations) {
    bool of_encoder = false;
    for (const CatalogueEntry& entry : catalogue) {
      if (!each.name.starts_with(entry.name)) continue;
      of_encoder = true;
      BISS_EXPECT(each.timing == entry.timing);
      BISS_EXPECT(each.frame_format() == entry.frame_format());
    }
    BISS_EXPECT(of_encoder != (each.timing == DeviceTiming{}));
    if (!of_encoder) continue;
    ++of_encoders;
    BISS_EXPECT_EQ(each.timing.ack_max.count, microseconds(16).count);
    BISS_EXPECT_EQ(each.timing.cycle_min.count, nanoseconds(31'250).count);
    BISS_EXPECT(each.timing.clock_min == kilohertz(250));
  }
  BISS_EXPECT_EQ(of_encoders, 5);
}

BISS_TEST(Catalogue, NamesNobodyHas_AreNotFound) {
  for (const std::string_view name : {"", "resolute", "resolute-27", "Resolute-26", "pos26"}) {
    BISS_EXPECT(find_encoder(name) == nullptr);
  }
}

BISS_TEST(Catalogue, EncodeThenDecode_IsTheIdentityForEveryFormat) {
  BISS_RANDOM(random, 0xCA7A);
  for (const CatalogueEntry& entry : catalogue) {
    const FrameFormat format = entry.frame_format();
    const PlainCodec codec(format);
    for (std::uint64_t i = 0; i < test::rounds(200, 2); ++i) {
      Frame sent;
      sent.channel_count = format.channel_count;
      sent.lead_clocks = 1;
      sent.ack_clocks = static_cast<std::uint16_t>(1 + random.below(400));
      for (std::size_t k = 0; k < format.channel_count; ++k) {
        const ChannelFormat& channel = format.channel_list[k];
        sent.channel_list[k].position = random.bits(channel.position_bits());
        sent.channel_list[k].life_counter =
            static_cast<std::uint32_t>(random.bits(channel.life_counter.bits));
        if (channel.error.present) sent.channel_list[k].nE = random.flip();
        if (channel.warning.present) sent.channel_list[k].nW = random.flip();
      }
      const auto bits = encode_frame(sent, codec);
      BISS_ASSERT(bits.ok());
      const auto received = decode_frame(bits->view(), codec);
      BISS_ASSERT(received.ok());
      BISS_EXPECT(received->channel_list == sent.channel_list);
      BISS_EXPECT_EQ(received->ack_clocks, sent.ack_clocks);
    }
  }
}

BISS_TEST(Catalogue, RenishawsTypes_AreUnidirectionalAt32kHz) {
  BISS_EXPECT_EQ(renishaw_encoders.size(), 13U);
  for (const CatalogueEntry& entry : renishaw_encoders) {
    BISS_EXPECT(entry.frame_format().cds0);
    BISS_EXPECT(entry.timing.timeout == Timeout({TimeoutRule::cycle, nanoseconds(31'250)}));
    BISS_EXPECT(entry.timing.ack_max == microseconds(16));
  }
  BISS_EXPECT_EQ(find_encoder("fs-36-28")->frame_format().payload_bits(), 96U);
}

enum class Flag : std::uint8_t { none, low, high };

constexpr Flag flag_of(const FlagField& field) {
  if (!field.present) return Flag::none;
  return field.active_high ? Flag::high : Flag::low;
}

struct Fact {
  const char* name;
  unsigned channel, turns, position;
  Flag error, warning;
  std::uint32_t polynomial;
  bool life_counter;
};

// From the sources that the entries name, not from the entries.
BISS_TEST(Catalogue, Facts_AreThoseOfTheSources) {
  using enum Flag;
  constexpr Fact facts[] = {
      // Renishaw, "BiSS C-mode (unidirectional)".
      {"resolute-18", 0, 0, 18, low, low, 0x43, false},
      {"resolute-26", 0, 0, 26, low, low, 0x43, false},
      {"resolute-32", 0, 0, 32, low, low, 0x43, false},
      {"resolute-linear-26", 0, 0, 26, low, low, 0x43, false},
      {"resolute-linear-32", 0, 0, 32, low, low, 0x43, false},
      {"resolute-linear-36", 0, 0, 36, low, low, 0x43, false},
      {"fortis-26", 0, 0, 26, low, low, 0x43, false},
      {"fortis-32", 0, 0, 32, low, low, 0x43, false},
      {"fortis-36", 0, 0, 36, low, low, 0x43, false},
      // Renishaw, "BiSS Safety".
      {"fs-32-32", 0, 0, 32, low, low, 0x43, false},
      {"fs-32-32", 1, 0, 32, low, low, 0x190D9, true},
      {"fs-28-24", 0, 0, 28, low, low, 0x43, false},
      {"fs-28-24", 1, 0, 24, low, low, 0x190D9, true},
      {"fs-36-28", 0, 0, 36, low, low, 0x43, false},
      {"fs-36-28", 1, 0, 28, low, low, 0x190D9, true},
      {"fortis-fs-36-28", 0, 0, 36, low, low, 0x43, false},
      {"fortis-fs-36-28", 1, 0, 28, low, low, 0x190D9, true},
      // Application notes and data sheets of iC-Haus.
      {"ic-mhm", 0, 0, 28, low, low, 0x43, false},
      {"ic-mh", 0, 0, 12, low, low, 0x43, false},
      {"ic-mr-26", 0, 0, 26, low, low, 0x43, false},
      {"ic-mr-24-24", 0, 24, 24, low, low, 0x43, false},
      {"ic-mr-crc16-24", 0, 0, 24, low, low, 0x190D9, false},
      {"ic-mr-crc16-12-26", 0, 12, 26, low, low, 0x190D9, false},
      {"ic-md-48", 0, 0, 48, low, low, 0x43, false},
      {"ic-lgc", 0, 12, 20, low, low, 0x190D9, true},
      // Manuals of other makers.
      {"lenz-b3", 0, 0, 24, low, low, 0x43, false},
      {"lika-amm3616", 0, 12, 16, low, low, 0x43, false},
      {"lika-amm3619", 0, 12, 19, low, low, 0x43, false},
      {"lika-smra-14", 0, 0, 14, low, low, 0x43, false},
      {"lika-sma1", 0, 0, 24, low, low, 0x43, false},
      {"waycon-mxs2-23", 0, 0, 23, low, none, 0x43, false},
      {"siko-msa213c", 0, 0, 25, low, low, 0x43, false},
      {"faulhaber-aemt", 0, 16, 12, low, low, 0x43, false},
      {"kuebler-s36-23", 0, 12, 23, low, low, 0x43, false},
      {"xscene-24", 0, 12, 24, low, low, 0x43, false},
      {"festo-sfc-laci", 0, 12, 11, none, none, 0x43, false},
      // Drivers: OnStepX (its As37h39bb.cpp treats 1 as error), Synapticon, motorlib, TI.
      {"lika-asc85", 0, 0, 25, low, low, 0x43, false},
      {"broadcom-as37", 0, 16, 23, high, low, 0x43, false},
      {"jtw-24", 0, 0, 24, low, low, 0x43, false},
      {"jtw-26", 0, 0, 26, low, low, 0x43, false},
      {"hengstler-ac36", 0, 12, 13, low, low, 0x43, false},
      {"as50-18", 0, 0, 18, low, low, 0x43, false},
      {"as50-10-18", 0, 10, 18, low, low, 0x43, false},
      {"aksim2-20", 0, 0, 20, low, low, 0x43, false},
      {"moons-12", 0, 0, 12, low, low, 0x43, false},
      {"ti-safety-demo", 0, 16, 12, low, low, 0x190D9, true},
  };
  for (const Fact& fact : facts) {
    const CatalogueEntry* entry = find_encoder(fact.name);
    BISS_ASSERT(entry != nullptr);
    const ChannelFormat channel = entry->frame_format().channel_list[fact.channel];
    const bool same = channel.multiturn.bits == fact.turns &&
                      channel.position_bits() == fact.turns + fact.position &&
                      flag_of(channel.error) == fact.error &&
                      flag_of(channel.warning) == fact.warning &&
                      channel.crc.polynomial == fact.polynomial && channel.crc.inverted &&
                      channel.crc.start == 0 && channel.life_counter.present() == fact.life_counter;
    BISS_EXPECT(same) << fact.name;
  }
}

bool doubts_of_contain(std::string_view name, std::string_view part) {
  const CatalogueEntry* entry = find_encoder(name);
  return entry != nullptr && std::any_of(entry->uncertain.begin(), entry->uncertain.end(),
                                         [&](std::string_view sentence) {
                                           return sentence.find(part) != std::string_view::npos;
                                         });
}

// The data sheet lists the widths 18, 26, 32 and 36 bits without a word on rotary and linear, and
// the sizes of a count for FORTiS with 26 and 32 bits only.
BISS_TEST(Catalogue, WhatIsInferredOfRenishawsTypes_IsADoubt) {
  for (const std::string_view name : {"resolute-18", "resolute-26", "resolute-32"}) {
    BISS_EXPECT(doubts_of_contain(name, "which of 18, 26, 32 and 36 bits are rotary: inferred"));
  }
  for (const std::string_view name :
       {"resolute-linear-26", "resolute-linear-32", "resolute-linear-36"}) {
    BISS_EXPECT(doubts_of_contain(name, "which of 18, 26, 32 and 36 bits are linear: inferred"));
  }
  BISS_EXPECT(doubts_of_contain("resolute-linear-26", "stated for FORTiS only"));
  BISS_EXPECT(doubts_of_contain("resolute-linear-36", "stated for RESOLUTE FS only"));
  BISS_EXPECT(find_encoder("resolute-linear-32")->resolution.empty());
  BISS_EXPECT(doubts_of_contain("fortis-36", "1 nm or 10 nm"));
  BISS_EXPECT(doubts_of_contain("fortis-fs-36-28", "10 nm or 1 nm"));
  for (const CatalogueEntry& entry : renishaw_encoders) {
    const bool calculated = entry.resolution.find("calculated") != std::string_view::npos;
    BISS_EXPECT(calculated == (entry.resolution.find("range") != std::string_view::npos ||
                               entry.resolution.find("(calc") != std::string_view::npos));
  }
}

}  // namespace biss::catalogue_test
