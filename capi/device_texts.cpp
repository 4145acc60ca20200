// Formats and timings of devices by name.
#include <cstddef>
#include <string_view>

#include "biss/catalogue/catalogue.hpp"
#include "capi/device.hpp"

extern "C" {

size_t biss_encoder_count(void) { return biss::catalogue.size(); }

const char* biss_encoder_name(size_t index) {
  return index < biss_encoder_count() ? biss::catalogue[index].name.data() : nullptr;
}

const char* biss_format_problem(const char* format, size_t* at) {
  if (at != nullptr) *at = 0;
  const std::string_view text = format == nullptr ? "" : format;
  if (biss::find_encoder(text) != nullptr) return nullptr;
  const auto parsed = biss::parse_format(text);
  if (parsed.ok()) return nullptr;
  if (at != nullptr) *at = parsed.error().at;
  return biss::text_of(parsed.error().mistake).data();  // of a literal: ends with a zero
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
