// A monitor, its encoder and the clock between them, with every call of the monitor counted.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "lab/sequence_block.hpp"
#include "lab/sequence_counts.hpp"
#include "lab/sequence_encoder.hpp"

namespace biss::lab {

class SequenceRig {
 public:
  SequenceRig(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
              std::uint64_t block, WordRule rule, const SequenceWatcher& watcher);

  const SequenceFrame& frame() const { return frame_; }
  sim::Random& random() { return random_; }
  SequenceEncoder& encoder() { return encoder_; }
  SequenceFrame::Monitor& monitor() { return monitor_; }
  SequenceCounts& counts() { return counts_; }

  /// What is seen from now on belongs to this frame or event.
  void begin(std::uint64_t index);

  /// The encoder's next frame, which is then remembered.
  const SequenceWords& own();
  /// Its frame so many frames before that one. \pre age is below `remembered`
  const SequenceWords& past(std::size_t age) const;
  static constexpr std::size_t remembered = 512;

  /// Time passes; nobody calls the monitor.
  void pass(Picoseconds time);
  /// Time passes, and the monitor is called at its deadline and right behind it.
  void pass_watched(Picoseconds time);

  /// The encoder's next frame undamaged, which has to be safe once the monitor is past start-up.
  /// \param may_start it may be `starting` as well
  /// \return false where it is a false alarm, or misread
  bool good(bool may_start);
  /// The same of the words of own(), called before.
  bool good(const SequenceWords& words, bool may_start);

  /// A fault is on the line from this request on; the first call of an event counts.
  void fault_begins();
  /// A frame that must not be safe, in the place of `meant`.
  void show(const FrameBits& bits, const SequenceWords& meant);
  /// No answer to a request.
  void silence(const SequenceWords& meant);
  /// Counts the event.
  /// \param allowed whether its first verdict may be this one
  template <class Allowed>
  void close_event(std::uint64_t bound_cycles, const Allowed& allowed) {
    ++counts_.events;
    bool odd = accepted_;
    if (accepted_) {
      ++counts_.accepted;
      if (wrong_) ++counts_.wrong;
    } else {
      const bool late = !verdict_ || cycles_ > bound_cycles;
      const bool unexpected = verdict_ && !allowed(*verdict_);
      if (verdict_) ++counts_.verdicts[static_cast<std::size_t>(*verdict_)];
      if (late) ++counts_.late;
      if (unexpected) ++counts_.unexpected;
      counts_.worst_cycles = std::max(counts_.worst_cycles, cycles_);
      odd = late || unexpected;
    }
    if (odd) counts_.add_odd(index_);
  }

  /// A long pause, after which the monitor is asked to begin anew, wherever it was. What it has
  /// learned of the counter stays, unless `forget`.
  void settle(bool forget);

 private:
  void note(const SafetyJudgement& told, const SequenceWords* meant);
  void tell(std::string_view what, const BitView& bits, const SequenceWords* meant,
            const SafetyJudgement& told) const;
  void alarm() {
    ++counts_.false_alarms;
    counts_.add_odd(index_);
  }

  const SequenceFrame& frame_;
  const SequenceWatcher& watcher_;
  sim::Random random_;
  SequenceEncoder encoder_;
  SequenceFrame::Monitor monitor_;
  SequenceCounts counts_;
  Picoseconds now_{};
  std::array<SequenceWords, remembered> past_{};
  std::size_t newest_ = 0;

  // Of the event.
  std::uint64_t index_ = 0;
  std::optional<Picoseconds> due_;
  std::optional<SafetyVerdict> verdict_;
  std::uint64_t cycles_ = 0;
  bool accepted_ = false;
  bool wrong_ = false;
};

}  // namespace biss::lab
