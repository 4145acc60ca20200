// The words of a VCD, and the quick way through its value changes, for two of its lines.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "capture/decimal.hpp"
#include "capture/declared_lines.hpp"
#include "capture/text_source.hpp"
#include "capture/timescale.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// The kind of a word, from its first character; the first three are levels.
enum class VcdKind : std::uint8_t { low, high, unknown, space, time, vector, value, keyword, none };

constexpr std::array<VcdKind, 256> make_vcd_kinds() {
  std::array<VcdKind, 256> kinds{};
  kinds.fill(VcdKind::none);
  const auto set = [&kinds](std::string_view chars, VcdKind kind) {
    for (const char c : chars) kinds[static_cast<unsigned char>(c)] = kind;
  };
  set("0lL", VcdKind::low);
  set("1hH", VcdKind::high);
  set("xXzZuUwW-", VcdKind::unknown);
  set(" \t\n\v\f\r", VcdKind::space);
  set("#", VcdKind::time);
  set("bB", VcdKind::vector);
  set("rRsS", VcdKind::value);
  set("$", VcdKind::keyword);
  return kinds;
}

inline constexpr std::array<VcdKind, 256> vcd_kinds = make_vcd_kinds();
static_assert(static_cast<int>(VcdKind::low) == static_cast<int>(wire::Level::low));
static_assert(static_cast<int>(VcdKind::high) == static_cast<int>(wire::Level::high));
static_assert(static_cast<int>(VcdKind::unknown) == static_cast<int>(wire::Level::unknown));

constexpr VcdKind vcd_kind_of(char c) { return vcd_kinds[static_cast<unsigned char>(c)]; }

/// \pre a space follows
inline const char* end_of_word(const char* p) {
  while (!is_space(*p)) ++p;
  return p;
}

/// Identifiers to numbers 0, 1, 2, … in the order of their first add().
class VcdIds {
 public:
  static constexpr std::uint32_t none = UINT32_MAX;

  VcdIds() : slots_(64) { one_.fill(none); }

  /// The number of `id`, a new one when it was not known.
  /// \pre valid(id)
  std::uint32_t add(std::string_view id) {
    if (id.size() > packed_chars) {
      const auto [entry, added] = long_.try_emplace(std::string(id), size_);
      if (added) ++size_;
      return entry->second;
    }
    if (id.size() > 2) return add_packed(pack(id));
    if (two_.empty() && id.size() == 2) two_.assign(std::size_t{letters} * letters, none);
    std::uint32_t& entry = id.size() == 1 ? one_[static_cast<unsigned char>(id[0])]
                                          : two_[place(id[0]) * letters + place(id[1])];
    if (entry == none) entry = size_++;
    return entry;
  }

  /// The number of `id`, or none; any text may be requested.
  std::uint32_t find(std::string_view id) const {
    if (id.empty()) return none;
    if (id.size() == 1) return find_one(id[0]);
    if (id.size() == 2) return find_two(id.data());
    // A leading NUL would pack like the shorter identifier after it.
    if (id.size() <= packed_chars) return id[0] == 0 ? none : slots_[slot_of(pack(id))].number;
    const auto entry = long_.find(id);
    return entry == long_.end() ? none : entry->second;
  }

  /// The same for an identifier of one or two characters.
  std::uint32_t find_one(char c) const { return one_[static_cast<unsigned char>(c)]; }
  std::uint32_t find_two(const char* id) const {
    const unsigned first = place(id[0]);
    const unsigned second = place(id[1]);
    if (two_.empty() || first >= letters || second >= letters) return none;
    return two_[first * letters + second];
  }
  std::uint32_t size() const { return size_; }

  static bool valid(std::string_view id) {
    return !id.empty() &&
           std::all_of(id.begin(), id.end(), [](char c) { return place(c) < letters; });
  }

 private:
  static constexpr unsigned letters = '~' - '!' + 1;
  static constexpr std::size_t packed_chars = 8;

  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = none;
  };
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const {
      return std::hash<std::string_view>{}(text);
    }
  };

  static unsigned place(char c) { return static_cast<unsigned char>(c) - unsigned{'!'}; }

  static std::uint64_t pack(std::string_view id) {
    std::uint64_t key = 0;
    for (const char c : id) key = key << 8U | static_cast<unsigned char>(c);
    return key;
  }

  // The slot of `key`, or the free slot in which it belongs.
  std::size_t slot_of(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    auto at = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15U) >> 20U) & mask;
    while (slots_[at].number != none && slots_[at].key != key) at = (at + 1) & mask;
    return at;
  }

  std::uint32_t add_packed(std::uint64_t key) {
    Slot* slot = &slots_[slot_of(key)];
    if (slot->number != none) return slot->number;
    if (++slots_used_ * 2 > slots_.size()) {
      grow_slots();
      slot = &slots_[slot_of(key)];
    }
    *slot = {key, size_};
    return size_++;
  }

  void grow_slots() {
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(slots_.size() * 2));
    for (const Slot& slot : old) {
      if (slot.number != none) slots_[slot_of(slot.key)] = slot;
    }
  }

  std::uint32_t size_ = 0;
  std::array<std::uint32_t, 256> one_;
  std::vector<std::uint32_t> two_;  // empty until the first identifier of two characters
  // Three to eight characters are a number; open addressing, never more than half full.
  std::vector<Slot> slots_;
  std::size_t slots_used_ = 0;
  std::unordered_map<std::string, std::uint32_t, TextHash, std::equal_to<>> long_;
};

