#include "wasm/libraries/whole_inflate.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace biss::wasm {
namespace {

static_assert(std::endian::native == std::endian::little);

// An entry: bits 0 to 4 the length of the code, 5 and 6 the kind, 8 to 12 how many further bits are
// added to the base, 16 to 31 the base: a literal, the least length or the least distance.
enum class Kind : std::uint32_t { literal, repeat, end, longer };

constexpr DeflateEntry entry(Kind kind, unsigned base, unsigned extra = 0) {
  return base << 16U | extra << 8U | static_cast<std::uint32_t>(kind) << 5U;
}
constexpr unsigned bits_of(DeflateEntry entry) { return entry & 0x1FU; }
constexpr Kind kind_of(DeflateEntry entry) { return static_cast<Kind>(entry >> 5U & 3U); }
constexpr unsigned extra_of(DeflateEntry entry) { return entry >> 8U & 0x1FU; }
constexpr unsigned base_of(DeflateEntry entry) { return entry >> 16U; }

// RFC 1951, 3.2.5. What no stream may use means the same as with libdeflate.
constexpr std::array<DeflateEntry, 288> literal_entries = [] {
  constexpr unsigned end_of_block = 256;
  constexpr unsigned longest = 258;
  std::array<DeflateEntry, 288> entries{};
  for (unsigned i = 0; i < end_of_block; ++i) entries[i] = entry(Kind::literal, i);
  entries[end_of_block] = entry(Kind::end, 0);
  unsigned base = 3;
  for (unsigned i = end_of_block + 1; i < 285; ++i) {
    const unsigned extra = i < 265 ? 0 : (i - 261) / 4;
    entries[i] = entry(Kind::repeat, base, extra);
    base += 1U << extra;
  }
  for (unsigned i = 285; i < 288; ++i) entries[i] = entry(Kind::repeat, longest);
  return entries;
}();
constexpr std::array<DeflateEntry, 32> distance_entries = [] {
  std::array<DeflateEntry, 32> entries{};
  unsigned base = 1;
  for (unsigned i = 0; i < 30; ++i) {
    const unsigned extra = i < 4 ? 0 : (i - 2) / 2;
    entries[i] = entry(Kind::repeat, base, extra);
    base += 1U << extra;
  }
  entries[30] = entries[31] = entries[29];
  return entries;
}();
constexpr std::array<DeflateEntry, 19> length_entries = [] {
  std::array<DeflateEntry, 19> entries{};
  for (unsigned i = 0; i < entries.size(); ++i) entries[i] = entry(Kind::literal, i);
  return entries;
}();

unsigned reversed(unsigned code, unsigned bits) {
  unsigned result = 0;
  for (unsigned i = 0; i < bits; ++i) result |= (code >> i & 1U) << (bits - 1 - i);
  return result;
}

std::uint64_t load_word(const std::uint8_t* from) {
  std::uint64_t word = 0;
  std::memcpy(&word, from, sizeof word);
  return word;
}
void store_word(std::uint8_t* to, std::uint64_t word) { std::memcpy(to, &word, sizeof word); }

constexpr std::size_t word_bytes = 8;
constexpr std::size_t block_bytes = 16;
// What repeat() writes beyond the end.
constexpr std::size_t reserve_bytes = block_bytes;

// Bytes that repeat a pattern shorter than a word.
void repeat_pattern(std::uint8_t* to, std::size_t distance, std::size_t length) {
  std::uint64_t word = load_word(to - distance) & ((std::uint64_t{1} << 8 * distance) - 1);
  for (std::size_t have = distance; have < word_bytes; have *= 2) word |= word << 8 * have;
  const std::size_t step = word_bytes - word_bytes % distance;
  for (std::size_t i = 0; i < length; i += step) store_word(to + i, word);
}

// Writes up to `reserve_bytes` beyond the end. \pre a word may be read at to - distance
void repeat(std::uint8_t* to, std::size_t distance, std::size_t length) {
  if (distance >= block_bytes) {
    for (std::size_t i = 0; i < length; i += block_bytes) {
      std::array<std::uint8_t, block_bytes> block;
      std::memcpy(block.data(), to + i - distance, block_bytes);
      std::memcpy(to + i, block.data(), block_bytes);
    }
  } else if (distance >= word_bytes) {
    for (std::size_t i = 0; i < length; i += word_bytes) {
      store_word(to + i, load_word(to + i - distance));
    }
  } else {
    repeat_pattern(to, distance, length);
  }
}

}  // namespace

