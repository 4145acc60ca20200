// An FST without its values: blocks, time scale, declarations, and when dumping was off.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/compressed.hpp"
#include "capture/decimal.hpp"
#include "capture/declared_lines.hpp"
#include "capture/edge_source.hpp"
#include "capture/gather.hpp"
#include "capture/leb128.hpp"
#include "capture/timescale.hpp"
#include "capture/unpack.hpp"

namespace biss::capture {

/// Reads numbers of a block in memory. After the end of the memory, failed() is true and every
/// number is 0.
class FstCursor {
 public:
  explicit FstCursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (at_ != bytes_.size()) return bytes_[at_++];
    failed_ = true;
    return 0;
  }
  /// Seven bits a byte, the lowest first; the last byte is below 128.
  std::uint64_t varint() {
    const auto value = leb128<std::uint64_t>([this] { return byte(); });
    failed_ = failed_ || !value;
    return value.value_or(0);
  }

  /// The same in two's complement.
  std::int64_t signed_varint() {
    const auto value = leb128<std::int64_t>([this] { return byte(); });
    failed_ = failed_ || !value;
    return value.value_or(0);
  }

  std::uint64_t fixed64() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8U | byte();
    return value;
  }

  /// Text up to a NUL.
  std::string text() {
    std::string text;
    for (;;) {
      const std::uint8_t next = byte();
      if (next == 0) return text;
      text += static_cast<char>(next);
    }
  }

  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t at() const { return at_; }
  bool failed() const { return failed_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

/// The place of the content of a block of value changes.
struct FstBlock {
  std::uint64_t place = 0;
  std::uint64_t size = 0;
  bool signed_index = false;  ///< VCDATA_DYN_ALIAS2
};

/// From `tick` on dumping is on or off.
struct FstSwitch {
  std::uint64_t tick = 0;
  bool on = false;
};

class FstFile {
 public:
  /// A block is held in at most this much memory.
  static constexpr std::uint64_t most_block_bytes = 256U << 20U;

  static tl::expected<FstFile, CaptureError> open(std::unique_ptr<ByteSource> bytes) {
    auto gathered = gather(std::move(bytes));
    if (!gathered) return tl::unexpected(gathered.error());
    FstFile file;
    file.bytes_ = PlacedBytes(std::move(*gathered));
    if (!file.unwrap() || !file.read_sections()) return tl::unexpected(file.error_);
    return file;
  }

  const Timescale& timescale() const { return timescale_; }
  const std::vector<FstSwitch>& switches() const { return switches_; }
  /// The bytes that the initial value of each variable has.
  const std::vector<std::uint32_t>& lengths() const { return lengths_; }
  /// The one-bit signals; a variable is the number of its handle, from 0.
  DeclaredLines& declared() { return declared_; }
  std::uint64_t size() const { return bytes_.size(); }

  /// The next block of value changes; nothing after the last.
  std::optional<FstBlock> next_block() {
    while (const auto section = section_at(next_place_)) {
      next_place_ = section->place + section->size;
      const bool signed_index = section->kind == value_changes_alias_2;
      if (signed_index || section->kind == value_changes || section->kind == value_changes_alias) {
        return FstBlock{section->place, section->size, signed_index};
      }
    }
    return std::nullopt;
  }

  /// Reads bytes; false when they are not there.
  bool read(std::uint64_t place, std::span<std::uint8_t> into) const {
    return bytes_.read(place, into);
  }
  /// These bytes; none when they are not there, so that a FstCursor fails.
  std::vector<std::uint8_t> bytes(std::uint64_t place, std::uint64_t count) const {
    std::vector<std::uint8_t> read(static_cast<std::size_t>(count));
    if (!bytes_.read(place, read)) read.clear();
    return read;
  }
  /// Unpacks `packed_size` bytes at `place` into `into`, which has exactly the unpacked size. The
  /// bytes are stored without packing if both sizes are equal and `may_be_stored` is true.
  bool unpack(Packing packing, std::uint64_t place, std::uint64_t packed_size,
              std::span<std::uint8_t> into, bool may_be_stored = true) {
    if (place > bytes_.size() || packed_size > bytes_.size() - place) return false;
    if (may_be_stored && packed_size == into.size()) return bytes_.read(place, into);
    packed_.resize(static_cast<std::size_t>(packed_size));
    return bytes_.read(place, packed_) && capture::unpack(packing, packed_, into, inflater_);
  }

 private:
  // Kinds of sections and their sizes as in block_format.txt and fstapi.h of GTKWave.
  enum SectionKind : std::uint8_t {
    header = 0,
    value_changes = 1,
    blackouts = 2,
    geometry = 3,
    hierarchy = 4,
    value_changes_alias = 5,
    hierarchy_lz4 = 6,
    hierarchy_lz4_twice = 7,
    value_changes_alias_2 = 8,
    wrapper = 254,
    unfinished = 255,
  };
  static constexpr std::uint64_t section_head_bytes = 9;
  static constexpr std::uint64_t length_bytes = 8;
  static constexpr std::uint64_t wrapper_head_bytes = 17;
  static constexpr std::size_t time_scale_place = 64;

  // Tags of the hierarchy that are not a variable.
  static constexpr std::uint8_t tag_attribute = 252;
  static constexpr std::uint8_t tag_attribute_end = 253;
  static constexpr std::uint8_t tag_scope = 254;
  static constexpr std::uint8_t tag_scope_end = 255;
  static constexpr std::uint8_t last_variable_type = 29;
  static constexpr std::uint8_t real_types[] = {3, 4, 20, 29};
  // Event, integer (GHDL gives it one bit), the reals, port, index of an array, string.
  static constexpr std::uint8_t types_without_level[] = {0, 1, 3, 4, 18, 19, 20, 21, 29};
  static constexpr std::uint32_t real_bytes = 8;
  static constexpr const char* possible_size = "a size that the compressed data can have";

  template <std::size_t N>
  static bool is_one_of(std::uint8_t type, const std::uint8_t (&types)[N]) {
    return std::find(std::begin(types), std::end(types), type) != std::end(types);
  }

  // Each notes the error and returns false.
  bool wrong(CaptureCause cause, const char* part, const char* expected) {
    error_ = {.cause = cause, .expected = expected, .part = part};
    return false;
  }
  bool malformed(const char* part, const char* expected) {
    return wrong(CaptureCause::malformed, part, expected);
  }
  bool damaged(const char* part, const char* expected) {
    return wrong(CaptureCause::damaged, part, expected);
  }
  bool too_many() { return wrong(CaptureCause::too_many_lines, nullptr, nullptr); }

  // The name of a variable as VCD has its words: `MA [3]` is a bit of a wider signal.
  static std::string name_of(std::string_view text) {
    std::vector<std::string> words(1);
    for (const char c : text) {
      const bool blank = c == ' ' || c == '\t';
      if (!blank) words.back() += static_cast<unsigned char>(c) < ' ' ? '_' : c;
      if (blank && !words.back().empty()) words.emplace_back();
    }
    if (words.size() > 1 && words.back().empty()) words.pop_back();
    std::string name = joined_name(words);
    return name.empty() ? "_" : name;
  }

  struct Section {
    std::uint8_t kind = 0;
    std::uint64_t place = 0;  // of the content
    std::uint64_t size = 0;
  };

  std::optional<Section> section_at(std::uint64_t place) const {
    std::array<std::uint8_t, section_head_bytes> head{};
    if (!bytes_.read(place, head)) return std::nullopt;
    const std::uint64_t size = FstCursor(std::span(head).subspan(1)).fixed64();
    if (head[0] == unfinished || size < length_bytes) return std::nullopt;
    return Section{head[0], place + section_head_bytes, size - length_bytes};
  }

  // A file as a whole in gzip, if this is one.
  bool unwrap() {
    std::array<std::uint8_t, wrapper_head_bytes> head{};
    if (!bytes_.read(0, head) || head[0] != wrapper) return true;
    constexpr const char* part = "the gzip wrapper";
    const std::uint64_t size = FstCursor(std::span(head).subspan(section_head_bytes)).fixed64();
    if (size / max_packing_ratio > bytes_.size()) return damaged(part, possible_size);
    if (size > most_gathered_bytes) {
      return wrong(CaptureCause::too_large, part, "an FST of at most 4 GiB");
    }
    damaged(part, "data that inflates to its size");
    auto unwrapped = gather(limited_bytes(
        decompressed(bytes_from(bytes_, wrapper_head_bytes), Compression::gzip), size, error_));
    if (!unwrapped) {
      if (unwrapped.error().cause == CaptureCause::read_failed) error_ = unwrapped.error();
      return false;
    }
    bytes_ = PlacedBytes(std::move(*unwrapped));
    return bytes_.size() == size;
  }

  // Everything but the values.
  bool read_sections() {
    std::optional<Section> names;
    std::uint64_t place = 0;
    while (const auto section = section_at(place)) {
      if (place == 0 && !read_header(*section)) return false;
      if (section->size > bytes_.size() - section->place) break;
      place = section->place + section->size;
      switch (section->kind) {
        case header:
        case value_changes:
        case value_changes_alias:
        case value_changes_alias_2:
          break;
        case geometry:
          if (!read_geometry(*section)) return false;
          break;
        case blackouts:
          if (!read_blackouts(*section)) return false;
          break;
        case hierarchy:
        case hierarchy_lz4:
        case hierarchy_lz4_twice:
          if (names) return malformed("the hierarchy", "the names of signals once");
          names = section;
          break;
        default:
          return malformed("a section", "a kind of section that FST has");
      }
    }
    if (!timescale_.known()) return malformed("the header", "an FST with its header");
    if (!names) {
      return wrong(CaptureCause::truncated, nullptr,
                   "the names of signals at the end of an FST: let the simulator finish and close "
                   "the file");
    }
    if (place != bytes_.size()) {
      return wrong(CaptureCause::truncated, "a section", "whole sections up to the end");
    }
    return read_hierarchy(*names);
  }

  bool read_header(const Section& section) {
    std::array<std::uint8_t, time_scale_place + 1> content{};
    if (section.kind != header || section.size < content.size() ||
        !bytes_.read(section.place, content)) {
      return malformed("the header", "an FST with its header");
    }
    const int exponent = static_cast<std::int8_t>(content[time_scale_place]);
    constexpr int picoseconds_exponent = -12;
    if (exponent < -21 || exponent > 2) {
      return malformed("the header", "a time scale of 1 zs to 100 s");
    }
    const std::uint64_t power =
        powers_of_ten[static_cast<std::size_t>(std::abs(exponent - picoseconds_exponent))];
    timescale_ = exponent < picoseconds_exponent ? Timescale{1, power} : Timescale{power, 1};
    return true;
  }

  bool read_geometry(const Section& section) {
    constexpr std::uint64_t head_bytes = 16;
    constexpr const char* part = "the geometry";
    const auto head = bytes(section.place, std::min(section.size, head_bytes));
    FstCursor numbers(head);
    const std::uint64_t size = numbers.fixed64();
    const std::uint64_t handles = numbers.fixed64();
    if (numbers.failed()) return damaged(part, "its size and the number of variables");
    const std::uint64_t packed = section.size - head_bytes;
    if (handles > max_variables) return too_many();
    constexpr std::uint64_t most_varint_bytes = 5;
    if (size > max_variables * most_varint_bytes || size / max_packing_ratio > packed) {
      return damaged(part, possible_size);
    }
    std::vector<std::uint8_t> content(static_cast<std::size_t>(size));
    if (!unpack(Packing::zlib, section.place + head_bytes, packed, content)) {
      return damaged(part, "data that inflates to its size");
    }
    lengths_.clear();
    FstCursor cursor(content);
    constexpr std::uint64_t variable_length = UINT32_MAX;
    while (lengths_.size() < handles) {
      const std::uint64_t length = cursor.varint();
      if (cursor.failed() || length > variable_length) {
        return damaged(part, "the length of every variable");
      }
      lengths_.push_back(length == 0                 ? real_bytes
                         : length == variable_length ? 0
                                                     : static_cast<std::uint32_t>(length));
    }
    has_geometry_ = true;
    return true;
  }

  bool read_blackouts(const Section& section) {
    constexpr std::uint64_t most_bytes = 16U << 20U;
    if (section.size > most_bytes) {
      return wrong(CaptureCause::block_too_large, "the blackouts", nullptr);
    }
    const auto content = bytes(section.place, section.size);
    FstCursor cursor(content);
    std::uint64_t tick = 0;
    for (std::uint64_t left = cursor.varint(); left != 0 && !cursor.failed(); --left) {
      const bool on = cursor.byte() != 0;
      const std::uint64_t delta = cursor.varint();
      if (cursor.failed() || delta > timescale_.last_tick() - tick) break;
      tick += delta;
      switches_.push_back({tick, on});
      if (left == 1) return true;
    }
    return (!cursor.failed() && switches_.empty()) || damaged("the blackouts", "a time for each");
  }

  bool read_hierarchy(const Section& section) {
    std::vector<std::uint8_t> content;
    if (!unpack_hierarchy(section, content) || !take_hierarchy(content)) return false;
    return declared_.finish() || too_many();
  }

  bool unpack_hierarchy(const Section& section, std::vector<std::uint8_t>& into) {
    constexpr const char* part = "the hierarchy";
    constexpr std::uint64_t most_head_bytes = 18;
    const auto head = bytes(section.place, std::min(section.size, most_head_bytes));
    FstCursor cursor(head);
    const std::uint64_t size = cursor.fixed64();
    const bool twice = section.kind == hierarchy_lz4_twice;
    // The size after the first step of unpacking.
    const std::uint64_t once_size = twice ? cursor.varint() : size;
    if (cursor.failed()) return damaged(part, "its size");
    const std::uint64_t place = section.place + cursor.at();
    const std::uint64_t packed = section.size - cursor.at();
    if (size > most_block_bytes || once_size > most_block_bytes) {
      return wrong(CaptureCause::block_too_large, part, nullptr);
    }
    if (once_size / max_packing_ratio > packed || size / max_packing_ratio > once_size) {
      return damaged(part, possible_size);
    }
    into.resize(static_cast<std::size_t>(once_size));
    const Packing packing = section.kind == hierarchy ? Packing::gzip : Packing::lz4;
    bool good = unpack(packing, place, packed, into, false);
    if (twice) {
      const auto once = std::exchange(into, {});
      into.resize(static_cast<std::size_t>(size));
      good = good && capture::unpack(Packing::lz4, once, into, inflater_);
    }
    return good || damaged(part, "data that unpacks to its size");
  }

  bool take_hierarchy(std::span<const std::uint8_t> content) {
    constexpr const char* part = "the hierarchy";
    FstCursor cursor(content);
    std::uint32_t handles = 0;
    while (!cursor.at_end()) {
      const std::uint8_t tag = cursor.byte();
      if (tag == tag_scope) {
        cursor.byte();
        const std::string name = cursor.text();
        cursor.text();  // the component
        if (declared_.depth() == DeclaredLines::max_depth) {
          return malformed(part, "at most 256 nested scopes");
        }
        if (!declared_.open_scope(name_of(name))) return too_many();
      } else if (tag == tag_scope_end) {
        if (declared_.depth() == 0) return malformed(part, "a scope for each that is closed");
        declared_.close_scope();
      } else if (tag == tag_attribute) {
        cursor.byte();
        cursor.byte();
        cursor.text();
        cursor.varint();
      } else if (tag <= last_variable_type) {
        if (!take_variable(tag, cursor, handles)) return false;
      } else if (tag != tag_attribute_end) {
        return malformed(part, "a scope, an attribute or a variable");
      }
      if (cursor.failed()) return damaged(part, "complete entries");
    }
    return true;
  }

  // A variable with a handle of its own, or another name for an earlier one.
  bool take_variable(std::uint8_t type, FstCursor& cursor, std::uint32_t& handles) {
    cursor.byte();  // the direction
    const std::string name = cursor.text();
    const std::uint64_t length = cursor.varint();
    const std::uint64_t alias = cursor.varint();
    if (cursor.failed() || length > UINT32_MAX) {
      return damaged("the hierarchy", "complete entries");
    }
    if (alias == 0) {
      if (handles == max_variables) return too_many();
      ++handles;
      if (!has_geometry_) {
        lengths_.push_back(is_one_of(type, real_types) ? real_bytes
                                                       : static_cast<std::uint32_t>(length));
      }
    }
    const std::uint64_t handle = alias == 0 ? handles : alias;
    if (handle > lengths_.size() || handle > handles) {
      return damaged("the hierarchy", "variables of the geometry");
    }
    const auto variable = static_cast<std::uint32_t>(handle - 1);
    const bool is_signal =
        length == 1 && lengths_[variable] == 1 && !is_one_of(type, types_without_level);
    return !is_signal || declared_.add(name_of(name), variable) || too_many();
  }

  PlacedBytes bytes_;
  Inflater inflater_;
  std::vector<std::uint8_t> packed_;
  Timescale timescale_;
  std::vector<FstSwitch> switches_;
  bool has_geometry_ = false;
  std::vector<std::uint32_t> lengths_;
  DeclaredLines declared_;
  std::uint64_t next_place_ = 0;
  CaptureError error_;
};

}  // namespace biss::capture
