#include "lab/sequence_block.hpp"

#include <algorithm>

#include "lab/sequence_fault.hpp"
#include "lab/sequence_rig.hpp"

namespace biss::lab {
namespace {

// So many frames may be `starting`: the next one has to be safe.
unsigned start_up_frames(const SequenceFrame& frame, const SequenceRow& row) {
  const SafetySetup& setup = frame.setup();
  const unsigned learning =
      row.counter == CounterMode::learned ? setup.counter.learn_rollovers * row.period() : 0;
  return std::max(setup.start_frames - 1U, learning);
}

// From the cycle to the watchdog's bound, each of them every now and then.
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

// Good frames up to the first that shows the encoder's range to be the other one.
void try_counter_mode(SequenceRig& rig, const SequenceRow& row) {
  const bool counts_zero = row.encoder_counter == CounterMode::count_0_63;
  const unsigned start_up = rig.frame().setup().start_frames - 1U;
  for (unsigned shown = 0; shown <= 2 * row.period(); ++shown) {
    rig.pass(rig.frame().cycle());
    const SequenceWords& words = rig.own();
    const bool tells =
        counts_zero ? words.life_counter == 0 : words.life_counter == 1 && shown != 0;
    if (tells) {
      rig.fault_begins();
      rig.show(rig.frame().encode(words, rig.random()), words);
      return;
    }
    rig.good(words, shown < start_up);
  }
}

// The second trial of two goes on from the first, as after an acknowledgement in a machine.
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
    rig.close_event(0, [](SafetyVerdict told) { return told == SafetyVerdict::counter_mode; });
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
  return count_faults(frame, row, seed, block, watcher, start_up_frames(frame, row));
}

}  // namespace biss::lab
