#include "verbs/registers/access_rows.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "biss/control/register_map.hpp"
#include "verbs/common/access_option.hpp"
#include "verbs/common/fields.hpp"

namespace biss::verbs {

namespace {

using decode::SeenAccess;

FieldRow access_fields(const SeenAccess& access, std::optional<std::uint8_t> id) {
  std::optional<std::string> address, name, data;
  if (access.kind == SeenAccess::Kind::command) {
    name = name_of(access.command);
  } else if (access.header_sent) {
    address = fmt::format("0x{:02X}", access.address);
    name = register_field(access.address).name;
  }
  if (access.data) data = fmt::format("{:02X}", *access.data);
  return {{"cycle", access.cycle},
          {"time_ns", access.time, report::time_column("", "time")},
          {"id", id},
          {"access", name_of(access.kind)},
          {"address", address},
          {"name", name},
          {"data", data},
          {"outcome", name_of(access.outcome), {.role = report::Role::status}},
          {"cycles", access.cycles},
          {"busy_ns", access.busy, report::time_column("", "busy")}};
}

}  // namespace

std::vector<report::Column> access_columns() { return columns_of(access_fields({}, {})); }

void write_access(report::TableWriter& writer, const SeenAccess& access) {
  const bool command = access.kind == SeenAccess::Kind::command;
  if (!command || access.slaves == 0) {
    const bool known = access.header_sent && !command;
    write_row(writer, access_fields(access, known ? std::optional(access.id) : std::nullopt));
    return;
  }
  for (std::uint8_t id = 0; id < control_max_slaves; ++id) {
    if ((access.slaves >> id & 1U) != 0) write_row(writer, access_fields(access, id));
  }
}

}  // namespace biss::verbs
