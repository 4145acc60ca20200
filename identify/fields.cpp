#include "identify/fields.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "biss/base/bits.hpp"

namespace biss::identify {

namespace {

// How a bit changes from frame to frame.
struct BitHistory {
  std::size_t ones = 0;
  std::size_t changes = 0;
};

// A division of the moving bits into a sign of life, a position, and bits that flicker: they leave
// their usual level for few frames, as flags do.
struct Division {
  Bits counter;
  Bits position;
  std::uint64_t flicker = 0;
  /// The bits that it takes to write the motion down. The shortest division is taken.
  double length = 0;
};

class FieldSearch {
 public:
  FieldSearch(std::span<const DataWord> words, unsigned data_bits, double strays)
      : words_(words.begin(), words.end()), data_bits_(data_bits), strays_(strays) {
    fields_.channel.data_bits = static_cast<std::uint8_t>(data_bits);
    collect_history();
    if (strays > 0.005 && drop_strays()) collect_history();
    find_moved(strays);
  }

  Fields find() {
    divide();
    extend_counter();
    place_fields();
    judge_position();
    return fields_;
  }

 private:
  void collect_history() {
    history_.assign(data_bits_, {});
    for (std::size_t i = 0; i < words_.size(); ++i) {
      const std::uint64_t changed = i == 0 ? 0 : words_[i].data ^ words_[i - 1].data;
      for (unsigned bit = 0; bit < data_bits_; ++bit) {
        history_[bit].ones += (words_[i].data >> bit) & 1U;
        history_[bit].changes += (changed >> bit) & 1U;
      }
    }
  }

  // A word in which several bits differ from all others was damaged.
  bool drop_strays() {
    constexpr int least_bits = 3;
    std::uint64_t once_one = 0;
    std::uint64_t once_zero = 0;
    for (unsigned bit = 0; bit < data_bits_; ++bit) {
      const std::uint64_t mask = std::uint64_t{1} << bit;
      if (history_[bit].ones == 1) once_one |= mask;
      if (history_[bit].ones + 1 == words_.size()) once_zero |= mask;
    }
    return std::erase_if(words_, [&](const DataWord& word) {
             const std::uint64_t odd = (word.data & once_one) | (~word.data & once_zero);
             return std::popcount(odd) >= least_bits;
           }) != 0;
  }

  std::size_t minority(unsigned bit) const {
    return std::min(history_[bit].ones, words_.size() - history_[bit].ones);
  }
  bool is_moved(unsigned bit) const { return ((fields_.moved >> bit) & 1U) != 0; }

  void find_moved(double strays) {
    const auto few = static_cast<std::size_t>(strays < 0.5 ? 0 : std::ceil(2 * strays));
    for (unsigned bit = 0; bit < data_bits_; ++bit) {
      if (minority(bit) > few) fields_.moved |= std::uint64_t{1} << bit;
      if (minority(bit) > 0) seen_ |= std::uint64_t{1} << bit;
    }
  }

  // ---- Which bits are what

  void divide() {
    find_certain_flags();
    best_ = division_of({});
    const double without = best_.length;
    bool doubtful = false;
    for (const Bits& counter : possible_counters()) {
      Division division = division_of(counter);
      division.length += length_of_counter(counter);
      // A position hardly moves so evenly that its upper part counts every frame and starts again.
      const CountedSteps steps = count_steps(counter);
      const bool proven = steps.restarts > 1 || carries_into(counter).overflows > 1;
      const bool whole = steps.wrong == 0 && steps.restarts > (is_apart(counter) ? 0U : 1U) &&
                         division.position.count != 0;
      // Right below other moving bits it may be the end of a position that moves evenly.
      const double needed = whole && is_whole_run(counter) ? -whole_counter_gain : least_gain;
      const bool possible = whole || is_apart(counter);
      const bool clear = possible && division.length + 2 * least_gain < without;
      doubtful =
          doubtful || (!(whole && proven) && !clear && division.length < without + 2 * least_gain);
      if (possible && division.length + needed < best_.length) best_ = division;
    }
    if (doubtful) add(Doubt::counter);
    widen_counter();
  }

