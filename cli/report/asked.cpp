#include "cli/report/asked.hpp"

#include <nlohmann/json.hpp>

#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"

namespace biss::cli {

tl::expected<nlohmann::json, VerbError> ask_verb(const std::vector<std::string>& words,
                                                 Host& host) {
  MemoryHost asked(&host);
  Command command(asked);
  add_identify(command);
  add_explain(command);
  add_check(command);
  std::vector<const char*> arguments{"biss"};
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const ExitStatus status = command.run(static_cast<int>(arguments.size()), arguments.data());
  if (status >= ExitStatus::usage) {
    return tl::unexpected(VerbError{
        status,
        words.front() + ": " + (asked.lines().empty() ? "no message" : asked.lines().back())});
  }
  return nlohmann::json{
      {"status", static_cast<int>(status)}, {"out", asked.output_text()}, {"err", asked.text()}};
}

}  // namespace biss::cli
