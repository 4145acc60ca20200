// A ZIP archive written from front to back, so that it may go to a pipe: each member is known whole
// before its first byte is out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "capture/inflate.hpp"

namespace biss::capture {

/// Appends members to a string that the owner hands on as it likes. Dates are 1 January 1980, so
/// that equal captures make equal files.
class ZipWriter {
 public:
  /// Appends a member, deflated. False when the archive would pass 4 GiB or 65535 members; then
  /// nothing is appended. \pre bytes are fewer than 4 GiB
  bool add(std::string_view name, std::span<const std::uint8_t> bytes, std::string& out);
  bool add(std::string_view name, std::string_view text, std::string& out);

  /// Appends the directory.
  void finish(std::string& out);

 private:
  struct Member {
    std::string name;
    std::uint32_t checksum;
    std::uint32_t compressed_bytes;
    std::uint32_t size_bytes;
    std::uint32_t place;
  };

  Deflater deflater_;
  std::vector<Member> members_;
  std::uint64_t written_bytes_ = 0;
  std::uint64_t directory_bytes_ = 0;
};

}  // namespace biss::capture