template <unsigned TableBits>
bool DeflateCode<TableBits>::build(std::span<const std::uint8_t> lengths,
                                   const DeflateEntry* results) {
  counts_.fill(0);
  for (const std::uint8_t length : lengths) ++counts_[length];
  counts_[0] = 0;
  std::array<std::uint16_t, most_bits + 2> places{};
  std::int32_t left = 1;
  for (unsigned bits = 1; bits <= most_bits; ++bits) {
    left = 2 * left - counts_[bits];
    if (left < 0) return false;
    places[bits + 1] = static_cast<std::uint16_t>(places[bits] + counts_[bits]);
  }
  const unsigned symbols = places[most_bits + 1];
  sorted_[0] = results[0] | 1U;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] != 0) sorted_[places[lengths[i]]++] = results[i] | lengths[i];
  }
  if (left != 0) {
    if (symbols > 1 || counts_[1] != symbols) return false;
    table_.fill(sorted_[0]);
    return true;
  }
  table_.fill(entry(Kind::longer, 0));
  unsigned code = 0;
  for (unsigned i = 0; i < symbols; ++i) {
    const unsigned bits = bits_of(sorted_[i]);
    if (bits > TableBits) break;
    for (std::size_t at = reversed(code, bits); at < table_.size(); at += std::size_t{1} << bits) {
      table_[at] = sorted_[i];
    }
    if (i + 1 < symbols) code = (code + 1) << (bits_of(sorted_[i + 1]) - bits);
  }
  return true;
}

template <unsigned TableBits>
DeflateEntry DeflateCode<TableBits>::at(std::uint64_t next) const {
  const DeflateEntry found = table_[static_cast<std::size_t>(next) & (table_.size() - 1)];
  return kind_of(found) == Kind::longer ? count_out(next) : found;
}

template <unsigned TableBits>
DeflateEntry DeflateCode<TableBits>::count_out(std::uint64_t next) const {
  unsigned code = 0;
  unsigned first = 0;
  unsigned place = 0;
  for (unsigned bits = 1; bits <= most_bits; ++bits) {
    code |= static_cast<unsigned>(next >> (bits - 1) & 1U);
    const unsigned count = counts_[bits];
    if (code < first + count) return sorted_[place + code - first];
    place += count;
    first = (first + count) << 1U;
    code <<= 1U;
  }
  return sorted_[0];  // not reached: the code is complete
}

// The bits of the stream. After its end there are zeros; ended_within() says whether they were used.
class WholeInflater::Bits {
 public:
  explicit Bits(std::span<const std::uint8_t> in)
      : begin_(in.data()), at_(in.data()), end_(in.data() + in.size()) {}

  /// Afterwards there are 56 bits or more.
  void fill() {
    if (end_ - at_ >= static_cast<std::ptrdiff_t>(word_bytes)) {
      held_ |= load_word(at_) << count_;
      at_ += (63U - count_) >> 3U;
      count_ |= 56U;
      return;
    }
    for (; count_ <= 56; count_ += 8) {
      if (at_ == end_) {
        ++beyond_;
      } else {
        held_ |= std::uint64_t{*at_++} << count_;
      }
    }
  }
  std::uint64_t next() const { return held_; }
  void drop(unsigned count) {
    held_ >>= count;
    count_ -= count;
  }
  unsigned take(unsigned count) {
    const auto value = static_cast<unsigned>(held_ & ((std::uint64_t{1} << count) - 1));
    drop(count);
    return value;
  }
  bool ended_within() const { return beyond_ <= count_ / 8; }
  std::size_t used() const { return static_cast<std::size_t>(at_ - begin_) + beyond_ - count_ / 8; }
  /// Whole bytes, from the next whole byte on. Nothing where there are fewer. \pre ended_within()
  const std::uint8_t* bytes(std::size_t count) {
    const std::uint8_t* const from = begin_ + used();
    if (static_cast<std::size_t>(end_ - from) < count) return nullptr;
    at_ = from + count;
    held_ = 0;
    count_ = 0;
    beyond_ = 0;
    return from;
  }

 private:
  const std::uint8_t* begin_;
  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::uint64_t held_ = 0;
  unsigned count_ = 0;
  std::size_t beyond_ = 0;
};

struct WholeInflater::Output {
  std::uint8_t* begin;
  std::uint8_t* at;
  std::uint8_t* end;

  std::size_t made() const { return static_cast<std::size_t>(at - begin); }
  std::size_t room() const { return static_cast<std::size_t>(end - at); }

