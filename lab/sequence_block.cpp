#include "lab/sequence_block.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace biss::lab {
namespace {

// The clock of every fourth block wraps around in its first second.
Picoseconds clock_of(std::uint64_t block, sim::Random& random) {
  if (block % 4 != 3) return {};
  const auto before = static_cast<std::int64_t>(random.below(1'000'000) * 1'000'000);
  return Picoseconds{std::numeric_limits<std::int64_t>::max() - before};
}

// A monitor, its encoder and the clock between them; every call of the monitor is counted.
class SequenceRig {
 public:
  SequenceRig(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
              std::uint64_t block, WordRule rule, const SequenceWatcher& watcher);

  const SequenceFrame& frame() const { return frame_; }
  sim::Random& random() { return random_; }
  SequenceEncoder& encoder() { return encoder_; }
  Monitor& monitor() { return monitor_; }
  SequenceCounts& counts() { return counts_; }

  // The following calls of the monitor belong to this frame or event.
  void begin(std::uint64_t index);

  // The encoder's next frame, which is kept.
  const SequenceWords& own();
  // The frame `age` frames before the newest one. \pre age is below `kept`
  const SequenceWords& past(std::size_t age) const;
  static constexpr std::size_t kept = 512;

  // Time passes and the monitor is not called.
  void pass(Picoseconds time);
  // Time passes, and the monitor is called at its deadline and 1 ps later.
  void pass_watched(Picoseconds time);

  // The encoder's next frame, undamaged: it must be safe, or `starting` if may_start. Returns false
  // for a false alarm or a misread frame.
  bool good(bool may_start);
  // The same for words that own() returned.
  bool good(const SequenceWords& words, bool may_start);

  // The fault affects requests from this one on; the first call of an event counts.
  void fault_begins();
  // A frame that must not be safe, instead of `meant`.
  void send_fault(const FrameBits& bits, const SequenceWords& meant);
  // No answer to a request.
  void silence(const SequenceWords& meant);
  // Counts the event. `allowed` returns whether a first verdict is one of the error's.
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
      if (verdict_) ++counts_.verdicts[index_of(*verdict_)];
      if (late) ++counts_.late;
      if (unexpected) ++counts_.unexpected;
      counts_.worst_cycles = std::max(counts_.worst_cycles, cycles_);
      odd = late || unexpected;
    }
    if (odd) counts_.add_odd(index_);
  }

  // A long pause, then the monitor starts again. What it has learned about the counter stays, unless
  // `forget`.
  void settle(bool forget);

 private:
  void note(const SafetyJudgement& judgement, const SequenceWords* meant);
  void log(std::string_view what, const BitView& bits, const SequenceWords* meant,
           const SafetyJudgement& judgement) const;
  void alarm() {
    ++counts_.false_alarms;
    counts_.add_odd(index_);
  }

  const SequenceFrame& frame_;
  const SequenceWatcher& watcher_;
  sim::Random random_;
  SequenceEncoder encoder_;
  Monitor monitor_;
  SequenceCounts counts_;
  Picoseconds now_{};
  std::array<SequenceWords, kept> past_{};
  std::size_t newest_ = 0;

  // The current event.
  std::uint64_t index_ = 0;
  std::optional<Picoseconds> due_;
  std::optional<SafetyVerdict> verdict_;
  std::uint64_t cycles_ = 0;
  bool accepted_ = false;
  bool wrong_ = false;
  // The latest tolerated faults, of all events.
  std::deque<Picoseconds> tolerated_;
};

SequenceRig::SequenceRig(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
                         std::uint64_t block, WordRule rule, const SequenceWatcher& watcher)
    : frame_(frame),
      watcher_(watcher),
      random_(sim::scrambled(row.seed(seed)) + block),
      encoder_(frame, row.encoder_counter, row.motion, rule, random_.next()),
      monitor_(SharedSafetyPlan(frame.plan())),
      now_(clock_of(block, random_)) {
  // It has passed in SequenceFrame::make() already.
  static_cast<void>(monitor_.self_test());
}

