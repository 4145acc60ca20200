#include "capture/vcd_reader.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/digits.hpp"
#include "capture/text_source.hpp"
#include "capture/vcd_header.hpp"

namespace biss::capture {
namespace {

using wire::Level;

// What a word's first character says it is; the first three are levels.
enum class Kind : std::uint8_t { low, high, unknown, space, time, vector, value, keyword, none };

constexpr std::array<Kind, 256> make_kinds() {
  std::array<Kind, 256> kinds{};
  kinds.fill(Kind::none);
  const auto set = [&kinds](std::string_view chars, Kind kind) {
    for (const char c : chars) kinds[static_cast<unsigned char>(c)] = kind;
  };
  set("0lL", Kind::low);
  set("1hH", Kind::high);
  set("xXzZuUwW-", Kind::unknown);
  set(" \t\n\v\f\r", Kind::space);
  set("#", Kind::time);
  set("bB", Kind::vector);
  set("rRsS", Kind::value);
  set("$", Kind::keyword);
  return kinds;
}

constexpr std::array<Kind, 256> kinds = make_kinds();
static_assert(static_cast<int>(Kind::low) == static_cast<int>(Level::low));
static_assert(static_cast<int>(Kind::high) == static_cast<int>(Level::high));
static_assert(static_cast<int>(Kind::unknown) == static_cast<int>(Level::unknown));

Kind kind_of(char c) { return kinds[static_cast<unsigned char>(c)]; }

// \pre a space follows
const char* end_of_word(const char* p) {
  while (!is_space(*p)) ++p;
  return p;
}

std::string_view text_between(const char* from, const char* to) {
  return {from, static_cast<std::size_t>(to - from)};
}

class VcdReader final : public TextSource {
 public:
  explicit VcdReader(std::unique_ptr<ByteSource> bytes)
      : TextSource(std::move(bytes), TextWindow::Cut::words) {}

  // Reads the declarations; the cause when there are none.
  std::optional<CaptureError> open();

 private:
  // The value of a vector whose identifier is still to come.
  enum class Waiting : std::uint8_t { no, level, skipped };

  struct Variable {
    std::uint32_t first;  // the line itself when there is one, else a place in driven_
    std::uint32_t lines;
    std::uint8_t level;
  };

  void parse() override;
  void finish() override;
  bool in_comment() const override { return in_comment_; }

  VcdHeader::Step read_declarations();
  void take_signals();
  const char* stop(const char* place, CaptureCause cause, const char* expected = nullptr);
  const char* read_word(const char* p);
  const char* read_scalar(const char* p, Level level);
  const char* read_time(const char* p);
  const char* read_long_time(const char* p, const char* end);
  const char* read_vector(const char* p);
  const char* read_waiting(const char* p);
  const char* read_keyword(const char* p);
  const char* skip_comment(const char* p);
  void lose_levels();
  const char* set_tick(const char* p, std::uint64_t tick, const char* end);
  bool set_level(std::uint32_t variable, Level level);

