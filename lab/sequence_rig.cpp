#include "lab/sequence_rig.hpp"

#include <limits>

namespace biss::lab {
namespace {

using safety_detail::elapsed;
using safety_detail::later;

// The clock of every fourth block wraps around in its first second.
Picoseconds clock_of(std::uint64_t block, sim::Random& random) {
  if (block % 4 != 3) return {};
  const auto before = static_cast<std::int64_t>(random.below(1'000'000) * 1'000'000);
  return {std::numeric_limits<std::int64_t>::max() - before};
}

}  // namespace

SequenceRig::SequenceRig(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
                         std::uint64_t block, WordRule rule, const SequenceWatcher& watcher)
    : frame_(frame),
      watcher_(watcher),
      random_(sim::scrambled(row.seed(seed)) + block),
      encoder_(frame, row.encoder_counter, row.motion, rule, random_.next()),
      monitor_(frame.ready()),
      now_(clock_of(block, random_)) {}

void SequenceRig::begin(std::uint64_t index) {
  index_ = index;
  due_.reset();
  verdict_.reset();
  cycles_ = 0;
  accepted_ = false;
  wrong_ = false;
}

const SequenceWords& SequenceRig::own() {
  newest_ = (newest_ + 1U) % remembered;
  past_[newest_] = encoder_.next();
  return past_[newest_];
}

const SequenceWords& SequenceRig::past(std::size_t age) const {
  return past_[(newest_ + remembered - age) % remembered];
}

void SequenceRig::tell(std::string_view what, const BitView& bits, const SequenceWords* meant,
                       const SafetyJudgement& told) const {
  watcher_({.index = index_,
            .time = now_,
            .what = what,
            .bits = bits,
            .meant = meant != nullptr ? std::optional(*meant) : std::nullopt,
            .told = told});
}

void SequenceRig::pass(Picoseconds time) { now_ = later(now_, time); }

void SequenceRig::pass_watched(Picoseconds time) {
  const Picoseconds end = later(now_, time);
  const std::optional<Picoseconds> deadline = monitor_.deadline();
  if (deadline && elapsed(now_, *deadline).count >= 0 && elapsed(now_, *deadline) < time) {
    now_ = *deadline;
    const SafetyJudgement still = monitor_.watch(now_);
    if (watcher_) tell("watch", {}, nullptr, still);
    if (is_fault(still.verdict)) alarm();
    pass(picoseconds(1));
    const SafetyJudgement late = monitor_.watch(now_);
    if (watcher_) tell("watch", {}, nullptr, late);
    note(late, nullptr);
  }
  now_ = end;
}

bool SequenceRig::good(bool may_start) { return good(own(), may_start); }

bool SequenceRig::good(const SequenceWords& words, bool may_start) {
  const FrameBits bits = frame_.encode(words, random_);
  const bool was_content = !is_fault(monitor_.watch(now_).verdict);
  const SafetyJudgement told = monitor_.step(now_, bits.view());
  if (watcher_) tell("frame", bits.view(), &words, told);
  ++counts_.frames;
  const bool safe = told.verdict == SafetyVerdict::safe && told.state == SafetyState::safe;
  const bool starts = may_start && told.verdict == SafetyVerdict::starting;
  const bool content = was_content && (safe || starts);
  const bool right = told.position.has_value() == safe &&
                     told.position.value_or(words.cpw) == words.cpw &&
                     told.life_counter == words.life_counter && told.cpw_nW == words.cpw_nW &&
                     told.spw_nW == words.spw_nW;
  if (!content) {
    alarm();
  } else if (!right) {
    ++counts_.misread;
    counts_.add_odd(index_);
  }
  return content && right;
}

void SequenceRig::fault_begins() {
  if (!due_) due_ = now_;
}

void SequenceRig::note(const SafetyJudgement& told, const SequenceWords* meant) {
  if (told.position) {
    accepted_ = true;
    wrong_ = wrong_ || meant == nullptr || *told.position != meant->cpw;
  }
  if (verdict_ || !is_fault(told.verdict)) return;
  verdict_ = told.verdict;
  const std::int64_t cycle = frame_.cycle().count;
  const std::int64_t since = elapsed(due_.value_or(now_), now_).count;
  cycles_ = static_cast<std::uint64_t>((since + cycle - 1) / cycle);
}

void SequenceRig::show(const FrameBits& bits, const SequenceWords& meant) {
  const SafetyJudgement told = monitor_.step(now_, bits.view());
  if (watcher_) tell("fault", bits.view(), &meant, told);
  note(told, &meant);
}

void SequenceRig::silence(const SequenceWords& meant) {
  const SafetyJudgement told = monitor_.step(now_, BitView());
  if (watcher_) tell("silence", {}, &meant, told);
  note(told, &meant);
}

void SequenceRig::settle(bool forget) {
  pass(frame_.setup().frame_gap_max + frame_.cycle());
  monitor_.watch(now_);
  monitor_.acknowledge();
  if (forget) monitor_.restart();
}

}  // namespace biss::lab
