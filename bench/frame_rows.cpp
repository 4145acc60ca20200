// Decoding frames from SPI buffers, and encoding frames.
#include <cstdint>
#include <string>
#include <string_view>
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

// What a user reads of each channel: the position, and whether it may be used.
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

template <class Crc, std::size_t Channels>
void spi(benchmark::State& state, const char* text) {
  using Codec = FrameCodec<Crc, Channels>;
  const SpiSetup setup{.period = period_of(megahertz(10)), .line_delay = {.max = nanoseconds(700)}};
  DeviceTiming timing;
  timing.ack_max = microseconds(16);
  SpiReader<Codec> reader(hidden_codec<Codec>(text), setup, timing);
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
           search<CrcBitwise, 2>, 0);
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