void SequenceRig::begin(std::uint64_t index) {
  index_ = index;
  due_.reset();
  verdict_.reset();
  cycles_ = 0;
  accepted_ = false;
  wrong_ = false;
}

const SequenceWords& SequenceRig::own() {
  newest_ = (newest_ + 1U) % kept;
  past_[newest_] = encoder_.next();
  return past_[newest_];
}

const SequenceWords& SequenceRig::past(std::size_t age) const {
  return past_[(newest_ + kept - age) % kept];
}

void SequenceRig::log(std::string_view what, const BitView& bits, const SequenceWords* meant,
                      const SafetyJudgement& judgement) const {
  watcher_({.index = index_,
            .time = now_,
            .what = what,
            .bits = bits,
            .meant = meant != nullptr ? std::optional(*meant) : std::nullopt,
            .judgement = judgement,
            .position_read = judgement.position ? std::optional(control_position(
                                                      frame_.plan(), *judgement.position))
                                                : std::nullopt});
}

void SequenceRig::pass(Picoseconds time) { now_ = wrapping_later(now_, time); }

void SequenceRig::pass_watched(Picoseconds time) {
  const Picoseconds end = wrapping_later(now_, time);
  const std::optional<Picoseconds> deadline = monitor_.deadline();
  if (deadline && wrapping_elapsed(now_, *deadline).count >= 0 &&
      wrapping_elapsed(now_, *deadline) < time) {
    now_ = *deadline;
    const SafetyJudgement still = monitor_.watch(now_);
    if (watcher_) log("watch", {}, nullptr, still);
    if (is_fault(still.verdict)) alarm();
    pass(picoseconds(1));
    const SafetyJudgement late = monitor_.watch(now_);
    if (watcher_) log("watch", {}, nullptr, late);
    note(late, nullptr);
  }
  now_ = end;
}

bool SequenceRig::good(bool may_start) { return good(own(), may_start); }

bool SequenceRig::good(const SequenceWords& words, bool may_start) {
  const FrameBits bits = frame_.encode(words, random_);
  const bool was_safe = !is_fault(monitor_.watch(now_).verdict);
  const SafetyJudgement judgement = monitor_.step(now_, bits.view());
  if (watcher_) log("frame", bits.view(), &words, judgement);
  ++counts_.frames;
  const bool safe =
      judgement.verdict == SafetyVerdict::safe && judgement.state == SafetyState::safe;
  const bool starts = may_start && judgement.verdict == SafetyVerdict::starting;
  const bool expected = was_safe && (safe || starts);
  const bool right = judgement.position.has_value() == safe &&
                     (!safe || control_position(frame_.plan(), *judgement.position) == words.cpw) &&
                     judgement.life_counter == words.life_counter &&
                     judgement.cpw_nW == words.cpw_nW && judgement.spw_nW == words.spw_nW;
  if (!expected) {
    alarm();
  } else if (!right) {
    ++counts_.misread;
    counts_.add_odd(index_);
  }
  return expected && right;
}

void SequenceRig::fault_begins() {
  if (!due_) due_ = now_;
}

void SequenceRig::note(const SafetyJudgement& judgement, const SequenceWords* meant) {
  if (judgement.position) {
    accepted_ = true;
    wrong_ = wrong_ || meant == nullptr ||
             control_position(frame_.plan(), *judgement.position) != meant->cpw;
  }
  const SafetyBudget& budget = frame_.setup().budget;
  if (judgement.tolerated) {
    tolerated_.push_back(now_);
    if (tolerated_.size() > budget.faults) {
      if (wrapping_elapsed(tolerated_.front(), now_) <= budget.window) alarm();
      tolerated_.pop_front();
    }
  }
  if (verdict_ || !is_fault(judgement.verdict)) return;
  verdict_ = judgement.verdict;
  const std::int64_t cycle = frame_.cycle().count;
  const std::int64_t since = wrapping_elapsed(due_.value_or(now_), now_).count;
  cycles_ = static_cast<std::uint64_t>((since + cycle - 1) / cycle);
}

