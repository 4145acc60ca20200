// Shared by all readers of text: the text in stretches, and how edges are delivered.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

/// White space as VCD defines it.
constexpr bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

inline std::string_view text_between(const char* from, const char* to) {
  return {from, static_cast<std::size_t>(to - from)};
}

/// Whether a CR that does not end the line is in it: the file has lines that end in CR alone.
inline bool has_cr_inside(std::string_view line) {
  return line.find_first_not_of("\r ", std::min(line.find('\r'), line.size())) !=
         std::string_view::npos;
}
/// The valid content at this place.
inline constexpr const char* expected_line_ends = "lines that all end in LF or CR LF, or all in CR";

/// `text` with the letters A to Z in lower case.
std::string lower_case(std::string_view text);

/// A stretch of text, whole words or rows.
struct TextStretch {
  enum class Part : std::uint8_t {
    whole,     ///< words or rows with their delimiters
    overlong,  ///< one without an end, too long to be valid; its rest is left out
    rest,      ///< the end of the capture: one without an end, which was added, or nothing
    failed,    ///< nothing more could be read
  };

  /// Bytes around the text that may be read: the bytes before it mean nothing, the bytes after it
  /// are 0.
  static constexpr std::size_t margin = 24;

  const char* begin() const { return buffer.data() + margin; }
  const char* end() const { return begin() + bytes; }

  Part part = Part::whole;
  std::vector<char> buffer = std::vector<char>(2 * margin);
  std::size_t bytes = 0;
  /// Bytes of the capture before the text: the end of an overlong word.
  std::uint64_t left_out = 0;
  CaptureError error;  ///< of a failed stretch
};

/// A stretch of text on its way to changes of two lines.
///
/// A format adds quick_parse(), which handles text in its usual form. All other text is left to the
/// reader of the format, which handles every form and keeps the state from the earlier text.
class TextPiece : public PairPiece, public TextStretch {
 public:
  void expand() final {
    ma.clear();
    slo.clear();
    regular = part == Part::whole && quick_parse();
  }

  bool regular = false;          ///< `ma` and `slo` have all changes of the two lines
  std::uint64_t line_feeds = 0;  ///< of a regular piece

 protected:
  /// Reads the text into `ma` and `slo` and counts its line feeds; false when it holds anything
  /// that is not plainly right.
  virtual bool quick_parse() = 0;
};

/// The level after the last change; nothing if there is no change.
inline std::optional<wire::Level> last_level(const LineChanges& changes) {
  if (changes.times.empty()) return std::nullopt;
  return changes.run().level(changes.times.size() - 1);
}

/// Collects the changes of one line, a repeated level left out.
class ChangeBatch {
 public:
  static constexpr std::size_t size = 512;

  /// \pre not full()
  void add(std::int64_t time, std::uint32_t level) {
    times_[count_] = time;
    count_ += level_ != level ? 1U : 0U;
    level_ = level;
  }
  bool full() const { return count_ == size; }
  /// Moves the collected changes to the end of `changes`, each time as `convert` gives it.
  template <class Convert>
  void take(LineChanges& changes, Convert convert) {
    for (std::size_t i = 0; i < count_; ++i) times_[i] = convert(times_[i]);
    changes.times.insert(changes.times.end(), times_.data(), times_.data() + count_);
    count_ = 0;
    changes.first_high = (level_ == 1) == (changes.times.size() % 2 == 1);
  }
  void forget() { count_ = 0; }
  /// The level before the next change is not known.
  void restart() {
    forget();
    level_ = no_level;
  }

 private:
  std::array<std::int64_t, size> times_;
  std::size_t count_ = 0;
  std::uint32_t level_ = no_level;
};

/// Divides a text into stretches, in order and without gaps. A stretch is the result of one read,
/// so that the changes of a slow pipe are delivered as they arrive. Reads begin small and double
/// while the source fills them.
class TextCutter {
 public:
  /// The places at which stretches may end: after any white space, or only after a line feed.
  enum class Cut : std::uint8_t { words, lines };

  /// \param most_bytes that one read brings \pre most_bytes > 0
  TextCutter(std::unique_ptr<ByteSource> source, Cut cut, std::size_t most_bytes);

  /// The next stretch; false after the last, which is `rest` or `failed`.
  bool next(TextStretch& text);
  /// The text of the last stretch from `from` on comes next.
  void put_back(const TextStretch& last, const char* from);

