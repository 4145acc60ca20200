#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/edge_pairs.hpp"
#include "capture/event_csv.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_pairs.hpp"
#include "capture/vcd.hpp"
#include "tests/common/long_run.hpp"

namespace biss::capture {
namespace text_pairs_test {

using Random = std::mt19937_64;

/// What a captured line of BiSS looks like: bursts of the clock, data some time after its edges.
struct Shape {
  std::size_t lines = 2;
  bool unknown = false;  ///< levels are unknown now and then
  std::int64_t start = 0;
  std::size_t bursts = 12;
};

std::vector<wire::Edge> edges_of(const Shape& shape, Random& random) {
  std::vector<wire::Edge> edges;
  std::vector<wire::Level> levels(shape.lines, wire::Level::high);
  const auto set = [&](std::int64_t time, std::size_t line, wire::Level level) {
    if (levels[line] == level) return;
    levels[line] = level;
    edges.push_back({Picoseconds{time}, static_cast<wire::LineIndex>(line), level});
  };
  std::int64_t now = shape.start;
  for (std::size_t line = 0; line < shape.lines; ++line) {
    edges.push_back({Picoseconds{now}, static_cast<wire::LineIndex>(line), wire::Level::high});
  }
  for (std::size_t burst = 0; burst < shape.bursts; ++burst) {
    now += 1'000'000 + static_cast<std::int64_t>(random() % 20'000'000);
    for (std::size_t clock = 0; clock < 40; ++clock) {
      set(now += 40'000 + static_cast<std::int64_t>(random() % 9'000), 0, wire::Level::low);
      if (random() % 8 == 0) set(now, 1, wire::Level::low);
      set(now += 51'000, 0, wire::Level::high);
      set(now += static_cast<std::int64_t>(random() % 9'000), 1,
          static_cast<wire::Level>(random() % 2));
      if (shape.lines > 2 && random() % 3 == 0) {
        set(now, 2 + random() % (shape.lines - 2), static_cast<wire::Level>(random() % 3));
      }
      if (shape.unknown && random() % 100 == 0) set(now, random() % 2, wire::Level::unknown);
    }
  }
  return edges;
}

std::vector<std::string> names_of(std::size_t lines) {
  std::vector<std::string> names{"MA", "SLO"};
  while (names.size() < lines) names.push_back("line" + std::to_string(names.size()));
  return names;
}

template <class Writer, class... Dialect>
std::string text_of(const Shape& shape, Random& random, Dialect... dialect) {
  std::string text;
  StringSink sink(text);
  Writer writer(names_of(shape.lines), sink, dialect...);
  const std::vector<wire::Edge> edges = edges_of(shape, random);
  EXPECT_EQ(*writer.write(edges), edges.size());
  EXPECT_TRUE(writer.finish(edges.back().time + microseconds(3)).ok());
  return text;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// Times of fewer digits, in a unit of which a picosecond is a small part.
std::string in_unit(std::string vcd, std::string_view unit, std::size_t digits_dropped) {
  vcd = replaced(std::move(vcd), "1ps", unit);
  std::string text;
  for (std::size_t at = 0; at < vcd.size();) {
    const std::size_t end = std::min(vcd.find('\n', at), vcd.size() - 1);
    std::string_view row = std::string_view(vcd).substr(at, end - at);
    if (row.starts_with('#')) row.remove_suffix(std::min(row.size() - 2, digits_dropped));
    text.append(row) += '\n';
    at = end + 1;
  }
  return text;
}

/// The body of a VCD, after its declarations.
std::size_t body_of(const std::string& vcd) {
  constexpr std::string_view last = "$enddefinitions $end\n";
  return vcd.find(last) + last.size();
}

std::string changed_body(std::string vcd, std::string_view from, std::string_view to) {
  const std::size_t body = body_of(vcd);
  return vcd.substr(0, body) + replaced(vcd.substr(body), from, to);
}

/// A few words at random places dropped, doubled, swapped or replaced.
std::string mutated(std::string text, std::string_view delimiters,
                    const std::vector<std::string_view>& words, Random& random) {
  for (std::size_t times = 1 + random() % 4; times > 0; --times) {
    const std::size_t at = random() % text.size();
    const std::size_t before = text.find_last_of(delimiters, at);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    const std::size_t end =
        std::max(first, std::min(text.find_first_of(delimiters, at), text.size()));
    const std::string word = text.substr(first, end - first);
    switch (random() % 5) {
      case 0:
        text.erase(first, word.size() + random() % 2);
        break;
      case 1:
        text.insert(random() % text.size(), word);
        break;
      case 2:
        if (!word.empty())
          text[first + random() % word.size()] = static_cast<char>('0' + random() % 10);
        break;
      case 3:
        text.resize(std::max(text.size() - random() % 40, text.size() / 2));
        break;
      default:
        text.replace(first, word.size(), words[random() % words.size()]);
    }
  }
  return text;
}

const std::vector<std::string_view> vcd_words{"$comment 1! #5 $end",
                                              "$comment",
                                              "$end",
                                              "$dumpoff",
                                              "$dumpvars",
                                              "x!",
                                              "z\"",
                                              "b0 !",
                                              "b1 \"",
                                              "b01 #",
                                              "b01 !",
                                              "r1.5 #",
                                              "1#",
                                              "0nobody",
                                              "#0",
                                              "#",
                                              "#99999999999999999999",
                                              "#9223372036854775807",
                                              "#00012",
                                              "H!",
                                              "l\"",
                                              "\n",
                                              "\r\n",
                                              "\t",
                                              " ",
                                              "b1",
                                              "x#",
                                              "$vcdclose x $end"};
const std::vector<std::string_view> csv_words{"x",
                                              "Z",
                                              "",
                                              "\"1\"",
                                              " 0 ",
                                              "2",
                                              "1.5e3",
                                              "-1e-9",
                                              "0.0005",
                                              "1e999",
                                              "-0",
                                              ",",
                                              ";",
                                              "\n",
                                              "\r\n",
                                              "# comment",
                                              "\n\n",
                                              "nan",
                                              "123456789012345678901",
                                              "1.",
                                              ".5",
                                              "+7",
                                              "\"",
                                              "99999999.5"};

struct Source {
  OpenText open;
  std::string text;
};

Source plain_source(std::size_t number, Random& random) {
  Shape shape;
  shape.lines = number % 4 == 3 ? 2 + random() % 120 : 2 + random() % 3;
  shape.unknown = number % 5 == 4;
  shape.bursts = 1 + random() % 10;
  if (number % 2 == 0) {
    std::string text = text_of<VcdWriter>(shape, random);
    switch (number / 2 % 6) {
      case 0:
        return {open_vcd, changed_body(std::move(text), "\n", "\r\n")};
      case 1:
        return {open_vcd, changed_body(std::move(text), "\n", " ")};
      case 2:
        return {open_vcd, in_unit(std::move(text), "100fs", 0)};
      case 3:
        return {open_vcd, in_unit(std::move(text), "10ns", 4)};
      default:
        return {open_vcd, text};
    }
  }
  const bool negative = number % 3 == 0;
  shape.start = negative ? -static_cast<std::int64_t>(random() % 90'000'000) : 0;
  const CsvDialect dialect = number % 4 == 1 ? CsvDialect::saleae : CsvDialect::nanoseconds;
  std::string text = text_of<EventCsvWriter>(shape, random, dialect);
  switch (number / 2 % 6) {
    case 0:
      return {open_csv, replaced(std::move(text), "\n", "\r\n")};
    case 1:
      return {open_csv, replaced(std::move(text), ",", ", ")};
    case 2:
      return {open_csv, replaced(replaced(std::move(text), ",", ";"), ".", ",")};
    default:
      return {open_csv, text};
  }
}

// In 3 of 4 captures words are wrong.
Source source_of(std::size_t number) {
  Random random(number);
  Source source = plain_source(number, random);
  if (number % 4 == 0) return source;
  const bool vcd = source.open == open_vcd;
  source.text = mutated(source.text, vcd ? " \n" : ",\n", vcd ? vcd_words : csv_words, random);
  return source;
}

// What was read as edges counts, though its end is known before it is settled.
TEST(TextPairs, ErrorIsMetWhileReadingEdges_EdgesBeforeItAreSettledFirst) {
  Random random(13);
  const std::vector<wire::Edge> edges = edges_of({.bursts = 800}, random);
  std::string text;
  StringSink sink(text);
  EventCsvWriter writer(names_of(2), sink);
  ASSERT_TRUE(writer.write(edges).ok());
  ASSERT_TRUE(writer.finish(edges.back().time).ok());
  text.resize(text.size() - 3);
  const Opened opened = open_event_csv(memory_bytes(text));
  ASSERT_TRUE(opened);
  std::vector<wire::Edge> read;
  for (;;) {
    const auto block = (*opened)->next_block();
    if (!block.ok()) break;
    read.insert(read.end(), block->begin(), block->end());
  }
  const std::size_t count = read.size();
  const auto pairs = pairs_of(std::move(read), **opened, 0, 1);
  std::size_t settled = 0;
  std::unique_ptr<PairPiece> piece;
  while (!pairs->error() && (piece = pairs->fetch(std::move(piece)))) {
    piece->expand();
    if (pairs->settle(*piece, nullptr)) settled += piece->ma.times.size() + piece->slo.times.size();
  }
  EXPECT_EQ(settled, count);
  ASSERT_TRUE(pairs->error());
  EXPECT_EQ(pairs->error()->cause, CaptureCause::truncated);
}

TEST(TextPairs, AnyPieceSize_GivesTheEdgesAndTheErrorOfBlocks) {
  const std::size_t captures = test::rounds(500, 18);
  std::size_t errors = 0;
  std::size_t regular = 0;
  std::size_t irregular = 0;
  for (std::size_t number = 0; number < captures; ++number) {
    const Source source = source_of(number);
    Random random(~number);
    const Read read = read_all(source.open(memory_bytes(source.text), default_piece_bytes));
    errors += read.error ? 1U : 0U;
    for (const std::size_t bytes : {64U, 300U, 5'000U, 1U << 20U, 64U << 20U}) {
      PairWay way{.blocks = random() % 4, .ahead = 1 + random() % 5};
      if (random() % 2 == 0) std::swap(way.ma, way.slo);
      const std::size_t block = random() % 2 == 0 ? one_block : 1 + random() % 3'000;
      const PairRead pairs = read_pairs(source.open(memory_bytes(source.text, block), bytes), way);
      if (read.lines.size() < 2 || !pairs.by_pieces) continue;
      regular += pairs.regular;
      irregular += pairs.whole - pairs.regular;
      ASSERT_EQ(difference(pairs_of_edges(read, way), pairs), "")
          << "capture " << number << ", pieces of " << bytes << ", blocks of " << block;
    }
  }
  EXPECT_GT(errors, captures / 4);
  EXPECT_LT(errors, captures / 4 * 3);
  EXPECT_GT(regular, irregular);
  EXPECT_GT(irregular, captures);
}

/// Reads text in small pieces; every whole piece has to be regular, and the result right.
void expect_regular(OpenText open, const std::string& text, std::string_view what) {
  const Read read = read_all(open(memory_bytes(text), default_piece_bytes));
  EXPECT_FALSE(read.error) << what;
  for (const std::size_t bytes : {100U, 1'000U, 1U << 20U}) {
    const PairRead pairs = read_pairs(open(memory_bytes(text), bytes), {});
    EXPECT_EQ(difference(pairs_of_edges(read, {}), pairs), "") << what;
    EXPECT_GT(pairs.whole, 0U) << what;
    EXPECT_EQ(pairs.regular, pairs.whole) << what << ", pieces of " << bytes;
  }
}

TEST(TextPairs, VcdOfKnownLevels_IsRegular) {
  Random random(1);
  const std::string text = text_of<VcdWriter>({.lines = 5, .bursts = 30}, random);
  expect_regular(open_vcd, text, "plain");
  expect_regular(open_vcd, changed_body(text, "\n", "\r\n"), "CRLF");
  expect_regular(open_vcd, changed_body(text, "\n", " "), "one line");
  expect_regular(open_vcd, changed_body(text, "\n", "\n\n"), "blank lines");
  for (const char* unit : {"1fs", "10fs", "100fs", "10ps"}) {
    expect_regular(open_vcd, in_unit(text, unit, 0), unit);
  }
  for (const char* unit : {"1ns", "100ns", "1us"})
    expect_regular(open_vcd, in_unit(text, unit, 3), unit);
  expect_regular(open_vcd, text_of<VcdWriter>({.lines = 300, .bursts = 30}, random), "300 lines");
}

TEST(TextPairs, VectorsRealsAndLongIdentifiers_AreRegular) {
  std::string text =
      "$timescale 1ns $end $var wire 1 abc MA $end $var wire 1 !! SLO $end $var wire 8 # pos $end "
      "$var real 64 $ v $end $var wire 1 abcdefghijk X $end $enddefinitions $end\n";
  for (int i = 0; i < 900; ++i) {
    text += '#' + std::to_string(i * 25) + "\n" + (i % 2 == 0 ? "0abc\n" : "b1 abc\n");
    if (i % 3 == 0) text += std::string(i % 2 == 0 ? "1" : "0") + "!!\n";
    if (i % 5 == 0)
      text +=
          "b10x" + std::to_string(i % 2) + " #\nxabcdefghijk\nr1.5e" + std::to_string(i) + " $\n";
  }
  expect_regular(open_vcd, text, "vectors");
}

TEST(TextPairs, EventCsvOfKnownLevels_IsRegular) {
  Random random(2);
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{-70'000'000}}) {
    const Shape shape{.start = start, .bursts = 30};
    const std::string text = text_of<EventCsvWriter>(shape, random);
    expect_regular(open_csv, text, "plain");
    expect_regular(open_csv, replaced(text, "\n", "\r\n"), "CRLF");
    expect_regular(open_csv, replaced(text, ",", ", "), "blanks");
    expect_regular(open_csv, replaced(text, "\n", "\n# a comment\n\n"), "comments");
    expect_regular(open_csv, replaced(replaced(text, ",", ";"), ".", ","), "decimal comma");
    expect_regular(open_csv, text_of<EventCsvWriter>(shape, random, CsvDialect::saleae), "saleae");
  }
  const Shape wide{.lines = 12, .bursts = 30};
  expect_regular(open_csv, text_of<EventCsvWriter>(wide, random), "wide");
}

TEST(TextPairs, TimesOfManyDecimals_AreRoundedLikeThoseOfBlocks) {
  std::string text = "Time [s], MA, SLO\n";
  Random random(3);
  for (std::uint64_t i = 0; i < 500; ++i) {
    const std::string fraction =
        std::to_string(1'000'000'000'000'000 + i * 1'500'000'000 + random() % 1'500'000);
    text += "0." + fraction.substr(1) + (i % 2 == 0 ? ", 0, 1\n" : ", 1, 1\n");
  }
  expect_regular(open_csv, text, "15 decimals");
}

/// The text, then the same word again and again.
class EndlessWord final : public ByteSource {
 public:
  EndlessWord(std::string text, std::uint64_t length) : text_(std::move(text)), left_(length) {}

  Result<std::size_t, CaptureError> read(std::span<char> into) override {
    const std::size_t head = std::min(text_.size(), into.size());
    if (head != 0) {
      std::copy_n(text_.begin(), head, into.begin());
      text_.erase(0, head);
      return head;
    }
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left_, into.size()));
    std::fill_n(into.begin(), count, 'w');
    left_ -= count;
    return count;
  }

 private:
  std::string text_;
  std::uint64_t left_;
};

TEST(TextPairs, CommentOfHundredMegabytes_NeedsTheMemoryOfAPiece) {
  const std::string text = vcd_of_ma_and_slo("#0 1! 1\" #5 0! $comment ");
  const auto open = [&] {
    return open_vcd(std::make_unique<EndlessWord>(text, 100'000'000), default_piece_bytes);
  };
  const PairRead pairs = read_pairs(open(), {});
  ASSERT_TRUE(pairs.error);
  EXPECT_EQ(pairs.error->cause, CaptureCause::truncated);
  EXPECT_LT(pairs.largest, 3 * default_piece_bytes);
  const Read read = read_all(open());
  EXPECT_EQ(difference(pairs_of_edges(read, {}), pairs), "");
}

TEST(TextPairs, ReadThatFails_DeliversWhatCameBeforeAndTheError) {
  const std::string text = vcd_of_ma_and_slo("#0 1! 1\"\n#5 0!\n#7 0\"\n#9 1");
  const CaptureError failed{.cause = CaptureCause::read_failed};
  for (const std::size_t bytes : {8U, 64U, 1'000U}) {
    const auto open = [&] { return open_vcd(prefixed_bytes(text, failed_bytes(failed)), bytes); };
    const PairRead pairs = read_pairs(open(), {});
    ASSERT_TRUE(pairs.error);
    EXPECT_EQ(pairs.error->cause, CaptureCause::read_failed);
    EXPECT_EQ(pairs.changes[0].size(), 2U);
    const Read read = read_all(open());
    EXPECT_EQ(difference(pairs_of_edges(read, {}), pairs), "");
  }
}

TEST(TextPairs, LinesThatChangeTogether_AreReadAsEdges) {
  const std::string text =
      "$timescale 1ps $end $var wire 1 ! MA $end $var wire 1 ! SLO $end $enddefinitions $end #0 "
      "1!\n";
  EXPECT_FALSE(read_pairs(open_vcd(memory_bytes(text)), {}).by_pieces);
  EXPECT_FALSE(
      read_pairs(open_event_csv(memory_bytes("time_ns,MA,SLO\n0,1,1\n")), {.ma = 1, .slo = 1})
          .by_pieces);
}

}  // namespace text_pairs_test
}  // namespace biss::capture
