// What an EDS that was read over the line says of its device, and where each value comes from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/configure/configuration.hpp"
#include "biss/configure/configure_error.hpp"
#include "biss/configure/line_builder.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/image.hpp"

namespace biss::configure_detail {

/// Which of the common part's times were used in a unit that is a hypothesis.
struct HypothesisSink {
  bool timeout = false;
  bool busy = false;
  bool cycle = false;

  constexpr void operator()(const EdsRemark& remark) {
    if (remark.kind != EdsRemarkKind::hypothesis) return;
    const std::string_view symbol = remark.symbol;
    busy = busy || symbol == "TBUSY_MAX";
    cycle = cycle || symbol == "TCYC";
    timeout = timeout || symbol == "TCLK_MAX" || symbol == "TOS_MAX" || symbol == "TO_MAX";
  }
};

/// \param image with a common part; the identifiers are filled in here
/// \param slaves what is known of all slaves so far, by ID, up to the one that holds the EDS
/// \return the device, or eds_contradiction
constexpr Result<LineDevice, ConfigureFault> eds_device(
    EdsImage image, const std::array<SlaveDescription, control_max_slaves>& slaves,
    std::uint8_t holder, const EdsDeviceOptions& options, Hertz unstated_clock_max) {
  const CommonPart common = parse_common_part(*image.common);
  const auto wrong = [holder](std::optional<EdsDeviceCause> cause) {
    return failure(ConfigureFault{.cause = ConfigureError::eds_contradiction,
                                  .step = ConfigureStep::read_common,
                                  .slave = holder,
                                  .eds = cause});
  };
  if (common.sl_off > holder) return wrong(std::nullopt);
  LineDevice line;
  line.first = static_cast<std::uint8_t>(common.first_slave(holder));
  line.ids = common.sl_num;
  // Channel i is the i-th slave's where there is one each.
  for (std::size_t i = 0; i < common.dc_num && i < max_channels; ++i) {
    const std::size_t slave = common.dc_num == 1 ? holder : line.first + i;
    if (slave > holder || (common.dc_num != 1 && common.dc_num != common.sl_num)) break;
    if (slaves[slave].profile.value_or(0) != 0) image.identifiers[i] = slaves[slave].profile;
  }
  HypothesisSink used;
  const auto device = describe_device(image, {}, used, options);
  if (!device.ok()) return wrong(device.error().cause);
  line.format = device->format;
  line.timing = device->timing;
  line.busy_s_clocks = device->busy_s_clocks;
  // From common_clock_max down every slave takes every clock.
  line.timing.clock_min = common_clock_min;
  if (common.tma == 0) {
    line.clock_source = ValueSource::defaults;
    line.timing.clock_max = unstated_clock_max;
  }
  const auto source = [](bool hypothesis) {
    return hypothesis ? ValueSource::hypothesis : ValueSource::defaults;
  };
  line.timeout_source = source(used.timeout);
  line.busy_source = source(used.busy);
  line.cycle_source = source(used.cycle);
  return line;
}

}  // namespace biss::configure_detail