void SequenceRig::send_fault(const FrameBits& bits, const SequenceWords& meant) {
  const SafetyJudgement judgement = monitor_.step(now_, bits.view());
  if (watcher_) log("fault", bits.view(), &meant, judgement);
  note(judgement, &meant);
}

void SequenceRig::silence(const SequenceWords& meant) {
  const SafetyJudgement judgement = monitor_.step(now_, BitView());
  if (watcher_) log("silence", {}, &meant, judgement);
  note(judgement, &meant);
}

void SequenceRig::settle(bool forget) {
  pass(frame_.setup().frame_gap_max + frame_.cycle());
  monitor_.watch(now_);
  monitor_.acknowledge();
  if (forget) monitor_.encoder_restarted();
}

constexpr unsigned most_repeats = 8;
constexpr unsigned most_exchanged = 8;
constexpr unsigned most_lost = 62;
constexpr unsigned most_periods = 4;
constexpr unsigned most_foreign = 64;

// Injects the events of one row.
class FaultRun {
 public:
  FaultRun(SequenceRig& rig, const SequenceRow& row)
      : rig_(rig), row_(row), injection_(row.injection()) {
    if (injection_ == Injection::corrupt) corruption_ = *parse_fault(row.variant_name());
  }

  // One event. \pre the monitor is safe and the next request is due now
  void inject() {
    switch (injection_) {
      case Injection::corrupt:
        return corrupt();
      case Injection::previous:
        return repeat(1);
      case Injection::older:
        return repeat(any_of(2, row_.period() - 1));
      case Injection::any_age:
        return repeat(any_of(1, most_periods * row_.period()));
      case Injection::exchanged:
      case Injection::shuffled:
      case Injection::overtaken:
        return exchange();
      case Injection::no_answer:
        return lose_answers();
      case Injection::skipped:
        return skip();
      case Injection::not_called:
        return lose_calls(any_of(1, row_.period() - 1));
      case Injection::whole_period:
        return lose_calls(row_.period() * any_of(1, most_periods));
      case Injection::watched:
      case Injection::unwatched:
        return delay();
      case Injection::stored:
        return store();
      case Injection::constant:
        return;  // count_constant()
      case Injection::stale:
        return insert(true);
      case Injection::foreign:
        return insert(false);
      case Injection::noise:
      case Injection::noise_word:
      case Injection::standard:
        return disguise();
      case Injection::wrong_start_value:
        return send_with(rig_.frame().other_starts());
      case Injection::polynomial:
        return send_with(rig_.frame().other_polynomials());
      case Injection::one_frame:
      case Injection::foreign_start_value:
        return address(1);
      case Injection::permanent:
        return address(any_of(2, most_foreign));
    }
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return rig_.random().below(limit); }
  // first…last
  unsigned any_of(unsigned first, unsigned last) {
    return first + static_cast<unsigned>(below(last - first + 1U));
  }
  FrameBits bits_of(const SequenceWords& words) {
    return rig_.frame().encode(words, rig_.random());
  }
  FrameBits bits_of(const SequenceWords& words, const std::vector<SequenceFrame::Codec>& others) {
    return rig_.frame().encode(words, others[below(others.size())], rig_.random());
  }
  Picoseconds cycle() const { return rig_.frame().cycle(); }
  void send_fault(const FrameBits& bits, const SequenceWords& meant) {
    rig_.fault_begins();
    rig_.send_fault(bits, meant);
  }

