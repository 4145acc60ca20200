#include "capture/text_piece.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "capture/text_source.hpp"

namespace biss::capture {

TextCutter::TextCutter(TextRest rest, std::size_t piece_limit)
    : source_(std::move(rest.source)),
      cut_at_words_(rest.cut_at_words),
      piece_limit_(piece_limit),
      block_bytes_(std::min(TextWindow::first_block_bytes, piece_limit)),
      state_(rest.source_ended ? State::ended : State::reading),
      carry_(std::move(rest.text)) {}

bool TextCutter::is_delimiter(char c) const { return cut_at_words_ ? is_space(c) : c == '\n'; }

void TextCutter::read_more(TextPiece& piece) {
  const std::size_t filled = TextPiece::margin + piece.bytes;
  const std::size_t needed = filled + block_bytes_ + TextPiece::margin;
  if (piece.buffer.size() < needed) piece.buffer.resize(needed);
  const auto got = source_->read(std::span(piece.buffer).subspan(filled, block_bytes_));
  if (!got.ok()) {
    error_ = got.error();
    state_ = State::failed;
    return;
  }
  if (*got == 0) state_ = State::ended;
  if (*got == block_bytes_) block_bytes_ = std::min(2 * block_bytes_, piece_limit_);
  piece.bytes += *got;
}

// Drops the text up to the end of an overlong word.
void TextCutter::leave_out(TextPiece& piece) {
  char* const text = piece.buffer.data() + TextPiece::margin;
  char* const found =
      std::find_if(text, text + piece.bytes, [this](char c) { return is_delimiter(c); });
  const auto dropped = static_cast<std::size_t>(found - text);
  piece.left_out += dropped;
  piece.bytes -= dropped;
  if (piece.bytes == 0) return;
  std::memmove(text, found, piece.bytes);
  leaving_out_ = false;
}

// Ends the piece where a parser can go on without what came before: after a row where there is one
// near, else after any word. False when nothing ends in it; up to `searched` nothing does.
bool TextCutter::cut(TextPiece& piece, std::size_t searched) {
  constexpr std::ptrdiff_t longest_row = 4'096;
  const char* const text = piece.begin();
  const char* last = piece.end();
  while (last != text + searched && !is_delimiter(last[-1])) --last;
  if (last == text + searched) return false;
  const char* row = last;
  while (row != text && row[-1] != '\n' && last - row < longest_row) --row;
  if (row != text && row[-1] == '\n') last = row;
  carry_.assign(last, piece.end());
  piece.bytes -= carry_.size();
  return true;
}

void TextCutter::take_rest(TextPiece& piece) {
  const bool failed = std::exchange(state_, State::done) == State::failed;
  piece.part = failed ? TextPiece::Part::failed : TextPiece::Part::rest;
  piece.error = error_;
  if (failed) piece.bytes = 0;
  if (piece.bytes != 0) piece.buffer[TextPiece::margin + piece.bytes++] = '\n';
}

bool TextCutter::next(TextPiece& piece) {
  if (state_ == State::done) return false;
  const std::size_t around = 2 * TextPiece::margin;
  if (piece.buffer.size() < carry_.size() + around + 1) {
    piece.buffer.resize(carry_.size() + around + 1);
  }
  std::copy(carry_.begin(), carry_.end(), piece.buffer.begin() + TextPiece::margin);
  piece.bytes = carry_.size();
  piece.left_out = 0;
  piece.part = TextPiece::Part::whole;
  carry_.clear();
  for (std::size_t searched = 0;; searched = piece.bytes) {
    if (state_ == State::reading) read_more(piece);
    if (leaving_out_) leave_out(piece);
    if (cut(piece, searched)) break;
    if (state_ != State::reading) {
      take_rest(piece);
      break;
    }
    if (piece.bytes > max_token_bytes) {
      piece.part = TextPiece::Part::overlong;
      leaving_out_ = true;
      break;
    }
  }
  std::memset(piece.buffer.data() + TextPiece::margin + piece.bytes, 0, TextPiece::margin);
  return true;
}

}  // namespace biss::capture