  bool put(std::uint8_t byte) {
    if (at == end) return false;
    *at++ = byte;
    return true;
  }
  bool put_again(std::size_t distance, std::size_t length) {
    if (distance > made() || length > room()) return false;
    if (room() >= length + reserve_bytes) {
      repeat(at, distance, length);
    } else {
      for (std::size_t i = 0; i < length; ++i)
        at[i] = (at + i)[-static_cast<std::ptrdiff_t>(distance)];
    }
    at += length;
    return true;
  }
  bool put_stored(Bits& bits) {
    if (!bits.ended_within()) return false;
    const std::uint8_t* const head = bits.bytes(4);
    if (head == nullptr) return false;
    const unsigned length = head[0] | unsigned{head[1]} << 8U;
    const unsigned inverted = head[2] | unsigned{head[3]} << 8U;
    if ((length ^ inverted) != 0xFFFFU || length > room()) return false;
    const std::uint8_t* const from = bits.bytes(length);
    if (from == nullptr) return false;
    at = std::copy_n(from, length, at);
    return true;
  }
};

void WholeInflater::set_fixed_codes() {
  std::array<std::uint8_t, 288> lengths{};
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
  }
  literals_.build(lengths, literal_entries.data());
  std::array<std::uint8_t, 32> distances{};
  distances.fill(5);
  distances_.build(distances, distance_entries.data());
}

// RFC 1951, 3.2.7.
bool WholeInflater::read_codes(Bits& bits) {
  constexpr std::array<std::uint8_t, 19> order{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                               11, 4,  12, 3, 13, 2, 14, 1, 15};
  bits.fill();
  const std::size_t literals = 257 + bits.take(5);
  const std::size_t distances = 1 + bits.take(5);
  const std::size_t given = 4 + bits.take(4);
  std::array<std::uint8_t, 19> of_lengths{};
  for (std::size_t i = 0; i < given; ++i) {
    bits.fill();
    of_lengths[order[i]] = static_cast<std::uint8_t>(bits.take(3));
  }
  DeflateCode<7> code;
  if (!code.build(of_lengths, length_entries.data())) return false;

  std::array<std::uint8_t, 288 + 32> lengths{};
  const std::size_t all = literals + distances;
  for (std::size_t i = 0; i < all;) {
    bits.fill();
    const DeflateEntry found = code.at(bits.next());
    bits.drop(bits_of(found));
    const unsigned symbol = base_of(found);
    if (symbol < 16) {
      lengths[i++] = static_cast<std::uint8_t>(symbol);
      continue;
    }
    if (symbol == 16 && i == 0) return false;
    const std::uint8_t value = symbol == 16 ? lengths[i - 1] : std::uint8_t{0};
    const std::size_t count = symbol == 16   ? 3 + bits.take(2)
                              : symbol == 17 ? 3 + bits.take(3)
                                             : 11 + bits.take(7);
    // What goes beyond the last symbol is ignored, as libdeflate does.
    const std::size_t some = std::min(count, all - i);
    std::fill_n(lengths.begin() + static_cast<std::ptrdiff_t>(i), some, value);
    i += some;
  }
  const std::span<const std::uint8_t> whole(lengths);
  return literals_.build(whole.first(literals), literal_entries.data()) &&
         distances_.build(whole.subspan(literals, distances), distance_entries.data());
}

bool WholeInflater::inflate_codes(Bits& given, Output& output) const {
  // Copies, which stay in registers.
  Bits bits = given;
  Output out = output;
  for (;;) {
    bits.fill();
    DeflateEntry found = literals_.at(bits.next());
    if (kind_of(found) == Kind::literal) {
      bits.drop(bits_of(found));
      if (!out.put(static_cast<std::uint8_t>(base_of(found)))) return false;
      // The bits suffice for what follows, too.
      found = literals_.at(bits.next());
      if (kind_of(found) == Kind::literal) {
        bits.drop(bits_of(found));
        if (!out.put(static_cast<std::uint8_t>(base_of(found)))) return false;
        continue;
      }
      bits.fill();
    }
    bits.drop(bits_of(found));
    if (kind_of(found) == Kind::end) break;
    const std::size_t length = base_of(found) + bits.take(extra_of(found));
    const DeflateEntry far = distances_.at(bits.next());
    bits.drop(bits_of(far));
    const std::size_t distance = base_of(far) + bits.take(extra_of(far));
    if (!out.put_again(distance, length)) return false;
  }
  given = bits;
  output = out;
  return true;
}

std::optional<Inflated> WholeInflater::inflate(std::span<const std::uint8_t> in,
                                               std::span<std::uint8_t> into) {
  Bits bits(in);
  Output out{into.data(), into.data(), into.data() + into.size()};
  for (bool last = false; !last;) {
    bits.fill();
    last = bits.take(1) != 0;
    bool read = false;
    switch (bits.take(2)) {
      case 0:
        read = out.put_stored(bits);
        break;
      case 1:
        set_fixed_codes();
        read = inflate_codes(bits, out);
        break;
      case 2:
        read = read_codes(bits) && inflate_codes(bits, out);
        break;
      default:
        break;
    }
    if (!read || !bits.ended_within()) return std::nullopt;
  }
  return Inflated{bits.used(), out.made()};
}

}  // namespace biss::wasm