/// The content of the declarations of a VCD.
struct VcdSignals {
  Timescale timescale;
  VcdIds ids;
  DrivenLines driven;  ///< a variable is the number of an identifier
};

/// The meaning of identifiers for a pair of lines. Refers to the signals of the reader, and only
/// reads data that does not change.
class VcdPair {
 public:
  enum Role : std::uint8_t { ma, slo, other, undeclared };

  /// \pre the lines have different variables
  VcdPair(const VcdSignals& signals, std::uint32_t ma_variable, std::uint32_t slo_variable)
      : signals_(&signals), ma_variable_(ma_variable), slo_variable_(slo_variable) {
    for (std::size_t c = 0; c < roles_.size(); ++c) {
      roles_[c] = role_of(signals.ids.find_one(static_cast<char>(c)));
    }
  }

  Role role_of(char id) const { return roles_[static_cast<unsigned char>(id)]; }
  Role role_of(std::uint32_t variable) const {
    if (variable == VcdIds::none) return undeclared;
    if (variable == ma_variable_) return ma;
    return variable == slo_variable_ ? slo : other;
  }
  const VcdSignals& signals() const { return *signals_; }
  std::uint32_t ma_variable() const { return ma_variable_; }
  std::uint32_t slo_variable() const { return slo_variable_; }

 private:
  const VcdSignals* signals_;
  std::uint32_t ma_variable_;
  std::uint32_t slo_variable_;
  std::array<Role, 256> roles_;
};

/// A piece of a VCD. Times in order, values of declared identifiers, and levels 0 and 1 of the two
/// lines are regular. Keywords, comments, unknown levels of the lines and invalid text are not.
class VcdPiece final : public TextPiece {
 public:
  /// `pair` outlives the piece.
  explicit VcdPiece(const VcdPair& pair) : pair_(&pair) {}

  // In a regular piece:
  bool timed = false;            ///< it has a time
  std::uint64_t first_tick = 0;  ///< when timed
  std::uint64_t last_tick = 0;   ///< when timed
  std::size_t early_ma = 0;      ///< changes before the first time; they have none yet
  std::size_t early_slo = 0;

 private:
  // Identifiers beyond it are left to the reader.
  static constexpr std::uint64_t long_enough = 64;

  const Timescale& timescale() const { return pair_->signals().timescale; }

  bool quick_parse() override {
    const char* p = begin();
    const char* const text_end = end();
    std::uint64_t plain_line_feeds = 0;  // in a register, unlike the counts of other words
    timed = false;
    line_feeds = 0;
    last_tick = 0;
    for (ChangeBatch& batch : batches_) batch.restart();
    FixedDigits digits(0);
    while (p != text_end) {
      if (*p == '#') {
        const char* const time_end = p + 1 + digits.count();
        std::uint64_t tick = 0;
        if (is_space(*time_end) && digits.count() != 0 && digits.read(time_end, tick)) {
          if (!set_tick(tick)) return false;
          plain_line_feeds += *time_end == '\n' ? 1U : 0U;
          p = time_end + 1;
        } else {
          p = read_time(p, digits);
          if (p == nullptr) return false;
        }
      }
      const bool level = *p == '0' || *p == '1';
      if (level && is_space(p[2])) {
        if (!add_known(pair_->role_of(p[1]), *p)) return false;
        plain_line_feeds += p[2] == '\n' ? 1U : 0U;
        p += 3;
      } else if (level && is_space(p[3])) {
        if (!add_known(pair_->role_of(pair_->signals().ids.find_two(p + 1)), *p)) return false;
        plain_line_feeds += p[3] == '\n' ? 1U : 0U;
        p += 4;
      } else if (p != text_end && *p != '#') {
        p = read_other(p);
        if (p == nullptr) return false;
      }
    }
    line_feeds += plain_line_feeds;
    return finish();
  }

  bool set_tick(std::uint64_t tick) {
    if (!timed) {
      take_batches();
      timed = true;
      early_ma = ma.times.size();
      early_slo = slo.times.size();
      first_tick = tick;
    }
    const bool in_order = tick >= last_tick;
    last_tick = tick;
    return in_order;
  }