  std::vector<Variable> variables_;
  std::vector<wire::LineIndex> driven_;
  VcdTimescale timescale_;
  std::uint64_t last_tick_ = 0;
  std::uint64_t tick_ = 0;
  VcdIds ids_;
  Waiting waiting_ = Waiting::no;
  Level waiting_level_ = Level::unknown;
  bool in_comment_ = false;
  std::optional<VcdHeader> header_{std::in_place};  // until the declarations are complete
};

std::optional<CaptureError> VcdReader::open() {
  for (;;) {
    switch (window_.next(header_->in_comment())) {
      case TextWindow::Fill::failed:
        return window_.error();
      case TextWindow::Fill::ended:
        if (!header_->started()) return CaptureError{.cause = CaptureCause::empty};
        return window_.error_at(window_.end(), CaptureCause::truncated, "$enddefinitions");
      case TextWindow::Fill::ready:
        break;
    }
    const VcdHeader::Step step = read_declarations();
    if (step == VcdHeader::Step::failed) return error();
    if (step == VcdHeader::Step::done) break;
  }
  take_signals();
  return std::nullopt;
}

VcdHeader::Step VcdReader::read_declarations() {
  const char* p = window_.begin();
  const char* const end = window_.end();
  for (;;) {
    while (p != end && is_space(*p)) ++p;
    if (p == end) return VcdHeader::Step::more;
    const char* const word = p;
    p = end_of_word(p);
    const std::string_view text = text_between(word, p);
    const bool started = header_->started();
    if (text.size() > max_token_bytes && !header_->in_comment()) {
      stop(word, CaptureCause::token_too_long);
      return VcdHeader::Step::failed;
    }
    const VcdHeader::Step step = header_->feed(text);
    if (step == VcdHeader::Step::failed) {
      const bool cut = started && window_.unterminated();
      stop(word, cut ? CaptureCause::truncated : header_->cause(), header_->expected());
      return step;
    }
    if (step == VcdHeader::Step::done) {
      window_.advance(p);
      return step;
    }
  }
}

void VcdReader::take_signals() {
  VcdSignals& signals = header_->signals();
  lines_ = std::move(signals.lines);
  ids_ = std::move(signals.ids);
  driven_ = std::move(signals.driven);
  timescale_ = signals.timescale;
  last_tick_ = timescale_.last_tick();
  for (const VcdVariable& variable : signals.variables) {
    const std::uint32_t first = variable.lines == 1 ? driven_[variable.first] : variable.first;
    variables_.push_back({first, variable.lines, no_level});
  }
  header_.reset();
}

const char* VcdReader::stop(const char* place, CaptureCause cause, const char* expected) {
  fail(window_.error_at(place, cause, expected));
  return nullptr;
}

void VcdReader::parse() {
  const char* p = window_.begin();
  const char* const end = window_.end();
  if (in_comment_) p = skip_comment(p);
  if (waiting_ != Waiting::no) p = read_waiting(p);
  while (p != nullptr && p != end && !block_.full()) {
    const Kind kind = kind_of(*p);
    if (kind <= Kind::unknown) {
      p = read_scalar(p, static_cast<Level>(kind));
    } else if (kind == Kind::space) {
      ++p;
    } else if (kind == Kind::time) {
      p = read_time(p);
    } else {
      p = read_word(p);
    }
  }
  if (p != nullptr) window_.advance(p);
}

void VcdReader::finish() {
  if (waiting_ != Waiting::no) {
    stop(window_.end(), CaptureCause::truncated, "the identifier of this vector");
  } else if (in_comment_) {
    stop(window_.end(), CaptureCause::truncated, "$end");
  }
}

// False when no such identifier was declared.
inline bool VcdReader::set_level(std::uint32_t variable, Level level) {
  if (variable == VcdIds::none) return false;
  Variable& driver = variables_[variable];
  if (driver.level == static_cast<std::uint8_t>(level)) return true;
  driver.level = static_cast<std::uint8_t>(level);
  if (driver.lines == 1) {
    block_.push({end_time_, driver.first, level});
    return true;
  }
  for (std::uint32_t i = 0; i < driver.lines; ++i) {
    block_.push({end_time_, driven_[driver.first + i], level});
  }
  return true;
}

inline const char* VcdReader::read_scalar(const char* p, Level level) {
  const char* const id = p + 1;
  // What lies behind a space may be behind the window too: readable, and not used.
  if (is_space(id[1])) {
    if (set_level(ids_.find_one(id[0]), level)) return id + 1;
  } else if (is_space(id[2])) {
    if (set_level(ids_.find_two(id), level)) return id + 2;
  }
  const char* const end = end_of_word(p);
  if (text_between(p, end).size() > max_token_bytes) return stop(p, CaptureCause::token_too_long);
  if (set_level(ids_.find(text_between(id, end)), level)) return end;
  const bool cut = window_.unterminated();
  return stop(p, cut ? CaptureCause::truncated : CaptureCause::malformed,
              "a declared identifier right behind this value");
}

inline const char* VcdReader::set_tick(const char* p, std::uint64_t tick, const char* end) {
  if (tick > last_tick_) return stop(p, CaptureCause::time_out_of_range);
  if (tick < tick_) {
    // Digits cut off at the end make a time smaller.
    const bool cut = window_.unterminated();
    return stop(p, cut ? CaptureCause::truncated : CaptureCause::time_backwards);
  }
  tick_ = tick;
  end_time_ = timescale_.time_of(tick);
  return end;
}

inline const char* VcdReader::read_time(const char* p) {
  const Digits digits = read_digits(p + 1);
  const auto length = digits.end - p;
  if (length >= 2 && length <= 20 && is_space(*digits.end)) {
    return set_tick(p, digits.value, digits.end);
  }
  return read_long_time(p, end_of_word(p));
}

// A time that is malformed, or long because of zeros before it.
const char* VcdReader::read_long_time(const char* p, const char* end) {
  if (text_between(p, end).size() > max_token_bytes) return stop(p, CaptureCause::token_too_long);
  const char* const wrong =
      std::find_if_not(p + 1, end, [](char c) { return c >= '0' && c <= '9'; });
  if (wrong != end || end == p + 1) {
    const bool cut = window_.unterminated() && end == p + 1;
    return stop(p, cut ? CaptureCause::truncated : CaptureCause::malformed,
                "a whole number behind #");
  }
  std::uint64_t tick = 0;
  for (const char* digit = p + 1; digit != end; ++digit) {
    const auto value = static_cast<std::uint64_t>(*digit - '0');
    if (tick > (UINT64_MAX - value) / 10) return stop(p, CaptureCause::time_out_of_range);
    tick = tick * 10 + value;
  }
  return set_tick(p, tick, end);
}

const char* VcdReader::read_word(const char* p) {
  const Kind kind = kind_of(*p);
  if (kind == Kind::none) {
    return stop(p, CaptureCause::malformed, "a value change, a time or a word such as $dumpvars");
  }
  if (end_of_word(p) - p > static_cast<std::ptrdiff_t>(max_token_bytes)) {
    return stop(p, CaptureCause::token_too_long);
  }
  if (kind == Kind::keyword) return read_keyword(p);
  if (kind == Kind::vector) return read_vector(p);
  waiting_ = Waiting::skipped;
  return read_waiting(end_of_word(p));
}

const char* VcdReader::read_vector(const char* p) {
  const char* const end = end_of_word(p);
  const char* const wrong =
      std::find_if_not(p + 1, end, [](char c) { return kind_of(c) <= Kind::unknown; });
  if (end == p + 1 || wrong != end) {
    const bool cut = window_.unterminated() && wrong == end;
    return stop(p, cut ? CaptureCause::truncated : CaptureCause::malformed,
                "bits of a vector behind b");
  }
  waiting_ = end == p + 2 ? Waiting::level : Waiting::skipped;
  waiting_level_ = static_cast<Level>(kind_of(p[1]));
  return read_waiting(end);
}

// The identifier of a vector or a real; it may be in the next window only.
const char* VcdReader::read_waiting(const char* p) {
  while (p != window_.end() && is_space(*p)) ++p;
  if (p == window_.end()) return p;
  const char* const end = end_of_word(p);
  if (end - p > static_cast<std::ptrdiff_t>(max_token_bytes)) {
    return stop(p, CaptureCause::token_too_long);
  }
  const std::uint32_t variable = ids_.find(text_between(p, end));
  const bool cut = window_.unterminated();
  if (variable == VcdIds::none) {
    return stop(p, cut ? CaptureCause::truncated : CaptureCause::malformed,
                "a declared identifier behind a value");
  }
  const Waiting waiting = std::exchange(waiting_, Waiting::no);
  if (waiting == Waiting::level) {
    set_level(variable, waiting_level_);
  } else if (variables_[variable].lines != 0) {
    return stop(p, CaptureCause::malformed, "the value of one bit for a signal of one bit");
  }
  return end;
}

void VcdReader::lose_levels() {
  for (std::uint32_t variable = 0; variable < variables_.size(); ++variable) {
    if (variables_[variable].level != no_level) set_level(variable, Level::unknown);
  }
}

const char* VcdReader::read_keyword(const char* p) {
  constexpr std::array<std::string_view, 5> dump_words{"$end", "$dumpvars", "$dumpall", "$dumpon",
                                                       "$dumpoff"};
  constexpr std::array<std::string_view, 4> comments{"$comment", "$vcdclose", "$attrbegin",
                                                     "$attrend"};
  const char* const end = end_of_word(p);
  const std::string_view word = text_between(p, end);
  if (std::find(dump_words.begin(), dump_words.end(), word) != dump_words.end()) {
    // Nothing is recorded from here to $dumpon, whether or not the file says x for every signal.
    if (word == "$dumpoff") lose_levels();
    return end;
  }
  if (std::find(comments.begin(), comments.end(), word) != comments.end()) {
    in_comment_ = true;
    return skip_comment(end);
  }
  const bool cut = window_.unterminated();
  return stop(p, cut ? CaptureCause::truncated : CaptureCause::malformed,
              "$dumpvars, $dumpall, $dumpon, $dumpoff, $comment or $end");
}

const char* VcdReader::skip_comment(const char* p) {
  while (p != window_.end()) {
    if (is_space(*p)) {
      ++p;
      continue;
    }
    const char* const end = end_of_word(p);
    if (text_between(p, end) == "$end") {
      in_comment_ = false;
      return end;
    }
    p = end;
  }
  return p;
}

}  // namespace

Opened open_vcd(std::unique_ptr<ByteSource> bytes) {
  auto reader = std::make_unique<VcdReader>(std::move(bytes));
  if (const auto error = reader->open()) return {nullptr, *error};
  return {std::move(reader), {}};
}

}  // namespace biss::capture
