#include "capture/text_source.hpp"

#include <cstring>

#include "capture/csv_cells.hpp"

namespace biss::capture {
namespace {

// Eight bytes at a time: counting lines must cost little compared with reading them.
std::uint64_t count_line_feeds(const char* from, const char* to) {
  constexpr std::uint64_t ones = 0x0101010101010101U;
  constexpr std::uint64_t low_seven = 0x7F * ones;
  std::uint64_t count = 0;
  for (; to - from >= 8; from += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, from, sizeof word);
    const std::uint64_t differs = word ^ ('\n' * ones);
    const std::uint64_t set_where_not = ((differs & low_seven) + low_seven) | differs | low_seven;
    // A bit for each line feed found, added up into the top byte. This is quicker than popcount if
    // popcount is a call.
    count += (((~set_where_not) >> 7U) * ones) >> 56U;
  }
  return count + static_cast<std::uint64_t>(std::count(from, to, '\n'));
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

TextCutter::TextCutter(std::unique_ptr<ByteSource> source, Cut cut, std::size_t most_bytes)
    : source_(std::move(source)),
      cut_(cut),
      most_bytes_(most_bytes),
      block_bytes_(std::min<std::size_t>(4'096, most_bytes)) {}

void TextCutter::read_more(TextStretch& text) {
  const std::size_t filled = TextStretch::margin + text.bytes;
  const std::size_t needed = filled + block_bytes_ + TextStretch::margin;
  if (text.buffer.size() < needed) text.buffer.resize(needed);
  const auto got = source_->read(std::span(text.buffer).subspan(filled, block_bytes_));
  if (!got.ok()) {
    error_ = got.error();
    state_ = State::failed;
    return;
  }
  if (*got == 0) state_ = State::ended;
  if (*got == block_bytes_) block_bytes_ = std::min(2 * block_bytes_, most_bytes_);
  text.bytes += *got;
}

// Drops the text up to the end of an overlong word.
void TextCutter::leave_out(TextStretch& text) {
  char* const begin = text.buffer.data() + TextStretch::margin;
  char* const found =
      std::find_if(begin, begin + text.bytes, [this](char c) { return is_delimiter(c); });
  const auto dropped = static_cast<std::size_t>(found - begin);
  text.left_out += dropped;
  text.bytes -= dropped;
  if (text.bytes == 0) return;
  std::memmove(begin, found, text.bytes);
  leaving_out_ = false;
}

// Ends the text at a place from which a parser can continue without the earlier text: after a row
// if one ends nearby, else after any word. False when nothing ends in it; up to `searched` nothing
// does.
bool TextCutter::cut(TextStretch& text, std::size_t searched) {
  constexpr std::ptrdiff_t longest_row = 4'096;
  const char* const begin = text.begin();
  const char* last = text.end();
  while (last != begin + searched && !is_delimiter(last[-1])) --last;
  if (last == begin + searched) return false;
  const char* row = last;
  while (row != begin && row[-1] != '\n' && last - row < longest_row) --row;
  if (row != begin && row[-1] == '\n') last = row;
  carry_.assign(last, text.end());
  text.bytes -= carry_.size();
  return true;
}

void TextCutter::take_rest(TextStretch& text) {
  const bool failed = std::exchange(state_, State::done) == State::failed;
  text.part = failed ? TextStretch::Part::failed : TextStretch::Part::rest;
  text.error = error_;
  if (failed) text.bytes = 0;
  if (text.bytes != 0) text.buffer[TextStretch::margin + text.bytes++] = '\n';
}

bool TextCutter::next(TextStretch& text) {
  if (state_ == State::done) return false;
  const std::size_t around = 2 * TextStretch::margin;
  if (text.buffer.size() < carry_.size() + around + 1) {
    text.buffer.resize(carry_.size() + around + 1);
  }
  std::copy(carry_.begin(), carry_.end(), text.buffer.begin() + TextStretch::margin);
  text.bytes = carry_.size();
  text.left_out = 0;
  text.part = TextStretch::Part::whole;
  carry_.clear();
  for (std::size_t searched = 0;; searched = text.bytes) {
    if (state_ == State::reading) read_more(text);
    if (leaving_out_) leave_out(text);
    if (cut(text, searched)) break;
    if (state_ != State::reading) {
      take_rest(text);
      break;
    }
    if (text.bytes > max_token_bytes) {
      text.part = TextStretch::Part::overlong;
      leaving_out_ = true;
      break;
    }
  }
  std::memset(text.buffer.data() + TextStretch::margin + text.bytes, 0, TextStretch::margin);
  return true;
}

void TextCutter::put_back(const TextStretch& last, const char* from) {
  const bool ended = state_ == State::done;
  // The delimiter that was added is added once more.
  const char* const end = last.end() - (ended && from != last.end() ? 1 : 0);
  carry_.insert(carry_.begin(), from, end);
  if (ended) state_ = State::ended;
}

void TextWindow::show(const TextStretch& text) {
  text_ = &text;
  at_ = text.begin();
}

void TextWindow::pass(const TextStretch& text, std::uint64_t line_feeds) {
  offset_ += text.left_out + text.bytes;
  if (line_feeds == 0) return;
  line_ += line_feeds;
  const char* last = text.end();
  while (last[-1] != '\n') --last;
  line_offset_ = offset_ - static_cast<std::uint64_t>(text.end() - last);
}

void TextWindow::leave() {
  pass(*text_, count_line_feeds(text_->begin(), text_->end()));
  own_.bytes = own_.left_out = 0;
  show(own_);
}

TextCutter& TextWindow::hand_over() {
  cutter_.put_back(own_, at_);
  own_.bytes = static_cast<std::size_t>(at_ - own_.begin());
  leave();
  return cutter_;
}

tl::expected<bool, CaptureError> TextWindow::next(bool drop_long) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  do {
    leave();
    if (!cutter_.next(own_)) return false;
    show(own_);
  } while (drop_long && own_.part == TextStretch::Part::overlong);
  if (!std::exchange(started_, true) && text_between(at_, end()).starts_with(mark)) {
    at_ += mark.size();
    line_offset_ = mark.size();
  }
  if (own_.part == TextStretch::Part::overlong) {
    return tl::unexpected(error_at(at_, CaptureCause::token_too_long));
  }
  if (own_.part == TextStretch::Part::failed) return tl::unexpected(own_.error);
  return own_.part == TextStretch::Part::whole || own_.bytes != 0;
}

CaptureError TextWindow::error_at(const char* place, CaptureCause cause,
                                  const char* expected) const {
  const char* const from = text_->begin();
  const char* start = place;
  while (start > from && start[-1] != '\n') --start;
  const auto offset_of = [&](const char* p) {
    return offset_ + text_->left_out + static_cast<std::uint64_t>(p - from);
  };
  const std::uint64_t line_start = start > from ? offset_of(start) : line_offset_;
  CaptureError error{cause, line_ + count_line_feeds(from, place),
                     offset_of(place) - line_start + 1, expected};
  const char* const end = find_or_end(place, text_->end(), '\n');
  if (!cut_at_words_ && has_cr_inside(text_between(start, end))) {
    error.cause = CaptureCause::malformed;
    error.expected = expected_line_ends;
  }
  return error;
}

/// The rest of a text in pieces: the reader of its format settles them.
class TextSource::Pairs final : public PairSource {
 public:
  explicit Pairs(TextSource& text)
      : text_(&text), cutter_(&text.window_.hand_over()), ended_(text.ended()) {}

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    if (ended_) return nullptr;
    if (!used) used = text_->new_piece();
    if (cutter_->next(static_cast<TextPiece&>(*used))) return used;
    return nullptr;
  }

  bool settle(PairPiece& piece, const OnEdges& on_edges) override {
    return text_->settle(static_cast<TextPiece&>(piece), on_edges);
  }

  Picoseconds end_time() const override { return text_->end_time_; }
  const std::optional<CaptureError>& error() const override { return text_->error(); }

 private:
  TextSource* text_;
  TextCutter* cutter_;
  bool ended_;
};

std::unique_ptr<PairSource> TextSource::pairs(wire::LineIndex ma, wire::LineIndex slo) {
  if (!choose_pair(ma, slo)) return nullptr;
  return std::make_unique<Pairs>(*this);
}

bool TextSource::settle(TextPiece& piece, const PairSource::OnEdges& on_edges) {
  if (ended()) return false;
  if (piece.regular && take_over(piece)) {
    window_.pass(piece, piece.line_feeds);
    return true;
  }
  window_.show(piece);
  if (piece.part == TextPiece::Part::overlong) {
    if (!in_comment()) fail(window_.error_at(window_.begin(), CaptureCause::token_too_long));
  } else {
    while (!ended() && window_.begin() != window_.end()) {
      renew_block();
      parse();
      if (!block_.empty()) on_edges(block_.edges());
    }
  }
  if (!ended() && piece.part == TextPiece::Part::failed) fail(piece.error);
  if (!ended() && piece.part == TextPiece::Part::rest) end();
  window_.leave();
  return false;
}

void TextSource::end() {
  finish();
  finish_text();
}

void TextSource::step() {
  if (window_.begin() != window_.end()) return parse();
  const auto more = window_.next(in_comment());
  if (!more) return fail(more.error());
  if (!*more) end();
}

}  // namespace biss::capture
