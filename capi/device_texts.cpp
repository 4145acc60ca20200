// Formats and timings of devices by name.
#include <cstddef>

#include "biss/catalogue/catalogue.hpp"
#include "capi/device.hpp"

extern "C" {

size_t biss_encoder_count(void) { return biss::catalogue.size(); }

const char* biss_encoder_name(size_t index) {
  return index < biss_encoder_count() ? biss::catalogue[index].name.data() : nullptr;
}

const char* biss_format_problem(const char* format, size_t* at) {
  if (at != nullptr) *at = 0;
  const auto device = biss::read_device(format == nullptr ? "" : format);
  if (device.ok()) return nullptr;
  if (at != nullptr) *at = device.error().item.at;
  return biss::text_of(device.error()).data();
}

biss_status biss_timing_of(const char* format, biss_timing* timing) {
  if (format == nullptr || timing == nullptr) return BISS_NULL_ARGUMENT;
  const auto device = biss::capi::find_device(format);
  if (!device) return BISS_BAD_FORMAT;
  *timing = biss::capi::as_c(device->timing);
  return BISS_OK;
}

biss_status biss_channels_of(const char* format, size_t* channels) {
  if (format == nullptr || channels == nullptr) return BISS_NULL_ARGUMENT;
  const auto device = biss::capi::find_device(format);
  if (!device) return BISS_BAD_FORMAT;
  *channels = device->format.channel_count;
  return BISS_OK;
}

}  // extern "C"
