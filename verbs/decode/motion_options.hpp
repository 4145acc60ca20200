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

struct MotionArguments {
  bool unwrap = false;
  bool velocity = false;
  std::optional<std::uint64_t> max_step;
  /// Empty: not given; otherwise a text that scale_unit() accepts.
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
