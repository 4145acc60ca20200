#include "lab/sequence_block.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "lab/sequence_theory.hpp"

namespace biss::lab {
namespace {

// The clock of every fourth block wraps around in its first second.
Picoseconds clock_of(std::uint64_t block, sim::Random& random) {
  if (block % 4 != 3) return {};
  const auto before = static_cast<std::int64_t>(random.below(1'000'000) * 1'000'000);
  return Picoseconds{std::numeric_limits<std::int64_t>::max() - before};
}

}  // namespace

// A monitor, its encoder and the clock between them; every call of the monitor is counted.
class SequenceRig {
 public:
  static constexpr std::size_t kept = 512;

  SequenceRig(const SequenceFrame& frame, const SequenceRow& row, std::uint64_t seed,
              std::uint64_t block, WordRule rule, const SequenceWatcher& watcher)
      : frame_(frame),
        watcher_(watcher),
        random_(sim::scrambled(row.seed(seed)) + block),
        encoder_(frame, row.encoder_counter, row.motion, rule, random_.next()),
        monitor_(frame.plan()),
        now_(clock_of(block, random_)) {
    // It has passed in SequenceFrame::make() already.
    static_cast<void>(monitor_.self_test());
  }

  const SequenceFrame& frame() const { return frame_; }
  sim::Random& random() { return random_; }
  SequenceEncoder& encoder() { return encoder_; }
  Monitor& monitor() { return monitor_; }
  SequenceCounts& counts() { return counts_; }

  // The following calls of the monitor belong to this frame or event.
  void begin(std::uint64_t index) { event_ = {.index = index}; }

  // The encoder's next frame, which is kept.
  const SequenceWords& own() {
    newest_ = (newest_ + 1U) % kept;
    past_[newest_] = encoder_.next();
    return past_[newest_];
  }
  // The frame `age` frames before the newest one. \pre age is below `kept`
  const SequenceWords& past(std::size_t age) const { return past_[(newest_ + kept - age) % kept]; }

  // Time passes and the monitor is not called.
  void pass(Picoseconds time) { now_ = wrapping_later(now_, time); }

  // Time passes, and the monitor is called at its deadline and 1 ps later.
  void pass_watched(Picoseconds time) {
    const Picoseconds end = wrapping_later(now_, time);
    const std::optional<Picoseconds> deadline = monitor_.deadline();
    if (deadline && wrapping_elapsed(now_, *deadline).count >= 0 &&
        wrapping_elapsed(now_, *deadline) < time) {
      now_ = *deadline;
      if (is_fault(logged("watch", {}, nullptr, monitor_.watch(OneClock{now_})).verdict)) alarm();
      pass(picoseconds(1));
      note(logged("watch", {}, nullptr, monitor_.watch(OneClock{now_})), nullptr);
    }
    now_ = end;
  }

  // The encoder's next frame, undamaged: it must be safe, or `starting` if may_start. Returns false
  // for a false alarm or a misread frame.
  bool good(bool may_start) { return good(own(), may_start); }
  // The same for words that own() returned.
  bool good(const SequenceWords& words, bool may_start) {
    const FrameBits bits = frame_.encode(words, random_);
    const bool was_safe = !is_fault(monitor_.watch(OneClock{now_}).verdict);
    const SafetyJudgement judgement =
        logged("frame", bits.view(), &words, monitor_.step(OneClock{now_}, bits.view()));
    ++counts_.frames;
    const bool safe =
        judgement.verdict == SafetyVerdict::safe && judgement.state == SafetyState::safe;
    const bool starts = may_start && judgement.verdict == SafetyVerdict::starting;
    const bool expected = was_safe && (safe || starts);
    const bool right = judgement.position.has_value() == safe &&
                       (!safe || position_of(judgement) == words.cpw) &&
                       judgement.life_counter == words.life_counter &&
                       judgement.cpw_nW == words.cpw_nW && judgement.spw_nW == words.spw_nW;
    if (!expected) {
      alarm();
    } else if (!right) {
      ++counts_.misread;
      counts_.add_odd(event_.index);
    }
    return expected && right;
  }