 private:
  enum class State : std::uint8_t { reading, ended, failed, done };

  bool is_delimiter(char c) const { return cut_ == Cut::words ? is_space(c) : c == '\n'; }
  void read_more(TextStretch& text);
  void leave_out(TextStretch& text);
  bool cut(TextStretch& text, std::size_t searched);
  void take_rest(TextStretch& text);

  std::unique_ptr<ByteSource> source_;
  Cut cut_;
  std::size_t most_bytes_;
  std::size_t block_bytes_;
  State state_ = State::reading;
  CaptureError error_;
  bool leaving_out_ = false;  // until the end of an overlong word
  std::vector<char> carry_;   // comes before the text of the source
};

/// The stretch of a text that is being read, and its place in the capture.
class TextWindow {
 public:
  using Cut = TextCutter::Cut;

  TextWindow(std::unique_ptr<ByteSource> source, Cut cut,
             std::size_t most_bytes = default_piece_bytes)
      : cutter_(std::move(source), cut, most_bytes), cut_at_words_(cut == Cut::words) {}

  /// Leaves the window and makes the next; false at the end. A byte order mark at the start is left
  /// out. `drop_long` drops a word that no delimiter ends within `max_token_bytes` (text of a
  /// comment) up to that delimiter; otherwise it fails with `token_too_long`. Fails with
  /// `read_failed` too.
  tl::expected<bool, CaptureError> next(bool drop_long = false);

  const char* begin() const { return at_; }
  const char* end() const { return text_->end(); }
  /// The window begins at `place` from now on.
  /// \pre begin() <= place && place <= end()
  void advance(const char* place) { at_ = place; }

  /// The window is one word or line with which the text ended; its delimiter was added.
  bool unterminated() const { return text_->part == TextStretch::Part::rest && text_->bytes != 0; }

  /// Gives away the text from begin() on; no next() follows. From now on the text from the cutter
  /// is shown, or passed.
  TextCutter& hand_over();
  /// This text, the next one, becomes the window.
  void show(const TextStretch& text);
  /// Counts the text, the next one, as seen.
  void pass(const TextStretch& text, std::uint64_t line_feeds);
  /// Counts the window as seen.
  void leave();

  /// An error at `place`, which lies in the window or was in it since next() or show().
  /// If a line of CSV has a CR inside, that is the cause.
  CaptureError error_at(const char* place, CaptureCause cause,
                        const char* expected = nullptr) const;

 private:
  TextCutter cutter_;
  bool cut_at_words_;
  bool started_ = false;
  TextStretch own_;
  const TextStretch* text_ = &own_;
  const char* at_ = own_.begin();
  // Before the text: bytes, offset of the last line, its number.
  std::uint64_t offset_ = 0;
  std::uint64_t line_offset_ = 0;
  std::uint64_t line_ = 1;
};

/// An EdgeSource over text. A format adds parse() and finish_text().
class TextSource : public StepSource {
 public:
  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) final;

 protected:
  /// \param piece_limit the most text of a piece of pairs()
  TextSource(std::unique_ptr<ByteSource> bytes, TextWindow::Cut cut, std::size_t piece_limit)
      : window_(std::move(bytes), cut, piece_limit) {}

  /// Reads on from the window's begin until the window is used up, the block is full or fail() was
  /// called; advances the window.
  virtual void parse() = 0;
  /// The text has ended; may call fail().
  virtual void finish_text() = 0;
  /// Inside text whose words may have any length.
  virtual bool in_comment() const { return false; }

  /// Makes new_piece() possible; false if these lines cannot be read as arrays.
  virtual bool choose_pair(wire::LineIndex ma, wire::LineIndex slo) = 0;
  /// A piece for the lines chosen. Another thread may be in parse() or take_over().
  virtual std::unique_ptr<TextPiece> new_piece() const = 0;
  /// Takes the content of the regular piece as if parse() had read it. Returns false, and takes
  /// nothing, if the piece cannot follow the earlier text.
  virtual bool take_over(TextPiece& piece) = 0;

  TextWindow window_;

 private:
  class Pairs;

  void step() override;
  void end();
  bool settle(TextPiece& piece, const PairSource::OnEdges& on_edges);
};

}  // namespace biss::capture
