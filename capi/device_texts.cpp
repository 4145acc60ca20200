// Formats as texts.
#include <algorithm>
#include <cstddef>
#include <string_view>

#include "biss/catalogue/catalogue.hpp"
#include "biss/configure/named_device.hpp"
#include "biss/frame/format_text.hpp"
#include "capi/device.hpp"

namespace biss::capi {

extern "C" {

size_t biss_encoder_count(void) { return catalogue.size(); }

const char* biss_encoder_name(size_t index) {
  return index < biss_encoder_count() ? catalogue[index].name.data() : nullptr;
}

biss_status biss_format_parse(const char* text, biss_format* format) {
  if (text == nullptr || format == nullptr) return BISS_NULL_ARGUMENT;
  const auto device = read_device(text);
  if (!device.ok()) return BISS_BAD_FORMAT;
  *format = as_c(device->format, device->timing);
  return BISS_OK;
}

const char* biss_format_problem(const char* text, size_t* at) {
  if (at != nullptr) *at = 0;
  const auto device = read_device(text == nullptr ? "" : text);
  if (device.ok()) return nullptr;
  if (at != nullptr) *at = device.error().item.at;
  return text_of(device.error()).data();
}

biss_status biss_format_text(const biss_format* format, char* text, size_t room, size_t* length) {
  if (text == nullptr) return BISS_NULL_ARGUMENT;
  Described device;
  if (const auto wrong = read(format, device)) return wrong;
  const FormatText whole = format_text(device.format);
  const std::string_view view = whole.view();
  if (length != nullptr) *length = view.size();
  if (room <= view.size()) return BISS_NO_ROOM;
  std::copy(view.begin(), view.end(), text);
  text[view.size()] = '\0';
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
