// Captures that a program has in memory, for the verbs, which name captures by their files.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "capture/edge_source.hpp"
#include "cli/common/capture_input.hpp"

namespace biss::cli {

struct GivenCapture {
  std::function<capture::Opened(const InputArguments& arguments)> open;
  /// It can be opened more than once.
  bool again = true;
};

/// While it exists, this thread opens the captures of these names from here and not from files.
class GivenCaptures {
 public:
  GivenCaptures();
  ~GivenCaptures();
  GivenCaptures(const GivenCaptures&) = delete;
  GivenCaptures& operator=(const GivenCaptures&) = delete;

  void add(const std::string& name, GivenCapture capture) { captures_[name] = std::move(capture); }
  /// Null where this thread has no capture of that name.
  static const GivenCapture* find(const std::string& name);

 private:
  std::map<std::string, GivenCapture> captures_;
  GivenCaptures* outer_;
};

}  // namespace biss::cli