  void corrupt() {
    const SequenceWords meant = rig_.own();
    FrameBits bits = bits_of(meant);
    if (corruption_.kind == FaultKind::burst) {
      flip_burst(bits);
    } else {
      while (!flip_some(bits)) {
      }
    }
    send_fault(bits, meant);
  }
  // Returns false if no bit was drawn.
  bool flip_some(FrameBits& bits) {
    bool any = false;
    for (std::size_t at = rig_.frame().payload_at(bits); at + 1 < bits.size_bits(); ++at) {
      if ((rig_.random().next() >> 32U) >= corruption_.rate) continue;
      bits.flip(at);
      any = true;
    }
    return any;
  }
  void flip_burst(FrameBits& bits) {
    const std::size_t payload = rig_.frame().payload_at(bits);
    const unsigned length = corruption_.length_bits;
    const std::size_t first = payload + below(bits.size_bits() - payload - length);
    const std::uint64_t pattern = rig_.random().next();
    for (unsigned k = 0; k < length; ++k) {
      if (k == 0 || k + 1 == length || ((pattern >> k) & 1U) != 0) bits.flip(first + k);
    }
  }

  void repeat(unsigned age) {
    rig_.own();
    const FrameBits old = bits_of(rig_.past(age));
    for (unsigned left = any_of(1, most_repeats); left != 0; --left) {
      send_fault(old, rig_.past(0));
      if (left == 1) break;
      rig_.pass(cycle());
      rig_.own();
    }
  }

  void exchange() {
    const unsigned count = any_of(2, most_exchanged);
    std::array<SequenceWords, most_exchanged> frames;
    std::array<std::uint8_t, most_exchanged> order{};
    for (unsigned n = 0; n < count; ++n) frames[n] = rig_.own();
    mix(order, count);
    bool begun = false;
    for (unsigned n = 0; n < count; ++n) {
      if (n != 0) rig_.pass(cycle());
      begun = begun || order[n] != n;
      if (begun) {
        send_fault(bits_of(frames[order[n]]), frames[n]);
      } else {
        rig_.good(frames[n], false);
      }
    }
  }
  // Any order but the right one.
  void mix(std::array<std::uint8_t, most_exchanged>& order, unsigned count) {
    const auto end = order.begin() + count;
    std::iota(order.begin(), end, std::uint8_t{0});
    if (injection_ == Injection::overtaken) {
      std::rotate(order.begin(), order.begin() + 1, end);
    } else if (injection_ == Injection::exchanged) {
      const unsigned one = any_of(0, count - 2);
      std::swap(order[one], order[any_of(one + 1, count - 1)]);
    } else {
      while (std::is_sorted(order.begin(), end)) {
        for (unsigned n = count - 1; n != 0; --n) std::swap(order[n], order[any_of(0, n)]);
      }
    }
  }

  void send_own() {
    const SequenceWords meant = rig_.own();
    send_fault(bits_of(meant), meant);
  }

  // Requests without an answer; the encoder may have counted them or not.
  void lose_answers() {
    const unsigned count = any_of(1, most_lost);
    const bool counts = below(2) != 0;
    for (unsigned left = count; left != 0; --left) {
      if (counts) rig_.own();
      rig_.fault_begins();
      rig_.silence(rig_.past(0));
      rig_.pass(cycle());
    }
    send_own();
  }
  void skip() {
    for (unsigned left = any_of(1, row_.period() - 1); left != 0; --left) rig_.own();
    send_own();
  }
  void lose_calls(unsigned count) {
    rig_.fault_begins();
    for (unsigned left = count; left != 0; --left) {
      rig_.own();
      rig_.pass_watched(cycle());
    }
    send_own();
  }

  // From now on every frame comes some cycles late.
  void store() {
    const unsigned late = any_of(1, most_lost);
    for (unsigned n = 0; n < late + 3; ++n) {
      const SequenceWords meant = rig_.own();
      rig_.fault_begins();
      if (n < late) {
        rig_.silence(meant);
      } else {
        rig_.send_fault(bits_of(rig_.past(late)), meant);
      }
      rig_.pass(cycle());
    }
  }
  void delay() {
    const Picoseconds least = rig_.frame().setup().frame_gap_max - cycle() + picoseconds(1);
    if (injection_ == Injection::watched) {
      rig_.fault_begins();
      rig_.pass_watched(least + longer());
    } else {
      rig_.pass(least + longer());
    }
    send_own();
  }
  // 0, or up to 128 cycles, every magnitude equally often.
  Picoseconds longer() {
    if (below(4) == 0) return {};
    const std::uint64_t share = rig_.random().next() >> 44U;
    return sim::part_of(cycle() * 128 / (std::int64_t{1} << below(20)), share);
  }

