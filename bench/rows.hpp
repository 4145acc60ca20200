// The measured subjects, one function each. Each function adds its rows to the table.
#pragma once

#include "bench/table.hpp"

namespace biss::bench {

void add_crc_rows(Table& table);
/// Decoding frames from SPI buffers, and encoding frames.
void add_frame_rows(Table& table);
/// Format text, turns, and the machine itself: its clock rate and its memory.
void add_core_rows(Table& table);
/// The readers of captures, and the decoder that uses them.
void add_capture_rows(Table& table);
/// Rows of `decode` as text and as columns.
void add_row_rows(Table& table);
/// Sampled captures on their way to the changes of two lines.
void add_samples_rows(Table& table);
/// The line model.
void add_sim_rows(Table& table);
/// Fault campaigns against BiSS Safety.
void add_campaign_rows(Table& table);
/// The command as a whole process.
void add_command_rows(Table& table);

}  // namespace biss::bench