  // The first bits of a short capture may count alone.
  void widen_counter() {
    Bits wider = best_.counter;
    if (wider.count == 0) return;
    while (++wider.count <= max_life_counter_bits && wider.high() <= data_bits_ &&
           is_moved(wider.high() - 1) && counts_whole(wider)) {
      const Division division = division_of(wider);
      if (division.length < best_.length + whole_counter_gain) best_ = division;
    }
    const Bits counter = best_.counter;
    if (counter.count < safety_counter_bits && counter.high() < data_bits_ &&
        ((seen_ >> counter.high()) & 1U) != 0) {
      add(Doubt::counter);
    }
  }

  bool counts_whole(Bits bits) const {
    const CountedSteps steps = count_steps(bits);
    return steps.wrong == 0 && steps.top_changes > (bits.count > safety_counter_bits ? 1U : 0U);
  }

  // Bits that leave their usual level for a few frames where other bits change often, and without a
  // carry from below, wherever they are.
  void find_certain_flags() {
    std::vector<unsigned> moving;
    std::size_t most_changes = 0;
    for (unsigned bit = 0; bit < data_bits_; ++bit) {
      if (!is_moved(bit)) continue;
      moving.push_back(bit);
      most_changes = std::max(most_changes, history_[bit].changes);
    }
    if (moving.size() < 3) return;
    const Bits all{moving.front(), moving.back() + 1 - moving.front()};
    gray_ = 4 * sum(step_lengths(words_, all, all.count)) < 3 * sum(step_lengths(words_, all, 0));
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const unsigned bit = moving[i];
      if (!is_rare(bit) || !is_short_lived(bit) || 3 * history_[bit].changes >= most_changes)
        continue;
      if (share_carried(moving, i) >= 0.5 || (gray_ && i >= moving.size() / 2)) continue;
      certain_flags_ |= std::uint64_t{1} << bit;
    }
  }

  // The position is what moves apart from the counter, from the lowest to the highest bit, without
  // flags at its ends.
  Division division_of(Bits counter) const {
    std::vector<unsigned> moving;
    for (unsigned bit = 0; bit < data_bits_; ++bit) {
      if (is_moved(bit) && ((counter.mask() >> bit) & 1U) == 0) moving.push_back(bit);
    }
    // What is at rest shows at most its flags.
    if (std::all_of(moving.begin(), moving.end(),
                    [this](unsigned bit) { return is_rare(bit) && is_short_lived(bit); })) {
      return stripped(counter, moving, moving.size(), 0);
    }
    Division best{counter, {}, 0, HUGE_VAL};
    const std::size_t below = flags_at(moving.begin(), moving.end());
    const std::size_t above = flags_at(moving.rbegin(), moving.rend());
    for (std::size_t low = 0; low <= below; ++low) {
      for (std::size_t high = 0; high <= above && low + high <= moving.size(); ++high) {
        const Division division = stripped(counter, moving, low, high);
        if (division.length < best.length) best = division;
      }
    }
    const Bits position = best.position;
    if (position.count == 0) return best;
    double shortest = HUGE_VAL;
    for (unsigned gray = 0; gray <= position.count; gray = std::max(gray + 1, least_gray_bits)) {
      shortest = std::min(shortest, sum(step_lengths(words_, position, gray)));
    }
    best.length += shortest - length_of(position);
    return best;
  }

  double length_of(Bits position) const {
    return std::min(sum(step_lengths(words_, position, 0)),
                    sum(step_lengths(words_, position, position.count)));
  }

  bool is_rare(unsigned bit) const { return 4 * minority(bit) <= words_.size(); }
  // It leaves its usual level for three frames at most.
  bool is_short_lived(unsigned bit) const {
    return 2 * minority(bit) <= 3 * (history_[bit].changes + 1);
  }