  void insert(bool stale) {
    rig_.pass(-(cycle() / 2));  // between two requests
    const SequenceWords& last = rig_.past(0);
    const SequenceWords inserted =
        stale ? rig_.past(below(row_.period() - 1)) : rig_.encoder().foreign(rig_.random());
    send_fault(bits_of(inserted), last);
  }

  // The right content with another checksum.
  void send_with(const std::vector<SequenceFrame::Codec>& others) {
    const SequenceWords meant = rig_.own();
    send_fault(bits_of(meant, others), meant);
  }
  // Noise instead of the words or of the safety word, or zeros instead of the safety word.
  void disguise() {
    const SequenceWords meant = rig_.own();
    FrameBits bits = bits_of(meant);
    const std::size_t payload = rig_.frame().payload_at(bits);
    const std::size_t word = payload + rig_.frame().words().cpw_bits();
    std::size_t at = injection_ == Injection::noise ? payload : word;
    for (; at + 1 < bits.size_bits(); ++at) {
      const bool flip =
          injection_ == Injection::standard ? bits.view()[at] : (rig_.random().next() >> 63U) != 0;
      if (flip) bits.flip(at);
    }
    send_fault(bits, meant);
  }

  void address(unsigned count) {
    SequenceWords other = rig_.encoder().foreign(rig_.random());
    for (unsigned n = 0; n < count; ++n) {
      if (n != 0) rig_.pass(cycle());
      const SequenceWords meant = rig_.own();
      send_fault(injection_ == Injection::foreign_start_value
                     ? bits_of(other, rig_.frame().other_starts())
                     : bits_of(other),
                 meant);
      // It does not move, but counts.
      other.life_counter = other.life_counter == 63
                               ? static_cast<std::uint8_t>(64 - row_.period())
                               : static_cast<std::uint8_t>(other.life_counter + 1);
    }
  }

  SequenceRig& rig_;
  const SequenceRow& row_;
  Injection injection_;
  FaultChoice corruption_{};
};

// The number of frames that may be `starting`; the next one must be safe.
unsigned start_up_frames(const SequenceFrame& frame, const SequenceRow& row) {
  const SafetySetup& setup = frame.setup();
  const unsigned learning =
      row.counter == CounterMode::learned ? setup.counter.learn_rollovers * row.period() : 0;
  return std::max(setup.start_frames - 1U, learning);
}

// From the cycle to the watchdog's bound; the bound itself in 1 of 64 cases.
Picoseconds gap(const SequenceFrame& frame, sim::Random& random) {
  const std::uint64_t drawn = random.next();
  if (drawn % 64 == 0) return frame.setup().frame_gap_max;
  const Picoseconds room = frame.setup().frame_gap_max - frame.cycle();
  return frame.cycle() + sim::part_of(room, (drawn >> 48U) * (sim::time_parts >> 16U));
}

SequenceCounts count_undamaged(const SequenceFrame& frame, const SequenceRow& row,
                               std::uint64_t seed, std::uint64_t block,
                               const SequenceWatcher& watcher) {
  const WordRule rule = block % 2 == 0 ? WordRule::truncated : WordRule::rounded;
  SequenceRig rig(frame, row, seed, block, rule, watcher);
  const unsigned start_up = start_up_frames(frame, row);
  unsigned may_start = start_up;
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    rig.pass(gap(frame, rig.random()));
    const bool good = rig.good(may_start != 0);
    if (rig.monitor().state() == SafetyState::safe) may_start = 0;
    if (may_start != 0) --may_start;
    if (good) continue;
    rig.monitor().acknowledge();
    if (rig.monitor().state() != SafetyState::safe) may_start = start_up;
  }
  rig.counts().position_wraps = rig.encoder().position_wraps();
  rig.counts().counter_wraps = rig.encoder().counter_wraps();
  return rig.counts();
}