  // A time of another length than the one before.
  const char* read_time(const char* p, FixedDigits& digits) {
    const Digits read = read_digits(p + 1);
    const auto count = static_cast<std::size_t>(read.end - (p + 1));
    if (count == 0 || count > 19 || !is_space(*read.end) || !set_tick(read.value)) return nullptr;
    if (count <= FixedDigits::most) digits = FixedDigits(count);
    return read.end;
  }

  const char* read_other(const char* p) {
    const VcdKind kind = vcd_kind_of(*p);
    if (kind <= VcdKind::unknown) return read_scalar(p, kind);
    if (kind == VcdKind::space) return skip_space(p);
    if (kind == VcdKind::vector || kind == VcdKind::value) return read_vector(p);
    return nullptr;
  }

  const char* read_scalar(const char* p, VcdKind level) {
    const char* const id = p + 1;
    if (is_space(id[1])) return add(pair_->role_of(id[0]), level) ? id + 1 : nullptr;
    const char* const end = is_space(id[2]) ? id + 2 : end_of_word(id);
    const std::uint32_t variable =
        end == id + 2 ? pair_->signals().ids.find_two(id) : find(id, end);
    return add(pair_->role_of(variable), level) ? end : nullptr;
  }

  // A vector, a real or a string, and its identifier.
  const char* read_vector(const char* p) {
    const char* const value = p + 1;
    const char* const value_end = end_of_word(value);
    if (vcd_kind_of(*p) == VcdKind::vector) {
      const auto is_bit = [](char c) { return vcd_kind_of(c) <= VcdKind::unknown; };
      if (value == value_end || !std::all_of(value, value_end, is_bit)) return nullptr;
    }
    const bool one_bit = vcd_kind_of(*p) == VcdKind::vector && value_end == value + 1;
    const char* const id = skip_space(value_end);
    if (id == end()) return nullptr;
    const char* const end = end_of_word(id);
    if (end - p > static_cast<std::ptrdiff_t>(max_token_bytes)) return nullptr;
    const std::uint32_t variable = find(id, end);
    const VcdPair::Role role = pair_->role_of(variable);
    if (one_bit) return add(role, vcd_kind_of(*value)) ? end : nullptr;
    return role == VcdPair::undeclared || pair_->signals().driven.drives(variable) ? nullptr : end;
  }

  const char* skip_space(const char* p) {
    for (; is_space(*p); ++p) line_feeds += *p == '\n' ? 1U : 0U;
    return p;
  }

  std::uint32_t find(const char* id, const char* end) const {
    const std::string_view text = text_between(id, end);
    return text.size() > long_enough ? VcdIds::none : pair_->signals().ids.find(text);
  }

  // False for a level that arrays cannot say.
  bool add(VcdPair::Role role, VcdKind level) {
    if (role == VcdPair::other) return true;
    if (level == VcdKind::unknown) return false;
    return add_known(role, level == VcdKind::high ? '1' : '0');
  }

  /// \pre level is 0 or 1
  bool add_known(VcdPair::Role role, char level) {
    if (role == VcdPair::undeclared) return false;
    batches_[role].add(static_cast<std::int64_t>(last_tick),
                       static_cast<std::uint32_t>(level - '0'));
    if (batches_[role].full()) take_batches();
    return true;
  }

  // A time beyond the range may be converted to anything: then the piece is not regular.
  void take_batches() {
    const auto divided = [this](auto divisor) {
      take_batches([divisor](std::int64_t tick) {
        const auto ticks = static_cast<std::uint64_t>(tick);
        const std::uint64_t by = divisor();
        return static_cast<std::int64_t>(ticks / by + (ticks % by >= by / 2 ? 1 : 0));
      });
    };
    const auto factor = timescale().factor;
    switch (timescale().divisor) {
      case 1:
        return take_batches([factor](std::int64_t tick) {
          return static_cast<std::int64_t>(static_cast<std::uint64_t>(tick) * factor);
        });
      case 10:
        return divided([] { return std::uint64_t{10}; });
      case 100:
        return divided([] { return std::uint64_t{100}; });
      default:
        return divided([] { return std::uint64_t{1'000}; });
    }
  }

  template <class Convert>
  void take_batches(Convert convert) {
    batches_[VcdPair::ma].take(ma, convert);
    batches_[VcdPair::slo].take(slo, convert);
    batches_[VcdPair::other].forget();
  }

  bool finish() {
    take_batches();
    if (!timed) {
      early_ma = ma.times.size();
      early_slo = slo.times.size();
    }
    return !timed || last_tick <= timescale().last_tick();
  }

  const VcdPair* pair_;
  std::array<ChangeBatch, 3> batches_;  // by role
};

}  // namespace biss::capture
