#include "verbs/common/program.hpp"

#include <fmt/format.h>

#include <string_view>

namespace biss::verbs {

std::string program_text() {
  const std::string_view commit = build_commit;
  return fmt::format("biss {}{}{}", BISS_VERSION, commit.empty() ? "" : " ", commit);
}

}  // namespace biss::verbs