  // The bits at an end that change rarely.
  template <class Iterator>
  std::size_t flags_at(Iterator begin, Iterator end) const {
    std::size_t count = 0;
    for (; begin != end && count < most_flags && is_rare(*begin); ++begin) ++count;
    return count;
  }

  // Of the changes of a bit, the share at which the bits below go over their end.
  double share_carried(const std::vector<unsigned>& moving, std::size_t index) const {
    std::size_t top = index;
    while (top > 0 && is_rare(moving[top - 1])) --top;
    if (top < 3) return 0;
    const Bits below{moving[0], moving[top - 1] + 1 - moving[0]};
    const std::uint64_t half = std::uint64_t{1} << (below.count - 1U);
    std::size_t changes = 0;
    std::size_t overflows = 0;
    std::size_t carried = 0;
    for (std::size_t i = 1; i < words_.size(); ++i) {
      const std::uint64_t from = below.of(words_[i - 1].data);
      const std::uint64_t to = below.of(words_[i].data);
      const bool overflow = std::max(from, to) - std::min(from, to) > half;
      const bool change = (((words_[i].data ^ words_[i - 1].data) >> moving[index]) & 1U) != 0;
      changes += change ? 1U : 0U;
      overflows += overflow ? 1U : 0U;
      carried += change && overflow ? 1U : 0U;
    }
    // Where the bits below go over their end all the time, the bit would not change rarely.
    if (changes == 0 || overflows > 8 * changes + 4) return 0;
    return static_cast<double>(carried) / static_cast<double>(changes);
  }

  Division stripped(Bits counter, const std::vector<unsigned>& moving, std::size_t below,
                    std::size_t above) const {
    Division division{counter, {}, 0, 0};
    // A flag changes at any time: it takes the number of the frame to write that down.
    const double a_change = std::log2(static_cast<double>(words_.size())) + 1;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      if (i >= below && i + above < moving.size()) continue;
      division.flicker |= std::uint64_t{1} << moving[i];
      division.length += static_cast<double>(history_[moving[i]].changes) * a_change;
    }
    if (below + above >= moving.size()) return division;
    division.position.low = moving[below];
    division.position.count = moving[moving.size() - above - 1] + 1 - moving[below];
    const Bits bits = division.position;
    if ((bits.mask() & counter.mask()) != 0) return {counter, {}, 0, HUGE_VAL};
    // Bits that look like flags are hardly part of the position.
    constexpr double a_flag_inside = 200;
    division.length += a_flag_inside * std::popcount(bits.mask() & certain_flags_);
    division.length += length_of(bits);
    return division;
  }

  // ---- The sign of life: a counter that goes up by one from request to request

  // Runs whose lowest bit changes in nearly every frame, and which count in most frames.
  std::vector<Bits> possible_counters() {
    std::vector<Bits> counters;
    for (unsigned low = 0; low < data_bits_; ++low) {
      if (!is_moved(low) || 5 * history_[low].changes < 4 * (words_.size() - 1)) continue;
      Bits bits{low, 2};
      for (; bits.count <= max_life_counter_bits && bits.high() <= data_bits_; ++bits.count) {
        if (!is_moved(bits.high() - 1) || exceptions(bits) > 0.15) break;
        if (bits.count < 3 || count_steps(bits).top_changes == 0) continue;
        if (!is_carried_into(bits)) {
          counters.push_back(bits);
        } else if (is_whole_run(bits) && carries_into(bits).overflows < 4 &&
                   count_steps(bits).restarts > 1) {
          add(Doubt::counter);
        }
      }
    }
    return counters;
  }

  // The next value; where the counter starts again, 0 may be left out.
  static bool follows(std::uint64_t value, std::uint64_t next, std::uint64_t mask) {
    return next == ((value + 1) & mask) || (value == mask && next == 1);
  }

