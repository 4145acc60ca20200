// Banks of 64 bytes, one behind the other, from bank 0 or the one that the options name.
#include "dump/place.hpp"
#include "dump/read.hpp"

namespace biss::dump {

DumpResult read_binary(std::istream& stream, std::string head, const DumpOptions& options) {
  std::string bytes = std::move(head);
  const std::size_t had = bytes.size();
  bytes.resize(image_bytes + 1);  // one more than there may be
  if (stream && had <= image_bytes) {
    stream.read(bytes.data() + had, static_cast<std::streamsize>(bytes.size() - had));
    bytes.resize(had + static_cast<std::size_t>(stream.gcount()));
    if (stream.bad()) return failure(DumpError{DumpCause::read_failed});
  } else {
    bytes.resize(had);
  }
  RegisterDump dump;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(bytes[i]);
    if (const auto cause = place_at_offset(dump, i, byte, options)) {
      return failure(DumpError{*cause, 0, 0, "at most 256 banks"});
    }
  }
  if (bytes.size() % bank_bytes != 0) return failure(DumpError{DumpCause::not_whole_banks});
  return dump;
}

}  // namespace biss::dump
