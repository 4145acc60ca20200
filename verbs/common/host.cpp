#include "verbs/common/host.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "report/text.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

constexpr auto ask_every = std::chrono::milliseconds(20);

std::string line_of(std::string_view text) {
  std::string line = "biss: ";
  report::append_printable(line, text);
  line.push_back('\n');
  return line;
}

std::string printable_lines(std::string_view text) {
  std::string printable;
  report::append_printable_lines(printable, text);
  return printable;
}

}  // namespace

void ProcessHost::warn(std::string_view text) { print_summary(line_of(text)); }

// A closed stderr cannot be reported.
void ProcessHost::print_summary(std::string_view text) {
  const std::string printable = printable_lines(text);
  clear_progress();
  std::fwrite(printable.data(), 1, printable.size(), stderr);
  std::fflush(stderr);
}

bool ProcessHost::shows_progress() const { return ::isatty(STDERR_FILENO) == 1; }

void MemoryHost::warn(std::string_view text) {
  lines_.emplace_back(text);
  text_ += line_of(text);
}

void MemoryHost::print_summary(std::string_view text) {
  const std::string printable = printable_lines(text);
  summary_ += printable;
  text_ += printable;
}

const GivenCapture* MemoryHost::capture(const std::string& name) const {
  if (const auto found = captures_.find(name); found != captures_.end()) return &found->second;
  return outer_ == nullptr ? nullptr : std::as_const(*outer_).capture(name);
}

void MemoryHost::set_go_on(std::function<bool()> go_on) {
  go_on_ = std::move(go_on);
  asks_ = std::this_thread::get_id();
  next_ = std::chrono::steady_clock::now() + ask_every;
}

void MemoryHost::check() {
  if (outer_ != nullptr) outer_->check();
  if (go_on_ && std::this_thread::get_id() == asks_) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= next_) {
      next_ = now + ask_every;
      if (!go_on_()) ended_ = true;
    }
  }
  if (ended_) throw Interrupted();
}

}  // namespace biss::verbs
