// Every reader of captures on hostile files. The name of the program, biss_fuzz_TARGET, selects a row
// of the table at the end. README.md lists the checks of each target.
#include <bit>
#include <iterator>
#include <limits>
#include <memory>

#include "capture/compressed.hpp"
#include "capture/fst.hpp"
#include "capture/little_endian.hpp"
#include "capture/merge.hpp"
#include "capture/sampled_csv.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_pairs.hpp"
#include "capture/test_samples.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/fst_mutator.hpp"
#include "fuzz/mutate.hpp"
#include "fuzz/zip_mutator.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using capture::memory_bytes;

// ---- Text

constexpr std::string_view vcd_words =
    "$timescale 1fs $end|$timescale 100 us $end|$var wire 1 ! MA $end|$var wire 1 abc SLO $end|"
    "$var wire 8 ## pos [7:0] $end|$var real 64 $$ v $end|$scope module top $end|$upscope $end|"
    "$enddefinitions $end|$dumpvars|$dumpoff|$end|$comment x # 1! "
    "$end|$comment|0!|1!|0\"|1\"|x!|Z\"|"
    "b0 !|b1 \"|b1010 ##|r1.5 $$|0abc|#0|#9223372036854775807|#18446744073709551615|#|"
    "#99999999999999999999|\n| |b1|#00000000000000000012|1|\r\n|\t";
constexpr std::string_view csv_words =
    "1.0|0.0|+1|255|nan|\r|time|time_s|Time [us]|time(ps)|\"MA\"|SLO|0|1|x|Z||\"1\"| 0 "
    "|1.5e3|-1e-9|"
    "0.0005|9223372036854|1e999|-0|,|;|\t|\n|\r\n|# "
    "comment\n|\n\n|nan|123456789012345678901|2|-5.25|+7|"
    ".5|5.|0.1234567890123456";
constexpr std::string_view saleae_words =
    "Time [s]|Time[s]|Channel 0|MA|\"SLO\"|0|1|X||-0.000001|2e-08|9223372.036855|1e9|0.5|,|\r\n| 1 "
    "|nan";
constexpr std::string_view sampled_words =
    "X|CH1|CH2|Start|Increment|Sequence|Volt|Second|2e-08|x-axis|second|Model|TIME|Time|Time(s)|("
    "ms)|"
    "(mV)|CH1(V)|t0 = -1e-05s|tInc = 1e-08s|Source|Segments,2|LECROY|Record Length|; CSV|logic|V "
    "DC|"
    "; Samplerate: 3 MHz|nan|inf|-\xE2\x88\x9E|9.9E+37||3.3|-0.05|1.65|1e999|\r\n|\n\n|A0: 1 V "
    "DC\n";
constexpr std::string_view compressed_words =
    "#0|#18446744073709551615|0!|1!|x!|$dumpoff|$end|$comment|time_ns,MA,SLO|0,1,1|-1,0,x|\n|1,,|"
    "1e3,1,0";

std::string change_vcd(std::string text, SplitMix& random) {
  return TokenMutator(std::move(text), " \n", vcd_words, random).mutate();
}

std::string change_csv(std::string text, SplitMix& random) {
  return TokenMutator(std::move(text), ",\n", csv_words, random).mutate();
}

void check_vcd(std::string_view text) {
  check_reader(text, [](auto bytes) { return capture::open_vcd(std::move(bytes)); });
}

void check_event_csv(std::string_view text) {
  const capture::EventCsvRows rows = capture::event_csv_rows(text);
  check_reader(text, [&rows](auto bytes) {
    return capture::open_event_csv(std::move(bytes), capture::default_piece_bytes, rows);
  });
}

// Rows of Saleae have a level for every line, X before the first change.
std::vector<wire::Edge> known_edges(const Read& read) {
  std::vector<wire::Edge> known;
  known.reserve(read.edges.size());
  std::vector<bool> began(read.lines.size());
  for (const wire::Edge& edge : read.edges) {
    if (edge.level != wire::Level::unknown) began[edge.line] = true;
    if (began[edge.line]) known.push_back(edge);
  }
  return known;
}

