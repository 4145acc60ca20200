// The numbers in lab/reports/lost-start.md and docs/spi.md are the computed ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/spi/rates.hpp"

namespace biss::test::spi::doc_test {

std::string document(const char* name) {
  std::ifstream file(std::string(BISS_SOURCE_FOLDER "/") + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The table rows between `<!-- name -->` and the next empty line, without the two header lines.
std::vector<std::string> rows_of(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::vector<std::string> rows;
  std::string line;
  while (std::getline(lines, line) && line != "<!-- " + name + " -->") {
  }
  for (int header = 0; header < 2; ++header) std::getline(lines, line);
  while (std::getline(lines, line) && !line.empty()) rows.push_back(line);
  return rows;
}

void expect_rows(const std::string& name, const std::vector<std::string>& computed) {
  const std::vector<std::string> written = rows_of(document("lab/reports/lost-start.md"), name);
  if (written == computed) return;
  std::string text;
  for (const std::string& row : computed) text += row + "\n";
  ADD_FAILURE() << "lab/reports/lost-start.md, table " << name << "; computed:\n" << text;
}

std::string number(double rate) {
  if (rate == 0) return "0";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), rate >= 1e-3 ? "%.3g %%" : "%.1e",
                rate >= 1e-3 ? rate * 100 : rate);
  return text.data();
}

struct Named {
  const char* name;
  const char* format;
};

constexpr std::array<Named, 7> formats{{
    {"18", "pos18,nE,nW,crc6"},
    {"26", "pos26,nE,nW,crc6"},
    {"32", "pos32,nE,nW,crc6"},
    {"36", "pos36,nE,nW,crc6"},
    {"safety 28/24", "pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16"},
    {"safety 32/32", "pos32,nE,nW,crc6+pos32,nE,nW,lc6,crc16"},
    {"safety 36/28", "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16"},
}};

constexpr FrameBounds renishaw{
    .lead_min_clocks = 2, .lead_max_clocks = 10, .ack_min_clocks = 32, .ack_max_clocks = 160};
constexpr FrameBounds widest{.lead_min_clocks = 2};

Transfer transfer_of(const FrameFormat& format, const FrameBounds& bounds, unsigned ack) {
  return {2, ack,
          std::size_t{bounds.lead_max_clocks} + bounds.ack_max_clocks + 3 + format.payload_bits(),
          bounds};
}

/// The largest rate over every ACK within the bounds.
template <class Rate>
double worst(const FrameFormat& format, const FrameBounds& bounds, const Rate& rate) {
  double most = 0;
  for (unsigned ack = bounds.ack_min_clocks; ack <= bounds.ack_max_clocks; ++ack) {
    most = std::max(most, rate(transfer_of(format, bounds, ack)));
  }
  return most;
}

std::string row(const Named& named, bool cds0, const char* bounds_name, const FrameBounds& bounds) {
  const FrameFormat format = *parse_format(std::string(named.format) + (cds0 ? ";cds0" : ""));
  std::string text =
      std::string("| ") + named.name + " | " + (cds0 ? "yes" : "no") + " | " + bounds_name;
  for (const bool trusted : {false, true}) {
    const Rates rates(format, {.aligned_words = true, .trusted_only = trusted});
    text += " | " +
            number(worst(format, bounds, [&](const Transfer& t) { return rates.lost_start(t); }));
  }
  for (const lab::SlipModel model :
       {lab::SlipModel{.aligned_words = true},
        lab::SlipModel{.aligned_words = true, .tail_checked = true},
        lab::SlipModel{.aligned_words = true, .trusted_only = true, .tail_checked = true}}) {
    const Rates rates(format, model);
    text += " | " +
            number(worst(format, bounds, [&](const Transfer& t) { return rates.flipped_ack(t); }));
  }
  return text + " |";
}

TEST(LostStartDocument, Rates_AreTheComputedOnes) {
  std::vector<std::string> rows;
  for (const Named& named : formats) {
    for (const bool cds0 : {true, false}) {
      rows.push_back(row(named, cds0, "32…160", renishaw));
      rows.push_back(row(named, cds0, "1…400", widest));
    }
  }
  expect_rows("rates", rows);
}

TEST(LostStartDocument, Places_AreTheComputedOnes) {
  std::vector<std::string> rows;
  for (const Named& named : formats) {
    const FrameFormat format = *parse_format(std::string(named.format) + ";cds0");
    std::string text = std::string("| ") + named.name + " |";
    unsigned shown = 0;
    for (unsigned place = 1; place < format.payload_bits() + 2 && shown < 3; ++place) {
      const auto conditions =
          lab::slip_conditions(format, lab::lost_start(place), {.aligned_words = true});
      if (!conditions) continue;
      text += (shown++ == 0 ? " " : ", ") + std::to_string(place) + ": 2^-" +
              std::to_string(*conditions);
    }
    if (shown == 0) text += " none";
    text += " |";
    rows.push_back(text);
  }
  expect_rows("places", rows);
}

TEST(LostStartDocument, FixedAck_PassesNothing) {
  for (const Named& named : formats) {
    const FrameFormat format = *parse_format(named.format);
    const Rates rates(format, {.aligned_words = true});
    for (const std::uint16_t ack : std::array<std::uint16_t, 5>{1, 2, 4, 33, 160}) {
      const FrameBounds fixed{.lead_min_clocks = 2,
                              .lead_max_clocks = 10,
                              .ack_min_clocks = ack,
                              .ack_max_clocks = ack};
      EXPECT_EQ(rates.lost_start(transfer_of(format, fixed, ack)), 0);
      EXPECT_EQ(rates.flipped_ack(transfer_of(format, fixed, ack)), 0);
    }
  }
}

TEST(LostStartDocument, RenishawsBounds_AreThoseOfItsTiming) {
  const AckBounds ack =
      ack_bounds({.start_min = nanoseconds(3'225), .ack_max = microseconds(16)}, nanoseconds(100));
  EXPECT_EQ(ack.min_clocks, renishaw.ack_min_clocks);
  EXPECT_EQ(ack.max_clocks, renishaw.ack_max_clocks);
}

TEST(LostStartDocument, WorkedExample_IsWhatTheReaderSays) {
  const std::string text = document("docs/spi.md");
  const auto expect_said = [&](const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << words;
  };
  const FrameCodec<CrcFast, 1> codec(*parse_format("pos18,nE,nW,crc6;cds0"));
  const SpiSetup setup{.period = nanoseconds(100), .line_delay = {{}, picoseconds(242'500)}};
  const DeviceTiming timing{.start_min = nanoseconds(3'225),
                            .ack_max = microseconds(16),
                            .timeout = {TimeoutRule::cycle, nanoseconds(31'250)}};
  const SpiReader reader(codec, setup, timing);
  expect_said(std::to_string(reader.bounds().lead_min_clocks) + " to " +
              std::to_string(reader.bounds().lead_max_clocks) + " leading ones");
  expect_said(std::to_string(reader.clocks()) + " clocks");
  expect_said(std::to_string(reader.bytes()) + " bytes");

  Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = 4;
  frame.ack_clocks = 35;
  frame.channel_list[0].position = 0x12345;
  const auto bits = encode_frame(frame, codec);
  std::string shown;
  for (const std::uint8_t byte : bits->bytes()) {
    std::array<char, 8> hex{};
    std::snprintf(hex.data(), hex.size(), shown.empty() ? "%02X" : " %02X", byte);
    shown += hex.data();
  }
  expect_said(shown);
  const auto read = reader.read(bits->bytes());
  ASSERT_TRUE(read.ok());
  expect_said("`lead_clocks` is " + std::to_string(read->lead_clocks));
  const LineDelayRange delay = observed_line_delay(*read, setup);
  expect_said("between " + std::to_string(delay.min.count / 1000) + " and " +
              std::to_string(delay.max.count / 1000) + " ns");
  expect_said("`ack_clocks` is " + std::to_string(read->ack_clocks));
}

}  // namespace biss::test::spi::doc_test
