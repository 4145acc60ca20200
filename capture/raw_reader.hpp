// Raw samples: a file that is nothing but samples.
#pragma once

#include <memory>

#include "capture/byte_source.hpp"
#include "capture/edge_source.hpp"
#include "capture/sample_layout.hpp"

namespace biss::capture {

/// Opens raw samples laid out as `layout` says. Fails with `bad_layout`, `empty`, `read_failed`,
/// `time_out_of_range`, and with `truncated` when the last sample is not whole.
Opened open_raw(std::unique_ptr<ByteSource> bytes, const RawLayout& layout);

}  // namespace biss::capture
