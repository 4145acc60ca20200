// The member `metadata` of a sigrok session: what its samples mean.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/sample_layout.hpp"

namespace biss::capture {

struct SrMetadata {
  RawLayout layout;
  std::string capture_file;  ///< member with the samples, or the beginning of its chunks' names
};

/// Reads the first device that has logic samples. Sections and keys that say nothing of these are
/// passed over; of a key that stands twice the last counts. Fails with `malformed`: a line that is
/// no `key=value`, a rate, unit size or probe that cannot be, or nothing about logic samples.
std::variant<SrMetadata, CaptureError> parse_sr_metadata(std::string_view text);

/// The metadata that our own files have. \pre fault_of(layout) is null
std::string sr_metadata_text(const RawLayout& layout);

/// `100 MHz`, `12.5 MHz`, `2000000`: hertz, kilohertz, megahertz or gigahertz, with or without
/// `Hz`, rounded to the hertz. 0 Hz for what is no rate, or beyond 4.29 GHz.
Hertz parse_sample_rate(std::string_view text);

}  // namespace biss::capture
