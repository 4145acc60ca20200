#include "verbs/eds/value.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/eds/common_part.hpp"
#include "biss/eds/profile.hpp"
#include "device/quantity.hpp"
#include "dump/text.hpp"

namespace biss::verbs {
namespace {

// The longest table of names.
constexpr std::uint32_t table_values = 3;

bool has_table(const EdsField& field) { return !name_of(field.kind, 0).empty(); }

// Probably the reason why ranges leave out 0 and all ones (EdsField::may_be_absent()).
bool not_given(const EdsField& field, std::uint32_t value) {
  return field.may_be_absent() && (value == 0 || value == field.all_ones());
}

using Value = tl::expected<std::uint32_t, std::string>;

tl::unexpected<std::string> wrong(std::string error) { return tl::unexpected(std::move(error)); }

Value checked(const EdsField& field, std::uint64_t value) {
  if (value <= field.all_ones()) return static_cast<std::uint32_t>(value);
  return wrong(
      fmt::format("too large; {} at most {}",
                  field.bytes == 1 ? "1 byte holds" : fmt::format("{} bytes hold", field.bytes),
                  field.all_ones()));
}

Value parse_time_field(const EdsField& field, std::string_view text) {
  const EdsScale& scale = *find_scale(field.symbol);
  const bool confirmed = text.ends_with('?');
  if (confirmed) text = dump::trimmed(text.substr(0, text.size() - 1));
  const auto time = parse_duration(text);
  if (!time.ok()) return wrong(quantity_error_text(Quantity::duration, text, time.error()));
  if (scale.hypothesis && !confirmed) {
    return wrong(
        fmt::format("it is a hypothesis that {} counts steps of {}; write the number of "
                    "steps, or {}? to rely on it",
                    field.symbol, text_of(scale.step), text));
  }
  if (time->count % scale.step.count != 0) {
    return wrong(fmt::format("not a whole number of steps of {}", text_of(scale.step)));
  }
  return checked(field, static_cast<std::uint64_t>(time->count / scale.step.count));
}

// The names of the field's table.
std::string table_error(const EdsField& field) {
  std::string names;
  for (std::uint32_t value = 0; value < table_values; ++value) {
    const std::string_view name = name_of(field.kind, value);
    if (!name.empty()) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  return fmt::format("a number or one of: {}", names);
}

}  // namespace

tl::expected<std::uint32_t, std::string> parse_eds_value(const EdsField& field,
                                                         std::string_view text, bool linear) {
  text = dump::trimmed(text);
  for (std::uint32_t value = 0; has_table(field) && value < table_values; ++value) {
    if (text == name_of(field.kind, value)) return value;
  }
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  const std::size_t size =
      std::min(hexadecimal ? text.find(' ') : text.find_first_not_of("0123456789"), text.size());
  const std::string_view unit = dump::trimmed(text.substr(size));
  const auto number = parse_count(text.substr(0, size));
  if (number.ok() && unit.empty()) return checked(field, *number);
  if (field.unit == EdsUnit::time_step) return parse_time_field(field, text);
  if (!number.ok()) {
    return wrong(has_table(field) ? table_error(field) : std::string("a number, decimal or 0x..."));
  }
  const std::string_view due = text_of(field.unit, linear);
  if (unit == due || (field.unit == EdsUnit::banks && unit == "bank"))
    return checked(field, *number);
  return wrong(due.empty() ? fmt::format("a number without unit, not '{}'", unit)
                           : fmt::format("the unit is {}, not '{}'", due, unit));
}

std::string eds_value_text(const EdsField& field, std::uint32_t value, bool linear) {
  if (field.kind >= EdsKind::identifier) return fmt::format("0x{:0{}X}", value, 2 * field.bytes);
  if (const std::string_view name = name_of(field.kind, value); !name.empty()) {
    return std::string(name);
  }
  if (not_given(field, value)) return fmt::format("{}", value);
  if (field.unit == EdsUnit::time_step) {
    const bool is_number = find_scale(field.symbol)->hypothesis || value == 0;
    return is_number ? fmt::format("{}", value) : text_of(eds_time(field.symbol, value));
  }
  const std::string_view unit =
      field.unit == EdsUnit::banks && value == 1 ? "bank" : text_of(field.unit, linear);
  return unit.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

namespace {

std::string identifier_meaning(std::uint32_t value) {
  const ProfileIdentifier id{static_cast<std::uint16_t>(value)};
  const bool standard = id.profile() == Profile::bp3 || id.profile() == Profile::bp3s;
  if (!standard) return fmt::format("0x{:04X}: {}", value, name_of(id.profile()));
  return fmt::format("0x{:04X}: {} version {}, C = {}, DL = {}", value, name_of(id.profile()),
                     id.version(), id.crc_is_data() ? 1 : 0, id.data_length());
}

std::string format_meaning(std::uint32_t value) {
  const CommonChannel channel{.format = static_cast<std::uint8_t>(value)};
  std::string out = channel.actuator() ? "actuator" : "sensor";
  out += channel.left_aligned() ? ", left-aligned" : ", right-aligned";
  if (channel.leading_stop_bit()) out += ", leading stop bit";
  return out;
}

std::string coupler_meaning(std::uint32_t value) {
  const CommonPart part{.bc_off = static_cast<std::uint8_t>(value)};
  return part.has_bus_coupler() ? fmt::format("slave {}", part.bus_coupler_slave()) : "none";
}

}  // namespace

std::string eds_meaning(const EdsField& field, std::uint32_t value, bool linear) {
  if (not_given(field, value)) return "not given ?";
  switch (field.kind) {
    case EdsKind::identifier:
      return identifier_meaning(value);
    case EdsKind::polynomial:
      return value == 0 ? "" : fmt::format("0x{:X}", std::uint64_t{value} << 1U | 1U);
    case EdsKind::channel_format:
      return format_meaning(value);
    case EdsKind::bus_coupler:
      return coupler_meaning(value);
    default:
      break;
  }
  if (field.unit == EdsUnit::time_step) {
    if (value == 0) return {};
    const std::string time = text_of(eds_time(field.symbol, value));
    return find_scale(field.symbol)->hypothesis ? time + " ?" : time;
  }
  if (field.unit == EdsUnit::kelvin) {
    return fmt::format("{} K, {} degrees Celsius", value, static_cast<std::int64_t>(value) - 273);
  }
  const bool named = !name_of(field.kind, value).empty() || !text_of(field.unit, linear).empty();
  return named ? eds_value_text(field, value, linear) : std::string();
}

}  // namespace biss::verbs
