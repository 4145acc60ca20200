#include "capture/sampled_writer.hpp"

#include <algorithm>

namespace biss::capture {
namespace {

constexpr std::size_t most_copies = 8'192;

std::vector<std::string> names_of(const RawLayout& layout) {
  std::vector<std::string> names;
  for (const SampleLine& line : layout.lines) names.push_back(line.name);
  return names;
}

}  // namespace

SampledWriter::SampledWriter(const RawLayout& layout, ByteSink& sink)
    : EdgeWriter(names_of(layout), sink), clock_(layout.rate), unit_bytes_(layout.unit_bytes) {
  if (layout.lines.size() > 8 * max_unit_bytes) refuse(WriteCause::too_many_lines);
  for (const SampleLine& line : layout.lines) bits_.push_back(line.bit);
}

void SampledWriter::put(const wire::Edge& edge, bool) {
  put_until(clock_.first_at_or_after(edge.time));
  const std::uint64_t bit = std::uint64_t{1} << bits_[edge.line];
  levels_ = edge.level == wire::Level::high ? levels_ | bit : levels_ & ~bit;
  copies_.clear();
  last_time_ = edge.time;
}

void SampledWriter::put_end(Picoseconds end_time, bool later) {
  put_until(clock_.first_at_or_after(later ? end_time : last_time_) + 1);
  put_close();
}

// Samples up to the one before `index` show the levels that stand now.
void SampledWriter::put_until(std::uint64_t index) {
  while (next_ < index) {
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(index - next_, most_copies));
    while (copies_.size() < count * unit_bytes_) {
      for (std::size_t i = 0; i < unit_bytes_; ++i) {
        copies_ += static_cast<char>(levels_ >> (8U * i) & 0xFFU);
      }
    }
    if (!put_samples(std::string_view(copies_).substr(0, count * unit_bytes_))) return;
    next_ += count;
  }
}

bool RawWriter::put_samples(std::string_view bytes) {
  text() += bytes;
  return flush_full();
}

}  // namespace biss::capture