// Good frames up to the first one that shows that the encoder's range is the other one.
void try_counter_mode(SequenceRig& rig, const SequenceRow& row) {
  const bool counts_zero = row.encoder_counter == CounterMode::count_0_63;
  const unsigned start_up = rig.frame().setup().start_frames - 1U;
  for (unsigned shown = 0; shown <= 2 * row.period(); ++shown) {
    rig.pass(rig.frame().cycle());
    const SequenceWords& words = rig.own();
    const bool shows =
        counts_zero ? words.life_counter == 0 : words.life_counter == 1 && shown != 0;
    if (shows) {
      rig.fault_begins();
      rig.send_fault(rig.frame().encode(words, rig.random()), words);
      return;
    }
    rig.good(words, shown < start_up);
  }
}

// Every second trial continues from the one before, as after an acknowledgement in a machine.
SequenceCounts count_counter_mode(const SequenceFrame& frame, const SequenceRow& row,
                                  std::uint64_t seed, std::uint64_t block,
                                  const SequenceWatcher& watcher) {
  SequenceRig rig(frame, row, seed, block, WordRule::truncated, watcher);
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    if (n % 2 == 0) {
      rig.settle(true);
      rig.encoder().put_elsewhere();
    } else {
      rig.monitor().acknowledge();
    }
    try_counter_mode(rig, row);
    rig.close_event(0,
                    [](SafetyVerdict verdict) { return verdict == SafetyVerdict::counter_mode; });
  }
  return rig.counts();
}

// The position that a monitor gives for these words.
std::uint64_t value_of(const SequenceFrame& frame, const SequenceWords& words) {
  const SafetyFinding finding{.cpw_position = words.cpw, .spw_position = words.spw};
  return FieldEvaluation<SequenceFrame::Plan>::safe_position(frame.plan(), finding).value;
}

// Since power-up every answer is that to an earlier request, until and after a stimulus.
class ConstantRun {
 public:
  ConstantRun(SequenceRig& rig, const SequenceRow& row)
      : rig_(rig), late_(1U + below(row.period() - 1U)) {
    rig_.settle(true);
    // Instead of what the event before has left.
    rig_.monitor().expect_position(0, ~std::uint64_t{0});
    rig_.encoder().put_elsewhere();
    for (unsigned frames = late_; frames != 0; --frames) rig_.own();
  }

  // \param starting the number of frames that may be `starting`
  void inject(std::uint64_t index, unsigned starting) {
    request();
    for (unsigned left = below(starting + 8U); left != 0 || !is_moved(); left -= left != 0) {
      rig_.send_fault(stale_bits(), rig_.past(0));
      request();
    }
    const std::uint64_t at = value_of(rig_.frame(), rig_.past(0));
    rig_.monitor().expect_position(at, at);
    // Nothing could show the delay before.
    rig_.begin(index);
    rig_.fault_begins();
    // Faults before the answer, tolerated or not.
    for (unsigned left = below(most_damaged() + 1U); left != 0; --left) {
      FrameBits damaged = stale_bits();
      damaged.flip(rig_.frame().payload_at(damaged));
      below(2) == 0 ? rig_.silence(rig_.past(0)) : rig_.send_fault(damaged, rig_.past(0));
      request();
    }
    for (unsigned left = starting + 8U; left != 0; --left) {
      rig_.send_fault(stale_bits(), rig_.past(0));
      pretend();
      request();
    }
    rig_.settle(true);
  }

