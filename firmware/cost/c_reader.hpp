// The reader of the samples in the C interface, from plain data.
#pragma once

#include <bit>

#include "capi/biss_c_frame.h"
#include "firmware/cost/sample.hpp"

namespace cost {

inline biss_spi c_reader;

/// Inlined, as the program of a user has it.
[[gnu::always_inline]] inline biss_status make_c_reader() {
  biss_format described = biss_format_defaults();
  described.channel_count = 1;
  described.cds0 = true;
  described.channels[0] = std::bit_cast<biss_channel_format>(format.channel_list[0]);
  biss_spi_setup chosen = biss_spi_defaults(&described, setup.period.count);
  chosen.line_delay_max_ps = setup.line_delay.max.count;
  return biss_spi_init(&c_reader, &chosen);
}

/// The position of a good frame, all ones of a bad one.
inline std::uint64_t read_in_c(const Sample& sample) {
  biss_frame frame;
  biss_spi_read(&c_reader, sample.bytes.data(), sample.size_bytes, SIZE_MAX, &frame);
  return biss_frame_trusted(&frame) ? frame.channels[0].position : ~std::uint64_t{0};
}

}  // namespace cost