void check_saleae_again(const Read& read) {
  if (read.lines.empty()) return;
  std::string written;
  capture::StringSink sink(written);
  capture::EventCsvWriter writer(read.lines, sink, capture::CsvDialect::saleae);
  require(writer.write(read.edges).ok() && writer.finish(read.end).ok());
  const Read back = read_checked(capture::open_event_csv(capture::memory_bytes(written)));
  require(back.lines.size() == read.lines.size());
  require(known_edges(back) == known_edges(read));
}

void check_saleae(std::string_view text) {
  check_saleae_again(
      check_reader(text, [](auto bytes) { return capture::open_event_csv(std::move(bytes)); }));
}

std::string change_saleae(std::string text, SplitMix& random) {
  return TokenMutator(std::move(text), ",\n", saleae_words, random).mutate();
}

void check_sampled_csv(std::string_view text) {
  using capture::Likeness;
  capture::OpenOptions options;
  // Some with a threshold, some with a differential.
  if (text.size() % 8 == 1) options.analog.threshold = {millivolts(1'700), millivolts(200)};
  if (text.size() % 16 == 2) options.analog.differentials = {{"CH1-CH2", "MA"}};
  check_reader(
      text, [&](auto bytes) { return capture::open_capture(std::move(bytes), "x.csv", options); });
  // The likeness of the beginning does not change when more is seen.
  std::optional<Likeness> likeness;
  for (std::size_t end = text.size() < 512 ? 1 : text.size(); end < text.size();
       end += 1 + end / 8) {
    const Likeness now = capture::looks_like_sampled_csv(text.substr(0, end), false);
    require(!likeness || *likeness == Likeness::not_yet || now == *likeness);
    likeness = now;
  }
}

std::string change_sampled_csv(std::string text, SplitMix& random) {
  // Each change of the grid ends the capture: mostly one, so that enough inputs have a cycle.
  return TokenMutator(std::move(text), ",;\n", sampled_words, random)
      .mutate(random() % 4 == 0 ? 3 : 1);
}

// ---- Text that is compressed

// What can be decompressed, up to 64 KiB.
std::string text_of(std::string_view bytes) {
  constexpr std::size_t most_bytes = 65'536;
  const auto compression = capture::compression_of(bytes);
  if (compression == capture::Compression::none) return {};
  const auto source = capture::decompressed(capture::memory_bytes(bytes), compression);
  std::string text;
  std::array<char, 4'096> block{};
  while (text.size() < most_bytes) {
    const auto got = source->read(block);
    if (!got.ok() || *got == 0) break;
    text.append(block.data(), *got);
  }
  return text;
}

void damage_bytes(std::string& bytes, SplitMix& random) {
  const std::size_t at = random() % bytes.size();
  switch (random() % 4) {
    case 0:
      bytes.resize(at + 1);
      return;
    case 1:
      bytes.erase(at, 1 + random() % 8);
      return;
    case 2:
      bytes.insert(at, 1 + random() % 8, static_cast<char>(random() % 3));
      return;
    default:
      bytes[at] ^= static_cast<char>(1U << random() % 8);
  }
}

void check_compressed(std::string_view bytes) {
  check_reader(bytes,
               [](auto source) { return capture::open_capture(std::move(source), "x.vcd.gz"); });
}

std::string change_compressed(std::string bytes, SplitMix& random) {
  if (random() % 8 != 0) {
    constexpr std::size_t smallest_capture = 64;
    std::string text = text_of(bytes);
    if (text.size() < smallest_capture) text = text_seed(random());
    text = TokenMutator(std::move(text), " ,\n", compressed_words, random).mutate();
    bytes = compressed_in_parts(text, random);
    if (random() % 16 != 0) return bytes;
  }
  damage_bytes(bytes, random);
  return bytes;
}

// ---- Two files of Saleae Logic

using TwoFiles = std::array<std::string_view, 2>;

// Both are empty if the input has no size of the first.
TwoFiles split_files(std::string_view input) {
  if (input.size() < first_size_bytes) return {};
  const auto size = static_cast<std::size_t>(capture::get_number(input.data(), first_size_bytes));
  input.remove_prefix(first_size_bytes);
  const std::size_t first = std::min(size, input.size());
  return {input.substr(0, first), input.substr(first)};
}

// Reads both files as one capture of the lines MA and SLO; the first alone if the second cannot be
// opened. \param open opens the bytes of a file
template <class Open>
void check_files(std::string_view input, Open open) {
  const TwoFiles files = split_files(input);
  check_blocks(input, [&](std::size_t block) -> capture::Opened {
    std::vector<capture::NamedSource> sources;
    auto first = open(memory_bytes(files[0], block));
    if (!first) return first;
    sources.push_back({std::move(*first), "MA"});
    auto second = open(memory_bytes(files[1], block));
    if (second) sources.push_back({std::move(*second), "SLO"});
    require(second || !capture::capture_error_text(second.error(), "x").empty());
    return std::make_unique<capture::MergedSource>(std::move(sources));
  });
}

void check_saleae_analog(std::string_view input) {
  check_files(input, [](auto bytes) { return open_saleae_binary(std::move(bytes), "analog"); });
}

void overwrite(std::string& bytes, std::size_t at, std::uint64_t value, std::size_t count) {
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<char>(value >> (8 * i));
  }
}

// Changes a sample, a field of a header, or a few samples more or less.
void change_analog_once(std::string& bytes, SplitMix& random) {
  const std::size_t at = random() % bytes.size();
  static constexpr float volts[] = {0.1F, 3.4F, 1.7F, -5.0F, 1e30F, -1e30F, 0.0F};
  static constexpr std::uint64_t fields[] = {0, 1, 2, 100, 1ULL << 63, 1'000, ~std::uint64_t{0}};
  switch (random() % 8) {
    case 0:
      return overwrite(bytes, 12 + random() % 56 / 8 * 8, fields[random() % std::size(fields)], 8);
    case 1:
      bytes.erase(at, 4 * (random() % 8));
      return;
    case 2:
      bytes.insert(at, bytes.substr(at, 4 * (random() % 8)));
      return;
    case 3:
      return overwrite(bytes, at, random(), 1 + random() % 8);
    default: {
      // Samples begin at a multiple of four in each version.
      const std::size_t sample = at / 4 * 4;
      const auto bits = std::bit_cast<std::uint32_t>(volts[random() % std::size(volts)]);
      const std::size_t run = 1 + random() % 4;
      for (std::size_t i = 0; i < run; ++i) overwrite(bytes, sample + 4 * i, bits, 4);
    }
  }
}

void check_saleae_binary(std::string_view input) {
  check_files(input, [](auto bytes) { return open_saleae_binary(std::move(bytes), "line"); });
}

void replace_double(std::string& text, std::size_t at, double value) {
  std::string bytes;
  capture::put_double(bytes, value);
  text.replace(at, bytes.size(), bytes);
}

// A number of a file: most are times. Chunks begin at multiples of four bytes.
std::size_t number_place(const std::string& input, SplitMix& random) {
  constexpr std::size_t header_bytes = 16;
  const std::size_t first =
      first_size_bytes + (random() % 2 == 0 ? 0 : split_files(input)[0].size());
  const std::size_t begin = std::min(first + header_bytes, input.size() - 8);
  return begin + 4 * (random() % ((input.size() - 8 - begin) / 4 + 1));
}

void change_binary_once(std::string& input, SplitMix& random) {
  using Limits = std::numeric_limits<double>;
  static constexpr std::array specials{Limits::quiet_NaN(),
                                       Limits::infinity(),
                                       -Limits::infinity(),
                                       Limits::max(),
                                       -0.0,
                                       0.0,
                                       Limits::denorm_min(),
                                       -1e-6,
                                       9'223'372.0,
                                       1e8};
  const std::size_t at = number_place(input, random);
  switch (random() % 8) {
    case 0:
      return replace_double(input, at, specials[random() % specials.size()]);
    case 1:
      input[at] = static_cast<char>(random() % 4);
      return;
    case 2:
      // Version or type of the first file, or the size of it.
      input[random() % 20] = static_cast<char>(random() % 3);
      return;
    default:
      // A little earlier or later: mostly still in order.
      const double step = static_cast<double>(random() % 200) * 1e-9 - 100e-9;
      return replace_double(input, at, capture::get_double(input.data() + at) + step);
  }
}

std::string change_saleae_analog(std::string input, SplitMix& random) {
  // Mostly one change, so that enough inputs have a cycle.
  const std::uint64_t most = random() % 4 == 0 ? 3 : 1;
  for (std::uint64_t i = random() % most + 1; i > 0 && !input.empty(); --i) {
    change_analog_once(input, random);
  }
  return input;
}

std::string change_saleae_binary(std::string input, SplitMix& random) {
  for (std::uint64_t i = random() % 3 + 1; i > 0; --i) change_binary_once(input, random);
  if (random() % 16 == 0) input.resize(input.size() - random() % 40);
  return input;
}

// ---- Samples

// The layout of a header, which may be invalid. \pre header.size() >= raw_header_bytes
capture::RawLayout raw_layout(std::string_view header) {
  const auto byte = [header](std::size_t i) { return static_cast<std::uint8_t>(header[i]); };
  capture::RawLayout layout;
  for (std::size_t i = 0; i < 4; ++i) layout.rate.count |= std::uint32_t{byte(i)} << (8 * i);
  layout.unit_bytes = byte(4);
  // Two names are those of BiSS lines, and some occur twice.
  constexpr std::string_view names[] = {"MA", "SLO", "a", "b", "a", "SLO", "", "c"};
  const std::size_t lines = std::min<std::size_t>(byte(5), std::size(names));
  for (std::size_t i = 0; i < lines; ++i) {
    layout.lines.push_back({std::string(names[i]), byte(6 + i)});
  }
  return layout;
}

bool can_be(const capture::RawLayout& layout) {
  std::vector<bool> used(256);
  for (const auto& line : layout.lines) {
    if (line.bit >= 8 * layout.unit_bytes || used[line.bit]) return false;
    used[line.bit] = true;
  }
  return layout.rate.count != 0 && layout.unit_bytes >= 1 && layout.unit_bytes <= 8 &&
         !layout.lines.empty();
}

void check_raw(std::string_view input) {
  if (input.size() < raw_header_bytes) return;
  const capture::RawLayout layout = raw_layout(input);
  const std::string_view samples = input.substr(raw_header_bytes);
  const auto read = check_reader(samples, [&](auto bytes) {
    return capture::open_capture(std::move(bytes), "x.raw", {.raw = layout});
  });
  // A binary export of Saleae Logic is not raw samples, whatever its name.
  if (samples.starts_with("<SALEAE>")) return;
  require(read.lines.size() == (can_be(layout) ? layout.lines.size() : 0));
  if (can_be(layout)) require(read.edges == plain_edges(layout, samples));
}

// Damages the layout, or adds or removes a sample, so that a change comes earlier or later.
std::string change_raw(std::string input, SplitMix& random) {
  const std::size_t samples = input.size() - raw_header_bytes;
  const std::size_t at = raw_header_bytes + random() % samples;
  switch (random() % 4) {
    case 0:
      input[random() % raw_header_bytes] ^= static_cast<char>(1U << random() % 8);
      break;
    case 1:
      input.insert(at, 1 + random() % 4, input[at]);
      break;
    case 2:
      if (samples > 8) input.erase(at, 1 + random() % 4);
      break;
    default:
      input[at] ^= static_cast<char>(1U << random() % 8);
  }
  return input;
}

void check_sr(std::string_view archive) {
  check_reader(archive, [](auto bytes) { return capture::open_zip(std::move(bytes)); });
}

std::string change_sr(std::string archive, SplitMix& random) {
  return ZipMutator(sr_kind, random).mutate(std::move(archive));
}

void check_dsl(std::string_view archive) {
  check_reader(archive, [](auto bytes) { return capture::open_zip(std::move(bytes)); });
}

std::string change_dsl(std::string archive, SplitMix& random) {
  return ZipMutator(dsl_kind, random).mutate(std::move(archive));
}

void check_fst(std::string_view file) { check_reader(file, capture::open_fst); }

std::string change_fst(std::string file, SplitMix& random) {
  return FstMutator(random).mutate(file);
}

// ---- Captures as changes of two lines, in pieces of any size

// Reads two lines both ways: pieces give the changes, the end and the error of the edges.
template <class Open>
void check_pairs(const capture::Read& read, Open open, SplitMix& random, bool always_by_pieces) {
  const auto any_line = [&] { return static_cast<wire::LineIndex>(random() % read.lines.size()); };
  const capture::PairWay way{
      .ma = any_line(), .slo = any_line(), .blocks = random() % 4, .ahead = 1 + random() % 4};
  const capture::PairRead pairs = read_pairs(open(), way);
  require(pairs.by_pieces || !always_by_pieces);
  if (pairs.by_pieces) require(difference(pairs_of_edges(read, way), pairs).empty());
}

bool is_vcd(std::string_view text) { return text.starts_with('$'); }

void check_pairs_text(std::string_view text) {
  using namespace biss::capture;
  const EventCsvRows rows = event_csv_rows(text);
  const auto open = [&](std::size_t block, std::size_t piece) {
    return is_vcd(text) ? open_vcd(memory_bytes(text, block), piece)
                        : open_event_csv(memory_bytes(text, block), piece, rows);
  };
  const capture::Read read = read_all(open(default_piece_bytes, default_piece_bytes));
  if (read.lines.size() < 2) return;
  SplitMix random{mixed_from(text)};
  for (int i = 0; i < 2; ++i) {
    const std::size_t block = random() % 2 == 0 ? 1 + random() % 700 : one_block;
    const std::size_t piece = random() % 4 == 0 ? default_piece_bytes : 1 + random() % 700;
    check_pairs(
        read, [&] { return open(block, piece); }, random, false);
  }
}

std::string change_pairs_text(std::string text, SplitMix& random) {
  return (is_vcd(text) ? change_vcd : change_csv)(std::move(text), random);
}

void check_pairs_samples(std::string_view input) {
  constexpr std::array<std::size_t, 8> piece_sizes{1,   7,     64,     100,
                                                   512, 1'000, 10'000, std::size_t{64} << 20U};
  SplitMix random{mixed_from(input)};
  capture::OpenOptions options;
  options.piece_bytes = piece_sizes[random() % piece_sizes.size()];
  options.no_verify = random() % 4 == 0;
  const bool zip = input.starts_with("PK");
  std::size_t block = capture::one_block;
  if (!zip) {
    if (input.size() < raw_header_bytes) return;
    options.raw = raw_layout(input);
    block = block_size_of(input);
    input.remove_prefix(raw_header_bytes);
    // A binary export of Saleae Logic is not raw samples, whatever its name.
    if (input.starts_with("<SALEAE>")) return;
  }
  const auto open = [&] {
    return capture::open_capture(memory_bytes(input, block), zip ? "x.sr" : "x.raw", options);
  };
  const capture::Read read = capture::read_all(open());
  if (!read.lines.empty()) check_pairs(read, open, random, true);
}

std::string change_pairs_samples(std::string input, SplitMix& random) {
  if (!input.starts_with("PK")) return change_raw(std::move(input), random);
  const bool is_dsl = input.find("metadata") == std::string::npos;
  return (is_dsl ? change_dsl : change_sr)(std::move(input), random);
}

// ----

struct Target {
  std::string_view name;
  void (*check)(std::string_view input);
  std::string (*change)(std::string input, SplitMix& random);
  /// Without its end, an input cannot be read.
  bool whole = false;
};

constexpr Target targets[] = {
    {"vcd", check_vcd, change_vcd},
    {"event_csv", check_event_csv, change_csv},
    {"saleae", check_saleae, change_saleae},
    {"sampled_csv", check_sampled_csv, change_sampled_csv},
    {"compressed", check_compressed, change_compressed, true},
    {"saleae_analog", check_saleae_analog, change_saleae_analog},
    {"saleae_binary", check_saleae_binary, change_saleae_binary},
    {"raw", check_raw, change_raw},
    {"sr", check_sr, change_sr, true},
    {"dsl", check_dsl, change_dsl, true},
    {"fst", check_fst, change_fst, true},
    {"pairs_text", check_pairs_text, change_pairs_text},
    {"pairs_samples", check_pairs_samples, change_pairs_samples, true},
};

const Target* target = nullptr;
const CaptureSeed* seeds = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** argv) {
  const std::string_view program = (*argv)[0];
  const std::string_view name = program.substr(program.rfind("biss_fuzz_") + 10);
  target = std::find_if(std::begin(targets), std::end(targets),
                        [&](const Target& each) { return each.name == name; });
  seeds = std::find_if(std::begin(capture_seeds), std::end(capture_seeds),
                       [&](const CaptureSeed& each) { return each.target == name; });
  require(target != std::end(targets) && seeds != std::end(capture_seeds));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target->check({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return mutate_input({data, max_size}, size, seed, seeds->make, target->change, target->whole);
}
