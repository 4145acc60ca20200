// An electronic data sheet as a format and a timing.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/profile.hpp"
#include "capi/biss_c_control.h"
#include "capi/device.hpp"

namespace biss::capi {
namespace {

// The parts as the core reads them.
struct Parts {
  explicit Parts(const biss_device& device) {
    std::copy(std::begin(device.common), std::end(device.common), common.begin());
    if (device.has_common) image.common = &common;
    if (device.has_common) image.eds_bank = static_cast<std::uint8_t>(device.eds_bank);
    for (std::size_t i = 0; i < max_channels; ++i) {
      std::copy(std::begin(device.channel[i]), std::end(device.channel[i]), channels[i].begin());
      if (device.has_channel[i]) image.profiles[i] = &channels[i];
    }
    // The identifier belongs to the channel if there is only one.
    const bool single = !device.has_common || channel_count(image) == 1;
    if (device.has_profile && device.profile != 0 && single) {
      image.identifiers[0] = static_cast<std::uint16_t>(device.profile);
    }
  }
  Parts(const Parts&) = delete;

  EdsBank common{};
  std::array<EdsBank, max_channels> channels{};
  EdsImage image;
};

}  // namespace

extern "C" {

biss_status biss_eds_format(const biss_device* device, uint32_t clock_hz, biss_format* format,
                            biss_eds_remark remark, void* user) {
  if (device == nullptr || format == nullptr) return BISS_NULL_ARGUMENT;
  if (clock_hz == 0) return BISS_BAD_SETUP;
  const Parts parts(*device);
  if (!device->has_common) {
    const auto of_profile = profile_format(static_cast<std::uint16_t>(device->profile));
    if (!device->has_profile || !of_profile.ok()) return BISS_BAD_EDS;
    *format = as_c(*of_profile, {});
    return BISS_OK;
  }
  // Symbols and remarks are literals, so they end with a zero.
  const auto tell = [&](const auto& each, auto kind, std::uint32_t stored, std::uint32_t used) {
    if (remark == nullptr) return;
    remark(user, each.channel, each.symbol.data(), text_of(kind).data(), stored, used);
  };
  bool contradiction = false;
  check_eds(parts.image, [&](const EdsFinding& each) {
    contradiction = contradiction || contradicts(each);
    tell(each, each.problem, each.value, each.expected);
  });
  const auto found = describe_device(parts.image, {}, [&](const EdsRemark& each) {
    tell(each, each.kind, each.stored, each.used);
  });
  if (!found.ok() || contradiction) return BISS_BAD_EDS;
  *format = as_c(found->format, timing_at(*found, hertz(clock_hz)));
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
