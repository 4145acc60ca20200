#include "decode/control_listener.hpp"

#include <array>

namespace biss::decode {

std::string_view name_of(AccessOutcome outcome) {
  constexpr std::array<std::string_view, access_outcome_count> names{
      "ok",         "header_crc",    "no_answer",        "no_such_slave",
      "id_pattern", "refused",       "not_addressed",    "refused_or_not_addressed",
      "rw_pattern", "busy_too_long", "start_missing",    "data_crc",
      "write_crc",  "echo",          "next_unavailable", "not_accepted",
      "dropped",    "frame_lost",    "cut_end",          "cds_not_seen"};
  return names[static_cast<std::size_t>(outcome)];
}

std::string_view name_of(SeenAccess::Kind kind) {
  constexpr std::array<std::string_view, 4> names{"read", "write", "command", "unknown"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace biss::decode
