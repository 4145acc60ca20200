// What a GHW says before its values: strings, types, and the hierarchy of signals.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/declared_lines.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// The numbers of a GHW, read from front to back. After the end or a failure every number is 0.
class GhwStream {
 public:
  explicit GhwStream(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  std::uint8_t byte() {
    if (rest_.empty() && !fill()) return 0;
    const auto byte = static_cast<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    return byte;
  }
  /// In LEB128; UINT32_MAX for a larger one.
  std::uint32_t unsigned_number();
  /// In LEB128; the least number for one of more than 64 bits.
  std::int64_t signed_number();
  std::uint32_t word();
  std::int64_t time();
  void skip(std::size_t bytes) {
    for (; bytes != 0 && !failed_; --bytes) byte();
  }
  /// Four letters.
  std::array<char, 4> name();

  void set_big_endian(bool big_endian) { big_endian_ = big_endian; }
  /// Something was not there.
  bool failed() const { return failed_; }
  /// Why: `truncated` or `read_failed`.
  CaptureCause cause() const { return cause_; }

 private:
  bool fill();

  std::unique_ptr<ByteSource> bytes_;
  BlockReader block_;
  std::span<const char> rest_;
  bool big_endian_ = false;
  bool failed_ = false;
  CaptureCause cause_ = CaptureCause::truncated;
};

/// How the value of a signal is stored.
enum class GhwValue : std::uint8_t { letter, number, real };

/// A signal in the order of values.
struct GhwSignal {
  static constexpr std::uint32_t no_variable = UINT32_MAX;

  std::uint32_t number = 0;  ///< in the hierarchy
  std::uint32_t variable = no_variable;
  std::uint32_t type = 0;  ///< in types whose letters are levels
  GhwValue value{};
};

struct GhwHeader {
  DeclaredLines lines;
  std::uint32_t variables = 0;
  std::vector<GhwSignal> signals;
  /// The level of each letter of the types of lines.
  std::vector<std::vector<wire::Level>> letters;
};

/// Reads up to the end of the header.
tl::expected<GhwHeader, CaptureError> read_ghw_header(GhwStream& stream);

}  // namespace biss::capture
