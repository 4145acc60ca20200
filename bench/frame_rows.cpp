// Decoding frames from SPI buffers, and encoding frames.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "bench/pool.hpp"
#include "bench/rows.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"

namespace biss::bench {

namespace {

constexpr const char* text_22 = "pos22,nE,nW,crc6";
constexpr const char* text_36 = "pos36,nE,nW,crc6";
constexpr const char* text_safety = "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0";

template <class Codec>
Codec hidden_codec(const char* text) {
  Codec codec(parse_format(text).value());
  benchmark::DoNotOptimize(codec);
  return codec;
}

// The values that a user reads of each channel: the position, and whether it may be used.
std::uint64_t used(const Channel& channel) {
  return channel.position * 2U + std::uint64_t{channel.nE};
}

template <std::size_t Looked, class Frame>
std::uint64_t used(const Frame& frame) {
  std::uint64_t sum = 0;
  for (std::size_t k = 0; k < Looked; ++k) sum = sum * 3U + used(frame.channel_list[k]);
  return sum;
}

// `decode(i)` decodes buffer i. All results are checked once, so that only right results are timed.
template <std::size_t Looked, class Decode>
void run(benchmark::State& state, const Pool& pool, Decode decode) {
  for (std::size_t i = 0; i < pool_size; ++i) {
    if (decode(i) != used<Looked>(pool.frame(i))) return state.SkipWithError("a wrong position");
  }
  measure(state, pool_size, decode);
}

template <class Crc, std::size_t Channels, std::size_t Looked = Channels>
void search(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<FrameCodec<Crc, Channels>>(text);
  const Pool pool(text);
  run<Looked>(state, pool, [&codec, buffers = pool.buffers()](std::size_t i) {
    const auto frame = decode_frame(BitView(buffers[i]), codec);
    return frame.ok() ? used<Looked>(*frame) : ~std::uint64_t{0};
  });
}

SpiSetup spi_setup() {
  return {.period = period_of(megahertz(10)), .line_delay = {.max = nanoseconds(700)}};
}

DeviceTiming spi_timing() {
  DeviceTiming timing;
  timing.ack_max = microseconds(16);
  return timing;
}

template <class Crc, std::size_t Channels>
void spi(benchmark::State& state, const char* text) {
  using Codec = FrameCodec<Crc, Channels>;
  SpiReader<Codec> reader(hidden_codec<Codec>(text), spi_setup(), spi_timing());
  benchmark::DoNotOptimize(reader);
  const Pool pool(text);
  run<Channels>(state, pool, [&reader, buffers = pool.buffers()](std::size_t i) {
    const auto frame = reader.read(buffers[i]);
    return frame.ok() ? used<Channels>(*frame) : ~std::uint64_t{0};
  });
}

constexpr FrameFormat format_22 = parse_format(text_22).value();

// The same search with the format as a compile-time constant.
void search_fixed(benchmark::State& state) {
  const Pool pool(text_22);
  run<1>(state, pool, [buffers = pool.buffers()](std::size_t i) {
    const auto frame = decode_frame(BitView(buffers[i]), FixedCodec<format_22>{});
    return frame.ok() ? used<1>(*frame) : ~std::uint64_t{0};
  });
}

constexpr FrameFormat fixed_format = parse_format("pos24,nE,nW,crc6").value();

template <class Crc>
void fixed(benchmark::State& state) {
  using Encoder = FixedChannel<fixed_format.channel_list[0], Crc>;
  const Pool pool("pos24,nE,nW,crc6");
  std::vector<std::uint64_t> words;
  for (std::size_t i = 0; i < pool_size; ++i) {
    words.push_back(Encoder::encode(pool.frame(i).channel_list[0]));
  }
  run<1>(state, pool, [&](std::size_t i) {
    const auto channel = Encoder::decode(words[i]);
    return channel.ok() ? used(*channel) : ~std::uint64_t{0};
  });
}

template <class Crc>
void encode(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<FrameCodec<Crc>>(text);
  const Pool pool(text);
  measure(state, pool_size, [&](std::size_t i) {
    const auto line = encode_frame(pool.frame(i), codec);
    return std::uint64_t{line->bytes().back()} ^ line->size_bits();
  });
}

void unpack_words(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<FrameCodec<>>(text);
  const Pool pool(text);
  const ChannelFormat& format = codec.format().channel_list[0];
  std::vector<std::uint64_t> words;
  for (std::size_t i = 0; i < pool_size; ++i) {
    words.push_back(pack(format, pool.frame(i).channel_list[0]));
  }
  run<1>(state, pool, [&](std::size_t i) { return used(unpack(format, words[i])); });
}

// ---- A decoder of the shortest kind, for comparison: one load, no bound, no cause

constexpr auto crc6_table = [] {
  std::array<std::uint8_t, 64> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    table[i] = static_cast<std::uint8_t>(crc_detail::remainder(crc6, i, 6, 0));
  }
  return table;
}();

// Two leading ones, ACK, START, CDS, position, nE, nW, CRC6, all within the first 8 bytes.
template <unsigned PositionBits>
std::uint64_t decode_plainly(const std::uint8_t* bytes) {
  static_assert(std::endian::native == std::endian::little);
  constexpr unsigned data_bits = PositionBits + 2;
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  word = __builtin_bswap64(word);
  word = word << std::countl_zero(word) << 2U;
  word = word << std::countl_zero(word) << 2U;
  const std::uint64_t data = word >> (64U - data_bits);
  const auto crc = static_cast<unsigned>(word << data_bits >> 58U);
  unsigned sum = 0;
#pragma GCC unroll 8
  for (unsigned k = 0; k < (data_bits + 5) / 6; ++k) {
    const unsigned shift = (data_bits + 5) / 6 * 6 - 6 * (k + 1);
    sum = crc6_table[sum ^ ((data >> shift) & 63U)];
  }
  if ((sum ^ 63U) != crc) return ~std::uint64_t{0};
  return data >> 2U << 1U | (data >> 1U & 1U);
}

constexpr std::uint16_t lead_of_plain = 2;

// The longest ACK, up to 24 clocks, that leaves room for the frame in this number of bytes.
constexpr std::uint16_t longest_ack(unsigned position_bits, std::size_t bytes) {
  const auto room = static_cast<unsigned>(bytes * 8U) - lead_of_plain - 3U - position_bits - 8U;
  return static_cast<std::uint16_t>(std::min(room, 24U));
}

template <unsigned PositionBits>
inline constexpr FrameFormat format_of = parse_format(PositionBits == 22   ? "pos22,nE,nW,crc6"
                                                      : PositionBits == 26 ? "pos26,nE,nW,crc6"
                                                      : PositionBits == 32 ? "pos32,nE,nW,crc6"
                                                                           : "pos36,nE,nW,crc6")
                                             .value();

// A loop in a separate function, as users write it: only the library's attributes decide what is
// inlined.
template <class Decode>
[[gnu::noinline]] std::uint64_t loop(const Pool::Buffers& buffers, const Decode& decode) {
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < pool_size; ++i) {
    const auto frame = decode(buffers[i]);
    if (frame.ok()) hash += used(frame->channel_list[0]);
  }
  return hash;
}