  // This word answers the request after that of the word before. Where a request is not answered, an
  // encoder need not count.
  bool is_next(std::size_t i) const {
    return words_[i].cycle - words_[i - 1].cycle == 1 && words_[i].requests <= 1;
  }

  // The moving bits directly below a run.
  Bits moving_below(Bits bits) const {
    unsigned low = bits.low;
    while (low > 0 && is_moved(low - 1)) --low;
    return {low, bits.low - low};
  }

  struct Carries {
    std::size_t overflows = 0;
    std::size_t carried = 0;
  };

  // How often the bits below go over their end, and this run then does not count by one.
  Carries carries_into(Bits bits) const {
    const Bits below = moving_below(bits);
    if (below.count == 0) return {};
    std::size_t up = 0;
    std::size_t down = 0;
    for (std::size_t i = 1; i < words_.size(); ++i) {
      (below.of(words_[i].data) < below.of(words_[i - 1].data) ? down : up) += 1;
    }
    Carries carries;
    for (std::size_t i = 1; i < words_.size(); ++i) {
      const bool fell = below.of(words_[i].data) < below.of(words_[i - 1].data);
      if (!is_next(i) || fell != (down < up)) continue;
      ++carries.overflows;
      if (!follows(bits.of(words_[i - 1].data), bits.of(words_[i].data), low_mask(bits.count))) {
        ++carries.carried;
      }
    }
    return carries;
  }

  // No moving bit follows above.
  bool is_whole_run(Bits bits) const { return bits.high() == data_bits_ || !is_moved(bits.high()); }

  // The bits below carry into this run: it is the upper part of a position that moves evenly.
  bool is_carried_into(Bits bits) const {
    const Carries carries = carries_into(bits);
    return carries.overflows != 0 && 2 * carries.carried >= carries.overflows;
  }

  // The bits below do not carry into this run, or have not moved.
  bool is_apart(Bits bits) const {
    return moving_below(bits).count == 0 || carries_into(bits).overflows != 0;
  }

  // The share of steps at which a counter does not count.
  double exceptions(Bits bits) const {
    const CountedSteps steps = count_steps(bits);
    return steps.all < 8 ? 1.0 : static_cast<double>(steps.wrong) / static_cast<double>(steps.all);
  }

  double length_of_counter(Bits bits) const {
    constexpr double an_exception = 20;
    return static_cast<double>(count_steps(bits).wrong) * an_exception;
  }

  struct CountedSteps {
    std::size_t all = 0;
    std::size_t wrong = 0;
    std::size_t restarts = 0;
    // At which the highest bit changes.
    std::size_t top_changes = 0;
  };
  CountedSteps count_steps(Bits bits) const {
    CountedSteps steps;
    for (std::size_t i = 1; i < words_.size(); ++i) {
      if (!is_next(i)) continue;
      const std::uint64_t from = bits.of(words_[i - 1].data);
      const std::uint64_t to = bits.of(words_[i].data);
      ++steps.all;
      if (!follows(from, to, low_mask(bits.count))) {
        ++steps.wrong;
      } else {
        steps.restarts += to < from ? 1U : 0U;
        steps.top_changes += ((from ^ to) >> (bits.count - 1U)) & 1U;
      }
    }
    return steps;
  }

  // Six bits by the safety concept; zeros that have not moved above may belong to it.
  void extend_counter() {
    Bits& counter = best_.counter;
    if (counter.count == 0) return;
    while (counter.count < safety_counter_bits && counter.high() < data_bits_ &&
           !is_moved(counter.high()) && history_[counter.high()].ones == 0) {
      ++counter.count;
    }
    if (counter.count < safety_counter_bits) add(Doubt::counter);
    fields_.channel.life_counter = {static_cast<std::uint8_t>(counter.low),
                                    static_cast<std::uint8_t>(counter.count)};
  }

  // ---- The places of the fields

