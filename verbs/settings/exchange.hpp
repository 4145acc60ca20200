// A frame format as settings of a master, and back.
#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "verbs/settings/masters.hpp"

namespace biss::verbs {

/// Times that some masters have settings for, if they are known.
struct LineTimes {
  std::optional<Hertz> clock{};
  std::optional<Picoseconds> ack_max{};
  std::optional<Picoseconds> timeout{};
};

/// A value to type.
struct Setting {
  /// Its rows in the table; the key is the same.
  std::vector<const Parameter*> rows;
  /// `?` if no source has the value.
  std::string value{};
  /// The reasons why it is not certain.
  std::vector<std::string_view> doubts{};
  bool complete = true;
};

/// The settings of a format, without those that need a time that is not known.
/// \return or the reason why the master cannot read the format: `crc_start: …`
tl::expected<std::vector<Setting>, std::string> settings_for(const Master& master,
                                                             const FrameFormat& format,
                                                             const LineTimes& times);

/// The format of settings.
struct Found {
  FrameFormat format;
  /// Those that were given. The drive's own: it may wait longer than the encoder needs.
  LineTimes times;
  /// Facts that the settings leave open, and the choices: `turns: …`.
  std::vector<std::string> open;
  /// Parameters that were left out, with their value.
  std::vector<std::string> assumed;
  /// Doubts of the parameters: `80p8:11: …`.
  std::vector<std::string> doubts;
  /// With `expected`: facts that come from it, and parameters without a fact of the format.
  std::vector<std::string> not_compared;
};

/// Throws a VerbError (wrong usage) if the settings are wrong.
/// \param settings `KEY=VALUE` each
/// \param expected takes the place of what the settings leave open; wrong usage if they contradict it
Found format_of(const Master& master, const std::vector<std::string>& settings,
                const std::optional<FrameFormat>& expected);

}  // namespace biss::verbs
