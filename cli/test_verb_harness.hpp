// For tests of verbs: a command line, run in this process.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/command_line.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// The result of a run.
struct Ran {
  ExitStatus status{};
  std::string out;
  std::string err;
};

/// `biss ARGUMENTS…`.
inline Ran run_verb(const std::vector<std::string>& arguments) {
  ProcessHost host;
  Command command(host);
  add_verbs(command, arguments.empty() ? "" : arguments.front());
  std::vector<const char*> all{"biss"};
  for (const std::string& argument : arguments) all.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ran ran;
  ran.status = cli::run_command_line(command, static_cast<int>(all.size()), all.data());
  ran.out = testing::internal::GetCapturedStdout();
  ran.err = testing::internal::GetCapturedStderr();
  return ran;
}

}  // namespace biss::verbs