  // The position extends over what has not moved, from the counter or an end of the word to another.
  void place_fields() {
    const Bits counter = best_.counter;
    const bool still = best_.position.count == 0;
    if (still) add(Doubt::still);
    const bool counter_above = counter.count != 0 && !still && counter.low >= best_.position.high();
    const bool counter_below = counter.count != 0 && !counter_above;
    bottom_ = counter_below ? counter.high() : 0;
    top_ = counter_above ? counter.low : data_bits_;
    position_low_ = still ? std::min(top_, bottom_ + 2) : best_.position.low;
    place_flags_before();
    place_flags_after();
    if (top_ != position_low_) {
      fields_.channel.position = {static_cast<std::uint8_t>(position_low_),
                                  static_cast<std::uint8_t>(top_ - position_low_)};
    }
    const std::uint64_t position = low_mask(top_ - position_low_) << position_low_;
    fields_.position_moved = fields_.moved & position;
    if ((best_.flicker & position) != 0) add(Doubt::flag_place);
    judge_end_bits();
    const std::uint64_t unexplained = seen_ & ~fields_.flags_moved & ~counter.mask() &
                                      ~best_.position.mask() & ~(best_.flicker & position);
    if (unexplained != 0) add(Doubt::further_bits);
  }

  // Where the end bits of a position hardly move, they may be flags, and flags may be such bits.
  void judge_end_bits() {
    const unsigned lowest = best_.position.low;
    const unsigned highest = best_.position.high() - 1;
    if (best_.position.count < 2) return;
    if (is_rare(highest) && is_short_lived(highest) && history_[highest].changes <= 4) {
      add(Doubt::flag_place);
    }
    if (!is_rare(lowest)) return;
    if (fields_.flags_moved != 0) add(Doubt::low_bits);
    if (is_short_lived(lowest)) add(strays_ > 0.01 ? Doubt::low_bits : Doubt::flag_place);
  }

  bool is_flicker(unsigned bit) const { return ((best_.flicker >> bit) & 1U) != 0; }

  // The lowest bit of two flags in [low, high): the last two bits, but one that changes is among
  // them.
  unsigned pair_in(unsigned low, unsigned high) const {
    unsigned first = high;
    unsigned last = low;
    for (unsigned bit = low; bit < high; ++bit) {
      if (!is_flicker(bit)) continue;
      first = std::min(first, bit);
      last = bit;
    }
    if (first == high || (first == last && last <= low + 1)) return low;
    // Two flags at rest in their usual place.
    if (is_mostly_high(low) && is_mostly_high(low + 1)) return low;
    if (first != last || first == low) return first;
    const bool pair_above = history_[first - 1].ones == 0 && first + 1 < high;
    return pair_above ? first : first - 1;
  }

  bool is_mostly_high(unsigned bit) const { return 4 * history_[bit].ones >= 3 * words_.size(); }

  // Usually the last two bits before the sign of life or the checksum; or after the sign of life.
  void place_flags_after() {
    ChannelFormat& channel = fields_.channel;
    if (channel.error.present) {
      // Nothing says that what has not moved after the position does not belong to it.
      position_low_ = bottom_;
      return;
    }
    unsigned low = bottom_;
    unsigned high = position_low_;
    if (low == high && bottom_ != 0) {
      low = 0;
      high = best_.counter.low;
    }
    if (high == low) return;
    const unsigned pair = pair_in(low, high);
    const bool one = high - low == 1 || (is_flicker(pair) && history_[pair + 1].ones == 0 &&
                                         2 * history_[pair].ones > words_.size());
    if (one) {
      set_flag(channel.error, pair);
      if (is_moved(pair)) add(Doubt::flag_place);
    } else {
      set_flag(channel.warning, pair);
      set_flag(channel.error, pair + 1);
      same_polarity();
      // The bit of nE may be one of the position.
      const bool alone = is_moved(pair) && !is_moved(pair + 1);
      if (pair != low) add(Doubt::flag_place);
      if (alone && 4 * history_[best_.position.low].changes < words_.size()) add(Doubt::low_bits);
    }
    // Bits that have not moved between the position and the flags may belong to it.
    if (low == bottom_) position_low_ = pair + (one ? 1 : 2);
  }

