#include "cli/common/given_captures.hpp"

namespace biss::cli {

namespace {

thread_local GivenCaptures* innermost = nullptr;

}  // namespace

GivenCaptures::GivenCaptures() : outer_(innermost) { innermost = this; }
GivenCaptures::~GivenCaptures() { innermost = outer_; }

const GivenCapture* GivenCaptures::find(const std::string& name) {
  for (const GivenCaptures* each = innermost; each != nullptr; each = each->outer_) {
    if (const auto found = each->captures_.find(name); found != each->captures_.end()) {
      return &found->second;
    }
  }
  return nullptr;
}

}  // namespace biss::cli
