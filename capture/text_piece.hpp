// Text in pieces that are parsed by any thread, for the readers of text that know two lines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

/// A stretch of text, whole words or rows.
///
/// A format adds quick_parse(), which knows what the text nearly always looks like. What it does
/// not know it leaves to the reader of the format, which knows everything and remembers what came
/// before.
class TextPiece : public PairPiece {
 public:
  enum class Part : std::uint8_t {
    whole,     ///< words or rows with what ends them
    overlong,  ///< one without an end, too long to be valid; its rest is left out
    rest,      ///< the end of the capture: one without an end, which was added, or nothing
    failed,    ///< nothing more could be read
  };

  /// Bytes around the text that may be read: those before mean nothing, those after are 0.
  static constexpr std::size_t margin = 24;

  void expand() final {
    ma.clear();
    slo.clear();
    regular = part == Part::whole && quick_parse();
  }

  const char* begin() const { return buffer.data() + margin; }
  const char* end() const { return begin() + bytes; }

  Part part = Part::whole;
  std::vector<char> buffer;
  std::size_t bytes = 0;
  std::uint64_t left_out =
      0;                 ///< bytes of the capture before the text, the end of an overlong word
  CaptureError error;    ///< of a failed piece
  bool regular = false;  ///< `ma` and `slo` say everything about the two lines
  std::uint64_t line_feeds = 0;  ///< of a regular piece

 protected:
  /// Reads the text into `ma` and `slo` and counts its line feeds; false when it holds anything
  /// that is not plainly right.
  virtual bool quick_parse() = 0;
};

/// The level after the last change; nothing where there is none.
inline std::optional<wire::Level> last_level(const LineChanges& changes) {
  if (changes.times.empty()) return std::nullopt;
  const bool high = changes.first_high == (changes.times.size() % 2 == 1);
  return high ? wire::Level::high : wire::Level::low;
}

/// What a window of text has not yet shown.
struct TextRest {
  std::unique_ptr<ByteSource> source;
  bool source_ended = false;
  bool cut_at_words = false;
  std::vector<char> text;  ///< comes before what the source gives
};

/// Divides the rest of a text into pieces. A piece is what one read brings, so that the changes of a
/// slow pipe are delivered as they arrive.
class TextCutter {
 public:
  /// \pre piece_limit > 0
  TextCutter(TextRest rest, std::size_t piece_limit);

  /// The next text; false after the last, which is `rest` or `failed`.
  bool next(TextPiece& piece);

 private:
  enum class State : std::uint8_t { reading, ended, failed, done };

  bool is_delimiter(char c) const;
  void read_more(TextPiece& piece);
  void leave_out(TextPiece& piece);
  bool cut(TextPiece& piece, std::size_t searched);
  void take_rest(TextPiece& piece);

  std::unique_ptr<ByteSource> source_;
  bool cut_at_words_;
  std::size_t piece_limit_;
  std::size_t block_bytes_;
  State state_ = State::reading;
  CaptureError error_;
  bool leaving_out_ = false;  // until the end of an overlong word
  std::vector<char> carry_;   // has no end yet
};

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
  /// Moves what was collected to the end of `changes`, each time as `convert` gives it.
  template <class Convert>
  void take(LineChanges& changes, Convert convert) {
    for (std::size_t i = 0; i < count_; ++i) times_[i] = convert(times_[i]);
    changes.times.insert(changes.times.end(), times_.data(), times_.data() + count_);
    count_ = 0;
    changes.first_high = (level_ == 1) == (changes.times.size() % 2 == 1);
  }
  void forget() { count_ = 0; }

 private:
  std::array<std::int64_t, size> times_;
  std::size_t count_ = 0;
  std::uint32_t level_ = no_level;
};

}  // namespace biss::capture
