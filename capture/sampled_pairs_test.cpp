#include "capture/sampled_pairs.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/bit_scan.hpp"
#include "capture/dsl.hpp"
#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_samples.hpp"
#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::capture {
namespace sampled_pairs_test {

PairRead pair_of(const Read& read, wire::LineIndex ma, wire::LineIndex slo) {
  return pairs_of_edges(read, {.ma = ma, .slo = slo});
}
PairRead read_pairs(const Opened& opened, wire::LineIndex ma, wire::LineIndex slo,
                    std::size_t blocks = 0, std::size_t in_flight = 1) {
  return capture::read_pairs(opened, {ma, slo, blocks, in_flight});
}
void expect_same(const PairRead& pairs, const PairRead& edges) {
  EXPECT_EQ(difference(edges, pairs), "");
}

// Runs `work` with each kind of vectors that this processor has, and without any.
template <class Work>
void at_each_simd_level(Work work) {
  const std::int64_t all = hwy::SupportedTargets();
  for (const std::int64_t target :
       {std::int64_t{HWY_AVX3_DL}, std::int64_t{HWY_AVX3}, std::int64_t{HWY_AVX2},
        std::int64_t{HWY_SSE4}, std::int64_t{HWY_NEON}, std::int64_t{HWY_STATIC_TARGET}}) {
    if ((all & target) == 0 && target != HWY_STATIC_TARGET) continue;
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target | HWY_STATIC_TARGET);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    work();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

// Busy and resting stretches of two bits among others that change too.
std::string two_lines(std::mt19937_64& random, std::size_t unit, unsigned ma, unsigned slo,
                      std::size_t samples) {
  std::string bytes;
  std::uint64_t sample = random();
  const std::uint64_t pair = std::uint64_t{1} << ma | std::uint64_t{1} << slo;
  while (bytes.size() < samples * unit) {
    const bool busy = random() % 2 == 0;
    const std::uint64_t others = random() % 2 == 0 ? ~pair : 0;
    const std::size_t stretch = random() % 4 == 0 ? 1 + random() % 2'000 : 1 + random() % 80;
    const std::uint64_t faster = random() % 3 == 0 ? random() : ~std::uint64_t{0};
    for (std::size_t i = 0; i < stretch; ++i) {
      if (busy && random() % 3 == 0) sample ^= random() & random() & pair;
      if (busy && faster != ~std::uint64_t{0}) sample ^= std::uint64_t{1} << ma;
      sample ^= random() & others;
      for (std::size_t k = 0; k < unit; ++k) bytes += static_cast<char>(sample >> (8 * k));
    }
  }
  bytes.resize(samples * unit);
  return bytes;
}

RawLayout layout_of(Hertz rate, std::size_t unit, unsigned ma, unsigned slo) {
  return {rate, unit, {{"MA", ma}, {"SLO", slo}}};
}

PairRead pairs_of_raw(std::string_view bytes, const RawLayout& layout, std::size_t piece_bytes,
                      std::size_t blocks = 0, std::size_t in_flight = 1,
                      std::size_t block = one_block) {
  return read_pairs(open_raw(memory_bytes(bytes, block), layout, {.piece_bytes = piece_bytes}), 0,
                    1, blocks, in_flight);
}

TEST(BitScan, EachSimdLevel_FindsWhatThePlainScanFinds) {
  constexpr std::uint64_t seed = 13'101;
  std::printf("seed %" PRIu64 "\n", seed);
  at_each_simd_level([&] {
    std::mt19937_64 random(seed);
    for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
      for (int i = 0; i < 6; ++i) {
        const auto ma = static_cast<unsigned>(random() % (8 * unit));
        const auto slo = static_cast<unsigned>(random() % (8 * unit));
        const std::size_t count = i < 3 ? 4'096 : random() % 4'097;
        const std::string bytes = two_lines(random, unit, ma, slo, count + 1);
        std::vector<std::int64_t> times(4 * (4'096 + scan_slack));
        const auto scan_with = [&](void (*scan)(PairScan&), std::size_t room) {
          PairScan found{.samples = reinterpret_cast<const std::uint8_t*>(bytes.data()),
                         .count = count,
                         .unit_bytes = unit,
                         .ma_bit = ma,
                         .slo_bit = slo,
                         .ma_high = i % 2 == 0,
                         .slo_high = i % 3 == 0,
                         .time = 1'000'000'000'007,
                         .step = i == 4 ? 4'294'967'295U : 10'000U,
                         .ma = times.data() + room,
                         .slo = times.data() + room + 4'096 + scan_slack};
          scan(found);
          EXPECT_LE(found.ma, times.data() + room + count);
          return found;
        };
        const PairScan plain = scan_with(scan_pair_plain, 0);
        const PairScan fast = scan_with(scan_pair, 2 * (4'096 + scan_slack));
        const std::ptrdiff_t apart = 2 * (4'096 + scan_slack);
        ASSERT_EQ(fast.ma - plain.ma, apart) << unit;
        ASSERT_EQ(fast.slo - plain.slo, apart) << unit;
        ASSERT_TRUE(std::equal(times.data(), plain.ma, times.data() + apart)) << unit;
        ASSERT_TRUE(std::equal(times.data() + 4'096 + scan_slack, plain.slo,
                               times.data() + 4'096 + scan_slack + apart));
        ASSERT_EQ(fast.ma_high, plain.ma_high);
        ASSERT_EQ(fast.slo_high, plain.slo_high);
      }
    }
  });
}

TEST(Checksum, EachSimdLevelAndLength_IsThatOfLibdeflate) {
  std::mt19937_64 random(13'102);
  std::vector<std::uint8_t> bytes(5'000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  std::vector<std::uint32_t> wanted;
  // Bit by bit, as PKWARE's APPNOTE has it.
  std::uint32_t state = ~0U;
  for (const std::uint8_t byte : bytes) {
    wanted.push_back(~state);
    state ^= byte;
    for (int i = 0; i < 8; ++i) state = state >> 1U ^ ((state & 1U) != 0 ? 0xEDB8'8320U : 0U);
  }
  at_each_simd_level([&] {
    for (std::size_t i = 0; i < wanted.size(); i += i < 1'100 ? 1 : 97) {
      ASSERT_EQ(zip_checksum(std::span(bytes).first(i)), wanted[i]) << i;
      const std::size_t cut = random() % (i + 1);
      ASSERT_EQ(zip_checksum_after(wanted[cut], std::span(bytes).subspan(cut, i - cut)), wanted[i]);
    }
  });
}

TEST(SampleClock, TimesAfter_AreThoseOfEachSample) {
  std::mt19937_64 random = test::random_of(13'103);
  std::vector<std::int64_t> times(4'096);
  for (int i = 0; i < 600; ++i) {
    const std::uint32_t rates[] = {
        3'000'000,      24'000'000,
        48'000'000,     UINT32_MAX,
        UINT32_MAX - 1, 1U + static_cast<std::uint32_t>(random() >> (32U + random() % 32U))};
    const SampleClock clock(Hertz{rates[random() % 6]});
    const std::uint64_t first =
        i % 5 == 0 ? clock.last_index() - 4'095 : random() % (clock.last_index() - 4'095);
    for (std::size_t k = 0; k < times.size(); ++k) times[k] = static_cast<std::int64_t>(k);
    clock.times_after(first, times);
    for (std::size_t k = 0; k < times.size(); ++k) {
      ASSERT_EQ(times[k], clock.time_of(first + k).count) << clock.rate().count << ' ' << first;
    }
  }
}

TEST(SampledPairs, EveryUnitSizeAndBit_AgreesWithTheEdges) {
  std::mt19937_64 random = test::random_of(13'104);
  for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
    for (unsigned bit = 0; bit < 8 * unit; ++bit) {
      const auto other = static_cast<unsigned>((bit + 1 + random() % (8 * unit - 1)) % (8 * unit));
      const RawLayout layout = layout_of(megahertz(bit % 2 == 0 ? 100U : 48U), unit, bit, other);
      const std::string bytes = two_lines(random, unit, bit, other, 1 + random() % 3'000);
      const PairRead edges = pair_of(read_raw(bytes, layout), 0, 1);
      SCOPED_TRACE(testing::Message() << unit << " bytes, bit " << bit << " and " << other);
      expect_same(pairs_of_raw(bytes, layout, 1U << 20U), edges);
    }
  }
}

TEST(SampledPairs, EachSimdLevel_AgreesWithTheEdges) {
  std::mt19937_64 random(13'105);
  for (const std::size_t unit : {1U, 2U, 3U, 4U, 8U}) {
    const RawLayout layout = layout_of(megahertz(24), unit, 1, 6);
    const std::string bytes = two_lines(random, unit, 1, 6, 40'000);
    const PairRead edges = pair_of(read_raw(bytes, layout), 0, 1);
    at_each_simd_level([&] { expect_same(pairs_of_raw(bytes, layout, 50'000), edges); });
  }
}

TEST(SampledPairs, AnyPieceSizeAndStart_AgreesWithTheEdges) {
  std::mt19937_64 random = test::random_of(13'106);
  for (const std::size_t unit : {1U, 2U, 5U, 8U}) {
    const RawLayout layout =
        layout_of(Hertz{2U + static_cast<std::uint32_t>(random())}, unit, 0, 7);
    const std::string bytes =
        two_lines(random, unit, 0, 7, test::rounds(30'000, 10'000)) + std::string(unit - 1, 'x');
    const PairRead edges = pair_of(read_raw(bytes, layout), 0, 1);
    for (const std::size_t piece : {std::size_t{1}, std::size_t{64}, std::size_t{1'000},
                                    std::size_t{65'536}, std::size_t{64} << 20U}) {
      for (const std::size_t block : {std::size_t{777}, one_block}) {
        for (const std::size_t blocks : {0U, 1U, 3U, 20U, 100'000U}) {
          SCOPED_TRACE(testing::Message() << unit << " bytes, pieces of " << piece << " blocks of "
                                          << block << " after " << blocks);
          const PairRead pairs =
              pairs_of_raw(bytes, layout, piece, blocks, 1 + random() % 5, block);
          expect_same(pairs, edges);
        }
      }
    }
  }
}

TEST(SampledPairs, NothingOrNoWholeSample_EndsAsTheEdges) {
  const RawLayout layout = layout_of(megahertz(1), 3, 0, 1);
  for (const std::string_view bytes : {"", "\1", "\1\2"}) {
    expect_same(pairs_of_raw(bytes, layout, 64), pair_of(read_raw(bytes, layout), 0, 1));
  }
  EXPECT_EQ(pairs_of_raw("", layout, 64).error->cause, CaptureCause::empty);
  EXPECT_EQ(pairs_of_raw("\1\2", layout, 64).error->cause, CaptureCause::truncated);
}

TEST(SampledPairs, SamplesBeyondTheRange_EndAsTheEdges) {
  const std::size_t most = 9'223'373;
  for (const std::size_t unit : {1U, 2U}) {
    const RawLayout layout = layout_of(hertz(1), unit, 0, 1);
    for (const std::size_t more : {0U, 1U, 2U, 3U, 700U}) {
      std::string bytes(most * unit + more, '\1');
      bytes[bytes.size() - 1] = '\3';
      bytes[(most - 10) * unit] = '\2';
      for (const std::size_t piece : {std::size_t{1'000'000}, std::size_t{100'000'000}}) {
        SCOPED_TRACE(testing::Message() << unit << " bytes, " << more << " more");
        expect_same(pairs_of_raw(bytes, layout, piece), pair_of(read_raw(bytes, layout), 0, 1));
      }
    }
  }
}

TEST(SampledPairs, SamplesInMemory_APieceNamesTheBytesOfTheNextOnes) {
  const std::string bytes = "\1\1\2\2\3\3\1";
  const auto opened =
      open_raw(memory_bytes(bytes), layout_of(megahertz(1), 1, 0, 1), {.piece_bytes = 2});
  ASSERT_TRUE(opened);
  const auto pairs = (*opened)->pairs(0, 1);
  const auto piece = pairs->fetch(nullptr);
  const auto text = [&](std::size_t between) {
    const auto ahead = piece->ahead(between);
    return std::string(ahead.begin(), ahead.end());
  };
  EXPECT_EQ(text(0), "\2\2");
  EXPECT_EQ(text(1), "\3\3");
  EXPECT_EQ(text(2), "\1");
  EXPECT_EQ(text(3), "");
  EXPECT_EQ(text(1000), "");
}

// A reader that fails after some bytes.
TEST(SampledPairs, ReadErrors_ComeAfterTheSamples) {
  const RawLayout layout = layout_of(megahertz(1), 1, 0, 1);
  const CaptureError error{.cause = CaptureCause::read_failed};
  const std::string bytes = "\1\2\3\1\1\1\1";
  const auto open = [&] {
    return open_raw(limited_bytes(memory_bytes(bytes, 2), 5, error), layout, {.piece_bytes = 2});
  };
  const PairRead edges = pair_of(read_all(open()), 0, 1);
  EXPECT_EQ(edges.error->cause, CaptureCause::read_failed);
  expect_same(read_pairs(open(), 0, 1, 0, 4), edges);
}

std::string sr_of(std::mt19937_64& random, const RawLayout& layout, std::string_view bytes,
                  std::size_t most_chunk) {
  Members members{{"version", "2"}, {"metadata", sr_metadata_text(layout)}};
  for (std::size_t k = 1; !bytes.empty(); ++k) {
    const std::size_t size = std::min(bytes.size(), 1 + random() % most_chunk);
    members.emplace_back("logic-1-" + std::to_string(k), bytes.substr(0, size));
    bytes.remove_prefix(size);
  }
  return zip_of(members);
}

TEST(SrPairs, ChunksOfAnySize_AgreeWithTheEdges) {
  std::mt19937_64 random = test::random_of(13'107);
  for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
    const RawLayout layout = layout_of(megahertz(48), unit, 1, 4);
    const std::string bytes = two_lines(random, unit, 1, 4, 20'000);
    const std::string archive = sr_of(random, layout, bytes, unit % 2 == 0 ? 100'000 : 5'000);
    const PairRead edges = pair_of(read_sr(archive), 0, 1);
    for (const std::size_t blocks : {0U, 1U, 30U}) {
      SCOPED_TRACE(testing::Message() << unit << " bytes after " << blocks);
      expect_same(read_pairs(open_zip(memory_bytes(archive)), 0, 1, blocks, 3), edges);
    }
  }
}

TEST(SrPairs, AnyByteDamaged_EndsAsTheEdges) {
  std::mt19937_64 random(13'108);
  const RawLayout layout = layout_of(megahertz(100), 1, 0, 1);
  const std::string whole = sr_of(random, layout, two_lines(random, 1, 0, 1, 200), 90);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
    SCOPED_TRACE(at);
    for (const bool verify : {true, false}) {
      const SampleReading reading{.verify = verify};
      const PairRead edges = pair_of(read_all(open_zip(memory_bytes(damaged), reading)), 0, 1);
      expect_same(read_pairs(open_zip(memory_bytes(damaged), reading), 0, 1, 0, 2), edges);
    }
  }
}

TEST(SrPairs, WrongChecksum_IsDamagedUnlessNotVerified) {
  std::string archive = zip_of(session_of({"\3\3\2\2\3\1\1\3"}));
  const std::size_t entry = archive.rfind("PK\x01\x02");
  archive[entry + 16] = static_cast<char>(archive[entry + 16] ^ 1);
  const auto open = [&](bool no_verify) {
    return open_capture(memory_bytes(archive), "x.sr", {.no_verify = no_verify});
  };
  const PairRead verified = read_pairs(open(false), 0, 1);
  ASSERT_TRUE(verified.error);
  EXPECT_STREQ(verified.error->expected, "data with its checksum");
  EXPECT_EQ(verified.error->part_number, 1U);
  EXPECT_TRUE(verified.changes[0].empty());
  const PairRead not_verified = read_pairs(open(true), 0, 1);
  EXPECT_FALSE(not_verified.error);
  EXPECT_EQ(not_verified.changes[0].size(), 3U);
  expect_same(not_verified, pair_of(read_all(open(true)), 0, 1));
}

TEST(SrPairs, MemberLargerThanIsInflatedAtOnce_AgreesWithTheEdges) {
  std::mt19937_64 random(13'109);
  std::string bytes(40U * 1024U * 1024U, '\3');
  bytes.replace(35U * 1024U * 1024U, 100'000, two_lines(random, 1, 0, 1, 100'000));
  Members members = session_of({});
  members.emplace_back("logic-1", bytes);
  std::string archive = zip_of(members);
  for (int i = 0; i < 2; ++i) {
    const PairRead edges = pair_of(read_sr(archive), 0, 1);
    EXPECT_EQ(edges.error.has_value(), i == 1);
    expect_same(read_pairs(open_zip(memory_bytes(archive)), 0, 1, 2, 3), edges);
    const std::size_t entry = archive.rfind("PK\x01\x02");
    archive[entry + 16] = static_cast<char>(archive[entry + 16] ^ 1);
  }
  // Longer than it says: what it says it has are samples, whatever the size of the pieces.
  const std::size_t entry = archive.rfind("PK\x01\x02");
  archive[entry + 24] = '\x01';
  archive[entry + 26] = '\x34';
  const PairRead edges = pair_of(read_sr(archive), 0, 1);
  ASSERT_TRUE(edges.error);
  EXPECT_FALSE(edges.changes[0].empty());
  expect_same(read_pairs(open_zip(memory_bytes(archive)), 0, 1), edges);
}

// MA changes in every sample, SLO in seven of eight.
std::string noise(std::mt19937_64& random, std::size_t samples, unsigned ma, unsigned slo) {
  std::string bytes(samples, '\0');
  std::uint64_t drawn = 0;
  unsigned sample = 0;
  for (std::size_t i = 0; i < samples; ++i, drawn >>= 3U) {
    if (i % 16 == 0) drawn = random();
    sample ^= 1U << ma | ((drawn & 7U) != 0 ? 1U << slo : 0U);
    bytes[i] = static_cast<char>(sample);
  }
  return bytes;
}

// They have more changes than a piece takes as arrays.
constexpr std::size_t noisy_samples = most_changes / 8 * 5;

// Reads all as pairs. No piece takes more memory than its bound, and each edge is a change.
// Returns how many changes came as edges.
std::size_t edges_if_bounded(const Opened& opened, std::size_t blocks) {
  EXPECT_TRUE(opened);
  if (!opened) return 0;
  std::array<wire::Level, 2> levels{wire::Level::unknown, wire::Level::unknown};
  std::size_t edges = 0;
  const auto put = [&](std::span<const wire::Edge> some) {
    edges += some.size();
    for (const wire::Edge& edge : some) {
      EXPECT_NE(edge.level, levels[edge.line]);
      levels[edge.line] = edge.level;
    }
  };
  for (std::size_t i = 0; i < blocks; ++i) put((*opened)->next_block().value());
  const auto pairs = (*opened)->pairs(0, 1);
  std::unique_ptr<PairPiece> used;
  while (auto piece = pairs->fetch(std::move(used))) {
    piece->expand();
    EXPECT_LE(piece->ma.times.capacity() + piece->slo.times.capacity(), 2 * most_changes);
    if (pairs->settle(*piece, put)) {
      const auto level_after = [](const LineChanges& changes) {
        const bool high = changes.first_high == (changes.times.size() % 2 == 1);
        return high ? wire::Level::high : wire::Level::low;
      };
      levels = {level_after(piece->ma), level_after(piece->slo)};
    }
    used = std::move(piece);
  }
  return edges;
}

TEST(SampledPairs, MoreChangesThanAPieceTakes_AgreeWithTheEdgesInBoundedMemory) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::mt19937_64 random(13'113);
  const RawLayout layout = layout_of(megahertz(48), 1, 0, 1);
  const std::string calm = two_lines(random, 1, 0, 1, 200'000);
  const std::string bytes = calm + noise(random, 2 * noisy_samples, 0, 1) + calm;
  const PairRead edges = pair_of(read_raw(bytes, layout), 0, 1);
  expect_same(pairs_of_raw(bytes, layout, bytes.size() / 2, 0, 2), edges);
  EXPECT_GT(
      edges_if_bounded(open_raw(memory_bytes(bytes), layout, {.piece_bytes = bytes.size()}), 0),
      most_changes);
}

TEST(SrPairs, MoreChangesThanAPieceTakes_AgreeWithTheEdgesAndAreVerified) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::mt19937_64 random(13'114);
  const std::string bytes = noise(random, noisy_samples, 0, 1);
  std::string archive = zip_of(session_of({two_lines(random, 1, 0, 1, 5'000), bytes}));
  for (int i = 0; i < 2; ++i) {
    const PairRead edges = pair_of(read_sr(archive), 0, 1);
    EXPECT_EQ(edges.error.has_value(), i == 1);
    expect_same(read_pairs(open_zip(memory_bytes(archive)), 0, 1, 1), edges);
    const std::size_t entry = archive.rfind("PK\x01\x02");
    archive[entry + 16] = static_cast<char>(archive[entry + 16] ^ 1);
  }
}

std::string dsl_of(std::string_view samples, std::uint64_t said, const RawLayout& layout,
                   std::size_t block_bytes) {
  const std::string rest(4'096, samples[0]);
  Members members;
  std::uint64_t blocks = 0;
  for (const SampleLine& line : layout.lines) {
    std::string plane((samples.size() + 7) / 8, '\0');
    const auto is_high = [&](std::size_t i) {
      return (static_cast<unsigned char>(samples[i]) >> line.bit & 1) != 0;
    };
    for (std::size_t i = 0; i < samples.size(); ++i) {
      // Bit by bit a long rest would take seconds.
      if (i % rest.size() == 0 && samples.substr(i, rest.size()) == rest) {
        plane.replace(i / 8, rest.size() / 8, rest.size() / 8, is_high(i) ? '\xFF' : '\0');
        i += rest.size() - 1;
      } else {
        plane[i / 8] = static_cast<char>(plane[i / 8] | (is_high(i) ? 1 : 0) << i % 8);
      }
    }
    blocks = 0;
    for (std::size_t at = 0; at < plane.size(); at += block_bytes, ++blocks) {
      members.emplace_back("L-" + std::to_string(line.bit) + '/' + std::to_string(blocks),
                           plane.substr(at, block_bytes));
    }
  }
  std::string header =
      "[version]\nversion = 3\n[header]\ndevice mode = 0\ntotal samples = " + std::to_string(said) +
      "\ntotal blocks = " + std::to_string(blocks) +
      "\nsamplerate = " + std::to_string(layout.rate.count) + " Hz\n";
  for (const SampleLine& line : layout.lines) {
    header += "probe" + std::to_string(line.bit) + " = " + line.name + '\n';
  }
  members.emplace_back("header", header);
  return zip_of(members);
}

Opened opened_dsl(std::string_view archive) { return open_zip(memory_bytes(archive)); }

TEST(DslPairs, SamplesOfAnyNumber_AgreeWithTheEdges) {
  std::mt19937_64 random(13'110);
  const RawLayout layout{megahertz(48), 1, {{"MA", 2}, {"SLO", 5}, {"other", 6}}};
  for (const std::size_t count : {1U, 7U, 8U, 63U, 64U, 65U, 1'000U, 100'000U}) {
    const std::string samples = two_lines(random, 1, 2, 5, count);
    for (const std::uint64_t said : {count, count + 63, count + 100}) {
      const std::string archive = dsl_of(samples, said, layout, 1U << 21U);
      const PairRead edges = pair_of(read_all(opened_dsl(archive)), 0, 1);
      for (const std::size_t blocks : {0U, 1U, 2U, 5U, 10U, 100'000U}) {
        SCOPED_TRACE(testing::Message() << count << " of " << said << " after " << blocks);
        expect_same(read_pairs(opened_dsl(archive), 0, 1, blocks, 2), edges);
      }
    }
  }
}

TEST(DslPairs, AnyByteDamaged_EndsAsTheEdges) {
  std::mt19937_64 random(13'111);
  const RawLayout layout{megahertz(100), 1, {{"other", 0}, {"MA", 2}, {"SLO", 5}}};
  const std::string whole = dsl_of(two_lines(random, 1, 2, 5, 300), 300, layout, 1U << 21U);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
    SCOPED_TRACE(at);
    const Read read = read_all(opened_dsl(damaged));
    if (read.lines.size() != 3) continue;
    expect_same(read_pairs(opened_dsl(damaged), 1, 2, 0, 2), pair_of(read, 1, 2));
  }
}

// A piece of such a file has fewer samples than the arrays take changes.
TEST(DslPairs, ChangesInEverySample_AgreeWithTheEdgesInBoundedMemory) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::mt19937_64 random(13'115);
  const RawLayout layout{megahertz(24), 1, {{"MA", 2}, {"SLO", 5}}};
  const std::string samples = noise(random, noisy_samples + 37, 2, 5);
  const std::string archive = dsl_of(samples, samples.size(), layout, 1U << 21U);
  const PairRead edges = pair_of(read_all(opened_dsl(archive)), 0, 1);
  expect_same(read_pairs(opened_dsl(archive), 0, 1, 0), edges);
  EXPECT_LT(edges_if_bounded(opened_dsl(archive), 3), most_changes);
}

TEST(DslPairs, SeveralBlocksAndTimesBeyondTheRange_AgreeWithTheEdges) {
  constexpr std::size_t block_bytes = std::size_t{1} << 21U;
  std::mt19937_64 random(13'112);
  std::string samples(dsl_block_samples + 5'000, '\4');
  samples.replace(dsl_block_samples - 3'000, 6'000, two_lines(random, 1, 2, 5, 6'000));
  for (const std::uint32_t rate : {100'000'000U, 1U}) {
    for (const char last : {'\4', '\5'}) {
      std::string some = samples;
      if (rate == 1) some.replace(dsl_block_samples - 3'000, 8'000, 8'000, '\4');
      some.back() = last;
      const RawLayout layout{hertz(rate), 1, {{"MA", 2}, {"SLO", 5}, {"other", 0}}};
      const std::string archive = dsl_of(some, some.size(), layout, block_bytes);
      const PairRead edges = pair_of(read_all(opened_dsl(archive)), 0, 1);
      EXPECT_EQ(edges.error.has_value(), rate == 1 && last == '\5');
      for (const std::size_t blocks : {0U, 6U}) {
        SCOPED_TRACE(testing::Message() << rate << " Hz after " << blocks);
        expect_same(read_pairs(opened_dsl(archive), 0, 1, blocks, 2), edges);
      }
    }
  }
}

}  // namespace sampled_pairs_test
}  // namespace biss::capture
