// Frames out of SPI buffers, and the other way.
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
#include "biss/frame/format_parse.hpp"
#include "biss/master/spi_read.hpp"

namespace biss::bench {

namespace {

using FastCodec = FrameCodec<>;

constexpr const char* text_22 = "pos22,nE,nW,crc6";
constexpr const char* text_36 = "pos36,nE,nW,crc6";
constexpr const char* text_safety = "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0";

template <class Codec>
Codec hidden_codec(const char* text) {
  Codec codec(parse_format(text).value());
  benchmark::DoNotOptimize(codec);
  return codec;
}

// What a user asks of a frame: may the position be used, and what is it.
template <std::size_t Channels>
std::uint64_t used(const Result<BasicFrame<Channels>, FrameFault>& frame) {
  if (!frame.ok() || !frame->trusted()) return ~std::uint64_t{0};
  std::uint64_t sum = 0;
  for (const Channel& channel : frame->channels()) sum += channel.position;
  return sum;
}

// All frames once, so that no wrong answer is ever fast.
template <class Decode>
bool right(const Pool& pool, Decode decode) {
  for (std::size_t i = 0; i < pool_size; ++i) {
    if (decode(i) != used(pool.frame(i))) return false;
  }
  return true;
}

template <class Decode>
void run(benchmark::State& state, const Pool& pool, Decode decode) {
  if (!right(pool, decode)) return state.SkipWithError("a wrong position");
  measure(state, pool_size, decode);
}

template <class Codec>
void search(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<Codec>(text);
  const Pool pool(text);
  run(state, pool, [&](std::size_t i) { return used(decode_frame(BitView(pool[i]), codec)); });
}

template <class Codec>
void spi(benchmark::State& state, const char* text) {
  const SpiSetup setup{.period = period_of(megahertz(10)), .line_delay = {.max = nanoseconds(700)}};
  DeviceTiming timing;
  timing.ack_max = microseconds(16);
  SpiReader<Codec> reader(hidden_codec<Codec>(text), setup, timing);
  benchmark::DoNotOptimize(reader);
  const Pool pool(text);
  run(state, pool, [&](std::size_t i) { return used(reader.read(pool[i])); });
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
  run(state, pool, [&](std::size_t i) {
    const auto channel = Encoder::decode(words[i]);
    return channel.ok() && channel->nE ? channel->position : ~std::uint64_t{0};
  });
}

template <class Codec>
void encode(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<Codec>(text);
  const Pool pool(text);
  measure(state, pool_size, [&](std::size_t i) {
    const auto line = encode_frame(pool.frame(i), codec);
    return std::uint64_t{line->bytes().back()} ^ line->size_bits();
  });
}

void unpack_words(benchmark::State& state, const char* text) {
  const auto codec = hidden_codec<FastCodec>(text);
  const Pool pool(text);
  const ChannelFormat& format = codec.format().channel_list[0];
  std::vector<std::uint64_t> words;
  for (std::size_t i = 0; i < pool_size; ++i) {
    words.push_back(pack(format, pool.frame(i).channel_list[0]));
  }
  run(state, pool, [&](std::size_t i) { return unpack(format, words[i]).position; });
}

using RunText = void (*)(benchmark::State&, const char*);

void add_pair(Table& table, const std::string& name, const char* text, RunText fast, RunText plain,
              double target) {
  const std::string reference = name + ", PlainCodec";
  table.add({.name = name, .reference = reference, .target = target, .headline = true},
            [=](benchmark::State& state) { fast(state, text); });
  table.add({.name = reference}, [=](benchmark::State& state) { plain(state, text); });
}

}  // namespace

void add_frame_rows(Table& table) {
  add_pair(table, "decode with search, 22 bits", text_22, search<FastCodec>, search<PlainCodec>, 6);
  add_pair(table, "decode with search, 36 bits", text_36, search<FastCodec>, search<PlainCodec>, 7);
  add_pair(table, "decode with search, safety 36 + 28 bits", text_safety, search<FastCodec>,
           search<PlainCodec>, 0);
  add_pair(table, "SpiReader, 22 bits", text_22, spi<FastCodec>, spi<PlainCodec>, 0);
  add_pair(table, "SpiReader, 36 bits", text_36, spi<FastCodec>, spi<PlainCodec>, 0);
  add_pair(table, "SpiReader, safety 36 + 28 bits", text_safety, spi<FastCodec>, spi<PlainCodec>,
           0);
  table.add({.name = "FixedChannel, 24 bits",
             .reference = "FixedChannel, 24 bits, CrcBitwise",
             .target = 1.6,
             .headline = true},
            fixed<CrcFast>);
  table.add({.name = "FixedChannel, 24 bits, CrcBitwise"}, fixed<CrcBitwise>);
  add_pair(table, "encode_frame, 36 bits", text_36, encode<FastCodec>, encode<PlainCodec>, 0);
  table.add({.name = "unpack, 36 bits"},
            [](benchmark::State& state) { unpack_words(state, text_36); });
}

}  // namespace biss::bench