 private:
  unsigned below(unsigned limit) { return static_cast<unsigned>(rig_.random().below(limit)); }
  const SequenceWords& stale() const { return rig_.past(late_); }
  FrameBits stale_bits() { return rig_.frame().encode(stale(), rig_.random()); }
  void request() {
    rig_.pass(rig_.frame().cycle());
    rig_.own();
    rig_.monitor().acknowledge();
  }
  // Fewer than the requests by which the line is late: its answers are from before the stimulus.
  unsigned most_damaged() const { return std::min(3U, late_ - 1U); }
  // Whether the encoder has left all positions that the line may say next.
  bool is_moved() const {
    const std::uint64_t at = value_of(rig_.frame(), rig_.past(0));
    for (unsigned k = 0; k <= most_damaged(); ++k) {
      if (value_of(rig_.frame(), rig_.past(late_ - k)) == at) return false;
    }
    return true;
  }
  // What does not end the fault: the last one is met by the next answer.
  void pretend() {
    const std::uint64_t at = value_of(rig_.frame(), rig_.past(late_ - 1U));
    const unsigned what = below(32);
    if (what == 0) static_cast<void>(rig_.monitor().self_test());
    if (what < 8) rig_.monitor().expect_position(at, at);
  }

  SequenceRig& rig_;
  unsigned late_;
};

SequenceCounts count_constant(const SequenceFrame& frame, const SequenceRow& row,
                              std::uint64_t seed, std::uint64_t block,
                              const SequenceWatcher& watcher) {
  SequenceRig rig(frame, row, seed, block, WordRule::truncated, watcher);
  rig.encoder().warn(false);
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    ConstantRun(rig, row).inject(first + n, start_up_frames(frame, row));
    rig.close_event(reaction_bound(frame, row), [](SafetyVerdict verdict) {
      using enum SafetyVerdict;
      return verdict == stimulus || verdict == no_frame || verdict == cpw_crc;
    });
  }
  return rig.counts();
}

// Whether the fault needs earlier frames.
bool looks_back(const SequenceRow& row) {
  return row.kind == TransmissionError::repetition || row.kind == TransmissionError::insertion;
}

SequenceCounts count_faults(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
                            std::uint64_t block, const SequenceWatcher& watcher) {
  const unsigned start_up = start_up_frames(frame, row);
  SequenceRig rig(frame, row, seed, block, WordRule::truncated, watcher);
  rig.encoder().warn(false);
  FaultRun run(rig, row);
  const SafetyMeasure& measure = safety_measures[static_cast<std::size_t>(row.kind)];
  const unsigned again = frame.setup().start_frames - 1U;
  const bool learns = row.counter == CounterMode::learned;
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    rig.settle(!learns && rig.random().below(2) != 0);
    rig.encoder().put_elsewhere();
    // The encoder goes on while the monitor is not called.
    for (unsigned frames = looks_back(row) ? 256 : 0; frames != 0; --frames) rig.own();
    const unsigned starting = n == 0 ? start_up : again;
    const unsigned good = starting + 1U + static_cast<unsigned>(rig.random().below(8));
    for (unsigned k = 0; k < good; ++k) {
      rig.pass(frame.cycle());
      rig.good(k < starting);
    }
    rig.pass(frame.cycle());
    run.inject();
    rig.close_event(reaction_bound(frame, row),
                    [&](SafetyVerdict verdict) { return measure.may_be(verdict); });
  }
  return rig.counts();
}

}  // namespace

SequenceCounts count_sequence(const SequenceFrame& frame, const SequenceRow& row,
                              std::uint64_t seed, std::uint64_t block,
                              const SequenceWatcher& watcher) {
  switch (row.task) {
    case SequenceTask::undamaged:
      return count_undamaged(frame, row, seed, block, watcher);
    case SequenceTask::counter_mode:
      return count_counter_mode(frame, row, seed, block, watcher);
    case SequenceTask::fault:
      break;
  }
  if (row.is_constant()) return count_constant(frame, row, seed, block, watcher);
  return count_faults(frame, row, seed, block, watcher);
}

unsigned reaction_bound(const SequenceFrame& frame, const SequenceRow& row) {
  const Injection injection = row.injection();
  const bool silent = injection == Injection::not_called || injection == Injection::whole_period ||
                      injection == Injection::watched;
  return silent ? frame.watchdog_cycles() : 0;
}

}  // namespace biss::lab
