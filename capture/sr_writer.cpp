#include "capture/sr_writer.hpp"

#include "capture/sr_metadata.hpp"

namespace biss::capture {
namespace {

// As sigrok-cli cuts them. Runs of samples divide it, so that chunks hold whole samples.
constexpr std::size_t chunk_bytes = 4U * 1024U * 1024U;

}  // namespace

SrWriter::SrWriter(const std::vector<std::string>& lines, Hertz rate, ByteSink& sink)
    : SampledWriter(packed_layout(lines, rate), sink) {
  if (lines.size() > 8 * max_unit_bytes) return;
  archive_.add("version", "2", text());
  archive_.add("metadata", sr_metadata_text(packed_layout(lines, rate)), text());
}

bool SrWriter::put_samples(std::string_view bytes) {
  if (chunk_.size() + bytes.size() > chunk_bytes && !put_chunk()) return false;
  chunk_ += bytes;
  return true;
}

bool SrWriter::put_chunk() {
  if (!archive_.add("logic-1-" + std::to_string(++chunks_), chunk_, text())) {
    refuse(WriteCause::too_large);
  }
  chunk_.clear();
  return flush_full();
}

void SrWriter::put_close() {
  if (put_chunk()) archive_.finish(text());
}

}  // namespace biss::capture
