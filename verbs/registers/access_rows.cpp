#include "verbs/registers/access_rows.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>

#include "biss/control/register_map.hpp"
#include "verbs/common/access_option.hpp"

namespace biss::verbs {

namespace {

using decode::SeenAccess;
using report::Cell;
using report::Kind;

void put_access(report::TableWriter& writer, const SeenAccess& access, std::optional<unsigned> id) {
  const std::string address = fmt::format("0x{:02X}", access.address);
  const std::string data = access.data ? fmt::format("{:02X}", *access.data) : std::string();
  std::array<Cell, 10> cells{};
  cells[0] = access.cycle;
  cells[1] = access.time;
  cells[2] = id;
  cells[3] = name_of(access.kind);
  if (access.kind == SeenAccess::Kind::command) {
    cells[5] = name_of(access.command);
  } else if (access.header_sent) {
    cells[4] = address;
    cells[5] = register_field(access.address).name;
  }
  if (!data.empty()) cells[6] = data;
  cells[7] = name_of(access.outcome);
  cells[8] = access.cycles;
  cells[9] = access.busy;
  writer.row(cells);
}

}  // namespace

const std::vector<report::Column>& access_columns() {
  static const std::vector<report::Column> all{
      {.name = "cycle", .kind = Kind::unsigned_integer},
      report::time_column("time_ns", "time"),
      {.name = "id", .kind = Kind::unsigned_integer},
      {.name = "access", .kind = Kind::text},
      {.name = "address", .kind = Kind::text},
      {.name = "name", .kind = Kind::text},
      {.name = "data", .kind = Kind::text},
      {.name = "outcome", .kind = Kind::text, .role = report::Role::status},
      {.name = "cycles", .kind = Kind::unsigned_integer},
      report::time_column("busy_ns", "busy")};
  return all;
}

void write_access(report::TableWriter& writer, const SeenAccess& access) {
  const bool command = access.kind == SeenAccess::Kind::command;
  if (!command || access.slaves == 0) {
    const bool known = access.header_sent && !command;
    return put_access(writer, access, known ? std::optional<unsigned>(access.id) : std::nullopt);
  }
  for (unsigned id = 0; id < control_max_slaves; ++id) {
    if ((access.slaves >> id & 1U) != 0) put_access(writer, access, id);
  }
}

}  // namespace biss::verbs
