#include "capture/vcd_piece.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "capture/decimal.hpp"

namespace biss::capture {

VcdPair::VcdPair(const VcdSignals& signals, std::uint32_t ma_variable, std::uint32_t slo_variable)
    : signals_(&signals), ma_variable_(ma_variable), slo_variable_(slo_variable) {
  for (std::size_t c = 0; c < roles_.size(); ++c) {
    roles_[c] = role_of(signals.ids.find_one(static_cast<char>(c)));
  }
}

namespace {

/// Reads a piece. Text of another form ends the piece.
class VcdQuickParser {
 public:
  VcdQuickParser(const VcdPair& pair, VcdPiece& piece)
      : pair_(pair), piece_(piece), timescale_(pair.signals().timescale) {}

  bool parse() {
    const char* p = piece_.begin();
    const char* const end = piece_.end();
    std::uint64_t line_feeds = 0;  // in a register, unlike the counts of other words
    FixedDigits digits(0);
    while (p != end) {
      if (*p == '#') {
        const char* const time_end = p + 1 + digits.count();
        std::uint64_t tick = 0;
        if (is_space(*time_end) && digits.count() != 0 && digits.read(time_end, tick)) {
          if (!set_tick(tick)) return false;
          line_feeds += *time_end == '\n' ? 1U : 0U;
          p = time_end + 1;
        } else {
          p = read_time(p, digits);
          if (p == nullptr) return false;
        }
      }
      const bool level = *p == '0' || *p == '1';
      if (level && is_space(p[2])) {
        if (!add_known(pair_.role_of(p[1]), *p)) return false;
        line_feeds += p[2] == '\n' ? 1U : 0U;
        p += 3;
      } else if (level && is_space(p[3])) {
        if (!add_known(pair_.role_of(pair_.signals().ids.find_two(p + 1)), *p)) return false;
        line_feeds += p[3] == '\n' ? 1U : 0U;
        p += 4;
      } else if (p != end && *p != '#') {
        p = read_other(p);
        if (p == nullptr) return false;
      }
    }
    line_feeds_ += line_feeds;
    return finish();
  }

 private:
  bool set_tick(std::uint64_t tick) {
    if (!timed_) {
      take_batches();
      timed_ = true;
      piece_.early_ma = piece_.ma.times.size();
      piece_.early_slo = piece_.slo.times.size();
      piece_.first_tick = tick;
    }
    const bool in_order = tick >= tick_;
    tick_ = tick;
    return in_order;
  }

  // A time of a different length than the one before.
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
    if (is_space(id[1])) return add(pair_.role_of(id[0]), level) ? id + 1 : nullptr;
    const char* const end = is_space(id[2]) ? id + 2 : end_of_word(id);
    const std::uint32_t variable = end == id + 2 ? pair_.signals().ids.find_two(id) : find(id, end);
    return add(pair_.role_of(variable), level) ? end : nullptr;
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
    if (id == piece_.end()) return nullptr;
    const char* const end = end_of_word(id);
    if (end - p > static_cast<std::ptrdiff_t>(max_token_bytes)) return nullptr;
    const std::uint32_t variable = find(id, end);
    const VcdPair::Role role = pair_.role_of(variable);
    if (one_bit) return add(role, vcd_kind_of(*value)) ? end : nullptr;
    return role == VcdPair::undeclared || pair_.signals().driven.drives(variable) ? nullptr : end;
  }

  const char* skip_space(const char* p) {
    for (; is_space(*p); ++p) line_feeds_ += *p == '\n' ? 1U : 0U;
    return p;
  }

  std::uint32_t find(const char* id, const char* end) const {
    const std::string_view text = text_between(id, end);
    return text.size() > long_enough ? VcdIds::none : pair_.signals().ids.find(text);
  }

  // False for a level that arrays cannot represent.
  bool add(VcdPair::Role role, VcdKind level) {
    if (role == VcdPair::other) return true;
    if (level == VcdKind::unknown) return false;
    return add_known(role, level == VcdKind::high ? '1' : '0');
  }

  /// \pre level is 0 or 1
  bool add_known(VcdPair::Role role, char level) {
    if (role == VcdPair::undeclared) return false;
    batches_[role].add(static_cast<std::int64_t>(tick_), static_cast<std::uint32_t>(level - '0'));
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
    const auto factor = timescale_.factor;
    switch (timescale_.divisor) {
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
    batches_[VcdPair::ma].take(piece_.ma, convert);
    batches_[VcdPair::slo].take(piece_.slo, convert);
    batches_[VcdPair::other].forget();
  }

  bool finish() {
    take_batches();
    piece_.timed = timed_;
    piece_.last_tick = tick_;
    piece_.line_feeds = line_feeds_;
    if (!timed_) {
      piece_.early_ma = piece_.ma.times.size();
      piece_.early_slo = piece_.slo.times.size();
    }
    return !timed_ || tick_ <= timescale_.last_tick();
  }

  static constexpr std::uint64_t long_enough = 64;  // identifiers beyond it are left to the reader

  const VcdPair& pair_;
  VcdPiece& piece_;
  Timescale timescale_;
  std::uint64_t tick_ = 0;
  std::uint64_t line_feeds_ = 0;
  bool timed_ = false;
  std::array<ChangeBatch, 3> batches_;  // by role
};

}  // namespace

bool VcdPiece::quick_parse() { return VcdQuickParser(*pair_, *this).parse(); }

}  // namespace biss::capture