  // The fault affects requests from this one on; the first call of an event counts.
  void fault_begins() {
    if (!event_.due) event_.due = now_;
  }
  // A frame that must not be safe, instead of `meant`.
  void send_fault(const FrameBits& bits, const SequenceWords& meant) {
    note(logged("fault", bits.view(), &meant, monitor_.step(OneClock{now_}, bits.view())), &meant);
  }
  // No answer to a request.
  void silence(const SequenceWords& meant) {
    note(logged("silence", {}, &meant, monitor_.step(OneClock{now_}, BitView())), &meant);
  }

  // Counts the event. `allowed` returns whether a first verdict belongs to the error.
  template <class Allowed>
  void close_event(std::uint64_t bound_cycles, const Allowed& allowed) {
    ++counts_.events;
    bool odd = event_.accepted;
    if (event_.accepted) {
      ++counts_.accepted;
      if (event_.wrong) ++counts_.wrong;
    } else {
      const auto verdict = event_.verdict;
      const bool late = !verdict || event_.cycles > bound_cycles;
      const bool unexpected = verdict && !allowed(*verdict);
      if (verdict) ++counts_.verdicts[index_of(*verdict)];
      if (late) ++counts_.late;
      if (unexpected) ++counts_.unexpected;
      counts_.worst_cycles = std::max(counts_.worst_cycles, event_.cycles);
      odd = late || unexpected;
    }
    if (odd) counts_.add_odd(event_.index);
  }

  // A long pause, then the monitor starts again. It keeps the learned counter mode, unless
  // `forget`.
  void settle(bool forget) {
    pass(frame_.setup().frame_gap_max + frame_.cycle());
    monitor_.watch(OneClock{now_});
    monitor_.acknowledge();
    if (forget) monitor_.encoder_restarted();
  }

 private:
  struct Event {
    std::uint64_t index = 0;
    std::optional<Picoseconds> due{};
    std::optional<SafetyVerdict> verdict{};
    std::uint64_t cycles = 0;
    bool accepted = false;
    bool wrong = false;
  };

  std::uint64_t position_of(const SafetyJudgement& safe) const {
    return control_position(frame_.plan(), *safe.position);
  }

  void alarm() {
    ++counts_.false_alarms;
    counts_.add_odd(event_.index);
  }

  // Shows a call of the monitor to the watcher, and returns its judgement.
  const SafetyJudgement& logged(std::string_view what, const BitView& bits,
                                const SequenceWords* meant,
                                const SafetyJudgement& judgement) const {
    if (!watcher_) return judgement;
    SequenceStep step{
        .index = event_.index, .time = now_, .what = what, .bits = bits, .judgement = judgement};
    if (meant != nullptr) step.meant = *meant;
    if (judgement.position) step.position_read = position_of(judgement);
    watcher_(step);
    return judgement;
  }

  void note(const SafetyJudgement& judgement, const SequenceWords* meant) {
    if (judgement.position) {
      event_.accepted = true;
      event_.wrong = event_.wrong || meant == nullptr || position_of(judgement) != meant->cpw;
    }
    const SafetyBudget& budget = frame_.setup().budget;
    if (judgement.tolerated) {
      tolerated_.push_back(now_);
      if (tolerated_.size() > budget.faults) {
        if (wrapping_elapsed(tolerated_.front(), now_) <= budget.window) alarm();
        tolerated_.pop_front();
      }
    }
    if (event_.verdict || !is_fault(judgement.verdict)) return;
    event_.verdict = judgement.verdict;
    const std::int64_t cycle = frame_.cycle().count;
    const std::int64_t since = wrapping_elapsed(event_.due.value_or(now_), now_).count;
    event_.cycles = static_cast<std::uint64_t>((since + cycle - 1) / cycle);
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
  Event event_;
  // The latest tolerated faults, of all events.
  std::deque<Picoseconds> tolerated_;
};

namespace {

constexpr unsigned most_repeats = 8;
constexpr unsigned most_exchanged = 8;
constexpr unsigned most_lost = 62;
constexpr unsigned most_periods = 4;
constexpr unsigned most_foreign = 64;

}  // namespace

// Injects the events of one row. \pre the monitor is safe and the next request is due now
class FaultRun {
 public:
  FaultRun(SequenceRig& rig, const SequenceRow& row)
      : rig_(rig),
        period_(row.period()),
        corruption_(parse_fault(row.variant_name()).value_or(FaultChoice{})) {}

