#include "capture/ghw.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/ghw_header.hpp"
#include "capture/step_source.hpp"
#include "capture/timescale.hpp"

namespace biss::capture {
namespace {

using namespace std::string_view_literals;
using wire::Level;

constexpr std::string_view ghw_magic = "GHDLwave\n"sv;
constexpr Timescale femtoseconds{1, 1'000};

class GhwReader final : public StepSource {
 public:
  GhwReader(std::unique_ptr<GhwStream> stream, GhwHeader header)
      : StepSource(header.lines.take_names()),
        stream_(std::move(stream)),
        driven_(header.lines, header.variables),
        signals_(std::move(header.signals)),
        letters_(std::move(header.letters)),
        held_levels_(header.variables, no_level) {}

 private:
  enum class State : std::uint8_t { section, snapshot, changes, next_time };

  void fail(CaptureCause cause, const char* expected) {
    const bool missing = stream_->failed();
    StepSource::fail(
        {.cause = missing ? stream_->cause() : cause,
         .expected = missing ? "the end mark of a GHW: let GHDL finish the simulation" : expected,
         .part = nullptr});
  }
  void malformed(const char* expected) { fail(CaptureCause::malformed, expected); }

  void step() override;
  void begin_section();
  void skip_directory();
  void read_value();
  void read_change();
  void next_time();
  bool set_time(std::int64_t femtosecond);
  void release();

  std::unique_ptr<GhwStream> stream_;
  DrivenLines driven_;
  std::vector<GhwSignal> signals_;
  std::vector<std::vector<Level>> letters_;
  // The values of a snapshot are held: the cycle after it may change them at the same time, and a
  // VCD has only what they are then.
  std::vector<std::uint8_t> held_levels_;
  bool held_ = false;
  State state_ = State::section;
  std::int64_t time_ = 0;
  std::size_t signal_ = 0;  // of a snapshot the next one; of changes the last one, from 1
};

// Each step pushes at most one edge a line.
void GhwReader::step() {
  switch (state_) {
    case State::section:
      return begin_section();
    case State::snapshot:
      if (signal_ != signals_.size()) return read_value();
      state_ = State::section;
      if (const auto end = stream_->name(); std::string_view(end.data(), 4) != "ESN\0"sv) {
        malformed("ESN after a snapshot");
      }
      return;
    case State::changes:
      return read_change();
    case State::next_time:
      return next_time();
  }
}

void GhwReader::begin_section() {
  const std::array<char, 4> name = stream_->name();
  const std::string_view section(name.data(), name.size());
  if (section == "SNP\0"sv) {
    stream_->skip(4);
    signal_ = 0;
    if (!set_time(stream_->time())) return;
    state_ = State::snapshot;
    held_ = true;
  } else if (section == "CYC\0"sv) {
    signal_ = 0;
    if (set_time(stream_->time())) state_ = State::changes;
  } else if (section == "DIR\0"sv) {
    skip_directory();
  } else if (section == "TAI\0"sv) {
    stream_->skip(8);
    finish();
    release();
    if (stream_->failed()) malformed("the place of the directory");
  } else {
    malformed("the section SNP, CYC, DIR or TAI");
  }
}

void GhwReader::skip_directory() {
  constexpr std::size_t entry_bytes = 8;
  stream_->skip(4);
  for (std::uint32_t left = stream_->word(); left != 0 && !stream_->failed(); --left) {
    stream_->skip(entry_bytes);
  }
  const std::array<char, 4> end = stream_->name();
  if (std::string_view(end.data(), 4) != "EOD\0"sv) malformed("EOD after the directory");
}

bool GhwReader::set_time(std::int64_t femtosecond) {
  if (stream_->failed() || femtosecond < 0) {
    fail(CaptureCause::time_out_of_range, nullptr);
  } else if (femtosecond < time_) {
    fail(CaptureCause::time_backwards, nullptr);
  } else {
    if (femtosecond != time_) release();
    time_ = femtosecond;
    now_ = femtoseconds.time_of(static_cast<std::uint64_t>(femtosecond));
    return true;
  }
  return false;
}

// \pre signal_ < signals_.size()
void GhwReader::read_value() {
  const GhwSignal& signal = signals_[signal_++];
  if (signal.value == GhwValue::number) {
    stream_->signed_number();
  } else if (signal.value == GhwValue::real) {
    stream_->skip(8);
  } else {
    const std::uint8_t letter = stream_->byte();
    if (stream_->failed()) return malformed(nullptr);
    if (signal.variable == GhwSignal::no_variable) return;
    const std::vector<Level>& meanings = letters_[signal.type];
    if (letter >= meanings.size()) return malformed("a value that the type has");
    if (held_) {
      held_levels_[signal.variable] = static_cast<std::uint8_t>(meanings[letter]);
    } else {
      driven_.set(signal.variable, meanings[letter], now_, block_);
    }
  }
  if (stream_->failed()) malformed(nullptr);
}

void GhwReader::read_change() {
  const std::uint32_t step = stream_->unsigned_number();
  if (stream_->failed()) return malformed(nullptr);
  if (step == 0) {
    state_ = State::next_time;
    return;
  }
  if (step > signals_.size() - signal_) return malformed("a change of a signal that there is");
  signal_ += step - 1;
  read_value();
}

void GhwReader::release() {
  if (!std::exchange(held_, false)) return;
  for (std::uint32_t variable = 0; variable < held_levels_.size(); ++variable) {
    const std::uint8_t level = std::exchange(held_levels_[variable], no_level);
    if (level != no_level) driven_.set(variable, static_cast<Level>(level), now_, block_);
  }
}

void GhwReader::next_time() {
  if (held_) return release();
  const std::int64_t delta = stream_->signed_number();
  if (!stream_->failed() && delta == -1) {
    state_ = State::section;
    const std::array<char, 4> end = stream_->name();
    if (std::string_view(end.data(), 4) != "ECY\0"sv) malformed("ECY after the last cycle");
    return;
  }
  if (delta < 0) return fail(CaptureCause::time_backwards, nullptr);
  if (delta > std::numeric_limits<std::int64_t>::max() - time_) {
    return fail(CaptureCause::time_out_of_range, nullptr);
  }
  signal_ = 0;
  if (set_time(time_ + delta)) state_ = State::changes;
}

}  // namespace

bool looks_like_ghw(std::string_view head) { return head.starts_with(ghw_magic); }

Opened open_ghw(std::unique_ptr<ByteSource> bytes) {
  auto stream = std::make_unique<GhwStream>(std::move(bytes));
  auto header = read_ghw_header(*stream);
  if (!header) return tl::unexpected(header.error());
  return std::make_unique<GhwReader>(std::move(stream), std::move(*header));
}

}  // namespace biss::capture