  void place_flags_before() {
    ChannelFormat& channel = fields_.channel;
    unsigned lowest = data_bits_;
    for (unsigned bit = best_.position.high(); bit < data_bits_ && lowest == data_bits_; ++bit) {
      if (is_flicker(bit)) lowest = bit;
    }
    if (lowest == data_bits_ || best_.position.count == 0) return;
    const unsigned end = lowest < top_ ? top_ : data_bits_;
    const bool two = lowest + 1 < end && history_[lowest + 1].ones != 0;
    set_flag(channel.error, two ? lowest + 1 : lowest);
    if (two) set_flag(channel.warning, lowest);
    same_polarity();
    top_ = std::min(top_, lowest);
    add(Doubt::flag_place);
  }

  // A flag that is always 0 beside an active-high one is active-high too.
  void same_polarity() {
    ChannelFormat& channel = fields_.channel;
    if (!channel.error.present || !channel.warning.present) return;
    const auto follow = [this](FlagField& flag, const FlagField& other) {
      if (other.active_high && history_[flag.shift].ones == 0) flag.active_high = true;
    };
    follow(channel.error, channel.warning);
    follow(channel.warning, channel.error);
  }

  void set_flag(FlagField& flag, unsigned bit) {
    flag = {static_cast<std::uint8_t>(bit), true, false};
    if (is_moved(bit)) fields_.flags_moved |= std::uint64_t{1} << bit;
    if (2 * history_[bit].ones > words_.size()) return;
    // Active nearly always, or active-high.
    flag.active_high = is_moved(bit);
    add(Doubt::flag_level);
  }

  void judge_position() {
    if (best_.position.count == 0) return;
    const Coding coding = find_coding(words_, best_.position);
    if (!coding.sure) add(Doubt::order);
    if (coding.gray_bits == 0) return;
    // The lowest bits of Gray code change half as often.
    if (fields_.flags_moved != 0) add(Doubt::low_bits);
    ChannelFormat& channel = fields_.channel;
    const Field position = std::exchange(channel.position, {});
    const unsigned split = best_.position.low + coding.gray_bits;
    const unsigned end = split < best_.position.high() ? split : position.shift + position.bits;
    channel.singleturn_gray = true;
    channel.singleturn = {position.shift, static_cast<std::uint8_t>(end - position.shift)};
    channel.multiturn = {static_cast<std::uint8_t>(end),
                         static_cast<std::uint8_t>(position.shift + position.bits - end)};
  }

  void add(Doubt doubt) {
    if (std::find(fields_.doubts.begin(), fields_.doubts.end(), doubt) == fields_.doubts.end()) {
      fields_.doubts.push_back(doubt);
    }
  }

  static constexpr std::size_t most_flags = 2;
  // How much shorter a division with a sign of life must be; a whole one may be longer by the other.
  static constexpr double least_gain = 24;
  static constexpr double whole_counter_gain = 8;

  std::vector<DataWord> words_;
  unsigned data_bits_;
  double strays_;
  std::vector<BitHistory> history_;
  Fields fields_;
  bool gray_ = false;
  // Bits that changed at all; fewer frames than `strays` may be damaged ones.
  std::uint64_t seen_ = 0;
  std::uint64_t certain_flags_ = 0;
  Division best_;
  // The position may extend from bottom_ to top_; its lowest bit.
  unsigned bottom_ = 0;
  unsigned top_ = 0;
  unsigned position_low_ = 0;
};

}  // namespace

Fields find_fields(std::span<const DataWord> words, unsigned data_bits, double strays) {
  return FieldSearch(words, data_bits, strays).find();
}

}  // namespace biss::identify