template <class Decode>
void run_loop(benchmark::State& state, const Pool& pool, const Decode& decode) {
  std::uint64_t expected = 0;
  for (std::size_t i = 0; i < pool_size; ++i) expected += used<1>(pool.frame(i));
  if (loop(pool.buffers(), decode) != expected) return state.SkipWithError("a wrong position");
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(loop(pool.buffers(), decode));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(pool_size));
}

Pool::Shape short_ack(unsigned position_bits, std::size_t bytes) {
  return {.lead_least = lead_of_plain,
          .lead_most = lead_of_plain,
          .ack_least = 1,
          // Frames that a decoder of one word can read, too.
          .ack_most = longest_ack(position_bits, std::min<std::size_t>(bytes, 8)),
          .bytes = bytes};
}

template <unsigned PositionBits>
void add_short_rows(Table& table, std::size_t bytes) {
  const std::string text = fmt::format("pos{},nE,nW,crc6", PositionBits);
  const std::string what = fmt::format("{} bits in {} bytes, ACK 1 to {}", PositionBits, bytes,
                                       longest_ack(PositionBits, std::min<std::size_t>(bytes, 8)));
  const Pool::Shape shape = short_ack(PositionBits, bytes);
  std::string reference;
  if (bytes >= 8) {
    reference = "plain decoder, " + what;
    table.add({.name = reference}, [=](benchmark::State& state) {
      const Pool pool(text, shape);
      run<1>(state, pool, [buffers = pool.buffers()](std::size_t i) {
        return decode_plainly<PositionBits>(buffers[i].data());
      });
    });
  }
  const auto add = [&](const std::string& who, double share, auto work) {
    table.add({.name = who + ", " + what, .reference = reference, .share = bytes < 8 ? 0 : share},
              [=](benchmark::State& state) { work(state, Pool(text, shape)); });
  };
  add("decode_frame", 0.8, [text](benchmark::State& state, const Pool& pool) {
    const auto codec = hidden_codec<FrameCodec<CrcFast, 1>>(text.c_str());
    run_loop(state, pool, [&codec](std::span<const std::uint8_t> buffer) {
      return decode_frame(BitView(buffer), codec);
    });
  });
  add("decode_frame, fixed format", 0.8, [](benchmark::State& state, const Pool& pool) {
    run_loop(state, pool, [](std::span<const std::uint8_t> buffer) {
      return decode_frame(BitView(buffer), FixedCodec<format_of<PositionBits>>{});
    });
  });
  add("SpiReader", 1.2, [text](benchmark::State& state, const Pool& pool) {
    using Codec = FrameCodec<CrcFast, 1>;
    SpiReader<Codec> reader(hidden_codec<Codec>(text.c_str()), spi_setup(), spi_timing());
    benchmark::DoNotOptimize(reader);
    run_loop(state, pool,
             [&reader](std::span<const std::uint8_t> buffer) { return reader.read(buffer); });
  });
  add("SpiReader, fixed format", 1.2, [](benchmark::State& state, const Pool& pool) {
    using Codec = FixedCodec<format_of<PositionBits>>;
    SpiReader<Codec> reader(Codec{}, spi_setup(), spi_timing());
    benchmark::DoNotOptimize(reader);
    run_loop(state, pool,
             [&reader](std::span<const std::uint8_t> buffer) { return reader.read(buffer); });
  });
}

