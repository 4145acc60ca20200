// `decode --unwrap`, `--scale`, `--velocity`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "biss/catalogue/entry.hpp"
#include "biss/frame/format.hpp"
#include "rows/motion.hpp"

namespace biss::verbs {

class Verb;

/// The size of a count of channel 1, as the catalogue states it; empty if it states none, or
/// several of which one is right.
std::optional<rows::Scale> scale_of(const CatalogueEntry& entry);

struct MotionArguments {
  bool unwrap = false;
  bool velocity = false;
  std::optional<std::uint64_t> max_step;
  /// Empty: not given; else deg, mm, the counts of a turn or the size of a count.
  std::string scale;

  rows::MotionColumns columns() const;
  /// Empty, or the one line why the options do not go together.
  std::string wrong_usage() const;
};

void add_motion_options(Verb verb, MotionArguments& arguments);

/// \param entry null if the format has no name of the catalogue
/// \return one line if the format cannot give the requested values
/// \pre arguments.columns().any()
tl::expected<rows::Motion, std::string> make_motion(const MotionArguments& arguments,
                                                    const ChannelFormat& channel,
                                                    const CatalogueEntry* entry);

}  // namespace biss::verbs
