// For tests of verbs: a command line, run in this process.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
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

/// Expects that a run was refused: one line of error, no output.
inline void expect_wrong_usage(const Ran& ran) {
  EXPECT_EQ(ran.status, ExitStatus::usage) << ran.err;
  EXPECT_EQ(ran.out, "");
  EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
}

}  // namespace biss::verbs
