#include "capture/vcd.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "capture/decimal.hpp"
#include "capture/declared_lines.hpp"
#include "capture/text_source.hpp"
#include "capture/vcd_piece.hpp"

namespace biss::capture {
namespace {

bool is_one_bit(std::string_view type, std::string_view size) {
  constexpr std::array<std::string_view, 4> without_level{"real", "realtime", "string", "event"};
  if (std::find(without_level.begin(), without_level.end(), type) != without_level.end()) {
    return false;
  }
  return size.ends_with('1') && size.find_first_not_of('0') == size.size() - 1;
}

bool is_number(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Takes the declarations word by word.
///
/// Each one-bit `$var` is a line; its variable is the number of its identifier.
class VcdHeader {
 public:
  using Fault = std::optional<CaptureError>;

  explicit VcdHeader(VcdSignals& signals) : signals_(signals) {}

  /// The next word. Returns what is wrong with it.
  Fault feed(std::string_view word) {
    if (end_section_ == nullptr) return begin_section(word);
    if (word == "$end") return (this->*std::exchange(end_section_, nullptr))();
    if (in_comment()) return std::nullopt;
    if (words_.size() == max_words) return malformed("$end, after this many words");
    words_.emplace_back(word);
    return std::nullopt;
  }

  /// Text that is skipped up to `$end`; its words may have any length.
  bool in_comment() const { return end_section_ == &VcdHeader::end_comment; }
  bool started() const { return started_; }
  /// The signals are complete.
  bool done() const { return done_; }
  std::vector<std::string> take_names() { return lines_.take_names(); }

 private:
  using EndSection = Fault (VcdHeader::*)();

  static constexpr std::size_t max_words = 64;

  static constexpr CaptureError too_many{.cause = CaptureCause::too_many_lines};

  static CaptureError malformed(const char* expected) {
    return {.cause = CaptureCause::malformed, .expected = expected};
  }

  Fault begin_section(std::string_view keyword) {
    if (keyword.size() < 2 || keyword[0] != '$' || keyword[1] < 'a' || keyword[1] > 'z') {
      return malformed(started_ ? "a declaration such as $var, or $enddefinitions"
                                : "a VCD, which begins with a word such as $timescale or $date");
    }
    started_ = true;
    words_.clear();
    constexpr std::array<std::pair<std::string_view, EndSection>, 5> sections{{
        {"$timescale", &VcdHeader::end_timescale},
        {"$var", &VcdHeader::end_var},
        {"$scope", &VcdHeader::end_scope},
        {"$upscope", &VcdHeader::end_upscope},
        {"$enddefinitions", &VcdHeader::end_definitions},
    }};
    if (keyword == "$end") return malformed("a declaration for $end to close");
    // $date, $version, $comment, and keywords of single tools: text up to $end.
    end_section_ = &VcdHeader::end_comment;
    for (const auto& [name, end_section] : sections) {
      if (keyword == name) end_section_ = end_section;
    }
    return std::nullopt;
  }

  Fault end_comment() { return std::nullopt; }

  Fault end_timescale() {
    std::string text;
    for (const std::string& word : words_) text += word;
    const Timescale timescale = parse_vcd_timescale(text);
    if (!timescale.known()) {
      return malformed("a time scale of 1, 10 or 100 and s, ms, us, ns, ps or fs before this $end");
    }
    if (signals_.timescale.known() && timescale != signals_.timescale) {
      return malformed("one $timescale; this second one differs from the first");
    }
    signals_.timescale = timescale;
    return std::nullopt;
  }

  Fault end_var() {
    if (words_.size() < 4) return malformed("type, size, identifier and name before this $end");
    if (!is_number(words_[1])) return malformed("a number of bits as the second word of this $var");
    if (!VcdIds::valid(words_[2])) {
      return malformed("an identifier of printable characters as the third word of this $var");
    }
    const std::uint32_t variable = signals_.ids.add(words_[2]);
    if (signals_.ids.size() > max_variables || !lines_.store(words_[2].size())) {
      return too_many;
    }
    if (!is_one_bit(words_[0], words_[1])) return std::nullopt;
    if (!lines_.add(joined_name(std::span(words_).subspan(3)), variable)) {
      return too_many;
    }
    return std::nullopt;
  }

  Fault end_scope() {
    if (words_.size() < 2) return malformed("kind and name of the scope before this $end");
    if (lines_.depth() == DeclaredLines::max_depth) {
      return malformed("at most 256 nested scopes");
    }
    if (!lines_.open_scope(words_[1])) return too_many;
    return std::nullopt;
  }

  Fault end_upscope() {
    if (lines_.depth() == 0) return malformed("a $scope for this $upscope to close");
    lines_.close_scope();
    return std::nullopt;
  }

  Fault end_definitions() {
    if (!signals_.timescale.known()) return malformed("a $timescale before $enddefinitions");
    if (!lines_.finish()) return too_many;
    signals_.driven = DrivenLines(lines_, signals_.ids.size());
    done_ = true;
    return std::nullopt;
  }

  VcdSignals& signals_;
  EndSection end_section_ = nullptr;  // of the one that is open
  bool started_ = false;
  std::vector<std::string> words_;
  DeclaredLines lines_;
  bool done_ = false;
};

using wire::Level;
using Kind = VcdKind;

class VcdReader final : public TextSource {
 public:
  VcdReader(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit)
      : TextSource(std::move(bytes), TextWindow::Cut::words, piece_limit) {}

  // Reads the declarations; the cause when there are none.
  std::optional<CaptureError> open() {
    while (!header_->done()) {
      const auto more = window_.next(header_->in_comment());
      if (!more) return more.error();
      if (!*more && !header_->started()) return CaptureError{.cause = CaptureCause::empty};
      if (!*more) {
        return window_.error_at(window_.end(), CaptureCause::truncated, "$enddefinitions");
      }
      if (!read_declarations()) return error();
    }
    set_lines(header_->take_names());
    header_.reset();
    last_tick_ = signals_.timescale.last_tick();
    return std::nullopt;
  }

 private:
  // The value of a vector whose identifier is still to come.
  enum class Waiting : std::uint8_t { no, level, skipped };

  void parse() override {
    const char* p = window_.begin();
    const char* const end = window_.end();
    if (in_comment_) p = skip_comment(p);
    if (waiting_ != Waiting::no) p = read_waiting(p);
    while (p != nullptr && p != end && !block_.full()) {
      const Kind kind = vcd_kind_of(*p);
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

  void finish_text() override {
    if (waiting_ != Waiting::no) {
      stop(window_.end(), CaptureCause::truncated, "the identifier of this vector");
    } else if (in_comment_) {
      stop(window_.end(), CaptureCause::truncated, "$end");
    }
  }

  bool in_comment() const override { return in_comment_; }

  // Lines that change together are not a pair.
  bool choose_pair(wire::LineIndex ma, wire::LineIndex slo) override {
    const std::uint32_t ma_variable = signals_.driven.variable_of(ma);
    const std::uint32_t slo_variable = signals_.driven.variable_of(slo);
    if (ma_variable == slo_variable) return false;
    pair_.emplace(signals_, ma_variable, slo_variable);
    return true;
  }

  std::unique_ptr<TextPiece> new_piece() const override {
    return std::make_unique<VcdPiece>(*pair_);
  }

  bool take_over(TextPiece& text) override {
    auto& piece = static_cast<VcdPiece&>(text);
    if (waiting_ != Waiting::no || in_comment_) return false;
    if (piece.timed && piece.first_tick < tick_) return false;
    std::fill_n(piece.ma.times.begin(), piece.early_ma, end_time_.count);
    std::fill_n(piece.slo.times.begin(), piece.early_slo, end_time_.count);
    if (const auto level = last_level(piece.ma)) signals_.driven.note(pair_->ma_variable(), *level);
    if (const auto level = last_level(piece.slo))
      signals_.driven.note(pair_->slo_variable(), *level);
    if (!piece.timed) return true;
    tick_ = piece.last_tick;
    end_time_ = signals_.timescale.time_of(tick_);
    return true;
  }

  bool read_declarations() {
    const char* p = window_.begin();
    while (!header_->done()) {
      while (p != window_.end() && is_space(*p)) ++p;
      if (p == window_.end()) return true;
      const char* const word = p;
      p = end_of_word(p);
      const std::string_view text = text_between(word, p);
      const bool started = header_->started();
      if (text.size() > max_token_bytes && !header_->in_comment()) {
        return stop(word, CaptureCause::token_too_long) != nullptr;
      }
      if (const auto fault = header_->feed(text)) {
        const bool cut = started && window_.unterminated();
        return stop(word, cut ? CaptureCause::truncated : fault->cause, fault->expected) != nullptr;
      }
    }
    window_.advance(p);
    return true;
  }

  // Cold: it is called once, and the loop over the words is not laid out for it.
  [[gnu::cold]] const char* stop(const char* place, CaptureCause cause,
                                 const char* expected = nullptr) {
    fail(window_.error_at(place, cause, expected));
    return nullptr;
  }
  // The word is wrong; the end of the text may have cut it off.
  const char* stop_word(const char* place, const char* expected, bool may_be_cut = true) {
    const bool cut = may_be_cut && window_.unterminated();
    return stop(place, cut ? CaptureCause::truncated : CaptureCause::malformed, expected);
  }

  const char* read_word(const char* p) {
    const Kind kind = vcd_kind_of(*p);
    if (end_of_word(p) - p > static_cast<std::ptrdiff_t>(max_token_bytes)) {
      return stop(p, CaptureCause::token_too_long);
    }
    if (kind == Kind::none) {
      return stop(p, CaptureCause::malformed, "a value change, a time or a word such as $dumpvars");
    }
    if (kind == Kind::keyword) return read_keyword(p);
    if (kind == Kind::vector) return read_vector(p);
    waiting_ = Waiting::skipped;
    return read_waiting(end_of_word(p));
  }

  const char* read_scalar(const char* p, Level level) {
    const char* const id = p + 1;
    // The byte after a space may be after the window too: it can be read, and is not used.
    if (is_space(id[1])) {
      if (set_level(signals_.ids.find_one(id[0]), level)) return id + 1;
    } else if (is_space(id[2])) {
      if (set_level(signals_.ids.find_two(id), level)) return id + 2;
    }
    const char* const end = end_of_word(p);
    if (text_between(p, end).size() > max_token_bytes) return stop(p, CaptureCause::token_too_long);
    if (set_level(signals_.ids.find(text_between(id, end)), level)) return end;
    return stop_word(p, "a declared identifier directly after this value");
  }

  const char* read_time(const char* p) {
    const Digits digits = read_digits(p + 1);
    const auto length = digits.end - p;
    if (length >= 2 && length <= 20 && is_space(*digits.end)) {
      return set_tick(p, digits.value, digits.end);
    }
    return read_long_time(p, end_of_word(p));
  }

  // A time that is malformed, or long because of zeros before it.
  const char* read_long_time(const char* p, const char* end) {
    if (text_between(p, end).size() > max_token_bytes) return stop(p, CaptureCause::token_too_long);
    const char* const wrong =
        std::find_if_not(p + 1, end, [](char c) { return c >= '0' && c <= '9'; });
    if (wrong != end || end == p + 1) {
      return stop_word(p, "a whole number after #", end == p + 1);
    }
    std::uint64_t tick = 0;
    for (const char* digit = p + 1; digit != end; ++digit) {
      const auto value = static_cast<std::uint64_t>(*digit - '0');
      if (tick > (UINT64_MAX - value) / 10) return stop(p, CaptureCause::time_out_of_range);
      tick = tick * 10 + value;
    }
    return set_tick(p, tick, end);
  }

  const char* read_vector(const char* p) {
    const char* const end = end_of_word(p);
    const char* const wrong =
        std::find_if_not(p + 1, end, [](char c) { return vcd_kind_of(c) <= Kind::unknown; });
    if (end == p + 1 || wrong != end) {
      return stop_word(p, "bits of a vector after b", wrong == end);
    }
    waiting_ = end == p + 2 ? Waiting::level : Waiting::skipped;
    waiting_level_ = static_cast<Level>(vcd_kind_of(p[1]));
    return read_waiting(end);
  }

  // The identifier of a vector or a real; it may be in the next window only.
  const char* read_waiting(const char* p) {
    while (p != window_.end() && is_space(*p)) ++p;
    if (p == window_.end()) return p;
    const char* const end = end_of_word(p);
    if (end - p > static_cast<std::ptrdiff_t>(max_token_bytes)) {
      return stop(p, CaptureCause::token_too_long);
    }
    const std::uint32_t variable = signals_.ids.find(text_between(p, end));
    if (variable == VcdIds::none) return stop_word(p, "a declared identifier after a value");
    const Waiting waiting = std::exchange(waiting_, Waiting::no);
    if (waiting == Waiting::level) {
      set_level(variable, waiting_level_);
    } else if (signals_.driven.drives(variable)) {
      return stop(p, CaptureCause::malformed, "the value of one bit for a signal of one bit");
    }
    return end;
  }

  const char* read_keyword(const char* p) {
    constexpr std::array<std::string_view, 5> dump_words{"$end", "$dumpvars", "$dumpall", "$dumpon",
                                                         "$dumpoff"};
    constexpr std::array<std::string_view, 4> comments{"$comment", "$vcdclose", "$attrbegin",
                                                       "$attrend"};
    const char* const end = end_of_word(p);
    const std::string_view word = text_between(p, end);
    if (std::find(dump_words.begin(), dump_words.end(), word) != dump_words.end()) {
      // Nothing is recorded from here to $dumpon, whether or not the file has x for every signal.
      if (word == "$dumpoff") signals_.driven.lose_levels(end_time_, block_);
      return end;
    }
    if (std::find(comments.begin(), comments.end(), word) != comments.end()) {
      in_comment_ = true;
      return skip_comment(end);
    }
    return stop_word(p, "$dumpvars, $dumpall, $dumpon, $dumpoff, $comment or $end");
  }

  const char* skip_comment(const char* p) {
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

  const char* set_tick(const char* p, std::uint64_t tick, const char* end) {
    if (tick > last_tick_) return stop(p, CaptureCause::time_out_of_range);
    if (tick < tick_) {
      // Digits cut off at the end make a time smaller.
      const bool cut = window_.unterminated();
      return stop(p, cut ? CaptureCause::truncated : CaptureCause::time_backwards);
    }
    tick_ = tick;
    end_time_ = signals_.timescale.time_of(tick);
    return end;
  }

  // False when no such identifier was declared.
  bool set_level(std::uint32_t variable, Level level) {
    if (variable == VcdIds::none) return false;
    signals_.driven.set(variable, level, end_time_, block_);
    return true;
  }

  VcdSignals signals_;
  std::uint64_t last_tick_ = 0;
  std::uint64_t tick_ = 0;
  Waiting waiting_ = Waiting::no;
  Level waiting_level_ = Level::unknown;
  bool in_comment_ = false;
  std::optional<VcdPair> pair_;
  std::optional<VcdHeader> header_{signals_};  // until the declarations are complete
};

}  // namespace

Timescale parse_vcd_timescale(std::string_view text) {
  const std::size_t digits = std::min(text.find_first_not_of("01"), text.size());
  const std::string_view number = text.substr(0, digits);
  if (number != "1" && number != "10" && number != "100") return {};
  const std::uint64_t count = number.size() == 1 ? 1 : number.size() == 2 ? 10 : 100;
  const std::string_view unit = text.substr(digits);
  if (unit == "fs") return {1, 1'000 / count};
  if (unit == "ps") return {count, 1};
  if (unit == "ns") return {count * 1'000, 1};
  if (unit == "us") return {count * 1'000'000, 1};
  if (unit == "ms") return {count * 1'000'000'000, 1};
  if (unit == "s") return {count * 1'000'000'000'000, 1};
  return {};
}

Opened open_vcd(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit) {
  auto reader = std::make_unique<VcdReader>(std::move(bytes), piece_limit);
  if (const auto error = reader->open()) return tl::unexpected(*error);
  return reader;
}

namespace {

// 0 is `!`, 1 is `"`, … 94 is `!!`: the shortest identifiers first.
std::string id_of(std::size_t line) {
  constexpr std::size_t letters = '~' - '!' + 1;
  std::string id;
  for (;;) {
    id += static_cast<char>('!' + line % letters);
    if (line < letters) return id;
    line = line / letters - 1;
  }
}

std::string one_word(std::string_view name) {
  std::string word(name);
  for (char& c : word) {
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  if (word.empty() || word == "$end") return "_" + word;
  return word;
}

}  // namespace

VcdWriter::VcdWriter(std::vector<std::string> lines, ByteSink& sink)
    : EdgeWriter(std::move(lines), sink) {
  text() += "$timescale 1ps $end\n$scope module capture $end\n";
  for (const std::string& line : this->lines()) {
    ids_.push_back(id_of(ids_.size()));
    text() += "$var wire 1 " + ids_.back() + ' ' + one_word(line) + " $end\n";
  }
  text() += "$upscope $end\n$enddefinitions $end\n";
}

void VcdWriter::put_time(Picoseconds time) {
  text() += '#';
  append_number(static_cast<std::uint64_t>(time.count));
  text() += '\n';
}

void VcdWriter::put(const wire::Edge& edge, bool new_time) {
  if (new_time) put_time(edge.time);
  text() += "01x"[static_cast<std::size_t>(edge.level)];
  text() += ids_[edge.line];
  text() += '\n';
}

void VcdWriter::put_end(Picoseconds end_time, bool later) {
  if (later) put_time(end_time);
}

}  // namespace biss::capture
