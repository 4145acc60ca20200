// The contents of the picture of a cycle: its parts by name and value, cuts, and marks of failures.
// It is the same for every renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "draw/cycle_drawing.hpp"

namespace biss::draw {

/// A stretch of time that is not drawn, because nothing changes in it but an even MA.
struct Cut {
  Picoseconds from{};
  Picoseconds to{};
  /// Rising edges of MA in it.
  std::size_t clocks = 0;
};

/// The stretches of a drawing that can be left out: a long ACK, extra clocks, a long timeout. Some
/// periods before and after each change stay, and around the times in `kept`.
std::vector<Cut> cuts_of(const CycleDrawing& drawing, std::span<const Picoseconds> kept = {});

/// The places of times, in ticks from the left. Only integers, so that every machine has the same
/// result.
class Axis {
 public:
  /// Half a clock is drawn before the cycle.
  /// \param clock_ticks of a period; even
  /// \param cut_clocks  width of a cut in clocks
  Axis(const CycleDrawing& drawing, const std::vector<Cut>& cuts, std::size_t clock_ticks,
       std::size_t cut_clocks);

  /// The tick of a time; within a cut the tick of the cut's beginning. At most ticks().
  std::size_t at(Picoseconds time) const;
  /// False within a cut, and after the end of the drawing.
  bool shows(Picoseconds time) const;
  /// The tick at which a cut begins.
  std::size_t cut_at(std::size_t cut) const { return pieces_[cut].last; }

  std::size_t ticks() const { return pieces_.back().last; }
  std::size_t clock_ticks() const { return clock_ticks_; }
  std::size_t cut_ticks() const { return cut_ticks_; }
  /// The cycle has more clocks than a drawing can hold.
  bool truncated() const { return truncated_; }

 private:
  // From one cut to the next.
  struct Piece {
    Picoseconds from{};
    Picoseconds to{};
    std::size_t first = 0;
    std::size_t last = 0;
  };
  // The longest request has some 700 clocks.
  static constexpr std::int64_t clocks_max = 1365;

  std::int64_t ticks_of(Picoseconds from, Picoseconds to) const;

  Picoseconds period_;
  std::size_t clock_ticks_;
  std::size_t cut_ticks_;
  std::vector<Piece> pieces_;
  bool truncated_ = false;
};

enum class PartKind : std::uint8_t { line, frame, data, flag, crc };

/// A stretch of a cycle with a name.
struct Part {
  PartKind kind{};
  /// `ACK 3.2 us, 32 clocks`, `pos=1234`, `crc=0x16`.
  std::string text;
  Picoseconds from{};
  /// Not before `from`; the same for a moment.
  Picoseconds to{};
  /// It is wrong; an active error or warning of the encoder counts, too.
  bool wrong = false;
  /// A shorter text, if there is one, for a part that is too narrow for `text`.
  std::string brief{};
  /// The name without the value: `ACK`, `START`, a field as DrawnBit::field, `timeout`.
  std::string name{};
  /// The value of a complete field or bit, as in `text`.
  std::optional<std::uint64_t> value{};
  /// The checksum that the received data need, if it is not `value`.
  std::optional<std::uint64_t> expected{};
};

/// Parts next to one another in the order of time.
struct Track {
  std::string name;
  std::vector<Part> parts;
};

/// A moment and its text: the place and the cause of a failure.
struct Mark {
  Picoseconds time{};
  std::string text;
};

struct Layout {
  CycleDrawing drawing;
  std::vector<Cut> cuts;
  /// The text of each cut: `27 clocks`, or its time if MA rests.
  std::vector<std::string> cut_texts;
  std::vector<Track> tracks;
  std::vector<Mark> failures;
};

/// How a time is written, with its unit.
using TimeText = std::string (*)(Picoseconds time);

/// Values are decimal if the frame is good, and hexadecimal, as received, if it is not.
/// \param drawing of the whole cycle, DrawnExtent::cycle
/// \param format  that the drawing was made with
/// \param marks of the user; marks outside the cycle are left out
Layout lay_out(CycleDrawing drawing, const std::optional<FrameFormat>& format, TimeText time_text,
               std::span<const Mark> marks = {});

/// The tracks of Layout alone, without the tracks of marks.
std::vector<Track> tracks_of(const CycleDrawing& drawing, const std::optional<FrameFormat>& format,
                             TimeText time_text);

/// A label of a part, and its place.
struct Label {
  std::string text;
  std::size_t begin = 0;
  /// The part that it belongs to.
  std::size_t part_begin = 0;
  std::size_t part_end = 0;
  /// 0: within the part. Else the line below the parts, from 1.
  std::size_t line = 0;
};

/// A part between two ticks of a row; a part of several rows has a piece in each.
struct Piece {
  const Part* part = nullptr;
  std::size_t begin = 0;
  std::size_t end = 0;
  bool continued = false;  ///< the part begins in an earlier row
};

/// The pieces of a track in the row from tick `first` to tick `last`, counted from `first`.
std::vector<Piece> pieces_of(const Track& track, const Axis& axis, std::size_t first,
                             std::size_t last);

/// The labels of the pieces: within a piece if it is wide enough, else below it, so that no two
/// labels overlap.
/// \param width_of  a text in ticks, with the space that it needs around it
/// \param row_width of the row
std::vector<Label> labels_of(std::span<const Piece> pieces, std::size_t (*width_of)(std::size_t),
                             std::size_t row_width);

}  // namespace biss::draw
