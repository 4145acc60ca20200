#include "capture/text_source.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "capture/csv_cells.hpp"
#include "capture/text_piece.hpp"

namespace biss::capture {
namespace {

// Eight bytes at a time: counting lines must cost little beside reading them.
std::uint64_t count_line_feeds(const char* from, const char* to) {
  constexpr std::uint64_t ones = 0x0101010101010101U;
  constexpr std::uint64_t low_seven = 0x7F * ones;
  std::uint64_t count = 0;
  for (; to - from >= 8; from += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, from, sizeof word);
    const std::uint64_t differs = word ^ ('\n' * ones);
    const std::uint64_t set_where_not = ((differs & low_seven) + low_seven) | differs | low_seven;
    // A bit for each found, added up into the top byte: quicker than popcount where that is a call.
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

TextWindow::TextWindow(std::unique_ptr<ByteSource> source, Cut cut)
    : source_(std::move(source)),
      cut_at_words_(cut == Cut::words),
      buffer_(2 * first_block_bytes + readable_past_end) {}

void TextWindow::count_lines() {
  const char* const from = buffer_.data() + counted_;
  const char* const to = buffer_.data() + cut_;
  const std::uint64_t found = count_line_feeds(from, to);
  counted_ = cut_;
  if (found == 0) return;
  line_ += found;
  const char* last = to;
  while (last[-1] != '\n') --last;
  line_offset_ = buffer_offset_ + static_cast<std::uint64_t>(last - buffer_.data());
}

CaptureError TextWindow::error_at(const char* place, CaptureCause cause,
                                  const char* expected) const {
  const char* const from = buffer_.data() + counted_;
  const char* start = place;
  while (start > from && start[-1] != '\n') --start;
  const auto offset_of = [this](const char* p) {
    return buffer_offset_ + static_cast<std::uint64_t>(p - buffer_.data());
  };
  const std::uint64_t line_start = start > from ? offset_of(start) : line_offset_;
  CaptureError error{cause, line_ + count_line_feeds(from, place),
                     offset_of(place) - line_start + 1, expected};
  const char* const end = find_or_end(place, buffer_.data() + filled_, '\n');
  if (!cut_at_words_ && has_cr_inside(text_between(start, end))) {
    error.cause = CaptureCause::malformed;
    error.expected = expected_line_ends;
  }
  return error;
}

// Moves the token without an end to the front when less than a block is free after it.
void TextWindow::make_room() {
  if (free_bytes() >= block_bytes_) return;
  std::memmove(buffer_.data(), buffer_.data() + cut_, filled_ - cut_);
  buffer_offset_ += cut_;
  filled_ -= cut_;
  counted_ = at_ = cut_ = 0;
  if (free_bytes() >= block_bytes_) return;
  buffer_.resize(filled_ + 2 * block_bytes_ + readable_past_end);
}

// False when the source failed.
bool TextWindow::read_block() {
  make_room();
  const auto got = source_->read(std::span(buffer_).subspan(filled_, block_bytes_));
  if (!got.ok()) {
    error_ = got.error();
    return false;
  }
  if (*got == block_bytes_) block_bytes_ = std::min(2 * block_bytes_, max_block_bytes);
  source_ended_ = *got == 0;
  fresh_bytes_ = *got;
  return true;
}

void TextWindow::drop_carry() {
  buffer_offset_ += filled_ - cut_;
  filled_ = cut_;
  dropping_ = true;
}

// Takes in what was read; true when a window can be made of it.
bool TextWindow::take_fresh() {
  char* const fresh = buffer_.data() + filled_;
  filled_ += fresh_bytes_;
  char* last = buffer_.data() + filled_;
  while (last != fresh && !is_delimiter(last[-1])) --last;
  if (last == fresh) {
    if (dropping_) drop_carry();
    return false;
  }
  cut_ = static_cast<std::size_t>(last - buffer_.data());
  if (dropping_) {
    while (!is_delimiter(buffer_[at_])) ++at_;
    dropping_ = false;
  }
  return true;
}

// The text has ended: what is left becomes the last window.
TextWindow::Fill TextWindow::take_rest() {
  if (cut_ == filled_) return Fill::ended;
  buffer_[filled_] = '\n';
  cut_ = ++filled_;
  unterminated_ = true;
  return Fill::ready;
}

bool TextWindow::carry_fits(bool drop_long) {
  if (filled_ - cut_ <= max_token_bytes) return true;
  if (drop_long) {
    drop_carry();
    return true;
  }
  error_ = error_at(buffer_.data() + cut_, CaptureCause::token_too_long);
  return false;
}

TextWindow::Fill TextWindow::next(bool drop_long) {
  count_lines();
  at_ = cut_;
  Fill fill = Fill::ready;
  do {
    if (!carry_fits(drop_long)) return Fill::failed;
    if (!source_ended_ && !read_block()) return Fill::failed;
    if (source_ended_) fill = take_rest();
  } while (!source_ended_ && !take_fresh());
  if (!std::exchange(started_, true)) skip_byte_order_mark();
  return fill;
}

void TextWindow::skip_byte_order_mark() {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  if (!std::string_view(begin(), static_cast<std::size_t>(end() - begin())).starts_with(mark))
    return;
  at_ += mark.size();
  line_offset_ = mark.size();
}

TextRest TextWindow::hand_over() {
  const std::size_t from = std::exchange(cut_, at_);
  count_lines();
  TextRest rest{std::move(source_), source_ended_, cut_at_words_, {}};
  rest.text.assign(buffer_.data() + at_, buffer_.data() + filled_);
  // The delimiter that was added is added once more when the rest is read.
  if (unterminated_ && at_ != from) rest.text.pop_back();
  buffer_offset_ += at_;
  buffer_ = {};
  counted_ = at_ = cut_ = filled_ = 0;
  return rest;
}

void TextWindow::show(TextPiece& piece) {
  // The offset of the margin before the text may be below 0, which comes right again.
  buffer_offset_ += piece.left_out - TextPiece::margin;
  buffer_.swap(piece.buffer);
  counted_ = at_ = TextPiece::margin;
  cut_ = filled_ = TextPiece::margin + piece.bytes;
  unterminated_ = piece.part == TextPiece::Part::rest && piece.bytes != 0;
}

void TextWindow::leave(TextPiece& piece) {
  count_lines();
  buffer_.swap(piece.buffer);
  buffer_offset_ += cut_;
  counted_ = at_ = cut_ = filled_ = 0;
}

void TextWindow::pass(const TextPiece& piece) {
  const char* last = piece.end();
  buffer_offset_ += piece.left_out + piece.bytes;
  if (piece.line_feeds == 0) return;
  line_ += piece.line_feeds;
  while (last[-1] != '\n') --last;
  line_offset_ = buffer_offset_ - static_cast<std::uint64_t>(piece.end() - last);
}

/// The rest of a text in pieces: the reader of its format settles them.
class TextSource::Pairs final : public PairSource {
 public:
  explicit Pairs(TextSource& text)
      : text_(&text), cutter_(text.window_.hand_over(), text.piece_limit_) {
    ended_ = text.state_ != State::reading;
    if (text.failed()) error_ = text.error_;
  }

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    if (ended_) return nullptr;
    if (!used) used = text_->new_piece();
    if (cutter_.next(static_cast<TextPiece&>(*used))) return used;
    return nullptr;
  }

  bool settle(PairPiece& piece, const OnEdges& on_edges) override {
    const bool regular = text_->settle(static_cast<TextPiece&>(piece), on_edges);
    if (text_->failed()) error_ = text_->error_;
    return regular;
  }

  Picoseconds end_time() const override { return text_->end_time_; }
  const std::optional<CaptureError>& error() const override { return error_; }

 private:
  TextSource* text_;
  TextCutter cutter_;
  bool ended_ = false;
  std::optional<CaptureError> error_;
};

std::unique_ptr<PairSource> TextSource::pairs(wire::LineIndex ma, wire::LineIndex slo) {
  if (!choose_pair(ma, slo)) return nullptr;
  return std::make_unique<Pairs>(*this);
}

void TextSource::parse_piece(const PairSource::OnEdges& on_edges) {
  while (state_ == State::reading && window_.begin() != window_.end()) {
    block_.grow();
    block_.prepare(2 * lines_.size());
    parse();
    if (!block_.empty()) on_edges(block_.edges());
  }
}

bool TextSource::settle(TextPiece& piece, const PairSource::OnEdges& on_edges) {
  if (state_ != State::reading) return false;
  if (piece.regular && take_over(piece)) {
    window_.pass(piece);
    return true;
  }
  window_.show(piece);
  if (piece.part != TextPiece::Part::overlong) {
    parse_piece(on_edges);
  } else if (!in_comment()) {
    fail(window_.error_at(window_.begin(), CaptureCause::token_too_long));
  }
  if (state_ == State::reading && piece.part == TextPiece::Part::failed) fail(piece.error);
  if (state_ == State::reading && piece.part == TextPiece::Part::rest) {
    state_ = State::ended;
    finish();
  }
  window_.leave(piece);
  return false;
}

void TextSource::fill_window() {
  switch (window_.next(in_comment())) {
    case TextWindow::Fill::ready:
      return;
    case TextWindow::Fill::failed:
      return fail(window_.error());
    case TextWindow::Fill::ended:
      state_ = State::ended;
      return finish();
  }
}

Result<std::span<const wire::Edge>, CaptureError> TextSource::next_block() {
  block_.grow();
  block_.prepare(2 * lines_.size());
  while (state_ == State::reading && block_.empty()) {
    if (window_.begin() == window_.end()) {
      fill_window();
    } else {
      parse();
    }
  }
  if (block_.empty() && state_ == State::failed) return failure(error_);
  return block_.edges();
}

}  // namespace biss::capture
