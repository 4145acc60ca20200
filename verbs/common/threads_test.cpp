// Verbs that run at the same time in several threads print the same as each alone.
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "capture/test_folder.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {
namespace threads_test {

struct Request {
  std::vector<std::string> words;
  GivenOptions options;
};

// The status, and all that the verb writes.
std::string said_by(const Request& request) {
  MemoryHost host;
  Command command(host);
  add_verbs(command, request.words.front());
  const ExitStatus status = command.run(request.words, request.options);
  return std::to_string(static_cast<int>(status)) + '\n' + host.output_text() + host.text();
}

TEST(Threads, VerbsAtOnce_SayWhatEachSaysAlone) {
  const test::Folder folder;
  const std::string good = folder.path("good.vcd");
  const std::string bad = folder.path("bad.vcd");
  const GivenOption format{"--format", {"resolute-26"}};
  for (const auto& [file, fault] : {std::pair(good, "nE:0.1"), std::pair(bad, "flip:0.2")}) {
    said_by({{"simulate"},
             {format, {"--fault", {fault}}, {"--cycles", {"300"}}, {"--output", {file}}}});
  }
  std::vector<Request> requests;
  for (const std::string& file : {good, bad}) {
    const GivenOption rows{"--to", {"csv"}};
    requests.push_back({{"decode", file}, {format, rows, {"--threads", {"2"}}}});
    requests.push_back({{"decode", file}, {rows}});
    requests.push_back({{"check", file}, {format, {"--to", {"jsonl"}}}});
    requests.push_back({{"explain", file}, {format}});
    requests.push_back({{"identify", file}, {}});
    requests.push_back({{"draw", file}, {format, {"--cycle", {"7"}}}});
    requests.push_back({{"decode", file}, {{"--no-such", {}}}});
  }
  requests.push_back({{"simulate"}, {format, {"--cycles", {"20"}}, {"--output", {"-"}}}});
  requests.push_back({{"plan"}, {format}});
  const GivenOption safety{"--format", {"fs-36-28"}};
  requests.push_back({{"safety", "campaign"}, {safety, {"--frames", {"20000"}}}});
  requests.push_back({{"safety", "analyse"}, {safety}});
  requests.push_back({{"encoders"}, {}});

  std::vector<std::string> alone;
  for (const Request& request : requests) alone.push_back(said_by(request));
  EXPECT_NE(alone[0], alone[7]);
  constexpr std::size_t count = 4;
  std::vector<std::vector<std::string>> at_once(count, std::vector<std::string>(requests.size()));
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < count; ++k) {
      threads.emplace_back([&, k] {
        for (std::size_t i = 0; i < requests.size(); ++i) {
          const std::size_t now = (i + 5 * k) % requests.size();
          at_once[k][now] = said_by(requests[now]);
        }
      });
    }
  }
  for (const std::vector<std::string>& said : at_once) {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      EXPECT_EQ(said[i], alone[i]) << requests[i].words.front();
    }
  }
}

}  // namespace threads_test
}  // namespace biss::verbs
