// For tests: one verb, run as the shell would.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/common/verb.hpp"

namespace biss::cli {

/// The result of a run.
struct Ran {
  ExitStatus status{};
  std::string out;
  std::string err;
};

/// `biss ARGUMENTS…` with the one verb that `add` adds.
inline Ran run_verb(void (*add)(Command&), const std::vector<std::string>& arguments) {
  ProcessHost host;
  Command command(host);
  add(command);
  std::vector<const char*> all{"biss"};
  for (const std::string& argument : arguments) all.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ran ran;
  ran.status = command.run(static_cast<int>(all.size()), all.data());
  ran.out = testing::internal::GetCapturedStdout();
  ran.err = testing::internal::GetCapturedStderr();
  return ran;
}

}  // namespace biss::cli