using RunText = void (*)(benchmark::State&, const char*);

void add_pair(Table& table, const std::string& name, const char* text, RunText fast, RunText plain,
              double target) {
  const std::string reference = name + ", PlainCodec";
  table.add({.name = name, .reference = reference, .target = target},
            [=](benchmark::State& state) { fast(state, text); });
  table.add({.name = reference}, [=](benchmark::State& state) { plain(state, text); });
}

}  // namespace

void add_frame_rows(Table& table) {
  for (const std::size_t bytes : {8U, 16U, 32U}) {
    add_short_rows<22>(table, bytes);
    add_short_rows<26>(table, bytes);
    add_short_rows<32>(table, bytes);
    add_short_rows<36>(table, bytes);
  }
  // Lengths between, and shorter than a word: the same speed.
  add_short_rows<22>(table, 5);
  for (const std::size_t bytes : {7U, 12U}) add_short_rows<26>(table, bytes);
  add_pair(table, "decode with search, 22 bits", text_22, search<CrcFast, 1>, search<CrcBitwise, 1>,
           6);
  table.add({.name = "decode with search, 22 bits, 8-channel codec",
             .reference = "decode with search, 22 bits, PlainCodec",
             .target = 6},
            [](benchmark::State& state) { search<CrcFast, 8, 1>(state, text_22); });
  table.add({.name = "decode with search, 22 bits, fixed format",
             .reference = "decode with search, 22 bits, PlainCodec"},
            search_fixed);
  add_pair(table, "decode with search, 36 bits", text_36, search<CrcFast, 1>, search<CrcBitwise, 1>,
           7);
  add_pair(table, "decode with search, safety 36 + 28 bits", text_safety, search<CrcFast, 2>,
           search<CrcBitwise, 2>, 15);
  add_pair(table, "SpiReader, 22 bits", text_22, spi<CrcFast, 1>, spi<CrcBitwise, 1>, 0);
  add_pair(table, "SpiReader, 36 bits", text_36, spi<CrcFast, 1>, spi<CrcBitwise, 1>, 0);
  add_pair(table, "SpiReader, safety 36 + 28 bits", text_safety, spi<CrcFast, 2>,
           spi<CrcBitwise, 2>, 0);
  table.add({.name = "FixedChannel, 24 bits",
             .reference = "FixedChannel, 24 bits, CrcBitwise",
             .target = 1.6},
            fixed<CrcFast>);
  table.add({.name = "FixedChannel, 24 bits, CrcBitwise"}, fixed<CrcBitwise>);
  add_pair(table, "encode_frame, 36 bits", text_36, encode<CrcFast>, encode<CrcBitwise>, 0);
  table.add({.name = "unpack, 36 bits"},
            [](benchmark::State& state) { unpack_words(state, text_36); });
}

}  // namespace biss::bench
