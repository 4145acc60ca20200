// Within the room: a maker for each format, and the shared parts of the machine formats.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/table.hpp"
#include "report/text.hpp"

namespace biss::report {

std::unique_ptr<TableWriter> make_csv_writer(std::span<const Column> columns, TextSink& sink);
std::unique_ptr<TableWriter> make_jsonl_writer(std::span<const Column> columns, TextSink& sink);
std::unique_ptr<TableWriter> make_vcd_writer(std::span<const Column> columns, TextSink& sink);
std::unique_ptr<TableWriter> make_eye_writer(std::span<const Column> columns, TextSink& sink,
                                             TableOptions options);

/// Collects lines and hands them to the sink in large blocks; remembers a failure. A line is written
/// piece by piece:
///
///     char* at = writer.begin();
///     at = writer.room(at, bytes);   // before each piece
///     …                              // at most `bytes` from `at` on
///     return writer.end_line(at);
class BlockWriter {
 public:
  /// \param printable the lines are for TextSink::write_printable()
  explicit BlockWriter(TextSink& sink, bool printable = false)
      : sink_(sink), printable_(printable), block_(block_bytes + 4096) {}

  char* begin() { return block_.data() + used_; }
  /// \param at the end of the text written so far \return the same place, perhaps elsewhere in
  /// memory
  char* room(char* at, std::size_t bytes) {
    return static_cast<std::size_t>(block_.data() + block_.size() - at) >= bytes ? at
                                                                                 : grow(at, bytes);
  }
  bool end_line(const char* at) {
    used_ = static_cast<std::size_t>(at - block_.data());
    return used_ < block_bytes && !sink_.wants_lines() ? good_ : flush();
  }
  bool write_line(std::string_view line) {
    return end_line(std::copy(line.begin(), line.end(), room(begin(), line.size())));
  }
  bool flush() {
    const std::string_view lines(block_.data(), used_);
    good_ = good_ && (printable_ ? sink_.write_printable(lines) : sink_.write(lines));
    used_ = 0;
    return good_;
  }
  bool good() const { return good_; }

 private:
  static constexpr std::size_t block_bytes = 64U * 1024U;

  char* grow(const char* at, std::size_t bytes) {
    const auto kept = static_cast<std::size_t>(at - block_.data());
    block_.resize(std::max(kept + bytes, block_.size() * 2));
    return block_.data() + kept;
  }

  TextSink& sink_;
  bool printable_;
  std::vector<char> block_;
  std::size_t used_ = 0;
  bool good_ = true;
};

/// Puts a value that is not a text, as in CSV; nothing if it is absent. Returns the end.
inline char* put_plain(char* at, const Cell& cell) {
  switch (cell.kind()) {
    case Kind::flag:
    case Kind::unsigned_integer:
      return put_number(at, cell.unsigned_value());
    case Kind::signed_integer:
      return put_number(at, cell.signed_value());
    case Kind::real:
      return put_number(at, cell.real_value());
    case Kind::nanoseconds:
      return put_nanoseconds(at, cell.time());
    case Kind::bits:
      return put_hex(at, cell.bits());
    case Kind::absent:
    case Kind::text:
      break;
  }
  return at;
}
/// The most characters that it writes.
inline std::size_t plain_chars(const Cell& cell) {
  return cell.kind() == Kind::bits ? hex_chars(cell.bits()) : number_chars;
}

inline void append_plain(std::string& out, const Cell& cell) {
  const std::size_t before = out.size();
  out.resize(before + plain_chars(cell));
  out.resize(static_cast<std::size_t>(put_plain(out.data() + before, cell) - out.data()));
}

/// The bytes that a format writes unchanged.
template <class IsPlain>
constexpr std::array<bool, 256> byte_set(IsPlain is_plain) {
  std::array<bool, 256> set{};
  for (unsigned byte = 0; byte < 256; ++byte) set[byte] = is_plain(byte);
  return set;
}
inline bool all_in(const std::array<bool, 256>& set, std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [&set](char c) { return set[static_cast<unsigned char>(c)]; });
}

}  // namespace biss::report
