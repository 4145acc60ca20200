// What every reader of text shares: a sliding window over the text, and how edges are delivered.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

class TextPiece;
struct TextRest;

/// White space as VCD has it.
constexpr bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

inline std::string_view text_between(const char* from, const char* to) {
  return {from, static_cast<std::size_t>(to - from)};
}

/// Whether a CR that does not end the line is in it: the file has lines that end in CR alone.
inline bool has_cr_inside(std::string_view line) {
  return line.find_first_not_of("\r ", std::min(line.find('\r'), line.size())) !=
         std::string_view::npos;
}
/// What is expected instead.
inline constexpr const char* expected_line_ends = "lines that all end in LF or CR LF, or all in CR";

/// `text` with the letters A to Z in lower case.
std::string lower_case(std::string_view text);

/// Text in windows, in order and without gaps.
///
/// A window is begin()…end(), its last byte a delimiter; at least `readable_past_end` bytes after
/// it may be read and mean nothing. Blocks begin small and double while the source fills them;
/// memory is at most two of the largest and one token.
class TextWindow {
 public:
  /// Where windows may end: after any white space, or only after a line feed.
  enum class Cut : std::uint8_t { words, lines };
  enum class Fill : std::uint8_t { ready, ended, failed };

  static constexpr std::size_t first_block_bytes = 4'096;
  static constexpr std::size_t max_block_bytes = 262'144;
  static constexpr std::size_t readable_past_end = 16;

  TextWindow(std::unique_ptr<ByteSource> source, Cut cut);

  /// Leaves the window and makes the next. A byte order mark at the start is left out.
  /// `drop_long` drops what no delimiter ends within `max_token_bytes` (text of a comment) up to
  /// that delimiter; otherwise it fails with `token_too_long`. Fails with `read_failed` too.
  Fill next(bool drop_long = false);

  const char* begin() const { return buffer_.data() + at_; }
  const char* end() const { return buffer_.data() + cut_; }
  /// The window begins at `place` from now on.
  /// \pre begin() <= place && place <= end()
  void advance(const char* place) { at_ = static_cast<std::size_t>(place - buffer_.data()); }

  /// The window is one word or line with which the text ended; its delimiter was added.
  bool unterminated() const { return unterminated_; }

  /// Why next() failed.
  const CaptureError& error() const { return error_; }

  /// Gives away the source and what was read of it from begin() on; no next() follows. From now on
  /// the text comes in pieces, and the window is empty but between show() and leave().
  TextRest hand_over();
  /// The piece, the next one, becomes the window.
  void show(TextPiece& piece);
  /// Gives the text back to the piece.
  void leave(TextPiece& piece);
  /// Counts the piece as seen.
  void pass(const TextPiece& piece);

  /// An error at `place`, which lies in begin()…end() or anywhere the window has been since next().
  /// If a line of CSV has a CR inside, that is the cause.
  CaptureError error_at(const char* place, CaptureCause cause,
                        const char* expected = nullptr) const;

 private:
  // What one read may bring at most.
  std::size_t free_bytes() const { return buffer_.size() - readable_past_end - filled_; }
  bool is_delimiter(char c) const { return cut_at_words_ ? is_space(c) : c == '\n'; }
  void count_lines();
  void make_room();
  bool read_block();
  bool take_fresh();
  bool carry_fits(bool drop_long);
  void skip_byte_order_mark();
  Fill take_rest();
  void drop_carry();

  std::unique_ptr<ByteSource> source_;
  bool cut_at_words_;
  bool source_ended_ = false;
  bool unterminated_ = false;
  bool dropping_ = false;
  bool started_ = false;
  std::size_t fresh_bytes_ = 0;
  std::size_t block_bytes_ = first_block_bytes;
  std::vector<char> buffer_;
  // Places in the buffer: at_ <= cut_ <= filled_. After cut_ there is a token still without an end.
  std::size_t at_ = 0;
  std::size_t cut_ = 0;
  std::size_t filled_ = 0;
  // Lines are counted up to counted_, a place in the buffer; the others are offsets in the text.
  std::size_t counted_ = 0;
  std::uint64_t buffer_offset_ = 0;
  std::uint64_t line_offset_ = 0;
  std::uint64_t line_ = 1;
  CaptureError error_;
};

/// An EdgeSource over text. A format adds parse() and finish().
class TextSource : public EdgeSource {
 public:
  const std::vector<std::string>& lines() const final { return lines_; }
  Picoseconds end_time() const final { return end_time_; }
  Result<std::span<const wire::Edge>, CaptureError> next_block() final;
  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) final;

 protected:
  /// \param piece_limit the most text of a piece of pairs()
  TextSource(std::unique_ptr<ByteSource> bytes, TextWindow::Cut cut, std::size_t piece_limit)
      : window_(std::move(bytes), cut), piece_limit_(piece_limit) {}

  /// Reads on from the window's begin until the window is used up, the block is full or fail() was
  /// called; advances the window. While the block is not full, two edges a line fit.
  virtual void parse() = 0;
  /// The text has ended; may call fail().
  virtual void finish() = 0;
  /// Inside text whose words may have any length.
  virtual bool in_comment() const { return false; }

  /// Makes new_piece() possible; false where these lines cannot be read as arrays.
  virtual bool choose_pair(wire::LineIndex ma, wire::LineIndex slo) = 0;
  /// A piece for the lines chosen. Another thread may be in parse() or take_over().
  virtual std::unique_ptr<TextPiece> new_piece() const = 0;
  /// Remembers what the regular piece says as if parse() had read it; false, and nothing is
  /// remembered, where the piece cannot follow what was read before.
  virtual bool take_over(TextPiece& piece) = 0;

  /// Ends reading with an error, to be returned after the edges that came before it.
  void fail(const CaptureError& error) {
    error_ = error;
    state_ = State::failed;
  }
  bool failed() const { return state_ == State::failed; }
  const CaptureError& error() const { return error_; }

  TextWindow window_;
  EdgeBlock block_;
  std::vector<std::string> lines_;
  Picoseconds end_time_;

 private:
  enum class State : std::uint8_t { reading, ended, failed };
  class Pairs;

  void fill_window();
  bool settle(TextPiece& piece, const PairSource::OnEdges& on_edges);
  void parse_piece(const PairSource::OnEdges& on_edges);

  std::size_t piece_limit_;
  State state_ = State::reading;
  CaptureError error_;
};

}  // namespace biss::capture