  const SequenceFrame& frame() const { return rig_.frame(); }
  unsigned period() const { return period_; }
  // first…last
  unsigned any_of(unsigned first, unsigned last) {
    return first + static_cast<unsigned>(below(last - first + 1U));
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

  using Order = std::span<std::uint8_t>;

  // Several frames in an order that `mix` makes: any but the right one.
  void exchange(void (FaultRun::*mix)(Order)) {
    std::array<SequenceWords, most_exchanged> frames;
    std::array<std::uint8_t, most_exchanged> numbers{};
    const Order order(numbers.data(), any_of(2, most_exchanged));
    for (std::size_t n = 0; n < order.size(); ++n) frames[n] = rig_.own();
    std::iota(order.begin(), order.end(), std::uint8_t{0});
    (this->*mix)(order);
    bool begun = false;
    for (std::size_t n = 0; n < order.size(); ++n) {
      if (n != 0) rig_.pass(cycle());
      begun = begun || order[n] != n;
      if (begun) {
        send_fault(bits_of(frames[order[n]]), frames[n]);
      } else {
        rig_.good(frames[n], false);
      }
    }
  }
  void overtake(Order order) { std::rotate(order.begin(), order.begin() + 1, order.end()); }
  void swap_two(Order order) {
    const auto last = static_cast<unsigned>(order.size() - 1);
    const unsigned one = any_of(0, last - 1);
    std::swap(order[one], order[any_of(one + 1, last)]);
  }
  void shuffle(Order order) {
    while (std::is_sorted(order.begin(), order.end())) {
      for (auto n = static_cast<unsigned>(order.size() - 1); n != 0; --n) {
        std::swap(order[n], order[any_of(0, n)]);
      }
    }
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
    for (unsigned left = any_of(1, period_ - 1); left != 0; --left) rig_.own();
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
  void delay(bool watched) {
    const Picoseconds least = frame().setup().frame_gap_max - cycle() + picoseconds(1);
    if (watched) {
      rig_.fault_begins();
      rig_.pass_watched(least + longer());
    } else {
      rig_.pass(least + longer());
    }
    send_own();
  }

  void insert(bool stale) {
    rig_.pass(-(cycle() / 2));  // between two requests
    const SequenceWords& last = rig_.past(0);
    const SequenceWords inserted =
        stale ? rig_.past(below(period_ - 1)) : rig_.encoder().foreign(rig_.random());
    send_fault(bits_of(inserted), last);
  }

  // The right content with another checksum.
  void send_with(const std::vector<SequenceFrame::Codec>& others) {
    const SequenceWords meant = rig_.own();
    send_fault(bits_of(meant, others), meant);
  }
  // Noise instead of the words or of the safety word, or zeros.
  void disguise(bool both_words, bool zeros) {
    const SequenceWords meant = rig_.own();
    FrameBits bits = bits_of(meant);
    std::size_t at = frame().payload_at(bits);
    if (!both_words) at += frame().words().cpw_bits();
    for (; at + 1 < bits.size_bits(); ++at) {
      if (zeros ? bits.view()[at] : (rig_.random().next() >> 63U) != 0) bits.flip(at);
    }
    send_fault(bits, meant);
  }

  // Frames of another encoder, which does not move, but counts.
  void address(unsigned count, bool other_start = false) {
    SequenceWords other = rig_.encoder().foreign(rig_.random());
    for (unsigned n = 0; n < count; ++n) {
      if (n != 0) rig_.pass(cycle());
      const SequenceWords meant = rig_.own();
      send_fault(other_start ? bits_of(other, frame().other_starts()) : bits_of(other), meant);
      const unsigned next = other.life_counter == 63 ? 64 - period_ : other.life_counter + 1U;
      other.life_counter = static_cast<std::uint8_t>(next);
    }
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return rig_.random().below(limit); }
  FrameBits bits_of(const SequenceWords& words) { return frame().encode(words, rig_.random()); }
  FrameBits bits_of(const SequenceWords& words, const std::vector<SequenceFrame::Codec>& others) {
    return frame().encode(words, others[below(others.size())], rig_.random());
  }
  Picoseconds cycle() const { return frame().cycle(); }
  void send_fault(const FrameBits& bits, const SequenceWords& meant) {
    rig_.fault_begins();
    rig_.send_fault(bits, meant);
  }
  void send_own() {
    const SequenceWords meant = rig_.own();
    send_fault(bits_of(meant), meant);
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

  // 0, or up to 128 cycles, every magnitude equally often.
  Picoseconds longer() {
    if (below(4) == 0) return {};
    const std::uint64_t share = rig_.random().next() >> 44U;
    return sim::part_of(cycle() * 128 / (std::int64_t{1} << below(20)), share);
  }

  SequenceRig& rig_;
  unsigned period_;
  FaultChoice corruption_;
};

namespace {

void corrupt(FaultRun& run) { run.corrupt(); }

constexpr auto variants = [] {
  using E = TransmissionError;
  using Run = FaultRun&;
  constexpr bool silent = true;
  return std::to_array<SequenceVariant>({
      {E::corruption, "flips:0.5", corrupt, corruption_theory},
      {E::corruption, "flips:0.1", corrupt, corruption_theory},
      {E::corruption, "flips:0.01", corrupt, corruption_theory},
      {E::corruption, "flips:0.001", corrupt, corruption_theory},
      {E::corruption, "burst:8", corrupt, corruption_theory},
      {E::corruption, "burst:16", corrupt, corruption_theory},
      {E::corruption, "burst:32", corrupt, corruption_theory},
      {E::repetition, "previous", [](Run run) { run.repeat(1); }},
      {E::repetition, "older", [](Run run) { run.repeat(run.any_of(2, run.period() - 1)); }},
      {E::repetition, "any_age",
       [](Run run) { run.repeat(run.any_of(1, most_periods * run.period())); }, counter_theory},
      {E::sequence, "exchanged", [](Run run) { run.exchange(&FaultRun::swap_two); }},
      {E::sequence, "shuffled", [](Run run) { run.exchange(&FaultRun::shuffle); }},
      {E::sequence, "overtaken", [](Run run) { run.exchange(&FaultRun::overtake); }},
      {E::loss, "no_answer", [](Run run) { run.lose_answers(); }},
      {E::loss, "skipped", [](Run run) { run.skip(); }},
      {E::loss, "not_called", [](Run run) { run.lose_calls(run.any_of(1, run.period() - 1)); },
       nullptr, silent},
      {E::loss, "whole_period",
       [](Run run) { run.lose_calls(run.period() * run.any_of(1, most_periods)); }, nullptr,
       silent},
      {E::delay, "watched", [](Run run) { run.delay(true); }, nullptr, silent},
      {E::delay, "unwatched", [](Run run) { run.delay(false); }},
      {E::delay, "stored", [](Run run) { run.store(); }},
      {E::delay, "constant"},
      {E::insertion, "stale", [](Run run) { run.insert(true); }},
      {E::insertion, "foreign", [](Run run) { run.insert(false); }, insertion_theory},
      {E::masquerade, "noise", [](Run run) { run.disguise(true, false); }, noise_theory},
      {E::masquerade, "noise_word", [](Run run) { run.disguise(false, false); }, noise_word_theory},
      {E::masquerade, "start_value", [](Run run) { run.send_with(run.frame().other_starts()); }},
      {E::masquerade, "polynomial", [](Run run) { run.send_with(run.frame().other_polynomials()); },
       polynomial_theory},
      {E::masquerade, "standard", [](Run run) { run.disguise(false, true); }, standard_theory},
      {E::addressing, "one_frame", [](Run run) { run.address(1); }, counter_theory},
      {E::addressing, "permanent", [](Run run) { run.address(run.any_of(2, most_foreign)); },
       counter_theory},
      {E::addressing, "start_value", [](Run run) { run.address(1, true); }},
  });
}();

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
void try_counter_mode(SequenceRig& rig, const SequenceRow& row, bool continues) {
  if (continues) {
    rig.monitor().acknowledge();
  } else {
    rig.settle(true);
    rig.encoder().put_elsewhere();
  }
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

// The position that a monitor gives for these words.
std::uint64_t value_of(const SequenceFrame& frame, const SequenceWords& words) {
  const SafetyFinding finding{.cpw_position = words.cpw, .spw_position = words.spw};
  return FieldEvaluation<SequenceFrame::Plan>::safe_position(frame.plan(), finding).value;
}

// Since power-up every answer belongs to an earlier request, until and after a stimulus.
class ConstantRun {
 public:
  ConstantRun(SequenceRig& rig, const SequenceRow& row)
      : rig_(rig), late_(1U + below(row.period() - 1U)) {
    rig_.settle(true);
    // Replaces the expectation of the previous event.
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
  // Whether the encoder has left all positions that the line may deliver next.
  bool is_moved() const {
    const std::uint64_t at = value_of(rig_.frame(), rig_.past(0));
    for (unsigned k = 0; k <= most_damaged(); ++k) {
      if (value_of(rig_.frame(), rig_.past(late_ - k)) == at) return false;
    }
    return true;
  }
  // Calls that do not end the fault. The next answer meets the last expectation.
  void pretend() {
    const std::uint64_t at = value_of(rig_.frame(), rig_.past(late_ - 1U));
    const unsigned what = below(32);
    if (what == 0) static_cast<void>(rig_.monitor().self_test());
    if (what < 8) rig_.monitor().expect_position(at, at);
  }

  SequenceRig& rig_;
  unsigned late_;
};

// Good frames, then a fault.
void inject_fault(SequenceRig& rig, FaultRun& run, const SequenceRow& row, bool first) {
  rig.settle(row.counter != CounterMode::learned && rig.random().below(2) != 0);
  rig.encoder().put_elsewhere();
  // These faults need earlier frames: the encoder goes on while the monitor is not called.
  const bool looks_back =
      row.kind == TransmissionError::repetition || row.kind == TransmissionError::insertion;
  for (unsigned frames = looks_back ? 256 : 0; frames != 0; --frames) rig.own();
  const unsigned starting =
      first ? start_up_frames(rig.frame(), row) : rig.frame().setup().start_frames - 1U;
  const unsigned good = starting + 1U + static_cast<unsigned>(rig.random().below(8));
  for (unsigned k = 0; k < good; ++k) {
    rig.pass(rig.frame().cycle());
    rig.good(k < starting);
  }
  rig.pass(rig.frame().cycle());
  row.injection().inject(run);
}

// Whether this may be the first verdict of an event.
bool may_be(const SequenceRow& row, SafetyVerdict verdict) {
  using enum SafetyVerdict;
  if (row.task == SequenceTask::counter_mode) return verdict == counter_mode;
  if (row.is_constant()) return verdict == stimulus || verdict == no_frame || verdict == cpw_crc;
  return safety_measures[static_cast<std::size_t>(row.kind)].may_be(verdict);
}

}  // namespace

std::span<const SequenceVariant> variants_of(TransmissionError error) {
  const auto of_error = [error](const SequenceVariant& each) { return each.error == error; };
  const auto first = std::find_if(variants.begin(), variants.end(), of_error);
  return {first, std::find_if_not(first, variants.end(), of_error)};
}

SequenceCounts count_sequence(const SequenceFrame& frame, const SequenceRow& row,
                              std::uint64_t seed, std::uint64_t block,
                              const SequenceWatcher& watcher) {
  if (row.task == SequenceTask::undamaged) {
    return count_undamaged(frame, row, seed, block, watcher);
  }
  SequenceRig rig(frame, row, seed, block, WordRule::truncated, watcher);
  if (row.task == SequenceTask::fault) rig.encoder().warn(false);
  FaultRun run(rig, row);
  const std::uint64_t first = row.blocks().first_of(block);
  const std::uint64_t size = row.blocks().size_of(block);
  for (std::uint64_t n = 0; n < size; ++n) {
    rig.begin(first + n);
    if (row.task == SequenceTask::counter_mode) {
      // Every second trial continues from the one before, as after an acknowledgement in a machine.
      try_counter_mode(rig, row, n % 2 != 0);
    } else if (row.is_constant()) {
      ConstantRun(rig, row).inject(first + n, start_up_frames(frame, row));
    } else {
      inject_fault(rig, run, row, n == 0);
    }
    rig.close_event(reaction_bound(frame, row),
                    [&row](SafetyVerdict verdict) { return may_be(row, verdict); });
  }
  return rig.counts();
}

unsigned reaction_bound(const SequenceFrame& frame, const SequenceRow& row) {
  const bool silent = row.task == SequenceTask::fault && row.injection().silent;
  return silent ? frame.watchdog_cycles() : 0;
}

}  // namespace biss::lab
